// SPDX-License-Identifier: MIT
// Splat sub-sampling (lab/decimate/subsample*): covers against brute force, counts, sides,
// colours, any points.
#include "tests.h"

#include "base/math/rng.h"
#include "lab/decimate/subsample_attempt.h"

#include <stdlib.h>
#include <string.h>

enum { POINTS = 3000, SETS = 400 };

static float positions[3 * POINTS], normals[3 * POINTS];
static uint8_t colors[3 * POINTS];

static double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

static void destroy(stp_context* context, stp_decimate_output* output)
{
    stp_free(context, output->ellipses);
    stp_free(context, output->colors);
    *output = (stp_decimate_output){0};
}

/// An ellipsoid with points along a spiral and normals that face out.
static stp_decimate_input make_ellipsoid(uint32_t count)
{
    const double axes[3] = {1.0, 0.5, 2.0};
    for (uint32_t i = 0; i < count; ++i) {
        double y = 1.0 - 2.0 * ((double)i + 0.5) / count, around = 2.399963229728653 * i;
        double across = sqrt(1.0 - y * y);
        const double at[3] = {across * cos(around), y, across * sin(around)};
        stp_vec3 n = stp_normalize((stp_vec3){(float)(at[0] / axes[0]), (float)(at[1] / axes[1]),
                                              (float)(at[2] / axes[2])});
        memcpy(normals + 3 * (size_t)i, &n, sizeof(n));
        for (uint32_t c = 0; c < 3; ++c) {
            positions[3 * i + c] = (float)(at[c] * axes[c]);
            colors[3 * i + c] = (uint8_t)(i * (c + 1));
        }
    }
    return (stp_decimate_input){
        .count = count, .positions = positions, .normals = normals, .colors = colors};
}

static stp_vec3 vector_at(const float* values, uint32_t i)
{
    return (stp_vec3){values[3 * (size_t)i], values[3 * (size_t)i + 1], values[3 * (size_t)i + 2]};
}

/// Distance of a point to the plane of a splat that covers it; infinite if it does not.
static float reach(const stp_ellipse* e, const stp_decimate_input* input, uint32_t point)
{
    stp_vec3 d = stp_sub(vector_at(input->positions, point), e->center);
    float length = stp_length(e->major);
    float u = stp_dot(d, e->major) / (length * length);
    float v = stp_dot(d, stp_cross(e->normal, e->major)) / (length * e->minor);
    bool away =
        input->normals != NULL && stp_dot(e->normal, vector_at(input->normals, point)) < 0.0f;
    return !away && u * u + v * v <= 1.001f ? fabsf(stp_dot(d, e->normal)) : HUGE_VALF;
}

/// Maximum distance of a point to the nearest splat that covers it.
static float measure(const stp_ellipse* ellipses, uint32_t count, const stp_decimate_input* input)
{
    float maximum = 0.0f;
    for (uint32_t i = 0; i < input->count; ++i) {
        const float* p = input->positions + 3 * (size_t)i;
        float minimum = HUGE_VALF;
        for (uint32_t e = 0; e < count; ++e) {
            const stp_vec3 *at = &ellipses[e].center, *n = &ellipses[e].normal;
            float away = (p[0] - at->x) * n->x + (p[1] - at->y) * n->y + (p[2] - at->z) * n->z;
            if (fabsf(away) <= 1.001f * minimum) {
                minimum = stp_min(minimum, reach(&ellipses[e], input, i));
            }
        }
        maximum = stp_max(maximum, minimum);
    }
    return maximum;
}

static bool is_sound(const stp_decimate_output* output)
{
    for (uint32_t i = 0; i < output->count; ++i) {
        const stp_ellipse* e = &output->ellipses[i];
        float length = stp_length(e->major);
        if (!stp_is_finite(e->center) || !(e->minor > 0.0f) || !(length < HUGE_VALF) ||
            e->minor > 1.0001f * length || fabsf(stp_length(e->normal) - 1.0f) > 1e-3f ||
            fabsf(stp_dot(e->normal, e->major)) > 1e-3f * length) {
            return false;
        }
    }
    return true;
}

