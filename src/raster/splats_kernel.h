// SPDX-License-Identifier: MIT
//
// The parts of the splat rasteriser that every variant compiles for its own instruction set. Plain
// loops set up sixteen splats at a time, which compilers vectorise; then the variant's own
// `draw_small` and `draw_wide` draw them one by one. All arithmetic is single IEEE operations in a
// fixed order, so all variants give the same bits.
//
// A disk at view direction a = (ax, ay, 1) with normal n, D = n.a, projected radius R pixels and
// focal length s pixels covers the pixel at (u, v) from its centre where, with G = nx u + ny v and
// L = |a|^2,
//     D^2 (u^2 + v^2) - 2 D G (ax u + ay v) + G^2 L  <=  R^2 (D + G / s)^2
// This is the ray-plane test multiplied out, so no ray is needed. 1/depth is (1 + G / (D s)) /
// depth.
#pragma once

#include "raster/splats_frame.h"

#include <assert.h>
#include <string.h>

/// The splats of a batch.
typedef struct splat_lanes {
    uint32_t first, count;
    const uint32_t* queued; ///< NULL: they follow `first`
} splat_lanes;

static inline uint32_t lane_splat(splat_lanes lanes, uint32_t i)
{
    return lanes.queued != NULL ? lanes.queued[i] : lanes.first + i;
}

static inline void load_positions_scalar(const stp_splat_frame* frame, splat_lanes lanes,
                                         splat_batch* batch)
{
    const stp_raster_splats* splats = frame->splats;
    assert(lanes.count > 0 && lanes.count <= SPLAT_BATCH);
    for (uint32_t i = 0; i < lanes.count; ++i) {
        size_t at = 3 * (size_t)lane_splat(lanes, i);
        if (splats->positions != NULL) {
            batch->px[i] = (float)splats->positions[at];
            batch->py[i] = (float)splats->positions[at + 1];
            batch->pz[i] = (float)splats->positions[at + 2];
        } else {
            batch->px[i] = splats->points[at];
            batch->py[i] = splats->points[at + 1];
            batch->pz[i] = splats->points[at + 2];
        }
    }
    for (uint32_t i = lanes.count; i < SPLAT_BATCH; ++i) {
        batch->px[i] = batch->py[i] = batch->pz[i] = 0.0f;
    }
}

static inline void load_normals_scalar(const stp_splat_frame* frame, splat_lanes lanes,
                                       splat_batch* batch)
{
    const int8_t* normals = frame->splats->normals;
    for (uint32_t i = 0; i < lanes.count; ++i) {
        size_t at = 2 * (size_t)lane_splat(lanes, i);
        batch->nu[i] = (float)normals[at];
        batch->nv[i] = (float)normals[at + 1];
    }
    for (uint32_t i = lanes.count; i < SPLAT_BATCH; ++i) {
        batch->nu[i] = batch->nv[i] = 0.0f;
    }
}

/// Whether no splat of a batch is wanted; then none counts as hidden.
static inline bool skip_unwanted(const stp_raster_splats* splats, uint32_t first)
{
    bool skips = splats->wanted != NULL && splats->wanted[first / SPLAT_BATCH] == 0;
    if (skips && splats->hidden != NULL) {
        splats->hidden[first / SPLAT_BATCH] = 0;
    }
    return skips;
}

/// A batch of fully drawn splats; load_parts may change them.
static inline splat_batch empty_batch(void)
{
    splat_batch batch = {.halvings = {0}};
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        batch.part[i] = 255;
        batch.size[i] = batch.own[i] = 1.0f;
    }
    return batch;
}

/// Halves the radius of one splat, in pixels, as often as wanted while half of splat_min_diameter
/// is left.
static inline void halve_radius(const stp_splat_frame* f, uint32_t index, int i, splat_batch* t)
{
    float W = ((f->w[0] * t->px[i] + f->w[1] * t->py[i]) + f->w[2] * t->pz[i]) + f->w[3];
    float radius = (f->radius_px * (1.0f / W) + f->pixels) * t->own[i],
          minimum = splat_min_diameter(index);
    int32_t wanted = t->halvings[i], done = 0;
    while (done < wanted && radius * t->size[i] >= minimum) {
        t->size[i] *= 0.5f;
        done += 1;
    }
    t->halvings[i] = done;
}

