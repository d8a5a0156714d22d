// SPDX-License-Identifier: MIT
// Triangles are sorted along a space-filling curve; the tree of boxes halves that list recursively.
#include "base/splats/triangle_level.h"
#include "lod/grid.h"
#include "lod/spt/node_splats.h"

#include <assert.h>

enum {
    LEAF_TRIANGLES = 4,
    DEPTH_MAX = 33,
    LOOKS_MAX = 1000, ///< maximum visited tree nodes per sample
};

/// Maximum distance of a sample from its triangle caused by rounding, in grid steps of the set
#define NEAR_STEPS 1.5f
#define BESIDE 2.0f ///< radius within which a sample's disk may cover surface, in its own radii
#define ALIKE 0.5f  ///< minimum cosine between normals of surfaces that one disk covers

typedef struct range {
    uint32_t begin, end;
} range;

/// Bounding box of a range of triangles, and their highest level.
typedef struct bounds {
    stp_box box;
    float level;
} bounds;

typedef struct replaced {
    const stp_method_samples* samples;
    const float* corners;
    const uint32_t* order; ///< triangles sorted along the curve
    bounds* tree;          ///< binary heap over ranges of `order`
    uint32_t count;
    float near;  ///< maximum distance at which a sample counts as on a triangle
    float reach; ///< maximum distance at which any sample's disk may cover surface
    float* on;   ///< per sample, the highest level of triangles it lies on
    float* levels;
    const stp_grid* grid;
} replaced;

static stp_vec3 corner(const float* corners, uint32_t triangle, int k)
{
    const float* p = corners + 9 * (size_t)triangle + 3 * k;
    return (stp_vec3){p[0], p[1], p[2]};
}

static float find_level(const float* corners, uint32_t triangle)
{
    return stp_triangle_level(corner(corners, triangle, 0), corner(corners, triangle, 1),
                              corner(corners, triangle, 2));
}

static bounds make_tree(replaced* r, uint32_t node, range of)
{
    assert(of.begin < of.end && node < 2 * (size_t)r->count + 1);
    bounds b = {.box = stp_box_empty()};
    if (of.end - of.begin <= LEAF_TRIANGLES) {
        for (uint32_t i = of.begin; i < of.end; ++i) {
            for (int k = 0; k < 3; ++k) {
                stp_box_add(&b.box, corner(r->corners, r->order[i], k));
            }
            b.level = fmaxf(b.level, find_level(r->corners, r->order[i]));
        }
    } else {
        uint32_t middle = of.begin + (of.end - of.begin) / 2;
        b = make_tree(r, 2 * node + 1, (range){of.begin, middle});
        bounds other = make_tree(r, 2 * node + 2, (range){middle, of.end});
        stp_box_add(&b.box, other.box.min);
        stp_box_add(&b.box, other.box.max);
        b.level = fmaxf(b.level, other.level);
    }
    return r->tree[node] = b;
}

