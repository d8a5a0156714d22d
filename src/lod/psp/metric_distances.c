// SPDX-License-Identifier: MIT
// L2: distances of all points from the splat that represents them (Wu, Zhang, Kobbelt 2005, section
// 4.1).
#include "lod/psp/metric.h"

#include <assert.h>

/// Minimum ratio of the middle to the largest eigenvalue of the scatter; below it, points count as
/// a line
#define LINE 1e-4
/// Minimum cosine between the normal of the points' plane and the mean normal of the two splats;
/// below it, the plane is rejected
#define UPRIGHT 0.7f
/// Times the geometric mean of both areas: added to each sum of squares. Sums below this are noise;
/// with it, planes are merged evenly.
#define FLAT 1e-8

/// Points represented by a splat, and their moments about the centre of the cloud.
typedef struct moments {
    double count, sum[3], squares[6]; ///< xx, xy, xz, yy, yz, zz
    uint32_t first, last;             ///< linked list of points
} moments;

static bool open_lists(stp_psp_shared* shared)
{
    // per point, the next one in the list of its splat; UINT32_MAX at the end
    size_t count = (size_t)shared->points->count + 1;
    shared->own = shared->room != NULL ? STP_PSP_NEW(shared->room, uint32_t, count)
                                       : STP_NEW_ARRAY(shared->context, uint32_t, count);
    return shared->own != NULL;
}

static void close_lists(stp_psp_shared* shared)
{
    if (shared->room != NULL) {
        stp_psp_room_free(shared->room, shared->own);
    } else {
        stp_free(shared->context, shared->own);
    }
    shared->own = NULL;
}

static void begin(const stp_psp_shared* shared, uint32_t point, stp_psp_splat* splat, void* state)
{
    moments* own = state;
    uint32_t* next = shared->own;
    stp_vec3 d = stp_sub(splat->ellipse.center, shared->middle);
    const double at[3] = {(double)d.x, (double)d.y, (double)d.z};
    *own = (moments){.count = 1.0, .first = point, .last = point};
    for (int a = 0, place = 0; a < 3; ++a) {
        own->sum[a] = at[a];
        for (int b = a; b < 3; ++b) {
            own->squares[place++] = at[a] * at[b];
        }
    }
    next[point] = UINT32_MAX;
}

static moments add_moments(const moments* a, const moments* b)
{
    moments m = {.count = a->count + b->count, .first = a->first, .last = b->last};
    for (int i = 0; i < 3; ++i) {
        m.sum[i] = a->sum[i] + b->sum[i];
    }
    for (int i = 0; i < 6; ++i) {
        m.squares[i] = a->squares[i] + b->squares[i];
    }
    return m;
}

static void find_scatter(const moments* m, double scatter[6])
{
    for (int a = 0, at = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b, ++at) {
            scatter[at] = m->squares[at] - m->sum[a] * m->sum[b] / m->count;
        }
    }
}

/// Normal of the least-squares plane of a splat's points; zero if they lie on a line.
static stp_vec3 find_normal(const moments* m)
{
    double scatter[6], sums[3];
    find_scatter(m, scatter);
    stp_vec3d normal = stp_scatter_eigenvector(scatter, sums);
    return sums[1] > LINE * sums[2] ? stp_to_float(normal) : (stp_vec3){0};
}

static double measure(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                      const stp_psp_splat* b, const void* b_state)
{
    (void)shared;
    double scatter[6];
    moments both = add_moments(a_state, b_state);
    find_scatter(&both, scatter);
    double sum = stp_scatter_eigenvalue(scatter);
    return (sum > 0.0 ? sum : 0.0) + FLAT * sqrt((double)a->area * (double)b->area);
}

static void merge(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                  const stp_psp_splat* b, const void* b_state, stp_psp_splat* merged,
                  void* merged_state)
{
    const moments *l = a_state, *r = b_state;
    moments* both = merged_state;
    uint32_t* next = shared->own;
    assert(next[l->last] == UINT32_MAX && next[r->last] == UINT32_MAX && "ends of lists");
    next[l->last] = r->first;
    *both = add_moments(l, r);
    stp_vec3 normal = find_normal(both);
    stp_vec3 side =
        stp_add(stp_scale(a->ellipse.normal, a->area), stp_scale(b->ellipse.normal, b->area));
    // with few or collinear points, the plane may be perpendicular to the surface: then the splats'
    // normals are used
    if (!(fabsf(stp_dot(normal, side)) > UPRIGHT * stp_length(side))) {
        normal = stp_dot(side, side) > 0.0f ? side : a->ellipse.normal;
    }
    normal = stp_normalize(stp_dot(normal, side) < 0.0f ? stp_scale(normal, -1.0f) : normal);
    stp_vec3 mean = {(float)(both->sum[0] / both->count), (float)(both->sum[1] / both->count),
                     (float)(both->sum[2] / both->count)};
    stp_ellipse_fit fit = stp_ellipse_fit_begin(stp_add(shared->middle, mean), normal);
    for (uint32_t p = both->first; p != UINT32_MAX; p = next[p]) {
        stp_ellipse_fit_scatter(&fit, stp_psp_point_at(shared, p));
    }
    stp_ellipse_fit_orient(&fit, shared->minimum);
    for (uint32_t p = both->first; p != UINT32_MAX; p = next[p]) {
        stp_ellipse_fit_expand(&fit, stp_psp_point_at(shared, p));
    }
    merged->ellipse = stp_ellipse_fit_end(&fit);
    merged->area = stp_ellipse_area(&merged->ellipse);
}

const stp_psp_metric_table stp_psp_metric_distances = {
    .state_bytes = sizeof(moments),
    .power = 3,
    .by_length = true,
    .open = open_lists,
    .close = close_lists,
    .begin = begin,
    .error = measure,
    .merge = merge,
};
