// SPDX-License-Identifier: MIT
//
// The splat filter, compiled by every variant for its own instruction set. Plain loops set up
// sixteen splats at a time, as in splats_kernel.h. All variants give the same bits.
#pragma once

#include "raster/splats_blend.h"
#include "raster/splats_hidden.h"

#include <assert.h>

// Minimum cosine between a pixel's plane and a splat's. A larger angle means another surface: walls
// do not blend into the ground they stand on.
#define ALIKE 0.4f

/// The batch being added.
typedef struct blend_batch {
    const stp_raster_blend* blend;
    const stp_splat_frame* frame;
    splat_batch t;
    uint32_t first, count;
    bool adds;          ///< else it stores planes
    float tiny_opacity; ///< opacity of a one-pixel splat
    bool has_colors;
    uint32_t colors[SPLAT_BATCH][3];
} blend_batch;

/// Adds one fragment. The first fragment of a batch loads its colours.
static void add_fragment(blend_batch* b, uint32_t i, size_t at, uint32_t weight)
{
    const stp_raster_blend* blend = b->blend;
    if (!b->has_colors) {
        blend->colors(blend->user, b->first, b->count, b->t.sx, b->t.sy, b->colors);
        b->has_colors = true;
    }
    const uint32_t* color = b->colors[i];
    assert(weight > 0 && weight <= STP_BLEND_WEIGHT);
    assert(color[0] < STP_BLEND_COLORS && color[1] < STP_BLEND_COLORS &&
           color[2] < STP_BLEND_COLORS && "sums within STP_BLEND_LIMIT do not overflow");
    uint64_t first = (uint64_t)(weight * color[1]) << 32 | weight * color[0];
    uint64_t second = (uint64_t)weight << 32 | weight * color[2];
    atomic_fetch_add_explicit(blend->sums + 2 * at, first, memory_order_relaxed);
    atomic_fetch_add_explicit(blend->sums + 2 * at + 1, second, memory_order_relaxed);
}

static bool has_fragment(const blend_batch* b, uint32_t i, int32_t x, int32_t y)
{
    uint32_t index = b->first + i, part = (uint32_t)b->t.part[i];
    if (b->t.kind[i] == SPLAT_PIXEL && (b->t.clips >> i & 1u) != 0) {
        part = splat_clip_share(SPLAT_CLIP + b->t.code[i]);
    }
    uint32_t coverage = splat_coverage(b->frame->splats, part, b->t.halvings[i]);
    return coverage >= 255 ||
           splat_has_fragment(coverage, b->frame->seed + index, x - b->t.cx[i], y - b->t.cy[i]);
}

/// Step of nearness that equals a pixel's size in depth.
static float find_side(const stp_splat_frame* f, float nearness)
{
    return fabsf(nearness * f->slope_factor + f->slope_constant);
}

/// Normal of a plane with these slopes, hit by a ray (x, y, 1); not normalised.
typedef struct slope_normal {
    float x, y, z;
} slope_normal;

static slope_normal find_normal(float right, float down, float x, float y)
{
    return (slope_normal){right, down, 1.0f - (right * x + down * y)};
}

static bool is_turned(slope_normal a, slope_normal b)
{
    float both = a.x * b.x + a.y * b.y + a.z * b.z;
    float squares = (a.x * a.x + a.y * a.y + a.z * a.z) * (b.x * b.x + b.y * b.y + b.z * b.z);
    return both < 0.0f || both * both < ALIKE * ALIKE * squares; // never for planes without slopes
}

