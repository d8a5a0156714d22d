// SPDX-License-Identifier: MIT
#include "draw/cpu/passes.h"

#include "base/core/clock.h"
#include "draw/cpu/effects.h"
#include "draw/cpu/layers.h"
#include "draw/cpu/pixel_filter.h"
#include "draw/placement.h"

#include <assert.h>
#include <string.h>

static void choose_nearness(stp_cpu_renderer* r)
{
    stp_placement placement = {.frame = r->frame, .mesh_depth = r->mesh_depth};
    stp_placement_choose_nearness(&placement, r->directory);
    r->nearness_scale = placement.nearness_scale;
    r->nearness_offset = placement.nearness_offset;
}

/// Makes this eye the current one.
static void select_eye(stp_cpu_renderer* r, uint32_t number)
{
    size_t first = (size_t)number * r->width * r->height;
    assert(number < r->eye_count && first + (size_t)r->width * r->height <= r->pixel_count);
    const stp_depth_pyramid* pyramid = &r->pyramids[number];
    stp_cpu_accumulation* a = &r->accumulation;
    r->eye = &r->eyes[number];
    r->frame = r->eye->frame;
    r->image = &r->eye->picture;
    r->depth = r->depths + first;
    r->sums = r->all_sums != NULL ? r->all_sums + 4 * first : NULL;
    a->sums = a->memory != NULL ? a->memory + 4 * first : NULL;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].pixels = r->workers[i].memory + first;
    }
    r->occluding = r->two_passes != NULL && pyramid->level_count > 0 ? pyramid : NULL;
    choose_nearness(r);
}

static void shade_bands(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    stp_cpu_shade_rows(r, (uint32_t)begin, (uint32_t)end, &r->workers[worker]);
}

static void average_bands(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    stp_cpu_average_rows(r, (uint32_t)begin, (uint32_t)end, &r->workers[worker].covered);
}

static void find_depths(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    stp_cpu_find_depths(r, (uint32_t)begin, (uint32_t)end, &r->workers[worker]);
}

/// Builds the pyramid of the current eye from its depths: true ones, or those of the buffers, where
/// triangles are pushed back. Its picture may be shifted by a fraction of a pixel.
static stp_result make_pyramid(stp_cpu_renderer* r, bool of_buffers)
{
    stp_depth_pyramid* pyramid = &r->pyramids[r->eye - r->eyes];
    stp_view_frame frame = r->frame;
    frame.center_x += r->shift_x;
    frame.center_y += r->shift_y;
    r->eye->made = true;
    stp_result result = stp_depth_pyramid_fill(r->base.context, &frame, r->depth, pyramid);
    pyramid->pushed_back = of_buffers ? 1.0 + r->mesh_depth / frame.scale : 1.0;
    return result;
}

stp_result stp_cpu_select_sample(stp_cpu_renderer* r)
{
    stp_cpu_two_passes* passes = r->two_passes;
    assert(!passes->selected && "a selection is drawn before the next");
    double start = stp_clock_ms();
    bool known = false;
    for (uint32_t i = 0; i < STP_EYES_MAX; ++i) {
        known = known || r->pyramids[i].level_count > 0;
    }
    passes->quality.occlusion = known && passes->hides_nodes ? r->pyramids : NULL;
    stp_result result =
        stp_select(r->base.context, r->store, passes->view, &passes->quality, passes->list);
    passes->select_ms += stp_clock_ms() - start;
    passes->selected = true;
    return result;
}

bool stp_cpu_exceeds(stp_cpu_two_passes* passes)
{
    const stp_work_limit* limit = &passes->quality.limit;
    const stp_draw_list* list = passes->list;
    double work = limit->splat * (double)list->splat_count +
                  limit->triangle * (double)list->triangle_count +
                  limit->item * (double)list->count;
    double eyes = (double)stp_view_eye_count(passes->view);
    passes->exceeds = limit->most > 0.0 && eyes * work > limit->most;
    return passes->exceeds;
}

/// After the first pass of all eyes: selects deferred nodes that are visible. Nothing is drawn of a
/// list that is too long with them.
static stp_result select_rejected(stp_cpu_renderer* r, size_t first)
{
    stp_cpu_two_passes* passes = r->two_passes;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < r->eye_count && result == STP_OK; ++i) {
        select_eye(r, i);
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, find_depths, r);
        double start = stp_clock_ms();
        result = stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : make_pyramid(r, true);
        passes->select_ms += stp_clock_ms() - start;
    }
    double start = stp_clock_ms();
    passes->quality.occlusion = passes->hides_nodes ? r->pyramids : NULL;
    if (result == STP_OK) {
        result = stp_select_rejected(r->base.context, r->store, passes->view, &passes->quality,
                                     passes->list);
    }
    passes->select_ms += stp_clock_ms() - start;
    result = result == STP_OK && stp_cpu_exceeds(passes) ? STP_ERROR_CANCELLED : result;
    return result == STP_OK ? stp_cpu_prepare_items(r, passes->list, first) : result;
}