// Every member of a candidate lies in its ellipse and slab, and faces its side; each point belongs
// to a candidate.
void test_subsample_candidates_stay_within_tolerance(test_state* test)
{
    stp_decimate_input input = make_ellipsoid(1500);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_subsample_unique unique;
    stp_subsample_field field;
    CHECK_EQUAL(STP_OK, stp_subsample_unique_make(context, &input, &unique));
    CHECK_EQUAL(input.count, unique.count);
    CHECK_EQUAL(STP_OK, stp_subsample_field_make(context, &unique, &field));
    for (int step = 0; step < 4; ++step) {
        static const float tolerances[] = {0.0f, 0.003f, 0.02f, 10.0f};
        stp_subsample_candidates c;
        static uint8_t seen[POINTS];
        memset(seen, 0, sizeof(seen));
        CHECK_EQUAL(STP_OK,
                    stp_subsample_grow(context, &field, (double)tolerances[step], 100, 200, &c));
        CHECK(c.count >= 100);
        for (uint32_t i = 0; i < c.count; ++i) {
            stp_ellipse e = stp_subsample_ellipse(&c.shapes[i]);
            CHECK(c.starts[i + 1] > c.starts[i] && c.starts[i + 1] - c.starts[i] <= 200);
            for (size_t m = c.starts[i]; m < c.starts[i + 1]; ++m) {
                CHECK(c.members[m] < input.count);
                CHECK(reach(&e, &input, c.members[m]) <= tolerances[step] * 1.0001f + 1e-6f);
                seen[c.members[m]] = 1;
            }
        }
        CHECK(memchr(seen, 0, input.count) == NULL);
        stp_subsample_candidates_destroy(context, &c);
    }
    stp_subsample_field_destroy(context, &field);
    stp_subsample_unique_destroy(context, &unique);
    stp_context_destroy(context);
}

/// Random sets of points; the last ones hold one point each, so that a cover exists.
static stp_cover_problem make_sets(uint64_t seed, uint32_t point_count)
{
    static size_t starts[SETS + POINTS + 1];
    static uint32_t members[SETS * 64 + POINTS], weights[POINTS];
    static float areas[SETS + POINTS];
    size_t count = 0;
    for (uint32_t s = 0; s < SETS; ++s) {
        uint32_t maximum = point_count < 120 ? point_count / 4 + 1 : 40;
        uint32_t size = 1 + stp_rng_below(seed, s, maximum),
                 first = stp_rng_below(seed + 1, s, 1 << 20);
        starts[s] = count;
        areas[s] = (float)size;
        for (uint32_t i = 0; i < size; ++i) {
            members[count++] = (first + 3 * i) % point_count;
        }
    }
    for (uint32_t i = 0; i < point_count; ++i) {
        starts[SETS + i] = count;
        areas[SETS + i] = 0.5f;
        members[count++] = i;
        weights[i] = 1 + stp_rng_below(seed + 2, i, 3);
    }
    starts[SETS + point_count] = count;
    return (stp_cover_problem){.point_count = point_count,
                               .set_count = SETS + point_count,
                               .weights = weights,
                               .starts = starts,
                               .members = members,
                               .areas = areas};
}

/// Lists the sets of a greedy choice, by trying all sets in each step.
static uint32_t cover_slowly(const stp_cover_problem* p, uint32_t* chosen)
{
    static uint8_t covered[POINTS];
    memset(covered, 0, sizeof(covered));
    for (uint32_t count = 0;; ++count) {
        uint64_t maximum = 0;
        for (uint32_t s = 0; s < p->set_count; ++s) {
            uint64_t gain = 0;
            for (size_t i = p->starts[s]; i < p->starts[s + 1]; ++i) {
                gain += covered[p->members[i]] == 0 ? p->weights[p->members[i]] : 0;
            }
            if (gain > maximum) {
                maximum = gain;
                chosen[count] = s;
            }
        }
        if (maximum == 0) {
            return count;
        }
        for (size_t i = p->starts[chosen[count]]; i < p->starts[chosen[count] + 1]; ++i) {
            covered[p->members[i]] = 1;
        }
    }
}

/// Whether the chosen sets cover all points, with correct depths and places.
static bool is_cover(const stp_cover_problem* p, const stp_cover* cover)
{
    static uint32_t depths[POINTS];
    uint32_t placed = 0;
    memset(depths, 0, sizeof(depths));
    for (uint32_t i = 0; i < cover->count; ++i) {
        uint32_t s = cover->chosen[i];
        if (cover->places[s] != i) {
            return false;
        }
        for (size_t m = p->starts[s]; m < p->starts[s + 1]; ++m) {
            depths[p->members[m]]++;
        }
    }
    for (uint32_t s = 0; s < p->set_count; ++s) {
        placed += cover->places[s] != UINT32_MAX ? 1 : 0;
    }
    for (uint32_t i = 0; i < p->point_count; ++i) {
        if (depths[i] == 0 || depths[i] != cover->depths[i]) {
            return false;
        }
    }
    return placed == cover->count;
}

