// SPDX-License-Identifier: MIT
#include "program/measure/image_compare.h"

#include <assert.h>
#include <math.h>

#define GREY_PEAK 255000.0 // grey is 299 R + 587 G + 114 B: integers, exact in a float
#define PIXEL_GRAIN ((size_t)1 << 16)

enum { SCALES = 5 };

// Wang, Simoncelli, Bovik 2003, "Multi-scale structural similarity for image quality
// assessment", 3.2
static const double scale_weights[SCALES] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};

/// The pictures at the current scale.
typedef struct pictures {
    const stp_image *a, *b, *mask;
    uint32_t width, height; ///< size at this scale
    float *grey_a, *grey_b;
    uint8_t* counted;
    uint64_t* square_errors; ///< per task of PIXEL_GRAIN pixels, over the three channels
} pictures;

static float to_grey(const int color[3])
{
    return (float)(299 * color[0] + 587 * color[1] + 114 * color[2]);
}

static bool is_counted(const pictures* p, size_t i)
{
    if (p->a->pixels[4 * i + 3] == 0 && p->b->pixels[4 * i + 3] == 0) {
        return false;
    }
    const uint8_t* mask = p->mask != NULL ? p->mask->pixels + 4 * i : NULL;
    return mask == NULL || (mask[3] > 0 && (mask[0] > 127 || mask[1] > 127 || mask[2] > 127));
}

static void prepare_pixels(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    pictures* p = user;
    uint64_t sum = 0;
    for (size_t i = begin; i < end; ++i) {
        int a[3], b[3];
        for (int channel = 0; channel < 3; ++channel) {
            a[channel] = stp_composite_on_black(p->a->pixels + 4 * i, channel);
            b[channel] = stp_composite_on_black(p->b->pixels + 4 * i, channel);
            sum += (uint64_t)((a[channel] - b[channel]) * (a[channel] - b[channel]));
        }
        p->grey_a[i] = to_grey(a);
        p->grey_b[i] = to_grey(b);
        p->counted[i] = is_counted(p, i);
    }
    p->square_errors[begin / PIXEL_GRAIN] = sum;
}

// Halves a plane in place by averaging 2 x 2 pixels. An odd last row or column is averaged with
// itself, as in the authors' program (symmetric padding).
static void halve(float* plane, uint32_t width, uint32_t height)
{
    assert(width > 0 && height > 0);
    uint32_t half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    for (uint32_t y = 0; y < half_height; ++y) {
        const float* row0 = plane + (size_t)(2 * y) * width;
        const float* row1 = 2 * y + 1 < height ? row0 + width : row0;
        float* out = plane + (size_t)y * half_width;
        for (uint32_t x = 0; x < half_width; ++x) {
            uint32_t x0 = 2 * x, x1 = x0 + 1 < width ? x0 + 1 : x0;
            out[x] = 0.25f * ((row0[x0] + row0[x1]) + (row1[x0] + row1[x1]));
        }
    }
}

static double peak_ratio(const pictures* p, size_t pixel_count)
{
    uint64_t sum = 0;
    for (size_t i = 0; i * PIXEL_GRAIN < pixel_count; ++i) {
        sum += p->square_errors[i];
    }
    return sum == 0 ? STP_PSNR_EQUAL
                    : 10.0 * log10(255.0 * 255.0 * 3.0 * (double)pixel_count / (double)sum);
}

// Number of scales that are large enough for a whole window.
static int count_scales(uint32_t width, uint32_t height)
{
    int count = 1;
    uint32_t size = width < height ? width : height;
    for (size = (size + 1) / 2; count < SCALES && size > 2 * STP_SSIM_RADIUS;
         size = (size + 1) / 2) {
        count += 1;
    }
    assert(count > 0 && count <= SCALES);
    return count;
}

