// SPDX-License-Identifier: MIT
// Shared by the tests of point formats.
#pragma once

#include "formats_test.h"

/// A digest of the scene and, once more, of the points' attributes.
static inline stp_hash digest_points(const stp_scene* scene)
{
    stp_hash hash = digest_scene(scene);
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        const stp_point_set* p = &scene->point_sets[i];
        for (int a = 0; a < STP_ATTRIBUTES; ++a) {
            hash = digest_array(hash, p->attributes[a], p->point_count,
                                stp_attribute_size((stp_attribute)a));
        }
    }
    return hash;
}

/// Imports with `threads` threads, in memory or with everything in a spill file. @return the
/// digest; zero on failure
static inline stp_hash digest_imported(const char* name, const void* bytes, size_t size,
                                       uint32_t threads, int spills)
{
    stp_hash digest = {0};
    stp_scene* scene = NULL;
    stp_spill* spill = NULL;
    stp_context* context = test_context(NULL, threads, NULL);
    stp_result result = spills ? stp_spill_create(context, ".", &spill) : STP_OK;
    result = result == STP_OK ? stp_scene_create(context, &scene) : result;
    if (result == STP_OK && spills) {
        stp_scene_use_spill(scene, spill, 16);
    }
    if (result == STP_OK) {
        result = stp_import_memory(scene, name, bytes, size, &(stp_import_desc){0});
    }
    if (result == STP_OK && (!spills || scene->point_sets[0].spilled)) {
        digest = digest_points(scene);
    }
    stp_scene_destroy(scene);
    stp_spill_destroy(spill);
    stp_context_destroy(context);
    return digest;
}

/// Whether the result is independent of threads and the spill file.
static inline int is_the_same_everywhere(const char* name, const void* bytes, size_t size)
{
    stp_hash plain = digest_imported(name, bytes, size, 1, 0);
    int good = plain.low != 0 || plain.high != 0;
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        for (int spills = 0; spills < 2; ++spills) {
            stp_hash other = digest_imported(name, bytes, size, threads, spills);
            good = good && stp_hash_equal(plain, other);
        }
    }
    return good;
}

/// Imports invalid data. @return whether it ends with `wanted` and one sentence that contains
/// `says`
static inline int is_refused(const char* name, const void* bytes, size_t size, stp_result wanted,
                             const char* says)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, name, bytes, size, &result);
    int good =
        scene == NULL && result == wanted && log.errors == 1 && strstr(log.text, says) != NULL;
    if (!good) {
        fprintf(stderr, "%s: result %d, %d errors, said: %s\n", name, result, log.errors, log.text);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return good;
}

/// The position of a point along the file's own axes (z up or y up, as imported), with its object's
/// transform.
static inline stp_vec3d place_of(const stp_scene* scene, size_t object, size_t set, size_t point)
{
    const float* p = scene->point_sets[set].positions + 3 * point;
    stp_vec3d at = {(double)p[0], (double)p[1], (double)p[2]};
    for (uint32_t o = (uint32_t)object; o != STP_NONE; o = scene->objects[o].parent) {
        at = stp_affine_point(&scene->objects[o].transform, at);
    }
    return scene->up[0] == 'z' ? (stp_vec3d){at.x, -at.z, at.y} : at;
}

static inline int is_near(stp_vec3d a, double x, double y, double z, double maximum)
{
    return fabs(a.x - x) <= maximum && fabs(a.y - y) <= maximum && fabs(a.z - z) <= maximum;
}
