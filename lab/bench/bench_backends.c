// SPDX-License-Identifier: MIT
//
// Benchmark `backends`: similarity of the CPU and OpenGL pictures of a scene's views, at several
// splat sizes and with options that change pictures, with point splats and with compute shaders;
// and, at three sizes, similarity of both to the original triangles. --markdown writes a table row
// per view.
#include "draw/draw_gl.h"
#include "lab/bench/bench.h"
#include "lab/measure/measured_views.h"
#include "program/drawing/frame.h"
#include "program/files/scene_file.h"
#include "program/measure/image_compare.h"
#include "select/camera.h"
#include "select/sections.h"
#include "select/visibility.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { QUICK_VIEWS = 1, ACCUMULATED = 5, WAYS = 2 };
static const uint32_t default_size[2] = {640, 360}, quick_size[2] = {160, 90};

/// What changes a picture.
typedef struct picture_case {
    const char* name;
    float splat_size;
    bool fovea, section, ghosts, all_ghosts, originals, stereo, accumulate, reference;
    stp_draw_style style;
} picture_case;

static const picture_case cases[] = {
    {.name = "size 1", .splat_size = 1.0f, .reference = true},
    {.name = "size 2", .splat_size = 2.0f, .reference = true},
    {.name = "size 4", .splat_size = 4.0f, .reference = true},
    {.name = "fovea", .splat_size = 1.0f, .fovea = true},
    {.name = "section", .splat_size = 2.0f, .section = true},
    {.name = "ghosts", .splat_size = 2.0f, .ghosts = true},
    {.name = "all ghosts", .splat_size = 4.0f, .all_ghosts = true},
    {.name = "ghosts of originals", .splat_size = 1.0f, .all_ghosts = true, .originals = true},
    {.name = "eye-dome", .splat_size = 2.0f, .style = {.eye_dome = 1.0f}},
    {.name = "occlusion", .splat_size = 2.0f, .style = {.ambient_occlusion = 0.1f}},
    {.name = "pixel filter", .splat_size = 2.0f, .style = {.pixel_filter = true}},
    {.name = "accumulated", .splat_size = 2.0f, .accumulate = true},
    {.name = "two eyes", .splat_size = 2.0f, .stereo = true},
    {.name = "ewa", .splat_size = 4.0f, .style = {.filter = STP_FILTER_EWA}},
    {.name = "ewa", .splat_size = 8.0f, .style = {.filter = STP_FILTER_EWA}},
    {.name = "blend", .splat_size = 4.0f, .style = {.filter = STP_FILTER_BLEND}},
    {.name = "blend", .splat_size = 8.0f, .style = {.filter = STP_FILTER_BLEND}},
};
enum { CASES = sizeof(cases) / sizeof(cases[0]) };
static const stp_gl_splats ways[WAYS] = {STP_GL_SPLATS_POINTS, STP_GL_SPLATS_COMPUTE};
static const char* const way_names[WAYS] = {"points", "compute"};

typedef struct backends_bench {
    stp_context* context;
    stp_store* store;
    frame_maker cpu, gl;
    stp_visibility *some, *all; ///< ghosts
    stp_image reference, processor, opengl;
    const char* model;
    const bench_options* options;
    json_t* results;
    FILE* table;    ///< NULL: none is wanted
    double minimum; ///< SSIM of both pictures, so far
} backends_bench;

/// Makes ghosts of the root's children: every second child, or all.
static stp_result make_ghosts(backends_bench* b)
{
    const stp_store_directory* d = stp_store_get_directory(b->store);
    stp_result result = stp_visibility_create(b->context, b->store, &b->some);
    result = result == STP_OK ? stp_visibility_create(b->context, b->store, &b->all) : result;
    if (result != STP_OK || d->root == STP_STORE_NONE) {
        return result;
    }
    stp_visibility_reset(b->all, STP_SHOW_GHOST);
    const stp_store_node* root = &d->nodes[d->root];
    for (uint32_t i = 0; i < root->edge_count && result == STP_OK; i += 2) {
        const stp_store_edge* edge = &d->edges[root->first_edge + i];
        stp_placed_node placed = {edge->node, edge->transform};
        result = stp_visibility_set(b->some, &placed, STP_SHOW_GHOST);
    }
    return result;
}

/// Options of a case. The section passes through the target and removes the left side.
static void set_options(const backends_bench* b, const picture_case* c, stp_view* view,
                        stp_quality* quality)
{
    const double unit = stp_store_get_directory(b->store)->unit_metres;
    *quality = (stp_quality){.splat_size = c->splat_size, .reference = c->originals};
    if (c->fovea) {
        quality->fovea = (stp_fovea){.count = 2, .zones = {{0.2f, 1.0f}, {0.8f, 6.0f}}};
    }
    if (c->section) {
        stp_vec3d left = stp_normalized(stp_crossd(view->up, stp_subd(view->target, view->eye)));
        (void)stp_sections_add_plane(&view->sections, view->target, left);
    }
    quality->visibility = c->ghosts ? b->some : c->all_ghosts ? b->all : NULL;
    view->eye_distance = c->stereo ? 0.064 / (unit > 0.0 ? unit : 1.0) : 0.0;
}

