// SPDX-License-Identifier: MIT
#include "select/depth_pyramid.h"

#include "base/core/context.h"

#include <assert.h>

enum { MAX_BLOCKS = 4, ROWS_AT_ONCE = 8 };

#define ROUNDING 1e-5 ///< relative margin of nearness: rounding error on either side
#define SNAPPED 0.01  ///< pixels: corners of triangles lie on a grid

/// Sets the sizes of all levels. @return total number of floats
static size_t choose_levels(stp_depth_pyramid* p, uint32_t width, uint32_t height)
{
    uint32_t columns = (width - 1) / STP_DEPTH_PYRAMID_BLOCK + 1;
    uint32_t rows = (height - 1) / STP_DEPTH_PYRAMID_BLOCK + 1;
    size_t total = 0;
    p->level_count = 0;
    while (p->level_count < STP_DEPTH_PYRAMID_LEVELS) {
        p->columns[p->level_count] = columns;
        p->rows[p->level_count] = rows;
        p->level_count += 1;
        total += (size_t)columns * rows;
        if (columns == 1 && rows == 1 && p->level_count > 1) {
            break;
        }
        columns = (columns + 1) / 2;
        rows = (rows + 1) / 2;
    }
    return total;
}

typedef struct block_rows {
    const stp_depth_pyramid* pyramid;
    const float* nearness;
    uint32_t width, height;
} block_rows;

/// Computes rows of blocks of level 0.
static void reduce_pixels(size_t begin, size_t end, uint32_t worker, void* user)
{
    const block_rows* b = user;
    (void)worker;
    uint32_t columns = b->pyramid->columns[0], whole = b->width / STP_DEPTH_PYRAMID_BLOCK;
    for (size_t row = begin; row < end; ++row) {
        float* out = b->pyramid->levels[0] + row * columns;
        for (uint32_t i = 0; i < columns; ++i) {
            out[i] = FLT_MAX;
        }
        size_t last = (row + 1) * STP_DEPTH_PYRAMID_BLOCK;
        last = last < b->height ? last : b->height;
        for (size_t y = row * STP_DEPTH_PYRAMID_BLOCK; y < last; ++y) {
            const float* in = b->nearness + y * b->width;
            for (uint32_t i = 0; i < whole; ++i) {
                const float* four = in + (size_t)STP_DEPTH_PYRAMID_BLOCK * i;
                float least = stp_min(stp_min(four[0], four[1]), stp_min(four[2], four[3]));
                out[i] = stp_min(out[i], least);
            }
            for (uint32_t x = whole * STP_DEPTH_PYRAMID_BLOCK; x < b->width; ++x) {
                out[whole] = stp_min(out[whole], in[x]);
            }
        }
    }
}

static void reduce_level(stp_depth_pyramid* p, uint32_t level)
{
    const float* in = p->levels[level - 1];
    uint32_t columns = p->columns[level - 1], rows = p->rows[level - 1];
    assert(p->columns[level] == (columns + 1) / 2 && p->rows[level] == (rows + 1) / 2);
    float* out = p->levels[level];
    for (uint32_t y = 0; y < p->rows[level]; ++y) {
        const float* above = in + (size_t)(2 * y) * columns;
        const float* below = 2 * y + 1 < rows ? above + columns : above;
        for (uint32_t x = 0; x < p->columns[level]; ++x) {
            uint32_t left = 2 * x, right = left + 1 < columns ? left + 1 : left;
            *out++ =
                stp_min(stp_min(above[left], above[right]), stp_min(below[left], below[right]));
        }
    }
}

