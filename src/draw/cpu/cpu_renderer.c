// SPDX-License-Identifier: MIT
// Draws a frame, and owns the memory kept between frames.
#include "base/core/clock.h"
#include "base/math/color.h"
#include "draw/cpu/effects.h"
#include "draw/cpu/layers.h"
#include "draw/cpu/passes.h"
#include "draw/cpu/pixel_filter.h"
#include "draw/placement.h"

#include <assert.h>
#include <string.h>

enum { SUPERSAMPLE_LIMIT = 64, SCRATCH_BLOCK = 1 << 20 };

static void destroy(stp_renderer* renderer)
{
    stp_cpu_renderer* r = (stp_cpu_renderer*)renderer;
    stp_context* context = renderer->context;
    for (uint32_t i = 0; r->workers != NULL && i < r->team.threads; ++i) {
        stp_free(context, r->workers[i].memory);
        stp_arena_destroy(&r->workers[i].scratch);
    }
    for (int i = 0; i < STP_EYES_MAX; ++i) {
        stp_depth_pyramid_destroy(context, &r->pyramids[i]);
        stp_free(context, r->eyes[i].late);
        stp_free(context, r->eyes[i].late_tasks);
        stp_free(context, r->eyes[i].windows);
    }
    stp_cpu_destroy_textures(r);
    stp_cpu_destroy_shading(r);
    stp_cpu_destroy_effects(r);
    stp_cpu_destroy_pixel_filter(r);
    stp_cpu_destroy_accumulation(r);
    stp_cpu_destroy_blend(r);
    stp_caps_destroy(r->caps);
    stp_cpu_destroy_layers(r);
    stp_free(context, r->layers.alive);
    stp_free(context, r->layers.touched);
    stp_free(context, r->workers);
    stp_free(context, r->depths);
    stp_free(context, r->all_sums);
    stp_free(context, r->eye_pixels);
    stp_free(context, r->items);
    stp_free(context, r);
}

static const float* get_depth(const stp_renderer* renderer)
{
    return ((const stp_cpu_renderer*)renderer)->depths;
}

void stp_cpu_empty_pixels(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        for (size_t k = 0; r->workers[i].memory != NULL && k < r->pixel_count; ++k) {
            r->workers[i].memory[k] = STP_RASTER_EMPTY;
        }
        r->workers[i].drew = false;
    }
}

/// Allocates the pixels of all eyes. Buffers are empty between frames.
static stp_result make_buffers(stp_cpu_renderer* r, size_t needed)
{
    stp_context* context = r->base.context;
    if (needed <= r->pixel_count) {
        return STP_OK;
    }
    r->pixel_count = 0;
    stp_free(context, r->depths);
    r->depths = STP_NEW_ZEROED(context, float, needed);
    bool enough = r->depths != NULL;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        stp_free(context, r->workers[i].memory);
        r->workers[i].memory = STP_NEW_ARRAY(context, uint64_t, needed);
        enough = enough && r->workers[i].memory != NULL;
    }
    if (!enough) {
        return stp_fail_memory(context);
    }
    r->pixel_count = needed;
    stp_cpu_empty_pixels(r);
    return STP_OK;
}

/// Allocates memory for a frame.
static stp_result make_room(stp_cpu_renderer* r, bool with_sums)
{
    stp_context* context = r->base.context;
    size_t needed = (size_t)r->width * r->height * r->eye_count;
    stp_result result = make_buffers(r, needed);
    if (with_sums && needed > r->sum_count && result == STP_OK) {
        r->sum_count = 0;
        stp_free(context, r->all_sums);
        r->all_sums = STP_NEW_ARRAY(context, float, 4 * needed);
        result = r->all_sums != NULL ? STP_OK : stp_fail_memory(context);
        r->sum_count = result == STP_OK ? needed : 0;
    }
    if (r->eye_count > 1 && needed > r->eye_pixel_count && result == STP_OK) {
        r->eye_pixel_count = 0;
        stp_free(context, r->eye_pixels);
        r->eye_pixels = STP_NEW_ARRAY(context, uint8_t, 4 * needed);
        result = r->eye_pixels != NULL ? STP_OK : stp_fail_memory(context);
        r->eye_pixel_count = result == STP_OK ? needed : 0;
    }
    return result;
}

