// SPDX-License-Identifier: MIT
//
// stipple info: describes the content of a .stip file or a model.
#include "base/io/file.h"
#include "builder/writer_input.h"
#include "import/reading/import.h"
#include "program/files/import_options.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/point_colors.h"
#include "program/reports/describe.h"
#include "program/reports/reports.h"

#include <stdio.h>
#include <string.h>

static struct {
    uint64_t memory;
    const char *find, *columns;
    model_axes axes;
    bool json, formats;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "find",
         .type = OPTION_TEXT,
         .argument = "TEXT",
         .help = "list the objects of a .stip whose name or id contains TEXT, ignoring case",
         .value = &args.find},
        OPTION_MEMORY(&args.memory),
        OPTION_JSON(&args.json),
        {.name = "formats",
         .help = "list the formats of models with their suffixes; takes no FILE",
         .value = &args.formats},
        OPTION_COLUMNS(&args.columns),
        OPTION_MODEL_UP("up", &args.axes),
        OPTION_MODEL_UNIT(&args.axes),
        {0},
    };
    return table;
}

// The content of the header of a point file.
typedef struct header {
    const stp_scene* scene;
    const stp_scan_info* scan;
} header;

static json_t* make_json(const scene_figures* figures, const header* h)
{
    json_t* json = describe_json(figures);
    if (json != NULL && h != NULL) {
        (void)json_object_set_new(json, "scan", scan_report_json(h->scene, h->scan));
    }
    return json;
}

static int print_figures(const char* path, stp_result described, scene_figures* figures,
                         const header* h)
{
    int code = 0;
    if (described != STP_OK) {
        code = 1;
    } else if (args.json) {
        json_t* json = make_json(figures, h);
        code = json != NULL ? tool_print_json(json) : tool_error("out of memory");
    } else {
        describe_print(path, figures);
        if (h != NULL) {
            scan_report_print_fields(h->scan);
        }
    }
    describe_destroy(figures);
    return code;
}

/// Whether a file is drawn by elevation if no colour is asked for. Only of clouds does it read more
/// than the description; false if that is damaged.
static bool is_by_elevation(stp_context* context, const char* path, const scene_figures* figures)
{
    if (figures->summary.figures.triangles > 0 || figures->summary.figures.points == 0) {
        return point_colors_is_terrain(figures->directory);
    }
    stp_store* store = NULL;
    stp_store_open_desc desc = {.defer_objects = true, .accept_partial = true};
    int color = POINT_COLOR_AUTO;
    tool_hold_errors();
    bool opened = stp_store_open_with(context, path, &desc, &store) == STP_OK;
    bool known = opened && point_colors_choose(store, 0, &color) == STP_OK;
    stp_store_close(store);
    tool_release_errors(false, NULL);
    return known && color == POINT_COLOR_ELEVATION;
}

static int print_store(stp_context* context, const char* path)
{
    stp_store* store = NULL;
    stp_store_open_desc desc = {.summary_only = true, .accept_partial = true};
    if (stp_store_open_with(context, path, &desc, &store) != STP_OK) {
        return 1;
    }
    scene_figures figures;
    stp_result described = describe_store(context, store, &figures);
    figures.by_elevation = described == STP_OK && is_by_elevation(context, path, &figures);
    int code = print_figures(path, described, &figures, NULL);
    stp_store_close(store);
    return code;
}

static int print_found(stp_context* context, const char* path)
{
    stp_store* store = NULL;
    stp_store_open_desc desc = {.defer_objects = true, .accept_partial = true};
    if (stp_store_open_with(context, path, &desc, &store) != STP_OK) {
        return 1;
    }
    int code = find_print(context, store, args.find, args.json);
    stp_store_close(store);
    return code;
}

static int print_model(stp_context* context, const char* path)
{
    stp_scene* scene = NULL;
    stp_scan_info scan;
    stp_build_content content = {0};
    stp_store_census census = {0};
    stp_result result = tool_import_described(context, path, &scan, &scene);
    if (result == STP_OK && scan.alone) {
        int code = scan_report_print(path, scene, &scan, args.json);
        stp_scene_destroy(scene);
        return code;
    }
    result = result == STP_OK ? stp_build_census(scene, &census) : result;
    result =
        result == STP_OK ? stp_build_content_create(scene, NULL, 0, NULL, NULL, &content) : result;
    int code = 1;
    if (result == STP_OK) {
        scene_figures figures;
        content.content.census = &census;
        stp_result described = describe_content(context, &content.content, &figures);
        const header h = {scene, &scan};
        code = print_figures(path, described, &figures, scan.format != NULL ? &h : NULL);
    }
    stp_build_content_destroy(&content);
    stp_store_census_destroy(context, &census);
    stp_scene_destroy(scene);
    return code;
}

