// SPDX-License-Identifier: MIT
//
// Clouds from a file to a picture: the same points as LAS, LAZ, E57 and XYZ are built with all four
// methods and drawn. For every format, a picture shows what the original points show.
#include "builder/build_scene.h"
#include "draw/draw.h"
#include "import/e57_writer.h"
#include "import/las_points.h"
#include "lod/method.h"
#include "select/camera.h"

#include <math.h>
#include <string.h>

enum { POINTS = 4000, SIDE = 96, FORMATS = 4, PIXEL_BYTES = 4 * SIDE * SIDE };

static const char* const names[FORMATS] = {"cloud.las", "cloud.laz", "cloud.e57", "cloud.xyz"};

/// A ball of radius 1 m in millimetres, which all formats hold exactly.
static void make_points(las_point points[POINTS])
{
    for (int i = 0; i < POINTS; ++i) {
        double z = 1.0 - (2.0 * i + 1.0) / POINTS, r = sqrt(1.0 - z * z), angle = 2.39996323 * i;
        points[i] = (las_point){.position = {(int32_t)lrint(1000.0 * r * cos(angle)),
                                             (int32_t)lrint(1000.0 * r * sin(angle)),
                                             (int32_t)lrint(1000.0 * z)},
                                .return_number = 1,
                                .return_count = 1,
                                .class = 2};
    }
}

static bool write_bytes(const char* name, const void* bytes, size_t size)
{
    FILE* file = fopen(name, "wb");
    bool written = file != NULL && bytes != NULL && fwrite(bytes, 1, size, file) == size;
    return file != NULL && fclose(file) == 0 && written;
}

static bool write_las(const las_point points[POINTS], const char* name, las_coding coding)
{
    las_desc desc = {.points = points,
                     .count = POINTS,
                     .format = 6,
                     .coding = coding,
                     .chunk_size = 1500,
                     .scale = 0.001};
    las_buffer file = las_write(&desc);
    bool written = write_bytes(name, file.bytes, file.size);
    free(file.bytes);
    return written;
}

static bool write_e57(const las_point points[POINTS], const char* name)
{
    static uint64_t values[3][POINTS];
    for (int i = 0; i < POINTS; ++i) {
        for (int k = 0; k < 3; ++k) {
            double value = points[i].position[k] * 0.001;
            memcpy(&values[k][i], &value, sizeof(value));
        }
    }
    const e57_stream streams[] = {{64, values[0]}, {64, values[1]}, {64, values[2]}};
    e57_file file = e57_begin();
    char xml[2048];
    size_t size;
    unsigned long long offset = e57_add_points(&file, streams, 3, POINTS, 4000);
    snprintf(xml, sizeof(xml),
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
             "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\"><data3D type=\"Vector\">"
             "<vectorChild type=\"Structure\"><points type=\"CompressedVector\" "
             "fileOffset=\"%llu\" recordCount=\"%d\"><prototype type=\"Structure\">"
             "<cartesianX type=\"Float\"/><cartesianY type=\"Float\"/><cartesianZ "
             "type=\"Float\"/></prototype><codecs type=\"Vector\"/></points></vectorChild>"
             "</data3D></e57Root>\n",
             offset, (int)POINTS);
    unsigned char* bytes = e57_finish(&file, xml, &size);
    bool written = write_bytes(name, bytes, size);
    free(bytes);
    return written;
}

static bool write_xyz(const las_point points[POINTS], const char* name)
{
    FILE* file = fopen(name, "w");
    for (int i = 0; file != NULL && i < POINTS; ++i) {
        const int32_t* p = points[i].position;
        fprintf(file, "%.3f %.3f %.3f\n", p[0] * 0.001, p[1] * 0.001, p[2] * 0.001);
    }
    return file != NULL && fclose(file) == 0;
}

static stp_result build(stp_context* context, const char* input)
{
    const stp_method* methods[STP_METHOD_COUNT];
    for (uint32_t i = 0; i < STP_METHOD_COUNT; ++i) {
        methods[i] = &stp_methods[i];
    }
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = "cloud.stip",
                           .methods = methods,
                           .method_count = STP_METHOD_COUNT,
                           .method_options = stp_method_options_default(),
                           .threshold = 1};
    return stp_build(context, &desc, NULL);
}

/// Draws the ball with transparent surroundings. @return the number of covered pixels, 0 on failure
static uint32_t draw(stp_context* context, stp_store* store, stp_quality quality, uint8_t* pixels)
{
    static const stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    stp_view view = {.width = SIDE, .height = SIDE, .fov_degrees = 40};
    stp_image image = {SIDE, SIDE, pixels};
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_draw_style style = {0};
    bool drawn = stp_camera_frame("iso", &box, &view) &&
                 stp_draw_cpu_create(context, store, &renderer) == STP_OK &&
                 stp_select(context, store, &view, &quality, &list) == STP_OK &&
                 stp_renderer_draw(renderer, &view, &list, &style, &image, &stats) == STP_OK;
    stp_renderer_destroy(renderer);
    stp_draw_list_destroy(context, &list);
    uint32_t covered = 0;
    for (int i = 0; drawn && i < SIDE * SIDE; ++i) {
        covered += pixels[4 * i + 3] > 127;
    }
    return covered;
}

/// Pixels that picture `a` covers and `b` does not.
static uint32_t count_missing(const uint8_t* a, const uint8_t* b)
{
    uint32_t missing = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        missing += a[4 * i + 3] > 127 && b[4 * i + 3] <= 127;
    }
    return missing;
}

void test_clouds_of_all_formats_are_drawn_by_all_methods(test_state* test)
{
    static las_point points[POINTS];
    static uint8_t original[PIXEL_BYTES], first[STP_METHOD_COUNT][PIXEL_BYTES], got[PIXEL_BYTES];
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_points(points);
    CHECK(write_las(points, names[0], LAS_RAW) && write_las(points, names[1], LAZ_CHUNKED));
    CHECK(write_e57(points, names[2]) && write_xyz(points, names[3]));
    for (int f = 0; f < FORMATS; ++f) {
        stp_store* store = NULL;
        printf("%s\n", names[f]);
        CHECK_EQUAL(STP_OK, build(context, names[f]));
        CHECK_EQUAL(STP_OK, stp_store_open(context, "cloud.stip", &store));
        CHECK_EQUAL(STP_METHOD_COUNT, stp_store_get_directory(store)->method_count);
        uint32_t whole = draw(context, store, (stp_quality){.reference = true}, original);
        CHECK(whole > SIDE * SIDE / 5 && whole < SIDE * SIDE);
        for (uint32_t m = 0; m < STP_METHOD_COUNT; ++m) {
            stp_quality quality = {.splat_size = 4, .method = stp_methods[m].id};
            uint32_t covered = draw(context, store, quality, got);
            printf("%s: %u pixels, %u of the original, %u missing\n", stp_methods[m].name, covered,
                   whole, count_missing(original, got));
            CHECK(count_missing(original, got) < whole / 20);
            CHECK(covered < whole + whole / 2); // splats are larger only at the border
            // the points of each format are the same, except for the last bits of positions
            if (f == 0) {
                memcpy(first[m], got, PIXEL_BYTES);
            }
            CHECK(count_missing(got, first[m]) <= whole / 200);
            CHECK(count_missing(first[m], got) <= whole / 200);
        }
        stp_store_close(store);
    }
    stp_context_destroy(context);
}