stp_result stp_depth_pyramid_fill(stp_context* context, const stp_view_frame* frame,
                                  const float* nearness, stp_depth_pyramid* pyramid)
{
    uint32_t width = (uint32_t)frame->width, height = (uint32_t)frame->height;
    assert(width > 0 && height > 0 && "a valid view");
    pyramid->frame = *frame;
    pyramid->pushed_back = 1.0;
    size_t total = choose_levels(pyramid, width, height);
    if (total > pyramid->capacity) {
        stp_free(context, pyramid->memory);
        pyramid->capacity = 0;
        pyramid->memory = STP_NEW_ARRAY(context, float, total);
        if (pyramid->memory == NULL) {
            pyramid->level_count = 0;
            return stp_fail_memory(context);
        }
        pyramid->capacity = total;
    }
    float* at = pyramid->memory;
    for (uint32_t i = 0; i < pyramid->level_count; ++i) {
        pyramid->levels[i] = at;
        at += (size_t)pyramid->columns[i] * pyramid->rows[i];
    }
    assert(at == pyramid->memory + total && "the levels fill the memory");
    block_rows rows = {.pyramid = pyramid, .nearness = nearness, .width = width, .height = height};
    stp_parallel_for(context, pyramid->rows[0], ROWS_AT_ONCE, reduce_pixels, &rows);
    for (uint32_t i = 1; i < pyramid->level_count; ++i) {
        reduce_level(pyramid, i);
    }
    return STP_OK;
}

/// A rectangle of pixels, both ends inclusive, and the minimum depth of its content.
typedef struct footprint {
    double x0, y0, x1, y1, depth;
} footprint;

/// One coordinate in the view of a box's eight corners.
static void place_corners(const double row[4], const stp_boxd* box, double out[8])
{
    const double steps[3] = {row[0] * (box->max.x - box->min.x), row[1] * (box->max.y - box->min.y),
                             row[2] * (box->max.z - box->min.z)};
    out[0] = row[0] * box->min.x + row[1] * box->min.y + row[2] * box->min.z + row[3];
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 1 << k; ++i) {
            out[(1 << k) + i] = out[i] + steps[k];
        }
    }
}

/// @return false if a corner is not beyond `near`
static bool project(const stp_view_frame* f, const double rows[3][4], const stp_boxd* box,
                    double near, footprint* out)
{
    double x[8], y[8], depth[8];
    place_corners(rows[2], box, depth);
    out->depth = depth[0];
    for (int i = 1; i < 8; ++i) {
        out->depth = stp_mind(depth[i], out->depth);
    }
    if (!(out->depth > near)) {
        return false;
    }
    place_corners(rows[0], box, x);
    place_corners(rows[1], box, y);
    for (int i = 0; i < 8; ++i) {
        double inverse = f->scale / depth[i];
        x[i] *= inverse;
        y[i] *= inverse;
    }
    out->x0 = out->x1 = x[0];
    out->y0 = out->y1 = y[0];
    for (int i = 1; i < 8; ++i) {
        out->x0 = stp_mind(x[i], out->x0);
        out->x1 = stp_maxd(x[i], out->x1);
        out->y0 = stp_mind(y[i], out->y0);
        out->y1 = stp_maxd(y[i], out->y1);
    }
    out->x0 += f->center_x;
    out->x1 += f->center_x;
    out->y0 += f->center_y;
    out->y1 += f->center_y;
    return true;
}

/// Whether all pixels of a footprint within the picture are nearer than `nearness`. False if there
/// are none.
static bool hides_footprint(const stp_depth_pyramid* p, footprint at, double nearness)
{
    const stp_view_frame* f = &p->frame;
    at.x0 = stp_maxd(at.x0, 0.0);
    at.y0 = stp_maxd(at.y0, 0.0);
    at.x1 = stp_mind(at.x1, f->width - 1.0);
    at.y1 = stp_mind(at.y1, f->height - 1.0);
    if (!(at.x0 <= at.x1 && at.y0 <= at.y1)) {
        return false;
    }
    uint32_t x0 = (uint32_t)at.x0 / STP_DEPTH_PYRAMID_BLOCK;
    uint32_t y0 = (uint32_t)at.y0 / STP_DEPTH_PYRAMID_BLOCK;
    uint32_t x1 = (uint32_t)at.x1 / STP_DEPTH_PYRAMID_BLOCK;
    uint32_t y1 = (uint32_t)at.y1 / STP_DEPTH_PYRAMID_BLOCK;
    uint32_t level = 0;
    while (level + 1 < p->level_count && (x1 - x0 >= MAX_BLOCKS || y1 - y0 >= MAX_BLOCKS)) {
        level += 1;
        x0 /= 2;
        y0 /= 2;
        x1 /= 2;
        y1 /= 2;
    }
    assert(x1 < p->columns[level] && y1 < p->rows[level] && "blocks of the level");
    for (uint32_t y = y0; y <= y1; ++y) {
        const float* row = p->levels[level] + (size_t)y * p->columns[level];
        for (uint32_t x = x0; x <= x1; ++x) {
            if (!((double)row[x] > nearness)) {
                return false;
            }
        }
    }
    return true;
}

