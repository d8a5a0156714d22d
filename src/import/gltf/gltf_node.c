// SPDX-License-Identifier: MIT
// Nodes (3.5.2), scenes, skins (3.7.3) and the nodes that animations move (3.11). Nothing here
// recurses, because a hierarchy may be as deep as the file is long.
#include "import/gltf/gltf_accessor.h"

#include <assert.h>

static bool is_finite_affine(const stp_affine* a)
{
    double sum = 0.0; // becomes NaN if any element is not finite
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            sum += a->m[r][c] - a->m[r][c];
        }
    }
    return sum == 0.0;
}

stp_affine stp_gltf_affine_from_parts(const double translation[3], const double rotation[4],
                                      const double scale[3])
{
    double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    double length = x * x + y * y + z * z + w * w;
    double s = length > 0.0 ? 2.0 / length : 0.0;
    const double turn[3][3] = {
        {1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
        {s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)},
        {s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)},
    };
    stp_affine out;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            out.m[r][c] = turn[r][c] * scale[c];
        }
        out.m[r][3] = translation[r];
    }
    return out;
}

static stp_result read_transform(stp_gltf_scope* scope, stp_gltf_node* node)
{
    double matrix[16] = {1, [5] = 1, [10] = 1, [15] = 1};
    double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    stp_result result = stp_gltf_numbers(scope, node->json, "matrix", 16, matrix);
    if (result == STP_OK) {
        result = stp_gltf_numbers(scope, node->json, "translation", 3, translation);
    }
    if (result == STP_OK) {
        result = stp_gltf_numbers(scope, node->json, "rotation", 4, rotation);
    }
    if (result == STP_OK) {
        result = stp_gltf_numbers(scope, node->json, "scale", 3, scale);
    }
    if (result != STP_OK) {
        return result;
    }
    if (json_object_get(node->json, "matrix") == NULL) {
        node->local = stp_gltf_affine_from_parts(translation, rotation, scale);
    } else {
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 4; ++c) {
                node->local.m[r][c] = matrix[4 * c + r]; // column-major
            }
        }
    }
    if (!is_finite_affine(&node->local)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the transform is not finite");
    }
    return STP_OK;
}

static stp_result read_node(stp_gltf_scope* scope, stp_gltf_node* node, size_t index)
{
    const json_t* weights;
    stp_result result = stp_gltf_item(scope, STP_GLTF_NODES, index, &node->json);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, node->json, "mesh", STP_GLTF_MESHES, &node->mesh);
    }
    if (result == STP_OK) {
        result = stp_gltf_index(scope, node->json, "skin", STP_GLTF_SKINS, &node->skin);
    }
    if (result == STP_OK) {
        result = stp_gltf_index(scope, node->json, "camera", STP_GLTF_CAMERAS, &node->camera);
    }
    if (result == STP_OK) {
        result = stp_gltf_array(scope, node->json, "weights", &weights);
    }
    if (result != STP_OK) {
        return result;
    }
    node->flags |= json_array_size(weights) != 0 ? STP_GLTF_HAS_WEIGHTS : 0;
    node->flags |= node->mesh != STP_NONE && node->skin != STP_NONE ? STP_GLTF_MOVES : 0;
    return read_transform(scope, node);
}

static stp_result link_children(stp_gltf_scope* scope, stp_gltf* gltf, uint32_t index)
{
    const json_t* children;
    stp_result result = stp_gltf_array(scope, gltf->nodes[index].json, "children", &children);
    for (size_t i = 0; result == STP_OK && i < json_array_size(children); ++i) {
        uint32_t child;
        result = stp_gltf_element_index(scope, children, i, gltf->node_count, &child);
        if (result != STP_OK) {
            return result;
        }
        if (gltf->nodes[child].parent != STP_NONE) {
            return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                                 "its child nodes[%u] already has a parent, nodes[%u]", child,
                                 gltf->nodes[child].parent);
        }
        gltf->nodes[child].parent = index;
    }
    return result;
}

// Orders all nodes so that parents precede children. The end of the array serves as the stack of
// nodes to visit: a node is either on the stack or already ordered.
static stp_result order_nodes(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = gltf->node_count, done = 0, top = count;
    for (size_t i = count; i > 0; --i) {
        if (gltf->nodes[i - 1].parent == STP_NONE) {
            gltf->node_order[--top] = (uint32_t)(i - 1);
        }
    }
    while (top < count) {
        uint32_t index = gltf->node_order[top++];
        gltf->node_order[done++] = index;
        const json_t* children = json_object_get(gltf->nodes[index].json, "children");
        for (size_t i = json_array_size(children); i > 0; --i) {
            uint32_t child;
            stp_result result = stp_gltf_element_index(scope, children, i - 1, count, &child);
            if (result != STP_OK) {
                return result;
            }
            assert(top > done && "each node is pushed once");
            gltf->node_order[--top] = child;
        }
    }
    if (done == count) {
        return STP_OK;
    }
    // every node has at most one parent, so a node that no root reaches belongs to a cycle
    assert(done < count && top == count);
    uint32_t lost = 0;
    for (size_t i = 0; i < done; ++i) {
        gltf->nodes[gltf->node_order[i]].flags |= STP_GLTF_IN_SCENE;
    }
    while ((gltf->nodes[lost].flags & STP_GLTF_IN_SCENE) != 0) {
        lost += 1;
    }
    return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                         "nodes[%u] is its own ancestor, or below one that is", lost);
}

