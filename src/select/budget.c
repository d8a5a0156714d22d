// SPDX-License-Identifier: MIT
#include "select/coarseness.h"

#include <assert.h>

// Brandt 4.3: no change while the frame time is within [0.9, 1.1] of the budget
#define DEAD_BAND 0.1

// Initial prices in milliseconds per million (draws: per thousand), and their uncertainty.
static const double first_price[STP_BUDGET_TERMS] = {8.0, 1.0, 12.0, 2.0, 10.0};
#define FIRST_DOUBT 4.0 // relative to the price
static const double units[STP_BUDGET_TERMS] = {1e-6, 1e-6, 1e-6, 1e-3, 1e-6};

// drift of a price per frame, relative to its initial price: scenes and caches change
#define DRIFT 0.03
#define NOISE 0.1          // standard deviation of a frame's time, relative, from other effects
#define OUTLIER 0.5        // larger relative errors are clamped to this before learning
#define SPEED_FOLLOWS 0.25 // learning rate of the machine's speed
// share of log(speed) moved into the prices per frame: only their product is known
#define SPEED_FADES 0.05
#define SCATTER_FOLLOWS 0.1 // learning rate of the scatter of forecasts
#define MAX_SCATTER 0.25
#define SIGMAS 1.6         // 19 of 20 frames should stay within OVERSHOOT
#define OVERSHOOT 1.1      // accepted frame time, relative to the budget
#define FASTEST_FINER 0.92 // limit on shrinking per frame: shrinking too far makes a frame late
// limit on growing per frame: far too large sizes may cost as much as a good one, and then persist
#define FASTEST_COARSER 1.5
// Sizes shrink more slowly above this scatter: a view that empties suddenly can fill as suddenly.
#define SURE 0.05
#define SLOWEST 0.4 // minimum share of the pace
// exponent limit of the frame time as splats shrink: spare time may be used immediately
#define MAX_EXPONENT 2.5
#define FIRST_SPLAT_EXPONENT 2.0    // as splats cover the whole screen
#define FIRST_FRAGMENT_EXPONENT 0.0 // fewer splats, each of them larger
#define FIRST_TRIANGLE_EXPONENT 1.0
#define EXPONENT_FOLLOWS 0.4
#define SCENE_CHANGES 0.2 // change of log(counts) per frame that the scene alone may cause
// decay of an exponent towards its initial value while the size is constant
#define EXPONENT_FADES 0.01
#define MIN_CHANGE 0.02 // changes of the logarithm of the size below this count as constant
#define SLOW_FRAME 1.3  // limit relative to recent frames: a single frame teaches no more
#define MAX_OFF 0.1     // the same limit for the scatter
// If no size meets the goal: accepted time above the fastest size's, so that splats do not grow for
// a negligible gain.
#define LITTLE_GAIN 0.05
#define STEP 1.25         // factor on the size that must
#define STEP_SAVES 1.03   // save this factor of the time,
#define LEAST_LIMITED 3.0 // above this size
#define HOPELESS 0.1      // applies in full if the fastest size misses the goal by this share
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
#define TRIAL_AFTER 40  // late frames in a row before finer splats are tried
#define TRIAL_PAUSE 120 // frames after a trial that failed
#define TRIAL_LOSS 1.06 // factor on the time that finer splats may take
#define TRIAL_FOLLOWS 0.05
#define TRIAL_NOISE 1.03 // times of a trial rise by no more than this
#define TREND_FOLLOWS 0.5
#define SURPRISE 1.1       // limit on the work of a list, relative to the time wanted for it
#define LEAST_SURPRISE 0.2 // and to the budget
#define FORESIGHT 0.8      // share of the time after a jump: occlusion is not known yet
#define MOST_GROWN 2.0     // limit on what pixels are thought to grow with a list
#define MAX_LATE 0.4       // logarithm: a larger difference means a different place

