// SPDX-License-Identifier: MIT
#include "laz_encoder.h"

#include <assert.h>
#include <string.h>

void las_put(las_buffer* b, const void* bytes, size_t size)
{
    if (b->capacity < b->size + size) {
        b->capacity = 2 * (b->size + size) + 64;
        b->bytes = realloc(b->bytes, b->capacity);
    }
    if (size > 0) {
        memcpy(b->bytes + b->size, bytes, size);
    }
    b->size += size;
}

void las_put_number(las_buffer* b, uint64_t value, size_t size)
{
    unsigned char bytes[8];
    assert(size <= sizeof(bytes) && "a number has at most 8 bytes");
    for (size_t i = 0; i < size; ++i) {
        bytes[i] = (unsigned char)(value >> (8 * i));
    }
    las_put(b, bytes, size);
}

static void put_double(las_buffer* b, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    las_put_number(b, bits, 8);
}

static bool has_time(unsigned format)
{
    return format != 0 && format != 2;
}

static bool has_rgb(unsigned format)
{
    return format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
}

size_t las_record_size(const las_desc* desc)
{
    static const size_t sizes[11] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    assert(desc->format <= 10 && "a point format of LAS");
    return sizes[desc->format] + desc->extra;
}

size_t las_write_record(const las_desc* desc, size_t index, unsigned char* to)
{
    const las_point* p = &desc->points[index];
    unsigned format = desc->format;
    las_buffer b = {.bytes = to, .capacity = SIZE_MAX};
    for (int i = 0; i < 3; ++i) {
        las_put_number(&b, (uint32_t)p->position[i], 4);
    }
    las_put_number(&b, p->intensity, 2);
    if (format < 6) {
        las_put_number(&b, p->return_number | (unsigned)p->return_count << 3 | (p->flags & 1u) << 6,
                       1);
        las_put_number(&b, p->class | (p->flags & 7u) << 5, 1);
        las_put_number(&b, (uint8_t)(int8_t)p->angle, 1);
        las_put_number(&b, p->user, 1);
    } else {
        las_put_number(&b, p->return_number | (unsigned)p->return_count << 4, 1);
        las_put_number(&b, (unsigned)p->channel << 4, 1);
        las_put_number(&b, p->class, 1);
        las_put_number(&b, p->user, 1);
        las_put_number(&b, (uint16_t)p->angle, 2);
    }
    las_put_number(&b, p->source, 2);
    if (has_time(format)) {
        las_put_number(&b, p->time, 8);
    }
    for (int i = 0; i < 3 && has_rgb(format); ++i) {
        las_put_number(&b, p->rgb[i], 2);
    }
    if (format == 8 || format == 10) {
        las_put_number(&b, p->nir, 2);
    }
    for (size_t k = b.size; k < las_record_size(desc); ++k) { // wave packets and extra bytes
        las_put_number(&b, (index * 7 + k) & 255, 1);
    }
    assert(b.size == las_record_size(desc) && "a record has its full size");
    return b.size;
}

static void put_vlr(las_buffer* b, const char* user, unsigned id, const void* bytes, size_t size,
                    bool extended)
{
    char text[34] = {0};
    assert(strlen(user) <= 16 && "the field holds the user id");
    memcpy(text + 2, user, strlen(user));
    las_put(b, text, 18);
    las_put_number(b, id, 2);
    las_put_number(b, size, extended ? 8 : 2);
    memset(text, 0, sizeof(text));
    las_put(b, text, 32);
    las_put(b, bytes, size);
}