bool stp_depth_pyramid_hides_placed(const stp_depth_pyramid* p, const double rows[3][4],
                                    const stp_boxd* box, double margin)
{
    const stp_view_frame* f = &p->frame;
    assert(!(margin < 0.0));
    double ratio = margin / f->scale; // radius of such a splat over its depth
    footprint at;
    if (p->level_count == 0 || stp_boxd_is_empty(*box) || !(ratio < 0.5) ||
        !project(f, rows, box, f->near_distance / (1.0 - ratio), &at)) {
        return false;
    }
    double wider = margin / (1.0 - ratio) * f->corner + 1.5; // disks look larger off the view axis
    at.x0 -= wider;
    at.y0 -= wider;
    at.x1 += wider;
    at.y1 += wider;
    // occluders may be drawn half a splat behind their place (draw/cpu)
    return hides_footprint(
        p, at, f->near_distance / (at.depth * (1.0 - ratio)) * (1.0 + ratio) * (1.0 + ROUNDING));
}

/// Bound on the rounding error of coordinates in the view that are computed in float, relative to an
/// offset: each product and each sum is rounded.
static double float_error(const double rows[3][4], const float offset[3], const stp_boxd* box)
{
    double largest = 0.0;
    const double from[3] = {(double)offset[0], (double)offset[1], (double)offset[2]};
    const double reach[3] = {stp_maxd(fabs(box->min.x - from[0]), fabs(box->max.x - from[0])),
                             stp_maxd(fabs(box->min.y - from[1]), fabs(box->max.y - from[1])),
                             stp_maxd(fabs(box->min.z - from[2]), fabs(box->max.z - from[2]))};
    for (int k = 0; k < 3; ++k) {
        double base = rows[k][3], sum = 0.0;
        for (int c = 0; c < 3; ++c) {
            base += rows[k][c] * from[c];
            sum += fabs(rows[k][c]) * reach[c];
        }
        largest = stp_maxd(largest, sum + fabs(base));
    }
    return largest * (4.0 * (double)FLT_EPSILON);
}

bool stp_depth_pyramid_hides_triangles(const stp_depth_pyramid* p, const double rows[3][4],
                                       const float offset[3], const stp_boxd* box)
{
    const stp_view_frame* f = &p->frame;
    footprint at;
    if (p->level_count == 0 || stp_boxd_is_empty(*box) ||
        !project(f, rows, box, f->near_distance, &at)) {
        return false;
    }
    double error = float_error(rows, offset, box), nearest = at.depth - error;
    if (!(nearest > 0.5 * at.depth)) {
        return false;
    }
    // a pixel is hit if its centre is inside
    double wider = SNAPPED + error * f->scale / nearest * (1.0 + f->corner);
    at.x0 -= 0.5 + wider;
    at.y0 -= 0.5 + wider;
    at.x1 += wider - 0.5;
    at.y1 += wider - 0.5;
    assert(p->pushed_back >= 1.0);
    return hides_footprint(p, at, f->near_distance / (nearest * p->pushed_back) * (1.0 + ROUNDING));
}

bool stp_depth_pyramid_hides(const stp_depth_pyramid* p, const stp_boxd* box, double margin)
{
    const stp_view_frame* f = &p->frame;
    const stp_vec3d axes[3] = {f->right, f->down, f->forward};
    stp_boxd from_eye = {stp_subd(box->min, f->eye), stp_subd(box->max, f->eye)};
    double rows[3][4];
    for (int k = 0; k < 3; ++k) {
        rows[k][0] = axes[k].x;
        rows[k][1] = axes[k].y;
        rows[k][2] = axes[k].z;
        rows[k][3] = 0.0;
    }
    return stp_depth_pyramid_hides_placed(p, (const double(*)[4])rows,
                                          stp_boxd_is_empty(*box) ? box : &from_eye, margin);
}

void stp_depth_pyramid_destroy(stp_context* context, stp_depth_pyramid* pyramid)
{
    stp_free(context, pyramid->memory);
    *pyramid = (stp_depth_pyramid){0};
}
