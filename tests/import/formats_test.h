// SPDX-License-Identifier: MIT
// What the tests of single formats share: importing text, a digest of a scene, files in a scratch
// folder.
#pragma once

#include "tests.h"

#include "base/hash.h"
#include "import/import.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Imports bytes under a name. @return the scene, or NULL with the result in *result
static inline stp_scene* import_bytes(stp_context* context, const char* name, const void* bytes,
                                      size_t size, stp_result* result)
{
    stp_scene* scene = NULL;
    *result = stp_scene_create(context, &scene);
    if (*result == STP_OK) {
        *result = stp_import_memory(scene, name, bytes, size, &(stp_import_desc){0});
        if (*result == STP_OK) {
            return scene;
        }
        stp_scene_destroy(scene);
    }
    return NULL;
}

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

/// A digest of everything an importer adds: meshes, points, materials, textures, objects.
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

/// Whether every index, material and position of the scene is what its contract says.
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

/// Every truncation of the bytes: sound, or refused with exactly one sentence.
static inline int survives_truncation(const char* name, const void* bytes, size_t size)
{
    for (size_t cut = 0; cut < size; ++cut) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, name, bytes, cut, &result);
        int good = scene != NULL ? scene_is_sound(scene) && log.errors == 0 : log.errors == 1;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (!good) {
            fprintf(stderr, "%s: cut to %zu bytes: result %d, %d errors, last \"%s\"\n", name, cut,
                    result, log.errors, log.text);
            return 0;
        }
    }
    return 1;
}

/// Fails the n-th allocation, for every n until one import gets through: no leak, no crash, one
/// sentence.
static inline int survives_failing_allocator(const char* name, const void* bytes, size_t size)
{
    for (int n = 0; n < 100000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_result result;
        stp_scene* scene = import_bytes(context, name, bytes, size, &result);
        int done = scene != NULL;
        int good = done ? log.errors == 0 : result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (!good || heap.live_bytes != 0) {
            fprintf(stderr, "%s: allocation %d: result %d, %d errors, %zu bytes left\n", name, n,
                    result, log.errors, heap.live_bytes);
            return 0;
        }
        if (done) {
            return n > 0;
        }
    }
    return 0;
}

/// A scratch folder of this process; `path` receives folder/name. Files are written, never read
/// back.
static inline int write_scratch(char path[256], const char* name, const void* bytes, size_t size)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp-test-%ld-%s", folder != NULL ? folder : "/tmp", (long)getpid(),
             name);
    FILE* file = fopen(path, "wb");
    if (file == NULL) {
        return 0;
    }
    size_t written = fwrite(bytes, 1, size, file);
    return fclose(file) == 0 && written == size;
}