static double sum_areas(const stp_cover_problem* p, const stp_cover* cover)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < cover->count; ++i) {
        sum += (double)p->areas[cover->chosen[i]];
    }
    return sum;
}

void test_subsample_covers_points_with_few_sets(test_state* test)
{
    static uint32_t slow[SETS + POINTS];
    uint32_t greedy = 0, relaxed = 0;
    for (uint64_t seed = 0; seed < 12; ++seed) {
        stp_context* context = test_context(NULL, 1 + (uint32_t)(seed % 3), NULL);
        stp_cover_problem p = make_sets(seed, seed == 0 ? 1 : 100 + 50 * (uint32_t)seed);
        stp_cover cover;
        CHECK_EQUAL(STP_OK, stp_cover_problem_index(context, &p));
        CHECK_EQUAL(STP_OK, stp_cover_greedily(context, &p, &cover));
        CHECK(is_cover(&p, &cover));
        CHECK_EQUAL(cover_slowly(&p, slow), cover.count);
        CHECK(memcmp(slow, cover.chosen, cover.count * sizeof(*slow)) == 0);
        greedy += cover.count;
        // stops at the given number
        uint32_t before = cover.count;
        CHECK_EQUAL(STP_OK, stp_cover_relax(context, &p, before, 20, &cover));
        CHECK_EQUAL(before, cover.count);
        CHECK_EQUAL(STP_OK, stp_cover_relax(context, &p, 0, 20, &cover));
        CHECK(is_cover(&p, &cover) && cover.count <= before);
        before = cover.count;
        relaxed += before;
        for (uint32_t i = 0; i < cover.count; ++i) {
            CHECK(!stp_cover_is_redundant(&p, &cover, cover.chosen[i]));
        }
        double area = sum_areas(&p, &cover);
        CHECK_EQUAL(STP_OK, stp_cover_tighten(context, &p, 3, &cover));
        CHECK(is_cover(&p, &cover) && cover.count == before && sum_areas(&p, &cover) <= area);
        stp_cover_destroy(context, &cover);
        stp_cover_problem_destroy(context, &p);
        stp_context_destroy(context);
    }
    CHECK(relaxed < greedy);
}

// The splats of a tolerance cover all points within it; relaxing needs fewer, and fitting makes
// them smaller.
void test_subsample_keeps_a_tolerance(test_state* test)
{
    static stp_ellipse ellipses[POINTS];
    static uint8_t mixed[3 * POINTS];
    stp_decimate_input input = make_ellipsoid(1500);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_subsample_unique unique;
    stp_subsample_field field;
    CHECK_EQUAL(STP_OK, stp_subsample_unique_make(context, &input, &unique));
    CHECK_EQUAL(input.count, unique.count);
    CHECK_EQUAL(STP_OK, stp_subsample_field_make(context, &unique, &field));
    for (float tolerance = 0.002f; tolerance < 0.1f; tolerance *= 3.0f) {
        stp_subsample_attempt a;
        CHECK_EQUAL(STP_OK,
                    stp_subsample_attempt_make(context, &field, (double)tolerance, 100, &a));
        uint32_t greedy = a.cover.count, count;
        CHECK_EQUAL(STP_OK, stp_subsample_attempt_relax(context, 0, &a));
        CHECK(a.cover.count < greedy && is_cover(&a.problem, &a.cover));
        double loose = 0.0, tight = 0.0;
        for (uint32_t i = 0; i < a.cover.count; ++i) {
            ellipses[i] = stp_subsample_ellipse(&a.candidates.shapes[a.cover.chosen[i]]);
            loose += (double)stp_ellipse_area(&ellipses[i]);
        }
        CHECK(measure(ellipses, a.cover.count, &input) <= 1.001f * tolerance);
        stp_subsample_choice choice = {&field, &a.candidates, &a.problem, &a.cover};
        CHECK_EQUAL(STP_OK, stp_subsample_fit(context, &choice, ellipses, mixed, &count));
        CHECK(count > 0 && count <= a.cover.count);
        CHECK(measure(ellipses, count, &input) <= 1.001f * tolerance);
        for (uint32_t i = 0; i < count; ++i) {
            tight += (double)stp_ellipse_area(&ellipses[i]);
        }
        CHECK(tight < loose);
        stp_subsample_attempt_destroy(context, &a);
    }
    stp_subsample_field_destroy(context, &field);
    stp_subsample_unique_destroy(context, &unique);
    stp_context_destroy(context);
}

