// SPDX-License-Identifier: MIT
#include "candidate_helpers.h"
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "lod/blue/blue.h"
#include "lod/cloud_candidates.h"
#include "lod/set_columns.h"
#include "scene/scene.h"

#include <string.h>

void test_estimated_normals_of_a_sphere(test_state* test)
{
    enum { COUNT = 4000 };
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.06);
    CHECK(context != NULL);
    for (int i = 0; i < COUNT; ++i) {
        double z = 1.0 - (2.0 * i + 1.0) / COUNT, r = sqrt(1.0 - z * z),
               turn = 2.39996322972865332 * i;
        stp_vec3 n = {(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z};
        maker_add(m, n, (stp_vec3){0, 1, 0}, 0x808080ff);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.15f));
    for (int i = 0; i < COUNT; ++i) {
        const float* p = m->candidates.positions + 3 * (size_t)i;
        const float* n = m->candidates.normals + 3 * (size_t)i;
        CHECK(fabsf(p[0] * n[0] + p[1] * n[1] + p[2] * n[2]) > 0.99f);
        CHECK(n[1] >= 0.0f);
    }
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_normals_of_lonely_points_face_up(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.1);
    CHECK(context != NULL);
    for (int i = 0; i < 10; ++i) { // the last five coincide: they define no plane
        maker_add(m, (stp_vec3){i < 5 ? (float)i : 9.0f, 0, 0}, (stp_vec3){1, 0, 0}, 0x808080ff);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.1f));
    for (int i = 0; i < 10; ++i) {
        CHECK(m->candidates.normals[3 * i + 1] == 1.0f);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.0f));
    maker_destroy(m);
    stp_context_destroy(context);
}

// A slope with a sparse and a dense half: if fewer than four neighbours lie within the radius, the
// search widens.
void test_normals_of_sparse_points_are_those_of_their_surroundings(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.1);
    CHECK(context != NULL);
    for (int i = 0; i < 400; ++i) { // spaced 0.1, then 1
        float step = i < 200 ? 0.1f : 1.0f, from = i < 200 ? -2.0f : 0.0f;
        float along = from + step * (float)(i % 20), z = step * (float)(i % 200 / 20);
        maker_add(m, (stp_vec3){0.8f * along, 0.6f * along, z}, (stp_vec3){1, 0, 0}, 0x808080ff);
    }
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &m->candidates, 0.3f));
    for (int i = 0; i < 400; ++i) {
        const float* n = m->candidates.normals + 3 * (size_t)i;
        CHECK(0.8f * n[1] - 0.6f * n[0] > 0.999f);
    }
    maker_destroy(m);
    stp_context_destroy(context);
}

enum { SCANNED = 300 };

// A point set along x, with intensities that identify points, and optional classes.
static bool add_scan(stp_scene* scene, float y, bool classed)
{
    stp_context* context = scene->context;
    stp_point_set set = {.point_count = SCANNED,
                         .positions = STP_NEW_ARRAY(context, float, 3 * SCANNED)};
    uint16_t* intensity = STP_NEW_ARRAY(context, uint16_t, SCANNED);
    uint8_t* class = classed ? STP_NEW_ARRAY(context, uint8_t, SCANNED) : NULL;
    set.attributes[STP_ATTRIBUTE_INTENSITY] = intensity;
    set.attributes[STP_ATTRIBUTE_CLASS] = class;
    bool made = set.positions != NULL && intensity != NULL && (class != NULL || !classed);
    for (size_t i = 0; made && i < SCANNED; ++i) {
        const float place[3] = {(float)i, y, 0.0f};
        memcpy(set.positions + 3 * i, place, sizeof(place));
        intensity[i] = (uint16_t)(7 * i);
        if (classed) {
            class[i] = 6;
        }
    }
    if (!made) {
        stp_free(context, set.positions);
        stp_free(context, intensity);
        stp_free(context, class);
        return false;
    }
    uint32_t index, object;
    return stp_scene_add_point_set(scene, &set, &index) == STP_OK &&
           stp_scene_add_object(
               scene, &(stp_object){.parent = STP_NONE, .transform = stp_affine_identity()},
               &object) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}) == STP_OK;
}

