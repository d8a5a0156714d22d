// SPDX-License-Identifier: MIT
// Frame-time controllers against a simulated machine.
#include "tests.h"

#include "base/math/rng.h"
#include "select/budget.h"

#include <stdlib.h>

enum { FRAMES = 1200, WARM_UP = 30 };

// A scene along a flight: its visible content grows and shrinks by `swing`, and frame times have
// noise.
typedef struct machine {
    double splats, triangles; ///< at size 1, millions
    double swing;
    double noise;
    double slow; ///< slowdown of the second half of the flight
    /// Exponent of the splat count; 0: 2, constant screen coverage. Smaller if larger splats open
    /// fewer nodes; the same pixels are covered.
    double splat_exponent;
    double rate;  ///< growth of the content per frame (logarithm), which then shrinks
    int leg;      ///< frames of each phase; 0: constant
    double rough; ///< random change of the content (logarithm), every `period` frames
    int knot;
} machine;

static double random_between(uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(7, number) >> 11) * 0x1p-53);
}

static double swell_at(const machine* m, int frame)
{
    double swell = 1.0 + m->swing * sin(6.283185307 * (double)frame / 300.0);
    if (m->leg > 0) {
        int along = frame % (2 * m->leg);
        swell *= exp(m->rate * (double)(along < m->leg ? along : 2 * m->leg - along));
    }
    if (m->knot > 0) {
        uint64_t knot = (uint64_t)(frame / m->knot) + 100000;
        double before = random_between(knot, -m->rough, m->rough);
        double after = random_between(knot + 1, -m->rough, m->rough);
        swell *= exp(before + (after - before) * (double)(frame % m->knot) / (double)m->knot);
    }
    return swell;
}

/// A frame of these counts, in millions.
static stp_frame_cost make_cost(double milliseconds, double splats, double fragments,
                                double triangles, double covered, float size)
{
    return (stp_frame_cost){
        .milliseconds = milliseconds,
        .splats = (uint64_t)(splats * 1e6),
        .fragments = (uint64_t)(fragments * 1e6),
        .triangles = (uint64_t)(triangles * 1e6),
        .covered_pixels = (uint64_t)(covered * 1e6),
        .draw_calls = 500,
        .splat_size = size,
    };
}

static stp_frame_cost run_frame(const machine* m, int frame, float size)
{
    double swell = swell_at(m, frame), s = (double)size;
    double exponent = m->splat_exponent > 0.0 ? m->splat_exponent : 2.0;
    double splats = m->splats * swell / pow(s, exponent),
           triangles = m->triangles * swell / s + 0.05;
    double fragments = m->splats * swell * 0.3, covered = 1.5;
    double time = 1.0 + 6.0 * splats + 1.5 * fragments + 9.0 * triangles + 6.0 * covered;
    time *= random_between((uint64_t)frame, 1.0 - m->noise, 1.0 + m->noise);
    time *= frame > FRAMES / 2 ? m->slow : 1.0;
    return make_cost(time, splats, fragments, triangles, covered, size);
}

static int compare_doubles(const void* left, const void* right)
{
    double a = *(const double*)left, b = *(const double*)right;
    return a < b ? -1 : a > b;
}

typedef struct outcome {
    double p50, p95, p99, size; ///< percentiles of time over budget; mean splat size
} outcome;

static outcome fly(const machine* m, stp_controller controller, double budget_ms)
{
    static double times[FRAMES];
    stp_budget budget;
    stp_budget_init(&budget, controller, budget_ms);
    size_t count = 0;
    outcome out = {0};
    for (int i = 0; i < FRAMES; ++i) {
        stp_frame_cost cost = run_frame(m, i, stp_budget_splat_size(&budget));
        stp_budget_update(&budget, &cost);
        if (i >= WARM_UP) {
            times[count++] = cost.milliseconds / budget_ms;
            out.size += (double)cost.splat_size;
        }
    }
    out.size /= (double)count;
    qsort(times, count, sizeof(times[0]), compare_doubles);
    out.p50 = times[count / 2];
    out.p95 = times[count * 95 / 100];
    out.p99 = times[count * 99 / 100];
    return out;
}

void test_budget_prediction_holds_attainable_budgets(test_state* test)
{
    const machine machines[] = {
        {.splats = 10.0, .triangles = 4.0, .swing = 0.2, .noise = 0.02, .slow = 1.0},
        {.splats = 10.0, .triangles = 4.0, .swing = 0.8, .noise = 0.04, .slow = 1.0},
        {.splats = 16.0, .triangles = 4.0, .swing = 0.5, .noise = 0.03, .slow = 1.3},
        {.splats = 30.0, .triangles = 1.0, .swing = 0.6, .noise = 0.05, .slow = 1.0},
    };
    for (size_t i = 0; i < sizeof(machines) / sizeof(machines[0]); ++i) {
        outcome o = fly(&machines[i], STP_CONTROLLER_PREDICT, 40.0);
        CHECK(o.p95 <= 1.1);
        CHECK(o.p99 <= 1.5);
        CHECK(o.p50 >= 0.9); // and no time is wasted
    }
}

/// A frame of a hall whose time is that of fragments and pixels, at whatever size of splats.
static stp_frame_cost run_hall(double heavy, float size, float resolution)
{
    double area = (double)resolution * (double)resolution;
    double fragments = heavy * 20.0 * area, covered = 2.0 * area, splats = 0.05;
    double triangles = heavy * 0.5 * (double)resolution;
    double time = 2.0 + 6.0 * splats + 1.5 * fragments + 9.0 * triangles + 6.0 * covered;
    stp_frame_cost cost = make_cost(time, splats, fragments, triangles, covered, size);
    cost.resolution = resolution;
    return cost;
}

