// SPDX-License-Identifier: MIT
//
// Writes LAS and LAZ files for tests: any point format, uncompressed or compressed, with extra
// bytes. It encodes points one by one, like LASzip, while the reader uses blocks and layers.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct las_point {
    int32_t position[3];
    uint16_t intensity, source, rgb[3], nir;
    uint8_t return_number, return_count, class, flags, user, channel;
    int16_t angle; ///< degrees in formats 0 to 5, else 0.006 degrees
    uint64_t time; ///< bits of a double
} las_point;

typedef enum las_coding {
    LAS_RAW,
    LAZ_SINGLE,   ///< one chunk, no table; formats 0 to 5
    LAZ_CHUNKED,  ///< chunks of `chunk_size`
    LAZ_VARIABLE, ///< chunks of 1, 2, 3, 1, 2, 3, ... times `chunk_size`
} las_coding;

typedef struct las_desc {
    const las_point* points;
    size_t count;
    unsigned format, extra; ///< extra: number of extra bytes of each point
    las_coding coding;
    uint32_t chunk_size;
    bool table_at_end;    ///< the file's end has its offset
    bool fixed;           ///< layered, version 4
    const char* wkt;      ///< may be NULL
    const uint16_t* keys; ///< GeoTIFF keys, four numbers each after a head of four; may be NULL
    size_t key_numbers;
    double scale, offset; ///< 0: scale 0.01
    bool extended_wkt;    ///< it lies in an EVLR
    const char* vlr_user; ///< user id of one more VLR, written first; NULL: no such VLR
    unsigned vlr_id;
    const void* vlr;
    size_t vlr_size;
} las_desc;

typedef struct las_buffer {
    unsigned char* bytes;
    size_t size, capacity;
} las_buffer;

void las_put(las_buffer* b, const void* bytes, size_t size);
void las_put_number(las_buffer* b, uint64_t value, size_t size);
/// Makes the file; the caller frees its bytes.
las_buffer las_write(const las_desc* desc);
/// One record with its extra bytes. @return its size
size_t las_write_record(const las_desc* desc, size_t index, unsigned char* to);
size_t las_record_size(const las_desc* desc);

// Compressed chunks: support_las_pointwise.c and support_las_layered.c.
void laz_write_pointwise(const las_desc* desc, size_t first, size_t count, las_buffer* out);
void laz_write_layered(const las_desc* desc, size_t first, size_t count, las_buffer* out);
