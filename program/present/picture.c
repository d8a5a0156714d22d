// SPDX-License-Identifier: MIT
#include "base/io/file.h"
#include "image/image_codecs.h"
#include "program/present/picture_file.h"

#include <stdio.h>
#include <string.h>

#define STDIN_LIMIT ((size_t)1 << 30)
#define BLOCK ((size_t)1 << 16)

static stp_result read_stdin(stp_context* context, unsigned char** bytes, size_t* size)
{
    size_t capacity = 0;
    for (;;) {
        if (!STP_MAKE_ROOM(context, *bytes, capacity, *size + BLOCK)) {
            return stp_fail_memory(context);
        }
        size_t got = fread(*bytes + *size, 1, BLOCK, stdin);
        *size += got;
        if (got < BLOCK) {
            return ferror(stdin) == 0
                       ? STP_OK
                       : stp_fail(context, STP_ERROR_IO, "standard input: cannot be read");
        }
        if (*size > STDIN_LIMIT) {
            return stp_fail(context, STP_ERROR_LIMIT, "standard input: longer than %zu bytes",
                            STDIN_LIMIT);
        }
    }
}

/// Decodes a picture of any format that is written, by its content.
static stp_result decode(stp_context* context, const char* name, const unsigned char* bytes,
                         size_t size, stp_image* image)
{
    stp_image_info info;
    stp_result measured = stp_image_measure(bytes, size, &info);
    bool other = measured == STP_OK && info.kind != STP_IMAGE_PNG;
    return other ? stp_image_decode(context, name, bytes, size, image)
                 : stp_png_decode(context, name, bytes, size, image);
}

stp_result tool_read_picture(stp_context* context, const char* path, stp_image* image)
{
    if (strcmp(path, "-") != 0) {
        stp_mapped_file file;
        stp_result mapped = stp_file_map(context, path, &file);
        if (mapped == STP_OK) {
            mapped = decode(context, path, file.bytes, file.size, image);
            stp_file_unmap(&file);
        }
        return mapped;
    }
    unsigned char* bytes = NULL;
    size_t size = 0;
    stp_result result = read_stdin(context, &bytes, &size);
    if (result == STP_OK) {
        result = decode(context, "standard input", bytes, size, image);
    }
    stp_free(context, bytes);
    return result;
}

int tool_check_picture(const char* path)
{
    bool known = path == NULL || strcmp(path, "-") == 0 ||
                 stp_picture_format_of(path) != STP_PICTURE_UNKNOWN;
    return known ? 0
                 : tool_usage_error("%s: the file name must end in " STP_PICTURE_SUFFIXES
                                    "; convert one of these to other formats, for example with "
                                    "ImageMagick",
                                    path);
}

stp_result tool_write_picture(stp_context* context, const stp_image* image, const char* path)
{
    if (strcmp(path, "-") != 0) {
        return stp_picture_write(context, image, path);
    }
    unsigned char* bytes;
    size_t size;
    stp_result result = stp_png_encode(context, image, "standard output", &bytes, &size);
    if (result == STP_OK) {
        if (fwrite(bytes, 1, size, stdout) != size || fflush(stdout) != 0) {
            clearerr(stdout);
            result = stp_fail(context, STP_ERROR_IO, "standard output: cannot be written");
        }
        stp_free(context, bytes);
    }
    return result;
}