// Where the coarsest splats do not meet the budget, the resolution falls as far as necessary, and
// comes back.
void test_budget_lowers_the_resolution_last(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    stp_budget_lower_resolution(&budget);
    const double heavy[] = {0.9, 1.9, 6.0, 20.0, 0.3};
    const double least[] = {0.75, 0.55, 0.25, 0.25, 1.0}, most[] = {0.9, 0.7, 0.4, 0.25, 1.0};
    for (int place = 0; place < 5; ++place) {
        stp_frame_cost cost = {0};
        for (int i = 0; i < 120; ++i) {
            float resolution = stp_budget_resolution(&budget);
            CHECK((double)resolution >= STP_RESOLUTION_MIN && resolution <= 1.0f);
            CHECK(fmodf(16.0f * resolution, 1.0f) == 0.0f);
            float size = stp_budget_splat_size(&budget);
            CHECK(resolution == 1.0f || fabsf(size / resolution - STP_SPLAT_SIZE_COARSEST) < 1e-3f);
            cost = run_hall(heavy[place], size, resolution);
            stp_budget_update(&budget, &cost);
        }
        CHECK((double)cost.resolution >= least[place] && (double)cost.resolution <= most[place]);
        CHECK(place == 3 || cost.milliseconds < 1.1 * 33.0);
        CHECK(place != 4 || cost.splat_size < 2.0f);
    }
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    stp_budget_lower_resolution(&budget);
    for (int i = 0; i < 200; ++i) { // in time with splats that somebody wants larger
        CHECK(stp_budget_resolution(&budget) == 1.0f && stp_budget_splat_size(&budget) <= 24.0f);
        stp_frame_cost cost = run_hall(0.45, 40.0f, 1.0f);
        CHECK(cost.milliseconds < 31.0);
        stp_budget_update(&budget, &cost);
    }
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    for (int i = 0; i < 60; ++i) { // not unless it may
        stp_frame_cost cost = run_hall(9.0, stp_budget_splat_size(&budget), 1.0f);
        CHECK(stp_budget_resolution(&budget) == 1.0f);
        stp_budget_update(&budget, &cost);
    }
    stp_budget_init(&budget, STP_CONTROLLER_PAPER, 1.0);
    stp_budget_lower_resolution(&budget);
    for (int i = 0; i < 60; ++i) {
        stp_frame_cost cost = run_hall(9.0, stp_budget_splat_size(&budget), 1.0f);
        CHECK(stp_budget_resolution(&budget) == 1.0f);
        stp_budget_update(&budget, &cost);
    }
}

// An effect's time is that of its pixels: a picture at rest has more of them than one that moved.
void test_budget_expects_effects_of_all_pixels(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    stp_budget_lower_resolution(&budget);
    for (int i = 0; i < 60; ++i) {
        float resolution = stp_budget_resolution(&budget);
        stp_frame_cost cost = run_hall(9.0, stp_budget_splat_size(&budget), resolution);
        cost.effect_ms[STP_EFFECT_OCCLUSION] = 1.0 * (double)resolution * (double)resolution;
        cost.milliseconds += cost.effect_ms[STP_EFFECT_OCCLUSION];
        stp_budget_update(&budget, &cost);
    }
    CHECK(stp_budget_resolution(&budget) == 0.25f);
    double with = stp_budget_predict_whole(&budget, 1.0, 0);
    double without = stp_budget_predict_whole(&budget, 1.0, 1u << STP_EFFECT_OCCLUSION);
    CHECK(fabs(with - without - 1.0) < 0.05);
}

void test_budget_prediction_keeps_the_best_where_time_is_plenty(test_state* test)
{
    machine m = {.splats = 2.0, .triangles = 0.5, .swing = 0.2, .noise = 0.02, .slow = 1.0};
    outcome o = fly(&m, STP_CONTROLLER_PREDICT, 200.0);
    CHECK(o.size < 1.01);
}

void test_budget_prediction_takes_the_coarsest_where_nothing_helps(test_state* test)
{
    machine m = {.splats = 20.0, .triangles = 4.0, .swing = 0.1, .noise = 0.02, .slow = 1.0};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 2.0);
    for (int i = 0; i < 50; ++i) {
        stp_frame_cost cost = run_frame(&m, i, stp_budget_splat_size(&budget));
        stp_budget_update(&budget, &cost);
    }
    CHECK(stp_budget_splat_size(&budget) > 7.99f);
    CHECK(stp_budget_splat_size(&budget) <
          23.9f); // a twentieth of the time is not worth the finest size
}

void test_budget_prediction_goes_beyond_the_paper_to_be_in_time(test_state* test)
{
    machine m = {.splats = 30.0, .triangles = 25.0, .swing = 0.2, .noise = 0.02, .slow = 1.0};
    outcome ours = fly(&m, STP_CONTROLLER_PREDICT, 40.0);
    outcome paper = fly(&m, STP_CONTROLLER_PAPER, 40.0);
    CHECK(ours.p95 <= 1.1 && ours.size > 8.0 && ours.size < 24.0);
    CHECK(paper.p50 > 1.1);
}

