// SPDX-License-Identifier: MIT
//
// Builds a new graph from the old one, children before parents. Each old node becomes a new one (or
// shares one), so that objects keep their nodes. The children of a new parent need not be its old
// children's nodes.
#include "scene/partition.h"

#include "scene/graph.h"
#include "scene/partition_steps.h"
#include "scene/strays.h"

#include <assert.h>

#define DEFAULT_LEAF 400000u
// Points of a piece have one spacing, so pieces are small where density may vary
// (docs/notes/2026-11-scan-spacing.md). Clouds of a few pieces stay whole.
#define DEFAULT_POINTS 25000u
#define DEFAULT_CLOUD 400000u
// A piece is oriented without the others, so it should be a whole surface.
#define DEFAULT_UNORIENTED 1000000u
#define DEFAULT_CHILDREN 16u
// Parts with fewer triangles or points get no approximation of their own (Brandt 5.2).
#define SMALL_PART 1000u
#define PROGRESS_NODES 4096u

// A part or a new node below the node being made, in that node's space.
typedef struct item {
    bool is_part;
    stp_part part;
    stp_edge edge;
} item;

typedef struct partition {
    stp_scene* scene;
    stp_partition_desc desc;
    stp_graph graph;
    stp_node* old_nodes;
    stp_edge* old_edges;
    stp_part* old_parts;
    size_t old_count;
    bool has_limit; ///< the caller gave the limit of pieces of point sets
    uint8_t*
        dissolved;  ///< per old edge: the parent absorbs the child's content (partition_steps.h)
    uint32_t* made; ///< per old node: the new one
    uint32_t* split_meshes; ///< per mesh: the node of its pieces; STP_NONE: not split
    uint32_t* split_points; ///< per point set, likewise
    item* items;            ///< items of the node being made
    stp_boxd* boxes;        ///< boxes of the items
    stp_edge* stack;        ///< old nodes whose content is absorbed
    stp_grouping grouping;  ///< hierarchy over the boxes
    item* results;          ///< node of each group
    size_t item_count, item_capacity, box_capacity, stack_count, stack_capacity, result_capacity;
} partition;

static bool is_moving(const stp_node* node)
{
    return (node->flags & STP_OBJECT_MOVING) != 0;
}

static stp_result add_item(partition* p, const item* added)
{
    stp_context* context = p->scene->context;
    if (p->item_count >= STP_NONE ||
        !STP_MAKE_ROOM(context, p->items, p->item_capacity, p->item_count + 1)) {
        return stp_fail_memory(context);
    }
    p->items[p->item_count++] = *added;
    return STP_OK;
}