static void put_laz_vlr(las_buffer* b, const las_desc* desc)
{
    bool layered = desc->format >= 6, wave = desc->format == 4 || desc->format == 5;
    bool nir = desc->format == 8 || desc->format == 10;
    unsigned version = layered ? (desc->fixed ? 4 : 3) : 2, items = 0;
    wave = wave || desc->format >= 9;
    las_buffer list = {0}, vlr = {0};
    struct {
        bool there;
        unsigned type, size, version;
    } all[] = {
        {true, layered ? 10 : 6, layered ? 30 : 20, version},
        {!layered && has_time(desc->format), 7, 8, version},
        {has_rgb(desc->format), layered ? (nir ? 12 : 11) : 8, nir ? 8 : 6, version},
        {wave, layered ? 13 : 9, 29, layered ? version : 1},
        {desc->extra > 0, layered ? 14 : 0, desc->extra, version},
    };
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); ++i) {
        if (all[i].there) {
            items += 1;
            las_put_number(&list, all[i].type, 2);
            las_put_number(&list, all[i].size, 2);
            las_put_number(&list, all[i].version, 2);
        }
    }
    las_put_number(&vlr, layered ? 3 : desc->coding == LAZ_SINGLE ? 1 : 2, 2);
    las_put_number(&vlr, 0, 2);
    las_put_number(&vlr, 2 | 2 << 8, 4);
    las_put_number(&vlr, 0, 4);
    las_put_number(&vlr, desc->coding == LAZ_VARIABLE ? UINT32_MAX : desc->chunk_size, 4);
    las_put_number(&vlr, UINT64_MAX, 8);
    las_put_number(&vlr, UINT64_MAX, 8);
    las_put_number(&vlr, items, 2);
    las_put(&vlr, list.bytes, list.size);
    put_vlr(b, "laszip encoded", 22204, vlr.bytes, vlr.size, false);
    free(list.bytes);
    free(vlr.bytes);
}

static void put_header(las_buffer* b, const las_desc* desc, unsigned vlrs)
{
    static const char zero[64] = {0};
    size_t size = desc->format >= 6 || desc->extended_wkt ? 375 : 227;
    las_put(b, "LASF", 4);
    las_put(b, zero, 20);
    las_put_number(b, 1 | (size == 375 ? 4u : 2u) << 8, 2);
    las_put(b, zero, 64);
    las_put(b, zero, 4);
    las_put_number(b, size, 2);
    las_put_number(b, 0, 4); // where points begin: patched
    las_put_number(b, vlrs, 4);
    las_put_number(b, desc->format | (desc->coding != LAS_RAW ? 128u : 0), 1);
    las_put_number(b, las_record_size(desc), 2);
    las_put_number(b, desc->format >= 6 ? 0 : desc->count, 4);
    las_put(b, zero, 20);
    double scale = desc->scale != 0.0 ? desc->scale : 0.01;
    for (int i = 0; i < 6; ++i) {
        put_double(b, i < 3 ? scale : desc->offset);
    }
    for (int i = 0; i < 3; ++i) {
        int32_t low = INT32_MAX, high = INT32_MIN;
        for (size_t k = 0; k < desc->count; ++k) {
            int32_t v = desc->points[k].position[i];
            low = v < low ? v : low;
            high = v > high ? v : high;
        }
        put_double(b, high * scale + desc->offset);
        put_double(b, low * scale + desc->offset);
    }
    if (size == 375) {
        las_put(b, zero, 16); // EVLRs: patched
        las_put_number(b, 0, 4);
        las_put_number(b, desc->count, 8);
        las_put(b, zero, 60);
        las_put(b, zero, 60);
    }
}

static void patch(las_buffer* b, size_t at, uint64_t value, size_t size)
{
    assert(at + size <= b->size && "only written bytes are patched");
    for (size_t i = 0; i < size; ++i) {
        b->bytes[at + i] = (unsigned char)(value >> (8 * i));
    }
}

