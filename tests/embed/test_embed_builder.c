// SPDX-License-Identifier: MIT
// What a builder refuses, keeps and reports: descriptors, materials, methods, files and reports.
#include "support_embed.h"

#include "store/file/store.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

void test_embed_builders_check_their_descriptors(test_state* test)
{
    static const struct {
        char up;
        double unit;
        stp_result result;
    } cases[] = {{0, 0.0, STP_OK},
                 {'z', 0.001, STP_OK},
                 {'X', 1.0, STP_OK},
                 {'q', 1.0, STP_ERROR_ARGUMENT},
                 {'y', -1.0, STP_ERROR_ARGUMENT},
                 {'y', (double)NAN, STP_ERROR_ARGUMENT},
                 {'y', (double)INFINITY, STP_ERROR_ARGUMENT}};
    stp_context* context = test_context(NULL, 1, NULL);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_builder* builder = NULL;
        stp_builder_desc desc = {.up = cases[i].up, .unit_metres = cases[i].unit};
        CHECK_EQUAL(cases[i].result, stp_builder_create(context, &desc, &builder));
        CHECK((builder != NULL) == (cases[i].result == STP_OK));
        stp_builder_destroy(builder);
    }
    stp_context_destroy(context);
}

/// A material with one value out of range; false after the last.
static bool make_invalid_material(int which, stp_material_desc* desc, stp_image* picture)
{
    static uint8_t pixels[4 * 4];
    *picture = (stp_image){2, 2, pixels};
    *desc = (stp_material_desc){.base_color = {1, 1, 1, 1}};
    switch (which) {
    case 0:
        desc->base_color[3] = -0.1f;
        return true;
    case 1:
        desc->base_color[0] = NAN;
        return true;
    case 2:
        desc->emissive[2] = INFINITY;
        return true;
    case 3:
        desc->metallic = 1.01f;
        return true;
    case 4:
        desc->metallic = -1.0f;
        return true;
    case 5:
        desc->roughness = NAN;
        return true;
    case 6:
        desc->alpha_cutoff = -0.5f;
        return true;
    case 7:
        picture->pixels = NULL;
        break;
    case 8:
        picture->width = 0;
        break;
    case 9:
        picture->height = 0;
        break;
    case 10:
        picture->width = 65537;
        break;
    case 11:
        picture->height = 65537;
        break;
    case 12:
        desc->picture_stride = 7;
        break;
    default:
        return false;
    }
    desc->picture = picture;
    return true;
}

void test_embed_builders_refuse_invalid_materials(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_builder* builder = NULL;
    stp_material_desc desc;
    stp_image picture;
    CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
    int count = 0;
    for (; make_invalid_material(count, &desc, &picture); ++count) {
        uint32_t number = 77;
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_add_material(builder, &desc, &number));
        CHECK_EQUAL(count + 1, log.errors);
        CHECK_EQUAL(77, number);
    }
    CHECK_EQUAL(13, count);
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}

/// Builds a triangle of each material in memory, and opens it; NULL on failure.
static stp_store* build_materials(stp_builder* builder, const stp_material_desc* descs,
                                  uint32_t count, stp_context* context)
{
    stp_store* store = NULL;
    size_t size = 0;
    bool good = true;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t number = 0;
        good = good && stp_builder_add_material(builder, &descs[i], &number) == STP_OK &&
               number == i + 1;
        const stp_mesh_desc mesh = {
            .positions = corners, .vertex_count = 3, .triangle_count = 1, .material = number};
        good = good && stp_builder_add_mesh(builder, &mesh, NULL) == STP_OK;
    }
    good = good && stp_builder_write(builder, NULL, NULL) == STP_OK;
    const void* bytes = stp_builder_get_bytes(builder, &size);
    good = good && stp_store_open_memory(context, "memory", bytes, size, &(stp_store_open_desc){0},
                                         &store) == STP_OK;
    return good ? store : NULL;
}

