// SPDX-License-Identifier: MIT
// Passes over the rows of a picture: nearness with gaps between disks closed, shading by
// neighbours, colours.
#include "draw/cpu/effects.h"

#include "base/core/processor.h"

#include <assert.h>
#include <stdlib.h>

enum { SCRATCH_ROWS = 3, BLUR_REACH = 2, CLOSE_MAX = 4 };

#define BLUR_SLOPE 4.0f ///< neighbours that rise more steeply belong to another surface

typedef struct effect_frame {
    stp_cpu_renderer* r;
    const stp_cpu_effect_kernels* kernels;
    const stp_depth_pyramid* pyramid;
    size_t stride, pad;
    float *near, *spare, *far, *factor; ///< planes, each height * stride floats
    float* outside;                     ///< a row of infinite distance
    float* scratch;                     ///< SCRATCH_ROWS per worker
    stp_effect_shape shape;
    float scale;
    bool constant; ///< the gain is the same everywhere: parallel projection
} effect_frame;

const stp_cpu_effect_kernels* stp_cpu_choose_effect_kernels(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_cpu_effect_kernels);
}

/// First pixel of a row; rows outside the picture are infinitely far.
static float* row_of(const effect_frame* f, float* plane, int64_t y)
{
    bool there = y >= 0 && y < (int64_t)f->r->height;
    return (there ? plane + (size_t)y * f->stride : f->outside) + f->pad;
}

static float* scratch_row(const effect_frame* f, uint32_t worker, uint32_t index)
{
    return f->scratch + ((size_t)worker * SCRATCH_ROWS + index) * f->stride + f->pad;
}

static void fill_pads(const effect_frame* f, float* row, float value)
{
    assert(f->pad + f->r->width + f->pad <= f->stride && "a pad on each side");
    for (size_t i = 1; i <= f->pad; ++i) {
        row[-(ptrdiff_t)i] = value;
    }
    for (size_t i = f->r->width; i < f->stride - f->pad; ++i) {
        row[i] = value;
    }
}

// Disk rims lie behind their planes, which would outline each disk in dark. A morphological closing
// of nearness fills gaps narrower than the valley between disks, and keeps silhouettes.

static void widen_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    uint32_t width = f->r->width;
    float* padded = scratch_row(f, worker, 0);
    for (size_t y = begin; y < end; ++y) {
        memcpy(padded, f->r->depth + y * width, width * sizeof(float));
        fill_pads(f, padded, -1.0f);
        f->kernels->greatest(padded, f->shape.close, row_of(f, f->spare, (int64_t)y), width);
    }
}

static void widen_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    uint32_t width = f->r->width;
    float* padded = scratch_row(f, worker, 0);
    for (int64_t y = (int64_t)begin; y < (int64_t)end; ++y) {
        memcpy(padded, row_of(f, f->spare, y), width * sizeof(float));
        for (int64_t k = -f->shape.close; k <= f->shape.close; ++k) {
            if (y + k >= 0 && y + k < (int64_t)f->r->height) {
                f->kernels->add_max(row_of(f, f->spare, y + k), padded, width);
            }
        }
        fill_pads(f, padded, FLT_MAX);
        f->kernels->minimum(padded, f->shape.close, row_of(f, f->far, y), width);
    }
}

static void narrow_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    uint32_t width = f->r->width;
    (void)worker;
    for (int64_t y = (int64_t)begin; y < (int64_t)end; ++y) {
        float* out = row_of(f, f->near, y);
        const float* in =
            f->shape.close > 0 ? row_of(f, f->far, y) : f->r->depth + (size_t)y * width;
        memcpy(out, in, width * sizeof(float));
        for (int64_t k = -f->shape.close; k <= f->shape.close; ++k) {
            if (k != 0 && y + k >= 0 && y + k < (int64_t)f->r->height) {
                f->kernels->add_min(row_of(f, f->far, y + k), out, width);
            }
        }
        fill_pads(f, out, -1.0f);
    }
}

/// Upsamples the pyramid's blocks to pixels by interpolation.
static void spread_pyramid(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    const stp_depth_pyramid* p = f->pyramid;
    const uint32_t level = STP_EFFECT_LEVEL;
    assert(level < p->level_count);
    float* mixed = scratch_row(f, worker, 0);
    assert(p->columns[level] + 2 <= f->stride - f->pad && "blocks and both their ends fit a row");
    for (size_t y = begin; y < end; ++y) {
        float at = ((float)y + 0.5f) / (float)STP_EFFECT_BLOCK - 0.5f;
        at = at > 0.0f ? at : 0.0f;
        uint32_t above = (uint32_t)at, below = above + 1 < p->rows[level] ? above + 1 : above;
        const float* rows[2] = {p->levels[level] + (size_t)above * p->columns[level],
                                p->levels[level] + (size_t)below * p->columns[level]};
        float* out = row_of(f, f->far, (int64_t)y);
        f->kernels->spread(rows, at - (float)above, mixed, p->columns[level], out, f->r->width);
        fill_pads(f, out, -1.0f);
    }
}