// Adds a part as an item; if it was split, the node of its pieces.
static stp_result add_part_item(partition* p, stp_part part, const stp_affine* transform,
                                bool whole)
{
    const uint32_t* nodes = part.kind == STP_PART_MESH ? p->split_meshes : p->split_points;
    uint32_t node = whole ? STP_NONE : nodes[part.index];
    if (node == STP_NONE && !stp_affine_is_identity(transform)) { // parts have no transform
        size_t first_part = p->scene->node_part_count;
        stp_result result = stp_graph_add_part(&p->graph, part);
        if (result == STP_OK) {
            result = stp_graph_close_node(&p->graph, p->scene->edge_count, first_part, 0, &node);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    return add_item(p, &(item){.is_part = node == STP_NONE,
                               .part = part,
                               .edge = {.node = node, .transform = *transform}});
}

// Adds a new node as an item. Skips nodes that only transform another one.
static stp_result add_node_item(partition* p, uint32_t node, stp_affine transform)
{
    const stp_scene* scene = p->scene;
    assert(node < scene->node_count && "children are made first");
    const stp_node* n = &scene->nodes[node];
    while (n->edge_count == 1 && n->part_count == 0 && !is_moving(n)) {
        const stp_edge* edge = &scene->edges[n->first_edge];
        transform = stp_affine_multiply(transform, edge->transform);
        node = edge->node;
        n = &scene->nodes[node];
    }
    return add_item(p, &(item){.edge = {.node = node, .transform = transform}});
}

static stp_result push(partition* p, const stp_edge* edge)
{
    stp_context* context = p->scene->context;
    if (!STP_MAKE_ROOM(context, p->stack, p->stack_capacity, p->stack_count + 1)) {
        return stp_fail_memory(context);
    }
    p->stack[p->stack_count++] = *edge;
    return STP_OK;
}

// Collects the items of a new node: the old node's parts and children, and those of dissolved
// children.
static stp_result collect_items(partition* p, uint32_t index)
{
    p->item_count = 0;
    p->stack_count = 0;
    bool whole = is_moving(&p->old_nodes[index]);
    stp_result result = push(p, &(stp_edge){.node = index, .transform = stp_affine_identity()});
    while (result == STP_OK && p->stack_count > 0) {
        stp_edge at = p->stack[--p->stack_count];
        const stp_node* node = &p->old_nodes[at.node];
        for (uint32_t i = 0; result == STP_OK && i < node->part_count; ++i) {
            result = add_part_item(p, p->old_parts[node->first_part + i], &at.transform, whole);
        }
        for (uint32_t i = 0; result == STP_OK && i < node->edge_count; ++i) {
            stp_edge edge = p->old_edges[node->first_edge + i];
            uint8_t dissolved = p->dissolved[node->first_edge + i];
            edge.transform = stp_affine_multiply(at.transform, edge.transform);
            bool dissolves = dissolved == STP_DISSOLVED ||
                             (dissolved == STP_DISSOLVED_IN_ROOT && index == p->scene->root);
            result =
                dissolves ? push(p, &edge) : add_node_item(p, p->made[edge.node], edge.transform);
        }
    }
    return result;
}

static uint64_t count_elements(const partition* p, const item* i)
{
    const stp_scene* scene = p->scene;
    if (!i->is_part) {
        const stp_node* node = &scene->nodes[i->edge.node];
        return node->triangle_count + node->point_count;
    }
    return i->part.kind == STP_PART_MESH ? scene->meshes[i->part.index].triangle_count
                                         : scene->point_sets[i->part.index].point_count;
}

// Wraps a part in a separate node.
static stp_result wrap_part(partition* p, item* i)
{
    size_t first_part = p->scene->node_part_count;
    stp_result result = stp_graph_add_part(&p->graph, i->part);
    if (result == STP_OK) {
        result =
            stp_graph_close_node(&p->graph, p->scene->edge_count, first_part, 0, &i->edge.node);
    }
    assert(i->is_part && "wrapped once");
    i->edge.transform = stp_affine_identity();
    i->is_part = false;
    return result;
}

// Makes a node of the items with the indices order[0 .. count) (NULL: of the first `count`).
static stp_result make_node(partition* p, const uint32_t* order, item* items, uint32_t count,
                            uint32_t flags, item* made)
{
    assert(count > 0 && (count <= p->desc.child_count || (flags & STP_OBJECT_MOVING) != 0));
    stp_scene* scene = p->scene;
    uint64_t elements = 0;
    for (uint32_t i = 0; i < count; ++i) {
        elements += count_elements(p, &items[order != NULL ? order[i] : i]);
    }
    // in an inner node, a part large enough gets a node, and so an approximation, of its own;
    // points always do
    bool wraps = elements > p->desc.leaf_triangles;
    bool moving = (flags & STP_OBJECT_MOVING) != 0;
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && !moving && count > 1 && i < count; ++i) {
        item* it = &items[order != NULL ? order[i] : i];
        bool points = it->part.kind == STP_PART_POINTS;
        if (it->is_part && (points || (wraps && count_elements(p, it) > SMALL_PART))) {
            result = wrap_part(p, it);
        }
    }
    size_t first_edge = scene->edge_count, first_part = scene->node_part_count;
    for (uint32_t i = 0; result == STP_OK && i < count; ++i) {
        const item* it = &items[order != NULL ? order[i] : i];
        result = it->is_part ? stp_graph_add_part(&p->graph, it->part)
                             : stp_graph_add_edge(&p->graph, it->edge.node, &it->edge.transform);
    }
    *made = (item){.edge = {.transform = stp_affine_identity()}};
    if (result == STP_OK) {
        result = stp_graph_close_node(&p->graph, first_edge, first_part, flags, &made->edge.node);
    }
    return result;
}

static stp_result box_items(partition* p)
{
    stp_context* context = p->scene->context;
    if (!STP_MAKE_ROOM(context, p->boxes, p->box_capacity, p->item_count)) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < p->item_count; ++i) {
        const item* it = &p->items[i];
        if (it->is_part) {
            stp_box box = it->part.kind == STP_PART_MESH
                              ? p->scene->meshes[it->part.index].bounds
                              : p->scene->point_sets[it->part.index].bounds;
            p->boxes[i] = (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)};
        } else {
            p->boxes[i] =
                stp_affine_box(&it->edge.transform, p->scene->nodes[it->edge.node].bounds);
        }
    }
    return STP_OK;
}

