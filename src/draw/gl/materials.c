// SPDX-License-Identifier: MIT
// Materials in the shaders' layout; they never change.
#include "base/core/context.h"
#include "base/math/color.h"
#include "draw/gl/gl_renderer.h"

#include <string.h>

/// The same as on the CPU (src/draw/cpu/shade_tables.c).
static light_material_block make_light(float metallic, float roughness, const float emissive[3],
                                       uint32_t flags)
{
    float a = stp_max(roughness, 0.25f);
    float a2 = a * a * a * a;
    return (light_material_block){
        .surface = {metallic, (a - 0.25f) * (1.0f / 0.75f), a2, 1.0f / (4.0f * a2 + 0.2f)},
        .emissive = {emissive[0], emissive[1], emissive[2],
                     (flags & STP_SHADING_UNLIT) != 0 ? 1.0f : 0.0f}};
}

static material_block make_material(const stp_store_material* m)
{
    material_block block = {
        .base_color = {m->base_color[0], m->base_color[1], m->base_color[2], m->base_color[3]},
        .numbers = {m->metallic, m->roughness, m->alpha_cutoff, (float)m->alpha},
        .emissive = {m->emissive[0], m->emissive[1], m->emissive[2],
                     (m->flags & STP_SHADING_UNLIT) != 0 ? 1.0f : 0.0f}};
    const stp_store_texture_use* uses[] = {&m->base_color_texture, &m->metallic_roughness_texture,
                                           &m->emissive_texture, &m->normal_texture};
    for (int i = 0; i < 4; ++i) {
        memcpy(block.uses[2 * i], uses[i]->transform[0], sizeof(uses[i]->transform[0]));
        memcpy(block.uses[2 * i + 1], uses[i]->transform[1], sizeof(uses[i]->transform[1]));
        block.uses[2 * i][3] = uses[i]->texcoord != 0 ? 1.0f : 0.0f;
    }
    block.uses[7][3] = m->normal_scale;
    return block;
}

static GLuint make_buffer(const stp_gl* gl, const void* from, size_t size, const char* label)
{
    GLuint buffer;
    gl->CreateBuffers(1, &buffer);
    gl->NamedBufferStorage(buffer, (GLsizeiptr)size, from, 0);
    gl->ObjectLabel(GL_BUFFER, buffer, -1, label);
    return buffer;
}

stp_result stp_gl_materials_create(stp_gl_renderer* r)
{
    const stp_store_directory* d = r->directory;
    stp_context* context = r->base.context;
    size_t light_count = SHADINGS + (size_t)d->material_count;
    size_t count = (size_t)d->material_count + 1; // never empty
    light_material_block* lights =
        STP_NEW_ZEROED(context, light_material_block, light_count + SCALE_COLORS);
    material_block* materials = STP_NEW_ZEROED(context, material_block, count);
    if (lights == NULL || materials == NULL) {
        stp_free(context, lights);
        stp_free(context, materials);
        return stp_fail_memory(context);
    }
    const float dark[3] = {0};
    r->largest_growth = stp_largest_growth(d->shadings, d->shading_count);
    for (uint32_t i = 0; i < SHADINGS; ++i) {
        const stp_shading* s = i < d->shading_count ? &d->shadings[i] : NULL;
        lights[i] = s != NULL ? make_light(s->metallic, s->roughness, s->emissive, s->flags)
                              : make_light(0.0f, 1.0f, dark, 0);
    }
    for (uint32_t i = 0; i < d->material_count; ++i) {
        const stp_store_material* m = &d->materials[i];
        lights[SHADINGS + i] = make_light(m->metallic, m->roughness, m->emissive, m->flags);
        materials[i] = make_material(m);
    }
    for (uint32_t i = 0; i < SCALE_COLORS; ++i) { // behind them, the colour scale
        for (int k = 0; k < 3; ++k) {
            lights[light_count + i].surface[k] = stp_srgb8_to_linear(stp_color_map[i][k]);
        }
    }
    r->light_materials = make_buffer(&r->gl, lights, (light_count + SCALE_COLORS) * sizeof(*lights),
                                     "light materials");
    r->materials = make_buffer(&r->gl, materials, count * sizeof(*materials), "materials");
    stp_free(context, lights);
    stp_free(context, materials);
    return STP_OK;
}
