// SPDX-License-Identifier: MIT
//
// stipple view: opens a window to fly through a scene.
#include "lod/method.h"
#include "program/drawing/draw_options.h"
#include "program/files/import_options.h"
#include "program/files/scene_file.h"
#include "program/options/cloud_style.h"
#include "program/options/command.h"
#include "program/options/cue_names.h"
#include "program/viewer/panels/viewer.h"

#include <assert.h>
#include <string.h>

static struct {
    const char *view, *report, *cues, *point_size;
    uint32_t size[2];
    int backend, gl_splats, method;
    double budget_ms, scale;
    bool software, has_method, has_splats, back_faces, has_back_faces;
    uint64_t splats, threads, memory;
    point_color_options colors;
    model_axes axes;
    double smooth;
} args;

static const option own_options[] = {
    {.name = "view",
     .type = OPTION_TEXT,
     .argument = "NAME",
     .help = "first view: one of the file, a saved one, or front, back, left, right, top, "
             "bottom, iso; default iso",
     .value = &args.view,
     .group = "Window"},
    {.name = "size",
     .type = OPTION_PIXELS,
     .argument = "WxH",
     .words = "200..16384",
     .help = "size of the window; default 1280x720",
     .value = args.size},
    {.name = "budget-ms",
     .type = OPTION_NUMBER,
     .argument = "MS",
     .words = "4..500",
     .help = "maximum frame time while the camera moves; default as in the last session",
     .value = &args.budget_ms,
     .group = "Quality"},
    {.name = "splats",
     .type = OPTION_COUNT,
     .argument = "N",
     .words = "2..4294967294",
     .help = "draw N splats, or all if there are fewer; default as in the last session",
     .value = &args.splats,
     .given = &args.has_splats},
    {.name = "method",
     .type = OPTION_CHOICE,
     .argument = "NAME",
     .words = TOOL_METHOD_WORDS,
     .help = "method to draw if the file has several; default as in the last session, or the "
             "first in the file",
     .value = &args.method,
     .given = &args.has_method},
    OPTION_CUES(&args.cues),
    {.name = "back-faces",
     .type = OPTION_SWITCH,
     .argument = "on|off",
     .words = "off|on",
     .help = "draw the backs of single-sided materials of glTF files; default as in the last "
             "session",
     .value = &args.back_faces,
     .given = &args.has_back_faces,
     .rare = true},
    OPTION_POINT_SIZE(&args.point_size, "as in the last session"),
    {.name = "ui-scale",
     .type = OPTION_NUMBER,
     .argument = "F",
     .words = "0.5..4",
     .help = "scale of text and panels; default that of the display",
     .value = &args.scale,
     .group = "Window",
     .rare = true},
    {.name = "software-window", .help = "show the picture without OpenGL", .value = &args.software},
    {.name = "report",
     .type = OPTION_TEXT,
     .argument = "FILE.json",
     .help = "write the state of the viewer to a file at every change",
     .value = &args.report,
     .rare = true},
    {.name = "backend",
     .type = OPTION_CHOICE,
     .argument = "NAME",
     .words = "auto|cpu|gl",
     .help = "renderer; default as in the last session",
     .value = &args.backend,
     .group = "Machine"},
    OPTION_GL_SPLATS(&args.gl_splats),
    OPTION_MODEL_UP("up", &args.axes),
    OPTION_MODEL_UNIT(&args.axes),
    OPTION_SMOOTH(&args.smooth),
    OPTION_THREADS(&args.threads),
    OPTION_MEMORY(&args.memory),
    {0},
};

static const option* options(void)
{
    static option table[40];
    size_t count = sizeof(own_options) / sizeof(own_options[0]) - 1;
    assert(count + POINT_COLOR_OPTION_ROOM <= sizeof(table) / sizeof(table[0]));
    memcpy(table, own_options, sizeof(own_options));
    (void)point_color_options_table(table + count, &args.colors);
    return table;
}

static int run(int argc, char** argv)
{
    if (args.has_splats && args.budget_ms > 0.0) {
        return tool_usage_error("--budget-ms and --splats exclude each other");
    }
    uint32_t cues_off;
    if (!cue_names_parse(args.cues, &cues_off)) {
        return cue_names_refuse(args.cues);
    }
    int code = point_colors_check(&args.colors);
    if (code != 0) {
        return code;
    }
    code = tool_take_axes(&args.axes, argc, argv);
    code = code == 0 ? tool_take_smooth(args.smooth, argc, argv) : code;
    if (code != 0) {
        return code;
    }
    cloud_point_size size = {0};
    if (args.point_size != NULL && !cloud_style_read_size(args.point_size, &size)) {
        return cloud_style_refuse_size(args.point_size);
    }
    viewer_options o = {.colors = args.colors,
                        .point_size = size,
                        .has_point_size = args.point_size != NULL,
                        .back_faces = args.back_faces,
                        .has_back_faces = args.has_back_faces,
                        .files = (const char* const*)argv,
                        .file_count = (size_t)argc,
                        .up = model_axes_up(&args.axes),
                        .unit_metres = model_axes_unit(&args.axes),
                        .view = args.view,
                        .width = args.size[0] != 0 ? args.size[0] : 1280,
                        .height = args.size[1] != 0 ? args.size[1] : 720,
                        .scale = (float)args.scale,
                        .software = args.software,
                        .backend = args.backend,
                        .gl_splats = args.gl_splats,
                        .budget_ms = (float)args.budget_ms,
                        .method = args.has_method ? stp_methods[args.method].id : 0,
                        .cues_off = cues_off,
                        .splat_count = (uint32_t)args.splats,
                        .thread_count = (uint32_t)args.threads,
                        .memory_limit = args.memory,
                        .report = args.report};
    return viewer_run(&o);
}

const command command_view = {
    .name = "view",
    .arguments = "[FILE...]",
    .summary = "explore a scene in a window",
    .text =
        "Opens a window with a .stip file or a model; without FILE, an empty window onto which "
        "files can be dropped. Several models, or a folder of models, are one scene. A model is "
        "built into the cache in the background, as by render: "
        "its triangles appear as soon as they are read, its splats as soon as they are made.\n\n"
        "While the camera moves, the splat size follows the frame-time limit; at rest, the "
        "picture is refined to full quality. Press H for keys and mouse; docs/viewer.md explains "
        "all panels. A gamepad and, through spacenavd, a SpaceMouse move the camera too.\n\n"
        "Settings are kept in $XDG_CONFIG_HOME/stipple/viewer.json (or ~/.config/stipple).\n\n"
        "Without a display, use stipple render for pictures and stipple fly for films.",
    .examples = "Open a file or a model:\n"
                "$ stipple view plant.stip\n"
                "Show the tiles of a scan together:\n"
                "$ stipple view north.laz south.laz\n"
                "Turn a model whose file says y up:\n"
                "$ stipple view plant.glb --up z\n"
                "Show the window without OpenGL:\n"
                "$ stipple view plant.stip --software-window\n",
    .files = "$XDG_CONFIG_HOME/stipple/viewer.json\tsettings; ~/.config/stipple if the variable "
             "is not set\n"
             "FILE.views.json\tviewpoints saved beside the model\n"
             "$XDG_CACHE_HOME/stipple\tcache of built models; ~/.cache/stipple if the variable "
             "is not set\n"
             "$SPNAV_SOCKET\tsocket of spacenavd, for a SpaceMouse; /var/run/spnav.sock if the "
             "variable is not set\n",
    .options = options,
    .run = run,
};
