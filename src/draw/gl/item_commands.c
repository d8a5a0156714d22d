// SPDX-License-Identifier: MIT
// Turns a draw list into blocks, records and commands.
#include "draw/gl/item_commands.h"

#include "base/core/context.h"
#include "draw/gl/upload.h"
#include "draw/placement.h"
#include "draw/transparency.h"
#include "raster/splat_groups.h"
#include "raster/splats_kernel.h"

#include <assert.h>

// The same as on the CPU (src/draw/cpu/raster.c).
#define RIM_DEPTH 4.0f
#define BACK_DEPTH 2.0f

static struct stp_gl_command* add_command(stp_gl_renderer* r, stp_gl_command_kind kind)
{
    stp_gl_commands* c = &r->frame.commands[kind];
    if (c->count == c->capacity) {
        if (!STP_MAKE_ROOM(r->base.context, c->commands, c->capacity, c->count + 1)) {
            return NULL;
        }
    }
    return &c->commands[c->count++];
}

bool stp_gl_frame_repeat_command(stp_gl_renderer* r, stp_gl_command_kind kind, uint32_t count)
{
    assert(r->frame.record_count > 0 && "there is a record to repeat");
    struct stp_gl_command* command = add_command(r, kind);
    if (command != NULL) {
        *command = (struct stp_gl_command){count, 1, 0, (uint32_t)r->frame.record_count - 1};
    }
    return command != NULL;
}

record_block* stp_gl_frame_add_command(stp_gl_renderer* r, stp_gl_command_kind kind, uint32_t count)
{
    assert(r->frame.record_count < UINT32_MAX && "commands name their record in 32 bits");
    stp_gl_frame* f = &r->frame;
    struct stp_gl_command* command = add_command(r, kind);
    if (command == NULL) {
        return NULL;
    }
    if (f->record_count == f->record_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, f->records, f->record_capacity, f->record_count + 1)) {
            r->frame.commands[kind].count -= 1;
            return NULL;
        }
    }
    *command = (struct stp_gl_command){count, 1, 0, (uint32_t)f->record_count};
    record_block* record = &f->records[f->record_count++];
    *record =
        (record_block){.share = 1.0f, .nearest = -HUGE_VALF, .farthest = HUGE_VALF, .reach = 1.0f};
    return record;
}

chunk_block* stp_gl_frame_add_chunk(stp_gl_renderer* r, item_block* item)
{
    stp_gl_frame* f = &r->frame;
    if (f->chunk_count == f->chunk_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, f->chunks, f->chunk_capacity, f->chunk_count + 1)) {
            return NULL;
        }
    }
    item->chunk_count += 1;
    return &f->chunks[f->chunk_count++];
}

static stp_result make_points(stp_gl_renderer* r, uint32_t index)
{
    const stp_draw_item* draw = r->frame.placed[index].draw;
    item_block* item = &r->frame.items[index];
    stp_store_point_set points;
    stp_result result = stp_store_get_point_set(r->store, draw->index, &points);
    if (result != STP_OK) {
        return result;
    }
    uint32_t wanted = draw->prefix < points.point_count ? draw->prefix : points.point_count;
    item->material = points.material;
    const float box[2][3] = {{points.bounds.min.x, points.bounds.min.y, points.bounds.min.z},
                             {points.bounds.max.x, points.bounds.max.y, points.bounds.max.z}};
    memcpy(item->box_low, box[0], sizeof(box[0]));
    memcpy(item->box_high, box[1], sizeof(box[1]));
    item->flags |= ITEM_FACING | (points.colors != NULL ? ITEM_HAS_COLORS : 0u) |
                   (points.normals != NULL ? ITEM_HAS_NORMALS : 0u);
    item->first_chunk = (uint32_t)r->frame.chunk_count;
    for (uint32_t begin = 0; begin < wanted; begin += UPLOAD_POINTS) {
        uint32_t left = points.point_count - begin;
        stp_gl_upload got = stp_gl_upload_points(r, draw->index, begin / UPLOAD_POINTS, begin == 0);
        if (got == GL_UPLOAD_FAILED) {
            return r->failure;
        }
        if (got != GL_UPLOAD_THERE) {
            r->frame.missing += 1;
            break;
        }
        chunk_block* chunk = stp_gl_frame_add_chunk(r, item);
        if (chunk == NULL) {
            return stp_fail_memory(r->base.context);
        }
        uint32_t entry = r->entries.point_sets[draw->index] + begin / UPLOAD_POINTS;
        *chunk = (chunk_block){.begin = begin,
                               .end = begin + (left < UPLOAD_POINTS ? left : UPLOAD_POINTS),
                               .address = stp_gl_address(r, entry)};
        item->count = chunk->end < wanted ? chunk->end : wanted;
        assert(begin < item->count && chunk->end <= points.point_count);
        const stp_gl_splat_chunk splats = {.begin = begin,
                                           .end = item->count,
                                           .places = chunk->address,
                                           .place_words = 3,
                                           .reach = 1.0f};
        if (!stp_gl_splat_commands_add(r, index, &splats, NULL)) {
            return stp_fail_memory(r->base.context);
        }
    }
    return STP_OK;
}