void test_budget_prediction_goes_on_where_splats_fall_slowly(test_state* test)
{
    // a hall: 8 pixels take 43 ms, 14 would take 33
    machine m = {.splats = 14.0,
                 .triangles = 14.0,
                 .swing = 0.0,
                 .noise = 0.02,
                 .slow = 1.0,
                 .splat_exponent = 1.0};
    CHECK(run_frame(&m, 0, 8.0f).milliseconds > 40.0);
    CHECK(run_frame(&m, 0, 20.0f).milliseconds < 32.0);
    outcome o = fly(&m, STP_CONTROLLER_PREDICT, 33.0);
    CHECK(o.p50 <= 1.0);
    CHECK(o.p95 <= 1.1);
    CHECK(o.p50 >= 0.9);
}

void test_budget_prediction_forgives_one_slow_frame(test_state* test)
{
    machine m = {.splats = 10.0, .triangles = 4.0, .swing = 0.0, .noise = 0.02, .slow = 1.0};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 25.0);
    float before = 0.0f, maximum = 0.0f;
    for (int i = 0; i < 80; ++i) {
        stp_frame_cost cost = run_frame(&m, i, stp_budget_splat_size(&budget));
        if (i == 60) {
            before = cost.splat_size;
            cost.milliseconds *= 4.0;
        }
        stp_budget_update(&budget, &cost);
        float size = stp_budget_splat_size(&budget);
        maximum = i >= 60 && size > maximum ? size : maximum;
        CHECK(i < 66 || size < 1.1f * before); // and the picture is not coarse for long
    }
    CHECK(before > 1.1f && maximum < 1.25f * before);
}

void test_budget_prediction_knows_where_a_flight_goes(test_state* test)
{
    // an eighth more per frame, up to 18 times as much, then back at the same rate
    machine m = {
        .splats = 2.8, .triangles = 0.95, .noise = 0.02, .slow = 1.0, .rate = 0.12, .leg = 24};
    outcome o = fly(&m, STP_CONTROLLER_PREDICT, 40.0);
    CHECK(o.p95 <= 1.1);
    CHECK(o.p99 <= 1.15);
    CHECK(o.p50 >= 0.6);
}

void test_budget_prediction_holds_where_views_come_and_go(test_state* test)
{
    const machine machines[] = {
        {.splats = 6.0, .triangles = 2.5, .noise = 0.02, .slow = 1.0, .rough = 0.3, .knot = 1},
        {.splats = 6.0, .triangles = 2.5, .noise = 0.02, .slow = 1.0, .rough = 0.6, .knot = 3},
        {.splats = 6.0, .triangles = 2.5, .noise = 0.02, .slow = 1.0, .rough = 0.9, .knot = 7},
    };
    for (size_t i = 0; i < sizeof(machines) / sizeof(machines[0]); ++i) {
        outcome o = fly(&machines[i], STP_CONTROLLER_PREDICT, 40.0);
        CHECK(o.p95 <= 1.1);
        CHECK(o.p99 <= 1.5);
        CHECK(o.p50 >= 0.75);
    }
}

// 500,000 triangles that depend little on the size, and a floor of pixels: sizes above 3 save 1 ms.
void test_budget_prediction_is_not_coarse_for_little(test_state* test)
{
    stp_budget b;
    stp_budget_init(&b, STP_CONTROLLER_PREDICT, 33.0);
    float size = 0.0f;
    for (int frame = 0; frame < 200; ++frame) {
        size = stp_budget_splat_size(&b);
        double part = pow(1.0 / (double)size, 0.06);
        stp_frame_cost cost = {.splat_size = size,
                               .triangles = (uint64_t)(500000.0 * part),
                               .covered_pixels = 700000,
                               .fragments = 5000000,
                               .draw_calls = 1000,
                               .milliseconds = 26.0 + 10.0 * part};
        stp_budget_update(&b, &cost);
    }
    CHECK(size < 4.0f); // 24 pixels would save a tenth of the time
}

void test_budget_prediction_takes_what_the_coarsest_saves(test_state* test)
{
    // 24 pixels meet the budget, 16 exceed it by a twentieth
    machine m = {
        .splats = 40.0, .triangles = 4.0, .noise = 0.0, .slow = 1.0, .splat_exponent = 1.0};
    double budget_ms = run_frame(&m, 0, 23.0f).milliseconds;
    CHECK(run_frame(&m, 0, 19.0f).milliseconds > 1.04 * budget_ms);
    outcome o = fly(&m, STP_CONTROLLER_PREDICT, budget_ms);
    CHECK(o.p50 <= 1.01);
    CHECK(o.size > 20.0 && o.size < 24.0);
}

void test_budget_prediction_never_expects_larger_splats_to_be_slower(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 30.0);
    for (int i = 0; i < 40; ++i) {
        // a hall in which only the number of fragments grows with the size
        float size = stp_budget_splat_size(&budget);
        double fragments = 10.0 * pow((double)size, 0.3);
        stp_frame_cost cost = {.milliseconds = 10.0 + 2.0 * fragments,
                               .splats = 200000,
                               .fragments = (uint64_t)(fragments * 1e6),
                               .triangles = 300000,
                               .covered_pixels = 1500000,
                               .draw_calls = 300,
                               .splat_size = size};
        stp_budget_update(&budget, &cost);
    }
    double before = stp_budget_predict(&budget, (double)budget.last.splat_size);
    for (double size = (double)budget.last.splat_size; size < 24.0; size *= 1.2) {
        double now = stp_budget_predict(&budget, size);
        CHECK(now <= before * (1.0 + 1e-9));
        before = now;
    }
}

