// SPDX-License-Identifier: MIT
//
// stipple build: models in, one .stip file out.
#include "builder/build_scene.h"
#include "program/files/import_options.h"
#include "program/files/overwrite.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/model_axes.h"
#include "program/options/program.h"
#include "program/options/tool.h"
#include "program/reports/reports.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static struct {
    const char *output, *method, *columns;
    int order, error, metric, psp_metric;
    model_axes axes;
    uint64_t samples, interval, surfels, threshold, resolution, directions, threads, memory, seed,
        color_threshold;
    int progress, capture, levels;
    double leaf_flatness, surfel_ratio, smooth;
    uint64_t leaf_points, leaf_sample, leaf_scales, leaf_neighbors, normal_neighbors;
    bool leaf_points_given, leaf_flatness_given, leaf_sample_given, leaf_scales_given,
        leaf_neighbors_given, normal_neighbors_given;
    bool json, error_given, psp_metric_given, color_threshold_given, threshold_given, resume, fresh;
} args;

static const char* const order_names[] = {"exact", "paper-fast", "paper-text", "random"};
static const stp_order_kind order_kinds[] = {STP_ORDER_EXACT, STP_ORDER_PAPER_FAST,
                                             STP_ORDER_PAPER_TEXT, STP_ORDER_RANDOM};
static const char* const metric_names[] = {"side", "euclidean"};
static const stp_order_metric metrics[] = {STP_METRIC_SIDE, STP_METRIC_EUCLIDEAN};
static const char* const psp_metric_names[] = {"regions", "normals", "distances"};
static const stp_psp_metric psp_metrics[] = {STP_PSP_REGIONS, STP_PSP_NORMALS, STP_PSP_DISTANCES};
static const char* const capture_names[] = {"splats", "triangles"};
static const char* const error_names[] = {"unified", "split", "qsplat"};
static const stp_tree_error errors[] = {STP_TREE_GEOMETRIC, STP_TREE_SPLIT, STP_TREE_DIAMETER};

