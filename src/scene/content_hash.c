// SPDX-License-Identifier: MIT
#include "scene/bulk.h"
#include "scene/finish_steps.h"

#include <assert.h>
#include <string.h>

// Prefix of each kind's hash, so that kinds never collide.
enum { KIND_MESH = 1, KIND_POINTS, KIND_TEXTURE, KIND_MATERIAL, KIND_NODE };

// What lies in the spill need not stay resident.
static stp_hash hash_array(stp_hash hash, const stp_bulk_array* array, bool spilled)
{
    return spilled ? stp_hash_steps(hash, array->bytes, array->size, stp_spill_forget)
                   : stp_hash_bytes(hash, array->bytes, array->size);
}

static stp_hash hash_arrays(const uint32_t* head, size_t head_count, const stp_bulk_array* arrays,
                            size_t array_count, bool spilled)
{
    stp_hash hash = stp_hash_bytes((stp_hash){0}, head, head_count * sizeof(*head));
    for (size_t i = 0; i < array_count; ++i) {
        unsigned char present = arrays[i].bytes != NULL;
        hash = stp_hash_bytes(hash, &present, 1);
        if (arrays[i].size != 0) {
            hash = hash_array(hash, &arrays[i], spilled);
        }
    }
    return hash;
}

stp_hash stp_mesh_hash(const stp_mesh* mesh)
{
    uint32_t head[] = {KIND_MESH, mesh->vertex_count, mesh->triangle_count};
    stp_bulk_array arrays[STP_MESH_ARRAYS];
    stp_mesh_get_arrays(mesh, arrays);
    return hash_arrays(head, 3, arrays, STP_MESH_ARRAYS, mesh->spilled);
}

stp_hash stp_points_hash(const stp_point_set* points)
{
    uint32_t head[] = {KIND_POINTS, points->point_count};
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    stp_points_get_arrays(points, arrays);
    stp_hash hash = hash_arrays(head, 2, arrays, STP_POINT_ATTRIBUTE_ARRAY, points->spilled);
    for (uint32_t i = 0; i < STP_ATTRIBUTES; ++i) { // points without attributes keep their hash
        const stp_bulk_array* values = &arrays[STP_POINT_ATTRIBUTE_ARRAY + i];
        if (values->size != 0) {
            hash = stp_hash_bytes(hash, &i, sizeof(i));
            hash = hash_array(hash, values, points->spilled);
        }
    }
    return hash;
}

stp_hash stp_texture_hash(const stp_texture* texture)
{
    uint32_t head[] = {KIND_TEXTURE,
                       texture->width,
                       texture->height,
                       (uint32_t)texture->wrap_u,
                       (uint32_t)texture->wrap_v,
                       texture->nearest};
    stp_bulk_array arrays[STP_TEXTURE_ARRAYS];
    stp_texture_get_arrays(texture, arrays);
    return hash_arrays(head, 6, arrays, 1,
                       texture->spilled); // only the texels: the encoding is invisible
}

static stp_hash hash_floats(stp_hash hash, const float* values, size_t count)
{
    float plain[16];
    assert(count <= sizeof(plain) / sizeof(plain[0]));
    for (size_t i = 0; i < count; ++i) {
        plain[i] = values[i] + 0.0f; // normalises -0 to 0
    }
    return stp_hash_bytes(hash, plain, count * sizeof(float));
}

static stp_hash hash_texture_use(stp_hash hash, const stp_scene* scene, const stp_texture_use* use)
{
    bool none = use->texture == STP_NONE;
    stp_hash texture = none ? (stp_hash){0} : scene->textures[use->texture].content;
    hash = stp_hash_bytes(hash, &texture, sizeof(texture));
    if (none) {
        return hash; // without a texture, its transform does not matter
    }
    hash = stp_hash_bytes(hash, &use->texcoord, sizeof(use->texcoord));
    return hash_floats(hash, &use->transform[0][0], 6);
}

stp_hash stp_material_hash(const stp_scene* scene, const stp_material* material)
{
    bool masked = material->alpha_mode == STP_ALPHA_MASK;
    uint32_t head[] = {KIND_MATERIAL, (uint32_t)material->alpha_mode, material->double_sided,
                       material->unlit};
    float numbers[] = {
        material->base_color[0], material->base_color[1],
        material->base_color[2], material->base_color[3],
        material->metallic,      material->roughness,
        material->emissive[0],   material->emissive[1],
        material->emissive[2],   masked ? material->alpha_cutoff : 0.0f,
    };
    head[2] |= material->front_only ? 2u : 0u;
    stp_hash hash = stp_hash_bytes((stp_hash){0}, head, sizeof(head));
    hash = hash_floats(hash, numbers, sizeof(numbers) / sizeof(numbers[0]));
    hash = hash_texture_use(hash, scene, &material->base_color_texture);
    hash = hash_texture_use(hash, scene, &material->metallic_roughness_texture);
    hash = hash_texture_use(hash, scene, &material->emissive_texture);
    if (material->normal_texture.texture != STP_NONE) { // materials without one keep their hash
        hash = hash_texture_use(hash, scene, &material->normal_texture);
        hash = hash_floats(hash, &material->normal_scale, 1);
    }
    return hash;
}

// Hashed record of a part or an edge; no padding.
typedef struct part_record {
    uint64_t kind;
    stp_hash geometry, material;
} part_record;

typedef struct edge_record {
    stp_hash child;
    double transform[3][4];
} edge_record;

stp_hash stp_node_hash(const stp_scene* scene, const stp_node* node)
{
    uint32_t head[] = {KIND_NODE, node->edge_count, node->part_count, node->flags};
    assert(node->first_part + (size_t)node->part_count <= scene->node_part_count);
    assert(node->first_edge + (size_t)node->edge_count <= scene->edge_count);
    stp_hash hash = stp_hash_bytes((stp_hash){0}, head, sizeof(head));
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_part part = scene->node_parts[node->first_part + i];
        bool is_mesh = part.kind == STP_PART_MESH;
        const stp_mesh* mesh = is_mesh ? &scene->meshes[part.index] : NULL;
        const stp_point_set* points = is_mesh ? NULL : &scene->point_sets[part.index];
        uint32_t material = is_mesh ? mesh->material : points->material;
        part_record record = {.kind = (uint64_t)part.kind,
                              .geometry = is_mesh ? mesh->content : points->content,
                              .material = scene->materials[material].content};
        hash = stp_hash_bytes(hash, &record, sizeof(record));
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_edge* edge = &scene->edges[node->first_edge + i];
        assert(edge->node < scene->node_count && "children are made before their parents");
        edge_record record = {.child = scene->nodes[edge->node].content};
        for (int k = 0; k < 12; ++k) {
            record.transform[k / 4][k % 4] = edge->transform.m[k / 4][k % 4] + 0.0; // no -0
        }
        hash = stp_hash_bytes(hash, &record, sizeof(record));
    }
    return hash;
}