static stp_result draw(frame_maker* maker, const picture_case* c, const stp_view* view,
                       const stp_quality* quality, stp_image* image, frame_figures* figures)
{
    maker->style = c->style;
    if (!c->accumulate) {
        return frame_draw(maker, view, quality, image, figures);
    }
    stp_view other = *view; // another view restarts the accumulation
    other.fov_degrees *= 0.9;
    stp_result result = frame_accumulate(maker, &other, quality, ACCUMULATED, image);
    *figures = (frame_figures){.cost.splat_size = c->splat_size};
    for (int i = 0; i < ACCUMULATED && result == STP_OK; ++i) {
        result = frame_accumulate(maker, view, quality, ACCUMULATED, image);
    }
    return result;
}

static stp_result alike(backends_bench* b, const stp_image* one, const stp_image* other,
                        double* ssim)
{
    stp_image_quality q;
    stp_result result = stp_image_compare(b->context, one, other, NULL, NULL, &q);
    *ssim = result == STP_OK ? q.ssim : 0.0;
    return result;
}

/// Pixels with a channel that differs by more than six of 255 levels, per ten thousand pixels.
static double count_different(const stp_image* one, const stp_image* other)
{
    size_t count = (size_t)one->width * one->height, different = 0;
    assert(one->width == other->width && one->height == other->height && count > 0);
    for (size_t i = 0; i < count; ++i) {
        bool differs = false;
        for (size_t k = 4 * i; k < 4 * i + 4; ++k) {
            differs = differs || abs((int)one->pixels[k] - (int)other->pixels[k]) > 6;
        }
        different += differs ? 1 : 0;
    }
    return 1e4 * (double)different / (double)count;
}

static stp_result compare_way(backends_bench* b, const picture_case* c, const char* name,
                              const stp_view* view, int way, double own)
{
    stp_quality quality;
    stp_view seen = *view;
    frame_figures figures;
    double same = 0.0, likeness = 0.0;
    set_options(b, c, &seen, &quality);
    frame_maker_use_splats(&b->gl, (int)ways[way]);
    stp_result result = draw(&b->gl, c, &seen, &quality, &b->opengl, &figures);
    result = result == STP_OK ? alike(b, &b->processor, &b->opengl, &same) : result;
    if (result == STP_OK && c->reference) {
        result = alike(b, &b->reference, &b->opengl, &likeness);
    }
    if (result != STP_OK) {
        return result;
    }
    bench_entry e = bench_result(b->results, "backends");
    bench_set_text(e.params, "model", b->model);
    bench_set_text(e.params, "view", name);
    bench_set_text(e.params, "case", c->name);
    bench_set_text(e.params, "way", way_names[way]);
    bench_set_number(e.params, "splat_size", (double)c->splat_size);
    bench_set_number(e.figures, "ssim", same);
    bench_set_number(e.figures, "different_per_10k", count_different(&b->processor, &b->opengl));
    bench_set_count(e.figures, "draw_calls", stp_draw_gl_get_stats(b->gl.renderer).draw_calls);
    if (c->reference) {
        bench_set_number(e.figures, "ssim_reference_cpu", own);
        bench_set_number(e.figures, "ssim_reference_gl", likeness);
    }
    b->minimum = fmin(b->minimum, same);
    if (b->table != NULL) {
        fprintf(b->table, way == 0 ? " %.4f" : same < 0.99995 ? " / %.4f" : " / 1", same);
    }
    return STP_OK;
}

static stp_result compare_case(backends_bench* b, const picture_case* c, const char* name,
                               const stp_view* view)
{
    stp_quality quality;
    stp_view seen = *view;
    frame_figures figures;
    double own = 0.0;
    set_options(b, c, &seen, &quality);
    stp_result result = draw(&b->cpu, c, &seen, &quality, &b->processor, &figures);
    if (result == STP_OK && c->reference) {
        result = alike(b, &b->reference, &b->processor, &own);
    }
    if (b->table != NULL) {
        fprintf(b->table, " |");
    }
    for (int way = 0; way < WAYS && result == STP_OK; ++way) {
        if (way == 0 || c->style.filter != STP_FILTER_BLEND) { // blending always uses point splats
            result = compare_way(b, c, name, view, way, own);
        }
    }
    if (result == STP_ERROR_OUT_OF_MEMORY) { // cases that exceed OpenGL's limits are reported and
                                             // skipped
        fprintf(stderr, "bench backends: %s, %s is skipped\n", name, c->name);
        if (b->table != NULL) {
            fprintf(b->table, " -");
        }
        return STP_OK;
    }
    return result;
}