static const option table[] = {
    {.name = "output",
     .letter = 'o',
     .type = OPTION_TEXT,
     .argument = "FILE.stip",
     .help = "the file to write",
     .value = &args.output,
     .group = "Output"},
    OPTION_JSON(&args.json),
    OPTION_PROGRESS(&args.progress),
    {.name = "up",
     .type = OPTION_CHOICE,
     .argument = "AXIS",
     .words = MODEL_UP_WORDS,
     .help = "up axis, if the input does not specify it",
     .value = &args.axes.up,
     .given = &args.axes.has_up,
     .group = "Input"},
    {.name = "unit",
     .type = OPTION_CHOICE,
     .words = MODEL_UNIT_WORDS,
     .help = "unit of length, if the input does not specify it",
     .value = &args.axes.unit,
     .given = &args.axes.has_unit},
    OPTION_COLUMNS(&args.columns),
    OPTION_SMOOTH(&args.smooth),
    {.name = "method",
     .type = OPTION_TEXT,
     .argument = "NAME,...",
     .help = "method that turns the scene into splats: blue (Progressive Blue Surfels), spt "
             "(Sequential Point Trees), psp (Progressive Splatting) or stochastic "
             "(View-Dependent Stochastic Sampling); a list stores several methods for the "
             "same nodes; default blue",
     .value = &args.method,
     .group = "Splats"},
    {.name = "surfels",
     .type = OPTION_COUNT,
     .argument = "N|auto",
     .words = "auto|1..1000000000",
     .help = "most surfels of a node, which has fewer where --surfel-ratio asks for fewer; default "
             "50000; of a point cloud, all points",
     .value = &args.surfels},
    {.name = "surfel-ratio",
     .type = OPTION_NUMBER,
     .argument = "N",
     .words = "auto|0.001..1000000",
     .help =
         "one surfel for N triangles; default 8; the paper's rule is --surfel-ratio 2 --surfels "
         "200000",
     .value = &args.surfel_ratio,
     .rare = true},
    {.name = "threshold",
     .type = OPTION_COUNT,
     .argument = "N",
     .help = "give a node splats if it has more than N triangles; default 1000",
     .value = &args.threshold,
     .given = &args.threshold_given,
     .rare = true},
    {.name = "resume",
     .help = "continue an interrupted build and reuse unchanged parts of an earlier one "
             "(default)",
     .value = &args.resume,
     .group = "Build"},
    {.name = "fresh", .help = "start from scratch and reuse nothing", .value = &args.fresh},
    OPTION_MEMORY(&args.memory),
    OPTION_THREADS(&args.threads),
    {.name = "order",
     .type = OPTION_CHOICE,
     .words = "exact|paper-fast|paper-text|random",
     .help = "order of the surfels; default exact",
     .value = &args.order,
     .group = "Method blue, and the samples of spt and psp",
     .rare = true},
    {.name = "metric",
     .type = OPTION_CHOICE,
     .words = "side|euclidean",
     .help = "distance between candidates; side (the default) separates the two sides of a wall",
     .value = &args.metric,
     .rare = true},
    {.name = "samples",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "auto|1..1000000",
     .help = "random samples per round of the paper's orders; default 200",
     .value = &args.samples,
     .lab_only = true},
    {.name = "interval",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "auto|1..1000000000",
     .help = "rounds before the paper's schedules change; default 500",
     .value = &args.interval,
     .lab_only = true},
    {.name = "capture",
     .type = OPTION_CHOICE,
     .words = "splats|triangles",
     .help = "what upper nodes capture: their children's splats where these are dense "
             "enough (default), or always the triangles",
     .value = &args.capture,
     .rare = true},
    {.name = "levels",
     .type = OPTION_CHOICE,
     .words = "on|off",
     .help = "simplified triangles of dense parts, which views draw instead of splats where they "
             "show more for the work; off: the file is smaller and built sooner; default on",
     .value = &args.levels,
     .rare = true},
    {.name = "resolution",
     .type = OPTION_COUNT,
     .argument = "PX|auto",
     .words = "auto|1..32768",
     .help = "pixels along the longer side of a capture; by default chosen from the number "
             "of surfels",
     .value = &args.resolution,
     .rare = true},
    {.name = "directions",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "auto|1..1024",
     .help = "number of capture directions; default 8",
     .value = &args.directions,
     .rare = true},
    {.name = "seed",
     .type = OPTION_COUNT,
     .argument = "N",
     .help = "random seed of the orders; default 0",
     .value = &args.seed,
     .rare = true},
    {.name = "error",
     .type = OPTION_CHOICE,
     .argument = "NAME",
     .words = "unified|split|qsplat",
     .help = "error of an spt node: unified (its geometric error), split (its two parts, which "
             "depend on the direction of view: fewer splats, but slower) or qsplat (its "
             "diameter, as in QSplat); default unified",
     .value = &args.error,
     .given = &args.error_given,
     .group = "Method spt",
     .rare = true},
    {.name = "color-threshold",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "0..255",
     .help = "use the diameter as the error of an spt node whose colours differ by more than N "
             "of 255; default 48",
     .value = &args.color_threshold,
     .given = &args.color_threshold_given,
     .lab_only = true},
    {.name = "psp-metric",
     .type = OPTION_CHOICE,
     .argument = "NAME",
     .words = "regions|normals|distances",
     .help =
         "error that decides which splats are merged: regions (change of the picture), or those "
         "of the paper: normals (change of the normals) and distances (of the samples from "
         "their splat); default regions",
     .value = &args.psp_metric,
     .given = &args.psp_metric_given,
     .group = "Method psp",
     .rare = true},
    {.name = "leaf-points",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "16..1000000",
     .help = "maximum points per leaf; default 1024",
     .value = &args.leaf_points,
     .given = &args.leaf_points_given,
     .group = "Method stochastic",
     .lab_only = true},
    {.name = "leaf-flatness",
     .type = OPTION_NUMBER,
     .argument = "F",
     .words = "0..0.1",
     .help = "split a leaf until the smallest variance of its points is at most this share "
             "of the total; default 0.005",
     .value = &args.leaf_flatness,
     .given = &args.leaf_flatness_given,
     .lab_only = true},
    {.name = "leaf-sample",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "16..1000000",
     .help = "number of random points that decide whether a larger region is flat; "
             "default 256",
     .value = &args.leaf_sample,
     .given = &args.leaf_sample_given,
     .lab_only = true},
    {.name = "leaf-scales",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "1..4",
     .help = "number of region sizes, from a leaf's own on, that must show a feature for it "
             "to count: with 1, noise counts as a feature; default 2",
     .value = &args.leaf_scales,
     .given = &args.leaf_scales_given,
     .lab_only = true},
    {.name = "leaf-neighbors",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "1..32",
     .help = "number of neighbouring leaves that each leaf passes its orientation on to "
             "(points without normals); default 12",
     .value = &args.leaf_neighbors,
     .given = &args.leaf_neighbors_given,
     .lab_only = true},
    {.name = "normal-neighbors",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "4..1000",
     .help = "approximate number of neighbours used to estimate each normal (points "
             "without normals); default 20",
     .value = &args.normal_neighbors,
     .given = &args.normal_neighbors_given,
     .lab_only = true},
    {0},
};

