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

/// The direction whose smaller radius is most nearly across the larger axis.
static uint32_t find_direction(const stp_shape_directions* directions, float along_x, float along_y)
{
    uint32_t best = 0;
    float least = HUGE_VALF;
    for (uint32_t code = 0; code < STP_SHAPE_TURN; ++code) {
        const stp_shape_axis* a = &directions->smaller[code];
        float off = fabsf(a->along_x * along_x + a->along_y * along_y);
        best = off < least ? code : best;
        least = off < least ? off : least;
    }
    return best;
}

uint32_t stp_shape_of_ellipse(const stp_shape_directions* directions, float larger, float smaller,
                              stp_vec3 major, const int8_t normal[2])
{
    uint32_t most = stp_shape_code(larger), least = stp_shape_code(smaller);
    if (least >= most) {
        return most | most << 12 | ANY_NORMALS;
    }
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    uint32_t direction = find_direction(directions, stp_dot(major, axes.x), stp_dot(major, axes.y));
    return most | least << 12 | direction << 24;
}
