// SPDX-License-Identifier: MIT
#include "support_pictures.h"

#include "image/image_codecs.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>
#include <webp/encode.h>

uint8_t pictures_value(uint32_t x, uint32_t y, uint32_t channel)
{
    const uint32_t values[] = {40 + 5 * (x & 31), 60 + 4 * (y & 31), 128 + (x & 31) + (y & 31),
                               255};
    assert(channel < 4 && values[channel] < 256 && "a channel of a texel");
    return (uint8_t)values[channel];
}

int pictures_error(const stp_store_texture* texture)
{
    int maximum = 0;
    for (uint32_t i = 0; i < texture->width * texture->height; ++i) {
        for (uint32_t c = 0; c < 4; ++c) {
            int wanted = pictures_value(i % texture->width, i / texture->width, c);
            int error = abs(wanted - texture->texels[4 * i + c]);
            maximum = error > maximum ? error : maximum;
        }
    }
    return maximum;
}

static bool keep(stp_arena* arena, stp_store_texture* texture, uint32_t encoding, const void* bytes,
                 size_t size)
{
    uint8_t* copy = bytes != NULL ? stp_arena_alloc(arena, size) : NULL;
    if (copy == NULL) {
        return false;
    }
    memcpy(copy, bytes, size);
    texture->encoding = encoding;
    texture->encoded = copy;
    texture->encoded_size = size;
    return true;
}

static bool encode_png(stp_arena* arena, const stp_image* image, stp_store_texture* texture)
{
    unsigned char* bytes = NULL;
    size_t size = 0;
    bool made =
        stp_image_encode_png(arena->context, image, STP_IMAGE_SMALL, &bytes, &size) == STP_OK &&
        keep(arena, texture, STP_IMAGE_PNG, bytes, size);
    stp_free(arena->context, bytes);
    return made;
}

static bool encode_jpeg(stp_arena* arena, const stp_image* image, stp_store_texture* texture)
{
    tjhandle jpeg = tjInitCompress();
    unsigned char* bytes = NULL;
    unsigned long size = 0;
    bool made = tjCompress2(jpeg, image->pixels, (int)image->width, 0, (int)image->height,
                            TJPF_RGBA, &bytes, &size, TJSAMP_444, 98, 0) == 0 &&
                keep(arena, texture, STP_IMAGE_JPEG, bytes, size);
    tjFree(bytes);
    tjDestroy(jpeg);
    return made;
}

static bool encode_webp(stp_arena* arena, const stp_image* image, stp_store_texture* texture)
{
    uint8_t* bytes = NULL;
    int stride = 4 * (int)image->width;
    size_t size = WebPEncodeLosslessRGBA(image->pixels, (int)image->width, (int)image->height,
                                         stride, &bytes);
    bool made = size > 0 && keep(arena, texture, STP_IMAGE_WEBP, bytes, size);
    WebPFree(bytes);
    return made;
}

bool pictures_add(stp_arena* arena, sample* made, uint32_t large)
{
    uint32_t side = PICTURE_SIZE * large;
    stp_store_texture* textures = STP_ARENA_ARRAY(arena, stp_store_texture, PICTURE_TEXTURES);
    uint8_t* texels = stp_arena_alloc(arena, 4 * (size_t)side * side);
    if (textures == NULL || texels == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < 4 * side * side; ++i) {
        texels[i] = pictures_value(i / 4 % side, i / 4 / side, i % 4);
    }
    for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
        textures[i] = (stp_store_texture){.width = side, .height = side, .wrap_u = i % 3};
    }
    stp_image image = {side, side, texels};
    bool good = encode_png(arena, &image, &textures[PICTURE_PNG]) &&
                encode_png(arena, &image, &textures[PICTURE_AGAIN]) &&
                encode_jpeg(arena, &image, &textures[PICTURE_JPEG]) &&
                encode_webp(arena, &image, &textures[PICTURE_WEBP]);
    textures[PICTURE_TEXELS].texels = texels;
    made->content.textures = textures;
    made->content.directory.texture_count = PICTURE_TEXTURES;
    return good;
}
