// SPDX-License-Identifier: MIT
// Sets of method psp (src/lod/psp/psp_set.c): the implied forest, levels, coverage, and
// determinism.
#include "sphere_samples.h"
#include "tests.h"

#include "base/splats/coverage.h"
#include "base/splats/prefix_table.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "lod/psp/psp_set.h"
#include "lod/psp/region.h"
#include "lod/set_columns.h"

#include <string.h>

/// Half of the sphere is red. Samples cover like evenly spread ones.
static void make_sphere(samples* s, uint32_t count)
{
    make_sphere_samples(s, count, (float)(0.9 * sqrt(12.0 / (double)count)));
    for (uint32_t i = 0; i < count; ++i) {
        bool red = sample_normal(i, count).x > 0.0f;
        s->materials[i] = red ? 1 : 2;
        s->colors[3 * i] = 200;
        s->colors[3 * i + 1] = s->colors[3 * i + 2] = red ? 0 : 200;
        s->coverages[i] = STP_COVERAGE_WHOLE;
    }
}

static float distance_of(stp_vec3d a, stp_vec3d b)
{
    stp_vec3d d = stp_subd(a, b);
    return (float)sqrt(stp_dotd(d, d));
}

static float lowest_of(const stp_splats* s, uint32_t i)
{
    return stp_range_level(s->ranges[i] & 0xFFFFu);
}

static float highest_of(const stp_splats* s, uint32_t i)
{
    return stp_range_level(s->ranges[i] >> 16);
}

/// The next splat to split: among the unsplit ones before `end`, the one with the
/// highest lowest level.
static uint32_t find_next(const stp_splats* s, uint32_t end, const bool* is_split)
{
    uint32_t best = UINT32_MAX;
    for (uint32_t i = 0; i < end; ++i) {
        if (!is_split[i] && (s->ranges[i] & 0xFFFFu) != 0 &&
            (best == UINT32_MAX || lowest_of(s, i) > lowest_of(s, best))) {
            best = i;
        }
    }
    return best;
}

// One root; each split replaces an earlier splat by two, in the order given by the ranges.
static void check_imply_their_forest(test_state* test, stp_psp_metric metric)
{
    static samples from;
    static bool is_split[2 * SAMPLES];
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, metric, 0, &s));
    CHECK_EQUAL(2 * SAMPLES - 1, s.count);
    CHECK_EQUAL(STP_PSP_COLUMNS, s.columns);
    CHECK_EQUAL(STP_RANGE_INFINITE, s.ranges[0] >> 16);
    uint32_t leaves = 0;
    for (uint32_t i = 0; i < s.count; ++i) {
        CHECK(stp_range_is_valid(s.ranges[i]) && stp_shape_is_valid(s.shapes[i]));
        CHECK(s.materials[i] == 1 || s.materials[i] == 2);
        CHECK(i == 0 || s.ranges[i] >> 16 < STP_RANGE_INFINITE);
        leaves += (s.ranges[i] & 0xFFFFu) == 0;
    }
    CHECK_EQUAL(SAMPLES, leaves);
    memset(is_split, 0, sizeof(is_split));
    for (uint32_t child = 1; child < s.count; child += 2) {
        uint32_t parent = find_next(&s, child, is_split);
        CHECK(parent != UINT32_MAX);
        is_split[parent] = true;
        for (uint32_t k = 0; k < 2;
             ++k) { // a child may be drawn at every level at which its parent is not
            CHECK(lowest_of(&s, child + k) <= lowest_of(&s, parent));
            float apart =
                distance_of(place_of(&s, child + k), place_of(&s, parent)) - 2.0f * s.step;
            CHECK(highest_of(&s, child + k) >=
                  lowest_of(&s, parent) + STP_LEVEL_SLOPE * fmaxf(apart, 0.0f));
        }
    }
    for (uint32_t k = 0; k < s.table.size; ++k) {
        for (uint32_t i = s.table.count[k]; i < s.count; ++i) {
            CHECK(highest_of(&s, i) <= s.table.radius[k]);
        }
    }
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

void test_psp_sets_imply_their_forest(test_state* test)
{
    check_imply_their_forest(test, STP_PSP_REGIONS);
    check_imply_their_forest(test, STP_PSP_NORMALS);
    check_imply_their_forest(test, STP_PSP_DISTANCES);
}