void test_budget_prediction_tells_a_busy_machine_from_a_growing_scene(test_state* test)
{
    // four frames of the same scene take a third longer: another program was running
    machine m = {
        .splats = 14.0, .triangles = 10.0, .noise = 0.02, .slow = 1.0, .splat_exponent = 1.0};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 40.0);
    float before = 0.0f, maximum = 0.0f;
    for (int i = 0; i < 90; ++i) {
        stp_frame_cost cost = run_frame(&m, i, stp_budget_splat_size(&budget));
        before = i == 60 ? cost.splat_size : before;
        cost.milliseconds *= i >= 60 && i < 64 ? 1.33 : 1.0;
        stp_budget_update(&budget, &cost);
        maximum = fmaxf(i >= 60 ? stp_budget_splat_size(&budget) : 0.0f, maximum);
    }
    CHECK(maximum < 2.2f * before); // 1.6 would meet the budget
    CHECK(budget.trend < 0.02);
}

void test_budget_prediction_beats_the_paper_where_the_scene_changes(test_state* test)
{
    machine m = {.splats = 12.0, .triangles = 4.0, .swing = 0.8, .noise = 0.03, .slow = 1.3};
    outcome ours = fly(&m, STP_CONTROLLER_PREDICT, 40.0);
    outcome paper = fly(&m, STP_CONTROLLER_PAPER, 40.0);
    CHECK(ours.p95 < paper.p95);
}

void test_budget_of_the_paper_follows_its_formula(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PAPER, 20.0);
    CHECK(stp_budget_splat_size(&budget) == 1.0f);
    stp_frame_cost cost = {.milliseconds = 40.0, .splat_size = 2.0f};
    stp_budget_update(&budget, &cost); // average 2, twice too late: (2 * 3 + 2 * 2) / 4
    CHECK(fabsf(stp_budget_splat_size(&budget) - 2.5f) < 1e-6f);
    cost = (stp_frame_cost){.milliseconds = 30.0, .splat_size = 4.0f};
    stp_budget_update(&budget, &cost); // average 3: (9 + 4.5) / 4
    CHECK(fabsf(stp_budget_splat_size(&budget) - 3.375f) < 1e-6f);
    cost.milliseconds = 21.9; // within the dead band
    stp_budget_update(&budget, &cost);
    CHECK(fabsf(stp_budget_splat_size(&budget) - 3.375f) < 1e-6f);
    cost.milliseconds = 2000.0;
    stp_budget_update(&budget, &cost);
    CHECK(stp_budget_splat_size(&budget) == 8.0f);
    cost = (stp_frame_cost){.milliseconds = 1.0, .splat_size = 1.0f};
    for (int i = 0; i < 4; ++i) {
        stp_budget_update(&budget, &cost);
    }
    CHECK(stp_budget_splat_size(&budget) == 1.0f);
}

void test_budget_ignores_invalid_times(test_state* test)
{
    const stp_controller controllers[] = {STP_CONTROLLER_PREDICT, STP_CONTROLLER_PAPER};
    const double times[] = {0.0, -1.0, (double)NAN, (double)INFINITY, 1e300};
    for (int k = 0; k < 2; ++k) {
        stp_budget budget;
        stp_budget_init(&budget, controllers[k], 33.0);
        float before = stp_budget_splat_size(&budget);
        for (size_t i = 0; i < sizeof(times) / sizeof(times[0]); ++i) {
            stp_frame_cost cost = {.milliseconds = times[i], .splats = 1000, .splat_size = 2.0f};
            stp_budget_update(&budget, &cost);
        }
        CHECK(stp_budget_splat_size(&budget) == before);
        stp_frame_cost huge = {.milliseconds = 5.0,
                               .splats = UINT64_MAX,
                               .fragments = UINT64_MAX,
                               .triangles = UINT64_MAX,
                               .draw_calls = UINT32_MAX,
                               .splat_size = 8.0f};
        for (int i = 0; i < 100; ++i) {
            stp_budget_update(&budget, &huge);
            float size = stp_budget_splat_size(&budget);
            CHECK(size >= 1.0f && size <= (k == 1 ? 8.0f : 24.0f));
        }
    }
}

// A cold first frame says nothing about the machine's speed: for any duration of rest, the forecast
// stays right and the size recovers.
void test_budget_prediction_stays_right_after_a_cold_frame(test_state* test)
{
    const double colds[] = {1.0, 6.0, 30.0};
    float found[3];
    for (int i = 0; i < 3; ++i) {
        machine m = {.splats = 20.0, .triangles = 1.0, .noise = 0.05, .slow = 1.0};
        stp_budget budget;
        stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
        for (int frame = 0; frame < FRAMES; ++frame) {
            stp_frame_cost cost = run_frame(&m, frame, stp_budget_splat_size(&budget));
            cost.milliseconds *= frame == 0 ? colds[i] : 1.0;
            stp_budget_update(&budget, &cost);
            if (frame > 150) {
                double forecast = stp_budget_predict(&budget, (double)cost.splat_size);
                CHECK(fabs(forecast / cost.milliseconds - 1.0) < 0.15);
                CHECK(budget.speed > 0.7 && budget.speed < 1.4);
            }
        }
        found[i] = stp_budget_splat_size(&budget);
        CHECK(fabs((double)(found[i] / found[0]) - 1.0) < 0.1);
    }
}

