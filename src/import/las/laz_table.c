// SPDX-License-Identifier: MIT
// The VLR of LAZ describes how points are coded. The chunk table contains the offset of each chunk
// and, if chunk sizes vary, the number of points.
#include "base/io/bytes.h"
#include "import/las/laz.h"

#include <assert.h>
#include <string.h>

enum {
    VLR_ID = 22204,
    VLR_SIZE = 34, // without items
    ITEM_SIZE = 6,
    COMPRESSOR_POINTWISE = 1,
    COMPRESSOR_CHUNKED = 2,
    COMPRESSOR_LAYERED = 3,
    MAX_POINTS_PER_BYTE = 2048, // identical points take about 0.008 bits each
    MAX_EXTRA = 1 << 14,        // extra bytes per point: each needs a model of 1.3 KB
    POINTS_ALWAYS_ALLOWED = 1 << 24,
    POINTS_PER_BYTE = 256 // more than chunks of 50,000 equal points have
};
#define VARIABLE UINT32_MAX // a chunk size: each chunk has its own

// Types of items.
enum {
    BYTES = 0,
    POINT_OLD = 6,
    TIME_OLD = 7,
    RGB_OLD = 8,
    WAVE_OLD = 9,
    POINT_NEW = 10,
    RGB_NEW = 11,
    RGB_NIR_NEW = 12,
    WAVE_NEW = 13,
    BYTES_NEW = 14
};

typedef struct item {
    unsigned type;
    size_t size;
    unsigned version;
} item;

enum { MAX_ITEMS = 5 };

// The items of a format.
static size_t expect_items(const stp_las* las, item items[MAX_ITEMS])
{
    size_t count = 0, extra = las->record_size - las->layout.size;
    bool layered = las->format >= 6;
    unsigned version = layered ? 3 : 2;
    items[count++] = layered ? (item){POINT_NEW, 30, version} : (item){POINT_OLD, 20, version};
    if (!layered && las->layout.time != STP_LAS_NO_FIELD) {
        items[count++] = (item){TIME_OLD, 8, version};
    }
    if (las->layout.nir != STP_LAS_NO_FIELD) {
        items[count++] = (item){RGB_NIR_NEW, 8, version};
    } else if (las->layout.rgb != STP_LAS_NO_FIELD) {
        items[count++] = (item){layered ? RGB_NEW : RGB_OLD, 6, version};
    }
    if (las->layout.wave != STP_LAS_NO_FIELD) {
        items[count++] = (item){layered ? WAVE_NEW : WAVE_OLD, STP_LAS_WAVE_SIZE, layered ? 3 : 1};
    }
    if (extra > 0) {
        items[count++] = (item){layered ? BYTES_NEW : BYTES, extra, version};
    }
    assert(count <= MAX_ITEMS);
    return count;
}

static stp_result check_items(stp_las* las, const unsigned char* bytes, size_t count)
{
    item items[MAX_ITEMS];
    size_t expected = expect_items(las, items);
    const char* path = las->import->path;
    if (las->record_size - las->layout.size > MAX_EXTRA) {
        return stp_fail(las->context, STP_ERROR_LIMIT,
                        "%s: its compressed points have %zu bytes each; up to %d are supported",
                        path, las->record_size, MAX_EXTRA);
    }
    if (count != expected) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its compressed points have %zu items; those of format %u with %zu "
                        "bytes have %zu",
                        path, count, las->format, las->record_size, expected);
    }
    for (size_t i = 0; i < count; ++i, bytes += ITEM_SIZE) {
        unsigned type = stp_read_u16(bytes), version = stp_read_u16(bytes + 4);
        size_t size = stp_read_u16(bytes + 2);
        bool newer = las->format >= 6 && version == 4;
        if (type != items[i].type || size != items[i].size) {
            return stp_fail(las->context, STP_ERROR_FORMAT,
                            "%s: item %zu of its compressed points is of type %u with %zu bytes; "
                            "type %u with %zu is expected",
                            path, i, type, size, items[i].type, items[i].size);
        }
        if (version != items[i].version && !newer) {
            return stp_fail(las->context, STP_ERROR_UNSUPPORTED,
                            "%s: item %zu of its compressed points has version %u; version %u is "
                            "supported (save the file again with a current program)",
                            path, i, version, items[i].version);
        }
        las->items_fixed = newer;
    }
    return STP_OK;
}