// From any viewpoint, a splat is drawn near each sample, and far fewer splats are drawn
// at a high level.
static void check_cover_at_every_level(test_state* test, stp_psp_metric metric)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, metric, 0, &s));
    uint32_t before = UINT32_MAX;
    for (int round = 0; round < 24; ++round) {
        bool by_depth = round >= 12;
        float level = 0.01f * powf(1.6f, (float)(round % 12));
        stp_vec3d eye = {4.0 * unit(1, (uint64_t)round), 2.0, 3.0};
        float slope = STP_LEVEL_SLOPE * (round % 2 == 0 ? 1.0f : 0.3f);
        uint32_t count = 0, uncovered = 0;
        static bool drawn[2 * SAMPLES];
        for (uint32_t i = 0; i < s.count; ++i) {
            float at = by_depth ? slope * distance_of(place_of(&s, i), eye) : level;
            drawn[i] = at >= lowest_of(&s, i) && at <= highest_of(&s, i);
            count += drawn[i];
        }
        CHECK(count > 0 && (by_depth || count <= before));
        before = by_depth ? before : count;
        for (uint32_t k = 0; k < SAMPLES; k += 7) {
            bool covered = false;
            for (uint32_t i = 0; i < s.count && !covered; ++i) {
                if (!drawn[i]) {
                    continue;
                }
                float reach = s.step * stp_shape_radius(s.shapes[i] & 0xFFFu);
                float apart = distance_of(place_of(&from.set, k), place_of(&s, i));
                covered = apart * apart <= 1.2f * reach * reach;
            }
            uncovered += !covered;
        }
        CHECK(uncovered <= SAMPLES / 7 / 50);
    }
    CHECK(before < SAMPLES / 20);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

void test_psp_sets_cover_at_every_level(test_state* test)
{
    check_cover_at_every_level(test, STP_PSP_REGIONS);
    check_cover_at_every_level(test, STP_PSP_NORMALS);
    check_cover_at_every_level(test, STP_PSP_DISTANCES);
}

// If all points of a cloud are samples, their radius is 0; merged splats still have no holes.
void test_psp_sets_of_all_points_have_no_holes(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    from.set.candidate_radius = (float)(0.4 * sqrt(12.0 / SAMPLES));
    from.set.table.radius[0] = 1e-4f;
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, STP_PSP_REGIONS, 0, &s));
    uint32_t whole = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
        whole += s.coverages[i] == STP_COVERAGE_WHOLE;
    }
    CHECK(whole > 900);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

static bool is_same(const stp_splats* a, const stp_splats* b)
{
    size_t n = a->count;
    return a->count == b->count && memcmp(a->positions, b->positions, 6 * n) == 0 &&
           memcmp(a->normals, b->normals, 2 * n) == 0 && memcmp(a->colors, b->colors, 3 * n) == 0 &&
           memcmp(a->materials, b->materials, n) == 0 &&
           memcmp(a->coverages, b->coverages, n) == 0 && memcmp(a->shapes, b->shapes, 4 * n) == 0 &&
           memcmp(a->ranges, b->ranges, 4 * n) == 0 &&
           memcmp(&a->table, &b->table, sizeof(a->table)) == 0;
}

static uint32_t count_drawn(const stp_splats* s, float level)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        count += level >= lowest_of(s, i) && level <= highest_of(s, i);
    }
    return count;
}

// If the signs of normals are unknown, neighbours merge regardless of sign, into the same splats.
void test_psp_sets_of_guessed_signs_merge_alike(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    stp_splats known, guessed;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, STP_PSP_REGIONS, 0, &known));
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        if (unit(9, i) < 0.5) {
            stp_vec3 n = stp_octahedral_decode(from.normals[2 * i], from.normals[2 * i + 1]);
            stp_octahedral_encode(stp_scale(n, -1.0f), from.normals + 2 * i);
        }
    }
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, true, STP_PSP_REGIONS, 0, &guessed));
    CHECK_EQUAL(known.count, guessed.count);
    for (float level = 0.03f; level < 0.5f; level *= 1.5f) {
        uint32_t right = count_drawn(&known, level), drawn = count_drawn(&guessed, level);
        CHECK(right < SAMPLES && 10 * drawn <= 11 * right && 10 * right <= 11 * drawn);
    }
    stp_splats_destroy(context, &guessed);
    stp_splats_destroy(context, &known);
    stp_context_destroy(context);
}

void test_psp_sets_do_not_depend_on_threads(test_state* test)
{
    static samples from;
    stp_context* contexts[3];
    stp_splats sets[3];
    make_sphere(&from, SAMPLES);
    for (uint32_t i = 0; i < 3; ++i) {
        contexts[i] = test_context(NULL, i + 1, NULL);
        CHECK_EQUAL(STP_OK, stp_psp_make(contexts[i], &from.set, NULL, false, STP_PSP_REGIONS, 0,
                                         &sets[i]));
        CHECK(is_same(&sets[0], &sets[i]));
    }
    for (uint32_t i = 0; i < 3; ++i) {
        stp_splats_destroy(contexts[i], &sets[i]);
        stp_context_destroy(contexts[i]);
    }
}