// Whether each surfel has the intensity and class of its point.
static bool has_own_attributes(const stp_splats* s)
{
    const uint16_t* intensity = s->attributes[STP_ATTRIBUTE_INTENSITY];
    const uint8_t* class = s->attributes[STP_ATTRIBUTE_CLASS];
    bool same = intensity != NULL && class != NULL && s->attributes[STP_ATTRIBUTE_TIME] == NULL;
    for (uint32_t i = 0; same && i < s->count; ++i) {
        float x = s->origin.x + s->step * (float)s->positions[3 * (size_t)i];
        float y = s->origin.y + s->step * (float)s->positions[3 * (size_t)i + 1];
        same = fabsf(7.0f * x - (float)intensity[i]) < 3.0f && class[i] == (y > 5.0f ? 6 : 0);
    }
    return same && s->count == 2 * SCANNED;
}

void test_surfels_of_clouds_have_the_attributes_of_their_points(test_state* test)
{
    static const uint8_t shadings[4] = {0};
    for (int n = 0;; ++n) { // fail the n-th allocation, until one run gets through
        CHECK(n < 4000);
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_scene* scene = NULL;
        stp_splats set = {0};
        stp_blue_desc desc = {.splat_count = 0};
        bool good = stp_scene_create(context, &scene) == STP_OK && add_scan(scene, 0.0f, false) &&
                    add_scan(scene, 10.0f, true) && stp_scene_finish(scene) == STP_OK &&
                    stp_blue_make(scene, scene->root, shadings, &desc, &set, NULL) == STP_OK;
        bool right = !good || has_own_attributes(&set);
        stp_splats_destroy(context, &set);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(right);
        if (good && heap.count <= n) {
            break;
        }
    }
}

// If a twelfth of the points, eight times as far apart, has 0.85 of the area, disks are larger
// than the dense part alone needs: twice as large in the exact order.
void test_disks_grow_where_parts_are_sparse(test_state* test)
{
    static const stp_order_kind kinds[] = {STP_ORDER_EXACT, STP_ORDER_RANDOM};
    for (int round = 0; round < 4; ++round) {
        bool even = round / 2 == 1;
        uint32_t dense = 100 * 100, sparse = even ? 0 : 30 * 30;
        stp_context* context = test_context(NULL, 2, NULL);
        stp_scene* scene = NULL;
        uint32_t index, object;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        stp_point_set set = {.point_count = dense + sparse,
                             .positions =
                                 STP_NEW_ARRAY(context, float, 3 * (size_t)(dense + sparse))};
        CHECK(set.positions != NULL);
        for (uint32_t i = 0; i < dense + sparse; ++i) { // spaced 0.125, and 1 beside
            bool near = i < dense;
            uint32_t k = near ? i : i - dense, side = near ? 100 : 30;
            float step = near ? 0.125f : 1.0f;
            set.positions[3 * i] = (near ? 0.0f : 13.0f) + step * (float)(k % side);
            set.positions[3 * i + 1] = 0.0f;
            set.positions[3 * i + 2] = step * (float)(k / side);
        }
        CHECK_EQUAL(STP_OK, stp_scene_add_point_set(scene, &set, &index));
        CHECK_EQUAL(STP_OK, stp_scene_add_object(scene,
                                                 &(stp_object){.parent = STP_NONE,
                                                               .transform = stp_affine_identity()},
                                                 &object));
        CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_blue_desc desc = {.order = {.kind = kinds[round % 2], .seed = 3}};
        uint8_t shading[4] = {0};
        stp_splats s;
        CHECK_EQUAL(STP_OK, stp_blue_make(scene, scene->root, shading, &desc, &s, NULL));
        CHECK_EQUAL(dense + sparse, s.count);
        float minimum = even ? 0.06f : round == 0 ? 0.16f : 0.115f, maximum = even ? 0.12f : 0.5f;
        CHECK(s.candidate_radius > minimum && s.candidate_radius < maximum);
        stp_splats_destroy(context, &s);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

enum { WALL_SIDE = 60, WALL_POINTS = WALL_SIDE * WALL_SIDE };

/// A wall of points, which noise keeps off its plane: estimated normals face either way.
static stp_scene* make_wall(stp_context* context, const uint8_t* greys)
{
    stp_scene* scene = NULL;
    uint32_t index, object;
    stp_point_set set = {.point_count = WALL_POINTS,
                         .positions = STP_NEW_ARRAY(context, float, 3 * WALL_POINTS),
                         .colors = STP_NEW_ARRAY(context, uint8_t, 4 * WALL_POINTS)};
    bool made = set.positions != NULL && set.colors != NULL;
    for (uint32_t i = 0; made && i < WALL_POINTS; ++i) {
        double noise = (double)(stp_rng_hash(5, i) >> 11) * 0x1p-53;
        set.positions[3 * i] = (float)(i % WALL_SIDE);
        set.positions[3 * i + 1] = (float)(i / WALL_SIDE);
        set.positions[3 * i + 2] = (float)(0.1 * noise);
        memset(set.colors + 4 * i, greys[i], 3);
        set.colors[4 * i + 3] = 255;
    }
    made = made && stp_scene_create(context, &scene) == STP_OK &&
           stp_scene_add_point_set(scene, &set, &index) == STP_OK &&
           stp_scene_add_object(
               scene, &(stp_object){.parent = STP_NONE, .transform = stp_affine_identity()},
               &object) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}) == STP_OK &&
           stp_scene_finish(scene) == STP_OK;
    return made ? scene : NULL;
}