void stp_budget_init(stp_budget* budget, stp_controller controller, double budget_ms)
{
    *budget = (stp_budget){
        .controller = controller,
        .budget_ms = budget_ms > 0.0 ? budget_ms : 1.0,
        .coarseness = controller == STP_CONTROLLER_PAPER ? 1.0f : 0.5f * STP_SPLAT_SIZE_MAX,
        .coarsest = (double)STP_SPLAT_SIZE_COARSEST,
        .speed = 1.0,
        .scatter = 0.05,
        .splat_exponent = FIRST_SPLAT_EXPONENT,
        .fragment_exponent = FIRST_FRAGMENT_EXPONENT,
        .triangle_exponent = FIRST_TRIANGLE_EXPONENT,
        .ratios = {1.0, 1.0, 1.0},
    };
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        budget->price[i] = first_price[i];
        budget->covariance[i][i] = first_price[i] * first_price[i] * FIRST_DOUBT * FIRST_DOUBT;
    }
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

static void list_terms(const stp_frame_cost* cost, double terms[STP_BUDGET_TERMS])
{
    const double counts[STP_BUDGET_TERMS] = {(double)cost->splats, (double)cost->fragments,
                                             (double)cost->triangles, (double)cost->draw_calls,
                                             (double)cost->covered_pixels};
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        terms[i] = counts[i] * units[i];
    }
}

static double price_of(const stp_budget* b, const double terms[STP_BUDGET_TERMS])
{
    double sum = 0.0;
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        sum += b->price[i] * terms[i];
    }
    return sum;
}

double stp_budget_predict(const stp_budget* b, double coarseness)
{
    const double full = (double)STP_SPLAT_SIZE_COARSEST;
    double terms[STP_BUDGET_TERMS], factors[STP_BUDGET_TERMS], before[STP_BUDGET_TERMS];
    list_terms(&b->last, terms);
    assert(coarseness > 0.0);
    double last = b->frames > 0 ? (double)b->last.splat_size : coarseness;
    double finer = stp_mind(last, full) / stp_mind(coarseness, full);
    double triangles = pow(finer, b->triangle_exponent);
    terms[0] *= pow(finer, b->splat_exponent);
    // larger splats may have more fragments, but an estimate from other places must not keep splats
    // small
    terms[1] *= pow(finer, finer < 1.0 ? fmax(b->fragment_exponent, 0.0) : b->fragment_exponent);
    terms[2] *= triangles;
    terms[3] *= triangles;
    stp_coarseness_factors(stp_coarseness_resolution(coarseness), factors);
    stp_coarseness_factors(stp_coarseness_resolution(last), before);
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        terms[i] *= factors[i] / before[i];
    }
    return b->speed * price_of(b, terms);
}

// A Kalman filter of drifting prices. Prices stay positive, and the uncertainty of unobserved terms
// is bounded.
static void update_prices(stp_budget* b, const double terms[STP_BUDGET_TERMS], double milliseconds)
{
    double expected = price_of(b, terms), spread[STP_BUDGET_TERMS] = {0}, sum = 0.0;
    double error = milliseconds / b->speed - expected;
    error = stp_clampd(error, -OUTLIER * expected, OUTLIER * expected);
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        double maximum = first_price[i] * FIRST_DOUBT, drift = first_price[i] * DRIFT;
        b->covariance[i][i] += b->covariance[i][i] < maximum * maximum ? drift * drift : 0.0;
        for (int k = 0; k < STP_BUDGET_TERMS; ++k) {
            spread[i] += b->covariance[i][k] * terms[k];
        }
        sum += spread[i] * terms[i];
    }
    double noise = NOISE * expected + 1e-3;
    double gain = 1.0 / (sum + noise * noise);
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        double minimum = first_price[i] * 0.01;
        b->price[i] += spread[i] * gain * error;
        b->price[i] = b->price[i] > minimum ? b->price[i] : minimum;
        for (int k = 0; k < STP_BUDGET_TERMS; ++k) {
            b->covariance[i][k] -= spread[i] * spread[k] * gain;
        }
    }
}

