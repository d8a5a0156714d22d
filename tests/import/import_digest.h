// SPDX-License-Identifier: MIT
// Hashes and validates the content that an importer added to a scene. For tests and fuzzers.
#pragma once

#include "base/io/hash.h"
#include "import/reading/import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static inline stp_hash digest_text(stp_hash hash, const char* text)
{
    return text != NULL ? stp_hash_bytes(hash, text, strlen(text) + 1)
                        : stp_hash_bytes(hash, "\xff", 1);
}

static inline stp_hash digest_array(stp_hash hash, const void* array, size_t count, size_t size)
{
    return array != NULL ? stp_hash_bytes(hash, array, count * size)
                         : stp_hash_bytes(hash, "\xfe", 1);
}

/// Hashes most of what an importer adds: meshes (without the second texture coordinates), points,
/// base colours of materials, texels, objects (without their parts).
static inline stp_hash digest_scene(const stp_scene* scene)
{
    stp_hash hash = {0};
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const stp_mesh* m = &scene->meshes[i];
        hash = digest_text(hash, m->name);
        hash = digest_array(hash, m->positions, m->vertex_count, 3 * sizeof(float));
        hash = digest_array(hash, m->normals, m->vertex_count, 3 * sizeof(float));
        hash = digest_array(hash, m->texcoords[0], m->vertex_count, 2 * sizeof(float));
        hash = digest_array(hash, m->colors, m->vertex_count, 4 * sizeof(uint16_t));
        hash = digest_array(hash, m->indices, m->triangle_count, 3 * sizeof(uint32_t));
        hash = stp_hash_bytes(hash, &m->material, sizeof(m->material));
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        const stp_point_set* p = &scene->point_sets[i];
        hash = digest_array(hash, p->positions, p->point_count, 3 * sizeof(float));
        hash = digest_array(hash, p->normals, p->point_count, 3 * sizeof(float));
        hash = digest_array(hash, p->colors, p->point_count, 4);
        for (int k = 0; k < STP_ATTRIBUTES; ++k) {
            hash = digest_array(hash, p->attributes[k], p->point_count,
                                stp_attribute_size((stp_attribute)k));
        }
    }
    for (size_t i = 0; i < scene->material_count; ++i) {
        hash = digest_text(hash, scene->materials[i].name);
        hash = stp_hash_bytes(hash, scene->materials[i].base_color, 4 * sizeof(float));
    }
    for (size_t i = 0; i < scene->texture_count; ++i) {
        const stp_texture* t = &scene->textures[i];
        hash = digest_array(hash, t->texels, (size_t)t->width * t->height, 4);
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        const stp_object* o = &scene->objects[i];
        hash = digest_text(hash, o->name);
        hash = stp_hash_bytes(hash, &o->parent, sizeof(o->parent));
        hash = stp_hash_bytes(hash, &o->transform, sizeof(o->transform));
        hash = stp_hash_bytes(hash, &o->part_count, sizeof(o->part_count));
    }
    return hash;
}

/// Whether every index, material and position of the scene is valid.
static inline int scene_is_sound(const stp_scene* scene)
{
    int sound = 1;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const stp_mesh* m = &scene->meshes[i];
        sound = sound && m->material < scene->material_count;
        for (size_t k = 0; k < 3 * (size_t)m->triangle_count; ++k) {
            sound = sound && m->indices[k] < m->vertex_count;
        }
        for (size_t k = 0; k < 3 * (size_t)m->vertex_count; ++k) {
            sound = sound && isfinite(m->positions[k]);
        }
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        for (size_t k = 0; k < 3 * (size_t)scene->point_sets[i].point_count; ++k) {
            sound = sound && isfinite(scene->point_sets[i].positions[k]);
        }
    }
    return sound;
}