// Builds a hierarchy over the collected items, if there are too many for one node.
static stp_result make_hierarchy(partition* p, item* made)
{
    stp_context* context = p->scene->context;
    stp_result result = box_items(p);
    if (result == STP_OK) {
        result = stp_group_boxes(context, p->boxes, (uint32_t)p->item_count, p->desc.child_count,
                                 &p->grouping);
    }
    if (result != STP_OK) {
        return result;
    }
    const stp_grouping* g = &p->grouping;
    if (!STP_MAKE_ROOM(context, p->results, p->result_capacity, g->group_count)) {
        return stp_fail_memory(context);
    }
    for (size_t i = g->group_count; result == STP_OK && i > 0; --i) {
        const stp_group* group = &g->groups[i - 1];
        assert(group->child_count == 0 || group->first_child >= i);
        if (group->child_count > 0) {
            result = make_node(p, NULL, &p->results[group->first_child], group->child_count, 0,
                               &p->results[i - 1]);
        } else if (group->count == 1) {
            p->results[i - 1] = p->items[g->order[group->first]];
        } else {
            result = make_node(p, &g->order[group->first], p->items, group->count, 0,
                               &p->results[i - 1]);
        }
    }
    *made = p->results[0];
    return result;
}

// Makes the new node of the collected items.
static stp_result make_collected(partition* p, uint32_t flags, uint32_t* index)
{
    const item* only = &p->items[0];
    if (p->item_count == 1 && flags == 0 && !only->is_part &&
        stp_affine_is_identity(&only->edge.transform) &&
        p->scene->nodes[only->edge.node].flags == flags) {
        *index = only->edge.node;
        return STP_OK;
    }
    bool too_many = p->item_count > p->desc.child_count && (flags & STP_OBJECT_MOVING) == 0;
    item made;
    stp_result result = too_many
                            ? make_hierarchy(p, &made)
                            : make_node(p, NULL, p->items, (uint32_t)p->item_count, flags, &made);
    *index = made.edge.node;
    return result;
}

// The limit of a mesh or a point set: larger ones are split. @param maximum limit of a piece
static uint32_t limit_of(const partition* p, stp_part part, uint32_t* maximum)
{
    if (part.kind == STP_PART_MESH) {
        return *maximum = p->desc.leaf_triangles;
    }
    bool oriented = p->scene->point_sets[part.index].normals != NULL;
    if (!p->has_limit && p->desc.finds_signs && !oriented) {
        return *maximum = DEFAULT_UNORIENTED;
    }
    *maximum = p->desc.leaf_points;
    return p->has_limit ? *maximum : DEFAULT_CLOUD;
}

// Splits the large meshes or point sets, and makes a node of each one's pieces.
static stp_result split_kind(partition* p, stp_part_kind kind, const uint8_t* uses, uint32_t* nodes)
{
    stp_scene* scene = p->scene;
    bool is_mesh = kind == STP_PART_MESH;
    size_t count = is_mesh ? scene->mesh_count : scene->point_set_count;
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < count; ++i) {
        uint32_t size =
            is_mesh ? scene->meshes[i].triangle_count : scene->point_sets[i].point_count;
        nodes[i] = STP_NONE;
        uint32_t maximum, limit = limit_of(p, (stp_part){kind, i}, &maximum);
        if ((uses[i] & STP_USED_RESTING) == 0) {
            continue;
        }
        stp_strays strays = is_mesh ? (stp_strays){0} : stp_strays_find(&scene->point_sets[i]);
        if (size - strays.count <= limit) {
            if (strays.count == 0) {
                continue;
            }
            maximum = limit; // the rest stays whole
        }
        uint32_t first = 0, pieces = 0;
        result = stp_progress(scene->context, "partition", 0.5 * (double)i / (double)count);
        if (result == STP_OK) {
            result = is_mesh ? stp_split_mesh(scene, i, maximum, &first, &pieces)
                             : stp_split_points(scene, i, maximum, &strays, &first, &pieces);
        }
        if (result == STP_OK && (uses[i] & STP_USED_MOVING) == 0) {
            stp_scene_release(scene, (stp_part){kind, i}); // never twice in memory
        }
        p->item_count = 0;
        for (uint32_t k = 0; result == STP_OK && k < pieces; ++k) {
            result = add_item(p, &(item){.is_part = true, .part = {kind, first + k}});
            if (result == STP_OK) {
                result = wrap_part(p, &p->items[k]);
            }
        }
        if (result == STP_OK) {
            result = make_collected(p, 0, &nodes[i]);
        }
    }
    return result;
}

