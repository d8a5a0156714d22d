// SPDX-License-Identifier: MIT
#include "program/measure/image_compare.h"

#include <assert.h>
#include <string.h>

enum {
    RADIUS = STP_SSIM_RADIUS,
    TAPS = 2 * RADIUS + 1,
    // a, b, a^2 + b^2, a b: the sum of the squares is enough, as only va + vb is needed
    MOMENTS = 4,
    BAND = 64, // rows of one task of work
};

// exp(-x^2 / (2 * 1.5^2)), x = 0..5, scaled so that the window sums to 1
static const double window[RADIUS + 1] = {0.2660117248617943,   0.21300553771125366,
                                          0.1093606895097,      0.03600077212843082,
                                          0.007598758135239184, 0.0010283800844791099};

/// Contribution of a row to the means. Rows are added in order, so threads do not matter.
typedef struct row_sums {
    double ssim, contrast_structure; ///< over pixels with a whole window
    double all_ssim, all_contrast_structure;
    double counted;
    uint64_t counted_pixels;
} row_sums;

/// Memory of one worker.
typedef struct scratch {
    double* source[MOMENTS];           ///< one row, RADIUS zeros before and after
    double* ring[TAPS][MOMENTS];       ///< rows filtered across, by row modulo TAPS
    double* filtered[MOMENTS];         ///< one row filtered both ways
    double *ssim, *contrast_structure; ///< one row
} scratch;

enum { ROWS = MOMENTS * (2 + TAPS) + 2 }; // rows of a scratch

typedef struct comparison {
    const stp_ssim_planes* planes;
    double c1, c2;
    const double* scale_x; ///< 1 / the sum of the weights inside, per column
    const double* scale_y; ///< per row
    const double* zero_row;
    row_sums* sums;
    scratch* workers;
} comparison;

// Reciprocal of the window weight that lies within 0..count - 1, for each centre.
static void fill_scales(double* scales, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        double sum = 0.0;
        bool is_truncated = false;
        for (int k = -RADIUS; k <= RADIUS; ++k) {
            int64_t at = (int64_t)i + k;
            bool is_inside = at >= 0 && at < (int64_t)count;
            sum += is_inside ? window[k < 0 ? -k : k] : 0.0;
            is_truncated |= !is_inside;
        }
        assert(sum > 0.0 && sum < 1.0 + 1e-9 && "weights of sum 1");
        scales[i] = is_truncated ? 1.0 / sum : 1.0;
    }
}

static void filter_across(const double* restrict padded, const double* restrict scale,
                          double* restrict out, size_t width)
{
    for (size_t x = 0; x < width; ++x) {
        const double* p = padded + x + RADIUS;
        double sum = window[0] * p[0];
        sum += window[1] * (p[-1] + p[1]);
        sum += window[2] * (p[-2] + p[2]);
        sum += window[3] * (p[-3] + p[3]);
        sum += window[4] * (p[-4] + p[4]);
        sum += window[5] * (p[-5] + p[5]);
        out[x] = sum * scale[x];
    }
}

static void filter_down(const double* const rows[TAPS], double scale, double* restrict out,
                        size_t width)
{
    for (size_t x = 0; x < width; ++x) {
        double sum = window[0] * rows[5][x];
        sum += window[1] * (rows[4][x] + rows[6][x]);
        sum += window[2] * (rows[3][x] + rows[7][x]);
        sum += window[3] * (rows[2][x] + rows[8][x]);
        sum += window[4] * (rows[1][x] + rows[9][x]);
        sum += window[5] * (rows[0][x] + rows[10][x]);
        out[x] = sum * scale;
    }
}

static void fill_ring(const comparison* c, scratch* s, size_t y)
{
    size_t width = c->planes->width;
    const float* restrict a = c->planes->a + y * width;
    const float* restrict b = c->planes->b + y * width;
    for (size_t x = 0; x < width; ++x) {
        double va = (double)a[x], vb = (double)b[x];
        s->source[0][x + RADIUS] = va;
        s->source[1][x + RADIUS] = vb;
        s->source[2][x + RADIUS] = va * va + vb * vb;
        s->source[3][x + RADIUS] = va * vb;
    }
    for (int m = 0; m < MOMENTS; ++m) {
        filter_across(s->source[m], c->scale_x, s->ring[y % TAPS][m], width);
    }
}

static void compare_row(const comparison* c, scratch* s, size_t y)
{
    size_t width = c->planes->width, height = c->planes->height;
    for (int m = 0; m < MOMENTS; ++m) {
        const double* rows[TAPS];
        for (size_t k = 0; k < TAPS; ++k) {
            bool is_inside = y + k >= RADIUS && y + k < height + RADIUS;
            rows[k] = is_inside ? s->ring[(y + k - RADIUS) % TAPS][m] : c->zero_row;
        }
        filter_down(rows, c->scale_y[y], s->filtered[m], width);
    }
    const double* restrict mean_a = s->filtered[0];
    const double* restrict mean_b = s->filtered[1];
    const double* restrict squares = s->filtered[2];
    const double* restrict products = s->filtered[3];
    for (size_t x = 0; x < width; ++x) {
        double product = mean_a[x] * mean_b[x];
        double square_sum = mean_a[x] * mean_a[x] + mean_b[x] * mean_b[x];
        double contrast_structure =
            (2.0 * (products[x] - product) + c->c2) / (squares[x] - square_sum + c->c2);
        s->contrast_structure[x] = contrast_structure;
        s->ssim[x] = contrast_structure * ((2.0 * product + c->c1) / (square_sum + c->c1));
    }
}

