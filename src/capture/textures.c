// SPDX-License-Identifier: MIT
// Material inputs of a capture: texture coordinates, alpha, and mip levels of textures.
#include "capture/capture_internal.h"
#include "scene/looks.h"

#include <assert.h>

bool stp_capture_texcoord(const stp_mesh* mesh, const stp_texture_use* use, uint32_t vertex,
                          double uv[2])
{
    assert(vertex < mesh->vertex_count);
    const float* texcoords = use->texcoord < 2 ? mesh->texcoords[use->texcoord] : NULL;
    if (texcoords == NULL) {
        return false;
    }
    double u = (double)texcoords[2 * (size_t)vertex], v = (double)texcoords[2 * (size_t)vertex + 1];
    for (int r = 0; r < 2; ++r) {
        const float* row = use->transform[r];
        uv[r] = (double)row[0] * u + (double)row[1] * v + (double)row[2];
    }
    return true;
}

static stp_texture_pyramid level0_of(const stp_texture* texture)
{
    static const stp_texture_wrap wraps[] = {
        [STP_WRAP_REPEAT] = STP_TEXTURE_REPEAT,
        [STP_WRAP_CLAMP] = STP_TEXTURE_CLAMP,
        [STP_WRAP_MIRROR] = STP_TEXTURE_MIRROR,
    };
    return (stp_texture_pyramid){
        .level_count = 1,
        .width = {texture->width},
        .height = {texture->height},
        .texels = {texture->texels},
        .wrap_u = wraps[texture->wrap_u],
        .wrap_v = wraps[texture->wrap_v],
        .nearest = texture->nearest,
    };
}

stp_texture_pyramid stp_capture_level0(const stp_scene* scene, const stp_material* material)
{
    const stp_texture* texture = stp_scene_used_texture(scene, &material->base_color_texture);
    return texture != NULL ? level0_of(texture) : (stp_texture_pyramid){0};
}

float stp_capture_alpha(const stp_material* material, const stp_texture_pyramid* level0,
                        const stp_mesh* mesh, uint32_t triangle, float weight1, float weight2)
{
    const stp_texture_use* use = &material->base_color_texture;
    assert(triangle < mesh->triangle_count);
    const uint32_t* corner = mesh->indices + 3 * (size_t)triangle;
    float weight[3] = {1.0f - weight1 - weight2, weight1, weight2};
    float alpha = material->base_color[3];
    if (mesh->colors != NULL) {
        float sum = 0.0f;
        for (int k = 0; k < 3; ++k) {
            sum += weight[k] * ((float)mesh->colors[4 * (size_t)corner[k] + 3] / 65535.0f);
        }
        alpha *= sum;
    }
    if (level0->level_count == 0) {
        return alpha;
    }
    double at[2] = {0.0, 0.0};
    for (int k = 0; k < 3; ++k) {
        double uv[2];
        if (!stp_capture_texcoord(mesh, use, corner[k], uv)) {
            return alpha;
        }
        at[0] += (double)weight[k] * uv[0];
        at[1] += (double)weight[k] * uv[1];
    }
    return alpha * stp_texture_sample_alpha(level0, (stp_vec2){(float)at[0], (float)at[1]});
}

stp_result stp_capture_textures_create_empty(const stp_scene* scene,
                                             stp_capture_textures** textures)
{
    stp_capture_textures* made = STP_NEW_ZEROED(scene->context, stp_capture_textures, 1);
    if (made != NULL) {
        made->scene = scene;
        made->pyramids =
            STP_NEW_ZEROED(scene->context, stp_texture_pyramid, scene->texture_count + 1);
        made->surfaces =
            STP_NEW_ZEROED(scene->context, stp_texture_pyramid, scene->texture_count + 1);
    }
    if (made == NULL || made->pyramids == NULL || made->surfaces == NULL) {
        stp_capture_textures_destroy(made);
        return stp_fail_memory(scene->context);
    }
    *textures = made;
    return STP_OK;
}

/// Makes the mip levels of a use's texture unless they exist.
static stp_result add_use(const stp_capture_textures* textures, const stp_texture_use* use,
                          bool linear, stp_texture_pyramid* pyramids)
{
    const stp_texture* texture = stp_scene_used_texture(textures->scene, use);
    if (texture == NULL || pyramids[use->texture].level_count != 0) {
        return STP_OK;
    }
    stp_texture_pyramid* pyramid = &pyramids[use->texture];
    stp_texture_pyramid level0 = level0_of(texture);
    stp_result result =
        stp_texture_pyramid_create(textures->scene->context, texture->texels, texture->width,
                                   texture->height, linear, pyramid);
    if (result == STP_OK) {
        pyramid->wrap_u = level0.wrap_u;
        pyramid->wrap_v = level0.wrap_v;
        pyramid->nearest = level0.nearest;
    }
    return result;
}

stp_result stp_capture_textures_add(stp_capture_textures* textures, const stp_material* material,
                                    bool colors_only)
{
    stp_result result = add_use(textures, &material->base_color_texture, false, textures->pyramids);
    if (result == STP_OK && !colors_only) {
        result = add_use(textures, &material->normal_texture, true, textures->surfaces);
    }
    if (colors_only || material->look == 0) {
        return result;
    }
    const stp_look* look = &textures->scene->looks[material->look - 1];
    if (result == STP_OK && stp_look_surface(textures->scene, look)->count > 1) {
        result = add_use(textures, &material->metallic_roughness_texture, true, textures->surfaces);
    }
    if (result == STP_OK && stp_look_glow(textures->scene, look)->count > 1) {
        result = add_use(textures, &material->emissive_texture, false, textures->pyramids);
    }
    return result;
}

stp_result stp_capture_textures_create(const stp_scene* scene, bool colors_only,
                                       stp_capture_textures** textures)
{
    stp_capture_textures* made = NULL;
    stp_result result = stp_capture_textures_create_empty(scene, &made);
    for (size_t m = 0; made != NULL && m < scene->material_count && result == STP_OK; ++m) {
        result = stp_capture_textures_add(made, &scene->materials[m], colors_only);
    }
    if (result != STP_OK) {
        stp_capture_textures_destroy(made);
        return result;
    }
    *textures = made;
    return STP_OK;
}

void stp_capture_textures_destroy(stp_capture_textures* textures)
{
    if (textures == NULL) {
        return;
    }
    stp_context* context = textures->scene->context;
    stp_texture_pyramid* both[] = {textures->pyramids, textures->surfaces};
    for (int k = 0; k < 2; ++k) {
        for (size_t i = 0; both[k] != NULL && i < textures->scene->texture_count; ++i) {
            stp_texture_pyramid_destroy(context, &both[k][i]);
        }
        stp_free(context, both[k]);
    }
    stp_free(context, textures);
}