static stp_result draw_first_pass(stp_cpu_renderer* r, const stp_draw_list* list)
{
    stp_result result = stp_cpu_prepare_items(r, list, 0);
    r->placed = NULL;
    for (uint32_t i = 0; i < r->eye_count && result == STP_OK; ++i) {
        r->eyes[i].made = false;
        select_eye(r, i);
        result = stp_cpu_prepare_occluder(r);
        if (result != STP_OK) {
            return result;
        }
        stp_cpu_place_items(r, list, 0);
        result = i == 0 ? stp_cpu_prepare_shading(r, 0) : STP_OK;
        result = result == STP_OK ? stp_cpu_draw_items(r, 0) : result;
    }
    return result;
}

/// Whether anything was occluded for any eye.
static bool is_any_hidden(const stp_cpu_renderer* r)
{
    bool any = r->two_passes->list->hidden_count > 0;
    for (uint32_t i = 0; i < r->eye_count; ++i) {
        any = any || stp_cpu_is_any_late(r, &r->eyes[i]);
    }
    return any;
}

/// Shades the current eye's buffers into its picture.
static stp_result finish_picture(stp_cpu_renderer* r, stp_draw_stats* stats)
{
    bool blends = stp_cpu_has_filter(r->style) && r->splat_size > 0.0f;
    bool disks = r->style->splat_shape == STP_SPLAT_DISK; // squares have no planes
    bool planes = disks && r->style->plane_depth && !blends && r->splat_size > 0.0f;
    stp_result result = blends || planes ? stp_cpu_find_visible(r) : STP_OK;
    if (result != STP_OK) {
        return result;
    }
    bool filters = stp_cpu_filters_pixels(r) && stp_cpu_begin_pixel_filter(r);
    bool layered = r->layers.stage != CPU_LAYERS_NONE;
    stp_cpu_begin_shading(r);
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, shade_bands, r);
    result = stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : STP_OK;
    if (blends) {
        r->occluding = NULL;
        result = result == STP_OK ? stp_cpu_blend_splats(r) : result;
    } else if (planes) {
        r->occluding = NULL;
        result = result == STP_OK ? stp_cpu_find_plane_depths(r) : result;
    }
    if (result == STP_OK && stp_cpu_has_caps(r)) {
        result = stp_cpu_put_caps(r);
    }
    if (result == STP_OK && stp_cpu_has_effects(r->style)) {
        double start = stp_clock_ms();
        result = stp_cpu_apply_effects(r);
        stats->effect_ms += stp_clock_ms() - start;
    }
    if (result == STP_OK && r->two_passes != NULL && !r->eye->made) {
        result = make_pyramid(r, false);
    }
    if (result == STP_OK && layered) {
        double start = stp_clock_ms();
        result = stp_cpu_draw_layers(r);
        stats->layer_ms += stp_clock_ms() - start;
    }
    if (result == STP_OK && filters) {
        stp_cpu_filter_pixels(r);
    }
    return result;
}

/// Draws the second pass and shades, eye by eye; the last eye's items are already placed.
static stp_result draw_second_pass(stp_cpu_renderer* r, const stp_draw_list* list, bool again,
                                   size_t first, uint32_t first_task, stp_draw_stats* stats)
{
    assert(first <= r->item_count && first_task <= r->task_count && "items are appended");
    stp_result result = STP_OK;
    for (uint32_t i = r->eye_count; i-- > 0 && result == STP_OK;) {
        double start = stp_clock_ms();
        select_eye(r, i);
        result = again ? stp_cpu_prepare_occluder(r) : STP_OK;
        if (result != STP_OK) {
            return result;
        }
        if (again && r->placed == r->eye) {
            stp_cpu_place_late_occluders(r, list, first);
        }
        stp_cpu_place_items(r, list, again ? first : r->item_count);
        if (again) {
            result = i + 1 == r->eye_count ? stp_cpu_prepare_shading(r, first) : STP_OK;
            result = result == STP_OK ? stp_cpu_draw_items(r, first_task) : result;
        }
        double drawn = stp_clock_ms();
        result = result == STP_OK ? finish_picture(r, stats) : result;
        stats->draw_ms += drawn - start;
        stats->shade_ms += stp_clock_ms() - drawn;
    }
    return result;
}