static stp_result compare_view(backends_bench* b, const char* name)
{
    stp_view view = {.width = b->processor.width, .height = b->processor.height};
    stp_quality quality = {.splat_size = 1.0f, .reference = true};
    frame_figures figures;
    if (!measured_view(b->store, name, &view)) {
        return STP_OK;
    }
    view.fov_degrees = view.fov_degrees > 0.0 ? view.fov_degrees : STP_CAMERA_PLACED_FOV;
    b->cpu.style = (stp_draw_style){0};
    stp_result result = frame_draw(&b->cpu, &view, &quality, &b->reference, &figures);
    if (b->table != NULL) {
        fprintf(b->table, "| %s | %s", b->model, name);
    }
    for (int i = 0; i < CASES && result == STP_OK; ++i) {
        result = compare_case(b, &cases[i], name, &view);
    }
    if (b->table != NULL) {
        fprintf(b->table, " |\n");
    }
    return result;
}

static void write_head(const backends_bench* b)
{
    fprintf(b->table, "| scene | view");
    for (int i = 0; i < CASES; ++i) {
        fprintf(b->table, " | %s%s", cases[i].name, cases[i].splat_size > 4.0f ? ", size 8" : "");
    }
    fprintf(b->table, " |\n|---|---");
    for (int i = 0; i < CASES; ++i) {
        fprintf(b->table, "|---:");
    }
    fprintf(b->table, "|\n");
}

static stp_result measure(backends_bench* b)
{
    const stp_store_directory* d = stp_store_get_directory(b->store);
    uint32_t maximum = b->options->quick ? QUICK_VIEWS : d->view_count, compared = 0;
    stp_result result = make_ghosts(b);
    for (uint32_t i = 0; i < d->view_count && compared < maximum && result == STP_OK; ++i) {
        if (d->views[i].name != NULL) {
            result = compare_view(b, d->views[i].name);
            compared += 1;
        }
    }
    if (compared == 0 && result == STP_OK) {
        result = compare_view(b, "iso");
    }
    return result;
}

static stp_result open_all(backends_bench* b)
{
    const stp_draw_style plain = {0};
    const uint32_t* size = b->options->size[0] > 0 ? b->options->size
                           : b->options->quick     ? quick_size
                                                   : default_size;
    stp_image* images[] = {&b->reference, &b->processor, &b->opengl};
    for (int i = 0; i < 3; ++i) {
        if (!frame_image_create(b->context, size[0], size[1], images[i])) {
            return STP_ERROR_OUT_OF_MEMORY;
        }
    }
    stp_result result = tool_open_scene(b->context, b->model, &b->store);
    if (result == STP_OK) {
        result = frame_maker_create(b->context, b->store, &plain, &b->cpu);
    }
    if (result == STP_OK) {
        result = frame_maker_create_on(b->context, b->store, &plain, FRAME_BACKEND_GL, &b->gl);
    }
    if (result == STP_OK && b->options->markdown != NULL) {
        b->table = fopen(b->options->markdown, "w");
        if (b->table == NULL) {
            (void)tool_error("%s: cannot be written", b->options->markdown);
            return STP_ERROR_IO;
        }
        write_head(b);
    }
    return result;
}

static void close_all(backends_bench* b)
{
    frame_maker_destroy(&b->gl);
    frame_maker_destroy(&b->cpu);
    stp_visibility_destroy(b->some);
    stp_visibility_destroy(b->all);
    stp_free(b->context, b->reference.pixels);
    stp_free(b->context, b->processor.pixels);
    stp_free(b->context, b->opengl.pixels);
    if (b->store != NULL) {
        stp_store_close(b->store);
    }
    stp_context_destroy(b->context);
}

static int run_backends(const bench_options* options, json_t* results)
{
    stp_headless there = {0};
    backends_bench b = {.context = tool_context_create(options->threads, 0, "none"),
                        .model = options->model != NULL ? options->model : "scene:boxes",
                        .options = options,
                        .results = results,
                        .minimum = 1.0};
    if (b.context == NULL) {
        return tool_error("bench backends: out of memory");
    }
    const char* fault = stp_headless_create(&(stp_headless_desc){0}, &there);
    if (fault != NULL) { // others can be measured
        fprintf(stderr, "bench backends: %s; nothing is compared\n", fault);
        stp_context_destroy(b.context);
        return 0;
    }
    stp_headless_destroy(&there);
    stp_result result = open_all(&b);
    result = result == STP_OK ? measure(&b) : result;
    if (b.table != NULL && fclose(b.table) != 0) {
        result = STP_ERROR_IO;
    }
    if (result == STP_OK) {
        bench_entry e = bench_result(results, "backends least");
        bench_set_number(e.figures, "ssim", b.minimum);
    }
    close_all(&b);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_backends = {
    .name = "backends",
    .summary = "similarity of CPU and OpenGL pictures, view by view",
    .run = run_backends,
};
