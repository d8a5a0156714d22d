// SPDX-License-Identifier: MIT
//
// stipple-lab distribution: measures how evenly prefixes of ordered points are spread and how well they
// cover.
#include "lab/measure/distribution.h"
#include "program/files/overwrite.h"
#include "program/files/point_file.h"
#include "program/options/command.h"

#include <assert.h>
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_FILES = 6, MAX_PREFIXES = 32 };

static struct {
    const char* of;
    const char* prefixes;
    const char* plot;
    uint64_t threads;
    bool json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "of",
         .type = OPTION_TEXT,
         .argument = "POINTS.ply",
         .help = "points that the prefixes should cover; default the ordered points themselves",
         .value = &args.of},
        {.name = "prefix",
         .type = OPTION_TEXT,
         .argument = "N,N,...",
         .help = "prefix lengths; default 1000,5000,10000, up to the number of points",
         .value = &args.prefixes},
        {.name = "plot",
         .type = OPTION_TEXT,
         .argument = "OUT.svg",
         .help = "write violin and box plots of the spacings",
         .value = &args.plot},
        OPTION_THREADS(&args.threads),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

typedef struct study {
    stp_context* context;
    const char* paths[MAX_FILES];
    size_t file_count;
    uint32_t prefixes[MAX_PREFIXES];
    size_t prefix_count;
    stp_distribution figures[MAX_FILES][MAX_PREFIXES];
    float* spacings[MAX_FILES][MAX_PREFIXES]; // sorted and relative; kept for the plot
    uint32_t spacing_counts[MAX_FILES][MAX_PREFIXES];
} study;

// @return 0, or the exit code with the message printed
static int read_prefixes(study* s)
{
    const char* text = args.prefixes != NULL ? args.prefixes : "1000,5000,10000";
    while (*text != 0) {
        char* end = NULL;
        unsigned long long value = isdigit((unsigned char)*text) ? strtoull(text, &end, 10) : 0;
        if (value == 0 || value > UINT32_MAX || (*end != 0 && (*end != ',' || end[1] == 0)) ||
            s->prefix_count == MAX_PREFIXES) {
            return tool_usage_error(
                "distribution: --prefix expects up to %d counts like 1000,5000, not %s",
                MAX_PREFIXES, args.prefixes);
        }
        s->prefixes[s->prefix_count++] = (uint32_t)value;
        text = *end == ',' ? end + 1 : end;
    }
    return s->prefix_count != 0 ? 0 : tool_usage_error("distribution: --prefix expects counts");
}

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return (x > y) - (x < y);
}

static stp_result measure_prefix(study* s, size_t file, size_t prefix, const tool_points* ordered,
                                 const tool_points* of)
{
    uint32_t count = s->prefixes[prefix] < ordered->count ? s->prefixes[prefix] : ordered->count;
    float* spacings = STP_NEW_ARRAY(s->context, float, count);
    if (spacings == NULL) {
        return stp_fail_memory(s->context);
    }
    assert(file < MAX_FILES && prefix < s->prefix_count && s->spacings[file][prefix] == NULL);
    stp_distribution* d = &s->figures[file][prefix];
    stp_result result = stp_distribution_measure(s->context, ordered->positions, count,
                                                 of->positions, of->count, spacings, d);
    if (result != STP_OK) {
        stp_free(s->context, spacings);
        return result;
    }
    for (uint32_t i = 0; i < count; ++i) {
        spacings[i] = d->even_spacing > 0.0 ? (float)((double)spacings[i] / d->even_spacing) : 0.0f;
    }
    qsort(spacings, count, sizeof(spacings[0]), compare_floats);
    s->spacings[file][prefix] = spacings;
    s->spacing_counts[file][prefix] = count;
    return STP_OK;
}

static stp_result measure_file(study* s, size_t file)
{
    tool_points ordered, of = {0};
    stp_result result = tool_read_points(s->context, s->paths[file], NULL, &ordered);
    if (result != STP_OK) {
        return result;
    }
    if (args.of != NULL) {
        result = tool_read_points(s->context, args.of, ordered.origin, &of);
    }
    for (size_t i = 0; i < s->prefix_count && result == STP_OK; ++i) {
        result = measure_prefix(s, file, i, &ordered, args.of != NULL ? &of : &ordered);
    }
    tool_points_destroy(s->context, &of);
    tool_points_destroy(s->context, &ordered);
    return result;
}

// Formats a number, or null if there is none (the spacing of a single point).
static json_t* number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t* describe_prefixes(const study* s, size_t file)
{
    json_t* list = json_array();
    for (size_t i = 0; i < s->prefix_count; ++i) {
        const stp_distribution* d = &s->figures[file][i];
        json_array_append_new(list,
                              json_pack("{s:I, s:o, s:o, s:f, s:f, s:f, s:o, s:f}", "count",
                                        (json_int_t)d->count, "spacing_min", number(d->spacing_min),
                                        "spacing_median", number(d->spacing_median), "coverage_p50",
                                        d->coverage_p50, "coverage_p99", d->coverage_p99,
                                        "coverage_max", d->coverage_max, "relative_spacing_min",
                                        number(d->relative_spacing_min), "uncovered_fraction",
                                        d->uncovered_fraction));
    }
    return list;
}

