// SPDX-License-Identifier: MIT
// `stipple-lab kernels`: times the SIMD kernels against their portable variants, and compares bits.
#include "lab/bench/results.h"
#include "lab/kernels/kernels.h"
#include "program/options/command.h"

#include <stdio.h>
#include <string.h>

enum { RUNS = 51, QUICK_RUNS = 3 };

static struct {
    bool list, quick, json;
} given;

static const option* kernels_options(void)
{
    static const option options[] = {
        {.name = "list", .help = "list the kernels", .value = &given.list},
        {.name = "quick", .help = "few runs, within a second", .value = &given.quick},
        OPTION_JSON(&given.json),
        {0},
    };
    return options;
}

static int list_kernels(void)
{
    for (const kernel* k = kernels; k->name != NULL; ++k) {
        printf("%-20s %s\n", k->name, k->source);
    }
    return 0;
}

static bool is_kernel(const char* name)
{
    for (const kernel* k = kernels; k->name != NULL; ++k) {
        if (strcmp(k->name, name) == 0) {
            return true;
        }
    }
    return false;
}

static bool is_wanted(const kernel* k, int argc, char** argv)
{
    for (int i = 0; i < argc; ++i) {
        if (strcmp(k->name, argv[i]) == 0) {
            return true;
        }
    }
    return argc == 0;
}

static void add_result(const kernel* k, const kernel_result* r, json_t* results)
{
    bench_entry entry = bench_result(results, "kernels");
    bench_set_text(entry.params, "kernel", k->name);
    bench_set_text(entry.params, "source", k->source);
    bench_set_text(entry.params, "element", k->element);
    bench_set_count(entry.params, "elements", r->elements);
    bench_set_count(entry.params, "runs", r->runs);
    for (uint32_t v = 0; v < r->variants; ++v) {
        json_t* variant = json_object();
        bench_set_number(variant, "ns", r->times[v].median);
        bench_set_number(variant, "ns_min", r->times[v].min);
        bench_set_number(variant, "ns_max", r->times[v].max);
        json_object_set_new(variant, "same_bits", json_boolean(r->same[v]));
        json_object_set_new(entry.figures, stp_processor_name((stp_processor)v), variant);
    }
}

static void print_head(void)
{
    printf("nanoseconds of CPU time per element: median (minimum to maximum)\n%-20s %-10s", "", "");
    for (uint32_t v = 0; v <= (uint32_t)stp_processor_detect(); ++v) {
        printf(" %-24s", stp_processor_name((stp_processor)v));
    }
    printf("\n");
}

static void print_row(const kernel* k, const kernel_result* r)
{
    printf("%-20s %-10s", k->name, k->element);
    for (uint32_t v = 0; v < r->variants; ++v) {
        char cell[64];
        snprintf(cell, sizeof(cell), "%.3g (%.3g to %.3g)", r->times[v].median, r->times[v].min,
                 r->times[v].max);
        printf(" %-24s", cell);
    }
    printf("\n");
}

/// @return 0, or 1 with the message printed
static int check_bits(const kernel* k, const kernel_result* r)
{
    for (uint32_t v = 0; v < r->variants; ++v) {
        if (!r->same[v]) {
            return tool_error("kernels: %s: %s gives other bits than the portable variant", k->name,
                              stp_processor_name((stp_processor)v));
        }
    }
    return 0;
}

/// Measures the wanted kernels. @return the exit code
static int measure_kernels(stp_context* context, int argc, char** argv, json_t* results)
{
    int code = 0;
    if (!given.json) {
        print_head();
    }
    for (const kernel* k = kernels; k->name != NULL && !tool_is_interrupted(); ++k) {
        kernel_result result;
        if (!is_wanted(k, argc, argv)) {
            continue;
        }
        if (!kernel_measure(context, k, given.quick ? QUICK_RUNS : RUNS, &result)) {
            return tool_error("kernels: out of memory");
        }
        add_result(k, &result, results);
        if (!given.json) {
            print_row(k, &result);
        }
        code = check_bits(k, &result) != 0 ? 1 : code;
    }
    return code;
}

static int run_kernels(int argc, char** argv)
{
    if (given.list) {
        return list_kernels();
    }
    for (int i = 0; i < argc; ++i) {
        if (!is_kernel(argv[i])) {
            return tool_usage_error("kernels: there is no kernel %s; see stipple-lab kernels "
                                    "--list",
                                    argv[i]);
        }
    }
    stp_context* context = tool_context_create(1, 0, "none");
    if (context == NULL) {
        return 1;
    }
    json_t* results = json_array();
    int code = measure_kernels(context, argc, argv, results);
    stp_context_destroy(context);
    if (!given.json) {
        json_decref(results);
        return code;
    }
    int printed = bench_print_json(results);
    return code != 0 ? code : printed;
}

const command command_kernels = {
    .name = "kernels",
    .arguments = "[NAME...]",
    .summary = "time the SIMD kernels against their portable variants",
    .text = "Runs the named kernels, or all, with each instruction set that the processor has "
            "(baseline is portable C), taking turns, on the same random input. Prints nanoseconds "
            "of CPU time per element: the median, minimum and maximum of several runs. All "
            "variants must give "
            "the same bits; otherwise the exit code is 1. --json prints one object like stipple "
            "bench.",
    .examples = "Time all kernels:\n"
                "$ stipple-lab kernels\n"
                "Check two kernels:\n"
                "$ stipple-lab kernels splats triangles --quick\n",
    .files = "bench/results\tearlier figures, which bench/run kernels saves\n",
    .options = kernels_options,
    .run = run_kernels,
};
