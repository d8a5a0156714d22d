// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/position_grid.h"

#include <math.h>

enum { SIDE = 8 }; // cells

/// Ground of SIDE x SIDE cells with two large triangles each, `width` wide, from a corner on. The
/// caller has space for the indices of 2 * SIDE * SIDE triangles.
static void make_ground(float cell, float height, float corner, float* positions, uint32_t* indices)
{
    for (uint32_t row = 0; row <= SIDE; ++row) {
        for (uint32_t column = 0; column <= SIDE; ++column) {
            float* p = positions + (size_t)3 * (row * (SIDE + 1) + column);
            p[0] = corner + cell * (float)column;
            p[1] = height;
            p[2] = corner + cell * (float)row;
        }
    }
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        uint32_t a = i / SIDE * (SIDE + 1) + i % SIDE, b = a + SIDE + 1;
        const uint32_t corners[6] = {a, b, a + 1, a + 1, b, b + 1};
        for (uint32_t k = 0; k < 6; ++k) {
            indices[6 * i + k] = corners[k];
        }
    }
}

void test_position_grid_keeps_large_triangles_off_those_above_them(test_state* test)
{
    static const float corners[] = {0.0f, -128.0f, 4000.0f};
    static float positions[3 * (SIDE + 1) * (SIDE + 1)];
    static uint32_t indices[6 * SIDE * SIDE];
    for (size_t i = 0; i < 3; ++i) {
        make_ground(32.0f, -0.12f, corners[i], positions, indices);
        double step = stp_choose_grid_step(positions, indices, 2 * SIDE * SIDE);
        CHECK(step <= 256.0 / 16384.0); // relative to the size, not to the position
        CHECK(step >= 256.0 / 65536.0); // and no finer than required
        CHECK(fabs(nearbyint(-0.12 / step) * step + 0.12) < 0.01);
    }
    make_ground(0.001f, 0.0f, 0.0f, positions, indices); // small geometry stays in proportion
    CHECK(stp_choose_grid_step(positions, indices, 2 * SIDE * SIDE) <= 0.008 / 16384.0);
}
