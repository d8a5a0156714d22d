// SPDX-License-Identifier: MIT
//
// Surface cache: each worker looks up an id once, and keeps its surface until another id needs the
// slot. If a tile needs a slot twice, it uses private extra slots.
#include "draw/cpu/layers.h"
#include "draw/cpu/shade.h"
#include "draw/cpu/triangle.h"
#include "raster/splats_transparent.h"

#include <assert.h>
#include <string.h>

void stp_cpu_reset_surfaces(stp_cpu_shade_memory* memory)
{
    for (int i = 0; i < SHADE_KEPT; ++i) {
        memory->slots[i].id = UINT32_MAX;
        memory->slots[i].tile = 0;
    }
    memory->tile_count = memory->last_item = 0;
    stp_cpu_reset_triangles(memory->triangles);
}

stp_cpu_shade_tile* stp_cpu_begin_tile(stp_cpu_shade_memory* memory)
{
    uint32_t which = memory->tile_count++ & 1;
    stp_cpu_shade_tile* tile = &memory->tiles[which];
    tile->number = memory->tile_count + 1; // above 1: slots with 0 are free
    tile->extra = SHADE_CACHE + which * SHADE_PIXELS;
    tile->miss_count = 0;
    return tile;
}

uint32_t stp_cpu_find_surface(stp_cpu_shade_memory* memory, stp_cpu_shade_tile* tile, uint32_t id)
{
    assert(id != UINT32_MAX && "the background has no surface");
    uint32_t at = id * 0x9E3779B1u >> (32 - SHADE_CACHE_BITS);
    if (memory->slots[at].id == id) {
        memory->slots[at].tile = tile->number;
        return at;
    }
    if (memory->slots[at].tile + 1 >= tile->number) {
        at = tile->extra++;
    }
    assert(at < SHADE_KEPT && tile->miss_count < SHADE_PIXELS && "at most one per pixel");
    memory->slots[at].id = id;
    memory->slots[at].tile = tile->number;
    tile->misses[tile->miss_count++] = (uint16_t)at;
    return at;
}

static void turn(const stp_cpu_shade_item* item, float x, float y, float z, float out[3])
{
    for (int k = 0; k < 3; ++k) {
        const float* m = item->normal_matrix[k];
        out[k] = m[0] * x + m[1] * y + m[2] * z;
    }
}

/// stp_octahedral_decode without normalization
static void turn_code(const stp_cpu_shade_item* item, const int8_t* code, float out[3])
{
    float u = (float)code[0], v = (float)code[1];
    float z = 127.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    turn(item, u, v, z, out);
}

/// Direction and spread of the normals of what a splat stands for. Between octaves, means are mixed
/// with their lengths.
static void find_light(const stp_cpu_shade_item* item, size_t index, float out[4])
{
    const int8_t* own = item->normals + 2 * index;
    out[3] = 0.0f;
    if (item->lights.turns == NULL && item->low_lights.turns == NULL) {
        turn_code(item, own, out);
        return;
    }
    stp_vec3 mean = stp_light_normal(&item->lights, own, index);
    if (index < item->low_count) {
        stp_vec3 low = stp_light_normal(&item->low_lights, own, index);
        mean = stp_add(low, stp_scale(stp_sub(mean, low), item->blend));
    }
    float square = stp_dot(mean, mean);
    out[3] = 1.0f - stp_min(sqrtf(square), 1.0f);
    if (square > 0.0f) {
        turn(item, mean.x, mean.y, mean.z, out);
    } else {
        turn_code(item, own, out);
    }
}

/// Opacity of a transparent splat.
static float stp_cpu_find_opacity(const stp_cpu_renderer* r, const stp_cpu_shade_item* shade,
                                  uint32_t index)
{
    const stp_cpu_item* item = &r->items[shade - r->shade_items];
    float opacity = 1.0f;
    if (item->coverages != NULL) {
        opacity = stp_transparent_opacity(stp_cpu_coverage_share(item, item->coverages[index]));
        if (index < shade->low_count) {
            float before =
                stp_transparent_opacity(stp_cpu_coverage_share(item, item->low_coverages[index]));
            opacity = before + (opacity - before) * item->blend;
        }
    }
    return item->draw->ghost ? opacity * stp_cpu_ghost_share(r) : opacity;
}

static void make_splat_surface(const stp_cpu_renderer* r, const stp_cpu_shade_item* item,
                               uint32_t index, stp_cpu_shade_surface* surface)
{
    const uint8_t* color = item->colors + 3 * (size_t)index;
    for (int k = 0; k < 3; ++k) {
        surface->color[k] = r->decode[color[k]];
    }
    if (index < item->low_count) {
        const uint8_t* low = item->low_colors + 3 * (size_t)index;
        for (int k = 0; k < 3; ++k) {
            float before = r->decode[low[k]];
            surface->color[k] = before + (surface->color[k] - before) * item->blend;
        }
    }
    find_light(item, index, surface->normal);
    surface->material = r->shade_materials[item->materials[index]];
    if (r->layers.stage == CPU_LAYERS_PEEL) {
        surface->color[3] = stp_cpu_find_opacity(r, item, index);
    }
}

