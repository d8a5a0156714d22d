// SPDX-License-Identifier: MIT
//
// Fits a box into the picture in closed form. In camera axes (x right, y up, z towards the eye), a
// point p is in the picture of an eye e if
//
//     x - ex <= s (ez - z)    and    -(x - ex) <= s (ez - z)
//
// where s is the slope of the frame in x; likewise in y.
//
// With A = max(x + s z) and B = max(-x + s z) over all corners, this means
//
//     ex + s ez >= A    and    -ex + s ez >= B
//
// So the nearest eye has ez = (A + B) / 2 s and touches both sides. The larger ez of x and y
// satisfies both. Along the other axis, a bisection finds the smaller slope that just contains the
// corners from there; it gives equal margins.
#include "select/camera.h"

#include <assert.h>

enum {
    PLANES = 6 + STP_SECTION_PLANES,
    CORNERS = PLANES * (PLANES - 1) * (PLANES - 2) / 6, ///< at most: where three planes meet
    BISECTIONS = 60,
};

/// Share of the diagonal: the eye comes no nearer, so that the near plane cuts nothing off
#define NEAREST 2e-4

/// Corners in camera axes, relative to the centre of the box.
typedef struct corner_set {
    uint32_t count;
    stp_vec3d points[CORNERS];
} corner_set;

typedef struct plane {
    stp_vec3d normal; ///< unit
    double distance;  ///< from the centre of the box
} plane;

typedef struct camera_axes {
    stp_vec3d right, up, back;
} camera_axes;

static camera_axes axes_of(const stp_view* view)
{
    camera_axes a;
    a.back = stp_normalized(stp_subd(view->eye, view->target));
    a.right = stp_crossd(stp_normalized(view->up), a.back);
    if (!(stp_dotd(a.right, a.right) > 1e-12)) { // up is parallel to the view direction
        stp_vec3d other = fabs(a.back.y) < 0.9 ? (stp_vec3d){0, 1, 0} : (stp_vec3d){0, 0, -1};
        a.right = stp_crossd(other, a.back);
    }
    a.right = stp_normalized(a.right);
    a.up = stp_crossd(a.back, a.right);
    return a;
}

/// Planes of a box and of sections. @return their number
static uint32_t make_planes(const stp_sections* sections, stp_vec3d center, stp_vec3d half,
                            plane planes[PLANES])
{
    const double sides[3] = {half.x, half.y, half.z};
    uint32_t count = 0;
    for (int k = 0; k < 6; ++k) {
        double sign = k < 3 ? 1.0 : -1.0;
        stp_vec3d normal = {k % 3 == 0 ? sign : 0.0, k % 3 == 1 ? sign : 0.0,
                            k % 3 == 2 ? sign : 0.0};
        planes[count++] = (plane){normal, sides[k % 3]};
    }
    for (uint32_t i = 0; i < sections->count && i < STP_SECTION_PLANES; ++i) {
        const stp_section_plane* s = &sections->planes[i];
        double length = sqrt(stp_dotd(s->normal, s->normal));
        double distance = (s->distance - stp_dotd(s->normal, center)) / length;
        if (length > 0.0 && isfinite(length) && isfinite(distance)) {
            assert(count < PLANES);
            planes[count++] = (plane){stp_scaled(s->normal, 1.0 / length), distance};
        }
    }
    return count;
}

/// Intersection of three planes. @return false if it is not a single point
static bool intersect(const plane* a, const plane* b, const plane* c, stp_vec3d* point)
{
    stp_vec3d bc = stp_crossd(b->normal, c->normal);
    double determinant = stp_dotd(a->normal, bc);
    if (fabs(determinant) < 1e-9) {
        return false;
    }
    stp_vec3d sum = stp_scaled(bc, a->distance);
    sum = stp_addd(sum, stp_scaled(stp_crossd(c->normal, a->normal), b->distance));
    sum = stp_addd(sum, stp_scaled(stp_crossd(a->normal, b->normal), c->distance));
    *point = stp_scaled(sum, 1.0 / determinant);
    return true;
}

static void add_corner(corner_set* set, const camera_axes* axes, stp_vec3d p)
{
    assert(set->count < CORNERS && "three planes meet at most once");
    set->points[set->count++] =
        (stp_vec3d){stp_dotd(axes->right, p), stp_dotd(axes->up, p), stp_dotd(axes->back, p)};
}

/// Corners of the clipped box.
static void find_corners(const plane* planes, uint32_t count, double slack, const camera_axes* axes,
                         corner_set* set)
{
    for (uint32_t a = 0; a < count; ++a) {
        for (uint32_t b = a + 1; b < count; ++b) {
            for (uint32_t c = b + 1; c < count; ++c) {
                stp_vec3d p;
                bool inside = intersect(&planes[a], &planes[b], &planes[c], &p);
                for (uint32_t k = 0; k < count && inside; ++k) {
                    inside = stp_dotd(planes[k].normal, p) <= planes[k].distance + slack;
                }
                if (inside) {
                    add_corner(set, axes, p);
                }
            }
        }
    }
}

