// SPDX-License-Identifier: MIT
#include "base/core/clock.h"
#include "base/math/rng.h"
#include "order/earlier.h"

#include <assert.h>

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
