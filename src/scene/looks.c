// SPDX-License-Identifier: MIT
#include "scene/looks.h"

#include "base/core/context.h"
#include "base/math/color.h"

#include <assert.h>
#include <string.h>

enum {
    METAL_STEPS = 4,
    ROUGH_STEPS = 8,
    GLOW_STEPS = 4, ///< of each of three channels
};
_Static_assert(METAL_STEPS* ROUGH_STEPS <= STP_LOOK_CODES, "codes of a surface");
_Static_assert(GLOW_STEPS* GLOW_STEPS* GLOW_STEPS <= STP_LOOK_CODES, "codes of a glow");

/// The nearest of `steps` values from 0 to 1.
static uint32_t step_of(float value, uint32_t steps)
{
    float scaled = value * (float)(steps - 1) + 0.5f;
    return !(scaled > 0.0f) ? 0 : scaled >= (float)steps ? steps - 1 : (uint32_t)scaled;
}

static uint32_t surface_code(float metal, float roughness)
{
    return step_of(metal, METAL_STEPS) * ROUGH_STEPS + step_of(roughness, ROUGH_STEPS);
}

/// Steps are even to the eye: those of square roots.
static uint32_t glow_code(const float color[3], uint32_t steps)
{
    uint32_t code = 0;
    for (int c = 0; c < 3; ++c) {
        code = code * steps + step_of(sqrtf(stp_max(color[c], 0.0f)), steps);
    }
    return code;
}

/// Sums of the texels of each code.
typedef struct code_sums {
    uint64_t count[STP_LOOK_CODES];
    double sum[STP_LOOK_CODES][3];
} code_sums;

static void add_texel(code_sums* sums, uint32_t code, const float value[3])
{
    assert(code < STP_LOOK_CODES);
    sums->count[code] += 1;
    for (int c = 0; c < 3; ++c) {
        sums->sum[code][c] += (double)value[c];
    }
}

static void add_surfaces(const stp_texture* texture, code_sums* sums)
{
    size_t size = (size_t)texture->width * texture->height;
    for (size_t i = 0; i < size; ++i) {
        const uint8_t* t = texture->texels + 4 * i;
        const float value[3] = {(float)t[2] / 255.0f, (float)t[1] / 255.0f, 0.0f};
        add_texel(sums, surface_code(value[0], value[1]), value);
    }
}

static void add_glows(const stp_texture* texture, uint32_t steps, code_sums* sums)
{
    size_t size = (size_t)texture->width * texture->height;
    for (size_t i = 0; i < size; ++i) {
        const uint8_t* t = texture->texels + 4 * i;
        const float value[3] = {stp_srgb8_to_linear(t[0]), stp_srgb8_to_linear(t[1]),
                                stp_srgb8_to_linear(t[2])};
        add_texel(sums, glow_code(value, steps), value);
    }
}

/// The mean of all texels: farther away, that is what is seen.
static void find_mean(const code_sums* sums, float mean[3])
{
    double count = 0.0, sum[3] = {0};
    for (int i = 0; i < STP_LOOK_CODES; ++i) {
        count += (double)sums->count[i];
        for (int c = 0; c < 3; ++c) {
            sum[c] += sums->sum[i][c];
        }
    }
    for (int c = 0; c < 3; ++c) {
        mean[c] = count > 0.0 ? (float)(sum[c] / count) : 1.0f;
    }
}

/// Adds the mean, unless texels have its code.
static void add_mean(code_sums* sums, uint32_t code, const float mean[3])
{
    if (sums->count[code] == 0) {
        add_texel(sums, code, mean);
    }
}

/// The centre of a code, to compare codes.
static void centre_of(uint32_t code, const uint32_t steps[3], float out[3])
{
    for (int c = 2; c >= 0; --c) {
        out[c] = steps[c] > 1 ? (float)(code % steps[c]) / (float)(steps[c] - 1) : 0.0f;
        code /= steps[c];
    }
}

/// Makes a bin of each code that texels have. Other codes take the nearest bin.
static void make_bins(const code_sums* sums, const uint32_t steps[3], stp_look_bins* bins)
{
    uint32_t codes[STP_LOOK_CODES], code_count = steps[0] * steps[1] * steps[2];
    *bins = (stp_look_bins){.steps = steps[2]};
    for (uint32_t i = 0; i < code_count; ++i) {
        if (sums->count[i] != 0) {
            codes[bins->count] = i;
            for (int c = 0; c < 3; ++c) {
                bins->values[bins->count][c] = (float)(sums->sum[i][c] / (double)sums->count[i]);
            }
            bins->count += 1;
        }
    }
    assert(bins->count > 0 && "a texture has texels");
    for (uint32_t i = 0; i < code_count; ++i) {
        float own[3], least = FLT_MAX;
        centre_of(i, steps, own);
        for (uint32_t b = 0; b < bins->count; ++b) {
            float other[3], distance = 0.0f;
            centre_of(codes[b], steps, other);
            for (int c = 0; c < 3; ++c) {
                distance += (own[c] - other[c]) * (own[c] - other[c]);
            }
            if (distance < least) {
                least = distance;
                bins->of_code[i] = (uint8_t)b;
            }
        }
    }
}

/// One bin that changes nothing.
static void make_plain(stp_look_bins* bins)
{
    *bins = (stp_look_bins){.count = 1, .values = {{1.0f, 1.0f, 1.0f}}, .steps = 1};
}

