// SPDX-License-Identifier: MIT
//
// stipple order: orders the points of a file so that every prefix covers them all evenly.
#include "program/files/point_file.h"
#include "program/options/command.h"
#include "program/options/tool.h"

#include <stipple/order.h>

#include <assert.h>
#include <stdio.h>
#include <string.h>

static struct {
    const char* output;
    int order, metric;
    uint64_t count, samples, interval, seed, threads;
    double drop;
    bool json, metric_given;
} args;

static const char order_names[] = "exact|paper-fast|paper-text|random|best-of-k";
static const char metric_names[] = "side|euclidean";

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "ORDERED.ply",
         .help = "file to write the ordered points to",
         .value = &args.output},
        {.name = "order",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = order_names,
         .help = "ordering method; default exact",
         .value = &args.order},
        {.name = "metric",
         .type = OPTION_CHOICE,
         .argument = "NAME",
         .words = metric_names,
         .help =
             "distance between points; side: points that face apart count as far apart (default "
             "if there are normals)",
         .value = &args.metric,
         .given = &args.metric_given},
        {.name = "count",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "all|0..4294967295",
         .help = "number of points to write; default all",
         .value = &args.count},
        {.name = "samples",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "0..1000000",
         .help = "random samples per round of the paper's orders; default 200",
         .value = &args.samples,
         .lab_only = true},
        {.name = "interval",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "0..1000000000",
         .help = "rounds before the paper's schedules change; default 500",
         .value = &args.interval,
         .lab_only = true},
        {.name = "drop",
         .type = OPTION_NUMBER,
         .argument = "F",
         .words = "0..1",
         .help = "drop samples closer than F times the distance of the round's pick; default 0: "
                 "none",
         .value = &args.drop,
         .lab_only = true},
        {.name = "seed",
         .type = OPTION_COUNT,
         .argument = "N",
         .help = "random seed of the orders; default 0",
         .value = &args.seed},
        OPTION_THREADS(&args.threads),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

// The word at `index` of a list separated by bars.
static const char* word_at(const char* words, int index, char* buffer, size_t size)
{
    while (index > 0) {
        assert(*words != '\0' && "the list has a word at this index");
        index -= *words++ == '|';
    }
    size_t length = 0;
    for (; words[length] != 0 && words[length] != '|' && length + 1 < size; ++length) {
        buffer[length] = words[length];
    }
    buffer[length] = 0;
    return buffer;
}

static int print_report(const stp_order_desc* desc, const stp_order_report* report,
                        uint32_t candidates, uint32_t ordered, uint32_t threads)
{
    char order[16], metric[16];
    word_at(order_names, args.order, order, sizeof(order));
    word_at(metric_names, desc->metric == STP_METRIC_EUCLIDEAN, metric, sizeof(metric));
    if (!args.json) {
        printf("%u of %u points, %s, %s: index %.1f ms, order %.1f ms, %u thread%s\n", ordered,
               candidates, order, metric, report->index_ms, report->order_ms, threads,
               threads == 1 ? "" : "s");
        return 0;
    }
    json_t* json =
        json_pack("{s:s, s:s, s:I, s:I, s:f, s:f, s:I}", "order", order, "metric", metric,
                  "candidates", (json_int_t)candidates, "count", (json_int_t)ordered, "index_ms",
                  report->index_ms, "order_ms", report->order_ms, "threads", (json_int_t)threads);
    return json != NULL ? tool_print_json(json) : tool_error("out of memory");
}

static int order_points(stp_context* context, const char* path, tool_points* points)
{
    if (args.metric_given && args.metric == 0 && points->normals == NULL) {
        stp_warn(context, "%s: there are no normals, so the metric is euclidean", path);
    }
    static const stp_order_kind kinds[] = {STP_ORDER_EXACT, STP_ORDER_PAPER_FAST,
                                           STP_ORDER_PAPER_TEXT, STP_ORDER_RANDOM,
                                           STP_ORDER_BEST_OF_K};
    stp_order_desc desc = {
        .kind = kinds[args.order],
        .metric = args.metric == 1 || points->normals == NULL || args.order != 0
                      ? STP_METRIC_EUCLIDEAN
                      : STP_METRIC_SIDE,
        .seed = args.seed,
        .samples = (uint32_t)args.samples,
        .interval = (uint32_t)args.interval,
        .drop_factor = (float)args.drop,
    };
    uint32_t wanted =
        args.count != 0 && args.count < points->count ? (uint32_t)args.count : points->count;
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, wanted);
    if (order == NULL) {
        return tool_error("out of memory");
    }
    stp_order_report report;
    uint32_t ordered;
    stp_result result =
        stp_order_points(context, &desc, points->positions, points->normals, points->count, wanted,
                         order, NULL, &ordered, NULL, &report);
    if (result == STP_OK) {
        result = tool_write_points(context, args.output, points, order, ordered);
    }
    stp_free(context, order);
    return result == STP_OK ? print_report(&desc, &report, points->count, ordered,
                                           stp_context_thread_count(context))
                            : 1;
}

static int run(int argc, char** argv)
{
    static const tool_points_command task = {
        .name = "order", .input = "file of points", .output = "ORDERED.ply", .work = order_points};
    return tool_run_on_points(&task, argc, argv, args.output, args.threads, 0);
}

const command command_order = {
    .name = "order",
    .arguments = "POINTS.ply -o ORDERED.ply",
    .summary = "order points so that every prefix covers them evenly",
    .text = "Reads points from any file that can be imported (for meshes, the vertices) and "
            "writes them in the requested order, with normals and colours, as a binary PLY.\n\n"
            "The exact order is the greedy permutation: each point is the farthest from all "
            "points before it. No point of the file is farther from the first n points than "
            "point n + 1 was when it was chosen. Points that coincide with an earlier one are "
            "dropped. paper-fast and paper-text are the two schedules of Brandt et al. 2019, "
            "random is uniformly random, and best-of-k takes the best of 200 random candidates "
            "each time (in stipple-lab: of --samples).\n\n"
            "With the metric side, two points whose normals face apart count as farther from "
            "each other than any two whose normals do not, so that both sides of a thin wall are "
            "covered.",
    .examples = "Write the first 20,000 points of the exact order:\n"
                "$ stipple order points.ply -o ordered.ply --count 20000\n"
                "Use the paper's schedule, for comparison:\n"
                "$ stipple order points.ply -o paper.ply --order paper-fast\n",
    .files = "POINTS.ply\t"
             "any model that can be imported\n"
             "ORDERED.ply\t"
             "binary PLY, in order\n",
    .options = options,
    .run = run,
};
