// SPDX-License-Identifier: MIT
// Attributes of points that a file cannot hold: their points stay, and one warning counts them.
#include "e57_writer.h"
#include "las_points.h"
#include "points_test.h"

enum { COUNT = 6 };

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

// Times of a cloud of which all but the first and the last are invalid.
static const double times[COUNT] = {3.5, (double)NAN, (double)INFINITY, -1.7e308, 1.7e308, -7.0};

static void check_times(test_state* test, const char* name, const void* bytes, size_t size)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, name, bytes, size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    CHECK_EQUAL(COUNT, scene->point_sets[0].point_count);
    const double* kept = scene->point_sets[0].attributes[STP_ATTRIBUTE_TIME];
    CHECK(kept != NULL && kept[0] == 3.5 && kept[5] == -7.0);
    CHECK(kept[1] == 0.0 && kept[2] == 0.0 && kept[3] == 0.0 && kept[4] == 0.0);
    CHECK(strstr(log.warning, "not kept: 4 point times beyond 1e19 (stored as 0)") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(is_the_same_everywhere(name, bytes, size));
}

static las_buffer write_las(const double* written, las_coding coding)
{
    static las_point points[COUNT];
    for (size_t i = 0; i < COUNT; ++i) {
        points[i] = (las_point){.position = {(int32_t)i, 1, 2}, .time = bits_of(written[i])};
    }
    return las_write(&(las_desc){.points = points,
                                 .count = COUNT,
                                 .format = coding == LAS_RAW ? 1 : 6,
                                 .coding = coding,
                                 .chunk_size = 100});
}

void test_point_times_of_las_are_finite(test_state* test)
{
    for (int coding = 0; coding < 2; ++coding) {
        las_buffer file = write_las(times, coding == 0 ? LAS_RAW : LAZ_CHUNKED);
        check_times(test, "a.las", file.bytes, file.size);
        free(file.bytes);
    }
}

void test_point_times_without_a_valid_one_are_dropped(test_state* test)
{
    static const double bad[COUNT] = {(double)NAN,       (double)NAN, (double)INFINITY,
                                      -(double)INFINITY, 1e300,       -1e300};
    las_buffer file = write_las(bad, LAS_RAW);
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.las", file.bytes, file.size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(COUNT, scene->point_sets[0].point_count);
    CHECK(scene->point_sets[0].attributes[STP_ATTRIBUTE_TIME] == NULL);
    CHECK(strstr(log.warning, "6 point times") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(is_the_same_everywhere("a.las", file.bytes, file.size));
    free(file.bytes);
}

void test_point_times_of_ply_and_e57_are_finite(test_state* test)
{
    char ply[1024];
    int length =
        snprintf(ply, sizeof(ply),
                 "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
                 "property float z\nproperty double gps_time\nend_header\n");
    for (int i = 0; i < COUNT; ++i) {
        length +=
            snprintf(ply + length, sizeof(ply) - (size_t)length, "%d 0 0 %.17g\n", i, times[i]);
    }
    check_times(test, "a.ply", ply, (size_t)length);

    uint64_t v[4][COUNT];
    for (size_t i = 0; i < COUNT; ++i) {
        v[0][i] = bits_of((double)i);
        v[1][i] = v[2][i] = bits_of(1.0);
        v[3][i] = bits_of(times[i]);
    }
    const e57_stream streams[] = {{64, v[0]}, {64, v[1]}, {64, v[2]}, {64, v[3]}};
    e57_file f = e57_begin();
    unsigned long long section = e57_add_points(&f, streams, 4, COUNT, 1000);
    char xml[2048];
    snprintf(xml, sizeof(xml),
             "<?xml version=\"1.0\"?><e57Root><data3D><vectorChild><points fileOffset=\"%llu\" "
             "recordCount=\"6\"><prototype><cartesianX type=\"Float\"/><cartesianY type=\"Float\"/>"
             "<cartesianZ type=\"Float\"/><timeStamp type=\"Float\"/></prototype></points>"
             "</vectorChild></data3D></e57Root>",
             section);
    size_t size;
    unsigned char* bytes = e57_finish(&f, xml, &size);
    check_times(test, "a.e57", bytes, size);
    free(bytes);
}

// Infinite intensities and colours do not choose the scale of the others.
void test_point_scales_ignore_infinite_values(test_state* test)
{
    static const char xyz[] = "//X Y Z I R G B\n0 0 0 100 255 0 0\n1 0 0 200 0 255 0\n"
                              "2 0 0 inf inf 0 0\n3 0 0 -inf 0 0 nan\n4 0 0 nan 1 2 3\n";
    static const char pcd[] = "FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 5\n"
                              "HEIGHT 1\nDATA ascii\n0 0 0 100\n1 0 0 200\n2 0 0 inf\n3 0 0 -inf\n"
                              "4 0 0 nan\n";
    static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
                              "property float y\nproperty float z\nproperty float intensity\n"
                              "end_header\n0 0 0 0.39215686\n1 0 0 0.78431373\n2 0 0 inf\n"
                              "3 0 0 -inf\n4 0 0 nan\n";
    const char* const texts[][2] = {{"a.xyz", xyz}, {"a.pcd", pcd}, {"a.ply", ply}};
    for (int i = 0; i < 3; ++i) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene =
            import_bytes(context, texts[i][0], texts[i][1], strlen(texts[i][1]), &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(5, scene->point_sets[0].point_count);
        const uint16_t* strengths = scene->point_sets[0].attributes[STP_ATTRIBUTE_INTENSITY];
        CHECK_EQUAL(25700, strengths[0]);
        CHECK_EQUAL(51400, strengths[1]);
        const uint8_t* colors = scene->point_sets[0].colors;
        CHECK(i != 0 || (colors[0] == 255 && colors[5] == 255 && colors[16] == 1));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