static void put_table(las_buffer* b, const las_desc* desc, const size_t* counts,
                      const size_t* sizes, size_t chunks)
{
    stp_laz_integer integer = {0};
    stp_laz_pool pool = {0};
    stp_laz_integer_make(&pool, &integer, 32, 2);
    pool = (stp_laz_pool){.bytes = calloc(1, pool.used)};
    unsigned char* numbers = pool.bytes;
    stp_laz_integer_make(&pool, &integer, 32, 2);
    laz_encoder e = laz_encoder_begin();
    for (size_t i = 0; i < chunks; ++i) {
        if (desc->coding == LAZ_VARIABLE) {
            laz_put_integer(&e, &integer, i > 0 ? (int32_t)counts[i - 1] : 0, (int32_t)counts[i], 0,
                            32);
        }
        laz_put_integer(&e, &integer, i > 0 ? (int32_t)sizes[i - 1] : 0, (int32_t)sizes[i], 1, 32);
    }
    laz_encoder_end(&e);
    las_put_number(b, 0, 4);
    las_put_number(b, chunks, 4);
    las_put(b, e.out.bytes, e.out.size);
    free(e.out.bytes);
    free(numbers);
}

static void put_chunks(las_buffer* b, const las_desc* desc)
{
    enum { MAX_CHUNKS = 4096 };
    static size_t counts[MAX_CHUNKS], sizes[MAX_CHUNKS];
    size_t chunks = 0, pointer = b->size;
    bool single = desc->coding == LAZ_SINGLE;
    if (!single) {
        las_put_number(b, UINT64_MAX, 8);
    }
    for (size_t first = 0; first < desc->count; ++chunks) {
        size_t wish = single                         ? desc->count
                      : desc->coding == LAZ_VARIABLE ? (chunks % 3 + 1) * desc->chunk_size
                                                     : desc->chunk_size;
        size_t left = desc->count - first, begin = b->size;
        assert(chunks < MAX_CHUNKS && wish > 0 && "the arrays hold all chunks");
        counts[chunks] = wish < left ? wish : left;
        (desc->format >= 6 ? laz_write_layered : laz_write_pointwise)(desc, first, counts[chunks],
                                                                      b);
        sizes[chunks] = b->size - begin;
        first += counts[chunks];
    }
    if (!single) {
        size_t table = b->size;
        put_table(b, desc, counts, sizes, chunks);
        if (desc->table_at_end) {
            las_put_number(b, table, 8);
        } else {
            patch(b, pointer, table, 8);
        }
    }
}

las_buffer las_write(const las_desc* desc)
{
    las_buffer b = {0};
    bool vlr_wkt = desc->wkt != NULL && !desc->extended_wkt;
    unsigned vlrs = (desc->coding != LAS_RAW ? 1u : 0u) + (vlr_wkt ? 1u : 0u) +
                    (desc->keys != NULL ? 1u : 0u) + (desc->vlr_user != NULL ? 1u : 0u);
    put_header(&b, desc, vlrs);
    if (desc->vlr_user != NULL) {
        put_vlr(&b, desc->vlr_user, desc->vlr_id, desc->vlr, desc->vlr_size, false);
    }
    if (vlr_wkt) {
        put_vlr(&b, "LASF_Projection", 2112, desc->wkt, strlen(desc->wkt) + 1, false);
    }
    if (desc->keys != NULL) {
        put_vlr(&b, "LASF_Projection", 34735, desc->keys, 2 * desc->key_numbers, false);
    }
    if (desc->coding != LAS_RAW) {
        put_laz_vlr(&b, desc);
    }
    patch(&b, 96, b.size, 4);
    unsigned char record[256];
    assert(las_record_size(desc) <= sizeof(record) && "the buffer holds a record");
    for (size_t i = 0; i < desc->count && desc->coding == LAS_RAW; ++i) {
        las_put(&b, record, las_write_record(desc, i, record));
    }
    if (desc->coding != LAS_RAW) {
        put_chunks(&b, desc);
    }
    if (desc->wkt != NULL && desc->extended_wkt) {
        patch(&b, 235, b.size, 8);
        patch(&b, 243, 1, 4);
        put_vlr(&b, "LASF_Projection", 2112, desc->wkt, strlen(desc->wkt) + 1, true);
    }
    return b;
}
