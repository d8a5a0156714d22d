// SPDX-License-Identifier: MIT
#include "base/core/clock.h"
#include "base/core/desc.h"
#include "base/math/rng.h"
#include "order/order_kinds.h"

#include <assert.h>
#include <math.h>

static stp_result order_points(const stp_points* points, const stp_team* team,
                               const stp_order_desc* desc, stp_order_output* output)
{
    switch (desc->kind) {
    case STP_ORDER_RANDOM:
        return stp_order_random(points, team, desc, output);
    case STP_ORDER_PAPER_FAST:
    case STP_ORDER_PAPER_TEXT:
    case STP_ORDER_BEST_OF_K:
        return stp_order_sampled(points, team, desc, output);
    case STP_ORDER_EXACT:
        break;
    }
    return stp_order_exact(points, team, desc, output);
}

static stp_result check_desc(stp_context* context, const stp_order_desc* desc)
{
    const char* fault = (uint32_t)desc->kind > STP_ORDER_BEST_OF_K
                            ? "kind is not a value of stp_order_kind"
                        : (uint32_t)desc->metric > STP_METRIC_EUCLIDEAN
                            ? "metric is not a value of stp_order_metric"
                        : !isfinite(desc->drop_factor) || desc->drop_factor < 0.0f
                            ? "drop_factor must be finite and at least 0"
                            : NULL;
    return fault == NULL ? STP_OK
                         : stp_fail(context, STP_ERROR_ARGUMENT, "stp_order_desc: %s", fault);
}

stp_result stp_order_points(stp_context* context, const stp_order_desc* given,
                            const float* positions, const float* normals, uint32_t point_count,
                            uint32_t wanted, uint32_t* order, float* radii, uint32_t* ordered,
                            float* final_radius, stp_order_report* report)
{
    stp_order_output output = {
        .wanted = wanted < point_count ? wanted : point_count,
        .order = order,
        .radii = radii,
        .final_radius = final_radius,
    };
    stp_order_desc desc;
    if (context == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    stp_result result = STP_CHECK_POINTER(context, ordered);
    if (result != STP_OK) {
        return result;
    }
    *ordered = 0;
    if (!stp_desc_read(&desc, sizeof(desc), sizeof(desc), given)) {
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "stp_order_desc: sets fields that this version of the library lacks");
    }
    result = check_desc(context, &desc);
    if (result == STP_OK && output.wanted != 0) {
        result = STP_CHECK_POINTER(context, positions);
        result = result == STP_OK ? STP_CHECK_POINTER(context, order) : result;
    }
    if (result != STP_OK) {
        return result;
    }
    if (output.wanted != 0) {
        stp_team team = stp_team_create_immediate(context, desc.thread_count);
        stp_points points = {.positions = positions, .normals = normals, .count = point_count};
        double start = stp_clock_ms();
        result = stp_points_measure(&points, &team);
        double measured = stp_clock_ms();
        if (result == STP_OK) {
            result = order_points(&points, &team, &desc, &output);
        }
        output.report.index_ms += measured - start;
    } else if (final_radius != NULL) {
        *final_radius = point_count == 0 ? 0.0f : INFINITY;
    }
    assert(output.ordered <= output.wanted);
    if (result == STP_OK) {
        *ordered = output.ordered;
    }
    if (report != NULL) {
        *report = output.report;
    }
    return result;
}

// A prefix of a random permutation: swaps each place with a random later one (Fisher and Yates;
// Durstenfeld 1964).
stp_result stp_order_random(const stp_points* points, const stp_team* team,
                            const stp_order_desc* desc, stp_order_output* output)
{
    assert(output->wanted <= points->count);
    double start = stp_clock_ms();
    uint32_t* ids = STP_NEW_ARRAY(team->context, uint32_t, points->count);
    if (ids == NULL) {
        return stp_fail_memory(team->context);
    }
    for (uint32_t i = 0; i < points->count; ++i) {
        ids[i] = i;
    }
    for (uint32_t i = 0; i < output->wanted; ++i) {
        uint32_t other = i + stp_rng_below(desc->seed, i, points->count - i);
        uint32_t id = ids[other];
        ids[other] = ids[i];
        ids[i] = id;
        output->order[i] = id;
    }
    output->ordered = output->wanted;
    stp_free(team->context, ids);
    output->report.order_ms = stp_clock_ms() - start;
    if (output->radii == NULL && output->final_radius == NULL) {
        return STP_OK;
    }
    return stp_earlier_measure(points, team, output); // not counted in the time of the order
}
