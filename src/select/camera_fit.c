// SPDX-License-Identifier: MIT
//
// Fits points into the picture in closed form. In camera axes (x right, y up, z towards the eye), a
// point p is in the picture of an eye e if
//
//     x - ex <= s (ez - z)    and    -(x - ex) <= s (ez - z)
//
// where s is the slope of the frame in x; likewise in y.
//
// With A = max(x + s z) and B = max(-x + s z) over all points, this means
//
//     ex + s ez >= A    and    -ex + s ez >= B
//
// So the nearest eye has ez = (A + B) / 2 s and touches both sides. The larger ez of x and y
// satisfies both. Along the other axis, a bisection finds the smaller slope that just contains the
// points from there; it gives equal margins.
//
// Of a box, the points are its corners. Of content, they are the farthest points in the directions
// of x + s z and -x + s z, for slopes from 0 to that of the frame; so A and B are those of all
// content.
#include "select/box_clip.h"
#include "select/camera.h"
#include "select/sections.h"

#include <assert.h>

enum {
    BISECTIONS = 60,
    SLOPES = 8, ///< searched slopes above 0
    /// Both axes, with and against them, and along the view
    DIRECTIONS = 4 * (SLOPES + 1) + 2,
};

/// Share of the diagonal: the eye comes no nearer, so that the near plane cuts nothing off
#define NEAREST 2e-4

/// Points in camera axes, relative to a centre.
typedef struct point_set {
    uint32_t count;
    stp_vec3d center; ///< in scene space
    stp_vec3d points[STP_BOX_CLIP_CORNERS];
} point_set;

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

/// @param p relative to the centre, in scene axes
static void add_point(point_set* set, const camera_axes* axes, stp_vec3d p)
{
    assert(set->count < STP_BOX_CLIP_CORNERS);
    set->points[set->count++] =
        (stp_vec3d){stp_dotd(axes->right, p), stp_dotd(axes->up, p), stp_dotd(axes->back, p)};
}

static void add_corners(const stp_sections* sections, const stp_boxd* box, const camera_axes* axes,
                        point_set* set)
{
    static const stp_sections none = {0};
    stp_vec3d corners[STP_BOX_CLIP_CORNERS];
    uint32_t count = stp_box_clip(box, sections, corners);
    if (count == 0) { // everything is clipped
        count = stp_box_clip(box, &none, corners);
    }
    for (uint32_t i = 0; i < count; ++i) {
        add_point(set, axes, corners[i]);
    }
}

static double aspect_of(const stp_view* view)
{
    double aspect = (double)view->width / (double)view->height;
    return view->eye_distance > 0.0 ? 0.5 * aspect : aspect; // half the picture per eye
}

/// Slopes of the frame in x and y, within the margins.
static void find_slopes(const stp_view* view, double slope[2])
{
    double y = (1.0 - 2.0 * STP_CAMERA_MARGIN) * tan(view->fov_degrees * (STP_PI / 360.0));
    slope[0] = y * aspect_of(view);
    slope[1] = y;
}

/// @return whether the graph has content that the sections leave
static bool add_content(stp_context* context, const stp_farthest_graph* graph, const stp_view* view,
                        const camera_axes* axes, point_set* set)
{
    static const stp_sections none = {0};
    stp_vec3d directions[DIRECTIONS], points[DIRECTIONS];
    uint32_t count = 0;
    double slope[2] = {0};
    int slopes = view->ortho_height > 0.0 ? 0 : SLOPES;
    if (slopes > 0) {
        find_slopes(view, slope);
    }
    for (int i = 0; i <= slopes; ++i) {
        for (int side = 0; side < 4; ++side) {
            stp_vec3d axis = side < 2 ? axes->right : axes->up;
            stp_vec3d back = stp_scaled(axes->back, slope[side / 2] * i / SLOPES);
            directions[count++] = stp_addd(stp_scaled(axis, side % 2 == 0 ? 1.0 : -1.0), back);
        }
    }
    directions[count++] = axes->back;
    directions[count++] = stp_scaled(axes->back, -1.0);
    assert(count <= DIRECTIONS);
    bool valid = stp_sections_are_valid(&view->sections);
    if (!(valid && stp_farthest_find(context, graph, &view->sections, directions, count, points)) &&
        !stp_farthest_find(context, graph, &none, directions, count, points)) {
        return false;
    }
    for (uint32_t i = 0; i < count; ++i) {
        add_point(set, axes, stp_subd(points[i], set->center));
    }
    return true;
}

