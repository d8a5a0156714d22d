// SPDX-License-Identifier: MIT
#include "import/image_plain.h"

#include "base/bytes.h"

#include <string.h>

#define PIXEL_LIMIT ((uint64_t)1 << 28)
#define RUN_LIMIT 128 ///< pixels of one packet

// A picture as its header describes it: blue, green, red, alpha from pixel to pixel.
typedef struct plain {
    uint32_t width, height;
    uint32_t pixel_size;                  ///< bytes
    const unsigned char* palette;         ///< NULL: none
    uint32_t palette_count, palette_size; ///< entries, bytes of an entry
    size_t row_size;
    bool grey, runs, top_first, opaque;
    const unsigned char* at;
    const unsigned char* end;
} plain;

static stp_result refuse(stp_result result, const char* why, const char** reason)
{
    *reason = why;
    return result;
}

static bool describe_tga(const unsigned char* bytes, size_t size, plain* p)
{
    if (size < 18) {
        return false;
    }
    uint32_t kind = bytes[2] & 7u, bits = bytes[16], map_bits = bytes[7];
    uint32_t map_count = stp_read_u16(bytes + 5);
    bool mapped = kind == 1;
    bool known = bytes[1] <= 1 && (bytes[2] & ~11u) == 0 && kind >= 1 && kind <= 3 &&
                 (kind == 2 ? bits == 24 || bits == 32 : bits == 8) &&
                 (!mapped || (bytes[1] == 1 && stp_read_u16(bytes + 3) == 0 &&
                              (map_bits == 24 || map_bits == 32)));
    size_t map_bytes = bytes[1] == 1 ? (size_t)map_count * ((map_bits + 7u) / 8) : 0;
    size_t start = 18 + (size_t)bytes[0] + map_bytes;
    *p = (plain){.width = stp_read_u16(bytes + 12),
                 .height = stp_read_u16(bytes + 14),
                 .pixel_size = bits / 8,
                 .palette_count = mapped ? map_count : 0,
                 .palette_size = map_bits / 8,
                 .grey = kind == 3,
                 .runs = (bytes[2] & 8) != 0,
                 .top_first = (bytes[17] & 0x20) != 0,
                 .opaque = (bytes[17] & 15) == 0};
    if (!known || start > size || (bytes[17] & 0x10) != 0) {
        return false;
    }
    p->palette = mapped ? bytes + 18 + bytes[0] : NULL;
    p->row_size = (size_t)p->width * p->pixel_size;
    p->at = bytes + start;
    p->end = bytes + size;
    return true;
}

static bool describe_bmp(const unsigned char* bytes, size_t size, plain* p)
{
    if (size < 54 || bytes[0] != 'B' || bytes[1] != 'M') {
        return false;
    }
    uint32_t start = stp_read_u32(bytes + 10), header = stp_read_u32(bytes + 14);
    int32_t height = (int32_t)stp_read_u32(bytes + 22);
    uint32_t bits = stp_read_u16(bytes + 28), compression = stp_read_u32(bytes + 30);
    uint32_t used = stp_read_u32(bytes + 46);
    bool known = header >= 40 && header <= 124 && (bits == 8 || bits == 24 || bits == 32) &&
                 (compression == 0 || (compression == 3 && bits == 32)) && height != INT32_MIN;
    *p = (plain){.width = stp_read_u32(bytes + 18),
                 .height = height < 0 ? 0u - (uint32_t)height : (uint32_t)height,
                 .pixel_size = bits / 8,
                 .palette_count = bits != 8                 ? 0
                                  : used == 0 || used > 256 ? 256
                                                            : used,
                 .palette_size = 4,
                 .top_first = height < 0,
                 .opaque = true};
    size_t map_end = 14 + (size_t)header + 4 * (size_t)p->palette_count;
    if (!known || start > size || map_end > size) {
        return false;
    }
    p->palette = bits == 8 ? bytes + 14 + header : NULL;
    p->row_size = ((size_t)p->width * p->pixel_size + 3) & ~(size_t)3;
    p->at = bytes + start;
    p->end = bytes + size;
    return true;
}

