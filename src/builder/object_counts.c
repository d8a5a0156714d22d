// SPDX-License-Identifier: MIT
#include "base/core/saturate.h"
#include "builder/writer_input.h"

#include <assert.h>
#include <string.h>

// What an object shows: its own parts and those of the object it uses, per instance, and its
// children.
typedef struct shown {
    uint64_t objects, instances;
    bool known;
} shown;

typedef struct census_work {
    const stp_scene* scene;
    uint32_t *first_child, *next_sibling; ///< by object; prototypes are not linked to a parent
    /// Next child whose sum may be missing; later: the last walk that visited the object.
    uint32_t* cursor;
    uint32_t* shapes;     ///< for each object: index of its distinct list of parts; STP_NONE: none
    uint32_t* shapes_met; ///< for each shape: the last walk that visited it
    uint32_t shape_count, walk;
    shown* sums;
    uint32_t* stack;
    size_t stacked, stack_capacity;
    stp_store_census_candidate* candidates;
    size_t candidate_count, candidate_capacity;
} census_work;

static bool is_prototype(const stp_object* object)
{
    return (object->flags & STP_OBJECT_PROTOTYPE) != 0;
}

static bool is_empty(const stp_scene* scene, stp_part part)
{
    return part.kind == STP_PART_MESH ? scene->meshes[part.index].triangle_count == 0
                                      : scene->point_sets[part.index].point_count == 0;
}

static uint64_t count_own_parts(const stp_scene* scene, const stp_object* object)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < object->part_count; ++i) {
        count += is_empty(scene, scene->parts[object->first_part + i]) ? 0 : 1;
    }
    return count;
}

static bool push(census_work* w, uint32_t object)
{
    if (!STP_MAKE_ROOM(w->scene->context, w->stack, w->stack_capacity, w->stacked + 1)) {
        return false;
    }
    w->stack[w->stacked++] = object;
    return true;
}

static void link_children(census_work* w)
{
    const stp_scene* scene = w->scene;
    memset(w->first_child, 0xff, scene->object_count * sizeof(uint32_t));
    for (size_t i = scene->object_count;
         i-- > 0;) { // in reverse, so that children keep their order
        const stp_object* object = &scene->objects[i];
        w->next_sibling[i] = STP_NONE;
        if (object->parent != STP_NONE && !is_prototype(object)) {
            assert(object->parent < i && "parents come first");
            w->next_sibling[i] = w->first_child[object->parent];
            w->first_child[object->parent] = (uint32_t)i;
        }
    }
    memcpy(w->cursor, w->first_child, scene->object_count * sizeof(uint32_t));
}

// Computes the sum of an object. Its children and the object it uses must have theirs.
static void sum_object(census_work* w, uint32_t index)
{
    const stp_object* object = &w->scene->objects[index];
    assert(!w->sums[index].known && "an object is summed once");
    uint64_t parts = count_own_parts(w->scene, object);
    uint64_t times = object->instance_count > 0 ? object->instance_count : 1;
    shown sum = {.objects = parts != 0, .instances = parts, .known = true};
    if (object->use != STP_NONE) {
        sum.objects = stp_add_saturated(sum.objects, w->sums[object->use].objects);
        sum.instances = stp_add_saturated(sum.instances, w->sums[object->use].instances);
    }
    sum.objects = stp_multiply_saturated(sum.objects, times);
    sum.instances = stp_multiply_saturated(sum.instances, times);
    for (uint32_t c = w->first_child[index]; c != STP_NONE; c = w->next_sibling[c]) {
        assert(w->sums[c].known && "children come first");
        sum.objects = stp_add_saturated(sum.objects, w->sums[c].objects);
        sum.instances = stp_add_saturated(sum.instances, w->sums[c].instances);
    }
    w->sums[index] = sum;
}

// A child, or the used object, that has no sum yet. Finished scenes have no cycles.
static uint32_t find_missing(census_work* w, uint32_t index)
{
    uint32_t* next = &w->cursor[index];
    while (*next != STP_NONE && w->sums[*next].known) {
        *next = w->next_sibling[*next];
    }
    uint32_t use = w->scene->objects[index].use;
    return *next != STP_NONE ? *next : use != STP_NONE && !w->sums[use].known ? use : STP_NONE;
}