/// Frames until a steady view uses most of the budget again, after an external slowdown.
static int frames_to_recover(double slower, int slow_frames)
{
    machine m = {.splats = 12.0, .triangles = 1.0, .swing = 0.0, .noise = 0.02, .slow = 1.0};
    stp_budget budget;
    int frame = 0;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    for (; frame < 60; ++frame) {
        stp_frame_cost cost = run_frame(&m, frame, stp_budget_splat_size(&budget));
        stp_budget_update(&budget, &cost);
    }
    for (int i = 0; i < slow_frames; ++i, ++frame) { // another program, or reading a file
        stp_frame_cost cost = run_frame(&m, frame, stp_budget_splat_size(&budget));
        cost.milliseconds *= slower;
        stp_budget_update(&budget, &cost);
    }
    int first = frame;
    double used = 0.0;
    while (used < 0.6 && frame < first + 200) {
        stp_frame_cost cost = run_frame(&m, frame++, stp_budget_splat_size(&budget));
        stp_budget_update(&budget, &cost);
        used = cost.milliseconds / 33.0;
    }
    return frame - first;
}

void test_budget_prediction_uses_the_time_that_comes_back(test_state* test)
{
    CHECK(frames_to_recover(4.0, 10) <= 12);
    CHECK(frames_to_recover(8.0, 30) <= 16);
    CHECK(frames_to_recover(3.0, 3) <= 10);
}

/// The first frames of a view: a size between the default and what the budget allows.
void test_budget_prediction_uses_the_time_at_the_start(test_state* test)
{
    static const double splats[] = {0.5, 2.0, 12.0, 40.0};
    for (size_t i = 0; i < sizeof(splats) / sizeof(splats[0]); ++i) {
        machine m = {
            .splats = splats[i], .triangles = 0.2, .swing = 0.0, .noise = 0.02, .slow = 1.0};
        stp_budget budget;
        stp_frame_cost cost = {0};
        stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
        for (int frame = 0; frame < 12; ++frame) {
            cost = run_frame(&m, frame, stp_budget_splat_size(&budget));
            cost.milliseconds *= frame == 0 ? 5.0 : 1.0; // no data is in memory yet
            stp_budget_update(&budget, &cost);
        }
        CHECK(cost.milliseconds > 0.6 * 33.0 || cost.splat_size < 1.05f);
        CHECK(cost.milliseconds < 1.2 * 33.0);
    }
}

typedef struct effect_outcome {
    double size, p95; ///< mean splat size; percentile of time over budget
    int with, changes;
} effect_outcome;

/// Flies with effects of so many milliseconds, wherever the budget allows them.
static effect_outcome fly_with_effects(const machine* m, double budget_ms, double effect_ms)
{
    static double times[FRAMES];
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, budget_ms);
    effect_outcome out = {0};
    bool before = true;
    size_t count = 0;
    for (int i = 0; i < FRAMES; ++i) {
        bool effects = stp_budget_left_out(&budget) == 0;
        stp_frame_cost cost = run_frame(m, i, stp_budget_splat_size(&budget));
        cost.effect_ms[STP_EFFECT_OCCLUSION] = effects ? effect_ms : 0.0;
        cost.milliseconds += effects ? effect_ms : 0.0;
        stp_budget_update(&budget, &cost);
        out.changes += effects != before ? 1 : 0;
        before = effects;
        if (i >= WARM_UP) {
            times[count++] = cost.milliseconds / budget_ms;
            out.size += (double)cost.splat_size;
            out.with += effects ? 1 : 0;
        }
    }
    out.size /= (double)count;
    qsort(times, count, sizeof(times[0]), compare_doubles);
    out.p95 = times[count * 95 / 100];
    return out;
}

void test_budget_leaves_effects_out_before_splats_grow(test_state* test)
{
    machine m = {.splats = 10.0, .triangles = 4.0, .swing = 0.3, .noise = 0.03, .slow = 1.0};
    outcome without = fly(&m, STP_CONTROLLER_PREDICT, 40.0);
    effect_outcome dear = fly_with_effects(&m, 40.0, 15.0);
    CHECK(dear.with == 0 && dear.p95 <= 1.1);
    CHECK(dear.size < 1.03 * without.size && dear.size > 1.3);
    effect_outcome cheap = fly_with_effects(&m, 40.0, 1.0); // hardly any larger splats
    CHECK(cheap.with == FRAMES - WARM_UP && cheap.p95 <= 1.1);
    machine small = {.splats = 1.0, .triangles = 0.3, .swing = 0.2, .noise = 0.02, .slow = 1.0};
    effect_outcome plenty = fly_with_effects(&small, 60.0, 15.0);
    CHECK(plenty.with == FRAMES - WARM_UP && plenty.size < 1.01);
}

void test_budget_takes_effects_back_without_flicker(test_state* test)
{
    // content that grows threefold and shrinks again, in 600 frames
    machine m = {.splats = 1.0,
                 .triangles = 0.3,
                 .noise = 0.03,
                 .slow = 1.0,
                 .rate = 2.2 / 300.0,
                 .leg = 300};
    effect_outcome o = fly_with_effects(&m, 40.0, 12.0);
    CHECK(o.p95 <= 1.1);
    CHECK(o.with > FRAMES / 5 && o.with < FRAMES * 4 / 5);
    CHECK(o.changes >= 3 && o.changes <= 8);
}

