// SPDX-License-Identifier: MIT
#include "lod/set_columns.h"

#include <assert.h>
#include <string.h>

void stp_splats_destroy(stp_context* context, stp_splats* splats)
{
    stp_free(context, splats->positions);
    stp_free(context, splats->normals);
    stp_free(context, splats->materials);
    stp_free(context, splats->colors);
    stp_free(context, splats->coverages);
    stp_free(context, splats->turns);
    stp_free(context, splats->spreads);
    stp_free(context, splats->shapes);
    stp_free(context, splats->ranges);
    stp_free(context, splats->errors);
    stp_free(context, splats->leaves);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        stp_free(context, splats->attributes[i]);
    }
    *splats = (stp_splats){0};
}

static inline void copy_values(const unsigned char* column, const uint32_t* from, size_t count,
                               unsigned char* to_column, const uint32_t* to, size_t size)
{
    for (size_t i = 0; i < count; ++i) {
        size_t place = to != NULL ? to[i] : i;
        memcpy(to_column + place * size, column + from[i] * size, size);
    }
}

// Each size of an attribute has a loop of its own.
void stp_copy_attribute(stp_attribute attribute, const void* column, const uint32_t* from,
                        size_t count, void* to_column, const uint32_t* to)
{
    assert(attribute < STP_ATTRIBUTES);
    size_t size = stp_attribute_size(attribute);
    if (size == 1) {
        copy_values(column, from, count, to_column, to, 1);
    } else if (size == 2) {
        copy_values(column, from, count, to_column, to, 2);
    } else if (size == 8) {
        copy_values(column, from, count, to_column, to, 8);
    } else {
        copy_values(column, from, count, to_column, to, size);
    }
}

stp_result stp_splats_make_columns(stp_context* context, stp_splats* s)
{
    assert((s->columns & STP_SPLATS_FLAT_COLORS) != 0 && "one colour per splat");
    size_t count = s->count;
    s->positions = STP_NEW_ARRAY(context, uint16_t, 3 * count);
    s->normals = STP_NEW_ARRAY(context, int8_t, 2 * count);
    s->materials = STP_NEW_ARRAY(context, uint8_t, count);
    s->colors = STP_NEW_ARRAY(context, uint8_t, 3 * count);
    s->coverages = STP_NEW_ARRAY(context, uint8_t, count);
    s->shapes = STP_NEW_ARRAY(context, uint32_t, count);
    bool ranges = (s->columns & STP_SPLATS_RANGES) != 0;
    s->ranges = ranges ? STP_NEW_ARRAY(context, uint32_t, count) : NULL;
    bool errors = (s->columns & STP_SPLATS_ERRORS) != 0;
    s->errors = errors ? STP_NEW_ARRAY(context, uint32_t, count) : NULL;
    bool made = s->positions != NULL && s->normals != NULL && s->materials != NULL &&
                s->colors != NULL && s->coverages != NULL && s->shapes != NULL &&
                (s->ranges != NULL || !ranges) && (s->errors != NULL || !errors);
    return made ? STP_OK : stp_fail_memory(context);
}
