// SPDX-License-Identifier: MIT
// Sets of Sequential Point Trees (src/lod/spt/spt_set.c): order, ranges, table, and coverage at any
// level.
#include "sphere_samples.h"
#include "tests.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "base/splats/splat_codes.h"
#include "lod/method.h"
#include "lod/set_columns.h"
#include "lod/spt/spt_set.h"

#include <stdlib.h>
#include <string.h>

static void make_samples(samples* s)
{
    make_sphere_samples(s, SAMPLES, 0.06f);
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        stp_vec3 n = sample_normal(i, SAMPLES);
        s->materials[i] = (uint8_t)(i % 3);
        s->colors[3 * i] = 200;
        s->colors[3 * i + 1] = (uint8_t)(n.x > 0.0f ? 255 : 0);
        s->colors[3 * i + 2] = 10;
        s->coverages[i] = n.y > 0.0f ? STP_COVERAGE_WHOLE : stp_coverage_of_share(0.5);
    }
}

/// @param sight NULL, or the direction to the eye, for sets with split errors
static bool is_drawn(const stp_splats* s, uint32_t i, double level, const stp_vec3* sight)
{
    float own = 1.0f, parent = 1.0f;
    if (sight != NULL) {
        uint32_t code = s->errors[i];
        own = stp_error_share(code & 15u, code >> 4 & 15u,
                              stp_octahedral_decode(s->normals[2 * i], s->normals[2 * i + 1]),
                              *sight);
        parent = stp_error_share(code >> 8 & 15u, code >> 12 & 15u,
                                 stp_octahedral_decode((int8_t)(code >> 16), (int8_t)(code >> 24)),
                                 *sight);
    }
    return level >= (double)(own * stp_range_level(s->ranges[i] & 0xFFFFu)) &&
           level <= (double)(parent * stp_range_level(s->ranges[i] >> 16));
}

void test_spt_sets_are_sequences(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_samples(&from);
    stp_spt_desc desc = {.tree = stp_method_options_default().tree};
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_spt_make(context, &from.set, &desc, &s));
    CHECK(s.count > SAMPLES && s.count < 2 * SAMPLES);
    CHECK_EQUAL(STP_SPT_COLUMNS, s.columns);
    CHECK_EQUAL(s.count, s.octave_ends[s.octave_count - 1]);
    uint32_t leaves = 0, seams = 0;
    for (uint32_t i = 0; i < s.count; ++i) {
        CHECK(stp_range_is_valid(s.ranges[i]) && stp_shape_is_valid(s.shapes[i]));
        leaves += (s.ranges[i] & 0xFFFFu) == 0;
        seams += s.colors[3 * i + 1] != 0 && s.colors[3 * i + 1] != 255;
        CHECK(s.colors[3 * i] == 200 && s.colors[3 * i + 2] == 10); // means of equal values
        CHECK(s.materials[i] < 3 && s.coverages[i] != 0);
    }
    CHECK_EQUAL(SAMPLES, leaves);
    CHECK(seams > 0 && seams < s.count / 4);
    // the level of a prefix is the maximum level of all later splats
    for (uint32_t k = 0; k < s.table.size; ++k) {
        for (uint32_t i = s.table.count[k]; i < s.count; ++i) {
            CHECK(stp_range_level(s.ranges[i] >> 16) <= s.table.radius[k]);
        }
    }
    CHECK_EQUAL(s.count, s.table.count[s.table.size - 1]);
    CHECK(s.table.radius[s.table.size - 1] == 0.06f);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

// At any level, of a view or of the whole set, each sample lies in a drawn disk.
static void check_cover(test_state* test, stp_tree_error error)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    make_samples(&from);
    stp_spt_desc desc = {.tree = stp_method_options_default().tree};
    desc.tree.error = error;
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_spt_make(context, &from.set, &desc, &s));
    uint32_t before = UINT32_MAX;
    for (int round = 0; round < 40; ++round) {
        bool by_depth = round >= 20;
        double level = 0.004 * pow(2.0, 0.4 * (round % 20));
        double per_depth = (double)STP_LEVEL_SLOPE * (round % 2 == 0 ? 1.0 : 0.3);
        stp_vec3d eye = {4.0 * unit(1, (uint64_t)round), 1.5 + 8.0 * unit(2, (uint64_t)round), 3.0};
        bool drawn[2 * SAMPLES];
        uint32_t count = 0;
        for (uint32_t i = 0; i < s.count; ++i) {
            stp_vec3d d = stp_subd(place_of(&s, i), eye);
            double at = by_depth ? per_depth * sqrt(d.x * d.x + d.y * d.y + d.z * d.z) : level;
            stp_vec3 sight = {(float)d.x, (float)d.y, (float)d.z};
            drawn[i] = is_drawn(&s, i, at, by_depth && s.errors != NULL ? &sight : NULL);
            count += drawn[i];
        }
        CHECK(count > 0 && (by_depth || s.errors != NULL || count <= before));
        before = by_depth ? before : count;
        for (uint32_t k = 0; k < SAMPLES; k += 7) {
            bool covered = false;
            for (uint32_t i = 0; i < s.count && !covered; ++i) {
                double reach = (double)s.step * (double)stp_shape_radius(s.shapes[i] & 0xFFFu);
                stp_vec3d d = stp_subd(place_of(&from.set, k), place_of(&s, i));
                double square = d.x * d.x + d.y * d.y + d.z * d.z;
                // disks enclose their samples seen along the normal: across, not along it
                covered = drawn[i] && square <= 1.5 * reach * reach + 1e-6;
            }
            CHECK(covered);
        }
    }
    CHECK(before < SAMPLES / 20);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}