typedef struct compression {
    unsigned compressor;
    uint32_t chunk_size; ///< points; VARIABLE: stored in the table
} compression;

static stp_result read_vlr(stp_las* las, compression* c)
{
    stp_las_record vlr;
    const char* path = las->import->path;
    if (!stp_las_find_record(las, "laszip encoded", VLR_ID, &vlr) || vlr.size < VLR_SIZE) {
        return stp_fail(
            las->context, STP_ERROR_FORMAT,
            "%s: its points are compressed, but the VLR that describes the compression is missing",
            path);
    }
    size_t count = stp_read_u16(vlr.bytes + 32);
    unsigned coder = stp_read_u16(vlr.bytes + 2);
    c->compressor = stp_read_u16(vlr.bytes);
    c->chunk_size = stp_read_u32(vlr.bytes + 12);
    c->chunk_size = c->chunk_size != 0 ? c->chunk_size : VARIABLE; // as LASzip reads it
    if (vlr.size < VLR_SIZE + count * ITEM_SIZE) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: the VLR of its compression is too short for its %zu items", path,
                        count);
    }
    bool layered = c->compressor == COMPRESSOR_LAYERED;
    bool known =
        layered || c->compressor == COMPRESSOR_POINTWISE || c->compressor == COMPRESSOR_CHUNKED;
    if (!known || coder != 0 || layered != (las->format >= 6)) {
        return stp_fail(las->context, STP_ERROR_UNSUPPORTED,
                        "%s: points of format %u are compressed by method %u with coder %u, which "
                        "is not supported",
                        path, las->format, c->compressor, coder);
    }
    las->items = layered ? STP_LAZ_LAYERED : STP_LAZ_POINTWISE;
    return check_items(las, vlr.bytes + VLR_SIZE, count);
}

static stp_result fail_table(const stp_las* las, const char* why)
{
    return stp_fail(las->context, STP_ERROR_TRUNCATED,
                    "%s: its table of chunks %s: the file was truncated or never finished",
                    las->import->path, why);
}

// Sizes and counts are coded as differences from the previous chunk.
typedef struct table_reader {
    stp_laz_decoder decoder;
    stp_laz_integer integer;
    unsigned char* numbers;
    unsigned char tail[STP_LAZ_TAIL];
} table_reader;

static stp_result read_entries(stp_las* las, table_reader* t, uint32_t chunk_size, uint64_t end)
{
    uint64_t at = las->points + 8, given = 0;
    uint32_t count = 0, size = 0;
    for (size_t i = 0; i < las->chunk_count; ++i) {
        uint64_t left = las->point_count - given;
        assert(given <= las->point_count && at <= end);
        stp_laz_ensure(&t->decoder, 64);
        if (chunk_size == VARIABLE) {
            count += stp_laz_difference(&t->decoder, &t->integer, 0);
        } else {
            count = left < chunk_size ? (uint32_t)left : chunk_size;
        }
        size += stp_laz_difference(&t->decoder, &t->integer, 1);
        if (!stp_laz_is_good(&t->decoder)) {
            return fail_table(las, "is incomplete");
        }
        if (size > end - at || count > left || count / MAX_POINTS_PER_BYTE > size) {
            return stp_fail(
                las->context, STP_ERROR_FORMAT,
                "%s: chunk %zu of %zu has %u points in %u bytes by its table, which is impossible",
                las->import->path, i, las->chunk_count, count, size);
        }
        las->chunks[i] = (stp_las_chunk){
            .offset = at, .size = size, .first = given, .count = count, .read = count};
        at += size;
        given += count;
    }
    if (given != las->point_count) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its %zu chunks have %llu points, but the header says %llu",
                        las->import->path, las->chunk_count, (unsigned long long)given,
                        (unsigned long long)las->point_count);
    }
    return STP_OK;
}

