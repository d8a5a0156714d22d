// SPDX-License-Identifier: MIT
// Draws section caps into the shaded picture of the current eye.
#include "draw/cpu/passes.h"

#include <assert.h>
#include <string.h>

typedef struct cap_rows {
    stp_cpu_renderer* r;
    const stp_cap_picture* caps;
} cap_rows;

static void put_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const cap_rows* rows = user;
    stp_cpu_renderer* r = rows->r;
    for (size_t i = begin * r->width; i < end * r->width; ++i) {
        float near = rows->caps->nearness[i];
        if (near > r->depth[i]) {
            r->workers[worker].covered += r->depth[i] > 0.0f ? 0 : 1;
            r->depth[i] = near;
            memcpy(r->image->pixels + 4 * i, rows->caps->pixels + 4 * i, 4);
            if (r->layers.stage != CPU_LAYERS_NONE) { // it hides transparent surfaces behind it
                uint64_t pixel = stp_raster_pixel(near, UINT32_MAX - 1);
                uint64_t* opaque = &r->layers.farther[i];
                *opaque = pixel < *opaque ? pixel : *opaque;
            }
        }
    }
}

stp_result stp_cpu_put_caps(stp_cpu_renderer* r)
{
    assert(stp_cpu_has_caps(r));
    stp_result result = STP_OK;
    if (r->caps == NULL) {
        result = stp_caps_create(r->base.context, r->store, &r->caps);
    }
    result = result == STP_OK ? stp_caps_find(r->caps, r->sections, r->visibility) : result;
    stp_view_frame frame = r->frame;
    frame.center_x += r->shift_x;
    frame.center_y += r->shift_y;
    stp_cap_depth depth = {r->nearness_scale, r->nearness_offset};
    stp_cap_picture picture = {0};
    if (result == STP_OK) {
        result = stp_caps_fill(r->caps, &frame, r->style->headlight, &depth, &picture);
    }
    if (result == STP_OK && picture.any) {
        cap_rows rows = {r, &picture};
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, put_rows, &rows);
    }
    return result;
}
