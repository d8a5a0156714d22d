// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_attempt.h"

#include <assert.h>

enum {
    COARSE_STEPS = 12, ///< greedy covers until the tolerance is about right
    FINE_STEPS = 7, ///< relaxed covers between the tolerances that are too small and large enough
    TIGHTEN_PASSES = 4, ///< passes that tighten the final cover
    PATIENCE = 12,      ///< additional covers while none is large enough
};
#define START 1e-3       ///< first tolerance, relative to the diagonal
#define LEAST 1e-7       ///< minimum tolerance, likewise: about the rounding of positions
#define STEP_MAX 8.0     ///< maximum change of the tolerance per step
#define GREEDY_MORE 1.12 ///< wanted sets of a greedy cover, relative to the target
#define GREEDY_NEAR 0.04 ///< accepted relative deviation from them
#define FINE_RATIO 1.02  ///< final ratio of the two tolerances

/// Search for the minimum tolerance that needs at most the wanted number of splats. More tolerance
/// mostly needs fewer.
typedef struct search {
    stp_context* context;
    stp_subsample_field field;
    uint32_t target;
    /// Tolerances known to be too small, and large enough; 0: unknown
    double low, high;
    stp_subsample_attempt best;   ///< with the tolerance `high`
    stp_subsample_attempt fewest; ///< best attempt if none is good enough
} search;

/// Finds a tolerance whose greedy cover has somewhat more sets than wanted. Counts are about
/// inversely proportional to the tolerance (the deviation of a curved surface grows with the area
/// of a splat).
/// @param attempt receives the last cover
static stp_result search_coarse(search* s, stp_subsample_attempt* attempt)
{
    double wanted = GREEDY_MORE * (double)s->target, low = 0.0, high = 0.0;
    double minimum = LEAST * s->field.diagonal, maximum = s->field.diagonal;
    double tolerance = START * s->field.diagonal;
    for (int step = 0;; ++step) {
        stp_result result =
            stp_subsample_attempt_make(s->context, &s->field, tolerance, s->target, attempt);
        if (result == STP_OK) {
            result = stp_progress(s->context, "splats", 0.5 * step / COARSE_STEPS);
        }
        double count = (double)attempt->cover.count;
        bool near = fabs(count - wanted) <= GREEDY_NEAR * wanted;
        bool above = count > wanted;
        if (result != STP_OK || near || step == COARSE_STEPS || (above && tolerance >= maximum) ||
            (!above && tolerance <= minimum)) {
            return result;
        }
        low = above ? tolerance : low;
        high = above ? high : tolerance;
        double next = tolerance * stp_clampd(count / wanted, 1.0 / STEP_MAX, STEP_MAX);
        if (low > 0.0 && high > 0.0) { // stay inside, and approach from both ends
            double inside = 0.1 * (high - low);
            next = step % 3 == 2 ? sqrt(low * high) : stp_clampd(next, low + inside, high - inside);
        }
        tolerance = stp_clampd(next, minimum, maximum);
        stp_subsample_attempt_destroy(s->context, attempt);
    }
}

/// Keeps an attempt that is good enough, or the one with fewest splats.
static void keep(search* s, stp_subsample_attempt* attempt)
{
    assert(attempt->made && attempt->tolerance > 0.0);
    bool enough = attempt->cover.count <= s->target;
    stp_subsample_attempt* place = enough ? &s->best : &s->fewest;
    if (enough) {
        s->high = attempt->tolerance;
    } else {
        s->low = attempt->tolerance;
    }
    if (enough || !place->made || attempt->cover.count < place->cover.count) {
        stp_subsample_attempt other = *place;
        *place = *attempt;
        *attempt = other;
    }
    stp_subsample_attempt_destroy(s->context, attempt);
}

/// Relaxes covers until the minimum tolerance is known accurately, the maximum does not help, or
/// all steps are done.
static stp_result search_fine(search* s, stp_subsample_attempt* attempt)
{
    double minimum = LEAST * s->field.diagonal, maximum = s->field.diagonal;
    for (int step = 0;; ++step) {
        stp_result result = stp_subsample_attempt_relax(s->context, s->target, attempt);
        if (result == STP_OK) {
            result = stp_progress(s->context, "splats", 0.5 + 0.5 * step / (FINE_STEPS + PATIENCE));
        }
        if (result != STP_OK) {
            return result;
        }
        double tolerance = attempt->tolerance, count = (double)attempt->cover.count;
        keep(s, attempt);
        assert((s->high == 0.0 || s->low <= s->high) && "the bounds enclose the wanted tolerance");
        double next;
        if (s->low > 0.0 && s->high > 0.0) {
            next = sqrt(s->low * s->high);
        } else if (s->low > 0.0) {
            next = tolerance * stp_clampd(1.02 * count / (double)s->target, 1.0, STEP_MAX);
            next = step >= FINE_STEPS ? STEP_MAX * tolerance : next;
        } else {
            next = tolerance * stp_clampd(count / (double)s->target, 1.0 / STEP_MAX, 0.94);
        }
        bool known = s->low > 0.0 && s->high > 0.0 && s->high < FINE_RATIO * s->low;
        bool ended = s->high > 0.0 ? step >= FINE_STEPS || s->high <= minimum
                                   : step >= FINE_STEPS + PATIENCE || s->low >= maximum;
        if (known || ended) {
            return STP_OK;
        }
        next = stp_clampd(next, minimum, maximum);
        result = stp_subsample_attempt_make(s->context, &s->field, next, s->target, attempt);
        if (result != STP_OK) {
            return result;
        }
    }
}

