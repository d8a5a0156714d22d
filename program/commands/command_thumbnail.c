// SPDX-License-Identifier: MIT
//
// stipple thumbnail: draws a small picture of a model with few splats.
#include "base/core/clock.h"
#include "base/math/color.h"
#include "lod/method.h"
#include "program/drawing/draw_options.h"
#include "program/drawing/frame.h"
#include "program/drawing/scene_farthest.h"
#include "program/drawing/view_splats.h"
#include "program/files/import_options.h"
#include "program/files/overwrite.h"
#include "program/files/scene_file.h"
#include "program/options/cloud_style.h"
#include "program/options/command.h"
#include "program/options/point_colors.h"
#include "program/options/tool.h"
#include "program/present/picture_file.h"
#include "scene/strays.h"
#include "select/camera.h"

#include <string.h>

enum { DEFAULT_SPLATS = 2000, DEFAULT_SIZE = 256, SAMPLES = 16 };

/// Models of more triangles, counting all instances, are built as by render.
static const uint64_t max_triangles = UINT64_C(1) << 32;

static struct {
    const char *output, *view;
    uint64_t splats, threads, memory;
    uint32_t size[2];
    uint8_t background[3];
    bool has_background, json;
    model_axes axes;
    double smooth;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "file to write: PNG, JPEG or WebP; - writes a PNG to standard output",
         .value = &args.output},
        {.name = "splats",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..1000000",
         .help = "number of splats; default 2000",
         .value = &args.splats},
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .words = "1..4096",
         .help = "size of the picture; default 256x256",
         .value = args.size},
        {.name = "view",
         .type = OPTION_TEXT,
         .argument = "NAME",
         .help = "view direction: front, back, left, right, top, bottom, iso, d0 to d25; default "
                 "iso",
         .value = &args.view},
        {.name = "background",
         .type = OPTION_COLOR,
         .argument = "COLOR",
         .help = "background colour: a CSS name such as white, or hexadecimal such as #dfe3e8; "
                 "default none (transparent)",
         .value = args.background,
         .given = &args.has_background},
        OPTION_MODEL_UP("model-up", &args.axes),
        OPTION_MODEL_UNIT(&args.axes),
        OPTION_SMOOTH(&args.smooth),
        OPTION_THREADS(&args.threads),
        OPTION_MEMORY(&args.memory),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

typedef enum drawn_path {
    WAY_CAPTURED, ///< splats were made for the view
    WAY_STORED,   ///< splats of the file
    WAY_BUILT,    ///< as render draws it
} drawn_path;

/// State while a picture is made.
typedef struct thumbnail {
    stp_context* context;
    const char* path;
    stp_view view;
    stp_quality quality;
    stp_store* store; ///< NULL: nothing is visible
    view_splats made; ///< holds the store if it was made for the view
    drawn_path way;
    uint64_t drawn_splats;
    uint64_t drawn_triangles;
    bool is_cloud;     ///< all of the model are points
    bool by_elevation; ///< it has no colours of its own
    stp_image image;
} thumbnail;

/// Turns the view; it is not yet placed.
static void face(thumbnail* t)
{
    t->view.ortho_height = 1.0; // chooses the height that fits
    (void)stp_camera_face(args.view != NULL ? args.view : "iso", &t->view);
}

static uint64_t splats_wanted(void)
{
    return args.splats > 0 ? args.splats : DEFAULT_SPLATS;
}

/// Opens a .stip, whose splats of method psp are drawn if it has them, else those of its first
/// method.
static stp_result open_stored(thumbnail* t)
{
    stp_result result = stp_store_open(t->context, t->path, &t->store);
    if (result != STP_OK) {
        return result;
    }
    const stp_store_directory* d = stp_store_get_directory(t->store);
    t->way = WAY_STORED;
    t->quality.splat_count = splats_wanted();
    for (uint32_t i = 0; i < d->method_count; ++i) {
        if (d->methods[i].id == STP_METHOD_PSP) {
            t->quality.method = STP_METHOD_PSP;
        }
    }
    return STP_OK;
}

static stp_result open_built(thumbnail* t)
{
    t->way = WAY_BUILT;
    t->quality = (stp_quality){.splat_size = 1.0f};
    return tool_open_scene_for(t->context, t->path, SCENE_FOR_A_PICTURE, &t->store);
}

/// Whether points lie far from the rest of their cloud: only a build separates them.
static bool has_strays(const stp_scene* scene)
{
    bool any = false;
    for (size_t i = 0; i < scene->point_set_count && !any; ++i) {
        any = stp_strays_find(&scene->point_sets[i]).count > 0;
    }
    return any;
}

