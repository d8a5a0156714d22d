// SPDX-License-Identifier: MIT
#include "store/file/block_order.h"

#include "store/bytes/columns.h"
#include "store/file/texture_images.h"

#include <assert.h>
#include <float.h>
#include <math.h>
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

static uint32_t points_attributes(const stp_store_point_set* points)
{
    uint32_t mask = 0;
    for (uint32_t i = 0; i < STP_ATTRIBUTES && points->held_by == 0; ++i) {
        bool there = points->attributes[i] != NULL && points->point_count != 0;
        mask |= there ? stp_attribute_bit((stp_attribute)i) : 0;
    }
    return mask;
}

uint32_t stp_store_planned_attributes(const stp_store_content* content,
                                      const stp_store_block* block)
{
    assert(block->kind == STP_BLOCK_ATTRIBUTES || block->kind == STP_BLOCK_POINT_ATTRIBUTES);
    return block->kind == STP_BLOCK_ATTRIBUTES
               ? stp_splats_attributes(&content->sets[block->owner])
               : points_attributes(&content->point_sets[block->owner]);
}

// Largest factor by which a transform scales a length: exact for rotations with scales along the
// axes.
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

// How the scene uses its content.
typedef struct shown {
    double* set_scales; ///< per set: largest scale at which it appears; 0: never
    double* mesh_areas; ///< per mesh: area of all its copies, in square units of the scene
} shown;

static void destroy_shown(stp_context* context, shown* s)
{
    stp_free(context, s->set_scales);
    stp_free(context, s->mesh_areas);
    *s = (shown){0};
}

// Per node: the largest scale at which the scene shows it, and the factor on areas of all its
// copies together.
typedef struct shown_node {
    double scale, areas;
} shown_node;

static void add_node(const stp_store_content* content, uint32_t index, shown_node* nodes, shown* s)
{
    const stp_store_directory* directory = &content->directory;
    const stp_store_node* node = &directory->nodes[index];
    shown_node at = nodes[index];
    for (uint32_t k = 0; k < node->edge_count; ++k) {
        const stp_store_edge* edge = &directory->edges[node->first_edge + k];
        assert(edge->node < index && "the walk meets parents before children");
        shown_node* child = &nodes[edge->node];
        double larger = largest_scale(&edge->transform);
        child->scale = fmax(child->scale, at.scale * larger);
        child->areas =
            fmin(child->areas + at.areas * stp_affine_area_scale(&edge->transform), DBL_MAX);
    }
    for (uint32_t m = 0; m == 0 || m < directory->method_count; ++m) {
        uint32_t set = stp_store_set_of(directory, m, index);
        if (set != STP_STORE_NONE) {
            assert(set < directory->set_count);
            s->set_scales[set] = fmax(s->set_scales[set], at.scale);
        }
    }
    for (uint32_t k = 0; k < node->part_count; ++k) {
        const stp_store_part* part = &directory->parts[node->first_part + k];
        if (part->kind == STP_STORE_PART_MESH) {
            double area = at.areas * content->meshes[part->index].area;
            s->mesh_areas[part->index] = fmin(s->mesh_areas[part->index] + area, DBL_MAX);
        }
    }
}

static stp_result measure_shown(stp_context* context, const stp_store_content* content, shown* s)
{
    const stp_store_directory* directory = &content->directory;
    *s = (shown){
        .set_scales = STP_NEW_ZEROED(context, double, (size_t)directory->set_count + 1),
        .mesh_areas = STP_NEW_ZEROED(context, double, (size_t)directory->mesh_count + 1),
    };
    shown_node* nodes = STP_NEW_ZEROED(context, shown_node, (size_t)directory->node_count + 1);
    bool made = s->set_scales != NULL && s->mesh_areas != NULL && nodes != NULL;
    if (made && directory->root != STP_STORE_NONE) {
        nodes[directory->root] = (shown_node){1.0, 1.0};
    }
    for (uint32_t i = directory->node_count; made && i-- > 0;) { // parents before children
        add_node(content, i, nodes, s);
    }
    for (uint32_t i = 0; made && i < directory->level_count; ++i) {
        uint32_t mesh = stp_store_first_level_mesh(directory) + i;
        assert(directory->levels[i].node < directory->node_count);
        double area = nodes[directory->levels[i].node].areas * content->meshes[mesh].area;
        s->mesh_areas[mesh] = fmin(area, DBL_MAX);
    }
    stp_free(context, nodes);
    return made ? STP_OK : stp_fail_memory(context);
}