/// Sets up the eyes of a view, and the area of each.
static stp_result place_eyes(stp_cpu_renderer* r, const stp_view* view, stp_image* image)
{
    r->eye_count = stp_view_eye_count(view);
    assert(r->eye_count > 0 && r->eye_count <= STP_EYES_MAX);
    r->placed = NULL;
    stp_result result = stp_renderer_check_view(&r->base, view, image);
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < r->eye_count; ++i) {
        stp_view one = stp_view_of_eye(view, i);
        (void)stp_view_frame_make(&one, &r->eyes[i].frame); // was checked
        r->eyes[i].picture = (stp_image){one.width, one.height, image->pixels};
    }
    r->width = r->eyes[0].picture.width;
    r->height = r->eyes[0].picture.height;
    return STP_OK;
}

/// Whether the bytes of each sample are post-processed.
static bool works_on_bytes(const stp_cpu_renderer* r, const stp_draw_style* style,
                           const stp_view* view)
{
    bool caps = style->caps && view->sections.count > 0;
    return stp_cpu_has_effects(style) || stp_cpu_has_filter(style) || caps ||
           stp_cpu_wants_layers(r, style);
}

static stp_result begin_frame(stp_cpu_renderer* r, const stp_view* view, const stp_draw_list* list,
                              const stp_draw_style* style, stp_image* image, uint32_t first,
                              bool summed)
{
    stp_result result = place_eyes(r, view, image);
    if (result != STP_OK) {
        return result;
    }
    r->style = style;
    r->sections = &view->sections;
    r->splat_size = list->mixes ? stp_max(list->splat_size, 1.0f) : 0.0f;
    r->mesh_depth = stp_placement_mesh_depth(list);
    result = make_room(r, style->supersample > 1 && summed);
    result = result == STP_OK && !summed ? stp_cpu_make_accumulation(r, first) : result;
    for (uint32_t i = 0; i < r->eye_count && r->eye_count > 1 && result == STP_OK; ++i) {
        r->eyes[i].picture.pixels = r->eye_pixels + 4 * (size_t)i * r->width * r->height;
    }
    if (result == STP_OK) {
        stp_cpu_begin_layers(r);
    }
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].fragments = r->workers[i].covered = 0;
        r->workers[i].splats = r->workers[i].triangles = 0;
        r->workers[i].failed = false;
    }
    return result;
}

/// Draws samples [first, end) of side * side.
static stp_result draw_part(stp_cpu_renderer* r, const stp_view* view, const stp_draw_list* list,
                            const stp_draw_style* style, stp_image* image, uint32_t first,
                            uint32_t end, stp_draw_stats* stats)
{
    uint32_t side = style->supersample > 1 ? style->supersample : 1, all = side * side;
    *stats = (stp_draw_stats){0};
    if (side > SUPERSAMPLE_LIMIT) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT,
                        "style: at most %d x %d samples per pixel", SUPERSAMPLE_LIMIT,
                        SUPERSAMPLE_LIMIT);
    }
    assert(first <= end && end <= all && "samples of the grid");
    bool summed = end - first == all && (all == 1 || !works_on_bytes(r, style, view));
    r->team.stopped = r->base.stop;
    stp_result result = begin_frame(r, view, list, style, image, first, summed);
    if (result == STP_OK) {
        result = summed ? stp_cpu_draw_summed(r, list, side, stats)
                        : stp_cpu_draw_accumulated(r, list, side, first, end, stats);
    }
    assert((summed || result != STP_OK || r->accumulation.frames == end) &&
           "the sums hold the samples before `first` and the new ones");
    if (result == STP_OK && r->eye_count > 1) {
        stp_cpu_join_eyes(r, image);
    }
    result = result == STP_OK && stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : result;
    if (result == STP_ERROR_CANCELLED) {
        r->accumulation.frames = 0; // sums may be incomplete
    }
    stats->listed_splats = r->eye_count * list->splat_count;
    stats->listed_triangles = r->eye_count * (list->triangle_count + r->large_count);
    stats->draw_calls = r->eye_count * (uint32_t)list->count;
    stats->samples = summed ? all : r->accumulation.frames;
    stats->layers = r->layers.stage != CPU_LAYERS_NONE ? r->layers.count : 0;
    uint32_t pictures = end > first ? end - first : 1;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        stats->fragments += r->workers[i].fragments / pictures;
        stats->splats += r->workers[i].splats;
        stats->triangles += r->workers[i].triangles;
        stats->covered_pixels += r->workers[i].covered;
    }
    if (end > first) { // else nothing is left to draw: those of the last pass
        r->drawn_splats = stats->splats / pictures;
        r->drawn_triangles = stats->triangles / pictures;
    }
    stats->splats = r->drawn_splats;
    stats->triangles = r->drawn_triangles;
    r->image = NULL;
    r->style = NULL;
    r->pixel_filter.kinds = NULL; // a frame that failed or was stopped may have left it
    return result;
}

