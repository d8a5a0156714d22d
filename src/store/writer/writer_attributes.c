// SPDX-License-Identifier: MIT
// Writes attributes: their statistics and blocks.
#include "base/io/bytes.h"
#include "store/bytes/columns.h"
#include "store/bytes/values.h"
#include "store/file/content.h"
#include "store/file/point_attributes.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    BATCH = 32,        ///< chunks compressed at once
    BINS = 1 << 16,    ///< bins of a histogram
    PERCENT = 2,       ///< share of values below the lower percentile, and above the higher one
    CLASS_COUNT = 256, ///< distinct values that are counted
};

// The values of an attribute over all point sets.
typedef struct histogram {
    stp_store_attribute figures;
    uint64_t* bins;
} histogram;

static uint64_t bin_of(const histogram* h, double value)
{
    if (h->figures.attribute != STP_ATTRIBUTE_TIME) {
        assert(value >= h->figures.low && value - h->figures.low < (double)BINS);
        return (uint64_t)(value - h->figures.low);
    }
    double width = h->figures.high - h->figures.low;
    double place = width > 0.0 ? (value - h->figures.low) / width * (double)BINS : 0.0;
    return place < (double)(BINS - 1) ? (uint64_t)place : BINS - 1;
}

static double value_of_bin(const histogram* h, uint64_t bin)
{
    if (h->figures.attribute != STP_ATTRIBUTE_TIME) {
        return h->figures.low + (double)bin;
    }
    double part = ((double)bin + 0.5) / (double)BINS;
    return h->figures.low + part * (h->figures.high - h->figures.low);
}

static double find_percentile(const histogram* h, double share)
{
    double wanted = share * (double)h->figures.count;
    uint64_t sum = 0, bin = 0;
    while (bin < BINS - 1 && (double)(sum + h->bins[bin]) <= wanted) {
        sum += h->bins[bin++];
    }
    return value_of_bin(h, bin);
}

static void count_read(stp_store_writing* w, const stp_store_point_set* set, uint32_t a)
{
    if (set->attributes[a] != NULL) {
        stp_store_count_read(w, (uint64_t)set->point_count * stp_attribute_size((stp_attribute)a));
    }
}

static void measure_range(stp_store_writing* w, stp_store_attribute* figures)
{
    const stp_store_content* content = w->content;
    uint32_t a = figures->attribute;
    figures->low = HUGE_VAL;
    figures->high = -HUGE_VAL;
    for (uint32_t i = 0; i < content->directory.point_set_count; ++i) {
        const stp_store_point_set* set = &content->point_sets[i];
        for (size_t k = 0; set->attributes[a] != NULL && k < set->point_count; ++k) {
            double value = stp_attribute_number((stp_attribute)a, set->attributes[a], k);
            figures->low = value < figures->low ? value : figures->low;
            figures->high = value > figures->high ? value : figures->high;
            figures->count += 1;
        }
        count_read(w, set, a);
    }
}

static void measure_attribute(stp_store_writing* w, histogram* h)
{
    const stp_store_content* content = w->content;
    uint32_t a = h->figures.attribute;
    memset(h->bins, 0, BINS * sizeof(*h->bins));
    for (uint32_t i = 0; i < content->directory.point_set_count; ++i) {
        const stp_store_point_set* set = &content->point_sets[i];
        for (size_t k = 0; set->attributes[a] != NULL && k < set->point_count; ++k) {
            h->bins[bin_of(h, stp_attribute_number((stp_attribute)a, set->attributes[a], k))] += 1;
        }
        count_read(w, set, a);
    }
    h->figures.low_percentile = find_percentile(h, 0.01 * PERCENT);
    h->figures.high_percentile = find_percentile(h, 1.0 - 0.01 * PERCENT);
}

static void list_classes(const histogram* h, stp_store_writing* w)
{
    for (uint32_t bin = 0; bin < CLASS_COUNT; ++bin) {
        if (h->bins[bin] != 0) {
            assert(w->attribute_value_count < CLASS_COUNT);
            w->attribute_values[w->attribute_value_count++] =
                (stp_store_attribute_value){.attribute = h->figures.attribute,
                                            .value = (uint32_t)value_of_bin(h, bin),
                                            .count = h->bins[bin]};
        }
    }
}

stp_result stp_store_measure_attributes(stp_store_writing* w)
{
    histogram h = {.bins = NULL};
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        h.figures = (stp_store_attribute){.attribute = a};
        measure_range(w, &h.figures);
        if (h.figures.count == 0) {
            continue;
        }
        if (h.bins == NULL) {
            h.bins = STP_NEW_ARRAY(w->context, uint64_t, BINS);
            w->attribute_values = STP_NEW_ARRAY(w->context, stp_store_attribute_value, CLASS_COUNT);
        }
        if (h.bins == NULL || w->attribute_values == NULL) {
            stp_free(w->context, h.bins);
            return stp_fail_memory(w->context);
        }
        measure_attribute(w, &h);
        w->attributes[w->attribute_count++] = h.figures;
        if (a == STP_ATTRIBUTE_CLASS) {
            list_classes(&h, w);
        }
    }
    stp_free(w->context, h.bins);
    return STP_OK;
}

// Chunks of one attribute of one block that are compressed together.
typedef struct value_batch {
    stp_store_writing* w;
    const stp_store_block* block;
    stp_attribute attribute;
    const unsigned char* values;
    uint64_t count;        ///< number of values
    uint64_t first;        ///< index of the first chunk
    unsigned char* stored; ///< room for BATCH chunks
    unsigned char* split;  ///< room for a chunk of each thread
    uint32_t sizes[BATCH]; ///< 0: out of memory
    stp_store_packer** packers;
} value_batch;

