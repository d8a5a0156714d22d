// SPDX-License-Identifier: MIT
//
// Orders from random samples (Brandt 2019, 3.2): each round draws some of the remaining points,
// measures how far each is from all chosen points, and takes the farthest. This is the baseline for
// comparisons. The names denote the two schedules that the paper's text and its printed times
// imply.
//
//   paper-text   `samples` per round. Accepts one per round at first, and one more per round after
//                every `interval` rounds.
//   paper-fast   like the authors' program. Round 0 accepts none. Then, after every `interval`
//                rounds from round 0 on, halves the samples (never below 20) and accepts one more
//                (at most 3 of 10 samples): 200/0, 100/1, 50/2, 25/3, 20/4, 20/5, then always 20/6.
//                The best sample that was not accepted leaves the input, and returns only if it
//                runs empty.
//   best-of-k    the best of `samples` (Mitchell 1991): one accepted per round, always.
//
// The distances of a round are to the points chosen before the round, as in the paper. The output
// radii also count the points accepted earlier in the same round.
#include "base/core/clock.h"
#include "base/math/math.h"
#include "base/math/rng.h"
#include "order/order_kinds.h"

#include <assert.h>
#include <string.h>

enum { DEFAULT_SAMPLES = 200, DEFAULT_INTERVAL = 500, FEWEST_SAMPLES = 20 };

typedef struct schedule {
    stp_order_kind kind;
    uint32_t samples, accepted, interval;
    uint64_t round;
} schedule;

typedef struct drawn {
    float squared; // squared distance to the points chosen before the round
    uint32_t slot; // which sample of the round
} drawn;

typedef struct sampler {
    const stp_points* points;
    stp_context* context;
    stp_order_output* output;
    schedule plan;
    float drop_factor;
    uint64_t seed, draw_count;
    uint32_t* input; // unchosen points: the first `left`; set aside: the last `aside`
    uint32_t left, aside;
    stp_near_grid grid;
    stp_near_grid_nearest nearest;
    uint32_t capacity; // maximum samples per round
    float* positions;  // scaled positions of a round's samples, 3 per sample
    float* squared;
    drawn* ranking;
    uint8_t* state; // per sample
} sampler;

enum { BACK, CHOSEN, ASIDE, GONE };

static schedule first_schedule(const stp_order_desc* desc)
{
    schedule plan = {.kind = desc->kind, .accepted = desc->kind == STP_ORDER_PAPER_FAST ? 0 : 1};
    plan.samples = desc->samples != 0 ? desc->samples : DEFAULT_SAMPLES;
    plan.interval = desc->interval != 0 ? desc->interval : DEFAULT_INTERVAL;
    return plan;
}

static void end_round(schedule* plan)
{
    if (plan->kind == STP_ORDER_PAPER_FAST && plan->round % plan->interval == 0) {
        uint32_t half = plan->samples / 2;
        plan->samples = half > FEWEST_SAMPLES ? half : FEWEST_SAMPLES;
        uint32_t maximum = plan->samples * 3 / 10;
        plan->accepted = plan->accepted + 1 < maximum ? plan->accepted + 1 : maximum;
    }
    plan->round += 1;
    if (plan->kind == STP_ORDER_PAPER_TEXT && plan->round % plan->interval == 0) {
        plan->accepted += 1;
    }
}

// Draws `count` points of the input without repetition and moves them to its end.
static void draw(sampler* s, uint32_t count)
{
    enum { AHEAD = 32 };
    assert(count <= s->left && count <= s->capacity);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t last = s->left - 1 - i;
        uint32_t ahead = last > AHEAD ? last - AHEAD : 0; // prefetch position for later draws
        __builtin_prefetch(&s->input[stp_rng_below(s->seed, s->draw_count + AHEAD, ahead + 1)], 1);
        uint32_t at = stp_rng_below(s->seed, s->draw_count++, last + 1);
        uint32_t id = s->input[at];
        s->input[at] = s->input[last];
        s->input[last] = id;
        __builtin_prefetch(s->points->positions + 3 * (size_t)id);
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 p = stp_points_scaled(s->points, s->input[s->left - count + i]);
        s->positions[3 * i] = p.x;
        s->positions[3 * i + 1] = p.y;
        s->positions[3 * i + 2] = p.z;
    }
}

// Farther first; ties go to the one drawn earlier.
static inline bool ranks_before(drawn a, drawn b)
{
    return a.squared > b.squared || (a.squared == b.squared && a.slot > b.slot);
}

// Moves the `best` farthest of `count` samples to the front of the ranking, in order.
static void rank(sampler* s, uint32_t count, uint32_t best)
{
    uint32_t size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        drawn d = {s->squared[i], i};
        if (size == best && !ranks_before(d, s->ranking[size - 1])) {
            continue;
        }
        uint32_t at = size < best ? size++ : size - 1;
        for (; at > 0 && ranks_before(d, s->ranking[at - 1]); --at) {
            s->ranking[at] = s->ranking[at - 1];
        }
        s->ranking[at] = d;
    }
    assert(size == (best < count ? best : count));
}

static stp_result choose(sampler* s, uint32_t id, stp_vec3 p, float squared)
{
    stp_order_output* out = s->output;
    out->order[out->ordered] = id;
    if (out->radii != NULL) {
        out->radii[out->ordered] = sqrtf(squared) / s->points->scale;
    }
    out->ordered += 1;
    return stp_near_grid_add(&s->grid, p.x, p.y, p.z);
}

static stp_vec3 sample_position(const sampler* s, uint32_t slot)
{
    return (stp_vec3){s->positions[3 * slot], s->positions[3 * slot + 1],
                      s->positions[3 * slot + 2]};
}