static stp_result measure(stp_context* context, pictures* p, uint8_t* map,
                          stp_image_quality* quality)
{
    int scale_count = count_scales(p->width, p->height);
    double weight_sum = scale_count == SCALES ? 1.0 : 0.0; // the published weights sum to 1.0001
    for (int i = 0; scale_count < SCALES && i < scale_count; ++i) {
        weight_sum += scale_weights[i];
    }
    assert(weight_sum > 0.0);
    quality->ms_ssim = 1.0;
    for (int i = 0; i < scale_count; ++i) {
        stp_ssim_planes planes = {.width = p->width,
                                  .height = p->height,
                                  .peak = GREY_PEAK,
                                  .a = p->grey_a,
                                  .b = p->grey_b,
                                  .counted = i == 0 ? p->counted : NULL,
                                  .map = i == 0 ? map : NULL};
        stp_ssim_means means;
        stp_result result = stp_ssim(context, &planes, &means);
        if (result != STP_OK) {
            return result;
        }
        if (i == 0) {
            quality->ssim = means.ssim;
            quality->ssim_covered = means.counted;
        }
        // luminance is compared at the coarsest scale only
        double factor = i + 1 < scale_count ? means.contrast_structure : means.ssim;
        quality->ms_ssim *= pow(factor > 0.0 ? factor : 0.0, scale_weights[i] / weight_sum);
        halve(p->grey_a, p->width, p->height);
        halve(p->grey_b, p->width, p->height);
        p->width = (p->width + 1) / 2;
        p->height = (p->height + 1) / 2;
    }
    return STP_OK;
}

static stp_result check_sizes(stp_context* context, const stp_image* a, const stp_image* b,
                              const stp_image* mask)
{
    if (a->width != b->width || a->height != b->height) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "pictures of %u x %u and %u x %u cannot be compared", a->width, a->height,
                        b->width, b->height);
    }
    if (mask != NULL && (mask->width != a->width || mask->height != a->height)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "the mask is of %u x %u, the pictures are of %u x %u", mask->width,
                        mask->height, a->width, a->height);
    }
    if (a->width == 0 || a->height == 0) {
        return stp_fail(context, STP_ERROR_ARGUMENT, "pictures without pixels cannot be compared");
    }
    return STP_OK;
}

stp_result stp_image_compare(stp_context* context, const stp_image* a, const stp_image* b,
                             const stp_image* mask, stp_image* map, stp_image_quality* quality)
{
    stp_result result = check_sizes(context, a, b, mask);
    if (result != STP_OK) {
        return result;
    }
    size_t pixel_count = (size_t)a->width * a->height;
    pictures p = {
        .a = a,
        .b = b,
        .mask = mask,
        .width = a->width,
        .height = a->height,
        .grey_a = STP_NEW_ARRAY(context, float, pixel_count),
        .grey_b = STP_NEW_ARRAY(context, float, pixel_count),
        .counted = STP_NEW_ARRAY(context, uint8_t, pixel_count),
        .square_errors = STP_NEW_ARRAY(context, uint64_t, pixel_count / PIXEL_GRAIN + 1),
    };
    uint8_t* map_pixels = map != NULL ? stp_alloc_array(context, pixel_count, 4) : NULL;
    if (p.grey_a == NULL || p.grey_b == NULL || p.counted == NULL || p.square_errors == NULL ||
        (map != NULL && map_pixels == NULL)) {
        result = stp_fail_memory(context);
    } else {
        stp_parallel_for(context, pixel_count, PIXEL_GRAIN, prepare_pixels, &p);
        quality->psnr = peak_ratio(&p, pixel_count);
        result = measure(context, &p, map_pixels, quality);
    }
    if (result == STP_OK && map != NULL) {
        *map = (stp_image){.width = a->width, .height = a->height, .pixels = map_pixels};
        map_pixels = NULL;
    }
    stp_free(context, map_pixels);
    stp_free(context, p.square_errors);
    stp_free(context, p.counted);
    stp_free(context, p.grey_b);
    stp_free(context, p.grey_a);
    return result;
}
