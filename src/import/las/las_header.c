// SPDX-License-Identifier: MIT
#include "base/io/bytes.h"
#include "import/las/las.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// Sizes and offsets of the header's fields.
enum {
    HEADER_1_0 = 227,
    HEADER_1_4 = 375,
    ENCODING = 6,
    VERSION_MAJOR = 24,
    VERSION_MINOR = 25,
    HEADER_SIZE = 94,
    POINTS = 96,
    VLR_COUNT = 100,
    FORMAT = 104,
    RECORD_SIZE = 105,
    LEGACY_COUNT = 107,
    SCALE = 131,
    OFFSET = 155,
    BOX = 179,
    EVLRS = 235,
    EVLR_COUNT = 243,
    COUNT = 247,
    VLR_HEAD = 54,
    EVLR_HEAD = 60,
    WKT_BIT = 16,
    FORMAT_MASK = 63 // the bits above say that points are compressed
};

static const stp_las_layout layouts[] = {
    {.size = 20},
    {.size = 28, .time = 20},
    {.size = 26, .rgb = 20},
    {.size = 34, .time = 20, .rgb = 28},
    {.size = 57, .time = 20, .wave = 28},
    {.size = 63, .time = 20, .rgb = 28, .wave = 34},
    {.size = 30, .time = 22},
    {.size = 36, .time = 22, .rgb = 30},
    {.size = 38, .time = 22, .rgb = 30, .nir = 36},
    {.size = 59, .time = 22, .wave = 30},
    {.size = 67, .time = 22, .rgb = 30, .nir = 36, .wave = 38},
};
enum { FORMATS = sizeof(layouts) / sizeof(layouts[0]) };

static stp_result read_format(stp_las* las, const unsigned char* bytes)
{
    const char* path = las->import->path;
    las->compressed = bytes[FORMAT] > FORMAT_MASK;
    las->format = bytes[FORMAT] & FORMAT_MASK;
    las->record_size = stp_read_u16(bytes + RECORD_SIZE);
    if (las->format >= FORMATS) {
        return stp_fail(las->context, STP_ERROR_UNSUPPORTED,
                        "%s: its point format is %u; LAS has formats 0 to 10", path, las->format);
    }
    las->layout = layouts[las->format];
    if (las->record_size < las->layout.size) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its points have %zu bytes each; those of format %u have %u", path,
                        las->record_size, las->format, las->layout.size);
    }
    return STP_OK;
}

static stp_result read_transform(stp_las* las, const unsigned char* bytes)
{
    for (int i = 0; i < 3; ++i) {
        las->scale[i] = stp_read_f64(bytes + SCALE + 8 * i);
        las->offset[i] = stp_read_f64(bytes + OFFSET + 8 * i);
        las->high[i] = stp_read_f64(bytes + BOX + 16 * i);
        las->low[i] = stp_read_f64(bytes + BOX + 16 * i + 8);
        if (!isfinite(las->scale[i]) || las->scale[i] == 0.0 || !isfinite(las->offset[i])) {
            return stp_fail(las->context, STP_ERROR_FORMAT,
                            "%s: the scale of its %c is %g and the offset %g: they must be finite, "
                            "and the scale not 0",
                            las->import->path, (char)('x' + i), las->scale[i], las->offset[i]);
        }
    }
    return STP_OK;
}

// Since version 1.4 there is a second, wider count; the first is 0 if it does not fit or does not
// apply.
static void read_counts(stp_las* las, const unsigned char* bytes)
{
    las->vlr_count = stp_read_u32(bytes + VLR_COUNT);
    las->point_count = stp_read_u32(bytes + LEGACY_COUNT);
    if (las->minor >= 4 && las->header_size >= HEADER_1_4) {
        uint64_t count = stp_read_u64(bytes + COUNT);
        las->evlrs = stp_read_u64(bytes + EVLRS);
        las->evlr_count = stp_read_u32(bytes + EVLR_COUNT);
        las->point_count = count != 0 ? count : las->point_count;
    }
}

