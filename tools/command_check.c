// SPDX-License-Identifier: MIT
//
// stipple check: whether a .stip file is whole and right.
#include "command.h"

#include "store/store.h"

#include <stdio.h>

static struct {
    bool quick;
    bool json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "quick",
         .help = "check what a reader needs first, and read no bulk data",
         .value = &args.quick},
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

typedef struct fault_text {
    char text[1024]; ///< empty: none
} fault_text;

static void keep_fault(stp_log_level level, const char* message, void* user)
{
    fault_text* fault = user;
    if (level == STP_LOG_ERROR && fault->text[0] == '\0') {
        snprintf(fault->text, sizeof(fault->text), "%s", message);
    }
}

static int print_report(const stp_store_check_report* report, const char* fault)
{
    if (args.json) {
        return tool_print_json(json_pack("{s:b, s:s?, s:I, s:I, s:I}", "ok", fault == NULL, "fault",
                                         fault, "file_bytes", (json_int_t)report->file_bytes,
                                         "blocks", (json_int_t)report->blocks, "bytes_checked",
                                         (json_int_t)report->bytes_checked));
    }
    if (fault == NULL) {
        printf("ok: %llu of %llu bytes checked, %llu blocks\n",
               (unsigned long long)report->bytes_checked, (unsigned long long)report->file_bytes,
               (unsigned long long)report->blocks);
    }
    return 0;
}

static int run(int argc, char** argv)
{
    if (argc != 1) {
        return tool_usage_error("check needs one file, and got %d", argc);
    }
    fault_text fault = {{0}};
    stp_context_desc desc = {.log = keep_fault, .log_user = &fault, .thread_count = 1};
    stp_context* context = NULL;
    stp_result result = stp_context_create(&context, &desc);
    if (result != STP_OK) {
        return tool_error("%s", stp_result_string(result));
    }
    stp_store_check_report report;
    result = stp_store_check_with_report(context, argv[0], args.quick, &report);
    stp_context_destroy(context);
    int code = print_report(&report, result == STP_OK ? NULL : fault.text);
    return result == STP_OK ? code : tool_error("%s", fault.text);
}

const command command_check = {
    .name = "check",
    .arguments = "FILE.stip",
    .summary = "check every checksum and invariant of a file",
    .text =
        "Goes through the whole file: header, directory, every block of data, and the bytes "
        "between "
        "them. Any changed, missing or added byte is found. The first fault is printed on standard "
        "error; with --json it is also the value of \"fault\".\n"
        "\n"
        "With --quick no bulk data are read. A directory of up to 512 KiB is checked whole; of a "
        "larger "
        "one the header, the table of sections, the summary, scene parts, views, sources and "
        "parameters of the build with their texts, the checksums of all pages, and the first page "
        "of "
        "each section: less than 1 MB of a file of 10 GB. Files of version 1.0 have no checksums "
        "of "
        "pages; their whole directory is checked.\n"
        "\n"
        "Exit status is 0 where the file is right and 1 where it is not.",
    .examples = "Check everything:\n"
                "$ stipple check plant.stip\n"
                "Check only the directory, of a large file:\n"
                "$ stipple check plant.stip --quick\n",
    .files = "FILE.stip\t"
             "the file that is checked; it is never changed\n",
    .options = options,
    .run = run,
};
