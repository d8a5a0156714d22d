// SPDX-License-Identifier: MIT
#include "support_built.h"

#include "base/math/rng.h"
#include "builder/build_scene.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

enum { MESHES = 5, OBJECTS = 36, TRIANGLES = 30 };

static double random_between(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

static stp_affine random_transform(uint64_t seed, double reach)
{
    double turn = random_between(seed, 1, 0.0, 6.0), scale = random_between(seed, 2, 0.4, 1.2);
    double mirror = stp_rng_below(seed, 3, 4) == 0 ? -scale : scale;
    double c = cos(turn), s = sin(turn);
    stp_affine t = {{{scale * c, 0, scale * s, random_between(seed, 4, -reach, reach)},
                     {0, mirror, 0, random_between(seed, 5, -reach, reach)},
                     {-scale * s, 0, scale * c, random_between(seed, 6, -reach, reach)}}};
    return t;
}

/// A strip of triangles that winds through a box.
static stp_result add_mesh(stp_scene* scene, uint64_t seed)
{
    stp_mesh mesh = {.vertex_count = TRIANGLES + 2, .triangle_count = TRIANGLES};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 3 * (TRIANGLES + 2));
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * TRIANGLES);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return stp_fail_memory(scene->context);
    }
    for (uint32_t i = 0; i < 3 * (TRIANGLES + 2); ++i) {
        mesh.positions[i] = (float)random_between(seed, 100 + i, -1.0, 1.0);
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
        mesh.indices[i] = i / 3 + i % 3;
    }
    return stp_scene_add_mesh(scene, &mesh, NULL);
}

static stp_result add_content(stp_scene* scene, uint64_t seed, uint32_t index)
{
    stp_result result = STP_OK;
    for (uint32_t i = stp_rng_below(seed, 10, 3); i > 0 && result == STP_OK; --i) {
        result = stp_scene_add_part(scene,
                                    (stp_part){STP_PART_MESH, stp_rng_below(seed, 20 + i, MESHES)});
    }
    if (result == STP_OK && index > 3 && stp_rng_below(seed, 11, 3) == 0) {
        result = stp_scene_add_use(scene, stp_rng_below(seed, 12, 4));
    }
    for (uint32_t i = stp_rng_below(seed, 13, 4) == 0 ? 3 : 0; i > 0 && result == STP_OK; --i) {
        stp_affine place = random_transform(stp_rng_hash(seed, 30 + i), 4.0);
        result = stp_scene_add_instance(scene, &place);
    }
    return result;
}

static stp_result generate(stp_scene* scene, const char* name, void* user)
{
    uint64_t base = *(const uint64_t*)user;
    (void)name;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < MESHES && result == STP_OK; ++i) {
        result = add_mesh(scene, stp_rng_hash(base, i));
    }
    for (uint32_t i = 0; i < OBJECTS && result == STP_OK; ++i) {
        uint64_t seed = stp_rng_hash(base, 1000 + i);
        char text[32];
        snprintf(text, sizeof(text), "%s %u", i % 3 == 0 ? "Pump" : "valve", i);
        stp_object object = {.name = i % 7 == 6 ? NULL : text,
                             .id = i % 5 == 0 ? "guid" : NULL,
                             .parent = STP_NONE,
                             .transform = random_transform(seed, 6.0)};
        if (i < 2) { // two prototypes and their content
            object.flags = STP_OBJECT_PROTOTYPE;
        } else if (i < 4) {
            object.parent = i - 2;
        } else if (i > 6 && stp_rng_below(seed, 50, 4) != 0) {
            object.parent = 4 + stp_rng_below(seed, 51, i - 4);
            if (stp_rng_below(seed, 52, 3) == 0) { // a layer: as wide as its parent
                object.transform = stp_affine_identity();
            }
        }
        result = stp_scene_add_object(scene, &object, NULL);
        result = result == STP_OK ? add_content(scene, seed, i) : result;
    }
    return result;
}

stp_store* built_open(stp_context* context, uint64_t seed, bool splats)
{
    char folder[64] = "stp_built_XXXXXX", path[96];
    if (mkdtemp(folder) == NULL) {
        return NULL;
    }
    snprintf(path, sizeof(path), "%s/a.stip", folder);
    const char* inputs[] = {"scene:random"};
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 1,
                           .output = path,
                           .partition = {.leaf_triangles = 50, .child_count = 4},
                           .blue = {.capture = {.wanted_candidates = 500}},
                           .splat_rule = {1e-9, 60},
                           .threshold = splats ? 1 : UINT64_C(1) << 40,
                           .generate = generate,
                           .generate_user = &seed};
    stp_store* store = NULL;
    stp_result result = stp_build(context, &desc, NULL);
    result = result == STP_OK ? stp_store_open(context, path, &store) : result;
    unlink(path);
    rmdir(folder);
    return result == STP_OK ? store : NULL;
}

bool built_unfold(const stp_store* store, uint32_t node, const stp_affine* transform,
                  built_places* out)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_node* n = &d->nodes[node];
    for (uint32_t i = 0; i < n->part_count; ++i) {
        if (out->count == BUILT_PLACES) {
            return false;
        }
        out->places[out->count++] =
            stp_instance_of_part(store, d->parts[n->first_part + i], transform);
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        if (!built_unfold(store, edge->node, &below, out)) {
            return false;
        }
    }
    return true;
}

bool built_has(const built_places* places, const stp_instance* place)
{
    for (uint32_t i = 0; i < places->count; ++i) {
        const stp_instance* p = &places->places[i];
        if (p->part.kind == place->part.kind && p->part.index == place->part.index &&
            stp_instance_is_same(&p->bounds, &p->transform, &place->transform)) {
            return true;
        }
    }
    return false;
}
