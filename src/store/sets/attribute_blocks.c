// SPDX-License-Identifier: MIT
// Reads attributes of points: checks and links their blocks, and gives values of splats and points.
#include "store/bytes/values.h"
#include "store/file/block_table.h"
#include "store/file/tables.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

static stp_result fail(const stp_store* store, const char* what, uint32_t index, const char* fault)
{
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: %s %u %s", store->path, what, index,
                    fault);
}

static stp_result check_figures(const stp_store* store)
{
    const stp_store_attribute* figures = store->tables[STP_SECTION_ATTRIBUTES];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_ATTRIBUTES]; ++i) {
        const stp_store_attribute* f = &figures[i];
        if (f->attribute >= STP_ATTRIBUTES || (i > 0 && f->attribute <= figures[i - 1].attribute)) {
            return fail(store, "attribute", i, "is unknown or out of order");
        }
        if (f->count == 0 || f->low > f->low_percentile || f->high < f->high_percentile ||
            f->low_percentile > f->high_percentile) {
            return fail(store, "attribute", i, "has statistics that do not ascend");
        }
    }
    const stp_store_attribute_value* values = store->tables[STP_SECTION_ATTRIBUTE_VALUES];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_ATTRIBUTE_VALUES]; ++i) {
        bool ascends = i == 0 || values[i].attribute > values[i - 1].attribute ||
                       (values[i].attribute == values[i - 1].attribute &&
                        values[i].value > values[i - 1].value);
        if (values[i].attribute >= STP_ATTRIBUTES || !ascends) {
            return fail(store, "value of an attribute", i, "is out of order");
        }
    }
    return STP_OK;
}

stp_result stp_store_read_figures(stp_store* store, stp_store_text* text)
{
    static const uint32_t types[] = {STP_SECTION_ATTRIBUTES, STP_SECTION_ATTRIBUTE_VALUES,
                                     STP_SECTION_COORDINATES};
    stp_result result = STP_OK;
    for (size_t i = 0; i < sizeof(types) / sizeof(types[0]) && result == STP_OK; ++i) {
        result = stp_store_read_table(store, types[i], text);
    }
    result = result == STP_OK ? check_figures(store) : result;
    uint32_t coordinates = store->counts[STP_SECTION_COORDINATES];
    if (result == STP_OK && coordinates != 0 && coordinates != store->counts[STP_SECTION_SOURCES]) {
        result = stp_fail(store->context, STP_ERROR_FORMAT,
                          "%s: has %u coordinate systems for %u sources", store->path, coordinates,
                          store->counts[STP_SECTION_SOURCES]);
    }
    if (result != STP_OK) {
        return result;
    }
    const stp_store_coordinates* texts = store->tables[STP_SECTION_COORDINATES];
    stp_store_source* sources = store->tables[STP_SECTION_SOURCES];
    for (uint32_t i = 0; i < coordinates; ++i) {
        sources[i].coordinate_system = texts[i].text;
    }
    store->directory.attributes = store->tables[STP_SECTION_ATTRIBUTES];
    store->directory.attribute_count = store->counts[STP_SECTION_ATTRIBUTES];
    store->directory.attribute_values = store->tables[STP_SECTION_ATTRIBUTE_VALUES];
    store->directory.attribute_value_count = store->counts[STP_SECTION_ATTRIBUTE_VALUES];
    return STP_OK;
}

static bool is_attribute_block(const stp_store_block* block)
{
    return block->kind == STP_BLOCK_ATTRIBUTES || block->kind == STP_BLOCK_POINT_ATTRIBUTES;
}

// Index of an octave among all octaves; point sets follow. STP_STORE_NONE: no such owner.
static uint32_t place_of(const stp_store* store, const stp_store_block* block)
{
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    if (block->kind == STP_BLOCK_ATTRIBUTES) {
        bool there = block->owner < store->counts[STP_SECTION_SPLAT_SETS] &&
                     block->octave < sets[block->owner].splats.octave_count;
        return there ? sets[block->owner].first_octave + block->octave : STP_STORE_NONE;
    }
    bool there = block->owner < store->counts[STP_SECTION_POINT_SETS] && block->octave == 0;
    return there ? store->counts[STP_SECTION_OCTAVES] + block->owner : STP_STORE_NONE;
}

// Number of values per attribute in a block.
static uint64_t count_of(const stp_store* store, const stp_store_block* block)
{
    if (block->kind == STP_BLOCK_POINT_ATTRIBUTES) {
        return stp_store_describe_point_set(store, block->owner)->point_count;
    }
    const stp_splats* set = stp_store_describe_splat_set(store, block->owner);
    assert(block->octave < set->octave_count);
    return set->octave_ends[block->octave] - stp_store_octave_begin(set, block->octave);
}

