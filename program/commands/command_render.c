// SPDX-License-Identifier: MIT
//
// stipple render: draws one picture of a scene.
#include "base/core/clock.h"
#include "program/drawing/drawing.h"
#include "program/files/import_options.h"
#include "program/files/overwrite.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/tool.h"
#include "program/present/picture_file.h"
#include "program/reports/reports.h"
#include "select/camera.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum {
    REPEATS = 9,
    STILL_SAMPLES = 16,  ///< frames per picture if no option sets the quality
    SUM_BYTES = 16,      ///< bytes per pixel while frames are accumulated
    SUMS_IN_MEMORY = 16, ///< frames are accumulated if the memory limit has room for these sums
};
static const double repeat_ms = 3000.0; // total time after which frames are not repeated any more
static const double slow_ms =
    2000.0; // a frame this slow is repeated only once, if a repeat can be faster at all

static struct {
    const char* output;
    const char *view, *columns;
    double eye[3], target[3], up[3];
    bool has_eye, has_target, has_up;
    double ortho;
    uint64_t accumulate;
    bool once;
    const char* pick;
    model_axes axes;
    double smooth;
    draw_options draw;
} args;

static const option* options(void)
{
    static const option own[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "file to write: PNG, JPEG (.jpg, .jpeg; transparent areas become white) or WebP "
                 "(lossless); - writes a PNG to standard output",
         .value = &args.output,
         .group = "Output"},
        {.name = "view",
         .type = OPTION_TEXT,
         .argument = "NAME",
         .help = "view of the file, or front, back, left, right, top, bottom, iso, d0 to d25; "
                 "default iso; standard views fit what is visible",
         .value = &args.view,
         .group = "Camera"},
        {.name = "eye",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "position of the camera",
         .value = args.eye,
         .given = &args.has_eye},
        {.name = "target",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "point that the camera looks at; default the centre of the scene",
         .value = args.target,
         .given = &args.has_target},
        {.name = "up",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z|AXIS",
         .words = "x|-x|y|-y|z|-z",
         .help = "up direction of the camera: a vector, or x, -x, y, -y, z or -z; default 0,1,0",
         .value = args.up,
         .given = &args.has_up,
         .rare = true},
        {.name = "ortho",
         .type = OPTION_NUMBER,
         .argument = "HEIGHT",
         .words = "1e-9..1e12",
         .help =
             "parallel projection showing HEIGHT units from top to bottom; standard views set it "
             "themselves",
         .value = &args.ortho,
         .rare = true},
        {.name = "accumulate",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4096",
         .help = "average N frames with sub-pixel shifts, as the viewer does at rest; n x n "
                 "frames equal --supersample n; default 16 if no option sets the quality, else 1",
         .value = &args.accumulate,
         .group = "Quality",
         .rare = true},
        {.name = "once",
         .help = "time a single frame after the first (the first does not yet know what is "
                 "occluded)",
         .value = &args.once,
         .rare = true},
        {.name = "pick",
         .type = OPTION_TEXT,
         .argument = "X,Y",
         .help = "print as JSON what is at a column and row of the picture (from the upper left): "
                 "position, object, triangle; with --json this is its \"pick\"; a picture is drawn "
                 "only with -o",
         .value = &args.pick,
         .group = "Output",
         .rare = true},
        OPTION_COLUMNS(&args.columns),
        OPTION_MODEL_UP("model-up", &args.axes),
        OPTION_MODEL_UNIT(&args.axes),
        OPTION_SMOOTH(&args.smooth),
        {0},
    };
    static option table[OPTION_TABLE_ROOM];
    return draw_options_table(table, own, &args.draw);
}

static stp_vec3d vector_of(const double v[3])
{
    return (stp_vec3d){v[0], v[1], v[2]};
}

typedef struct session {
    drawing drawing;
    stp_image image;
    stp_view view;
    json_t* picked; ///< NULL: not requested
    stp_quality quality;
    frame_figures figures;
    double picture_ms; ///< time of all averaged frames, milliseconds
} session;

