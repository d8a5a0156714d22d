// SPDX-License-Identifier: MIT
// The origin of positions lies where most points are (src/import/reading/place_sample.h): a first
// point at 0, 0, 0 in a file of national coordinates takes the digits of no other.
#include "formats_test.h"
#include "las_writer.h"

#include "import/reading/place_sample.h"

#include <stdarg.h>

enum { POINTS = 400, ROOM = 1 << 16 };
#define STEP 0.01 // between neighbours, along the second axis

typedef struct text {
    char bytes[ROOM];
    size_t size;
} text;

__attribute__((format(printf, 2, 3))) static void put(text* t, const char* format, ...)
{
    va_list values;
    va_start(values, format);
    t->size += (size_t)vsnprintf(t->bytes + t->size, ROOM - t->size, format, values);
    va_end(values);
}

// The first `strays` points are at the origin of the file.
static void place_of(int i, int strays, double place[3])
{
    place[0] = i < strays ? 0.0 : 500000.25;
    place[1] = i < strays ? 0.0 : 4500000.0 + STEP * i;
    place[2] = i < strays ? 0.0 : 100.0;
}

static void put_places(text* t, int strays, const char* before, const char* behind)
{
    for (int i = 0; i < POINTS; ++i) {
        double p[3];
        place_of(i, strays, p);
        put(t, "%s%.2f %.2f %.2f%s\n", before, p[0], p[1], p[2], behind);
    }
}

static void put_doubles(text* t, int strays)
{
    for (int i = 0; i < POINTS; ++i) {
        double p[3];
        place_of(i, strays, p);
        memcpy(t->bytes + t->size, p, sizeof(p));
        t->size += sizeof(p);
    }
}

static void write_file(const char* name, int strays, text* t)
{
    const char* type = strrchr(name, '.') + 1;
    bool binary = name[0] == 'b';
    const char* ply = "ply\nformat %s 1.0\nelement vertex %d\nproperty double x\nproperty double "
                      "y\nproperty double z\nend_header\n";
    t->size = 0;
    if (strcmp(type, "xyz") == 0) {
        put_places(t, strays, "", "");
    } else if (strcmp(type, "ptx") == 0) {
        put(t, "%d\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", POINTS);
        put_places(t, strays, "", " 0.5");
    } else if (strcmp(type, "obj") == 0) {
        put_places(t, strays, "v ", "");
    } else if (strcmp(type, "ply") == 0) {
        put(t, ply, binary ? "binary_little_endian" : "ascii", POINTS);
        binary ? put_doubles(t, strays) : put_places(t, strays, "", "");
    } else {
        put(t,
            "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH %d\nHEIGHT 1\nPOINTS %d\n"
            "DATA %s\n",
            POINTS, POINTS, binary ? "binary" : "ascii");
        binary ? put_doubles(t, strays) : put_places(t, strays, "", "");
    }
}

/// Whether the steps between the points after the strays are those of the file.
static bool keeps_steps(const stp_scene* scene, int strays)
{
    const stp_point_set* set = scene->point_set_count == 1 ? &scene->point_sets[0] : NULL;
    bool good = set != NULL && set->point_count >= POINTS - 1;
    uint32_t steps = (uint32_t)(POINTS - strays);
    const float* last = good ? set->positions + 3 * ((size_t)set->point_count - 1) : NULL;
    for (uint32_t i = 2; good && i < set->point_count && i <= steps; ++i) {
        const float* p = set->positions + 3 * (size_t)(set->point_count - i);
        good = fabs((double)last[1] - (double)p[1] - STEP * (i - 1)) < 0.001;
    }
    return good;
}

void test_places_of_most_points_choose_the_origin(test_state* test)
{
    static const char* const names[] = {"a.xyz", "a.ptx", "a.obj", "a.ply",
                                        "b.ply", "a.pcd", "b.pcd"};
    static text t;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); ++i) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        write_file(names[i], 1, &t);
        stp_scene* scene = import_bytes(context, names[i], t.bytes, t.size, &result);
        if (scene == NULL || !keeps_steps(scene, 1)) {
            fprintf(stderr, "%s: result %d\n", names[i], result);
        }
        CHECK(scene != NULL && keeps_steps(scene, 1));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Strays may be more than the sample, so that it is spread over the file.
void test_places_of_many_strays_do_not_choose_the_origin(test_state* test)
{
    static const char* const names[] = {"a.xyz", "a.obj", "b.ply", "a.pcd", "b.pcd"};
    static text t;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); ++i) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        write_file(names[i], POINTS / 4, &t);
        stp_scene* scene = import_bytes(context, names[i], t.bytes, t.size, &result);
        CHECK(scene != NULL && keeps_steps(scene, POINTS / 4));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_places_of_most_points_choose_the_origin_of_las(test_state* test)
{
    static las_point points[POINTS];
    for (int i = 0; i < POINTS; ++i) {
        double p[3];
        place_of(i, 1, p);
        for (int k = 0; k < 3; ++k) {
            points[i].position[k] = (int32_t)floor(100.0 * p[k] + 0.5);
        }
        points[i].return_number = points[i].return_count = 1;
    }
    for (int coding = LAS_RAW; coding <= LAZ_CHUNKED; ++coding) {
        las_desc desc = {
            .points = points, .count = POINTS, .coding = (las_coding)coding, .chunk_size = 50};
        las_buffer file = las_write(&desc);
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
        CHECK(scene != NULL && keeps_steps(scene, 1));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        free(file.bytes);
    }
}

void test_place_samples_have_a_middle(test_state* test)
{
    stp_place_sample sample = {0};
    double middle[3] = {1.0, 1.0, 1.0};
    stp_place_sample_choose(&sample, middle);
    CHECK(middle[0] == 0.0 && middle[1] == 0.0 && middle[2] == 0.0);
    for (int i = 0; i < 200; ++i) {
        double x = i % 3 == 0 ? (double)NAN : i % 3 == 1 ? 1e9 : 5.0;
        stp_place_sample_add(&sample, (double[3]){x, i % 4 == 1 ? -7.0 : 8.0, i});
    }
    CHECK_EQUAL(STP_PLACE_SAMPLES, sample.count);
    stp_place_sample_choose(&sample, middle);
    CHECK(middle[0] == 1e9 && middle[1] == -7.0 && middle[2] == 1.0); // the first, which is near
    for (int i = 0; i < 20; ++i) {
        sample = (stp_place_sample){0};
        for (int k = 0; k < 20; ++k) {
            stp_place_sample_add(&sample, (double[3]){k == i ? 0.0 : 5e5, k, 4e6 + k});
        }
        stp_place_sample_choose(&sample, middle);
        CHECK(middle[0] == 5e5 && middle[1] == 0.0 && middle[2] == 4e6);
    }
    for (size_t count = 1; count < 1000; ++count) {
        size_t last = 0;
        for (uint32_t i = 0; i < STP_PLACE_SAMPLES; ++i) {
            size_t at = stp_place_sample_index(i, count);
            CHECK(at >= last && at < count);
            last = at;
        }
    }
}
