// SPDX-License-Identifier: MIT
// Parts of a budget. The model prices the counts of frames; effects are judged with it, and the
// controllers (budget.c) choose sizes with both.
#pragma once

#include "select/coarseness.h"

/// Limit relative to recent frames: a single frame teaches no more.
#define STP_BUDGET_SLOW_FRAME 1.3
/// Maximum scatter of forecasts that counts.
#define STP_BUDGET_MAX_SCATTER 0.25

/// The middle one of three numbers.
static inline double stp_budget_middle(const double v[STP_BUDGET_RATIOS])
{
    double low = fmin(v[0], v[1]), high = fmax(v[0], v[1]);
    return fmax(low, fmin(high, v[2]));
}

// The model (budget_model.c).

/// Sets the initial prices and exponents.
void stp_budget_init_model(stp_budget* b);

/// Learns from a frame without effects, and from how it differs from the forecast.
void stp_budget_learn(stp_budget* b, const stp_frame_cost* cost);

/// Share of the listed triangles that are drawn, if the list is not like the last one.
double stp_budget_drawn_share(const stp_budget* b);

/// Milliseconds of each count of a list that is not like the last one: splats, triangles and draws.
stp_work_limit stp_budget_list_prices(const stp_budget* b);

/// What the next list would take at these prices, if it is like the last one.
double stp_budget_predict_list(const stp_budget* b, double coarseness);

/// Size at which the model, which never rises with size, meets the goal. If no size does, does not
/// enlarge splats for a negligible gain.
double stp_budget_solve(const stp_budget* b, double goal);

// Effects (budget_effects.c).

/// Learns the times of a frame's effects; `own_ms` is its time without them. A single slow frame
/// counts as in the model's speed.
void stp_budget_learn_effects(stp_budget* b, const stp_frame_cost* cost, double own_ms);

/// The part of the budget that the next frame's effects leave. Unknown effects do not make splats
/// larger.
double stp_budget_time_for_detail(const stp_budget* b);

/// Leaves effects out while splats would be larger because of them: as many as necessary, in their
/// order. @param margin  factor on the time for detail
/// @return the size for which there is time beside the others, however large its change
double stp_budget_leave_effects(stp_budget* b, double margin);

/// Takes back the effect that was left out last, once there was time for it during some frames.
/// @param margin  factor on the time for detail
void stp_budget_return_effect(stp_budget* b, double margin);