/// Adds a fragment of a disk or of a single pixel; `opacity` is 0 to 1.
static void blend_fragment(blend_batch* b, uint32_t i, int32_t x, int32_t y, float nearness,
                           float opacity)
{
    const splat_batch* t = &b->t;
    assert(x >= 0 && (uint32_t)x < b->blend->width && y >= 0 && (uint32_t)y < b->blend->height);
    size_t at = (size_t)y * b->blend->width + (size_t)x;
    stp_raster_plane* plane = &b->blend->planes[at];
    if (!b->adds && plane->id != b->blend->first_id + b->first + i) {
        return;
    }
    bool tiny = t->kind[i] == SPLAT_PIXEL;
    float side = find_side(b->frame, nearness), inverse = 1.0f / side;
    float right = tiny ? NAN : t->gx[i] * inverse, down = tiny ? NAN : t->gy[i] * inverse;
    if (!b->adds) {
        plane->nearness = nearness;
        plane->right = right;
        plane->down = down;
        return;
    }
    float maximum = side * STP_BLEND_AWAY * (tiny ? 0.5f : t->radius[i]);
    if (!(fabsf(nearness - plane->nearness) <= maximum)) {
        return;
    }
    float ray_x = ((float)x - b->frame->center_x) * b->frame->inverse_scale;
    float ray_y = ((float)y - b->frame->center_y) * b->frame->inverse_scale;
    bool turned = is_turned(find_normal(right, down, ray_x, ray_y),
                            find_normal(plane->right, plane->down, ray_x, ray_y));
    if (!turned && has_fragment(b, i, x, y)) {
        add_fragment(b, i, at, 1 + (uint32_t)((float)(STP_BLEND_WEIGHT - 1) * opacity));
    }
}

/// Texture coordinates on a disk or an ellipse.
typedef struct splat_map {
    splat_line larger, smaller; ///< axes divided by their radii
    float right, down;          ///< change of 1 / depth per pixel, relative to the centre
} splat_map;

static splat_map map_texture(const blend_batch* b, int i)
{
    const splat_batch* t = &b->t;
    float inverse = 1.0f / t->radius[i], stretch = 1.0f;
    splat_map map = {.right = -0.5f * t->p[i] / t->limit[i], .down = -0.5f * t->q[i] / t->limit[i]};
    stp_shape_axis axis = {0.0f, 1.0f};
    if (b->frame->splats->normals == NULL) {
        map.larger = (splat_line){inverse, 0.0f, 1.0f};
        map.smaller = (splat_line){0.0f, inverse, 1.0f};
        return map;
    }
    if ((t->stretched >> i & 1u) != 0) {
        axis = t->smaller[i];
        stretch = sqrtf(1.0f + t->stretch[i]);
    }
    map.larger = project_line(b->frame, t, i, axis.along_y, -axis.along_x);
    map.smaller = project_line(b->frame, t, i, axis.along_x, axis.along_y);
    map.larger.ex *= inverse;
    map.larger.ey *= inverse;
    map.smaller.ex *= inverse * stretch;
    map.smaller.ey *= inverse * stretch;
    return map;
}

static float read_texture(const stp_splat_texture* texture, const splat_map* map, float u, float v)
{
    float depth = 1.0f / (1.0f + (map->right * u + map->down * v));
    return stp_splat_texture_read(texture, (map->larger.ex * u + map->larger.ey * v) * depth,
                                  (map->smaller.ex * u + map->smaller.ey * v) * depth);
}

static void blend_textured(blend_batch* b, uint32_t i)
{
    const splat_batch* t = &b->t;
    splat_box box = clip_box(b->frame, t, (int)i);
    splat_map map = map_texture(b, (int)i);
    float maximum = t->g_limit[i];
    for (int32_t y = box.y0; y < box.y1; ++y) {
        for (int32_t x = box.x0; x < box.x1; ++x) {
            float u = t->u0[i] + (float)(x - t->x0[i]), v = t->v0[i] + (float)(y - t->y0[i]);
            float value = u * ((t->a[i] * u + t->b[i] * v) + t->p[i]) + v * (t->c[i] * v + t->q[i]);
            if (!(value <= t->limit[i]) || splat_is_clipped(t, (int)i, u, v)) {
                continue;
            }
            float change = t->gx[i] * u + t->gy[i] * v;
            change = change > maximum ? maximum : change;
            change = change < -maximum ? -maximum : change;
            blend_fragment(b, i, x, y, t->nearness[i] + change,
                           read_texture(b->blend->texture, &map, u, v));
        }
    }
}