void test_budget_of_the_paper_ignores_effects(test_state* test)
{
    stp_budget with, without;
    stp_budget_init(&with, STP_CONTROLLER_PAPER, 20.0);
    stp_budget_init(&without, STP_CONTROLLER_PAPER, 20.0);
    stp_frame_cost cost = {.milliseconds = 50.0, .splats = 1000, .splat_size = 2.0f};
    stp_budget_update(&without, &cost);
    cost.effect_ms[STP_EFFECT_OCCLUSION] = 20.0;
    stp_budget_update(&with, &cost);
    CHECK_EQUAL(0, stp_budget_left_out(&with));
    CHECK(stp_budget_splat_size(&with) == stp_budget_splat_size(&without));
}

/// Frames with effects among `count` frames from `first`, at a budget of 33 ms: each takes 2 + 18 /
/// s^2 ms, and `effect_ms` where the budget allows effects.
static int count_effects(stp_budget* budget, int count, double effect_ms, double covered)
{
    int with = 0;
    for (int i = 0; i < count; ++i) {
        bool effects = stp_budget_left_out(budget) == 0;
        double size = (double)stp_budget_splat_size(budget);
        stp_frame_cost cost = {.milliseconds = 2.0 + 18.0 * covered / (size * size),
                               .splats = (uint64_t)(3e6 * covered / (size * size)),
                               .fragments = (uint64_t)(2e6 * covered),
                               .covered_pixels = (uint64_t)(1e6 * covered),
                               .draw_calls = 100,
                               .splat_size = (float)size,
                               .effect_ms = {effects ? effect_ms : 0.0}};
        cost.milliseconds += cost.effect_ms[STP_EFFECT_OCCLUSION];
        stp_budget_update(budget, &cost);
        with += effects ? 1 : 0;
    }
    return with;
}

void test_budget_forgives_one_slow_effect(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    CHECK_EQUAL(1, count_effects(&budget, 1, 60.0, 1.0)); // cold
    CHECK_EQUAL(300, count_effects(&budget, 300, 4.0, 1.0));
    CHECK_EQUAL(1, count_effects(&budget, 1, 104.0, 1.0));
    CHECK(count_effects(&budget, 300, 4.0, 1.0) >= 280);
}

void test_budget_takes_effects_back_in_a_smaller_picture(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    CHECK(count_effects(&budget, 300, 40.0, 1.0) < 10);
    CHECK(count_effects(&budget, 300, 40.0 / 16.0, 1.0 / 16.0) > 250);
    CHECK_EQUAL(300, count_effects(&budget, 300, 0.0, 1.0)); // not wanted any more
    CHECK(stp_budget_splat_size(&budget) < 1.01f);           // keeps no time for them
}

/// Detail, samples and effects of a frame: its model has a fixed part, a part that follows the size
/// of splats, occlusion, 2 x 2 samples and layers.
typedef struct lavish_machine {
    double fixed_ms, detail_ms;                ///< of one sample; the second at size 1
    double occlusion_ms, layer_ms, nearest_ms; ///< the second: beside the nearest layer
    double noise;
    bool plain; ///< one sample a pixel is wanted
} lavish_machine;

/// Draws a frame of a machine with the effects that the budget allows.
static stp_frame_cost draw_lavish(stp_budget* budget, const lavish_machine* m, uint64_t frame)
{
    uint32_t left_out = stp_budget_left_out(budget);
    double size = (double)stp_budget_splat_size(budget);
    double noise = random_between(frame, 1.0 - m->noise, 1.0 + m->noise);
    bool plain = m->plain || (left_out >> STP_EFFECT_ANTIALIASING & 1u) != 0;
    double samples = plain ? 1.0 : 4.0;
    double occlusion = (left_out >> STP_EFFECT_OCCLUSION & 1u) != 0 ? 0.0 : m->occlusion_ms;
    double layers = (left_out >> STP_EFFECT_LAYERS & 1u) != 0 ? 0.0 : m->layer_ms;
    double nearest = (left_out >> STP_EFFECT_NEAREST & 1u) != 0 ? 0.0 : m->nearest_ms;
    double sample = noise * (m->fixed_ms + m->detail_ms / (size * size) + layers + nearest);
    stp_frame_cost cost = {.milliseconds = samples * sample + noise * occlusion,
                           .splats = (uint64_t)(1e5 * m->detail_ms / (size * size)),
                           .fragments = (uint64_t)(4e4 * m->detail_ms),
                           .covered_pixels = (uint64_t)(5e5),
                           .draw_calls = 100,
                           .splat_size = (float)size};
    cost.effect_ms[STP_EFFECT_OCCLUSION] = noise * occlusion;
    cost.effect_ms[STP_EFFECT_ANTIALIASING] = (samples - 1.0) * sample;
    cost.effect_ms[STP_EFFECT_LAYERS] = noise * layers;
    cost.effect_ms[STP_EFFECT_NEAREST] = noise * nearest;
    stp_budget_update(budget, &cost);
    return cost;
}

void test_budget_leaves_effects_out_in_their_order(test_state* test)
{
    lavish_machine m = {.fixed_ms = 1.0, .occlusion_ms = 4.0, .layer_ms = 2.5, .noise = 0.02};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    uint32_t before = 0;
    const uint32_t more[] = {0, 1, 3, 7};
    int steps = 0;
    for (uint64_t frame = 0; frame < 1050; ++frame) { // content that grows to 150 ms
        m.detail_ms = frame < 100 ? 0.5 : 0.5 * exp(0.006 * (double)(frame - 100));
        stp_frame_cost cost = draw_lavish(&budget, &m, frame);
        uint32_t left_out = stp_budget_left_out(&budget);
        CHECK((left_out & before) == before); // none returns while content grows
        while (steps < 3 && more[steps] != left_out) {
            steps += 1;
        }
        CHECK_EQUAL(more[steps], left_out);
        if (frame > 60 && before != 7) { // effects first
            CHECK(cost.splat_size <= 1.6f);
        }
        before = left_out;
    }
    CHECK_EQUAL(7, before);
    CHECK(stp_budget_splat_size(&budget) > 1.2f); // splats last
}

