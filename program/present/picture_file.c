// SPDX-License-Identifier: MIT
#include "program/present/picture_file.h"

#include "base/io/file.h"

#include <string.h>
#include <strings.h>
#include <turbojpeg.h>
#include <webp/encode.h>

enum {
    JPEG_QUALITY = 92,
    JPEG_SIDE_LIMIT = 65500,
    WEBP_SIDE_LIMIT = WEBP_MAX_DIMENSION,
};

stp_picture_format stp_picture_format_of(const char* path)
{
    const char* slash = strrchr(path, '/');
    const char* dot = strrchr(slash != NULL ? slash : path, '.');
    static const struct {
        const char* suffix;
        stp_picture_format format;
    } known[] = {{".png", STP_PICTURE_PNG},
                 {".jpg", STP_PICTURE_JPEG},
                 {".jpeg", STP_PICTURE_JPEG},
                 {".webp", STP_PICTURE_WEBP}};
    for (size_t i = 0; dot != NULL && i < sizeof(known) / sizeof(known[0]); ++i) {
        if (strcasecmp(dot, known[i].suffix) == 0) {
            return known[i].format;
        }
    }
    return dot == NULL ? STP_PICTURE_PNG : STP_PICTURE_UNKNOWN;
}

static stp_result check_sides(stp_context* context, const stp_image* image, const char* path,
                              uint32_t limit)
{
    if (image->width <= limit && image->height <= limit) {
        return STP_OK;
    }
    return stp_fail(context, STP_ERROR_LIMIT,
                    "%s: the picture has %ux%u pixels, but this format allows at most %u per side",
                    path, image->width, image->height, limit);
}

static stp_result write_bytes(stp_context* context, const char* path, const void* bytes,
                              size_t size)
{
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result != STP_OK) {
        return result;
    }
    result = stp_file_writer_append(writer, bytes, size);
    if (result != STP_OK) {
        stp_file_writer_abort(writer);
        return result;
    }
    return stp_file_writer_commit(writer);
}

// Composites on white as RGB, three bytes per pixel. Free with stp_free; NULL if out of memory.
static unsigned char* put_on_white(stp_context* context, const stp_image* image)
{
    size_t count = (size_t)image->width * image->height;
    unsigned char* rgb = STP_NEW_ARRAY(context, unsigned char, 3 * count);
    for (size_t i = 0; rgb != NULL && i < count; ++i) {
        const uint8_t* from = image->pixels + 4 * i;
        for (size_t c = 0; c < 3; ++c) {
            rgb[3 * i + c] =
                (unsigned char)((from[c] * from[3] + 255u * (255u - from[3]) + 127u) / 255u);
        }
    }
    return rgb;
}

static stp_result write_jpeg(stp_context* context, const stp_image* image, const char* path)
{
    stp_result result = check_sides(context, image, path, JPEG_SIDE_LIMIT);
    if (result != STP_OK) {
        return result;
    }
    unsigned char* rgb = put_on_white(context, image);
    tjhandle codec = rgb != NULL ? tjInitCompress() : NULL;
    if (codec == NULL) {
        stp_free(context, rgb);
        return stp_fail_memory(context);
    }
    unsigned char* bytes = NULL;
    unsigned long size = 0;
    int failed = tjCompress2(codec, rgb, (int)image->width, 0, (int)image->height, TJPF_RGB, &bytes,
                             &size, TJSAMP_444, JPEG_QUALITY, TJFLAG_ACCURATEDCT);
    result = failed != 0
                 ? stp_fail(context, STP_ERROR_IO, "%s: JPEG: %s", path, tjGetErrorStr2(codec))
                 : write_bytes(context, path, bytes, size);
    tjFree(bytes);
    (void)tjDestroy(codec);
    stp_free(context, rgb);
    return result;
}

static stp_result write_webp(stp_context* context, const stp_image* image, const char* path)
{
    stp_result result = check_sides(context, image, path, WEBP_SIDE_LIMIT);
    if (result != STP_OK) {
        return result;
    }
    uint8_t* bytes = NULL;
    size_t size = WebPEncodeLosslessRGBA(image->pixels, (int)image->width, (int)image->height,
                                         (int)image->width * 4, &bytes);
    if (size == 0) {
        return stp_fail_memory(context); // the sides are within limits, so memory ran out
    }
    result = write_bytes(context, path, bytes, size);
    WebPFree(bytes);
    return result;
}

stp_result stp_picture_write(stp_context* context, const stp_image* image, const char* path)
{
    switch (stp_picture_format_of(path)) {
    case STP_PICTURE_PNG:
        return stp_png_write(context, image, path);
    case STP_PICTURE_JPEG:
        return write_jpeg(context, image, path);
    case STP_PICTURE_WEBP:
        return write_webp(context, image, path);
    default:
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "%s: the file name must end in " STP_PICTURE_SUFFIXES, path);
    }
}
