// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/closed_surface.h"

/// The side of a shape of four corners, turned and moved.
static int side_of(const uint8_t (*triangles)[3], int count, bool flat, float far)
{
    stp_closed_surface surface = {0};
    float corners[4][3];
    for (int i = 0; i < 4; ++i) {
        float x = i == 1 || i == 2 ? 0.7f : 0.1f, y = i >= 2 ? 0.9f : 0.2f;
        float z = flat || i != 3 ? 0.0f : 0.5f;
        corners[i][0] = 0.36f * x + 0.48f * y - 0.8f * z + far;
        corners[i][1] = -0.8f * x + 0.6f * y - 1.3f * far;
        corners[i][2] = 0.48f * x + 0.64f * y + 0.6f * z + 0.7f * far;
    }
    for (int i = 0; i < count; ++i) {
        const uint8_t* t = triangles[i];
        stp_closed_surface_add(
            &surface, (const float* const[3]){corners[t[0]], corners[t[1]], corners[t[2]]});
    }
    return stp_closed_surface_side(&surface);
}

void test_flat_closed_surfaces_have_no_side(test_state* test)
{
    static const uint8_t card[4][3] = {{0, 1, 2}, {0, 2, 3}, {2, 1, 0}, {3, 2, 0}};
    static const uint8_t other[4][3] = {{0, 1, 2}, {0, 2, 3}, {1, 0, 2}, {0, 3, 2}};
    static const uint8_t inward[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
    static const uint8_t outward[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    static const float far[] = {0.0f, 0.3f, 7.7f, 113.1f, 1234.5f};
    for (int i = 0; i < 5; ++i) {
        CHECK_EQUAL(0, side_of(card, 4, true, far[i]));
        CHECK_EQUAL(0, side_of(other, 4, true, far[i]));
        CHECK_EQUAL(0, side_of(card, 2, true, far[i])); // open
        CHECK_EQUAL(-1, side_of(inward, 4, false, far[i]));
        CHECK_EQUAL(1, side_of(outward, 4, false, far[i]));
    }
}
