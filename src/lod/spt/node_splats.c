// SPDX-License-Identifier: MIT
#include "lod/spt/node_splats.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "lod/set_columns.h"

#include <assert.h>
#include <string.h>

enum {
    GRAIN = 1024, ///< nodes
    BLOCK = 64,   ///< normals encoded per batch
};

#define HALF_DIAGONAL 0.8660254f ///< half the diagonal of a unit cube

typedef struct splat_maker {
    const stp_point_tree* tree;
    const stp_method_samples* samples;
    const stp_node_splats_desc* desc;
    double* areas;    ///< prefix sums over nodes: drawn share of each leaf's disk
    uint32_t* leaves; ///< prefix sums over nodes: number of leaves
    stp_node_splat* splats;
} splat_maker;

/// Sine of the largest angle between a node's normal and those of its leaves, rounded up:
/// STP_SHAPE_SPREAD_ANY is 1.
static uint8_t find_spread(const stp_point_tree* tree, uint32_t node)
{
    stp_vec3 normal = tree->disks[node].normal;
    float minimum = stp_dot(normal, normal) > 0.0f ? 1.0f : 0.0f;
    for (uint32_t i = node + 1; i < tree->ends[node] && minimum > 0.0f; ++i) {
        float cosine = stp_dot(normal, tree->disks[i].normal);
        minimum = tree->points[i] != UINT32_MAX && cosine < minimum ? cosine : minimum;
    }
    if (!(minimum > 0.0f)) {
        return STP_SHAPE_SPREAD_ANY;
    }
    float sine =
        sqrtf(fmaxf(1.0f - minimum * minimum, 0.0f)) * (float)STP_SHAPE_SPREAD_ANY + 0.999f;
    return sine < (float)STP_SHAPE_SPREAD_ANY ? (uint8_t)sine : STP_SHAPE_SPREAD_ANY;
}

/// The first leaf below a node, or itself.
static uint32_t first_leaf(const stp_point_tree* tree, uint32_t node)
{
    while (tree->points[node] == UINT32_MAX) {
        assert(node + 1 < tree->ends[node] && "an inner node has children");
        node += 1;
    }
    return node;
}

/// Maps a normal to one of 128 directions, the triangles of a subdivided octahedron (3.10): its
/// octant, then one of sixteen triangles.
static uint32_t find_cluster(stp_vec3 n)
{
    float x = fabsf(n.x), y = fabsf(n.y), sum = x + y + fabsf(n.z);
    uint32_t octant = (n.x < 0.0f ? 1u : 0u) | (n.y < 0.0f ? 2u : 0u) | (n.z < 0.0f ? 4u : 0u);
    float scale = sum > 0.0f ? 4.0f / sum : 0.0f;
    uint32_t a = (uint32_t)(x * scale), b = (uint32_t)(y * scale);
    a = a < 3 ? a : 3;
    b = b < 3 - a ? b : 3 - a;
    // each row alternates upright and inverted triangles
    bool turned = x * scale - (float)a + (y * scale - (float)b) > 1.0f && a + b < 3;
    static const uint32_t rows[4] = {0, 7, 12, 15};
    assert(a + b <= 3 && (!turned || a + b < 3));
    return 16 * octant + rows[a] + 2 * b + (turned ? 1 : 0);
}

// Drawn shares of leaves; 0 for inner nodes.
static void find_areas(size_t begin, size_t end, uint32_t worker, void* user)
{
    const splat_maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t point = m->tree->points[i];
        // leaves cut at a border count as whole: a share would make holes inside the border
        m->areas[i] = point != UINT32_MAX
                          ? (double)stp_coverage_share(m->samples->coverages[point]) / 255.0
                          : 0.0;
    }
}

// Sequential: floating-point sums depend on the order.
static void sum_areas(splat_maker* m)
{
    double area = 0.0;
    uint32_t leaves = 0;
    for (size_t i = 0; i <= m->tree->count; ++i) {
        double own = i < m->tree->count ? m->areas[i] : 0.0;
        m->areas[i] = area;
        m->leaves[i] = leaves;
        area += own;
        leaves += i < m->tree->count && m->tree->points[i] != UINT32_MAX;
    }
    assert(leaves == m->tree->leaf_count);
}

