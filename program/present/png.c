// SPDX-License-Identifier: MIT
#include "base/io/file.h"
#include "image/image_codecs.h"
#include "program/present/picture_file.h"

#include <assert.h>
#include <spng.h>

#define PIXEL_LIMIT ((uint64_t)1 << 28)
#define CHUNK_LIMIT ((size_t)1 << 24) // limit on text and profiles, which are not used
#define DEFLATE_RATIO 1032            // maximum compression ratio of deflate

static stp_result fail_codec(stp_context* context, const char* name, int code)
{
    if (code == SPNG_EMEM) {
        return stp_fail_memory(context);
    }
    return stp_fail(context, STP_ERROR_FORMAT, "%s: PNG: %s", name, spng_strerror(code));
}

stp_result stp_png_encode(stp_context* context, const stp_image* image, const char* name,
                          unsigned char** bytes, size_t* size)
{
    stp_result result = stp_image_encode_png(context, image, STP_IMAGE_FAST, bytes, size);
    if (result == STP_ERROR_OUT_OF_MEMORY) {
        return stp_fail_memory(context);
    }
    return result == STP_OK ? STP_OK
                            : stp_fail(context, result, "%s: PNG: cannot write %u x %u pixels",
                                       name, image->width, image->height);
}

stp_result stp_png_write(stp_context* context, const stp_image* image, const char* path)
{
    unsigned char* bytes = NULL;
    size_t size = 0;
    stp_result result = stp_png_encode(context, image, path, &bytes, &size);
    if (result != STP_OK) {
        return result;
    }
    stp_file_writer* writer = NULL;
    result = stp_file_writer_open(context, path, &writer);
    if (result == STP_OK) {
        result = stp_file_writer_append(writer, bytes, size);
        if (result == STP_OK) {
            result = stp_file_writer_commit(writer);
        } else {
            stp_file_writer_abort(writer);
        }
    }
    stp_free(context, bytes);
    return result;
}

// A picture may not claim more pixels than its file can hold: memory stays proportional to the
// input.
static stp_result check_size(stp_context* context, const char* name, const struct spng_ihdr* header,
                             size_t file_size)
{
    static const unsigned channels[] = {1, 0, 3, 1, 2, 0, 4};
    uint64_t pixels = (uint64_t)header->width * header->height;
    if (pixels > PIXEL_LIMIT) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "%s: PNG: %u x %u pixels exceed the limit of 2^28", name, header->width,
                        header->height);
    }
    assert(header->color_type < 7 && channels[header->color_type] != 0 && "checked by libspng");
    uint64_t raw_bytes = pixels * channels[header->color_type] * header->bit_depth / 8;
    if (raw_bytes / DEFLATE_RATIO > file_size || !stp_image_is_plausible(pixels, file_size)) {
        return stp_fail(context, STP_ERROR_FORMAT,
                        "%s: PNG: %u x %u pixels do not fit into %zu bytes", name, header->width,
                        header->height, file_size);
    }
    return STP_OK;
}

static stp_result decode(stp_context* context, spng_ctx* codec, const char* name,
                         const unsigned char* bytes, size_t size, stp_image* image)
{
    struct spng_ihdr header;
    int code = spng_set_chunk_limits(codec, CHUNK_LIMIT, CHUNK_LIMIT);
    code = code != 0 ? code : spng_set_png_buffer(codec, bytes, size);
    code = code != 0 ? code : spng_get_ihdr(codec, &header);
    if (code != 0) {
        return fail_codec(context, name, code);
    }
    stp_result result = check_size(context, name, &header, size);
    if (result != STP_OK) {
        return result;
    }
    size_t pixel_bytes = (size_t)header.width * header.height * 4;
    unsigned char* pixels = stp_alloc(context, pixel_bytes);
    if (pixels == NULL) {
        return stp_fail_memory(context);
    }
    code = spng_decode_image(codec, pixels, pixel_bytes, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
    code =
        code != 0 ? code : spng_decode_chunks(codec); // read to the end, to detect a truncated file
    if (code != 0) {
        stp_free(context, pixels);
        return fail_codec(context, name, code);
    }
    *image = (stp_image){.width = header.width, .height = header.height, .pixels = pixels};
    return STP_OK;
}

stp_result stp_png_decode(stp_context* context, const char* name, const unsigned char* bytes,
                          size_t size, stp_image* image)
{
    if (size == 0) {
        return stp_fail(context, STP_ERROR_FORMAT, "%s: PNG: the file is empty", name);
    }
    spng_ctx* codec = spng_ctx_new(0);
    if (codec == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = decode(context, codec, name, bytes, size, image);
    spng_ctx_free(codec);
    return result;
}

stp_result stp_png_read(stp_context* context, const char* path, stp_image* image)
{
    stp_mapped_file file;
    stp_result result = stp_file_map(context, path, &file);
    if (result == STP_OK) {
        result = stp_png_decode(context, path, file.bytes, file.size, image);
        stp_file_unmap(&file);
    }
    return result;
}