static stp_result split_large(partition* p)
{
    stp_scene* scene = p->scene;
    stp_context* context = scene->context;
    uint8_t *mesh_uses = NULL, *point_uses = NULL;
    p->split_meshes = STP_NEW_ARRAY(context, uint32_t, scene->mesh_count);
    p->split_points = STP_NEW_ARRAY(context, uint32_t, scene->point_set_count);
    stp_result result =
        p->split_meshes != NULL && p->split_points != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result =
            stp_find_uses(scene, p->old_nodes, p->old_count, p->old_parts, &mesh_uses, &point_uses);
    }
    result = result == STP_OK ? split_kind(p, STP_PART_MESH, mesh_uses, p->split_meshes) : result;
    result =
        result == STP_OK ? split_kind(p, STP_PART_POINTS, point_uses, p->split_points) : result;
    stp_free(context, point_uses);
    stp_free(context, mesh_uses);
    return result;
}

static stp_result make_nodes(partition* p)
{
    stp_scene* scene = p->scene;
    p->made = STP_NEW_ARRAY(scene->context, uint32_t, p->old_count);
    stp_result result = p->made != NULL ? STP_OK : stp_fail_memory(scene->context);
    for (uint32_t i = 0; result == STP_OK && i < p->old_count; ++i) {
        if (i % PROGRESS_NODES == 0) {
            double done = (double)i / (double)p->old_count;
            result = stp_progress(scene->context, "partition", 0.5 + 0.5 * done);
        }
        result = result == STP_OK ? collect_items(p, i) : result;
        if (result == STP_OK) {
            assert(p->item_count > 0 && "nodes hold something");
            result = make_collected(p, p->old_nodes[i].flags, &p->made[i]);
        }
    }
    return result;
}

// Points the objects and the root to their new nodes.
static void remap_references(partition* p)
{
    stp_scene* scene = p->scene;
    stp_boxd tight = p->old_nodes[scene->root].bounds;
    for (size_t i = 0; i < scene->object_count; ++i) {
        uint32_t* node = &scene->objects[i].node;
        *node = *node != STP_NONE ? p->made[*node] : STP_NONE;
    }
    assert(scene->root < p->old_count && p->made[scene->root] < scene->node_count);
    scene->root = p->made[scene->root];
    scene->nodes[scene->root].bounds = tight; // in the same space
}

stp_result stp_scene_partition(stp_scene* scene, const stp_partition_desc* desc)
{
    stp_context* context = scene->context;
    if (scene->root == STP_NONE) {
        return STP_OK;
    }
    partition p = {.scene = scene,
                   .desc = *desc,
                   .graph = {.scene = scene},
                   .old_nodes = scene->nodes,
                   .old_edges = scene->edges,
                   .old_parts = scene->node_parts,
                   .old_count = scene->node_count};
    p.desc.leaf_triangles = desc->leaf_triangles != 0 ? desc->leaf_triangles : DEFAULT_LEAF;
    p.has_limit = desc->leaf_points != 0 || desc->leaf_triangles != 0;
    p.desc.leaf_points = desc->leaf_points != 0 ? desc->leaf_points
                         : p.has_limit          ? desc->leaf_triangles
                                                : DEFAULT_POINTS;
    p.desc.child_count = desc->child_count != 0 ? desc->child_count : DEFAULT_CHILDREN;
    p.desc.child_count = p.desc.child_count < 2                 ? 2
                         : p.desc.child_count > STP_GROUP_LIMIT ? STP_GROUP_LIMIT
                                                                : p.desc.child_count;
    stp_result result = stp_find_dissolved(scene, &p.dissolved);
    scene->nodes = NULL;
    scene->edges = NULL;
    scene->node_parts = NULL;
    scene->node_count = scene->edge_count = scene->node_part_count = 0;
    result = result == STP_OK ? split_large(&p) : result;
    result = result == STP_OK ? make_nodes(&p) : result;
    if (result == STP_OK) {
        remap_references(&p);
        result = stp_drop_unused(scene);
    }
    stp_graph_destroy(&p.graph);
    stp_grouping_destroy(context, &p.grouping);
    void* arrays[] = {p.old_nodes, p.old_edges,    p.old_parts,    p.dissolved,
                      p.made,      p.split_meshes, p.split_points, p.items,
                      p.boxes,     p.stack,        p.results};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    return result;
}
