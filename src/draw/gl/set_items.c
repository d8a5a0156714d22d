// SPDX-License-Identifier: MIT
#include "base/splats/light_normal.h"
#include "base/splats/prefix_table.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "draw/gl/item_commands.h"
#include "draw/gl/upload.h"

#include <assert.h>

/// Drawable part of a set.
typedef struct octaves_here {
    uint32_t places; ///< number of leading octaves with resident positions
    uint32_t colors; ///< index of the octave that provides the colours
} octaves_here;

static stp_gl_upload upload_octaves(stp_gl_renderer* r, uint32_t set, uint32_t places,
                                    uint32_t colors, octaves_here* here)
{
    stp_gl_upload got = GL_UPLOAD_THERE;
    *here = (octaves_here){0};
    while (here->places < places && got == GL_UPLOAD_THERE) {
        got = stp_gl_upload_octave(r, set, here->places, false, here->places == 0);
        here->places += got == GL_UPLOAD_THERE ? 1 : 0;
    }
    assert((got != GL_UPLOAD_THERE || here->places == places) && here->places <= places);
    if (got == GL_UPLOAD_FAILED || here->places == 0) {
        return got;
    }
    // the wanted colours, or the finest resident ones, or at least the coarsest
    stp_gl_upload coloured = stp_gl_upload_octave(r, set, colors, true, colors == 0);
    here->colors = colors;
    while (coloured != GL_UPLOAD_THERE && coloured != GL_UPLOAD_FAILED && here->colors > 0) {
        here->colors -= 1;
        coloured =
            here->colors == 0 ||
                    stp_gl_pool_has(&r->pool, stp_gl_octave_entry(r, set, here->colors, true))
                ? stp_gl_upload_octave(r, set, here->colors, true, here->colors == 0)
                : GL_UPLOAD_LATER;
    }
    return coloured;
}

/// Extends the box of an item's splats by an octave.
static void hold_octave(const stp_gl_renderer* r, uint32_t set, uint32_t octave, item_block* item)
{
    const stp_gl_octave_box* box =
        &r->entries.boxes[stp_gl_octave_entry(r, set, octave, false) / 2];
    for (int k = 0; k < 3; ++k) {
        float low = (float)box->low[k], high = (float)box->high[k];
        item->box_low[k] = octave == 0 ? low : stp_min(item->box_low[k], low);
        item->box_high[k] = octave == 0 ? high : stp_max(item->box_high[k], high);
    }
}

/// Whether splats of a set have radii by their shadings.
static bool has_growths(const stp_gl_renderer* r, const stp_splats* known)
{
    return r->largest_growth > 0.0f && known->columns == 0;
}

/// The splats of an octave, up to the end of the item's prefix.
static stp_gl_splat_chunk find_chunk(const stp_gl_renderer* r, uint32_t set, uint32_t octave,
                                     const chunk_block* chunk, uint32_t prefix)
{
    assert(chunk->begin < chunk->end && chunk->begin < prefix && "octaves hold splats");
    const stp_splats* known = stp_store_describe_splat_set(r->store, set);
    const stp_gl_octave_box* box =
        &r->entries.boxes[stp_gl_octave_entry(r, set, octave, false) / 2];
    uint32_t count = chunk->end - chunk->begin;
    bool shapes = (known->columns & STP_SPLATS_SHAPES) != 0, grows = has_growths(r, known);
    return (stp_gl_splat_chunk){.begin = chunk->begin,
                                .end = prefix < chunk->end ? prefix : chunk->end,
                                .places = chunk->address,
                                .place_words = 2,
                                .options =
                                    chunk->address + 2 * count + (grows ? 0 : (count + 3) / 4),
                                .option_words = stp_gl_option_words(known),
                                .of_materials = grows,
                                .reach = shapes  ? stp_shape_radius(box->largest)
                                         : grows ? 1.0f + r->largest_growth
                                                 : 1.0f};
}