static stp_result decode_table(stp_las* las, table_reader* t, uint32_t chunk_size, uint64_t table)
{
    stp_laz_pool pool = {0};
    stp_laz_integer_make(&pool, &t->integer, 32, 2);
    t->numbers = stp_alloc(las->context, pool.used);
    las->chunks = STP_NEW_ARRAY(las->context, stp_las_chunk, las->chunk_count + 1);
    if (t->numbers == NULL || las->chunks == NULL) {
        return stp_fail_memory(las->context);
    }
    size_t size = pool.used;
    pool = (stp_laz_pool){.bytes = t->numbers};
    stp_laz_integer_make(&pool, &t->integer, 32, 2);
    assert(pool.used == size && "the models fill the memory that was counted");
    (void)size;
    const stp_mapped_file* file = &las->import->file;
    t->decoder = stp_laz_decoder_begin(file->bytes + table + 8, (size_t)(file->size - table - 8),
                                       t->tail, 1);
    return read_entries(las, t, chunk_size, table);
}

// Offset of the table: stored at the start of the points, or, if that is -1, at the end of the
// file.
static stp_result find_table(const stp_las* las, uint64_t* table)
{
    const stp_mapped_file* file = &las->import->file;
    assert(las->points <= file->size && "the header was checked");
    if (file->size - las->points < 8) {
        return fail_table(las, "is missing");
    }
    *table = stp_read_u64(file->bytes + las->points);
    if (*table == UINT64_MAX && file->size - las->points >= 16) {
        *table = stp_read_u64(file->bytes + file->size - 8);
    }
    if (*table < las->points + 8 || *table > file->size || file->size - *table < 8) {
        return fail_table(las, "is missing");
    }
    return STP_OK;
}

// Files of the first versions and small ones have one chunk and no table.
static stp_result make_single_chunk(stp_las* las)
{
    assert(las->points <= las->import->file.size && "the header was checked");
    uint64_t size = las->import->file.size - las->points;
    las->chunks = STP_NEW_ARRAY(las->context, stp_las_chunk, 1);
    if (las->chunks == NULL) {
        return stp_fail_memory(las->context);
    }
    las->chunk_count = las->point_count > 0;
    las->chunks[0] = (stp_las_chunk){
        .offset = las->points, .size = size, .count = las->point_count, .read = las->point_count};
    if (las->point_count / MAX_POINTS_PER_BYTE > size) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its header says %llu points in %llu bytes, which is impossible",
                        las->import->path, (unsigned long long)las->point_count,
                        (unsigned long long)size);
    }
    return STP_OK;
}

static stp_result read_chunks(stp_las* las, uint32_t chunk_size)
{
    uint64_t table = 0;
    stp_result result = find_table(las, &table);
    if (result != STP_OK) {
        return result;
    }
    uint64_t count = stp_read_u32(las->import->file.bytes + table + 4);
    if (count > (table - las->points - 8) / las->record_size + 1) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its table has %llu chunks, more than the file can hold",
                        las->import->path, (unsigned long long)count);
    }
    las->chunk_count = (size_t)count;
    table_reader* t = STP_NEW_ZEROED(las->context, table_reader, 1);
    if (t == NULL) {
        return stp_fail_memory(las->context);
    }
    result = decode_table(las, t, chunk_size, table);
    stp_free(las->context, t->numbers);
    stp_free(las->context, t);
    return result;
}

// Damaged data may decode to far more points than measured ones would: a limit for large counts.
static stp_result check_density(const stp_las* las)
{
    uint64_t size = las->import->file.size - las->points;
    if (las->point_count > POINTS_ALWAYS_ALLOWED && las->point_count / POINTS_PER_BYTE > size) {
        return stp_fail(las->context, STP_ERROR_LIMIT,
                        "%s: its header says %llu points in %llu bytes: up to %d a byte are "
                        "supported",
                        las->import->path, (unsigned long long)las->point_count,
                        (unsigned long long)size, POINTS_PER_BYTE);
    }
    return STP_OK;
}

stp_result stp_laz_read_table(stp_las* las)
{
    compression c = {0};
    stp_result result = read_vlr(las, &c);
    if (result != STP_OK) {
        return result;
    }
    if (las->point_count == 0) {
        return STP_OK;
    }
    result = c.compressor == COMPRESSOR_POINTWISE ? make_single_chunk(las)
                                                  : read_chunks(las, c.chunk_size);
    return result == STP_OK ? check_density(las) : result;
}
