// SPDX-License-Identifier: MIT
// Benchmark `quality`: the picture, at splat size 1 or another, against the original triangles, from 26
// directions that keep away from the capture's. Twice: the object framed to fill the picture (where
// the surfels do not suffice, triangles are drawn), and from as near as the surfels alone suffice.
#include "bench.h"

#include "build/build.h"
#include "draw/draw.h"
#include "measure/image_compare.h"
#include "measure/surface_compare.h"
#include "present/camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define DEFAULT_MODEL                                                                              \
    "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb"

enum { DIRECTION_COUNT = 26, QUICK_DIRECTION_COUNT = 3 };

// One model under test.
typedef struct quality_run {
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_image ours, reference;
    float* reference_nearness;
    uint32_t width, height;
    float splat_size;
} quality_run;

// Sums over the directions of one series.
typedef struct quality_sums {
    uint32_t pictures;
    stp_surface_errors errors;
    uint64_t splats, triangles;
    double ssim[DIRECTION_COUNT], covered[DIRECTION_COUNT];
    uint32_t worst; ///< direction with the most holes and wrong depths
    uint64_t worst_errors;
} quality_sums;

static stp_result draw_view(quality_run* run, const stp_view* view, bool reference,
                            stp_image* image, stp_draw_stats* stats)
{
    stp_quality quality = {.splat_size = run->splat_size, .reference = reference};
    stp_draw_style style = {0};
    stp_result result = stp_select(run->context, run->store, view, &quality, &run->list);
    return result != STP_OK
               ? result
               : stp_renderer_draw(run->renderer, view, &run->list, &style, image, stats);
}

// Draws both pictures of a view and adds their differences to the sums.
static stp_result compare_view(quality_run* run, const stp_view* view, uint32_t direction,
                               quality_sums* sums)
{
    stp_draw_stats stats;
    stp_result result = draw_view(run, view, true, &run->reference, &stats);
    if (result != STP_OK) {
        return result;
    }
    size_t pixels = (size_t)run->width * run->height;
    memcpy(run->reference_nearness, stp_renderer_depth(run->renderer), pixels * sizeof(float));
    result = draw_view(run, view, false, &run->ours, &stats);
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
    sums->errors.covered += errors.covered;
    sums->errors.holes += errors.holes;
    sums->errors.wrong_depth += errors.wrong_depth;
    sums->errors.extra += errors.extra;
    if (errors.holes + errors.wrong_depth > sums->worst_errors) {
        sums->worst_errors = errors.holes + errors.wrong_depth;
        sums->worst = direction;
    }
    sums->splats += stats.splats;
    sums->triangles += stats.triangles;
    sums->ssim[sums->pictures] = quality.ssim;
    sums->covered[sums->pictures] = quality.ssim_covered;
    sums->pictures += 1;
    return STP_OK;
}