// As many splats as requested, or at most 1 % fewer; more splats are closer to the
// surface.
void test_subsample_reaches_counts(test_state* test)
{
    static const uint32_t targets[] = {40, 200, 700, 1300, 2000};
    stp_decimate_input input = make_ellipsoid(1500);
    stp_context* context = test_context(NULL, 2, NULL);
    float last = HUGE_VALF;
    for (int t = 0; t < 5; ++t) {
        stp_decimate_output out;
        uint32_t target = targets[t] < input.count ? targets[t] : input.count;
        CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, targets[t], &out));
        CHECK(out.count <= target && 100 * out.count >= 99 * target - 100 && is_sound(&out));
        float maximum = measure(out.ellipses, out.count, &input);
        CHECK(maximum < last || maximum == 0.0f); // own disks pass through their points
        last = maximum;
        double area = 0.0;
        for (uint32_t i = 0; i < out.count; ++i) {
            area += (double)stp_ellipse_area(&out.ellipses[i]);
        }
        CHECK(area > 15.9 && area < 15.9 * (double)(t < 3 ? 3 : 9)); // the surface has 15.9
        destroy(context, &out);
    }
    stp_decimate_output out;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_decimate_by_subsample(context, &input, 0, &out));
    destroy(context, &out);
    stp_context_destroy(context);
}

// The same bytes for any number of threads.
void test_subsample_is_the_same_on_any_threads(test_state* test)
{
    stp_decimate_input input = make_ellipsoid(1000);
    stp_decimate_output first = {0};
    stp_context* keeper = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(keeper, &input, 60, &first));
    for (uint32_t threads = 2; threads < 4; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_decimate_output out;
        CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, 60, &out));
        CHECK_EQUAL(first.count, out.count);
        CHECK(memcmp(first.ellipses, out.ellipses, out.count * sizeof(*out.ellipses)) == 0);
        CHECK(memcmp(first.colors, out.colors, 3 * (size_t)out.count) == 0);
        destroy(context, &out);
        stp_context_destroy(context);
    }
    destroy(keeper, &first);
    stp_context_destroy(keeper);
}

// Two close sheets with opposite normals, red and blue: no splat mixes them. Without normals,
// splats represent both.
void test_subsample_keeps_sides_apart(test_state* test)
{
    enum { SIDE = 16 };
    for (uint32_t i = 0; i < 2 * SIDE * SIDE; ++i) {
        bool top = i < SIDE * SIDE;
        const float at[3] = {(float)(i % SIDE), top ? 0.01f : -0.01f, (float)(i / SIDE % SIDE)};
        const float n[3] = {0.0f, top ? 1.0f : -1.0f, 0.0f};
        const uint8_t color[3] = {top ? 200 : 0, 0, top ? 0 : 200};
        memcpy(positions + 3 * (size_t)i, at, sizeof(at));
        memcpy(normals + 3 * (size_t)i, n, sizeof(n));
        memcpy(colors + 3 * (size_t)i, color, sizeof(color));
    }
    stp_decimate_input input = {
        .count = 2 * SIDE * SIDE, .positions = positions, .normals = normals, .colors = colors};
    stp_context* context = test_context(NULL, 2, NULL);
    for (uint32_t target = 27; target > 0; target /= 3) {
        stp_decimate_output out;
        CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, target, &out));
        // one splat cannot cover both sides: the fewest are two
        CHECK(out.count <= (target > 2 ? target : 2) && is_sound(&out));
        CHECK(measure(out.ellipses, out.count, &input) < 0.01f);
        for (uint32_t i = 0; i < out.count; ++i) {
            CHECK_EQUAL(out.ellipses[i].normal.y > 0.0f ? 200 : 0, out.colors[3 * i]);
            CHECK_EQUAL(out.ellipses[i].normal.y > 0.0f ? 0 : 200, out.colors[3 * i + 2]);
        }
        destroy(context, &out);
    }
    input.normals = NULL;
    stp_decimate_output out;
    CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, 1, &out));
    CHECK_EQUAL(1, out.count);
    CHECK(measure(out.ellipses, 1, &input) < 0.02f);
    destroy(context, &out);
    stp_context_destroy(context);
}

