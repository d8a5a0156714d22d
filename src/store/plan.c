// SPDX-License-Identifier: MIT
#include "store/plan.h"

#include "store/columns.h"
#include "store/pictures.h"

#include <stdlib.h>

const stp_coded_mesh* stp_store_coded_mesh(const stp_store_content* content, uint32_t index)
{
    const stp_coded_mesh* coded = content->coded_meshes;
    return coded != NULL && coded[index].bytes != NULL ? &coded[index] : NULL;
}

uint32_t stp_store_mesh_present(const stp_store_mesh* mesh)
{
    return (mesh->normals != NULL ? (uint32_t)STP_COLUMN_NORMALS : 0) |
           (mesh->colors != NULL ? (uint32_t)STP_COLUMN_COLORS : 0) |
           (mesh->texcoords[0] != NULL ? (uint32_t)STP_COLUMN_TEXCOORDS_0 : 0) |
           (mesh->texcoords[1] != NULL ? (uint32_t)STP_COLUMN_TEXCOORDS_1 : 0);
}

uint32_t stp_store_points_present(const stp_store_point_set* points)
{
    return (points->normals != NULL ? (uint32_t)STP_COLUMN_NORMALS : 0) |
           (points->colors != NULL ? (uint32_t)STP_COLUMN_COLORS : 0);
}

// How much longer a transform can make a length: exact for rotations with scales along the axes.
static double largest_scale(const stp_affine* transform)
{
    double largest = 0.0;
    for (int c = 0; c < 3; ++c) {
        double x = transform->m[0][c], y = transform->m[1][c], z = transform->m[2][c];
        double squared = x * x + y * y + z * z;
        largest = squared > largest ? squared : largest;
    }
    return sqrt(largest);
}

// For each set the largest scale at which the scene shows it; sets that it does not show stay at 0.
static stp_result measure_scales(stp_context* context, const stp_store_directory* directory,
                                 double* set_scales)
{
    double* scales = STP_NEW_ZEROED(context, double, directory->node_count);
    if (scales == NULL && directory->node_count != 0) {
        return stp_fail_memory(context);
    }
    if (directory->root != STP_STORE_NONE) {
        scales[directory->root] = 1.0;
    }
    for (uint32_t i = directory->node_count; i-- > 0;) { // parents before their children
        const stp_store_node* node = &directory->nodes[i];
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const stp_store_edge* edge = &directory->edges[node->first_edge + k];
            double scale = scales[i] * largest_scale(&edge->transform);
            scales[edge->node] = scale > scales[edge->node] ? scale : scales[edge->node];
        }
        if (node->surfels != STP_STORE_NONE && scales[i] > set_scales[node->surfels]) {
            set_scales[node->surfels] = scales[i];
        }
    }
    stp_free(context, scales);
    return STP_OK;
}

// To what the first `count` surfels cover: the last breakpoint at or before; 0 where there is no
// table.
static float radius_reached(const stp_prefix_table* table, uint32_t count)
{
    float radius = table->size != 0 ? table->radius[0] : 0.0f;
    for (uint32_t i = 0; i < table->size && table->count[i] <= count; ++i) {
        radius = table->radius[i];
    }
    return radius;
}

static float scale_radius(float radius, double scale)
{
    double scaled = (double)radius * scale;
    return scaled < (double)FLT_MAX ? (float)scaled : FLT_MAX;
}

// Adds the blocks of all owners, in no order yet.
static void add_blocks(const stp_store_content* content, const double* set_scales,
                       const uint32_t* texture_owners, stp_store_plan* plan)
{
    const stp_store_directory* directory = &content->directory;
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_block* next = plan->blocks;
    for (uint32_t i = 0; i < directory->surfels_count; ++i) {
        const stp_surfels* surfels = &content->surfels[i];
        for (uint32_t k = 0; k < surfels->octave_count; ++k) {
            float radius = radius_reached(&surfels->table, surfels->octave_ends[k]);
            *next++ = (stp_store_block){
                .kind = STP_BLOCK_SURFELS,
                .owner = i,
                .octave = k,
                .size = stp_store_surfel_columns(surfels, k, columns),
                .radius = scale_radius(radius, set_scales[i]),
            };
        }
    }
    for (uint32_t i = 0; i < directory->mesh_count; ++i) {
        const stp_store_mesh* mesh = &content->meshes[i];
        const stp_coded_mesh* coded = stp_store_coded_mesh(content, i);
        if (coded != NULL) {
            *next++ =
                (stp_store_block){.kind = STP_BLOCK_CLUSTERS, .owner = i, .size = coded->size};
            continue;
        }
        *next++ = (stp_store_block){
            .kind = STP_BLOCK_MESH,
            .owner = i,
            .size = stp_store_mesh_columns(mesh->vertex_count, mesh->triangle_count,
                                           stp_store_mesh_present(mesh), columns),
        };
    }
    for (uint32_t i = 0; i < directory->point_set_count; ++i) {
        const stp_store_point_set* points = &content->point_sets[i];
        *next++ = (stp_store_block){
            .kind = STP_BLOCK_POINT_SET,
            .owner = i,
            .size = stp_store_point_columns(points->point_count, stp_store_points_present(points),
                                            columns),
        };
    }
    for (uint32_t i = 0; i < directory->texture_count; ++i) {
        const stp_store_texture* texture = &content->textures[i];
        bool is_picture = texture->encoded != NULL;
        if (texture_owners[i] != i) {
            continue;
        }
        *next++ = (stp_store_block){
            .kind = STP_BLOCK_TEXTURE,
            .owner = i,
            .size =
                is_picture ? texture->encoded_size : 4 * (uint64_t)texture->width * texture->height,
            .encoding = is_picture ? texture->encoding : 0,
        };
    }
    plan->block_count = (uint32_t)(next - plan->blocks);
}

