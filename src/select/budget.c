// SPDX-License-Identifier: MIT
// The controllers: sizes of splats, resolutions, and jumps.
#include "select/budget_parts.h"

#include <assert.h>

// Brandt 4.3: no change while the frame time is within [0.9, 1.1] of the budget
#define DEAD_BAND 0.1

#define SIGMAS 1.6         // 19 of 20 frames should stay within OVERSHOOT
#define OVERSHOOT 1.1      // accepted frame time, relative to the budget
#define FASTEST_FINER 0.92 // limit on shrinking per frame: shrinking too far makes a frame late
// the same after a size that was guessed from the list of another place, and may be far too large
#define GUESSED_FINER 0.4
// limit on growing per frame: far too large sizes may cost as much as a good one, and then persist
#define FASTEST_COARSER 1.5
// Sizes shrink more slowly above this scatter: a view that empties suddenly can fill as suddenly.
#define SURE 0.05
#define SLOWEST 0.4 // minimum share of the pace
// exponent limit of the frame time as splats shrink: spare time may be used immediately
#define MAX_EXPONENT 2.5
#define TRIAL_AFTER 40  // late frames in a row before finer splats are tried
#define TRIAL_PAUSE 120 // frames after a trial that failed
#define TRIAL_LOSS 1.06 // factor on the time that finer splats may take
#define TRIAL_FOLLOWS 0.05
#define TRIAL_NOISE 1.03   // times of a trial rise by no more than this
#define SURPRISE 1.1       // limit on the work of a list, relative to the time wanted for it
#define LEAST_SURPRISE 0.2 // and to the budget
#define FORESIGHT 0.8      // share of the time after a jump: occlusion is not known yet
#define MOST_GROWN 2.0     // limit on what pixels are thought to grow with a list

void stp_budget_init(stp_budget* budget, stp_controller controller, double budget_ms)
{
    *budget = (stp_budget){
        .controller = controller,
        .budget_ms = budget_ms > 0.0 ? budget_ms : 1.0,
        .coarseness = controller == STP_CONTROLLER_PAPER ? 1.0f : 0.5f * STP_SPLAT_SIZE_MAX,
        .coarsest = (double)STP_SPLAT_SIZE_COARSEST,
    };
    stp_budget_init_model(budget);
}

void stp_budget_lower_resolution(stp_budget* budget)
{
    budget->coarsest = budget->controller == STP_CONTROLLER_PREDICT
                           ? (double)STP_SPLAT_SIZE_COARSEST / STP_RESOLUTION_MIN
                           : budget->coarsest;
}

float stp_budget_resolution(const stp_budget* budget)
{
    return (float)stp_coarseness_resolution((double)budget->coarseness);
}

float stp_budget_splat_size(const stp_budget* budget)
{
    double coarseness = (double)budget->coarseness, full = (double)STP_SPLAT_SIZE_COARSEST;
    return (float)(stp_mind(coarseness, full) * stp_coarseness_resolution(coarseness));
}

uint32_t stp_budget_left_out(const stp_budget* budget)
{
    uint32_t bits = 0;
    for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
        bits |= budget->effects[i].left_out ? 1u << i : 0u;
    }
    return bits;
}

bool stp_budget_has_decided(const stp_budget* budget)
{
    return budget->calm_frames == 0;
}

static float clamp_size(double size, double maximum)
{
    return (float)stp_clampd(size, (double)STP_SPLAT_SIZE_MIN, maximum);
}

