// SPDX-License-Identifier: MIT
// Jumps of the camera: a budget looks at the next frame's list before it is drawn.
#include "tests.h"

#include "select/budget.h"

#include <math.h>

#define BUDGET_MS 33.0

/// A frame at a place with so many million triangles at a size of 4 pixels, in a picture of a
/// million pixels of which a part is covered. Larger splats save a part of the triangles.
static stp_frame_cost run_place(double millions, double covered, float size, float resolution)
{
    double area = (double)resolution * (double)resolution;
    double triangles = millions * pow(4.0 / (double)size, 0.6) * (double)resolution;
    double fragments = 4.0 * covered * area, pixels = covered * area;
    return (stp_frame_cost){
        .milliseconds = 1.0 + 6.0 * triangles + 1.5 * fragments + 6.0 * pixels,
        .triangles = (uint64_t)(1e6 * triangles),
        .fragments = (uint64_t)(1e6 * fragments),
        .covered_pixels = (uint64_t)(1e6 * pixels),
        .draw_calls = (uint32_t)(1000.0 * triangles),
        .splat_size = size,
        .resolution = resolution,
    };
}

static double work_of(const stp_work_limit* limit, const stp_frame_cost* cost)
{
    return limit->splat * (double)cost->splats + limit->triangle * (double)cost->triangles +
           limit->item * (double)cost->draw_calls;
}

typedef struct outcome {
    int late, refused;
    double worst; ///< over the budget
} outcome;

/// 40 stays of 12 frames at places in turn, the second of each pair of places being heavier.
static outcome fly(double heavier, bool looks)
{
    stp_budget budget;
    outcome out = {0};
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
    stp_budget_lower_resolution(&budget);
    for (int frame = 0; frame < 40 * 12; ++frame) {
        bool heavy = frame / 12 % 2 == 1;
        double millions = heavy ? 1.5 * heavier : 1.5, covered = heavy ? 0.8 : 0.4;
        stp_work_limit limit = stp_budget_limit(&budget);
        stp_frame_cost cost = run_place(millions, covered, stp_budget_splat_size(&budget),
                                        stp_budget_resolution(&budget));
        if (looks && limit.most > 0.0 && work_of(&limit, &cost) > limit.most) {
            stp_frame_cost listed = cost;
            listed.listed_triangles = listed.triangles;
            listed.fragments = listed.covered_pixels = listed.triangles = 0;
            listed.milliseconds = 1.0;
            stp_budget_foresee(&budget, &listed);
            cost = run_place(millions, covered, stp_budget_splat_size(&budget),
                             stp_budget_resolution(&budget));
            cost.milliseconds += listed.milliseconds;
            out.refused += 1;
        }
        double over = cost.milliseconds / BUDGET_MS;
        if (frame >= 12) { // the first place is new in any case
            out.late += over > 1.15;
            out.worst = fmax(out.worst, over);
        }
        stp_budget_update(&budget, &cost);
    }
    return out;
}

void test_budget_foresees_jumps(test_state* test)
{
    const double heavier[] = {1.6, 2.5, 4.0};
    for (int i = 0; i < 3; ++i) {
        outcome with = fly(heavier[i], true), without = fly(heavier[i], false);
        CHECK(without.late >= 20 && without.worst > 1.3); // at each jump to a heavier place
        CHECK(with.late == 0 && with.worst < 1.2);
        CHECK_EQUAL(20, with.refused); // nothing but jumps
    }
}

/// A frame before a wall: so many million triangles are listed, and a fiftieth of them is drawn.
/// Without the wall twice to eight times as many are listed at a size of 1 pixel, and 0.7 of them
/// are drawn.
static stp_frame_cost run_behind(double hidden, double times, bool wall, float size,
                                 float resolution)
{
    double area = (double)resolution * (double)resolution;
    double fall = pow(1.0 / (double)size, 0.8) * sqrt((double)resolution);
    double listed = hidden * (wall ? 1.0 : times * fall);
    double drawn = (wall ? 0.02 : 0.7) * listed, fragments = (wall ? 2.0 : 4.0) * area;
    return (stp_frame_cost){
        .milliseconds = 1.0 + 14.0 * drawn + 1.5 * fragments + 8.0 * area,
        .triangles = (uint64_t)(1e6 * drawn),
        .listed_triangles = (uint64_t)(1e6 * listed),
        .fragments = (uint64_t)(1e6 * fragments),
        .covered_pixels = (uint64_t)(1e6 * area),
        .draw_calls = (uint32_t)(100.0 * listed),
        .splat_size = size,
        .resolution = resolution,
    };
}

// When a wall leaves the view, the triangles behind it cost what triangles cost before they were
// hidden, however many hidden ones were listed meanwhile for nothing.
void test_budget_foresees_what_was_hidden(test_state* test)
{
    for (int k = 0; k < 6; ++k) {
        double hidden = k % 2 == 0 ? 1.0 : 3.0, times = k < 2 ? 2.0 : k < 4 ? 5.0 : 8.0;
        stp_budget budget;
        stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
        stp_budget_lower_resolution(&budget);
        for (int frame = 0; frame < 400; ++frame) {
            bool wall = frame >= 100 && frame % 100 < 80;
            stp_work_limit limit = stp_budget_limit(&budget);
            stp_frame_cost cost = run_behind(hidden, times, wall, stp_budget_splat_size(&budget),
                                             stp_budget_resolution(&budget));
            stp_frame_cost listed = cost;
            listed.triangles = listed.fragments = listed.covered_pixels = 0;
            double work = limit.triangle * (double)listed.listed_triangles +
                          limit.item * (double)listed.draw_calls;
            bool refused = limit.most > 0.0 && work > limit.most;
            if (refused) {
                stp_budget_foresee(&budget, &listed);
                cost = run_behind(hidden, times, wall, stp_budget_splat_size(&budget),
                                  stp_budget_resolution(&budget));
            }
            CHECK(frame < 100 || cost.milliseconds < 1.2 * BUDGET_MS);
            CHECK(frame < 100 || !refused || frame % 100 == 80 || frame % 100 == 0); // changes
            stp_budget_update(&budget, &cost);
        }
    }
}

