// SPDX-License-Identifier: MIT
// Attributes of points in files: round trip of whole and partial columns; damage is detected;
// colours and hidden classes replace the file's own.
#include "support_chunks.h"
#include "support_sample.h"
#include "tests.h"

#include "base/math/color.h"
#include "base/math/rng.h"
#include "store/bytes/columns.h"
#include "store/bytes/values.h"
#include "store/file/content.h"
#include "store/file/store_state.h"
#include "store/residency/residency.h"

#include <string.h>
#include <unistd.h>

enum { POINTS = 40, OCTAVES = 3, ENTRIES = 3 + 12 + POINTS };

// A small cloud, as a set and as points, with all attributes.
typedef struct cloud {
    uint16_t places[3 * POINTS];
    int8_t normals[2 * POINTS];
    uint8_t materials[POINTS], colors[3 * ENTRIES], coverages[ENTRIES];
    uint8_t class[POINTS], number[POINTS], numbers[POINTS];
    uint16_t intensity[POINTS], source[POINTS], infrared[POINTS];
    int16_t angle[POINTS];
    double time[POINTS];
    float positions[3 * POINTS];
    stp_splats set;
    stp_store_point_set points;
    stp_store_node node;
    stp_store_part part;
    stp_store_material material;
    stp_shading shading;
    stp_store_source file;
    stp_store_content content;
} cloud;

static void fill_values(cloud* c)
{
    for (uint32_t i = 0; i < POINTS; ++i) {
        c->class[i] = (uint8_t)(i % 4 == 0 ? 6 : 2);
        c->number[i] = (uint8_t)(1 + i % 3);
        c->numbers[i] = 3;
        c->intensity[i] = (uint16_t)(1000 * i);
        c->source[i] = (uint16_t)(i / 10);
        c->infrared[i] = (uint16_t)(65535 - i);
        c->angle[i] = (int16_t)(150 * (int)i - 3000);
        c->time[i] = 3e8 + 0.125 * i;
        c->positions[3 * i] = (float)i;
    }
    void* const columns[STP_ATTRIBUTES] = {c->intensity, c->class,  c->number, c->numbers,
                                           c->angle,     c->source, c->time,   c->infrared};
    for (int a = 0; a < STP_ATTRIBUTES; ++a) {
        c->set.attributes[a] = columns[a];
        c->points.attributes[a] = columns[a];
    }
}

static void make_cloud(cloud* c)
{
    *c = (cloud){.set = {.count = POINTS,
                         .step = 1.0f,
                         .octave_count = OCTAVES,
                         .octave_ends = {3, 12, POINTS},
                         .table = {.size = 1, .count = {1}, .radius = {4.0f}}},
                 .points = {.name = "scan", .point_count = POINTS},
                 .node = {.part_count = 1, .point_count = POINTS},
                 .part = {.kind = STP_STORE_PART_POINTS},
                 .file = {"a.las", "las", 1234, "EPSG:25832"}};
    c->material.base_color_texture.texture = STP_STORE_NONE;
    c->material.metallic_roughness_texture.texture = STP_STORE_NONE;
    c->material.emissive_texture.texture = STP_STORE_NONE;
    memset(c->colors, 77, sizeof(c->colors));
    memset(c->coverages, 255, sizeof(c->coverages));
    c->coverages[ENTRIES - 1] = 0; // the smallest coverage
    c->set.positions = c->places;
    c->set.normals = c->normals;
    c->set.materials = c->materials;
    c->set.colors = c->colors;
    c->set.coverages = c->coverages;
    c->points.positions = c->positions;
    fill_values(c);
    c->content = (stp_store_content){.directory = {.node_count = 1,
                                                   .nodes = &c->node,
                                                   .part_count = 1,
                                                   .parts = &c->part,
                                                   .material_count = 1,
                                                   .materials = &c->material,
                                                   .shading_count = 1,
                                                   .shadings = &c->shading,
                                                   .set_count = 1,
                                                   .point_set_count = 1,
                                                   .source_count = 1,
                                                   .sources = &c->file,
                                                   .up = 'z'},
                                     .point_sets = &c->points,
                                     .sets = &c->set};
}