void test_spt_sets_cover_at_every_level(test_state* test)
{
    check_cover(test, STP_TREE_GEOMETRIC);
}

void test_spt_split_sets_cover_at_every_level(test_state* test)
{
    check_cover(test, STP_TREE_SPLIT);
}

void test_spt_sets_are_the_same_for_any_number_of_threads(test_state* test)
{
    static samples from;
    stp_splats made[2];
    stp_context* contexts[2] = {test_context(NULL, 1, NULL), test_context(NULL, 4, NULL)};
    CHECK(contexts[0] != NULL && contexts[1] != NULL);
    make_samples(&from);
    stp_spt_desc desc = {.tree = {STP_TREE_SPLIT, 255}};
    for (int i = 0; i < 2; ++i) {
        CHECK_EQUAL(STP_OK, stp_spt_make(contexts[i], &from.set, &desc, &made[i]));
    }
    CHECK_EQUAL(made[0].count, made[1].count);
    CHECK(memcmp(made[0].positions, made[1].positions, 6 * (size_t)made[0].count) == 0);
    CHECK(memcmp(made[0].ranges, made[1].ranges, 4 * (size_t)made[0].count) == 0);
    CHECK(memcmp(made[0].shapes, made[1].shapes, 4 * (size_t)made[0].count) == 0);
    CHECK(memcmp(made[0].errors, made[1].errors, 4 * (size_t)made[0].count) == 0);
    for (int i = 0; i < 2; ++i) {
        stp_splats_destroy(contexts[i], &made[i]);
        stp_context_destroy(contexts[i]);
    }
}

// One sample, coincident samples, and no samples.
void test_spt_sets_of_little(test_state* test)
{
    static samples from;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    make_samples(&from);
    stp_spt_desc desc = {.tree = stp_method_options_default().tree};
    static const uint32_t counts[] = {0, 1, 2, 9};
    for (int i = 0; i < 4; ++i) {
        stp_splats s;
        from.set.count = from.set.octave_ends[0] = from.set.table.count[0] = counts[i];
        from.set.octave_count = counts[i] > 0;
        for (uint32_t k = 0; k < 3 * counts[i]; ++k) {
            from.positions[k] = 77;
        }
        CHECK_EQUAL(STP_OK, stp_spt_make(context, &from.set, &desc, &s));
        CHECK(counts[i] == 0 ? s.count == 0 : s.count >= counts[i]);
        stp_splats_destroy(context, &s);
    }
    stp_context_destroy(context);
}

// No failed allocation leaks memory.
void test_spt_sets_survive_failing_allocator(test_state* test)
{
    static samples from;
    make_samples(&from);
    const stp_shading shadings[3] = {{.growth = 0.0f}, {.growth = 1.0f}, {.growth = -0.5f}};
    stp_spt_desc desc = {.tree = {STP_TREE_SPLIT, 255}, .shadings = shadings};
    bool made = false;
    int failures = 0;
    for (int n = 0; !made && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_splats s;
            made = stp_spt_make(context, &from.set, &desc, &s) == STP_OK;
            CHECK(made || log.errors == 1);
            failures += !made;
            stp_splats_destroy(context, &s);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 15);
}

// Points of a scan have radii of their own: leaves are drawn with these.
void test_spt_leaves_have_the_radii_of_their_points(test_state* test)
{
    static samples from;
    const stp_shading shadings[3] = {{.growth = 0.0f}, {.growth = 1.0f}, {.growth = -0.5f}};
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_samples(&from);
    from.set.candidate_radius = 0.05f;
    stp_spt_desc desc = {.tree = stp_method_options_default().tree, .shadings = shadings};
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_spt_make(context, &from.set, &desc, &s));
    float reach = stp_prefix_table_radius(&from.set.table, from.set.count);
    uint32_t leaves[3] = {0};
    for (uint32_t i = 0; i < s.count; ++i) {
        float radius = stp_shape_radius(s.shapes[i] & 0xFFFu) * s.step;
        float own = reach + 0.05f * (1.0f + shadings[s.materials[i]].growth);
        bool leaf = (s.ranges[i] & 0xFFFFu) == 0;
        leaves[s.materials[i]] += leaf ? 1 : 0;
        CHECK(!leaf || fabsf(radius - own) < 0.03f * own + s.step);
    }
    CHECK_EQUAL(SAMPLES, leaves[0] + leaves[1] + leaves[2]);
    CHECK(leaves[0] > 0 && leaves[1] > 0 && leaves[2] > 0);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}