static stp_result run_search(search* s)
{
    stp_subsample_attempt attempt = {0};
    s->low = s->high = 0.0;
    stp_result result = search_coarse(s, &attempt);
    if (result == STP_OK) {
        result = search_fine(s, &attempt);
    }
    stp_subsample_attempt_destroy(s->context, &attempt);
    return result;
}

/// Searches. If separate parts need too many splats, searches again with splats that may span gaps;
/// if these are still too many, accepts the minimum possible number.
static stp_result search_cover(search* s)
{
    uint32_t added = 0;
    stp_result result = run_search(s);
    if (result == STP_OK && s->high == 0.0) {
        result = stp_subsample_field_connect(s->context, &s->field, &added);
    }
    if (result == STP_OK && added > 0) {
        result = run_search(s);
    }
    if (result == STP_OK && s->high == 0.0) {
        uint32_t wanted = s->target;
        s->target = s->fewest.cover.count;
        stp_warn(s->context,
                 "splat sub-sampling: %u splats are wanted, but it takes %u to cover all sides",
                 wanted, s->target);
        result = run_search(s);
    }
    return result;
}

static bool make_room(stp_context* context, uint32_t count, stp_decimate_output* output)
{
    output->ellipses = STP_NEW_ARRAY(context, stp_ellipse, (size_t)count + 1);
    output->colors = STP_NEW_ARRAY(context, uint8_t, 3 * (size_t)count + 1);
    return output->ellipses != NULL && output->colors != NULL;
}

/// Each point becomes a splat.
static stp_result take_all(stp_context* context, const stp_subsample_field* field,
                           stp_decimate_output* output)
{
    if (!make_room(context, field->count, output)) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < field->count; ++i) {
        uint8_t* color = output->colors + 3 * i;
        output->ellipses[i] = field->own[i];
        color[0] = color[1] = color[2] = 255;
        if (field->colors != NULL) {
            stp_subsample_mean_color(&field->colors[i], color);
        }
    }
    output->count = field->count;
    return STP_OK;
}

static stp_result take_cover(search* s, stp_decimate_output* output)
{
    stp_subsample_attempt* a = s->high > 0.0 ? &s->best : &s->fewest;
    assert(a->made);
    stp_result result = stp_cover_tighten(s->context, &a->problem, TIGHTEN_PASSES, &a->cover);
    if (result == STP_OK && !make_room(s->context, a->cover.count, output)) {
        result = stp_fail_memory(s->context);
    }
    if (result == STP_OK) {
        stp_subsample_choice choice = {&s->field, &a->candidates, &a->problem, &a->cover};
        result = stp_subsample_fit(s->context, &choice, output->ellipses, output->colors,
                                   &output->count);
    }
    return result;
}

stp_result stp_decimate_by_subsample(stp_context* context, const stp_decimate_input* input,
                                     uint32_t target, stp_decimate_output* output)
{
    search s = {.context = context, .target = target};
    stp_subsample_unique points;
    *output = (stp_decimate_output){0};
    if (target == 0 && input->count > 0) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "splat sub-sampling: at least one splat must be wanted");
    }
    if (input->count >= STP_SUBSAMPLE_POINTS_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "splat sub-sampling: %u points (fewer than %d are allowed)", input->count,
                        STP_SUBSAMPLE_POINTS_MAX);
    }
    stp_result result = stp_subsample_unique_make(context, input, &points);
    if (result == STP_OK) {
        result = stp_subsample_field_make(context, &points, &s.field);
    }
    if (result == STP_OK && target >= points.count) {
        result = take_all(context, &s.field, output);
    } else if (result == STP_OK) {
        result = search_cover(&s);
        if (result == STP_OK) {
            result = take_cover(&s, output);
        }
    }
    stp_subsample_attempt_destroy(context, &s.best);
    stp_subsample_attempt_destroy(context, &s.fewest);
    stp_subsample_field_destroy(context, &s.field);
    stp_subsample_unique_destroy(context, &points);
    return result;
}
