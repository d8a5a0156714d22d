// SPDX-License-Identifier: MIT
#include "lab/scenes/gltf_plan.h"

#include <stdlib.h>
#include <string.h>

static stp_result list_children(gltf_plan* plan)
{
    const stp_scene* scene = plan->scene;
    stp_context* context = scene->context;
    plan->first_child = STP_NEW_ARRAY(context, uint32_t, scene->object_count + 1);
    plan->next_sibling = STP_NEW_ARRAY(context, uint32_t, scene->object_count + 1);
    if (plan->first_child == NULL || plan->next_sibling == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        plan->first_child[i] = STP_NONE;
    }
    for (size_t i = scene->object_count; i-- > 0;) { // backwards: the first one ends up first
        uint32_t parent = scene->objects[i].parent;
        if (parent != STP_NONE) {
            plan->next_sibling[i] = plan->first_child[parent];
            plan->first_child[parent] = (uint32_t)i;
        }
    }
    return STP_OK;
}

static stp_result add_node(gltf_plan* plan, const gltf_node* node, const char* path)
{
    stp_context* context = plan->scene->context;
    if (plan->node_count >= GLTF_MOST_NODES) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "%s: the expanded scene has more than %u nodes, as glTF cannot share "
                        "them; use `stipple build scene:NAME` or a smaller --scale",
                        path, GLTF_MOST_NODES);
    }
    if (!STP_MAKE_ROOM(context, plan->nodes, plan->node_capacity, plan->node_count + 1)) {
        return stp_fail_memory(context);
    }
    plan->nodes[plan->node_count++] = *node;
    return STP_OK;
}

// Parts of one object in the chain of uses: shown by the node itself if it has none yet.
static stp_result add_content(gltf_plan* plan, size_t at, uint32_t object, const char* path)
{
    const stp_object* o = &plan->scene->objects[object];
    if (o->part_count == 0) {
        return STP_OK;
    }
    if (o->instance_count > 0 && plan->instance_accessor[object] == STP_NONE) {
        stp_result result = STP_OK;
        for (uint32_t i = 0; result == STP_OK && i < o->instance_count; ++i) {
            result = add_node(
                plan, &(gltf_node){.object = object, .instance = i, .content = object}, path);
        }
        return result;
    }
    if (plan->nodes[at].content == STP_NONE) {
        plan->nodes[at].content = object;
        return STP_OK;
    }
    return add_node(
        plan,
        &(gltf_node){.object = object, .instance = STP_NONE, .content = object, .part_only = true},
        path);
}

// Breadth first: the children of a node get the next free indices.
static stp_result list_nodes(gltf_plan* plan, const char* path)
{
    const stp_scene* scene = plan->scene;
    stp_result result = STP_OK;
    gltf_node fresh = {.instance = STP_NONE, .content = STP_NONE};
    for (uint32_t i = 0; result == STP_OK && i < scene->object_count; ++i) {
        bool shown = scene->objects[i].parent == STP_NONE &&
                     (scene->objects[i].flags & STP_OBJECT_PROTOTYPE) == 0;
        fresh.object = i;
        result = shown ? add_node(plan, &fresh, path) : STP_OK;
    }
    plan->root_count = plan->node_count;
    for (size_t at = 0; result == STP_OK && at < plan->node_count; ++at) {
        plan->nodes[at].first_child = (uint32_t)plan->node_count;
        bool whole = plan->nodes[at].instance == STP_NONE && !plan->nodes[at].part_only;
        uint32_t object = whole ? plan->nodes[at].object : STP_NONE;
        for (; result == STP_OK && object != STP_NONE; object = scene->objects[object].use) {
            result = add_content(plan, at, object, path);
            for (uint32_t child = plan->first_child[object]; result == STP_OK && child != STP_NONE;
                 child = plan->next_sibling[child]) {
                bool shown = (scene->objects[child].flags & STP_OBJECT_PROTOTYPE) == 0;
                fresh.object = child;
                result = shown ? add_node(plan, &fresh, path) : STP_OK;
            }
        }
        plan->nodes[at].child_count = (uint32_t)(plan->node_count - plan->nodes[at].first_child);
    }
    return result;
}

