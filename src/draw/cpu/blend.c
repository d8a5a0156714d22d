// SPDX-License-Identifier: MIT
#include "draw/cpu/passes.h"
#include "draw/cpu/shade.h"
#include "draw/placement.h"

#include <assert.h>
#include <string.h>

static stp_result make_room(stp_cpu_renderer* r)
{
    stp_cpu_blend* b = &r->blend;
    size_t needed = (size_t)r->width * r->height;
    if (needed <= b->capacity) {
        return STP_OK;
    }
    b->capacity = 0;
    stp_free(r->base.context, b->planes);
    stp_free(r->base.context, b->sums);
    b->planes = STP_NEW_ARRAY(r->base.context, stp_raster_plane, needed);
    b->sums = STP_NEW_ARRAY(r->base.context, uint64_t, 2 * needed);
    if (b->planes == NULL || b->sums == NULL) {
        return stp_fail_memory(r->base.context);
    }
    b->capacity = needed;
    return STP_OK;
}

static stp_result make_bits(stp_cpu_renderer* r)
{
    stp_cpu_blend* b = &r->blend;
    if (!STP_MAKE_ROOM(r->base.context, b->visible, b->visible_capacity, r->late_count)) {
        return stp_fail_memory(r->base.context);
    }
    memset(b->visible, 0, r->late_count * sizeof(*b->visible));
    return STP_OK;
}

static uint32_t count_blocks(uint32_t pixels, uint32_t shift)
{
    return (pixels + (1u << shift) - 1) >> shift;
}

/// Allocates blocks and windows; splats touch few of them.
static stp_result make_blocks(stp_cpu_renderer* r)
{
    stp_cpu_blend* b = &r->blend;
    b->block_shift = CPU_FIRST_SHIFT + stp_cpu_choose_level(r, &r->frame, STP_DEPTH_PYRAMID_LEVELS);
    size_t columns = count_blocks(r->width, b->block_shift);
    size_t count = columns * count_blocks(r->height, b->block_shift);
    return STP_MAKE_ROOM(r->base.context, b->blocks, b->block_capacity, 2 * count)
               ? STP_OK
               : stp_fail_memory(r->base.context);
}

/// Finds the nearest of all workers' pixels; only pixels of splats are blended.
static void find_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const stp_cpu_renderer* r = user;
    uint32_t slot = 0, last = UINT32_MAX;
    (void)worker;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        uint64_t pixel = stp_cpu_nearest_of_workers(r, at);
        r->blend.sums[2 * at] = r->blend.sums[2 * at + 1] = 0;
        r->blend.planes[at] = (stp_raster_plane){.nearness = FLT_MAX, .id = UINT32_MAX};
        if (pixel != STP_RASTER_EMPTY) {
            uint32_t id = stp_raster_id(pixel);
            const stp_cpu_item* item = &r->items[slot];
            if (id - item->first_id >= item->count) {
                slot = stp_cpu_find_item(r, id);
                item = &r->items[slot];
            }
            assert((item->kind == STP_DRAW_MESH || id - item->first_id < item->count) &&
                   "a bit per splat");
            if (item->kind != STP_DRAW_MESH) {
                r->blend.planes[at].id = id;
            }
            if (item->kind == STP_DRAW_SPLATS && id != last) {
                uint32_t index = id - item->first_id;
                _Atomic uint16_t* visible = (_Atomic uint16_t*)r->blend.visible + item->late;
                atomic_fetch_or_explicit(&visible[index / 16], (uint16_t)(1u << index % 16),
                                         memory_order_relaxed);
                last = id;
            }
        }
    }
}

stp_result stp_cpu_find_visible(stp_cpu_renderer* r)
{
    stp_result result = make_room(r);
    result = result == STP_OK ? make_bits(r) : result;
    result = result == STP_OK ? make_blocks(r) : result;
    if (result == STP_OK) {
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, find_rows, r);
    }
    return result == STP_OK && stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : result;
}