/// Whether sixteen disks are all drawn fully.
static inline bool are_whole(const uint8_t* coverages)
{
    uint64_t halves[2];
    memcpy(halves, coverages, sizeof(halves));
    return (halves[0] & halves[1]) == UINT64_MAX;
}

static inline void load_shapes(const stp_splat_frame* f, splat_lanes lanes, splat_batch* t)
{
    const uint32_t* shapes = f->splats->shapes;
    if (shapes == NULL) { // without growths, keep the defaults of an empty batch
        for (uint32_t i = 0; i < lanes.count && f->splats->materials != NULL; ++i) {
            t->own[i] = splat_growth(f->splats, lane_splat(lanes, i));
        }
        return;
    }
    t->stretched = 0;
    for (uint32_t i = 0; i < lanes.count; ++i) {
        uint32_t code = shapes[lane_splat(lanes, i)];
        t->own[i] = stp_shape_radius(code & 0xFFFu);
        if ((code >> 12 & 0xFFFu) != (code & 0xFFFu)) {
            t->stretched |= 1u << i;
            t->stretch[i] = stp_shape_stretch(code);
            t->smaller[i] = stp_shape_smaller(code);
        }
    }
}

/// Loads coverages and sizes. Requires positions and shapes.
static inline void load_parts(const stp_splat_frame* f, splat_lanes lanes, splat_batch* t)
{
    const stp_raster_splats* splats = f->splats;
    if (splats->coverages == NULL) {
        return; // keep the defaults of an empty batch
    }
    t->clips = 0;
    if (lanes.queued == NULL && lanes.count == SPLAT_BATCH && lanes.first >= splats->low_count &&
        are_whole(splats->coverages + lanes.first)) {
        for (int i = 0; i < SPLAT_BATCH; ++i) {
            t->part[i] = 255;
            t->halvings[i] = 0;
            t->size[i] = 1.0f;
        }
        return;
    }
    for (uint32_t i = 0; i < lanes.count; ++i) {
        uint32_t part = splat_part(splats, lane_splat(lanes, i));
        if (part > SPLAT_CLIP) {
            t->clips |= 1u << i;
            t->code[i] = (uint8_t)(part - SPLAT_CLIP);
            part = 255;
        }
        t->part[i] = (int32_t)part;
    }
    int32_t any = 0;
    for (uint32_t i = 0; i < SPLAT_BATCH; ++i) {
        t->halvings[i] = (int32_t)splat_halvings((uint32_t)t->part[i]);
        t->size[i] = 1.0f;
        any |= t->halvings[i];
    }
    for (uint32_t i = 0; i < lanes.count && any != 0; ++i) {
        if (t->halvings[i] != 0) {
            halve_radius(f, lane_splat(lanes, i), (int)i, t);
        }
    }
}

