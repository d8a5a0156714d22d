// SPDX-License-Identifier: MIT
// Builds the outline: a counting sort of objects by their parents, in slices.
#include "store/outline/outline_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

stp_result stp_outline_create(stp_context* context, stp_store* store, stp_outline** outline)
{
    *outline = STP_NEW_ZEROED(context, stp_outline, 1);
    if (*outline == NULL) {
        return stp_fail_memory(context);
    }
    **outline = (stp_outline){
        .context = context, .store = store, .directory = stp_store_get_directory(store)};
    return STP_OK;
}

void stp_outline_destroy(stp_outline* outline)
{
    if (outline != NULL) {
        stp_free(outline->context, outline->places);
        stp_free(outline->context, outline->order);
        stp_free(outline->context, outline->prototypes);
        stp_free(outline->context, outline->uses_prototypes);
        stp_free(outline->context, outline);
    }
}

uint32_t stp_outline_object_count(const stp_outline* outline)
{
    return outline->directory->object_count;
}

static bool is_prototype(const stp_store_object* object)
{
    for (int i = 0; i < 12; ++i) {
        if (object->transform.m[i / 4][i % 4] != 0.0) {
            return false;
        }
    }
    return true;
}

/// Sort key: 0 for objects without a parent, else parent index + 1.
static uint32_t key_of(const stp_store_object* object)
{
    return object->parent == STP_STORE_NONE ? 0 : object->parent + 1;
}

static stp_result add_prototype(stp_outline* outline, uint32_t object, uint32_t node)
{
    if (!STP_MAKE_ROOM(outline->context, outline->prototypes, outline->prototype_capacity,
                       outline->prototype_count + 1)) {
        return stp_fail_memory(outline->context);
    }
    outline->prototypes[outline->prototype_count++] =
        (stp_outline_prototype){.node = node, .object = object};
    return STP_OK;
}

static int compare_prototypes(const void* a, const void* b)
{
    const stp_outline_prototype *x = a, *y = b;
    return x->node != y->node ? (x->node > y->node) - (x->node < y->node)
                              : (x->object > y->object) - (x->object < y->object);
}

static stp_result begin(stp_outline* outline)
{
    size_t count = (size_t)outline->directory->object_count + 2;
    stp_free(outline->context, outline->places);
    stp_free(outline->context, outline->order);
    outline->order = STP_NEW_ARRAY(outline->context, uint32_t, count);
    outline->places = STP_NEW_ZEROED(outline->context, uint32_t, count);
    outline->prototype_count = 0;
    outline->next = outline->running = 0;
    outline->phase = STP_OUTLINE_COUNT;
    if (outline->order == NULL || outline->places == NULL) {
        outline->phase = STP_OUTLINE_BEGIN;
        return stp_fail_memory(outline->context);
    }
    return STP_OK;
}

/// Marks the nodes at or above some prototype's node.
static stp_result mark_users(stp_outline* outline)
{
    const stp_store_directory* d = outline->directory;
    if (outline->prototype_count == 0) {
        return STP_OK;
    }
    qsort(outline->prototypes, outline->prototype_count, sizeof(*outline->prototypes),
          compare_prototypes);
    stp_free(outline->context, outline->uses_prototypes);
    uint8_t* uses = STP_NEW_ZEROED(outline->context, uint8_t, (size_t)d->node_count + 1);
    outline->uses_prototypes = uses;
    if (uses == NULL) {
        return stp_fail_memory(outline->context);
    }
    for (size_t i = 0; i < outline->prototype_count; ++i) {
        uses[outline->prototypes[i].node] = 1;
    }
    for (uint32_t i = 0; i < d->node_count; ++i) {
        for (uint32_t k = 0; k < d->nodes[i].edge_count; ++k) {
            uses[i] |= uses[d->edges[d->nodes[i].first_edge + k].node];
        }
    }
    return STP_OK;
}

/// Runs one step of the current phase, for outline->next. @return as stp_outline_prepare
static stp_result step(stp_outline* outline)
{
    stp_store_object object;
    if (outline->phase == STP_OUTLINE_SUM) {
        uint32_t count = outline->places[outline->next];
        outline->places[outline->next] = outline->running;
        outline->running += count;
        return STP_OK;
    }
    stp_result result = stp_store_read_object_place(outline->store, outline->next, &object);
    if (result != STP_OK) {
        return result;
    }
    if (object.parent == STP_STORE_NONE && is_prototype(&object)) {
        bool counting = outline->phase == STP_OUTLINE_COUNT && object.node != STP_STORE_NONE;
        return counting ? add_prototype(outline, outline->next, object.node) : STP_OK;
    }
    uint32_t* place = &outline->places[key_of(&object)];
    if (outline->phase == STP_OUTLINE_SORT) {
        outline->order[*place] = outline->next;
    }
    *place += 1;
    return STP_OK;
}

static stp_result end_phase(stp_outline* outline)
{
    outline->next = 0;
    outline->phase = (stp_outline_phase)(outline->phase + 1);
    if (outline->phase != STP_OUTLINE_READY) {
        return STP_OK;
    }
    outline->ordered_count = outline->running;
    stp_free(outline->context, outline->places);
    outline->places = NULL;
    stp_result result = mark_users(outline);
    outline->phase = result == STP_OK ? STP_OUTLINE_READY : STP_OUTLINE_BEGIN;
    return result;
}

stp_result stp_outline_prepare(stp_outline* outline, uint64_t records, bool* ready)
{
    uint32_t count = outline->directory->object_count;
    stp_result result = outline->phase == STP_OUTLINE_BEGIN ? begin(outline) : STP_OK;
    for (uint64_t i = 0; result == STP_OK && outline->phase != STP_OUTLINE_READY &&
                         (records == 0 || i < records);) {
        uint32_t end = outline->phase == STP_OUTLINE_SUM ? count + 1 : count;
        assert(outline->next <= end);
        if (outline->next < end) {
            result = step(outline);
            outline->next += result == STP_OK ? 1 : 0;
            i += 1;
        } else {
            result = end_phase(outline);
        }
    }
    *ready = result == STP_OK && outline->phase == STP_OUTLINE_READY;
    return result;
}

/// The first position in the order whose object's key is at least `key`.
static stp_result find_key(stp_outline* outline, uint64_t key, uint32_t* found)
{
    uint32_t low = 0, high = outline->ordered_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        stp_store_object object;
        stp_result result =
            stp_store_read_object_place(outline->store, outline->order[middle], &object);
        if (result != STP_OK) {
            return result;
        }
        if (key_of(&object) < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    *found = low;
    return STP_OK;
}

stp_result stp_outline_range(stp_outline* outline, uint32_t parent, uint32_t* first, uint32_t* end)
{
    assert(outline->phase == STP_OUTLINE_READY);
    uint64_t key = parent == STP_STORE_NONE ? 0 : (uint64_t)parent + 1;
    *first = *end = 0;
    stp_result result = find_key(outline, key, first);
    return result == STP_OK ? find_key(outline, key + 1, end) : result;
}

uint32_t stp_outline_prototype_of(const stp_outline* outline, uint32_t node)
{
    assert(outline->phase == STP_OUTLINE_READY && "prototypes are sorted");
    size_t low = 0, high = outline->prototype_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (outline->prototypes[middle].node < node) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < outline->prototype_count && outline->prototypes[low].node == node
               ? outline->prototypes[low].object
               : STP_STORE_NONE;
}