// Writes content. @return its bytes, or NULL
static unsigned char* write_content(stp_context* context, const stp_store_content* content,
                                    size_t* size)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_attributes_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    unsigned char* bytes =
        stp_store_write(context, content, path) == STP_OK ? sample_read_file(path, size) : NULL;
    unlink(path);
    return bytes;
}

static stp_store* open_bytes(stp_context* context, const unsigned char* bytes, size_t size)
{
    stp_store* store = NULL;
    stp_store_open_desc desc = {0};
    return stp_store_open_memory(context, "memory", bytes, size, &desc, &store) == STP_OK ? store
                                                                                          : NULL;
}

// Whether values [first, first + count) of the set and of the points are those written.
static bool are_values(stp_store* store, const cloud* c, uint32_t first, uint32_t count)
{
    bool same = true;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        unsigned char got[8 * POINTS];
        size_t size = stp_attribute_size((stp_attribute)a);
        const unsigned char* wanted = (const unsigned char*)c->set.attributes[a] + first * size;
        memset(got, 0xee, sizeof(got));
        same = same &&
               stp_store_get_values(store, 0, (stp_attribute)a, first, count, got) == STP_OK &&
               memcmp(got, wanted, count * size) == 0;
        memset(got, 0xee, sizeof(got));
        same =
            same &&
            stp_store_get_point_values(store, 0, (stp_attribute)a, first, count, got) == STP_OK &&
            memcmp(got, wanted, count * size) == 0;
    }
    return same;
}

void test_store_attributes_come_back(test_state* test)
{
    static cloud c;
    size_t size = 0;
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    make_cloud(&c);
    unsigned char* bytes = write_content(context, &c.content, &size);
    stp_store* store = bytes != NULL ? open_bytes(context, bytes, size) : NULL;
    CHECK(store != NULL);
    CHECK(are_values(store, &c, 0, POINTS) && are_values(store, &c, 11, 3));
    CHECK(are_values(store, &c, 39, 1) && are_values(store, &c, 3, 0));
    CHECK_EQUAL(0xff, stp_store_octave_attributes(store, 0, 2));
    CHECK_EQUAL(0xff, stp_store_point_attributes(store, 0));
    CHECK_EQUAL(0, stp_store_octave_attributes(store, 0, 3));
    unsigned char value[8];
    CHECK_EQUAL(STP_ERROR_ARGUMENT,
                stp_store_get_values(store, 0, STP_ATTRIBUTE_TIME, 40, 1, value));
    CHECK_EQUAL(1, log.errors);

    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(STP_ATTRIBUTES, d->attribute_count);
    const stp_store_attribute* f = stp_store_find_attribute(store, STP_ATTRIBUTE_INTENSITY);
    CHECK(f->count == POINTS && f->low == 0.0 && f->high == 39000.0);
    CHECK(f->low_percentile == 0.0 && f->high_percentile == 39000.0);
    f = stp_store_find_attribute(store, STP_ATTRIBUTE_TIME);
    CHECK(f->low == 3e8 && f->high == 3e8 + 0.125 * 39);
    CHECK_EQUAL(2, d->attribute_value_count);
    CHECK(d->attribute_values[0].value == 2 && d->attribute_values[0].count == 30);
    CHECK(d->attribute_values[1].value == 6 && d->attribute_values[1].count == 10);
    CHECK(strcmp(d->sources[0].coordinate_system, "EPSG:25832") == 0);
    stp_store_close(store);
    free(bytes);
    stp_context_destroy(context);
}

#define GOLDEN STP_TEST_SOURCE_DIR "/tests/golden/store/v1/attributes-1.2.stip"

// STP_WRITE_GOLDEN rewrites the file; only before the format is released.
void test_store_opens_attributes_of_version_1_2_for_ever(test_state* test)
{
    static cloud c;
    stp_store* store = NULL;
    stp_context* context = test_context(NULL, 1, NULL);
    make_cloud(&c);
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        CHECK_EQUAL(STP_OK, stp_store_write(context, &c.content, GOLDEN));
    }
    CHECK_EQUAL(STP_OK, stp_store_open(context, GOLDEN, &store));
    CHECK(are_values(store, &c, 0, POINTS));
    CHECK_EQUAL(STP_ATTRIBUTES, stp_store_get_directory(store)->attribute_count);
    CHECK(strcmp(stp_store_coordinate_system(store), "EPSG:25832") == 0);
    stp_store_close(store);
    CHECK_EQUAL(STP_OK, stp_store_check(context, GOLDEN, false));
    stp_context_destroy(context);
}

