// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/octahedral.h"

#include <string.h>

enum { COUNT = 3001 };

void test_many_octahedral_codes_are_those_of_each(test_state* test)
{
    static float normals[3 * COUNT];
    static int8_t codes[2 * COUNT + 2];
    for (uint32_t i = 0; i < 3 * COUNT; ++i) {
        // vectors of all lengths; many on the axes and edges of the octahedron, some zero or without
        // a direction
        uint64_t kind = stp_rng_below(1, 2 * i, 8);
        float value = (float)stp_rng_below(1, 2 * i + 1, 2001) * 1e-3f - 1.0f;
        normals[i] = kind == 0 ? 0.0f : kind == 1 ? -0.0f : kind == 2 ? 0.5f : value;
        normals[i] *= i % 1000 < 100 ? 1e-30f : i % 1000 < 200 ? 1e30f : 1.0f;
    }
    normals[30] = normals[61] = INFINITY;
    memset(normals + 90, 0, 12 * sizeof(float));
    codes[2 * COUNT] = codes[2 * COUNT + 1] = 99;
    stp_octahedral_encode_many(normals, COUNT, codes);
    for (uint32_t i = 0; i < COUNT; ++i) {
        int8_t single[2];
        stp_octahedral_encode((stp_vec3){normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]},
                              single);
        CHECK_EQUAL(single[0], codes[2 * i]);
        CHECK_EQUAL(single[1], codes[2 * i + 1]);
    }
    CHECK_EQUAL(99, codes[2 * COUNT]);
    CHECK_EQUAL(99, codes[2 * COUNT + 1]);
}
