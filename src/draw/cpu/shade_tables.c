// SPDX-License-Identifier: MIT
// Lookup tables of shading: materials, once per renderer; items, and the item of each id, once per
// frame.
#include "draw/cpu/shade.h"

#include <assert.h>

enum { SHADINGS = 256, ID_TABLE_SIZE = 1 << 16 };

stp_cpu_shade_material stp_cpu_make_shade_material(float metallic, float roughness,
                                                   const float emissive[3], bool unlit)
{
    float a = stp_max(roughness, 0.25f);
    float a2 = a * a * a * a;
    return (stp_cpu_shade_material){.metallic = metallic,
                                    .rough = (a - 0.25f) * (1.0f / 0.75f),
                                    .a2 = a2,
                                    .gloss = 1.0f / (4.0f * a2 + 0.2f),
                                    .emissive = {emissive[0], emissive[1], emissive[2]},
                                    .unlit = unlit ? 1.0f : 0.0f};
}

stp_result stp_cpu_make_shade_materials(stp_cpu_renderer* r)
{
    const stp_store_directory* d = r->directory;
    size_t count = d->material_count;
    r->shade_materials =
        STP_NEW_ARRAY(r->base.context, stp_cpu_shade_material, SHADINGS + 2 * count);
    if (r->shade_materials == NULL) {
        return stp_fail_memory(r->base.context);
    }
    const float dark[3] = {0};
    if (stp_any_growth(d->shadings, d->shading_count)) {
        r->growths = STP_NEW_ZEROED(r->base.context, float, SHADINGS);
        if (r->growths == NULL) {
            return stp_fail_memory(r->base.context);
        }
        for (uint32_t i = 0; i < d->shading_count; ++i) {
            r->growths[i] = d->shadings[i].growth;
        }
    }
    for (uint32_t i = 0; i < SHADINGS; ++i) {
        r->shade_materials[i] = stp_cpu_make_shade_material(0.0f, 1.0f, dark, false);
        if (i < d->shading_count) {
            const stp_shading* s = &d->shadings[i];
            bool unlit = (s->flags & STP_SHADING_UNLIT) != 0;
            r->shade_materials[i] =
                stp_cpu_make_shade_material(s->metallic, s->roughness, s->emissive, unlit);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        const stp_store_material* m = &d->materials[i];
        bool unlit = (m->flags & STP_SHADING_UNLIT) != 0;
        stp_cpu_shade_material* made = r->shade_materials + SHADINGS + i;
        made[0] = stp_cpu_make_shade_material(m->metallic, m->roughness, m->emissive, unlit);
        made[count] = made[0];
        made[count].unlit = 1.0f;
    }
    return STP_OK;
}

static stp_cpu_shade_item make_item(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    stp_cpu_shade_item made = {.kind = item->kind,
                               .first_id = item->first_id,
                               .count = item->count,
                               .blend = item->blend,
                               .nearness = {item->near_factor, item->near_shift}};
    for (int k = 0; k < 9; ++k) {
        made.normal_matrix[k / 3][k % 3] = item->normal_matrix[k / 3][k % 3];
    }
    if (item->kind == STP_DRAW_SPLATS) {
        made.colors = item->colors;
        made.low_colors = item->low_colors;
        made.low_count = item->blend < 1.0f ? item->low_count : 0;
        made.normals = item->splats.normals;
        made.lights = item->lights;
        if (made.low_count > 0) {
            made.low_lights = item->low_lights;
        }
        made.materials = item->splats.materials;
    } else {
        uint32_t number = (uint32_t)(item->material - r->directory->materials);
        bool unlit = item->kind == STP_DRAW_POINTS && item->points.normals == NULL;
        made.material = SHADINGS + number + (unlit ? r->directory->material_count : 0);
    }
    return made;
}

/// Item of the first id in each run of 2^id_shift ids, plus a last entry.
static void index_ids(stp_cpu_renderer* r, uint64_t id_count)
{
    uint32_t item = 0, last = (uint32_t)r->item_count - 1;
    uint64_t runs = (id_count >> r->id_shift) + 1;
    assert(runs < ID_TABLE_SIZE + 2 && "there is a last entry");
    for (uint64_t run = 0; run < runs; ++run) {
        while (item < last && r->first_ids[item + 1] <= run << r->id_shift) {
            item += 1;
        }
        r->id_starts[run] = item;
    }
    r->id_starts[runs] = last;
}

static bool make_room(stp_cpu_renderer* r)
{
    stp_context* context = r->base.context;
    if (r->item_count > r->shade_item_capacity) {
        if (!STP_MAKE_ROOM(context, r->shade_items, r->shade_item_capacity, r->item_count)) {
            return false;
        }
    }
    if (r->item_count > r->first_id_capacity) {
        if (!STP_MAKE_ROOM(context, r->first_ids, r->first_id_capacity, r->item_count)) {
            return false;
        }
    }
    if (r->id_starts == NULL) {
        r->id_starts = STP_NEW_ARRAY(context, uint32_t, ID_TABLE_SIZE + 2);
    }
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        if (r->workers[i].shading == NULL) {
            r->workers[i].shading = stp_cpu_make_shade_memory(context);
        }
        if (r->workers[i].buffers == NULL) {
            r->workers[i].buffers = STP_NEW_ARRAY(context, uint64_t*, r->team.threads);
        }
        if (r->workers[i].shading == NULL || r->workers[i].buffers == NULL) {
            return false;
        }
    }
    return r->id_starts != NULL;
}

stp_result stp_cpu_prepare_shading(stp_cpu_renderer* r, size_t first)
{
    assert(first <= r->item_count);
    if (!make_room(r)) {
        return stp_fail_memory(r->base.context);
    }
    if (r->item_count == 0) {
        return STP_OK;
    }
    for (size_t i = first; i < r->item_count; ++i) {
        r->shade_items[i] = make_item(r, &r->items[i]);
        r->first_ids[i] = r->items[i].first_id;
        assert((i == 0 || r->first_ids[i - 1] <= r->first_ids[i]) && "ids are searched by halving");
    }
    const stp_cpu_item* last = &r->items[r->item_count - 1];
    uint64_t id_count = (uint64_t)last->first_id + last->count;
    r->id_shift = 0;
    while (id_count >> r->id_shift > ID_TABLE_SIZE - 1) {
        r->id_shift += 1;
    }
    index_ids(r, id_count);
    return STP_OK;
}

uint32_t stp_cpu_find_item(const stp_cpu_renderer* r, uint32_t id)
{
    const uint32_t* starts = r->id_starts + (id >> r->id_shift);
    uint32_t low = starts[0], high = starts[1] + 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (r->first_ids[middle] <= id) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(low < r->item_count && r->first_ids[low] <= id);
    return low;
}

void stp_cpu_begin_shading(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        stp_cpu_reset_surfaces(r->workers[i].shading);
    }
}

void stp_cpu_destroy_shading(stp_cpu_renderer* r)
{
    stp_context* context = r->base.context;
    for (uint32_t i = 0; r->workers != NULL && i < r->team.threads; ++i) {
        stp_cpu_destroy_shade_memory(context, r->workers[i].shading);
        stp_free(context, r->workers[i].buffers);
    }
    stp_free(context, r->growths);
    stp_free(context, r->shade_materials);
    stp_free(context, r->shade_items);
    stp_free(context, r->first_ids);
    stp_free(context, r->id_starts);
}