static stp_result place_nodes(stp_gltf_scope* scope, stp_gltf* gltf)
{
    for (size_t i = 0; i < gltf->node_count; ++i) {
        uint32_t index = gltf->node_order[i];
        stp_gltf_node* node = &gltf->nodes[index];
        node->world = node->local;
        if (node->parent != STP_NONE) {
            const stp_gltf_node* parent = &gltf->nodes[node->parent];
            assert(node->parent < gltf->node_count && node->parent != index);
            node->world = stp_affine_multiply(parent->world, node->local);
            node->flags |= parent->flags & STP_GLTF_IN_SCENE;
        }
        if (!is_finite_affine(&node->world)) {
            return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                                 "nodes[%u]: the transform to the world is not finite", index);
        }
    }
    return STP_OK;
}

// Marks the roots of the scene to show: all roots if the file has no scenes.
static stp_result mark_roots(stp_gltf_scope* scope, stp_gltf* gltf)
{
    uint32_t shown = STP_NONE;
    size_t scene_count = stp_gltf_count(gltf, STP_GLTF_SCENES);
    stp_result result = stp_gltf_index(scope, gltf->root, "scene", STP_GLTF_SCENES, &shown);
    if (result != STP_OK) {
        return result;
    }
    if (scene_count == 0) {
        for (size_t i = 0; i < gltf->node_count; ++i) {
            gltf->nodes[i].flags |= gltf->nodes[i].parent == STP_NONE ? STP_GLTF_IN_SCENE : 0;
        }
        return STP_OK;
    }
    shown = shown == STP_NONE ? 0 : shown;
    if (scene_count > 1) {
        stp_losses_add(&gltf->import->losses, STP_LOSS_SCENE, scene_count - 1);
    }
    const json_t *json, *roots;
    result = stp_gltf_item(scope, STP_GLTF_SCENES, shown, &json);
    if (result == STP_OK) {
        result = stp_gltf_array(scope, json, "nodes", &roots);
    }
    for (size_t i = 0; result == STP_OK && i < json_array_size(roots); ++i) {
        uint32_t root;
        stp_gltf_set_place(scope, "scenes[%u].nodes", shown);
        result = stp_gltf_element_index(scope, roots, i, gltf->node_count, &root);
        if (result == STP_OK && gltf->nodes[root].parent != STP_NONE) {
            result = stp_gltf_fail(scope, STP_ERROR_FORMAT,
                                   "nodes[%u] is not a root but a child of nodes[%u]", root,
                                   gltf->nodes[root].parent);
        }
        if (result == STP_OK) {
            gltf->nodes[root].flags |= STP_GLTF_IN_SCENE;
        }
    }
    stp_gltf_set_place(scope, "%s", "");
    return result;
}

static stp_result mark_animated(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_ANIMATIONS);
    for (size_t i = 0; i < count; ++i) {
        const json_t *animation, *channels, *target;
        stp_gltf_set_place(scope, "animations[%zu]", i);
        stp_result result = stp_gltf_item(scope, STP_GLTF_ANIMATIONS, i, &animation);
        if (result == STP_OK) {
            result = stp_gltf_array(scope, animation, "channels", &channels);
        }
        for (size_t k = 0; result == STP_OK && k < json_array_size(channels); ++k) {
            uint32_t node = STP_NONE;
            result = stp_gltf_object(scope, json_array_get(channels, k), "target", &target);
            if (result == STP_OK) {
                result = stp_gltf_index(scope, target, "node", STP_GLTF_NODES, &node);
            }
            if (node != STP_NONE) {
                gltf->nodes[node].flags |= STP_GLTF_MOVES;
            }
        }
        if (result != STP_OK) {
            return result;
        }
    }
    stp_gltf_set_place(scope, "%s", "");
    stp_losses_add(&gltf->import->losses, STP_LOSS_ANIMATION, count);
    return STP_OK;
}