static void light_row(const effect_frame* f, int64_t y, const float* gain, float* out)
{
    static const int8_t ring[4][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}};
    const float* center = row_of(f, f->near, y);
    int32_t step = f->shape.light_step;
    assert(step > 0 && (size_t)(2 * step) <= f->pad && "neighbours lie in the pads");
    memset(out, 0, f->r->width * sizeof(float));
    for (int32_t reach = step; reach <= 2 * step; reach += step) { // two scales
        for (int i = 0; i < 4; ++i) {
            int32_t dx = ring[i][0] * reach, dy = ring[i][1] * reach;
            const float* const neighbours[2] = {row_of(f, f->near, y + dy) + dx,
                                                row_of(f, f->near, y - dy) - dx};
            float length = dx != 0 && dy != 0 ? 1.41421356f : 1.0f;
            f->kernels->rise(center, gain, neighbours, 1.0f / (length * (float)reach), out,
                             f->r->width);
        }
    }
    f->kernels->eye_dome(out, f->shape.light, f->r->width);
}

static void find_occlusion(const effect_frame* f, int64_t y, const float* gain)
{
    float* out = row_of(f, f->spare, y);
    const float* center = row_of(f, f->near, y);
    memset(out, 0, f->r->width * sizeof(float));
    fill_pads(f, out, 0.0f); // blurred with weight 0, but must not be NaN
    for (uint32_t i = 0; i < f->shape.pair_count; ++i) {
        const stp_effect_pair* p = &f->shape.pairs[i];
        float* plane = p->far ? f->far : f->near;
        const float* const neighbours[2] = {row_of(f, plane, y + p->y) + p->x,
                                            row_of(f, plane, y - p->y) - p->x};
        f->kernels->pair(center, gain, neighbours, p->numbers, out, f->r->width);
    }
}

static void find_shades(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    float* gain = scratch_row(f, worker, 0);
    for (int64_t y = (int64_t)begin; y < (int64_t)end; ++y) {
        f->kernels->gain(row_of(f, f->near, y), f->scale, f->constant, gain, f->r->width);
        if (f->r->style->eye_dome > 0.0f) {
            light_row(f, y, gain, row_of(f, f->factor, y));
        }
        if (f->shape.pair_count > 0) {
            find_occlusion(f, y, gain);
        }
    }
}

/// One direction of the blur: from a plane into a row of sums, then their means.
static void blur_row(const effect_frame* f, int64_t y, bool down, float* plane, uint32_t worker,
                     float* out)
{
    uint32_t width = f->r->width;
    float *gain = scratch_row(f, worker, 0), *weights = scratch_row(f, worker, 1);
    const float* center = row_of(f, f->near, y);
    float* const sums[2] = {out, weights};
    f->kernels->gain(center, f->scale, f->constant, gain, width);
    memcpy(out, row_of(f, plane, y), width * sizeof(float));
    for (uint32_t x = 0; x < width; ++x) {
        weights[x] = 1.0f;
    }
    for (int32_t k = -BLUR_REACH; k <= BLUR_REACH; ++k) {
        int64_t row = down ? y + k : y;
        int32_t x = down ? 0 : k;
        if (k != 0 && row >= 0 && row < (int64_t)f->r->height) {
            float inverse = 1.0f / (BLUR_SLOPE * (float)abs(k));
            f->kernels->blur(center, gain, row_of(f, f->near, row) + x, row_of(f, plane, row) + x,
                             inverse, sums, width);
        }
    }
    for (uint32_t x = 0; x < width; ++x) {
        out[x] = out[x] / weights[x];
    }
}

static void blur_across(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    for (int64_t y = (int64_t)begin; y < (int64_t)end; ++y) {
        blur_row(f, y, false, f->spare, worker, row_of(f, f->far, y));
    }
}

static uint8_t darken(const stp_cpu_renderer* r, uint8_t color, float factor)
{
    float scaled = r->decode[color] * factor * (float)CPU_ENCODE_SIZE;
    float top = (float)(CPU_ENCODE_SIZE - 1);
    return r->encode[scaled >= top ? CPU_ENCODE_SIZE - 1 : (int)scaled];
}

