// SPDX-License-Identifier: MIT
// Appearance of a triangle at a point: texture coordinates, colours, and alpha tests.
#include "base/math/rng.h"
#include "draw/cpu/triangle.h"
#include "raster/blue_noise.h"
#include "raster/cutout.h"

#include <assert.h>

enum { GHOST_SEED = 0x6057 }; // independent of the pixels that alpha removes

stp_vec2 stp_cpu_mesh_uv(const stp_cpu_triangle* triangle, const stp_store_texture_use* use,
                         const float weight[3])
{
    int set = use->texcoord != 0 ? 1 : 0;
    if (!triangle->has_texcoord[set]) {
        return (stp_vec2){0};
    }
    float u = 0.0f, v = 0.0f;
    for (int k = 0; k < 3; ++k) {
        const float* uv = triangle->texcoord[set][k];
        u += weight[k] * uv[0];
        v += weight[k] * uv[1];
    }
    const float(*t)[3] = use->transform;
    return (stp_vec2){t[0][0] * u + t[0][1] * v + t[0][2], t[1][0] * u + t[1][1] * v + t[1][2]};
}

float stp_cpu_mesh_density(const stp_cpu_triangle* triangle, const stp_store_texture_use* use,
                           const stp_texture_pyramid* pyramid)
{
    int set = use->texcoord != 0 ? 1 : 0;
    if (!triangle->has_texcoord[set]) {
        return 0.0f;
    }
    const float *a = triangle->texcoord[set][0], *b = triangle->texcoord[set][1],
                *c = triangle->texcoord[set][2];
    const float(*t)[3] = use->transform;
    float turned = fabsf(t[0][0] * t[1][1] - t[0][1] * t[1][0]);
    float uv_area = fabsf((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) * turned;
    float texels = uv_area * (float)pyramid->width[0] * (float)pyramid->height[0];
    const float *p = triangle->position[0], *q = triangle->position[1], *s = triangle->position[2];
    stp_vec3 across = stp_cross((stp_vec3){q[0] - p[0], q[1] - p[1], q[2] - p[2]},
                                (stp_vec3){s[0] - p[0], s[1] - p[1], s[2] - p[2]});
    float area = stp_length(across);
    return area > 0.0f ? sqrtf(stp_min(texels / area, FLT_MAX)) : 0.0f;
}

static float vertex_color(const stp_cpu_triangle* triangle, const float weight[3], int channel)
{
    float sum = 0.0f;
    for (int corner = 0; corner < 3; ++corner) {
        sum += weight[corner] * triangle->color[corner][channel];
    }
    return sum;
}

void stp_cpu_mesh_color(const stp_cpu_item* item, const stp_cpu_triangle* triangle,
                        const float weight[3], float footprint, float out[4])
{
    const stp_store_material* material = item->material;
    for (int k = 0; k < 4; ++k) {
        out[k] = material->base_color[k];
    }
    if (item->base_color != NULL) {
        const stp_store_texture_use* use = &material->base_color_texture;
        float texel[4];
        stp_texture_sample(item->base_color, stp_cpu_mesh_uv(triangle, use, weight), footprint,
                           texel);
        for (int k = 0; k < 4; ++k) {
            out[k] *= texel[k];
        }
    }
    for (int k = 0; k < 4 && triangle->has_color; ++k) {
        out[k] *= vertex_color(triangle, weight, k);
    }
}

int32_t stp_cpu_item_facing(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    bool front_only = (item->material->flags & STP_SHADING_FRONT_ONLY) != 0;
    return front_only && !stp_cpu_draws_backs(r) ? stp_affine_front_turn(&item->draw->transform)
                                                 : 0;
}

bool stp_cpu_item_needs_keep(const stp_cpu_item* item)
{
    const stp_store_material* material = item->material;
    if (item->draw->ghost) {
        return true;
    }
    if (material->alpha == STP_STORE_OPAQUE) {
        return false;
    }
    float minimum = material->alpha == STP_STORE_MASK ? material->alpha_cutoff : 1.0f;
    bool colors = item->mesh.colors != NULL || (item->clusters.present & STP_COLUMN_COLORS) != 0;
    return item->base_color != NULL || colors || material->base_color[3] < minimum;
}

/// Pseudo-random number 0..1 from identity and place; the same for the same picture.
static float noise(uint64_t seed, uint32_t x, uint32_t y)
{
    uint64_t bits = stp_rng_hash(seed, (uint64_t)y << 32 | x);
    return (float)(bits >> 40) * (1.0f / 16777216.0f);
}

/// Key of a triangle's alpha thresholds: its facing, and its position along that direction.
static uint32_t find_pattern(const stp_cpu_item* item, const stp_cpu_triangle* triangle)
{
    const float *a = triangle->position[0], *b = triangle->position[1], *c = triangle->position[2];
    stp_vec3 across = stp_cross((stp_vec3){b[0] - a[0], b[1] - a[1], b[2] - a[2]},
                                (stp_vec3){c[0] - a[0], c[1] - a[1], c[2] - a[2]});
    float x = fabsf(across.x), y = fabsf(across.y), z = fabsf(across.z);
    uint32_t axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    float along = axis == 0 ? across.x : axis == 1 ? across.y : across.z;
    float middle = (a[axis] + b[axis] + c[axis]) * (1.0f / 3.0f);
    float cell =
        floorf(stp_clamp(middle * item->cells, -STP_TRANSPARENT_CELLS, STP_TRANSPARENT_CELLS));
    return stp_blue_noise_key(item->seed, 2 * axis + (along < 0.0f ? 1 : 0), (int32_t)cell);
}

static void remember_triangle(const stp_cpu_keep* keep, uint32_t index)
{
    const stp_cpu_item* item = keep->item;
    stp_cpu_keep_memory* memory = keep->memory;
    const float* w = item->camera.matrix.m[3];
    const stp_cpu_triangle* triangle = stp_cpu_read_triangle(&memory->reader, item, index);
    memory->triangle = index;
    for (int k = 0; k < 3; ++k) {
        const float* p = triangle->position[k];
        memory->w[k] = w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3];
    }
    memory->pattern = find_pattern(item, triangle);
    memory->density = 0.0f;
    if (item->base_color != NULL) {
        memory->density =
            stp_cpu_mesh_density(triangle, &item->material->base_color_texture, item->base_color);
    }
}