static const option* options(void)
{
    return table;
}

// Parses a list of method names. @return the number of methods; 0 if a name is unknown or repeated
static uint32_t choose_methods(const stp_method* chosen[STP_METHOD_COUNT])
{
    const char* at = args.method != NULL ? args.method : "blue";
    for (uint32_t count = 0; count < STP_METHOD_COUNT;) {
        char name[32];
        size_t length = strcspn(at, ",");
        snprintf(name, sizeof(name), "%.*s", (int)(length < 31 ? length : 31), at);
        const stp_method* method = stp_method_by_name(name);
        for (uint32_t i = 0; i < count; ++i) {
            method = chosen[i] == method ? NULL : method;
        }
        if (method == NULL) {
            return 0;
        }
        chosen[count++] = method;
        if (at[length] == '\0') {
            return count;
        }
        at += length + 1;
    }
    return 0;
}

// The options as the file records them. Threads and memory do not affect the file, so they are left
// out. NULL if memory runs out.
static char* parameters_json(void)
{
    json_t* json = json_pack(
        "{s:s, s:s, s:s, s:s, s:I, s:I}", "method", args.method != NULL ? args.method : "blue",
        "order", order_names[args.order], "metric", metric_names[args.metric], "capture",
        capture_names[args.capture], "threshold",
        (json_int_t)(args.threshold_given ? args.threshold : STP_BUILD_DEFAULT_THRESHOLD), "seed",
        (json_int_t)args.seed);
    const struct {
        const char* key;
        uint64_t value;
    } counts[] = {{"samples", args.samples},
                  {"interval", args.interval},
                  {"surfels", args.surfels},
                  {"resolution", args.resolution},
                  {"directions", args.directions}};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); ++i) {
        if (counts[i].value != 0) {
            (void)json_object_set_new(json, counts[i].key,
                                      json_integer((json_int_t)counts[i].value));
        }
    }
    if (args.surfel_ratio > 0.0) {
        (void)json_object_set_new(json, "surfel_ratio", json_real(args.surfel_ratio));
    }
    if (args.levels == 1) {
        (void)json_object_set_new(json, "levels", json_string("off"));
    }
    if (args.error_given) {
        (void)json_object_set_new(json, "error", json_string(error_names[args.error]));
    }
    if (args.psp_metric_given) {
        (void)json_object_set_new(json, "psp_metric",
                                  json_string(psp_metric_names[args.psp_metric]));
    }
    if (args.color_threshold_given) {
        (void)json_object_set_new(json, "color_threshold",
                                  json_integer((json_int_t)args.color_threshold));
    }
    if (args.axes.has_up) {
        (void)json_object_set_new(json, "up", json_string(model_up_names[args.axes.up]));
    }
    if (args.axes.has_unit) {
        (void)json_object_set_new(json, "unit", json_string(model_unit_names[args.axes.unit]));
    }
    if (args.smooth > 0.0) {
        (void)json_object_set_new(json, "smooth", json_real(args.smooth));
    }
    if (args.columns != NULL) {
        (void)json_object_set_new(json, "columns", json_string(args.columns));
    }
    char* text = json_dumps(json, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(json);
    return text;
}

/// Whether a failed build left finished parts beside its output, which could not be written.
static bool resumes(const char* output)
{
    char folder[PATH_MAX];
    struct stat status;
    size_t size = strlen(output);
    const char* error = tool_held_error(); // begins with the path
    bool writing = strncmp(error, output, size) == 0 &&
                   (error[size] == ':' || strncmp(error + size, ".work", 5) == 0);
    return writing && stp_build_work_folder(output, folder, sizeof(folder)) &&
           stat(folder, &status) == 0 && S_ISDIR(status.st_mode);
}