// Moving average of the last three sizes, weighted by the lateness of the last frame.
static void react(stp_budget* b, const stp_frame_cost* cost)
{
    b->sizes[b->frames % STP_BUDGET_AVERAGED] = cost->splat_size;
    uint64_t known = b->frames + 1 < STP_BUDGET_AVERAGED ? b->frames + 1 : STP_BUDGET_AVERAGED;
    double old = 0.0;
    for (uint64_t i = 0; i < known; ++i) {
        old += (double)b->sizes[i] / (double)known;
    }
    double deviation = cost->milliseconds / b->budget_ms;
    if (deviation < 1.0 - DEAD_BAND || deviation > 1.0 + DEAD_BAND) {
        b->coarseness = clamp_size((old * 3.0 + old * deviation) / 4.0, (double)STP_SPLAT_SIZE_MAX);
    }
}

// Smallest factor on the last size that keeps the next frame in time. Sizes shrink slowly, as the
// model may be wrong; but if each of the last frames left time over, that time bounds the factor.
// (A single frame is not enough: a view that empties suddenly can fill as suddenly.)
static double find_finest(const stp_budget* b, double goal)
{
    uint64_t known = b->frames < STP_BUDGET_RATIOS ? b->frames : STP_BUDGET_RATIOS;
    double slowest = 0.0;
    for (uint64_t i = 0; i < known; ++i) {
        slowest = fmax(slowest, b->times[i]);
    }
    double steady = pow(FASTEST_FINER, stp_clampd(SURE / b->scatter, SLOWEST, 1.0));
    return known < STP_BUDGET_RATIOS ? steady
                                     : fmin(steady, pow(slowest / goal, 1.0 / MAX_EXPONENT));
}

// Largest factor on the last size. A model that is still wrong after a slow period must not enlarge
// splats while frames are in time.
static double find_coarsest(const stp_budget* b, double milliseconds)
{
    double expected = milliseconds * exp(fmax(b->trend, 0.0));
    double late = OVERSHOOT * (1.0 + SIGMAS * fmin(b->scatter, STP_BUDGET_MAX_SCATTER)) * expected;
    return stp_clampd(late / stp_budget_time_for_detail(b), 1.0, FASTEST_COARSER);
}

/// If no size meets the budget, larger splats may be no faster, but the model cannot know that
/// while the size stays the same. So finer splats are tried, and kept as long as they take no more
/// time.
/// @param size  that the model chooses  @return the size to use
static double try_finer(stp_budget* b, const stp_frame_cost* cost, double size)
{
    bool late = cost->milliseconds > OVERSHOOT * stp_budget_time_for_detail(b);
    double middle = stp_budget_middle(b->times), used = (double)cost->splat_size;
    bool fails = b->trial_ms > 0.0 && middle > TRIAL_LOSS * b->trial_ms;
    if (!late || fails) {
        b->late_frames = late ? -TRIAL_PAUSE : 0;
        b->trial_ms = 0.0;
        return size;
    }
    b->late_frames += 1;
    if (!(b->trial_ms > 0.0) && b->late_frames >= TRIAL_AFTER) {
        b->trial_ms = middle;
        b->trial_limit_ms = middle * TRIAL_NOISE;
    }
    if (b->trial_ms > 0.0 &&
        used <= (double)STP_SPLAT_SIZE_MIN) { // it succeeded: averages the noise of frames
        double follows = b->trial_ms + TRIAL_FOLLOWS * (middle - b->trial_ms);
        b->trial_ms = fmin(follows, b->trial_limit_ms); // not content that grows slowly
    }
    return b->trial_ms > 0.0 ? fmin(size, used * FASTEST_FINER) : size;
}

/// Share of the time that a forecast may take, so that most frames are in time.
static double find_margin(const stp_budget* b)
{
    double scatter = b->scatter < STP_BUDGET_MAX_SCATTER ? b->scatter : STP_BUDGET_MAX_SCATTER;
    double margin = OVERSHOOT / (1.0 + SIGMAS * 1.25 * scatter); // converts mean deviation to sigma
    return fmin(margin, 1.0);
}