/// Number of frames to average; 1: a single frame. Under a tight memory limit the memory goes to
/// scene data instead of the sums of frames.
static uint32_t frames_of_picture(const session* s)
{
    bool still = draw_options_leave_quality(&args.draw) && !args.once;
    uint64_t sums = (uint64_t)s->view.width * s->view.height * SUM_BYTES;
    bool has_room = args.draw.memory == 0 || SUMS_IN_MEMORY * sums <= args.draw.memory;
    return args.accumulate > 0 ? (uint32_t)args.accumulate : still && has_room ? STILL_SAMPLES : 1;
}

/// Samples a pixel.
static uint32_t samples_of_picture(const session* s)
{
    uint32_t side = args.draw.settings.style.supersample;
    return side > 1 ? side * side : frames_of_picture(s);
}

/// Finds a view of the scene, or a saved viewpoint with what it hides. @return the exit code, with
/// the message printed
static int find_view(session* s, const char* path, const char* name)
{
    stp_view* view = &s->view;
    const stp_farthest_store content = {s->drawing.context, s->drawing.store, NULL};
    if (tool_find_view(&content, name, view)) {
        return 0;
    }
    stp_viewpoints viewpoints = {0};
    char* sidecar = stp_viewpoints_path(s->drawing.context, path);
    stp_result result = sidecar != NULL
                            ? stp_viewpoints_read(s->drawing.context, sidecar, &viewpoints)
                            : STP_ERROR_OUT_OF_MEMORY;
    const stp_viewpoint* found = stp_viewpoints_find(&viewpoints, name);
    if (result == STP_OK && found != NULL) {
        double fov = view->fov_degrees;
        stp_viewpoint_get_view(found, view);
        view->fov_degrees = fov > 0.0 ? fov : view->fov_degrees;
        result = scene_show_viewpoint(&s->drawing.show, found);
    }
    int code = result == STP_OK ? 0 : 1;
    if (result == STP_OK && found == NULL) {
        code = view_list_refuse(name, s->drawing.store, &viewpoints);
    }
    stp_viewpoints_destroy(s->drawing.context, &viewpoints);
    stp_free(s->drawing.context, sidecar);
    return code;
}

/// Applies the camera options to a view. Standard views fit the visible objects, oriented by --up.
static void place_eye(session* s, bool is_standard)
{
    stp_view* view = &s->view;
    stp_boxd box = stp_visible_bounds(s->drawing.store, s->quality.visibility);
    if (args.has_up) {
        view->up = vector_of(args.up);
    }
    if (is_standard && (args.has_eye || args.has_target) && !(args.draw.fov > 0.0)) {
        view->fov_degrees = STP_CAMERA_PLACED_FOV;
    }
    if (is_standard && !stp_boxd_is_empty(box)) {
        const stp_farthest_store content = {s->drawing.context, s->drawing.store,
                                            s->quality.visibility};
        stp_camera_fit_store(&content, NULL, view);
    }
    if (!args.has_eye && !args.has_target) {
        return;
    }
    if (args.has_eye) {
        view->eye = vector_of(args.eye);
    }
    if (args.has_target) {
        view->target = vector_of(args.target);
    } else if (is_standard && !stp_boxd_is_empty(box)) {
        view->target = stp_scaled(stp_addd(box.min, box.max), 0.5);
    }
    view->up = args.has_up ? vector_of(args.up) : (stp_vec3d){0, 1, 0}; // not the named view's own
    view->ortho_height = args.ortho;
}

/// @return the exit code, with the message printed
static int choose_view(session* s, const char* path)
{
    stp_view* view = &s->view;
    *view = draw_options_view(&args.draw);
    view->ortho_height = args.ortho;
    view->eye_distance = draw_options_eye_distance(&args.draw, s->drawing.store);
    const char* name = args.view != NULL ? args.view : "iso";
    int code = draw_options_check_method(&args.draw, s->drawing.store, path);
    code = code == 0 ? find_view(s, path, name) : code;
    code = code == 0 ? scene_show_apply(&s->drawing.show, &args.draw.show, view) : code;
    if (code != 0) {
        return code;
    }
    s->quality.visibility = s->drawing.show.visibility;
    place_eye(s, tool_is_standard_view(s->drawing.store, name));
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : STP_CAMERA_PLACED_FOV;
    return 0;
}

static int compare_figures(const void* a, const void* b)
{
    double x = ((const frame_figures*)a)->cost.milliseconds;
    double y = ((const frame_figures*)b)->cost.milliseconds;
    return (x > y) - (x < y);
}

