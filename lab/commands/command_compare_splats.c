// SPDX-License-Identifier: MIT
//
// stipple-lab compare-splats: measures how well a few splats, or triangles, approximate a model.
#include "base/io/file.h"
#include "lab/measure/shape_list.h"
#include "lab/measure/splat_pictures.h"
#include "lod/method.h"
#include "program/drawing/draw_options.h"
#include "program/files/point_file.h"
#include "program/files/scene_file.h"
#include "program/files/splat_store.h"
#include "program/options/command.h"
#include "program/options/tool.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static struct {
    uint64_t splats, samples, threads;
    int method;
    bool has_method, no_pictures, json;
    uint32_t size[2];
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "splats",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..4294967294",
         .help = "number of splats to use from a .stip, as for render --splats; default all",
         .value = &args.splats},
        {.name = "method",
         .type = OPTION_CHOICE,
         .words = TOOL_METHOD_WORDS,
         .help = "method whose splats to use from a .stip; default the first in the file",
         .value = &args.method,
         .given = &args.has_method},
        {.name = "samples",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "auto|1..1000000000",
         .help = "samples of the model's area, besides its vertices; default ten per triangle, "
                 "200,000 to 4,000,000",
         .value = &args.samples},
        {.name = "size",
         .type = OPTION_PIXELS,
         .argument = "WxH",
         .help = "size of the pictures; default 512x512",
         .value = args.size},
        {.name = "no-pictures",
         .help = "measure distances and areas only, without pictures",
         .value = &args.no_pictures},
        OPTION_THREADS(&args.threads),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

typedef enum input_kind { INPUT_STORE, INPUT_SPLATS, INPUT_MODEL } input_kind;

/// The state of one comparison.
typedef struct comparison {
    stp_context* context;
    const char *path, *model;
    input_kind kind, model_kind;
    char up; ///< up axis in the model's own coordinates: x, y or z
    tool_shape_list drawn, original;
    tool_splat_set splats;          ///< read from a PLY; else empty
    stp_store *store, *model_store; ///< open if the input is a .stip
    stp_hausdorff found;
    stp_quality quality; ///< how pictures of `path` are drawn
    double diagonal, drawn_area;
    splat_pictures pictures;
} comparison;

static input_kind find_kind(const char* path)
{
    return tool_is_store_file(path)   ? INPUT_STORE
           : tool_is_splat_file(path) ? INPUT_SPLATS
                                      : INPUT_MODEL;
}

static void set_origin(comparison* c, stp_boxd bounds)
{
    if (!stp_boxd_is_empty(bounds)) {
        stp_vec3d middle = tool_own_axes(c->up, stp_scaled(stp_addd(bounds.min, bounds.max), 0.5));
        const double origin[3] = {middle.x, middle.y, middle.z};
        memcpy(c->original.origin, origin, sizeof(origin));
        memcpy(c->drawn.origin, origin, sizeof(origin));
    }
}

static stp_result read_model(comparison* c)
{
    static const stp_quality reference = {.reference = true};
    stp_scene* scene = NULL;
    stp_result result;
    if (c->model_kind == INPUT_STORE) {
        result = stp_store_open(c->context, c->model, &c->model_store);
        if (result == STP_OK) {
            const stp_store_directory* d = stp_store_get_directory(c->model_store);
            c->up = d->up;
            set_origin(c, d->root != STP_STORE_NONE ? d->nodes[d->root].bounds : stp_boxd_empty());
            result = tool_shapes_add_store(c->context, &c->original, c->model_store, &reference);
        }
    } else {
        result = tool_import_scene(c->context, c->model, &scene);
        if (result == STP_OK) {
            c->up = scene->up != NULL ? scene->up[0] : 'y';
            set_origin(c, scene->root != STP_NONE ? scene->nodes[scene->root].bounds
                                                  : stp_boxd_empty());
            result = tool_shapes_add_scene(&c->original, scene);
        }
        stp_scene_destroy(scene);
    }
    if (result == STP_OK && c->original.triangle_count == 0 && c->original.point_count == 0) {
        result = stp_fail(c->context, STP_ERROR_FORMAT,
                          "%s: expected triangles or points, found none", c->model);
    }
    return result;
}