/// Whether a model consists of points without colours, or of heights.
static bool lacks_colors(const stp_scene* scene, bool is_cloud)
{
    bool heights = scene->source_count > 0, plain = is_cloud;
    for (size_t i = 0; i < scene->source_count; ++i) {
        heights = heights && strcmp(scene->sources[i].format, "hgt") == 0;
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        plain = plain && scene->point_sets[i].colors == NULL;
    }
    return heights || plain;
}

/// Makes splats of a model for the view, unless the model is too large or has strays.
static stp_result open_model(thumbnail* t)
{
    stp_scene* scene = NULL;
    stp_result result = tool_import_scene(t->context, t->path, &scene);
    const stp_node* root =
        result == STP_OK && scene->root != STP_NONE ? &scene->nodes[scene->root] : NULL;
    bool any = root != NULL && root->triangle_count + root->point_count > 0;
    if (result == STP_OK && !any) {
        result = stp_fail(t->context, STP_ERROR_FORMAT,
                          "%s: expected triangles or points, found none", t->path);
    }
    bool large = any && (root->triangle_count > max_triangles || has_strays(scene));
    t->is_cloud = any && root->triangle_count == 0;
    t->by_elevation = any && lacks_colors(scene, t->is_cloud);
    if (result == STP_OK && !large) {
        stp_farthest_graph graph = scene_farthest_graph(scene);
        stp_camera_fit_content(t->context, &graph, &t->view);
        tool_hold_errors();
        result = view_splats_make(scene, &t->view, (uint32_t)splats_wanted(), &t->made);
        large = result == STP_ERROR_LIMIT;
        tool_release_errors(result != STP_OK && !large, NULL);
        t->store = t->made.store;
        t->way = WAY_CAPTURED;
        t->quality.method = STP_METHOD_PSP;
        t->quality.splat_count = UINT64_MAX;
    }
    stp_scene_destroy(scene);
    return large ? open_built(t) : result;
}

/// Place of the drawn method in the file's table.
static uint32_t method_of(const thumbnail* t)
{
    return stp_store_find_method(stp_store_get_directory(t->store), t->quality.method);
}

static stp_result open_any(thumbnail* t)
{
    t->quality = (stp_quality){.splat_size = 1.0f};
    face(t);
    stp_result result = tool_is_store_file(t->path) ? open_stored(t) : open_model(t);
    if (result == STP_OK && t->way != WAY_CAPTURED) {
        int color = POINT_COLOR_AUTO;
        t->is_cloud = cloud_style_is_cloud(t->store);
        result = point_colors_choose(t->store, method_of(t), &color);
        t->by_elevation = color == POINT_COLOR_ELEVATION;
        const stp_farthest_store content = {t->context, t->store, NULL};
        stp_camera_fit_store(&content, NULL, &t->view);
    }
    return result;
}

/// Averages frames with sub-pixel shifts.
static stp_result draw(thumbnail* t)
{
    stp_draw_style style = {.transparency = STP_TRANSPARENCY_LAYERS,
                            .eye_dome = t->is_cloud ? CLOUD_THUMBNAIL_EYE_DOME : 0.0f};
    frame_maker maker = {0};
    frame_figures figures = {0};
    if (!frame_image_create(t->context, t->view.width, t->view.height, &t->image)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    if (t->store == NULL) {
        memset(t->image.pixels, 0, 4 * (size_t)t->image.width * t->image.height);
        return STP_OK;
    }
    stp_result result = STP_OK;
    if (t->by_elevation) {
        style.coloring = STP_DRAW_ELEVATION;
        result = point_colors_elevations(t->context, t->store, method_of(t), style.elevation);
    }
    result = result == STP_OK ? frame_maker_create(t->context, t->store, &style, &maker) : result;
    if (result == STP_OK) {
        result = frame_draw(&maker, &t->view, &t->quality, &t->image, &figures);
    }
    for (int i = 0; i < SAMPLES && result == STP_OK; ++i) {
        result = tool_is_interrupted()
                     ? STP_ERROR_CANCELLED
                     : frame_accumulate(&maker, &t->view, &t->quality, SAMPLES, &t->image);
    }
    if (result == STP_OK) {
        result = view_splats_trim(t->context, &t->made, &t->view, &t->image);
    }
    t->drawn_splats = figures.splats;
    t->drawn_triangles = figures.triangles;
    frame_maker_destroy(&maker);
    return result;
}

/// Blends the picture over its background in linear light.
static void fill_background(stp_image* image)
{
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i) {
        uint8_t* p = image->pixels + 4 * i;
        float share = (float)p[3] / 255.0f;
        for (size_t k = 0; k < 3; ++k) {
            p[k] = stp_linear_to_srgb8(share * stp_srgb8_to_linear(p[k]) +
                                       (1.0f - share) * stp_srgb8_to_linear(args.background[k]));
        }
        p[3] = 255;
    }
}

