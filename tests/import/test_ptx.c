// SPDX-License-Identifier: MIT
//
// PTX: scans with poses, cells without points, normals from the grid.
#include "points_test.h"

#include <time.h>

#define HEADER(columns, rows, x, y, z)                                                             \
    columns "\n" rows "\n" x " " y " " z "\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n" x    \
            " " y " " z " 1\n"

static const char two[] =
    HEADER("2", "2", "600000", "800000", "400") "1 0 0 0.5 255 0 0\n0 0 0 0.5 0 0 0\n1 1 0 1 0 255 "
                                                "0\n1 1 1 0 0 0 255\n" HEADER("1", "1", "5", "0",
                                                                              "0") "0 0 2 0.25\n";

void test_ptx_scans(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ptx", two, strlen(two), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(3, scene->object_count);
    CHECK(strcmp(scene->objects[1].name, "scan 1") == 0);
    CHECK(strcmp(scene->up, "z") == 0);
    const stp_point_set* p = &scene->point_sets[0];
    CHECK_EQUAL(3, p->point_count);
    CHECK(is_near(place_of(scene, 1, 0, 1), 600001, 800001, 400, 1e-9));
    CHECK_EQUAL(255, p->colors[5]);
    const uint16_t* intensities = p->attributes[STP_ATTRIBUTE_INTENSITY];
    CHECK_EQUAL(32768, intensities[0]);
    CHECK_EQUAL(0, intensities[2]);
    CHECK_EQUAL(1, scene->point_sets[1].point_count);
    CHECK(is_near(place_of(scene, 2, 1, 0), 5, 0, 2, 1e-9));
    CHECK(scene->point_sets[1].colors == NULL);
    // alone in its grid: it faces the scanner
    CHECK(scene->point_sets[1].normals[2] == -1.0f);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// The pose is for row vectors: a quarter turn about z sends x to y.
void test_ptx_pose(test_state* test)
{
    static const char text[] =
        "1\n1\n10 20 30\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 "
        "20 30 1\n3 0 1 0\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ptx", text, strlen(text), &result);
    CHECK(scene != NULL);
    CHECK(is_near(place_of(scene, 1, 0, 0), 10, 23, 31, 1e-9));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

enum { SIDE = 40 };

// A scan of a wall at x = 4, with a pillar at x = 2 in front; `placed`: the points are in world
// coordinates, without a pose.
static char* write_wall(size_t* size, int placed)
{
    char* text = malloc(SIDE * SIDE * 64 + 1024);
    const double shift = placed ? 5000.0 : 0.0;
    size_t at = text == NULL
                    ? 0
                    : (size_t)sprintf(text,
                                      "%d\n%d\n%g 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 "
                                      "0\n0 0 1 0\n%g 0 0 1\n",
                                      SIDE, SIDE, 5000.0, 5000.0 - shift);
    for (int c = 0; text != NULL && c < SIDE; ++c) {
        for (int r = 0; r < SIDE; ++r) {
            double y = (SIDE / 2 - c) * 0.02, z = (r - SIDE / 2) * 0.02;
            double x = c >= 10 && c < 20 ? 2.0 : 4.0;
            if (r == 7 && c == 3) {
                at += (size_t)sprintf(text + at, "0 0 0 0\n");
            } else {
                at += (size_t)sprintf(text + at, "%.5f %.5f %.5f 0.5\n", x + shift, x * y, x * z);
            }
        }
    }
    *size = at;
    return text;
}

void test_ptx_normals_face_the_scanner(test_state* test)
{
    for (int placed = 0; placed < 2; ++placed) {
        size_t size;
        char* text = write_wall(&size, placed);
        CHECK(text != NULL);
        stp_context* context = test_context(NULL, 2, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.ptx", text, size, &result);
        CHECK(scene != NULL);
        const stp_point_set* p = &scene->point_sets[0];
        CHECK_EQUAL(SIDE * SIDE - 1, p->point_count);
        for (size_t i = 0; i < p->point_count; ++i) { // also next to depth jumps
            CHECK(p->normals[3 * i] < -0.999f);
        }
        CHECK(is_near(place_of(scene, 1, 0, 0), 5004.0, 4.0 * 0.4, -4.0 * 0.4, 1e-3));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK(is_the_same_everywhere("a.ptx", text, size));
        free(text);
    }
}

void test_ptx_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char* text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"", STP_ERROR_TRUNCATED, "is empty"},
        {"2\n2\n0 0 0\n", STP_ERROR_TRUNCATED, "starts with 10 header lines"},
        {"2.5\n2\n0 0 0\n\n\n\n\n\n\n\n", STP_ERROR_FORMAT, "number of columns"},
        {"-1\n2\n0 0 0\n\n\n\n\n\n\n\n", STP_ERROR_FORMAT, "number of columns"},
        {"2\n2\n0 0 0\n1 0\n\n\n\n\n\n\n", STP_ERROR_FORMAT, "line 4: expected the three"},
        {HEADER("2", "2", "0", "0", "0") "1 1 1 1\n", STP_ERROR_TRUNCATED, "ends after 1 cells"},
        {HEADER("4000000000", "4000000000", "0", "0", "0"), STP_ERROR_TRUNCATED, "after 0 cells"},
        {HEADER("1", "1", "0", "0", "inf") "1 1 1 1\n", STP_ERROR_FORMAT,
         "line 3: inf in the scanner's position: expected magnitudes below 1e+15"},
        {"1\n1\n0 0 -1e300\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 1 1 1\n",
         STP_ERROR_FORMAT, "line 3: -1e+300 in the scanner's position"},
        {"1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1e300 0 0\n0 0 1 0\n0 0 0 1\n1 1 1 1\n",
         STP_ERROR_FORMAT, "line 8: 1e+300 in the rotation of the pose"},
        {HEADER("1", "1", "0", "0", "0") "1 1 1 1 1\n", STP_ERROR_FORMAT,
         "line 11: expected three"},
        {HEADER("1", "2", "0", "0", "0") "1 1 1 1\n1 1 x 1\n", STP_ERROR_FORMAT, "line 12"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_refused("a.ptx", cases[i].text, strlen(cases[i].text), cases[i].result,
                         cases[i].says));
    }
}

// Columns without cells take no time, however many there are.
void test_ptx_empty_scan(test_state* test)
{
    static const char text[] =
        HEADER("4294967294", "0", "0", "0", "0") HEADER("0", "7", "0", "0", "0");
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ptx", text, strlen(text), &result);
    CHECK(scene != NULL && scene->object_count == 3 && scene->point_set_count == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Thousands of small scans in one file take little longer than one large scan.
void test_ptx_of_many_scans_takes_linear_time(test_state* test)
{
    enum { SCANS = 8000 };
    static const char one[] = HEADER("1", "1", "0", "0", "0") "1 2 3 0.5\n";
    const size_t length = sizeof(one) - 1;
    char* text = malloc(SCANS * length);
    for (size_t i = 0; i < SCANS; ++i) {
        memcpy(text + i * length, one, length);
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    clock_t before = clock();
    stp_scene* scene = import_bytes(context, "a.ptx", text, SCANS * length, &result);
    double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
    CHECK(scene != NULL);
    CHECK_EQUAL(SCANS, scene->point_set_count);
    CHECK(seconds < 3.0); // it is below 0.1; in quadratic time it was above 10
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(text);
}

void test_ptx_survives_truncation_and_failing_allocator(test_state* test)
{
    CHECK(survives_truncation("a.ptx", two, strlen(two)));
    CHECK(survives_failing_allocator("a.ptx", two, strlen(two)));
}