/// Draws the frame, repeatedly if figures are wanted: the first frame runs with cold caches.
static stp_result draw_frames(session* s)
{
    frame_figures frames[REPEATS];
    double total = 0.0;
    stp_result result = STP_OK;
    if (args.draw.budget_ms > 0.0) {
        stp_budget budget;
        frame_maker* maker = &s->drawing.maker;
        stp_budget_init(&budget, (stp_controller)args.draw.controller, args.draw.budget_ms);
        if (!maker->uses_gl && frames_of_picture(s) <= 1) { // averaged frames have all pixels
            stp_budget_lower_resolution(&budget);
        }
        result = frame_settle(maker, &s->view, &budget, &s->quality, &s->image);
        maker->style.resolution = stp_budget_resolution(&budget);
    }
    if (result == STP_OK) {
        result = frame_draw_loaded(&s->drawing.maker, &s->view, &s->quality, &s->image, &frames[0]);
    }
    size_t count = 0, maximum = 0;
    if (result == STP_OK && args.draw.json) {
        // occlusion is known from the second frame on; a reference does not use it
        maximum = frames[0].cost.milliseconds >= slow_ms ? !args.draw.settings.quality.reference
                  : args.once                            ? 1
                                                         : REPEATS;
    }
    while (result == STP_OK && count < maximum && (count < 3 || total < repeat_ms)) {
        result = frame_draw(&s->drawing.maker, &s->view, &s->quality, &s->image, &frames[count]);
        result = tool_is_interrupted() ? STP_ERROR_CANCELLED : result;
        total += frames[count++].cost.milliseconds;
    }
    assert(count <= maximum && maximum <= REPEATS);
    qsort(frames, count, sizeof(frames[0]), compare_figures);
    s->figures = frames[count / 2];
    s->picture_ms = s->figures.cost.milliseconds;
    uint32_t frames_wanted = frames_of_picture(s);
    double start = stp_clock_ms();
    for (uint32_t i = 0; result == STP_OK && frames_wanted > 1 && i < frames_wanted; ++i) {
        result = tool_is_interrupted() ? STP_ERROR_CANCELLED
                                       : frame_accumulate(&s->drawing.maker, &s->view, &s->quality,
                                                          frames_wanted, &s->image);
    }
    s->picture_ms = frames_wanted > 1 ? stp_clock_ms() - start : s->picture_ms;
    return result;
}

/// What the picture was drawn with. Triangles alone if they are cheaper than splats, or if the
/// scene has no splats.
static const char* name_drawn(const frame_figures* figures)
{
    bool splats = figures->splats > 0, triangles = figures->triangles > 0;
    return splats && triangles ? "splats and triangles"
           : splats            ? "splats"
           : triangles         ? "triangles"
                               : "nothing";
}

/// The camera, as --eye, --target, --up, --fov and --ortho take it. @return NULL if memory runs out
static json_t* describe_camera(const stp_view* view)
{
    const stp_vec3d *e = &view->eye, *t = &view->target, *u = &view->up;
    return json_pack("{s:[f,f,f], s:[f,f,f], s:[f,f,f], s:f, s:f}", "eye", e->x, e->y, e->z,
                     "target", t->x, t->y, t->z, "up", u->x, u->y, u->z, "fov", view->fov_degrees,
                     "ortho", view->ortho_height);
}

/// Takes ownership of `picked`, which may be NULL. @return NULL if memory runs out
static json_t* describe(const session* s, json_t* picked)
{
    const drawing* d = &s->drawing;
    uint64_t resident = frame_maker_resident_bytes(&d->maker);
    json_t* object = drawing_describe(d, &s->view);
    json_t* bytes = json_integer((json_int_t)resident);
    json_t* figures = frame_describe(&s->figures);
    json_t* samples = json_integer((json_int_t)samples_of_picture(s));
    json_t* frames = json_integer((json_int_t)frames_of_picture(s));
    json_t* kinds = json_string(name_drawn(&s->figures));
    json_t* camera = describe_camera(&s->view);
    bool described = json_object_set_new(object, "resident_bytes", bytes) == 0;
    const char* method = draw_options_method(&args.draw, s->drawing.store);
    described = json_object_set_new(object, "method",
                                    method != NULL ? json_string(method) : json_null()) == 0 &&
                described;
    described =
        json_object_set_new(
            object, "coarse_method",
            json_pack("s?", draw_options_coarse_method(&args.draw, s->drawing.store))) == 0 &&
        described;
    described = json_object_set_new(object, "samples", samples) == 0 && described;
    described = point_colors_describe(&args.draw.colors, &d->coloring, object) && described;
    described = json_object_set_new(object, "accumulated_frames", frames) == 0 && described;
    described =
        json_object_set_new(object, "picture_ms", json_real(s->picture_ms)) == 0 && described;
    described = json_object_set_new(object, "drawn", kinds) == 0 && described;
    described = json_object_set_new(object, "camera", camera) == 0 && described;
    if (!described || figures == NULL || json_object_update(object, figures) != 0) {
        json_decref(object);
        json_decref(figures);
        json_decref(picked);
        return NULL;
    }
    json_decref(figures);
    if (picked != NULL && json_object_set_new(object, "pick", picked) != 0) {
        json_decref(object);
        return NULL;
    }
    return object;
}

