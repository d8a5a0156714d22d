// SPDX-License-Identifier: MIT
#include "support_store.h"

#include "base/splats/prefix_table.h"

#include <assert.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static stp_store_texture_use no_texture(void)
{
    return (stp_store_texture_use){.texture = STP_STORE_NONE, .transform = {{1, 0, 0}, {0, 1, 0}}};
}

stp_store_material made_material(void)
{
    return (stp_store_material){.base_color = {1, 1, 1, 1},
                                .roughness = 1,
                                .alpha_cutoff = 0.5f,
                                .base_color_texture = no_texture(),
                                .metallic_roughness_texture = no_texture(),
                                .emissive_texture = no_texture()};
}

stp_store_mesh made_square(uint32_t material)
{
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const float texcoords[] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    return (stp_store_mesh){.vertex_count = 4,
                            .triangle_count = 2,
                            .material = material,
                            .bounds = {{-1, -1, 0}, {1, 1, 0}},
                            .positions = positions,
                            .texcoords = {texcoords, NULL},
                            .indices = indices};
}

stp_splats made_square_set(stp_context* context, uint32_t log_side, const uint8_t color[3])
{
    assert(log_side < 16 && "coordinates have 16 bits");
    uint32_t count = 1u << (2 * log_side);
    stp_splats s = {.count = count, .origin = {-1, -1, 0}, .step = 1.0f / 32768.0f};
    s.positions = STP_NEW_ZEROED(context, uint16_t, 3 * (size_t)count);
    s.normals = STP_NEW_ZEROED(context, int8_t, 2 * (size_t)count); // zero: +z
    s.materials = STP_NEW_ZEROED(context, uint8_t, count);
    s.colors = STP_NEW_ZEROED(context, uint8_t, 3 * (size_t)count);
    s.coverages = STP_NEW_ZEROED(context, uint8_t, count);
    if (s.positions == NULL || s.normals == NULL || s.materials == NULL || s.colors == NULL ||
        s.coverages == NULL) {
        abort(); // the test has no memory
    }
    s.octave_count = 1;
    s.octave_ends[0] = count;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t x = 0, y = 0; // bits of i, lowest first, are the bits of x and y, highest first
        for (uint32_t bit = 0; bit < log_side; ++bit) {
            x |= (i >> (2 * bit) & 1u) << (15 - bit);
            y |= (i >> (2 * bit + 1) & 1u) << (15 - bit);
        }
        uint32_t half = 1u << (15 - log_side); // the middle of the finest cell
        s.positions[3 * i] = (uint16_t)(x + half);
        s.positions[3 * i + 1] = (uint16_t)(y + half);
        s.coverages[i] = 255;
        for (int k = 0; k < 3; ++k) {
            s.colors[3 * i + (uint32_t)k] = color[k];
        }
    }
    // a prefix of 4^k leaves a cell's far corner: its diagonal
    for (uint32_t k = 0; k <= log_side; ++k) {
        s.table.count[k] = 1u << (2 * k);
        s.table.radius[k] = 2.0f * 1.42f / (float)(1u << k);
    }
    s.table.size = log_side + 1;
    s.candidate_radius = 0.001f;
    s.paper_radius = 0.1f;
    s.paper_count = count / 4;
    return s;
}

void made_free_set(stp_context* context, stp_splats* s)
{
    stp_free(context, s->positions);
    stp_free(context, s->normals);
    stp_free(context, s->materials);
    stp_free(context, s->colors);
    stp_free(context, s->coverages);
    stp_free(context, s->turns);
    stp_free(context, s->spreads);
}

void made_one_node(made_scene* s, const stp_store_mesh* mesh, const stp_splats* set)
{
    s->material_count = s->shading_count = s->mesh_count = s->part_count = s->node_count = 1;
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1, .flags = STP_SHADING_UNLIT};
    s->meshes[0] = *mesh;
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->nodes[0] = (stp_store_node){
        .part_count = 1, .triangle_count = 1000000, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    s->sets[0] = *set;
    s->set_count = 1;
    s->method = (stp_store_method){.name = "spt", .id = STP_METHOD_SPT, .columns = set->columns};
}

stp_store* made_open(stp_context* context, made_scene* scene)
{
    int file = -1;
    stp_store* store = made_open_file(context, scene, &file);
    if (file >= 0) {
        close(file);
    }
    return store;
}

stp_store* made_open_file(stp_context* context, made_scene* scene, int* descriptor)
{
    stp_store_content content = {
        .directory = {.node_count = scene->node_count,
                      .edge_count = scene->edge_count,
                      .part_count = scene->part_count,
                      .material_count = scene->material_count,
                      .shading_count = scene->shading_count,
                      .texture_count = scene->texture_count,
                      .mesh_count = scene->mesh_count,
                      .point_set_count = scene->point_set_count,
                      .set_count = scene->set_count,
                      .view_count = scene->view_count,
                      .nodes = scene->nodes,
                      .edges = scene->edges,
                      .parts = scene->parts,
                      .materials = scene->materials,
                      .shadings = scene->shadings,
                      .views = scene->views,
                      .root = scene->node_count > 0 ? scene->node_count - 1 : STP_STORE_NONE,
                      .up = 'y',
                      .build_json = "{}"},
        .meshes = scene->meshes,
        .coded_meshes = scene->coded_meshes,
        .point_sets = scene->point_sets,
        .textures = scene->textures,
        .sets = scene->sets,
    };
    if (scene->method.id != 0) {
        scene->method.set_count = scene->set_count;
        content.directory.methods = &scene->method;
        content.directory.method_count = 1;
    }
    char path[64] = "stipple-made-XXXXXX";
    int file = mkstemp(path);
    if (file < 0) {
        return NULL;
    }
    close(file);
    stp_store* store = NULL;
    stp_result result = stp_store_write(context, &content, path);
    if (result == STP_OK) {
        result = stp_store_open(context, path, &store);
    }
    *descriptor = open(path, O_RDWR);
    unlink(path); // an open store keeps its bytes
    return result == STP_OK ? store : NULL;
}

unsigned char* made_file_bytes(stp_context* context, made_scene* scene, size_t* size)
{
    int file = -1;
    stp_store_close(made_open_file(context, scene, &file));
    off_t end = file >= 0 ? lseek(file, 0, SEEK_END) : 0;
    unsigned char* bytes = malloc((size_t)end + 1);
    bool read = bytes != NULL && end > 0 && pread(file, bytes, (size_t)end, 0) == end;
    if (file >= 0) {
        close(file);
    }
    *size = (size_t)end;
    if (!read) {
        free(bytes);
    }
    return read ? bytes : NULL;
}
