// SPDX-License-Identifier: MIT
// Meshes and points of the stream.
#include "import/assimp/assimp_reader.h"
#include "import/reading/smooth.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#define FAR_MESH 128.0         ///< a mesh is far if its size is less than this part of its distance
#define FAR_COORDINATE 65536.0 ///< coordinates below this keep their digits

static void free_mesh(stp_context* context, const stp_mesh* mesh)
{
    stp_free(context, mesh->positions);
    stp_free(context, mesh->normals);
    stp_free(context, mesh->texcoords[0]);
    stp_free(context, mesh->texcoords[1]);
    stp_free(context, mesh->colors);
    stp_free(context, mesh->indices);
}

static void repair_attributes(const stp_mesh* mesh)
{
    size_t count = mesh->vertex_count;
    for (size_t i = 0; mesh->normals != NULL && i < count; ++i) {
        float* n = mesh->normals + 3 * i;
        stp_vec3 unit = stp_normalize((stp_vec3){n[0], n[1], n[2]});
        memcpy(n, &unit, sizeof(unit));
    }
    for (int set = 0; set < 2; ++set) {
        for (size_t i = 0; mesh->texcoords[set] != NULL && i < 2 * count; ++i) {
            float* value = &mesh->texcoords[set][i];
            *value = isfinite(*value) ? *value : 0.0f;
        }
    }
}

// assimp stores coordinates as floats, which have too few digits for small meshes far from the
// origin. Notes the largest step of their coordinates.
static void note_precision(stp_assimp_reader* r, const stp_mesh* mesh)
{
    stp_box box = stp_box_empty();
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const float* p = mesh->positions + 3 * i;
        stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
    }
    const double low[3] = {(double)box.min.x, (double)box.min.y, (double)box.min.z};
    const double high[3] = {(double)box.max.x, (double)box.max.y, (double)box.max.z};
    double size = 0.0, farthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        size = fmax(size, high[axis] - low[axis]);
        farthest = fmax(farthest, fmax(fabs(low[axis]), fabs(high[axis])));
    }
    if (size < farthest / FAR_MESH && farthest > FAR_COORDINATE && farthest < 1e15) {
        r->coarse_step = fmax(r->coarse_step, farthest * (double)FLT_EPSILON);
    }
}

// Reads the arrays of a mesh; after a failure `mesh` holds what was read so far.
static stp_result read_arrays(stp_assimp_reader* r, const stp_assimp_mesh* head, stp_mesh* mesh,
                              float** colors)
{
    stp_result result = STP_OK;
    size_t count = head->vertex_count;
    mesh->positions = stp_assimp_take_copy(r, count, 3 * sizeof(float), &result);
    if (result == STP_OK && (head->flags & STP_ASSIMP_NORMALS) != 0) {
        mesh->normals = stp_assimp_take_copy(r, count, 3 * sizeof(float), &result);
    }
    for (int set = 0; set < 2 && result == STP_OK; ++set) {
        if ((head->flags & (set == 0 ? STP_ASSIMP_TEXCOORDS_0 : STP_ASSIMP_TEXCOORDS_1)) != 0) {
            mesh->texcoords[set] = stp_assimp_take_copy(r, count, 2 * sizeof(float), &result);
        }
    }
    if (result == STP_OK && (head->flags & STP_ASSIMP_COLORS) != 0) {
        *colors = stp_assimp_take_copy(r, count, 4 * sizeof(float), &result);
    }
    if (result == STP_OK) {
        mesh->indices =
            stp_assimp_take_copy(r, head->triangle_count, 3 * sizeof(uint32_t), &result);
    }
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < 3 * (size_t)head->triangle_count; ++i) {
        if (mesh->indices[i] >= head->vertex_count) {
            return stp_assimp_fail_stream(r, "indices");
        }
    }
    repair_attributes(mesh);
    note_precision(r, mesh);
    return STP_OK;
}

static stp_result add_points(stp_assimp_reader* r, stp_mesh* mesh, const float* colors,
                             stp_part* part)
{
    stp_point_set set = {
        .name = mesh->name, .point_count = mesh->vertex_count, .material = mesh->material};
    if (colors != NULL) {
        set.colors = STP_NEW_ARRAY(r->context, uint8_t, 4 * (size_t)set.point_count);
        if (set.colors == NULL) {
            return stp_fail_memory(r->context);
        }
        for (size_t i = 0; i < 4 * (size_t)set.point_count; ++i) {
            set.colors[i] = stp_unorm8(colors[i]);
        }
    }
    assert(mesh->positions != NULL && set.point_count > 0);
    set.positions = mesh->positions;
    set.normals = mesh->normals;
    mesh->positions = mesh->normals = NULL;
    part->kind = STP_PART_POINTS;
    return stp_scene_add_point_set(r->import->scene, &set, &part->index);
}

static stp_result add_mesh(stp_assimp_reader* r, stp_mesh* mesh, const float* colors,
                           stp_part* part)
{
    if (colors != NULL) {
        mesh->colors = STP_NEW_ARRAY(r->context, uint16_t, 4 * (size_t)mesh->vertex_count);
        if (mesh->colors == NULL) {
            return stp_fail_memory(r->context);
        }
        for (size_t i = 0; i < 4 * (size_t)mesh->vertex_count; ++i) {
            mesh->colors[i] = stp_unorm16(i % 4 < 3 ? stp_srgb_to_linear(colors[i]) : colors[i]);
        }
    }
    assert(mesh->positions != NULL && mesh->indices != NULL && mesh->triangle_count > 0);
    stp_mesh given = *mesh;
    *mesh = (stp_mesh){0};
    return stp_import_add_mesh(r->import, &given, &part->index);
}

static stp_result read_mesh(stp_assimp_reader* r, stp_part* part)
{
    stp_mesh mesh = {0};
    stp_assimp_mesh head;
    float* colors = NULL;
    *part = (stp_part){.kind = STP_PART_MESH, .index = STP_NONE};
    stp_result result = stp_assimp_take_text(r, &mesh.name);
    if (result != STP_OK) {
        return result;
    }
    if (!stp_assimp_take_value(r, &head, sizeof(head)) || head.material >= r->material_count) {
        return stp_assimp_fail_stream(r, "meshes");
    }
    mesh.material = r->materials[head.material];
    mesh.vertex_count = head.vertex_count;
    mesh.triangle_count = head.triangle_count;
    result = read_arrays(r, &head, &mesh, &colors);
    bool points = (head.flags & STP_ASSIMP_POINTS) != 0;
    if (result == STP_OK && points && head.vertex_count != 0) {
        result = add_points(r, &mesh, colors, part);
    } else if (result == STP_OK && !points && head.triangle_count != 0) {
        result = add_mesh(r, &mesh, colors, part);
    }
    free_mesh(r->context, &mesh);
    stp_free(r->context, colors);
    return result;
}

stp_result stp_assimp_read_meshes(stp_assimp_reader* r)
{
    if (!stp_assimp_take_count(r, sizeof(stp_assimp_mesh), &r->mesh_count)) {
        return stp_assimp_fail_stream(r, "meshes");
    }
    r->parts = STP_NEW_ARRAY(r->context, stp_part, r->mesh_count);
    if (r->parts == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->mesh_count; ++i) {
        stp_result result = read_mesh(r, &r->parts[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    if (r->coarse_step > 0.0) {
        stp_warn(r->context,
                 "%s: assimp reads coordinates as floats: those far from the origin are rounded to "
                 "about %.2g units",
                 r->import->path, r->coarse_step);
    }
    return STP_OK;
}