/// An empty picture is rarely intended, so a message says why it is empty.
static void explain_empty(const session* s, const char* path)
{
    if (s->figures.cost.covered_pixels == 0) {
        bool any = stp_store_get_directory(s->drawing.store)->root != STP_STORE_NONE;
        stp_warn(s->drawing.context, "%s: the picture is empty: %s", path,
                 !any                               ? "the scene is empty"
                 : s->drawing.maker.list.count == 0 ? "no part of the scene is in view"
                                                    : "the objects in view cover no pixel centre");
    }
}

/// Reports what is at a position of the picture. @return false on failure (message printed)
static bool pick(session* s)
{
    double place[2];
    (void)pick_read_place(args.pick, place);
    s->picked =
        pick_describe(&s->drawing.show, &s->view, args.draw.settings.style.back_faces, place);
    return s->picked != NULL;
}

/// Writes the picture after freeing the memory used to draw it, and prints the figures. @return the
/// exit code
static int finish(session* s)
{
    json_t *picked = s->picked, *said = args.draw.json ? describe(s, picked) : picked;
    s->picked = NULL;
    if (args.draw.json && said == NULL) {
        return tool_error("out of memory");
    }
    frame_maker_destroy(&s->drawing.maker);
    if (tool_write_picture(s->drawing.context, &s->image, args.output) != STP_OK) {
        json_decref(said);
        return 1;
    }
    return said != NULL ? tool_print_json(said) : 0;
}

static int render(session* s, const char* path)
{
    if (drawing_open(&s->drawing, &args.draw, path) != STP_OK) {
        return 1;
    }
    s->quality = draw_options_quality(&args.draw);
    int code = choose_view(s, path);
    if (code != 0) {
        return code;
    }
    if (args.pick != NULL && !pick(s)) {
        return 1;
    }
    if (args.output == NULL) {
        json_t* picked = s->picked;
        s->picked = NULL;
        return tool_print_json(picked);
    }
    if (!frame_image_create(s->drawing.context, s->view.width, s->view.height, &s->image)) {
        return 1;
    }
    stp_result result = drawing_make(&s->drawing, &args.draw);
    if (result == STP_OK) {
        result = draw_frames(s);
    }
    if (result != STP_OK) {
        return 1;
    }
    if (tool_is_interrupted()) { // writes no picture
        return 1;
    }
    explain_empty(s, path);
    return finish(s);
}

/// Rejects outputs that cannot be written before the work starts, and never overwrites an input.
static int check_output(const char* path)
{
    int code = overwrite_check(path, args.output);
    return code != 0 ? code : tool_check_picture(args.output);
}