/// Projects the centres and classifies splats. A disk with a radius below half a pixel (its square
/// at most 0.24, for rounding) covers no pixel centre except perhaps that of its own pixel: `tiny`.
static inline void project_batch(const stp_splat_frame* restrict f, splat_batch* restrict t)
{
    float width = (float)f->target->width;
    float top = (float)f->row_begin, bottom = (float)f->row_end;
    bool perspective = !f->camera->parallel;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float x = t->px[i], y = t->py[i], z = t->pz[i];
        float X = ((f->x[0] * x + f->x[1] * y) + f->x[2] * z) + f->x[3];
        float Y = ((f->y[0] * x + f->y[1] * y) + f->y[2] * z) + f->y[3];
        float N = ((f->n[0] * x + f->n[1] * y) + f->n[2] * z) + f->n[3];
        float W = ((f->w[0] * x + f->w[1] * y) + f->w[2] * z) + f->w[3];
        float inverse = 1.0f / W;
        float sx = X * inverse, sy = Y * inverse, nearness = N * inverse;
        float radius = (f->radius_px * inverse + f->pixels) * (t->size[i] * t->own[i]);
        float ax = (sx - f->center_x) * f->inverse_scale,
              ay = (sy - f->center_y) * f->inverse_scale;
        float reach = radius * radius * ((ax * ax + ay * ay) + 1.0f); // below 0.24: tiny
        int32_t within = (int32_t)(W >= f->nearest) & (int32_t)(W <= f->farthest);
        int32_t close = (int32_t)(W < f->near_w * t->own[i]) & (int32_t)(W > f->far_w * t->own[i]) &
                        (int32_t)perspective;
        int32_t seen = (int32_t)(W > 0.0f) & (int32_t)(nearness > 0.0f) &
                       (int32_t)(nearness <= f->nearness_limit) & (close ^ 1) & within;
        close &= within;
        int32_t tiny = (int32_t)(reach <= 0.24f) & seen;
        int32_t inside = (int32_t)(sx >= 0.0f) & (int32_t)(sx < width) & (int32_t)(sy >= top) &
                         (int32_t)(sy < bottom);
        int32_t disk = seen & (tiny ^ 1);
        t->sx[i] = sx;
        t->sy[i] = sy;
        t->nearness[i] = nearness;
        t->radius[i] = radius;
        t->kind[i] = (tiny & inside) * SPLAT_PIXEL + disk * SPLAT_DISK + close * SPLAT_LARGE;
        t->cx[i] = (int32_t)(inside != 0 ? sx : 0.0f);
        t->cy[i] = (int32_t)(inside != 0 ? sy : 0.0f);
    }
}

/// Drops disks close to the eye that are fully outside the picture.
static inline void drop_beside(const stp_splat_frame* restrict f, splat_batch* restrict t)
{
    float width = (float)f->target->width;
    float top = (float)f->row_begin, bottom = (float)f->row_end;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float x = t->px[i], y = t->py[i], z = t->pz[i];
        float X = ((f->x[0] * x + f->x[1] * y) + f->x[2] * z) + f->x[3];
        float Y = ((f->y[0] * x + f->y[1] * y) + f->y[2] * z) + f->y[3];
        float W = ((f->w[0] * x + f->w[1] * y) + f->w[2] * z) + f->w[3];
        float radius = f->radius_px * 1.01f * t->own[i];
        int32_t beside = (int32_t)(X < -(radius * f->beside[0])) |
                         (int32_t)(X - width * W > radius * f->beside[1]) |
                         (int32_t)(Y - top * W < -(radius * f->beside[2])) |
                         (int32_t)(Y - bottom * W > radius * f->beside[3]);
        int32_t large = (int32_t)(t->kind[i] == SPLAT_LARGE);
        t->kind[i] = (large & beside) != 0 ? SPLAT_NONE : t->kind[i];
    }
}

/// Whether a splat of a classified batch is drawn.
static inline bool splat_is_drawn(const splat_batch* t, uint32_t i)
{
    int32_t kind = t->kind[i];
    assert(kind != SPLAT_DISK && "classified");
    return kind != SPLAT_NONE && kind != SPLAT_HIDDEN;
}

/// Counts the splats drawn of a batch, one bit each.
static inline void count_drawn(const stp_raster_splats* splats, uint32_t drawn)
{
    if (splats->drawn != NULL) {
        *splats->drawn += (uint64_t)__builtin_popcount(drawn);
    }
}

