// SPDX-License-Identifier: MIT
#include "support_embed.h"

#include <math.h>
#include <string.h>

enum { RINGS = 24, SECTORS = 24 };

static stp_result add_box(stp_builder* builder, uint32_t material, uint32_t* part)
{
    static const float corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                        {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
    static const uint32_t indices[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    stp_mesh_desc desc = {.name = "cube",
                          .positions = corners[0],
                          .vertex_count = 8,
                          .indices = indices,
                          .triangle_count = 12,
                          .material = material};
    return stp_builder_add_mesh(builder, &desc, part);
}

static stp_result add_ball(stp_builder* builder, uint32_t* part)
{
    float positions[(RINGS + 1) * SECTORS][3];
    uint8_t colors[(RINGS + 1) * SECTORS][4];
    uint32_t indices[RINGS * SECTORS * 6];
    size_t count = 0;
    for (uint32_t i = 0; i <= RINGS; ++i) {
        for (uint32_t k = 0; k < SECTORS; ++k) {
            double a = 3.14159265358979 * i / RINGS, b = 6.28318530717959 * k / SECTORS;
            float* p = positions[i * SECTORS + k];
            p[0] = (float)(sin(a) * cos(b));
            p[1] = (float)cos(a);
            p[2] = (float)(sin(a) * sin(b));
            memcpy(colors[i * SECTORS + k], (uint8_t[4]){200, (uint8_t)(10 * i), 40, 255}, 4);
            if (i < RINGS) {
                uint32_t here = i * SECTORS + k, right = i * SECTORS + (k + 1) % SECTORS;
                uint32_t corners[6] = {here, right,           right + SECTORS,
                                       here, right + SECTORS, here + SECTORS};
                memcpy(indices + count, corners, sizeof(corners));
                count += 6;
            }
        }
    }
    stp_mesh_desc desc = {.name = "ball",
                          .positions = positions[0],
                          .normals = positions[0],
                          .colors = colors[0],
                          .vertex_count = (RINGS + 1) * SECTORS,
                          .indices = indices,
                          .triangle_count = RINGS * SECTORS * 2};
    return stp_builder_add_mesh(builder, &desc, part);
}

static stp_result add_points(stp_builder* builder)
{
    float positions[EMBED_POINTS][3] = {{0}}, normals[EMBED_POINTS][3] = {{0}};
    uint16_t intensities[EMBED_POINTS] = {0};
    uint8_t classes[EMBED_POINTS] = {0};
    for (int i = 0; i < EMBED_POINTS; ++i) {
        positions[i][0] = (float)(i % 50) * 0.2f - 5.0f;
        positions[i][1] = (float)(i / 50) * 0.2f;
        positions[i][2] = -6.0f;
        normals[i][2] = 1.0f;
        intensities[i] = (uint16_t)(40 * i);
        classes[i] = i % 50 < 25 ? 2 : 6;
    }
    stp_points_desc desc = {
        .name = "scan",
        .positions = positions[0],
        .normals = normals[0],
        .point_count = EMBED_POINTS,
        .attributes = {[STP_ATTRIBUTE_INTENSITY] = intensities, [STP_ATTRIBUTE_CLASS] = classes}};
    return stp_builder_add_points(builder, &desc, NULL);
}

static stp_affine place(double x, double y, double z)
{
    return (stp_affine){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
}

stp_result embed_add_town(stp_builder* builder, bool points)
{
    uint32_t material = 0, box = 0, ball = 0, town = 0;
    const stp_affine places[3] = {place(-3, 4, 0), place(0, 4, 0), place(3, 4, 0)};
    stp_material_desc blue = {.name = "blue", .base_color = {0.1f, 0.2f, 0.8f, 1.0f}};
    stp_result result = stp_builder_add_material(builder, &blue, &material);
    result = result == STP_OK ? add_box(builder, material, &box) : result;
    result = result == STP_OK ? add_ball(builder, &ball) : result;
    stp_object_desc objects[3] = {{.name = "town", .id = "{\"key\":7}"},
                                  {.name = "box", .parts = &box, .part_count = 1},
                                  {.name = "balls",
                                   .parts = &ball,
                                   .part_count = 1,
                                   .instances = places,
                                   .instance_count = 3}};
    result = result == STP_OK ? stp_builder_add_object(builder, &objects[0], &town) : result;
    for (int i = 1; i < 3 && result == STP_OK; ++i) {
        objects[i].parent = town;
        result = stp_builder_add_object(builder, &objects[i], NULL);
    }
    return result == STP_OK && points ? add_points(builder) : result;
}

void* embed_build_town(bool points, size_t* size)
{
    return embed_build_town_on(2, points, size);
}

void* embed_build_town_on(uint32_t threads, bool points, size_t* size)
{
    stp_context* context = test_context(NULL, threads, NULL);
    stp_builder* builder = NULL;
    void* copy = NULL;
    stp_write_desc desc = {.threshold = 100};
    if (context != NULL && stp_builder_create(context, NULL, &builder) == STP_OK &&
        embed_add_town(builder, points) == STP_OK &&
        stp_builder_write(builder, &desc, NULL) == STP_OK) {
        const void* bytes = stp_builder_get_bytes(builder, size);
        copy = aligned_alloc(64, (*size + 63) / 64 * 64);
        copy = copy != NULL ? memcpy(copy, bytes, *size) : NULL;
    }
    stp_builder_destroy(builder);
    stp_context_destroy(context);
    return copy;
}

stp_view embed_view(void)
{
    return (stp_view){.eye = {0, 2, 14},
                      .target = {0, 2, 0},
                      .up = {0, 1, 0},
                      .fov_degrees = 50,
                      .width = EMBED_SIDE,
                      .height = EMBED_SIDE};
}

stp_result embed_draw(stp_model* model, const stp_paint_desc* desc, uint8_t* pixels)
{
    stp_painter* painter = NULL;
    stp_view view = embed_view();
    stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = pixels};
    stp_result result = stp_painter_create(model, NULL, &painter);
    result = result == STP_OK ? stp_painter_draw(painter, &view, desc, &image, NULL) : result;
    stp_painter_destroy(painter);
    return result;
}
