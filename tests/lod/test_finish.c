// SPDX-License-Identifier: MIT
#include "candidate_helpers.h"
#include "tests.h"

#include "base/math/color.h"
#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "lod/blue/blue.h"

static uint32_t paint_grey(double x, double y, void* user)
{
    (void)x, (void)y, (void)user;
    return 0x336699ff;
}

static uint32_t paint_wire(double x, double y, void* user)
{
    double half_width = *(const double*)user;
    return fabs(x - 0.3 * y) < half_width ? 0xffffffff : 0;
}

static uint32_t paint_stripes(double x, double y, void* user)
{
    (void)y, (void)user;
    return fmod(x + 100.0, 0.04) < 0.02 ? 0xffffffff : 0x000000ff;
}

static uint32_t paint_halves(double x, double y, void* user)
{
    (void)y, (void)user;
    return x < 0.0 ? 0xff0000ff : 0x0000ffff;
}

static uint32_t paint_pane(double x, double y, void* user)
{
    (void)x, (void)y, (void)user;
    return 0x80c0ff40; // a quarter opaque
}

static int count_holes(const stp_splats* s, uint32_t octave)
{
    int count = 0;
    size_t start = octave_start(s, octave);
    for (uint32_t i = 0; i < s->octave_ends[octave]; ++i) {
        count += !is_without_holes(s->coverages[start + i]);
    }
    return count;
}

// Radius to which an octave's prefix covers.
static float octave_radius(const maker* m, const stp_splats* s, uint32_t octave)
{
    uint32_t end = s->octave_ends[octave];
    return end < m->count ? m->radii[end] : m->final_radius;
}

void test_solid_plates_are_fully_covered(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    maker* m = maker_create(0.014);
    maker_add_plane(m, 1.0, paint_grey, NULL);
    CHECK(context != NULL && m->candidates.count > 20000 && m->candidates.count < MAKER_LIMIT);
    stp_splats s;
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 17, &s));
    CHECK(s.octave_count >= 5);
    for (uint32_t octave = 0; octave < s.octave_count;
         ++octave) { // inside and at the border, at any distance
        CHECK(octave_radius(m, &s, octave) > 0.4f || count_holes(&s, octave) == 0);
    }
    size_t entries = octave_start(&s, s.octave_count);
    for (size_t i = 0; i < entries; ++i) { // an average of one colour is that colour
        CHECK_EQUAL(0x33, s.colors[3 * i]);
        CHECK_EQUAL(0x66, s.colors[3 * i + 1]);
        CHECK_EQUAL(0x99, s.colors[3 * i + 2]);
    }
    CHECK((double)entries < s.count * 1.6 + 10);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

// Expected picture: each pixel is covered with the probability that one of its disks is drawn.
static double drawn_area(const maker* m, const stp_splats* s, uint32_t octave, float radius)
{
    enum { SIZE = 256 };
    static float clear[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; ++i) {
        clear[i] = 1.0f;
    }
    float extent = 1.5f, pixel = 2.0f * extent / SIZE;
    size_t start = octave_start(s, octave);
    for (uint32_t k = 0; k < s->octave_ends[octave]; ++k) {
        const float* p = m->candidates.positions + 3 * (size_t)m->order[k];
        for (int i = 0; i < SIZE; ++i) {
            float dy = ((float)i + 0.5f) * pixel - extent - p[1];
            for (int j = 0; dy * dy < radius * radius && j < SIZE; ++j) {
                float dx = ((float)j + 0.5f) * pixel - extent - p[0];
                if (dx * dx + dy * dy < radius * radius) {
                    stp_vec3 offset = {dx / radius, dy / radius, 0.0f};
                    clear[i * SIZE + j] *= 1.0f - (float)drawn_chance(s, start + k, k, offset);
                }
            }
        }
    }
    double area = 0.0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        area += (double)((1.0f - clear[i]) * pixel * pixel);
    }
    return area;
}