static stp_result draw(stp_renderer* renderer, const stp_view* view, const stp_draw_list* list,
                       const stp_draw_style* style, stp_image* image, stp_draw_stats* stats)
{
    uint32_t side = style->supersample > 1 ? style->supersample : 1;
    side = side <= SUPERSAMPLE_LIMIT ? side : SUPERSAMPLE_LIMIT + 1;
    stp_cpu_renderer* r = (stp_cpu_renderer*)renderer;
    stp_result result = draw_part(r, view, list, style, image, 0, side * side, stats);
    if (side > 1 && works_on_bytes(r, style, view)) {
        r->accumulation.frames = 0; // its sums were consumed
    }
    return result;
}

/// Whether occlusion culling may be used. Radii are unknown with a splat count, with fixed-size
/// points, and if splats are drawn larger than selected; parallel projection has no pyramids.
static bool may_occlude(const stp_view* view, const stp_quality* quality,
                        const stp_draw_style* style)
{
    return quality->splat_count == 0 && !(style->splat_scale > 1.0f) &&
           style->point_sizing == STP_POINTS_ADAPTIVE && !(view->ortho_height > 0.0);
}

static stp_result accumulate(stp_renderer* renderer, const stp_view* view,
                             const stp_quality* quality, const stp_draw_style* style,
                             stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_cpu_renderer* r = (stp_cpu_renderer*)renderer;
    stp_draw_style finer = *style;
    finer.supersample = style->supersample > 2 ? style->supersample : 2;
    stp_cpu_two_passes passes = {
        .view = view, .quality = *quality, .list = list, .hides_nodes = !stp_cpu_has_filter(style)};
    double start = stp_clock_ms();
    *stats = (stp_draw_stats){0};
    passes.quality.occlusion = NULL; // every visible input decides whether the sums continue
    passes.quality.limit = (stp_work_limit){0};
    stp_result result = stp_select(renderer->context, r->store, view, &passes.quality, list);
    if (result != STP_OK) {
        return result;
    }
    stp_cpu_continue_accumulation(r, view, list, &finer);
    r->visibility = quality->visibility;
    uint32_t first = r->accumulation.frames;
    uint32_t all = finer.supersample * finer.supersample, end = first < all ? first + 1 : all;
    r->two_passes = may_occlude(view, quality, style) ? &passes : NULL;
    double select_ms = stp_clock_ms() - start;
    result = draw_part(r, view, list, &finer, image, first, end, stats);
    r->two_passes = NULL;
    r->visibility = NULL;
    stats->select_ms = select_ms + passes.select_ms;
    return result;
}

