// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/present/view_cube.h"

#include <string.h>

static stp_view_cube cube_of(double azimuth, double elevation)
{
    stp_navigator n = {.azimuth = azimuth, .elevation = elevation};
    stp_navigator_axes axes = stp_navigator_get_axes(&n);
    stp_view_cube cube;
    stp_view_cube_make(&axes, &cube);
    return cube;
}

static int find(const stp_view_cube* cube, const char* view)
{
    int side = 0;
    while (strcmp(cube->sides[side].view, view) != 0) {
        side += 1;
    }
    return side;
}

/// Whether a click at a side's face or handle hits it.
static bool can_be_clicked(const stp_view_cube* cube, int side)
{
    const stp_view_cube_side* s = &cube->sides[side];
    return stp_view_cube_hit(cube, s->center[0], s->center[1]) == side ||
           stp_view_cube_hit(cube, s->handle[0], s->handle[1]) == side;
}

void test_view_cube_shows_the_side_that_is_looked_at(test_state* test)
{
    static const char* const names[] = {"front", "back", "left", "right", "top", "bottom"};
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    for (int i = 0; i < STP_VIEW_CUBE_SIDES; ++i) {
        stp_navigator n;
        stp_navigator_init(&n, &box, 100, 100);
        CHECK(stp_navigator_face(&n, names[i], &box, NULL));
        stp_navigator_axes axes = stp_navigator_get_axes(&n);
        stp_view_cube cube;
        stp_view_cube_make(&axes, &cube);
        int side = find(&cube, names[i]);
        CHECK(cube.sides[side].facing > 0.9999);
        CHECK_EQUAL(side, stp_view_cube_hit(&cube, 0.0, 0.0));
        // a second click goes to the other side; those beside it have handles
        CHECK_EQUAL(side ^ 1, find(&cube, stp_view_cube_target(&cube, side)));
        for (int k = 0; k < STP_VIEW_CUBE_SIDES; ++k) {
            CHECK(k / 2 == side / 2 || can_be_clicked(&cube, k));
        }
    }
}

void test_view_cube_reaches_all_sides_from_everywhere(test_state* test)
{
    for (int i = 0; i < 72; ++i) {
        for (int k = -17; k <= 17; ++k) {
            stp_view_cube cube = cube_of(STP_PI / 36.0 * i, STP_PI / 36.0 * k + 0.01);
            for (int side = 0; side < STP_VIEW_CUBE_SIDES; ++side) {
                bool direct = can_be_clicked(&cube, side);
                CHECK(direct || can_be_clicked(&cube, side ^ 1));
                CHECK(direct || cube.sides[side].facing < 0.0); // only sides that face away
                const stp_view_cube_side* s = &cube.sides[side];
                CHECK(hypot(s->handle[0], s->handle[1]) + STP_VIEW_CUBE_HANDLE <=
                      STP_VIEW_CUBE_REACH);
            }
        }
    }
}

void test_view_cube_is_missed_beside_it(test_state* test)
{
    stp_view_cube cube = cube_of(0.7, 0.6);
    CHECK_EQUAL(-1, stp_view_cube_hit(&cube, 2.9, 2.9));
    CHECK_EQUAL(-1, stp_view_cube_hit(&cube, -2.9, 0.4));
    CHECK(strcmp(stp_view_cube_target(&cube, find(&cube, "top")), "top") == 0);
}
