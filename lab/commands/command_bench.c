// SPDX-License-Identifier: MIT
// `stipple-lab bench`: runs benchmarks and prints their results as a table or as one JSON object.
#include "lab/bench/bench.h"
#include "lod/method.h"
#include "program/drawing/draw_options.h"

#include <stdio.h>
#include <string.h>

#define BENCH(name) extern const benchmark benchmark_##name;
#include "bench_list.h"
#undef BENCH

const benchmark* const* benchmarks(void)
{
    static const benchmark* const list[] = {
#define BENCH(name) &benchmark_##name,
#include "bench_list.h"
#undef BENCH
        NULL,
    };
    return list;
}

static struct {
    bool list, quick, json;
    const char *model, *markdown;
    uint64_t count, first, threads, memory;
    double splat_size;
    int method, backend;
    bool has_method;
    double eye[3], target[3];
    bool has_eye;
    uint32_t size[2];
} given;

static const option* bench_options_table(void)
{
    static const option options[] = {
        {.name = "list", .help = "list the benchmarks", .value = &given.list},
        {.name = "quick", .help = "small cases that finish within seconds", .value = &given.quick},
        {.name = "model",
         .type = OPTION_TEXT,
         .argument = "PATH",
         .help = "model to measure",
         .value = &given.model},
        {.name = "count",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..1000000",
         .help = "positions: number of positions above the whole scene; each part gets a quarter "
                 "as many; default 20",
         .value = &given.count},
        {.name = "splat-size",
         .type = OPTION_NUMBER,
         .argument = "PX",
         .words = "1..64",
         .help =
             "frame, positions, quality: splat size; default 1; for quality 1, 2, 4, 8, 16 and 24",
         .value = &given.splat_size},
        {.name = "method",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = TOOL_METHOD_WORDS,
         .help = "frame, quality: method to draw; default the first in the file",
         .value = &given.method,
         .given = &given.has_method},
        {.name = "backend",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = "cpu|gl",
         .help = "spt: renderer; gl is OpenGL 4.5; default cpu",
         .value = &given.backend},
        {.name = "eye",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "quality: use only the view from this position",
         .value = given.eye,
         .given = &given.has_eye},
        {.name = "target",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "quality: point that the camera looks at; default 0,0,0",
         .value = given.target},
        {.name = "first",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "0..1000000",
         .help = "positions: skip the first N, for example because they are already measured; "
                 "default 0",
         .value = &given.first},
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .help = "frame, positions, quality: size of pictures; default 1920x1080, with --quick "
                 "320x180",
         .value = given.size},
        {.name = "memory",
         .type = OPTION_SIZE,
         .argument = "SIZE",
         .words = OPTION_MEMORY_WORDS,
         .help = "frame, positions: load data while drawing, within this limit, such as 1G; by "
                 "default the file is mapped",
         .value = &given.memory},
        {.name = "threads",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "auto|0..1024",
         .help = "frame, positions: drawing threads; spt: building threads; default all "
                 "processors",
         .value = &given.threads},
        {.name = "markdown",
         .type = OPTION_TEXT,
         .argument = "FILE.md",
         .help = "gl: also write a table",
         .value = &given.markdown},
        OPTION_JSON(&given.json),
        {0},
    };
    return options;
}

static const benchmark* find_benchmark(const char* name)
{
    for (const benchmark* const* b = benchmarks(); *b != NULL; ++b) {
        if (strcmp((*b)->name, name) == 0) {
            return *b;
        }
    }
    return NULL;
}

static int list_benchmarks(void)
{
    for (const benchmark* const* b = benchmarks(); *b != NULL; ++b) {
        printf("%-12s %s\n", (*b)->name, (*b)->summary);
    }
    return 0;
}

static int run_bench(int argc, char** argv)
{
    if (given.list) {
        return list_benchmarks();
    }
    for (int i = 0; i < argc; ++i) {
        if (find_benchmark(argv[i]) == NULL) {
            return tool_usage_error("bench: there is no benchmark %s; see stipple-lab bench --list",
                                    argv[i]);
        }
    }
    if (given.backend != 0 && (argc != 1 || strcmp(argv[0], "spt") != 0)) {
        return tool_usage_error(
            "bench: only spt has --backend: stipple-lab bench spt --backend gl");
    }
    bench_options options = {.quick = given.quick,
                             .model = given.model,
                             .count = (uint32_t)given.count,
                             .first = (uint32_t)given.first,
                             .splat_size = given.splat_size > 0.0 ? given.splat_size : 1.0,
                             .method = given.has_method ? stp_methods[given.method].id : 0,
                             .all_sizes = !(given.splat_size > 0.0),
                             .has_eye = given.has_eye,
                             .eye = {given.eye[0], given.eye[1], given.eye[2]},
                             .target = {given.target[0], given.target[1], given.target[2]},
                             .size = {given.size[0], given.size[1]},
                             .threads = (uint32_t)given.threads,
                             .memory = given.memory,
                             .uses_gl = given.backend != 0,
                             .markdown = given.markdown};
    json_t* results = json_array();
    int code = 0;
    for (const benchmark* const* b = benchmarks(); *b != NULL && code == 0; ++b) {
        bool wanted = argc == 0;
        for (int i = 0; i < argc; ++i) {
            wanted = wanted || strcmp((*b)->name, argv[i]) == 0;
        }
        if (wanted) {
            fprintf(stderr, "%s ...\n", (*b)->name);
            code = (*b)->run(&options, results);
        }
    }
    if (code != 0) {
        json_decref(results);
        return code;
    }
    return given.json ? bench_print_json(results) : bench_print_text(results);
}

const command command_bench = {
    .name = "bench",
    .arguments = "[NAME...]",
    .summary = "measure Stipple and compare it with other programs",
    .text = "Runs the named benchmarks, or all of them, and prints the results. Alternatives are "
            "measured interleaved in one run; times are medians. Data goes to standard output; "
            "--json prints one object: machine, and results with name, params and figures.",
    .examples = "List the benchmarks:\n"
                "$ stipple-lab bench --list\n"
                "Run a small case and print JSON:\n"
                "$ stipple-lab bench splats --quick --json\n",
    .files = "$TMPDIR\tscratch files of benchmarks that build; /tmp if the variable is not set\n",
    .options = bench_options_table,
    .run = run_bench,
};