static void make_corners(const stp_sections* sections, stp_vec3d center, stp_vec3d half,
                         const camera_axes* axes, corner_set* set)
{
    plane planes[PLANES];
    double slack = 1e-9 * sqrt(stp_dotd(half, half));
    set->count = 0;
    find_corners(planes, make_planes(sections, center, half, planes), slack, axes, set);
    if (set->count == 0) { // everything is clipped
        find_corners(planes, 6, slack, axes, set);
    }
}

static double coordinate(stp_vec3d p, int axis)
{
    return axis == 0 ? p.x : p.y;
}

/// The A and B of above: extent along an axis and against it, at a slope. `spread`: half the
/// distance of the eyes.
static void reach(const corner_set* set, int axis, double slope, double spread, double* a,
                  double* b)
{
    *a = *b = -HUGE_VAL;
    for (uint32_t i = 0; i < set->count; ++i) {
        double x = coordinate(set->points[i], axis), z = slope * set->points[i].z;
        *a = fmax(*a, x + z + spread);
        *b = fmax(*b, -x + z + spread);
    }
}

/// Position along an axis that centres the corners as seen from depth `ez`.
static double center_along(const corner_set* set, int axis, double slope, double spread, double ez)
{
    double low = 0.0, high = slope, a, b;
    for (int i = 0; i < BISECTIONS; ++i) {
        double middle = 0.5 * (low + high);
        reach(set, axis, middle, spread, &a, &b);
        *(a + b <= 2.0 * middle * ez ? &high : &low) = middle;
    }
    reach(set, axis, high, spread, &a, &b);
    return 0.5 * (a - b);
}

/// @param slope  slopes of the frame in x and y
static stp_vec3d fit_perspective(const corner_set* set, const double slope[2], double spread,
                                 double nearest)
{
    double depth[2], a, b;
    for (int axis = 0; axis < 2; ++axis) {
        reach(set, axis, slope[axis], axis == 0 ? spread : 0.0, &a, &b);
        depth[axis] = (a + b) / (2.0 * slope[axis]);
    }
    double ez = fmax(fmax(depth[0], depth[1]), nearest);
    return (stp_vec3d){center_along(set, 0, slope[0], spread, ez),
                       center_along(set, 1, slope[1], 0.0, ez), ez};
}

/// @return the height of the picture; stores the centre in `eye`
static double fit_parallel(const corner_set* set, double aspect, stp_vec3d* eye)
{
    double a, b, sizes[2];
    for (int axis = 0; axis < 2; ++axis) {
        reach(set, axis, 0.0, 0.0, &a, &b);
        sizes[axis] = a + b;
        *(axis == 0 ? &eye->x : &eye->y) = 0.5 * (a - b);
    }
    return fmax(sizes[1], sizes[0] / aspect) / (1.0 - 2.0 * STP_CAMERA_MARGIN);
}

void stp_camera_fit(stp_view* view, const stp_boxd* box)
{
    static const stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd b = stp_boxd_is_empty(*box) ? unit : *box;
    stp_vec3d center = stp_scaled(stp_addd(b.min, b.max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(b.max, b.min), 0.5);
    camera_axes axes = axes_of(view);
    corner_set set;
    make_corners(&view->sections, center, half, &axes, &set);
    stp_boxd left = stp_boxd_empty(); // in camera axes
    for (uint32_t i = 0; i < set.count; ++i) {
        stp_boxd_add(&left, set.points[i]);
    }
    stp_vec3d diagonal = stp_subd(left.max, left.min);
    double size = sqrt(stp_dotd(diagonal, diagonal));
    double minimum = size > 0.0 ? NEAREST * size : 1.0; // a single point is viewed from 1 unit away
    double aspect = (double)view->width / (double)view->height;
    aspect = view->eye_distance > 0.0 ? 0.5 * aspect : aspect; // half the picture per eye
    stp_vec3d eye = {0};
    if (view->ortho_height > 0.0) {
        double height = fit_parallel(&set, aspect, &eye);
        view->ortho_height = height > 0.0 ? height : 1.0;
        eye.z = left.max.z + (size > 0.0 ? size : 1.0);
    } else {
        double y = (1.0 - 2.0 * STP_CAMERA_MARGIN) * tan(view->fov_degrees * (STP_PI / 360.0));
        const double slope[2] = {y * aspect, y};
        eye = fit_perspective(&set, slope, 0.5 * view->eye_distance, left.max.z + minimum);
    }
    stp_vec3d aside = stp_addd(stp_scaled(axes.right, eye.x), stp_scaled(axes.up, eye.y));
    stp_vec3d on_axis = stp_addd(center, aside);
    view->eye = stp_addd(on_axis, stp_scaled(axes.back, eye.z));
    view->target = stp_addd(on_axis, stp_scaled(axes.back, 0.5 * (left.min.z + left.max.z)));
    view->up = axes.up;
}
