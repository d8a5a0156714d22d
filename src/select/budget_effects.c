// SPDX-License-Identifier: MIT
// Effects of frames within a budget: they are left out before splats grow, and come back.
#include "select/budget_parts.h"

#define EFFECT_SHARE 0.05 // effects that take less of the budget are never left out
#define EFFECT_MOST 0.75  // nor others while splats are fine, unless all take more than this
#define EFFECT_ROOM 0.9   // share of the budget that they, with the finest splats, must fit
#define EFFECT_FRAMES 15  // for so many frames, before the next one returns
#define EFFECT_STAYS 300  // an effect that leaves within so many frames comes and goes:
#define EFFECT_PATIENCE 3 // each time, up to so often, the next return takes four times as long
// Frames with an effect before it is judged. The first frame is cold, but many samples or layers
// may take so long that a second one is not worth it.
static const uint32_t effect_proof[STP_EFFECT_COUNT] = {3, 1, 1, 3};
// Splats up to these sizes count as fine beside an effect. Instead of the nearest layer there is a
// pattern, which shows nearly as much: it is not worth larger splats.
static const double effect_size[STP_EFFECT_COUNT] = {1.5, 1.5, 1.5, 1.1};

/// The time of an effect in a frame that covers so many pixels, at the whole resolution, and is
/// drawn at another.
static double expect_effect(const stp_budget_effect_state* e, double covered_pixels,
                            double resolution)
{
    double whole = resolution * resolution * e->ms;
    return covered_pixels < e->pixels ? whole * covered_pixels / e->pixels : whole;
}

/// Pixels that a frame would have covered at the whole resolution.
static double whole_pixels(const stp_frame_cost* cost)
{
    double resolution = stp_frame_resolution(cost);
    return (double)cost->covered_pixels / (resolution * resolution);
}

void stp_budget_learn_effects(stp_budget* b, const stp_frame_cost* cost, double own_ms)
{
    double rest = own_ms;
    for (int i = STP_EFFECT_COUNT; i-- > 0;) {
        stp_budget_effect_state* e = &b->effects[i];
        if ((cost->unwanted >> i & 1u) != 0) {
            *e = (stp_budget_effect_state){0}; // it is judged anew once it is wanted again
            continue;
        }
        if (e->left_out) {
            continue;
        }
        // as at the whole resolution
        double resolution = stp_frame_resolution(cost), pixels = whole_pixels(cost);
        double ms = cost->effect_ms[i] / (resolution * resolution);
        bool known = e->ms > 0.0 && e->frames >= effect_proof[i];
        double most = known ? STP_BUDGET_SLOW_FRAME * expect_effect(e, pixels, 1.0) : ms;
        e->ms = fmin(ms, fmax(most, 0.01 * b->budget_ms));
        e->share = cost->effect_ms[i] / rest;
        e->pixels = pixels;
        e->frames = cost->effect_ms[i] > 0.0 ? e->frames + 1 : 0;
        rest += cost->effect_ms[i];
    }
}

/// Whether an effect is drawn, and known well enough to be judged.
static bool is_judged(const stp_budget* b, int effect)
{
    const stp_budget_effect_state* e = &b->effects[effect];
    return !e->left_out && e->frames >= effect_proof[effect];
}

/// The part of the budget that effects leave: those that are judged, and the one of number `more`.
static double time_beside(const stp_budget* b, int more)
{
    double left = b->budget_ms, resolution = stp_frame_resolution(&b->last);
    for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
        const stp_budget_effect_state* e = &b->effects[i];
        if (i == STP_EFFECT_ANTIALIASING && (i == more || is_judged(b, i))) {
            left /= 1.0 + e->share;
        } else if (i == more) {
            left -= expect_effect(e, whole_pixels(&b->last), resolution);
        } else if (is_judged(b, i)) {
            left -= resolution * resolution * e->ms;
        }
    }
    return fmax(left, (1.0 - EFFECT_MOST) * b->budget_ms);
}

double stp_budget_time_for_detail(const stp_budget* b)
{
    return time_beside(b, STP_EFFECT_COUNT);
}

double stp_budget_leave_effects(stp_budget* b, double margin)
{
    double size = stp_budget_solve(b, margin * stp_budget_time_for_detail(b));
    for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
        double sum = 0.0;
        for (int k = 0; k < STP_EFFECT_COUNT; ++k) {
            sum += is_judged(b, k) ? b->effects[k].ms : 0.0;
        }
        bool dear = b->effects[i].ms > EFFECT_SHARE * b->budget_ms;
        bool alone = i != STP_EFFECT_NEAREST || b->effects[STP_EFFECT_LAYERS].left_out;
        if (is_judged(b, i) && dear && alone &&
            (size > effect_size[i] || sum > EFFECT_MOST * b->budget_ms)) {
            b->effects[i].left_out = true;
            b->calm_frames = 0;
            bool soon = b->returned > 0 && b->frames - b->returned < EFFECT_STAYS;
            b->patience = soon ? b->patience + (b->patience < EFFECT_PATIENCE) : 0;
            size = stp_budget_solve(b, margin * stp_budget_time_for_detail(b));
        }
    }
    return size;
}

/// Adds the times of effects, at the whole resolution, to that of a frame without them: of the last
/// one to that of `first`, but those of the bits `without`.
static double add_effects(const stp_budget* b, double milliseconds, int first, uint32_t without)
{
    for (int i = STP_EFFECT_COUNT; i-- > first;) {
        const stp_budget_effect_state* e = &b->effects[i];
        if ((without >> i & 1u) != 0) {
            continue;
        }
        milliseconds += i == STP_EFFECT_ANTIALIASING
                            ? e->share * milliseconds
                            : expect_effect(e, whole_pixels(&b->last), 1.0);
    }
    return milliseconds;
}

double stp_budget_predict_whole(const stp_budget* budget, double splat_size, uint32_t without)
{
    return add_effects(budget, stp_budget_predict(budget, splat_size), 0, without);
}

void stp_budget_return_effect(stp_budget* b, double margin)
{
    int next = STP_EFFECT_COUNT - 1;
    while (next >= 0 && !b->effects[next].left_out) {
        next -= 1;
    }
    double detail = stp_budget_predict(b, (double)STP_SPLAT_SIZE_MIN);
    double wanted = next >= 0 ? add_effects(b, detail, next, 0) : detail;
    // no effect returns that would be left out again
    bool fits = wanted <= EFFECT_ROOM * b->budget_ms &&
                wanted - detail <= EFFECT_ROOM * EFFECT_MOST * b->budget_ms;
    fits = fits && next >= 0 &&
           stp_budget_solve(b, EFFECT_ROOM * margin * time_beside(b, next)) <= effect_size[next];
    b->calm_frames = fits ? b->calm_frames + 1 : 0;
    if (b->calm_frames >= (uint32_t)EFFECT_FRAMES << 2u * b->patience) {
        b->returned = b->frames;
        b->effects[next].left_out = false;
        b->effects[next].frames = 0;
        b->calm_frames = 0;
    }
}