static void sum_row(const comparison* c, const scratch* s, size_t y)
{
    const stp_ssim_planes* planes = c->planes;
    row_sums sums = {0};
    for (size_t x = 0; x < planes->width; ++x) {
        sums.all_ssim += s->ssim[x];
        sums.all_contrast_structure += s->contrast_structure[x];
    }
    for (size_t x = RADIUS; x + RADIUS < planes->width; ++x) {
        sums.ssim += s->ssim[x];
        sums.contrast_structure += s->contrast_structure[x];
    }
    for (size_t x = 0; planes->counted != NULL && x < planes->width; ++x) {
        if (planes->counted[y * planes->width + x] != 0) {
            sums.counted += s->ssim[x];
            sums.counted_pixels += 1;
        }
    }
    for (size_t x = 0; planes->map != NULL && x < planes->width; ++x) {
        double value = s->ssim[x];
        uint8_t* pixel = planes->map + 4 * (y * planes->width + x);
        pixel[0] = (uint8_t)(value > 0.0 ? value * 255.0 + 0.5 : 0.0);
        pixel[1] = pixel[0];
        pixel[2] = pixel[0];
        pixel[3] = 255;
    }
    c->sums[y] = sums;
}

static void compare_band(size_t begin, size_t end, uint32_t worker, void* user)
{
    const comparison* c = user;
    scratch* s = &c->workers[worker];
    size_t height = c->planes->height;
    assert(begin < end && end <= height);
    for (size_t y = begin < RADIUS ? 0 : begin - RADIUS; y < begin + RADIUS && y < height; ++y) {
        fill_ring(c, s, y);
    }
    for (size_t y = begin; y < end; ++y) {
        if (y + RADIUS < height) {
            fill_ring(c, s, y + RADIUS);
        }
        compare_row(c, s, y);
        sum_row(c, s, y);
    }
}

// Divides a zeroed block into the rows of a worker.
static scratch divide(double* block, size_t stride)
{
    scratch s;
    for (int m = 0; m < MOMENTS; ++m) {
        s.source[m] = block;
        s.filtered[m] = block + stride;
        block += 2 * stride;
        for (int k = 0; k < TAPS; ++k, block += stride) {
            s.ring[k][m] = block;
        }
    }
    s.ssim = block;
    s.contrast_structure = block + stride;
    return s;
}

static stp_ssim_means add_rows(const stp_ssim_planes* planes, const row_sums* sums)
{
    uint32_t width = planes->width, height = planes->height;
    bool has_whole_window = width > 2 * RADIUS && height > 2 * RADIUS;
    stp_ssim_means means = {0};
    double count = has_whole_window ? (double)(width - 2 * RADIUS) * (double)(height - 2 * RADIUS)
                                    : (double)width * (double)height;
    uint64_t counted = 0;
    for (uint32_t y = 0; y < height; ++y) {
        if (!has_whole_window) {
            means.ssim += sums[y].all_ssim;
            means.contrast_structure += sums[y].all_contrast_structure;
        } else if (y >= RADIUS && y + RADIUS < height) {
            means.ssim += sums[y].ssim;
            means.contrast_structure += sums[y].contrast_structure;
        }
        means.counted += sums[y].counted;
        counted += sums[y].counted_pixels;
    }
    means.ssim /= count;
    means.contrast_structure /= count;
    means.counted = counted != 0 ? means.counted / (double)counted : 1.0;
    return means;
}

stp_result stp_ssim(stp_context* context, const stp_ssim_planes* planes, stp_ssim_means* means)
{
    assert(planes->width > 0 && planes->height > 0 && planes->peak > 0.0);
    uint32_t worker_count = stp_context_thread_count(context);
    size_t stride = (size_t)planes->width + 2 * RADIUS;
    size_t rows = (size_t)worker_count * ROWS + 2; // and scale_x, zero_row
    double* block = stp_alloc_zeroed(context, rows, stride * sizeof(double));
    double* scale_y = STP_NEW_ARRAY(context, double, planes->height);
    row_sums* sums = STP_NEW_ARRAY(context, row_sums, planes->height);
    scratch* workers = STP_NEW_ARRAY(context, scratch, worker_count);
    stp_result result = STP_OK;
    if (block == NULL || scale_y == NULL || sums == NULL || workers == NULL) {
        result = stp_fail_memory(context);
    } else {
        fill_scales(block, planes->width);
        fill_scales(scale_y, planes->height);
        for (uint32_t i = 0; i < worker_count; ++i) {
            workers[i] = divide(block + (2 + (size_t)i * ROWS) * stride, stride);
            assert(workers[i].contrast_structure == block + (1 + (i + (size_t)1) * ROWS) * stride);
        }
        double k1 = 0.01 * planes->peak, k2 = 0.03 * planes->peak;
        comparison c = {.planes = planes,
                        .c1 = k1 * k1,
                        .c2 = k2 * k2,
                        .scale_x = block,
                        .scale_y = scale_y,
                        .zero_row = block + stride,
                        .sums = sums,
                        .workers = workers};
        stp_parallel_for(context, planes->height, BAND, compare_band, &c);
        *means = add_rows(planes, sums);
    }
    stp_free(context, workers);
    stp_free(context, sums);
    stp_free(context, scale_y);
    stp_free(context, block);
    return result;
}