void test_wires_keep_their_projected_area(test_state* test)
{
    static const double half_widths[] = {0.005, 0.01, 0.02};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int i = 0; i < 3; ++i) {
        double half_width = half_widths[i];
        maker* m = maker_create(0.008);
        maker_add_plane(m, 1.0, paint_wire, &half_width);
        stp_splats s;
        CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 17, &s));
        double truth = 2.0 * 2.0 * half_width;
        for (uint32_t octave = 0; octave + 1 < s.octave_count; ++octave) {
            float radius = m->radii[s.octave_ends[octave]] + s.candidate_radius;
            double area = drawn_area(m, &s, octave, radius);
            double fat = s.octave_ends[octave] * 3.14 * (double)(radius * radius);
            if (getenv("STP_TEST_PRINT") != NULL) {
                printf("width %.3f octave %u: %u surfels, radius %.3f, drawn %.4f of %.4f (disks "
                       "%.3f), %d\n",
                       2 * half_width, octave, s.octave_ends[octave], (double)radius, area, truth,
                       fat, s.coverages[octave_start(&s, octave)]);
            }
            if ((double)radius > 8.0 * half_width && s.octave_ends[octave] > 4) {
                CHECK(area < 3.5 * truth && area > 0.4 * truth);
                CHECK(area < 0.2 * fat); // expected result of drawing the disks
            }
        }
        stp_splats_destroy(context, &s);
        maker_destroy(m);
    }
    stp_context_destroy(context);
}

void test_coarse_colours_are_averages_of_light(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.01);
    maker_add_plane(m, 1.0, paint_stripes, NULL);
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 17, &s));
    // stripes are two pixels wide: from the middle octaves on every surfel sees many, half of the
    // light
    uint8_t half = stp_linear_to_srgb8(0.5f);
    for (uint32_t octave = 0; octave + 3 < s.octave_count; ++octave) {
        size_t start = octave_start(&s, octave);
        for (uint32_t i = 0; i < s.octave_ends[octave]; ++i) {
            CHECK(abs((int)s.colors[3 * (start + i)] - (int)half) < 40);
        }
    }
    CHECK(abs((int)s.colors[0] - (int)half) < 6);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_colours_stay_on_their_patch(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.015);
    maker_add_plane(m, 1.0, paint_halves, NULL);
    // the same plate seen from below is green: sides must not mix
    uint32_t top = m->candidates.count;
    for (uint32_t i = 0; i < top; ++i) {
        const float* p = m->candidates.positions + 3 * (size_t)i;
        maker_add(m, (stp_vec3){p[0], p[1], -0.001f}, (stp_vec3){0, 0, -1}, 0x00ff00ff);
    }
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 17, &s));
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        size_t start = octave_start(&s, octave);
        for (uint32_t i = 0; i < s.octave_ends[octave]; ++i) {
            const uint8_t* c = s.colors + 3 * (start + i);
            float x = m->candidates.positions[3 * m->order[i]];
            if (m->order[i] >= top) {
                CHECK(c[0] == 0 && c[1] == 255 && c[2] == 0);
            } else {
                CHECK_EQUAL(0, c[1]);
                CHECK(octave + 2 < s.octave_count || x > -0.15f || (c[0] == 255 && c[2] == 0));
                CHECK(octave + 2 < s.octave_count || x < 0.15f || (c[0] == 0 && c[2] == 255));
            }
        }
    }
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_clear_panes_let_light_through(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.015);
    maker_add_plane(m, 1.0, paint_pane, NULL);
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 17, &s));
    int expected = (int)(255.0 * (1.0 - sqrt(1.0 - 64.0 / 255.0)) + 0.5);
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        size_t start = octave_start(&s, octave);
        for (size_t i = start; i < start + s.octave_ends[octave]; ++i) {
            int share = stp_coverage_share(s.coverages[i]);
            CHECK(octave_radius(m, &s, octave) > 0.4f || abs(share - expected) <= expected / 12);
            CHECK(octave_radius(m, &s, octave) > 0.4f || !is_without_holes(s.coverages[i]));
            CHECK_EQUAL(0x80, s.colors[3 * i]);
        }
    }
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

