// SPDX-License-Identifier: MIT
// Points far from the rest of their set (src/scene/strays.c): found, grouped, and in nodes of their
// own after the partition.
#include "tests.h"

#include "base/math/rng.h"
#include "scene/partition.h"
#include "scene/strays.h"

#include <string.h>

enum { POINTS = 20000, STRAYS_MAX = 600 };

static float unit(uint64_t seed, uint64_t index)
{
    return (float)((double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53);
}

/// A survey 20 wide and 2 high, with strays up to 4,500,000 away among its points.
static void fill(float* positions, uint32_t count, uint32_t strays)
{
    for (uint32_t i = 0; i < count; ++i) {
        float* p = positions + 3 * (size_t)i;
        bool stray = strays > 0 && i % (count / strays) == 0 && i / (count / strays) < strays;
        float reach = stray ? 9e6f : 20.0f;
        p[0] = reach * (unit(1, i) - 0.5f);
        p[1] = stray ? 0.0f : 2.0f * unit(2, i);
        p[2] = reach * (unit(3, i) - 0.5f);
    }
}

static stp_point_set set_of(float* positions, uint32_t count)
{
    stp_point_set set = {.point_count = count, .positions = positions, .bounds = stp_box_empty()};
    for (uint32_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * (size_t)i;
        stp_box_add(&set.bounds, (stp_vec3){p[0], p[1], p[2]});
    }
    return set;
}

void test_strays_are_found(test_state* test)
{
    static float positions[3 * POINTS];
    static const uint32_t counts[] = {0, 1, 10, STRAYS_MAX};
    for (size_t i = 0; i < 4; ++i) {
        fill(positions, POINTS, counts[i]);
        stp_point_set set = set_of(positions, POINTS);
        stp_strays strays = stp_strays_find(&set);
        CHECK_EQUAL(counts[i], strays.count);
        CHECK(counts[i] == 0 || (strays.distance > 1e5 && strays.distance < 7e6));
        CHECK(counts[i] == 0 || (strays.width > 15.0 && strays.width <= 20.0));
    }
    fill(positions, POINTS, 0); // three of a hundred at one place, as points that a scanner missed
    for (uint32_t i = 0; i < POINTS; i += 33) {
        positions[3 * i] = positions[3 * i + 1] = positions[3 * i + 2] = 4e6f;
    }
    stp_point_set missed = set_of(positions, POINTS);
    CHECK_EQUAL((POINTS + 32) / 33, stp_strays_find(&missed).count);
    fill(positions, POINTS, POINTS / 20); // as many belong to the content
    stp_point_set many = set_of(positions, POINTS);
    CHECK_EQUAL(0, stp_strays_find(&many).count);
    // a road, a wall, and a scan whose density falls with the distance have none
    for (int kind = 0; kind < 3; ++kind) {
        for (uint32_t i = 0; i < POINTS; ++i) {
            float* p = positions + 3 * (size_t)i;
            float r = 1.0f / (0.02f + unit(4, i));
            p[0] = kind == 0 ? 10000.0f * unit(1, i) : kind == 1 ? 0.0f : r * (unit(1, i) - 0.5f);
            p[1] = kind == 2 ? 0.0f : unit(2, i);
            p[2] = kind == 2 ? r * (unit(3, i) - 0.5f) : 30.0f * unit(3, i);
        }
        stp_point_set set = set_of(positions, POINTS);
        CHECK_EQUAL(0, stp_strays_find(&set).count);
    }
    // one of few points, and points of which most coincide
    for (uint32_t count = 1; count < 40; ++count) {
        memset(positions, 0, 3 * (size_t)count * sizeof(float));
        positions[0] = 500.0f;
        stp_point_set set = set_of(positions, count);
        CHECK_EQUAL(0, stp_strays_find(&set).count);
        for (uint32_t i = 1; i < count; ++i) {
            positions[3 * i] = (float)i / (float)count;
        }
        set = set_of(positions, count);
        CHECK_EQUAL(count < 8 ? 0 : 1, stp_strays_find(&set).count);
    }
}

void test_strays_are_grouped_by_distance(test_state* test)
{
    static float positions[3 * POINTS];
    static stp_place places[STRAYS_MAX];
    static uint32_t ends[STRAYS_MAX];
    stp_context* context = test_context(NULL, 1, NULL);
    fill(positions, POINTS, STRAYS_MAX);
    stp_point_set set = set_of(positions, POINTS);
    stp_strays strays = stp_strays_find(&set);
    CHECK_EQUAL(STRAYS_MAX, strays.count);
    uint32_t found = 0, groups = 0;
    for (uint32_t i = 0; i < POINTS; ++i) {
        if (stp_is_stray(&strays, positions + 3 * (size_t)i)) {
            places[found] = (stp_place){.index = i};
            memcpy(places[found++].at, positions + 3 * (size_t)i, 3 * sizeof(float));
        }
    }
    CHECK_EQUAL(STRAYS_MAX, found);
    memcpy(places[1].at, places[0].at, sizeof(places[1].at)); // two in one place
    places[1].at[0] += 1.0f;
    CHECK_EQUAL(STP_OK, stp_strays_group(context, &strays, places, ends, &groups));
    CHECK_EQUAL(STRAYS_MAX - 1, groups);
    CHECK_EQUAL(STRAYS_MAX, ends[groups - 1]);
    uint64_t sum = 0;
    for (uint32_t g = 0, first = 0; g < groups; first = ends[g++]) {
        CHECK(ends[g] > first);
        for (uint32_t i = first; i < ends[g]; ++i) {
            sum += places[i].index;
            for (int k = 0; k < 3; ++k) {
                CHECK(fabsf(places[i].at[k] - places[first].at[k]) <= (float)strays.width);
            }
        }
    }
    uint64_t all = 0;
    for (uint32_t i = 0; i < STRAYS_MAX; ++i) {
        all += (uint64_t)i * (POINTS / STRAYS_MAX);
    }
    CHECK_EQUAL(all, sum); // each once
    stp_context_destroy(context);
}

/// Makes and partitions a scene of one cloud; `leaf` limits pieces, 0: the default.
static stp_scene* partitioned(stp_context* context, uint32_t strays, uint32_t leaf)
{
    stp_scene* scene = NULL;
    float* positions = STP_NEW_ARRAY(context, float, 3 * POINTS);
    uint32_t index;
    if (positions == NULL || stp_scene_create(context, &scene) != STP_OK) {
        return NULL;
    }
    fill(positions, POINTS, strays);
    stp_point_set set = {.point_count = POINTS, .positions = positions};
    stp_object object = {.parent = STP_NONE, .transform = stp_affine_identity()};
    scene->unit_metres = 1.0;
    stp_partition_desc desc = {.leaf_points = leaf};
    bool made = stp_scene_add_point_set(scene, &set, &index) == STP_OK &&
                stp_scene_add_object(scene, &object, NULL) == STP_OK &&
                stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}) == STP_OK &&
                stp_scene_finish(scene) == STP_OK && stp_scene_partition(scene, &desc) == STP_OK;
    if (!made) {
        stp_scene_destroy(scene);
        return NULL;
    }
    return scene;
}

void test_strays_get_nodes_of_their_own(test_state* test)
{
    static const uint32_t strays[] = {0, 1, 10, STRAYS_MAX}, leaves[] = {0, 3000};
    for (size_t i = 0; i < 8; ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        stp_scene* scene = partitioned(context, strays[i / 2], leaves[i % 2]);
        CHECK(scene != NULL);
        uint64_t points = 0, far = 0;
        for (size_t k = 0; k < scene->point_set_count; ++k) {
            const stp_point_set* set = &scene->point_sets[k];
            float side =
                fmaxf(set->bounds.max.x - set->bounds.min.x, set->bounds.max.z - set->bounds.min.z);
            CHECK(side <= 20.0f);
            points += set->point_count;
            far += set->point_count == 1 ? 1 : 0;
        }
        CHECK_EQUAL(POINTS, points);
        CHECK_EQUAL(strays[i / 2], far);
        CHECK_EQUAL(POINTS, scene->nodes[scene->root].point_count);
        CHECK((strstr(log.warning, "km from the rest") != NULL) == (strays[i / 2] > 0));
        CHECK(strays[i / 2] != 10 || strncmp(log.warning, "10 points lie up to ", 20) == 0);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
