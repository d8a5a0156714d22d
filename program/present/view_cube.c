// SPDX-License-Identifier: MIT
#include "program/present/view_cube.h"

#include <assert.h>

static const double min_facing = 0.12;      // smaller faces are too narrow to click
static const double straight = 0.9999;      // the camera already looks at this side
static const double handle_distance = 2.45; // from the centre, in half edges
static const double handle_apart =
    1.3; // nearer to the centre in the picture it is before or behind the faces

static stp_vec3d unit_of(int axis, double length)
{
    return (stp_vec3d){axis == 0 ? length : 0.0, axis == 1 ? length : 0.0,
                       axis == 2 ? length : 0.0};
}

static void project(const stp_navigator_axes* axes, stp_vec3d p, double out[2])
{
    out[0] = stp_dotd(axes->right, p);
    out[1] = -stp_dotd(axes->up, p);
}

void stp_view_cube_make(const stp_navigator_axes* axes, stp_view_cube* cube)
{
    static const char* const views[STP_VIEW_CUBE_SIDES] = {"right",  "left",  "top",
                                                           "bottom", "front", "back"};
    static const double around[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < STP_VIEW_CUBE_SIDES; ++i) {
        stp_view_cube_side* s = &cube->sides[i];
        int axis = i / 2, next = (axis + 1) % 3, last = (axis + 2) % 3;
        stp_vec3d normal = unit_of(axis, i % 2 == 0 ? 1.0 : -1.0);
        *s = (stp_view_cube_side){.view = views[i], .axis = axis, .positive = i % 2 == 0};
        s->facing = stp_dotd(normal, axes->back);
        s->visible = s->facing > min_facing;
        project(axes, normal, s->center);
        project(axes, stp_scaled(normal, handle_distance), s->handle);
        s->has_handle = hypot(s->handle[0], s->handle[1]) > handle_apart;
        for (int k = 0; k < 4; ++k) {
            stp_vec3d corner = stp_addd(
                normal, stp_addd(unit_of(next, around[k][0]), unit_of(last, around[k][1])));
            project(axes, corner, s->corners[k]);
        }
    }
}

static bool is_in_face(const stp_view_cube_side* s, double x, double y)
{
    int left = 0, right = 0;
    for (int k = 0; k < 4; ++k) {
        const double *a = s->corners[k], *b = s->corners[(k + 1) % 4];
        double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        left += side >= 0.0;
        right += side <= 0.0;
    }
    return left == 4 || right == 4;
}

/// The handle at a position, among those before or behind the faces. @return -1 if there is none
static int find_handle(const stp_view_cube* cube, bool in_front, double x, double y)
{
    for (int i = 0; i < STP_VIEW_CUBE_SIDES; ++i) {
        const stp_view_cube_side* s = &cube->sides[i];
        double away = hypot(x - s->handle[0], y - s->handle[1]);
        if (s->has_handle && (s->facing > 0.0) == in_front && away <= STP_VIEW_CUBE_HANDLE) {
            return i;
        }
    }
    return -1;
}

int stp_view_cube_hit(const stp_view_cube* cube, double x, double y)
{
    int hit = find_handle(cube, true, x, y);
    for (int i = 0; i < STP_VIEW_CUBE_SIDES && hit < 0; ++i) {
        if (cube->sides[i].visible && is_in_face(&cube->sides[i], x, y)) {
            hit = i;
        }
    }
    return hit >= 0 ? hit : find_handle(cube, false, x, y);
}

const char* stp_view_cube_target(const stp_view_cube* cube, int side)
{
    assert(side >= 0 && side < STP_VIEW_CUBE_SIDES && "the position hit a side");
    return cube->sides[cube->sides[side].facing > straight ? side ^ 1 : side].view;
}
