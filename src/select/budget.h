// SPDX-License-Identifier: MIT
//
// The size of splats that keeps frames within a time. Two controllers: the paper's reactive one (Brandt 4.3), and one that
// predicts. Plain data, nothing is allocated; a budget belongs to one thread.
#pragma once

#include "base/math.h"

typedef enum stp_controller {
    STP_CONTROLLER_PREDICT,
    STP_CONTROLLER_PAPER, ///< Brandt 4.3 as printed
} stp_controller;

#define STP_SPLAT_SIZE_LEAST 1.0f
#define STP_SPLAT_SIZE_MOST 8.0f ///< the paper's
#define STP_SPLAT_SIZE_COARSEST                                                                    \
    24.0f ///< of the predicting controller, where a budget cannot be held otherwise

/// What a frame was and what it took.
typedef struct stp_frame_cost {
    double milliseconds;
    uint64_t splats, fragments, triangles, covered_pixels;
    uint32_t draw_calls;
    float splat_size; ///< in effect
} stp_frame_cost;

enum {
    STP_BUDGET_TERMS = 5,    ///< splats, fragments, triangles, draws, covered pixels
    STP_BUDGET_AVERAGED = 3, ///< frames whose splat size the paper averages
    STP_BUDGET_RATIOS = 3,   ///< frames whose middle one says how the machine and the scene change
};

typedef struct stp_budget {
    stp_controller controller;
    double budget_ms;
    uint64_t frames; ///< learned from
    float sizes[STP_BUDGET_AVERAGED];
    float splat_size;
    stp_frame_cost last;
    double times[STP_BUDGET_RATIOS]; ///< milliseconds of the last frames
    // The model: milliseconds a unit of each term, and how far they are known.
    double price[STP_BUDGET_TERMS];
    double covariance[STP_BUDGET_TERMS][STP_BUDGET_TERMS];
    double speed; ///< measured over predicted, lately: what else the machine does
    double
        trend; ///< logarithm of what comes into view: a frame's counts, priced, over its forecast
    double scatter; ///< of measured over forecast around `trend`: mean deviation
    /// How counts fall with the size of splats; fragments may rise (negative).
    double splat_exponent, fragment_exponent, triangle_exponent;
    double ratios[STP_BUDGET_RATIOS]; ///< of measured to what a frame's counts should take
    double growth[STP_BUDGET_RATIOS]; ///< logarithm of what counts should take over the forecast
} stp_budget;

/// `budget_ms` above 0.
void stp_budget_init(stp_budget* budget, stp_controller controller, double budget_ms);

/// For the next frame: between STP_SPLAT_SIZE_LEAST and STP_SPLAT_SIZE_MOST, or STP_SPLAT_SIZE_COARSEST.
float stp_budget_splat_size(const stp_budget* budget);

/// To be called after each frame. What is not a number or negative is not learned from.
void stp_budget_learn(stp_budget* budget, const stp_frame_cost* cost);

/// What the model expects of a frame like the last one at another size, in milliseconds. 0 before the first frame.
double stp_budget_predict(const stp_budget* budget, double splat_size);
