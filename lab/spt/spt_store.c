// SPDX-License-Identifier: MIT
#include "lab/spt/spt_drawing.h"
#include "program/options/command.h"
#include "store/writer/writer.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static stp_boxd bounds_of(const stp_splats* set)
{
    double size = 65535.0 * (double)set->step;
    stp_vec3d low = {(double)set->origin.x, (double)set->origin.y, (double)set->origin.z};
    return (stp_boxd){low, {low.x + size, low.y + size, low.z + size}};
}

stp_result spt_store_open(stp_context* context, const stp_splats* set, stp_store** store)
{
    static const float positions[9] = {0}; // a node has triangles, which are not drawn here
    static const uint32_t indices[3] = {0, 1, 2};
    const stp_store_texture_use none = {.texture = STP_STORE_NONE,
                                        .transform = {{1, 0, 0}, {0, 1, 0}}};
    const stp_store_material material = {.base_color = {1, 1, 1, 1},
                                         .roughness = 1,
                                         .base_color_texture = none,
                                         .metallic_roughness_texture = none,
                                         .emissive_texture = none};
    const stp_store_mesh mesh = {
        .vertex_count = 3, .triangle_count = 1, .positions = positions, .indices = indices};
    const stp_store_part part = {STP_STORE_PART_MESH, 0};
    const stp_shading shading = {.roughness = 1, .flags = STP_SHADING_UNLIT};
    const stp_store_node node = {.part_count = 1, .triangle_count = 1, .bounds = bounds_of(set)};
    const stp_store_method method = {
        .name = "spt", .id = STP_METHOD_SPT, .columns = set->columns, .set_count = 1};
    const stp_store_content content = {.directory = {.node_count = 1,
                                                     .part_count = 1,
                                                     .material_count = 1,
                                                     .shading_count = 1,
                                                     .mesh_count = 1,
                                                     .set_count = 1,
                                                     .method_count = 1,
                                                     .nodes = &node,
                                                     .parts = &part,
                                                     .materials = &material,
                                                     .shadings = &shading,
                                                     .methods = &method,
                                                     .up = 'y',
                                                     .build_json = "{}"},
                                       .meshes = &mesh,
                                       .sets = set,
                                       .passing = true};
    char path[512];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stipple-bench-XXXXXX", folder != NULL ? folder : "/tmp");
    int file = mkstemp(path);
    if (file < 0) {
        tool_error("bench spt: cannot create scratch file %s", path);
        return STP_ERROR_IO;
    }
    close(file);
    stp_result result = stp_store_write(context, &content, path);
    result = result == STP_OK ? stp_store_open(context, path, store) : result;
    unlink(path);
    return result;
}
