// What is seen of boxes: src/select/view_frame.c, and what hides them: src/select/depth_pyramid.c.
#include "select_interface.h"

layout(std430, binding = BINDING_SELECT_VIEW) readonly buffer View { select_view view; };
layout(std430, binding = BINDING_SELECT_PYRAMID) readonly buffer Pyramid { float pyramid[]; };

struct box_place {
    dvec3 low, high;
};

struct box_sight {
    double near, far; // depths; 1 in parallel projection
    bool is_inside;
};

dvec3 to_vec(double a[3])
{
    return dvec3(a[0], a[1], a[2]);
}

dvec3 apply(double m[12], dvec3 p)
{
    return dvec3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                 m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

// The box that holds a transformed box.
box_place place_box(double m[12], box_place box)
{
    dvec3 half_side = (box.high - box.low) * 0.5lf, center = apply(m, box.low + half_side);
    dvec3 reach = dvec3(abs(m[0]) * half_side.x + abs(m[1]) * half_side.y + abs(m[2]) * half_side.z,
                        abs(m[4]) * half_side.x + abs(m[5]) * half_side.y + abs(m[6]) * half_side.z,
                        abs(m[8]) * half_side.x + abs(m[9]) * half_side.y + abs(m[10]) * half_side.z);
    return box_place(center - reach, center + reach);
}

double reach_along(dvec3 axis, dvec3 half_side)
{
    return abs(axis.x) * half_side.x + abs(axis.y) * half_side.y + abs(axis.z) * half_side.z;
}

bool see(box_place box, out box_sight sight)
{
    dvec3 eye = to_vec(view.frame.eye), forward = to_vec(view.frame.forward);
    dvec3 half_side = (box.high - box.low) * 0.5lf, center = box.low + half_side - eye;
    double middle = dot(forward, center), deep = reach_along(forward, half_side);
    sight = box_sight(middle - deep, middle + deep, false);
    bool seen = box.low.x <= box.high.x && sight.far >= view.frame.near_distance;
    for (uint i = 0u; i < 4u; ++i) {
        dvec3 side = dvec3(view.frame.sides[3u * i], view.frame.sides[3u * i + 1u], view.frame.sides[3u * i + 2u]);
        seen = seen && dot(side, center) - reach_along(side, half_side) <= view.frame.side_limits[i];
    }
    if (view.parallel != 0u) {
        sight = box_sight(1.0lf, 1.0lf, false);
        return seen;
    }
    dvec3 away = max(max(box.low - eye, eye - box.high), dvec3(0.0lf));
    sight.near = max(max(sight.near, sqrt(dot(away, away)) / view.frame.corner), view.frame.near_distance);
    sight.is_inside = all(greaterThanEqual(eye, box.low)) && all(lessThanEqual(eye, box.high));
    return seen;
}

// The rectangle of pixels and the least depth of a box before the pyramid's eye. @return false where it is not wholly so
bool project(box_place box, double near, out dvec4 around, out double depth)
{
    around = dvec4(1e300lf, 1e300lf, -1e300lf, -1e300lf);
    depth = 1e300lf;
    for (uint i = 0u; i < 8u; ++i) {
        dvec3 p = dvec3((i & 1u) != 0u ? box.high.x : box.low.x, (i & 2u) != 0u ? box.high.y : box.low.y,
                        (i & 4u) != 0u ? box.high.z : box.low.z) - to_vec(view.pyramid_frame.eye);
        double z = dot(to_vec(view.pyramid_frame.forward), p);
        if (!(z > near)) {
            return false;
        }
        double inverse = view.pyramid_frame.scale / z;
        double u = view.pyramid_frame.center_x + dot(to_vec(view.pyramid_frame.right), p) * inverse;
        double v = view.pyramid_frame.center_y + dot(to_vec(view.pyramid_frame.down), p) * inverse;
        around = dvec4(min(around.x, u), min(around.y, v), max(around.z, u), max(around.w, v));
        depth = min(depth, z);
    }
    return true;
}

// stp_depth_pyramid_hides
bool is_hidden(box_place box, double margin)
{
    double ratio = margin / view.pyramid_frame.scale, depth;
    dvec4 around;
    if (view.pyramid_levels == 0u || !(box.low.x <= box.high.x) || !(ratio < 0.5lf) ||
        !project(box, view.pyramid_frame.near_distance / (1.0lf - ratio), around, depth)) {
        return false;
    }
    double wider = margin / (1.0lf - ratio) * view.pyramid_frame.corner + 1.5lf;
    around = dvec4(max(around.x - wider, 0.0lf), max(around.y - wider, 0.0lf),
                   min(around.z + wider, view.pyramid_frame.width - 1.0lf),
                   min(around.w + wider, view.pyramid_frame.height - 1.0lf));
    if (!(around.x <= around.z && around.y <= around.w)) {
        return false;
    }
    uvec4 blocks = uvec4(around) / 8u;
    uint level = 0u;
    while (level + 1u < view.pyramid_levels && (blocks.z - blocks.x >= 4u || blocks.w - blocks.y >= 4u)) {
        level += 1u;
        blocks /= 2u;
    }
    double nearness = view.pyramid_frame.near_distance / (depth * (1.0lf - ratio)) * (1.0lf + ratio) * (1.0lf + 1e-5lf);
    bool hidden = true;
    for (uint y = blocks.y; y <= blocks.w; ++y) {
        for (uint x = blocks.x; x <= blocks.z; ++x) {
            float there = pyramid[view.offsets[level] + y * view.columns[level] + x];
            hidden = hidden && double(there) > nearness;
        }
    }
    return hidden;
}