// Upper bound from the file size: an uncompressed point takes its record, a compressed one may take
// almost nothing.
static stp_result check_count(const stp_las* las)
{
    uint64_t size = las->import->file.size;
    assert(las->record_size >= las->layout.size && las->record_size > 0);
    uint64_t room = las->points < size ? size - las->points : 0;
    if (!las->compressed && las->point_count > room / las->record_size) {
        return stp_fail(las->context, STP_ERROR_TRUNCATED,
                        "%s: ends after %llu of the %llu points in its header", las->import->path,
                        (unsigned long long)(room / las->record_size),
                        (unsigned long long)las->point_count);
    }
    if (las->compressed && las->points > size) {
        return stp_fail(las->context, STP_ERROR_TRUNCATED,
                        "%s: ends before its points, which begin at byte %llu", las->import->path,
                        (unsigned long long)las->points);
    }
    return STP_OK;
}

stp_result stp_las_read_header(stp_las* las)
{
    const unsigned char* bytes = las->import->file.bytes;
    uint64_t size = las->import->file.size;
    const char* path = las->import->path;
    if (size < 4 || memcmp(bytes, "LASF", 4) != 0) {
        return stp_fail(las->context, STP_ERROR_FORMAT, "%s: has no LAS signature", path);
    }
    if (size < HEADER_1_0) {
        return stp_fail(las->context, STP_ERROR_TRUNCATED, "%s: ends within its header", path);
    }
    unsigned major = bytes[VERSION_MAJOR];
    las->minor = bytes[VERSION_MINOR];
    if (major != 1 || las->minor > 4) {
        return stp_fail(las->context, STP_ERROR_UNSUPPORTED,
                        "%s: has LAS version %u.%u; only 1.0 to 1.4 are supported", path, major,
                        las->minor);
    }
    las->header_size = stp_read_u16(bytes + HEADER_SIZE);
    las->points = stp_read_u32(bytes + POINTS);
    las->wkt = (stp_read_u16(bytes + ENCODING) & WKT_BIT) != 0;
    if (las->header_size < HEADER_1_0 || las->points < las->header_size) {
        return stp_fail(las->context, STP_ERROR_FORMAT,
                        "%s: its header has %llu bytes, and its points begin at byte %llu", path,
                        (unsigned long long)las->header_size, (unsigned long long)las->points);
    }
    if (las->header_size > size) {
        return stp_fail(las->context, STP_ERROR_TRUNCATED, "%s: ends within its header", path);
    }
    read_counts(las, bytes);
    stp_result result = read_format(las, bytes);
    result = result == STP_OK ? read_transform(las, bytes) : result;
    return result == STP_OK ? check_count(las) : result;
}

static bool next_record(const stp_las* las, stp_las_records* records, stp_las_record* record)
{
    const unsigned char* bytes = las->import->file.bytes;
    uint64_t size = las->import->file.size;
    bool extended = records->index >= las->vlr_count;
    if (records->index == 0) {
        records->at = las->header_size;
    }
    if (records->index == las->vlr_count) {
        records->at = las->evlrs;
    }
    if (records->damaged || records->index >= las->vlr_count + las->evlr_count) {
        return false;
    }
    uint64_t end = extended ? size : las->points < size ? las->points : size;
    uint64_t head = extended ? EVLR_HEAD : VLR_HEAD, at = records->at;
    if (at > end || end - at < head) {
        records->damaged = true;
        return false;
    }
    record->user = (const char*)bytes + at + 2;
    record->id = stp_read_u16(bytes + at + 18);
    record->size = extended ? stp_read_u64(bytes + at + 20) : stp_read_u16(bytes + at + 20);
    record->bytes = bytes + at + head;
    if (record->size > end - at - head) {
        records->damaged = true;
        return false;
    }
    assert(at + head + record->size <= size && "the record lies within the file");
    records->at = at + head + record->size;
    records->index += 1;
    return true;
}

bool stp_las_find_record(const stp_las* las, const char* user, unsigned id, stp_las_record* record)
{
    stp_las_records records = {0};
    while (next_record(las, &records, record)) {
        if (record->id == id && strncmp(record->user, user, 16) == 0) {
            return true;
        }
    }
    return false;
}