static void add_sphere(maker* m, uint32_t count, stp_vec3 centre)
{
    for (uint32_t i = 0; i < count; ++i) { // a spiral: even over the sphere
        double z = 1.0 - (2.0 * i + 1.0) / count, r = sqrt(1.0 - z * z),
               turn = 2.39996322972865332 * i;
        stp_vec3 n = {(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z};
        maker_add(m, stp_add(centre, n), n, 0x808080ff);
    }
}

void test_spheres_are_solid_and_face_outwards(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    enum { COUNT = 30000 };
    maker* m = maker_create(
        sqrt(2.0 * 4.0 * 3.14159 / COUNT)); // two candidates per square pixel, as from eight views
    add_sphere(m, COUNT, (stp_vec3){0, 0, 0});
    maker_order(m, 2000, 10.0f);
    m->candidates.origin = (stp_vec3d){400000.0, -3.0, 7e6}; // far out: precision must not suffer
    stp_finish_input input = maker_input(m);
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, stp_finish_surfels(context, &input, &s));
    CHECK_EQUAL(2000, s.count);
    for (uint32_t octave = s.octave_count; octave > 0 && s.octave_ends[octave - 1] > 60; --octave) {
        CHECK_EQUAL(0, count_holes(&s, octave - 1));
    }
    for (uint32_t i = 0; i < s.count; ++i) {
        const float* p = m->candidates.positions + 3 * (size_t)m->order[i];
        const uint16_t* q = s.positions + 3 * (size_t)i;
        stp_vec3d got = {(double)s.origin.x + (double)s.step * q[0] - 400000.0,
                         (double)s.origin.y + (double)s.step * q[1] + 3.0,
                         (double)s.origin.z + (double)s.step * q[2] - 7e6};
        CHECK(fabs(got.x - (double)p[0]) <= 0.5001 * (double)s.step);
        CHECK(fabs(got.y - (double)p[1]) <= 0.5001 * (double)s.step);
        CHECK(fabs(got.z - (double)p[2]) <= 0.5001 * (double)s.step);
        stp_vec3 n = stp_octahedral_decode(s.normals[2 * i], s.normals[2 * i + 1]);
        CHECK(stp_dot(n, (stp_vec3){p[0], p[1], p[2]}) > 0.9998f);
    }
    CHECK(s.step < 0.001f);
    CHECK(s.paper_count == 1000 && s.paper_radius > 0.05f && s.paper_radius < 0.2f);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

// The guarantee of the prefix table, with positions as stored: the renderer
// relies on it.
void test_prefixes_cover_what_the_table_promises(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.02);
    add_sphere(m, 6000, (stp_vec3){0, 0, 0});
    add_sphere(m, 6000, (stp_vec3){1.5f, 0.2f, 0});
    maker_order(m, 700, 0.0f);
    stp_finish_input input = maker_input(m);
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, stp_finish_surfels(context, &input, &s));
    CHECK(s.table.size >= 2 && s.table.count[s.table.size - 1] == s.count);
    float* nearest = malloc(m->candidates.count * sizeof(float));
    for (uint32_t i = 0; i < m->candidates.count; ++i) {
        nearest[i] = INFINITY;
    }
    uint32_t done = 0;
    for (uint32_t at = 0; at < s.table.size; ++at) {
        float farthest = 0.0f;
        for (uint32_t i = 0; i < m->candidates.count; ++i) {
            const float* p = m->candidates.positions + 3 * (size_t)i;
            for (uint32_t k = done; k < s.table.count[at]; ++k) {
                const uint16_t* q = s.positions + 3 * (size_t)k;
                float x = s.origin.x + s.step * (float)q[0] - p[0];
                float y = s.origin.y + s.step * (float)q[1] - p[1];
                float z = s.origin.z + s.step * (float)q[2] - p[2];
                nearest[i] = stp_min(nearest[i], sqrtf(x * x + y * y + z * z));
            }
            farthest = stp_max(farthest, nearest[i]);
        }
        done = s.table.count[at];
        CHECK(farthest <= s.table.radius[at]);
        CHECK(at == 0 || s.table.radius[at] <= s.table.radius[at - 1]);
    }
    free(nearest);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