static int build(stp_context* context, int argc, char** argv)
{
    const stp_method* chosen[STP_METHOD_COUNT];
    stp_build_desc desc = {
        .inputs = (const char* const*)argv,
        .input_count = (size_t)argc,
        .generate = program_make_scene,
        .output = args.output,
        .import = {.up = model_axes_up(&args.axes),
                   .unit_metres = model_axes_unit(&args.axes),
                   .columns = args.columns,
                   .smooth_degrees = args.smooth},
        .blue = {.capture = {.direction_count = (uint32_t)args.directions,
                             .resolution = (uint32_t)args.resolution},
                 .order = {.kind = order_kinds[args.order],
                           .metric = metrics[args.metric],
                           .seed = args.seed,
                           .samples = (uint32_t)args.samples,
                           .interval = (uint32_t)args.interval}},
        .splat_rule = {args.surfel_ratio, (uint32_t)args.surfels},
        .methods = chosen,
        .method_count = choose_methods(chosen),
        .coarse = true,
        .method_options = stp_method_options_default(),
        .threshold = args.threshold_given && args.threshold == 0 ? 1 : args.threshold,
        .no_levels = args.levels == 1,
        .from_triangles = args.capture == 1,
        .fresh = args.fresh,
        .memory_bytes = args.memory,
    };
    desc.method_options.tree.error = errors[args.error];
    desc.method_options.psp_metric = psp_metrics[args.psp_metric];
    if (args.leaf_points_given) {
        desc.method_options.leaves.budget = (uint32_t)args.leaf_points;
    }
    if (args.leaf_flatness_given) {
        desc.method_options.leaves.flatness = (float)args.leaf_flatness;
    }
    if (args.leaf_sample_given) {
        desc.method_options.leaves.sample = (uint32_t)args.leaf_sample;
    }
    if (args.leaf_scales_given) {
        desc.method_options.leaves.scales = (uint32_t)args.leaf_scales;
    }
    if (args.leaf_neighbors_given) {
        desc.method_options.leaves.neighbours = (uint32_t)args.leaf_neighbors;
    }
    if (args.normal_neighbors_given) {
        desc.method_options.leaves.normal_neighbours = (uint32_t)args.normal_neighbors;
    }
    if (args.color_threshold_given) {
        desc.method_options.tree.color_threshold = (uint32_t)args.color_threshold;
    }
    char* parameters = parameters_json();
    if (parameters == NULL) {
        return tool_error("out of memory");
    }
    desc.parameters_json = parameters;
    stp_build_report report;
    tool_hold_errors();
    stp_result result = stp_build(context, &desc, &report);
    bool again = result == STP_ERROR_IO && !args.fresh && resumes(args.output);
    tool_release_errors(true, again ? "the same command resumes where it stopped" : NULL);
    free(parameters);
    return result == STP_OK
               ? build_report_print(context, args.output, &report,
                                    build_sizes_input(desc.inputs, desc.input_count), args.json)
               : 1;
}

// Suffixes of models and pictures that a .stip file should not have. Any other suffix is allowed.
static bool output_is_stip(const char* path)
{
    static const char* const others[] = {
        "gltf",  "glb", "obj",  "mtl", "ply",  "stl", "fbx",  "dae", "3ds",  "3mf",
        "blend", "ifc", "x3d",  "wrl", "off",  "dxf", "lwo",  "usd", "usda", "usdc",
        "usdz",  "stp", "step", "igs", "iges", "las", "laz",  "e57", "pts",  "ptx",
        "pcd",   "xyz", "hgt",  "tif", "tiff", "png", "bin",  "jpg", "jpeg", "webp",
        "ktx2",  "bmp", "gif",  "svg", "pdf",  "mp4", "json", "zip"};
    const char* slash = strrchr(path, '/');
    const char* dot = strrchr(slash != NULL ? slash : path, '.');
    for (size_t i = 0; dot != NULL && i < sizeof(others) / sizeof(others[0]); ++i) {
        if (strcasecmp(dot + 1, others[i]) == 0) {
            return false;
        }
    }
    return true;
}