// Learns a count's exponent from its response to a size change. Weights larger changes more,
// relative to changes of the scene.
static double update_exponent(double exponent, uint64_t before, uint64_t now, double change,
                              double minimum, double maximum)
{
    if (before < 1000 || now < 1000) {
        return exponent;
    }
    assert(fabs(change) >= MIN_CHANGE && minimum < maximum);
    double seen = log((double)now / (double)before) / change, square = change * change;
    double follows = EXPONENT_FOLLOWS * square / (square + SCENE_CHANGES * SCENE_CHANGES);
    return exponent + follows * (stp_clampd(seen, minimum, maximum) - exponent);
}

// Learns from the response of counts to the last size change. While the size is constant, other
// content comes into view and the exponents decay.
static void update_exponents(stp_budget* b, const stp_frame_cost* cost)
{
    const double full = (double)STP_SPLAT_SIZE_COARSEST;
    double change =
        log(stp_mind((double)b->last.splat_size, full) / stp_mind((double)cost->splat_size, full));
    bool lower =
        stp_coarseness_resolution((double)b->last.splat_size) < 1.0 ||
        stp_coarseness_resolution((double)cost->splat_size) < 1.0; // other counts than splats
    if (b->frames == 0 || lower) {
        return;
    }
    if (fabs(change) < MIN_CHANGE) {
        b->splat_exponent += EXPONENT_FADES * (FIRST_SPLAT_EXPONENT - b->splat_exponent);
        b->fragment_exponent += EXPONENT_FADES * (FIRST_FRAGMENT_EXPONENT - b->fragment_exponent);
        b->triangle_exponent += EXPONENT_FADES * (FIRST_TRIANGLE_EXPONENT - b->triangle_exponent);
        return;
    }
    const stp_frame_cost* last = &b->last;
    b->splat_exponent =
        update_exponent(b->splat_exponent, last->splats, cost->splats, change, 0.5, 2.5);
    b->fragment_exponent =
        update_exponent(b->fragment_exponent, last->fragments, cost->fragments, change, -0.5, 1.0);
    b->triangle_exponent =
        update_exponent(b->triangle_exponent, last->triangles, cost->triangles, change, 0.0, 3.0);
}

// Size at which the model, which never rises with size, meets the goal. If no size does, does not
// enlarge splats for a negligible gain.
static double solve_size(const stp_budget* b, double goal)
{
    double low = (double)STP_SPLAT_SIZE_MIN, high = b->coarsest;
    assert(goal > 0.0);
    double fastest = stp_budget_predict(b, high);
    double beyond = stp_clampd((fastest / goal - 1.0) / HOPELESS, 0.0, 1.0);
    goal = fmax(goal, fastest * (1.0 + LITTLE_GAIN * beyond));
    for (int i = 0; i < 24; ++i) {
        double middle = 0.5 * (low + high);
        *(stp_budget_predict(b, middle) > goal ? &low : &high) = middle;
    }
    // never a coarser picture that is hardly cheaper
    while (high > LEAST_LIMITED &&
           stp_budget_predict(b, high / STEP) < STEP_SAVES * stp_budget_predict(b, high)) {
        high /= STEP;
    }
    return high;
}

static double middle_of(const double v[STP_BUDGET_RATIOS])
{
    double low = fmin(v[0], v[1]), high = fmax(v[0], v[1]);
    return fmax(low, fmin(high, v[2]));
}

// Updates the machine's speed from the median of the last frames, so that one slow frame has little
// effect. @return the time to learn from
static double update_speed(stp_budget* b, double milliseconds, double expected)
{
    if (b->frames == 0 || !(expected > 0.0)) {
        return milliseconds;
    }
    b->ratios[b->frames % STP_BUDGET_RATIOS] = stp_clampd(milliseconds / expected, 0.2, 5.0);
    double middle = middle_of(b->ratios);
    b->speed += SPEED_FOLLOWS * (middle - b->speed);
    return fmin(milliseconds, SLOW_FRAME * middle * expected);
}

