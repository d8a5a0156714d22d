// SPDX-License-Identifier: MIT
// Base colours at points of triangles.
#include "capture/capture_internal.h"

#include <assert.h>

/// The square root of the texels on a triangle.
static double texels_across(const stp_texture_pyramid* pyramid, double uv[3][2])
{
    double a = (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]);
    double b = (uv[2][0] - uv[0][0]) * (uv[1][1] - uv[0][1]);
    return sqrt(0.5 * fabs(a - b) * (double)pyramid->width[0] * (double)pyramid->height[0]);
}

bool stp_capture_has_colors(const stp_capture_textures* textures, const stp_mesh* mesh)
{
    const stp_material* material = &textures->scene->materials[mesh->material];
    uint32_t texture = material->base_color_texture.texture;
    bool textured =
        texture < textures->scene->texture_count && textures->pyramids[texture].level_count != 0;
    return mesh->colors != NULL || textured;
}

void stp_capture_triangle_color(const stp_capture_textures* textures, const stp_mesh* mesh,
                                uint32_t triangle, const float weights[3], double share,
                                float color[3])
{
    const stp_material* material = &textures->scene->materials[mesh->material];
    const stp_texture_use* use = &material->base_color_texture;
    const uint32_t* corner = mesh->indices + 3 * (size_t)triangle;
    assert(triangle < mesh->triangle_count);
    for (size_t c = 0; c < 3; ++c) {
        color[c] = material->base_color[c];
        float sum = 0.0f;
        for (int k = 0; k < 3 && mesh->colors != NULL; ++k) {
            sum += weights[k] * (float)mesh->colors[4 * (size_t)corner[k] + c];
        }
        color[c] *= mesh->colors != NULL ? sum / 65535.0f : 1.0f;
    }
    const stp_texture_pyramid* pyramid =
        use->texture < textures->scene->texture_count ? &textures->pyramids[use->texture] : NULL;
    double uv[3][2], u = 0.0, v = 0.0;
    bool textured = pyramid != NULL && pyramid->level_count != 0;
    for (int k = 0; k < 3 && textured; ++k) {
        textured = stp_capture_texcoord(mesh, use, corner[k], uv[k]);
        u += textured ? (double)weights[k] * uv[k][0] : 0.0;
        v += textured ? (double)weights[k] * uv[k][1] : 0.0;
    }
    if (textured) {
        float texel[4], footprint = (float)fmin(share * texels_across(pyramid, uv), 65536.0);
        stp_texture_sample(pyramid, (stp_vec2){(float)u, (float)v}, footprint, texel);
        for (int c = 0; c < 3; ++c) {
            color[c] *= texel[c];
        }
    }
}