static stp_result draw_sample(stp_cpu_renderer* r, const stp_draw_list* list, uint32_t side,
                              uint32_t sample, stp_draw_stats* stats)
{
    stp_cpu_two_passes* passes = r->two_passes;
    r->pattern = sample;
    stp_placement_shift(side, sample, &r->shift_x, &r->shift_y);
    stp_result result = passes != NULL && !passes->selected ? stp_cpu_select_sample(r) : STP_OK;
    result = result == STP_OK && stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : result;
    double start = stp_clock_ms(), select_ms = passes != NULL ? passes->select_ms : 0.0;
    result = result == STP_OK ? draw_first_pass(r, list) : result;
    size_t first = r->item_count;
    uint32_t first_task = r->task_count;
    bool again = result == STP_OK && passes != NULL && is_any_hidden(r);
    if (again) {
        result = select_rejected(r, first);
    }
    if (passes != NULL) {
        stats->draw_ms -= passes->select_ms - select_ms;
        passes->selected = false;
        passes->quality.limit = (stp_work_limit){0}; // the first sample decides
    }
    stats->draw_ms += stp_clock_ms() - start;
    if (result == STP_OK) {
        result = draw_second_pass(r, list, again, first, first_task, stats);
    }
    if (result != STP_OK) {
        stp_cpu_empty_pixels(r);
    }
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].drew = false;
    }
    return result;
}

stp_result stp_cpu_draw_summed(stp_cpu_renderer* r, const stp_draw_list* list, uint32_t side,
                               stp_draw_stats* stats)
{
    stp_result result = STP_OK;
    r->sample_count = side * side;
    for (r->sample = 0; r->sample < r->sample_count && result == STP_OK; ++r->sample) {
        result = draw_sample(r, list, side, r->sample, stats);
    }
    double start = stp_clock_ms();
    for (uint32_t i = 0; i < r->eye_count && r->sample_count > 1 && result == STP_OK; ++i) {
        select_eye(r, i);
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, average_bands, r);
    }
    stats->shade_ms += stp_clock_ms() - start;
    return result;
}

static void add_frames(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->eye_count; ++i) {
        select_eye(r, i);
        stp_cpu_add_frame(r);
    }
    r->accumulation.frames += 1;
}

static void show_frames(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].covered = 0;
    }
    for (uint32_t i = 0; i < r->eye_count; ++i) {
        select_eye(r, i);
        stp_cpu_show_frames(r);
    }
}

stp_result stp_cpu_draw_accumulated(stp_cpu_renderer* r, const stp_draw_list* list, uint32_t side,
                                    uint32_t first, uint32_t end, stp_draw_stats* stats)
{
    assert(first <= end && end <= side * side);
    const stp_draw_style* style = r->style;
    stp_draw_style bare = *style;
    bare.background = bare.pixel_filter = false;
    r->style = &bare;
    r->sample_count = 1;
    r->sample = 0;
    stp_result result = STP_OK;
    for (uint32_t k = first; k < end && result == STP_OK; ++k) {
        result = draw_sample(r, list, side, stp_resting_sample(side, k), stats);
        if (result == STP_OK) {
            add_frames(r);
        }
    }
    r->style = style;
    double start = stp_clock_ms();
    if (r->accumulation.frames > 0 && result == STP_OK) {
        show_frames(r);
    }
    stats->shade_ms += stp_clock_ms() - start;
    return result;
}

typedef struct joined_rows {
    const stp_cpu_renderer* r;
    stp_image* image;
} joined_rows;

static void join_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const joined_rows* rows = user;
    const stp_cpu_renderer* r = rows->r;
    size_t size = 4 * (size_t)r->width, whole = 4 * (size_t)rows->image->width;
    assert(r->eye_count * size <= whole && "eyes lie side by side");
    (void)worker;
    for (size_t y = begin; y < end; ++y) {
        uint8_t* out = rows->image->pixels + y * whole;
        memset(out + (whole - 4), 0, 4); // odd widths: belongs to no eye
        for (uint32_t i = 0; i < r->eye_count; ++i) {
            memcpy(out + i * size, r->eyes[i].picture.pixels + y * size, size);
        }
    }
}

void stp_cpu_join_eyes(stp_cpu_renderer* r, stp_image* image)
{
    joined_rows rows = {r, image};
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, join_rows, &rows);
}
