// SPDX-License-Identifier: MIT
// Prepares draw items: looks up data and textures, computes matrices from item to screen.
#include "draw/cpu/cpu.h"
#include "draw/placement.h"
#include "raster/cutout.h"
#include "store/bytes/columns.h"

#include <assert.h>
#include <string.h>

static void place_item(const stp_placement* placement, const stp_draw_item* draw,
                       stp_cpu_item* item)
{
    stp_placed_item placed;
    stp_placement_place(placement, draw, item->offset, &placed);
    item->camera = placed.camera;
    item->near_factor = placed.near_factor;
    item->near_shift = placed.near_shift;
    item->scale = placed.scale;
    memcpy(item->normal_matrix, placed.normal_matrix, sizeof(item->normal_matrix));
}

void stp_cpu_place_items(stp_cpu_renderer* r, const stp_draw_list* list, size_t first)
{
    assert(first <= r->item_count && r->item_count <= list->count && "prepared items");
    const stp_placement placement = {.frame = r->frame,
                                     .nearness_scale = r->nearness_scale,
                                     .nearness_offset = r->nearness_offset,
                                     .mesh_depth = r->mesh_depth,
                                     .shift_x = r->shift_x,
                                     .shift_y = r->shift_y};
    for (size_t i = r->placed == r->eye ? first : 0; i < r->item_count; ++i) {
        place_item(&placement, &list->items[i], &r->items[i]);
        stp_cpu_place_occluder(r, &list->items[i], &r->items[i]);
    }
    r->placed = r->eye;
}

/// Colours and light of a prefix's octave, and of the previous octave.
static void choose_octave(stp_cpu_item* item, const stp_splats* splats, uint32_t prefix)
{
    stp_octave_choice choice = stp_placement_choose_octave(splats, prefix);
    uint32_t lower = choice.octave > 0 ? choice.octave - 1 : 0;
    size_t first = (size_t)stp_store_colors_begin(splats, choice.octave);
    size_t low_first = (size_t)stp_store_colors_begin(splats, lower);
    item->colors = splats->colors + 3 * first;
    item->low_colors = splats->colors + 3 * low_first;
    item->coverages = splats->coverages != NULL ? splats->coverages + first : NULL;
    item->low_coverages = splats->coverages != NULL ? splats->coverages + low_first : NULL;
    item->lights = stp_light_normals_of(splats, choice.octave);
    item->low_lights = stp_light_normals_of(splats, lower);
    item->low_count = choice.low_count;
    item->blend = choice.blend;
}

/// Decodes a texture on first use.
static stp_result find_texture(stp_cpu_renderer* r, const stp_store_texture_use* use, bool data,
                               const stp_texture_pyramid** out)
{
    *out = NULL;
    if (use->texture == STP_STORE_NONE) {
        return STP_OK;
    }
    stp_cpu_texture* texture = &r->textures[use->texture];
    bool* made = data ? &texture->has_data : &texture->has_color;
    stp_texture_pyramid* pyramid = data ? &texture->as_data : &texture->as_color;
    if (!*made) {
        stp_store_texture source;
        stp_result result = stp_store_get_texture(r->store, use->texture, &source);
        if (result != STP_OK) {
            return result;
        }
        result = stp_texture_pyramid_create(r->base.context, source.texels, source.width,
                                            source.height, data, pyramid);
        if (result != STP_OK) {
            return result;
        }
        pyramid->wrap_u = (stp_texture_wrap)source.wrap_u;
        pyramid->wrap_v = (stp_texture_wrap)source.wrap_v;
        pyramid->nearest = source.nearest != 0;
        *made = true;
    }
    *out = pyramid;
    return STP_OK;
}

static void release_texture(stp_cpu_renderer* r, stp_cpu_texture* texture)
{
    if (texture->has_color) {
        stp_texture_pyramid_destroy(r->base.context, &texture->as_color);
    }
    if (texture->has_data) {
        stp_texture_pyramid_destroy(r->base.context, &texture->as_data);
    }
    *texture = (stp_cpu_texture){0};
}

/// Drops decoded data of evicted texels.
static void release_old_textures(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->directory->texture_count; ++i) {
        uint64_t arrival = stp_store_texture_arrival(r->store, i);
        if (r->textures[i].arrival != arrival) {
            release_texture(r, &r->textures[i]);
            r->textures[i].arrival = arrival;
        }
    }
}