static stp_result upload_texture(stp_gl_renderer* r, const stp_store_texture_use* use, bool data,
                                 uint32_t* address)
{
    *address = NO_ADDRESS;
    if (use->texture == STP_STORE_NONE) {
        return STP_OK;
    }
    stp_gl_upload got = stp_gl_upload_texture(r, use->texture, data);
    if (got == GL_UPLOAD_THERE) {
        *address = stp_gl_address(r, r->entries.textures + 2 * use->texture + (data ? 1u : 0u));
    }
    r->frame.missing += got != GL_UPLOAD_THERE ? 1 : 0;
    return got == GL_UPLOAD_FAILED ? r->failure : STP_OK;
}

static stp_result make_mesh(stp_gl_renderer* r, uint32_t index)
{
    const stp_draw_item* draw = r->frame.placed[index].draw;
    item_block* item = &r->frame.items[index];
    const stp_store_mesh* known = stp_store_describe_mesh(r->store, draw->index);
    const stp_store_material* material = &r->directory->materials[known->material];
    item->material = known->material;
    item->count = draw->large ? known->triangle_count : 0;
    if (draw->large && !r->frame.beside) {
        return STP_OK; // all splats of the set are drawn
    }
    stp_result result = upload_texture(r, &material->base_color_texture, false, &item->base_color);
    if (result == STP_OK) {
        result = upload_texture(r, &material->metallic_roughness_texture, true,
                                &item->metallic_roughness);
    }
    if (result == STP_OK) {
        result = upload_texture(r, &material->emissive_texture, false, &item->emissive);
    }
    if (result == STP_OK && material->normal_scale != 0.0f) {
        result = upload_texture(r, &material->normal_texture, true, &item->normal_map);
    }
    stp_gl_upload got = result == STP_OK ? stp_gl_upload_mesh(r, draw->index) : GL_UPLOAD_FAILED;
    if (got != GL_UPLOAD_THERE) {
        r->frame.missing += 1;
        return got == GL_UPLOAD_FAILED ? r->failure : STP_OK;
    }
    item->count = known->triangle_count;
    item->address = stp_gl_address(r, r->entries.meshes + draw->index);
    return draw->large ? stp_gl_cull_large(r, index) : stp_gl_cull_mesh(r, index);
}

static void place_splats(const stp_gl_renderer* r, const stp_gl_placed* placed,
                         const stp_placed_item* where, item_block* item)
{
    static const uint16_t somewhere[3] = {0};
    const stp_raster_target target = {.width = r->target.width, .height = r->target.height};
    bool of_splats = item->kind == KIND_SPLATS;
    float behind = placed->unknown_signs ? 0.0f : BACK_DEPTH;
    stp_raster_splats splats = {.positions = of_splats ? somewhere : NULL,
                                .origin = placed->origin,
                                .step = placed->step,
                                .radius = placed->radius,
                                .rim_depth = of_splats ? RIM_DEPTH : 0.0f,
                                .back_depth = of_splats ? behind : 0.0f};
    if ((item->flags & ITEM_FIXED) != 0) {
        stp_point_radius radius = stp_point_radius_of(r->style, placed->draw);
        splats.radius = radius.units;
        splats.pixels = radius.pixels;
        splats.rim_depth = STP_POINT_RIM_DEPTH;
    }
    stp_splat_frame frame;
    memset(item->rows, 0, sizeof(item->rows)); // nothing is drawn
    if (!stp_splats_make_frame(&frame, &target, 0, target.height, &where->camera, &splats, 0)) {
        return;
    }
    memcpy(item->rows[0], frame.x, sizeof(frame.x));
    memcpy(item->rows[1], frame.y, sizeof(frame.y));
    memcpy(item->rows[2], frame.n, sizeof(frame.n));
    memcpy(item->rows[3], frame.w, sizeof(frame.w));
    for (int k = 0; k < 3; ++k) {
        memcpy(item->turn[k], frame.turn[k], sizeof(frame.turn[k]));
    }
    item->radius_px = frame.radius_px;
    if ((item->flags & ITEM_GROWTHS) != 0) {
        const stp_splats* known = stp_store_describe_splat_set(r->store, placed->draw->index);
        item->growth_share =
            stp_growth_share(known->candidate_radius * placed->scale, placed->radius);
    }
    item->pixels = frame.pixels;
    item->center_x = frame.center_x;
    item->center_y = frame.center_y;
    item->inverse_scale = frame.inverse_scale;
    item->slope_factor = frame.slope_factor;
    item->slope_constant = frame.slope_constant;
    item->rim_depth = frame.rim_depth;
    item->back_depth = frame.back_depth;
    item->near_w = frame.near_w;
    item->far_w = frame.far_w;
    if ((item->flags & ITEM_ERRORS) != 0) {
        stp_raster_find_eye(&where->camera, &splats, item->eye);
    }
}

