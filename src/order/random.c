// SPDX-License-Identifier: MIT
#include "base/clock.h"
#include "base/math.h"
#include "base/rng.h"
#include "order/cover.h"
#include "order/order_kinds.h"

// Computes the radii that the exact order produces as a by-product: distances to earlier points,
// and of all points to the order. Not counted in the time of a random order.
static stp_result measure_radii(const stp_points* points, const stp_team* team,
                                stp_order_output* output)
{
    stp_near_grid grid;
    stp_near_grid_nearest nearest = stp_near_grid_nearest_select();
    stp_result result = stp_cover_create_grid(points, team->context, &grid);
    for (uint32_t i = 0; i < output->ordered && result == STP_OK; ++i) {
        stp_vec3 p = stp_points_scaled(points, output->order[i]);
        if (output->radii != NULL) {
            float squared;
            nearest(&grid, (float[3]){p.x, p.y, p.z}, 1, &squared);
            output->radii[i] = sqrtf(squared) / points->scale;
        }
        result = stp_near_grid_add(&grid, p.x, p.y, p.z);
    }
    if (result == STP_OK && output->final_radius != NULL) {
        result = stp_cover_radius(points, team, &grid, output->final_radius);
    }
    stp_near_grid_destroy(&grid);
    return result;
}

// A prefix of a random permutation: swaps each place with a random later one (Fisher and Yates;
// Durstenfeld 1964).
stp_result stp_order_random(const stp_points* points, const stp_team* team,
                            const stp_order_desc* desc, stp_order_output* output)
{
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
    return measure_radii(points, team, output);
}
