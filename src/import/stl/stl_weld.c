// SPDX-License-Identifier: MIT
#include "import/stl/stl_weld.h"

#include "base/io/bytes.h"
#include "base/io/hash.h"

#include <assert.h>
#include <string.h>

#define FIRST_SLOTS ((size_t)64)

stp_vec3 stp_stl_corner(const unsigned char* facets, size_t corner)
{
    // the normal comes first
    const unsigned char* bytes = facets + corner / 3 * STP_STL_FACET_SIZE + 12 + 12 * (corner % 3);
    return (stp_vec3){stp_read_f32(bytes) + 0.0f, stp_read_f32(bytes + 4) + 0.0f,
                      stp_read_f32(bytes + 8) + 0.0f};
}

// What corners of a vertex have in common.
typedef struct corner_key {
    stp_vec3 place;
    uint32_t color;
} corner_key;

// The start slot of a corner's search. Seeded with an address, so that a malicious file cannot
// cause collisions.
static size_t first_slot(const stp_weld* weld, const corner_key* key)
{
    assert(weld->slot_count > 0 && (weld->slot_count & (weld->slot_count - 1)) == 0);
    stp_hash seed = {.low = (uint64_t)(uintptr_t)weld};
    stp_hash hash = weld->coding == STP_STL_PLAIN
                        ? stp_hash_bytes(seed, &key->place, sizeof(key->place))
                        : stp_hash_bytes(seed, key, sizeof(*key));
    return hash.low & (weld->slot_count - 1);
}

static uint32_t color_of(const stp_weld* weld, size_t corner)
{
    return weld->coding != STP_STL_PLAIN ? stp_stl_color_bits(weld->coding, weld->facets, corner)
                                         : 0;
}

static corner_key key_of(const stp_weld* weld, uint32_t entry)
{
    assert(entry < (weld->facets != NULL ? weld->index_count : weld->vertex_count));
    if (weld->facets != NULL) {
        return (corner_key){stp_stl_corner(weld->facets, entry), color_of(weld, entry)};
    }
    const float* p = weld->positions + 3 * (size_t)entry;
    return (corner_key){.place = {p[0], p[1], p[2]}};
}

static void insert(stp_weld* weld, uint32_t entry)
{
    corner_key key = key_of(weld, entry);
    size_t slot = first_slot(weld, &key);
    while (weld->slots[slot] != 0) {
        slot = (slot + 1) & (weld->slot_count - 1);
    }
    weld->slots[slot] = entry + 1;
}

// Frees the old table before allocating the new one, so that both are never in memory.
static stp_result grow(stp_weld* weld)
{
    size_t count = weld->slot_count == 0 ? FIRST_SLOTS : 2 * weld->slot_count;
    stp_free(weld->context, weld->slots);
    weld->slots = STP_NEW_ZEROED(weld->context, uint32_t, count);
    weld->slot_count = weld->slots != NULL ? count : 0;
    if (weld->slots == NULL) {
        return stp_fail_memory(weld->context);
    }
    if (weld->facets == NULL) {
        for (size_t i = 0; i < weld->vertex_count; ++i) {
            insert(weld, (uint32_t)i);
        }
        return STP_OK;
    }
    uint32_t vertex = 0;
    for (size_t i = 0; i < weld->index_count; ++i) {
        if (weld->indices[i] == vertex) { // its first corner: numbers follow the order of corners
            insert(weld, (uint32_t)i);
            vertex += 1;
        }
    }
    assert(vertex == weld->vertex_count);
    return STP_OK;
}

static stp_result keep_place(stp_weld* weld, stp_vec3 place)
{
    if (!stp_make_room(weld->context, &weld->positions, &weld->vertex_capacity,
                       weld->vertex_count + 1, sizeof(place))) {
        return stp_fail_memory(weld->context);
    }
    memcpy(weld->positions + 3 * weld->vertex_count, &place, sizeof(place));
    return STP_OK;
}

stp_result stp_weld_begin(stp_weld* weld, const unsigned char* facets, size_t count,
                          stp_stl_coding coding)
{
    assert(count < UINT32_MAX / 3 && weld->index_count == 0 && "it starts empty");
    weld->facets = facets;
    weld->coding = coding;
    weld->indices = STP_NEW_ARRAY(weld->context, uint32_t, 3 * count);
    weld->index_capacity = 3 * count;
    return weld->indices != NULL ? STP_OK : stp_fail_memory(weld->context);
}

stp_result stp_weld_add(stp_weld* weld, stp_vec3 place)
{
    stp_result result = STP_OK;
    assert(weld->index_count < UINT32_MAX - 1 && weld->vertex_count <= weld->index_count);
    assert(weld->facets == NULL || weld->index_count < weld->index_capacity);
    if (2 * (weld->vertex_count + 1) > weld->slot_count) {
        result = grow(weld);
    }
    if (result != STP_OK) {
        return result;
    }
    if (!STP_MAKE_ROOM(weld->context, weld->indices, weld->index_capacity, weld->index_count + 1)) {
        return stp_fail_memory(weld->context);
    }
    assert(2 * weld->vertex_count < weld->slot_count && "searches end at a free slot");
    uint32_t* indices = weld->indices;
    corner_key key = {.place = place, .color = color_of(weld, weld->index_count)};
    size_t slot = first_slot(weld, &key);
    for (uint32_t found; (found = weld->slots[slot]) != 0;
         slot = (slot + 1) & (weld->slot_count - 1)) {
        corner_key other = key_of(weld, found - 1);
        if (memcmp(&place, &other.place, sizeof(place)) == 0 && key.color == other.color) {
            indices[weld->index_count++] = weld->facets != NULL ? indices[found - 1] : found - 1;
            return STP_OK;
        }
    }
    result = weld->facets == NULL ? keep_place(weld, place) : STP_OK;
    if (result == STP_OK) {
        size_t entry = weld->facets != NULL ? weld->index_count : weld->vertex_count;
        weld->slots[slot] = (uint32_t)entry + 1;
        indices[weld->index_count++] = (uint32_t)weld->vertex_count++;
    }
    return result;
}

stp_result stp_weld_finish(stp_weld* weld)
{
    stp_free(weld->context, weld->slots);
    weld->slots = NULL;
    weld->slot_count = 0;
    if (weld->facets == NULL) {
        return STP_OK;
    }
    weld->positions = stp_alloc_array(weld->context, weld->vertex_count, 3 * sizeof(float));
    if (weld->coding != STP_STL_PLAIN) {
        weld->colors = STP_NEW_ARRAY(weld->context, uint16_t, weld->vertex_count);
    }
    if (weld->positions == NULL || (weld->colors == NULL && weld->coding != STP_STL_PLAIN)) {
        return stp_fail_memory(weld->context);
    }
    uint32_t vertex = 0;
    for (size_t i = 0; i < weld->index_count; ++i) {
        if (weld->indices[i] == vertex) {
            stp_vec3 place = stp_stl_corner(weld->facets, i);
            memcpy(weld->positions + 3 * (size_t)vertex, &place, sizeof(place));
            if (weld->colors != NULL) {
                weld->colors[vertex] = stp_stl_color_bits(weld->coding, weld->facets, i);
            }
            vertex += 1;
        }
    }
    assert(vertex == weld->vertex_count && "vertices are numbered in the order of corners");
    return STP_OK;
}

void stp_weld_clear(stp_weld* weld)
{
    stp_free(weld->context, weld->slots);
    stp_free(weld->context, weld->positions);
    stp_free(weld->context, weld->colors);
    stp_free(weld->context, weld->indices);
    *weld = (stp_weld){.context = weld->context};
}