void test_budget_takes_effects_back_in_reverse_order(test_state* test)
{
    lavish_machine m = {.fixed_ms = 1.0, .occlusion_ms = 4.0, .layer_ms = 2.5, .noise = 0.02};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    int changes = 0;
    uint32_t before = 0, seen[8] = {0};
    for (uint64_t frame = 0; frame < 1500; ++frame) {
        m.detail_ms = frame < 300 ? 150.0 : fmax(150.0 * exp(-0.008 * (double)(frame - 300)), 0.3);
        draw_lavish(&budget, &m, frame);
        uint32_t left_out = stp_budget_left_out(&budget);
        if (frame > 100) {
            changes += left_out != before ? 1 : 0;
            CHECK((left_out & ~before) == 0); // none leaves again
            seen[left_out] += 1;
        }
        before = left_out;
    }
    CHECK_EQUAL(0, before);
    CHECK_EQUAL(3, changes);
    CHECK(seen[7] > 0 && seen[3] > 0 && seen[1] > 0);
}

/// How often the effects that are left out change after the first 60 frames. `round` varies noise.
static int count_changes(const lavish_machine* m, double budget_ms, uint64_t frames, int round)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, budget_ms);
    int changes = 0;
    uint32_t before = 0;
    for (uint64_t frame = 0; frame < frames; ++frame) {
        draw_lavish(&budget, m, frame + 1000 * (uint64_t)round);
        uint32_t left_out = stp_budget_left_out(&budget);
        changes += frame > 60 && left_out != before ? 1 : 0;
        before = left_out;
    }
    return changes;
}

void test_budget_does_not_alternate_effects(test_state* test)
{
    for (int i = 0; i < 60; ++i) { // every share of the budget that an effect may take
        lavish_machine m = {.fixed_ms = 2.0,
                            .detail_ms = 0.2 + 0.2 * (double)(i % 20),
                            .occlusion_ms = i < 20 ? 1.5 * (double)i : 10.0,
                            .layer_ms = i >= 40 ? 1.5 * (double)(i - 40) : 0.0,
                            .noise = 0.04};
        int changes = count_changes(&m, 33.0, 600, i);
        CHECK(changes <= 1);
    }
}

enum { GLASS_OUT = 1u << STP_EFFECT_LAYERS, PATTERN = GLASS_OUT | 1u << STP_EFFECT_NEAREST };

/// Draws many frames. @return the bits that the last one was drawn without
static uint32_t settle(stp_budget* budget, const lavish_machine* m, uint64_t first,
                       stp_frame_cost* cost)
{
    uint32_t left_out = 0;
    for (uint64_t frame = first; frame < first + 300; ++frame) {
        left_out = stp_budget_left_out(budget);
        *cost = draw_lavish(budget, m, frame);
    }
    return left_out;
}

void test_budget_leaves_the_nearest_layer_out_before_splats_grow(test_state* test)
{
    lavish_machine m = {.fixed_ms = 3.0,
                        .detail_ms = 14.0,
                        .layer_ms = 14.0,
                        .nearest_ms = 4.5,
                        .noise = 0.02,
                        .plain = true};
    const double budgets[] = {40.0, 26.0, 18.0, 12.0};
    const uint32_t wanted[] = {0, GLASS_OUT, PATTERN, PATTERN};
    for (int i = 0; i < 4; ++i) {
        stp_budget budget, opaque;
        stp_frame_cost cost, least;
        stp_budget_init(&budget, STP_CONTROLLER_PREDICT, budgets[i]);
        stp_budget_init(&opaque, STP_CONTROLLER_PREDICT, budgets[i]);
        CHECK_EQUAL(wanted[i], settle(&budget, &m, 0, &cost));
        CHECK(cost.milliseconds < 1.1 * budgets[i]);
        lavish_machine without = m;
        without.layer_ms = without.nearest_ms = 0.0;
        CHECK_EQUAL(0, settle(&opaque, &without, 0, &least));
        CHECK(cost.splat_size < 1.05f * least.splat_size); // not larger than beside a pattern
    }
}

void test_budget_takes_the_nearest_layer_back(test_state* test)
{
    lavish_machine m = {
        .fixed_ms = 3.0, .detail_ms = 14.0, .nearest_ms = 4.5, .noise = 0.02, .plain = true};
    stp_frame_cost cost;
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 18.0);
    m.layer_ms = 6.0;
    CHECK_EQUAL(PATTERN, settle(&budget, &m, 0, &cost));
    m.detail_ms = 8.0; // time for one layer
    CHECK_EQUAL(GLASS_OUT, settle(&budget, &m, 300, &cost));
    m.detail_ms = 1.0; // and for all
    CHECK_EQUAL(0, settle(&budget, &m, 600, &cost));
    m.detail_ms = 14.0;
    CHECK_EQUAL(PATTERN, settle(&budget, &m, 900, &cost));
}