void stp_cpu_destroy_textures(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; r->textures != NULL && i < r->directory->texture_count; ++i) {
        release_texture(r, &r->textures[i]);
    }
    stp_free(r->base.context, r->textures);
    stp_free(r->base.context, r->asked);
}

static stp_result find_mesh(stp_cpu_renderer* r, uint32_t index, stp_cpu_item* item)
{
    const stp_store_mesh* known = stp_store_describe_mesh(r->store, index);
    stp_result result = stp_store_is_clustered(r->store, index)
                            ? stp_store_get_clusters(r->store, index, &item->clusters)
                            : stp_store_get_mesh(r->store, index, &item->mesh);
    if (result != STP_OK) {
        return result;
    }
    stp_box box = known->bounds;
    stp_mesh_offset(r->store, r->directory, item->draw, item->offset);
    item->count = known->triangle_count;
    item->unit_count = item->count;
    item->task_units = CPU_TASK_TRIANGLES;
    if (item->clusters.bytes != NULL) {
        item->unit_count = item->clusters.cluster_count;
        item->task_units = CPU_TASK_CLUSTERS;
    }
    result = item->draw->large ? stp_cpu_find_large(r, item) : result;
    if (result != STP_OK) {
        return result;
    }
    const stp_store_material* material = &r->directory->materials[known->material];
    item->material = material;
    result = find_texture(r, &material->base_color_texture, false, &item->base_color);
    if (result == STP_OK && item->base_color != NULL && material->alpha == STP_STORE_MASK) {
        result = stp_cutout_prepare(r->base.context,
                                    &r->textures[material->base_color_texture.texture].as_color);
    }
    if (result == STP_OK) {
        result =
            find_texture(r, &material->metallic_roughness_texture, true, &item->metallic_roughness);
    }
    if (result == STP_OK) {
        result = find_texture(r, &material->emissive_texture, false, &item->emissive);
    }
    if (result == STP_OK && material->normal_scale != 0.0f) {
        result = find_texture(r, &material->normal_texture, true, &item->normal_map);
    }
    bool colors = item->mesh.colors != NULL || (item->clusters.present & STP_COLUMN_COLORS) != 0;
    item->glass = stp_transparency_of_mesh(material, item->base_color != NULL || colors);
    item->cells = stp_transparency_cells(box);
    const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
    uint32_t use_count = stp_store_used_textures(material, uses);
    for (uint32_t i = 0; i < use_count; ++i) {
        item->reads_texcoords[uses[i]->texcoord != 0 ? 1 : 0] = true;
    }
    return result;
}

/// Reads only the octaves that the prefix needs.
static stp_result find_splat_set(stp_cpu_renderer* r, const stp_draw_item* draw, stp_cpu_item* item)
{
    const stp_splats* known = stp_store_describe_splat_set(r->store, draw->index);
    uint32_t full = draw->full_prefix > draw->prefix ? draw->full_prefix : draw->prefix;
    uint32_t octaves = stp_store_octaves_for(known, full > 0 ? full : 1);
    stp_splats got;
    stp_result result = stp_store_get_splat_set_prefix(r->store, draw->index, octaves, &got);
    if (result != STP_OK) {
        return result;
    }
    item->splats = (stp_cpu_splats){.origin = got.origin,
                                    .step = got.step,
                                    .positions = got.positions,
                                    .normals = got.normals,
                                    .materials = got.materials,
                                    .shapes = got.shapes,
                                    .ranges = got.ranges,
                                    .errors = got.errors,
                                    .groups = got.groups,
                                    .plain_coverages = got.plain_coverages,
                                    .unknown_signs = known->unknown_signs};
    item->count = draw->prefix < got.count ? draw->prefix : got.count;
    item->growth_share = stp_growth_share(known->candidate_radius, draw->radius);
    choose_octave(item, &got, full < got.count ? full : got.count);
    return STP_OK;
}

