// SPDX-License-Identifier: MIT
// Textures and materials of the stream.
#include "import/assimp/assimp_reader.h"

#include <assert.h>

static bool all_finite(const float* numbers, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(numbers[i])) {
            return false;
        }
    }
    return true;
}

static stp_result read_texture(stp_assimp_reader* r, uint32_t* index)
{
    const char* name;
    stp_result result = stp_assimp_take_text(r, &name);
    uint32_t size[2];
    *index = STP_NONE;
    if (result != STP_OK) {
        return result;
    }
    if (!stp_assimp_take_value(r, size, sizeof(size))) {
        return stp_assimp_fail_stream(r, "textures");
    }
    stp_texture texture = {.name = name, .width = size[0], .height = size[1]};
    if (size[1] == 0) {
        const unsigned char* bytes = stp_assimp_take(r, size[0], 1);
        if (bytes == NULL) {
            return stp_assimp_fail_stream(r, "textures");
        }
        bool read;
        result =
            stp_picture_decode(r->import, "an embedded picture", bytes, size[0], &texture, &read);
        if (result != STP_OK || !read) {
            return result;
        }
    } else {
        uint64_t texels = (uint64_t)size[0] * size[1];
        if (size[0] == 0 || texels > (uint64_t)(r->end - r->at) / 4) {
            return stp_assimp_fail_stream(r, "textures");
        }
        texture.texels = stp_assimp_take_copy(r, (size_t)texels, 4, &result);
    }
    return result == STP_OK ? stp_scene_add_texture(r->import->scene, &texture, index) : result;
}

stp_result stp_assimp_read_textures(stp_assimp_reader* r)
{
    if (!stp_assimp_take_count(r, 3 * sizeof(uint32_t), &r->texture_count)) {
        return stp_assimp_fail_stream(r, "textures");
    }
    r->textures = STP_NEW_ARRAY(r->context, uint32_t, r->texture_count);
    if (r->textures == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->texture_count; ++i) {
        stp_result result = read_texture(r, &r->textures[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_result read_use(stp_assimp_reader* r, const char* material, stp_texture_use* use)
{
    uint32_t source[2];
    const char* path;
    stp_assimp_use in;
    if (!stp_assimp_take_value(r, source, sizeof(source))) {
        return stp_assimp_fail_stream(r, "materials");
    }
    stp_result result = stp_assimp_take_text(r, &path);
    if (result != STP_OK) {
        return result;
    }
    if (!stp_assimp_take_value(r, &in, sizeof(in)) || in.wrap_u > STP_WRAP_MIRROR ||
        in.wrap_v > STP_WRAP_MIRROR) {
        return stp_assimp_fail_stream(r, "materials");
    }
    if (source[0] == STP_ASSIMP_EMBEDDED && source[1] < r->texture_count) {
        use->texture = r->textures[source[1]];
        assert(use->texture == STP_NONE || use->texture < r->import->scene->texture_count);
        if (use->texture != STP_NONE) {
            r->import->scene->textures[use->texture].wrap_u = (stp_wrap)in.wrap_u;
            r->import->scene->textures[use->texture].wrap_v = (stp_wrap)in.wrap_v;
        }
    } else if (source[0] == STP_ASSIMP_PATH && path != NULL) {
        result = stp_pictures_read(&r->pictures, material != NULL ? material : "material", path,
                                   (stp_wrap)in.wrap_u, &use->texture);
    }
    assert(result != STP_OK || use->texture == STP_NONE ||
           use->texture < r->import->scene->texture_count);
    use->texcoord = in.texcoord < 2 ? in.texcoord : 0;
    if (all_finite(in.scale, 2) && all_finite(in.offset, 2)) {
        // coordinates were flipped: v_file = 1 - v, and back
        use->transform[0][0] = in.scale[0];
        use->transform[0][2] = in.offset[0];
        use->transform[1][1] = in.scale[1];
        use->transform[1][2] = 1.0f - in.scale[1] - in.offset[1];
    }
    return result;
}

static stp_result read_material(stp_assimp_reader* r, uint32_t* index)
{
    stp_material material = stp_material_plain();
    stp_result result = stp_assimp_take_text(r, &material.name);
    stp_assimp_material in;
    if (result != STP_OK) {
        return result;
    }
    if (!stp_assimp_take_value(r, &in, sizeof(in))) {
        return stp_assimp_fail_stream(r, "materials");
    }
    for (int i = 0; i < 3; ++i) {
        material.base_color[i] =
            in.base_color[i] >= 0.0f ? stp_clamp(in.base_color[i], 0, 1) : 0.0f;
        material.emissive[i] = in.emissive[i] >= 0.0f ? stp_clamp(in.emissive[i], 0, 1e6f) : 0.0f;
    }
    material.base_color[3] = in.base_color[3] >= 0.0f ? stp_clamp(in.base_color[3], 0, 1) : 1.0f;
    material.metallic = in.metallic >= 0.0f ? stp_clamp(in.metallic, 0, 1) : 0.0f;
    material.roughness = in.roughness >= 0.0f ? stp_clamp(in.roughness, 0, 1) : 1.0f;
    material.alpha_mode = in.masked != 0                  ? STP_ALPHA_MASK
                          : material.base_color[3] < 1.0f ? STP_ALPHA_BLEND
                                                          : STP_ALPHA_OPAQUE;
    result = read_use(r, material.name, &material.base_color_texture);
    if (result == STP_OK) {
        result = read_use(r, material.name, &material.emissive_texture);
    }
    if (result == STP_OK) {
        result = read_use(r, material.name, &material.normal_texture);
    }
    return result == STP_OK ? stp_scene_add_material(r->import->scene, &material, index) : result;
}

stp_result stp_assimp_read_materials(stp_assimp_reader* r)
{
    if (!stp_assimp_take_count(r, sizeof(stp_assimp_material), &r->material_count)) {
        return stp_assimp_fail_stream(r, "materials");
    }
    r->materials = STP_NEW_ARRAY(r->context, uint32_t, r->material_count);
    if (r->materials == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->material_count; ++i) {
        stp_result result = read_material(r, &r->materials[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}
