// SPDX-License-Identifier: MIT
//
// stipple check: verifies a .stip file.
#include "program/options/command.h"
#include "store/file/store.h"

#include <stdio.h>

static struct {
    bool quick;
    bool json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "quick",
         .help = "check only what a reader needs first; skip the bulk data",
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
        return tool_usage_error("check needs one file, but got %d", argc);
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
    .summary = "verify every checksum and invariant of a file",
    .text =
        "Verifies the whole file: header, directory, every data block, and the bytes between "
        "them. Any changed, missing or added byte is detected. The first error is printed on "
        "standard error; with --json it is also the value of \"fault\".\n\n"
        "--quick skips the bulk data. It verifies a directory of up to 512 KiB completely. Of a "
        "larger one it verifies the header, the section table, the summary, scene parts, views, "
        "sources, build parameters and their texts, the checksums of all pages, and the first "
        "page of each section: less than 1 MB for a 10 GB file. Files of version 1.0 have no "
        "page checksums, so their whole directory is verified.\n\n"
        "The exit status is 0 if the file is valid and 1 if it is not.",
    .examples = "Verify everything:\n"
                "$ stipple check plant.stip\n"
                "Verify only the directory of a large file:\n"
                "$ stipple check plant.stip --quick\n",
    .files = "FILE.stip\tthe file to verify; it is never changed\n",
    .options = options,
    .run = run,
};
