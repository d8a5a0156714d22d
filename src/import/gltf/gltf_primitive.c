// SPDX-License-Identifier: MIT
// One primitive (3.7.2) becomes a mesh of triangles or a set of points.
#include "import/gltf/gltf_primitive.h"

#include "base/math/color.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static stp_result draco_attribute(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                  const char* name, size_t id, float divisor, uint32_t* components,
                                  float** values)
{
    stp_context* context = scope->gltf->context;
    const stp_gltf_selection* selection = &vertices->selection;
    uint32_t count = id < STP_NONE ? stp_draco_component_count(vertices->draco, (uint32_t)id) : 0;
    if (count == 0) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "%s: the compressed mesh has no attribute of id %zu", name, id);
    }
    float* all = STP_NEW_ARRAY(context, float, (vertices->count * count));
    float* out = STP_NEW_ARRAY(context, float, (selection->count * count));
    if (all == NULL || out == NULL) {
        stp_free(context, all);
        stp_free(context, out);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_draco_values(vertices->draco, (uint32_t)id, all);
    for (size_t i = 0; i < selection->count; ++i) {
        size_t vertex = selection->map != NULL ? selection->map[i] : selection->first + i;
        assert(vertex < vertices->count);
        for (size_t c = 0; c < count; ++c) {
            float value = all[vertex * count + c] / divisor;
            out[i * count + c] = divisor != 1.0f ? stp_max(value, -1.0f) : value;
        }
    }
    stp_free(context, all);
    *components = count;
    *values = out;
    return STP_OK;
}

static stp_result plain_attribute(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                  const char* name, uint32_t index, uint32_t* components,
                                  float** values)
{
    stp_gltf_accessor accessor;
    stp_result result = stp_gltf_accessor_get(scope, index, &accessor);
    if (result != STP_OK) {
        return result;
    }
    if (accessor.count < vertices->count) {
        stp_gltf_warn(scope, "%s is left out: it has %zu elements for %zu vertices", name,
                      accessor.count, vertices->count);
        return STP_OK;
    }
    *components = accessor.component_count;
    float* out =
        STP_NEW_ARRAY(scope->gltf->context, float, (vertices->selection.count * (*components)));
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *values = out; // the caller frees it in any case
    return stp_gltf_accessor_floats(scope, &accessor, &vertices->selection, out);
}

stp_result stp_gltf_attribute(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                              const char* name, uint32_t components[2], float** values)
{
    uint32_t index = STP_NONE, count = components[0];
    assert(components[0] <= components[1]);
    *values = NULL;
    stp_result result =
        stp_gltf_index(scope, vertices->attributes, name, STP_GLTF_ACCESSORS, &index);
    if (result != STP_OK || index == STP_NONE) {
        return result;
    }
    size_t id = STP_NONE;
    if (vertices->draco != NULL) {
        result = stp_gltf_size(scope, vertices->draco_attributes, name, &id);
    }
    if (result == STP_OK && id != STP_NONE) {
        stp_gltf_accessor accessor;
        result = stp_gltf_accessor_describe(scope, index, &accessor);
        if (result == STP_OK) {
            result = draco_attribute(scope, vertices, name, id,
                                     stp_gltf_accessor_divisor(&accessor), &count, values);
        }
    } else if (result == STP_OK) {
        result = plain_attribute(scope, vertices, name, index, &count, values);
    }
    if (result == STP_OK && (count < components[0] || count > components[1])) {
        result = stp_gltf_fail(scope, STP_ERROR_FORMAT, "%s has %u components", name, count);
    }
    if (result != STP_OK) {
        stp_free(scope->gltf->context, *values);
        *values = NULL;
    }
    components[0] = components[1] = count;
    return result;
}