static stp_result add_buffer(gltf_plan* plan)
{
    if (!STP_MAKE_ROOM(plan->scene->context, plan->buffers, plan->buffer_capacity,
                       plan->buffer_count + 1)) {
        return stp_fail_memory(plan->scene->context);
    }
    plan->buffers[plan->buffer_count++] = (gltf_buffer){.sizes = {0}};
    return STP_OK;
}

static stp_result place_mesh(gltf_plan* plan, size_t index, uint64_t most_bytes, const char* path)
{
    const stp_mesh* mesh = &plan->scene->meshes[index];
    gltf_mesh* placed = &plan->meshes[index];
    if (mesh->triangle_count == 0) {
        return stp_fail(plan->scene->context, STP_ERROR_UNSUPPORTED,
                        "%s: mesh %zu has no triangles, which glTF does not allow", path, index);
    }
    uint64_t vertices = mesh->vertex_count;
    placed->index_bytes = vertices < UINT16_MAX ? 2 : 4; // the largest index is reserved (restart)
    uint64_t sizes[GLTF_REGIONS] = {
        vertices * 12 * (mesh->normals != NULL ? 2 : 1),
        mesh->colors != NULL ? vertices * 8 : 0,
        ((uint64_t)mesh->triangle_count * 3 * placed->index_bytes + 3) & ~(uint64_t)3,
    };
    uint64_t size = sizes[0] + sizes[1] + sizes[2];
    bool full = plan->buffer_count > 0 && gltf_buffer_bytes(plan, plan->buffer_count - 1) > 0 &&
                gltf_buffer_bytes(plan, plan->buffer_count - 1) + size > most_bytes;
    stp_result result = full ? add_buffer(plan) : STP_OK;
    if (result == STP_OK) {
        placed->buffer = (uint32_t)plan->buffer_count - 1;
        gltf_buffer* buffer = &plan->buffers[placed->buffer];
        placed->first_accessor = plan->accessor_count;
        plan->accessor_count +=
            2 + (mesh->normals != NULL ? 1u : 0u) + (mesh->colors != NULL ? 1u : 0u);
        for (int r = 0; r < GLTF_REGIONS; ++r) {
            placed->offsets[r] = buffer->sizes[r];
            buffer->sizes[r] += sizes[r];
        }
    }
    return result;
}

static stp_result place_meshes(gltf_plan* plan, uint64_t most_bytes, const char* path)
{
    stp_context* context = plan->scene->context;
    plan->meshes = STP_NEW_ARRAY(context, gltf_mesh, plan->scene->mesh_count + 1);
    stp_result result = plan->meshes != NULL ? add_buffer(plan) : stp_fail_memory(context);
    for (size_t i = 0; result == STP_OK && i < plan->scene->mesh_count; ++i) {
        result = place_mesh(plan, i, most_bytes, path);
    }
    return result;
}

typedef struct listed_object {
    const stp_scene* scene;
    uint32_t object;
} listed_object;

static int compare_lists(const void* left, const void* right)
{
    const listed_object *a = left, *b = right;
    const stp_object *x = &a->scene->objects[a->object], *y = &b->scene->objects[b->object];
    if (x->part_count != y->part_count) {
        return x->part_count < y->part_count ? -1 : 1;
    }
    for (uint32_t i = 0; i < x->part_count; ++i) {
        uint32_t p = a->scene->parts[x->first_part + i].index;
        uint32_t q = b->scene->parts[y->first_part + i].index;
        if (p != q) {
            return p < q ? -1 : 1;
        }
    }
    return 0;
}

static stp_result check_parts(const stp_scene* scene, const char* path)
{
    for (size_t i = 0; i < scene->part_count; ++i) {
        if (scene->parts[i].kind != STP_PART_MESH) {
            return stp_fail(scene->context, STP_ERROR_UNSUPPORTED,
                            "%s: the scene contains points; glTF output does not support them",
                            path);
        }
    }
    return STP_OK;
}

