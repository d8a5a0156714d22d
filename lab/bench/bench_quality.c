// SPDX-License-Identifier: MIT
// Benchmark `quality`: compares pictures at splat sizes 1 to 24, or at a given size, with the
// original triangles: SSIM, holes, wrong depths, and growth of the covered area. Three series: the
// object framed to fill the picture (triangles are drawn where the splats are too coarse) from 26
// directions away from the capture's, and from the named views; and from the nearest distance at
// which splats alone suffice.
#include "builder/build_scene.h"
#include "draw/draw.h"
#include "lab/bench/bench.h"
#include "lab/measure/measured_views.h"
#include "lab/measure/surface_compare.h"
#include "program/drawing/draw_options.h"
#include "program/measure/image_compare.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define DEFAULT_MODEL                                                                              \
    "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb"

enum { DIRECTION_COUNT = 26, QUICK_DIRECTION_COUNT = 3, SIZE_COUNT = 6 };

static const float all_sizes[SIZE_COUNT] = {1.0f, 2.0f, 4.0f, 8.0f, 16.0f, 24.0f};
static const char* const named_views[] = {"iso",   "front", "back",   "left",
                                          "right", "top",   "bottom", NULL};

// One model under test.
typedef struct quality_run {
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_image ours, reference;
    float* reference_nearness;
    uint32_t width, height;
    float sizes[SIZE_COUNT]; ///< splat sizes that are compared, pixels
    uint32_t size_count;
    const stp_view* eye; ///< the only view, or NULL
    uint32_t method;     ///< STP_METHOD_*; 0: the file's first
} quality_run;

// Sums over the views of one series, at one size of splats.
typedef struct quality_sums {
    float splat_size;
    uint32_t pictures;
    stp_surface_errors errors;
    uint64_t splats, triangles;
    double ssim[DIRECTION_COUNT], covered[DIRECTION_COUNT];
    uint32_t worst; ///< index of the view with the most holes and wrong depths
    uint64_t worst_errors;
    double max_holes;            ///< most holes of a picture, per 10,000 interior pixels
    double min_area, area_limit; ///< smallest and largest covered area, over the reference's
} quality_sums;

// The views of a series.
typedef struct quality_series {
    const char* name;
    const char* const* views; ///< names, NULL at the end; NULL: the directions
    const stp_view* eye;      ///< one view instead
    bool limit;               ///< from the nearest distance at which the splats suffice
    const float* sizes;
    uint32_t size_count, direction_count;
} quality_series;

static stp_result draw_view(quality_run* run, const stp_view* view, float splat_size,
                            bool reference, stp_image* image, stp_draw_stats* stats)
{
    stp_quality quality = {.splat_size = splat_size, .method = run->method, .reference = reference};
    stp_draw_style style = {.plane_depth = true};
    stp_result result = stp_select(run->context, run->store, view, &quality, &run->list);
    return result == STP_OK
               ? stp_renderer_draw(run->renderer, view, &run->list, &style, image, stats)
               : result;
}

// Draws the reference picture and keeps its depths.
static stp_result draw_reference(quality_run* run, const stp_view* view)
{
    stp_draw_stats stats;
    stp_result result = draw_view(run, view, 1.0f, true, &run->reference, &stats);
    if (result == STP_OK) {
        size_t pixels = (size_t)run->width * run->height;
        memcpy(run->reference_nearness, stp_renderer_depth(run->renderer), pixels * sizeof(float));
    }
    return result;
}

static void add_errors(quality_sums* sums, const stp_surface_errors* errors, uint32_t direction)
{
    sums->errors.covered += errors->covered;
    sums->errors.interior += errors->interior;
    sums->errors.holes += errors->holes;
    sums->errors.wrong_depth += errors->wrong_depth;
    sums->errors.drawn += errors->drawn;
    sums->errors.extra += errors->extra;
    if (errors->holes + errors->wrong_depth > sums->worst_errors) {
        sums->worst_errors = errors->holes + errors->wrong_depth;
        sums->worst = direction;
    }
    if (errors->covered == 0) {
        return;
    }
    double interior = errors->interior > 0 ? (double)errors->interior : 1.0;
    sums->max_holes = fmax(sums->max_holes, 1e4 * (double)errors->holes / interior);
    double area = (double)errors->drawn / (double)errors->covered;
    sums->area_limit = fmax(sums->area_limit, area);
    sums->min_area = sums->min_area > 0.0 ? fmin(sums->min_area, area) : area;
}

