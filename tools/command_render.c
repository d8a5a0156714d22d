// SPDX-License-Identifier: MIT
//
// stipple render: one picture of a scene.
#include "command.h"
#include "drawing.h"
#include "overwrite.h"
#include "pick_report.h"
#include "picture.h"
#include "scene_file.h"
#include "tool.h"
#include "view_list.h"

#include "base/clock.h"
#include "present/camera.h"

#include <stdlib.h>
#include <string.h>

enum {
    REPEATS = 9,
    STILL_SAMPLES = 16, ///< frames of a picture where no option asks for a quality
    SUM_BYTES = 16,     ///< of a pixel, while frames are accumulated
    SUMS_IN_MEMORY = 16,
};
static const double repeat_ms = 3000.0; // no more repeats once they have taken this long
static const double slow_ms =
    2000.0; // what takes so long is repeated once, if that can be any faster

static struct {
    const char* output;
    const char *view, *columns;
    double eye[3], target[3], up[3];
    bool has_eye, has_target, has_up;
    double ortho;
    uint64_t accumulate;
    bool once;
    const char* pick;
    draw_options draw;
} args;

static const option* options(void)
{
    static const option own[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "the picture to write: PNG, JPEG (.jpg, .jpeg; white where nothing is drawn) or "
                 "WebP (lossless); - is standard output, as PNG",
         .value = &args.output},
        {.name = "view",
         .type = OPTION_TEXT,
         .argument = "NAME",
         .help = "a view of the file, or front, back, left, right, top, bottom, iso, d0 to d25; "
                 "default iso",
         .value = &args.view},
        {.name = "eye",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "where the eye is",
         .value = args.eye,
         .given = &args.has_eye},
        {.name = "target",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z",
         .help = "what it looks at; default the middle of the scene",
         .value = args.target,
         .given = &args.has_target},
        {.name = "up",
         .type = OPTION_VECTOR,
         .argument = "X,Y,Z|AXIS",
         .words = "x|-x|y|-y|z|-z",
         .help = "what is up in the picture: a direction, or x, -x, y, -y, z or -z; default 0,1,0",
         .value = args.up,
         .given = &args.has_up},
        OPTION_COLUMNS(&args.columns),
        {.name = "ortho",
         .type = OPTION_NUMBER,
         .argument = "HEIGHT",
         .words = "1e-9..1e12",
         .help =
             "parallel projection, of so many units from top to bottom; standard views choose it",
         .value = &args.ortho},
        {.name = "accumulate",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4096",
         .help = "the mean of N frames, each shifted by a part of a pixel, as a viewer shows when "
                 "it rests; of n x n they are --supersample n; default 16 where no option asks for "
                 "a quality, else 1",
         .value = &args.accumulate},
        {.name = "once",
         .help = "time a single frame after the first, which does not know yet what is hidden",
         .value = &args.once},
        {.name = "pick",
         .type = OPTION_TEXT,
         .argument = "X,Y",
         .help =
             "tell as JSON what is at a column and row of the picture (from the upper left): "
             "place, object, triangle; with --json as its \"pick\"; a picture is drawn only with "
             "-o",
         .value = &args.pick},
        {0},
    };
    static option table[DRAW_OPTION_ROOM];
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
    json_t* picked; ///< NULL: was not asked for
    stp_quality quality;
    frame_figures figures;
    double picture_ms; ///< of all frames that the picture is the mean of
} session;

/// How many frames the picture is the mean of; 1: it is a single frame. Where memory is limited to a few times what sums
/// of frames take, scene data needs it more.
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
    uint32_t side = (uint32_t)args.draw.supersample;
    return side > 1 ? side * side : frames_of_picture(s);
}

/// A view of the scene, or one kept beside it, with what is hidden there. @return the exit code, with the message printed
static int find_view(session* s, const char* path, const char* name)
{
    stp_view* view = &s->view;
    if (tool_find_view(s->drawing.store, name, NULL, view)) {
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
        stp_viewpoint_look(found, view);
        view->fov_degrees = fov > 0.0 ? fov : view->fov_degrees;
        result = scene_show_viewpoint(&s->drawing.show, found);
    }
    int code = result != STP_OK ? 1
               : found != NULL  ? 0
                                : view_list_refuse(name, s->drawing.store, &viewpoints);
    stp_viewpoints_destroy(s->drawing.context, &viewpoints);
    stp_free(s->drawing.context, sidecar);
    return code;
}

