// SPDX-License-Identifier: MIT
#include "lab/scenes/noise.h"

#include "base/math/rng.h"

// The cell of a coordinate, and the smoothed position in it.
static int64_t find_cell(double x, double* blend)
{
    int64_t cell = (int64_t)x - (x < 0.0 ? 1 : 0);
    double t = x - (double)cell;
    *blend = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    return cell;
}

static double lattice(uint64_t seed, int64_t x, int64_t y, int64_t z)
{
    uint64_t h = (uint64_t)x * UINT64_C(0x9E3779B97F4A7C15) +
                 (uint64_t)y * UINT64_C(0xC2B2AE3D27D4EB4F) +
                 (uint64_t)z * UINT64_C(0x165667B19E3779F9);
    return (double)(int64_t)stp_rng_hash(seed, h) * (1.0 / 9223372036854775808.0);
}

static double blend(double a, double b, double t)
{
    return a + (b - a) * t;
}

static double layer(uint64_t seed, int64_t x, int64_t y, int64_t z, double u, double v)
{
    return blend(blend(lattice(seed, x, y, z), lattice(seed, x + 1, y, z), u),
                 blend(lattice(seed, x, y + 1, z), lattice(seed, x + 1, y + 1, z), u), v);
}

double noise2(uint64_t seed, double x, double y)
{
    double u, v;
    int64_t i = find_cell(x, &u), j = find_cell(y, &v);
    return layer(seed, i, j, 0, u, v);
}

static double noise3(uint64_t seed, double x, double y, double z)
{
    double u, v, w;
    int64_t i = find_cell(x, &u), j = find_cell(y, &v), k = find_cell(z, &w);
    return blend(layer(seed, i, j, k, u, v), layer(seed, i, j, k + 1, u, v), w);
}

double noise2_octaves(uint64_t seed, double x, double y, int count)
{
    double sum = 0.0, height = 0.5;
    for (int i = 0; i < count; ++i, height *= 0.5) {
        sum += height * noise2(seed + (uint64_t)i, x, y);
        x *= 2.0;
        y *= 2.0;
    }
    return sum;
}

double noise3_octaves(uint64_t seed, double x, double y, double z, int count)
{
    double sum = 0.0, height = 0.5;
    for (int i = 0; i < count; ++i, height *= 0.5) {
        sum += height * noise3(seed + (uint64_t)i, x, y, z);
        x *= 2.0;
        y *= 2.0;
        z *= 2.0;
    }
    return sum;
}
