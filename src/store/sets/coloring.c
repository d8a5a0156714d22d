// SPDX-License-Identifier: MIT
// Makes the colours and coverages that replace those of the file.
#include "base/math/color.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

enum { MIN_COVERAGE = 1 }; ///< smallest code that is drawn where 0 hides a splat

bool stp_attribute_is_distinct(stp_attribute attribute)
{
    return attribute == STP_ATTRIBUTE_CLASS || attribute == STP_ATTRIBUTE_RETURN ||
           attribute == STP_ATTRIBUTE_RETURNS || attribute == STP_ATTRIBUTE_SOURCE;
}

/// The colour of a value, in sRGB.
static void color_value(const stp_store_coloring* coloring, double value, uint8_t color[3])
{
    const uint8_t* found;
    if (coloring->attribute == STP_ATTRIBUTE_CLASS) {
        found = stp_class_color((uint32_t)value);
    } else if (stp_attribute_is_distinct(coloring->attribute)) {
        found = stp_distinct_colors[(uint32_t)value % STP_DISTINCT_COLORS];
    } else {
        found = stp_color_map[stp_color_map_place(value, coloring->low, coloring->high)];
    }
    memcpy(color, found, 3);
}

bool stp_store_is_colored(const stp_store* store)
{
    return store->coloring.by_attribute || store->coloring.hides;
}

const stp_store_coloring* stp_store_get_coloring(const stp_store* store)
{
    return &store->coloring;
}

stp_result stp_store_set_coloring(stp_store* store, const stp_store_coloring* coloring)
{
    static const stp_store_coloring none = {0};
    if (store->residency != NULL) {
        return stp_fail(store->context, STP_ERROR_ARGUMENT,
                        "%s: colours cannot change while data is being loaded", store->path);
    }
    store->coloring = coloring != NULL ? *coloring : none;
    for (uint32_t i = 0; i < store->directory.set_count; ++i) {
        stp_store_release_splat_set(store, i);
    }
    stp_store_release_points(store); // the file's own colours are restored on the next use
    return STP_OK;
}

// Targets of the conversion.
typedef struct paint {
    const stp_store_coloring* coloring;
    uint8_t* colors;
    size_t stride; ///< bytes from one colour to the next
    uint8_t* marks;
    size_t mark_stride; ///< bytes from one coverage, or alpha, to the next
} paint;

static void take_colors(void* user, uint64_t first, const void* values, size_t count)
{
    const paint* p = user;
    for (size_t i = 0; i < count; ++i) {
        double value = stp_attribute_number(p->coloring->attribute, values, i);
        color_value(p->coloring, value, p->colors + (first + i) * p->stride);
    }
}

static void take_classes(void* user, uint64_t first, const void* values, size_t count)
{
    const paint* p = user;
    const uint8_t* classes = values;
    for (size_t i = 0; i < count; ++i) {
        if (!p->coloring->shown[classes[i]]) {
            p->marks[(first + i) * p->mark_stride] = 0;
        }
    }
}

// Colours and marks `values->count` items. Visible items are already marked.
static const char* paint_values(const stp_store_values* values, paint* p, uint64_t* read_bytes)
{
    const stp_store_coloring* c = p->coloring;
    const char* fault = NULL;
    if (values->block == NULL) {
        return NULL;
    }
    if (c->by_attribute && stp_store_has_bit(values->attributes, c->attribute)) {
        fault = stp_store_read_values(values, c->attribute, 0, values->count, take_colors, p,
                                      read_bytes);
    }
    if (fault == NULL && c->hides && stp_store_has_bit(values->attributes, STP_ATTRIBUTE_CLASS)) {
        fault = stp_store_read_values(values, STP_ATTRIBUTE_CLASS, 0, values->count, take_classes,
                                      p, read_bytes);
    }
    return fault;
}

// Splats of earlier octaves keep their look from there.
static void copy_earlier(const stp_store_coloring* c, const stp_splats* s, uint32_t octave,
                         size_t entry, bool colored)
{
    assert(octave > 0 && octave < s->octave_count);
    size_t count = stp_store_octave_begin(s, octave);
    size_t before = (size_t)stp_store_pyramid_begin(s, octave - 1);
    if (c->by_attribute && colored) {
        memcpy(s->colors + 3 * entry, s->colors + 3 * before, 3 * count);
    }
    for (size_t i = 0; c->hides && i < count; ++i) {
        if (s->coverages[before + i] == 0) {
            s->coverages[entry + i] = 0;
        }
    }
}

const char* stp_store_color_octave(const stp_store* store, uint32_t index, uint32_t octave,
                                   const stp_splats* splats, const stp_store_block_source* source,
                                   uint64_t* read_bytes)
{
    const stp_store_coloring* c = &store->coloring;
    if (!stp_store_is_colored(store)) {
        return NULL;
    }
    size_t entry = (size_t)stp_store_pyramid_begin(splats, octave);
    size_t end = (size_t)stp_store_pyramid_begin(splats, octave + 1);
    bool flat = (splats->columns & STP_SPLATS_FLAT_COLORS) != 0;
    size_t begin = flat ? 0 : stp_store_octave_begin(splats, octave);
    for (size_t i = entry; c->hides && i < end; ++i) {
        splats->coverages[i] =
            splats->coverages[i] > MIN_COVERAGE ? splats->coverages[i] : MIN_COVERAGE;
    }
    stp_store_values values = stp_store_values_of(store, STP_BLOCK_ATTRIBUTES, index, octave);
    assert(values.block == NULL || values.count == end - entry - begin);
    if (!flat && octave > 0) {
        copy_earlier(c, splats, octave, entry, stp_store_has_bit(values.attributes, c->attribute));
    }
    values.read = source->read;
    values.user = source->user;
    paint p = {.coloring = c,
               .colors = splats->colors + 3 * (entry + begin),
               .stride = 3,
               .marks = splats->coverages + entry + begin,
               .mark_stride = 1};
    return paint_values(&values, &p, read_bytes);
}

const char* stp_store_color_points(const stp_store* store, uint32_t index, const uint8_t* colors,
                                   const stp_store_block_source* source, uint8_t* colored,
                                   uint64_t* read_bytes)
{
    size_t count = stp_store_describe_point_set(store, index)->point_count;
    for (size_t i = 0; i < count; ++i) {
        memset(colored + 4 * i, 255, 4);
        if (colors != NULL) {
            memcpy(colored + 4 * i, colors + 4 * i, 3);
        }
    }
    stp_store_values values = stp_store_values_of(store, STP_BLOCK_POINT_ATTRIBUTES, index, 0);
    assert(values.block == NULL || values.count == count);
    values.read = source->read;
    values.user = source->user;
    paint p = {.coloring = &store->coloring,
               .colors = colored,
               .stride = 4,
               .marks = colored + 3,
               .mark_stride = 4};
    return paint_values(&values, &p, read_bytes);
}
