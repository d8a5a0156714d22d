// SPDX-License-Identifier: MIT
#include "exhaustive.h"
#include "las_points.h"

#include "import/las/las.h"

enum { COUNT = 3000 };

static las_point points[COUNT];

static int imports_right(const las_desc* desc, uint32_t threads)
{
    las_buffer file = las_write(desc);
    test_log log = {0};
    stp_context* context = test_context(NULL, threads, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    int good = scene != NULL && scene_is_sound(scene) && scene->point_set_count == 1 &&
               scene->point_sets[0].point_count == desc->count &&
               las_set_is_right(desc, &scene->point_sets[0], 0, &scene->objects[0].transform);
    if (!good) {
        fprintf(stderr, "format %u, coding %d, %u extra bytes: result %d, \"%s\"\n", desc->format,
                desc->coding, desc->extra, result, log.text);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
    return good;
}

void test_las_reads_every_format(test_state* test)
{
    for (unsigned format = 0; format <= 10; ++format) {
        las_make_points(points, COUNT, format, format + 1);
        for (unsigned extra = 0; extra < 10; extra += 5) {
            las_desc desc = {.points = points, .count = COUNT, .format = format, .extra = extra};
            CHECK(imports_right(&desc, 2));
        }
    }
}

void test_laz_reads_every_format(test_state* test)
{
    for (unsigned format = 0; format <= 10; ++format) {
        las_make_points(points, COUNT, format, format + 1);
        for (int coding = format < 6 ? LAZ_SINGLE : LAZ_CHUNKED; coding <= LAZ_VARIABLE; ++coding) {
            unsigned stride = (unsigned)test_stride(4); // else one kind, another for each format
            unsigned first = stride == 1 ? 0 : (format + (unsigned)coding) % 4;
            for (unsigned kind = first; kind < 4; kind += stride) {
                las_desc desc = {.points = points,
                                 .count = COUNT - kind,
                                 .format = format,
                                 .coding = (las_coding)coding,
                                 .chunk_size = 1000 - kind,
                                 .table_at_end = kind % 2 == 1,
                                 .extra = kind / 2 * 5,
                                 .fixed = format >= 6 && kind < 2};
                CHECK(imports_right(&desc, 3));
            }
        }
    }
}

// Steps of every size, up to the maximum, in each of the values.
void test_laz_reads_steps_of_every_size(test_state* test)
{
    for (unsigned format = 3; format <= 8; format += 5) {
        las_make_points(points, COUNT, format, 99);
        for (size_t i = 0; i < COUNT; ++i) {
            uint32_t step = 1u << i % 32;
            points[i].position[i % 3] = (int32_t)(i % 2 ? step : ~step);
            points[i].position[(i + 1) % 3] = i % 7 == 0 ? INT32_MIN : INT32_MAX;
            points[i].time = i % 5 == 0 ? (uint64_t)step << 31 : points[i].time + step;
        }
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = format,
                         .coding = LAZ_CHUNKED,
                         .chunk_size = 2900,
                         .scale = 1e-6};
        CHECK(imports_right(&desc, 1));
    }
}

// One value after the other is constant in all points: such a layer has no bytes.
void test_laz_reads_layers_without_bytes(test_state* test)
{
    for (int kind = 0; kind < 8; ++kind) {
        las_make_points(points, COUNT, 8, 5);
        for (size_t i = 0; i < COUNT; ++i) {
            points[i].position[2] = kind == 0 ? 5 : points[i].position[2];
            points[i].class = kind == 1 ? 5 : points[i].class;
            points[i].intensity = kind == 2 ? 5 : points[i].intensity;
            points[i].angle = kind == 3 ? 5 : points[i].angle;
            points[i].source = kind == 4 ? 5 : points[i].source;
            points[i].time = kind == 5 ? 5 : points[i].time;
            points[i].rgb[0] = kind == 6 ? 500 : points[i].rgb[0];
            points[i].rgb[1] = kind == 6 ? 600 : points[i].rgb[1];
            points[i].rgb[2] = kind == 6 ? 700 : points[i].rgb[2];
            points[i].nir = kind == 7 ? 5 : points[i].nir;
        }
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = 8,
                         .coding = LAZ_CHUNKED,
                         .fixed = true,
                         .chunk_size = 1000};
        CHECK(imports_right(&desc, 1));
    }
}

static stp_scene* import_desc(stp_context* context, const las_desc* desc, stp_result* result)
{
    las_buffer file = las_write(desc);
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, result);
    free(file.bytes);
    return scene;
}

