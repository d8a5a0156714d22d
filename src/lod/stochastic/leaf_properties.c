// SPDX-License-Identifier: MIT
#include "lod/stochastic/leaf_properties.h"

#include "base/splats/leaf_codes.h"
#include "lod/stochastic/scatter.h"

#include <assert.h>
#include <string.h>

enum {
    GRAIN = 64,         ///< leaves
    PLANE_SAMPLE = 256, ///< points from which the plane is fitted: the first ones, in random order
    EDGE_POINTS = 8,    ///< tested points per leaf
    EDGE_AMONG = 128,   ///< points among which neighbours are searched: a power of 2
    EDGE_NEIGHBOURS = 16,
    BEND_SAMPLE = 48,
    /// Reciprocal share of outlier normals that the spread ignores
    OUTLYING = 10,
    MIN_POINTS = 6, ///< minimum points from which plane and area are estimated
};
// a rectangle has an area of 12 sqrt(l1 l2), a disk of 4 pi sqrt(l1 l2)
#define AREA_OF_SCATTER 12.5
/// Squared length of a line over l2. Points on a line represent squares as wide as their distance
#define LINE_OF_SCATTER 12.0
#define AREA_OF_FOLD 4.0 // additional area of a folded surface, relative to its flatness
#define MIN_RATIO 0.5f   // minimum ratio of a splat's radii
/// Radius of a splat among few, relative to the radius of curvature, below which it stays a disk
#define MIN_CURVATURE 0.1f
#define FEW 6.0f // growth of splats if few are drawn

typedef struct property_loop {
    const stp_leaf_octree* octree;
    const stp_leaf_points* points;
    stp_leaf_properties* properties;
    stp_scatter* scatters; ///< NULL: not wanted
} property_loop;

static const uint32_t* points_of(const property_loop* l, size_t leaf, uint32_t maximum,
                                 uint32_t* count)
{
    const stp_leaf_cell* at = &l->octree->leaves[leaf];
    assert(at->begin < at->end && "no leaf is empty");
    uint32_t all = at->end - at->begin;
    *count = all < maximum ? all : maximum;
    return l->octree->order + at->begin;
}

static stp_vec3 normal_of(const property_loop* l, uint32_t point)
{
    const float* n = l->points->normals + 3 * (size_t)point;
    return (stp_vec3){n[0], n[1], n[2]};
}

/// A point relative to the corner of its leaf: whole numbers, so sums are exact.
static stp_vec3d place_of(const property_loop* l, size_t leaf, uint32_t point)
{
    const uint16_t* p = l->points->positions + 3 * (size_t)point;
    const uint16_t* c = l->octree->leaves[leaf].corner;
    assert(p[0] >= c[0] && p[1] >= c[1] && p[2] >= c[2]);
    return (stp_vec3d){(double)p[0] - (double)c[0], (double)p[1] - (double)c[1],
                       (double)p[2] - (double)c[2]};
}

/// A leaf's first points, relative to its corner.
typedef struct edge_points {
    float at[3][EDGE_AMONG];
    uint32_t count;
} edge_points;

/// Finds the nearest points to one. Their indices are in the low bits of sort keys, which resolve
/// distances to one part in 2^16.
static uint32_t find_nearest(const edge_points* among, uint32_t point,
                             uint32_t nearest[EDGE_NEIGHBOURS])
{
    assert(point < among->count);
    float x = among->at[0][point], y = among->at[1][point], z = among->at[2][point];
    uint32_t keys[EDGE_AMONG], found = 0;
    for (uint32_t i = 0; i < among->count; ++i) {
        float dx = among->at[0][i] - x, dy = among->at[1][i] - y, dz = among->at[2][i] - z;
        uint32_t bits = stp_bits_of_float(dx * dx + dy * dy + dz * dz);
        keys[i] = (bits & ~(uint32_t)(EDGE_AMONG - 1)) | i;
    }
    for (uint32_t i = 0; i < among->count; ++i) {
        if (found == EDGE_NEIGHBOURS && keys[i] >= nearest[found - 1]) {
            continue;
        }
        uint32_t at = found < EDGE_NEIGHBOURS ? found++ : found - 1;
        for (; at > 0 && nearest[at - 1] > keys[i]; --at) {
            nearest[at] = nearest[at - 1];
        }
        nearest[at] = keys[i];
    }
    assert(found == (among->count < EDGE_NEIGHBOURS ? among->count : EDGE_NEIGHBOURS));
    return found;
}