static stp_result draw_selected(stp_renderer* renderer, const stp_view* view,
                                const stp_quality* quality, const stp_draw_style* style,
                                stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_cpu_renderer* r = (stp_cpu_renderer*)renderer;
    bool occludes = may_occlude(view, quality, style);
    stp_cpu_two_passes passes = {.view = view,
                                 .quality = *quality,
                                 .list = list,
                                 .hides_nodes = occludes && !stp_cpu_has_filter(style)};
    *stats = (stp_draw_stats){0};
    r->two_passes = &passes;
    r->visibility = quality->visibility;
    stp_result result = stp_cpu_select_sample(r);
    r->two_passes = occludes ? &passes : NULL;
    if (result == STP_OK && !stp_cpu_exceeds(&passes)) {
        result = draw(renderer, view, list, style, image, stats);
    }
    if (passes.exceeds && (result == STP_OK || !stp_cpu_is_stopped(r))) {
        uint32_t eyes = stp_view_eye_count(view);
        *stats = (stp_draw_stats){.listed_splats = eyes * list->splat_count,
                                  .listed_triangles = eyes * list->triangle_count,
                                  .draw_calls = eyes * (uint32_t)list->count,
                                  .draw_ms = stats->draw_ms,
                                  .exceeds = true};
        result = STP_OK;
    }
    r->two_passes = NULL;
    r->visibility = NULL;
    stats->select_ms = passes.select_ms;
    return result;
}

stp_result stp_draw_cpu_create(stp_context* context, stp_store* store, stp_renderer** renderer)
{
    stp_cpu_renderer* r = STP_NEW_ZEROED(context, stp_cpu_renderer, 1);
    *renderer = NULL;
    if (r == NULL) {
        return stp_fail_memory(context);
    }
    r->base = (stp_renderer){.context = context,
                             .destroy = destroy,
                             .draw = draw,
                             .draw_selected = draw_selected,
                             .accumulate = accumulate,
                             .depth = get_depth};
    r->store = store;
    r->directory = stp_store_get_directory(store);
    r->layers.possible = stp_transparency_of_scene(r->directory);
    r->front_only = stp_front_only_of_shadings(r->directory, r->front_only_shadings);
    stp_transparency_of_shadings(r->directory, r->layers.of_shading);
    for (int i = 0; i < 256; ++i) {
        r->layers.depth_of_opacity[i] = stp_optical_depth((float)i * (1.0f / 255.0f));
    }
    r->layers.of_splats = memchr(r->layers.of_shading, 1, sizeof(r->layers.of_shading)) != NULL;
    r->team = stp_team_create_useful(context);
    assert(r->team.threads > 0);
    r->workers = STP_NEW_ZEROED(context, stp_cpu_worker, r->team.threads);
    r->textures = STP_NEW_ZEROED(context, stp_cpu_texture, (size_t)r->directory->texture_count + 1);
    r->asked = STP_NEW_ARRAY(context, uint32_t, (size_t)r->directory->texture_count + 1);
    if (r->workers == NULL || r->textures == NULL || r->asked == NULL) {
        destroy(&r->base);
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        stp_cpu_worker* worker = &r->workers[i];
        worker->scratch = stp_arena_create(context, SCRATCH_BLOCK);
        stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
        // any worker may need scratch memory in a later frame, which must not allocate
        if (stp_arena_alloc(&worker->scratch, SCRATCH_BLOCK / 2) == NULL) {
            destroy(&r->base);
            return stp_fail_memory(context);
        }
        stp_arena_rewind(&worker->scratch, mark);
    }
    for (int i = 0; i < 256; ++i) {
        r->decode[i] = stp_srgb8_to_linear((uint8_t)i);
    }
    for (int i = 0; i < CPU_ENCODE_SIZE; ++i) {
        r->encode[i] = stp_linear_to_srgb8(((float)i + 0.5f) / (float)CPU_ENCODE_SIZE);
    }
    if (stp_cpu_make_shade_materials(r) != STP_OK) {
        destroy(&r->base);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *renderer = &r->base;
    return STP_OK;
}