// The radius that the first `count` splats cover: from the last breakpoint at or before; 0 without
// a table.
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

// A block to be placed. Within its kind, larger values come first.
typedef struct valued_block {
    stp_store_block block;
    double value;
} valued_block;

// Splats: the radius that they cover, so that coarse octaves come first.
static valued_block value_octave(const stp_store_content* content, uint32_t set, uint32_t octave,
                                 double scale)
{
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    const stp_splats* splats = &content->sets[set];
    assert(octave < splats->octave_count);
    float radius = radius_reached(&splats->table, splats->octave_ends[octave]);
    stp_store_block block = {
        .kind = STP_BLOCK_SPLATS,
        .owner = set,
        .octave = octave,
        .size = stp_store_octave_columns(splats, octave, columns),
        .radius = scale_radius(radius, scale),
    };
    return (valued_block){block, (double)block.radius};
}

// Leaves follow the first octave that ends with at least as many splats as leaves: before that, few
// leaves have any splat.
static valued_block value_leaves(const stp_store_content* content, uint32_t set, double scale)
{
    const stp_splats* splats = &content->sets[set];
    assert(splats->octave_count != 0 && "only splats have leaves");
    uint32_t octave = 0;
    while (octave + 1 < splats->octave_count && splats->octave_ends[octave] < splats->leaf_count) {
        octave += 1;
    }
    valued_block with = value_octave(content, set, octave, scale);
    with.block.kind = STP_BLOCK_LEAVES;
    with.block.octave = 0;
    with.block.size = STP_STORE_LEAF_BYTES * (uint64_t)splats->leaf_count;
    return with;
}

// Meshes: area shown per byte. Walls, floors and large beams precede screws.
static valued_block value_mesh(const stp_store_content* content, uint32_t index, double area)
{
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    const stp_store_mesh* mesh = &content->meshes[index];
    const stp_coded_mesh* coded = stp_store_coded_mesh(content, index);
    stp_store_block block = {.kind = STP_BLOCK_CLUSTERS, .owner = index};
    if (coded != NULL) {
        block.size = coded->size;
    } else {
        block.kind = STP_BLOCK_MESH;
        block.size = stp_store_mesh_columns(mesh->vertex_count, mesh->triangle_count,
                                            stp_store_mesh_present(mesh), columns);
    }
    return (valued_block){block, area / fmax((double)block.size, 1.0)};
}

static valued_block value_points(const stp_store_content* content, uint32_t index)
{
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    const stp_store_point_set* points = &content->point_sets[index];
    stp_store_block block = {
        .kind = STP_BLOCK_POINT_SET,
        .owner = index,
        .size =
            stp_store_point_columns(points->point_count, stp_store_points_present(points), columns),
    };
    return (valued_block){block, 0.0};
}

static valued_block value_texture(const stp_store_content* content, uint32_t index)
{
    const stp_store_texture* texture = &content->textures[index];
    bool is_picture = texture->encoded != NULL;
    stp_store_block block = {
        .kind = STP_BLOCK_TEXTURE,
        .owner = index,
        .size = is_picture ? texture->encoded_size : 4 * (uint64_t)texture->width * texture->height,
        .encoding = is_picture ? texture->encoding : 0,
    };
    return (valued_block){block, 0.0};
}

// Attributes of an octave: sorted by its radius, which is not stored.
static valued_block value_octave_attributes(const stp_store_content* content, uint32_t set,
                                            uint32_t octave, double scale)
{
    valued_block made = value_octave(content, set, octave, scale);
    made.block = (stp_store_block){.kind = STP_BLOCK_ATTRIBUTES, .owner = set, .octave = octave};
    return made;
}

// Number of attribute blocks.
static uint64_t count_attribute_blocks(const stp_store_content* content)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < content->directory.set_count; ++i) {
        const stp_splats* set = &content->sets[i];
        count += stp_splats_attributes(set) != 0 ? set->octave_count : 0;
    }
    for (uint32_t i = 0; i < content->directory.point_set_count; ++i) {
        count += points_attributes(&content->point_sets[i]) != 0 ? 1 : 0;
    }
    return count;
}

// Point sets that no set of splats holds.
static uint64_t count_point_blocks(const stp_store_content* content)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < content->directory.point_set_count; ++i) {
        count += content->point_sets[i].held_by == 0 ? 1 : 0;
    }
    return count;
}