static stp_result read_store(comparison* c)
{
    stp_result result = stp_store_open(c->context, c->path, &c->store);
    uint32_t method = args.has_method ? stp_methods[args.method].id : 0;
    c->quality = (stp_quality){.method = method,
                               .splat_size = 1.0f,
                               .splat_count = args.splats > 0 ? args.splats : UINT64_MAX};
    if (result == STP_OK && tool_check_method(method, c->store, c->path) != 0) {
        return STP_ERROR_ARGUMENT;
    }
    return result == STP_OK ? tool_shapes_add_store(c->context, &c->drawn, c->store, &c->quality)
                            : result;
}

static stp_result read_drawn(comparison* c)
{
    stp_result result;
    stp_scene* scene = NULL;
    switch (c->kind) {
    case INPUT_STORE:
        result = read_store(c);
        break;
    case INPUT_SPLATS:
        result = tool_read_splats(c->context, c->path, &c->splats);
        if (result == STP_OK) {
            result = tool_shapes_add_splats(c->context, &c->drawn, &c->splats);
        }
        c->quality = (stp_quality){.splat_size = 1.0f, .splat_count = UINT64_MAX};
        break;
    default:
        result = tool_import_scene(c->context, c->path, &scene);
        result = result == STP_OK ? tool_shapes_add_scene(&c->drawn, scene) : result;
        stp_scene_destroy(scene);
        c->quality = (stp_quality){.splat_size = 1.0f, .reference = true};
        break;
    }
    return result == STP_OK ? tool_shapes_draw_points(c->context, &c->drawn) : result;
}

static stp_result measure(comparison* c)
{
    stp_shapes drawn = tool_shapes_drawn(&c->drawn);
    stp_measured_surface original = tool_shapes_surface(&c->original);
    stp_boxd box = tool_shapes_bounds(&c->original);
    stp_vec3d size = stp_subd(box.max, box.min);
    c->diagonal = sqrt(stp_dotd(size, size));
    if (!(c->diagonal > 0.0)) {
        return stp_fail(c->context, STP_ERROR_ARGUMENT,
                        "%s: is a single point, so there is no diagonal to measure by", c->model);
    }
    if (drawn.disk_count + drawn.triangle_count == 0) {
        return stp_fail(c->context, STP_ERROR_ARGUMENT,
                        "%s: expected splats or triangles, found none", c->path);
    }
    stp_shape_tree tree;
    stp_result result = stp_shape_tree_create(c->context, &drawn, &tree);
    if (result != STP_OK) {
        return result;
    }
    uint64_t samples =
        args.samples > 0 ? args.samples : stp_hausdorff_samples(original.triangle_count);
    result = stp_hausdorff_measure(c->context, &original, &tree, samples, &c->found);
    c->drawn_area = stp_shapes_area(&drawn);
    stp_shape_tree_destroy(c->context, &tree);
    return result;
}

/// Splats of a PLY as a scene.
static stp_result open_splats(comparison* c, stp_store** store)
{
    uint32_t* indices = STP_NEW_ARRAY(c->context, uint32_t, c->splats.count);
    if (indices == NULL) {
        return stp_fail_memory(c->context);
    }
    for (uint32_t i = 0; i < c->splats.count; ++i) {
        indices[i] = i;
    }
    tool_splats splats = {.ellipses = c->splats.ellipses,
                          .colors = c->splats.colors,
                          .indices = indices,
                          .count = c->splats.count};
    memcpy(splats.origin, c->splats.origin, sizeof(splats.origin));
    stp_result result = tool_open_splat_store(c->context, &splats, c->up, store);
    stp_free(c->context, indices);
    return result;
}

