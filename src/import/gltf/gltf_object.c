// SPDX-License-Identifier: MIT
// Nodes as objects of the scene, with their parts, their instances (EXT_mesh_gpu_instancing) and
// cameras.
#include "import/gltf/gltf_accessor.h"

#include <stipple/view.h>

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

// As in gltf_limit.c: nodes may share meshes and instances without limit, and valid files do.
#define PARTS_ALWAYS_ALLOWED ((size_t)1 << 22)
#define INSTANCES_ALWAYS_ALLOWED ((size_t)1 << 20)
#define SHARES_PER_BYTE 16

typedef struct object_writer {
    stp_gltf_scope* scope;
    stp_gltf* gltf;
    stp_scene* scene;
    size_t part_count, instance_count;
    size_t camera_count;
} object_writer;

static stp_result check_limit(object_writer* writer, size_t count, size_t allowed, const char* what)
{
    size_t bytes = writer->gltf->content_bytes;
    if (count > allowed && count / SHARES_PER_BYTE > bytes) {
        return stp_gltf_fail(writer->scope, STP_ERROR_LIMIT,
                             "the nodes claim %zu %s in a file of %zu bytes", count, what, bytes);
    }
    return STP_OK;
}

// Extras as JSON text, which often identifies the object in the source program.
static stp_result add_object(object_writer* writer, const stp_gltf_node* node, const char* name,
                             uint32_t parent, const stp_affine* transform, uint32_t* index)
{
    const json_t* extras = json_object_get(node->json, "extras");
    char* id = extras != NULL && !json_is_null(extras)
                   ? json_dumps(extras, JSON_COMPACT | JSON_ENCODE_ANY)
                   : NULL;
    stp_object object = {
        .name = name,
        .id = id,
        .parent = parent,
        .transform = *transform,
        .flags = (node->flags & STP_GLTF_MOVES) != 0 ? STP_OBJECT_MOVING : 0,
    };
    stp_result result = stp_scene_add_object(writer->scene, &object, index);
    free(id); // jansson's, from the C library
    return stp_gltf_logged(writer->scope, result);
}

static stp_result add_parts(object_writer* writer, const stp_gltf_node* node)
{
    const stp_gltf_variant* variant = &writer->gltf->variants[node->variant];
    assert(node->variant < writer->gltf->variant_count && "shown nodes with a mesh have one");
    writer->part_count += variant->primitive_count;
    stp_result result = check_limit(writer, writer->part_count, PARTS_ALWAYS_ALLOWED, "primitives");
    for (size_t i = 0; result == STP_OK && i < variant->primitive_count; ++i) {
        const stp_gltf_part* part = &writer->gltf->parts[variant->first_primitive + i];
        if (part->present) {
            result = stp_gltf_logged(writer->scope, stp_scene_add_part(writer->scene, part->part));
        }
    }
    return result;
}

// The values of one attribute of all instances; NULL if it is missing.
static stp_result read_instance_values(object_writer* writer, const json_t* attributes,
                                       const char* name, uint32_t components, size_t* count,
                                       float** values)
{
    stp_gltf_scope* scope = writer->scope;
    uint32_t index = STP_NONE;
    stp_gltf_accessor accessor;
    *values = NULL;
    stp_result result = stp_gltf_index(scope, attributes, name, STP_GLTF_ACCESSORS, &index);
    if (result != STP_OK || index == STP_NONE) {
        return result;
    }
    result = stp_gltf_accessor_get(scope, index, &accessor);
    if (result != STP_OK) {
        return result;
    }
    if (accessor.component_count != components || accessor.count == 0 ||
        (*count != SIZE_MAX && accessor.count != *count)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "EXT_mesh_gpu_instancing: %s has %zu elements of %u components", name,
                             accessor.count, accessor.component_count);
    }
    *count = accessor.count;
    *values = STP_NEW_ARRAY(writer->gltf->context, float, (accessor.count * components));
    if (*values == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_gltf_selection all = {.count = accessor.count};
    return stp_gltf_accessor_floats(scope, &accessor, &all, *values);
}

