// SPDX-License-Identifier: MIT
// Light normals of surfels: means of the surface that they stand for.
#include "candidate_helpers.h"
#include "tests.h"

#include "base/splats/light_normal.h"
#include "lod/set_columns.h"

#define FOLD 0.05 // width of a slope of the folded sheet

static uint32_t paint_white(double x, double y, void* user)
{
    (void)x, (void)y, (void)user;
    return 0xffffffff;
}

/// A sheet in the plane z = 0, whose normals lean by 40 degrees to the left or to the right.
static maker* make_folds(void)
{
    maker* m = maker_create(0.02);
    maker_add_plane(m, 1.0, paint_white, NULL);
    for (uint32_t i = 0; i < m->candidates.count; ++i) {
        double x = (double)m->candidates.positions[3 * (size_t)i] + 100.0;
        float lean = fmod(x, 2.0 * FOLD) < FOLD ? -0.64278761f : 0.64278761f;
        const float n[3] = {lean, 0.0f, 0.76604444f};
        memcpy(m->candidates.normals + 3 * (size_t)i, n, sizeof(n));
    }
    return m;
}

static void copy_normals(maker* m)
{
    size_t bytes = 3 * sizeof(float) * m->candidates.count;
    m->candidates.light_normals = malloc(bytes);
    memcpy(m->candidates.light_normals, m->candidates.normals, bytes);
}

static stp_vec3 light_of(const stp_splats* s, uint32_t octave, uint32_t surfel)
{
    stp_light_normals lights = stp_light_normals_of(s, octave);
    return stp_light_normal(&lights, s->normals + 2 * (size_t)surfel, surfel);
}

void test_smooth_surfaces_have_no_light_normals(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.02);
    maker_add_plane(m, 1.0, paint_white, NULL);
    stp_splats s;
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 12, &s));
    CHECK(s.octave_count > 3 && s.light_octaves == 0 && s.turns == NULL && s.spreads == NULL);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_light_normals_are_means_of_the_surface(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = make_folds();
    stp_splats s;
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 6, &s));
    uint32_t wide = 0;
    CHECK(stp_has_light_normals(&s, 0));
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        float radius = s.octave_ends[octave] < m->count ? m->radii[s.octave_ends[octave]] : 0.0f;
        for (uint32_t i = 0; i < s.octave_ends[octave]; ++i) {
            stp_vec3 light = light_of(&s, octave, i);
            float length = stp_length(light);
            CHECK(length > 0.6f && length <= 1.0f && fabsf(light.y) < 0.03f);
            if (radius > 8.0f * (float)FOLD) { // many folds: the mean is that of both slopes
                CHECK(fabsf(light.x) < 0.1f && fabsf(length - 0.766f) < 0.03f);
                wide += 1;
            }
        }
    }
    CHECK(wide > 15);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_light_normals_follow_those_of_candidates(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.02);
    maker_add_plane(m, 1.0, paint_white, NULL);
    copy_normals(m);
    for (uint32_t i = 0; i < m->candidates.count; ++i) { // as of a map, and of a set below
        const float light[3] = {0.0f, 0.36f, 0.48f};
        memcpy(m->candidates.light_normals + 3 * (size_t)i, light, sizeof(light));
    }
    stp_splats s;
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 12, &s));
    CHECK_EQUAL((1u << s.octave_count) - 1, s.light_octaves);
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        for (uint32_t i = 0; i < s.octave_ends[octave]; ++i) {
            stp_vec3 light = light_of(&s, octave, i);
            CHECK(s.normals[2 * i] == 0 && s.normals[2 * i + 1] == 0); // the disk's own: +z
            CHECK(fabsf(light.x) < 0.03f && fabsf(light.y - 0.36f) < 0.03f &&
                  fabsf(light.z - 0.48f) < 0.03f);
        }
    }
    stp_splats_destroy(context, &s);
    free(m->candidates.light_normals);
    maker_destroy(m);
    stp_context_destroy(context);
}

/// Where each candidate is a surfel, the finest octave has their own normals, and needs no entries.
void test_surfels_that_are_points_keep_their_normals(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    for (int lit = 0; lit < 2; ++lit) {
        maker* m = make_folds();
        if (lit != 0) {
            copy_normals(m);
        }
        stp_splats s;
        CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count, &s));
        CHECK(s.count == m->candidates.count && s.octave_count > 2);
        CHECK_EQUAL((1u << (s.octave_count - 1)) - 1, s.light_octaves);
        stp_finish_input input = maker_input(m);
        stp_splats_destroy(context, &s);
        input.two_sided = true; // signs are a guess: there is no mean
        CHECK_EQUAL(STP_OK, stp_finish_surfels(context, &input, &s));
        CHECK(s.light_octaves == 0 && s.turns == NULL);
        stp_splats_destroy(context, &s);
        free(m->candidates.light_normals);
        maker_destroy(m);
    }
    stp_context_destroy(context);
}

void test_light_normals_are_the_same_for_any_thread_count(test_state* test)
{
    maker* m = make_folds();
    copy_normals(m);
    stp_splats made[2];
    stp_context* contexts[2];
    for (uint32_t i = 0; i < 2; ++i) {
        contexts[i] = test_context(NULL, 1 + 3 * i, NULL);
        CHECK_EQUAL(STP_OK, maker_finish(m, contexts[i], m->candidates.count / 3, &made[i]));
    }
    size_t entries = (size_t)stp_light_normals_begin(&made[0], made[0].octave_count);
    CHECK_EQUAL(made[0].light_octaves, made[1].light_octaves);
    CHECK(entries > 100 && memcmp(made[0].turns, made[1].turns, 2 * entries) == 0);
    CHECK(memcmp(made[0].spreads, made[1].spreads, entries) == 0);
    for (uint32_t i = 0; i < 2; ++i) {
        stp_splats_destroy(contexts[i], &made[i]);
        stp_context_destroy(contexts[i]);
    }
    free(m->candidates.light_normals);
    maker_destroy(m);
}