static void normalize_all(float* normals, size_t count)
{
    for (size_t i = 0; normals != NULL && i < count; ++i) {
        float* n = normals + 3 * i;
        stp_vec3 unit = stp_normalize((stp_vec3){n[0], n[1], n[2]});
        unit = stp_is_finite(unit) ? unit : (stp_vec3){0};
        memcpy(n, (const float[3]){unit.x, unit.y, unit.z}, 3 * sizeof(float));
    }
}

// Positions and normals, posed. The scene skips invalid positions (scene/finish_steps.h).
static stp_result read_geometry(stp_gltf_scope* scope, const json_t* mesh, const json_t* json,
                                const stp_gltf_variant* variant, const stp_gltf_vertices* vertices,
                                float** positions, float** normals)
{
    uint32_t three[2] = {3, 3};
    stp_result result = stp_gltf_attribute(scope, vertices, "POSITION", three, positions);
    if (result != STP_OK) {
        return result;
    }
    if (*positions == NULL) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "POSITION has too few elements");
    }
    three[0] = three[1] = 3;
    result = stp_gltf_attribute(scope, vertices, "NORMAL", three, normals);
    if (result == STP_OK) {
        result = stp_gltf_pose(scope, mesh, json, variant, vertices, *positions, *normals);
    }
    if (result == STP_OK) {
        normalize_all(*normals, vertices->selection.count);
    }
    return result;
}

static float to_unit(float x)
{
    return x > 0.0f ? stp_min(x, 1.0f) : 0.0f; // NaN becomes 0
}

// COLOR_0: three or four floats per vertex, not clamped.
static stp_result read_colors(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                              float** colors, uint32_t* components)
{
    uint32_t allowed[2] = {3, 4};
    stp_result result = stp_gltf_attribute(scope, vertices, "COLOR_0", allowed, colors);
    *components = allowed[0];
    return result;
}

