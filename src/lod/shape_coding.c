// SPDX-License-Identifier: MIT
#include "base/splats/coverage.h"
#include "lod/set_columns.h"

#include <assert.h>
#include <math.h>

#define ANY_NORMALS (255u << 24) ///< unbounded normal spread of a disk

static float off_axis(const stp_shape_directions* directions, uint32_t code, stp_shape_axis along)
{
    const stp_shape_axis* a = &directions->smaller[code];
    return a->along_x * along.along_x + a->along_y * along.along_y;
}

/// Class of an axis by its slope: neighbouring directions have neighbouring classes.
static uint32_t slope_class(stp_shape_axis along)
{
    float x = along.along_y < 0.0f ? -along.along_x : along.along_x;
    float sum = fabsf(x) + fabsf(along.along_y);
    float place = sum > 0.0f ? 0.5f - 0.5f * x / sum : 0.0f;
    uint32_t index = (uint32_t)(place * (float)STP_SHAPE_GUESSES);
    return index < STP_SHAPE_GUESSES ? index : STP_SHAPE_GUESSES - 1;
}

/// Last code before the sign of the distance to the axis changes; it changes at most once.
/// @param low where to start
static uint32_t find_change(const stp_shape_directions* directions, stp_shape_axis along,
                            uint32_t low)
{
    bool negative = off_axis(directions, 0, along) < 0.0f;
    while ((off_axis(directions, low, along) < 0.0f) != negative) {
        low -= 1;
    }
    while (low + 1 < STP_SHAPE_TURN && (off_axis(directions, low + 1, along) < 0.0f) == negative) {
        low += 1;
    }
    assert(low < STP_SHAPE_TURN);
    return low;
}

void stp_shape_directions_make(stp_shape_directions* directions)
{
    for (uint32_t code = 0; code < STP_SHAPE_TURN; ++code) {
        directions->smaller[code] = stp_shape_smaller(code << 24);
    }
    uint32_t low = 0;
    for (uint32_t i = 0; i < STP_SHAPE_GUESSES; ++i) {
        float place = ((float)i + 0.5f) / (float)STP_SHAPE_GUESSES;
        float x = 1.0f - 2.0f * place;
        low = find_change(directions, (stp_shape_axis){x, 1.0f - fabsf(x)}, low);
        assert((i == 0 || low >= directions->guesses[i - 1]) && "classes ascend as codes do");
        directions->guesses[i] = (uint8_t)low;
    }
}

uint32_t stp_shape_direction(const stp_shape_directions* directions, stp_shape_axis along)
{
    // the distance to the axis is least at the change of its sign
    uint32_t low = find_change(directions, along, directions->guesses[slope_class(along)]);
    // half a turn later is the first code again
    uint32_t other = low + 1 < STP_SHAPE_TURN ? low + 1 : 0;
    float off = fabsf(off_axis(directions, low, along));
    float other_off = fabsf(off_axis(directions, other, along));
    return other_off < off || (other_off == off && other < low) ? other : low;
}

uint32_t stp_shape_of_codes(const stp_shape_directions* directions, uint32_t larger,
                            uint32_t smaller, stp_vec3 major, const int8_t normal[2])
{
    assert(larger < STP_SHAPE_NOT_FINITE);
    if (smaller >= larger) {
        return larger | larger << 12 | ANY_NORMALS;
    }
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    stp_shape_axis along = {stp_dot(major, axes.x), stp_dot(major, axes.y)};
    uint32_t direction = stp_shape_direction(directions, along);
    assert(direction < STP_SHAPE_TURN);
    return larger | smaller << 12 | direction << 24;
}

uint32_t stp_shape_of_ellipse(const stp_shape_directions* directions, float larger, float smaller,
                              stp_vec3 major, const int8_t normal[2])
{
    return stp_shape_of_codes(directions, stp_shape_code(larger), stp_shape_code(smaller), major,
                              normal);
}