/// Frames of a still camera that are refused after the first 40 of 1,400. Splats or triangles take
/// 20 ms at a size of 4 pixels and fall with the size by an exponent; pixels take a fixed time.
static int count_refused(bool splats, double exponent, double pixel_ms)
{
    stp_budget budget;
    int refused = 0;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
    stp_budget_lower_resolution(&budget);
    for (int frame = 0; frame < 1400; ++frame) {
        stp_work_limit limit = stp_budget_limit(&budget);
        for (int attempt = 0; attempt < 2; ++attempt) {
            double resolution = (double)stp_budget_resolution(&budget),
                   area = resolution * resolution;
            double size = (double)stp_budget_splat_size(&budget) / resolution;
            double share = pow(4.0 / size, exponent) * (splats ? 1.0 : resolution);
            stp_frame_cost cost = {
                .milliseconds = 20.0 * share + pixel_ms * area,
                .splats = splats ? (uint64_t)(3e6 * share) : 0,
                .triangles = splats ? 0 : (uint64_t)(3e6 * share),
                .covered_pixels = (uint64_t)(1e5 * pixel_ms * area),
                .draw_calls = 500,
                .splat_size = (float)(size * resolution),
                .resolution = (float)resolution,
            };
            if (attempt > 0 || !(work_of(&limit, &cost) > limit.most)) {
                stp_budget_update(&budget, &cost);
                break;
            }
            cost.listed_triangles = cost.triangles;
            cost.fragments = cost.covered_pixels = cost.triangles = 0;
            stp_budget_foresee(&budget, &cost);
            refused += frame >= 40;
        }
    }
    return refused;
}

void test_budget_refuses_nothing_of_a_still_camera(test_state* test)
{
    for (int splats = 0; splats < 2; ++splats) {
        for (double exponent = 0.6; exponent <= 2.0; exponent += 0.35) {
            for (double pixel_ms = 0.0; pixel_ms <= 20.0; pixel_ms += 5.0) {
                CHECK(count_refused(splats != 0, exponent, pixel_ms) <= 2);
            }
        }
    }
}

void test_budget_refuses_nothing_without_jumps(test_state* test)
{
    CHECK_EQUAL(0, fly(1.0, true).refused);
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
    CHECK(stp_budget_limit(&budget).most == 0.0); // nothing is known
    stp_frame_cost cost = run_place(1.5, 0.8, stp_budget_splat_size(&budget), 1.0f);
    stp_budget_update(&budget, &cost);
    CHECK(stp_budget_limit(&budget).most > 0.0);
    budget.coarseness = STP_SPLAT_SIZE_COARSEST;
    CHECK(stp_budget_limit(&budget).most == 0.0); // nothing is coarser
    stp_budget_lower_resolution(&budget);
    CHECK(stp_budget_limit(&budget).most > 0.0);
    stp_budget_init(&budget, STP_CONTROLLER_PAPER, BUDGET_MS);
    cost = run_place(1.0, 0.8, 1.0f, 1.0f);
    stp_budget_update(&budget, &cost);
    CHECK(stp_budget_limit(&budget).most == 0.0);
}

// A list that is only surprising never makes splats finer, and an empty frame before it is no
// reason to refuse the next one.
void test_budget_foresight_is_never_finer(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
    stp_frame_cost nothing = {.milliseconds = 0.5, .splat_size = 1.0f, .resolution = 1.0f};
    stp_budget_update(&budget, &nothing);
    stp_work_limit limit = stp_budget_limit(&budget);
    CHECK(limit.most > 0.0 && limit.most <= 2.0 * BUDGET_MS && limit.triangle > 0.0);
    for (int i = 0; i < 12; ++i) {
        float before = stp_budget_splat_size(&budget);
        stp_frame_cost listed = run_place(pow(2.0, (double)(i - 6)), 0.0, before, 1.0f);
        listed.listed_triangles = listed.triangles;
        stp_budget_foresee(&budget, &listed);
        CHECK(stp_budget_splat_size(&budget) >= before);
    }
    CHECK(stp_budget_splat_size(&budget) > 4.0f);
}

// A size that was chosen from a list alone may be far too large. The frame shows it, and the next
// size is not bound to the slow pace at which splats shrink otherwise.
void test_budget_corrects_a_guess_at_once(test_state* test)
{
    stp_budget budget;
    stp_budget_init(&budget, STP_CONTROLLER_PREDICT, BUDGET_MS);
    for (int frame = 0; frame < 60; ++frame) {
        stp_frame_cost cost = run_place(1.5, 0.8, stp_budget_splat_size(&budget), 1.0f);
        stp_budget_update(&budget, &cost);
    }
    float settled = stp_budget_splat_size(&budget);
    stp_frame_cost listed = run_place(9.0, 0.8, settled, 1.0f);
    listed.listed_triangles = listed.triangles;
    listed.fragments = listed.covered_pixels = listed.triangles = 0;
    stp_budget_foresee(&budget, &listed);
    float guessed = stp_budget_splat_size(&budget);
    CHECK(guessed > 2.0f * settled);
    stp_frame_cost cost = run_place(1.5, 0.8, guessed, 1.0f); // all that was new is hidden
    stp_budget_update(&budget, &cost);
    CHECK(stp_budget_splat_size(&budget) < 0.6f * guessed);
}