static const char* name_method(const thumbnail* t)
{
    const stp_store_directory* d = t->store != NULL ? stp_store_get_directory(t->store) : NULL;
    if (d == NULL || d->method_count == 0 || t->drawn_splats == 0) {
        return NULL;
    }
    return t->quality.method == STP_METHOD_PSP ? "psp" : d->methods[0].name;
}

static int print_report(const thumbnail* t, double seconds)
{
    static const char* const ways[] = {"captured", "stored", "built"};
    if (!args.json) {
        return 0;
    }
    return tool_print_json(json_pack(
        "{s:s, s:s?, s:I, s:I, s:I, s:I, s:I, s:f, s:I}", "way", ways[t->way], "method",
        name_method(t), "width", (json_int_t)t->view.width, "height", (json_int_t)t->view.height,
        "candidates", (json_int_t)t->made.candidates, "splats", (json_int_t)t->drawn_splats,
        "triangles", (json_int_t)t->drawn_triangles, "seconds", seconds, "peak_bytes",
        (json_int_t)stp_context_peak_bytes(t->context)));
}

static int make(thumbnail* t)
{
    double start = stp_clock_ms();
    stp_result result = open_any(t);
    result = result == STP_OK ? draw(t) : result;
    if (result == STP_OK && args.has_background) {
        fill_background(&t->image);
    }
    if (result == STP_OK && t->way == WAY_CAPTURED && t->store == NULL) {
        stp_warn(t->context, "%s: the picture is empty: nothing covers a pixel centre", t->path);
    }
    result = result == STP_OK ? tool_write_picture(t->context, &t->image, args.output) : result;
    return result == STP_OK ? print_report(t, 1e-3 * (stp_clock_ms() - start)) : 1;
}

static int check_arguments(int argc, const char* path)
{
    if (argc != 1) {
        return tool_usage_error("thumbnail needs one model, but got %d", argc);
    }
    if (args.output == NULL) {
        return tool_usage_error("thumbnail needs -o OUT.png");
    }
    if (args.json && strcmp(args.output, "-") == 0) {
        return tool_usage_error("standard output receives the figures; give a file name");
    }
    if (args.view != NULL && !stp_camera_is_standard(args.view)) {
        return tool_usage_error("--view must be front, back, left, right, top, bottom, iso or d0 "
                                "to d25, not %s",
                                args.view);
    }
    int code = overwrite_check(path, args.output);
    return code != 0 ? code : tool_check_picture(args.output);
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argc > 0 ? argv[0] : NULL);
    code = code == 0 ? tool_take_axes(&args.axes, argc, argv) : code;
    code = code == 0 ? tool_take_smooth(args.smooth, argc, argv) : code;
    if (code != 0) {
        return code;
    }
    thumbnail t = {.path = argv[0],
                   .view = {.width = args.size[0] > 0 ? args.size[0] : DEFAULT_SIZE,
                            .height = args.size[1] > 0 ? args.size[1] : DEFAULT_SIZE},
                   .context = tool_context_create((uint32_t)args.threads, args.memory, NULL)};
    if (t.context == NULL) {
        return 1;
    }
    code = make(&t);
    if (t.store != NULL && t.store != t.made.store) {
        stp_store_close(t.store);
    }
    view_splats_destroy(t.context, &t.made);
    stp_free(t.context, t.image.pixels);
    stp_context_destroy(t.context);
    return code;
}

const command command_thumbnail = {
    .name = "thumbnail",
    .arguments = "MODEL -o OUT.png",
    .summary = "draw a small picture of a model with few splats",
    .text =
        "Draws a model in parallel projection with the requested number of elliptical splats. "
        "Nothing is built or cached. The visible surface is captured at about twice the "
        "resolution of the picture, and Progressive Splatting (method psp) merges it into "
        "splats. All splats are visible in the picture; they are smaller where the surface or "
        "its colours change. The outline is taken from the capture; the few pixels inside it "
        "that no splat covers take the colours of their neighbours.\n\n"
        "A point of a cloud is as wide as the distance to its eighth-nearest neighbour. Clouds "
        "are drawn with eye-dome lighting.\n\n"
        "For a .stip, the first N splats of its psp sets are drawn, or of its first method if it "
        "has none. Parts that are too small for splats are drawn as triangles.\n\n"
        "Models of more than 4 billion triangles or 4 million uses of parts are drawn as by "
        "render, using the same cache.\n\n"
        "The background is transparent. The same input gives the same bytes with any number of "
        "threads.",
    .examples = "Draw a thumbnail for a file browser:\n"
                "$ stipple thumbnail statue.glb -o statue.png\n"
                "Draw a larger one with more splats, on white:\n"
                "$ stipple thumbnail statue.glb -o statue.png --size 512x512 --splats 8000 "
                "--background white\n",
    .files = "MODEL\t"
             "any model that can be imported, a named scene (scene:NAME), or a .stip\n",
    .options = options,
    .run = run,
};
