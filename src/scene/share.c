// SPDX-License-Identifier: MIT
//
// From the tree of objects to the graph of nodes: identical meshes become one, identical subtrees
// one node. Identity is by content (128-bit hashes), so it does not depend on how often and where
// the input repeats it.
#include "base/math/position_grid.h"
#include "scene/finish_steps.h"
#include "scene/graph.h"
#include "scene/scene.h"
#include "scene/strays.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define NODE_FLAGS ((uint32_t)STP_OBJECT_MOVING) // object flags that nodes inherit

static void measure_meshes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_scene* scene = user;
    for (size_t i = begin; i < end; ++i) {
        stp_mesh* mesh = &scene->meshes[i];
        stp_mesh_measure(mesh);
        mesh->grid_step =
            stp_choose_grid_step(mesh->positions, mesh->indices, mesh->triangle_count);
    }
}

static bool part_is_empty(const stp_scene* scene, stp_part part)
{
    return part.kind == STP_PART_MESH ? scene->meshes[part.index].triangle_count == 0
                                      : scene->point_sets[part.index].point_count == 0;
}

// State for building the graph: the children of each object, and the content of nodes.
typedef struct share {
    stp_scene* scene;
    uint32_t* first_child; ///< per object: list by `next_sibling`; STP_NONE ends it
    uint32_t* next_sibling;
    uint32_t* last_child; ///< per object: last child; later the first child that may not be done
    uint8_t* states;      ///< visit_state of each object
    uint32_t* stack;      ///< objects waiting for other nodes
    stp_graph graph;
    size_t stack_count, stack_capacity;
    uint32_t left_out; ///< dropped objects, counting instances: out of reach in their parents
    uint32_t first_left_out;
} share;

typedef enum visit_state { NOT_VISITED, WAITING, DONE } visit_state;

// Places a node below the one being made, unless it would be out of reach there.
static stp_result place_node(share* s, uint32_t object, uint32_t node, const stp_affine* transform)
{
    assert(node < s->scene->node_count && "dependencies have their nodes");
    if (stp_is_within_distance_limit(stp_affine_box(transform, s->scene->nodes[node].bounds))) {
        return stp_graph_add_edge(&s->graph, node, transform);
    }
    s->first_left_out = s->left_out == 0 ? object : s->first_left_out;
    s->left_out += s->left_out < UINT32_MAX ? 1 : 0;
    return STP_OK;
}

static void warn_left_out(const share* s)
{
    if (s->left_out > 0) {
        const char* name = s->scene->objects[s->first_left_out].name;
        char others[48] = "";
        if (s->left_out > 1) {
            snprintf(others, sizeof(others), ", and %u more", s->left_out - 1);
        }
        stp_warn(s->scene->context,
                 "object %u (%s) reaches farther than %g from the origin of its parent: it is left "
                 "out%s",
                 s->first_left_out, name != NULL ? name : "no name", STP_SCENE_DISTANCE_LIMIT,
                 others);
    }
}

// Content that instances of the object place: its own parts, and the object it uses.
static stp_result add_own_content(share* s, const stp_object* object)
{
    stp_scene* scene = s->scene;
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < object->part_count; ++i) {
        stp_part part = scene->parts[object->first_part + i];
        result = part_is_empty(scene, part) ? STP_OK : stp_graph_add_part(&s->graph, part);
    }
    uint32_t used = object->use != STP_NONE ? scene->objects[object->use].node : STP_NONE;
    const stp_affine identity = stp_affine_identity();
    if (result == STP_OK && used != STP_NONE) {
        result = stp_graph_add_edge(&s->graph, used, &identity);
    }
    return result;
}

// Closes the node of an object. If it would only repeat the used object's node, returns that one.
static stp_result close_object(share* s, const stp_object* object, size_t first_edge,
                               size_t first_part, uint32_t* index)
{
    stp_scene* scene = s->scene;
    uint32_t used = object->use != STP_NONE ? scene->objects[object->use].node : STP_NONE;
    uint32_t flags = object->flags & NODE_FLAGS;
    bool single = scene->edge_count == first_edge + 1 && scene->node_part_count == first_part;
    if (used != STP_NONE && single && scene->edges[first_edge].node == used &&
        stp_affine_is_identity(&scene->edges[first_edge].transform) &&
        (flags & ~scene->nodes[used].flags) == 0) {
        scene->edge_count = first_edge;
        *index = used;
        return STP_OK;
    }
    return stp_graph_close_node(&s->graph, first_edge, first_part, flags, index);
}

// Makes the node of an object whose dependencies have their nodes. An empty object gets none.
static stp_result share_object(share* s, uint32_t index)
{
    stp_scene* scene = s->scene;
    stp_object* object = &scene->objects[index];
    uint32_t content = STP_NONE; // the instanced node
    size_t first_edge = scene->edge_count, first_part = scene->node_part_count;
    stp_result result = add_own_content(s, object);
    bool hollow = scene->edge_count == first_edge && scene->node_part_count == first_part;
    if (result == STP_OK && object->instance_count > 0 && !hollow) {
        result = close_object(s, object, first_edge, first_part, &content);
        first_edge = scene->edge_count;
        first_part = scene->node_part_count;
    }
    for (uint32_t child = s->first_child[index]; result == STP_OK && child != STP_NONE;
         child = s->next_sibling[child]) {
        const stp_object* below = &scene->objects[child];
        if (below->node != STP_NONE && (below->flags & STP_OBJECT_PROTOTYPE) == 0) {
            result = place_node(s, child, below->node, &below->transform);
        }
    }
    for (uint32_t i = 0; result == STP_OK && content != STP_NONE && i < object->instance_count;
         ++i) {
        result = place_node(s, index, content, &scene->instances[object->first_instance + i]);
    }
    bool empty = scene->edge_count == first_edge && scene->node_part_count == first_part;
    if (result != STP_OK || empty) {
        return result;
    }
    return close_object(s, object, first_edge, first_part, &object->node);
}