// Accepts the first points of the ranking. @return STP_OK, or STP_ERROR_OUT_OF_MEMORY
static stp_result accept(sampler* s, uint32_t first_input, uint32_t accepted)
{
    for (uint32_t i = 0; i < accepted; ++i) {
        drawn d = s->ranking[i];
        stp_vec3 p = sample_position(s, d.slot);
        float squared = d.squared;
        for (uint32_t k = 0; k < i; ++k) { // points of this round are not in the grid yet
            stp_vec3 e = stp_sub(p, sample_position(s, s->ranking[k].slot));
            squared = stp_min(squared, (e.x * e.x + e.y * e.y) + e.z * e.z);
        }
        s->state[d.slot] = CHOSEN;
        stp_result result = choose(s, s->input[first_input + d.slot], p, squared);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

// Compacts the input. Returned points stay in front; points set aside go to the end of the array,
// where drawn points left room.
static void compact_input(sampler* s, uint32_t first_input, uint32_t count)
{
    s->left = first_input;
    uint32_t set_aside = 0;
    bool sets_aside = false;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t id = s->input[first_input + i];
        if (s->state[i] == BACK) {
            s->input[s->left++] = id;
        } else if (s->state[i] == ASIDE) {
            set_aside = id;
            sets_aside = true;
        }
    }
    if (sets_aside) {
        assert(s->left + s->aside < s->points->count && "drawn points left room");
        s->aside += 1;
        s->input[s->points->count - s->aside] = set_aside;
    }
}

static stp_result run_round(sampler* s)
{
    stp_order_output* out = s->output;
    uint32_t count = s->plan.samples < s->left ? s->plan.samples : s->left;
    uint32_t first_input = s->left - count;
    uint32_t accepted = s->plan.accepted < count ? s->plan.accepted : count;
    accepted = accepted < out->wanted - out->ordered ? accepted : out->wanted - out->ordered;
    assert(accepted <= count && count <= s->left);
    draw(s, count);
    s->nearest(&s->grid, s->positions, count, s->squared);
    out->report.distance_count += count;
    bool sets_aside = s->plan.kind == STP_ORDER_PAPER_FAST && accepted < count;
    rank(s, count, accepted + sets_aside);
    float drop = -1.0f; // samples nearer than this leave the input
    if (s->drop_factor > 0.0f && accepted > 0) {
        drop = s->drop_factor * s->drop_factor * s->ranking[0].squared;
    }
    for (uint32_t i = 0; i < count; ++i) {
        s->state[i] = s->squared[i] < drop ? GONE : BACK;
    }
    if (sets_aside) {
        s->state[s->ranking[accepted].slot] = ASIDE;
    }
    stp_result result = accept(s, first_input, accepted);
    compact_input(s, first_input, count);
    end_round(&s->plan);
    return result;
}

static stp_result sampler_create(sampler* s)
{
    stp_context* context = s->context;
    uint32_t count = s->points->count;
    s->capacity = s->plan.samples > FEWEST_SAMPLES ? s->plan.samples : FEWEST_SAMPLES;
    s->input = STP_NEW_ARRAY(context, uint32_t, count);
    s->positions = STP_NEW_ARRAY(context, float, 3 * (size_t)s->capacity);
    s->squared = STP_NEW_ARRAY(context, float, s->capacity);
    s->ranking = STP_NEW_ARRAY(context, drawn, (size_t)s->capacity + 1);
    s->state = STP_NEW_ARRAY(context, uint8_t, s->capacity);
    if (s->input == NULL || s->positions == NULL || s->squared == NULL || s->ranking == NULL ||
        s->state == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        s->input[i] = i;
    }
    s->left = count;
    return stp_cover_create_grid(s->points, context, &s->grid);
}

static void sampler_destroy(sampler* s)
{
    if (s->grid.context != NULL) {
        stp_near_grid_destroy(&s->grid);
    }
    stp_free(s->context, s->input);
    stp_free(s->context, s->positions);
    stp_free(s->context, s->squared);
    stp_free(s->context, s->ranking);
    stp_free(s->context, s->state);
}

static stp_result run_rounds(sampler* s)
{
    stp_order_output* out = s->output;
    draw(s, 1);
    stp_result result = choose(s, s->input[s->left - 1], sample_position(s, 0), INFINITY);
    s->left -= 1;
    while (result == STP_OK && out->ordered < out->wanted && s->left + s->aside != 0) {
        if (s->left == 0) {
            memmove(s->input, s->input + s->points->count - s->aside,
                    s->aside * sizeof(s->input[0]));
            s->left = s->aside;
            s->aside = 0;
        }
        assert(out->ordered + s->left + s->aside <= s->points->count && "each point once");
        result = run_round(s);
        if (result == STP_OK && s->plan.round % 1024 == 0) {
            result = stp_progress(s->context, "order", (double)out->ordered / (double)out->wanted);
        }
    }
    return result;
}

stp_result stp_order_sampled(const stp_points* points, const stp_team* team,
                             const stp_order_desc* desc, stp_order_output* output)
{
    sampler s = {
        .points = points,
        .context = team->context,
        .output = output,
        .plan = first_schedule(desc),
        .drop_factor = desc->drop_factor,
        .seed = desc->seed,
        .nearest = stp_near_grid_nearest_select(),
    };
    double start = stp_clock_ms();
    stp_result result = sampler_create(&s);
    double created = stp_clock_ms();
    if (result == STP_OK) {
        result = run_rounds(&s);
    }
    output->report.index_ms = created - start;
    output->report.order_ms = stp_clock_ms() - created;
    if (result == STP_OK && output->final_radius != NULL) {
        result = stp_cover_radius(points, team, &s.grid, output->final_radius);
    }
    sampler_destroy(&s);
    return result;
}
