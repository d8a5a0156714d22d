// SPDX-License-Identifier: MIT
//
// stipple-lab decimate: approximates many points by a few elliptical splats.
#include "base/core/clock.h"
#include "lab/decimate/decimators.h"
#include "lod/psp/forest.h"
#include "lod/psp/kd_tree.h"
#include "program/files/point_file.h"
#include "program/files/splat_file.h"
#include "program/files/splat_store.h"
#include "program/options/command.h"
#include "program/options/tool.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { DEFAULT_SPLATS = 2000 };

static struct {
    const char* output;
    int by, metric, queue;
    uint64_t splats, neighbours, piece_size, threads, memory;
    double merge_angle;
    bool has_angle, connect, record, json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "SPLATS.ply|SPLATS.stip",
         .help = "file to write: a PLY of splats, or a .stip, which render and view draw",
         .value = &args.output},
        {.name = "by",
         .type = OPTION_CHOICE,
         .words = DECIMATOR_WORDS,
         .help = "decimation method; default psp (Progressive Splatting); the others are for "
                 "comparison",
         .value = &args.by},
        {.name = "splats",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4294967295",
         .help = "number of splats; default 2000; more remain if the points lie too far apart to "
                 "merge",
         .value = &args.splats},
        {.name = "metric",
         .type = OPTION_CHOICE,
         .words = "normals|distances",
         .help =
             "error of a merge: change of the normals, or distance of the points from the splat; "
             "default normals",
         .value = &args.metric},
        {.name = "neighbours",
         .type = OPTION_COUNT,
         .argument = "K",
         .words = "1..32",
         .help = "number of nearest points that count as neighbours; default 8",
         .value = &args.neighbours},
        {.name = "merge-angle",
         .type = OPTION_NUMBER,
         .argument = "DEGREES",
         .words = "0..180",
         .help = "maximum angle between the normals of merged splats; default 90",
         .value = &args.merge_angle,
         .given = &args.has_angle},
        {.name = "connect",
         .help = "also merge splats that lie apart or face apart, if no others remain, "
                 "until there are at most N",
         .value = &args.connect},
        {.name = "record",
         .help = "store all merges in a .stip: it draws N splats, and render, view and "
                 "compare-splats --splats M draw any number up to one per point",
         .value = &args.record},
        {.name = "queue",
         .type = OPTION_CHOICE,
         .words = "eager|lazy",
         .help = "when to update the queue after the best merge of a splat gets worse: at once "
                 "(eager) or when the splat is next; the result is the same; default eager",
         .value = &args.queue},
        {.name = "piece-size",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "auto|8..1073741824",
         .help = "splats that one queue merges; more are merged in pieces on all threads; default "
                 "8192",
         .value = &args.piece_size},
        OPTION_THREADS(&args.threads),
        {.name = "memory",
         .type = OPTION_SIZE,
         .argument = "SIZE",
         .words = OPTION_MEMORY_WORDS,
         .help = "memory limit, such as 8G or 512M; psp stores more data in temporary files in the "
                 "folder of the output; default no limit",
         .value = &args.memory},
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

static stp_psp_desc make_desc(void)
{
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = args.metric == 0 ? STP_PSP_NORMALS : STP_PSP_DISTANCES;
    desc.neighbours = args.neighbours != 0 ? (uint32_t)args.neighbours : desc.neighbours;
    desc.eager = args.queue == 0;
    desc.piece_size = (uint32_t)args.piece_size;
    desc.connect_components = args.connect;
    if (args.has_angle) {
        desc.min_cosine =
            args.merge_angle < 180.0 ? (float)cos(args.merge_angle * 0.017453292519943295) : -2.0f;
    }
    return desc;
}

static void notice_more(stp_context* context, uint32_t count, uint32_t target)
{
    if (count > target) {
        stp_notice(context, "%u splats are left: their points lie apart, or face apart", count);
    }
}

static int print_report(stp_context* context, const tool_splats* splats, uint32_t points,
                        double seconds)
{
    double area = 0.0, rate = seconds > 0.0 ? points / seconds : 0.0;
    for (uint32_t i = 0; i < splats->count; ++i) {
        area += (double)stp_ellipse_area(&splats->ellipses[splats->indices[i]]);
    }
    if (args.json) {
        return tool_print_json(json_pack(
            "{s:s, s:s, s:I, s:I, s:f, s:f, s:f, s:I}", "by", "psp", "metric",
            args.metric == 0 ? "normals" : "distances", "points", (json_int_t)points, "splats",
            (json_int_t)splats->count, "area", area, "seconds", seconds, "points_per_second", rate,
            "peak_bytes", (json_int_t)stp_context_peak_bytes(context)));
    }
    printf("%u splats for %u points, area %.4g, in %.2f s\n", splats->count, points, area, seconds);
    return 0;
}