static void blend_disk(blend_batch* b, uint32_t i)
{
    const splat_batch* t = &b->t;
    splat_box box = clip_box(b->frame, t, (int)i);
    float limit = t->limit[i], maximum = t->g_limit[i], inverse = 1.0f / limit;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        for (int32_t x = box.x0; x < box.x1; ++x) {
            float u = t->u0[i] + (float)(x - t->x0[i]), v = t->v0[i] + (float)(y - t->y0[i]);
            float value = u * ((t->a[i] * u + t->b[i] * v) + t->p[i]) + v * (t->c[i] * v + t->q[i]);
            if (!(value <= limit) || splat_is_clipped(t, (int)i, u, v)) {
                continue;
            }
            float change = t->gx[i] * u + t->gy[i] * v;
            change = change > maximum ? maximum : change;
            change = change < -maximum ? -maximum : change;
            float share = 1.0f - (value > 0.0f ? value * inverse : 0.0f);
            share = share > 0.0f ? share : 0.0f; // squared: nearly exp(-2 q), and 0 at the rim
            blend_fragment(b, i, x, y, t->nearness[i] + change, share * share);
        }
    }
}

static void blend_lanes(blend_batch* b)
{
    splat_batch* t = &b->t;
    b->has_colors = false;
    for (uint32_t i = 0; i < b->count; ++i) {
        if (t->kind[i] == SPLAT_PIXEL) {
            blend_fragment(b, i, t->cx[i], t->cy[i], t->nearness[i], b->tiny_opacity);
        } else if (t->kind[i] != SPLAT_SMALL && t->kind[i] != SPLAT_WIDE) {
            continue;
        } else if (b->adds && b->blend->texture != NULL) {
            blend_textured(b, i);
        } else {
            blend_disk(b, i);
        }
    }
}

/// Adds splats to sums, or stores planes.
static inline void blend_all(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats, bool adds)
{
    assert((adds ? blend->sums != NULL && blend->colors != NULL : splats->occluder == NULL) &&
           splats->hidden == NULL);
    stp_raster_target target = {
        .width = blend->width, .height = blend->height, .stride = blend->width};
    stp_splat_frame frame;
    if (!stp_splats_make_frame(&frame, &target, 0, blend->height, camera, splats,
                               blend->first_id)) {
        return;
    }
    blend_batch b = {.blend = blend,
                     .frame = &frame,
                     .adds = adds,
                     .t = empty_batch(),
                     .tiny_opacity = blend->texture != NULL ? stp_splat_texture_mean(blend->texture)
                                                            : 0.7f * 0.7f};
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        b.first = first;
        b.count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        if (splats->wanted != NULL && splats->wanted[first / SPLAT_BATCH] == 0) {
            continue;
        }
        splat_lanes lanes = {first, b.count, NULL};
        load_positions_scalar(&frame, lanes, &b.t);
        load_shapes(&frame, lanes, &b.t);
        load_parts(&frame, lanes, &b.t);
        project_batch(&frame, &b.t);
        pick_batch(&frame, &b.t, lanes);
        bool disks = false, any = false;
        for (uint32_t i = 0; i < b.count; ++i) {
            disks = disks || b.t.kind[i] == SPLAT_DISK;
            any = any || (b.t.kind[i] != SPLAT_NONE && b.t.kind[i] != SPLAT_HIDDEN);
        }
        if (disks) {
            if (splats->normals != NULL) {
                load_normals_scalar(&frame, lanes, &b.t);
            }
            shape_batch(&frame, &b.t);
            stretch_batch(&frame, &b.t);
            clip_batch(&frame, &b.t);
            box_batch(&b.t);
            sort_batch(&frame, &b.t);
        }
        if (any) {
            blend_lanes(&b);
        }
    }
}

typedef void (*blend_kernel)(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats, bool adds);
void stp_splats_blend_portable(const stp_raster_blend* blend, const stp_raster_camera* camera,
                               const stp_raster_splats* splats, bool adds);
void stp_splats_blend_vector(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats, bool adds);
void stp_splats_blend_wide(const stp_raster_blend* blend, const stp_raster_camera* camera,
                           const stp_raster_splats* splats, bool adds);