void test_embed_builders_keep_materials(test_state* test)
{
    const stp_material_desc descs[] = {
        {.name = "plain"},
        {.name = "metal",
         .base_color = {0.5f, 0.25f, 0.125f, 0.75f},
         .metallic = 1.0f,
         .roughness = 0.25f,
         .transparent = true,
         .double_sided = true},
        {.name = "lamp", .emissive = {1, 2, 3}, .alpha_cutoff = 0.5f, .unlit = true}};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_builder* builder = NULL;
    CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
    stp_store* store = build_materials(builder, descs, 3, context);
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK(d->material_count >= 3); // in their order, after those that every file has
    const stp_store_material* plain = &d->materials[d->material_count - 3];
    const stp_store_material *metal = plain + 1, *lamp = plain + 2;
    CHECK(plain->base_color[0] == 1.0f && plain->base_color[3] == 1.0f);
    CHECK(plain->metallic == 0.0f && plain->roughness == 1.0f && plain->flags == 0);
    CHECK(memcmp(metal->base_color, descs[1].base_color, sizeof(metal->base_color)) == 0);
    CHECK(metal->metallic == 1.0f && metal->roughness == 0.25f);
    CHECK(metal->alpha == STP_STORE_BLEND && metal->flags == STP_SHADING_DOUBLE_SIDED);
    CHECK(lamp->emissive[0] == 1.0f && lamp->emissive[2] == 3.0f && lamp->alpha_cutoff == 0.5f);
    CHECK(lamp->alpha == STP_STORE_MASK && lamp->flags == STP_SHADING_UNLIT);
    CHECK(lamp->roughness == 1.0f && lamp->base_color[1] == 1.0f); // the defaults
    stp_store_close(store);
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}

/// Writes the town with these methods. @return the result; `*count` receives the file's methods
static stp_result write_methods(stp_context* context, const char* methods, uint32_t* count)
{
    stp_builder* builder = NULL;
    stp_write_desc desc = {.methods = methods, .threshold = 100, .splat_limit = 64};
    size_t size = 0;
    *count = 0;
    stp_result result = stp_builder_create(context, NULL, &builder);
    result = result == STP_OK ? embed_add_town(builder, false) : result;
    result = result == STP_OK ? stp_builder_write(builder, &desc, NULL) : result;
    const void* bytes = result == STP_OK ? stp_builder_get_bytes(builder, &size) : NULL;
    stp_store* store = NULL;
    if (bytes != NULL && stp_store_open_memory(context, "memory", bytes, size,
                                               &(stp_store_open_desc){0}, &store) == STP_OK) {
        *count = stp_store_offered_methods(stp_store_get_directory(store));
        stp_store_close(store);
    }
    // a builder builds once, but is as before if the methods are refused
    bool refused = result == STP_ERROR_ARGUMENT;
    desc.methods = NULL;
    bool good = stp_builder_write(builder, &desc, NULL) == (refused ? STP_OK : STP_ERROR_ARGUMENT);
    good = good && stp_builder_add_file(builder, "a.obj") == STP_ERROR_ARGUMENT;
    stp_builder_destroy(builder);
    return good ? result : STP_ERROR_BUSY;
}

void test_embed_builders_take_each_method_once(test_state* test)
{
    static const struct {
        const char* names;
        uint32_t count; ///< 0: refused
    } cases[] = {{"blue", 1},      {"psp", 1},  {"spt,blue", 2}, {"blue,spt,psp", 3},
                 {"blue,blue", 0}, {"", 0},     {"blue,", 0},    {",blue", 0},
                 {"zebra", 0},     {"Blue", 0}, {"blue spt", 0}, {"blue,spt,psp,stochastic,x", 0}};
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        uint32_t count;
        log = (test_log){0};
        stp_result result = write_methods(context, cases[i].names, &count);
        CHECK_EQUAL(cases[i].count > 0 ? STP_OK : STP_ERROR_ARGUMENT, result);
        CHECK_EQUAL(cases[i].count, count);
    }
    stp_context_destroy(context);
}

static stp_result write_town(stp_context* context, const stp_write_desc* desc,
                             stp_write_report* report)
{
    stp_builder* builder = NULL;
    size_t size = 1;
    stp_result result = stp_builder_create(context, NULL, &builder);
    result = result == STP_OK ? embed_add_town(builder, false) : result;
    result = result == STP_OK ? stp_builder_write(builder, desc, report) : result;
    if (result == STP_OK && desc->path != NULL && stp_builder_get_bytes(builder, &size) != NULL) {
        result = STP_ERROR_FORMAT; // the bytes are in the file
    }
    stp_builder_destroy(builder);
    return result;
}

void test_embed_builders_report_files_and_reuse_them(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_write_desc desc = {.path = "town.stip", .threshold = 100, .splat_limit = 64};
    stp_write_report first = {.struct_size = sizeof(first)}, again = first, other = first;
    struct stat status;
    CHECK_EQUAL(STP_OK, write_town(context, &desc, &first));
    CHECK(stat(desc.path, &status) == 0 && first.file_bytes == (uint64_t)status.st_size);
    CHECK(first.sets_made > 0 && first.sets_found == 0 && first.seconds > 0.0);
    CHECK_EQUAL(STP_OK, write_town(context, &desc, &again));
    CHECK(again.sets_made == 0 && again.sets_found == first.sets_made);
    CHECK_EQUAL(first.file_bytes, again.file_bytes);
    desc.fresh = true;
    CHECK_EQUAL(STP_OK, write_town(context, &desc, &again));
    CHECK(again.sets_made == first.sets_made && again.sets_found == 0);
    desc.path = NULL;
    CHECK_EQUAL(STP_OK, write_town(context, &desc, &other));
    CHECK_EQUAL(first.file_bytes, other.file_bytes);
    unlink("town.stip");
    stp_context_destroy(context);
}

