// SPDX-License-Identifier: MIT
//
// stb_image decodes. It treats bytes after the end of a file as zeros, reads palette entries that a
// file lacks from uninitialised memory, and has no limit on memory: the checks are here.
#include "base/io/bytes.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <string.h>

#define PIXEL_LIMIT (UINT64_C(1) << 28)

static const char unknown[] =
    "the picture is neither PNG, JPEG, WebP, nor a known kind of TGA or BMP";

// stb_image's allocation functions have no parameter for a context.
static _Thread_local stp_context* allocator;
static _Thread_local bool is_out_of_memory;

static void* allocate(size_t size)
{
    void* memory = stp_alloc(allocator, size);
    is_out_of_memory |= memory == NULL;
    return memory;
}

static void release(void* memory)
{
    stp_free(allocator, memory);
}

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_NO_HDR
#define STBI_NO_FAILURE_STRINGS
#define STBI_ASSERT(x) ((void)0)
#define STBI_MALLOC(size) allocate(size)
#define STBI_REALLOC(memory, size) ((void)(memory), (void)(size), NULL) // never for TGA and BMP
#define STBI_FREE(memory) release(memory)
#define STBI_MAX_DIMENSIONS (1 << 26)              // a row's bytes fit into an int
#pragma GCC diagnostic ignored "-Wunused-function" // gcc warns at the end of the file
#include <stb_image.h>

typedef struct stream {
    const unsigned char* bytes;
    size_t size, at;
    bool is_short;      ///< more was read than there is
    const char* buffer; ///< stb_image's read-ahead buffer; it may ask beyond the end; NULL: unknown
} stream;

// The first read fills the buffer. Rows that are read past it must be whole.
static int read_bytes(void* user, char* out, int size)
{
    stream* s = user;
    size_t left = s->size - s->at, wanted = (size_t)size, count = wanted < left ? wanted : left;
    s->buffer = s->buffer == NULL ? out : s->buffer;
    s->is_short |= out == s->buffer ? count == 0 && wanted != 0 : count < wanted;
    if (count != 0) {
        memcpy(out, s->bytes + s->at, count);
    }
    s->at += count;
    assert(s->at <= s->size);
    return (int)count;
}

static void skip_bytes(void* user, int size)
{
    stream* s = user;
    size_t left = s->size - s->at, wanted = size > 0 ? (size_t)size : 0;
    s->is_short |= wanted > left;
    s->at += wanted < left ? wanted : left;
}

static int is_at_end(void* user)
{
    const stream* s = user;
    return s->at == s->size;
}

static const stbi_io_callbacks callbacks = {read_bytes, skip_bytes, is_at_end};

/// What the header says and stb_image ignores or gets wrong.
typedef struct plain {
    bool known, opaque, runs;
    uint32_t pixel_bits;
    size_t palette_gap; ///< bytes by which a palette is shorter than the values of a pixel allow
    size_t start;       ///< BMP: offset of the pixels
} plain;

// Pictures stored from right to left, and palettes that do not begin at 0, are not decoded.
static plain describe_tga(const unsigned char* bytes)
{
    uint32_t kind = bytes[2] & 7u;
    return (plain){.known = (bytes[1] == 0 || (bytes[1] == 1 && kind == 1)) &&
                            stp_read_u16(bytes + 3) == 0 && (bytes[17] & 0x10) == 0,
                   .opaque = (bytes[17] & 15) == 0,
                   .runs = (bytes[2] & 8) != 0,
                   .pixel_bits = bytes[16]};
}

static plain describe_bmp(const unsigned char* bytes, size_t size)
{
    if (size < 54) {
        return (plain){0};
    }
    uint32_t start = stp_read_u32(bytes + 10), header = stp_read_u32(bytes + 14);
    uint32_t bits = stp_read_u16(bytes + 28);
    bool known = header >= 40 && header <= 124 && start >= 14 + header && start <= size &&
                 stp_read_u32(bytes + 22) != UINT32_C(0x80000000);
    size_t full = 14 + (size_t)header + (bits <= 8 ? (size_t)4 << bits : 0);
    return (plain){.known = known,
                   .opaque = stp_read_u32(bytes + 30) == 0,
                   .pixel_bits = bits,
                   .palette_gap = known && full > start ? full - start : 0,
                   .start = start};
}

