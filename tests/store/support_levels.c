// SPDX-License-Identifier: MIT
#include "support_levels.h"

#include "support_sample.h"

#include "base/math/position_grid.h"

#include <stdio.h>
#include <unistd.h>

static const uint32_t sides[LEVELS_MESHES] = {5, 9, 8, 11,
                                              13}; // 50, 162, 128, 242 and 338 triangles
static const uint32_t ends[LEVELS_MESHES][3] = {{0}, {0}, {100, 128}, {121, 242}, {128, 250, 338}};
static const uint32_t counts[LEVELS_MESHES] = {0, 0, 2, 2, 3};

static bool make_mesh(levels_fixture* f, uint32_t i)
{
    if (!made_mesh_create(MADE_WAVE, sides[i], i == 1 ? MADE_NORMALS : 0, &f->sheets[i])) {
        return false;
    }
    f->meshes[i] = made_mesh_view(&f->sheets[i]);
    f->meshes[i].name = i < LEVELS_OWN ? "sheet" : NULL;
    f->meshes[i].area = 1.0;
    f->meshes[i].material = i < LEVELS_OWN + 1 ? 0 : i - 1;
    f->keys[i] = (stp_hash){i + 1, 7};
    const stp_store_mesh* mesh = &f->meshes[i];
    double step = stp_choose_grid_step(mesh->positions, mesh->indices, mesh->triangle_count);
    if (i == 0) {
        return true;
    }
    return i == 1 ? stp_clusters_encode(f->context, mesh, step, &f->coded[i]) == STP_OK
                  : stp_clusters_encode_ranges(f->context, mesh, step, ends[i], counts[i],
                                               &f->coded[i]) == STP_OK;
}

static void make_graph(levels_fixture* f)
{
    for (uint32_t i = 0; i < 2; ++i) {
        f->nodes[i] = (stp_store_node){.first_part = i,
                                       .part_count = 1,
                                       .set = STP_STORE_NONE,
                                       .triangle_count = f->meshes[i].triangle_count,
                                       .bounds = {{0, 0, 0}, {1, 1, 1}}};
        f->parts[i] = (stp_store_part){STP_STORE_PART_MESH, i};
        f->edges[i] = (stp_store_edge){i, stp_affine_identity()};
    }
    f->nodes[2] =
        (stp_store_node){.edge_count = 2, .set = STP_STORE_NONE, .bounds = {{0, 0, 0}, {1, 1, 1}}};
    for (uint32_t i = 0; i < LEVELS_MATERIALS; ++i) {
        f->materials[i] =
            (stp_store_material){.base_color = {1.0f, 0.5f, 0.25f, 1.0f},
                                 .base_color_texture = {.texture = STP_STORE_NONE},
                                 .metallic_roughness_texture = {.texture = STP_STORE_NONE},
                                 .emissive_texture = {.texture = STP_STORE_NONE}};
    }
}

static void make_levels(levels_fixture* f)
{
    static const stp_store_level levels[] = {
        {.node = 0}, {.node = 0}, {.node = 2, .flags = STP_LEVEL_FROM_OUTSIDE}};
    static const stp_store_level_group groups[] = {{{0.5f, 0.0f, 0.25f}, 2.0f, 0.5f},
                                                   {{0.5f, 0.1f, 0.25f}, 3.0f, 2.0f}};
    static const stp_store_level_cluster clusters[] = {
        {1, STP_STORE_NONE, 100},
        {1, STP_STORE_NONE, 0}, // coarse
        {0, 1, 5},
        {0, 1, 121}, // middle
        {STP_STORE_NONE, 0, 0},
        {STP_STORE_NONE, 1, 7},
        {0, 1, 88}, // of the root
    };
    memcpy(f->levels, levels, sizeof(levels));
    memcpy(f->groups, groups, sizeof(groups));
    memcpy(f->clusters, clusters, sizeof(clusters));
}

bool levels_set_up(levels_fixture* f, stp_context* context)
{
    *f = (levels_fixture){.context = context};
    for (uint32_t i = 0; i < LEVELS_MESHES; ++i) {
        if (!make_mesh(f, i)) {
            return false;
        }
    }
    make_graph(f);
    make_levels(f);
    f->content = (stp_store_content){.directory = {.node_count = LEVELS_NODES,
                                                   .edge_count = 2,
                                                   .part_count = 2,
                                                   .material_count = LEVELS_MATERIALS,
                                                   .mesh_count = LEVELS_MESHES,
                                                   .level_count = LEVELS_LEVELS,
                                                   .level_cluster_count = LEVELS_CLUSTERS,
                                                   .level_group_count = LEVELS_GROUPS,
                                                   .nodes = f->nodes,
                                                   .edges = f->edges,
                                                   .parts = f->parts,
                                                   .materials = f->materials,
                                                   .levels = f->levels,
                                                   .level_clusters = f->clusters,
                                                   .level_groups = f->groups,
                                                   .root = 2,
                                                   .up = 'y'},
                                     .meshes = f->meshes,
                                     .coded_meshes = f->coded,
                                     .mesh_keys = f->keys};
    return true;
}

void levels_tear_down(levels_fixture* f)
{
    for (uint32_t i = 0; i < LEVELS_MESHES; ++i) {
        made_mesh_destroy(&f->sheets[i]);
        stp_coded_mesh_destroy(f->context, &f->coded[i]);
    }
    free(f->bytes);
    f->bytes = NULL;
}

stp_store_content levels_without(const levels_fixture* f)
{
    stp_store_content content = f->content;
    content.directory.mesh_count = LEVELS_OWN;
    content.directory.material_count = 2;
    content.directory.level_count = 0;
    content.directory.level_cluster_count = 0;
    content.directory.level_group_count = 0;
    return content;
}

stp_result levels_write(levels_fixture* f, const stp_store_content* content)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_levels_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    free(f->bytes);
    f->bytes = NULL;
    stp_result result = stp_store_write(f->context, content, path);
    if (result == STP_OK) {
        f->bytes = sample_read_file(path, &f->size);
    }
    unlink(path);
    return result;
}

stp_result levels_open(levels_fixture* f, uint64_t prefix, stp_store** store)
{
    const stp_store_open_desc desc = {.accept_partial = prefix != 0, .partial_bytes = prefix};
    *store = NULL;
    return stp_store_open_memory(f->context, "levels", f->bytes, f->size, &desc, store);
}
