// SPDX-License-Identifier: MIT
// The nearness function of a view (src/draw/placement.c): it falls with depth, and holds the whole
// scene, wherever the eye is.
#include "tests.h"

#include "draw/placement.h"

#include <math.h>

static const stp_boxd box = {{-3, -2, -1}, {3, 2, 1}};

/// A view along -z from a height, with a near plane (0: the default).
static stp_placement look(double height, double near_distance, bool parallel)
{
    static const stp_store_node root = {.bounds = {{-3, -2, -1}, {3, 2, 1}}};
    const stp_store_directory directory = {.node_count = 1, .nodes = &root, .root = 0};
    const stp_view view = {.eye = {0, 0, height},
                           .target = {0, 0, height - 1.0},
                           .up = {0, 1, 0},
                           .near_distance = near_distance,
                           .fov_degrees = parallel ? 0.0 : 60.0,
                           .ortho_height = parallel ? 10.0 : 0.0,
                           .width = 100,
                           .height = 100};
    stp_placement p = {.mesh_depth = 1.0};
    (void)stp_view_frame_make(&view, &p.frame);
    stp_placement_choose_nearness(&p, &directory);
    return p;
}

static double nearness(const stp_placement* p, double depth)
{
    return p->frame.parallel ? p->nearness_scale * depth + p->nearness_offset
                             : p->nearness_scale / depth + p->nearness_offset;
}

void test_placement_nearness_is_near_over_depth_in_perspective(test_state* test)
{
    stp_placement p = look(10.0, 0.0, false);
    CHECK(!p.frame.parallel && fabs(nearness(&p, p.frame.near_distance) - 1.0) < 1e-12);
    CHECK(fabs(nearness(&p, 4.0 * p.frame.near_distance) - 0.25) < 1e-12);
}

void test_placement_nearness_holds_the_scene_in_parallel_projection(test_state* test)
{
    for (double height = 2.0; height < 1e6; height *= 3.0) {
        stp_placement p = look(height, 0.0, true);
        CHECK(p.frame.parallel);
        double near = height - box.max.z, far = height - box.min.z;
        CHECK(nearness(&p, near) <= 1.0 && nearness(&p, far) >= 0.0625 - 1e-9);
        CHECK(nearness(&p, near) - nearness(&p, far) > 0.4); // most of the range is used
    }
}

// The near plane is beyond everything: the function is finite, and falls over a length that floats resolve.
void test_placement_nearness_is_finite_where_nothing_is_seen(test_state* test)
{
    for (double height = 2.0; height < 1e6; height *= 3.0) {
        stp_placement p = look(height, 2.0 * height, true);
        double low = p.frame.near_distance;
        CHECK(p.frame.parallel && isfinite(p.nearness_scale) && isfinite(p.nearness_offset));
        CHECK(fabs(nearness(&p, low) - 1.0) < 1e-9);
        CHECK(nearness(&p, low + 1.0) > 0.06 && nearness(&p, low + 1.0) < 1.0);
    }
}