// Collects the blocks of all owners, unsorted. @return their number
static uint32_t add_blocks(const stp_store_content* content, const shown* s,
                           const uint32_t* texture_owners, valued_block* blocks)
{
    const stp_store_directory* directory = &content->directory;
    valued_block* next = blocks;
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        for (uint32_t k = 0; k < content->sets[i].octave_count; ++k) {
            *next++ = value_octave(content, i, k, s->set_scales[i]);
            if (stp_splats_attributes(&content->sets[i]) != 0) {
                *next++ = value_octave_attributes(content, i, k, s->set_scales[i]);
            }
        }
        if (content->sets[i].leaf_count > 0) {
            *next++ = value_leaves(content, i, s->set_scales[i]);
        }
    }
    for (uint32_t i = 0; i < directory->mesh_count; ++i) {
        *next++ = value_mesh(content, i, s->mesh_areas[i]);
    }
    for (uint32_t i = 0; i < directory->point_set_count; ++i) {
        if (content->point_sets[i].held_by == 0) {
            *next++ = value_points(content, i);
        }
        if (points_attributes(&content->point_sets[i]) != 0) {
            *next++ = (valued_block){{.kind = STP_BLOCK_POINT_ATTRIBUTES, .owner = i}, 0.0};
        }
    }
    for (uint32_t i = 0; i < directory->texture_count; ++i) {
        if (texture_owners[i] == i) {
            *next++ = value_texture(content, i);
        }
    }
    return (uint32_t)(next - blocks);
}

// Splats first, then their attributes, textures, meshes, point sets and their attributes.
static int rank_of(uint32_t kind)
{
    switch (kind) {
    case STP_BLOCK_SPLATS:
    case STP_BLOCK_LEAVES:
        return 0;
    case STP_BLOCK_ATTRIBUTES:
        return 1;
    case STP_BLOCK_TEXTURE:
        return 2;
    case STP_BLOCK_MESH:
    case STP_BLOCK_CLUSTERS:
        return 3;
    case STP_BLOCK_POINT_SET:
        return 4;
    default:
        return 5;
    }
}

// A total order: kind, then value, leaves after octaves, then octave and owner.
static int compare_blocks(const void* left, const void* right)
{
    const valued_block* a = left;
    const valued_block* b = right;
    if (rank_of(a->block.kind) != rank_of(b->block.kind)) {
        return rank_of(a->block.kind) < rank_of(b->block.kind) ? -1 : 1;
    }
    if (a->value > b->value || a->value < b->value) {
        return a->value > b->value ? -1 : 1;
    }
    if (rank_of(a->block.kind) == 0 && a->block.kind != b->block.kind) { // leaves after octaves
        return a->block.kind < b->block.kind ? -1 : 1;
    }
    if (a->block.octave != b->block.octave) {
        return a->block.octave < b->block.octave ? -1 : 1;
    }
    return a->block.owner < b->block.owner ? -1 : a->block.owner > b->block.owner ? 1 : 0;
}

#ifndef NDEBUG
static bool are_ordered(const valued_block* blocks, uint32_t count)
{
    for (uint32_t i = 1; i < count; ++i) {
        if (compare_blocks(&blocks[i - 1], &blocks[i]) >= 0) {
            return false;
        }
    }
    return true;
}
#endif

// Puts the blocks of all owners into the plan, in file order.
static stp_result order_blocks(stp_context* context, const stp_store_content* content,
                               const shown* s, const uint32_t* texture_owners, stp_store_plan* plan)
{
    valued_block* blocks = STP_NEW_ARRAY(context, valued_block, (size_t)plan->block_count + 1);
    if (blocks == NULL) {
        return stp_fail_memory(context);
    }
    uint32_t planned = plan->block_count;
    plan->block_count = add_blocks(content, s, texture_owners, blocks);
    assert(plan->block_count <= planned);
    (void)planned;
    qsort(blocks, plan->block_count, sizeof(blocks[0]), compare_blocks);
    assert(are_ordered(blocks, plan->block_count) && "the order is total");
    for (uint32_t i = 0; i < plan->block_count; ++i) {
        plan->blocks[i] = blocks[i].block;
    }
    stp_free(context, blocks);
    return STP_OK;
}

