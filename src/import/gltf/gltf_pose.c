// SPDX-License-Identifier: MIT
// The rest pose: morph targets at their default weights (3.7.2.2), then skins (3.7.3.3).
#include "import/gltf/gltf_primitive.h"

#include <assert.h>
#include <stdio.h>

enum { JOINT_SETS = 4 }; // sixteen joints per vertex; the specification requires only four

// The weights of the node if the variant belongs to it, else those of the mesh.
static stp_result find_weights(stp_gltf_scope* scope, const json_t* mesh,
                               const stp_gltf_variant* variant, const json_t** weights)
{
    *weights = NULL;
    if (variant->weights_node != STP_NONE) {
        const json_t* node = scope->gltf->nodes[variant->weights_node].json;
        return stp_gltf_array(scope, node, "weights", weights);
    }
    return stp_gltf_array(scope, mesh, "weights", weights);
}

static stp_result add_deltas(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                             const char* name, float weight, float* values)
{
    uint32_t components[2] = {3, 3};
    float* deltas = NULL;
    stp_result result = STP_OK;
    if (values != NULL) {
        result = stp_gltf_attribute(scope, vertices, name, components, &deltas);
    }
    assert(deltas == NULL || (result == STP_OK && components[0] == 3));
    for (size_t i = 0; deltas != NULL && i < vertices->selection.count * 3; ++i) {
        values[i] += weight * deltas[i];
    }
    stp_free(scope->gltf->context, deltas);
    return result;
}

static stp_result apply_morphs(stp_gltf_scope* scope, const json_t* mesh, const json_t* primitive,
                               const stp_gltf_variant* variant, const stp_gltf_vertices* vertices,
                               float* positions, float* normals)
{
    const json_t *targets, *weights;
    stp_result result = stp_gltf_array(scope, primitive, "targets", &targets);
    if (result == STP_OK) {
        result = find_weights(scope, mesh, variant, &weights);
    }
    for (size_t i = 0; result == STP_OK && i < json_array_size(targets); ++i) {
        float weight = (float)json_number_value(json_array_get(weights, i));
        stp_gltf_vertices target = {.attributes = json_array_get(targets, i),
                                    .count = vertices->count,
                                    .selection = vertices->selection};
        if (weight != 0.0f) {
            result = add_deltas(scope, &target, "POSITION", weight, positions);
            if (result == STP_OK) {
                result = add_deltas(scope, &target, "NORMAL", weight, normals);
            }
        }
    }
    return result;
}

typedef struct skin_arrays {
    stp_affine* matrices;
    size_t matrix_count;
    float* joints[JOINT_SETS];
    float* weights[JOINT_SETS];
    size_t set_count;
} skin_arrays;

static stp_result read_skin(stp_gltf_scope* scope, uint32_t skin, const stp_gltf_vertices* vertices,
                            skin_arrays* arrays)
{
    stp_result result =
        stp_gltf_skin_matrices(scope, skin, &arrays->matrices, &arrays->matrix_count);
    for (size_t set = 0; result == STP_OK && set < JOINT_SETS; ++set) {
        uint32_t components[2] = {4, 4};
        char name[16];
        snprintf(name, sizeof(name), "JOINTS_%zu", set);
        result = stp_gltf_attribute(scope, vertices, name, components, &arrays->joints[set]);
        if (result == STP_OK) {
            components[0] = components[1] = 4;
            snprintf(name, sizeof(name), "WEIGHTS_%zu", set);
            result = stp_gltf_attribute(scope, vertices, name, components, &arrays->weights[set]);
        }
        if (arrays->joints[set] == NULL || arrays->weights[set] == NULL) {
            break;
        }
        arrays->set_count = set + 1;
    }
    return result;
}

// Sums the weighted matrices of a vertex; *total receives their weight. Fails if a joint does not
// exist.
static stp_result blend(stp_gltf_scope* scope, const skin_arrays* arrays, size_t vertex,
                        stp_affine* blended, double* total)
{
    *blended = (stp_affine){0};
    *total = 0.0;
    assert(arrays->set_count <= JOINT_SETS);
    for (size_t k = 0; k < arrays->set_count * 4; ++k) {
        double weight = (double)arrays->weights[k / 4][4 * vertex + k % 4];
        float joint = arrays->joints[k / 4][4 * vertex + k % 4];
        if (!(weight > 0.0) || weight > 1e6) {
            continue; // no weight, or an implausible one
        }
        if (!(joint >= 0.0f) || joint >= (float)arrays->matrix_count) {
            return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                                 "vertex %zu refers to joint %g, but the skin has %zu joints",
                                 vertex, (double)joint, arrays->matrix_count);
        }
        const stp_affine* matrix = &arrays->matrices[(size_t)joint];
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 4; ++c) {
                blended->m[r][c] += weight * matrix->m[r][c];
            }
        }
        *total += weight;
    }
    return STP_OK;
}

static void move_vertex(const stp_affine* matrix, double total, float* position, float* normal)
{
    assert(total > 0.0 && "vertices without weight stay");
    stp_vec3d p = stp_affine_point(
        matrix, (stp_vec3d){(double)position[0], (double)position[1], (double)position[2]});
    position[0] = (float)(p.x / total);
    position[1] = (float)(p.y / total);
    position[2] = (float)(p.z / total);
    if (normal != NULL) {
        double turn[3][3];
        stp_affine_normal_matrix(matrix, turn);
        const double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
        double length = 0.0, out[3];
        for (int r = 0; r < 3; ++r) {
            out[r] = turn[r][0] * n[0] + turn[r][1] * n[1] + turn[r][2] * n[2];
            length += out[r] * out[r];
        }
        for (int r = 0; length > 0.0 && r < 3; ++r) {
            normal[r] = (float)(out[r] / sqrt(length));
        }
    }
}

static stp_result apply_skin(stp_gltf_scope* scope, uint32_t skin,
                             const stp_gltf_vertices* vertices, float* positions, float* normals)
{
    skin_arrays arrays = {0};
    stp_result result = read_skin(scope, skin, vertices, &arrays);
    for (size_t i = 0; result == STP_OK && i < vertices->selection.count; ++i) {
        stp_affine blended;
        double total;
        result = blend(scope, &arrays, i, &blended, &total);
        if (result == STP_OK && total > 0.0) {
            move_vertex(&blended, total, positions + 3 * i,
                        normals != NULL ? normals + 3 * i : NULL);
        }
    }
    for (size_t set = 0; set < JOINT_SETS; ++set) {
        stp_free(scope->gltf->context, arrays.joints[set]);
        stp_free(scope->gltf->context, arrays.weights[set]);
    }
    stp_free(scope->gltf->context, arrays.matrices);
    return result;
}

stp_result stp_gltf_pose(stp_gltf_scope* scope, const json_t* mesh, const json_t* primitive,
                         const stp_gltf_variant* variant, const stp_gltf_vertices* vertices,
                         float* positions, float* normals)
{
    stp_result result = apply_morphs(scope, mesh, primitive, variant, vertices, positions, normals);
    if (result == STP_OK && variant->skin != STP_NONE) {
        result = apply_skin(scope, variant->skin, vertices, positions, normals);
    }
    return result;
}