static stp_result link_block(stp_store* store, uint32_t index)
{
    const stp_store_attribute_block* records = store->tables[STP_SECTION_ATTRIBUTE_BLOCKS];
    const stp_store_attribute_block* record = &records[index];
    const char* name = "block of attributes";
    if (record->block >= store->counts[STP_SECTION_BLOCKS] ||
        (index > 0 && record->block <= records[index - 1].block)) {
        return fail(store, name, index, "does not exist or is out of order");
    }
    const stp_store_block* block = stp_store_block_at(store, record->block);
    uint32_t place = is_attribute_block(block) ? place_of(store, block) : STP_STORE_NONE;
    if (place == STP_STORE_NONE || store->attribute_blocks[place] != STP_STORE_NONE) {
        return fail(store, name, index, "has no owner, or its owner has another one");
    }
    if (block->encoding != STP_STORE_VALUES_ENCODING) {
        return stp_fail(store->context, STP_ERROR_UNSUPPORTED, "%s: %s %u: unknown encoding %u",
                        store->path, name, index, block->encoding);
    }
    if (record->attributes == 0 || record->attributes >> STP_ATTRIBUTES != 0) {
        return fail(store, name, index, "holds attributes that this version does not define");
    }
    if (!stp_store_can_hold_values(record->attributes, count_of(store, block), block->size)) {
        return fail(store, name, index, "has the wrong size for its counts");
    }
    store->attribute_blocks[place] = index;
    return STP_OK;
}

stp_result stp_store_link_attributes(stp_store* store)
{
    uint32_t count = store->counts[STP_SECTION_ATTRIBUTE_BLOCKS], blocks = 0;
    size_t places =
        (size_t)store->counts[STP_SECTION_OCTAVES] + store->counts[STP_SECTION_POINT_SETS];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_BLOCKS]; ++i) {
        blocks += is_attribute_block(stp_store_block_at(store, i)) ? 1 : 0;
    }
    if (blocks != count) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: describes %u blocks of attributes but has %u", store->path, count,
                        blocks);
    }
    if (count == 0) {
        return STP_OK;
    }
    store->attribute_blocks = STP_NEW_ARRAY(store->context, uint32_t, places + 1);
    if (store->attribute_blocks == NULL) {
        return stp_fail_memory(store->context);
    }
    memset(store->attribute_blocks, 0xff, (places + 1) * sizeof(uint32_t));
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        result = link_block(store, i);
    }
    return result;
}

// The record of an owner's block, or NULL.
static const stp_store_attribute_block* record_of(const stp_store* store,
                                                  const stp_store_block* owner)
{
    const stp_store_attribute_block* records = store->tables[STP_SECTION_ATTRIBUTE_BLOCKS];
    uint32_t place = store->attribute_blocks != NULL ? place_of(store, owner) : STP_STORE_NONE;
    uint32_t record = place != STP_STORE_NONE ? store->attribute_blocks[place] : STP_STORE_NONE;
    return record != STP_STORE_NONE ? &records[record] : NULL;
}

static uint32_t attributes_of(const stp_store* store, const stp_store_block* owner)
{
    const stp_store_attribute_block* record = record_of(store, owner);
    return record != NULL &&
                   stp_store_is_block_here(store, stp_store_block_at(store, record->block))
               ? record->attributes
               : 0;
}

uint32_t stp_store_octave_attributes(const stp_store* store, uint32_t set, uint32_t octave)
{
    return attributes_of(
        store, &(stp_store_block){.kind = STP_BLOCK_ATTRIBUTES, .owner = set, .octave = octave});
}

uint32_t stp_store_point_attributes(const stp_store* store, uint32_t point_set)
{
    uint32_t held_by = stp_store_describe_point_set(store, point_set)->held_by;
    if (held_by != 0) {
        const stp_splats* set = stp_store_describe_splat_set(store, held_by - 1);
        return set->octave_count != 0
                   ? stp_store_octave_attributes(store, held_by - 1, set->octave_count - 1)
                   : 0;
    }
    return attributes_of(
        store, &(stp_store_block){.kind = STP_BLOCK_POINT_ATTRIBUTES, .owner = point_set});
}

stp_store_values stp_store_values_of(const stp_store* store, uint32_t kind, uint32_t owner,
                                     uint32_t octave)
{
    stp_store_block of = {.kind = kind, .owner = owner, .octave = octave};
    const stp_store_attribute_block* record = record_of(store, &of);
    if (record == NULL || attributes_of(store, &of) == 0) {
        return (stp_store_values){.block = NULL};
    }
    const stp_store_block* block = stp_store_block_at(store, record->block);
    return (stp_store_values){.block = block,
                              .attributes = record->attributes,
                              .count = count_of(store, block),
                              .read = stp_store_read_mapped,
                              .user = (void*)(uintptr_t)store};
}