static stp_result compare_pictures(comparison* c)
{
    stp_store *shown = c->store, *original = c->model_store;
    stp_result result = STP_OK;
    if (original == NULL) {
        result = tool_open_scene_for(c->context, c->model, SCENE_FOR_ORIGINALS, &original);
    }
    if (result == STP_OK && c->kind == INPUT_SPLATS) {
        result = open_splats(c, &shown);
    } else if (result == STP_OK && c->kind == INPUT_MODEL) {
        result = tool_open_scene_for(c->context, c->path, SCENE_FOR_ORIGINALS, &shown);
    }
    if (result == STP_OK) {
        const splat_scene splats = {shown, c->quality};
        const splat_scene model = {original, {.splat_size = 1.0f, .reference = true}};
        const uint32_t size[2] = {args.size[0] > 0 ? args.size[0] : 512,
                                  args.size[1] > 0 ? args.size[1] : 512};
        result = splat_pictures_compare(c->context, &splats, &model, size, &c->pictures);
    }
    if (shown != c->store && shown != NULL) {
        stp_store_close(shown);
    }
    if (original != c->model_store && original != NULL) {
        stp_store_close(original);
    }
    return result;
}

static json_t* describe_views(const comparison* c)
{
    json_t* views = json_array();
    for (int v = 0; v < SPLAT_PICTURES; ++v) {
        const stp_image_quality* q = &c->pictures.views[v];
        json_t* view = json_pack("{s:s, s:f, s:f}", "view", splat_picture_views[v], "ssim", q->ssim,
                                 "ssim_covered", q->ssim_covered);
        if (json_array_append_new(views, view) != 0) {
            json_decref(views);
            return NULL;
        }
    }
    return views;
}

static double percent_of(const comparison* c, double distance)
{
    assert(c->diagonal > 0.0 && "measure() refuses a model without one");
    return 100.0 * distance / c->diagonal;
}

static int print_json(const comparison* c)
{
    bool has_area = c->found.area > 0.0, pictures = !args.no_pictures;
    json_t* ratio = has_area ? json_real(c->drawn_area / c->found.area) : json_null();
    json_t* why = has_area ? json_null() : json_string("the model has no triangles with an area");
    json_t* ssim = pictures ? json_real(c->pictures.ssim) : json_null();
    json_t* covered = pictures ? json_real(c->pictures.ssim_covered) : json_null();
    json_t* views = pictures ? describe_views(c) : json_null();
    const double* origin = c->drawn.origin;
    stp_vec3d at = c->found.farthest;
    return tool_print_json(json_pack(
        "{s:I, s:I, s:f, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:f, s:f, s:f, s:I, s:[f, f, f]}",
        "splats", (json_int_t)c->drawn.disk_count, "triangles", (json_int_t)c->drawn.triangle_count,
        "hausdorff_max_percent", percent_of(c, c->found.max), "hausdorff_mean_percent",
        percent_of(c, c->found.mean), "hausdorff_bound_percent", percent_of(c, c->found.bound),
        "area_ratio", ratio, "area_ratio_missing", why, "ssim", ssim, "ssim_covered", covered,
        "views", views, "diagonal", c->diagonal, "area", c->found.area, "splat_area", c->drawn_area,
        "samples", (json_int_t)c->found.samples, "farthest", at.x + origin[0], at.y + origin[1],
        at.z + origin[2]));
}

static int print(const comparison* c)
{
    if (args.json) {
        return print_json(c);
    }
    printf("splats          %zu\n", c->drawn.disk_count);
    if (c->drawn.triangle_count > 0) {
        printf("triangles       %zu\n", c->drawn.triangle_count);
    }
    printf("largest         %.4f %% of the diagonal\nmean            %.4f %%\n",
           percent_of(c, c->found.max), percent_of(c, c->found.mean));
    if (c->found.area > 0.0) {
        printf("area            %.3f times the model's\n", c->drawn_area / c->found.area);
    } else {
        printf("area            %.6g; the model has none to compare with\n", c->drawn_area);
    }
    if (!args.no_pictures) {
        printf("ssim            %.4f\nssim_covered    %.4f\n", c->pictures.ssim,
               c->pictures.ssim_covered);
    }
    return 0;
}

