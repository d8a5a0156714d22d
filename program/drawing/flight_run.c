// SPDX-License-Identifier: MIT
#include "program/drawing/flight_run.h"

#include "draw/renderer.h"
#include "program/measure/popping.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

enum {
    WARM_FRAMES =
        3, ///< frames of the first view before the flight, so that the disk is not measured
    TRUTH_SIDE = 4, ///< samples a pixel of the true picture, across and down
};

uint32_t flight_count_frames(const flight_plan* plan)
{
    return plan->frame_count > 0 ? plan->frame_count
                                 : stp_flight_frame_count(plan->flight, plan->flight->fps);
}

static stp_result create_record(stp_context* context, const flight_plan* plan,
                                flight_record* record)
{
    uint32_t count = flight_count_frames(plan);
    *record = (flight_record){.frame_count = count,
                              .budget_ms = plan->budget_ms,
                              .times = STP_NEW_ARRAY(context, double, count),
                              .frames = STP_NEW_ZEROED(context, frame_figures, count),
                              .qualities = STP_NEW_ARRAY(context, flight_quality, count),
                              .poppings = STP_NEW_ZEROED(context, double, count)};
    if (record->times == NULL || record->frames == NULL || record->qualities == NULL ||
        record->poppings == NULL) {
        return stp_fail_memory(context);
    }
    double first = plan->flight->keys[0].t;
    double length = plan->flight->keys[plan->flight->key_count - 1].t - first;
    for (uint32_t i = 0; i < count; ++i) {
        record->times[i] = first + (plan->frame_count == 0 ? (double)i / plan->flight->fps
                                    : count > 1 ? length * (double)i / (double)(count - 1)
                                                : 0.0);
    }
    return STP_OK;
}

void flight_record_destroy(stp_context* context, flight_record* record)
{
    stp_free(context, record->times);
    stp_free(context, record->frames);
    stp_free(context, record->qualities);
    stp_free(context, record->poppings);
    *record = (flight_record){0};
}

static stp_view view_of_frame(const flight_plan* plan, const flight_record* record, uint32_t frame)
{
    stp_view view = plan->view;
    assert(frame < record->frame_count);
    stp_flight_get_view(plan->flight, record->times[frame], &view);
    view.fov_degrees = plan->view.fov_degrees > 0.0 ? plan->view.fov_degrees : view.fov_degrees;
    return view;
}

// Before the flight: the first view, until it is warm, or its size of splats found.
static stp_result warm_up(frame_maker* maker, const flight_plan* plan, flight_record* record,
                          stp_budget* budget, stp_image* image)
{
    stp_view view = view_of_frame(plan, record, 0);
    stp_quality quality = plan->quality;
    frame_figures figures;
    if (plan->budget_ms > 0.0) {
        quality.splat_size = stp_budget_splat_size(budget);
    }
    stp_result result = frame_draw(maker, &view, &quality, image, &record->first);
    if (plan->budget_ms > 0.0 && result == STP_OK) {
        return frame_settle(maker, &view, budget, &quality, image);
    }
    for (int i = 1; i < WARM_FRAMES && result == STP_OK; ++i) {
        result = frame_draw(maker, &view, &quality, image, &figures);
    }
    return result;
}

/// Draws a frame within a budget. One whose list is too long is not drawn before it is coarser.
static stp_result draw_in_time(frame_maker* maker, const stp_view* view, stp_quality* quality,
                               const stp_draw_style* whole, stp_budget* budget, stp_image* image,
                               frame_figures* figures)
{
    double refused_ms = 0.0, refused_draw_ms = 0.0; // spent on frames that were given up
    quality->limit = stp_budget_limit(budget);
    stp_result result;
    for (;;) {
        quality->splat_size = stp_budget_splat_size(budget);
        maker->style = stp_draw_style_without(whole, stp_budget_left_out(budget));
        maker->style.resolution = stp_budget_resolution(budget);
        result = frame_draw(maker, view, quality, image, figures);
        if (result != STP_OK || !figures->exceeds) {
            break;
        }
        stp_budget_foresee(budget, &figures->cost);
        refused_ms += figures->cost.milliseconds;
        refused_draw_ms += figures->draw_ms;
        quality->limit = (stp_work_limit){0};
    }
    figures->cost.milliseconds += refused_ms;
    figures->draw_ms += refused_draw_ms;
    figures->select_ms += refused_ms - refused_draw_ms;
    return result;
}

static stp_result fly_timed(frame_maker* maker, const flight_plan* plan, flight_record* record,
                            stp_image* image)
{
    stp_budget budget;
    stp_budget_init(&budget, plan->controller, plan->budget_ms);
    if (!maker->uses_gl) {
        stp_budget_lower_resolution(&budget);
    }
    stp_quality quality = plan->quality;
    const stp_draw_style whole = maker->style;
    stp_result result = warm_up(maker, plan, record, &budget, image);
    for (uint32_t i = 0; i < record->frame_count && result == STP_OK; ++i) {
        stp_view view = view_of_frame(plan, record, i);
        if (plan->budget_ms > 0.0) {
            result =
                draw_in_time(maker, &view, &quality, &whole, &budget, image, &record->frames[i]);
            stp_budget_update(&budget, &record->frames[i].cost);
        } else {
            result = frame_draw(maker, &view, &quality, image, &record->frames[i]);
        }
        if (result == STP_OK) {
            result =
                stp_progress(maker->context, "fly", (double)(i + 1) / (double)record->frame_count);
        }
    }
    maker->style = whole;
    return result;
}

