// SPDX-License-Identifier: MIT
#include "builder/writer_input.h"
#include "image/image_codecs.h"
#include "scene/bulk.h"

#include <assert.h>
#include <string.h>

/// Result of encoding one texture.
typedef struct encoded_texture {
    unsigned char* bytes; ///< PNG file; NULL: the texture stays as it is
    size_t size;
    stp_result result;
} encoded_texture;

typedef struct encode_loop {
    const stp_scene* scene;
    encoded_texture* encoded;
} encode_loop;

static size_t texel_bytes(const stp_texture* texture)
{
    return (size_t)texture->width * texture->height * 4;
}

static void encode_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const encode_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_texture* texture = &loop->scene->textures[i];
        encoded_texture* out = &loop->encoded[i];
        if (texture->encoded != NULL || texture->texels == NULL) {
            continue;
        }
        stp_image image = {texture->width, texture->height, texture->texels};
        out->result = stp_image_encode_png(loop->scene->context, &image, STP_IMAGE_SMALL,
                                           &out->bytes, &out->size);
        if (out->result == STP_ERROR_FORMAT || out->size >= texel_bytes(texture)) {
            stp_free(loop->scene->context, out->bytes);
            *out = (encoded_texture){0};
        }
    }
}

/// Attaches an image file to its texture. It is stored instead of the texels.
static stp_result take_picture(stp_scene* scene, stp_texture* texture, encoded_texture* encoded)
{
    assert(texture->encoded == NULL && "an original picture is kept");
    assert(encoded->size < texel_bytes(texture) && "the texels are smaller");
    if (texture->spilled) {
        unsigned char* copy = stp_spill_alloc(scene->spill, encoded->size);
        if (copy == NULL) {
            return STP_ERROR_IO; // already logged
        }
        memcpy(copy, encoded->bytes, encoded->size);
        stp_free(scene->context, encoded->bytes);
        encoded->bytes = copy;
    } else {
        scene->bulk_bytes += encoded->size;
    }
    texture->encoded = encoded->bytes;
    texture->encoded_size = encoded->size;
    texture->encoding = STP_TEXTURE_PNG;
    encoded->bytes = NULL;
    return STP_OK;
}

stp_result stp_build_encode_textures(stp_scene* scene)
{
    stp_context* context = scene->context;
    encoded_texture* encoded = STP_NEW_ZEROED(context, encoded_texture, scene->texture_count + 1);
    if (encoded == NULL) {
        return stp_fail_memory(context);
    }
    encode_loop loop = {scene, encoded};
    stp_parallel_for(context, scene->texture_count, 1, encode_job, &loop);
    stp_result result = STP_OK;
    for (size_t i = 0; i < scene->texture_count; ++i) {
        if (result == STP_OK && encoded[i].result != STP_OK) {
            result = stp_fail_memory(context);
        }
        if (result == STP_OK && encoded[i].bytes != NULL) {
            result = take_picture(scene, &scene->textures[i], &encoded[i]);
        }
        stp_free(context, encoded[i].bytes);
    }
    stp_free(context, encoded);
    return result;
}