static void darken_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const effect_frame* f = user;
    const stp_cpu_renderer* r = f->r;
    float* occlusion = scratch_row(f, worker, 2);
    float share =
        f->shape.pair_count > 0 ? STP_OCCLUSION_STRENGTH / (float)f->shape.pair_count : 0.0f;
    for (size_t y = begin; y < end; ++y) {
        const float* depth = r->depth + y * r->width;
        const float* light = row_of(f, f->factor, (int64_t)y);
        uint8_t* out = r->image->pixels + 4 * y * r->width;
        if (f->shape.pair_count > 0) {
            blur_row(f, (int64_t)y, true, f->far, worker, occlusion);
        }
        for (uint32_t x = 0; x < r->width; ++x, out += 4) {
            if (!(depth[x] > 0.0f)) {
                continue;
            }
            float factor = 1.0f;
            if (f->shape.pair_count > 0) {
                factor = 1.0f - occlusion[x] * share;
                factor = factor > STP_OCCLUSION_MIN ? factor : STP_OCCLUSION_MIN;
            }
            factor *= r->style->eye_dome > 0.0f ? light[x] : 1.0f;
            for (int k = 0; k < 3; ++k) {
                out[k] = darken(r, out[k], factor);
            }
        }
    }
}

static stp_result make_room(stp_cpu_renderer* r, effect_frame* f)
{
    stp_cpu_effects* e = &r->effects;
    int32_t reach = 3 * CLOSE_MAX;
    for (uint32_t i = 0; i < f->shape.pair_count; ++i) {
        int32_t x = abs(f->shape.pairs[i].x);
        reach = x > reach ? x : reach;
    }
    f->pad = ((size_t)reach + 16) / 16 * 16;
    assert(f->pad > (size_t)reach && f->shape.close <= CLOSE_MAX && "no kernel reads beyond a pad");
    f->stride = (f->pad + r->width + f->pad + 15) / 16 * 16;
    size_t plane = f->stride * r->height;
    size_t rows = 1 + (size_t)r->team.threads * SCRATCH_ROWS;
    size_t needed = 4 * plane + rows * f->stride;
    if (needed > e->capacity) {
        e->capacity = 0;
        stp_free(r->base.context, e->memory);
        e->memory = STP_NEW_ARRAY(r->base.context, float, needed);
        if (e->memory == NULL) {
            return stp_fail_memory(r->base.context);
        }
        e->capacity = needed;
    }
    assert(needed <= e->capacity);
    f->near = e->memory;
    f->spare = f->near + plane;
    f->far = f->spare + plane;
    f->factor = f->far + plane;
    f->outside = f->factor + plane;
    f->scratch = f->outside + f->stride;
    for (size_t i = 0; i < f->stride; ++i) {
        f->outside[i] = -1.0f;
    }
    return STP_OK;
}

/// Returns the pyramid that culling will use for the next frame; in parallel projection, without
/// culling, a separate one.
static stp_result find_pyramid(stp_cpu_renderer* r, effect_frame* f)
{
    stp_depth_pyramid* pyramid =
        r->frame.parallel ? &r->effects.pyramid : &r->pyramids[r->eye - r->eyes];
    stp_result result = stp_depth_pyramid_fill(r->base.context, &r->frame, r->depth, pyramid);
    r->eye->made = result == STP_OK && !r->frame.parallel;
    f->pyramid = pyramid;
    return result;
}

static void run(const effect_frame* f, stp_job job)
{
    effect_frame copy = *f;
    stp_team_run(&f->r->team, f->r->height, EFFECT_BAND_ROWS, job, &copy);
}

stp_result stp_cpu_apply_effects(stp_cpu_renderer* r)
{
    assert(stp_cpu_has_effects(r->style) && r->splat_size >= 0.0f);
    effect_frame f = {.r = r, .kernels = stp_cpu_choose_effect_kernels()};
    f.shape = stp_effect_shape_make(r->style, r->height, r->splat_size);
    f.constant = r->frame.parallel;
    double scale = r->frame.scale;
    f.scale = (float)(f.constant ? scale / fabs(r->nearness_scale) : scale);
    stp_result result = make_room(r, &f);
    if (result == STP_OK && f.shape.far) {
        result = find_pyramid(r, &f);
    }
    if (result != STP_OK) {
        return result;
    }
    if (f.shape.close > 0) {
        run(&f, widen_columns);
        run(&f, widen_rows);
    }
    run(&f, narrow_rows);
    if (f.shape.far) {
        run(&f, spread_pyramid);
    }
    run(&f, find_shades);
    if (f.shape.pair_count > 0) {
        run(&f, blur_across);
    }
    run(&f, darken_rows);
    return STP_OK;
}

void stp_cpu_destroy_effects(stp_cpu_renderer* r)
{
    stp_free(r->base.context, r->effects.memory);
    stp_depth_pyramid_destroy(r->base.context, &r->effects.pyramid);
}
