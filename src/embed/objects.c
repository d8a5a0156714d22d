// SPDX-License-Identifier: MIT
// The tree of a model's objects, and their visibility.
#include "embed/model_internal.h"

#include <assert.h>

enum { CHILDREN_AT_ONCE = 64 };

stp_result stp_model_use_outline(stp_model* model, stp_outline** outline)
{
    bool ready = true;
    stp_result result = STP_OK;
    if (model->outline == NULL) {
        result = stp_outline_create(model->context, model->store, &model->outline);
        if (result == STP_OK) {
            result = stp_outline_prepare(model->outline, 0, &ready);
        }
        if (result != STP_OK && model->outline != NULL) {
            stp_outline_destroy(model->outline);
            model->outline = NULL;
        }
    }
    *outline = model->outline;
    return result;
}

/// Finds an object, placed or not; STP_NO_OBJECT: the whole scene. Logs STP_ERROR_ARGUMENT if there
/// is no such object.
static stp_result find_item(stp_model* model, uint32_t object, stp_outline_item* item)
{
    stp_outline* outline;
    stp_result result = stp_model_use_outline(model, &outline);
    if (result != STP_OK) {
        return result;
    }
    uint32_t count = stp_outline_object_count(outline);
    if (object == STP_NO_OBJECT) {
        *item = stp_outline_root(outline);
        return STP_OK;
    }
    if (object >= count) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "object %u does not exist (the model has %u)", object, count);
    }
    return stp_outline_item_of(outline, object, item);
}

stp_result stp_model_get_object(stp_model* model, uint32_t object, stp_object_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    stp_outline_item item;
    stp_outline_row row;
    stp_store_object record = {.parent = STP_NO_OBJECT};
    stp_result result = find_item(model, object, &item);
    if (result == STP_OK) {
        result = stp_outline_describe(model->outline, &item, &row);
    }
    if (result == STP_OK && object != STP_NO_OBJECT) {
        result = stp_store_read_object_place(model->store, object, &record);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_object_info made = {.name = row.name,
                            .id = row.id,
                            .parent = record.parent,
                            .placed = stp_model_is_placed(&item),
                            .transform = item.transform,
                            .bounds = row.bounds,
                            .triangle_count = row.triangle_count,
                            .point_count = row.point_count,
                            .child_count = row.child_count};
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

stp_result stp_model_get_children(stp_model* model, uint32_t object, uint64_t first, uint32_t room,
                                  uint32_t* objects, uint32_t* count)
{
    stp_outline_item item, children[CHILDREN_AT_ONCE];
    stp_result result = STP_CHECK_CALL(model, count);
    if (result == STP_OK && room > 0) {
        result = STP_CHECK_CALL(model, objects);
    }
    if (result != STP_OK) {
        return result;
    }
    *count = 0;
    result = find_item(model, object, &item);
    uint32_t given = 1;
    while (result == STP_OK && *count < room && given > 0) {
        uint32_t left = room - *count;
        left = left < CHILDREN_AT_ONCE ? left : CHILDREN_AT_ONCE;
        result =
            stp_outline_children(model->outline, &item, first + *count, left, children, &given);
        assert(result != STP_OK || given <= left);
        for (uint32_t i = 0; result == STP_OK && i < given; ++i) {
            assert(children[i].depth > 0 && "only the root has no object");
            objects[*count] = children[i].objects[children[i].depth - 1];
            *count += 1;
        }
    }
    return result;
}

stp_result stp_model_find_object(stp_model* model, const char* text, uint32_t from,
                                 uint32_t* object)
{
    stp_outline* outline;
    stp_result result = STP_CHECK_CALL(model, text);
    result = result == STP_OK ? STP_CHECK_CALL(model, object) : result;
    if (result != STP_OK) {
        return result;
    }
    *object = STP_NO_OBJECT;
    result = stp_model_use_outline(model, &outline);
    uint32_t count = result == STP_OK ? stp_outline_object_count(outline) : 0;
    for (uint32_t i = from; i < count && result == STP_OK && *object == STP_NO_OBJECT; ++i) {
        bool named = false;
        result = stp_outline_is_named(outline, i, text, &named);
        *object = named ? i : STP_NO_OBJECT;
    }
    return result;
}

stp_result stp_model_set_appearance(stp_model* model, uint32_t object, stp_appearance appearance)
{
    static const stp_show shows[] = {[STP_APPEARANCE_SHOWN] = STP_SHOW,
                                     [STP_APPEARANCE_HIDDEN] = STP_SHOW_NOT,
                                     [STP_APPEARANCE_GHOST] = STP_SHOW_GHOST};
    stp_result result = STP_OK;
    if (model == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    if ((uint32_t)appearance > STP_APPEARANCE_GHOST) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT, "appearance %d does not exist",
                        (int)appearance);
    }
    if (model->visibility == NULL) {
        result = stp_visibility_create(model->context, model->store, &model->visibility);
    }
    if (result != STP_OK) {
        return result;
    }
    if (object == STP_NO_OBJECT) {
        stp_visibility_reset(model->visibility, shows[appearance]);
        return STP_OK;
    }
    stp_outline_item item;
    result = find_item(model, object, &item);
    if (result == STP_OK && !stp_model_is_placed(&item)) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "object %u is not placed in the scene itself", object);
    }
    assert(result != STP_OK || item.depth > 0);
    stp_placed_node placed = {.node = item.node, .transform = item.transform};
    return result == STP_OK ? stp_visibility_set(model->visibility, &placed, shows[appearance])
                            : result;
}
