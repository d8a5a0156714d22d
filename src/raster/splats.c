// SPDX-License-Identifier: MIT
#include "raster/splats.h"

#include "base/core/processor.h"
#include "raster/splats_hidden.h"
#include "raster/splats_levels_kernel.h"
#include "raster/splats_squares_kernel.h"

#include <assert.h>
#include <math.h>

static double dot3(const double* a, const double* b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void stp_splats_fold_row(const float row[4], const stp_raster_splats* splats, float out[4])
{
    bool grid = splats->positions != NULL;
    double step = grid ? (double)splats->step : 1.0;
    double origin[3] = {(double)splats->origin.x, (double)splats->origin.y,
                        (double)splats->origin.z};
    double m[3] = {(double)row[0], (double)row[1], (double)row[2]};
    for (int k = 0; k < 3; ++k) {
        out[k] = (float)(m[k] * step);
    }
    out[3] = (float)((double)row[3] + (grid ? dot3(m, origin) : 0.0));
}

static void widen(const float row[4], double out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = (double)row[k];
    }
}

/// How far a ball of unit projected radius reaches beyond its centre's pixel, times W, against each
/// side of the picture.
static void measure_sides(stp_splat_frame* frame)
{
    float sides[4] = {-frame->center_x, (float)frame->target->width - frame->center_x,
                      (float)frame->row_begin - frame->center_y,
                      (float)frame->row_end - frame->center_y};
    for (int i = 0; i < 4; ++i) {
        float slope = sides[i] * frame->inverse_scale;
        frame->beside[i] = sqrtf(1.0f + slope * slope);
    }
}

static void place_occluder(stp_splat_frame* frame)
{
    const stp_raster_occluder* occluder = frame->splats->occluder;
    if (occluder != NULL) {
        for (int k = 0; k < 3; ++k) {
            stp_splats_fold_row(occluder->matrix[k], frame->splats, frame->occluder[k]);
        }
        frame->occluder_radius = frame->splats->radius * occluder->scale * occluder->pixel_scale;
    }
}

void stp_splats_test_frame(stp_splat_frame* frame, const stp_raster_splats* splats)
{
    *frame = (stp_splat_frame){.splats = splats};
    place_occluder(frame);
}

bool stp_splats_make_frame(stp_splat_frame* frame, const stp_raster_target* target,
                           uint32_t row_begin, uint32_t row_end, const stp_raster_camera* camera,
                           const stp_raster_splats* splats, uint32_t first_id)
{
    assert(splats->begin <= splats->end);
    assert(
        ((splats->wanted == NULL && splats->hidden == NULL) || splats->begin % SPLAT_BATCH == 0) &&
        "whole words of bits");
    assert(target->width <= INT32_MAX);
    assert((splats->low_count == 0 || splats->low_coverages != NULL) && splats->low_share <= 256);
    assert((splats->occluder == NULL || splats->positions != NULL) && "splats of a set only");
    *frame = (stp_splat_frame){
        .target = target, .splats = splats, .camera = camera, .first_id = first_id};
    row_end = row_end < target->height ? row_end : target->height;
    bool by_depth = splats->nearest != 0.0f || splats->farthest != 0.0f;
    frame->nearest = by_depth ? splats->nearest : -INFINITY;
    frame->farthest = by_depth ? splats->farthest : INFINITY;
    frame->seed = splats->seed;
    frame->pixels = splats->pixels;
    frame->rim_depth = splats->rim_depth;
    frame->back_depth = splats->back_depth;
    frame->row_begin = (int32_t)row_begin;
    frame->row_end = (int32_t)row_end;
    stp_splats_fold_row(camera->matrix.m[0], splats, frame->x);
    stp_splats_fold_row(camera->matrix.m[1], splats, frame->y);
    stp_splats_fold_row(camera->matrix.m[2], splats, frame->n);
    stp_splats_fold_row(camera->matrix.m[3], splats, frame->w);
    place_occluder(frame);
    double x[3], y[3], n[3], w[3], vx[3], vy[3], vz[3];
    widen(camera->matrix.m[0], x);
    widen(camera->matrix.m[1], y);
    widen(camera->matrix.m[2], n);
    widen(camera->matrix.m[3], w);
    widen(camera->view[0], vx);
    widen(camera->view[1], vy);
    widen(camera->view[2], vz);
    double square = dot3(vz, vz), scale = sqrt(square);
    if (!(scale > 0.0) || !(camera->pixel_scale > 0.0f) || row_begin >= row_end) {
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        frame->turn[0][k] = (float)(vx[k] / scale);
        frame->turn[1][k] = (float)(vy[k] / scale);
        frame->turn[2][k] = (float)(vz[k] / scale);
    }
    double s = (double)camera->pixel_scale, radius = (double)splats->radius * scale;
    frame->nearness_limit = camera->nearness_limit;
    if (camera->parallel) {
        frame->radius_px = (float)(radius * s);
        frame->slope_constant = (float)(-dot3(n, vz) / square / s);
        return true;
    }
    // W = factor * view z, X = factor * (s x + cx z): gives where the view axis meets the screen
    double factor = dot3(w, vz) / square;
    if (!(factor > 0.0)) {
        return false;
    }
    frame->radius_px = (float)(radius * s * factor);
    frame->center_x = (float)(dot3(x, vz) / square / factor);
    frame->center_y = (float)(dot3(y, vz) / square / factor);
    frame->inverse_scale = (float)(1.0 / s);
    frame->slope_factor = frame->inverse_scale;
    // nearer than this many radii
    double radii = 4.0 + 2.0 * (double)(frame->rim_depth + frame->back_depth);
    frame->near_w = (float)(radii * radius * factor);
    frame->far_w = (float)(-radius * factor);
    measure_sides(frame);
    return true;
}