/// The point of a triangle nearest to `p` (Ericson 2005, 5.1.5).
static stp_vec3 find_nearest(const float* corners, uint32_t triangle, stp_vec3 p)
{
    stp_vec3 a = corner(corners, triangle, 0), b = corner(corners, triangle, 1),
             c = corner(corners, triangle, 2);
    stp_vec3 ab = stp_sub(b, a), ac = stp_sub(c, a), ap = stp_sub(p, a), bp = stp_sub(p, b),
             cp = stp_sub(p, c);
    float d1 = stp_dot(ab, ap), d2 = stp_dot(ac, ap), d3 = stp_dot(ab, bp), d4 = stp_dot(ac, bp),
          d5 = stp_dot(ab, cp), d6 = stp_dot(ac, cp);
    if (d1 <= 0.0f && d2 <= 0.0f) {
        return a;
    }
    if (d3 >= 0.0f && d4 <= d3) {
        return b;
    }
    if (d6 >= 0.0f && d5 <= d6) {
        return c;
    }
    float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) {
        return stp_add(a, stp_scale(ab, d1 / (d1 - d3)));
    }
    if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) {
        return stp_add(a, stp_scale(ac, d2 / (d2 - d6)));
    }
    if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) {
        return stp_add(b, stp_scale(stp_sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    float whole = va + vb + vc;
    return stp_add(a, stp_add(stp_scale(ab, vb / whole), stp_scale(ac, vc / whole)));
}

static bool is_outside(stp_box box, stp_vec3 p, float near)
{
    return p.x < box.min.x - near || p.x > box.max.x + near || p.y < box.min.y - near ||
           p.y > box.max.y + near || p.z < box.min.z - near || p.z > box.max.z + near;
}

/// Highest level of the triangles that a point lies on. 0 if the search takes too long: then splats
/// are kept.
static float find_on(const replaced* r, stp_vec3 p)
{
    struct {
        uint32_t node;
        range of;
    } stack[DEPTH_MAX] = {{0, {0, r->count}}};
    uint32_t size = 1, looked = 0;
    float level = 0.0f;
    while (size > 0) {
        uint32_t node = stack[--size].node;
        range of = stack[size].of;
        if (++looked > LOOKS_MAX) {
            return 0.0f;
        }
        if (!(r->tree[node].level > level) || is_outside(r->tree[node].box, p, r->near)) {
            continue;
        }
        if (of.end - of.begin > LEAF_TRIANGLES) {
            uint32_t middle = of.begin + (of.end - of.begin) / 2;
            assert(size + 2 <= DEPTH_MAX && "each level adds one range");
            stack[size].node = 2 * node + 1;
            stack[size++].of = (range){of.begin, middle};
            stack[size].node = 2 * node + 2;
            stack[size++].of = (range){middle, of.end};
            continue;
        }
        for (uint32_t i = of.begin; i < of.end; ++i) {
            uint32_t t = r->order[i];
            if (stp_length(stp_sub(find_nearest(r->corners, t, p), p)) <= r->near) {
                level = fmaxf(level, find_level(r->corners, t));
            }
        }
    }
    return level;
}

static stp_vec3 vector_at(const float* values, size_t index)
{
    return (stp_vec3){values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

static void find_all_on(size_t begin, size_t end, uint32_t worker, void* user)
{
    const replaced* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        r->on[i] = find_on(r, vector_at(r->samples->positions, i));
    }
}

/// Minimum level of the samples in a bucket whose surface a sample's disk may cover.
static float min_level_in_bucket(const replaced* r, uint32_t bucket, size_t sample, float level)
{
    const stp_grid* g = r->grid;
    stp_vec3 p = vector_at(r->samples->positions, sample),
             n = vector_at(r->samples->normals, sample);
    float reach = BESIDE * stp_method_samples_radius(r->samples, sample);
    for (uint32_t k = g->starts[bucket]; k < g->starts[bucket + 1]; ++k) {
        stp_vec3 d = {g->x[k] - p.x, g->y[k] - p.y, g->z[k] - p.z};
        stp_vec3 m = {g->nx[k], g->ny[k], g->nz[k]};
        if (stp_dot(d, d) <= reach * reach && stp_dot(m, n) > ALIKE) {
            level = fminf(level, r->on[g->index[k]]);
        }
    }
    return level;
}

static void find_levels(size_t begin, size_t end, uint32_t worker, void* user)
{
    const replaced* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        stp_vec3 p = vector_at(r->samples->positions, i);
        float level = r->on[i];
        int32_t low[3] = {stp_grid_cell(r->grid, p.x) - 1, stp_grid_cell(r->grid, p.y) - 1,
                          stp_grid_cell(r->grid, p.z) - 1};
        for (int32_t k = 0; k < 27 && level > 0.0f; ++k) {
            uint32_t bucket =
                stp_grid_bucket(r->grid, low[0] + k % 3, low[1] + k / 3 % 3, low[2] + k / 9);
            level = min_level_in_bucket(r, bucket, i, level);
        }
        r->levels[i] = level;
    }
}

static stp_result find_all(stp_context* context, replaced* r)
{
    const stp_tree_points* points = &r->samples->points;
    stp_grid grid = {0};
    stp_result result = stp_grid_create(context, r->samples->positions, r->samples->normals,
                                        points->count, r->reach, 0.0f, &grid);
    if (result == STP_OK) {
        assert(!(grid.cell < r->reach) && "27 cells hold all neighbours");
        r->grid = &grid;
        (void)make_tree(r, 0, (range){0, r->count});
        stp_parallel_for(context, points->count, 512, find_all_on, r);
        stp_parallel_for(context, points->count, 512, find_levels, r);
    }
    stp_grid_destroy(context, &grid);
    return result;
}

stp_result stp_spt_find_replaced(stp_context* context, const stp_method_samples* samples,
                                 float step, const float* corners, uint32_t count, float* levels)
{
    assert(count == 0 || (corners != NULL && step > 0.0f));
    size_t sample_count = samples->points.count;
    for (size_t i = 0; i < sample_count; ++i) {
        levels[i] = 0.0f;
    }
    if (count == 0 || !(samples->points.radius > 0.0f)) {
        return STP_OK;
    }
    float* middles = STP_NEW_ARRAY(context, float, 3 * (size_t)count);
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, count);
    replaced r = {.samples = samples,
                  .corners = corners,
                  .order = order,
                  .tree = STP_NEW_ARRAY(context, bounds, 2 * (size_t)count + 1),
                  .count = count,
                  .near = NEAR_STEPS * step,
                  .on = STP_NEW_ARRAY(context, float, sample_count),
                  .levels = levels};
    float widest = samples->points.radius;
    for (size_t i = 0; i < sample_count; ++i) {
        widest = fmaxf(widest, stp_method_samples_radius(samples, i));
    }
    r.reach = BESIDE * widest;
    bool made = middles != NULL && order != NULL && r.tree != NULL && r.on != NULL;
    for (size_t i = 0; made && i < 3 * (size_t)count; ++i) {
        const float* p = corners + 9 * (i / 3) + i % 3;
        middles[i] = (p[0] + p[3] + p[6]) * (1.0f / 3.0f);
    }
    stp_result result =
        made ? stp_sort_spatially(context, middles, count, order) : stp_fail_memory(context);
    result = result == STP_OK ? find_all(context, &r) : result;
    stp_free(context, middles);
    stp_free(context, order);
    stp_free(context, r.tree);
    stp_free(context, r.on);
    return result;
}
