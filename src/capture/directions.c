// SPDX-License-Identifier: MIT
#include "capture/capture.h"

#include <assert.h>

/// Corners of a cube, then the middles of its faces, then of its edges.
static void cube_directions(uint32_t count, stp_vec3d* directions)
{
    static const int components[3] = {3, 1, 2}; // non-zero components
    uint32_t made = 0;
    for (int step = 0; made < count; ++step) {
        assert(step < 3);
        for (int code = 0; code < 27; ++code) {
            int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
            if ((x != 0) + (y != 0) + (z != 0) == components[step]) {
                assert(made < count && "counts end with whole steps");
                directions[made++] = stp_normalized((stp_vec3d){(double)x, (double)y, (double)z});
            }
        }
    }
}

/// A spiral of golden angles (Fibonacci lattice). Advances the angle by rotation, so needs no sine.
static void spiral_directions(uint32_t count, stp_vec3d* directions)
{
    const double turn_cosine = -0.7373688780783197, turn_sine = 0.6754902942615238;
    double c = 1.0, s = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        double y = 1.0 - (2.0 * (double)i + 1.0) / (double)count;
        assert(y > -1.0 && y < 1.0);
        double r = sqrt(1.0 - y * y);
        directions[i] = (stp_vec3d){r * c, y, r * s};
        double next = c * turn_cosine - s * turn_sine;
        s = c * turn_sine + s * turn_cosine;
        double length = sqrt(next * next + s * s);
        c = next / length;
        s /= length;
    }
}

void stp_capture_directions(uint32_t count, stp_vec3d* directions)
{
    if (count == 8 || count == 14 || count == 26) {
        cube_directions(count, directions);
    } else {
        spiral_directions(count, directions);
    }
}
