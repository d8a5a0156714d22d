// SPDX-License-Identifier: MIT
// A number of splats from sets that were built leaf by leaf (src/select/cue_share.c): distributed
// over all leaves by weight, against a search for the density by bisection.
#include "stochastic_scene.h"

#include "base/math/rng.h"
#include "base/splats/leaf_runs.h"
#include "select/cues.h"

#include <string.h>

enum { POINTS = 3000, LEAVES_MAX = POINTS };

typedef struct fixture {
    stochastic_scene scene;
    uint32_t drawn[LEAVES_MAX]; ///< splats of each leaf in the list
} fixture;

static double unit(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

/// A floor that is dense on one side, and a ball on it: leaves with many and few points, flat and
/// bent ones, and edges.
static bool set_up(fixture* f)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    const stp_leaf_desc desc = {.budget = 60, .minimum = 4, .flatness = 0.005f, .sample = 100};
    for (uint64_t i = 0; i < POINTS; ++i) {
        float *p = positions + 3 * i, *n = normals + 3 * i;
        double a = unit(1, i), b = unit(2, i);
        if (i % 3 != 0) {
            memcpy(p, (float[3]){(float)(a * a * a), (float)b, 0.0f}, 3 * sizeof(float));
            memcpy(n, (float[3]){0.0f, 0.0f, 1.0f}, 3 * sizeof(float));
            continue;
        }
        double z = 2.0 * a - 1.0, r = sqrt(1.0 - z * z), turn = 6.2831853 * b;
        memcpy(n, (float[3]){(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z},
               3 * sizeof(float));
        for (int k = 0; k < 3; ++k) {
            p[k] = 0.5f + 0.2f * n[k];
        }
    }
    const stp_boxd bounds = {{0, 0, 0}, {1, 1, 1}};
    return stochastic_scene_open(&f->scene, &desc, positions, normals, POINTS, bounds) &&
           f->scene.leaves.leaf_count > 20 && f->scene.leaves.leaf_count <= LEAVES_MAX;
}

/// Selects `count` splats, and counts those of each leaf. @return false if a splat is drawn twice
static bool draw(fixture* f, uint64_t count, uint32_t cues, stp_vec3d eye)
{
    static uint8_t seen[POINTS];
    const stp_splats* set = &f->scene.made.sets[0];
    const stp_view view = {.eye = eye,
                           .target = {0.5, 0.5, 0.0},
                           .up = {0, 1, 0},
                           .fov_degrees = 60,
                           .width = 200,
                           .height = 200};
    const stp_quality quality = {.splat_count = count, .cues_off = STP_CUES_ALL & ~cues};
    bool good =
        stp_select(f->scene.context, f->scene.store, &view, &quality, &f->scene.list) == STP_OK;
    memset(seen, 0, sizeof(seen));
    for (size_t i = 0; good && i < f->scene.list.count; ++i) {
        const stp_draw_item* item = &f->scene.list.items[i];
        const stp_draw_run all = {.begin = 0, .end = item->prefix};
        const stp_draw_run* runs =
            item->run_count > 0 ? f->scene.list.runs + item->first_run : &all;
        for (uint32_t r = 0; r < (item->run_count > 0 ? item->run_count : 1); ++r) {
            for (uint32_t k = runs[r].begin; k < runs[r].end; ++k) {
                good = good && seen[k] == 0;
                seen[k] = 1;
            }
        }
    }
    memset(f->drawn, 0, sizeof(f->drawn));
    for (uint32_t i = 0; i < f->scene.leaves.node_count; ++i) {
        const stp_leaf_node* node = &f->scene.leaves.nodes[i];
        for (uint32_t k = 0; node->leaf_count == 1 && k < set->octave_count; ++k) {
            stp_leaf_run run = stp_leaf_run_of(node->first, node->first + node->count, k,
                                               set->octave_count, set->count);
            for (uint32_t at = run.begin; at < run.end; ++at) {
                f->drawn[node->leaf] += seen[at];
            }
        }
    }
    return good;
}

static double weight(const stp_leaf_node* node, uint32_t cues)
{
    double w = (double)node->area;
    if ((cues & STP_CUE_ERROR_BIT) != 0) {
        return w;
    }
    w *= node->edge > 0.0f && (cues & STP_CUE_EDGE_BIT) != 0 ? 4.0 : 1.0;
    double bent = fmin((double)node->flatness / 0.005, 1.0);
    return (cues & STP_CUE_FLATNESS_BIT) != 0 ? w * (1.0 + bent) : w;
}

/// What a leaf gets at a density.
static double given(const stp_leaf_node* node, uint32_t cues, double density)
{
    return fmin(density * weight(node, cues), node->count);
}

static double find_density(const fixture* f, uint32_t count, uint32_t cues)
{
    double low = 0.0, high = 1e12;
    for (int step = 0; step < 200; ++step) {
        double middle = 0.5 * (low + high), sum = 0.0;
        for (uint32_t i = 0; i < f->scene.leaves.node_count; ++i) {
            const stp_leaf_node* node = &f->scene.leaves.nodes[i];
            sum += node->leaf_count == 1 ? given(node, cues, middle) : 0.0;
        }
        low = sum < count ? middle : low;
        high = sum < count ? high : middle;
    }
    return low;
}

void test_stochastic_count_is_shared_by_weight(test_state* test)
{
    static fixture f;
    static const uint32_t counts[] = {40, 150, 333, 1000, 2000, 2900};
    static const uint32_t cues[] = {STP_CUE_ERROR_BIT | STP_CUE_EDGE_BIT, STP_CUE_EDGE_BIT,
                                    STP_CUE_FLATNESS_BIT, STP_CUE_EDGE_BIT | STP_CUE_FLATNESS_BIT,
                                    0};
    CHECK(set_up(&f));
    for (size_t c = 0; c < sizeof(cues) / sizeof(cues[0]); ++c) {
        for (size_t n = 0; n < sizeof(counts) / sizeof(counts[0]); ++n) {
            CHECK(draw(&f, counts[n], cues[c], (stp_vec3d){0.5, 0.5, 3.0}));
            CHECK_EQUAL(counts[n], f.scene.list.splat_count);
            double density = find_density(&f, counts[n], cues[c]);
            for (uint32_t i = 0; i < f.scene.leaves.node_count; ++i) {
                const stp_leaf_node* node = &f.scene.leaves.nodes[i];
                double expected = 0.0, drawn = 0.0;
                for (uint32_t k = i; k < node->next; ++k) {
                    const stp_leaf_node* leaf = &f.scene.leaves.nodes[k];
                    bool is_leaf = leaf->leaf_count == 1;
                    expected += is_leaf ? given(leaf, cues[c], density) : 0.0;
                    drawn += is_leaf ? f.drawn[leaf->leaf] : 0.0;
                }
                double depth = node->depth; // each level rounds
                CHECK(fabs(drawn - expected) < 1.5 + 0.5 * depth);
            }
        }
    }
    stochastic_scene_close(&f.scene);
}

// The view does not matter, nor do counts beyond all.
void test_stochastic_count_has_its_limits(test_state* test)
{
    static fixture f;
    static uint32_t from_above[LEAVES_MAX];
    const uint32_t cues = STP_CUE_EDGE_BIT;
    CHECK(set_up(&f));
    CHECK(draw(&f, 500, cues, (stp_vec3d){0.5, 0.5, 3.0}));
    memcpy(from_above, f.drawn, sizeof(from_above));
    CHECK(draw(&f, 500, cues, (stp_vec3d){0.9, 0.1, 0.4})); // some leaves are out of view
    CHECK(memcmp(from_above, f.drawn, sizeof(from_above)) == 0);
    CHECK(draw(&f, 1, cues, (stp_vec3d){0.5, 0.5, 3.0}));
    CHECK_EQUAL(1, f.scene.list.splat_count);
    const uint64_t all[] = {POINTS, POINTS + 1, UINT64_MAX};
    uint32_t whole = f.scene.made.sets[0].count;
    for (int i = 0; i < 3; ++i) {
        CHECK(draw(&f, all[i], cues, (stp_vec3d){0.5, 0.5, 3.0}));
        CHECK_EQUAL(whole, f.scene.list.splat_count);
    }
    stochastic_scene_close(&f.scene);
}

/// Splats of the leaves in one half of the floor and ball, x below or from 0.5 on.
static uint32_t count_half(const fixture* f, bool upper)
{
    uint32_t sum = 0;
    double step = (double)f->scene.made.sets[0].step, low = (double)f->scene.made.sets[0].origin.x;
    for (uint32_t i = 0; i < f->scene.leaves.node_count; ++i) {
        const stp_leaf_node* node = &f->scene.leaves.nodes[i];
        bool above = low + step * node->corner[0] >= 0.5;
        sum += node->leaf_count == 1 && above == upper ? f->drawn[node->leaf] : 0;
    }
    return sum;
}

// Importance sampling: the same number, and more of it near the eye.
void test_stochastic_count_follows_the_view(test_state* test)
{
    static fixture f;
    const uint32_t by_area = STP_CUE_COVERAGE_BIT, by_view = by_area | STP_CUE_IMPORTANCE_BIT;
    CHECK(set_up(&f));
    for (int side = 0; side < 2; ++side) {
        const stp_vec3d eye = {side == 0 ? -0.4 : 1.4, 0.5, 0.5};
        CHECK(draw(&f, 300, by_area, eye));
        CHECK_EQUAL(300, f.scene.list.splat_count);
        uint32_t before = count_half(&f, side == 1);
        CHECK(draw(&f, 300, by_view, eye));
        CHECK_EQUAL(300, f.scene.list.splat_count);
        CHECK(count_half(&f, side == 1) > 1.15 * before);
        CHECK(draw(&f, 2900, by_view, eye)); // those out of view give the rest
        CHECK_EQUAL(2900, f.scene.list.splat_count);
    }
    stochastic_scene_close(&f.scene);
}