/// Position of an item, for the placement's shift.
static void place_item(stp_gl_renderer* r, uint32_t index, uint32_t pattern)
{
    const stp_gl_placed* placed = &r->frame.placed[index];
    item_block* item = &r->frame.items[index];
    stp_placed_item where;
    stp_placement_place(&r->placement, placed->draw, placed->offset, &where);
    for (int k = 0; k < 3; ++k) {
        memcpy(item->normal[k], where.normal_matrix[k], sizeof(where.normal_matrix[k]));
    }
    item->near_factor = where.near_factor;
    item->near_shift = where.near_shift;
    item->nearness_limit = where.camera.nearness_limit;
    item->footprint = 1.0f / (where.camera.pixel_scale * where.scale);
    bool own = (item->flags & ITEM_SHAPES) != 0;
    item->glass_radius =
        (own ? placed->draw->radius * placed->scale : placed->radius) * where.scale;
    item->section_slack = item->kind == KIND_SPLATS ? 0.5f * placed->step * where.scale : 0.0f;
    item->seed = stp_placement_seed(placed->draw) + pattern * 0x9E3779B1u;
    if (item->kind != KIND_MESH) {
        place_splats(r, placed, &where, item);
        return;
    }
    for (int k = 0; k < 4; ++k) {
        memcpy(item->rows[k], where.camera.matrix.m[k], sizeof(where.camera.matrix.m[k]));
    }
}

void stp_gl_frame_place(stp_gl_renderer* r, uint32_t pattern)
{
    for (size_t i = 0; i < r->frame.item_count; ++i) {
        place_item(r, (uint32_t)i, pattern);
    }
}

static stp_result make_item(stp_gl_renderer* r, uint32_t index)
{
    const stp_draw_item* draw = &r->list->items[index];
    item_block* item = &r->frame.items[index];
    stp_gl_placed* placed = &r->frame.placed[index];
    float scale = r->style->splat_scale > 0.0f ? r->style->splat_scale : 1.0f;
    *placed = (stp_gl_placed){.draw = draw, .scale = scale, .radius = draw->radius * scale};
    *item = (item_block){
        .kind = (uint32_t)draw->kind,
        .first_id = draw->first_id,
        .flags = (draw->ghost ? ITEM_GHOST : 0u) |
                 (stp_point_size_is_fixed(r->style, draw) ? ITEM_FIXED | ITEM_FACING : 0u),
        .sections = draw->sections,
        .blend = 1.0f,
        .base_color = NO_ADDRESS,
        .metallic_roughness = NO_ADDRESS,
        .emissive = NO_ADDRESS,
        .normal_map = NO_ADDRESS};
    switch (draw->kind) {
    case STP_DRAW_SPLATS:
        return stp_gl_set_item_make(r, index);
    case STP_DRAW_POINTS:
        return make_points(r, index);
    case STP_DRAW_MESH:
        break;
    }
    stp_box box = stp_store_describe_mesh(r->store, draw->index)->bounds;
    item->glass_cells = stp_transparency_cells(box);
    stp_mesh_offset(r->store, r->directory, draw, placed->offset);
    memcpy(item->offset, placed->offset, sizeof(placed->offset));
    place_item(r, index, 0);
    return make_mesh(r, index);
}