static stp_result write_instances(object_writer* writer, const float* const values[3], size_t count)
{
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
        bool is_finite = true;
        for (size_t c = 0; c < 4; ++c) {
            if (values[0] != NULL && c < 3) {
                translation[c] = (double)values[0][3 * i + c];
            }
            if (values[1] != NULL) {
                rotation[c] = (double)values[1][4 * i + c];
            }
            if (values[2] != NULL && c < 3) {
                scale[c] = (double)values[2][3 * i + c];
            }
            is_finite = is_finite && isfinite(rotation[c]) &&
                        (c == 3 || (isfinite(translation[c]) && isfinite(scale[c])));
        }
        if (!is_finite) {
            return stp_gltf_fail(writer->scope, STP_ERROR_FORMAT,
                                 "EXT_mesh_gpu_instancing: instance %zu is not finite", i);
        }
        stp_affine transform = stp_gltf_affine_from_parts(translation, rotation, scale);
        result = stp_gltf_logged(writer->scope, stp_scene_add_instance(writer->scene, &transform));
    }
    return result;
}

static stp_result add_instances(object_writer* writer, const stp_gltf_node* node)
{
    static const char* const names[] = {"TRANSLATION", "ROTATION", "SCALE"};
    const json_t *extension, *attributes;
    stp_result result =
        stp_gltf_extension(writer->scope, node->json, "EXT_mesh_gpu_instancing", &extension);
    if (result == STP_OK) {
        result = stp_gltf_object(writer->scope, extension, "attributes", &attributes);
    }
    if (result != STP_OK || attributes == NULL) {
        return result;
    }
    float* values[3] = {NULL};
    size_t count = SIZE_MAX; // not known yet
    for (size_t i = 0; result == STP_OK && i < 3; ++i) {
        result =
            read_instance_values(writer, attributes, names[i], i == 1 ? 4 : 3, &count, &values[i]);
    }
    if (result == STP_OK && count != SIZE_MAX) {
        writer->instance_count += count;
        result = check_limit(writer, writer->instance_count, INSTANCES_ALWAYS_ALLOWED, "instances");
        if (result == STP_OK) {
            result = write_instances(writer, (const float* const*)values, count);
        }
    }
    for (size_t i = 0; i < 3; ++i) {
        stp_free(writer->gltf->context, values[i]);
    }
    return result;
}

// The inverse of an affine map; false if it is singular.
static bool invert(const stp_affine* a, stp_affine* out)
{
    double determinant = stp_affine_determinant(a);
    if (!(determinant < 0.0) && !(determinant > 0.0)) {
        return false;
    }
    for (int r = 0; r < 3; ++r) {
        int r1 = (r + 1) % 3, r2 = (r + 2) % 3;
        for (int c = 0; c < 3; ++c) {
            int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out->m[c][r] =
                (a->m[r1][c1] * a->m[r2][c2] - a->m[r1][c2] * a->m[r2][c1]) / determinant;
        }
    }
    bool is_finite = true;
    for (int r = 0; r < 3; ++r) {
        out->m[r][3] =
            -(out->m[r][0] * a->m[0][3] + out->m[r][1] * a->m[1][3] + out->m[r][2] * a->m[2][3]);
        for (int c = 0; c < 4; ++c) {
            is_finite = is_finite && isfinite(out->m[r][c]);
        }
    }
    return is_finite;
}

// The joints alone place a skinned mesh in the world; its node's transform is ignored (3.7.3.3). So
// it becomes a separate object that undoes that transform.
static stp_result add_skinned(object_writer* writer, const stp_gltf_node* node, const char* name)
{
    stp_affine undo;
    bool has_inverse = invert(&node->world, &undo);
    undo = has_inverse ? undo : stp_affine_identity();
    stp_result result = add_object(
        writer, node, name, has_inverse ? node->object : writer->gltf->import->root, &undo, NULL);
    return result == STP_OK ? add_parts(writer, node) : result;
}

static stp_result add_node(object_writer* writer, stp_gltf_node* node)
{
    stp_gltf* gltf = writer->gltf;
    const json_t* mesh = json_array_get(gltf->lists[STP_GLTF_MESHES],
                                        node->mesh == STP_NONE ? SIZE_MAX : (size_t)node->mesh);
    const char* name = stp_gltf_text(node->json, "name");
    name = name != NULL ? name : stp_gltf_text(mesh, "name");
    uint32_t parent =
        node->parent == STP_NONE ? gltf->import->root : gltf->nodes[node->parent].object;
    assert(parent < writer->scene->object_count && "parents come first");
    stp_result result = add_object(writer, node, name, parent, &node->local, &node->object);
    if (result != STP_OK || node->mesh == STP_NONE) {
        return result;
    }
    if (node->skin != STP_NONE) {
        return add_skinned(writer, node, name);
    }
    result = add_parts(writer, node);
    return result == STP_OK ? add_instances(writer, node) : result;
}

