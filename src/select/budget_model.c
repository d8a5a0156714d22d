// SPDX-License-Identifier: MIT
// The model of a frame's time: a price for each count, and exponents by which counts fall with the
// size of splats.
#include "select/budget_parts.h"

#include <assert.h>

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
#define SCATTER_FOLLOWS 0.1         // learning rate of the scatter of forecasts
#define FIRST_SPLAT_EXPONENT 2.0    // as splats cover the whole screen
#define FIRST_FRAGMENT_EXPONENT 0.0 // fewer splats, each of them larger
#define FIRST_TRIANGLE_EXPONENT 1.0
#define EXPONENT_FOLLOWS 0.4
#define SCENE_CHANGES 0.2 // change of log(counts) per frame that the scene alone may cause
// decay of an exponent towards its initial value while the size is constant
#define EXPONENT_FADES 0.01
#define MIN_CHANGE 0.02 // changes of the logarithm of the size below this count as constant
#define MAX_OFF 0.1     // the same limit for the scatter
// If no size meets the goal: accepted time above the fastest size's, so that splats do not grow for
// a negligible gain.
#define LITTLE_GAIN 0.05
#define STEP 1.25         // factor on the size that must
#define STEP_SAVES 1.03   // save this factor of the time,
#define LEAST_LIMITED 3.0 // above this size
#define HOPELESS 0.1      // applies in full if the fastest size misses the goal by this share
#define TREND_FOLLOWS 0.5
// least share of the triangles of an unexpected list that are drawn: whatever hid the last ones may
// have left the view
#define SURPRISING_SHARE 0.7
#define MAX_LATE 0.4 // logarithm: a larger difference means a different place

void stp_budget_init_model(stp_budget* b)
{
    b->speed = 1.0;
    b->scatter = 0.05;
    b->splat_exponent = FIRST_SPLAT_EXPONENT;
    b->fragment_exponent = FIRST_FRAGMENT_EXPONENT;
    b->triangle_exponent = FIRST_TRIANGLE_EXPONENT;
    for (int i = 0; i < STP_BUDGET_RATIOS; ++i) {
        b->ratios[i] = 1.0;
    }
    for (int i = 0; i < STP_BUDGET_TERMS; ++i) {
        b->price[i] = first_price[i];
        b->covariance[i][i] = first_price[i] * first_price[i] * FIRST_DOUBT * FIRST_DOUBT;
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

/// The counts of a frame like the last one, but with so many triangles, at another size.
static void predict_terms(const stp_budget* b, double triangle_count, double coarseness,
                          double terms[STP_BUDGET_TERMS])
{
    const double full = (double)STP_SPLAT_SIZE_COARSEST;
    double factors[STP_BUDGET_TERMS], before[STP_BUDGET_TERMS];
    list_terms(&b->last, terms);
    terms[2] = triangle_count * units[2];
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
}

double stp_budget_predict(const stp_budget* b, double coarseness)
{
    double terms[STP_BUDGET_TERMS];
    predict_terms(b, (double)b->last.triangles, coarseness, terms);
    return b->speed * price_of(b, terms);
}

static uint64_t count_listed(const stp_frame_cost* cost)
{
    return cost->listed_triangles > cost->triangles ? cost->listed_triangles : cost->triangles;
}

double stp_budget_drawn_share(const stp_budget* b)
{
    uint64_t listed = count_listed(&b->last);
    return listed > 0 ? fmax((double)b->last.triangles / (double)listed, SURPRISING_SHARE)
                      : SURPRISING_SHARE;
}

double stp_budget_predict_list(const stp_budget* b, double coarseness)
{
    double terms[STP_BUDGET_TERMS];
    double unhidden = stp_budget_drawn_share(b) * (double)count_listed(&b->last);
    predict_terms(b, unhidden, coarseness, terms);
    terms[1] = terms[4] = 0.0;
    return b->speed * price_of(b, terms);
}

double stp_budget_solve(const stp_budget* b, double goal)
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

// Updates the machine's speed from the median of the last frames, so that one slow frame has little
// effect. @return the time to learn from
static double update_speed(stp_budget* b, double milliseconds, double expected)
{
    if (b->frames == 0 || !(expected > 0.0)) {
        return milliseconds;
    }
    b->ratios[b->frames % STP_BUDGET_RATIOS] = stp_clampd(milliseconds / expected, 0.2, 5.0);
    double middle = stp_budget_middle(b->ratios);
    b->speed += SPEED_FOLLOWS * (middle - b->speed);
    return fmin(milliseconds, STP_BUDGET_SLOW_FRAME * middle * expected);
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
    b->trend += TREND_FOLLOWS * (stp_budget_middle(b->growth) - b->trend);
}

void stp_budget_learn(stp_budget* b, const stp_frame_cost* cost)
{
    double terms[STP_BUDGET_TERMS];
    list_terms(cost, terms);
    update_trend(b, cost, terms);
    update_prices(b, terms, update_speed(b, cost->milliseconds, price_of(b, terms)));
    settle_speed(b);
    if (!b->foreseen) { // else its counts are of another place, and partly guessed
        update_exponents(b, cost);
    }
}

stp_work_limit stp_budget_list_prices(const stp_budget* b)
{
    return (stp_work_limit){
        .splat = b->speed * b->price[0] * units[0],
        .triangle = b->speed * b->price[2] * units[2] * stp_budget_drawn_share(b),
        .item = b->speed * b->price[3] * units[3],
    };
}
