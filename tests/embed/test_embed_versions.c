// SPDX-License-Identifier: MIT
// Structs of other versions: callers with older or newer headers.
#include "tests.h"

#include "base/core/desc.h"

#include <stipple/stipple.h>

typedef struct short_desc {
    size_t struct_size;
    int first;
} short_desc;

typedef struct known_desc {
    size_t struct_size;
    int first, second;
} known_desc;

typedef struct long_desc {
    size_t struct_size;
    int first, second, third;
} long_desc;

void test_embed_descriptors_of_other_versions_are_read(test_state* test)
{
    known_desc read;
    short_desc older = {.struct_size = offsetof(known_desc, second), .first = 1};
    long_desc newer = {.struct_size = sizeof(newer), .first = 1, .second = 2};
    long_desc beyond = {.struct_size = sizeof(beyond), .first = 1, .second = 2, .third = 3};
    known_desc unsized = {.first = 4, .second = 5};
    const size_t size = sizeof(read);
    CHECK(stp_desc_read(&read, size, size, &older) && read.first == 1 && read.second == 0);
    CHECK(stp_desc_read(&read, size, size, &newer) && read.first == 1 && read.second == 2);
    CHECK(!stp_desc_read(&read, size, size, &beyond));
    CHECK(stp_desc_read(&read, size, size, &unsized) && read.first == 4 && read.second == 5);
    CHECK(stp_desc_read(&read, size, offsetof(known_desc, second), &unsized) && read.second == 0);
    CHECK(stp_desc_read(&read, size, size, NULL) && read.first == 0);
    older.struct_size = 3; // not even its size
    CHECK(!stp_desc_read(&read, size, size, &older));
}

void test_embed_infos_of_other_versions_are_filled(test_state* test)
{
    known_desc made = {.first = 1, .second = 2};
    known_desc older = {.struct_size = offsetof(known_desc, second), .first = 7, .second = 8};
    long_desc newer = {.struct_size = sizeof(newer), .third = 9};
    stp_info_write(&older, &made, sizeof(made), sizeof(made));
    stp_info_write(&newer, &made, sizeof(made), sizeof(made));
    CHECK(older.first == 1 && older.second == 8 &&
          older.struct_size == offsetof(known_desc, second));
    CHECK(newer.first == 1 && newer.second == 2 && newer.third == 0);
}

void test_embed_unknown_fields_are_refused(test_state* test)
{
    struct {
        stp_builder_desc known;
        uint64_t later;
    } desc = {.known = {.struct_size = sizeof(desc)}};
    test_log log = {0};
    stp_builder* builder = NULL;
    stp_context *context = test_context(NULL, 1, &log), *plain = NULL;
    stp_result without = stp_context_create(&plain, NULL);
    stp_context_destroy(plain);
    stp_context* halved = NULL;
    stp_context_desc half = {.allocator = {.alloc = test_heap_alloc}};
    stp_result refused = stp_context_create(&halved, &half);
    stp_result zero = stp_builder_create(context, &desc.known, &builder);
    stp_builder_destroy(builder);
    desc.later = 1;
    stp_result set = stp_builder_create(context, &desc.known, &builder);
    bool none = builder == NULL;
    stp_context_destroy(context);
    CHECK(without == STP_OK && plain != NULL);
    CHECK(refused == STP_ERROR_ARGUMENT && halved == NULL);
    CHECK_EQUAL(STP_OK, zero);
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, set);
    CHECK(none && log.errors == 1);
    CHECK_EQUAL(STP_VERSION_MAJOR * 10000 + STP_VERSION_MINOR * 100 + STP_VERSION_PATCH,
                stp_version());
}

static stp_result add_wrong_input(stp_builder* builder, int which)
{
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t beyond[3] = {0, 1, 3};
    uint32_t number = 9;
    stp_mesh_desc mesh = {.positions = corners, .vertex_count = 3, .triangle_count = 1};
    stp_object_desc object = {.parts = &number, .part_count = 1};
    stp_material_desc material = {.roughness = 2.0f};
    switch (which) {
    case 0:
        mesh.indices = beyond;
        break;
    case 1:
        mesh.vertex_count = 2;
        break;
    case 2:
        mesh.material = 1;
        break;
    case 3:
        return stp_builder_add_object(builder, &object, NULL);
    case 4:
        object = (stp_object_desc){.parent = 1};
        return stp_builder_add_object(builder, &object, NULL);
    case 5:
        return stp_builder_add_material(builder, &material, &number);
    case 6:
        return stp_builder_add_points(builder, &(stp_points_desc){.positions = corners}, NULL);
    case 7:
        mesh.material = UINT32_MAX;
        break;
    case 8:
        return stp_builder_write(builder, NULL, NULL); // nothing was added
    default:
        return STP_OK;
    }
    return stp_builder_add_mesh(builder, &mesh, NULL);
}

void test_embed_builders_refuse_invalid_input(test_state* test)
{
    test_log log = {0};
    stp_builder* builder = NULL;
    stp_context* context = test_context(NULL, 1, &log);
    bool made = stp_builder_create(context, NULL, &builder) == STP_OK;
    int refused = 0;
    for (int i = 0; made && i < 9; ++i) {
        refused += add_wrong_input(builder, i) == STP_ERROR_ARGUMENT;
    }
    stp_builder_destroy(builder);
    stp_context_destroy(context);
    CHECK_EQUAL(9, refused);
    CHECK_EQUAL(9, log.errors);
}