static stp_result add_variant(stp_gltf* gltf, stp_gltf_node* node, uint32_t index,
                              uint32_t* plain_variants)
{
    bool has_weights = (node->flags & STP_GLTF_HAS_WEIGHTS) != 0;
    bool is_plain = node->skin == STP_NONE && !has_weights;
    assert(node->mesh < stp_gltf_count(gltf, STP_GLTF_MESHES));
    if (is_plain && plain_variants[node->mesh] != STP_NONE) {
        node->variant = plain_variants[node->mesh];
        return STP_OK;
    }
    if (!STP_MAKE_ROOM(gltf->context, gltf->variants, gltf->variant_capacity,
                       gltf->variant_count + 1)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    node->variant = (uint32_t)gltf->variant_count++;
    gltf->variants[node->variant] = (stp_gltf_variant){
        .mesh = node->mesh,
        .skin = node->skin,
        .weights_node = has_weights ? index : STP_NONE,
    };
    if (is_plain) {
        plain_variants[node->mesh] = node->variant;
    }
    return STP_OK;
}

static stp_result find_variants(stp_gltf* gltf)
{
    size_t mesh_count = stp_gltf_count(gltf, STP_GLTF_MESHES);
    uint32_t* plain_variants = STP_NEW_ARRAY(gltf->context, uint32_t, mesh_count);
    if (plain_variants == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < mesh_count; ++i) {
        plain_variants[i] = STP_NONE;
    }
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < gltf->node_count; ++i) {
        uint32_t index = gltf->node_order[i];
        stp_gltf_node* node = &gltf->nodes[index];
        if ((node->flags & STP_GLTF_IN_SCENE) != 0 && node->mesh != STP_NONE) {
            result = add_variant(gltf, node, index, plain_variants);
        }
    }
    stp_free(gltf->context, plain_variants);
    return result;
}

stp_result stp_gltf_load_nodes(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_NODES);
    gltf->node_count = count;
    gltf->nodes = STP_NEW_ZEROED(gltf->context, stp_gltf_node, count);
    gltf->node_order = STP_NEW_ARRAY(gltf->context, uint32_t, count);
    if (gltf->nodes == NULL || gltf->node_order == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        gltf->nodes[i].parent = gltf->nodes[i].variant = gltf->nodes[i].object = STP_NONE;
        stp_gltf_set_place(scope, "nodes[%zu]", i);
        result = read_node(scope, &gltf->nodes[i], i);
    }
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        stp_gltf_set_place(scope, "nodes[%zu]", i);
        result = link_children(scope, gltf, (uint32_t)i);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_gltf_set_place(scope, "%s", "");
    result = order_nodes(scope, gltf);
    if (result == STP_OK) {
        result = mark_roots(scope, gltf);
    }
    if (result == STP_OK) {
        result = mark_animated(scope, gltf);
    }
    if (result == STP_OK) {
        result = place_nodes(scope, gltf);
    }
    return result == STP_OK ? find_variants(gltf) : result;
}

// The inverse bind matrices of a skin as affine maps; identities if it has none.
static stp_result read_inverse_binds(stp_gltf_scope* scope, const json_t* skin, size_t count,
                                     stp_affine* matrices)
{
    uint32_t index = STP_NONE;
    stp_result result =
        stp_gltf_index(scope, skin, "inverseBindMatrices", STP_GLTF_ACCESSORS, &index);
    for (size_t i = 0; i < count; ++i) {
        matrices[i] = stp_affine_identity();
    }
    if (result != STP_OK || index == STP_NONE) {
        return result;
    }
    stp_gltf_accessor accessor;
    result = stp_gltf_accessor_get(scope, index, &accessor);
    if (result != STP_OK) {
        return result;
    }
    if (accessor.count < count || accessor.component_count != 16) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "inverseBindMatrices has %zu matrices of %u components, but there are "
                             "%zu joints",
                             accessor.count, accessor.component_count, count);
    }
    float* columns = STP_NEW_ARRAY(scope->gltf->context, float, count * 16);
    if (columns == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_gltf_selection selection = {.count = count};
    result = stp_gltf_accessor_floats(scope, &accessor, &selection, columns);
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        for (size_t k = 0; k < 12; ++k) {
            matrices[i].m[k / 4][k % 4] = (double)columns[16 * i + 4 * (k % 4) + k / 4];
        }
    }
    stp_free(scope->gltf->context, columns);
    return result;
}

stp_result stp_gltf_skin_matrices(stp_gltf_scope* scope, uint32_t skin, stp_affine** matrices,
                                  size_t* count)
{
    const stp_gltf* gltf = scope->gltf;
    const json_t *json, *joints;
    *matrices = NULL;
    stp_result result = stp_gltf_item(scope, STP_GLTF_SKINS, skin, &json);
    if (result == STP_OK) {
        result = stp_gltf_array(scope, json, "joints", &joints);
    }
    if (result != STP_OK) {
        return result;
    }
    *count = json_array_size(joints);
    stp_affine* made = STP_NEW_ARRAY(gltf->context, stp_affine, *count);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    result = read_inverse_binds(scope, json, *count, made);
    for (size_t i = 0; result == STP_OK && i < *count; ++i) {
        uint32_t joint;
        result = stp_gltf_element_index(scope, joints, i, gltf->node_count, &joint);
        if (result == STP_OK) {
            made[i] = stp_affine_multiply(gltf->nodes[joint].world, made[i]);
        }
    }
    if (result != STP_OK) {
        stp_free(gltf->context, made);
        return result;
    }
    *matrices = made;
    return STP_OK;
}