/// `cost` is without effects.
static void predict(stp_budget* b, const stp_frame_cost* cost)
{
    bool guessed = b->foreseen;
    stp_budget_learn(b, cost);
    b->foreseen = false;
    b->last = *cost;
    double margin = find_margin(b) * exp(-fmax(b->trend, 0.0));
    b->times[b->frames % STP_BUDGET_RATIOS] = cost->milliseconds;
    b->frames += 1;
    double solved = stp_budget_leave_effects(b, margin);
    double finer = guessed ? GUESSED_FINER : find_finest(b, margin * stp_budget_time_for_detail(b));
    double size = fmax(solved, (double)cost->splat_size * finer);
    size = fmin(size, (double)cost->splat_size * find_coarsest(b, cost->milliseconds));
    size = try_finer(b, cost, size);
    b->coarseness = clamp_size(size, b->coarsest);
    stp_budget_return_effect(b, margin);
}

stp_work_limit stp_budget_limit(const stp_budget* b)
{
    const double next = (double)b->coarseness;
    if (b->controller != STP_CONTROLLER_PREDICT || b->frames == 0 || next >= b->coarsest) {
        return (stp_work_limit){0};
    }
    double expected = stp_budget_predict(b, next), listed = stp_budget_predict_list(b, next);
    double wanted = fmax(expected, stp_budget_time_for_detail(b));
    // pixels grow with the list; where most of the last one was hidden, only what is new takes time
    double longest = SURPRISE * wanted;
    double most = expected > 0.0 ? longest * fmin(listed / expected, 1.0) : 0.0;
    most += fmax(listed - expected, 0.0);
    stp_work_limit limit = stp_budget_list_prices(b);
    limit.most = fmax(most, LEAST_SURPRISE * b->budget_ms);
    return limit;
}

void stp_budget_foresee(stp_budget* b, const stp_frame_cost* listed)
{
    assert(b->frames > 0 && "a frame was within the limit");
    const stp_work_limit prices = stp_budget_list_prices(b);
    double before = stp_budget_predict_list(b, stp_coarseness_of(listed));
    double triangles = (double)listed->listed_triangles;
    double now = prices.splat * (double)listed->splats + prices.triangle * triangles +
                 prices.item * (double)listed->draw_calls;
    double grown = before > 0.0 ? stp_clampd(now / before, 1.0, MOST_GROWN) : MOST_GROWN;
    b->last.splats = listed->splats;
    b->last.triangles = (uint64_t)(stp_budget_drawn_share(b) * triangles);
    b->last.listed_triangles = listed->listed_triangles;
    b->last.draw_calls = listed->draw_calls;
    b->last.fragments = (uint64_t)(grown * (double)b->last.fragments);
    b->last.covered_pixels = (uint64_t)(grown * (double)b->last.covered_pixels);
    b->last.splat_size = (float)stp_coarseness_of(listed);
    b->last.resolution = listed->resolution;
    b->foreseen = true;
    double solved = stp_budget_solve(b, FORESIGHT * find_margin(b) * stp_budget_time_for_detail(b));
    b->coarseness = clamp_size(fmax((double)b->coarseness, solved), b->coarsest);
}

void stp_budget_update(stp_budget* b, const stp_frame_cost* cost)
{
    if (!(cost->milliseconds > 0.0 && cost->milliseconds < 1e9 && cost->splat_size > 0.0f)) {
        return;
    }
    if (b->controller == STP_CONTROLLER_PAPER) {
        react(b, cost);
        b->last = *cost;
        b->frames += 1;
    } else {
        stp_frame_cost own = *cost;
        own.splat_size = (float)stp_coarseness_of(cost);
        for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
            own.milliseconds -= fmax(cost->effect_ms[i], 0.0);
        }
        own.milliseconds = fmax(own.milliseconds, 0.01 * cost->milliseconds);
        stp_budget_learn_effects(b, cost, own.milliseconds);
        predict(b, &own);
    }
    assert(b->coarseness >= STP_SPLAT_SIZE_MIN && (double)b->coarseness <= b->coarsest);
}
