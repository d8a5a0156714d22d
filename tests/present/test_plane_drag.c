// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/present/navigate.h"

static const stp_boxd box = {{-1, -2, -3}, {1, 2, 3}};

void test_planes_intersect_boxes_in_polygons(test_state* test)
{
    stp_vec3d corners[STP_PLANE_CORNERS_MAX];
    CHECK_EQUAL(
        4, stp_plane_intersect_box((stp_vec3d){0.5, 9, 9}, (stp_vec3d){1, 0, 0}, &box, corners));
    for (int i = 0; i < 4; ++i) { // a rectangle in order: neighbours differ in one coordinate
        stp_vec3d way = stp_subd(corners[i], corners[(i + 1) % 4]);
        CHECK(corners[i].x == 0.5 && (way.y == 0.0) != (way.z == 0.0));
    }
    stp_vec3d slanted = stp_normalized((stp_vec3d){6, 3, 2});
    CHECK_EQUAL(6, stp_plane_intersect_box((stp_vec3d){0, 0, 0}, slanted, &box, corners));
    for (int i = 0; i < 6; ++i) {
        CHECK(fabs(stp_dotd(slanted, corners[i])) < 1e-12);
        stp_vec3d a = corners[i], b = corners[(i + 1) % 6], c = corners[(i + 2) % 6];
        stp_vec3d turn = stp_crossd(stp_subd(b, a), stp_subd(c, b));
        CHECK(stp_dotd(turn, slanted) > 0.0); // convex, one way round
    }
    CHECK(stp_plane_intersect_box((stp_vec3d){5, 0, 0}, (stp_vec3d){1, 0, 0}, &box, corners) < 3);
}

void test_planes_follow_the_cursor(test_state* test)
{
    static const char* const views[] = {"front", "iso", "left", "top"};
    for (int i = 0; i < 8; ++i) {
        stp_navigator n;
        stp_navigator_init(&n, &box, 800, 600);
        CHECK(stp_navigator_face(&n, views[i / 2], &box, NULL));
        if (i % 2 == 1) {
            stp_navigator_switch_projection(&n);
        }
        for (int axis = 0; axis < 3; ++axis) {
            stp_vec3d anchor = {0.1, 0.2, -0.1}, direction = {axis == 0, axis == 1, axis == 2};
            stp_vec3d moved = stp_addd(anchor, stp_scaled(direction, 0.002));
            double from[2], to[2], depth;
            CHECK(stp_navigator_project(&n, anchor, &from[0], &from[1], &depth));
            CHECK(stp_navigator_project(&n, moved, &to[0], &to[1], &depth));
            double along = stp_plane_drag(&n, anchor, direction, from, to);
            if (hypot(to[0] - from[0], to[1] - from[1]) > 0.1) {
                CHECK(fabs(along - 0.002) < 0.0002);
            } else { // straight along the view axis: up moves away
                stp_navigator_axes axes = stp_navigator_get_axes(&n);
                to[1] = from[1] - 10.0;
                along = stp_plane_drag(&n, anchor, direction, from, to);
                CHECK(along * -stp_dotd(axes.back, direction) > 0.0);
            }
        }
    }
}