// Columns of many chunks; one set without attributes, one with two.
void test_store_attributes_of_many_chunks_come_back(test_state* test)
{
    static chunk_sample made;
    size_t size = 0;
    stp_context* context = test_context(NULL, 4, NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    CHECK(chunk_sample_make(&arena, 2, &made));
    uint32_t count = made.sets[0].count;
    double* time = STP_ARENA_ARRAY(&arena, double, count);
    uint16_t* source = STP_ARENA_ARRAY(&arena, uint16_t, count);
    double* got = STP_ARENA_ARRAY(&arena, double, count);
    CHECK(time != NULL && source != NULL && got != NULL);
    for (uint32_t i = 0; i < count; ++i) {
        time[i] = 1e9 + 1e-6 * (double)(stp_rng_hash(1, i) % 1000000);
        source[i] = (uint16_t)stp_rng_hash(2, i);
    }
    made.sets[0].attributes[STP_ATTRIBUTE_TIME] = time;
    made.sets[0].attributes[STP_ATTRIBUTE_SOURCE] = source;
    unsigned char* bytes = write_content(context, &made.content, &size);
    stp_store* store = bytes != NULL ? open_bytes(context, bytes, size) : NULL;
    CHECK(store != NULL);
    CHECK_EQUAL(STP_OK, stp_store_get_values(store, 0, STP_ATTRIBUTE_TIME, 0, count, got));
    CHECK(memcmp(got, time, 8 * (size_t)count) == 0);
    CHECK_EQUAL(STP_OK, stp_store_get_values(store, 0, STP_ATTRIBUTE_SOURCE, 777, 40000, got));
    CHECK(memcmp(got, source + 777, 2 * (size_t)40000) == 0);
    CHECK_EQUAL(0, stp_store_octave_attributes(store, 1, 0));
    CHECK_EQUAL(STP_OK, stp_store_get_values(store, 1, STP_ATTRIBUTE_SOURCE, 0, 4, got));
    CHECK(got[0] == 0.0);
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    stp_store_close(store);
    free(bytes);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_store_attributes_refuse_every_truncation_and_changed_byte(test_state* test)
{
    static cloud c;
    size_t size = 0;
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    make_cloud(&c);
    unsigned char* bytes = write_content(context, &c.content, &size);
    CHECK(bytes != NULL);
    CHECK_EQUAL(STP_OK, sample_check(context, bytes, size));
    for (size_t length = 0; length < size; ++length) {
        void* copy = NULL;
        CHECK(posix_memalign(&copy, 64, length) == 0); // exactly the file's size
        memcpy(copy, bytes, length);
        log.errors = 0;
        CHECK_EQUAL(STP_ERROR_TRUNCATED, sample_check(context, copy, length));
        CHECK_EQUAL(1, log.errors);
        free(copy);
    }
    for (size_t at = 0; at < size; ++at) {
        bytes[at] ^= 0x55;
        log.errors = 0;
        CHECK(sample_check(context, bytes, size) != STP_OK);
        CHECK_EQUAL(1, log.errors);
        bytes[at] ^= 0x55;
    }
    free(bytes);
    stp_context_destroy(context);
}

void test_store_attributes_survive_failing_allocator(test_state* test)
{
    static cloud c;
    make_cloud(&c);
    int failures = 0;
    for (int n = 0;; ++n) { // fail the n-th allocation, until a run succeeds
        CHECK(n < 2000);
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            CHECK_EQUAL(0, heap.live_bytes);
            continue;
        }
        size_t size = 0;
        stp_store_coloring coloring = {.by_attribute = true, .high = 100.0};
        unsigned char* bytes = write_content(context, &c.content, &size);
        stp_store* store = bytes != NULL ? open_bytes(context, bytes, size) : NULL;
        stp_store_point_set points;
        stp_splats set;
        bool good = store != NULL && stp_store_set_coloring(store, &coloring) == STP_OK &&
                    stp_store_get_splat_set(store, 0, &set) == STP_OK &&
                    stp_store_get_point_set(store, 0, &points) == STP_OK;
        stp_store_close(store);
        stp_context_destroy(context);
        free(bytes);
        CHECK_EQUAL(0, heap.live_bytes);
        if (good && heap.count <= n) {
            break;
        }
        CHECK(good || log.errors == 1);
        failures += good ? 0 : 1;
    }
    CHECK(failures > 20);
}

static bool is_color(const uint8_t* color, double value, double low, double high)
{
    return memcmp(color, stp_color_map[stp_color_map_place(value, low, high)], 3) == 0;
}

// Colours of the set's finest octave and of the points are the intensities; the class of houses is
// hidden.
static const char* find_color_fault(const cloud* c, const stp_splats* set,
                                    const stp_store_point_set* points)
{
    size_t entry = (size_t)stp_store_colors_begin(set, OCTAVES - 1);
    for (uint32_t i = 0; i < POINTS; ++i) {
        bool hidden = c->class[i] == 6;
        if (!is_color(set->colors + 3 * (entry + i), c->intensity[i], 1000.0, 30000.0) ||
            !is_color(points->colors + 4 * (size_t)i, c->intensity[i], 1000.0, 30000.0)) {
            return "colour";
        }
        if ((set->coverages[entry + i] == 0) != hidden ||
            (points->colors[4 * (size_t)i + 3] == 0) != hidden) {
            return "hidden";
        }
    }
    return set->coverages[entry + POINTS - 1] == 1 ? NULL : "smallest coverage";
}

void test_store_coloring_replaces_colors_and_hides_classes(test_state* test)
{
    static cloud c;
    size_t size = 0;
    stp_context* context = test_context(NULL, 1, NULL);
    make_cloud(&c);
    unsigned char* bytes = write_content(context, &c.content, &size);
    stp_store* store = bytes != NULL ? open_bytes(context, bytes, size) : NULL;
    stp_store_coloring coloring = {.by_attribute = true,
                                   .attribute = STP_ATTRIBUTE_INTENSITY,
                                   .low = 1000.0,
                                   .high = 30000.0,
                                   .hides = true};
    coloring.shown[2] = 1;
    stp_splats set;
    stp_store_point_set points;
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &set));
    CHECK(set.colors[0] == 77 && set.coverages[ENTRIES - 1] == 0);
    CHECK_EQUAL(STP_OK, stp_store_set_coloring(store, &coloring));
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(store, 0, 2, &set)); // octave by octave
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &set));
    CHECK_EQUAL(STP_OK, stp_store_get_point_set(store, 0, &points));
    const char* fault = find_color_fault(&c, &set, &points);
    CHECK(fault == NULL);

    // the same with data loaded by threads
    stp_residency* residency = NULL;
    const stp_data_request wants[] = {
        {.kind = STP_RESIDENT_SPLATS, .octaves = OCTAVES, .need = 1.0f},
        {.kind = STP_RESIDENT_POINTS, .need = 1.0f}};
    CHECK_EQUAL(STP_OK, stp_residency_create(store, &(stp_residency_desc){0}, &residency));
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_set_coloring(store, NULL));
    do {
        stp_residency_update(residency, wants, 2);
    } while (stp_residency_wait(residency));
    stp_residency_update(residency, wants, 2);
    CHECK_EQUAL(POINTS, stp_store_resident_splats(store, 0));
    CHECK(stp_store_are_points_resident(store, 0));
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &set));
    CHECK_EQUAL(STP_OK, stp_store_get_point_set(store, 0, &points));
    CHECK(find_color_fault(&c, &set, &points) == NULL);
    stp_residency_destroy(residency);

    CHECK_EQUAL(STP_OK, stp_store_set_coloring(store, NULL)); // back to the file's colours
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &set));
    CHECK_EQUAL(STP_OK, stp_store_get_point_set(store, 0, &points));
    CHECK(memcmp(set.colors, c.colors, sizeof(c.colors)) == 0 && points.colors == NULL);
    CHECK(memcmp(set.coverages, c.coverages, sizeof(c.coverages)) == 0);
    stp_store_close(store);
    free(bytes);
    stp_context_destroy(context);
}