/// Applies the camera's own options to a view; a standard one fits what is shown, as --up turns it.
static void place_eye(session* s, bool is_standard)
{
    stp_view* view = &s->view;
    stp_boxd box = stp_visible_bounds(s->drawing.store, s->quality.visibility);
    if (args.has_up) {
        view->up = vector_of(args.up);
    }
    if (is_standard && !stp_boxd_is_empty(box)) {
        stp_camera_fit(view, &box);
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
    view->up = args.has_up ? vector_of(args.up) : (stp_vec3d){0, 1, 0}; // as it was before the fit
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
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : 60.0;
    return 0;
}

static int compare_figures(const void* a, const void* b)
{
    double x = ((const frame_figures*)a)->frame_ms, y = ((const frame_figures*)b)->frame_ms;
    return (x > y) - (x < y);
}

/// Draws the frame, again and again where figures are wanted: the first finds nothing in caches.
static stp_result draw_frames(session* s)
{
    frame_figures frames[REPEATS];
    double total = 0.0;
    stp_result result = STP_OK;
    if (args.draw.has_budget) {
        stp_budget budget;
        stp_budget_init(&budget, (stp_controller)args.draw.controller, args.draw.budget_ms);
        result = frame_settle(&s->drawing.maker, &s->view, &budget, &s->quality, &s->image);
    }
    if (result == STP_OK) {
        result = frame_draw_loaded(&s->drawing.maker, &s->view, &s->quality, &s->image, &frames[0]);
    }
    size_t count = 0;
    // what is hidden is known from the second frame on; all that a reference draws is drawn again
    size_t most = result != STP_OK || !args.draw.json ? 0
                  : frames[0].frame_ms >= slow_ms     ? !args.draw.reference
                  : args.once                         ? 1
                                                      : REPEATS;
    while (result == STP_OK && count < most && (count < 3 || total < repeat_ms)) {
        result = frame_draw(&s->drawing.maker, &s->view, &s->quality, &s->image, &frames[count]);
        result = tool_is_interrupted() ? STP_ERROR_CANCELLED : result;
        total += frames[count++].frame_ms;
    }
    qsort(frames, count, sizeof(frames[0]), compare_figures);
    s->figures = frames[count / 2];
    s->picture_ms = s->figures.frame_ms;
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

/// What a picture was drawn with. Triangles alone: they are cheaper there than splats, or the scene has no splats.
static const char* name_drawn(const frame_figures* figures)
{
    bool splats = figures->splats > 0, triangles = figures->triangles > 0;
    return splats && triangles ? "splats and triangles"
           : splats            ? "splats"
           : triangles         ? "triangles"
                               : "nothing";
}

/// Takes `picked` over, which may be NULL. @return NULL where memory runs out
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

/// An empty picture is rarely what was wanted: it should not look like a scene without content.
static void explain_empty(const session* s, const char* path)
{
    if (s->figures.covered_pixels == 0) {
        bool any = stp_store_get_directory(s->drawing.store)->root != STP_STORE_NONE;
        stp_warn(s->drawing.context, "%s: the picture is empty: %s", path,
                 !any ? "so is the scene"
                 : s->drawing.maker.list.count == 0
                     ? "nothing of the scene lies in the view"
                     : "what lies in the view covers the middle of no pixel");
    }
}

/// What is at a place of the picture. @return false where that failed (message printed)
static bool pick(session* s)
{
    double place[2];
    (void)pick_read_place(args.pick, place);
    s->picked = pick_describe(&s->drawing.show, &s->view, place);
    return s->picked != NULL;
}

/// Writes the picture, to which all that made it gives its memory, and prints what is to be said. @return the exit code
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
    if (tool_is_interrupted()) { // no picture that was not wanted any more
        return 1;
    }
    explain_empty(s, path);
    return finish(s);
}

/// What could not be written is refused before the work, and no input is written over.
static int check_output(const char* path)
{
    int code = overwrite_check(path, args.output);
    return code != 0 ? code : tool_check_picture(args.output);
}

static int check_arguments(int argc, const char* path)
{
    if (argc != 1) {
        return tool_usage_error("render needs one file, and got %d", argc);
    }
    double place[2];
    if (args.pick != NULL && !pick_read_place(args.pick, place)) {
        return tool_usage_error("--pick is a column and a row, X,Y, not %s", args.pick);
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
        return tool_usage_error("standard output is for the figures; name a file");
    }
    if (args.accumulate > 0 && args.draw.supersample > 0) {
        return tool_usage_error("--accumulate and --supersample exclude each other");
    }
    return draw_options_check(&args.draw);
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argv[0]);
    code = code == 0 ? tool_take_columns(args.columns) : code;
    if (code != 0) {
        return code;
    }
    session s = {.figures = {0}};
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
        "Draws the scene as splats where they are good enough, and as its own triangles elsewhere. "
        "--splat-size says what is good enough: 1 is a splat a pixel, larger is faster.\n"
        "\n"
        "A model is built into a cache first ($XDG_CACHE_HOME/stipple, or ~/.cache/stipple). Where "
        "nothing is asked of splats and the model has more than 100,000 triangles, it is built "
        "without surfels, which takes a tenth of the time, and drawn as triangles; so it is for "
        "--reference. More than 134 million triangles, all instances counted, always get surfels.\n"
        "\n"
        "Where no option asks for a quality (--splat-size, --splats, --splat-scale, --budget-ms, "
        "--policy, --fovea, --reference, --supersample, --accumulate, --once), the picture is the "
        "mean of 16 frames, each shifted by a part of a pixel: edges are smooth (unless --memory "
        "leaves "
        "little room). To compare two "
        "pictures, ask for the same number of samples in both.\n"
        "\n"
        "--budget-ms draws the view until the size of splats has settled that lets a frame take so "
        "long, and keeps "
        "the last picture.\n"
        "\n"
        "--stereo draws what two eyes see, the left one's half on the left; both look the same "
        "way. What "
        "is drawn is chosen once for both, and figures are those of the whole picture.\n"
        "\n"
        "Under --memory, data is loaded as the view needs it, coarse first, as much as there is "
        "room "
        "for: with less, the picture is coarser, and has no holes.\n"
        "\n"
        "A .stip file that ends early is drawn as far as it goes, with a warning: every prefix "
        "that "
        "holds the directory is the whole scene, coarser. --prefix draws a part of a whole file. "
        "--reference needs the whole file.\n"
        "\n"
        "--section and --section-box cut the scene open; --hide, --isolate and --ghost say what is "
        "shown of it, by names, paths, ids or numbers of objects, and may be given several times, "
        "as may sections. What stands in several places is hidden in all that have the name. "
        "--view also finds the viewpoints that were saved beside the model (NAME.views.json), with "
        "what they hide and cut.\n"
        "\n"
        "--pick looks at original triangles and points, however coarse the picture is.\n"
        "\n"
        "The picture is transparent where nothing was drawn. --json prints what was drawn and how "
        "long it took: frame_ms is the median of repeated single frames, without opening the file, "
        "and so are the counts; samples (a pixel), accumulated_frames and picture_ms (the time all "
        "of them took) are of the picture that was written; where "
        "that takes two seconds or more, and with --once, it is the second frame's, and that of "
        "--reference the first's.",
    .examples =
        "Draw a picture, as finely as its size asks for:\n"
        "$ stipple render plant.stip -o plant.png\n"
        "From the front, on white, with 2 x 2 samples a pixel, as JPEG:\n"
        "$ stipple render plant.stip -o plant.jpg --view front --background white --supersample 2\n"
        "As fine as a frame of 33 ms allows, with its figures:\n"
        "$ stipple render plant.stip -o plant.png --budget-ms 33 --json\n"
        "Only the original triangles, to compare with:\n"
        "$ stipple render plant.stip -o reference.png --reference\n",
    .files = "FILE.views.json\t"
             "viewpoints saved beside the model, for --view\n"
             "$XDG_CACHE_HOME/stipple\t"
             "models that were built to be drawn; ~/.cache/stipple where the variable is not set\n",
    .options = options,
    .run = run,
};
