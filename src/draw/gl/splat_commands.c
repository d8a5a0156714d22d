// SPDX-License-Identifier: MIT
#include "draw/gl/item_commands.h"
#include "draw/transparency.h"

#include <assert.h>

enum {
    GAP = 2, ///< maximum invisible groups drawn to avoid another command
};

// Samples are shifted by up to half a pixel, and filters widen splats by about one pixel.
static const float margin_px = 2.0f;

stp_result stp_gl_splat_groups_make(stp_gl_renderer* r, uint32_t index, uint32_t octaves,
                                    stp_gl_splat_groups* groups)
{
    assert(octaves > 0 && index < r->list->count);
    const stp_gl_placed* placed = &r->frame.placed[index];
    const stp_draw_item* draw = placed->draw;
    *groups = (stp_gl_splat_groups){.groups = NULL};
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    if ((known->columns & STP_SPLATS_RANGES) == 0 || r->omits.groups) {
        return STP_OK;
    }
    stp_splats resident; // the resident ones: the store may hold fewer than the pool
    stp_result result = stp_store_get_splat_set_prefix(r->store, draw->index, octaves, &resident);
    if (result != STP_OK || resident.groups == NULL) {
        return result;
    }
    groups->groups = resident.groups;
    groups->beside = (r->frame.items[index].flags & ITEM_BESIDE) != 0;
    bool whole = resident.count == known->octave_ends[octaves - 1]; // the last group too
    groups->count = (resident.count + (whole ? STP_GROUP_SPLATS - 1 : 0)) / STP_GROUP_SPLATS;
    stp_placed_item where;
    stp_placement_place(&r->placement, draw, placed->offset, &where);
    const stp_raster_splats splats = {.positions = resident.positions,
                                      .origin = placed->origin,
                                      .step = placed->step,
                                      .radius = placed->radius};
    const stp_raster_frame frame = {.width = r->target.width,
                                    .height = r->target.height,
                                    .margin = margin_px,
                                    .one_sided = stp_draw_one_sided(draw, r->layer_pass.of_splats)};
    groups->view = stp_raster_groups_make(&where.camera, &splats, &frame);
    return STP_OK;
}

/// Splats [begin, end) of an item.
typedef struct splat_range {
    uint32_t begin, end;
} splat_range;

static bool is_dropped(const stp_gl_splat_groups* groups, uint32_t group)
{
    if (group >= groups->count) {
        return false;
    }
    const stp_splat_group* g = &groups->groups[group];
    return (groups->beside && g->replaced == UINT64_MAX) ||
           stp_raster_drops_group(&groups->view, g);
}

/// First part of a range that one command draws. Includes short runs of invisible groups. @return
/// false if nothing is drawn
static bool find_part(const stp_gl_splat_groups* groups, splat_range range, splat_range* part)
{
    *part = range;
    if (groups == NULL || groups->groups == NULL || range.begin == range.end) {
        return range.begin < range.end;
    }
    uint32_t group = range.begin / STP_GROUP_SPLATS, end = (range.end - 1) / STP_GROUP_SPLATS + 1;
    while (group < end && is_dropped(groups, group)) {
        group += 1;
    }
    uint32_t last = group; // possibly visible
    for (uint32_t i = group + 1; i < end && i - last <= GAP + 1; ++i) {
        last = is_dropped(groups, i) ? last : i;
    }
    uint32_t first = group * STP_GROUP_SPLATS, after = (last + 1) * STP_GROUP_SPLATS;
    part->begin = first > range.begin ? first : range.begin;
    part->end = last + 1 < end ? after : range.end;
    assert(group == end || (part->begin < part->end && part->end <= range.end));
    return group < end;
}

static bool add_command(stp_gl_renderer* r, uint32_t index, const stp_gl_splat_chunk* chunk,
                        splat_range range, const stp_draw_run* run)
{
    assert(chunk->begin <= range.begin && range.begin < range.end && range.end <= chunk->end);
    const stp_draw_item* draw = r->frame.placed[index].draw;
    uint32_t count = range.end - range.begin, before = range.begin - chunk->begin;
    record_block* record = stp_gl_frame_add_command(r, GL_COMMANDS_SPLATS, count);
    if (record == NULL) {
        return false;
    }
    record->item = index;
    record->first = range.begin;
    record->address = chunk->places + chunk->place_words * before;
    record->options = chunk->options + chunk->option_words * before;
    if (chunk->of_materials) {
        record->options += before / 4;
        record->share = (float)(before % 4);
    }
    record->reach = chunk->reach;
    if (run != NULL && (run->nearest != 0.0f || run->farthest != 0.0f)) {
        record->nearest = run->nearest;
        record->farthest = run->farthest;
    }
    return draw->kind != STP_DRAW_SPLATS || !r->layer_pass.active || !r->layer_pass.of_splats ||
           stp_gl_frame_repeat_command(r, GL_COMMANDS_GLASS_SPLATS, count);
}

bool stp_gl_splat_commands_add(stp_gl_renderer* r, uint32_t index, const stp_gl_splat_chunk* chunk,
                               const stp_gl_splat_groups* groups)
{
    const stp_draw_item* draw = r->frame.placed[index].draw;
    const stp_draw_run* runs = draw->run_count > 0 ? r->list->runs + draw->first_run : NULL;
    for (uint32_t run = 0; run < (runs != NULL ? draw->run_count : 1); ++run) {
        splat_range part, left = {chunk->begin, chunk->end};
        if (runs != NULL) {
            left.begin = runs[run].begin > left.begin ? runs[run].begin : left.begin;
            left.end = runs[run].end < left.end ? runs[run].end : left.end;
        }
        for (; left.begin < left.end && find_part(groups, left, &part); left.begin = part.end) {
            if (!add_command(r, index, chunk, part, runs != NULL ? &runs[run] : NULL)) {
                return false;
            }
        }
    }
    return true;
}