typedef struct splat_lighter {
    const stp_cpu_renderer* r;
    uint32_t slot; ///< index of the item
    const stp_cpu_shade_kernels* kernels;
    stp_cpu_shade_scene scene;
    stp_cpu_shade_lanes lanes;
    _Alignas(64) stp_cpu_shade_surface surfaces[SHADE_LANES_MAX];
} splat_lighter;

/// Lights splats like pixels at their centres.
static void light_splats(void* user, uint32_t first, uint32_t count, const float* x, const float* y,
                         uint32_t (*out)[3])
{
    splat_lighter* s = user;
    assert(count > 0 && count <= SHADE_LANES_MAX);
    for (uint32_t i = 0; i < SHADE_LANES_MAX; ++i) {
        uint32_t there = i < count ? i : 0;
        s->lanes.surface[i] = there;
        s->lanes.x[i] = x[there];
        s->lanes.y[i] = y[there];
        if (i < count) {
            stp_cpu_make_splat_surface(s->r, s->slot, first + i, &s->surfaces[i]);
        }
    }
    s->lanes.count = count;
    s->lanes.wants_linear = true;
    s->kernels->light(&s->scene, s->surfaces, &s->lanes);
    for (uint32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            float scaled = s->lanes.linear[k][i] * (float)STP_BLEND_COLORS;
            bool inside = scaled > 0.0f && scaled < (float)(STP_BLEND_COLORS - 1);
            out[i][k] = inside ? (uint32_t)scaled : scaled > 0.0f ? STP_BLEND_COLORS - 1 : 0;
        }
    }
}

/// Computes the minimum nearness of planes in rows of blocks. Pixels without a splat get the
/// maximum nearness, so nothing is added there.
static void find_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    const stp_cpu_renderer* r = user;
    uint32_t shift = r->blend.block_shift, columns = count_blocks(r->width, shift);
    (void)worker;
    for (size_t row = begin; row < end; ++row) {
        float* blocks = r->blend.blocks + row * columns;
        size_t last = (row + 1) << shift;
        last = last < r->height ? last : r->height;
        for (uint32_t x = 0; x < columns; ++x) {
            blocks[x] = FLT_MAX;
        }
        for (size_t y = row << shift; y < last; ++y) {
            const stp_raster_plane* planes = r->blend.planes + y * r->width;
            for (uint32_t x = 0; x < r->width; ++x) {
                float* block = &blocks[x >> shift];
                *block = planes[x].nearness < *block ? planes[x].nearness : *block;
            }
        }
    }
}

/// Occlusion test: splats behind all planes they overlap contribute nothing.
static void find_windows(stp_cpu_renderer* r)
{
    uint32_t columns = count_blocks(r->width, r->blend.block_shift);
    uint32_t rows = count_blocks(r->height, r->blend.block_shift);
    stp_team_run(&r->team, rows, 1, find_blocks, r);
    stp_raster_make_windows(r->blend.blocks, columns, rows,
                            r->blend.blocks + (size_t)columns * rows);
}

static stp_raster_occluder make_occluder(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    static const float nowhere[3] = {0.0f, 0.0f, 0.0f};
    uint32_t shift = r->blend.block_shift, columns = count_blocks(r->width, shift);
    size_t count = (size_t)columns * count_blocks(r->height, shift);
    stp_view_frame frame = r->frame;
    double rows[3][4];
    frame.center_x += r->shift_x;
    frame.center_y += r->shift_y;
    stp_placement_view_rows(&frame, &item->draw->transform, nowhere, rows);
    stp_raster_occluder occluder =
        stp_cpu_make_occluder(&frame, (const double(*)[4])rows, &item->draw->transform,
                              r->blend.blocks + count, columns, shift);
    occluder.apart = STP_BLEND_AWAY;
    return occluder;
}