// Surfels first, then textures, meshes and point sets.
static int rank_of(uint32_t kind)
{
    switch (kind) {
    case STP_BLOCK_SURFELS:
        return 0;
    case STP_BLOCK_TEXTURE:
        return 1;
    case STP_BLOCK_MESH:
    case STP_BLOCK_CLUSTERS:
        return 2;
    default:
        return 3;
    }
}

// A total order: the radius reached, coarse first; then kind, octave and owner.
static int compare_blocks(const void* left, const void* right)
{
    const stp_store_block* a = left;
    const stp_store_block* b = right;
    if (rank_of(a->kind) != rank_of(b->kind)) {
        return rank_of(a->kind) < rank_of(b->kind) ? -1 : 1;
    }
    if (a->radius > b->radius || a->radius < b->radius) {
        return a->radius > b->radius ? -1 : 1;
    }
    if (a->octave != b->octave) {
        return a->octave < b->octave ? -1 : 1;
    }
    return a->owner < b->owner ? -1 : a->owner > b->owner ? 1 : 0;
}

// Gives blocks their offsets, and owners their blocks.
static void place_blocks(uint64_t data_offset, const uint32_t* first_octaves, stp_store_plan* plan)
{
    uint64_t end = data_offset;
    for (uint32_t i = 0; i < plan->block_count; ++i) {
        stp_store_block* block = &plan->blocks[i];
        block->offset = stp_store_align(end, STP_STORE_ALIGNMENT);
        end = block->offset + block->size;
        switch (block->kind) {
        case STP_BLOCK_SURFELS:
            plan->octave_blocks[first_octaves[block->owner] + block->octave] = i;
            break;
        case STP_BLOCK_MESH:
        case STP_BLOCK_CLUSTERS:
            plan->mesh_blocks[block->owner] = i;
            break;
        case STP_BLOCK_POINT_SET:
            plan->point_blocks[block->owner] = i;
            break;
        default:
            plan->texture_blocks[block->owner] = i;
            break;
        }
    }
    plan->file_bytes = end;
}

static stp_result plan_blocks(stp_context* context, const stp_store_content* content,
                              uint64_t data_offset, uint32_t* first_octaves, double* set_scales,
                              uint32_t* texture_owners, stp_store_plan* plan)
{
    const stp_store_directory* directory = &content->directory;
    uint64_t octaves = 0;
    for (uint32_t i = 0; i < directory->surfels_count; ++i) {
        first_octaves[i] = (uint32_t)octaves;
        octaves += content->surfels[i].octave_count;
    }
    uint64_t blocks =
        octaves + directory->mesh_count + directory->point_set_count + directory->texture_count;
    if (blocks >= STP_STORE_NONE) {
        return stp_fail(context, STP_ERROR_LIMIT, "a file cannot hold %llu blocks of data",
                        (unsigned long long)blocks);
    }
    plan->block_count = (uint32_t)blocks;
    plan->blocks = STP_NEW_ARRAY(context, stp_store_block, plan->block_count + 1);
    plan->mesh_blocks = STP_NEW_ARRAY(context, uint32_t, directory->mesh_count + 1);
    plan->point_blocks = STP_NEW_ARRAY(context, uint32_t, directory->point_set_count + 1);
    plan->texture_blocks = STP_NEW_ARRAY(context, uint32_t, directory->texture_count + 1);
    plan->octave_blocks = STP_NEW_ARRAY(context, uint32_t, octaves + 1);
    if (plan->blocks == NULL || plan->mesh_blocks == NULL || plan->point_blocks == NULL ||
        plan->texture_blocks == NULL || plan->octave_blocks == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = stp_store_find_texture_owners(context, content, texture_owners);
    result = result == STP_OK ? measure_scales(context, directory, set_scales) : result;
    if (result == STP_OK) {
        add_blocks(content, set_scales, texture_owners, plan);
        qsort(plan->blocks, plan->block_count, sizeof(plan->blocks[0]), compare_blocks);
        place_blocks(data_offset, first_octaves, plan);
        for (uint32_t i = 0; i < directory->texture_count; ++i) {
            plan->texture_blocks[i] = plan->texture_blocks[texture_owners[i]];
        }
    }
    return result;
}

stp_result stp_store_plan_make(stp_context* context, const stp_store_content* content,
                               uint64_t data_offset, stp_store_plan* plan)
{
    *plan = (stp_store_plan){0};
    uint32_t set_count = content->directory.surfels_count;
    uint32_t* first_octaves = STP_NEW_ZEROED(context, uint32_t, (size_t)set_count + 1);
    double* set_scales = STP_NEW_ZEROED(context, double, (size_t)set_count + 1);
    uint32_t* texture_owners =
        STP_NEW_ARRAY(context, uint32_t, (size_t)content->directory.texture_count + 1);
    stp_result result = STP_OK;
    if (first_octaves == NULL || set_scales == NULL || texture_owners == NULL) {
        result = stp_fail_memory(context);
    } else {
        result = plan_blocks(context, content, data_offset, first_octaves, set_scales,
                             texture_owners, plan);
    }
    stp_free(context, texture_owners);
    stp_free(context, set_scales);
    stp_free(context, first_octaves);
    if (result != STP_OK) {
        stp_store_plan_destroy(context, plan);
    }
    return result;
}

void stp_store_plan_destroy(stp_context* context, stp_store_plan* plan)
{
    stp_free(context, plan->blocks);
    stp_free(context, plan->mesh_blocks);
    stp_free(context, plan->point_blocks);
    stp_free(context, plan->texture_blocks);
    stp_free(context, plan->octave_blocks);
    *plan = (stp_store_plan){0};
}