/// Whether the points nearest to one are distributed as at an edge.
static bool is_edge_point(const edge_points* among, uint32_t point)
{
    uint32_t nearest[EDGE_NEIGHBOURS], found = find_nearest(among, point, nearest);
    stp_scatter scatter = {0};
    for (uint32_t i = 0; i < found; ++i) {
        uint32_t other = nearest[i] & (uint32_t)(EDGE_AMONG - 1);
        stp_scatter_add(&scatter, (double)(among->at[0][other] - among->at[0][point]),
                        (double)(among->at[1][other] - among->at[1][point]),
                        (double)(among->at[2][other] - among->at[2][point]));
    }
    double matrix[6], eigenvalues[3];
    stp_scatter_matrix(&scatter, matrix);
    stp_symmetric_eigenvalues(matrix, eigenvalues);
    return stp_scatter_is_edge(eigenvalues);
}

/// Tests some points of a leaf: if none lies on an edge, the leaf has no edge (2, Edge
/// Containment).
static bool has_edge(const property_loop* l, size_t leaf)
{
    edge_points among;
    const uint32_t* order = points_of(l, leaf, EDGE_AMONG, &among.count);
    const uint16_t* corner = l->octree->leaves[leaf].corner;
    for (uint32_t i = 0; i < among.count; ++i) {
        const uint16_t* p = l->points->positions + 3 * (size_t)order[i];
        for (int k = 0; k < 3; ++k) {
            among.at[k][i] = (float)(p[k] - corner[k]);
        }
    }
    bool edge = false;
    for (uint32_t i = 0; i < EDGE_POINTS && among.count >= EDGE_NEIGHBOURS && !edge; ++i) {
        edge = is_edge_point(&among, i);
    }
    return edge;
}

static void measure_places(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const property_loop* l = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_leaf_cell* leaf = &l->octree->leaves[i];
        stp_leaf_properties* f = &l->properties[i];
        uint32_t count;
        const uint32_t* order = points_of(l, i, PLANE_SAMPLE, &count);
        stp_scatter scatter = {0};
        for (uint32_t k = 0; k < count; ++k) {
            stp_vec3d p = place_of(l, i, order[k]);
            stp_scatter_add(&scatter, p.x, p.y, p.z);
        }
        if (l->scatters != NULL) {
            l->scatters[i] = scatter;
        }
        double matrix[6], e[3];
        stp_scatter_matrix(&scatter, matrix);
        stp_symmetric_eigenvalues(matrix, e);
        assert(!(e[0] > e[1]) && !(e[1] > e[2]) && "the normal belongs to the smallest one");
        double sum = matrix[0] + matrix[3] + matrix[5];
        double flatness = sum > 0.0 && e[0] > 0.0 ? e[0] / sum : 0.0;
        double area = e[1] > 0.0 ? AREA_OF_SCATTER * sqrt(e[1] * e[2]) : 0.0;
        area = fmax(area, LINE_OF_SCATTER * e[2] / (double)(leaf->end - leaf->begin));
        area *=
            (1.0 + AREA_OF_FOLD * flatness) * (double)count / (double)(count > 1 ? count - 1 : 1);
        bool known = count >= MIN_POINTS && area > 0.0;
        *f = (stp_leaf_properties){
            .mean = {(float)(scatter.x / (double)count + (double)leaf->corner[0]),
                     (float)(scatter.y / (double)count + (double)leaf->corner[1]),
                     (float)(scatter.z / (double)count + (double)leaf->corner[2])},
            .normal = stp_to_float(stp_symmetric_eigenvector(matrix, e[0])),
            .flatness = (float)flatness,
            .min_flatness = (float)flatness,
            .area = known ? (float)area : 0.0f,
            .ratio = 1.0f,
            .known = known,
            .edge = flatness > 0.0 && (stp_scatter_is_edge(e) || has_edge(l, i))};
        f->spacing = sqrtf(f->area / (float)(leaf->end - leaf->begin));
    }
}

