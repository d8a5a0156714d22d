// SPDX-License-Identifier: MIT
// Items: their children, their transforms, and the item that a part belongs to.
#include "store/file/instances.h"
#include "store/outline/outline_internal.h"

#include <assert.h>
#include <string.h>

static const uint64_t visit_limit = UINT64_C(1) << 25;
enum { PLACES_MAX = 1 << 20 }; ///< placed prototypes per item

stp_outline_item stp_outline_root(const stp_outline* outline)
{
    return (stp_outline_item){.node = outline->directory->root, .transform = stp_affine_identity()};
}

/// Makes the item of a child. @return false if it is too deep
static bool make_child(const stp_outline_item* item, uint32_t object, uint32_t node,
                       const stp_affine* transform, stp_outline_item* child)
{
    if (item->depth >= STP_OUTLINE_DEPTH) {
        return false;
    }
    *child = *item;
    child->objects[child->depth++] = object;
    child->node = node;
    child->transform = stp_affine_multiply(item->transform, *transform);
    return true;
}

/// The range of an item's children: those of its own object, else of the prototype that it uses.
static stp_result find_children(stp_outline* outline, const stp_outline_item* item, uint32_t* first,
                                uint32_t* end)
{
    uint32_t object = item->depth > 0 ? item->objects[item->depth - 1] : STP_STORE_NONE;
    stp_result result = stp_outline_range(outline, object, first, end);
    if (result != STP_OK || *end > *first || item->depth == 0 || item->node == STP_STORE_NONE) {
        return result;
    }
    uint32_t prototype = stp_outline_prototype_of(outline, item->node);
    if (prototype == STP_STORE_NONE) {
        return STP_OK;
    }
    for (uint32_t at = object; at != STP_STORE_NONE;) { // skips prototypes that contain the object
        stp_store_object record;
        result =
            at == prototype ? STP_OK : stp_store_read_object_place(outline->store, at, &record);
        if (result != STP_OK || at == prototype) {
            return result;
        }
        at = record.parent;
    }
    return stp_outline_range(outline, prototype, first, end);
}

/// A walk over the prototypes placed below an item.
typedef struct place_walk {
    stp_outline* outline;
    const stp_outline_item* item;
    uint64_t first, seen, visits;
    uint32_t room, given;
    stp_outline_item* items;
} place_walk;

static void walk_places(place_walk* w, uint32_t node, const stp_affine* transform, uint32_t depth)
{
    const stp_store_directory* d = w->outline->directory;
    const stp_store_node* n = &d->nodes[node];
    if (w->visits == 0 || depth >= STP_INSTANCE_DEPTH || w->seen >= PLACES_MAX) {
        return;
    }
    w->visits -= 1;
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        if (w->outline->uses_prototypes[edge->node] == 0) {
            continue;
        }
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        uint32_t prototype = stp_outline_prototype_of(w->outline, edge->node);
        if (prototype == STP_STORE_NONE) {
            walk_places(w, edge->node, &below, depth + 1);
            continue;
        }
        if (w->seen >= w->first && w->given < w->room &&
            make_child(w->item, prototype, edge->node, &below, &w->items[w->given])) {
            w->items[w->given++].transform = below;
        }
        w->seen += 1;
    }
}

/// Lists the prototypes below an item that has no children itself. @return their number
static uint64_t find_places(stp_outline* outline, const stp_outline_item* item, uint64_t first,
                            uint32_t room, stp_outline_item* items, uint32_t* given)
{
    place_walk w = {.outline = outline,
                    .item = item,
                    .first = first,
                    .visits = visit_limit,
                    .room = room,
                    .items = items};
    bool any = item->depth > 0 && item->depth < STP_OUTLINE_DEPTH && item->node != STP_STORE_NONE &&
               outline->uses_prototypes != NULL && outline->uses_prototypes[item->node] != 0 &&
               stp_outline_prototype_of(outline, item->node) == STP_STORE_NONE;
    if (any) {
        walk_places(&w, item->node, &item->transform, 0);
    }
    *given = w.given;
    return w.seen;
}

stp_result stp_outline_children(stp_outline* outline, const stp_outline_item* item, uint64_t first,
                                uint32_t room, stp_outline_item* items, uint32_t* count)
{
    uint32_t begin, end;
    *count = 0;
    assert(item->depth <= STP_OUTLINE_DEPTH);
    stp_result result = find_children(outline, item, &begin, &end);
    if (result == STP_OK && begin == end) {
        (void)find_places(outline, item, first, room, items, count);
        return STP_OK;
    }
    for (uint64_t i = begin + first; result == STP_OK && i < end && *count < room; ++i) {
        stp_store_object object;
        uint32_t index = outline->order[i];
        result = stp_store_read_object_place(outline->store, index, &object);
        if (result == STP_OK &&
            make_child(item, index, object.node, &object.transform, &items[*count])) {
            *count += 1;
        }
    }
    return result;
}

stp_result stp_outline_describe(stp_outline* outline, const stp_outline_item* item,
                                stp_outline_row* row)
{
    uint32_t begin, end, given;
    *row = (stp_outline_row){.bounds = stp_boxd_empty()};
    stp_result result = find_children(outline, item, &begin, &end);
    if (result != STP_OK) {
        return result;
    }
    row->child_count = end > begin ? end - begin : find_places(outline, item, 0, 0, NULL, &given);
    if (item->node != STP_STORE_NONE) {
        const stp_store_node* node = &outline->directory->nodes[item->node];
        row->triangle_count = node->triangle_count;
        row->point_count = node->point_count;
        row->bounds = stp_affine_box(&item->transform, node->bounds);
    }
    if (item->depth > 0) {
        stp_store_object object;
        result = stp_store_read_object(outline->store, item->objects[item->depth - 1], &object);
        row->name = result == STP_OK ? object.name : NULL;
        row->id = result == STP_OK ? object.id : NULL;
    }
    return result;
}