static const stp_texture* texture_of(const stp_scene* scene, const stp_texture_use* use)
{
    const stp_texture* texture =
        use->texture < scene->texture_count ? &scene->textures[use->texture] : NULL;
    bool there =
        texture != NULL && texture->texels != NULL && texture->width != 0 && texture->height != 0;
    return there ? texture : NULL;
}

static void find_surface(const stp_texture* texture, stp_look_bins* bins)
{
    static const uint32_t steps[3] = {1, METAL_STEPS, ROUGH_STEPS};
    code_sums sums = {0};
    float mean[3];
    add_surfaces(texture, &sums);
    find_mean(&sums, mean);
    add_mean(&sums, surface_code(mean[0], mean[1]), mean);
    make_bins(&sums, steps, bins);
}

/// @param steps of each channel; 1: the mean alone
static void find_glow(const stp_texture* texture, uint32_t steps, stp_look_bins* bins)
{
    const uint32_t of_channels[3] = {steps, steps, steps};
    code_sums sums = {0};
    float mean[3];
    add_glows(texture, steps, &sums);
    find_mean(&sums, mean);
    add_mean(&sums, glow_code(mean, steps), mean);
    make_bins(&sums, of_channels, bins);
}

/// Finds the bins of a material's textures.
static void find_look(const stp_scene* scene, stp_look* look)
{
    const stp_material* material = &scene->materials[look->material];
    const stp_texture* surface = texture_of(scene, &material->metallic_roughness_texture);
    const stp_texture* glow = texture_of(scene, &material->emissive_texture);
    bool glows = material->emissive[0] > 0.0f || material->emissive[1] > 0.0f ||
                 material->emissive[2] > 0.0f;
    make_plain(&look->surface);
    make_plain(&look->glow);
    if (surface != NULL) {
        find_surface(surface, &look->surface);
    }
    uint32_t steps = glow != NULL && glows ? GLOW_STEPS : 0;
    for (; steps > 0; steps /= 2) { // fewer steps, until there are few variants
        find_glow(glow, steps, &look->glow);
        if (look->surface.count * look->glow.count <= STP_LOOK_VARIANTS) {
            break;
        }
    }
}

static void find_looks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_scene* scene = user;
    for (size_t i = begin; i < end; ++i) {
        find_look(scene, &scene->looks[i]);
    }
}

/// Lists the materials that may have looks and that triangles have.
static stp_result list_looks(stp_scene* scene)
{
    bool* used = STP_NEW_ZEROED(scene->context, bool, scene->material_count + 1);
    if (used == NULL) {
        return stp_fail_memory(scene->context);
    }
    stp_free(scene->context, scene->looks);
    scene->looks = NULL;
    scene->look_count = scene->variant_count = 0;
    size_t capacity = 0;
    stp_result result = STP_OK;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        used[scene->meshes[i].material] = true;
    }
    for (uint32_t i = 0; i < scene->material_count && result == STP_OK; ++i) {
        stp_material* m = &scene->materials[i];
        m->look = 0;
        bool textured = texture_of(scene, &m->metallic_roughness_texture) != NULL ||
                        texture_of(scene, &m->emissive_texture) != NULL;
        if (!used[i] || !textured || m->unlit) {
            continue;
        }
        result = STP_SCENE_MAKE_ROOM(scene->context, scene->looks, capacity,
                                     (size_t)scene->look_count + 1);
        if (result == STP_OK) {
            scene->looks[scene->look_count++] = (stp_look){.material = i};
            m->look = scene->look_count;
        }
    }
    stp_free(scene->context, used);
    return result;
}

stp_result stp_scene_find_looks(stp_scene* scene)
{
    stp_result result = list_looks(scene);
    if (result != STP_OK) {
        return result;
    }
    stp_parallel_for(scene->context, scene->look_count, 1, find_looks, scene);
    for (uint32_t i = 0; i < scene->look_count; ++i) {
        stp_look* look = &scene->looks[i];
        uint32_t count = look->surface.count * look->glow.count;
        look->first_variant = scene->variant_count;
        if (count > 1) {
            scene->variant_count += count;
        } else { // the means say it all
            scene->materials[look->material].look = 0;
        }
    }
    return STP_OK;
}

uint32_t stp_look_surface_bin(const stp_look* look, float metal, float roughness)
{
    return look->surface.count > 1 ? look->surface.of_code[surface_code(metal, roughness)] : 0;
}

uint32_t stp_look_glow_bin(const stp_look* look, const float color[3])
{
    return look->glow.count > 1 ? look->glow.of_code[glow_code(color, look->glow.steps)] : 0;
}

stp_variant stp_scene_get_variant(const stp_scene* scene, uint32_t variant)
{
    uint32_t i = 0;
    assert(variant < scene->variant_count);
    while (i + 1 < scene->look_count && scene->looks[i + 1].first_variant <= variant) {
        i += 1;
    }
    const stp_look* look = &scene->looks[i];
    const stp_material* m = &scene->materials[look->material];
    uint32_t within = variant - look->first_variant;
    const float* surface = look->surface.values[within / look->glow.count];
    const float* glow = look->glow.values[within % look->glow.count];
    assert(within < look->surface.count * look->glow.count);
    return (stp_variant){
        .material = look->material,
        .metallic = m->metallic * surface[0],
        .roughness = m->roughness * surface[1],
        .emissive = {m->emissive[0] * glow[0], m->emissive[1] * glow[1], m->emissive[2] * glow[2]}};
}
