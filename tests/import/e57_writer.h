// SPDX-License-Identifier: MIT
//
// Writes small E57 files: bit streams split into packets at odd places, an XML section, pages with
// checksums.
#pragma once

#include "base/io/bytes.h"
#include "base/io/hash.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

enum { E57_STREAMS = 16, E57_ROOM = 1 << 20 };

typedef struct e57_file {
    unsigned char* bytes; ///< logical bytes: without checksums
    size_t size;
} e57_file;

/// A stream of `count` values of `bits` bits each.
typedef struct e57_stream {
    unsigned bits;
    const uint64_t* values;
} e57_stream;

static inline uint64_t e57_physical(size_t logical)
{
    return (uint64_t)(logical / 1020 * 1024 + logical % 1020);
}

static inline e57_file e57_begin(void)
{
    e57_file file = {calloc(1, E57_ROOM), 48};
    return file;
}

static inline size_t e57_pack(const e57_stream* s, size_t count, unsigned char* out)
{
    for (size_t i = 0, at = 0; i < count; ++i) {
        for (unsigned b = 0; b < s->bits; ++b, ++at) {
            out[at / 8] |= (unsigned char)((s->values[i] >> b & 1) << (at % 8));
        }
    }
    return (count * s->bits + 7) / 8;
}

/// Appends a section of points in packets with about `maximum` bytes of each stream, after an index
/// packet. @return its physical offset
static inline uint64_t e57_add_points(e57_file* f, const e57_stream* streams, size_t stream_count,
                                      size_t count, size_t maximum)
{
    unsigned char* packed[E57_STREAMS];
    size_t sizes[E57_STREAMS], done[E57_STREAMS] = {0}, section = f->size, left = 0;
    assert(stream_count <= E57_STREAMS && "the arrays hold all streams");
    assert(section + 48 <= E57_ROOM && "the room holds the section's head");
    for (size_t s = 0; s < stream_count; ++s) {
        packed[s] = calloc(1, count * 8 + 8);
        sizes[s] = e57_pack(&streams[s], count, packed[s]);
        left += sizes[s];
    }
    f->size += 32;
    f->bytes[section] = 1;
    stp_write_u64(f->bytes + section + 16, e57_physical(f->size));
    stp_write_u16(f->bytes + f->size + 2, 15); // an index packet, of zeros
    f->size += 16;
    for (size_t packet = 0; left > 0; ++packet) {
        size_t begin = f->size, at = begin + 6 + 2 * stream_count;
        for (size_t s = 0; s < stream_count; ++s) {
            size_t part = maximum + (packet + s) % 3; // makes the streams drift apart
            part = part < sizes[s] - done[s] ? part : sizes[s] - done[s];
            memcpy(f->bytes + at, packed[s] + done[s], part);
            stp_write_u16(f->bytes + begin + 6 + 2 * s, (uint16_t)part);
            done[s] += part;
            left -= part;
            at += part;
        }
        f->size = begin + (at - begin + 3) / 4 * 4;
        assert(f->size <= E57_ROOM && "the room holds the packet");
        f->bytes[begin] = 1;
        stp_write_u16(f->bytes + begin + 2, (uint16_t)(f->size - begin - 1));
        stp_write_u16(f->bytes + begin + 4, (uint16_t)stream_count);
    }
    stp_write_u64(f->bytes + section + 8, f->size - section);
    for (size_t s = 0; s < stream_count; ++s) {
        free(packed[s]);
    }
    return e57_physical(section);
}

/// Appends the XML section and frees the logical bytes. @return the file in pages (malloc)
static inline unsigned char* e57_finish(e57_file* f, const char* xml, size_t* size)
{
    size_t start = f->size, length = strlen(xml);
    assert(start + length <= E57_ROOM && "the room holds the XML");
    memcpy(f->bytes + start, xml, length);
    f->size += length;
    size_t pages = (f->size + 1019) / 1020;
    *size = pages * 1024;
    memcpy(f->bytes, "ASTM-E57\1\0\0\0\0\0\0\0", 16);
    stp_write_u64(f->bytes + 16, *size);
    stp_write_u64(f->bytes + 24, e57_physical(start));
    stp_write_u64(f->bytes + 32, length);
    stp_write_u64(f->bytes + 40, 1024);
    unsigned char* out = malloc(*size);
    for (size_t i = 0; i < pages; ++i) {
        unsigned char* page = out + 1024 * i;
        memcpy(page, f->bytes + 1020 * i, 1020);
        uint32_t crc = stp_crc32c(page, 1020);
        for (size_t k = 0; k < 4; ++k) {
            page[1020 + k] = (unsigned char)(crc >> (24 - 8 * k));
        }
    }
    free(f->bytes);
    f->bytes = NULL;
    return out;
}

/// Recomputes the checksums of changed pages.
static inline void e57_seal(unsigned char* bytes, size_t size)
{
    for (size_t at = 0; at + 1024 <= size; at += 1024) {
        uint32_t crc = stp_crc32c(bytes + at, 1020);
        for (size_t k = 0; k < 4; ++k) {
            bytes[at + 1020 + k] = (unsigned char)(crc >> (24 - 8 * k));
        }
    }
}