static stp_result prepare_item(stp_cpu_renderer* r, const stp_draw_list* list,
                               const stp_draw_item* draw, stp_cpu_item* item)
{
    stp_result result = STP_OK;
    *item = (stp_cpu_item){
        .kind = draw->kind, .first_id = draw->first_id, .count = draw->prefix, .draw = draw};
    item->seed = stp_placement_seed(draw);
    item->radius = draw->radius * stp_cpu_splat_scale(r);
    if (draw->run_count > 0) {
        item->runs = list->runs + draw->first_run;
    }
    switch (draw->kind) {
    case STP_DRAW_SPLATS:
        result = find_splat_set(r, draw, item);
        break;
    case STP_DRAW_MESH:
        result = find_mesh(r, draw->index, item);
        break;
    case STP_DRAW_POINTS:
        result = stp_store_get_point_set(r->store, draw->index, &item->points);
        if (result == STP_OK) {
            item->count =
                draw->prefix < item->points.point_count ? draw->prefix : item->points.point_count;
            item->material = &r->directory->materials[item->points.material];
        }
        break;
    }
    return result;
}

/// Schedules a texture for decoding, once. @return number of scheduled textures
static uint32_t schedule_texture(stp_cpu_renderer* r, uint32_t texture, uint32_t count)
{
    if (!r->textures[texture].is_asked) {
        assert(count < r->directory->texture_count && "each is scheduled once");
        r->textures[texture].is_asked = true;
        r->asked[count++] = texture;
    }
    return count;
}

/// Decodes textures first used by items from `first`, on all threads.
static void decode_pictures(stp_cpu_renderer* r, const stp_draw_list* list, size_t first)
{
    uint32_t count = 0;
    for (size_t i = first; r->directory->texture_count > 1 && i < list->count; ++i) {
        if (list->items[i].kind == STP_DRAW_MESH) {
            const stp_store_mesh* mesh = stp_store_describe_mesh(r->store, list->items[i].index);
            const stp_store_material* m = &r->directory->materials[mesh->material];
            const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
            uint32_t use_count = stp_store_used_textures(m, uses);
            for (uint32_t k = 0; k < use_count; ++k) {
                count = schedule_texture(r, uses[k]->texture, count);
            }
        }
    }
    if (count > 1) { // a single one is decoded on use
        stp_store_decode_textures(r->store, r->asked, count);
    }
}

/// Makes an item of large triangles that draws none.
static void skip_item(const stp_cpu_renderer* r, const stp_draw_item* draw, stp_cpu_item* item)
{
    const stp_store_mesh* mesh = stp_store_describe_mesh(r->store, draw->index);
    *item = (stp_cpu_item){.kind = draw->kind,
                           .first_id = draw->first_id,
                           .count = mesh->triangle_count,
                           .task_units = CPU_TASK_TRIANGLES,
                           .draw = draw,
                           .material = &r->directory->materials[mesh->material]};
}

stp_result stp_cpu_prepare_items(stp_cpu_renderer* r, const stp_draw_list* list, size_t first)
{
    assert(first <= list->count && (first == 0 || first == r->item_count) && "items are appended");
    if (list->count > r->item_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, r->items, r->item_capacity, list->count)) {
            return stp_fail_memory(r->base.context);
        }
    }
    if (first == 0) {
        r->large_count = 0;
        release_old_textures(r);
    }
    decode_pictures(r, list, first);
    for (size_t i = 0; i < first; ++i) { // the list may have been reallocated
        const stp_draw_item* draw = &list->items[i];
        r->items[i].draw = draw;
        r->items[i].runs = r->items[i].runs != NULL ? list->runs + draw->first_run : NULL;
    }
    r->item_count = first;
    uint64_t tasks = first > 0 ? r->task_count : 0;
    bool leaves_out = false; // whether large triangles replace splats of the set that they follow
    for (size_t i = first; i < list->count; ++i) {
        stp_cpu_item* item = &r->items[i];
        const stp_draw_item* draw = &list->items[i];
        stp_result result = STP_OK;
        assert((i == 0 || item[-1].first_id <= draw->first_id) && "ids ascend");
        if (draw->large && !leaves_out) {
            skip_item(r, draw, item); // no need to read its mesh
        } else {
            result = prepare_item(r, list, draw, item);
        }
        if (result != STP_OK) {
            return result;
        }
        if (item->kind != STP_DRAW_MESH) {
            item->unit_count = item->count;
            item->task_units = CPU_TASK_SPLATS;
        }
        leaves_out = draw->large ? leaves_out : stp_cpu_leaves_out_splats(item);
        item->first_task = (uint32_t)tasks;
        tasks += ((uint64_t)item->unit_count + item->task_units - 1) / item->task_units;
        r->item_count = i + 1;
    }
    assert(tasks <= UINT32_MAX);
    r->task_count = (uint32_t)tasks; // at most one per id plus one per item
    return stp_cpu_prepare_late(r, first);
}