static int print_study(const study* s)
{
    if (args.json) {
        json_t* files = json_array();
        for (size_t i = 0; i < s->file_count; ++i) {
            json_array_append_new(files, json_pack("{s:s, s:o}", "path", s->paths[i], "prefixes",
                                                   describe_prefixes(s, i)));
        }
        json_t* json = json_pack("{s:o, s:o}", "prefixes", describe_prefixes(s, 0), "files", files);
        return json != NULL ? tool_print_json(json) : tool_error("out of memory");
    }
    for (size_t i = 0; i < s->file_count; ++i) {
        printf("%s\n%10s %12s %12s %12s %12s %12s %9s %10s\n", s->paths[i], "points", "spacing min",
               "median", "cover 50%", "cover 99%", "cover max", "relative", "uncovered");
        for (size_t k = 0; k < s->prefix_count; ++k) {
            const stp_distribution* d = &s->figures[i][k];
            printf("%10u %12.6g %12.6g %12.6g %12.6g %12.6g %9.4f %9.4f%%\n", d->count,
                   d->spacing_min, d->spacing_median, d->coverage_p50, d->coverage_p99,
                   d->coverage_max, d->relative_spacing_min, 100.0 * d->uncovered_fraction);
        }
    }
    return 0;
}

// The name of a file without its folder and extension.
static void make_label(const char* path, char* label, size_t size)
{
    const char* slash = strrchr(path, '/');
    snprintf(label, size, "%s", slash != NULL ? slash + 1 : path);
    char* dot = strrchr(label, '.');
    if (dot != NULL && dot != label) {
        *dot = 0;
    }
}

static stp_result plot(const study* s)
{
    static plot_violin violins[MAX_FILES * MAX_PREFIXES];
    static char labels[MAX_FILES][20];
    size_t count = 0;
    for (size_t i = 0; i < s->file_count; ++i) {
        make_label(s->paths[i], labels[i], sizeof(labels[i]));
    }
    for (size_t k = 0; k < s->prefix_count; ++k) {
        for (size_t i = 0; i < s->file_count; ++i) {
            violins[count++] = (plot_violin){labels[i], s->prefixes[k], s->spacings[i][k],
                                             s->spacing_counts[i][k]};
        }
    }
    return plot_violins(s->context, args.plot, violins, count);
}

static int run(int argc, char** argv)
{
    static study s;
    if (argc < 1 || argc > MAX_FILES) {
        return tool_usage_error("distribution: expected one file of ordered points, or up to %d",
                                MAX_FILES);
    }
    int code = overwrite_check(args.of, args.plot);
    for (int i = 0; i < argc && code == 0; ++i) {
        code = overwrite_check(argv[i], args.plot);
    }
    code = code != 0 ? code : read_prefixes(&s);
    if (code != 0) {
        return code;
    }
    s.context = tool_context_create((uint32_t)args.threads, 0, NULL);
    if (s.context == NULL) {
        return 1;
    }
    stp_result result = STP_OK;
    for (; s.file_count < (size_t)argc && result == STP_OK; ++s.file_count) {
        s.paths[s.file_count] = argv[s.file_count];
        result = measure_file(&s, s.file_count);
    }
    if (result == STP_OK && args.plot != NULL) {
        result = plot(&s);
    }
    code = result == STP_OK ? print_study(&s) : 1;
    for (size_t i = 0; i < MAX_FILES; ++i) {
        for (size_t k = 0; k < MAX_PREFIXES; ++k) {
            stp_free(s.context, s.spacings[i][k]);
        }
    }
    stp_context_destroy(s.context);
    return code;
}

const command command_distribution = {
    .name = "distribution",
    .arguments = "ORDERED.ply...",
    .summary = "measure how evenly prefixes of ordered points are spread and how well they cover",
    .text = "Prints figures for prefixes of the points, in file order. The spacing is the "
            "distance from each point to its nearest neighbour within the prefix (minimum and "
            "median). The coverage is the distance from each point of --of to the prefix "
            "(median, 99th percentile and maximum). The relative spacing is the minimum spacing "
            "divided by that of a hexagonal lattice with as many points on the same area, which "
            "is the largest possible. uncovered is the share of points that lie farther from the "
            "prefix than its median spacing.\n\n"
            "--plot draws the spacings of each prefix, relative to that lattice, as violins with "
            "boxes (minimum, quartiles, median, maximum), like Figure 3 of Brandt et al. 2019; "
            "several files are shown side by side.",
    .examples =
        "Measure the spacing and coverage of prefixes:\n"
        "$ stipple-lab distribution ordered.ply --of points.ply --prefix 1000,10000\n"
        "Plot two orders side by side:\n"
        "$ stipple-lab distribution ordered.ply paper.ply --prefix 1000,10000 --plot spacing.svg\n",
    .files = "ORDERED.ply\t"
             "points in order, as stipple order writes them\n"
             "OUT.svg\t"
             "violins of spacings, with --plot\n",
    .options = options,
    .run = run,
};