// Moves lasting speed changes into the prices. Otherwise rising prices and a falling speed could
// diverge.
static void settle_speed(stp_budget* b)
{
    double part = pow(b->speed, SPEED_FADES);
    b->speed /= part;
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        b->price[i] *= part;
        for (int k = 0; k < STP_BUDGET_TERMS; ++k) {
            b->covariance[i][k] *= part * part;
        }
    }
    for (int i = 0; i < STP_BUDGET_RATIOS; ++i) {
        b->ratios[i] /= part;
    }
}

// Updates the forecast error. In a flight towards something, content keeps coming into view;
// measures this trend from the counts at the forecast's prices, independent of the machine's speed.
static void update_trend(stp_budget* b, const stp_frame_cost* cost,
                         const double terms[STP_BUDGET_TERMS])
{
    double forecast = stp_budget_predict(b, (double)cost->splat_size);
    if (b->frames == 0 || !(forecast > 0.0)) {
        return;
    }
    double late = stp_clampd(log(cost->milliseconds / forecast), -MAX_LATE, MAX_LATE);
    double grown = log(b->speed * price_of(b, terms) / forecast);
    b->growth[b->frames % STP_BUDGET_RATIOS] = stp_clampd(grown, -MAX_LATE, MAX_LATE);
    double off = fmin(fabs(late - fmax(b->trend, 0.0)), fmax(MAX_OFF, 3.0 * b->scatter));
    b->scatter += SCATTER_FOLLOWS * (off - b->scatter);
    b->trend += TREND_FOLLOWS * (middle_of(b->growth) - b->trend);
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

/// Learns the times of a frame's effects. A single slow frame counts as in the speed.
static void update_effects(stp_budget* b, const stp_frame_cost* cost, double own_ms)
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
        double most = known ? SLOW_FRAME * expect_effect(e, pixels, 1.0) : ms;
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

/// The part of the budget that the next frame's effects leave. Unknown effects do not make splats
/// larger.
static double time_for_detail(const stp_budget* b)
{
    return time_beside(b, STP_EFFECT_COUNT);
}

// Largest factor on the last size. A model that is still wrong after a slow period must not enlarge
// splats while frames are in time.
static double find_coarsest(const stp_budget* b, double milliseconds)
{
    double expected = milliseconds * exp(fmax(b->trend, 0.0));
    double late = OVERSHOOT * (1.0 + SIGMAS * fmin(b->scatter, MAX_SCATTER)) * expected;
    return stp_clampd(late / time_for_detail(b), 1.0, FASTEST_COARSER);
}

/// Leaves effects out while splats would be larger because of them: as many as necessary, in their
/// order. @param margin  factor on the time for detail
/// @return the size for which there is time beside the others, however large its change
static double leave_effects(stp_budget* b, double margin)
{
    double size = solve_size(b, margin * time_for_detail(b));
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
            size = solve_size(b, margin * time_for_detail(b));
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

/// Takes back the effect that was left out last, once there was time for it during some frames.
/// @param margin  factor on the time for detail
static void return_effect(stp_budget* b, double margin)
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
           solve_size(b, EFFECT_ROOM * margin * time_beside(b, next)) <= effect_size[next];
    b->calm_frames = fits ? b->calm_frames + 1 : 0;
    if (b->calm_frames >= (uint32_t)EFFECT_FRAMES << 2u * b->patience) {
        b->returned = b->frames;
        b->effects[next].left_out = false;
        b->effects[next].frames = 0;
        b->calm_frames = 0;
    }
}

/// If no size meets the budget, larger splats may be no faster, but the model cannot know that
/// while the size stays the same. So finer splats are tried, and kept as long as they take no more
/// time.
/// @param size  that the model chooses  @return the size to use
static double try_finer(stp_budget* b, const stp_frame_cost* cost, double size)
{
    bool late = cost->milliseconds > OVERSHOOT * time_for_detail(b);
    double middle = middle_of(b->times), used = (double)cost->splat_size;
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
    double scatter = b->scatter < MAX_SCATTER ? b->scatter : MAX_SCATTER;
    double margin = OVERSHOOT / (1.0 + SIGMAS * 1.25 * scatter); // converts mean deviation to sigma
    return fmin(margin, 1.0);
}

/// `cost` is without effects.
static void predict(stp_budget* b, const stp_frame_cost* cost)
{
    double terms[STP_BUDGET_TERMS];
    list_terms(cost, terms);
    update_trend(b, cost, terms);
    update_prices(b, terms, update_speed(b, cost->milliseconds, price_of(b, terms)));
    settle_speed(b);
    if (!b->foreseen) { // else its counts are of another place, and partly guessed
        update_exponents(b, cost);
    }
    b->foreseen = false;
    b->last = *cost;
    double margin = find_margin(b) * exp(-fmax(b->trend, 0.0));
    b->times[b->frames % STP_BUDGET_RATIOS] = cost->milliseconds;
    b->frames += 1;
    double solved = leave_effects(b, margin);
    double finer = find_finest(b, margin * time_for_detail(b));
    double size = fmax(solved, (double)cost->splat_size * finer);
    size = fmin(size, (double)cost->splat_size * find_coarsest(b, cost->milliseconds));
    size = try_finer(b, cost, size);
    b->coarseness = clamp_size(size, b->coarsest);
    return_effect(b, margin);
}

/// Time of the counts that a list has: splats, triangles and draws.
static double price_list(const stp_budget* b, const stp_frame_cost* cost)
{
    double terms[STP_BUDGET_TERMS];
    list_terms(cost, terms);
    terms[1] = terms[4] = 0.0;
    return b->speed * price_of(b, terms);
}

stp_work_limit stp_budget_limit(const stp_budget* b)
{
    if (b->controller != STP_CONTROLLER_PREDICT || b->frames == 0 ||
        (double)b->coarseness >= b->coarsest) {
        return (stp_work_limit){0};
    }
    double expected = stp_budget_predict(b, (double)b->coarseness);
    double wanted = fmax(expected, time_for_detail(b)), listed = price_list(b, &b->last);
    double most = SURPRISE * wanted * listed / expected; // pixels grow with the list
    return (stp_work_limit){
        .splat = b->speed * b->price[0] * units[0],
        .triangle = b->speed * b->price[2] * units[2],
        .item = b->speed * b->price[3] * units[3],
        .most = fmax(most, LEAST_SURPRISE * b->budget_ms),
    };
}

void stp_budget_foresee(stp_budget* b, const stp_frame_cost* listed)
{
    assert(b->frames > 0 && "a frame was within the limit");
    double before = price_list(b, &b->last), now = price_list(b, listed);
    double grown = before > 0.0 ? stp_clampd(now / before, 1.0, MOST_GROWN) : MOST_GROWN;
    b->last.splats = listed->splats;
    b->last.triangles = listed->triangles;
    b->last.draw_calls = listed->draw_calls;
    b->last.fragments = (uint64_t)(grown * (double)b->last.fragments);
    b->last.covered_pixels = (uint64_t)(grown * (double)b->last.covered_pixels);
    b->last.splat_size = (float)stp_coarseness_of(listed);
    b->last.resolution = listed->resolution;
    b->foreseen = true;
    double solved = solve_size(b, FORESIGHT * find_margin(b) * time_for_detail(b));
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
        update_effects(b, cost, own.milliseconds);
        predict(b, &own);
    }
    assert(b->coarseness >= STP_SPLAT_SIZE_MIN && (double)b->coarseness <= b->coarsest);
}