/// Uploads the meshes whose large triangles follow a set, if they replace any splat of these
/// octaves.
static stp_result upload_large(stp_gl_renderer* r, uint32_t index, uint32_t octaves)
{
    const stp_draw_item* set = r->frame.placed[index].draw;
    const stp_draw_item *draw = set + 1, *end = r->list->items + r->list->count;
    bool all = false;
    r->frame.beside = false;
    for (uint32_t k = 0; k < octaves && set->beside_triangles; ++k) {
        all = all || r->entries.boxes[stp_gl_octave_entry(r, set->index, k, false) / 2].replaced;
    }
    for (; all && draw < end && draw->large; ++draw) {
        stp_gl_upload got = stp_gl_upload_mesh(r, draw->index);
        r->frame.missing += got != GL_UPLOAD_THERE ? 1 : 0;
        all = got == GL_UPLOAD_THERE;
        if (got == GL_UPLOAD_FAILED) {
            return r->failure;
        }
    }
    r->frame.beside = all;
    r->frame.items[index].flags |= all ? ITEM_BESIDE : 0u;
    return STP_OK;
}

/// Octaves that an item is drawn with: as wanted, or coarser until the others are uploaded.
typedef struct set_octaves {
    octaves_here here;
    stp_octave_choice choice;
    bool drawn; ///< false: nothing resident yet
} set_octaves;

static stp_result find_octaves(stp_gl_renderer* r, const stp_draw_item* draw, uint32_t prefix,
                               set_octaves* found)
{
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    uint32_t full = draw->full_prefix > prefix ? draw->full_prefix : prefix;
    full = full < known->count ? full : known->count;
    *found = (set_octaves){.choice = stp_placement_choose_octave(known, full)};
    octaves_here* here = &found->here;
    stp_octave_choice* choice = &found->choice;
    stp_gl_upload got =
        upload_octaves(r, draw->index, stp_store_octaves_for(known, prefix), choice->octave, here);
    if (got == GL_UPLOAD_FAILED) {
        return r->failure;
    }
    r->frame.missing += got != GL_UPLOAD_THERE || here->colors < choice->octave ||
                                known->octave_ends[here->places - 1] < prefix
                            ? 1
                            : 0;
    found->drawn = got == GL_UPLOAD_THERE;
    if (!found->drawn) {
        return STP_OK;
    }
    if (here->colors < choice->octave) { // drawn as a complete earlier octave
        *choice = (stp_octave_choice){.octave = here->colors, .blend = 1.0f};
    } else if (choice->blend < 1.0f && choice->low_count > 0 &&
               stp_gl_upload_octave(r, draw->index, choice->octave - 1, true, false) !=
                   GL_UPLOAD_THERE) {
        choice->blend = 1.0f; // until they are resident
        r->frame.missing += 1;
    }
    return STP_OK;
}

/// Reduces an item that draws a state of a set to the nearest state in a shorter prefix. Sets
/// `*prefix` to the state's.
static stp_result cut_shorter_prefix(stp_gl_renderer* r, const stp_draw_item* draw,
                                     uint32_t octaves, uint32_t* prefix, item_block* item)
{
    stp_splats got;
    stp_result result = stp_store_get_splat_set_prefix(r->store, draw->index, octaves, &got);
    if (result != STP_OK || got.ranges == NULL) {
        return result;
    }
    uint32_t here = *prefix < got.count ? *prefix : got.count;
    stp_progressive_cut cut =
        stp_progressive_find_cut(got.ranges, here, draw->prefix - draw->split_count);
    item->level_min = cut.level;
    item->level_below = cut.below;
    item->divide = cut.divide;
    *prefix = cut.end;
    return STP_OK;
}

/// Address of an octave's light normals, behind its colours; NO_ADDRESS: none.
static uint32_t find_lights(const stp_splats* known, uint32_t octave, uint32_t colors)
{
    return stp_has_light_normals(known, octave) ? colors + known->octave_ends[octave] : NO_ADDRESS;
}