// The file with the missing entries of the palette as zeros: black.
static unsigned char* fill_palette(stp_context* context, const plain* p, stream* s)
{
    assert(p->palette_gap > 0 && p->start <= s->size);
    unsigned char* copy = stp_alloc_zeroed(context, s->size + p->palette_gap, 1);
    if (copy != NULL) {
        memcpy(copy, s->bytes, p->start);
        memcpy(copy + p->start + p->palette_gap, s->bytes + p->start, s->size - p->start);
        stp_write_u32(copy + 10, (uint32_t)(p->start + p->palette_gap));
        *s = (stream){copy, s->size + p->palette_gap, 0, false, NULL};
    }
    return copy;
}

static stp_result decode(const plain* p, stream* s, stp_texture* texture, const char** reason)
{
    int width = 0, height = 0, channels = 0;
    *reason = unknown;
    if (!stbi_info_from_callbacks(&callbacks, s, &width, &height, &channels)) {
        return STP_ERROR_UNSUPPORTED;
    }
    uint64_t rows = height < 0 ? 0u - (uint32_t)height : (uint32_t)height; // below 0: top row first
    uint64_t pixels = (uint64_t)(uint32_t)width * rows;
    if (pixels == 0 || width < 0 || width > STBI_MAX_DIMENSIONS || pixels > PIXEL_LIMIT) {
        *reason = "the picture's size is out of range";
        return STP_ERROR_UNSUPPORTED;
    }
    // A run of 128 equal pixels takes a byte and a pixel; anything else a pixel each.
    uint64_t bits = 8 * (uint64_t)s->size, minimum = p->pixel_bits;
    bool fits =
        p->runs ? pixels / 128 <= bits / (8 + minimum) : pixels <= bits / (minimum + !minimum);
    *s = (stream){s->bytes, s->size, 0, false, NULL};
    stbi_uc* texels = NULL;
    if (fits) {
        texels = stbi_load_from_callbacks(&callbacks, s, &width, &height, &channels, 4);
    }
    if (!fits || (s->is_short && !is_out_of_memory)) {
        *reason = "the picture is truncated";
        release(texels);
        return STP_ERROR_TRUNCATED;
    }
    if (texels == NULL) {
        *reason = is_out_of_memory ? "out of memory" : *reason;
        return is_out_of_memory ? STP_ERROR_OUT_OF_MEMORY : STP_ERROR_UNSUPPORTED;
    }
    for (uint64_t i = 0; i < pixels && p->opaque; ++i) {
        texels[4 * i + 3] = 255;
    }
    assert((uint64_t)(uint32_t)width * rows == pixels && pixels <= PIXEL_LIMIT);
    texture->width = (uint32_t)width;
    texture->height = (uint32_t)rows;
    texture->texels = texels;
    return STP_OK;
}

stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes, size_t size,
                                  stp_texture* texture, const char** reason)
{
    assert(bytes != NULL || size == 0);
    allocator = context;
    is_out_of_memory = false;
    bool is_bmp = size >= 2 && bytes[0] == 'B' && bytes[1] == 'M';
    plain p = {0};
    if (size >= 18) {
        p = is_bmp ? describe_bmp(bytes, size) : describe_tga(bytes);
    }
    if (!p.known) {
        *reason = unknown;
        return STP_ERROR_UNSUPPORTED;
    }
    stream s = {bytes, size, 0, false, NULL};
    unsigned char* copy = p.palette_gap != 0 ? fill_palette(context, &p, &s) : NULL;
    if (p.palette_gap != 0 && copy == NULL) {
        *reason = "out of memory";
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_result result = decode(&p, &s, texture, reason);
    stp_free(context, copy);
    allocator = NULL;
    return result;
}
