// SPDX-License-Identifier: MIT
// The level switch: the share of a node's children shown at a depth, and runs of splats between two
// depths.
#include "select/select_internal.h"

#include <assert.h>

double stp_level_switch_share(double switch_depth, double depth)
{
    if (depth <= switch_depth) {
        return 1.0;
    }
    return stp_clampd((STP_LEVEL_SWITCH_FAR * switch_depth - depth) /
                          ((STP_LEVEL_SWITCH_FAR - 1.0) * switch_depth),
                      0.0, 1.0);
}

stp_result stp_select_add_run(stp_selection* s, uint32_t begin, uint32_t end, stp_depth_range range)
{
    stp_draw_list* list = s->list;
    assert(begin < end && "empty runs are left out");
    if (list->run_count == list->run_capacity) {
        if (!STP_MAKE_ROOM(s->context, list->runs, list->run_capacity, list->run_count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    // rounded outwards
    float nearest = (float)(range.near * (1.0 - 1e-6)), farthest = INFINITY;
    if (range.far < (double)FLT_MAX) {
        farthest = (float)(range.far * (1.0 + 1e-6));
    }
    list->runs[list->run_count++] =
        (stp_draw_run){.begin = begin, .end = end, .nearest = nearest, .farthest = farthest};
    return STP_OK;
}