// Moves the eye along its gaze to where the whole order of the root's surfels just suffices: there
// half a splat at the nearest point of the box's sphere is as large as the radius the surfels
// reach.
static void move_to_limit(const stp_surfels* surfels, const stp_boxd* box, float splat_size,
                          stp_view* view)
{
    stp_vec3d centre = stp_scaled(stp_addd(box->min, box->max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    double sphere = sqrt(stp_dotd(half, half));
    double pixel_angle = 2.0 * tan(view->fov_degrees * STP_PI / 360.0) / (double)view->height;
    double reached = (double)surfels->table.radius[surfels->table.size - 1];
    double nearest = 2.0 * reached / pixel_angle / (double)splat_size * 1.001;
    stp_vec3d away = stp_normalized(stp_subd(view->eye, view->target));
    view->target = centre;
    view->eye = stp_addd(centre, stp_scaled(away, sphere + nearest));
}

static void report_series(json_t* results, const char* model, const char* series,
                          const quality_run* run, quality_sums* sums)
{
    bench_entry entry = bench_result(results, "quality");
    bench_set_text(entry.params, "model", model);
    bench_set_text(entry.params, "series", series);
    bench_set_count(entry.params, "width", run->width);
    bench_set_count(entry.params, "height", run->height);
    bench_set_number(entry.params, "splat_size", (double)run->splat_size);
    bench_set_count(entry.params, "pictures", sums->pictures);
    double covered = sums->errors.covered > 0 ? (double)sums->errors.covered : 1.0;
    double least = sums->pictures > 0 ? sums->covered[0] : 0.0;
    for (uint32_t i = 1; i < sums->pictures; ++i) {
        least = sums->covered[i] < least ? sums->covered[i] : least;
    }
    bench_set_number(entry.figures, "ssim", bench_median(sums->ssim, sums->pictures));
    bench_set_number(entry.figures, "ssim_covered", bench_median(sums->covered, sums->pictures));
    bench_set_number(entry.figures, "ssim_covered_least", least);
    bench_set_number(entry.figures, "holes_per_10k", 1e4 * (double)sums->errors.holes / covered);
    bench_set_number(entry.figures, "wrong_depth_per_10k",
                     1e4 * (double)sums->errors.wrong_depth / covered);
    bench_set_number(entry.figures, "extra_per_10k", 1e4 * (double)sums->errors.extra / covered);
    bench_set_count(entry.figures, "worst_direction", sums->worst);
    bench_set_count(entry.figures, "covered_pixels", sums->errors.covered);
    uint32_t pictures = sums->pictures > 0 ? sums->pictures : 1;
    bench_set_count(entry.figures, "splats", sums->splats / pictures);
    bench_set_count(entry.figures, "triangles", sums->triangles / pictures);
}

static stp_result run_series(quality_run* run, const char* model, const char* series, bool limit,
                             uint32_t directions, json_t* results)
{
    const stp_store_directory* directory = stp_store_get_directory(run->store);
    const stp_store_node* root = &directory->nodes[directory->root];
    stp_surfels surfels;
    stp_result result = STP_OK;
    if (limit) {
        result = stp_store_get_surfels(run->store, root->surfels, &surfels);
    }
    quality_sums sums = {0};
    for (uint32_t i = 0; result == STP_OK && i < directions; ++i) {
        char name[16];
        snprintf(name, sizeof(name), "d%u", i);
        stp_view view = {.width = run->width, .height = run->height};
        stp_camera_frame(name, &root->bounds, &view);
        if (limit) {
            move_to_limit(&surfels, &root->bounds, run->splat_size, &view);
        }
        result = compare_view(run, &view, i, &sums);
    }
    if (result == STP_OK) {
        report_series(results, model, series, run, &sums);
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
    uint32_t directions = quick ? QUICK_DIRECTION_COUNT : DIRECTION_COUNT;
    result = run_series(run, model, "framed", false, directions, results);
    if (result == STP_OK && directory->nodes[directory->root].surfels != STP_STORE_NONE) {
        result = run_series(run, model, "limit", true, directions, results);
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

static int run_quality(const bench_options* options, json_t* results)
{
    const char* model = options->model != NULL ? options->model : DEFAULT_MODEL;
    char folder[] = "/tmp/stipple-quality-XXXXXX", path[64];
    if (mkdtemp(folder) == NULL) {
        return tool_error("bench quality: a temporary folder cannot be made");
    }
    snprintf(path, sizeof(path), "%s/model.stip", folder);
    stp_context* context = tool_context_create(0, 0, "none");
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (context != NULL) {
        quality_run run = {.context = context,
                           .width = 1920,
                           .height = 1080,
                           .splat_size = (float)options->splat_size};
        if (options->quick) {
            run.width = 320;
            run.height = 180;
        }
        const char* ending = strrchr(model, '.');
        bool is_built = ending != NULL && strcmp(ending, ".stip") == 0;
        stp_build_desc desc = {.inputs = &model, .input_count = 1, .output = path};
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
    .summary = "splats against the original triangles, from 26 directions",
    .run = run_quality,
};
