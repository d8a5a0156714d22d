// SPDX-License-Identifier: MIT
// Encodes texels to PNG, in memory that the context counts.
#include "image/image_codecs.h"

#include <assert.h>
#include <spng.h>
#include <string.h>

// Level 3 takes a third of level 6's time and gives 1.1 times its bytes (rendered pictures).
enum { FAST_LEVEL = 3, SMALL_LEVEL = 6 };

/// Output buffer of the encoder.
typedef struct byte_sink {
    stp_context* context;
    unsigned char* bytes;
    size_t size, capacity;
    bool out_of_memory;
} byte_sink;

static int append(spng_ctx* codec, void* user, void* source, size_t size)
{
    (void)codec;
    byte_sink* sink = user;
    if (!STP_MAKE_ROOM(sink->context, sink->bytes, sink->capacity, sink->size + size)) {
        sink->out_of_memory = true;
        return SPNG_IO_ERROR;
    }
    assert(sink->size + size <= sink->capacity);
    memcpy(sink->bytes + sink->size, source, size);
    sink->size += size;
    return 0;
}

/// Rows of a PNG colour type with 8 bits per channel.
typedef struct png_rows {
    uint8_t color_type;
    size_t channels;
    const uint8_t* bytes;
    uint8_t* owned; ///< NULL: uses the picture's own texels
    int level;
    int filters;
} png_rows;

static size_t count_pixels(const stp_image* image)
{
    return (size_t)image->width * image->height;
}

/// Chooses the fewest channels that hold every texel.
static void choose_channels(const stp_image* image, png_rows* rows)
{
    bool has_alpha = false, has_color = false;
    for (size_t i = 0; i < count_pixels(image); ++i) {
        const uint8_t* texel = image->pixels + 4 * i;
        has_alpha = has_alpha || texel[3] != 255;
        has_color = has_color || texel[0] != texel[1] || texel[0] != texel[2];
    }
    rows->channels = (has_color ? 3u : 1u) + (has_alpha ? 1u : 0u);
    assert(rows->channels >= 1 && rows->channels <= 4);
    rows->color_type = has_color
                           ? has_alpha ? SPNG_COLOR_TYPE_TRUECOLOR_ALPHA : SPNG_COLOR_TYPE_TRUECOLOR
                       : has_alpha ? SPNG_COLOR_TYPE_GRAYSCALE_ALPHA
                                   : SPNG_COLOR_TYPE_GRAYSCALE;
}

/// Copies the chosen channels. @return false if out of memory
static bool pack_rows(stp_context* context, const stp_image* image, png_rows* rows)
{
    assert(rows->channels < 4 && rows->owned == NULL);
    size_t channels = rows->channels, last = channels - 1;
    rows->owned = stp_alloc_array(context, count_pixels(image), channels);
    for (size_t i = 0; rows->owned != NULL && i < count_pixels(image); ++i) {
        const uint8_t* texel = image->pixels + 4 * i;
        memcpy(rows->owned + channels * i, texel, channels);
        if (channels == 2) { // grey and alpha
            rows->owned[channels * i + last] = texel[3];
        }
    }
    rows->bytes = rows->owned;
    return rows->owned != NULL;
}

static int encode(spng_ctx* codec, const stp_image* image, const png_rows* rows, byte_sink* sink)
{
    struct spng_ihdr header = {.width = image->width,
                               .height = image->height,
                               .bit_depth = 8,
                               .color_type = rows->color_type};
    size_t size = count_pixels(image) * rows->channels;
    int code = spng_set_png_stream(codec, append, sink);
    code = code != 0 ? code : spng_set_ihdr(codec, &header);
    code = code != 0 ? code : spng_set_option(codec, SPNG_IMG_COMPRESSION_LEVEL, rows->level);
    code = code != 0 ? code : spng_set_option(codec, SPNG_FILTER_CHOICE, rows->filters);
    return code != 0
               ? code
               : spng_encode_image(codec, rows->bytes, size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
}

stp_result stp_image_encode_png(stp_context* context, const stp_image* image,
                                stp_image_effort effort, unsigned char** bytes, size_t* size)
{
    png_rows rows = {.color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA,
                     .channels = 4,
                     .bytes = image->pixels,
                     .level = FAST_LEVEL,
                     .filters = SPNG_FILTER_CHOICE_SUB | SPNG_FILTER_CHOICE_UP};
    if (effort == STP_IMAGE_SMALL) {
        rows.level = SMALL_LEVEL;
        rows.filters = SPNG_FILTER_CHOICE_ALL;
        choose_channels(image, &rows);
        if (rows.channels < 4 && !pack_rows(context, image, &rows)) {
            return STP_ERROR_OUT_OF_MEMORY;
        }
    }
    byte_sink sink = {.context = context};
    spng_ctx* codec = spng_ctx_new(SPNG_CTX_ENCODER);
    int code = codec != NULL ? encode(codec, image, &rows, &sink) : SPNG_EMEM;
    spng_ctx_free(codec);
    stp_free(context, rows.owned);
    if (code != 0) {
        stp_free(context, sink.bytes);
        return sink.out_of_memory || code == SPNG_EMEM ? STP_ERROR_OUT_OF_MEMORY : STP_ERROR_FORMAT;
    }
    assert(sink.size > 0 && !sink.out_of_memory);
    *bytes = sink.bytes;
    *size = sink.size;
    return STP_OK;
}
