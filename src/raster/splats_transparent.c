// SPDX-License-Identifier: MIT
#include "raster/splats_transparent.h"

#include "raster/blue_noise.h"
#include "raster/splats_squares_kernel.h"

#include <assert.h>

/// Splats of one call and their coverages. The frame's copy of the splats has no coverages, so
/// disks are whole.
struct stp_transparent_splats {
    const stp_raster_splats* splats;
    const stp_raster_transparency* glass;
};

/// Axis of the normal's largest component and the splat's cell along that axis: constant over a
/// plane.
static uint32_t find_key(const struct stp_transparent_splats* g, uint32_t index)
{
    const int8_t* code = g->splats->normals + 2 * (size_t)index;
    const uint16_t* place = g->splats->positions + 3 * (size_t)index;
    int32_t u = code[0], v = code[1];
    int32_t absolute_u = u < 0 ? -u : u, absolute_v = v < 0 ? -v : v;
    int32_t z = 127 - absolute_u - absolute_v, fold = z < 0 ? -z : 0;
    absolute_u = absolute_u > fold ? absolute_u - fold : fold - absolute_u;
    absolute_v = absolute_v > fold ? absolute_v - fold : fold - absolute_v;
    z = z < 0 ? -z : z;
    uint32_t axis = absolute_u >= absolute_v && absolute_u >= z ? 0 : absolute_v >= z ? 1 : 2;
    return stp_blue_noise_key(g->glass->seed, axis, place[axis] >> STP_TRANSPARENT_CELL_SHIFT);
}

bool stp_transparent_store(const stp_splat_frame* frame, uint32_t index, int32_t x, int32_t y,
                           float nearness)
{
    const struct stp_transparent_splats* g = frame->glass;
    assert(x >= 0 && (uint32_t)x < frame->target->width && y >= frame->row_begin &&
           y < frame->row_end && "a pixel of the target");
    size_t at = (size_t)y * frame->target->stride + (size_t)x;
    uint64_t pixel = stp_raster_pixel(nearness, frame->first_id + index);
    if (g->glass->layer != NULL) {
        if (!stp_layer_has_splat(g->glass->layer, at, pixel)) {
            return false;
        }
    } else {
        uint32_t part = splat_part(g->splats, index);
        float opacity = stp_transparent_opacity(part < 255 ? part : 255) * g->glass->share;
        if (opacity <= stp_blue_noise_threshold(find_key(g, index), (uint32_t)x, (uint32_t)y,
                                                g->glass->sample)) {
            return false;
        }
    }
    splat_store(&frame->target->pixels[at], pixel);
    return true;
}

static uint64_t draw_disk(const stp_splat_frame* f, const splat_batch* t, int i, uint32_t index)
{
    splat_box box = clip_box(f, t, i);
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        for (int32_t x = box.x0; x < box.x1; ++x) {
            float nearness;
            if (disk_fragment(f, t, i, x - t->x0[i], y - t->y0[i], &nearness)) {
                fragments += stp_transparent_store(f, index, x, y, nearness);
            }
        }
    }
    return fragments;
}

static uint64_t draw_transparent_square(const stp_splat_frame* f, const splat_batch* t, int i,
                                        uint32_t index)
{
    splat_box box = clip_box(f, t, i);
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        for (int32_t x = box.x0; x < box.x1; ++x) {
            fragments += stp_transparent_store(f, index, x, y, t->nearness[i]);
        }
    }
    return fragments;
}

static uint64_t draw_transparent_squares(const stp_splat_frame* f, splat_batch* t, uint32_t first,
                                         uint32_t count)
{
    uint64_t fragments = 0;
    uint32_t drawn = 0;
    splat_lanes lanes = {first, count, NULL};
    load_shapes(f, lanes, t);
    project_batch(f, t);
    pick_batch(f, t, lanes);
    place_squares(f, t, lanes);
    for (uint32_t i = 0; i < count; ++i) {
        drawn |= (uint32_t)splat_is_drawn(t, i) << i;
        if (t->kind[i] == SPLAT_PIXEL) {
            fragments += stp_transparent_store(f, first + i, t->cx[i], t->cy[i], t->nearness[i]);
        } else if (t->kind[i] == SPLAT_WIDE) {
            fragments += draw_transparent_square(f, t, (int)i, first + i);
        }
    }
    count_drawn(f->splats, drawn);
    return fragments;
}

static uint64_t draw_batch(const stp_splat_frame* f, splat_batch* t, uint32_t first, uint32_t count)
{
    uint64_t fragments = 0;
    uint32_t drawn = 0;
    bool disks = false;
    splat_lanes lanes = {first, count, NULL};
    load_shapes(f, lanes, t);
    project_batch(f, t);
    pick_batch(f, t, lanes);
    for (uint32_t i = 0; i < count; ++i) {
        disks = disks || t->kind[i] == SPLAT_DISK;
    }
    if (disks) {
        load_normals_scalar(f, lanes, t);
        shape_batch(f, t);
        stretch_batch(f, t);
        box_batch(t);
        sort_batch(f, t);
    }
    for (uint32_t i = 0; i < count; ++i) {
        drawn |= (uint32_t)splat_is_drawn(t, i) << i;
        if (t->kind[i] == SPLAT_PIXEL) {
            fragments += stp_transparent_store(f, first + i, t->cx[i], t->cy[i], t->nearness[i]);
        } else if (t->kind[i] == SPLAT_LARGE) {
            fragments += stp_splats_draw_large(f, first + i);
        } else if (t->kind[i] == SPLAT_SMALL || t->kind[i] == SPLAT_WIDE) {
            fragments += draw_disk(f, t, (int)i, first + i);
        }
    }
    count_drawn(f->splats, drawn);
    return fragments;
}

uint64_t stp_raster_draw_transparent(const stp_raster_target* target,
                                     const stp_raster_camera* camera,
                                     const stp_raster_splats* splats, uint32_t first_id,
                                     const stp_raster_transparency* glass)
{
    assert(splats->positions != NULL && splats->normals != NULL && "splats of a set only");
    assert(splats->occluder == NULL && splats->hidden == NULL);
    struct stp_transparent_splats g = {.splats = splats, .glass = glass};
    stp_raster_splats whole = *splats;
    whole.coverages = whole.low_coverages = NULL;
    whole.low_count = 0;
    whole.share = 0.0f;
    whole.rim_depth = STP_TRANSPARENT_RIM_DEPTH;
    whole.back_depth = STP_TRANSPARENT_BACK_DEPTH;
    stp_splat_frame frame;
    if (!stp_splats_make_frame(&frame, target, 0, target->height, camera, &whole, first_id)) {
        return 0;
    }
    frame.glass = &g;
    uint64_t fragments = 0;
    splat_batch batch = empty_batch();
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first, count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        if (splats->wanted == NULL || splats->wanted[first / SPLAT_BATCH] != 0) {
            load_positions_scalar(&frame, (splat_lanes){first, count, NULL}, &batch);
            fragments += splats->squares ? draw_transparent_squares(&frame, &batch, first, count)
                                         : draw_batch(&frame, &batch, first, count);
        }
    }
    return fragments;
}
