// SPDX-License-Identifier: MIT
// Pixels of a caller whose rows are not tightly packed.
#include "support_embed.h"

#include <string.h>

enum { ROW = 4 * EMBED_SIDE, STRIDE = ROW + 20, FILL = 0xA5 };

static int count_wrong_rows(const uint8_t* tight, const uint8_t* wide)
{
    int wrong = 0;
    for (size_t y = 0; y < EMBED_SIDE; ++y) {
        wrong += memcmp(tight + y * ROW, wide + y * STRIDE, ROW) != 0;
        for (size_t i = ROW; i < STRIDE; ++i) {
            wrong += wide[y * STRIDE + i] != FILL;
        }
    }
    return wrong;
}

void test_embed_rows_may_be_apart(test_state* test)
{
    static uint8_t tight[ROW * EMBED_SIDE], same[sizeof(tight)], wide[STRIDE * EMBED_SIDE];
    memset(wide, FILL, sizeof(wide));
    size_t size = 0;
    void* bytes = embed_build_town(false, &size);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_model* model = NULL;
    stp_result results[4] = {STP_ERROR_IO, STP_ERROR_IO, STP_ERROR_IO, STP_ERROR_IO};
    if (stp_model_open(context, &(stp_model_desc){.bytes = bytes, .size = size}, &model) ==
        STP_OK) {
        results[0] = embed_draw(model, NULL, tight);
        results[1] = embed_draw(model, &(stp_paint_desc){.stride = ROW}, same);
        results[2] = embed_draw(model, &(stp_paint_desc){.stride = STRIDE}, wide);
        results[3] = embed_draw(model, &(stp_paint_desc){.stride = ROW - 4}, same);
    }
    stp_model_close(model);
    stp_context_destroy(context);
    free(bytes);
    CHECK_EQUAL(STP_OK, results[0]);
    CHECK_EQUAL(STP_OK, results[1]);
    CHECK_EQUAL(STP_OK, results[2]);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, results[3]);
    CHECK(memcmp(tight, same, sizeof(tight)) == 0);
    CHECK_EQUAL(0, count_wrong_rows(tight, wide));
}

/// A textured triangle as a `.stip`. @return its bytes, which the builder owns, or NULL
static const void* build_textured(stp_builder* builder, const uint8_t* pixels, size_t stride,
                                  size_t* size)
{
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       texcoords[6] = {0, 1, 1, 1, 0, 0};
    stp_image picture = {.width = 3, .height = 2, .pixels = (uint8_t*)(uintptr_t)pixels};
    stp_material_desc desc = {.picture = &picture, .picture_stride = stride};
    stp_mesh_desc mesh = {
        .positions = positions, .texcoords = texcoords, .vertex_count = 3, .triangle_count = 1};
    return stp_builder_add_material(builder, &desc, &mesh.material) == STP_OK &&
                   stp_builder_add_mesh(builder, &mesh, NULL) == STP_OK &&
                   stp_builder_write(builder, NULL, NULL) == STP_OK
               ? stp_builder_get_bytes(builder, size)
               : NULL;
}

void test_embed_rows_of_textures_may_be_apart(test_state* test)
{
    uint8_t tight[24], wide[32];
    memset(wide, FILL, sizeof(wide));
    for (size_t i = 0; i < sizeof(tight); ++i) {
        tight[i] = (uint8_t)(9 * i);
        wide[i / 12 * 16 + i % 12] = tight[i];
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_builder* builders[3] = {NULL, NULL, NULL};
    const void* bytes[3] = {NULL, NULL, NULL};
    const struct {
        const uint8_t* pixels;
        size_t stride;
    } given[3] = {{tight, 0}, {wide, 16}, {wide, 8}};
    size_t sizes[3] = {0};
    for (int i = 0; i < 3; ++i) {
        bytes[i] = stp_builder_create(context, NULL, &builders[i]) == STP_OK
                       ? build_textured(builders[i], given[i].pixels, given[i].stride, &sizes[i])
                       : NULL;
    }
    bool alike = bytes[0] != NULL && bytes[1] != NULL && sizes[0] == sizes[1] &&
                 memcmp(bytes[0], bytes[1], sizes[0]) == 0;
    bool refused = bytes[2] == NULL;
    for (int i = 0; i < 3; ++i) {
        stp_builder_destroy(builders[i]);
    }
    stp_context_destroy(context);
    CHECK(alike);
    CHECK(refused);
}