/// Item of the first id in each run of 2^id_shift ids, a last entry, and all first ids.
static stp_result make_lookup(stp_gl_renderer* r)
{
    stp_gl_frame* f = &r->frame;
    size_t needed = ID_TABLE + 2 + f->item_count;
    if (needed > f->lookup_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, f->lookup, f->lookup_capacity, needed)) {
            return stp_fail_memory(r->base.context);
        }
    }
    f->lookup_count = needed;
    uint32_t* first_ids = f->lookup + ID_TABLE + 2;
    uint64_t id_count = 0;
    for (size_t i = 0; i < f->item_count; ++i) {
        first_ids[i] = f->items[i].first_id;
        assert((i == 0 || first_ids[i - 1] <= first_ids[i]) && "ids are searched by halving");
        id_count = (uint64_t)f->items[i].first_id + f->items[i].count;
    }
    f->id_shift = 0;
    while (id_count >> f->id_shift > ID_TABLE - 1) {
        f->id_shift += 1;
    }
    uint32_t item = 0, last = f->item_count > 0 ? (uint32_t)f->item_count - 1 : 0;
    uint64_t runs = (id_count >> f->id_shift) + 1;
    assert(runs < ID_TABLE + 2 && "there is a last entry");
    for (uint64_t run = 0; run < runs; ++run) {
        while (item < last && first_ids[item + 1] <= run << f->id_shift) {
            item += 1;
        }
        f->lookup[run] = item;
    }
    f->lookup[runs] = last;
    return STP_OK;
}

static bool make_room(stp_gl_renderer* r, size_t count)
{
    stp_gl_frame* f = &r->frame;
    if (count > f->item_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, f->items, f->item_capacity, count)) {
            return false;
        }
    }
    if (count > f->placed_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, f->placed, f->placed_capacity, count)) {
            return false;
        }
    }
    return true;
}

/// Data without a coarser stand-in comes first, for all items: if memory is short, finer data is
/// evicted.
static stp_result upload_urgent(stp_gl_renderer* r)
{
    for (size_t i = 0; i < r->list->count; ++i) {
        const stp_draw_item* draw = &r->list->items[i];
        stp_gl_upload got = GL_UPLOAD_THERE;
        if (draw->large) {
            continue; // the set represents them
        }
        if (draw->kind == STP_DRAW_MESH) {
            got = stp_gl_upload_mesh(r, draw->index);
        } else if (draw->kind == STP_DRAW_POINTS) {
            got = draw->prefix > 0 ? stp_gl_upload_points(r, draw->index, 0, true) : got;
        } else if (stp_store_describe_splat_set(r->store, draw->index)->octave_count > 0) {
            got = stp_gl_upload_octave(r, draw->index, 0, false, true);
            got =
                got == GL_UPLOAD_THERE ? stp_gl_upload_octave(r, draw->index, 0, true, true) : got;
        }
        if (got == GL_UPLOAD_FAILED) {
            return r->failure;
        }
    }
    return STP_OK;
}

stp_result stp_gl_frame_make(stp_gl_renderer* r)
{
    stp_gl_frame* f = &r->frame;
    size_t count = r->list->count;
    if (!make_room(r, count)) {
        return stp_fail_memory(r->base.context);
    }
    f->record_count = f->chunk_count = f->item_count = 0;
    f->large_count = 0;
    f->drawn_triangles = r->eye == 0 ? 0 : f->drawn_triangles; // of all eyes
    if (r->eye == 0) { // for the picture, not only its last eye
        f->missing = f->coming = 0;
        f->uploaded_bytes = 0;
    }
    r->failure = STP_ERROR_UNSUPPORTED;
    for (int i = 0; i < GL_COMMAND_KINDS; ++i) {
        f->commands[i].count = 0;
    }
    stp_gl_pool_begin_frame(&r->pool);
    stp_result result = upload_urgent(r);
    result = result == STP_OK ? stp_gl_cluster_shares_find(r) : result;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        result = make_item(r, (uint32_t)i);
        f->item_count = i + 1;
    }
    assert((result != STP_OK || f->item_count == count) && "items have the numbers of the list's");
    result = result == STP_OK ? stp_gl_conversions_send(&r->conversions, &r->pool) : result;
    if (result != STP_OK) {
        stp_gl_conversions_drop(&r->conversions, &r->pool);
        return result;
    }
    return make_lookup(r);
}

void stp_gl_frame_destroy(stp_gl_renderer* r)
{
    stp_gl_frame* f = &r->frame;
    stp_context* context = r->base.context;
    stp_gl_ring_destroy(&r->gl, &f->ring);
    r->gl.DeleteBuffers(1, &f->buffer);
    stp_gl_cluster_shares_destroy(context, &f->shares);
    for (int i = 0; i < GL_COMMAND_KINDS; ++i) {
        stp_free(context, f->commands[i].commands);
    }
    stp_free(context, f->items);
    stp_free(context, f->placed);
    stp_free(context, f->records);
    stp_free(context, f->chunks);
    stp_free(context, f->lookup);
    stp_free(context, f->marks);
}
