// SPDX-License-Identifier: MIT
// Point trees, sequences and sets of many points (src/lod/spt): the same for any number of threads,
// and equal to an octree that is built by its definition.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "lod/method.h"
#include "lod/set_columns.h"
#include "lod/spt/sequence.h"
#include "lod/spt/spt_set.h"

#include <stdlib.h>
#include <string.h>

enum {
    POINTS = 70000, ///< enough to be sorted by several threads
    TOGETHER = 6000,
};

typedef struct cloud {
    uint16_t grid[3 * POINTS];
    float positions[3 * POINTS], normals[3 * POINTS];
    int8_t codes[2 * POINTS];
    uint8_t materials[POINTS], colors[3 * POINTS], coverages[POINTS];
    float corners[9]; ///< corners of a large triangle
    stp_tree_points points;
    stp_splats set;
} cloud;

/// A wavy floor; some points coincide, and some are so close that only deep levels separate them.
static void fill(cloud* c)
{
    for (uint32_t i = 0; i < POINTS; ++i) {
        uint16_t* g = c->grid + 3 * (size_t)i;
        g[0] = (uint16_t)stp_rng_below(1, 3 * (uint64_t)i, 65536);
        g[1] = (uint16_t)(30000 + 40 * (g[0] >> 9));
        g[2] = (uint16_t)stp_rng_below(1, 3 * (uint64_t)i + 1, 65536);
        stp_vec3 normal = stp_normalize((stp_vec3){0.3f, 1.0f, (float)(i % 7) * 0.1f});
        if (i % 5 == 0 && i / 5 < TOGETHER) {
            g[0] = g[1] = g[2] = 12345;
        }
        for (size_t k = 0; k < 3; ++k) {
            float nearby = i % 11 == 0 ? 1e-6f * (float)stp_rng_below(2, 3 * i + k, 9) : 0.0f;
            c->positions[3 * (size_t)i + k] =
                i % 11 == 0 ? 0.25f + nearby : (float)g[k] / 32768.0f - 1.0f;
            c->colors[3 * (size_t)i + k] = (uint8_t)stp_rng_below(3, 3 * i + k, 90);
        }
        memcpy(c->normals + 3 * (size_t)i, &normal, sizeof(normal));
        stp_octahedral_encode(normal, c->codes + 2 * (size_t)i);
        c->materials[i] = (uint8_t)(i % 4);
        c->coverages[i] = (uint8_t)(i % 3 == 0 ? 255 : 100);
    }
    memcpy(c->corners, (float[9]){-1, 0, -1, 1, 0, -1, 0, 0, 1}, sizeof(c->corners));
    c->points = (stp_tree_points){.count = POINTS,
                                  .positions = c->positions,
                                  .normals = c->normals,
                                  .colors = c->colors,
                                  .radius = 0.01f};
    c->set = (stp_splats){.count = POINTS,
                          .origin = {-1.0f, -1.0f, -1.0f},
                          .step = 1.0f / 32768.0f,
                          .positions = c->grid,
                          .normals = c->codes,
                          .materials = c->materials,
                          .octave_count = 1,
                          .octave_ends = {POINTS},
                          .colors = c->colors,
                          .coverages = c->coverages,
                          .table = {.size = 1, .count = {POINTS}, .radius = {0.01f}},
                          .candidate_radius = 0.001f};
}

typedef struct made {
    stp_context* context;
    const cloud* from;
    stp_result results[3];
    stp_point_tree tree;
    stp_point_sequence sequence;
    stp_splats set;
} made;

static void make(made* m)
{
    stp_tree_desc desc = stp_method_options_default().tree;
    m->results[0] = stp_point_tree_make(m->context, &m->from->points, &desc, &m->tree);
    m->results[1] = stp_point_sequence_make(m->context, &m->tree, 0.01, true, &m->sequence);
    stp_spt_desc all = {.tree = desc, .corners = m->from->corners, .triangle_count = 1};
    m->results[2] = stp_spt_make(m->context, &m->from->set, &all, &m->set);
}

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        make((made*)user + i);
    }
}

static void destroy(made* m)
{
    stp_point_tree_destroy(m->context, &m->tree);
    stp_point_sequence_destroy(m->context, &m->sequence);
    stp_splats_destroy(m->context, &m->set);
}

static void check_same(test_state* test, const made* a, const made* b)
{
    const stp_point_tree *s = &a->tree, *t = &b->tree;
    for (int i = 0; i < 3; ++i) {
        CHECK(a->results[i] == STP_OK && b->results[i] == STP_OK);
    }
    CHECK_EQUAL(s->count, t->count);
    CHECK_EQUAL(a->set.count, b->set.count);
    size_t nodes = s->count, splats = a->set.count;
    CHECK(memcmp(s->disks, t->disks, nodes * sizeof(*s->disks)) == 0);
    CHECK(memcmp(s->colors, t->colors, 3 * nodes) == 0);
    CHECK(memcmp(s->ends, t->ends, nodes * sizeof(*s->ends)) == 0);
    CHECK(memcmp(s->points, t->points, nodes * sizeof(*s->points)) == 0);
    CHECK(memcmp(s->errors, t->errors, nodes * sizeof(*s->errors)) == 0);
    CHECK(memcmp(s->perpendicular, t->perpendicular, nodes * sizeof(float)) == 0);
    CHECK(memcmp(s->tangential, t->tangential, nodes * sizeof(float)) == 0);
    CHECK(memcmp(a->sequence.nodes, b->sequence.nodes, nodes * sizeof(uint32_t)) == 0);
    CHECK(memcmp(a->sequence.centers, b->sequence.centers, nodes * sizeof(stp_vec3)) == 0);
    CHECK(memcmp(a->sequence.lowest, b->sequence.lowest, nodes * sizeof(float)) == 0);
    CHECK(memcmp(a->sequence.highest, b->sequence.highest, nodes * sizeof(float)) == 0);
    CHECK(memcmp(a->set.positions, b->set.positions, 6 * splats) == 0);
    CHECK(memcmp(a->set.normals, b->set.normals, 2 * splats) == 0);
    CHECK(memcmp(a->set.materials, b->set.materials, splats) == 0);
    CHECK(memcmp(a->set.colors, b->set.colors, 3 * splats) == 0);
    CHECK(memcmp(a->set.coverages, b->set.coverages, splats) == 0);
    CHECK(memcmp(a->set.shapes, b->set.shapes, splats * sizeof(uint32_t)) == 0);
    CHECK(memcmp(a->set.ranges, b->set.ranges, splats * sizeof(uint32_t)) == 0);
    CHECK(memcmp(&a->set.table, &b->set.table, sizeof(a->set.table)) == 0);
}