static stp_result read_mesh_colors(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                   stp_mesh* mesh)
{
    stp_context* context = scope->gltf->context;
    float* colors;
    uint32_t components;
    stp_result result = read_colors(scope, vertices, &colors, &components);
    if (result != STP_OK || colors == NULL) {
        return result;
    }
    assert(components == 3 || components == 4);
    size_t count = vertices->selection.count;
    mesh->colors = STP_NEW_ARRAY(context, uint16_t, count * 4);
    for (size_t i = 0; mesh->colors != NULL && i < count; ++i) {
        for (size_t c = 0; c < 4; ++c) {
            float value = c < components ? to_unit(colors[i * components + c]) : 1.0f;
            mesh->colors[4 * i + c] = (uint16_t)(value * 65535.0f + 0.5f);
        }
    }
    stp_free(context, colors);
    return mesh->colors != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

// Colours of points replace the one of their material, so they contain its factor.
static stp_result read_point_colors(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                    stp_point_set* points)
{
    stp_context* context = scope->gltf->context;
    float* colors;
    uint32_t components;
    stp_result result = read_colors(scope, vertices, &colors, &components);
    if (result != STP_OK || colors == NULL) {
        return result;
    }
    assert(components == 3 || components == 4);
    size_t count = vertices->selection.count;
    const float* base = scope->gltf->import->scene->materials[points->material].base_color;
    points->colors = STP_NEW_ARRAY(context, uint8_t, count * 4);
    for (size_t i = 0; points->colors != NULL && i < count; ++i) {
        uint8_t* out = points->colors + 4 * i;
        for (size_t c = 0; c < 3; ++c) {
            out[c] = stp_linear_to_srgb8(to_unit(colors[i * components + c] * base[c]));
        }
        float alpha = components < 4 ? 1.0f : to_unit(colors[i * components + 3]);
        float scaled = to_unit(alpha * base[3]) * 255.0f + 0.5f;
        out[3] = (uint8_t)scaled;
    }
    stp_free(context, colors);
    return points->colors != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

// The texture coordinates that the material needs.
static stp_result read_texcoords(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                 const stp_gltf_material* slots, stp_mesh* mesh)
{
    stp_result result = STP_OK;
    for (uint32_t set = 0; result == STP_OK && set < slots->set_count; ++set) {
        uint32_t components[2] = {2, 2};
        char name[24];
        snprintf(name, sizeof(name), "TEXCOORD_%u", slots->sets[set]);
        result = stp_gltf_attribute(scope, vertices, name, components, &mesh->texcoords[set]);
        float* values = mesh->texcoords[set];
        for (size_t i = 0; values != NULL && i < vertices->selection.count * 2; ++i) {
            values[i] = isfinite(values[i]) ? values[i] : 0.0f;
        }
    }
    return result;
}

static stp_result read_material(stp_gltf_scope* scope, const json_t* json, uint32_t* material,
                                stp_gltf_material* slots)
{
    uint32_t index = STP_NONE;
    stp_result result = stp_gltf_index(scope, json, "material", STP_GLTF_MATERIALS, &index);
    if (result == STP_OK && index != STP_NONE) {
        *material = scope->gltf->first_material + index;
        *slots = scope->gltf->materials[index];
    }
    return result;
}

static stp_result read_triangles(stp_gltf_scope* scope, const json_t* mesh_json, const json_t* json,
                                 stp_gltf_vertices* vertices, stp_gltf_primitive* primitive)
{
    stp_mesh* mesh = &primitive->mesh;
    const stp_gltf_variant* variant = &scope->gltf->variants[primitive->variant];
    stp_gltf_material slots = {0};
    size_t triangle_count;
    stp_result result =
        stp_gltf_triangles(scope, json, primitive->mode, vertices, &mesh->indices, &triangle_count);
    if (result != STP_OK || triangle_count == 0) {
        return result;
    }
    mesh->name = stp_gltf_text(mesh_json, "name");
    mesh->triangle_count = (uint32_t)triangle_count;
    assert(vertices->selection.count > 0 && vertices->selection.count < STP_NONE);
    mesh->vertex_count = (uint32_t)vertices->selection.count;
    result =
        read_geometry(scope, mesh_json, json, variant, vertices, &mesh->positions, &mesh->normals);
    if (result == STP_OK) {
        mesh->material = scope->gltf->default_material;
        result = read_material(scope, json, &mesh->material, &slots);
    }
    if (result == STP_OK) {
        result = read_texcoords(scope, vertices, &slots, mesh);
    }
    if (result == STP_OK) {
        result = read_mesh_colors(scope, vertices, mesh);
    }
    primitive->present = result == STP_OK;
    return result;
}

static stp_result read_points(stp_gltf_scope* scope, const json_t* mesh_json, const json_t* json,
                              stp_gltf_vertices* vertices, stp_gltf_primitive* primitive)
{
    stp_point_set* points = &primitive->points;
    const stp_gltf_variant* variant = &scope->gltf->variants[primitive->variant];
    stp_gltf_material slots = {0};
    stp_result result = stp_gltf_points(scope, json, vertices);
    if (result != STP_OK || vertices->selection.count == 0) {
        return result;
    }
    points->name = stp_gltf_text(mesh_json, "name");
    assert(vertices->selection.count < STP_NONE);
    points->point_count = (uint32_t)vertices->selection.count;
    result = read_geometry(scope, mesh_json, json, variant, vertices, &points->positions,
                           &points->normals);
    if (result == STP_OK) {
        result = read_material(scope, json, &points->material, &slots);
    }
    if (result == STP_OK) {
        result = read_point_colors(scope, vertices, points);
    }
    primitive->present = result == STP_OK;
    return result;
}

// KHR_draco_mesh_compression.
static stp_result open_draco(stp_gltf_scope* scope, const json_t* json, stp_gltf_vertices* vertices)
{
    const json_t* extension;
    uint32_t view = STP_NONE;
    stp_result result = stp_gltf_extension(scope, json, "KHR_draco_mesh_compression", &extension);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, extension, "bufferView", STP_GLTF_BUFFER_VIEWS, &view);
    }
    if (result == STP_OK) {
        result = stp_gltf_object(scope, extension, "attributes", &vertices->draco_attributes);
    }
    if (result != STP_OK || view == STP_NONE) {
        return result;
    }
    const unsigned char* bytes;
    size_t size, stride;
    char reason[80] = "";
    result = stp_gltf_view(scope, view, &bytes, &size, &stride);
    if (result != STP_OK) {
        return result;
    }
    switch (stp_draco_decode(bytes, size, &vertices->draco, reason)) {
    case STP_DRACO_OK:
        vertices->count = stp_draco_point_count(vertices->draco);
        break;
    case STP_DRACO_DAMAGED:
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the Draco data cannot be decoded: %s",
                             reason);
    case STP_DRACO_OUT_OF_MEMORY:
        return STP_ERROR_OUT_OF_MEMORY;
    }
    return STP_OK;
}