// What the second pass needs: this frame and the one before, by parity.
typedef struct study {
    frame_maker* maker;
    const flight_plan* plan;
    flight_record* record;
    uint32_t frame;
    stp_image ours[2], references[2];
    stp_popping popping;
    // the true picture of the view compared last, and how true the originals with one sample are
    stp_image truth, scratch;
    const stp_image* exact; ///< those originals: the frame's reference, or drawn into `scratch`
    stp_view compared;
    double exact_truth, filtered_truth;
    bool has_truth;
} study;

static stp_result get_picture(void* user)
{
    study* s = user;
    return s->plan->sink(s->plan->sink_user, &s->ours[s->frame & 1], s->frame);
}

static stp_result compare_picture(void* user)
{
    study* s = user;
    uint32_t now = s->frame & 1;
    flight_quality* q = &s->record->qualities[s->record->quality_count];
    assert(s->record->quality_count < s->record->frame_count && "one comparison per frame");
    q->frame = s->frame;
    return stp_image_compare(s->maker->context, &s->ours[now], &s->references[now], NULL, NULL,
                             &q->quality);
}

static stp_result compare_truth(void* user)
{
    study* s = user;
    stp_image_quality quality;
    flight_quality* q = &s->record->qualities[s->record->quality_count];
    stp_result result = stp_image_compare(s->maker->context, &s->ours[s->frame & 1], &s->truth,
                                          NULL, NULL, &quality);
    q->truth = quality.ssim_covered;
    return result;
}

static stp_result compare_exact(void* user)
{
    study* s = user;
    stp_image_quality quality;
    stp_result result =
        stp_image_compare(s->maker->context, s->exact, &s->truth, NULL, NULL, &quality);
    s->exact_truth = quality.ssim_covered;
    return result;
}

/// Finds how true the originals with one sample are. @return in `truth`
static stp_result measure_exact(study* s, const stp_view* view, bool filtered, double* truth)
{
    const stp_visibility* visibility = s->plan->quality.visibility;
    const stp_draw_style* style = &s->maker->style;
    bool drawn = style->supersample <= 1 && style->pixel_filter == filtered; // as the reference
    stp_result result = STP_OK;
    s->exact = drawn ? &s->references[s->frame & 1] : &s->scratch;
    if (!drawn) {
        result = frame_draw_originals(s->maker, view, visibility, 1, filtered, &s->scratch);
    }
    result = result == STP_OK ? frame_do(s->maker, compare_exact, s) : result;
    *truth = s->exact_truth;
    return result;
}

/// Draws the true picture of a view, unless it is that of the frame compared before.
static stp_result draw_truth(study* s, const stp_view* view)
{
    const stp_visibility* visibility = s->plan->quality.visibility;
    if (s->has_truth && stp_resting_is_same_view(&s->compared, view)) {
        return STP_OK;
    }
    stp_result result =
        frame_draw_originals(s->maker, view, visibility, TRUTH_SIDE, false, &s->truth);
    result = result == STP_OK ? measure_exact(s, view, true, &s->filtered_truth) : result;
    result = result == STP_OK ? measure_exact(s, view, false, &s->exact_truth) : result;
    s->compared = *view;
    s->has_truth = result == STP_OK;
    return result;
}

static stp_result compare_frame(study* s, const stp_view* view)
{
    stp_result result = frame_do(s->maker, compare_picture, s);
    result = result == STP_OK ? draw_truth(s, view) : result;
    result = result == STP_OK ? frame_do(s->maker, compare_truth, s) : result;
    if (result == STP_OK) {
        flight_quality* q = &s->record->qualities[s->record->quality_count++];
        q->exact = s->exact_truth;
        q->exact_filtered = s->filtered_truth;
    }
    return result;
}

static stp_result add_popping(void* user)
{
    study* s = user;
    uint32_t now = s->frame & 1, before = now ^ 1u;
    return stp_popping_add(s->maker->context, &s->popping, &s->ours[before], &s->ours[now],
                           &s->references[before], &s->references[now]);
}