static stp_result write_view(object_writer* writer, const stp_gltf_node* node, const json_t* camera,
                             double degrees)
{
    assert(degrees > 0.0 && degrees < 180.0);
    stp_affine root = writer->scene->objects[writer->gltf->import->root].transform;
    stp_affine world = stp_affine_multiply(root, node->world);
    stp_vec3d eye = {world.m[0][3], world.m[1][3], world.m[2][3]};
    // a camera looks along its -z, with y up (3.10)
    stp_vec3d gaze = stp_normalized((stp_vec3d){-world.m[0][2], -world.m[1][2], -world.m[2][2]});
    stp_vec3d up = stp_normalized((stp_vec3d){world.m[0][1], world.m[1][1], world.m[2][1]});
    if (!(stp_dotd(gaze, gaze) > 0.5) || !(stp_dotd(up, up) > 0.5)) {
        stp_gltf_warn(writer->scope, "its camera is left out: the scale of the node is 0");
        return STP_OK;
    }
    char numbered[32];
    snprintf(numbered, sizeof(numbered), "camera%zu", writer->camera_count);
    const char* name = stp_gltf_text(node->json, "name");
    name = name != NULL && name[0] != '\0' ? name : stp_gltf_text(camera, "name");
    stp_scene_view view = {.name = name != NULL && name[0] != '\0' ? name : numbered,
                           .eye = eye,
                           .target = stp_addd(eye, gaze),
                           .up = up,
                           .fov_degrees = degrees};
    writer->camera_count += 1;
    return stp_gltf_logged(writer->scope, stp_scene_add_view(writer->scene, &view));
}

static stp_result add_camera(object_writer* writer, const stp_gltf_node* node)
{
    stp_gltf_scope* scope = writer->scope;
    const json_t *camera, *perspective;
    double fov = 0.0;
    stp_result result = stp_gltf_item(scope, STP_GLTF_CAMERAS, node->camera, &camera);
    if (result == STP_OK) {
        result = stp_gltf_object(scope, camera, "perspective", &perspective);
    }
    if (result == STP_OK) {
        result = stp_gltf_number(scope, perspective, "yfov", &fov);
    }
    if (result != STP_OK) {
        return result;
    }
    double degrees = fov * 180.0 / STP_PI;
    if (!(degrees >= STP_FOV_DEGREES_MIN && degrees <= STP_FOV_DEGREES_MAX)) {
        stp_losses_add(&writer->gltf->import->losses, STP_LOSS_CAMERA, 1);
        return STP_OK;
    }
    return write_view(writer, node, camera, degrees);
}

stp_result stp_gltf_add_objects(stp_gltf_scope* scope, stp_gltf* gltf)
{
    object_writer writer = {.gltf = gltf, .scene = gltf->import->scene, .scope = scope};
    bool has_skins = false;
    for (size_t i = 0; i < gltf->node_count; ++i) {
        uint32_t index = gltf->node_order[i];
        stp_gltf_node* node = &gltf->nodes[index];
        if ((node->flags & STP_GLTF_IN_SCENE) == 0) {
            continue;
        }
        stp_gltf_scope own = stp_gltf_scope_begin(gltf); // so that each node has its warning
        stp_gltf_set_place(&own, "nodes[%u]", index);
        writer.scope = &own;
        stp_result result = add_node(&writer, node);
        if (result == STP_OK && node->camera != STP_NONE) {
            result = add_camera(&writer, node);
        }
        if (stp_gltf_scope_end(&own, result) != STP_OK) {
            return stp_gltf_logged(scope, result);
        }
        has_skins = has_skins || (node->mesh != STP_NONE && node->skin != STP_NONE);
    }
    if (has_skins) {
        stp_losses_add(&gltf->import->losses, STP_LOSS_SKIN, stp_gltf_count(gltf, STP_GLTF_SKINS));
    }
    return STP_OK;
}