// Finds the number of vertices of the primitive; *shows becomes false if it has no positions.
static stp_result open_vertices(stp_gltf_scope* scope, const json_t* json,
                                stp_gltf_vertices* vertices, bool* shows)
{
    uint32_t position = STP_NONE;
    stp_gltf_accessor accessor;
    *shows = false;
    stp_result result = stp_gltf_object(scope, json, "attributes", &vertices->attributes);
    if (result == STP_OK) {
        result =
            stp_gltf_index(scope, vertices->attributes, "POSITION", STP_GLTF_ACCESSORS, &position);
    }
    if (result == STP_OK && position == STP_NONE) {
        stp_gltf_warn(scope, "it has no POSITION and is left out");
        return STP_OK;
    }
    if (result == STP_OK) {
        result = stp_gltf_accessor_describe(scope, position, &accessor);
    }
    if (result != STP_OK) {
        return result;
    }
    vertices->count = accessor.count;
    *shows = true;
    return open_draco(scope, json, vertices);
}

stp_result stp_gltf_read_primitive(stp_gltf_scope* scope, stp_gltf_primitive* primitive)
{
    const stp_gltf_variant* variant = &scope->gltf->variants[primitive->variant];
    const json_t *mesh, *primitives;
    size_t mode = STP_GLTF_TRIANGLES;
    stp_result result = stp_gltf_item(scope, STP_GLTF_MESHES, variant->mesh, &mesh);
    if (result == STP_OK) {
        result = stp_gltf_array(scope, mesh, "primitives", &primitives);
    }
    if (result != STP_OK) {
        return result;
    }
    const json_t* json = json_array_get(primitives, primitive->index);
    if (!json_is_object(json)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "it is not an object");
    }
    result = stp_gltf_size(scope, json, "mode", &mode);
    if (result == STP_OK && mode > STP_GLTF_TRIANGLE_FAN) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "mode %zu is unknown", mode);
    }
    primitive->mode = (stp_gltf_mode)mode;
    bool is_lines = mode >= STP_GLTF_LINES && mode <= STP_GLTF_LINE_STRIP;
    if (result != STP_OK || is_lines) {
        return result;
    }
    stp_gltf_vertices vertices = {0};
    bool shows;
    result = open_vertices(scope, json, &vertices, &shows);
    if (result == STP_OK && shows) {
        result = mode == STP_GLTF_POINTS ? read_points(scope, mesh, json, &vertices, primitive)
                                         : read_triangles(scope, mesh, json, &vertices, primitive);
    }
    stp_free(scope->gltf->context, vertices.selection.map);
    stp_draco_destroy(vertices.draco);
    return result;
}

void stp_gltf_free_primitive(stp_context* context, stp_gltf_primitive* primitive)
{
    void* arrays[] = {primitive->mesh.positions,
                      primitive->mesh.normals,
                      primitive->mesh.texcoords[0],
                      primitive->mesh.texcoords[1],
                      primitive->mesh.colors,
                      primitive->mesh.indices,
                      primitive->points.positions,
                      primitive->points.normals,
                      primitive->points.colors,
                      primitive->error,
                      primitive->warning};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
}
