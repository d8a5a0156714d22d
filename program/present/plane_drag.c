// SPDX-License-Identifier: MIT
#include "program/present/navigate.h"

#include <assert.h>

static const double min_slant =
    0.15; // share of a direction's length that must be seen for a hand to follow it

static double component(stp_vec3d v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static stp_vec3d corner_of(const stp_boxd* box, int corner)
{
    return (stp_vec3d){(corner & 1) != 0 ? box->max.x : box->min.x,
                       (corner & 2) != 0 ? box->max.y : box->min.y,
                       (corner & 4) != 0 ? box->max.z : box->min.z};
}

/// Angle of a corner around the plane's normal, seen from a centre point.
static double angle_around(stp_vec3d corner, stp_vec3d middle, stp_vec3d normal)
{
    int minimum = 0;
    for (int i = 1; i < 3; ++i) {
        minimum = fabs(component(normal, i)) < fabs(component(normal, minimum)) ? i : minimum;
    }
    stp_vec3d side = {minimum == 0, minimum == 1, minimum == 2};
    stp_vec3d across = stp_normalized(stp_crossd(normal, side));
    stp_vec3d up = stp_crossd(normal, across), way = stp_subd(corner, middle);
    return atan2(stp_dotd(way, up), stp_dotd(way, across));
}

int stp_plane_intersect_box(stp_vec3d point, stp_vec3d normal, const stp_boxd* box,
                            stp_vec3d corners[STP_PLANE_CORNERS_MAX])
{
    stp_vec3d found[12], middle = {0, 0, 0};
    int count = 0;
    for (int i = 0; i < 8; ++i) {
        for (int k = 1; k < 8; k *= 2) {
            stp_vec3d a = corner_of(box, i), b = corner_of(box, i | k);
            double da = stp_dotd(normal, stp_subd(a, point));
            double db = stp_dotd(normal, stp_subd(b, point));
            if ((i & k) == 0 && (da < 0.0) != (db < 0.0)) {
                assert(count < 12 && "each edge is cut once");
                found[count] = stp_addd(a, stp_scaled(stp_subd(b, a), da / (da - db)));
                middle = stp_addd(middle, found[count]);
                count += 1;
            }
        }
    }
    if (count < 3 || count > STP_PLANE_CORNERS_MAX) {
        return 0;
    }
    middle = stp_scaled(middle, 1.0 / (double)count);
    for (int i = 0; i < count; ++i) { // sorted by angle
        int at = i;
        double angle = angle_around(found[i], middle, normal);
        while (at > 0 && angle_around(corners[at - 1], middle, normal) > angle) {
            corners[at] = corners[at - 1];
            at -= 1;
        }
        corners[at] = found[i];
    }
    return count;
}

double stp_plane_drag(const stp_navigator* n, stp_vec3d anchor, stp_vec3d direction,
                      const double from[2], const double to[2])
{
    double x, y, depth;
    if (!stp_navigator_project(n, anchor, &x, &y, &depth)) {
        return 0.0;
    }
    double pixel = stp_navigator_pixel(n, depth);
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double dx = to[0] - from[0], dy = to[1] - from[1];
    // pixels per step along the direction, at its start
    double right = stp_dotd(axes.right, direction) / pixel;
    double down = -stp_dotd(axes.up, direction) / pixel;
    double away = -stp_dotd(axes.back, direction);
    if (!(n->ortho_height > 0.0)) { // receding points move towards the centre of the picture
        right -= (x - 0.5 * (double)n->width) * away / depth;
        down -= (y - 0.5 * (double)n->height) * away / depth;
    }
    double square = right * right + down * down;
    if (square * pixel * pixel < min_slant * min_slant) {
        return -dy * pixel * (away < 0.0 ? -1.0 : 1.0);
    }
    return (dx * right + dy * down) / square;
}
