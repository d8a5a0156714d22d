// SPDX-License-Identifier: MIT
// The rare triangles that reach behind the viewer, beyond the near plane, or far off the screen.
//
// Sutherland-Hodgman clipping in homogeneous coordinates. A new corner is always computed from the
// inner end of its edge towards the outer one, so that the two triangles at an edge get the same
// corner. Unclipped corners keep the grid coordinates that adjacent triangles use. So there are no
// cracks.
#include "raster/triangles_internal.h"

#include <assert.h>

enum {
    PLANE_NEAR,
    PLANE_EYE,
    PLANE_FAR,
    PLANE_LEFT,
    PLANE_RIGHT,
    PLANE_TOP,
    PLANE_BOTTOM,
    PLANE_COUNT
};

typedef struct clip_corner {
    stp_screen_point point;
    uint32_t outcode; ///< outcode of an original corner; new ones are tested by their distance
    int original;     ///< index of the triangle's corner, or -1
} clip_corner;

uint32_t stp_triangle_outcode(float x, float y, float n, float w, float nearness_limit)
{
    const float guard = (float)STP_GUARD_BAND;
    uint32_t code = 0;
    code |= (uint32_t) !(w >= STP_MIN_W) << PLANE_EYE;
    if (w >= STP_MIN_W) {
        float inverse = 1.0f / w;
        float gx = (x * inverse) * (float)STP_SUBPIXEL, gy = (y * inverse) * (float)STP_SUBPIXEL;
        float gn = n * inverse;
        code |= (uint32_t) !(gn <= nearness_limit) << PLANE_NEAR;
        code |= (uint32_t) !(gn >= STP_MIN_NEARNESS) << PLANE_FAR;
        code |= (uint32_t) !(gx >= -guard) << PLANE_LEFT;
        code |= (uint32_t) !(gx <= guard) << PLANE_RIGHT;
        code |= (uint32_t) !(gy >= -guard) << PLANE_TOP;
        code |= (uint32_t) !(gy <= guard) << PLANE_BOTTOM;
    } else {
        float reach = guard / (float)STP_SUBPIXEL * w;
        code |= (uint32_t) !(n <= nearness_limit * w) << PLANE_NEAR;
        code |= (uint32_t) !(n >= 0.0f) << PLANE_FAR;
        code |= (uint32_t) !(x >= -reach) << PLANE_LEFT;
        code |= (uint32_t) !(x <= reach) << PLANE_RIGHT;
        code |= (uint32_t) !(y >= -reach) << PLANE_TOP;
        code |= (uint32_t) !(y <= reach) << PLANE_BOTTOM;
    }
    return code;
}

void stp_triangle_project(const stp_triangle_transform* transform, const float* position,
                          float out[4])
{
    float x = position[0] - transform->offset[0];
    float y = position[1] - transform->offset[1];
    float z = position[2] - transform->offset[2];
    for (int r = 0; r < 4; ++r) {
        const float* m = transform->matrix[r];
        out[r] = x * m[0] + y * m[1] + z * m[2] + m[3];
    }
}

static double distance_to(int plane, const stp_screen_point* p, double nearness_limit)
{
    const double reach = (double)STP_GUARD_BAND / (double)STP_SUBPIXEL;
    switch (plane) {
    case PLANE_NEAR:
        return nearness_limit * p->w - p->n;
    case PLANE_EYE:
        return p->w - (double)STP_MIN_W;
    case PLANE_FAR:
        return p->n;
    case PLANE_LEFT:
        return p->x + reach * p->w;
    case PLANE_RIGHT:
        return reach * p->w - p->x;
    case PLANE_TOP:
        return p->y + reach * p->w;
    default:
        return reach * p->w - p->y;
    }
}

static bool is_inside(const clip_corner* corner, int plane, double distance)
{
    return corner->original >= 0 ? (corner->outcode >> plane & 1) == 0 : distance >= 0.0;
}

static clip_corner clip_edge(const clip_corner* in, double in_distance, const clip_corner* out,
                             double out_distance)
{
    in_distance = in_distance > 0.0 ? in_distance : 0.0;
    out_distance = out_distance < 0.0 ? out_distance : 0.0;
    double whole = in_distance - out_distance;
    double t = whole > 0.0 ? in_distance / whole : 0.0;
    assert(t >= 0.0 && t <= 1.0 && "on the edge");
    const stp_screen_point *a = &in->point, *b = &out->point;
    return (clip_corner){
        .point = {a->x + t * (b->x - a->x), a->y + t * (b->y - a->y), a->n + t * (b->n - a->n),
                  a->w + t * (b->w - a->w)},
        .original = -1,
    };
}