static void write_pixel(const plain* p, const unsigned char* in, uint8_t* out)
{
    uint32_t size = p->pixel_size;
    if (p->grey) {
        memset(out, in[0], 3);
        out[3] = 255;
        return;
    }
    if (p->palette != NULL) {
        uint32_t index = in[0] < p->palette_count ? in[0] : 0;
        in = p->palette + (size_t)index * p->palette_size;
        size = p->palette_size;
    }
    out[0] = in[2];
    out[1] = in[1];
    out[2] = in[0];
    out[3] = size == 4 && !p->opaque ? in[3] : 255;
}

static uint8_t* row_of(const plain* p, uint8_t* texels, uint32_t row)
{
    return texels + 4 * (size_t)p->width * (p->top_first ? row : p->height - 1 - row);
}

static bool read_rows(plain* p, uint8_t* texels)
{
    for (uint32_t y = 0; y < p->height; ++y) {
        uint8_t* out = row_of(p, texels, y);
        for (uint32_t x = 0; x < p->width; ++x) {
            write_pixel(p, p->at + (size_t)x * p->pixel_size, out + 4 * (size_t)x);
        }
        p->at += p->row_size;
    }
    return true;
}

// Packets: a count, then one repeated pixel or that many pixels. They may cross rows.
static bool read_runs(plain* p, uint8_t* texels)
{
    uint64_t count = (uint64_t)p->width * p->height;
    for (uint64_t i = 0; i < count;) {
        if (p->at >= p->end) {
            return false;
        }
        unsigned char head = *p->at++;
        bool repeats = (head & 0x80) != 0;
        uint32_t run = (head & 0x7fu) + 1;
        size_t bytes = (repeats ? 1 : (size_t)run) * p->pixel_size;
        if ((size_t)(p->end - p->at) < bytes) {
            return false;
        }
        for (uint32_t k = 0; k < run && i < count; ++k, ++i) {
            const unsigned char* in = p->at + (repeats ? 0 : (size_t)k * p->pixel_size);
            write_pixel(p, in, row_of(p, texels, (uint32_t)(i / p->width)) + 4 * (i % p->width));
        }
        p->at += bytes;
    }
    return true;
}

stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes, size_t size,
                                  stp_texture* texture, const char** reason)
{
    plain p;
    if (!describe_bmp(bytes, size, &p) && !describe_tga(bytes, size, &p)) {
        return refuse(STP_ERROR_UNSUPPORTED, "the picture is neither PNG, JPEG, WebP, TGA nor BMP",
                      reason);
    }
    uint64_t pixels = (uint64_t)p.width * p.height;
    size_t left = (size_t)(p.end - p.at);
    if (pixels == 0 || p.width > PIXEL_LIMIT || pixels > PIXEL_LIMIT) {
        return refuse(STP_ERROR_UNSUPPORTED, "the picture's size is out of range", reason);
    }
    bool fits = p.runs ? pixels / RUN_LIMIT <= left : p.row_size <= left / p.height;
    if (!fits) {
        return refuse(STP_ERROR_TRUNCATED, "the picture is truncated", reason);
    }
    uint8_t* texels = stp_alloc_array(context, (size_t)pixels, 4);
    if (texels == NULL) {
        return refuse(STP_ERROR_OUT_OF_MEMORY, "out of memory", reason);
    }
    if (!(p.runs ? read_runs(&p, texels) : read_rows(&p, texels))) {
        stp_free(context, texels);
        return refuse(STP_ERROR_TRUNCATED, "the picture is truncated", reason);
    }
    texture->width = p.width;
    texture->height = p.height;
    texture->texels = texels;
    return STP_OK;
}
