// SPDX-License-Identifier: MIT
// Point sets for tests of orders: random, clustered, flat, thin, coinciding, huge, tiny.
#pragma once

#include "base/math/math.h"
#include "base/math/rng.h"

#include <stdlib.h>

typedef enum test_shape {
    TEST_BOX,      ///< uniform in a box
    TEST_SPHERE,   ///< on a sphere, normals outwards
    TEST_WALL,     ///< on both sides of a thin wall, normals outwards
    TEST_CLUSTERS, ///< a few tight clusters and a far outlier
    TEST_LATTICE,  ///< a regular grid: equal distances everywhere
    TEST_LINE,     ///< collinear
    TEST_COPIES,   ///< few places, many points at each
    TEST_HUGE,     ///< coordinates near the largest float
    TEST_TINY,     ///< coordinates below the smallest normal float
    TEST_SHAPE_COUNT,
} test_shape;

static inline float test_unit(uint64_t seed, uint64_t index)
{
    return (float)(stp_rng_hash(seed, index) >> 40) * 0x1p-24f;
}

static inline stp_vec3 test_direction(uint64_t seed, uint64_t index)
{
    for (uint64_t k = 0;; ++k) {
        stp_vec3 v = {test_unit(seed + k, 3 * index) * 2.0f - 1.0f,
                      test_unit(seed + k, 3 * index + 1) * 2.0f - 1.0f,
                      test_unit(seed + k, 3 * index + 2) * 2.0f - 1.0f};
        float squared = stp_dot(v, v);
        if (squared > 0.01f && squared <= 1.0f) {
            return stp_normalize(v);
        }
    }
}

static inline void test_make_points(test_shape shape, uint64_t seed, uint32_t count,
                                    float* positions, float* normals)
{
    for (uint32_t i = 0; i < count; ++i) {
        float u = test_unit(seed, 4 * (uint64_t)i), v = test_unit(seed, 4 * (uint64_t)i + 1),
              w = test_unit(seed, 4 * (uint64_t)i + 2);
        stp_vec3 n = test_direction(seed ^ 77, i), p = {u * 3.0f, v * 2.0f, w};
        switch (shape) {
        case TEST_BOX:
        case TEST_SHAPE_COUNT:
            break;
        case TEST_SPHERE:
            p = n;
            break;
        case TEST_WALL:
            n = (stp_vec3){0.0f, 0.0f, w < 0.5f ? -1.0f : 1.0f};
            p.z = w < 0.5f ? 0.0f : 0.02f;
            break;
        case TEST_CLUSTERS:
            p = stp_add((stp_vec3){(float)(i % 3) * 5.0f, 0.0f, 1.0f}, stp_scale(p, 0.001f));
            p = i == 0 ? (stp_vec3){1e6f, 0.0f, 0.0f} : p;
            break;
        case TEST_LATTICE:
            p = (stp_vec3){(float)(i % 11), (float)(i / 11 % 11), (float)(i / 121)};
            break;
        case TEST_LINE:
            p = (stp_vec3){u, 2.0f * u, -u};
            break;
        case TEST_COPIES:
            p = (stp_vec3){(float)(i % 5), (float)(i % 3), 0.0f};
            break;
        case TEST_HUGE:
            p = (stp_vec3){(u * 2.0f - 1.0f) * 3e38f, (v * 2.0f - 1.0f) * 3e38f, w};
            break;
        case TEST_TINY:
            p = (stp_vec3){u * 1e-39f, v * 1e-39f, w * 1e-40f};
            break;
        }
        positions[3 * i] = p.x;
        positions[3 * i + 1] = p.y;
        positions[3 * i + 2] = p.z;
        normals[3 * i] = n.x;
        normals[3 * i + 1] = n.y;
        normals[3 * i + 2] = n.z;
    }
}