// Draws a view and adds its differences from the reference, which is already drawn, to the sums.
static stp_result compare_view(quality_run* run, const stp_view* view, uint32_t direction,
                               quality_sums* sums)
{
    stp_draw_stats stats;
    stp_result result = draw_view(run, view, sums->splat_size, false, &run->ours, &stats);
    if (result != STP_OK) {
        return result;
    }
    stp_image_quality quality;
    result = stp_image_compare(run->context, &run->ours, &run->reference, NULL, NULL, &quality);
    if (result != STP_OK) {
        return result;
    }
    stp_surface_frame truth = {run->width, run->height, run->reference_nearness};
    stp_surface_frame frame = {run->width, run->height, stp_renderer_depth(run->renderer)};
    double pixel_angle = 2.0 * tan(view->fov_degrees * STP_PI / 360.0) / (double)run->height;
    stp_surface_errors errors;
    stp_surface_compare(&truth, &frame, pixel_angle, 2.0, &errors);
    add_errors(sums, &errors, direction);
    sums->splats += stats.splats;
    sums->triangles += stats.triangles;
    assert(sums->pictures < DIRECTION_COUNT && "no series has more views");
    sums->ssim[sums->pictures] = quality.ssim;
    sums->covered[sums->pictures] = quality.ssim_covered;
    sums->pictures += 1;
    return STP_OK;
}