/// Whether a point of a triangle is cut away.
static bool is_beyond_section(const stp_cpu_keep* keep, const stp_cpu_triangle* triangle,
                              const float weight[3])
{
    assert(keep->section_mask >> keep->sections->count == 0 && "bits of known planes");
    float at[3];
    for (int c = 0; c < 3; ++c) {
        at[c] = weight[0] * triangle->position[0][c] + weight[1] * triangle->position[1][c] +
                weight[2] * triangle->position[2][c];
    }
    for (uint32_t bits = keep->section_mask; bits != 0; bits &= bits - 1) {
        const float* row = keep->sections->rows[__builtin_ctz(bits)];
        if (row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3] > 0.0f) {
            return true;
        }
    }
    return false;
}

/// Whether a fragment of a blended material is drawn.
static bool keeps_alpha(const stp_cpu_keep* keep, float alpha, uint32_t x, uint32_t y)
{
    const stp_cpu_renderer* r = keep->renderer;
    switch (r->layers.stage) {
    case CPU_LAYERS_OPAQUE:
        return alpha >= STP_ALPHA_OPAQUE_FROM;
    case CPU_LAYERS_PEEL:
        if (!(alpha >= STP_ALPHA_MIN && alpha < STP_ALPHA_OPAQUE_FROM)) {
            return false;
        }
        if (r->layers.nearest_only) {
            uint32_t depth = r->layers.depth_of_opacity[(uint32_t)(alpha * 255.0f + 0.5f)];
            atomic_fetch_add_explicit(&r->layers.optical_depths[(size_t)y * r->width + x], depth,
                                      memory_order_relaxed);
        }
        return true;
    default:
        return alpha >= STP_ALPHA_OPAQUE_FROM ||
               alpha > stp_blue_noise_threshold(keep->memory->pattern, x, y, r->pattern);
    }
}

bool stp_cpu_keep_fragment(const void* user, uint32_t triangle, float weight1, float weight2,
                           uint32_t x, uint32_t y)
{
    const stp_cpu_keep* keep = user;
    const stp_cpu_item* item = keep->item;
    const stp_cpu_keep_memory* memory = keep->memory;
    assert(item->kind == STP_DRAW_MESH && triangle <= UINT32_MAX - keep->first_triangle);
    const stp_store_material* material = item->material;
    triangle += keep->first_triangle;
    if (memory->triangle != triangle) {
        remember_triangle(keep, triangle);
    }
    const stp_cpu_triangle* corners = &memory->reader.triangle;
    float weight[3] = {1.0f - weight1 - weight2, weight1, weight2};
    uint64_t seed = (uint64_t)stp_cpu_sample_seed(keep->renderer, item) << 32 | triangle;
    if ((keep->section_mask != 0 && is_beyond_section(keep, corners, weight)) ||
        (item->draw->ghost &&
         noise(stp_rng_hash(seed, GHOST_SEED), x, y) >= stp_cpu_ghost_share(keep->renderer))) {
        return false;
    }
    if (material->alpha == STP_STORE_OPAQUE) {
        return true;
    }
    float own = material->base_color[3];
    if (corners->has_color) {
        own *= vertex_color(corners, weight, 3);
    }
    bool masked = material->alpha == STP_STORE_MASK;
    if (item->base_color == NULL) {
        return masked ? own >= material->alpha_cutoff : keeps_alpha(keep, own, x, y);
    }
    float depth = weight[0] * memory->w[0] + weight[1] * memory->w[1] +
                  weight[2] * memory->w[2]; // W is 1 everywhere in parallel projection
    float footprint = memory->density * depth / (item->camera.pixel_scale * item->scale);
    stp_vec2 uv = stp_cpu_mesh_uv(corners, &material->base_color_texture, weight);
    if (masked) {
        return stp_cutout_keeps(item->base_color, uv, footprint, own, material->alpha_cutoff);
    }
    float alpha = own * stp_texture_sample_alpha_of(item->base_color, uv, footprint);
    return keeps_alpha(keep, alpha, x, y);
}