static bool same_surfels(const stp_splats* a, const stp_splats* b)
{
    size_t entries = octave_start(a, a->octave_count);
    return a->count == b->count && a->octave_count == b->octave_count && a->step == b->step &&
           memcmp(&a->origin, &b->origin, sizeof(a->origin)) == 0 &&
           memcmp(a->octave_ends, b->octave_ends, sizeof(a->octave_ends)) == 0 &&
           memcmp(a->positions, b->positions, 6 * (size_t)a->count) == 0 &&
           memcmp(a->normals, b->normals, 2 * (size_t)a->count) == 0 &&
           memcmp(a->materials, b->materials, a->count) == 0 &&
           memcmp(a->colors, b->colors, 3 * entries) == 0 &&
           memcmp(a->coverages, b->coverages, entries) == 0 && a->paper_radius == b->paper_radius;
}

static maker* make_mixed(void)
{
    maker* m = maker_create(0.02);
    double half_width = 0.01;
    maker_add_plane(m, 1.0, paint_wire, &half_width);
    add_sphere(m, 4000, (stp_vec3){0, 0.5f, 0.5f});
    for (uint32_t i = 0; i < m->candidates.count; ++i) {
        m->candidates.colors[4 * (size_t)i] = (uint8_t)stp_rng_hash(4, i);
    }
    maker_order(m, 400, 1.0f);
    return m;
}

void test_finished_surfels_do_not_depend_on_threads(test_state* test)
{
    maker* m = make_mixed();
    stp_finish_input input = maker_input(m);
    stp_context* contexts[4];
    stp_splats s[4];
    for (uint32_t i = 0; i < 4; ++i) {
        contexts[i] = test_context(NULL, i + 1, NULL);
        CHECK(contexts[i] != NULL);
        CHECK_EQUAL(STP_OK, stp_finish_surfels(contexts[i], &input, &s[i]));
        CHECK(same_surfels(&s[0], &s[i]));
    }
    for (uint32_t i = 0; i < 4; ++i) {
        stp_splats_destroy(contexts[i], &s[i]);
        stp_context_destroy(contexts[i]);
    }
    maker_destroy(m);
}

void test_finishing_survives_failing_allocator(test_state* test)
{
    maker* m = make_mixed();
    stp_finish_input input = maker_input(m);
    bool made = false;
    int failures = 0;
    for (int n = 0; !made && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_splats s;
            stp_result result = stp_finish_surfels(context, &input, &s);
            made = result == STP_OK;
            failures += !made;
            CHECK(made ||
                  (result == STP_ERROR_OUT_OF_MEMORY && s.positions == NULL && s.count == 0));
            CHECK_EQUAL(!made, log.errors);
            stp_splats_destroy(context, &s);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 15);
    maker_destroy(m);
}

void test_tiny_sets_can_be_finished(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (uint32_t count = 1; count <= 5; ++count) {
        maker* m = maker_create(count == 3 ? 0.0 : 0.1);
        for (uint32_t i = 0; i < count; ++i) {
            maker_add(m, (stp_vec3){(float)i, 0, 0}, (stp_vec3){0, 0, 1}, 0x010203ff);
        }
        maker_order(m, count, 1.0f);
        CHECK_EQUAL(count, m->count);
        stp_finish_input input = maker_input(m);
        stp_splats s;
        CHECK_EQUAL(STP_OK, stp_finish_surfels(context, &input, &s));
        CHECK_EQUAL(count, s.count);
        CHECK(s.octave_count >= 1 && s.octave_ends[s.octave_count - 1] == count);
        size_t entries = octave_start(&s, s.octave_count);
        for (size_t i = 0; i < entries; ++i) {
            CHECK(s.colors[3 * i] == 1 && s.colors[3 * i + 1] == 2 && s.colors[3 * i + 2] == 3);
            CHECK(stp_coverage_area(s.coverages[i]) > 0.0f);
        }
        stp_splats_destroy(context, &s);
        maker_destroy(m);
    }
    stp_context_destroy(context);
}