static stp_result make_wall_set(stp_context* context, const uint8_t* greys, stp_splats* set)
{
    static const uint8_t shadings[4] = {0};
    const stp_blue_desc desc = {.order = {.seed = 3}};
    stp_scene* scene = make_wall(context, greys);
    stp_result result = scene != NULL
                            ? stp_blue_make(scene, scene->root, shadings, &desc, set, NULL)
                            : STP_ERROR_OUT_OF_MEMORY;
    stp_scene_destroy(scene);
    return result;
}

// The side that a normal was estimated to face means nothing: colours of both sides are averaged.
void test_colours_of_estimated_normals_are_those_of_both_sides(test_state* test)
{
    static uint8_t greys[WALL_POINTS];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_splats s;
    CHECK_EQUAL(STP_OK, make_wall_set(context, greys, &s));
    CHECK_EQUAL(WALL_POINTS, s.count);
    uint32_t front = 0;
    for (uint32_t i = 0; i < s.count; ++i) { // white where they face one way, else black
        stp_vec3 n = stp_octahedral_decode(s.normals[2 * i], s.normals[2 * i + 1]);
        double x = (double)(s.origin.x + s.step * (float)s.positions[3 * i]);
        double y = (double)(s.origin.y + s.step * (float)s.positions[3 * i + 1]);
        uint32_t point = (uint32_t)(nearbyint(y) * WALL_SIDE + nearbyint(x));
        CHECK(point < WALL_POINTS);
        greys[point] = n.z > 0.0f ? 255 : 0;
        front += n.z > 0.0f;
    }
    CHECK(front > WALL_POINTS / 4 && front < WALL_POINTS * 3 / 4);
    stp_splats_destroy(context, &s);
    CHECK_EQUAL(STP_OK, make_wall_set(context, greys, &s));
    uint32_t entry = 0, grey = 0;
    for (uint32_t k = 0; s.octave_ends[k] < 100; ++k) {
        for (uint32_t i = 0; i < s.octave_ends[k]; ++i, ++entry) {
            grey += s.colors[3 * entry] > 120 && s.colors[3 * entry] < 235;
        }
    }
    CHECK(entry > 50 && grey > entry * 9 / 10);
    stp_splats_destroy(context, &s);
    stp_context_destroy(context);
}