// Colours are means in linear light: black and white give 188, not 128.
void test_subsample_mixes_colors_in_linear_light(test_state* test)
{
    static const float two[] = {0, 0, 0, 1, 0, 0};
    static const uint8_t black_and_white[] = {0, 0, 0, 255, 255, 255};
    stp_decimate_input input = {.count = 2, .positions = two, .colors = black_and_white};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_decimate_output out;
    CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, 1, &out));
    CHECK(out.count == 1 && out.colors[0] == 188 && out.colors[2] == 188);
    CHECK(measure(out.ellipses, 1, &input) == 0.0f);
    destroy(context, &out);
    // copies of a point count for colours, although they are one point otherwise: a third of white
    // gives 156
    static const float three[] = {0, 0, 0, 1, 0, 0, -0.0f, 0, 0};
    static const uint8_t with_copy[] = {0, 0, 0, 255, 255, 255, 0, 0, 0};
    input = (stp_decimate_input){.count = 3, .positions = three, .colors = with_copy};
    CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, 1, &out));
    CHECK(out.count == 1 && out.colors[0] == 156 && out.colors[2] == 156);
    destroy(context, &out);
    CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, 3, &out));
    CHECK(out.count == 2 && out.colors[0] == 0 && out.colors[3] == 255);
    destroy(context, &out);
    stp_context_destroy(context);
}

static void place_point(int shape, uint32_t i)
{
    float* p = positions + 3 * (size_t)i;
    p[0] = 5.0f;
    p[1] = p[2] = 1.0f;
    switch (shape) {
    case 0: // all at one place
        break;
    case 1: // in a line
        p[0] = (float)i;
        break;
    case 2: // in groups of twelve coincident points, far apart
        p[0] = (float)(i / 12 % 10) * 100.0f;
        p[1] = (float)(i / 120) * 100.0f;
        break;
    case 3: // anywhere in a cube
        for (uint32_t c = 0; c < 3; ++c) {
            p[c] = (float)unit(3, 3 * i + c);
        }
        break;
    default: // a plane with one point far away
        p[0] = i == 0 ? 1e6f : (float)(i % 32);
        p[1] = (float)(i / 32);
        break;
    }
}

void test_subsample_takes_any_points(test_state* test)
{
    static const uint32_t counts[] = {0, 1, 2, 3, 10, 100, 400}, targets[] = {1, 3, 50, 399};
    stp_context* context = test_context(NULL, 2, NULL);
    for (int shape = 0; shape < 5; ++shape) {
        for (uint32_t i = 0; i < 400; ++i) {
            place_point(shape, i);
        }
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            for (size_t t = 0; t < sizeof(targets) / sizeof(targets[0]); ++t) {
                stp_decimate_input input = {.count = counts[c], .positions = positions};
                stp_decimate_output out;
                CHECK_EQUAL(STP_OK, stp_decimate_by_subsample(context, &input, targets[t], &out));
                CHECK(out.count <= targets[t] && (out.count > 0) == (counts[c] > 0));
                CHECK(is_sound(&out));
                CHECK(measure(out.ellipses, out.count, &input) < HUGE_VALF);
                destroy(context, &out);
            }
        }
    }
    stp_context_destroy(context);
}

void test_subsample_survives_failing_allocator(test_state* test)
{
    stp_decimate_input input = make_ellipsoid(40);
    bool made = false;
    for (int n = 1; !made && n < 3000; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_decimate_output out = {0};
            made =
                stp_decimate_by_subsample(context, &input, 18, &out) == STP_OK && heap.count <= n;
            destroy(context, &out);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
    // separate parts that must be connected
    for (uint32_t i = 0; i < 48; ++i) {
        place_point(2, i);
    }
    input = (stp_decimate_input){.count = 48, .positions = positions};
    made = false;
    for (int n = 1; !made && n < 3000; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_decimate_output out = {0};
            made = stp_decimate_by_subsample(context, &input, 2, &out) == STP_OK && heap.count <= n;
            CHECK(!made || out.count <= 2);
            destroy(context, &out);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
