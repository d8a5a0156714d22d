// SPDX-License-Identifier: MIT
// Textures and materials of assimp's scene, as the child process writes them.
#include "import/assimp/assimp_writer.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <assimp/material.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void stp_assimp_put_texture(stp_assimp_writer* w, const struct aiTexture* texture)
{
    stp_assimp_put_string(w, &texture->mFilename);
    stp_assimp_put_u32(w, texture->mWidth);
    stp_assimp_put_u32(w, texture->mHeight);
    if (texture->mHeight == 0) {
        stp_assimp_put(w, texture->pcData, texture->mWidth);
        return;
    }
    for (size_t i = 0; i < (size_t)texture->mWidth * texture->mHeight; ++i) {
        const struct aiTexel* texel = &texture->pcData[i];
        unsigned char rgba[4] = {texel->r, texel->g, texel->b, texel->a};
        stp_assimp_put(w, rgba, sizeof(rgba));
    }
}

static uint32_t wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Mirror  ? STP_WRAP_MIRROR
           : mode == aiTextureMapMode_Clamp ? STP_WRAP_CLAMP
                                            : STP_WRAP_REPEAT;
}

static const char* file_name(const char* path)
{
    const char* name = path;
    for (; *path != '\0'; ++path) {
        name = *path == '/' || *path == '\\' ? path + 1 : name;
    }
    return name;
}

// "*3" is the embedded texture of index 3; some formats name embedded ones by their file name.
static uint32_t find_embedded(const struct aiScene* scene, const char* path)
{
    if (path[0] == '*') {
        return (uint32_t)strtoul(path + 1, NULL, 10);
    }
    assert(scene->mNumTextures == 0 || scene->mTextures != NULL);
    for (uint32_t i = 0; i < scene->mNumTextures; ++i) {
        const char* name = file_name(scene->mTextures[i]->mFilename.data);
        if (name[0] != '\0' && strcmp(name, file_name(path)) == 0) {
            return i;
        }
    }
    return STP_NONE;
}

static int get_texture(const struct aiMaterial* material, enum aiTextureType type,
                       struct aiString* path, stp_assimp_use* use)
{
    unsigned texcoord = 0;
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap,
                                      aiTextureMapMode_Wrap};
    *use = (stp_assimp_use){.scale = {1, 1}};
    if (aiGetMaterialTexture(material, type, 0, path, NULL, &texcoord, NULL, NULL, modes, NULL) !=
            aiReturn_SUCCESS ||
        path->length == 0) {
        return 0;
    }
    struct aiUVTransform transform;
    if (aiGetMaterialUVTransform(material, AI_MATKEY_UVTRANSFORM(type, 0), &transform) ==
        aiReturn_SUCCESS) {
        use->scale[0] = transform.mScaling.x;
        use->scale[1] = transform.mScaling.y;
        use->offset[0] = transform.mTranslation.x;
        use->offset[1] = transform.mTranslation.y;
    }
    use->texcoord = texcoord;
    use->wrap_u = wrap_of(modes[0]);
    use->wrap_v = wrap_of(modes[1]);
    return 1;
}

static void put_use(stp_assimp_writer* w, const struct aiString* path, const stp_assimp_use* use)
{
    uint32_t embedded = path != NULL ? find_embedded(w->scene, path->data) : STP_NONE;
    stp_assimp_put_u32(w, path == NULL           ? STP_ASSIMP_NO_TEXTURE
                          : embedded != STP_NONE ? STP_ASSIMP_EMBEDDED
                                                 : STP_ASSIMP_PATH);
    stp_assimp_put_u32(w, embedded);
    stp_assimp_put_text(w, path != NULL ? path->data : "", path != NULL ? path->length : 0);
    stp_assimp_put(w, use, sizeof(*use));
}

static int get_color(const struct aiMaterial* material, const char* key, float* rgb)
{
    struct aiColor4D color;
    int found = aiGetMaterialColor(material, key, 0, 0, &color) == aiReturn_SUCCESS;
    if (found) {
        memcpy(rgb, &color, 3 * sizeof(float));
    }
    return found;
}

static void decode(float* rgb)
{
    for (int i = 0; i < 3; ++i) {
        rgb[i] = stp_srgb_to_linear(rgb[i]);
    }
}

// Colours of formats without physical materials are sRGB; base colours are linear. A picture
// replaces a diffuse colour.
void stp_assimp_put_material(stp_assimp_writer* w, const struct aiMaterial* material)
{
    stp_assimp_material out = {.base_color = {1, 1, 1, 1}, .roughness = 1};
    struct aiString name = {0}, base = {0}, emissive = {0}, opacity = {0};
    struct aiString normals = {0}, heights = {0};
    stp_assimp_use base_use, emissive_use, normal_use, unused;
    (void)aiGetMaterialString(material, AI_MATKEY_NAME, &name);
    int has_base = get_texture(material, aiTextureType_BASE_COLOR, &base, &base_use) ||
                   get_texture(material, aiTextureType_DIFFUSE, &base, &base_use);
    int has_emissive = get_texture(material, aiTextureType_EMISSIVE, &emissive, &emissive_use);
    int has_normals = get_texture(material, aiTextureType_NORMALS, &normals, &normal_use);
    int has_heights = get_texture(material, aiTextureType_HEIGHT, &heights, &unused);
    if (has_normals && w->bumps) {
        has_normals = 0;
        has_heights = 1;
    }
    w->heights += has_heights && !has_normals ? 1 : 0; // as in mtl.c
    out.masked = get_texture(material, aiTextureType_OPACITY, &opacity, &unused) && has_base &&
                 strcmp(opacity.data, base.data) == 0;
    int physical = get_color(material, "$clr.base", out.base_color);
    if (!physical && !has_base && get_color(material, "$clr.diffuse", out.base_color)) {
        decode(out.base_color);
    }
    if (get_color(material, "$clr.emissive", out.emissive) && !physical) {
        decode(out.emissive);
    }
    float value;
    if (aiGetMaterialFloatArray(material, AI_MATKEY_OPACITY, &value, NULL) == aiReturn_SUCCESS &&
        value > 0.0f) { // 0 is almost always a misread transparency
        out.base_color[3] = value;
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_SHININESS, &value, NULL) == aiReturn_SUCCESS &&
        value > 0.0f) {
        out.roughness = sqrtf(sqrtf(2.0f / (value + 2.0f))); // as in mtl.c
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_METALLIC_FACTOR, &value, NULL) ==
        aiReturn_SUCCESS) {
        out.metallic = value;
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_ROUGHNESS_FACTOR, &value, NULL) ==
        aiReturn_SUCCESS) {
        out.roughness = value;
    }
    stp_assimp_put_string(w, &name);
    stp_assimp_put(w, &out, sizeof(out));
    put_use(w, has_base ? &base : NULL, &base_use);
    put_use(w, has_emissive ? &emissive : NULL, &emissive_use);
    put_use(w, has_normals ? &normals : NULL, &normal_use);
}