/// Computes the conic of each disk, its slope of nearness, and its box.
static inline void shape_batch(const stp_splat_frame* restrict f, splat_batch* restrict t)
{
    const float maximum = (float)SPLAT_EXTENT_LIMIT;
    int32_t facing = f->splats->normals == NULL;
    float depth[SPLAT_BATCH], away[SPLAT_BATCH];
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float ax = (t->sx[i] - f->center_x) * f->inverse_scale;
        float ay = (t->sy[i] - f->center_y) * f->inverse_scale;
        float u = t->nu[i], v = t->nv[i];
        float z = (127.0f - fabsf(u)) - fabsf(v);
        float fold = z < 0.0f ? -z : 0.0f;
        u = u + (u >= 0.0f ? -fold : fold);
        v = v + (v >= 0.0f ? -fold : fold);
        float nx = (f->turn[0][0] * u + f->turn[0][1] * v) + f->turn[0][2] * z;
        float ny = (f->turn[1][0] * u + f->turn[1][1] * v) + f->turn[1][2] * z;
        float nz = (f->turn[2][0] * u + f->turn[2][1] * v) + f->turn[2][2] * z;
        nx = facing != 0 ? ax : nx; // any multiple of the normal will do
        ny = facing != 0 ? ay : ny;
        nz = facing != 0 ? 1.0f : nz;
        float square = (nx * nx + ny * ny) + nz * nz;
        float D = (nx * ax + ny * ay) + nz;
        float minimum = square * 1e-6f; // edge-on: at least a thousandth of the diameter wide
        float D2 = D * D;
        float fixed = sqrtf(minimum);
        D = D2 < minimum ? (D < 0.0f ? -fixed : fixed) : D;
        D2 = D * D;
        float radius = t->radius[i], R2 = radius * radius;
        float ratio = radius * f->inverse_scale; // radius over depth
        float L = ((ax * ax + ay * ay) + 1.0f) - ratio * ratio;
        t->a[i] = (D2 - 2.0f * (D * (nx * ax))) + L * (nx * nx);
        t->b[i] = 2.0f * (L * (nx * ny) - D * (nx * ay + ny * ax));
        t->c[i] = (D2 - 2.0f * (D * (ny * ay))) + L * (ny * ny);
        float linear = -2.0f * ((R2 * D) * f->inverse_scale);
        t->p[i] = linear * nx;
        t->q[i] = linear * ny;
        t->limit[i] = R2 * D2;
        float slope = t->nearness[i] * f->slope_factor + f->slope_constant;
        t->gx[i] = slope * (nx / D);
        t->gy[i] = slope * (ny / D);
        // extents: the disk's extent across the ray, widened where its near rim looks larger
        float ex2 = (ax * ax + 1.0f) - (nx - ax * nz) * (nx - ax * nz) / square;
        float ey2 = (ay * ay + 1.0f) - (ny - ay * nz) * (ny - ay * nz) / square;
        float grow = radius / (1.0f - ratio);
        t->g_limit[i] = fabsf(slope) * grow; // from one radius before the centre to one behind it
        depth[i] = fabsf(slope) * radius;    // a step of one radius along the view axis
        away[i] = D;
        float ex = grow * sqrtf(ex2 > 0.0f ? ex2 : 0.0f) + 0.01f;
        float ey = grow * sqrtf(ey2 > 0.0f ? ey2 : 0.0f) + 0.01f;
        t->u0[i] = ex;
        t->v0[i] = ey;
        t->large[i] = 1 - ((int32_t)(ex < maximum) & (int32_t)(ey < maximum));
        t->sx[i] = t->sx[i] > -SPLAT_FAR ? t->sx[i] : -SPLAT_FAR; // also for NaN
        t->sy[i] = t->sy[i] > -SPLAT_FAR ? t->sy[i] : -SPLAT_FAR;
    }
    float back = facing == 0 ? f->back_depth : 0.0f;
    for (int i = 0; i < SPLAT_BATCH; ++i) { // separate loop: gcc vectorises neither if merged
        float behind = away[i] > 0.0f ? back : 0.0f;
        float moved = t->nearness[i] - behind * depth[i];
        t->nearness[i] = t->kind[i] == SPLAT_DISK ? moved : t->nearness[i];
        t->rim[i] = f->rim_depth * depth[i] / t->limit[i];
    }
}