void test_embed_builders_name_the_folder_that_fails(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    const stp_write_desc desc = {.folder = "nowhere/at all"};
    CHECK_EQUAL(STP_ERROR_IO, write_town(context, &desc, NULL));
    CHECK(log.errors == 1 && strstr(log.text, "nowhere/at all/stipple-") != NULL);
    stp_context_destroy(context);
}

void test_embed_builders_join_files_and_parts(test_state* test)
{
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    stp_context* context = test_context(NULL, 1, NULL);
    FILE* file = fopen("scene:odd.obj", "w"); // a file, whatever it is called
    CHECK(file != NULL && fputs(obj, file) >= 0 && fclose(file) == 0);
    for (int parts = 0; parts < 2; ++parts) {
        stp_builder* builder = NULL;
        stp_store* store = NULL;
        size_t size = 0;
        const stp_mesh_desc mesh = {.positions = corners, .vertex_count = 3, .triangle_count = 1};
        CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
        CHECK_EQUAL(STP_OK, stp_builder_add_file(builder, "scene:odd.obj"));
        CHECK(!parts || stp_builder_add_mesh(builder, &mesh, NULL) == STP_OK);
        CHECK_EQUAL(STP_OK, stp_builder_write(builder, NULL, NULL));
        const void* bytes = stp_builder_get_bytes(builder, &size);
        CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "memory", bytes, size,
                                                  &(stp_store_open_desc){0}, &store));
        const stp_store_directory* d = stp_store_get_directory(store);
        CHECK_EQUAL(parts ? 2 : 1, d->source_count);
        CHECK(strcmp(d->sources[d->source_count - 1].path, "./scene:odd.obj") == 0);
        stp_store_close(store);
        stp_builder_destroy(builder);
    }
    stp_context_destroy(context);
}

void test_embed_builders_check_counts(test_state* test)
{
    const size_t most = SIZE_MAX / 64;
    const stp_mesh_desc meshes[] = {
        {.positions = NULL, .vertex_count = 3, .triangle_count = 1},
        {.positions = corners, .vertex_count = 0, .triangle_count = 1},
        {.positions = corners, .vertex_count = 3, .triangle_count = 0},
        {.positions = corners, .vertex_count = most, .triangle_count = 1},
        {.positions = corners, .vertex_count = 3, .triangle_count = most},
        {.positions = corners, .vertex_count = 5, .triangle_count = 2}};
    const stp_points_desc points[] = {{.positions = NULL, .point_count = 3},
                                      {.positions = corners, .point_count = 0},
                                      {.positions = corners, .point_count = UINT32_MAX}};
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_builder* builder = NULL;
    uint32_t part = 0;
    CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
    for (size_t i = 0; i < sizeof(meshes) / sizeof(meshes[0]); ++i) {
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_add_mesh(builder, &meshes[i], &part));
    }
    for (size_t i = 0; i < sizeof(points) / sizeof(points[0]); ++i) {
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_add_points(builder, &points[i], &part));
    }
    CHECK_EQUAL(0, part);
    CHECK_EQUAL(9, log.errors);
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}

// Normals without a length are accepted, and times that are no numbers become zeros.
void test_embed_builders_clean_values(test_state* test)
{
    const float normals[9] = {0, 0, 4, 0, 0, 0, NAN, 1, 0};
    const double times[3] = {(double)NAN, 7.5, (double)INFINITY};
    const stp_points_desc desc = {.positions = corners,
                                  .normals = normals,
                                  .point_count = 3,
                                  .attributes = {[STP_ATTRIBUTE_TIME] = times}};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_builder* builder = NULL;
    stp_model* model = NULL;
    size_t size = 0;
    uint32_t part = 0;
    CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
    CHECK_EQUAL(STP_OK, stp_builder_add_points(builder, &desc, &part));
    CHECK_EQUAL(1, part);
    CHECK_EQUAL(STP_OK, stp_builder_write(builder, NULL, NULL));
    const void* bytes = stp_builder_get_bytes(builder, &size);
    CHECK_EQUAL(STP_OK,
                stp_model_open(context, &(stp_model_desc){.bytes = bytes, .size = size}, &model));
    stp_attribute_info info = {.struct_size = sizeof(info)};
    CHECK_EQUAL(STP_OK, stp_model_get_attribute(model, STP_ATTRIBUTE_TIME, &info));
    CHECK(info.count == 3 && info.low == 0.0 && info.high == 7.5);
    stp_model_close(model);
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}