static void make_point(const stp_cpu_renderer* r, uint32_t slot, uint32_t index,
                       stp_cpu_shade_surface* surface)
{
    const stp_store_point_set* points = &r->items[slot].points;
    stp_vec3 normal = {0};
    for (size_t k = 0; k < 3; ++k) {
        surface->color[k] = r->items[slot].material->base_color[k];
        if (points->colors != NULL) {
            surface->color[k] *= r->decode[points->colors[4 * (size_t)index + k]];
        }
    }
    if (points->normals != NULL) {
        normal = stp_cpu_decode_normal(points->normals + 2 * (size_t)index);
    }
    turn(&r->shade_items[slot], normal.x, normal.y, normal.z, surface->normal);
    surface->normal[3] = 0.0f;
    surface->material = r->shade_materials[r->shade_items[slot].material];
}

void stp_cpu_make_splat_surface(const stp_cpu_renderer* r, uint32_t slot, uint32_t index,
                                stp_cpu_shade_surface* surface)
{
    const stp_cpu_shade_item* item = &r->shade_items[slot];
    if (item->kind == STP_DRAW_SPLATS) {
        make_splat_surface(r, item, index, surface);
    } else {
        make_point(r, slot, index, surface);
    }
}

static void prefetch_splat(const stp_cpu_shade_item* item, size_t index)
{
    __builtin_prefetch(item->colors + 3 * index);
    __builtin_prefetch(item->normals + 2 * index);
    __builtin_prefetch(item->materials + index);
    if (item->lights.turns != NULL) {
        __builtin_prefetch(item->lights.turns + 2 * index);
        __builtin_prefetch(item->lights.spreads + index);
    }
    if (index < item->low_count) {
        __builtin_prefetch(item->low_colors + 3 * index);
    }
}

void stp_cpu_prefetch_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                               const stp_cpu_shade_tile* tile)
{
    uint32_t slot = memory->last_item;
    for (uint32_t i = 0; i < tile->miss_count; ++i) {
        uint32_t at = tile->misses[i], id = memory->slots[at].id;
        const stp_cpu_shade_item* item = &r->shade_items[slot];
        if (id - item->first_id >= item->count) {
            slot = stp_cpu_find_item(r, id);
            item = &r->shade_items[slot];
        }
        assert(id >= item->first_id && slot < r->item_count && "every id belongs to an item");
        memory->item[at] = slot;
        if (item->kind == STP_DRAW_SPLATS) {
            prefetch_splat(item, id - item->first_id);
        } else if (item->kind == STP_DRAW_MESH) {
            stp_cpu_prefetch_triangle(r, memory, at);
        }
    }
    memory->last_item = slot;
}

void stp_cpu_make_surfaces(const stp_cpu_renderer* r, stp_cpu_shade_memory* memory,
                           stp_cpu_shade_tile* tile)
{
    for (uint32_t i = 0; i < tile->miss_count; ++i) {
        uint32_t at = tile->misses[i], slot = memory->item[at];
        const stp_cpu_shade_item* item = &r->shade_items[slot];
        stp_cpu_shade_surface* surface = &memory->surfaces[at];
        uint32_t index = memory->slots[at].id - item->first_id;
        assert((item->kind == STP_DRAW_MESH || index < item->count) && "a splat of the item");
        memory->nearness[at] = item->nearness;
        memory->kind[at] = SHADE_FLAT;
        memory->splats[at] = item->kind != STP_DRAW_MESH ? 1 : 0;
        if (item->kind != STP_DRAW_MESH) {
            stp_cpu_make_splat_surface(r, slot, index, surface);
        } else {
            memory->kind[at] = (uint8_t)stp_cpu_make_triangle_surface(r, memory, at);
        }
    }
    tile->miss_count = 0;
}

stp_cpu_shade_memory* stp_cpu_make_shade_memory(stp_context* context)
{
    const size_t line = 64;
    stp_cpu_shade_memory* memory = STP_NEW_ZEROED(context, stp_cpu_shade_memory, 1);
    if (memory == NULL) {
        return NULL;
    }
    memory->triangles = stp_cpu_make_triangle_memory(context);
    memory->room = STP_NEW_ZEROED(context, unsigned char,
                                  SHADE_SURFACES * sizeof(stp_cpu_shade_surface) + line);
    if (memory->triangles == NULL || memory->room == NULL) {
        stp_cpu_destroy_shade_memory(context, memory);
        return NULL;
    }
    size_t past = (uintptr_t)memory->room % line;
    void* begin = memory->room + (line - past) % line;
    assert((uintptr_t)begin % sizeof(stp_cpu_shade_surface) == 0 && "one cache line each");
    memory->surfaces = begin;
    return memory;
}

void stp_cpu_destroy_shade_memory(stp_context* context, stp_cpu_shade_memory* memory)
{
    if (memory != NULL) {
        stp_free(context, memory->triangles);
        stp_free(context, memory->room);
        stp_free(context, memory);
    }
}
