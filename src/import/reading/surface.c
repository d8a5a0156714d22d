// SPDX-License-Identifier: MIT
#include "import/reading/surface.h"

#include "base/math/color.h"
#include "image/image_codecs.h"

#include <assert.h>
#include <string.h>

stp_material stp_material_plain(void)
{
    stp_material material = stp_material_default();
    material.metallic = 0.0f;
    material.double_sided = true;
    return material;
}

stp_result stp_add_plain_material(stp_import* import, uint32_t* index)
{
    if (*index != STP_NONE) {
        return STP_OK;
    }
    stp_material material = stp_material_plain();
    stp_result result = stp_scene_add_material(import->scene, &material, index);
    assert(result != STP_OK || *index < import->scene->material_count);
    return result;
}

float stp_srgb_to_linear(float value)
{
    if (!(value > 0.0f)) {
        return 0.0f;
    }
    if (value >= 1.0f) {
        return 1.0f;
    }
    // between two table entries the curve is straight to 5e-6
    float scaled = value * 255.0f;
    int below = (int)scaled;
    assert(below >= 0 && below <= 255 && "the value is between 0 and 1");
    float low = stp_srgb8_to_linear((uint8_t)below);
    float high = stp_srgb8_to_linear((uint8_t)(below < 255 ? below + 1 : 255));
    return low + (high - low) * (scaled - (float)below);
}

uint16_t stp_unorm16(float value)
{
    return value >= 1.0f ? 65535 : value > 0.0f ? (uint16_t)(value * 65535.0f + 0.5f) : 0;
}

uint8_t stp_unorm8(float value)
{
    return value >= 1.0f ? 255 : value > 0.0f ? (uint8_t)(value * 255.0f + 0.5f) : 0;
}

void stp_import_default_axes(stp_import* import, char up)
{
    stp_import_set_axes(import, import->desc.up != 0 ? import->desc.up : up, 0.0);
}

stp_pictures stp_pictures_create(stp_import* import)
{
    return (stp_pictures){.import = import, .known = {.context = import->context}};
}

void stp_pictures_destroy(stp_pictures* pictures)
{
    stp_lookup_destroy(&pictures->known);
}

_Static_assert((int)STP_IMAGE_PNG == (int)STP_TEXTURE_PNG &&
                   (int)STP_IMAGE_JPEG == (int)STP_TEXTURE_JPEG &&
                   (int)STP_IMAGE_WEBP == (int)STP_TEXTURE_WEBP,
               "one numbering");

stp_result stp_picture_decode_kept(stp_context* context, const unsigned char* bytes, size_t size,
                                   stp_image_info* info, stp_texture* texture)
{
    assert(size > 0 && info->width > 0 && info->height > 0 && "stp_image_measure accepted it");
    uint8_t* kept = stp_alloc(context, size);
    if (kept == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_image image;
    stp_result result = stp_image_decode_measured(context, bytes, size, info, &image);
    if (result != STP_OK) {
        stp_free(context, kept);
        return result;
    }
    assert(image.width == info->width && image.height == info->height);
    memcpy(kept, bytes, size);
    texture->width = image.width;
    texture->height = image.height;
    texture->texels = image.pixels;
    texture->encoded = kept;
    texture->encoded_size = size;
    texture->encoding = (stp_texture_encoding)info->kind;
    return STP_OK;
}

stp_result stp_picture_decode(stp_import* import, const char* place, const unsigned char* bytes,
                              size_t size, stp_texture* texture, bool* read)
{
    stp_image_info info = {0};
    stp_result result = stp_image_measure(bytes, size, &info);
    const char* reason = info.reason;
    uint64_t pixels = import->picture_pixels + (uint64_t)info.width * info.height;
    uint64_t read_bytes = import->picture_bytes + size;
    if (result == STP_OK && !stp_image_is_plausible(pixels, read_bytes)) {
        reason = "the pictures of the file claim too many pixels for their bytes";
        result = STP_ERROR_LIMIT;
    } else if (result == STP_OK) {
        import->picture_pixels = pixels;
        import->picture_bytes = read_bytes;
        result = stp_picture_decode_kept(import->context, bytes, size, &info, texture);
    } else if (info.kind == STP_IMAGE_UNKNOWN && size != 0) {
        result = stp_image_decode_plain(import->context, bytes, size, texture, &reason);
    }
    *read = result == STP_OK;
    if (result == STP_ERROR_OUT_OF_MEMORY) {
        return stp_fail_memory(import->context);
    }
    if (result != STP_OK) {
        stp_warn(import->context, "%s: %s is left out: %s", import->path, place, reason);
    }
    return STP_OK;
}

// Exporters write paths of their author's machine; the picture is usually delivered next to the
// file.
static const char* without_root(const char* reference)
{
    bool rooted = reference[0] == '/' || reference[0] == '\\' ||
                  (reference[0] != '\0' && reference[1] == ':');
    if (!rooted) {
        return reference;
    }
    const char* name = reference;
    for (const char* at = reference; *at != '\0'; ++at) {
        if (*at == '/' || *at == '\\' || *at == ':') {
            name = at + 1;
        }
    }
    return name;
}

static stp_result read_picture(stp_import* import, const char* path, stp_texture* texture,
                               bool* read)
{
    stp_mapped_file file;
    stp_result result = stp_file_map(import->context, path, &file);
    if (result == STP_OK) {
        result = stp_picture_decode(import, path, file.bytes, file.size, texture, read);
        stp_file_unmap(&file);
    }
    return result;
}

stp_result stp_pictures_read(stp_pictures* pictures, const char* place, const char* reference,
                             stp_wrap wrap, uint32_t* texture)
{
    stp_import* import = pictures->import;
    *texture = STP_NONE;
    const char* path;
    stp_result result = stp_import_resolve_optional(import, place, without_root(reference), &path);
    if (result != STP_OK || path == NULL) {
        return result;
    }
    struct {
        stp_hash path;
        uint64_t wrap;
    } key = {stp_hash_bytes((stp_hash){0}, path, strlen(path)), (uint64_t)wrap};
    uint32_t found = stp_lookup_find(&pictures->known, &key, sizeof(key), STP_NONE - 1);
    if (found != STP_NONE - 1) {
        *texture = found;
        return STP_OK;
    }
    bool read;
    stp_texture picture = {.name = path, .wrap_u = wrap, .wrap_v = wrap};
    result = read_picture(import, path, &picture, &read);
    if (result == STP_OK && read) {
        result = stp_scene_add_texture(import->scene, &picture, texture);
    }
    assert(*texture == STP_NONE || *texture < import->scene->texture_count);
    return result == STP_OK ? stp_lookup_add(&pictures->known, &key, sizeof(key), *texture, &found)
                            : result;
}