void stp_leaf_measure_planes(stp_context* context, const stp_leaf_octree* octree,
                             const stp_leaf_points* points, stp_leaf_properties* properties,
                             stp_scatter* scatters)
{
    property_loop loop = {octree, points, properties, scatters};
    stp_parallel_for(context, octree->leaf_count, GRAIN, measure_places, &loop);
}

enum { SPACINGS = 512 }; ///< 16 per factor of two

/// Histogram class of a spacing.
static uint32_t class_of(float spacing)
{
    const uint32_t lowest = (127u - 8u) << 4; // a 256th of a step
    uint32_t code = stp_bits_of_float(spacing) >> 19;
    return code < lowest ? 0 : code - lowest < SPACINGS ? code - lowest : SPACINGS - 1;
}

float stp_leaf_median_spacing(const stp_leaf_octree* octree, const stp_leaf_properties* properties)
{
    uint64_t counts[SPACINGS] = {0}, all = 0, below = 0;
    double sums[SPACINGS] = {0};
    for (uint32_t i = 0; i < octree->leaf_count; ++i) {
        uint32_t count = octree->leaves[i].end - octree->leaves[i].begin;
        if (properties[i].spacing > 0.0f) {
            counts[class_of(properties[i].spacing)] += count;
            sums[class_of(properties[i].spacing)] += (double)properties[i].spacing * (double)count;
            all += count;
        }
    }
    for (uint32_t k = 0; k < SPACINGS && all > 0; ++k) {
        below += counts[k];
        if (2 * below >= all) {
            return (float)(sums[k] / (double)counts[k]);
        }
    }
    return 0.0f;
}

static void measure_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const property_loop* l = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t count;
        const uint32_t* order = points_of(l, i, BEND_SAMPLE, &count);
        stp_vec3 sum = {0};
        for (uint32_t k = 0; k < count; ++k) {
            sum = stp_add(sum, normal_of(l, order[k]));
        }
        stp_vec3 mean = stp_normalize(sum), plane = l->properties[i].normal;
        // otherwise the normals face away from each other
        if (stp_length(sum) > 0.25f * (float)count) {
            l->properties[i].normal = mean;
        } else if (stp_dot(mean, plane) < 0.0f) {
            l->properties[i].normal = stp_scale(plane, -1.0f);
        }
    }
}

void stp_leaf_measure_normals(stp_context* context, const stp_leaf_octree* octree,
                              const stp_leaf_points* points, stp_leaf_properties* properties)
{
    property_loop loop = {octree, points, properties, NULL};
    if (points->are_oriented) {
        stp_parallel_for(context, octree->leaf_count, GRAIN, measure_normals, &loop);
    }
}

/// A symmetric 2 x 2 matrix.
typedef struct shape_operator {
    double uu, uv, vv;
} shape_operator;

/// Fits the change of normals along a surface by least squares: the matrix S with dn = S dp.
static bool fit_shape_operator(const property_loop* l, size_t leaf, stp_vec3 u, stp_vec3 v,
                               shape_operator* out)
{
    uint32_t count;
    const uint32_t* order = points_of(l, leaf, BEND_SAMPLE, &count);
    const stp_leaf_properties* f = &l->properties[leaf];
    double pp[3] = {0}, np[4] = {0}; // p p^t; n p^t
    for (uint32_t k = 0; k < count; ++k) {
        const uint16_t* at = l->points->positions + 3 * (size_t)order[k];
        stp_vec3 p = {(float)at[0] - f->mean[0], (float)at[1] - f->mean[1],
                      (float)at[2] - f->mean[2]};
        stp_vec3 n = normal_of(l, order[k]);
        n = stp_dot(n, f->normal) < 0.0f ? stp_scale(n, -1.0f) : n;
        double pu = (double)stp_dot(p, u), pv = (double)stp_dot(p, v);
        double nu = (double)stp_dot(n, u), nv = (double)stp_dot(n, v);
        pp[0] += pu * pu;
        pp[1] += pu * pv;
        pp[2] += pv * pv;
        np[0] += nu * pu;
        np[1] += nu * pv;
        np[2] += nv * pu;
        np[3] += nv * pv;
    }
    double det = pp[0] * pp[2] - pp[1] * pp[1];
    if (count < MIN_POINTS || !(det > 1e-6 * (pp[0] + pp[2]) * (pp[0] + pp[2]))) {
        return false;
    }
    double i0 = pp[2] / det, i1 = -pp[1] / det, i2 = pp[0] / det;
    *out = (shape_operator){.uu = np[0] * i0 + np[1] * i1,
                            .uv = 0.5 * (np[0] * i1 + np[1] * i2 + np[2] * i0 + np[3] * i1),
                            .vv = np[2] * i1 + np[3] * i2};
    return true;
}