const stp_store_attribute* stp_store_find_attribute(const stp_store* store, stp_attribute attribute)
{
    const stp_store_directory* d = &store->directory;
    for (uint32_t i = 0; i < d->attribute_count; ++i) {
        if (d->attributes[i].attribute == (uint32_t)attribute) {
            return &d->attributes[i];
        }
    }
    return NULL;
}

const char* stp_store_coordinate_system(const stp_store* store)
{
    const char* found = NULL;
    for (uint32_t i = 0; i < store->directory.source_count; ++i) {
        const char* own = store->directory.sources[i].coordinate_system;
        if (own != NULL && found != NULL && strcmp(own, found) != 0) {
            return NULL;
        }
        found = own != NULL ? own : found;
    }
    return found;
}

// Destination of decoded values.
typedef struct value_target {
    unsigned char* out;
    uint64_t first; ///< index of the value at `out`
    size_t size;
} value_target;

static void take_values(void* user, uint64_t first, const void* values, size_t count)
{
    const value_target* t = user;
    assert(first >= t->first);
    memcpy(t->out + (first - t->first) * t->size, values, count * t->size);
}

// Reads values [first, end) of a block; all 0 if the block lacks the attribute.
static stp_result get_values(stp_store* store, const stp_store_values* values,
                             stp_attribute attribute, uint64_t first, uint64_t end, void* out)
{
    assert(first <= end);
    value_target target = {out, first, stp_attribute_size(attribute)};
    uint64_t read_bytes = 0;
    if (values->block == NULL || !stp_store_has_bit(values->attributes, attribute)) {
        memset(out, 0, (size_t)(end - first) * target.size);
        return STP_OK;
    }
    const char* fault =
        stp_store_read_values(values, attribute, first, end, take_values, &target, &read_bytes);
    return fault != NULL ? stp_store_fail_block(store, values->block, fault) : STP_OK;
}

stp_result stp_store_get_values(stp_store* store, uint32_t set, stp_attribute attribute,
                                uint32_t first, uint32_t count, void* values)
{
    const stp_splats* splats =
        set < store->directory.set_count ? stp_store_describe_splat_set(store, set) : NULL;
    if (splats == NULL || first > splats->count || count > splats->count - first) {
        return stp_store_fail_index(store, "splat of a set, the last of values,", first + count);
    }
    size_t size = stp_attribute_size(attribute);
    uint64_t end = (uint64_t)first + count;
    stp_result result = STP_OK;
    for (uint32_t k = 0; k < splats->octave_count && result == STP_OK; ++k) {
        uint64_t begin = stp_store_octave_begin(splats, k), octave_end = splats->octave_ends[k];
        uint64_t from = first > begin ? first : begin, to = end < octave_end ? end : octave_end;
        if (from < to) {
            stp_store_values block = stp_store_values_of(store, STP_BLOCK_ATTRIBUTES, set, k);
            result = get_values(store, &block, attribute, from - begin, to - begin,
                                (unsigned char*)values + (from - first) * size);
        }
    }
    return result;
}

stp_result stp_store_get_point_values(stp_store* store, uint32_t point_set, stp_attribute attribute,
                                      uint32_t first, uint32_t count, void* values)
{
    const stp_store_point_set* points = point_set < store->directory.point_set_count
                                            ? stp_store_describe_point_set(store, point_set)
                                            : NULL;
    if (points == NULL || first > points->point_count || count > points->point_count - first) {
        return stp_store_fail_index(store, "point of a set, the last of values,", first + count);
    }
    if (points->held_by != 0) {
        return stp_store_get_values(store, points->held_by - 1, attribute, first, count, values);
    }
    stp_store_values block = stp_store_values_of(store, STP_BLOCK_POINT_ATTRIBUTES, point_set, 0);
    return get_values(store, &block, attribute, first, (uint64_t)first + count, values);
}

static void drop_values(void* user, uint64_t first, const void* values, size_t count)
{
    (void)user;
    (void)first;
    (void)values;
    (void)count;
}

stp_result stp_store_check_values(stp_store* store, const stp_store_block* block)
{
    const unsigned char* bytes = NULL;
    stp_store_values values = stp_store_values_of(store, block->kind, block->owner, block->octave);
    assert((values.block == NULL || values.block == block) && "an owner has one block");
    stp_result result = stp_store_verify_block(store, block, &bytes);
    for (uint32_t a = 0; a < STP_ATTRIBUTES && result == STP_OK; ++a) {
        uint64_t read_bytes = 0;
        if (stp_store_has_bit(values.attributes, a)) {
            const char* fault = stp_store_read_values(&values, (stp_attribute)a, 0, values.count,
                                                      drop_values, NULL, &read_bytes);
            result = fault != NULL ? stp_store_fail_block(store, block, fault) : STP_OK;
        }
    }
    return result;
}