static uint8_t* drop_alpha(stp_context* context, const tool_points* points)
{
    uint8_t* colors = STP_NEW_ARRAY(context, uint8_t, 3 * (size_t)points->count + 1);
    for (size_t i = 0; colors != NULL && i < points->count; ++i) {
        memcpy(colors + 3 * i, points->colors + 4 * i, 3);
    }
    return colors;
}

static int decimate_by_other(stp_context* context, const tool_points* from)
{
    uint8_t* colors = from->colors != NULL ? drop_alpha(context, from) : NULL;
    int code = 1;
    if (from->colors != NULL && colors == NULL) {
        (void)stp_fail_memory(context);
    } else {
        code = tool_decimate_by(
            context,
            &(tool_decimation){.by = args.by,
                               .points = from,
                               .colors = colors,
                               .target = args.splats != 0 ? (uint32_t)args.splats : DEFAULT_SPLATS,
                               .output = args.output,
                               .json = args.json});
    }
    stp_free(context, colors);
    return code;
}

/// If the merge does not fit in memory, it uses a file in the folder of the output.
static stp_result choose_spill(stp_context* context, tool_points* from, stp_psp_desc* desc)
{
    uint64_t needed = stp_context_live_bytes(context) + stp_psp_decimate_bytes(from->count, desc);
    if (needed <= stp_usable_memory(stp_memory_limit(context))) {
        return STP_OK;
    }
    stp_result result = tool_points_open_spill(context, args.output, from);
    desc->spill = from->spill;
    return result;
}

/// Merges points, and writes the splats that are left with the record of merges: a base set, and an
/// operator for each merge (section 5).
static int decimate_with_record(stp_context* context, const tool_points* from,
                                const stp_psp_points* points, const stp_psp_desc* desc)
{
    uint32_t target = args.splats != 0 ? (uint32_t)args.splats : DEFAULT_SPLATS;
    stp_psp_forest forest = {0};
    stp_psp_sequence sequence = {0};
    double start = stp_clock_ms();
    stp_result result = stp_psp_forest_make(context, points, desc, target, &forest);
    double seconds = 1e-3 * (stp_clock_ms() - start);
    result = result == STP_OK ? stp_psp_rank_merges(context, &forest) : result;
    result = result == STP_OK ? stp_psp_sequence_make(context, &forest, &sequence) : result;
    int code = 1;
    if (result == STP_OK) {
        uint32_t left = forest.point_count - forest.merge_count;
        tool_splats splats = {.ellipses = forest.ellipses,
                              .colors = forest.colors,
                              .indices = sequence.splats,
                              .count = sequence.count,
                              .ranges = sequence.ranges,
                              .base = left};
        memcpy(splats.origin, from->origin, sizeof(splats.origin));
        notice_more(context, left, target);
        result = tool_write_any_splats(context, args.output, &splats, from->up);
        splats.count = left; // the base set comes first
        code = result == STP_OK ? print_report(context, &splats, from->count, seconds) : 1;
    }
    stp_psp_sequence_destroy(context, &sequence);
    stp_psp_forest_destroy(context, &forest);
    return code;
}

static int decimate(stp_context* context, const char* path, tool_points* from)
{
    (void)path;
    if (args.by != 0) {
        return decimate_by_other(context, from);
    }
    uint32_t target = args.splats != 0 ? (uint32_t)args.splats : DEFAULT_SPLATS;
    const stp_psp_points points = {.count = from->count,
                                   .positions = from->positions,
                                   .normals = from->normals,
                                   .colors = from->colors,
                                   .color_bytes = 4};
    stp_psp_desc desc = make_desc();
    desc.two_sided = from->normals == NULL; // then the sides of the initial splats are a guess
    if (args.record) {
        return decimate_with_record(context, from, &points, &desc);
    }
    stp_psp_splats left = {0};
    double start = stp_clock_ms();
    stp_result result = choose_spill(context, from, &desc);
    result = result == STP_OK ? stp_psp_decimate(context, &points, &desc, target, &left) : result;
    double seconds = 1e-3 * (stp_clock_ms() - start);
    uint32_t* all =
        result == STP_OK ? STP_NEW_ARRAY(context, uint32_t, (size_t)left.count + 1) : NULL;
    int code = 1;
    if (all != NULL) {
        for (uint32_t i = 0; i < left.count; ++i) {
            all[i] = i;
        }
        tool_splats splats = {
            .ellipses = left.ellipses, .colors = left.colors, .indices = all, .count = left.count};
        memcpy(splats.origin, from->origin, sizeof(splats.origin));
        notice_more(context, splats.count, target);
        result = tool_write_any_splats(context, args.output, &splats, from->up);
        code = result == STP_OK ? print_report(context, &splats, from->count, seconds) : 1;
    } else if (result == STP_OK) {
        (void)stp_fail_memory(context);
    }
    stp_free(context, all);
    stp_psp_splats_destroy(context, &left);
    return code;
}