// Assigns offsets to blocks, and blocks to owners.
static void place_blocks(uint64_t data_offset, const uint32_t* first_octaves, stp_store_plan* plan)
{
    uint64_t end = data_offset;
    for (uint32_t i = 0; i < plan->block_count; ++i) {
        stp_store_block* block = &plan->blocks[i];
        assert((i == 0 || block->radius <= block[-1].radius) && "the reader refuses other orders");
        block->offset = stp_store_align(end, STP_STORE_ALIGNMENT);
        end = block->offset + block->size;
        switch (block->kind) {
        case STP_BLOCK_SPLATS:
            plan->octave_blocks[first_octaves[block->owner] + block->octave] = i;
            break;
        case STP_BLOCK_LEAVES:
            plan->leaf_blocks[block->owner] = i;
            break;
        case STP_BLOCK_MESH:
        case STP_BLOCK_CLUSTERS:
            plan->mesh_blocks[block->owner] = i;
            break;
        case STP_BLOCK_POINT_SET:
            plan->point_blocks[block->owner] = i;
            break;
        case STP_BLOCK_ATTRIBUTES:
        case STP_BLOCK_POINT_ATTRIBUTES:
            break;
        default:
            plan->texture_blocks[block->owner] = i;
            break;
        }
    }
    plan->file_bytes = end;
}

static stp_result plan_blocks(stp_context* context, const stp_store_content* content,
                              uint64_t data_offset, uint32_t* first_octaves,
                              uint32_t* texture_owners, stp_store_plan* plan)
{
    const stp_store_directory* directory = &content->directory;
    uint64_t octaves = 0, leaf_tables = 0;
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        first_octaves[i] = (uint32_t)octaves;
        octaves += content->sets[i].octave_count;
        leaf_tables += content->sets[i].leaf_count > 0 ? 1 : 0;
    }
    uint64_t attributes = count_attribute_blocks(content);
    uint64_t blocks = octaves + leaf_tables + directory->mesh_count + count_point_blocks(content) +
                      directory->texture_count + attributes;
    if (blocks >= STP_STORE_NONE) {
        return stp_fail(context, STP_ERROR_LIMIT, "a file cannot hold %llu blocks of data",
                        (unsigned long long)blocks);
    }
    plan->block_count = (uint32_t)blocks;
    plan->attribute_count = (uint32_t)attributes;
    plan->blocks = STP_NEW_ARRAY(context, stp_store_block, plan->block_count + 1);
    plan->mesh_blocks = STP_NEW_ARRAY(context, uint32_t, directory->mesh_count + 1);
    plan->point_blocks = STP_NEW_ARRAY(context, uint32_t, directory->point_set_count + 1);
    plan->texture_blocks = STP_NEW_ARRAY(context, uint32_t, directory->texture_count + 1);
    plan->octave_blocks = STP_NEW_ARRAY(context, uint32_t, octaves + 1);
    plan->leaf_blocks = STP_NEW_ARRAY(context, uint32_t, (size_t)directory->set_count + 1);
    if (plan->blocks == NULL || plan->mesh_blocks == NULL || plan->point_blocks == NULL ||
        plan->texture_blocks == NULL || plan->octave_blocks == NULL || plan->leaf_blocks == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        plan->leaf_blocks[i] = STP_STORE_NONE;
    }
    for (uint32_t i = 0; i < directory->point_set_count; ++i) {
        plan->point_blocks[i] = STP_STORE_NONE; // if a set of splats holds the points
    }
    stp_result result = stp_store_find_texture_owners(context, content, texture_owners);
    shown s = {0};
    result = result == STP_OK ? measure_shown(context, content, &s) : result;
    result = result == STP_OK ? order_blocks(context, content, &s, texture_owners, plan) : result;
    destroy_shown(context, &s);
    if (result == STP_OK) {
        place_blocks(data_offset, first_octaves, plan);
        for (uint32_t i = 0; i < directory->texture_count; ++i) {
            assert(texture_owners[i] <= i &&
                   texture_owners[texture_owners[i]] == texture_owners[i]);
            plan->texture_blocks[i] = plan->texture_blocks[texture_owners[i]];
        }
    }
    return result;
}

stp_result stp_store_plan_make(stp_context* context, const stp_store_content* content,
                               uint64_t data_offset, stp_store_plan* plan)
{
    *plan = (stp_store_plan){0};
    uint32_t set_count = content->directory.set_count;
    uint32_t* first_octaves = STP_NEW_ZEROED(context, uint32_t, (size_t)set_count + 1);
    uint32_t* texture_owners =
        STP_NEW_ARRAY(context, uint32_t, (size_t)content->directory.texture_count + 1);
    stp_result result = STP_OK;
    if (first_octaves == NULL || texture_owners == NULL) {
        result = stp_fail_memory(context);
    } else {
        result = plan_blocks(context, content, data_offset, first_octaves, texture_owners, plan);
    }
    stp_free(context, texture_owners);
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
    stp_free(context, plan->leaf_blocks);
    *plan = (stp_store_plan){0};
}
