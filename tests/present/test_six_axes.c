// SPDX-License-Identifier: MIT
// A device with six axes moves the camera, or the content about the pivot.
#include "tests.h"

#include "program/present/navigate.h"

#include <math.h>

static const double step = 0.05; // seconds

static stp_navigator camera(void)
{
    stp_navigator n;
    stp_boxd box = {{-4, -2, -3}, {4, 2, 3}};
    stp_navigator_init(&n, &box, 640, 400);
    (void)stp_navigator_face(&n, "front", &box, NULL);
    return n;
}

/// Where a point is in the picture.
static stp_vec3d seen(const stp_navigator* n, stp_vec3d point)
{
    stp_vec3d place;
    (void)stp_navigator_project(n, point, &place.x, &place.y, &place.z);
    return place;
}

static stp_six_axes only(int axis, double value)
{
    stp_six_axes axes = {{0}, {0}};
    *(axis < 3 ? &axes.moves[axis] : &axes.turns[axis - 3]) = value;
    return axes;
}

void test_six_axes_hold_the_content(test_state* test)
{
    static const stp_vec3d front = {0, 0, 3}, pivot = {0, 0, 0}, side = {3, 0, 0};
    stp_navigator start = camera();
    stp_vec3d middle = seen(&start, pivot);
    for (int axis = 0; axis < 6; ++axis) {
        stp_navigator n = start;
        stp_six_axes axes = only(axis, 1.0);
        stp_navigator_hold_six(&n, &axes, step);
        stp_vec3d at = seen(&n, pivot), near = seen(&n, front), right = seen(&n, side);
        if (axis == 0) {
            CHECK(fabs(at.x - middle.x - 0.03 * 400) < 1e-6 && fabs(at.y - middle.y) < 1e-6);
        } else if (axis == 1) {
            CHECK(fabs(at.y - middle.y + 0.03 * 400) < 1e-6);
        } else if (axis == 2) { // away from the hand
            CHECK(at.z > middle.z && fabs(log(at.z / middle.z) - 0.03) < 1e-9);
        } else { // turns keep the pivot
            CHECK(fabs(at.x - middle.x) < 1e-6 && fabs(at.y - middle.y) < 1e-6);
            CHECK(fabs(at.z - middle.z) < 1e-9 * middle.z);
        }
        CHECK(axis != 3 || near.y > at.y + 1.0);  // the cap leans back: the front turns down
        CHECK(axis != 4 || near.x > at.x + 1.0);  // seen from above against the clock
        CHECK(axis != 5 || right.y > at.y + 1.0); // clockwise
    }
}

void test_six_axes_fly_the_camera(test_state* test)
{
    static const stp_vec3d pivot = {0, 0, 0}, side = {3, 0, 0};
    stp_navigator start = camera();
    stp_vec3d middle = seen(&start, pivot);
    for (int axis = 0; axis < 6; ++axis) {
        stp_navigator n = start;
        stp_six_axes axes = only(axis, 1.0);
        stp_navigator_fly_six(&n, &axes, step);
        stp_vec3d at = seen(&n, pivot), right = seen(&n, side);
        double flown = stp_lengthd(stp_subd(n.eye, start.eye));
        CHECK(axis >= 3 || fabs(flown - 0.03 * start.reach) < 1e-9 * start.reach);
        CHECK(axis < 3 || flown == 0.0);
        CHECK(axis != 0 || at.x < middle.x - 1.0); // the opposite of the content
        CHECK(axis != 1 || at.y > middle.y + 1.0);
        CHECK(axis != 2 || at.z < middle.z);
        CHECK(axis != 3 || at.y > middle.y + 1.0); // it looks up
        CHECK(axis != 4 || at.x > middle.x + 1.0); // it looks to the left
        CHECK(axis != 5 || right.y < at.y - 1.0);
    }
}

void test_six_axes_tilt_the_horizon_only_on_purpose(test_state* test)
{
    stp_navigator n = camera();
    stp_six_axes axes = {{0.1, 0, 0}, {0, 0.5, 0.4}};
    stp_navigator_hold_six(&n, &axes, step);
    stp_navigator_fly_six(&n, &axes, step);
    CHECK(n.roll == 0.0);
    axes.turns[2] = -0.6;
    stp_navigator_fly_six(&n, &axes, step);
    CHECK(fabs(n.roll + 0.6 * 1.8 * step) < 1e-12);
}

void test_six_axes_turn_in_a_tilted_picture(test_state* test)
{
    stp_navigator n = camera();
    stp_vec3d target = {0, 0, 0};
    n.roll = 0.5 * STP_PI; // right in the picture is down in the scene
    stp_vec3d before = seen(&n, target);
    stp_six_axes axes = only(4, 0.1);
    stp_navigator_fly_six(&n, &axes, step);
    stp_vec3d after = seen(&n, target);
    CHECK(after.x > before.x + 1.0 && fabs(after.y - before.y) < 0.1);
    axes = only(3, 0.1);
    n = camera();
    n.roll = -1.0;
    before = seen(&n, target);
    stp_navigator_fly_six(&n, &axes, step);
    after = seen(&n, target);
    CHECK(after.y > before.y + 1.0 && fabs(after.x - before.x) < 0.1);
}

void test_six_axes_zoom_in_parallel_projection(test_state* test)
{
    stp_navigator n = camera();
    stp_navigator_switch_projection(&n);
    double height = n.ortho_height;
    stp_six_axes axes = only(2, 1.0);
    stp_navigator_hold_six(&n, &axes, step); // away
    CHECK(fabs(n.ortho_height / height - exp(0.03)) < 1e-9);
    stp_navigator_fly_six(&n, &axes, step); // forward
    CHECK(fabs(n.ortho_height / height - 1.0) < 1e-9);
}