uint64_t stp_splats_draw_portable(const stp_splat_frame* frame)
{
    const stp_raster_splats* splats = frame->splats;
    uint64_t fragments = 0;
    splat_batch batch = empty_batch();
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        uint32_t count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        if (skip_unwanted(splats, first)) {
            continue;
        }
        splat_lanes lanes = {first, count, NULL};
        load_positions_scalar(frame, lanes, &batch);
        load_shapes(frame, lanes, &batch);
        load_parts(frame, lanes, &batch);
        project_batch(frame, &batch);
        pick_batch(frame, &batch, lanes);
        bool disks = false;
        uint32_t hidden = 0;
        for (uint32_t i = 0; i < count; ++i) {
            disks = disks || batch.kind[i] == SPLAT_DISK;
            hidden |= (uint32_t)(batch.kind[i] == SPLAT_HIDDEN) << i;
        }
        if (splats->hidden != NULL) {
            splats->hidden[first / SPLAT_BATCH] = (uint16_t)hidden;
        }
        if (disks) {
            if (splats->normals != NULL) {
                load_normals_scalar(frame, lanes, &batch);
            }
            shape_batch(frame, &batch);
            stretch_batch(frame, &batch);
            clip_batch(frame, &batch);
            box_batch(&batch);
            sort_batch(frame, &batch);
        }
        uint32_t drawn = 0;
        for (uint32_t i = 0; i < count; ++i) {
            int lane = (int)i;
            drawn |= (uint32_t)splat_is_drawn(&batch, i) << i;
            if (batch.kind[i] == SPLAT_PIXEL) {
                fragments += draw_pixel(frame, &batch, lane, first + i);
            } else if (batch.kind[i] == SPLAT_LARGE) {
                fragments += stp_splats_draw_large(frame, first + i);
            } else if (batch.kind[i] == SPLAT_SMALL || batch.kind[i] == SPLAT_WIDE) {
                splat_box box = clip_box(frame, &batch, lane);
                fragments += draw_disk_scalar(frame, &batch, lane, first + i, box);
            }
        }
        count_drawn(splats, drawn);
    }
    return fragments;
}

bool stp_splats_test_portable(const stp_splat_frame* frame, uint16_t* bits)
{
    return test_all(frame, bits);
}

bool stp_raster_test_splats(const stp_raster_splats* splats, uint16_t* bits)
{
    assert(splats->occluder != NULL && splats->positions != NULL && "splats of a set only");
    assert(splats->begin <= splats->end && splats->begin % SPLAT_BATCH == 0);
    stp_splat_frame frame;
    stp_splats_test_frame(&frame, splats);
    return STP_VARIANT(stp_processor_detect(), stp_splats_test)(&frame, bits);
}

static uint64_t draw_squares(const stp_splat_frame* frame)
{
    return STP_VARIANT(stp_processor_detect(), stp_splats_squares)(frame);
}

uint64_t stp_raster_draw_splats(const stp_raster_target* target, uint32_t row_begin,
                                uint32_t row_end, const stp_raster_camera* camera,
                                const stp_raster_splats* splats, uint32_t first_id)
{
    assert(target->stride >= target->width && "rows do not overlap");
    stp_splat_frame frame;
    if (!stp_splats_make_frame(&frame, target, row_begin, row_end, camera, splats, first_id)) {
        return 0;
    }
    if (splats->squares) {
        return draw_squares(&frame);
    }
    return STP_VARIANT(stp_processor_detect(), stp_splats_draw)(&frame);
}

uint64_t stp_splats_squares_portable(const stp_splat_frame* frame)
{
    return draw_all_squares(frame);
}

bool stp_splats_pick_portable(const levels_frame* frame, uint16_t* bits)
{
    return pick_all(frame, bits);
}

bool stp_raster_pick_levels(const stp_raster_camera* camera, const stp_raster_splats* splats,
                            const uint32_t* ranges, const stp_raster_levels* levels, uint16_t* bits)
{
    assert(splats->begin <= splats->end && splats->begin % SPLAT_BATCH == 0);
    assert((!levels->beside_triangles || levels->groups != NULL) && "groups hold the marks");
    levels_frame frame = {.splats = splats, .ranges = ranges, .levels = *levels};
    stp_splats_fold_row(camera->matrix.m[3], splats, frame.w);
    if (levels->minimum > 0.0f) {
        frame.levels.errors = NULL;
    }
    if (frame.levels.errors != NULL) {
        assert(splats->normals != NULL && "shares depend on them");
        stp_raster_find_eye(camera, splats, frame.eye);
        frame.away = camera->parallel ? 0.0f : 1.0f;
    }
    if (levels->groups != NULL) {
        const stp_raster_frame picture = {
            .width = levels->width, .height = levels->height, .one_sided = levels->one_sided};
        frame.groups = stp_raster_groups_make(camera, splats, &picture);
    }
    return STP_VARIANT(stp_processor_detect(), stp_splats_pick)(&frame, bits);
}
