// SPDX-License-Identifier: MIT
// Triangles along a Hilbert curve.
// Skilling. Programming the Hilbert Curve. 2004 (without its branches).
#include "base/sort.h"
#include "store/clusters_encode.h"

enum { CURVE_BITS = 10, INDEX_BITS = 32 };

/// Zeros between the bits of a number of ten.
static uint32_t spread(uint32_t x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    x = (x | x << 2) & 0x09249249u;
    return x;
}

static uint32_t curve_place(uint32_t x, uint32_t y, uint32_t z)
{
    for (uint32_t bit = CURVE_BITS - 1; bit > 0; --bit) {
        uint32_t low = (1u << bit) - 1;
        x ^= low & (0u - (x >> bit & 1u));
        uint32_t set = 0u - (y >> bit & 1u);
        uint32_t swap = (x ^ y) & low & ~set;
        x ^= swap | (low & set);
        y ^= swap;
        set = 0u - (z >> bit & 1u);
        swap = (x ^ z) & low & ~set;
        x ^= swap | (low & set);
        z ^= swap;
    }
    y ^= x;
    z ^= y;
    uint32_t flip = 0;
    for (uint32_t bit = CURVE_BITS - 1; bit > 0; --bit) {
        flip ^= ((1u << bit) - 1) & (0u - (z >> bit & 1u));
    }
    return spread(x ^ flip) << 2 | spread(y ^ flip) << 1 | spread(z ^ flip);
}

/// Three times the middle.
static void sum_corners(const stp_store_mesh* mesh, uint32_t triangle, double sum[3])
{
    const uint32_t* corner = mesh->indices + 3 * (size_t)triangle;
    const float* a = mesh->positions + 3 * (size_t)corner[0];
    const float* b = mesh->positions + 3 * (size_t)corner[1];
    const float* c = mesh->positions + 3 * (size_t)corner[2];
    for (int k = 0; k < 3; ++k) {
        sum[k] = (double)a[k] + (double)b[k] + (double)c[k];
    }
}

uint64_t* clusters_sort(const stp_store_mesh* mesh, uint64_t* items, uint64_t* scratch)
{
    double least[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, most[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    double sum[3];
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        sum_corners(mesh, t, sum);
        for (int k = 0; k < 3; ++k) {
            least[k] = sum[k] < least[k] ? sum[k] : least[k];
            most[k] = sum[k] > most[k] ? sum[k] : most[k];
        }
    }
    double extent = 0.0;
    for (int k = 0; k < 3; ++k) {
        extent = most[k] - least[k] > extent ? most[k] - least[k] : extent;
    }
    double scale = extent > 0.0 ? ((1 << CURVE_BITS) - 1) / extent : 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        sum_corners(mesh, t, sum);
        uint32_t cell[3];
        for (int k = 0; k < 3; ++k) {
            cell[k] = (uint32_t)((sum[k] - least[k]) * scale);
        }
        items[t] = (uint64_t)curve_place(cell[0], cell[1], cell[2]) << INDEX_BITS | t;
    }
    return stp_sort_u64(items, scratch, mesh->triangle_count, INDEX_BITS, 3 * CURVE_BITS);
}
