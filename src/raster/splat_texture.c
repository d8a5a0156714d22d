// SPDX-License-Identifier: MIT
#include "raster/splat_texture.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>

enum { SIDE = STP_SPLAT_TEXTURE_SIDE };

/// Centre of a texel, -1 to 1.
static double place(int at)
{
    return (2.0 * (double)at + 1.0) / (double)SIDE - 1.0;
}

stp_splat_texture stp_splat_texture_gaussian(void)
{
    stp_splat_texture texture;
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            double square = place(x) * place(x) + place(y) * place(y);
            texture.texels[y * SIDE + x] = (uint8_t)(255.0 * exp(-2.0 * square) + 0.5);
        }
    }
    return texture;
}

static bool is_opaque(const stp_image* image)
{
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i) {
        if (image->pixels[4 * i + 3] != 255) {
            return false;
        }
    }
    return true;
}

static double read_pixel(const stp_image* image, bool opaque, uint32_t x, uint32_t y)
{
    const uint8_t* p = image->pixels + 4 * ((size_t)y * image->width + x);
    double luma = (0.299 * (double)p[0] + 0.587 * (double)p[1]) + 0.114 * (double)p[2];
    return opaque ? luma : (double)p[3];
}

/// Overlap of pixel `at` with [low, high).
static double overlap(uint32_t at, double low, double high)
{
    double begin = fmax((double)at, low), end = fmin((double)at + 1.0, high);
    return end > begin ? end - begin : 0.0;
}

/// Area-weighted mean of the pixels under one texel.
static double average(const stp_image* image, bool opaque, int x, int y)
{
    double wide = (double)image->width / (double)SIDE, high = (double)image->height / (double)SIDE;
    double left = x * wide, right = left + wide, top = y * high, bottom = top + high;
    double sum = 0.0, weights = 0.0;
    for (uint32_t v = (uint32_t)top; v < image->height && (double)v < bottom; ++v) {
        for (uint32_t u = (uint32_t)left; u < image->width && (double)u < right; ++u) {
            double weight = overlap(u, left, right) * overlap(v, top, bottom);
            sum += weight * read_pixel(image, opaque, u, v);
            weights += weight;
        }
    }
    assert(weights > 0.0 && sum <= 255.5 * weights && "a texel covers some of the image");
    return weights > 0.0 ? sum / weights : 0.0;
}

stp_splat_texture stp_splat_texture_of_image(const stp_image* image)
{
    assert(image->width > 0 && image->height > 0);
    stp_splat_texture texture;
    bool opaque = is_opaque(image);
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            texture.texels[y * SIDE + x] = (uint8_t)(average(image, opaque, x, y) + 0.5);
        }
    }
    return texture;
}

float stp_splat_texture_mean(const stp_splat_texture* texture)
{
    uint32_t sum = 0, count = 0;
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            bool inside = place(x) * place(x) + place(y) * place(y) <= 1.0;
            sum += inside ? texture->texels[y * SIDE + x] : 0;
            count += inside ? 1 : 0;
        }
    }
    assert(count > 0 && sum <= 255 * count);
    return (float)sum / (255.0f * (float)count);
}
