// SPDX-License-Identifier: MIT
#include "support_chunks.h"

#include "base/rng.h"

#include <string.h>

/// Bytes of which most are alike, so that they compress, but some not at all.
static void fill(uint64_t seed, void* bytes, size_t size, uint32_t levels)
{
    unsigned char* out = bytes;
    for (size_t i = 0; i < size; ++i) {
        out[i] = levels == 0 ? 0 : (unsigned char)(stp_rng_hash(seed, i) % levels);
    }
}

static bool make_set(stp_arena* arena, uint64_t seed, const uint32_t* ends, uint32_t octaves,
                     stp_surfels* set)
{
    size_t entries = 0, count = ends[octaves - 1];
    *set = (stp_surfels){.step = 0.5f, .octave_count = octaves, .count = ends[octaves - 1]};
    for (uint32_t k = 0; k < octaves; ++k) {
        set->octave_ends[k] = ends[k];
        entries += ends[k];
        set->table.count[k] = ends[k];
        set->table.radius[k] = 64.0f / (float)(1u << k);
        set->table.size = k + 1;
    }
    set->positions = stp_arena_alloc(arena, 6 * count);
    set->normals = stp_arena_alloc(arena, 2 * count);
    set->materials = stp_arena_alloc(arena, count);
    set->colors = stp_arena_alloc(arena, 3 * entries);
    set->coverages = stp_arena_alloc(arena, entries);
    if (set->positions == NULL || set->normals == NULL || set->materials == NULL ||
        set->colors == NULL || set->coverages == NULL) {
        return false;
    }
    fill(seed, set->positions, 6 * count, seed == 0 ? 0 : 256);
    fill(seed + 1, set->normals, 2 * count, seed == 0 ? 0 : 7);
    fill(seed + 2, set->materials, count, seed == 0 ? 0 : 1);
    fill(seed + 3, set->colors, 3 * entries, seed == 0 ? 0 : 3);
    fill(seed + 4, set->coverages, entries, seed == 0 ? 0 : 2);
    return true;
}

bool chunk_sample_make(stp_arena* arena, uint64_t seed, chunk_sample* made)
{
    static const uint32_t ends[CHUNK_SAMPLE_SETS][4] = {
        {100, 5141, 21000, 60000}, {1, 2, 3, 4}, {5041, 5042, 16384, 16385}};
    *made = (chunk_sample){.shading = {0}};
    for (uint32_t i = 0; i < CHUNK_SAMPLE_SETS; ++i) {
        if (!make_set(arena, seed == 0 ? 0 : 10 * seed + 100 * i, ends[i], 4, &made->sets[i])) {
            return false;
        }
    }
    made->content = (stp_store_content){
        .directory = {.root = STP_STORE_NONE,
                      .shading_count = 1,
                      .shadings = &made->shading,
                      .surfels_count = CHUNK_SAMPLE_SETS,
                      .up = 'y'},
        .surfels = made->sets,
    };
    return true;
}

bool chunk_sample_is_same(const stp_surfels* a, const stp_surfels* b)
{
    size_t entries = 0;
    for (uint32_t k = 0; k < a->octave_count; ++k) {
        entries += a->octave_ends[k];
    }
    return a->count == b->count && a->octave_count == b->octave_count &&
           memcmp(a->octave_ends, b->octave_ends, sizeof(a->octave_ends)) == 0 &&
           memcmp(a->positions, b->positions, 6 * (size_t)a->count) == 0 &&
           memcmp(a->normals, b->normals, 2 * (size_t)a->count) == 0 &&
           memcmp(a->materials, b->materials, a->count) == 0 &&
           memcmp(a->colors, b->colors, 3 * entries) == 0 &&
           memcmp(a->coverages, b->coverages, entries) == 0;
}