void test_spt_threads_change_nothing(test_state* test)
{
    cloud* c = calloc(1, sizeof(*c));
    CHECK(c != NULL);
    fill(c);
    stp_context *one = test_context(NULL, 1, NULL), *several = test_context(NULL, 4, NULL);
    made alone = {.context = one, .from = c}, together = {.context = several, .from = c};
    made within[2] = {together, together};
    make(&alone);
    make(&together);
    stp_parallel_for(several, 2, 1, make_some,
                     within); // like a build that makes several nodes at once
    check_same(test, &alone, &together);
    check_same(test, &alone, &within[0]);
    check_same(test, &alone, &within[1]);
    destroy(&alone);
    destroy(&together);
    destroy(&within[0]);
    destroy(&within[1]);
    stp_context_destroy(one);
    stp_context_destroy(several);
    free(c);
}

/// Divides a box of the octree by definition: moves points and counts nodes.
typedef struct division {
    const float* positions;
    uint32_t order[POINTS], scratch[POINTS];
    uint32_t ends[2 * POINTS], points[2 * POINTS], count;
} division;

static uint32_t octant_of(const float* p, const double center[3])
{
    return ((double)p[0] >= center[0] ? 1u : 0u) | ((double)p[1] >= center[1] ? 2u : 0u) |
           ((double)p[2] >= center[2] ? 4u : 0u);
}

static void divide(division* d, const double center[3], double half, int level, uint32_t begin,
                   uint32_t end)
{
    uint32_t ends[9] = {begin}, at = begin, filled = 0;
    for (uint32_t k = 0; k < 8; ++k) {
        for (uint32_t i = begin; i < end && level < 40; ++i) {
            if (octant_of(d->positions + 3 * (size_t)d->order[i], center) == k) {
                d->scratch[at++] = d->order[i];
            }
        }
        ends[k + 1] = level < 40 ? at : begin + (uint32_t)((uint64_t)(end - begin) * (k + 1) / 8);
        filled += ends[k + 1] > ends[k];
    }
    if (level < 40) {
        memcpy(d->order + begin, d->scratch + begin, (end - begin) * sizeof(uint32_t));
    }
    uint32_t node = filled > 1 || end - begin == 1 ? d->count++ : UINT32_MAX;
    for (uint32_t k = 0; k < 8 && end - begin > 1; ++k) {
        double next[3];
        for (uint32_t axis = 0; axis < 3; ++axis) {
            next[axis] = center[axis] + ((k >> axis & 1) != 0 ? 0.5 * half : -0.5 * half);
        }
        if (ends[k + 1] > ends[k]) {
            divide(d, next, 0.5 * half, level + 1, ends[k], ends[k + 1]);
        }
    }
    if (node != UINT32_MAX) {
        d->points[node] = end - begin == 1 ? d->order[begin] : UINT32_MAX;
        d->ends[node] = d->count;
    }
}

void test_spt_trees_are_octrees(test_state* test)
{
    cloud* c = calloc(1, sizeof(*c));
    division* d = calloc(1, sizeof(*d));
    CHECK(c != NULL && d != NULL);
    fill(c);
    stp_context* context = test_context(NULL, 3, NULL);
    double center[3], half = 0.0;
    for (size_t k = 0; k < 3; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t i = 0; i < POINTS; ++i) {
            low = fmin(low, (double)c->positions[3 * i + k]);
            high = fmax(high, (double)c->positions[3 * i + k]);
        }
        center[k] = 0.5 * (low + high);
        half = fmax(half, 0.5 * (high - low));
    }
    for (uint32_t i = 0; i < POINTS; ++i) {
        d->order[i] = i;
    }
    d->positions = c->positions;
    divide(d, center, half, 0, 0, POINTS);
    stp_tree_desc desc = stp_method_options_default().tree;
    stp_point_tree tree;
    CHECK_EQUAL(STP_OK, stp_point_tree_make(context, &c->points, &desc, &tree));
    CHECK_EQUAL(d->count, tree.count);
    CHECK(memcmp(d->ends, tree.ends, tree.count * sizeof(uint32_t)) == 0);
    CHECK(memcmp(d->points, tree.points, tree.count * sizeof(uint32_t)) == 0);
    stp_point_tree_destroy(context, &tree);
    stp_context_destroy(context);
    free(c);
    free(d);
}
