// SPDX-License-Identifier: MIT
//
// Frame-time budget: chooses the splat size that keeps frames within a time. Two controllers: the
// paper's reactive one (Brandt 4.3), and a predictive one. Plain data without allocations; a budget
// belongs to one thread.
#pragma once

#include "base/math/math.h"
#include "select/select.h"

typedef enum stp_controller {
    STP_CONTROLLER_PREDICT,
    STP_CONTROLLER_PAPER, ///< Brandt 4.3 as printed
} stp_controller;

#define STP_SPLAT_SIZE_MIN 1.0f
#define STP_SPLAT_SIZE_MAX 8.0f ///< the paper's
/// for the predictive controller, if the budget cannot be met otherwise
#define STP_SPLAT_SIZE_COARSEST 24.0f
/// Least share of the picture's width and height that a budget draws, in steps of 1/16; splats then
/// keep their size in the whole picture
#define STP_RESOLUTION_MIN 0.25

/// Effects of a frame that a budget leaves out before splats grow, in the order in which it does
/// so.
typedef enum stp_budget_effect {
    STP_EFFECT_OCCLUSION,    ///< ambient occlusion
    STP_EFFECT_ANTIALIASING, ///< all samples of a pixel but one
    STP_EFFECT_LAYERS,       ///< all layers of transparent surfaces, instead of the nearest one
    STP_EFFECT_NEAREST,      ///< the nearest layer, instead of a pattern of pixels
    STP_EFFECT_COUNT
} stp_budget_effect;

/// Measurements of a frame.
typedef struct stp_frame_cost {
    double milliseconds;
    uint64_t splats, fragments, triangles, covered_pixels;
    /// Drawn triangles, and those that were found to be hidden or out of view; fewer than
    /// `triangles`: as many
    uint64_t listed_triangles;
    uint32_t draw_calls;
    float splat_size; ///< as used
    float resolution; ///< likewise: share of the picture's width and height; 0: all of it
    /// Parts of the time: what a frame without the effects before this one would have saved by
    /// leaving it out, too. 0: it was not drawn
    double effect_ms[STP_EFFECT_COUNT];
    uint32_t unwanted; ///< effects that nobody asked for now, as bits 1 << stp_budget_effect
} stp_frame_cost;

/// Share of the picture's width and height that a frame drew; 1: all.
static inline double stp_frame_resolution(const stp_frame_cost* cost)
{
    return cost->resolution > 0.0f && cost->resolution < 1.0f ? (double)cost->resolution : 1.0;
}

/// Size of a frame's splats in pixels of the whole picture.
static inline double stp_frame_splat_size(const stp_frame_cost* cost)
{
    return (double)cost->splat_size / stp_frame_resolution(cost);
}

enum {
    STP_BUDGET_TERMS = 5,    ///< splats, fragments, triangles, draws, covered pixels
    STP_BUDGET_AVERAGED = 3, ///< frames whose splat size the paper averages
    /// Number of recent frames whose median tracks changes of machine and scene
    STP_BUDGET_RATIOS = 3,
};

/// What a budget knows of an effect.
typedef struct stp_budget_effect_state {
    double ms; ///< when it was last drawn, as at the whole resolution; 0: it was not wanted
    double
        share; ///< its time then, relative to the rest of the frame without the effects before it
    double pixels;   ///< covered then, at the whole resolution
    uint32_t frames; ///< in a row that had it
    bool left_out;
} stp_budget_effect_state;

typedef struct stp_budget {
    stp_controller controller;
    double budget_ms;
    uint64_t frames; ///< number of frames learned from
    float sizes[STP_BUDGET_AVERAGED];
    /// Size of splats; beyond STP_SPLAT_SIZE_COARSEST, that over the resolution
    float coarseness;
    double coarsest;                 ///< maximum of it
    stp_frame_cost last;             ///< splat_size: its coarseness
    double times[STP_BUDGET_RATIOS]; ///< milliseconds of the last frames
    // The model: milliseconds per unit of each term, and their covariance.
    double price[STP_BUDGET_TERMS];
    double covariance[STP_BUDGET_TERMS][STP_BUDGET_TERMS];
    double speed;   ///< recent ratio of measured to predicted time: other load on the machine
    double trend;   ///< logarithm of new content: the priced counts of a frame over its forecast
    double scatter; ///< mean deviation of log(measured / forecast) from `trend`
    /// Exponents by which counts fall with splat size; fragments may rise (negative).
    double splat_exponent, fragment_exponent, triangle_exponent;
    double ratios[STP_BUDGET_RATIOS]; ///< ratios of measured to expected time for a frame's counts
    /// Logarithms of the expected time for counts over the forecast
    double growth[STP_BUDGET_RATIOS];
    // Trial of finer splats: frames in a row that were late (negative: a trial waits), and the time
    // that it must keep (0: there is none)
    int32_t late_frames;
    double trial_ms;
    double trial_limit_ms; ///< what it may rise to
    stp_budget_effect_state effects[STP_EFFECT_COUNT];
    uint32_t calm_frames; ///< in a row that would have had time for the effect that returns next
    uint64_t returned;    ///< frame after which an effect returned last
    uint32_t patience;    ///< how often effects left soon after they had returned
    bool foreseen;        ///< `last` has counts of the next frame's list
} stp_budget;

/// `budget_ms` above 0.
void stp_budget_init(stp_budget* budget, stp_controller controller, double budget_ms);

/// Lets the predictive controller lower the resolution of pictures where the coarsest splats do not
/// meet the budget. Call after stp_budget_init.
void stp_budget_lower_resolution(stp_budget* budget);

/// Share of the next frame's width and height that is drawn: STP_RESOLUTION_MIN to 1.
float stp_budget_resolution(const stp_budget* budget);

/// Size for the next frame, in pixels as drawn: between STP_SPLAT_SIZE_MIN and STP_SPLAT_SIZE_MAX, or
/// STP_SPLAT_SIZE_COARSEST.
float stp_budget_splat_size(const stp_budget* budget);

/// Effects that the next frame must not have, as bits 1 << stp_budget_effect. Splats grow after all
/// of them are left out. 0 with the paper's controller.
uint32_t stp_budget_left_out(const stp_budget* budget);

/// Whether no effect is about to return.
bool stp_budget_has_decided(const stp_budget* budget);

/// Call after each frame. Ignores a frame whose time or splat size is not positive, or whose time
/// is 10^9 ms or more.
void stp_budget_update(stp_budget* budget, const stp_frame_cost* cost);

/// What the next frame may have to draw: more than that means another place than the last frame's,
/// as after a jump of the camera, or that something large has left the view of what it hid. So it is
/// better not drawn before stp_budget_foresee. No limit if nothing is coarser.
stp_work_limit stp_budget_limit(const stp_budget* budget);

/// Chooses the splat size and resolution of the next frame anew, from the counts of its list, which
/// exceeded the limit: `listed` has splats, listed triangles, draw calls, and the size and
/// resolution of this list. Call before the frame is drawn again, and stp_budget_update after it.
void stp_budget_foresee(stp_budget* budget, const stp_frame_cost* listed);

/// Predicted time of a frame like the last one at another size of splats (stp_budget.coarseness),
/// without effects, in milliseconds. 0 before the first frame.
double stp_budget_predict(const stp_budget* budget, double coarseness);
/// The same with all effects that are wanted, whether or not they are left out, but those of
/// `without`, as bits 1 << stp_budget_effect.
double stp_budget_predict_whole(const stp_budget* budget, double splat_size, uint32_t without);