static bool names_a_store(const char* path)
{
    size_t length = strlen(path);
    return length > 5 && strcmp(path + length - 5, ".stip") == 0;
}

/// Whether a name has the extension of a format that decimate does not write.
static bool names_another_format(const char* path)
{
    const char* slash = strrchr(path, '/');
    const char* dot = strrchr(slash != NULL ? slash : path, '.');
    return dot != NULL && strcasecmp(dot, ".ply") != 0 && strcasecmp(dot, ".stip") != 0;
}

static int run(int argc, char** argv)
{
    if (args.by != 0 && (args.metric != 0 || args.queue != 0 || args.neighbours != 0 ||
                         args.has_angle || args.connect || args.record || args.piece_size != 0)) {
        return tool_usage_error("decimate: --metric, --neighbours, --merge-angle, --connect, "
                                "--record, --queue and --piece-size need --by psp");
    }
    if (args.record && args.output != NULL && !names_a_store(args.output)) {
        return tool_usage_error("decimate: --record needs a name of the output that ends in .stip");
    }
    if (args.output != NULL && names_another_format(args.output)) {
        return tool_usage_error("decimate: the name of the output, %s, ends in neither .ply nor "
                                ".stip",
                                args.output);
    }
    const tool_points_command task = {.name = "decimate",
                                      .input = "model",
                                      .output = "SPLATS.ply",
                                      .work = decimate,
                                      .triangles = args.by != 0,
                                      .spills = args.by == 0};
    return tool_run_on_points(&task, argc, argv, args.output, args.threads, args.memory);
}

const command command_decimate = {
    .name = "decimate",
    .arguments = "MODEL -o SPLATS.ply",
    .summary = "approximate points by a few elliptical splats",
    .text =
        "Reads points from any file that can be imported (for meshes, the vertices) and replaces "
        "them by the requested number of elliptical splats.\n\n"
        "psp is Progressive Splatting (Wu, Zhang, Kobbelt 2005). Each point becomes a disk that "
        "reaches the farthest of its nearest neighbours. Then pairs of neighbouring splats are "
        "merged, the pair with the smallest error first. The points do not need normals.\n\n"
        "The other methods are for comparison:\n\n"
        "octree: one ellipse per cell of an octree (Pajarola 2003). The largest cell is split "
        "first, as long as there are at most N splats; the result has up to six fewer.\n\n"
        "octree-level: one ellipse per cell of the octree level whose number of cells is closest "
        "to N.\n\n"
        "quadric: pairs of neighbouring points are contracted by quadric error (Pauly, Gross, "
        "Kobbelt 2002), then each point becomes a disk that reaches the farthest of its nearest "
        "neighbours.\n\n"
        "mesh: edges of the triangles are collapsed by quadric error (Garland, Heckbert "
        "1997) until N vertices remain; the PLY holds triangles.\n\n"
        "blue: the first N points of `stipple order`, with the smallest disks that cover the "
        "points nearest to each.\n\n"
        "subsample: splats that cover the most points are chosen until all points are covered, "
        "then moved so that fewer suffice (Wu, Kobbelt 2004). The tolerance is searched so that "
        "at most N remain.\n\n"
        "With --record, a .stip also stores how each merge is undone, about 16 bytes each: the "
        "progressive splats of the paper. Merging then takes about 220 bytes of memory a point, or "
        "290 by distances, and spills nothing.\n\n"
        "A .stip stores the splats as one set. render, view and compare-splats draw all of them, "
        "or the first N with --splats N. --splat-scale 0.3 shows how they are distributed.",
    .examples = "Turn a statue into 5,000 splats:\n"
                "$ stipple-lab decimate statue.ply -o splats.ply --splats 5000\n"
                "Draw a picture of their distribution:\n"
                "$ stipple-lab decimate statue.ply -o splats.stip --splats 5000\n"
                "$ stipple render splats.stip -o splats.png --splat-scale 0.3\n"
                "Sample a mesh evenly first, because its vertices are sparse on flat parts:\n"
                "$ stipple-lab capture plant.glb -o points.ply\n"
                "$ stipple-lab decimate points.ply -o splats.ply\n"
                "Use an octree, for comparison:\n"
                "$ stipple-lab decimate statue.ply -o octree.ply --splats 5000 --by octree\n",
    .files = "MODEL\tany model that can be imported\n"
             "SPLATS.ply\tbinary PLY: centre, normal, major axis, length of the minor axis, "
             "colour; for mesh: vertices with colours, and triangles\n"
             "SPLATS.stip\tthe same splats as a scene: 16-bit positions, radii up to 0.8 % too "
             "large\n",
    .options = options,
    .run = run,
};
