// SPDX-License-Identifier: MIT
// Codes of elliptical splats, against a search through all directions.
#include "tests.h"

#include "base/math/rng.h"
#include "lod/set_columns.h"

static double off_of(const stp_shape_directions* directions, uint32_t code, stp_shape_axis along)
{
    const stp_shape_axis* a = &directions->smaller[code];
    return fabs((double)a->along_x * (double)along.along_x +
                (double)a->along_y * (double)along.along_y);
}

void test_shape_directions_are_the_nearest(test_state* test)
{
    stp_shape_directions directions;
    stp_shape_directions_make(&directions);
    for (uint64_t i = 0; i < 4096; ++i) {
        // axes along each coded direction, between two, and random ones
        stp_shape_axis along = directions.smaller[i % STP_SHAPE_TURN];
        if (i >= STP_SHAPE_TURN) {
            along.along_x = (float)((double)(stp_rng_hash(3, i) >> 11) * 0x1p-52 - 1.0);
            along.along_y = (float)((double)(stp_rng_hash(4, i) >> 11) * 0x1p-52 - 1.0);
        }
        double minimum = HUGE_VAL;
        for (uint32_t code = 0; code < STP_SHAPE_TURN; ++code) {
            minimum = fmin(minimum, off_of(&directions, code, along));
        }
        uint32_t found = stp_shape_direction(&directions, along);
        CHECK(found < STP_SHAPE_TURN);
        CHECK(off_of(&directions, found, along) <= minimum + 1e-7);
    }
    CHECK_EQUAL(0, stp_shape_direction(&directions, (stp_shape_axis){0.0f, 0.0f}));
}
