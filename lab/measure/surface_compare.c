// SPDX-License-Identifier: MIT
#include "lab/measure/surface_compare.h"

#include <assert.h>
#include <stdbool.h>

enum { WINDOW = 2 }; // pixels to each side

// The reference around a pixel.
typedef struct surroundings {
    bool inside;    ///< the whole window is covered
    float farthest; ///< least nearness of its covered pixels; 0 if there are none
} surroundings;

static surroundings find_surroundings(const stp_surface_frame* frame, int64_t x, int64_t y)
{
    surroundings around = {.inside = true};
    for (int64_t v = y - WINDOW; v <= y + WINDOW; ++v) {
        for (int64_t u = x - WINDOW; u <= x + WINDOW; ++u) {
            bool outside = u < 0 || v < 0 || u >= frame->width || v >= frame->height;
            if (outside) {
                continue; // the picture's border is not a silhouette
            }
            float nearness = frame->nearness[(size_t)v * frame->width + (size_t)u];
            if (!(nearness > 0.0f)) {
                around.inside = false;
            } else if (around.farthest == 0.0f || nearness < around.farthest) {
                around.farthest = nearness;
            }
        }
    }
    return around;
}

void stp_surface_compare(const stp_surface_frame* reference, const stp_surface_frame* frame,
                         double pixel_angle, double tolerance, stp_surface_errors* errors)
{
    assert(reference->width == frame->width && reference->height == frame->height);
    assert(pixel_angle >= 0.0 && tolerance >= 0.0);
    *errors = (stp_surface_errors){0};
    // behind by more than t pixels: depth (1 - t angle) > farthest depth, and depth is 1 / nearness
    double factor = 1.0 - pixel_angle * tolerance;
    for (uint32_t y = 0; y < reference->height; ++y) {
        for (uint32_t x = 0; x < reference->width; ++x) {
            size_t at = (size_t)y * reference->width + x;
            bool covered = reference->nearness[at] > 0.0f;
            bool drawn = frame->nearness[at] > 0.0f;
            errors->covered += covered;
            errors->drawn += drawn;
            errors->extra += !covered && drawn;
            if (covered) {
                surroundings around = find_surroundings(reference, x, y);
                errors->interior += around.inside;
                errors->holes += !drawn && around.inside;
                errors->wrong_depth +=
                    drawn && (double)frame->nearness[at] < (double)around.farthest * factor;
            }
        }
    }
    assert(errors->holes <= errors->interior && errors->interior <= errors->covered);
    assert(errors->extra <= errors->drawn && errors->wrong_depth <= errors->covered);
}