void stp_cpu_blend_range(const stp_cpu_renderer* r, const stp_cpu_item* item,
                         const stp_raster_splats* splats)
{
    stp_raster_blend blend = {.width = r->width,
                              .height = r->height,
                              .planes = r->blend.planes,
                              .first_id = item->first_id};
    assert(r->blend.stage != CPU_BLEND_NONE && item->kind != STP_DRAW_MESH);
    stp_raster_splats asked = *splats;
    if (r->blend.stage == CPU_BLEND_PLANES) {
        asked.wanted = item->kind == STP_DRAW_SPLATS ? r->blend.visible + item->late : NULL;
        stp_raster_find_planes(&blend, &item->camera, &asked);
        return;
    }
    stp_raster_occluder occluder;
    if (item->kind == STP_DRAW_SPLATS && !r->frame.parallel) {
        occluder = make_occluder(r, item);
        asked.occluder = &occluder;
    }
    splat_lighter lighter;
    lighter.r = r;
    lighter.slot = (uint32_t)(item - r->items);
    lighter.kernels = stp_cpu_choose_shade_kernels();
    lighter.scene = stp_cpu_make_shade_scene(r);
    blend.sums = (_Atomic uint64_t*)r->blend.sums;
    blend.texture = r->style->filter == STP_FILTER_TEXTURED ? &r->blend.texture : NULL;
    blend.colors = light_splats;
    blend.user = &lighter;
    stp_raster_blend_splats(&blend, &item->camera, &asked);
}

static void mix_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const stp_cpu_renderer* r = user;
    (void)worker;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        uint64_t first = r->blend.sums[2 * at], second = r->blend.sums[2 * at + 1];
        uint32_t weight = (uint32_t)(second >> 32);
        if (weight == 0 || weight > STP_BLEND_LIMIT) {
            continue; // nothing was added, or the sums overflowed
        }
        const uint32_t sums[3] = {(uint32_t)first, (uint32_t)(first >> 32), (uint32_t)second};
        for (int k = 0; k < 3; ++k) {
            assert(sums[k] / weight < CPU_ENCODE_SIZE && "a mean of colours is a colour");
            r->image->pixels[4 * at + (size_t)k] = r->encode[sums[k] / weight];
        }
    }
}

static void copy_plane_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const stp_cpu_renderer* r = user;
    (void)worker;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        const stp_raster_plane* plane = &r->blend.planes[at];
        if (plane->id != UINT32_MAX && plane->nearness < FLT_MAX) {
            r->depth[at] = plane->nearness;
        }
    }
}

stp_result stp_cpu_find_plane_depths(stp_cpu_renderer* r)
{
    assert(r->blend.stage == CPU_BLEND_NONE && r->blend.capacity >= (size_t)r->width * r->height);
    r->blend.stage = CPU_BLEND_PLANES;
    stp_result result = stp_cpu_draw_items(r, 0);
    r->blend.stage = CPU_BLEND_NONE;
    if (result == STP_OK) {
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, copy_plane_rows, r);
    }
    return result;
}

stp_result stp_cpu_blend_splats(stp_cpu_renderer* r)
{
    assert(r->blend.stage == CPU_BLEND_NONE && r->blend.capacity >= (size_t)r->width * r->height);
    r->blend.stage = CPU_BLEND_PLANES;
    stp_result result = stp_cpu_draw_items(r, 0);
    if (result == STP_OK) {
        find_windows(r);
    }
    if (r->style->filter == STP_FILTER_TEXTURED) {
        const stp_splat_texture* texture = r->style->splat_texture;
        r->blend.texture = texture != NULL ? *texture : stp_splat_texture_gaussian();
    }
    r->blend.stage = CPU_BLEND_SPLATS;
    result = result == STP_OK ? stp_cpu_draw_items(r, 0) : result;
    r->blend.stage = CPU_BLEND_NONE;
    if (result == STP_OK) {
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, mix_rows, r);
    }
    return result;
}

void stp_cpu_destroy_blend(stp_cpu_renderer* r)
{
    stp_free(r->base.context, r->blend.planes);
    stp_free(r->base.context, r->blend.sums);
    stp_free(r->base.context, r->blend.visible);
    stp_free(r->base.context, r->blend.blocks);
}