static stp_result study_frame(study* s, uint32_t i)
{
    const flight_plan* plan = s->plan;
    bool compared = plan->reference_every > 0 && i % plan->reference_every == 0;
    if (!compared && !plan->popping && plan->sink == NULL) {
        return STP_OK;
    }
    stp_view view = view_of_frame(plan, s->record, i);
    frame_figures figures;
    stp_quality quality = plan->quality;
    s->frame = i;
    if (plan->budget_ms > 0.0) {
        quality.splat_size = s->record->frames[i].cost.splat_size;
    }
    const stp_draw_style style = s->maker->style;
    s->maker->style = stp_draw_style_without(&style, s->record->frames[i].left_out);
    s->maker->style.resolution = s->record->frames[i].cost.resolution;
    stp_result result = frame_draw_loaded(s->maker, &view, &quality, &s->ours[i & 1], &figures);
    s->maker->style = style;
    if (result == STP_OK && plan->sink != NULL) {
        result = frame_do(s->maker, get_picture, s);
    }
    if (result == STP_OK && (compared || plan->popping)) {
        result = frame_draw_originals(s->maker, &view, plan->quality.visibility, style.supersample,
                                      style.pixel_filter, &s->references[i & 1]);
    }
    if (result == STP_OK && compared) {
        result = compare_frame(s, &view);
    }
    if (result == STP_OK && plan->popping && i > 0) {
        result = frame_do(s->maker, add_popping, s);
        s->record->poppings[i] = s->popping.last_mean;
    }
    return result;
}

static bool create_images(study* s)
{
    uint32_t width = s->plan->view.width, height = s->plan->view.height;
    bool compares = s->plan->reference_every > 0, created = true;
    bool with_reference = s->plan->popping || compares;
    for (int i = 0; i < 2 && created; ++i) {
        created = frame_maker_create_image(s->maker, width, height, &s->ours[i]) &&
                  (!with_reference ||
                   frame_maker_create_image(s->maker, width, height, &s->references[i]));
    }
    created =
        created && (!compares || frame_maker_create_image(s->maker, width, height, &s->truth));
    return created && (!compares || frame_maker_create_image(s->maker, width, height, &s->scratch));
}

static stp_result fly_again(frame_maker* maker, const flight_plan* plan, flight_record* record)
{
    study s = {.maker = maker, .plan = plan, .record = record};
    bool created = create_images(&s);
    stp_result result =
        created ? stp_popping_create(maker->context, &s.popping) : STP_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < record->frame_count && result == STP_OK; ++i) {
        result = study_frame(&s, i);
        if (result == STP_OK) {
            result = stp_progress(maker->context, "pictures",
                                  (double)(i + 1) / (double)record->frame_count);
        }
    }
    if (result == STP_OK && plan->popping) {
        record->has_popping = true;
        record->popping_p50 = stp_popping_percentile(&s.popping, 0.5);
        record->popping_p999 = stp_popping_percentile(&s.popping, 0.999);
        record->popping_max = stp_popping_percentile(&s.popping, 1.0);
    }
    stp_popping_destroy(maker->context, &s.popping);
    for (int i = 0; i < 2; ++i) {
        stp_free(maker->context, s.ours[i].pixels);
        stp_free(maker->context, s.references[i].pixels);
    }
    stp_free(maker->context, s.truth.pixels);
    stp_free(maker->context, s.scratch.pixels);
    return result;
}

stp_result flight_run(frame_maker* maker, const flight_plan* plan, flight_record* record)
{
    stp_result result = create_record(maker->context, plan, record);
    stp_image image = {0};
    // what OpenGL draws stays on the GPU, as in the viewer: no frame waits for its pixels
    if (result == STP_OK && !maker->uses_gl &&
        !frame_image_create(maker->context, plan->view.width, plan->view.height, &image)) {
        result = STP_ERROR_OUT_OF_MEMORY;
    }
    if (result == STP_OK) {
        result = fly_timed(maker, plan, record, maker->uses_gl ? NULL : &image);
    }
    stp_free(maker->context, image.pixels);
    bool again = plan->sink != NULL || plan->popping || plan->reference_every > 0;
    return result == STP_OK && again ? fly_again(maker, plan, record) : result;
}

double flight_frame_ms(const frame_figures* figures)
{
    return figures->cost.milliseconds;
}

double flight_splats(const frame_figures* figures)
{
    return (double)figures->splats;
}

double flight_triangles(const frame_figures* figures)
{
    return (double)figures->triangles;
}

double flight_splat_size(const frame_figures* figures)
{
    return stp_frame_splat_size(&figures->cost);
}

double flight_draw_calls(const frame_figures* figures)
{
    return (double)figures->cost.draw_calls;
}

double flight_extra_splats(const frame_figures* figures)
{
    return (double)figures->extra_splats;
}

static int compare_doubles(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

static double value_at(const double* sorted, uint32_t count, double part)
{
    uint32_t rank = (uint32_t)ceil(part * (double)count - 1e-9);
    assert(count > 0 && rank <= count);
    return sorted[rank > 0 ? rank - 1 : 0];
}

flight_ranks flight_rank(const flight_record* record, flight_value value)
{
    uint32_t count = record->frame_count;
    double* sorted = calloc(count, sizeof(*sorted));
    if (sorted == NULL) {
        return (flight_ranks){0};
    }
    for (uint32_t i = 0; i < count; ++i) {
        sorted[i] = value(&record->frames[i]);
    }
    qsort(sorted, count, sizeof(*sorted), compare_doubles);
    flight_ranks ranks = {value_at(sorted, count, 0.5), value_at(sorted, count, 0.95),
                          value_at(sorted, count, 0.99), sorted[count - 1]};
    free(sorted);
    return ranks;
}