static bool sum_objects(census_work* w)
{
    bool made = true;
    for (size_t i = 0; made && i < w->scene->object_count; ++i) {
        made = w->sums[i].known || push(w, (uint32_t)i);
        while (made && w->stacked != 0) {
            uint32_t top = w->stack[w->stacked - 1], missing = find_missing(w, top);
            if (missing != STP_NONE) {
                made = push(w, missing);
            } else {
                sum_object(w, top);
                w->stacked -= 1;
            }
        }
    }
    return made;
}

static stp_hash hash_parts(const stp_scene* scene, const stp_object* object)
{
    stp_hash hash = {0};
    for (uint32_t i = 0; i < object->part_count; ++i) {
        stp_part part = scene->parts[object->first_part + i];
        uint32_t words[2] = {(uint32_t)part.kind, part.index};
        hash = is_empty(scene, part) ? hash : stp_hash_bytes(hash, words, sizeof(words));
    }
    return hash;
}

typedef struct shape_slot {
    stp_hash hash;
    uint32_t shape; ///< STP_NONE: free slot
} shape_slot;

// Numbers the distinct lists of parts. Identical meshes are already merged.
static bool number_shapes(census_work* w)
{
    const stp_scene* scene = w->scene;
    size_t size = 16;
    while (size < 2 * scene->object_count) {
        size *= 2;
    }
    shape_slot* slots = STP_NEW_ARRAY(scene->context, shape_slot, size);
    if (slots == NULL) {
        return false;
    }
    memset(slots, 0xff, size * sizeof(*slots));
    for (size_t i = 0; i < scene->object_count; ++i) {
        w->shapes[i] = STP_NONE;
        if (count_own_parts(scene, &scene->objects[i]) == 0) {
            continue;
        }
        stp_hash hash = hash_parts(scene, &scene->objects[i]);
        size_t slot = hash.low & (size - 1);
        while (slots[slot].shape != STP_NONE && !stp_hash_equal(slots[slot].hash, hash)) {
            slot = (slot + 1) & (size - 1);
        }
        if (slots[slot].shape == STP_NONE) {
            slots[slot] = (shape_slot){hash, w->shape_count++};
        }
        w->shapes[i] = slots[slot].shape;
    }
    stp_free(scene->context, slots);
    return true;
}

static bool visit_object(census_work* w, uint32_t object)
{
    if (object == STP_NONE || w->cursor[object] == w->walk) {
        return true;
    }
    w->cursor[object] = w->walk;
    return push(w, object);
}

// Adds the distinct shapes of the objects on the stack and below them to `count`.
static bool count_shapes(census_work* w, uint64_t* count)
{
    bool made = true;
    while (made && w->stacked != 0) {
        uint32_t index = w->stack[--w->stacked], shape = w->shapes[index];
        assert(shape == STP_NONE || shape < w->shape_count);
        if (shape != STP_NONE && w->shapes_met[shape] != w->walk) {
            w->shapes_met[shape] = w->walk;
            *count += 1;
        }
        made = visit_object(w, w->scene->objects[index].use);
        for (uint32_t c = w->first_child[index]; made && c != STP_NONE; c = w->next_sibling[c]) {
            made = visit_object(w, c);
        }
    }
    return made;
}

static bool add_candidate(census_work* w, uint32_t index)
{
    const stp_scene* scene = w->scene;
    const stp_object* object = &scene->objects[index];
    if (w->sums[index].objects == 0) {
        return true;
    }
    if (!STP_MAKE_ROOM(scene->context, w->candidates, w->candidate_capacity,
                       w->candidate_count + 1)) {
        return false;
    }
    w->candidates[w->candidate_count++] = (stp_store_census_candidate){
        .object = index,
        .triangles = object->node != STP_NONE ? scene->nodes[object->node].triangle_count : 0,
        .name = object->name,
    };
    return true;
}