/// Sets colours and splat size of an item, and limits its prefix to the drawn part.
static stp_result begin_item(stp_gl_renderer* r, uint32_t index, const set_octaves* octaves,
                             uint32_t* prefix)
{
    stp_gl_placed* placed = &r->frame.placed[index];
    const stp_draw_item* draw = placed->draw;
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    item_block* item = &r->frame.items[index];
    stp_octave_choice choice = octaves->choice;
    assert(octaves->drawn && octaves->here.places > 0 && choice.octave < known->octave_count);
    uint32_t maximum = known->octave_ends[octaves->here.places - 1];
    maximum =
        maximum < known->octave_ends[choice.octave] ? maximum : known->octave_ends[choice.octave];
    if (maximum < *prefix) { // fewer, larger splats
        *prefix = maximum;
        float reached = stp_prefix_table_radius(&known->table, maximum);
        bool own = (item->flags & ITEM_SHAPES) != 0;
        placed->radius =
            own ? placed->radius : stp_max(placed->radius, reached + known->candidate_radius);
        item->level_min = stp_max(item->level_min, reached);
        stp_result result = draw->split_count > 0
                                ? cut_shorter_prefix(r, draw, octaves->here.places, prefix, item)
                                : STP_OK;
        if (result != STP_OK) {
            return result;
        }
    }
    assert(*prefix <= maximum && "resident, with colours");
    item->count = *prefix;
    item->colors = stp_gl_address(r, stp_gl_octave_entry(r, draw->index, choice.octave, true));
    item->lights = find_lights(known, choice.octave, item->colors);
    item->low_lights = NO_ADDRESS;
    item->blend = choice.blend;
    if (choice.blend < 1.0f && choice.low_count > 0) {
        item->low_count = choice.low_count;
        item->low_colors =
            stp_gl_address(r, stp_gl_octave_entry(r, draw->index, choice.octave - 1, true));
        item->low_lights = find_lights(known, choice.octave - 1, item->low_colors);
    }
    return STP_OK;
}

static stp_result add_octaves(stp_gl_renderer* r, uint32_t index, uint32_t prefix, uint32_t octaves)
{
    const stp_draw_item* draw = r->frame.placed[index].draw;
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    item_block* item = &r->frame.items[index];
    stp_gl_splat_groups groups = {.groups = NULL};
    stp_result result = upload_large(r, index, octaves);
    result = result == STP_OK ? stp_gl_splat_groups_make(r, index, octaves, &groups) : result;
    if (result != STP_OK) {
        return result;
    }
    item->first_chunk = (uint32_t)r->frame.chunk_count;
    for (uint32_t k = 0, begin = 0; k < octaves && begin < prefix; ++k) {
        chunk_block* chunk = stp_gl_frame_add_chunk(r, item);
        if (chunk == NULL) {
            return stp_fail_memory(r->base.context);
        }
        *chunk = (chunk_block){
            .begin = begin,
            .end = known->octave_ends[k],
            .address = stp_gl_address(r, stp_gl_octave_entry(r, draw->index, k, false))};
        begin = chunk->end;
        hold_octave(r, draw->index, k, item);
        stp_gl_splat_chunk splats = find_chunk(r, draw->index, k, chunk, prefix);
        if (!stp_gl_splat_commands_add(r, index, &splats, &groups)) {
            return stp_fail_memory(r->base.context);
        }
    }
    return STP_OK;
}

stp_result stp_gl_set_item_make(stp_gl_renderer* r, uint32_t index)
{
    stp_gl_placed* placed = &r->frame.placed[index];
    const stp_draw_item* draw = placed->draw;
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    item_block* item = &r->frame.items[index];
    placed->origin = known->origin;
    placed->step = known->step;
    r->frame.beside = false;
    placed->unknown_signs = known->unknown_signs;
    bool sides = !known->unknown_signs && stp_affine_is_similarity(&draw->transform);
    item->flags |= sides ? 0u : ITEM_SIDELESS;
    if ((known->columns & STP_SPLATS_SHAPES) != 0 && (item->flags & ITEM_FIXED) == 0) {
        item->flags |= ITEM_SHAPES;
        float larger = draw->shape_scale > 0.0f ? draw->shape_scale : 1.0f;
        placed->radius = known->step * placed->scale * larger;
    }
    if (has_growths(r, known) && (item->flags & ITEM_FIXED) == 0) {
        item->flags |= ITEM_GROWTHS;
    }
    if ((known->columns & STP_SPLATS_RANGES) != 0) {
        item->flags |= ITEM_RANGES;
        item->level_per_depth = draw->level_per_depth;
        item->level_min = draw->level_min;
        item->level_below = draw->level_below;
        item->divide = draw->divide;
    }
    if ((known->columns & STP_SPLATS_ERRORS) != 0) {
        item->flags |= ITEM_ERRORS;
    }
    uint32_t prefix = draw->prefix < known->count ? draw->prefix : known->count;
    set_octaves octaves;
    if (prefix == 0) {
        return STP_OK;
    }
    stp_result result = find_octaves(r, draw, prefix, &octaves);
    if (result != STP_OK || !octaves.drawn) {
        return result;
    }
    result = begin_item(r, index, &octaves, &prefix);
    return result == STP_OK ? add_octaves(r, index, prefix, octaves.here.places) : result;
}