/// Chooses the ellipse of a leaf's splats: its axes have the ratio of the principal curvatures; the
/// long one lies along the smaller curvature.
static void find_ellipse(const property_loop* l, size_t leaf)
{
    stp_leaf_properties* f = &l->properties[leaf];
    stp_vec3 n = f->normal;
    stp_vec3 other = fabsf(n.x) < 0.6f ? (stp_vec3){1, 0, 0} : (stp_vec3){0, 1, 0};
    stp_vec3 u = stp_normalize(stp_cross(n, other)), v = stp_cross(n, u);
    shape_operator b;
    if (!fit_shape_operator(l, leaf, u, v, &b)) {
        return;
    }
    double mean = 0.5 * (b.uu + b.vv), half = 0.5 * (b.uu - b.vv);
    double root = sqrt(half * half + b.uv * b.uv);
    double first = mean + root, second = mean - root; // eigenvalues of the directions below
    bool first_is_larger = fabs(first) >= fabs(second);
    double larger = first_is_larger ? fabs(first) : fabs(second);
    double smaller = first_is_larger ? fabs(second) : fabs(first);
    if (!((float)larger * f->spacing * FEW > MIN_CURVATURE)) {
        return; // flat
    }
    // eigenvector of the first, from the longer row
    double x = half + root, y = b.uv;
    if (half < 0.0) {
        x = b.uv;
        y = root - half;
    }
    double length = sqrt(x * x + y * y);
    double along_u = length > 0.0 ? x / length : 1.0, along_v = length > 0.0 ? y / length : 0.0;
    if (first_is_larger) { // its ellipse is long across it
        double kept = along_u;
        along_u = -along_v;
        along_v = kept;
    }
    f->ratio = stp_max((float)(smaller / larger), MIN_RATIO);
    assert(f->ratio >= MIN_RATIO && f->ratio <= 1.0f);
    f->stretch = stp_normalize(stp_add(stp_scale(u, (float)along_u), stp_scale(v, (float)along_v)));
}

static void measure_curvatures(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const property_loop* l = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t count;
        const uint32_t* order = points_of(l, i, BEND_SAMPLE, &count);
        float lowest[BEND_SAMPLE / OUTLYING + 1];
        uint32_t kept = count / OUTLYING + 1, found = 0;
        for (uint32_t k = 0; k < count; ++k) { // the lowest cosines, ascending
            float cosine = stp_dot(normal_of(l, order[k]), l->properties[i].normal);
            cosine = l->points->are_oriented ? cosine : fabsf(cosine);
            if (found == kept && cosine >= lowest[kept - 1]) {
                continue;
            }
            uint32_t at = found < kept ? found++ : kept - 1;
            for (; at > 0 && lowest[at - 1] > cosine; --at) {
                lowest[at] = lowest[at - 1];
            }
            lowest[at] = cosine;
        }
        assert(found == kept && kept <= count);
        float minimum = lowest[kept - 1];
        l->properties[i].spread =
            minimum > 0.0f ? sqrtf(stp_max(1.0f - minimum * minimum, 0.0f)) : 1.0f;
        find_ellipse(l, i);
    }
}

void stp_leaf_measure_curvature(stp_context* context, const stp_leaf_octree* octree,
                                const stp_leaf_points* points, stp_leaf_properties* properties)
{
    property_loop loop = {octree, points, properties, NULL};
    stp_parallel_for(context, octree->leaf_count, GRAIN, measure_curvatures, &loop);
}
