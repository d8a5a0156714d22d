// SPDX-License-Identifier: MIT
// Textures become PNG files where these are smaller (src/builder/encode_textures.c): the same texels,
// whether they are in memory or in the spill.
#include "tests.h"

#include "builder/writer_input.h"
#include "image/image_codecs.h"
#include "scene/scene.h"

#include <string.h>

enum { SIDE = 16, BYTES = 4 * SIDE * SIDE };

static uint8_t texel_of(int kind, size_t byte)
{
    if (kind != 1) {
        return (uint8_t)(byte % 4 == 3 ? 255 : 40 * (byte % 4) + (size_t)kind); // one colour
    }
    uint64_t noise = (byte + 1) * 0x9E3779B97F4A7C15u; // does not compress
    return (uint8_t)((noise ^ noise >> 29) * 0xBF58476D1CE4E5B9u >> 56);
}

/// Adds a texture of a colour (kinds 0 and 2) or of noise (kind 1), with or without the picture it came
/// from.
static stp_result add_texture(stp_scene* scene, int kind, const char* picture)
{
    uint32_t index;
    stp_texture texture = {.width = SIDE, .height = SIDE};
    texture.texels = STP_NEW_ARRAY(scene->context, uint8_t, BYTES);
    if (texture.texels == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < BYTES; ++i) {
        texture.texels[i] = texel_of(kind, i);
    }
    if (picture != NULL) {
        texture.encoded_size = strlen(picture);
        texture.encoded = STP_NEW_ARRAY(scene->context, unsigned char, texture.encoded_size);
        texture.encoding = STP_TEXTURE_JPEG;
        if (texture.encoded == NULL) {
            stp_free(scene->context, texture.texels);
            return STP_ERROR_OUT_OF_MEMORY;
        }
        memcpy(texture.encoded, picture, texture.encoded_size);
    }
    return stp_scene_add_texture(scene, &texture, &index);
}

static stp_result make_textures(stp_scene* scene)
{
    stp_result result = add_texture(scene, 0, NULL);
    result = result == STP_OK ? add_texture(scene, 1, NULL) : result;
    return result == STP_OK ? add_texture(scene, 2, "a picture") : result;
}

static bool decodes_to(stp_context* context, const stp_texture* texture, int kind)
{
    stp_image image = {0};
    bool good = stp_image_decode(context, "picture", texture->encoded, texture->encoded_size,
                                 &image) == STP_OK &&
                image.width == SIDE && image.height == SIDE;
    for (size_t i = 0; good && i < BYTES; ++i) {
        good = image.pixels[i] == texel_of(kind, i);
    }
    stp_free(context, image.pixels);
    return good;
}

void test_textures_become_pictures_where_these_are_smaller(test_state* test)
{
    for (int spills = 0; spills < 2; ++spills) {
        stp_context* context = test_context(NULL, 3, NULL);
        stp_scene* scene = NULL;
        stp_spill* spill = NULL;
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        if (spills) {
            CHECK_EQUAL(STP_OK, stp_spill_create(context, ".", &spill));
            stp_scene_use_spill(scene, spill, 16);
        }
        CHECK_EQUAL(STP_OK, make_textures(scene));
        size_t before = scene->bulk_bytes;
        CHECK_EQUAL(STP_OK, stp_build_encode_textures(scene));
        const stp_texture* t = scene->textures;
        CHECK(t[0].encoding == STP_TEXTURE_PNG && t[0].encoded_size < BYTES);
        CHECK(decodes_to(context, &t[0], 0));
        CHECK_EQUAL(spills ? before : before + t[0].encoded_size, scene->bulk_bytes);
        CHECK(t[1].encoded == NULL && t[1].encoding == STP_TEXTURE_TEXELS);
        CHECK(t[2].encoding == STP_TEXTURE_JPEG && t[2].encoded_size == strlen("a picture"));
        stp_scene_destroy(scene);
        stp_spill_destroy(spill);
        stp_context_destroy(context);
    }
}

void test_encoding_textures_survives_failing_allocator(test_state* test)
{
    bool done = false;
    for (int n = 0; !done; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_scene* scene = NULL;
        if (context == NULL) {
            continue;
        }
        stp_result result = stp_scene_create(context, &scene);
        result = result == STP_OK ? make_textures(scene) : result;
        result = result == STP_OK ? stp_build_encode_textures(scene) : result;
        done = result == STP_OK;
        CHECK(done || result == STP_ERROR_OUT_OF_MEMORY);
        heap.fail_at = -1;
        CHECK(!done || decodes_to(context, &scene->textures[0], 0));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