/// A direction in a splat's plane, on the screen: an offset of (u, v) pixels from the projected
/// centre is ex u + ey v pixels along it.
typedef struct splat_line {
    float ex, ey;
    float square; ///< square of the normal's component towards the eye (D^2 of the conic)
} splat_line;

static inline splat_line project_line(const stp_splat_frame* f, const splat_batch* t, int i,
                                      float across, float along)
{
    float u = t->nu[i], v = t->nv[i];
    stp_disk_axes axes = stp_disk_axes_of(u, v);
    stp_vec3 d = {across * axes.x.x + along * axes.y.x, across * axes.x.y + along * axes.y.y,
                  across * axes.x.z + along * axes.y.z};
    stp_vec3 n = stp_octahedral_unfold(u, v);
    float ax = (t->sx[i] - f->center_x) * f->inverse_scale;
    float ay = (t->sy[i] - f->center_y) * f->inverse_scale;
    float nx = (f->turn[0][0] * n.x + f->turn[0][1] * n.y) + f->turn[0][2] * n.z;
    float ny = (f->turn[1][0] * n.x + f->turn[1][1] * n.y) + f->turn[1][2] * n.z;
    float nz = (f->turn[2][0] * n.x + f->turn[2][1] * n.y) + f->turn[2][2] * n.z;
    float dx = (f->turn[0][0] * d.x + f->turn[0][1] * d.y) + f->turn[0][2] * d.z;
    float dy = (f->turn[1][0] * d.x + f->turn[1][1] * d.y) + f->turn[1][2] * d.z;
    float dz = (f->turn[2][0] * d.x + f->turn[2][1] * d.y) + f->turn[2][2] * d.z;
    float D = (nx * ax + ny * ay) + nz;
    float minimum = ((nx * nx + ny * ny) + nz * nz) * 1e-6f;
    D = D * D < minimum ? (D < 0.0f ? -sqrtf(minimum) : sqrtf(minimum)) : D;
    float slide = ((dx * ax + dy * ay) + dz) / D;
    return (splat_line){dx - slide * nx, dy - slide * ny, D * D};
}

/// Turns the stretched disks of a batch into ellipses, exactly: with e = (ex, ey), the conic gains
/// stretch D^2 (e . (u, v))^2. Call after shape_batch, if splats have normals.
static inline void stretch_batch(const stp_splat_frame* f, splat_batch* t)
{
    for (uint32_t lanes = t->stretched; lanes != 0; lanes &= lanes - 1) {
        int i = __builtin_ctz(lanes);
        if (t->kind[i] == SPLAT_DISK) {
            splat_line line = project_line(f, t, i, t->smaller[i].along_x, t->smaller[i].along_y);
            float more = t->stretch[i] * line.square;
            t->a[i] += more * (line.ex * line.ex);
            t->b[i] += 2.0f * (more * (line.ex * line.ey));
            t->c[i] += more * (line.ey * line.ey);
        }
    }
}

/// Clipping lines of one disk on the screen, to first order about its centre.
static inline void clip_disk(const stp_splat_frame* f, splat_batch* t, int i)
{
    stp_disk_clip clip = stp_coverage_clip(t->code[i]);
    splat_line line = project_line(f, t, i, clip.across, clip.along);
    float inverse = 1.0f / t->radius[i];
    t->ex[i] = line.ex * inverse;
    t->ey[i] = line.ey * inverse;
    t->low[i] = clip.low;
    t->high[i] = clip.high;
}

/// Clips the disks of a batch. Call after shape_batch, before box_batch, which clamps centres.
static inline void clip_batch(const stp_splat_frame* f, splat_batch* t)
{
    for (uint32_t clips = t->clips; clips != 0; clips &= clips - 1) {
        int i = __builtin_ctz(clips);
        if (t->kind[i] == SPLAT_DISK) {
            clip_disk(f, t, i);
        }
    }
}

/// Whether a fragment at (u, v) from its splat's centre is clipped away.
static inline bool splat_is_clipped(const splat_batch* t, int i, float u, float v)
{
    float at = t->ex[i] * u + t->ey[i] * v;
    return (t->clips >> i & 1u) != 0 && !(at >= t->low[i] && at <= t->high[i]);
}