// A single-part object shows the scene's mesh; equal lists of several parts become one mesh of
// several primitives.
static stp_result list_meshes(gltf_plan* plan)
{
    const stp_scene* scene = plan->scene;
    stp_context* context = scene->context;
    size_t count = 0;
    plan->mesh_of_object = STP_NEW_ARRAY(context, uint32_t, scene->object_count + 1);
    plan->lists = STP_NEW_ARRAY(context, uint32_t, scene->object_count + 1);
    listed_object* listed = STP_NEW_ARRAY(context, listed_object, scene->object_count + 1);
    if (plan->mesh_of_object == NULL || plan->lists == NULL || listed == NULL) {
        stp_free(context, listed);
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        plan->mesh_of_object[i] =
            object->part_count == 1 ? scene->parts[object->first_part].index : STP_NONE;
        if (object->part_count > 1) {
            listed[count++] = (listed_object){scene, i};
        }
    }
    qsort(listed, count, sizeof(*listed), compare_lists);
    for (size_t i = 0; i < count; ++i) {
        if (i == 0 || compare_lists(&listed[i - 1], &listed[i]) != 0) {
            plan->lists[plan->list_count++] = listed[i].object;
        }
        plan->mesh_of_object[listed[i].object] =
            (uint32_t)(scene->mesh_count + plan->list_count - 1);
    }
    stp_free(context, listed);
    return STP_OK;
}

// Finds objects whose instances are translations, rotations and scales, as the extension requires.
static stp_result place_instances(gltf_plan* plan)
{
    const stp_scene* scene = plan->scene;
    plan->instance_accessor = STP_NEW_ARRAY(scene->context, uint32_t, scene->object_count + 1);
    if (plan->instance_accessor == NULL) {
        return stp_fail_memory(scene->context);
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        bool plain = object->instance_count > 0 && object->part_count > 0;
        for (uint32_t k = 0; plain && k < object->instance_count; ++k) {
            float ignored[3][4];
            plain = gltf_decompose(&scene->instances[object->first_instance + k], ignored[0],
                                   ignored[1], ignored[2]);
        }
        plan->instance_accessor[i] = plain ? plan->accessor_count : STP_NONE;
        plan->accessor_count += plain ? 3 : 0;
        plan->instance_count += plain ? object->instance_count : 0;
    }
    return STP_OK;
}

static void number_views(gltf_plan* plan)
{
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        plan->buffers[i].first_view = plan->view_count;
        for (int r = 0; r < GLTF_REGIONS; ++r) {
            plan->view_count += plan->buffers[i].sizes[r] > 0 ? 1 : 0;
        }
    }
    plan->view_count += plan->instance_count > 0 ? 3 : 0;
}

stp_result gltf_plan_make(const stp_scene* scene, uint64_t most_buffer_bytes, const char* path,
                          gltf_plan* plan)
{
    *plan = (gltf_plan){.scene = scene};
    stp_result result = check_parts(scene, path);
    result = result == STP_OK ? list_children(plan) : result;
    result = result == STP_OK ? place_meshes(plan, most_buffer_bytes, path) : result;
    result = result == STP_OK ? list_meshes(plan) : result;
    result = result == STP_OK ? place_instances(plan) : result;
    result = result == STP_OK ? list_nodes(plan, path) : result;
    if (result == STP_OK) {
        number_views(plan);
    } else {
        gltf_plan_destroy(plan);
    }
    return result;
}

void gltf_plan_destroy(gltf_plan* plan)
{
    stp_context* context = plan->scene->context;
    void* arrays[] = {plan->nodes,   plan->first_child,      plan->next_sibling,
                      plan->meshes,  plan->mesh_of_object,   plan->lists,
                      plan->buffers, plan->instance_accessor};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    *plan = (gltf_plan){.scene = plan->scene};
}

uint64_t gltf_buffer_bytes(const gltf_plan* plan, size_t buffer)
{
    const uint64_t* sizes = plan->buffers[buffer].sizes;
    bool last = buffer + 1 == plan->buffer_count;
    return sizes[0] + sizes[1] + sizes[2] + (last ? 40 * plan->instance_count : 0);
}