static int run(int argc, char** argv)
{
    if (argc < 1) {
        return tool_usage_error("build needs at least one input");
    }
    int streams = tool_check_inputs(argc, argv);
    if (streams != 0) {
        return streams;
    }
    const stp_method* chosen[STP_METHOD_COUNT];
    uint32_t count = choose_methods(chosen);
    if (count == 0) {
        assert(args.method != NULL && "the default method is known");
        return tool_usage_error(
            "--method is a list of blue, spt, psp and stochastic, each at most once, not %s",
            args.method);
    }
    bool point_trees = false, merges = false, leaves = false;
    for (uint32_t i = 0; i < count; ++i) {
        point_trees = point_trees || chosen[i]->id == STP_METHOD_SPT;
        merges = merges || chosen[i]->id == STP_METHOD_PSP;
        leaves = leaves || chosen[i]->id == STP_METHOD_STOCHASTIC;
    }
    const char* needless = args.leaf_points_given        ? "leaf-points"
                           : args.leaf_flatness_given    ? "leaf-flatness"
                           : args.leaf_sample_given      ? "leaf-sample"
                           : args.leaf_scales_given      ? "leaf-scales"
                           : args.leaf_neighbors_given   ? "leaf-neighbors"
                           : args.normal_neighbors_given ? "normal-neighbors"
                                                         : NULL;
    if (!leaves && needless != NULL) {
        return tool_usage_error("--%s requires --method stochastic", needless);
    }
    if (!point_trees && (args.error_given || args.color_threshold_given)) {
        return tool_usage_error("--%s requires --method spt",
                                args.error_given ? "error" : "color-threshold");
    }
    if (!merges && args.psp_metric_given) {
        return tool_usage_error("--psp-metric requires --method psp");
    }
    if (args.resume && args.fresh) {
        return tool_usage_error("--resume and --fresh exclude each other");
    }
    if (args.output == NULL) {
        return tool_usage_error("build needs -o FILE.stip");
    }
    int usage = tool_take_columns(args.columns, argc, argv);
    usage = usage == 0 ? tool_take_smooth(args.smooth, argc, argv) : usage;
    if (usage != 0) {
        return usage;
    }
    if (strcmp(args.output, "-") == 0) {
        return tool_usage_error("a build cannot be written to standard output; name a file");
    }
    for (int i = 0; i < argc; ++i) {
        int code = overwrite_check(argv[i], args.output);
        if (code != 0) {
            return code;
        }
    }
    if (!output_is_stip(args.output)) {
        return tool_usage_error("%s: build writes .stip files only", args.output);
    }
    stp_context* context = tool_context_create((uint32_t)args.threads, args.memory,
                                               tool_progress_names[args.progress]);
    if (context == NULL) {
        return 1;
    }
    int code = build(context, argc, argv);
    stp_context_destroy(context);
    return code;
}

const command command_build = {
    .name = "build",
    .arguments = "INPUT... -o FILE.stip",
    .summary = "import models, order them into splats, write a .stip file",
    .text =
        "Imports one or more models into one scene and writes it as splats and triangles. In "
        "stipple-lab an input may also be a procedural scene, scene:NAME, with settings after "
        "commas: scene:paper,scale=0.1,seed=3. If several inputs have a view of "
        "the same name, the later ones get a number: front, front-2.\n\n"
        "The build captures the visible surface from all around and orders surfels from it so "
        "that every prefix covers the whole surface evenly (Brandt et al. 2019). It keeps the "
        "original triangles for close views, and simplified ones of dense parts for those in "
        "between.\n\n"
        "Reads directly: glTF 2.0 (.gltf, .glb; with Draco, meshopt, quantization, PNG, JPEG and "
        "WebP), OBJ, PLY, STL, OFF, 3MF, point clouds (LAS 1.0 to 1.4, LAZ, COPC, E57, PTX, PTS, "
        "PCD "
        "and "
        "the text formats XYZ, TXT, CSV, ASC) and height tiles (.hgt). Reads through assimp: "
        "FBX, Collada (.dae), 3DS, IFC, X3D, Blender, DXF, LWO and other formats that "
        "assimp supports. One warning lists what was skipped (animations, skins, lines, "
        "extensions). STEP and IGES are not supported: they store exact surfaces, not "
        "triangles.\n\n"
        "Each node with more triangles than --threshold gets its own splats, from the leaves "
        "up. Intermediate results are kept in FILE.stip.work until the file is complete: run the "
        "same command again to resume an interrupted build, with the same result. If FILE.stip "
        "exists, unchanged parts are reused.\n\n"
        "The same inputs and options always produce the same bytes, on any machine, with any "
        "number of threads and any memory limit. The file is written under a temporary name and "
        "then renamed: if a build fails or is interrupted, an existing file stays unchanged.",
    .examples = "Build a model:\n"
                "$ stipple build plant.glb -o plant.stip\n"
                "Several models in one scene, z up, in millimetres:\n"
                "$ stipple build hall.obj pipes.stl -o plant.stip --up z --unit mm\n"
                "A large model, within 8 GB of memory:\n"
                "$ stipple build city.glb -o city.stip --memory 8G\n",
    .files = "FILE.stip\tthe result\n"
             "FILE.stip.work\tfinished parts of an incomplete build; the same command resumes "
             "from them\n",
    .interrupted = "the same command resumes where it stopped",
    .options = options,
    .run = run,
};
