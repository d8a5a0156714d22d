// SPDX-License-Identifier: MIT
#include "draw/placement.h"

#include <assert.h>

stp_bounding stp_bounding_make(const float rows[4][4], float nearness_limit, const float offset[3],
                               uint32_t width, uint32_t height)
{
    stp_bounding bounding;
    assert(width > 0 && height > 0 && "an empty picture has no sides");
    double right = (double)width + 1.0, bottom = (double)height + 1.0;
    for (int c = 0; c < 4; ++c) {
        double x = (double)rows[0][c], y = (double)rows[1][c];
        double near = (double)rows[2][c], w = (double)rows[3][c];
        double planes[5] = {x + w, right * w - x, y + w, bottom * w - y,
                            (double)nearness_limit * w - near};
        for (int i = 0; i < 5; ++i) {
            if (c < 3) {
                bounding.a[i][c] = planes[i];
            } else {
                bounding.b[i] = planes[i];
            }
        }
        bounding.depth[c] = rows[3][c];
    }
    for (int c = 0; c < 3; ++c) {
        bounding.shift[c] = offset[c];
        bounding.offset[c] = (double)offset[c];
    }
    return bounding;
}

bool stp_bounding_misses(const stp_bounding* bounding, stp_box box)
{
    const double low[3] = {(double)box.min.x, (double)box.min.y, (double)box.min.z};
    const double high[3] = {(double)box.max.x, (double)box.max.y, (double)box.max.z};
    bool outside = false;
    for (int i = 0; i < 5; ++i) {
        double maximum = bounding->b[i], size = fabs(bounding->b[i]);
        for (int c = 0; c < 3; ++c) {
            double a = bounding->a[i][c], offset = bounding->offset[c];
            double from = (low[c] - offset) * a, to = (high[c] - offset) * a;
            maximum += from > to ? from : to;
            size += fmax(fabs(from), fabs(to));
        }
        outside = outside || maximum < -1e-5 * size;
    }
    return outside;
}

/// Depth of the corner of a box that is nearest, or farthest.
static float depth_of_corner(const stp_bounding* bounding, stp_box box, bool farthest)
{
    const float* w = bounding->depth;
    const float low[3] = {box.min.x, box.min.y, box.min.z};
    const float high[3] = {box.max.x, box.max.y, box.max.z};
    float depth = w[3];
    for (int c = 0; c < 3; ++c) {
        depth += w[c] * (((w[c] > 0.0f) == farthest ? high[c] : low[c]) - bounding->shift[c]);
    }
    return depth;
}

float stp_bounding_min_depth(const stp_bounding* bounding, stp_box box)
{
    return depth_of_corner(bounding, box, false);
}

float stp_bounding_max_depth(const stp_bounding* bounding, stp_box box)
{
    return depth_of_corner(bounding, box, true);
}
