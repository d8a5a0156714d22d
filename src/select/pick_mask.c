// SPDX-License-Identifier: MIT
// Evaluates the alpha of a material: of its texture at full resolution, its colour and vertex
// colours, as drawn at close range (src/draw/cpu/triangle_look.c).
#include "select/pick_internal.h"

#include <assert.h>

stp_result stp_pick_mask_make(stp_store* store, const stp_store_material* material, bool colors,
                              stp_pick_mask* mask)
{
    *mask = (stp_pick_mask){.material = material};
    float minimum = material->alpha == STP_STORE_MASK ? material->alpha_cutoff : 0.0f;
    const stp_store_texture_use* use = &material->base_color_texture;
    if (material->alpha == STP_STORE_OPAQUE ||
        (use->texture == STP_STORE_NONE && !colors && material->base_color[3] > minimum)) {
        return STP_OK;
    }
    mask->asks = true;
    return use->texture != STP_STORE_NONE
               ? stp_store_get_texture(store, use->texture, &mask->texture)
               : STP_OK;
}

/// Floor; large values and NaN become 0.
static int64_t floor_of(float value)
{
    if (!(value > -1e9f && value < 1e9f)) {
        return 0;
    }
    int64_t whole = (int64_t)value;
    return (float)whole > value ? whole - 1 : whole;
}

static size_t wrap(int64_t at, uint32_t size, uint32_t how)
{
    assert(size > 0 && "a texture with texels");
    int64_t n = size;
    if (how == 1) { // clamp
        return (size_t)(at < 0 ? 0 : at >= n ? n - 1 : at);
    }
    int64_t period = how == 2 ? 2 * n : n; // mirror
    int64_t rest = at % period;
    rest = rest < 0 ? rest + period : rest;
    return (size_t)(rest < n ? rest : period - 1 - rest);
}

/// Interpolates the texels around a position.
static float sample(const stp_store_texture* texture, stp_vec2 uv)
{
    float half = texture->nearest != 0 ? 0.0f : 0.5f;
    float u = uv.x * (float)texture->width - half, v = uv.y * (float)texture->height - half;
    int64_t x = floor_of(u), y = floor_of(v);
    float part_x = stp_clamp(u - (float)x, 0.0f, 1.0f),
          part_y = stp_clamp(v - (float)y, 0.0f, 1.0f);
    float rows[2];
    if (texture->nearest != 0) {
        part_x = part_y = 0.0f;
    }
    for (int j = 0; j < 2; ++j) {
        const uint8_t* row = texture->texels + 4 * (wrap(y + j, texture->height, texture->wrap_v) *
                                                    (size_t)texture->width);
        float left = (float)row[4 * wrap(x, texture->width, texture->wrap_u) + 3];
        float right = (float)row[4 * wrap(x + 1, texture->width, texture->wrap_u) + 3];
        rows[j] = left + (right - left) * part_x;
    }
    return (rows[0] + (rows[1] - rows[0]) * part_y) / 255.0f;
}

bool stp_pick_mask_has(const stp_pick_mask* mask, const stp_pick_corner corners[3],
                       const double share[3])
{
    const stp_store_material* material = mask->material;
    assert(mask->asks && material->alpha != STP_STORE_OPAQUE);
    float u = 0.0f, v = 0.0f, own = 0.0f, alpha = material->base_color[3];
    for (int k = 0; k < 3; ++k) {
        float part = (float)share[k];
        u += part * corners[k].uv.x;
        v += part * corners[k].uv.y;
        own += part * corners[k].alpha;
    }
    if (mask->texture.texels != NULL && mask->texture.width > 0 && mask->texture.height > 0) {
        const float(*t)[3] = material->base_color_texture.transform;
        alpha *= sample(&mask->texture, (stp_vec2){t[0][0] * u + t[0][1] * v + t[0][2],
                                                   t[1][0] * u + t[1][1] * v + t[1][2]});
    }
    alpha *= own;
    return material->alpha == STP_STORE_MASK ? alpha >= material->alpha_cutoff : alpha > 0.0f;
}