// Makes the children of an object, and of what it uses, candidates, unless the object has content
// itself, or uses another more than once.
static bool open_object(census_work* w, uint32_t index, bool* opened)
{
    const stp_scene* scene = w->scene;
    *opened = false;
    for (uint32_t i = index; i != STP_NONE;
         i = scene->objects[i].use) { // a used object comes before its users
        const stp_object* object = &scene->objects[i];
        if (w->shapes[i] != STP_NONE || (object->use != STP_NONE && object->instance_count > 1)) {
            return true;
        }
    }
    w->candidate_count = 0;
    bool made = true;
    for (uint32_t i = index; made && i != STP_NONE; i = scene->objects[i].use) {
        for (uint32_t c = w->first_child[i]; made && c != STP_NONE; c = w->next_sibling[c]) {
            made = add_candidate(w, c);
        }
    }
    *opened = true;
    return made;
}

static bool find_candidates(census_work* w)
{
    const stp_scene* scene = w->scene;
    bool made = true, opened = true;
    for (size_t i = 0; made && i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        if (object->parent == STP_NONE && !is_prototype(object)) {
            made = add_candidate(w, (uint32_t)i);
        }
    }
    while (made && opened && w->candidate_count == 1) {
        made = open_object(w, w->candidates[0].object, &opened);
    }
    return made;
}

static bool fill_part(census_work* w, stp_store_census_part* part)
{
    bool made = true;
    w->walk += 1;
    for (uint32_t i = 0; made && i < part->member_count; ++i) {
        uint32_t member = part->members[i];
        part->objects = stp_add_saturated(part->objects, w->sums[member].objects);
        part->instances = stp_add_saturated(part->instances, w->sums[member].instances);
        made = visit_object(w, member);
    }
    return made && count_shapes(w, &part->unique_objects);
}

static bool fill_whole(census_work* w, stp_store_census* census)
{
    const stp_scene* scene = w->scene;
    bool made = true;
    w->walk += 1;
    for (size_t i = 0; made && i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        if (object->parent == STP_NONE && !is_prototype(object)) {
            census->objects = stp_add_saturated(census->objects, w->sums[i].objects);
            census->instances = stp_add_saturated(census->instances, w->sums[i].instances);
            made = visit_object(w, (uint32_t)i);
        }
    }
    return made && count_shapes(w, &census->unique_objects);
}

static bool create_work(census_work* w)
{
    stp_context* context = w->scene->context;
    size_t count = w->scene->object_count + 1;
    w->first_child = STP_NEW_ARRAY(context, uint32_t, count);
    w->next_sibling = STP_NEW_ARRAY(context, uint32_t, count);
    w->cursor = STP_NEW_ARRAY(context, uint32_t, count);
    w->shapes = STP_NEW_ARRAY(context, uint32_t, count);
    w->shapes_met = STP_NEW_ZEROED(context, uint32_t, count);
    w->sums = STP_NEW_ZEROED(context, shown, count);
    return w->first_child != NULL && w->next_sibling != NULL && w->cursor != NULL &&
           w->shapes != NULL && w->shapes_met != NULL && w->sums != NULL;
}

static void destroy_work(census_work* w)
{
    void* arrays[] = {w->first_child, w->next_sibling, w->cursor, w->shapes,
                      w->shapes_met,  w->sums,         w->stack,  w->candidates};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(w->scene->context, arrays[i]);
    }
}

stp_result stp_build_census(const stp_scene* scene, stp_store_census* census)
{
    census_work w = {.scene = scene};
    *census = (stp_store_census){0};
    bool made = create_work(&w);
    if (made) {
        link_children(&w);
        made = sum_objects(&w) && number_shapes(&w) && find_candidates(&w);
    }
    if (!made) {
        destroy_work(&w);
        return stp_fail_memory(scene->context);
    }
    stp_result result =
        stp_store_census_create(scene->context, w.candidates, w.candidate_count, census);
    if (result == STP_OK) {
        memset(w.cursor, 0, scene->object_count * sizeof(uint32_t));
        made = fill_whole(&w, census);
        for (uint32_t i = 0; made && i < census->part_count; ++i) {
            made = fill_part(&w, &census->parts[i]);
        }
        assert(!made || census->unique_objects <= census->objects);
        if (!made) {
            stp_store_census_destroy(scene->context, census);
            result = stp_fail_memory(scene->context);
        }
    }
    destroy_work(&w);
    return result;
}