// No samples, one, two, and coincident ones.
void test_psp_sets_of_few_samples(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    for (uint32_t count = 0; count < 4; ++count) {
        for (int shape = 0; shape < 2; ++shape) {
            stp_splats s;
            make_sphere(&from, count > 0 ? count : 1);
            from.set.count = count;
            for (uint32_t i = 0; i < 3 * count && shape == 1; ++i) {
                from.positions[i] = 7;
                from.set.table.radius[0] = 0.0f;
            }
            CHECK_EQUAL(STP_OK,
                        stp_psp_make(context, &from.set, NULL, false, STP_PSP_REGIONS, 0, &s));
            CHECK_EQUAL(count > 0 ? 2 * count - 1 : 0, s.count);
            for (uint32_t i = 0; i < s.count; ++i) {
                CHECK(stp_range_is_valid(s.ranges[i]) && stp_shape_is_valid(s.shapes[i]));
            }
            stp_splats_destroy(context, &s);
        }
    }
    stp_context_destroy(context);
}

// A metric merges other pairs, but levels are differences of pictures with any: the counts that a
// level draws are alike, and no level of the paper's metrics decreases towards the root.
void test_psp_sets_have_picture_levels_by_any_metric(test_state* test)
{
    static samples from;
    make_sphere(&from, SAMPLES);
    const stp_psp_metric metrics[] = {STP_PSP_REGIONS, STP_PSP_NORMALS, STP_PSP_DISTANCES};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_splats sets[3];
    for (int k = 0; k < 3; ++k) {
        CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, metrics[k], 0, &sets[k]));
    }
    for (int k = 1; k < 3; ++k) {
        CHECK(!is_same(&sets[0], &sets[k]));
        for (float level = 0.03f; level < 0.3f; level *= 1.5f) {
            uint32_t drawn = count_drawn(&sets[k], level), plain = count_drawn(&sets[0], level);
            CHECK(drawn < 2 * plain && plain < 2 * drawn);
        }
    }
    CHECK(!is_same(&sets[1], &sets[2]));
    for (int k = 0; k < 3; ++k) {
        stp_splats_destroy(context, &sets[k]);
    }
    stp_context_destroy(context);
}

// A set with a limit has the first splits of the whole set, and ends in leaves.
void test_psp_sets_end_at_a_limit(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    stp_splats whole, s;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, NULL, false, STP_PSP_REGIONS, 0, &whole));
    for (uint32_t limit = 1; limit < 2 * SAMPLES; limit *= 3) {
        uint32_t order[2 * SAMPLES], scratch[2 * SAMPLES], leaves = 0;
        uint32_t count = limit < SAMPLES ? 2 * limit - 1 : whole.count;
        CHECK_EQUAL(STP_OK,
                    stp_psp_make(context, &from.set, NULL, false, STP_PSP_REGIONS, limit, &s));
        CHECK_EQUAL(count, s.count);
        CHECK_EQUAL(count, s.octave_ends[s.octave_count - 1]);
        CHECK_EQUAL((count + 1) / 2 - 1, stp_progressive_order(s.ranges, count, order, scratch));
        CHECK(stp_progressive_is_whole(s.ranges, count, order));
        for (uint32_t i = 0; i < count; ++i) {
            bool ends = (s.ranges[i] & 0xFFFFu) == 0;
            leaves += ends;
            CHECK(s.shapes[i] == whole.shapes[i]);
            CHECK(ends || s.ranges[i] == whole.ranges[i]);
            CHECK(s.ranges[i] >> 16 == whole.ranges[i] >> 16);
        }
        CHECK_EQUAL((count + 1) / 2, leaves);
        CHECK(memcmp(s.positions, whole.positions, 6 * (size_t)count) == 0);
        CHECK(memcmp(s.colors, whole.colors, 3 * (size_t)count) == 0);
        for (uint32_t i = count; i < whole.count; ++i) { // what was left out is not drawn there
            CHECK(highest_of(&whole, i) <= s.table.radius[s.table.size - 1]);
        }
        stp_splats_destroy(context, &s);
    }
    stp_splats_destroy(context, &whole);
    stp_context_destroy(context);
}