/// Lists an object and its ancestors, lowest first. `count` is their number, even if above `room`.
static stp_result list_above(stp_outline* outline, uint32_t object, uint32_t* above, size_t room,
                             size_t* count)
{
    stp_store_object record;
    *count = 0;
    for (uint32_t at = object; at != STP_STORE_NONE; at = record.parent) {
        if (*count < room) {
            above[*count] = at;
        }
        *count += 1;
        stp_result result = stp_store_read_object_place(outline->store, at, &record);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

/// Descends from the root along the path. If it is too deep for an item, the lowest objects remain.
static stp_result descend(stp_outline* outline, const uint32_t* above, size_t depth,
                          stp_outline_item* item)
{
    bool nowhere = false;
    while (depth > 0) {
        stp_store_object record;
        uint32_t at = above[--depth];
        stp_result result = stp_store_read_object_place(outline->store, at, &record);
        if (result != STP_OK) {
            return result;
        }
        nowhere = nowhere || stp_affine_scale(&record.transform) == 0.0;
        if (item->depth == STP_OUTLINE_DEPTH) {
            item->depth -= 1;
            memmove(item->objects, item->objects + 1, item->depth * sizeof(item->objects[0]));
        }
        stp_outline_item upper = *item;
        (void)make_child(&upper, at, record.node, &record.transform, item);
    }
    item->node = nowhere ? STP_STORE_NONE : item->node;
    return STP_OK;
}

stp_result stp_outline_item_of(stp_outline* outline, uint32_t object, stp_outline_item* item)
{
    uint32_t few[STP_OUTLINE_DEPTH], *all = NULL;
    size_t depth;
    *item = stp_outline_root(outline);
    stp_result result = list_above(outline, object, few, STP_OUTLINE_DEPTH, &depth);
    if (result == STP_OK && depth > STP_OUTLINE_DEPTH) {
        all = STP_NEW_ARRAY(outline->context, uint32_t, depth);
        result = all != NULL ? list_above(outline, object, all, depth, &depth)
                             : stp_fail_memory(outline->context);
    }
    if (result == STP_OK) {
        result = descend(outline, all != NULL ? all : few, depth, item);
    }
    stp_free(outline->context, all);
    return result;
}

/// Marks the nodes that have the part at or below them.
static uint8_t* mark_part(const stp_outline* outline, stp_store_part part)
{
    const stp_store_directory* d = outline->directory;
    uint8_t* marks = STP_NEW_ZEROED(outline->context, uint8_t, (size_t)d->node_count + 1);
    for (uint32_t i = 0; marks != NULL && i < d->node_count; ++i) {
        const stp_store_node* n = &d->nodes[i];
        for (uint32_t k = 0; k < n->part_count; ++k) {
            const stp_store_part* own = &d->parts[n->first_part + k];
            marks[i] |= own->kind == part.kind && own->index == part.index;
        }
        for (uint32_t k = 0; k < n->edge_count; ++k) {
            marks[i] |= marks[d->edges[n->first_edge + k].node];
        }
    }
    return marks;
}

/// Finds the first child of an item that contains the occurrence; `found` is false if none does.
static stp_result find_holder(stp_outline* outline, const stp_outline_item* item,
                              const stp_instance* instance, stp_instance_search* search,
                              stp_outline_item* holder, bool* found)
{
    enum { ROOM = 32 };
    stp_outline_item items[ROOM];
    uint32_t count = ROOM;
    stp_result result = STP_OK;
    *found = false;
    for (uint64_t first = 0; result == STP_OK && !*found && count == ROOM; first += ROOM) {
        result = stp_outline_children(outline, item, first, ROOM, items, &count);
        for (uint32_t i = 0; result == STP_OK && i < count && !*found; ++i) {
            uint32_t node = items[i].node;
            if (node != STP_STORE_NONE && search->reaches[node] != 0 &&
                stp_instance_may_hold(&outline->directory->nodes[node].bounds, &items[i].transform,
                                      instance->center) &&
                stp_instance_holds(search, node, &items[i].transform, instance)) {
                *holder = items[i];
                *found = true;
            }
        }
    }
    return result;
}

stp_result stp_outline_find(stp_outline* outline, stp_store_part part, const stp_affine* transform,
                            stp_outline_item* item)
{
    *item = stp_outline_root(outline);
    uint8_t* marks = mark_part(outline, part);
    if (marks == NULL) {
        return stp_fail_memory(outline->context);
    }
    stp_instance instance = stp_instance_of_part(outline->store, part, transform);
    stp_instance_search search = {
        .directory = outline->directory, .reaches = marks, .visits_left = visit_limit};
    stp_result result = STP_OK;
    bool found = true;
    while (result == STP_OK && found) {
        stp_outline_item holder;
        result = find_holder(outline, item, &instance, &search, &holder, &found);
        if (result == STP_OK && found) {
            assert(holder.depth == item->depth + 1 && "each step descends, so the loop ends");
            *item = holder;
        }
    }
    stp_free(outline->context, marks);
    return result;
}
