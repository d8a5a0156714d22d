// SPDX-License-Identifier: MIT
#include "store/file/content_sizes.h"

#include "store/file/block_table.h"

#include <assert.h>

static stp_result create_sizes(stp_context* context, const stp_store_directory* directory,
                               stp_store_sizes* sizes)
{
    *sizes = (stp_store_sizes){.directory = directory};
    sizes->meshes = STP_NEW_ZEROED(context, stp_store_amount, (size_t)directory->mesh_count + 1);
    sizes->point_sets =
        STP_NEW_ZEROED(context, stp_store_amount, (size_t)directory->point_set_count + 1);
    sizes->textures =
        STP_NEW_ZEROED(context, stp_store_amount, (size_t)directory->texture_count + 1);
    sizes->sets = STP_NEW_ZEROED(context, stp_store_amount, (size_t)directory->set_count + 1);
    if (sizes->meshes == NULL || sizes->point_sets == NULL || sizes->textures == NULL ||
        sizes->sets == NULL) {
        stp_store_sizes_destroy(context, sizes);
        return stp_fail_memory(context);
    }
    return STP_OK;
}

void stp_store_sizes_destroy(stp_context* context, stp_store_sizes* sizes)
{
    stp_free(context, sizes->meshes);
    stp_free(context, sizes->point_sets);
    stp_free(context, sizes->textures);
    stp_free(context, sizes->sets);
    *sizes = (stp_store_sizes){0};
}

static void add_octaves(const stp_store_block* blocks, uint32_t count, stp_store_amount* sets)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (blocks[i].kind == STP_BLOCK_SPLATS) {
            sets[blocks[i].owner].bytes += blocks[i].size;
        }
    }
}

static stp_store_amount amount_of_texture(const stp_store_texture* texture,
                                          const stp_store_block* block)
{
    assert(block->kind == STP_BLOCK_TEXTURE);
    return (stp_store_amount){.count = (uint64_t)texture->width * texture->height,
                              .bytes = block->size,
                              .owner = block->owner};
}

stp_result stp_store_sizes_of_file(const stp_store* store, stp_store_sizes* sizes)
{
    const stp_store_directory* directory = &store->directory;
    assert(!store->only_summary && "blocks are not read for a summary");
    const stp_store_mesh_record* meshes = store->tables[STP_SECTION_MESHES];
    const stp_store_point_record* point_sets = store->tables[STP_SECTION_POINT_SETS];
    const stp_store_texture_record* textures = store->tables[STP_SECTION_TEXTURES];
    stp_result result = create_sizes(store->context, directory, sizes);
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < directory->mesh_count; ++i) {
        sizes->meshes[i] = (stp_store_amount){
            .count = meshes[i].mesh.triangle_count,
            .bytes = stp_store_block_at(store, meshes[i].block)->size,
            .material = meshes[i].mesh.material,
        };
    }
    for (uint32_t i = 0; i < directory->point_set_count; ++i) {
        sizes->point_sets[i] = (stp_store_amount){
            .count = point_sets[i].points.point_count,
            .bytes = point_sets[i].points.held_by == 0
                         ? stp_store_block_at(store, point_sets[i].block)->size
                         : 0,
            .material = point_sets[i].points.material,
        };
    }
    for (uint32_t i = 0; i < directory->texture_count; ++i) {
        sizes->textures[i] =
            amount_of_texture(&textures[i].texture, stp_store_block_at(store, textures[i].block));
        assert(sizes->textures[i].owner <= i && "the first texture with a block owns it");
    }
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        sizes->sets[i].count = stp_store_describe_splat_set(store, i)->count;
    }
    add_octaves(store->tables[STP_SECTION_BLOCKS], store->counts[STP_SECTION_BLOCKS], sizes->sets);
    return STP_OK;
}

stp_result stp_store_sizes_of_plan(stp_context* context, const stp_store_content* content,
                                   const stp_store_plan* plan, stp_store_sizes* sizes)
{
    const stp_store_directory* directory = &content->directory;
    stp_result result = create_sizes(context, directory, sizes);
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < directory->mesh_count; ++i) {
        const stp_coded_mesh* coded = stp_store_coded_mesh(content, i);
        sizes->meshes[i] = (stp_store_amount){
            .count = coded != NULL ? coded->triangle_count : content->meshes[i].triangle_count,
            .bytes = plan->blocks[plan->mesh_blocks[i]].size,
            .material = content->meshes[i].material,
        };
    }
    for (uint32_t i = 0; i < directory->point_set_count; ++i) {
        sizes->point_sets[i] = (stp_store_amount){
            .count = content->point_sets[i].point_count,
            .bytes =
                content->point_sets[i].held_by == 0 ? plan->blocks[plan->point_blocks[i]].size : 0,
            .material = content->point_sets[i].material,
        };
    }
    for (uint32_t i = 0; i < directory->texture_count; ++i) {
        sizes->textures[i] =
            amount_of_texture(&content->textures[i], &plan->blocks[plan->texture_blocks[i]]);
        assert(sizes->textures[i].owner <= i && "the first texture with a block owns it");
    }
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        sizes->sets[i].count = content->sets[i].count;
    }
    add_octaves(plan->blocks, plan->block_count, sizes->sets);
    return STP_OK;
}

// Number of children of an object, and the last of them.
typedef struct below {
    uint32_t count, last;
} below;

// Whether an object only places other objects and has no content itself.
static bool is_place(const stp_store_directory* directory, uint32_t object, const below* children)
{
    assert(directory->objects[object].node != STP_STORE_NONE);
    return directory->nodes[directory->objects[object].node].part_count == 0 &&
           children[object].count != 0;
}

// The object whose children are the parts; STP_STORE_NONE: the top-level objects are.
static uint32_t find_place(const stp_store_directory* directory, below* children)
{
    below roots = {0, STP_STORE_NONE};
    for (uint32_t i = 0; i < directory->object_count; ++i) {
        const stp_store_object* object = &directory->objects[i];
        assert(object->parent == STP_STORE_NONE || object->parent < i);
        below* parent = object->parent != STP_STORE_NONE ? &children[object->parent] : &roots;
        if (object->node != STP_STORE_NONE) {
            *parent = (below){parent->count + 1, i};
        }
    }
    uint32_t place = STP_STORE_NONE;
    for (below at = roots; at.count == 1 && is_place(directory, at.last, children);) {
        place = at.last;
        at = children[place];
    }
    return place;
}

stp_result stp_store_guess_census(stp_context* context, const stp_store_directory* directory,
                                  stp_store_census* census)
{
    *census = (stp_store_census){0};
    size_t count = directory->object_count;
    below* children = STP_NEW_ZEROED(context, below, count + 1);
    stp_store_census_candidate* candidates =
        STP_NEW_ARRAY(context, stp_store_census_candidate, count + 1);
    stp_result result = STP_OK;
    if (children == NULL || candidates == NULL) {
        result = stp_fail_memory(context);
    } else {
        uint32_t place = find_place(directory, children);
        size_t found = 0;
        for (uint32_t i = 0; i < directory->object_count; ++i) {
            const stp_store_object* object = &directory->objects[i];
            if (object->parent == place && object->node != STP_STORE_NONE) {
                candidates[found++] = (stp_store_census_candidate){
                    .object = i,
                    .triangles = directory->nodes[object->node].triangle_count,
                    .name = object->name,
                };
            }
        }
        result = stp_store_census_create(context, candidates, found, census);
    }
    stp_free(context, candidates);
    stp_free(context, children);
    return result;
}