static stp_result compare(comparison* c)
{
    c->kind = find_kind(c->path);
    c->model_kind = find_kind(c->model);
    if ((args.splats > 0 || args.has_method) && c->kind != INPUT_STORE) {
        return stp_fail(c->context, STP_ERROR_ARGUMENT,
                        "%s: --splats and --method apply only to a .stip", c->path);
    }
    stp_result result = read_model(c);
    result = result == STP_OK ? read_drawn(c) : result;
    result = result == STP_OK ? measure(c) : result;
    return result == STP_OK && !args.no_pictures ? compare_pictures(c) : result;
}

static int run(int argc, char** argv)
{
    if (argc != 2) {
        return tool_usage_error("compare-splats needs splats and a model, but got %d files", argc);
    }
    comparison c = {.path = argv[0],
                    .model = argv[1],
                    .context = tool_context_create((uint32_t)args.threads, 0, "none")};
    if (c.context == NULL) {
        return 1;
    }
    int code = compare(&c) == STP_OK ? print(&c) : 1;
    tool_shapes_destroy(c.context, &c.drawn);
    tool_shapes_destroy(c.context, &c.original);
    tool_splat_set_destroy(c.context, &c.splats);
    if (c.store != NULL) {
        stp_store_close(c.store);
    }
    if (c.model_store != NULL) {
        stp_store_close(c.model_store);
    }
    stp_context_destroy(c.context);
    return code;
}

const command command_compare_splats = {
    .name = "compare-splats",
    .arguments = "FILE MODEL",
    .summary = "measure how well splats approximate a model: distances, area, pictures",
    .text =
        "Measures the largest and the mean distance from the surface of MODEL to the nearest "
        "splat of FILE (one-sided Hausdorff distances), in percent of the diagonal of MODEL's "
        "bounding box. FILE is a .stip (the splats that render --splats N draws), a PLY of "
        "splats written by decimate, or a mesh, measured by its triangles. Splats count as whole "
        "ellipses at their drawn size, without cuts, holes or opacity. Parts of a .stip that are "
        "too small for splats count as triangles or points.\n\n"
        "The surface of MODEL is represented by every triangle vertex and by samples spread "
        "evenly over its area; the mean uses the samples only. Surfaces that are invisible from "
        "outside also count. Each point of a cloud counts once. Where the largest distance may "
        "lie between samples, more positions are measured; no position is farther away than "
        "hausdorff_bound_percent. That bound is about a thousandth above the largest measured "
        "distance, or more with few --samples; for a cloud both are equal. The figures are the "
        "same on every machine and for any number of threads.\n\n"
        "The area is the total area of all ellipses divided by that of MODEL's triangles; it "
        "shows how much splats overlap. For a MODEL without triangles the ratio is null in "
        "JSON.\n\n"
        "ssim and ssim_covered are means over seven standard views: FILE is compared with "
        "MODEL's triangles and points (render --reference), as in stipple compare. Colours "
        "count. Points of a cloud are drawn as single pixels, so compare such figures only with "
        "each other.\n\n"
        "The files may have different formats: positions are compared along each file's own axes.",
    .examples = "Compare a statue with 2,000 splats of it:\n"
                "$ stipple-lab decimate statue.ply -o splats.ply --splats 2000\n"
                "$ stipple-lab compare-splats splats.ply statue.ply\n"
                "Compare it with the first 2,000 splats of a built scene:\n"
                "$ stipple-lab compare-splats statue.stip statue.ply --splats 2000\n",
    .files = "FILE\t"
             "a .stip, splats or triangles\n"
             "MODEL\t"
             "the original: any model that can be imported, or a .stip\n",
    .options = options,
    .run = run,
};