static int check_arguments(int argc, const char* path)
{
    if (argc != 1) {
        return tool_usage_error("render needs one file, but got %d", argc);
    }
    double place[2];
    if (args.pick != NULL && !pick_read_place(args.pick, place)) {
        return tool_usage_error("--pick needs a column and a row, X,Y, not %s", args.pick);
    }
    if (args.output == NULL && args.pick == NULL) {
        return tool_usage_error("render needs -o OUT.png");
    }
    if (args.output == NULL) {
        return draw_options_check(&args.draw);
    }
    int code = check_output(path);
    if (code != 0) {
        return code;
    }
    if (args.draw.stereo && args.ortho > 0.0) {
        return tool_usage_error("--stereo and --ortho exclude each other");
    }
    if ((args.draw.json || args.pick != NULL) && strcmp(args.output, "-") == 0) {
        return tool_usage_error("standard output receives the figures; give a file name");
    }
    if (args.accumulate > 0 && args.draw.settings.style.supersample > 0) {
        return tool_usage_error("--accumulate and --supersample exclude each other");
    }
    return draw_options_check(&args.draw);
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argv[0]);
    code = code == 0 ? tool_take_columns(args.columns, argc, argv) : code;
    code = code == 0 ? tool_take_axes(&args.axes, argc, argv) : code;
    code = code == 0 ? tool_take_smooth(args.smooth, argc, argv) : code;
    if (code != 0) {
        return code;
    }
    session s = {0};
    if (!drawing_begin(&s.drawing, &args.draw)) {
        return 1;
    }
    code = render(&s, argv[0]);
    stp_free(s.drawing.context, s.image.pixels);
    json_decref(s.picked);
    drawing_end(&s.drawing);
    return code;
}

const command command_render = {
    .name = "render",
    .arguments = "FILE -o OUT.png",
    .summary = "draw one picture of a scene",
    .text =
        "Draws splats where they are detailed enough, and the original triangles elsewhere. "
        "--splat-size sets the level of detail: 1 is one splat per pixel; larger values are "
        "faster.\n\n"
        "A model is first built into a cache ($XDG_CACHE_HOME/stipple, or ~/.cache/stipple). "
        "Models of more than 100,000 triangles are built without splats, in a tenth of the "
        "time, and drawn as triangles if no option refers to splats, or with --reference. Models "
        "of more than 134 million triangles (counting all instances) always get splats.\n\n"
        "If no option sets the quality (--splat-size, --splats, --splat-scale, --budget-ms, "
        "--policy, --fovea, --reference, --supersample, --accumulate, --once), the picture is "
        "antialiased: it is the average of 16 frames with sub-pixel shifts, or of fewer if "
        "--memory leaves little room. To compare two pictures, use the same number of samples in "
        "both.\n\n"
        "--budget-ms draws the view repeatedly until the splat size that meets the frame time "
        "has settled, and writes the last picture.\n\n"
        "--stereo draws the views of two eyes with parallel gaze, the left eye on the left. Both "
        "share one level-of-detail selection, and the figures are for the whole picture.\n\n"
        "With --memory, data is loaded as the view needs it, coarse data first, up to the limit. "
        "A smaller limit gives a coarser picture without holes.\n\n"
        "A truncated .stip file is drawn as far as it goes, with a warning: every prefix that "
        "contains the directory shows the whole scene at a coarser level. --prefix uses only the "
        "first part of a complete file. --reference needs the complete file.\n\n"
        "--section and --section-box cut the scene open. --hide, --isolate and --ghost select "
        "objects by name, path, id or number. All of these can be repeated. If several objects "
        "have the name, all of them are affected. --view also finds the viewpoints saved beside "
        "the model (NAME.views.json), including what they hide and cut.\n\n"
        "--pick uses the original triangles and points, even if the picture is coarse.\n\n"
        "The background is transparent. --json prints what was drawn and the times. frame_ms and "
        "the counts are medians of repeated single frames, without opening the file; if drawing "
        "takes two seconds or more, or with --once, they are those of the second frame, or of "
        "the first with --reference. samples (per pixel), accumulated_frames and picture_ms (the "
        "time of all averaged frames) describe the written picture. camera holds its camera.",
    .examples =
        "Draw a picture at full quality for its size:\n"
        "$ stipple render plant.stip -o plant.png\n"
        "Draw the front on white, with 2 x 2 samples per pixel, as JPEG:\n"
        "$ stipple render plant.stip -o plant.jpg --view front --background white --supersample "
        "2\n"
        "Use the finest splats that fit into 33 ms, and print figures:\n"
        "$ stipple render plant.stip -o plant.png --budget-ms 33 --json\n"
        "Draw only the original triangles, for comparison:\n"
        "$ stipple render plant.stip -o reference.png --reference\n",
    .files = "FILE.views.json\tviewpoints saved beside the model, for --view\n"
             "$XDG_CACHE_HOME/stipple\tcache of built models; ~/.cache/stipple if the variable "
             "is not set\n",
    .options = options,
    .run = run,
};
