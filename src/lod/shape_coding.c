// SPDX-License-Identifier: MIT
#include "lod/shape_coding.h"

#include "base/coverage.h"

#define ANY_NORMALS (255u << 24) ///< of a disk

void stp_shape_directions_make(stp_shape_directions* directions)
{
    for (uint32_t code = 0; code < STP_SHAPE_TURN; ++code) {
        directions->smaller[code] = stp_shape_smaller(code << 24);
    }
}

static float off_axis(const stp_shape_directions* directions, uint32_t code, stp_shape_axis along)
{
    const stp_shape_axis* a = &directions->smaller[code];
    return a->along_x * along.along_x + a->along_y * along.along_y;
}

uint32_t stp_shape_direction(const stp_shape_directions* directions, stp_shape_axis along)
{
    // over half a turn the sign changes at most once: between the two codes that may be best
    bool negative = off_axis(directions, 0, along) < 0.0f;
    uint32_t low = 0, high = STP_SHAPE_TURN; // the sign changes between `low` and `high`
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        bool changed = (off_axis(directions, middle, along) < 0.0f) != negative;
        high = changed ? middle : high;
        low = changed ? low : middle;
    }
    uint32_t other = high < STP_SHAPE_TURN ? high : 0; // half a turn later is the first code again
    float off = fabsf(off_axis(directions, low, along));
    float other_off = fabsf(off_axis(directions, other, along));
    return other_off < off || (other_off == off && other < low) ? other : low;
}

uint32_t stp_shape_of_ellipse(const stp_shape_directions* directions, float larger, float smaller,
                              stp_vec3 major, const int8_t normal[2])
{
    uint32_t most = stp_shape_code(larger), least = stp_shape_code(smaller);
    if (least >= most) {
        return most | most << 12 | ANY_NORMALS;
    }
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    stp_shape_axis along = {stp_dot(major, axes.x), stp_dot(major, axes.y)};
    uint32_t direction = stp_shape_direction(directions, along);
    return most | least << 12 | direction << 24;
}