static uint8_t find_coverage(const splat_maker* m, uint32_t node)
{
    uint32_t point = m->tree->points[node], end = m->tree->ends[node];
    if (point != UINT32_MAX) {
        return m->samples->coverages[point];
    }
    assert(m->leaves[end] > m->leaves[node] && "each node has leaves");
    double area = m->areas[end] - m->areas[node];
    double mean = area / (double)(m->leaves[end] - m->leaves[node]);
    return mean < 254.0 / 255.0 ? stp_coverage_of_share(mean) : STP_COVERAGE_WHOLE;
}

/// Makes all but the encoded normal and the level of replacement. @return the normal
static stp_vec3 make_splat(const splat_maker* m, uint32_t node, stp_node_splat* splat)
{
    const stp_tree_disk* disk = &m->tree->disks[node];
    const stp_node_splats_desc* grid = m->desc;
    uint32_t leaf = first_leaf(m->tree, node);
    splat->position[0] = stp_splats_grid_place(disk->center.x, grid->origin.x, grid->step);
    splat->position[1] = stp_splats_grid_place(disk->center.y, grid->origin.y, grid->step);
    splat->position[2] = stp_splats_grid_place(disk->center.z, grid->origin.z, grid->step);
    memcpy(splat->color, m->tree->colors + 3 * (size_t)node, 3);
    splat->material = m->desc->materials[m->tree->points[leaf]];
    splat->coverage = find_coverage(m, node);
    splat->cluster = (uint8_t)find_cluster(disk->normal);
    // rounding to the grid moves centres by up to half the diagonal of a cell
    float radius = disk->radius / grid->step + HALF_DIAGONAL;
    splat->shape = stp_shape_disk(radius, find_spread(m->tree, node), false);
    // a sphere uses the normal of its first leaf
    bool turned = stp_dot(disk->normal, disk->normal) > 0.0f;
    return turned ? disk->normal : m->tree->disks[leaf].normal;
}

static void make_splats(size_t begin, size_t end, uint32_t worker, void* user)
{
    const splat_maker* m = user;
    stp_vec3 normals[BLOCK];
    int8_t codes[2 * BLOCK];
    (void)worker;
    for (size_t first = begin; first < end; first += BLOCK) {
        size_t count = end - first < BLOCK ? end - first : BLOCK;
        for (size_t i = 0; i < count; ++i) {
            normals[i] = make_splat(m, (uint32_t)(first + i), &m->splats[first + i]);
        }
        stp_octahedral_encode_many(&normals[0].x, count, codes);
        for (size_t i = 0; i < count; ++i) {
            memcpy(m->splats[first + i].normal, codes + 2 * i, 2);
        }
    }
}

/// Leaves take the value of their sample; inner nodes the minimum of their children.
static void find_replaced(const splat_maker* m)
{
    const stp_point_tree* t = m->tree;
    for (uint32_t i = t->count; i-- > 0;) {
        uint32_t point = t->points[i];
        float minimum = point != UINT32_MAX ? m->desc->replaced[point] : HUGE_VALF;
        for (uint32_t c = i + 1; c < t->ends[i]; c = t->ends[c]) {
            assert(t->ends[c] <= t->ends[i] && "subtrees of children are in that of their parent");
            minimum = fminf(minimum, m->splats[c].replaced);
        }
        m->splats[i].replaced = minimum;
    }
}

stp_result stp_node_splats_make(stp_context* context, const stp_point_tree* tree,
                                const stp_method_samples* samples, const stp_node_splats_desc* desc,
                                stp_node_splat** splats)
{
    assert(desc->step > 0.0f && samples->points.count == tree->leaf_count);
    size_t count = tree->count;
    splat_maker m = {
        .tree = tree,
        .samples = samples,
        .desc = desc,
        .areas = STP_NEW_ARRAY(context, double, count + 1),
        .leaves = STP_NEW_ARRAY(context, uint32_t, count + 1),
        .splats = STP_NEW_ARRAY(context, stp_node_splat, count),
    };
    bool made = m.areas != NULL && m.leaves != NULL && m.splats != NULL;
    if (made) {
        stp_parallel_for(context, count, 16 * GRAIN, find_areas, &m);
        sum_areas(&m);
        stp_parallel_for(context, count, GRAIN, make_splats, &m);
        find_replaced(&m);
    }
    stp_free(context, m.areas);
    stp_free(context, m.leaves);
    if (!made) {
        stp_free(context, m.splats);
        return stp_fail_memory(context);
    }
    *splats = m.splats;
    return STP_OK;
}