/// Boxes from centres and extents (stored in u0, v0). Each includes the centre's pixel, so none is
/// empty.
static inline void box_batch(splat_batch* restrict t)
{
    const float maximum = (float)SPLAT_EXTENT_LIMIT, far = SPLAT_FAR;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float sx = t->sx[i], sy = t->sy[i];
        sx = sx < far ? sx : far;
        sy = sy < far ? sy : far;
        float ex = t->u0[i], ey = t->v0[i];
        ex = ex < maximum ? ex : maximum;
        ey = ey < maximum ? ey : maximum;
        t->cx[i] = (int32_t)floorf(sx);
        t->cy[i] = (int32_t)floorf(sy);
        t->x0[i] = (int32_t)floorf((sx - ex) + 0.5f);
        t->y0[i] = (int32_t)floorf((sy - ey) + 0.5f);
        t->x1[i] = (int32_t)floorf((sx + ex) - 0.5f);
        t->y1[i] = (int32_t)floorf((sy + ey) - 0.5f);
        t->sx[i] = sx;
        t->sy[i] = sy;
    }
    for (int i = 0; i < SPLAT_BATCH; ++i) { // separate loop: gcc vectorises neither if merged
        int32_t cx = t->cx[i], cy = t->cy[i];
        int32_t x0 = t->x0[i] < cx ? t->x0[i] : cx, y0 = t->y0[i] < cy ? t->y0[i] : cy;
        t->x1[i] = t->x1[i] > cx ? t->x1[i] : cx;
        t->y1[i] = t->y1[i] > cy ? t->y1[i] : cy;
        t->x0[i] = x0;
        t->y0[i] = y0;
        t->u0[i] = ((float)x0 + 0.5f) - t->sx[i];
        t->v0[i] = ((float)y0 + 0.5f) - t->sy[i];
    }
}

/// Final classification of disks.
static inline void sort_batch(const stp_splat_frame* restrict f, splat_batch* restrict t)
{
    int32_t width = (int32_t)f->target->width, top = f->row_begin, bottom = f->row_end;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        int32_t x0 = t->x0[i], y0 = t->y0[i], x1 = t->x1[i], y1 = t->y1[i];
        int32_t in = -(int32_t)(x1 >= 0) & -(int32_t)(x0 < width) & -(int32_t)(y1 >= top) &
                     -(int32_t)(y0 < bottom);
        int32_t small = -(int32_t)(x1 - x0 < SPLAT_BLOCK) & -(int32_t)(y1 - y0 < SPLAT_BLOCK) &
                        -(int32_t)(x0 >= 0) & -(int32_t)(x0 + SPLAT_BLOCK <= width) &
                        -(int32_t)(y0 >= top) & -(int32_t)(y0 + SPLAT_BLOCK <= bottom);
        int32_t large = -t->large[i];
        int32_t drawn = in & ((small & SPLAT_SMALL) | (~small & SPLAT_WIDE));
        drawn = (large & SPLAT_LARGE) | (~large & drawn);
        int32_t disk = -(int32_t)(t->kind[i] == SPLAT_DISK);
        t->kind[i] = (disk & drawn) | (~disk & t->kind[i]);
    }
}

/// One fragment of a disk: whether the pixel at (column, row) of its box is inside, and its
/// nearness.
static inline bool disk_fragment(const stp_splat_frame* f, const splat_batch* t, int i,
                                 int32_t column, int32_t row, float* nearness)
{
    float u = t->u0[i] + (float)column, v = t->v0[i] + (float)row;
    float value = u * ((t->a[i] * u + t->b[i] * v) + t->p[i]) + v * (t->c[i] * v + t->q[i]);
    float change = t->gx[i] * u + t->gy[i] * v, maximum = t->g_limit[i];
    change = change > maximum ? maximum : change;
    change = change < -maximum ? -maximum : change;
    float limit = t->limit[i];
    float at = (t->nearness[i] + change) - (value < limit ? value : limit) * t->rim[i];
    at = at > SPLAT_MIN_NEARNESS ? at : SPLAT_MIN_NEARNESS;
    *nearness = at < f->nearness_limit ? at : f->nearness_limit;
    return value <= limit;
}