// 8-bit values in 16-bit colour fields; a file whose first points look 8-bit; a file with all other
// fields zero too.
void test_las_judges_colors(test_state* test)
{
    for (int kind = 0; kind < 3; ++kind) {
        las_make_points(points, COUNT, 2, 7);
        for (size_t i = 0; i < COUNT; ++i) {
            for (int k = 0; k < 3; ++k) {
                points[i].rgb[k] = kind == 2 ? 0 : points[i].rgb[k] >> 8;
            }
            points[i].intensity = kind == 2 ? 0 : points[i].intensity;
        }
        points[COUNT - 1].rgb[1] = kind == 1 ? 0x1234 : points[COUNT - 1].rgb[1];
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = 2,
                         .coding = LAZ_CHUNKED,
                         .chunk_size = 1500};
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene = import_desc(context, &desc, &result);
        CHECK_EQUAL(STP_OK, result);
        const stp_point_set* set = &scene->point_sets[0];
        CHECK_EQUAL(kind != 2, set->colors != NULL);
        CHECK_EQUAL(kind != 2, set->attributes[STP_ATTRIBUTE_INTENSITY] != NULL);
        for (size_t i = 0; i < 4 * COUNT && kind != 2; ++i) {
            unsigned value = i % 4 == 3 ? 255 : points[i / 4].rgb[i % 4];
            CHECK_EQUAL(kind == 1 && i % 4 != 3 ? value >> 8 : value, set->colors[i]);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_las_is_the_same_on_any_number_of_threads(test_state* test)
{
    for (unsigned format = 3; format <= 8; format += 5) {
        las_make_points(points, COUNT, format, 12);
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = format,
                         .coding = LAZ_VARIABLE,
                         .chunk_size = 50};
        stp_hash one = {0};
        for (uint32_t threads = 1; threads <= 5; ++threads) {
            stp_context* context = test_context(NULL, threads, NULL);
            stp_result result;
            stp_scene* scene = import_desc(context, &desc, &result);
            CHECK_EQUAL(STP_OK, result);
            stp_hash now = digest_scene(scene);
            one = threads == 1 ? now : one;
            CHECK(stp_hash_equal(one, now));
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}

static stp_result import_in_sets(stp_scene* scene, las_buffer file, uint64_t points_in_set)
{
    stp_import import = {.context = scene->context,
                         .scene = scene,
                         .path = "a.las",
                         .file = {.bytes = file.bytes, .size = file.size},
                         .alone = true};
    stp_source source = {.path = "a.las", .format = "las"};
    stp_object root = {.name = "a", .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_source(scene, &source);
    result = result == STP_OK ? stp_scene_add_object(scene, &root, &import.root) : result;
    return result == STP_OK ? stp_las_import(&import, points_in_set) : result;
}

// Files with more points than a set holds give several sets of one object, in memory or in the
// spill file.
void test_las_splits_large_files_into_sets(test_state* test)
{
    for (int spills = 0; spills < 2; ++spills) {
        las_make_points(points, COUNT, 3, 21);
        las_desc desc = {.points = points,
                         .count = COUNT,
                         .format = 3,
                         .coding = LAZ_CHUNKED,
                         .chunk_size = 400};
        las_buffer file = las_write(&desc);
        stp_context* context = test_context(NULL, 3, NULL);
        stp_scene* scene = NULL;
        stp_spill* spill = NULL;
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        if (spills == 1) {
            CHECK_EQUAL(STP_OK, stp_spill_create(context, ".", &spill));
            stp_scene_use_spill(scene, spill, 1);
        }
        CHECK_EQUAL(STP_OK, import_in_sets(scene, file, 1000));
        CHECK_EQUAL(4, scene->point_set_count); // with 800, 800, 800 and 600 points
        CHECK_EQUAL(4, scene->objects[0].part_count);
        size_t first = 0;
        for (size_t i = 0; i < 4; ++i) {
            const stp_point_set* set = &scene->point_sets[i];
            CHECK_EQUAL(spills, set->spilled);
            CHECK(las_set_is_right(&desc, set, first, &scene->objects[0].transform));
            first += set->point_count;
        }
        CHECK_EQUAL(COUNT, first);
        stp_scene_destroy(scene);
        stp_spill_destroy(spill);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

// A sparse file of 5 billion points: no offset may overflow.
void test_las_addresses_more_than_32_bits(test_state* test)
{
    const uint64_t count = 5000000000u;
    las_make_points(points, 2, 6, 1);
    las_desc desc = {.points = points, .count = 2, .format = 6};
    las_buffer file = las_write(&desc);
    memcpy(file.bytes + 247, &count, 8);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_import import = {.context = context,
                         .path = "a.las",
                         .file = {.bytes = file.bytes, .size = 375 + count * 30}};
    stp_las las = {.import = &import, .context = context};
    CHECK_EQUAL(STP_OK, stp_las_read_header(&las));
    CHECK_EQUAL(count, las.point_count);
    CHECK_EQUAL(STP_OK, stp_las_list_records(&las));
    const stp_las_chunk* last = &las.chunks[las.chunk_count - 1];
    CHECK_EQUAL(count, last->first + last->count);
    CHECK_EQUAL(375 + count * 30, last->offset + last->size);
    uint64_t sum = 0, sets = 0;
    for (size_t first = 0; first < las.chunk_count; ++sets) {
        uint64_t in_set;
        first += stp_las_chunks_of_set(&las, first, (uint64_t)1 << 27, &in_set);
        CHECK(in_set <= (uint64_t)1 << 27);
        sum += in_set;
    }
    CHECK_EQUAL(count, sum);
    CHECK_EQUAL(38, sets);
    import.file.size -= 1; // half a record is missing
    CHECK_EQUAL(STP_ERROR_TRUNCATED, stp_las_read_header(&las));
    stp_free(context, las.chunks);
    stp_context_destroy(context);
    free(file.bytes);
}