void test_budget_does_not_alternate_layers_and_pattern(test_state* test)
{
    for (int i = 0; i < 80; ++i) { // every share of the budget that layers may take
        lavish_machine m = {.fixed_ms = 2.0,
                            .detail_ms = 6.0 + 0.4 * (double)(i % 40),
                            .layer_ms = i < 40 ? 3.0 : 0.0,
                            .nearest_ms = 3.5,
                            .noise = 0.04,
                            .plain = true};
        int changes = count_changes(&m, 20.0, 1000, i);
        CHECK(changes <= 1);
    }
}

/// Frames whose times scatter by a fifth: neither layers nor occlusion come and go.
void test_budget_does_not_alternate_in_noise(test_state* test)
{
    int most = 0;
    for (int i = 0; i < 240; ++i) {
        lavish_machine m = {.fixed_ms = 6.0 + 0.25 * (double)(i % 40),
                            .detail_ms = 3.0,
                            .layer_ms = i % 80 < 40 ? 3.0 : 0.0,
                            .nearest_ms = i < 160 ? 3.5 : 0.0,
                            .occlusion_ms = i < 160 ? 0.0 : 4.0,
                            .noise = i % 3 == 0   ? 0.15
                                     : i % 3 == 1 ? 0.2
                                                  : 0.25,
                            .plain = true};
        int changes = count_changes(&m, 20.0, 1000, i);
        most = changes > most ? changes : most;
    }
    CHECK(most <= 4);
}

void test_budget_predicts_frames_with_all_effects(test_state* test)
{
    const lavish_machine m = {
        .fixed_ms = 2.0, .detail_ms = 4.0, .occlusion_ms = 9.0, .layer_ms = 5.0, .nearest_ms = 2.0};
    stp_frame_cost cost;
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 12.0);
    CHECK(stp_budget_predict_whole(&budget, 1.0, 0) == 0.0);
    CHECK(settle(&budget, &m, 0, &cost) != 0);
    double whole = stp_budget_predict_whole(&budget, (double)cost.splat_size, 0);
    double size = (double)cost.splat_size;
    double sample = m.fixed_ms + m.detail_ms / (size * size) + m.layer_ms + m.nearest_ms;
    CHECK(fabs(whole / (4.0 * sample + m.occlusion_ms) - 1.0) < 0.1);
    CHECK(stp_budget_predict(&budget, size) < 0.3 * whole);
    double without = stp_budget_predict_whole(&budget, size, 1u << STP_EFFECT_OCCLUSION);
    CHECK(fabs(whole - without - m.occlusion_ms) < 0.1 * m.occlusion_ms);
}

/// An effect that was left out and is then switched off counts no more, and is judged anew later.
void test_budget_forgets_effects_that_are_switched_off(test_state* test)
{
    lavish_machine m = {.fixed_ms = 2.0, .detail_ms = 20.0, .occlusion_ms = 60.0, .plain = true};
    stp_frame_cost cost;
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 20.0);
    CHECK_EQUAL(1, settle(&budget, &m, 0, &cost));
    CHECK(stp_budget_predict_whole(&budget, 1.0, 0) > 60.0);
    cost.unwanted = 1u << STP_EFFECT_OCCLUSION;
    stp_budget_update(&budget, &cost);
    CHECK(stp_budget_predict_whole(&budget, 1.0, 0) < 30.0);
    CHECK_EQUAL(0, stp_budget_left_out(&budget));
    CHECK(stp_budget_has_decided(&budget));
}

void test_budget_does_not_grow_splats_for_unknown_effects(test_state* test)
{
    lavish_machine m = {.fixed_ms = 4.0, .detail_ms = 6.0, .occlusion_ms = 60.0, .layer_ms = 80.0};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 33.0);
    float first = stp_budget_splat_size(&budget);
    for (uint64_t frame = 0; frame < 120; ++frame) {
        stp_frame_cost cost = draw_lavish(&budget, &m, frame);
        CHECK(cost.splat_size <= first && (frame < 3 || cost.milliseconds < 36.0));
    }
    CHECK(stp_budget_splat_size(&budget) < 1.1f);
}

void test_budget_is_never_coarser_without_gain(test_state* test)
{
    // whatever the budget, a fixed time cannot be reduced by larger splats
    for (int i = 0; i < 4; ++i) {
        lavish_machine m = {.fixed_ms = 15.0 + 20.0 * (double)i, .detail_ms = 1.0, .noise = 0.03};
        stp_budget budget;
        stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 20.0);
        double size = 0.0;
        for (uint64_t frame = 0; frame < 400; ++frame) {
            stp_frame_cost cost = draw_lavish(&budget, &m, frame);
            size += frame >= 200 ? (double)cost.splat_size / 200.0 : 0.0;
        }
        CHECK(size < 1.2);
    }
}

// Finer splats that took no longer once may do so later, however slowly the content grows.
void test_budget_gives_finer_splats_up_when_they_cost(test_state* test)
{
    lavish_machine m = {.fixed_ms = 35.0, .noise = 0.01};
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, 20.0);
    double slowest = 0.0;
    for (uint64_t frame = 0; frame < 3000; ++frame) {
        m.detail_ms = frame < 300 ? 1.0 : fmin(exp(0.003 * (double)(frame - 300)), 200.0);
        stp_frame_cost cost = draw_lavish(&budget, &m, frame);
        slowest = frame > 2800 ? fmax(slowest, cost.milliseconds) : slowest;
    }
    CHECK(slowest < 60.0); // of 236 at a pixel
}
