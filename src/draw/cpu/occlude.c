// SPDX-License-Identifier: MIT
// Occlusion culling of splats and clusters within visible items. The first pass of a frame tests
// against the previous picture's pyramid and records what is occluded; the second tests those again
// with the frame's own pyramid, and draws the visible ones.
#include "draw/cpu/cpu.h"
#include "draw/placement.h"

#include <assert.h>

/// Pyramid levels used for splats: blocks of up to 64 pixels.
enum { MAX_SHIFT = 6 };

stp_result stp_cpu_prepare_late(stp_cpu_renderer* r, size_t first)
{
    assert(first <= r->item_count);
    if (first == 0) {
        r->late_count = 0;
    }
    for (size_t i = first; i < r->item_count; ++i) {
        stp_cpu_item* item = &r->items[i];
        item->late = r->late_count;
        if (item->clusters.bytes != NULL) {
            r->late_count += 2 * (((size_t)item->unit_count + 31) / 32);
        } else if (item->kind == STP_DRAW_SPLATS) {
            r->late_count += ((size_t)item->unit_count + 15) / 16;
        }
    }
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < r->eye_count && result == STP_OK; ++i) {
        stp_cpu_eye* eye = &r->eyes[i];
        if (!STP_MAKE_ROOM(r->base.context, eye->late, eye->late_capacity, r->late_count) ||
            !STP_MAKE_ROOM(r->base.context, eye->late_tasks, eye->late_task_capacity,
                           r->task_count)) {
            result = stp_fail_memory(r->base.context);
        }
    }
    return result;
}

bool stp_cpu_is_any_late(const stp_cpu_renderer* r, const stp_cpu_eye* eye)
{
    bool any = false;
    for (uint32_t i = 0; i < r->task_count; ++i) {
        any = any || eye->late_tasks[i] != 0;
    }
    return any;
}

uint32_t stp_cpu_choose_level(const stp_cpu_renderer* r, const stp_view_frame* frame,
                              uint32_t level_count)
{
    double width = 2.0 * (1.1 * (double)r->splat_size * frame->corner + 0.51);
    double maximum = (double)(STP_DEPTH_PYRAMID_BLOCK * (STP_RASTER_OCCLUDER_BLOCKS - 1));
    uint32_t level = 0;
    while (level + 1 < level_count && level < MAX_SHIFT - CPU_FIRST_SHIFT && maximum < width) {
        level += 1;
        maximum *= 2.0;
    }
    assert(level < level_count && level <= MAX_SHIFT - CPU_FIRST_SHIFT);
    return level;
}

stp_result stp_cpu_prepare_occluder(stp_cpu_renderer* r)
{
    const stp_depth_pyramid* p = r->occluding;
    stp_cpu_eye* eye = r->eye;
    if (p == NULL) {
        return STP_OK;
    }
    uint32_t level = stp_cpu_choose_level(r, &p->frame, p->level_count);
    eye->window_level = level;
    if (!STP_MAKE_ROOM(r->base.context, eye->windows, eye->window_capacity,
                       (size_t)p->columns[level] * p->rows[level])) {
        return stp_fail_memory(r->base.context);
    }
    stp_raster_make_windows(p->levels[level], p->columns[level], p->rows[level], eye->windows);
    return STP_OK;
}

stp_raster_occluder stp_cpu_make_occluder(const stp_view_frame* frame, const double rows[3][4],
                                          const stp_affine* transform, const float* windows,
                                          uint32_t columns, uint32_t shift)
{
    assert(columns > 0 && shift >= CPU_FIRST_SHIFT && shift <= MAX_SHIFT);
    stp_raster_occluder occluder = {
        .windows = windows,
        .columns = columns,
        .shift = shift,
        .width = (float)frame->width,
        .height = (float)frame->height,
        .pixel_scale = (float)frame->scale,
        .scale = (float)stp_affine_scale(transform),
        .corner = (float)frame->corner,
        .near_distance = (float)frame->near_distance,
        .behind = (float)(1.0 + 1e-5),
    };
    for (int c = 0; c < 4; ++c) {
        double depth = rows[2][c];
        occluder.matrix[0][c] = (float)(frame->scale * rows[0][c] + frame->center_x * depth);
        occluder.matrix[1][c] = (float)(frame->scale * rows[1][c] + frame->center_y * depth);
        occluder.matrix[2][c] = (float)depth;
    }
    return occluder;
}

void stp_cpu_place_occluder(const stp_cpu_renderer* r, const stp_draw_item* draw,
                            stp_cpu_item* item)
{
    static const float nowhere[3] = {0.0f, 0.0f, 0.0f};
    const stp_depth_pyramid* p = r->occluding;
    if (p == NULL) {
        return;
    }
    stp_placement_view_rows(&p->frame, &draw->transform, nowhere, item->occluder_rows);
    if (item->kind != STP_DRAW_SPLATS) {
        return;
    }
    uint32_t level = r->eye->window_level;
    item->occluder =
        stp_cpu_make_occluder(&p->frame, (const double(*)[4])item->occluder_rows, &draw->transform,
                              r->eye->windows, p->columns[level], CPU_FIRST_SHIFT + level);
    double behind = 1.0 + r->mesh_depth / p->frame.scale;
    item->occluder.behind = (float)(behind * (1.0 + 1e-5));
}

void stp_cpu_place_late_occluders(stp_cpu_renderer* r, const stp_draw_list* list, size_t first)
{
    assert(first <= r->item_count && r->item_count <= list->count);
    for (size_t i = 0; i < first; ++i) {
        uint32_t end = i + 1 < r->item_count ? r->items[i + 1].first_task : r->task_count;
        bool late = false;
        for (uint32_t task = r->items[i].first_task; task < end && !late; ++task) {
            late = r->eye->late_tasks[task] != 0;
        }
        if (late) {
            stp_cpu_place_occluder(r, &list->items[i], &r->items[i]);
        }
    }
}

bool stp_cpu_hides(const stp_cpu_renderer* r, const stp_cpu_item* item, stp_box box)
{
    assert(r->occluding != NULL && "rows were placed for a pyramid");
    stp_boxd wide = {stp_to_double(box.min), stp_to_double(box.max)};
    return stp_depth_pyramid_hides_triangles(r->occluding, (const double(*)[4])item->occluder_rows,
                                             item->offset, &wide);
}

bool stp_cpu_hides_cluster(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           const float* positions, uint32_t count)
{
    return r->occluding != NULL && stp_cpu_hides(r, item, stp_box_of(positions, count));
}