static uint32_t clip_to_plane(int plane, double nearness_limit, const clip_corner* in,
                              uint32_t count, clip_corner* out)
{
    uint32_t made = 0;
    for (uint32_t i = 0; i < count && made + 2 <= STP_CLIPPED_MAX; ++i) {
        const clip_corner *a = &in[i], *b = &in[(i + 1) % count];
        double da = distance_to(plane, &a->point, nearness_limit);
        double db = distance_to(plane, &b->point, nearness_limit);
        bool a_inside = is_inside(a, plane, da), b_inside = is_inside(b, plane, db);
        if (a_inside) {
            out[made++] = *a;
        }
        if (a_inside && !b_inside) {
            out[made++] = clip_edge(a, da, b, db);
        } else if (!a_inside && b_inside) {
            out[made++] = clip_edge(b, db, a, da);
        }
    }
    assert(made <= STP_CLIPPED_MAX);
    return made;
}

static int32_t snap(double pixels)
{
    const double guard = (double)STP_GUARD_BAND;
    double grid = pixels * (double)STP_SUBPIXEL;
    grid = grid > -guard ? grid : -guard; // also for NaN
    return stp_triangle_snap(grid < guard ? grid : guard);
}

static stp_screen_vertex finish_corner(const clip_corner* corner, double nearness_limit)
{
    const stp_screen_point* p = &corner->point;
    double nearness = p->n / p->w;
    nearness = nearness > (double)STP_MIN_NEARNESS ? nearness : (double)STP_MIN_NEARNESS;
    nearness = nearness < nearness_limit ? nearness : nearness_limit;
    return (stp_screen_vertex){snap(p->x / p->w), snap(p->y / p->w), (float)nearness};
}

uint32_t stp_triangle_clip(const stp_triangle_transform* transform, const float* const corners[3],
                           stp_screen_vertex polygon[STP_CLIPPED_MAX])
{
    clip_corner buffers[2][STP_CLIPPED_MAX];
    float limit = transform->nearness_limit;
    double finite_limit = (double)(limit < FLT_MAX ? limit : FLT_MAX);
    uint32_t needed = 0;
    for (int k = 0; k < 3; ++k) {
        float p[4];
        stp_triangle_project(transform, corners[k], p);
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !isfinite(p[3])) {
            return 0;
        }
        uint32_t code = stp_triangle_outcode(p[0], p[1], p[2], p[3], limit);
        buffers[0][k] = (clip_corner){
            .point = {(double)p[0], (double)p[1], (double)p[2], (double)p[3]},
            .outcode = code,
            .original = k,
        };
        needed |= code;
    }
    uint32_t count = 3;
    const clip_corner* current = buffers[0];
    for (int plane = 0, into = 1; plane < PLANE_COUNT && count != 0; ++plane) {
        // a new corner may lie beyond planes that no original corner is beyond: W falls, so X/W
        // grows
        if ((needed >> plane & 1) != 0 || (plane >= PLANE_LEFT && needed != 0)) {
            count = clip_to_plane(plane, finite_limit, current, count, buffers[into]);
            current = buffers[into];
            into = 1 - into;
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        polygon[i] = finish_corner(&current[i], finite_limit);
        if (current[i].original >= 0) { // the same bits as in the kernels
            const stp_screen_point* p = &current[i].point;
            float inverse = 1.0f / (float)p->w;
            polygon[i].nearness = (float)p->n * inverse;
            polygon[i].x =
                stp_triangle_snap((double)(((float)p->x * inverse) * (float)STP_SUBPIXEL));
            polygon[i].y =
                stp_triangle_snap((double)(((float)p->y * inverse) * (float)STP_SUBPIXEL));
        }
        assert(polygon[i].x >= -STP_GUARD_BAND && polygon[i].x <= STP_GUARD_BAND &&
               polygon[i].y >= -STP_GUARD_BAND && polygon[i].y <= STP_GUARD_BAND);
    }
    return count;
}