void test_psp_sets_survive_failing_allocator(test_state* test)
{
    static samples from;
    make_sphere(&from, 200);
    const stp_shading shadings[3] = {{.growth = 0.0f}, {.growth = 1.0f}, {.growth = -0.5f}};
    const stp_psp_metric metrics[] = {STP_PSP_REGIONS, STP_PSP_DISTANCES};
    for (int k = 0; k < 2; ++k) {
        bool made = false;
        for (int n = 1; !made && n < 300; ++n) {
            test_heap heap = TEST_HEAP(n);
            stp_context* context = test_context(&heap, 1, NULL);
            stp_splats s = {0};
            if (context != NULL) {
                // of one metric, a part of the splats
                made = stp_psp_make(context, &from.set, shadings, false, metrics[k],
                                    k == 0 ? 20 : 0, &s) == STP_OK &&
                       heap.count <= n;
                stp_splats_destroy(context, &s);
            }
            stp_context_destroy(context);
            CHECK_EQUAL(0, heap.live_bytes);
        }
        CHECK(made);
    }
}

// Sums of parts equal the sums of all samples; fitting recovers an evenly sampled ellipse.
void test_psp_regions_find_their_ellipse(test_state* test)
{
    const float major = 3.0f, minor = 0.5f;
    stp_psp_region halves[2] = {{.area = 0.0}, {.area = 0.0}};
    uint32_t count = 0;
    for (int y = -60; y <= 60; ++y) {
        for (int x = -60; x <= 60; ++x) {
            float u = (float)x / 60.5f, v = (float)y / 60.5f;
            if (u * u + v * v > 1.0f) {
                continue;
            }
            stp_psp_sample sample = {.position = {5.0f, major * u, minor * v},
                                     .normal = {1.0f, 0.0f, 0.0f},
                                     .color = {100, 100, 100},
                                     .area = 1e-6f};
            stp_psp_region one = stp_psp_region_of(&sample);
            stp_psp_region* half = &halves[count++ % 2];
            *half = half->area > 0.0 ? stp_psp_region_add(half, &one) : one;
        }
    }
    stp_psp_region sum = stp_psp_region_add(&halves[0], &halves[1]);
    stp_ellipse e = stp_psp_region_ellipse(&sum, (stp_vec3){0, 0, 1});
    CHECK(fabs((double)e.center.x - 5.0) < 1e-4);
    CHECK(fabs((double)e.center.y - 0.0) < 1e-3);
    CHECK(fabs((double)e.normal.x - 1.0) < 1e-6);
    CHECK(fabs((double)fabsf(e.major.y) - (double)major) < 0.02 * (double)major);
    CHECK(fabs((double)e.minor - (double)minor) < 0.02 * (double)minor);
}

// Points of a scan have radii of their own: samples that are drawn by themselves have these.
void test_psp_samples_have_the_radii_of_their_points(test_state* test)
{
    static samples from;
    const stp_shading shadings[3] = {{.growth = 0.0f}, {.growth = 1.0f}, {.growth = -0.5f}};
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_sphere(&from, SAMPLES);
    from.set.candidate_radius = 0.05f;
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, shadings, false, STP_PSP_REGIONS, 0, &s));
    float reach = stp_prefix_table_radius(&from.set.table, from.set.count);
    uint32_t leaves = 0;
    for (uint32_t i = 0; i < s.count; ++i) {
        float radius = stp_shape_radius(s.shapes[i] & 0xFFFu) * s.step;
        float own = reach + 0.05f * (1.0f + shadings[s.materials[i]].growth);
        leaves += (s.ranges[i] & 0xFFFFu) == 0 ? 1 : 0;
        CHECK((s.ranges[i] & 0xFFFFu) != 0 || fabsf(radius - own) < 0.03f * own + s.step);
    }
    CHECK_EQUAL(SAMPLES, leaves);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

// Splats that stand for points reach as far as these, whatever their radii.
void test_psp_merges_reach_as_far_as_their_points(test_state* test)
{
    static samples from;
    const stp_shading shadings[3] = {{.growth = 0.0f}, {.growth = 7.0f}, {.growth = 7.0f}};
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_sphere(&from, 300);
    from.set.candidate_radius = 0.05f;
    float own = stp_prefix_table_radius(&from.set.table, from.set.count) + 8.0f * 0.05f;
    const stp_psp_metric metrics[] = {STP_PSP_REGIONS, STP_PSP_DISTANCES};
    for (int k = 0; k < 2; ++k) {
        stp_splats s;
        CHECK_EQUAL(STP_OK, stp_psp_make(context, &from.set, shadings, false, metrics[k], 0, &s));
        for (uint32_t i = 0; i < s.count; ++i) { // in regions, disks are cut by their neighbours
            float radius = stp_shape_radius(s.shapes[i] & 0xFFFu) * s.step;
            CHECK(radius > (k == 0 ? 0.3f : 0.97f) * own);
        }
        stp_splats_destroy(context, &s);
    }
    stp_context_destroy(context);
}