/// The part of a splat's box inside the target's rows, as half-open ranges of columns and rows.
typedef struct splat_box {
    int32_t x0, y0, x1, y1;
} splat_box;

static inline splat_box clip_box(const stp_splat_frame* f, const splat_batch* t, int i)
{
    int32_t width = (int32_t)f->target->width;
    splat_box box = {t->x0[i], t->y0[i], t->x1[i] + 1, t->y1[i] + 1};
    box.x0 = box.x0 > 0 ? box.x0 : 0;
    box.y0 = box.y0 > f->row_begin ? box.y0 : f->row_begin;
    box.x1 = box.x1 < width ? box.x1 : width;
    box.y1 = box.y1 < f->row_end ? box.y1 : f->row_end;
    return box;
}

/// Whether the block of a small disk lies within the target's rows.
static inline bool is_block_inside(const stp_splat_frame* f, const splat_batch* t, int i)
{
    return t->x0[i] >= 0 && t->x0[i] + SPLAT_BLOCK <= (int32_t)f->target->width &&
           t->y0[i] >= f->row_begin && t->y0[i] + SPLAT_BLOCK <= f->row_end;
}

/// Draws a disk pixel by pixel.
static inline uint64_t draw_disk_scalar(const stp_splat_frame* f, const splat_batch* t, int i,
                                        uint32_t index, splat_box box)
{
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        uint64_t* row = f->target->pixels + (size_t)y * f->target->stride;
        for (int32_t x = box.x0; x < box.x1; ++x) {
            float nearness;
            float u = t->u0[i] + (float)(x - t->x0[i]), v = t->v0[i] + (float)(y - t->y0[i]);
            if (!disk_fragment(f, t, i, x - t->x0[i], y - t->y0[i], &nearness) ||
                splat_is_clipped(t, i, u, v)) {
                continue;
            }
            if (coverage < 255 &&
                !splat_has_fragment(coverage, f->seed + index, x - t->cx[i], y - t->cy[i])) {
                continue;
            }
            splat_store(&row[x], stp_raster_pixel(nearness, f->first_id + index));
            fragments += 1;
        }
    }
    return fragments;
}

static inline uint64_t draw_pixel(const stp_splat_frame* f, const splat_batch* t, int i,
                                  uint32_t index)
{
    bool clip = (t->clips >> i & 1u) != 0;
    assert(t->cx[i] >= 0 && (uint32_t)t->cx[i] < f->target->width && t->cy[i] >= f->row_begin &&
           t->cy[i] < f->row_end && "a pixel of the target");
    uint32_t part = clip ? splat_clip_share(SPLAT_CLIP + t->code[i]) : (uint32_t)t->part[i];
    uint32_t coverage = splat_coverage(f->splats, part, t->halvings[i]);
    if (coverage < 255 && !splat_has_fragment(coverage, f->seed + index, 0, 0)) {
        return 0;
    }
    splat_store(f->target->pixels + (size_t)t->cy[i] * f->target->stride + (size_t)t->cx[i],
                stp_raster_pixel(t->nearness[i], f->first_id + index));
    return 1;
}

/// Prefetches the pixels of small disks: neighbours in the order are far apart in the picture.
static inline void fetch_small(const stp_splat_frame* f, const splat_batch* t, uint32_t lanes)
{
    for (; lanes != 0; lanes &= lanes - 1) {
        int i = __builtin_ctz(lanes);
        assert(is_block_inside(f, t, i));
        size_t at = (size_t)t->y0[i] * f->target->stride + (size_t)t->x0[i];
        for (int k = 0; k < SPLAT_BLOCK; ++k) {
            __builtin_prefetch(f->target->pixels + at + (size_t)k * f->target->stride, 1);
        }
    }
}