static double coordinate(stp_vec3d p, int axis)
{
    return axis == 0 ? p.x : p.y;
}

/// The A and B of above: extent along an axis and against it, at a slope. `spread`: half the
/// distance of the eyes.
static void reach(const point_set* set, int axis, double slope, double spread, double* a, double* b)
{
    *a = *b = -HUGE_VAL;
    for (uint32_t i = 0; i < set->count; ++i) {
        double x = coordinate(set->points[i], axis), z = slope * set->points[i].z;
        *a = fmax(*a, x + z + spread);
        *b = fmax(*b, -x + z + spread);
    }
}

/// Position along an axis that centres the points as seen from depth `ez`.
static double center_along(const point_set* set, int axis, double slope, double spread, double ez)
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
static stp_vec3d fit_perspective(const point_set* set, const double slope[2], double spread,
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
static double fit_parallel(const point_set* set, double aspect, stp_vec3d* eye)
{
    double a, b, sizes[2];
    for (int axis = 0; axis < 2; ++axis) {
        reach(set, axis, 0.0, 0.0, &a, &b);
        sizes[axis] = a + b;
        *(axis == 0 ? &eye->x : &eye->y) = 0.5 * (a - b);
    }
    return fmax(sizes[1], sizes[0] / aspect) / (1.0 - 2.0 * STP_CAMERA_MARGIN);
}

/// Places the eye so that the points fit.
static void place(stp_view* view, const camera_axes* axes, const point_set* set)
{
    stp_boxd left = stp_boxd_empty(); // in camera axes
    for (uint32_t i = 0; i < set->count; ++i) {
        stp_boxd_add(&left, set->points[i]);
    }
    stp_vec3d diagonal = stp_subd(left.max, left.min);
    double size = sqrt(stp_dotd(diagonal, diagonal));
    double minimum = size > 0.0 ? NEAREST * size : 1.0; // a single point is viewed from 1 unit away
    stp_vec3d eye = {0};
    if (view->ortho_height > 0.0) {
        double height = fit_parallel(set, aspect_of(view), &eye);
        view->ortho_height = height > 0.0 ? height : 1.0;
        eye.z = left.max.z + (size > 0.0 ? size : 1.0);
    } else {
        double slope[2];
        find_slopes(view, slope);
        eye = fit_perspective(set, slope, 0.5 * view->eye_distance, left.max.z + minimum);
    }
    stp_vec3d aside = stp_addd(stp_scaled(axes->right, eye.x), stp_scaled(axes->up, eye.y));
    stp_vec3d on_axis = stp_addd(set->center, aside);
    view->eye = stp_addd(on_axis, stp_scaled(axes->back, eye.z));
    view->target = stp_addd(on_axis, stp_scaled(axes->back, 0.5 * (left.min.z + left.max.z)));
    view->up = axes->up;
}

static stp_vec3d middle_of(const stp_boxd* box)
{
    return stp_scaled(stp_addd(box->min, box->max), 0.5);
}

void stp_camera_fit(stp_view* view, const stp_boxd* box)
{
    static const stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd b = stp_boxd_is_empty(*box) ? unit : *box;
    camera_axes axes = axes_of(view);
    point_set set;
    set.count = 0;
    set.center = middle_of(&b);
    add_corners(&view->sections, &b, &axes, &set);
    place(view, &axes, &set);
}

void stp_camera_fit_content(stp_context* context, const stp_farthest_graph* graph, stp_view* view)
{
    stp_boxd box = stp_affine_box(&graph->root.transform, graph->root.bounds);
    camera_axes axes = axes_of(view);
    point_set set;
    set.count = 0;
    set.center = middle_of(&box);
    if (stp_boxd_is_empty(graph->root.bounds) || !add_content(context, graph, view, &axes, &set)) {
        stp_camera_fit(view, &box);
        return;
    }
    place(view, &axes, &set);
}

void stp_camera_fit_store(const stp_farthest_store* content, const stp_placed_node* placed,
                          stp_view* view)
{
    stp_farthest_graph graph;
    stp_boxd none = stp_boxd_empty();
    if (stp_farthest_begin(content, placed, &graph)) {
        stp_camera_fit_content(content->context, &graph, view);
    } else {
        stp_camera_fit(view, &none);
    }
}