// Moves the eye along its view direction to the nearest position at which the root's splats
// suffice: there half a splat at the nearest point of the box's sphere equals the splats' coverage
// radius.
static void move_to_limit(const stp_splats* splats, const stp_boxd* box, float splat_size,
                          stp_view* view)
{
    stp_vec3d centre = stp_scaled(stp_addd(box->min, box->max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    double sphere = sqrt(stp_dotd(half, half));
    double pixel_angle = 2.0 * tan(view->fov_degrees * STP_PI / 360.0) / (double)view->height;
    assert(splats->table.size > 0 && splat_size > 0.0f);
    double reached = (double)splats->table.radius[splats->table.size - 1];
    double nearest = 2.0 * reached / pixel_angle / (double)splat_size * 1.001;
    stp_vec3d away = stp_normalized(stp_subd(view->eye, view->target));
    view->target = centre;
    view->eye = stp_addd(centre, stp_scaled(away, sphere + nearest));
}

static void report_errors(json_t* figures, const quality_sums* sums)
{
    const stp_surface_errors* errors = &sums->errors;
    double covered = errors->covered > 0 ? (double)errors->covered : 1.0;
    double interior = errors->interior > 0 ? (double)errors->interior : 1.0;
    bench_set_number(figures, "holes_per_10k", 1e4 * (double)errors->holes / covered);
    bench_set_number(figures, "wrong_depth_per_10k", 1e4 * (double)errors->wrong_depth / covered);
    bench_set_number(figures, "extra_per_10k", 1e4 * (double)errors->extra / covered);
    bench_set_number(figures, "interior_holes_per_10k", 1e4 * (double)errors->holes / interior);
    bench_set_number(figures, "interior_holes_per_10k_most", sums->max_holes);
    bench_set_number(figures, "wrong_depth_per_1k", 1e3 * (double)errors->wrong_depth / covered);
    bench_set_number(figures, "area_ratio", (double)errors->drawn / covered);
    bench_set_number(figures, "area_ratio_least", sums->min_area);
    bench_set_number(figures, "area_ratio_most", sums->area_limit);
    bench_set_count(figures, "worst_direction", sums->worst);
    bench_set_count(figures, "covered_pixels", errors->covered);
    bench_set_count(figures, "interior_pixels", errors->interior);
}

static void report_series(json_t* results, const char* model, const char* series,
                          const quality_run* run, quality_sums* sums)
{
    bench_entry entry = bench_result(results, "quality");
    bench_set_text(entry.params, "model", model);
    bench_set_text(entry.params, "series", series);
    bench_set_count(entry.params, "width", run->width);
    bench_set_count(entry.params, "height", run->height);
    bench_set_number(entry.params, "splat_size", (double)sums->splat_size);
    bench_set_count(entry.params, "pictures", sums->pictures);
    double minimum = sums->pictures > 0 ? sums->covered[0] : 0.0;
    for (uint32_t i = 1; i < sums->pictures; ++i) {
        minimum = sums->covered[i] < minimum ? sums->covered[i] : minimum;
    }
    bench_set_number(entry.figures, "ssim", bench_median(sums->ssim, sums->pictures));
    bench_set_number(entry.figures, "ssim_covered", bench_median(sums->covered, sums->pictures));
    bench_set_number(entry.figures, "ssim_covered_least", minimum);
    report_errors(entry.figures, sums);
    uint32_t pictures = sums->pictures > 0 ? sums->pictures : 1;
    bench_set_count(entry.figures, "splats", sums->splats / pictures);
    bench_set_count(entry.figures, "triangles", sums->triangles / pictures);
}

// View `index` of a series. @return false if there are no more
static bool make_view(const quality_run* run, const quality_series* series, uint32_t index,
                      stp_view* view)
{
    if (series->eye != NULL) {
        *view = *series->eye;
        return index == 0;
    }
    const stp_store_directory* directory = stp_store_get_directory(run->store);
    char direction[16];
    snprintf(direction, sizeof(direction), "d%u", index);
    const char* name = direction;
    if (series->views != NULL) {
        name = series->views[index];
    } else if (index == series->direction_count) {
        name = NULL;
    }
    *view = (stp_view){.width = run->width, .height = run->height};
    return name != NULL &&
           measured_standard_view(name, &directory->nodes[directory->root].bounds, view);
}

static stp_result run_series(quality_run* run, const char* model, const quality_series* series,
                             json_t* results)
{
    const stp_store_directory* directory = stp_store_get_directory(run->store);
    const stp_store_node* root = &directory->nodes[directory->root];
    quality_sums sums[SIZE_COUNT] = {0};
    stp_splats splats;
    stp_result result = STP_OK;
    if (series->limit) {
        uint32_t method = stp_store_find_method(directory, run->method);
        uint32_t set = stp_store_set_of(directory, method, directory->root);
        result = stp_store_get_splat_set(run->store, set, &splats);
    }
    stp_view view;
    for (uint32_t i = 0; result == STP_OK && make_view(run, series, i, &view); ++i) {
        if (series->limit) {
            move_to_limit(&splats, &root->bounds, series->sizes[0], &view);
        }
        result = draw_reference(run, &view);
        for (uint32_t k = 0; result == STP_OK && k < series->size_count; ++k) {
            sums[k].splat_size = series->sizes[k];
            result = compare_view(run, &view, i, &sums[k]);
        }
    }
    for (uint32_t k = 0; result == STP_OK && k < series->size_count; ++k) {
        report_series(results, model, series->name, run, &sums[k]);
    }
    return result;
}

static stp_result allocate_pictures(quality_run* run)
{
    size_t pixels = (size_t)run->width * run->height;
    run->ours = (stp_image){run->width, run->height, stp_alloc(run->context, pixels * 4)};
    run->reference = (stp_image){run->width, run->height, stp_alloc(run->context, pixels * 4)};
    run->reference_nearness = STP_NEW_ARRAY(run->context, float, pixels);
    bool got = run->ours.pixels != NULL && run->reference.pixels != NULL;
    return got && run->reference_nearness != NULL ? STP_OK : stp_fail_memory(run->context);
}

static stp_result measure_file(quality_run* run, const char* path, const char* model, bool quick,
                               json_t* results)
{
    stp_result result = stp_store_open(run->context, path, &run->store);
    if (result == STP_OK && tool_check_method(run->method, run->store, model) != 0) {
        return STP_ERROR_ARGUMENT;
    }
    if (result == STP_OK) {
        result = stp_draw_cpu_create(run->context, run->store, &run->renderer);
    }
    if (result == STP_OK) {
        result = allocate_pictures(run);
    }
    if (result != STP_OK) {
        return result;
    }
    const stp_store_directory* directory = stp_store_get_directory(run->store);
    if (directory->root == STP_STORE_NONE) {
        return stp_fail(run->context, STP_ERROR_FORMAT, "%s: the scene is empty", model);
    }
    quality_series series = {.name = "framed",
                             .sizes = run->sizes,
                             .size_count = run->size_count,
                             .direction_count = quick ? QUICK_DIRECTION_COUNT : DIRECTION_COUNT};
    if (run->eye != NULL) {
        series.name = "eye";
        series.eye = run->eye;
        return run_series(run, model, &series, results);
    }
    result = run_series(run, model, &series, results);
    if (result == STP_OK) {
        quality_series named = series;
        named.name = "views";
        named.views = named_views;
        result = run_series(run, model, &named, results);
    }
    uint32_t method = stp_store_find_method(directory, run->method);
    if (result == STP_OK &&
        stp_store_set_of(directory, method, directory->root) != STP_STORE_NONE) {
        quality_series near = series;
        near.name = "limit";
        near.limit = true;
        near.size_count = 1; // the position of the eye depends on it
        result = run_series(run, model, &near, results);
    }
    return result;
}

static void free_run(quality_run* run)
{
    stp_draw_list_destroy(run->context, &run->list);
    stp_free(run->context, run->reference_nearness);
    stp_free(run->context, run->reference.pixels);
    stp_free(run->context, run->ours.pixels);
    if (run->renderer != NULL) {
        stp_renderer_destroy(run->renderer);
    }
    if (run->store != NULL) {
        stp_store_close(run->store);
    }
}

static quality_run make_run(stp_context* context, const bench_options* options)
{
    quality_run run = {.context = context,
                       .width = options->quick ? 320 : 1920,
                       .height = options->quick ? 180 : 1080,
                       .method = options->method,
                       .sizes = {(float)options->splat_size},
                       .size_count = 1};
    if (options->size[0] != 0) {
        run.width = options->size[0];
        run.height = options->size[1];
    }
    if (options->all_sizes) {
        memcpy(run.sizes, all_sizes, sizeof(all_sizes));
        run.size_count = SIZE_COUNT;
    }
    return run;
}

static int run_quality(const bench_options* options, json_t* results)
{
    const char* model = options->model != NULL ? options->model : DEFAULT_MODEL;
    char folder[] = "/tmp/stipple-quality-XXXXXX", path[64];
    if (mkdtemp(folder) == NULL) {
        return tool_error("bench quality: cannot create a temporary folder");
    }
    snprintf(path, sizeof(path), "%s/model.stip", folder);
    stp_context* context = tool_context_create(0, 0, "none");
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (context != NULL) {
        quality_run run = make_run(context, options);
        stp_view eye = {.eye = options->eye,
                        .target = options->target,
                        .up = {0.0, 1.0, 0.0},
                        .fov_degrees = 60.0,
                        .width = run.width,
                        .height = run.height};
        run.eye = options->has_eye ? &eye : NULL;
        const char* ending = strrchr(model, '.');
        bool is_built = ending != NULL && strcmp(ending, ".stip") == 0;
        const stp_method* method = stp_method_by_id(options->method);
        stp_build_desc desc = {.inputs = &model,
                               .input_count = 1,
                               .output = path,
                               .methods = &method,
                               .method_count = method != NULL ? 1 : 0,
                               .method_options = stp_method_options_default()};
        stp_build_report report;
        result = is_built ? STP_OK : stp_build(context, &desc, &report);
        if (result == STP_OK) {
            const char* file = is_built ? model : path;
            result = measure_file(&run, file, model, options->quick, results);
        }
        free_run(&run);
        stp_context_destroy(context);
    }
    unlink(path);
    rmdir(folder);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_quality = {
    .name = "quality",
    .summary = "splats of sizes 1 to 24 against the original triangles, from 26 directions and the "
               "named views",
    .run = run_quality,
};
