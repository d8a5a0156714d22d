// SPDX-License-Identifier: MIT
#include "support_chunks.h"

#include "base/math/rng.h"
#include "base/splats/light_normal.h"

#include <assert.h>
#include <string.h>

/// Random bytes below `levels` (0: zeros). Few levels compress well, 256 do not compress.
static void fill(uint64_t seed, void* bytes, size_t size, uint32_t levels)
{
    unsigned char* out = bytes;
    for (size_t i = 0; i < size; ++i) {
        out[i] = levels == 0 ? 0 : (unsigned char)(stp_rng_hash(seed, i) % levels);
    }
}

static bool make_set(stp_arena* arena, uint64_t seed, const uint32_t* ends, uint32_t octaves,
                     uint32_t columns, stp_splats* set)
{
    assert(octaves > 0 && octaves <= STP_OCTAVE_LIMIT && "the set holds the octaves");
    size_t entries = 0, count = ends[octaves - 1];
    *set = (stp_splats){
        .step = 0.5f, .columns = columns, .octave_count = octaves, .count = ends[octaves - 1]};
    for (uint32_t k = 0; k < octaves; ++k) {
        set->octave_ends[k] = ends[k];
        entries = (columns & STP_SPLATS_FLAT_COLORS) != 0 ? ends[k] : entries + ends[k];
        set->table.count[k] = ends[k];
        set->table.radius[k] = 64.0f / (float)(1u << k);
        set->table.size = k + 1;
    }
    set->positions = stp_arena_alloc(arena, 6 * count);
    set->normals = stp_arena_alloc(arena, 2 * count);
    set->materials = stp_arena_alloc(arena, count);
    set->colors = stp_arena_alloc(arena, 3 * entries);
    set->coverages = stp_arena_alloc(arena, entries);
    set->shapes = stp_arena_alloc(arena, 4 * count);
    set->ranges = stp_arena_alloc(arena, 4 * count);
    set->errors = stp_arena_alloc(arena, 4 * count);
    if (set->shapes == NULL || set->ranges == NULL || set->errors == NULL ||
        set->positions == NULL || set->normals == NULL || set->materials == NULL ||
        set->colors == NULL || set->coverages == NULL) {
        return false;
    }
    fill(seed, set->positions, 6 * count, seed == 0 ? 0 : 256);
    fill(seed + 1, set->normals, 2 * count, seed == 0 ? 0 : 7);
    fill(seed + 2, set->materials, count, seed == 0 ? 0 : 1);
    fill(seed + 3, set->colors, 3 * entries, seed == 0 ? 0 : 3);
    fill(seed + 4, set->coverages, entries, seed == 0 ? 0 : 2);
    for (size_t i = 0; i < count; ++i) {
        set->shapes[i] = (uint32_t)stp_rng_hash(seed + 5, i) & 0xFF0007FFu;
        set->ranges[i] = ((uint32_t)stp_rng_hash(seed + 6, i) & 0x3FFFu) | 0x40000000u;
        set->errors[i] = (uint32_t)stp_rng_hash(seed + 7, i) & 0x0F0FFFFFu;
    }
    set->shapes = (columns & STP_SPLATS_SHAPES) != 0 ? set->shapes : NULL;
    set->ranges = (columns & STP_SPLATS_RANGES) != 0 ? set->ranges : NULL;
    set->errors = (columns & STP_SPLATS_ERRORS) != 0 ? set->errors : NULL;
    return true;
}

/// Gives light normals to all octaves but the second.
static bool add_lights(stp_arena* arena, uint64_t seed, stp_splats* set)
{
    set->light_octaves = ((1u << set->octave_count) - 1) & ~2u;
    size_t entries = (size_t)stp_light_normals_begin(set, set->octave_count);
    set->turns = stp_arena_alloc(arena, 2 * entries);
    set->spreads = stp_arena_alloc(arena, entries);
    if (set->turns == NULL || set->spreads == NULL) {
        return false;
    }
    fill(seed + 8, set->turns, 2 * entries, 9);
    fill(seed + 9, set->spreads, entries, 60);
    return true;
}

bool chunk_sample_make(stp_arena* arena, uint64_t seed, chunk_sample* made)
{
    static const uint32_t ends[CHUNK_SAMPLE_SETS][4] = {
        {100, 5141, 21000, 60000}, {1, 2, 3, 4}, {5041, 5042, 16384, 16385}};
    *made = (chunk_sample){.shading = {0}};
    uint32_t columns = seed % 2 != 0 ? STP_SPLATS_COLUMNS : 0;
    for (uint32_t i = 0; i < CHUNK_SAMPLE_SETS; ++i) {
        if (!make_set(arena, seed == 0 ? 0 : 10 * seed + 100 * i, ends[i], 4, columns,
                      &made->sets[i])) {
            return false;
        }
        if (columns == 0 && seed != 0 && !add_lights(arena, seed, &made->sets[i])) {
            return false;
        }
    }
    made->content = (stp_store_content){
        .directory = {.root = STP_STORE_NONE,
                      .shading_count = 1,
                      .shadings = &made->shading,
                      .set_count = CHUNK_SAMPLE_SETS,
                      .up = 'y'},
        .sets = made->sets,
    };
    made->method = (stp_store_method){
        .name = "spt", .id = STP_METHOD_SPT, .columns = columns, .set_count = CHUNK_SAMPLE_SETS};
    if (columns != 0) {
        made->content.directory.methods = &made->method;
        made->content.directory.method_count = 1;
    }
    return true;
}

bool chunk_sample_is_same(const stp_splats* a, const stp_splats* b)
{
    size_t entries = 0;
    for (uint32_t k = 0; k < a->octave_count; ++k) {
        bool flat = (a->columns & STP_SPLATS_FLAT_COLORS) != 0;
        entries = flat ? a->octave_ends[k] : entries + a->octave_ends[k];
    }
    size_t lights = (size_t)stp_light_normals_begin(a, a->octave_count);
    return a->count == b->count && a->light_octaves == b->light_octaves &&
           (lights == 0 || (memcmp(a->turns, b->turns, 2 * lights) == 0 &&
                            memcmp(a->spreads, b->spreads, lights) == 0)) &&
           a->octave_count == b->octave_count &&
           memcmp(a->octave_ends, b->octave_ends, sizeof(a->octave_ends)) == 0 &&
           memcmp(a->positions, b->positions, 6 * (size_t)a->count) == 0 &&
           memcmp(a->normals, b->normals, 2 * (size_t)a->count) == 0 &&
           memcmp(a->materials, b->materials, a->count) == 0 &&
           memcmp(a->colors, b->colors, 3 * entries) == 0 &&
           memcmp(a->coverages, b->coverages, entries) == 0 && a->columns == b->columns &&
           (a->shapes == NULL || memcmp(a->shapes, b->shapes, 4 * (size_t)a->count) == 0) &&
           (a->ranges == NULL || memcmp(a->ranges, b->ranges, 4 * (size_t)a->count) == 0) &&
           (a->errors == NULL || memcmp(a->errors, b->errors, 4 * (size_t)a->count) == 0);
}
