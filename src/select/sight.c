// SPDX-License-Identifier: MIT
// Visibility of a box for all eyes together, and the wanted splat sizes.
#include "select/select_internal.h"

#include <assert.h>

/// Splat sizes wanted in an eye's picture of the box.
static void choose_sizes(const stp_selection* s, uint32_t eye, const stp_boxd* box,
                         stp_box_visibility* sight)
{
    const stp_fovea* fovea = &s->quality->fovea;
    double base = (double)s->list->splat_size, minimum = 1.0, greatest = 1.0;
    if (fovea->count > 0) {
        stp_view_rectangle seen = stp_view_frame_cover(&s->frames[eye], box);
        stp_fovea_bound(fovea, &s->frames[eye], &seen, &minimum, &greatest);
    }
    sight->splat_size = fmin(sight->splat_size, fmax(base * minimum, 1.0));
    sight->largest_size = fmax(sight->largest_size, base * greatest);
}

bool stp_select_is_in_view(const stp_selection* s, const stp_boxd* box, stp_box_visibility* sight)
{
    *sight = (stp_box_visibility){.range = {HUGE_VAL, 0.0},
                                  .splat_size = HUGE_VAL,
                                  .largest_size = (double)s->list->splat_size};
    for (uint32_t i = 0; i < s->eye_count; ++i) {
        const stp_view_frame* frame = &s->frames[i];
        double near, far;
        if (!stp_view_frame_depths(frame, box, &near, &far)) {
            continue;
        }
        sight->eyes |= 1u << i;
        sight->range.near = fmin(sight->range.near, near);
        sight->range.far = fmax(sight->range.far, far);
        sight->is_inside = sight->is_inside || stp_view_frame_is_inside(frame, box);
        choose_sizes(s, i, box, sight);
    }
    assert((sight->eyes == 0 || sight->splat_size <= sight->largest_size) && "sizes are bounds");
    if (s->frames[0].parallel) {
        sight->range = (stp_depth_range){1.0, 1.0};
    }
    return sight->eyes != 0;
}
