// SPDX-License-Identifier: MIT
#include "support_level_shapes.h"

#include <math.h>
#include <string.h>

/// A net of quads. Where it wraps, the last row or column is the first one.
typedef struct net {
    uint32_t columns, rows; ///< quads
    bool wraps_columns, wraps_rows;
    bool turned; ///< fronts are on the other side
} net;

static stp_mesh make_net(stp_context* context, net n)
{
    uint32_t wide = n.wraps_columns ? n.columns : n.columns + 1;
    uint32_t high = n.wraps_rows ? n.rows : n.rows + 1;
    stp_mesh mesh = {.vertex_count = wide * high, .triangle_count = 2 * n.columns * n.rows};
    mesh.positions = STP_NEW_ARRAY(context, float, 3 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)mesh.triangle_count);
    uint32_t* to = mesh.indices;
    for (uint32_t r = 0; r < n.rows && mesh.indices != NULL; ++r) {
        for (uint32_t c = 0; c < n.columns; ++c) {
            uint32_t a = r * wide + c, b = r * wide + (c + 1) % wide;
            uint32_t below = (r + 1) % high * wide;
            uint32_t d = below + c, e = below + (c + 1) % wide;
            *to++ = a;
            *to++ = n.turned ? b : d;
            *to++ = n.turned ? d : b;
            *to++ = b;
            *to++ = n.turned ? e : d;
            *to++ = n.turned ? d : e;
        }
    }
    return mesh;
}

static void put(const stp_mesh* mesh, uint32_t vertex, double x, double y, double z)
{
    float* p = mesh->positions + 3 * (size_t)vertex;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

stp_mesh level_torus(stp_context* context, uint32_t around, uint32_t across, double wide,
                     double thick)
{
    stp_mesh mesh = make_net(context, (net){.columns = across,
                                            .rows = around,
                                            .wraps_columns = true,
                                            .wraps_rows = true,
                                            .turned = true});
    for (uint32_t i = 0; i < mesh.vertex_count && mesh.positions != NULL; ++i) {
        double a = 2.0 * STP_PI * (i / across) / around, b = 2.0 * STP_PI * (i % across) / across;
        double tube = thick * (1.0 + 0.03 * sin(9.0 * a) * cos(5.0 * b));
        double out = wide + tube * cos(b);
        put(&mesh, i, out * cos(a), tube * sin(b), out * sin(a));
    }
    return mesh;
}

stp_mesh level_ball(stp_context* context, uint32_t columns, uint32_t rows, uint32_t open,
                    double radius)
{
    stp_mesh mesh = make_net(
        context,
        (net){.columns = columns, .rows = rows - open, .wraps_columns = true, .turned = true});
    for (uint32_t i = 0; i < mesh.vertex_count && mesh.positions != NULL; ++i) {
        uint32_t row = i / columns + open;
        double a = STP_PI * row / rows, b = 2.0 * STP_PI * (i % columns) / columns;
        double ring = row % rows == 0 ? 0.0 : radius * sin(a); // all vertices of a pole are one
        put(&mesh, i, ring * cos(b), radius * cos(a), ring * sin(b));
    }
    return mesh;
}

stp_mesh level_sheet(stp_context* context, uint32_t side, double width, double bump)
{
    stp_mesh mesh = make_net(context, (net){.columns = side, .rows = side});
    for (uint32_t i = 0; i < mesh.vertex_count && mesh.positions != NULL; ++i) {
        double x = (double)(i % (side + 1)) / side, z = (double)(i / (side + 1)) / side;
        put(&mesh, i, width * x, bump * sin(17.0 * x) * cos(13.0 * z), width * z);
    }
    return mesh;
}

uint32_t level_add_material(stp_scene* scene, float red, float green, float blue)
{
    stp_material material = stp_material_default();
    const float color[4] = {red, green, blue, 1.0f};
    uint32_t index = STP_NONE;
    memcpy(material.base_color, color, sizeof(color));
    material.metallic = 0.0f;
    return stp_scene_add_material(scene, &material, &index) == STP_OK ? index : STP_NONE;
}

uint32_t level_add(stp_scene* scene, stp_mesh mesh, uint32_t material, stp_affine place)
{
    const stp_object object = {.parent = STP_NONE, .transform = place};
    uint32_t index = STP_NONE;
    mesh.material = material;
    if (mesh.positions == NULL || mesh.indices == NULL || material == STP_NONE) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.colors);
        stp_free(scene->context, mesh.texcoords[0]);
        stp_free(scene->context, mesh.indices);
        return STP_NONE;
    }
    if (stp_scene_add_mesh(scene, &mesh, &index) != STP_OK ||
        stp_scene_add_object(scene, &object, NULL) != STP_OK ||
        stp_scene_add_part(scene, (stp_part){STP_PART_MESH, index}) != STP_OK) {
        return STP_NONE;
    }
    return index;
}