static stp_result push_object(share* s, uint32_t index)
{
    stp_context* context = s->scene->context;
    if (s->states[index] == WAITING) {
        const char* name = s->scene->objects[index].name;
        return stp_fail(
            context, STP_ERROR_FORMAT,
            "object %u (%s) would contain itself through the objects that are used in it", index,
            name != NULL ? name : "no name");
    }
    if (!STP_MAKE_ROOM(context, s->stack, s->stack_capacity, s->stack_count + 1)) {
        return stp_fail_memory(context);
    }
    s->states[index] = WAITING;
    s->stack[s->stack_count++] = index;
    return STP_OK;
}

// A dependency that is not done: a child, or the used object; STP_NONE: none.
static uint32_t find_missing(share* s, uint32_t index)
{
    uint32_t* next = &s->last_child[index]; // where to continue the search
    while (*next != STP_NONE && s->states[*next] == DONE) {
        *next = s->next_sibling[*next];
    }
    uint32_t use = s->scene->objects[index].use;
    return *next != STP_NONE ? *next : use != STP_NONE && s->states[use] != DONE ? use : STP_NONE;
}

// Makes the nodes of an object and of all its dependencies.
static stp_result share_depending(share* s, uint32_t index)
{
    stp_result result = s->states[index] != DONE ? push_object(s, index) : STP_OK;
    while (result == STP_OK && s->stack_count > 0) {
        uint32_t top = s->stack[s->stack_count - 1];
        uint32_t missing = find_missing(s, top);
        if (missing != STP_NONE) {
            result = push_object(s, missing);
            continue;
        }
        assert(s->states[top] == WAITING);
        result = share_object(s, top);
        s->states[top] = DONE;
        s->stack_count -= 1;
    }
    return result;
}

// Makes the root, which contains all objects without a parent.
static stp_result share_roots(share* s)
{
    stp_scene* scene = s->scene;
    size_t first_edge = scene->edge_count;
    for (uint32_t i = 0; i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        bool shown = (object->flags & STP_OBJECT_PROTOTYPE) == 0;
        if (object->parent == STP_NONE && object->node != STP_NONE && shown) {
            stp_result result = place_node(s, i, object->node, &object->transform);
            if (result != STP_OK) {
                return result;
            }
        }
    }
    if (scene->edge_count == first_edge) {
        return STP_OK;
    }
    return stp_graph_close_node(&s->graph, first_edge, scene->node_part_count, 0, &scene->root);
}

static void link_children(share* s)
{
    const stp_scene* scene = s->scene;
    memset(s->first_child, 0xff, scene->object_count * sizeof(uint32_t));
    memset(s->next_sibling, 0xff, scene->object_count * sizeof(uint32_t));
    for (uint32_t i = 0; i < scene->object_count; ++i) {
        uint32_t parent = scene->objects[i].parent;
        if (parent == STP_NONE) {
            continue;
        }
        assert(parent < i && "parents come before their children");
        if (s->first_child[parent] == STP_NONE) {
            s->first_child[parent] = i;
        } else {
            s->next_sibling[s->last_child[parent]] = i;
        }
        s->last_child[parent] = i;
    }
}

static stp_result make_graph(share* s)
{
    stp_scene* scene = s->scene;
    stp_context* context = scene->context;
    s->first_child = STP_NEW_ARRAY(context, uint32_t, scene->object_count);
    s->next_sibling = STP_NEW_ARRAY(context, uint32_t, scene->object_count);
    s->last_child = STP_NEW_ARRAY(context, uint32_t, scene->object_count);
    s->states = STP_NEW_ZEROED(context, uint8_t, scene->object_count);
    if (s->first_child == NULL || s->next_sibling == NULL || s->last_child == NULL ||
        s->states == NULL) {
        return stp_fail_memory(context);
    }
    link_children(s);
    memcpy(s->last_child, s->first_child, scene->object_count * sizeof(uint32_t));
    stp_result result = STP_OK;
    for (size_t i = scene->object_count; result == STP_OK && i > 0; --i) {
        result = share_depending(s, (uint32_t)(i - 1)); // parents come before their children
    }
    return result == STP_OK ? share_roots(s) : result;
}

stp_result stp_scene_finish(stp_scene* scene)
{
    assert(scene->nodes == NULL && scene->root == STP_NONE && "finished already");
    stp_scene_report_dropped(scene);
    if (scene->shortened > 0) {
        stp_warn(scene->context, "names of more than %d bytes are shortened (%u)",
                 STP_SCENE_TEXT_LIMIT, scene->shortened);
    }
    stp_result result = stp_scene_merge(scene);
    result = result == STP_OK ? stp_scene_distinguish_views(scene) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_parallel_for(scene->context, scene->mesh_count, 4, measure_meshes, scene);
    share s = {.scene = scene, .graph = {.scene = scene}};
    result = stp_scene_find_inverted(scene);
    result = result == STP_OK ? make_graph(&s) : result;
    if (result == STP_OK) {
        warn_left_out(&s);
        stp_strays_report(scene);
    }
    stp_graph_destroy(&s.graph);
    stp_free(scene->context, s.stack);
    stp_free(scene->context, s.states);
    stp_free(scene->context, s.last_child);
    stp_free(scene->context, s.next_sibling);
    stp_free(scene->context, s.first_child);
    return result == STP_OK && scene->root != STP_NONE ? stp_scene_tighten_root(scene) : result;
}