static void pack_values(size_t begin, size_t end, uint32_t worker, void* user)
{
    value_batch* b = user;
    unsigned char* split = b->split + (size_t)worker * STP_STORE_CHUNK_BYTES;
    size_t size = stp_attribute_size(b->attribute);
    uint64_t each = stp_store_values_each(b->attribute);
    bool passing = b->w->content->passing;
    if (b->packers[worker] == NULL && !passing) {
        b->packers[worker] = stp_store_packer_create();
    }
    for (size_t i = begin; i < end; ++i) {
        uint64_t first = (b->first + i) * each, left = b->count - first;
        assert(first < b->count);
        size_t count = (size_t)(left < each ? left : each);
        bool good = b->packers[worker] != NULL || passing;
        stp_store_split_values(b->values + first * size, count, size,
                               b->block->kind == STP_BLOCK_POINT_ATTRIBUTES, split);
        unsigned char* out = b->stored + i * STP_STORE_CHUNK_BYTES;
        b->sizes[i] =
            good ? (uint32_t)stp_store_pack(b->packers[worker], split, count * size, out) : 0;
    }
}

// Writes the chunks of one attribute and fills in their table.
static stp_result write_attribute(value_batch* b, unsigned char** table)
{
    stp_store_writing* w = b->w;
    uint64_t chunks = stp_store_values_chunks(stp_attribute_bit(b->attribute), b->count);
    stp_result result = STP_OK;
    for (b->first = 0; b->first < chunks && result == STP_OK; b->first += BATCH) {
        uint64_t left = chunks - b->first;
        size_t count = (size_t)(left < BATCH ? left : BATCH);
        stp_parallel_for(w->context, count, 1, pack_values, b);
        for (size_t i = 0; i < count && result == STP_OK; ++i, *table += STP_STORE_CHUNK_ENTRY) {
            const unsigned char* bytes = b->stored + i * STP_STORE_CHUNK_BYTES;
            stp_write_u32(*table, b->sizes[i]);
            stp_write_u32(*table + 4, stp_store_crc(0, bytes, b->sizes[i]));
            result = b->sizes[i] != 0 ? stp_store_emit(w, bytes, b->sizes[i])
                                      : stp_fail_memory(w->context);
        }
    }
    return result;
}

static const void* values_of(const stp_store_writing* w, const stp_store_block* block, uint32_t a)
{
    if (block->kind == STP_BLOCK_POINT_ATTRIBUTES) {
        return w->content->point_sets[block->owner].attributes[a];
    }
    const stp_splats* set = &w->content->sets[block->owner];
    size_t begin = stp_store_octave_begin(set, block->octave);
    return (const unsigned char*)set->attributes[a] + begin * stp_attribute_size((stp_attribute)a);
}

static uint64_t count_of(const stp_store_writing* w, const stp_store_block* block)
{
    if (block->kind == STP_BLOCK_POINT_ATTRIBUTES) {
        return w->content->point_sets[block->owner].point_count;
    }
    const stp_splats* set = &w->content->sets[block->owner];
    assert(block->octave < set->octave_count);
    return set->octave_ends[block->octave] - stp_store_octave_begin(set, block->octave);
}

static stp_result write_values(value_batch* b, stp_store_block* block)
{
    stp_store_writing* w = b->w;
    uint32_t attributes = stp_store_planned_attributes(w->content, block);
    b->block = block;
    b->count = count_of(w, block);
    size_t size = (size_t)stp_store_values_chunks(attributes, b->count) * STP_STORE_CHUNK_ENTRY;
    unsigned char* table = STP_NEW_ARRAY(w->context, unsigned char, size + 4);
    unsigned char* next = table;
    stp_result result = table != NULL ? stp_store_pad(w) : stp_fail_memory(w->context);
    block->offset = stp_file_writer_size(w->file);
    w->crc = 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES && result == STP_OK; ++a) {
        if (stp_store_has_bit(attributes, a)) {
            b->attribute = (stp_attribute)a;
            b->values = values_of(w, block, a);
            result = write_attribute(b, &next);
        }
    }
    if (result == STP_OK) {
        assert(next == table + size && "every chunk has an entry");
        stp_write_u32(next, stp_store_crc(0, table, size));
        result = stp_store_emit(w, table, size + 4);
    }
    block->crc = w->crc;
    block->size = stp_file_writer_size(w->file) - block->offset;
    assert(result != STP_OK || stp_store_can_hold_values(attributes, b->count, block->size));
    stp_free(w->context, table);
    return result;
}

stp_result stp_store_write_values(stp_store_writing* w, stp_store_block* block)
{
    uint32_t threads = stp_context_thread_count(w->context);
    value_batch b = {.w = w,
                     .stored = stp_alloc_array(w->context, BATCH, STP_STORE_CHUNK_BYTES),
                     .split = stp_alloc_array(w->context, threads, STP_STORE_CHUNK_BYTES),
                     .packers = STP_NEW_ZEROED(w->context, stp_store_packer*, threads)};
    bool made = b.stored != NULL && b.split != NULL && b.packers != NULL;
    stp_result result = made ? write_values(&b, block) : stp_fail_memory(w->context);
    for (uint32_t i = 0; b.packers != NULL && i < threads; ++i) {
        stp_store_packer_destroy(b.packers[i]);
    }
    stp_free(w->context, b.packers);
    stp_free(w->context, b.split);
    stp_free(w->context, b.stored);
    return result;
}
