// SPDX-License-Identifier: MIT
// Nodes that the depth pyramid occludes are deferred in the first pass, and culled in the second.
#include "select/select_internal.h"

#include <assert.h>

/// Radius in pixels of the largest splat: half the splat size, plus the growth of a set in its level
/// switch.
static double splat_margin(const stp_box_visibility* sight)
{
    return 0.5 * STP_LEVEL_SWITCH_SHORTFALL * sight->largest_size;
}

static stp_result set_aside(stp_selection* s, const stp_select_entry* at)
{
    stp_draw_list* list = s->list;
    assert(!s->second_pass && "the second pass culls");
    if (list->rejected_count == list->rejected_capacity) {
        if (!STP_MAKE_ROOM(s->context, list->rejected, list->rejected_capacity,
                           list->rejected_count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    list->rejected[list->rejected_count++] = *at;
    return STP_OK;
}

stp_result stp_select_hide(stp_selection* s, const stp_select_entry* at, const stp_boxd* box,
                           const stp_box_visibility* sight, bool* hidden)
{
    *hidden = false;
    if (s->quality->occlusion == NULL) {
        return STP_OK;
    }
    assert(sight->eyes != 0 && "a node that no eye sees would count as hidden");
    assert(!s->frames[0].parallel && "pyramids occlude in perspective only");
    double reach =
        (double)s->graph->margins[at->node] * stp_affine_scale(&at->transform) * (1.0 + 1e-6);
    stp_vec3d margin = {reach, reach, reach};
    stp_boxd wider = {stp_subd(box->min, margin), stp_addd(box->max, margin)};
    *hidden = true;
    for (uint32_t i = 0; i < s->eye_count && *hidden; ++i) {
        const stp_depth_pyramid* pyramid = &s->quality->occlusion[i];
        *hidden = (sight->eyes & 1u << i) == 0 ||
                  stp_depth_pyramid_hides(pyramid, &wider, splat_margin(sight));
    }
    if (!*hidden) {
        return STP_OK;
    }
    s->list->hidden_count += 1;
    return s->second_pass ? STP_OK : set_aside(s, at);
}