// Whether the file starts like a .stip or has that extension. Any other file, also an unreadable
// one, is left to the importer to report.
static bool is_store(const char* path)
{
    static const unsigned char magic[8] = {0x89, 'S', 'T', 'P', '\r', '\n', 0x1a, '\n'};
    unsigned char bytes[8] = {0};
    bool same = stp_file_peek(path, bytes, 8) == 8 && memcmp(bytes, magic, 8) == 0;
    size_t length = strlen(path);
    return same || (length > 5 && strcmp(path + length - 5, ".stip") == 0);
}

/// Prints a line for each format: its name and its suffixes.
static int print_formats(void)
{
    json_t* list = json_array();
    const stp_importer* importer;
    for (size_t i = 0; (importer = stp_import_listed(i)) != NULL; ++i) {
        const char* suffixes = stp_importer_listed(importer);
        (void)json_array_append_new(list,
                                    json_pack("{s:s, s:s, s:s}", "format", importer->name, "title",
                                              importer->title, "suffixes", suffixes));
        if (!args.json) {
            printf("%-16s%s\n", importer->title, suffixes);
        }
    }
    if (args.json) {
        return tool_print_json(json_pack("{s:o}", "formats", list));
    }
    json_decref(list);
    return 0;
}

static int run(int argc, char** argv)
{
    if (args.formats) {
        return argc == 0 ? print_formats() : tool_usage_error("--formats takes no file");
    }
    if (argc != 1) {
        return tool_usage_error("info needs one file, but got %d", argc);
    }
    int usage = tool_take_columns(args.columns, argc, argv);
    usage = usage == 0 ? tool_take_axes(&args.axes, argc, argv) : usage;
    if (usage != 0) {
        return usage;
    }
    bool stored = is_store(argv[0]);
    if (args.find != NULL && !stored) {
        return tool_usage_error("--find needs a .stip file; build %s first", argv[0]);
    }
    stp_context* context = tool_context_create(0, args.memory, "none");
    if (context == NULL) {
        return 1;
    }
    int code = args.find != NULL ? print_found(context, argv[0])
               : stored          ? print_store(context, argv[0])
                                 : print_model(context, argv[0]);
    stp_context_destroy(context);
    return code;
}

const command command_info = {
    .name = "info",
    .arguments = "FILE | --formats",
    .summary = "describe the content of a .stip file or a model",
    .text =
        "Prints a table of the scene's parts: objects, levels of detail (nodes with splats), "
        "triangles, points and splats, and their size in bytes. Counts include all instances; "
        "counts without instances are in parentheses. Below the table: nodes, instances, bytes "
        "per splat and triangle, bytes of levels of triangles, dimensions, unit and up axis, "
        "sources and named views. --json "
        "has the figures of every part.\n\n"
        "A part is a child of the root object; while an object has only one child, that child's "
        "children are used instead. Beyond 64 parts, the smallest are combined as \"others\". An "
        "object is anything with a shape to which the input gives a name of its own.\n\n"
        "--find prints one line for each matching object, up to 1,000: its number (for --hide "
        "and similar options of render), its content and its path; with --json, one object "
        "\"found\".\n\n"
        "Only the first pages of a .stip file are read, however large it is (in version 1.0, the "
        "directory). A model is imported but not built. For LAS, LAZ and COPC files only the "
        "header is read, not the points. For these, E57 and PCD files the output lists the "
        "values that each point has, with their types, and marks the values that Stipple does "
        "not keep. --json has them as \"scan\".",
    .examples = "Print a table of the parts:\n"
                "$ stipple info plant.stip\n"
                "Print it as JSON:\n"
                "$ stipple info plant.stip --json\n"
                "Find objects by name:\n"
                "$ stipple info plant.stip --find pump\n"
                "List the formats that can be read:\n"
                "$ stipple info --formats\n",
    .files = "FILE\t"
             "a .stip file, or a model that is imported but not built\n",
    .options = options,
    .run = run,
};
