// SPDX-License-Identifier: MIT
#include "tests.h"

#include "embed/measuring.h"

#include <math.h>
#include <string.h>

static bool is_near(double a, double b)
{
    return fabs(a - b) <= 1e-12 * fmax(1.0, fabs(b));
}

void test_measures_of_a_staircase(test_state* test)
{
    stp_vec3d foot = {1, 2, 3}, head = {4, 8, 5};
    stp_distance d = stp_measure_distance(foot, head);
    CHECK(is_near(d.length, 7) && is_near(d.height, 6) && is_near(d.horizontal, sqrt(13)));
    CHECK(is_near(d.slope, atan(6 / sqrt(13)) * 180 / STP_PI));
    d = stp_measure_distance(head, foot);
    CHECK(is_near(d.height, -6) && d.slope < 0);
    d = stp_measure_distance(foot, foot);
    CHECK(d.length == 0 && d.slope == 0);
    d = stp_measure_distance(foot, (stp_vec3d){1, -5, 3});
    CHECK(is_near(d.slope, -90) && d.horizontal == 0);
    // a tenth of a millimetre, 500 km away
    d = stp_measure_distance((stp_vec3d){5e5, 0, 4e6}, (stp_vec3d){5e5, 0, 4e6 + 1e-4});
    CHECK(fabs(d.length - 1e-4) < 1e-9);
}

void test_measures_of_angles(test_state* test)
{
    stp_vec3d o = {2, 2, 2}, x = {3, 2, 2}, y = {2, 5, 2};
    CHECK(is_near(stp_measure_angle(x, o, y), 90));
    CHECK(is_near(stp_measure_angle(x, o, x), 0));
    CHECK(is_near(stp_measure_angle(x, o, (stp_vec3d){1, 2, 2}), 180));
    CHECK(stp_measure_angle(o, o, y) == 0);
    double tiny = stp_measure_angle(x, o, (stp_vec3d){3, 2 + 1e-9, 2});
    CHECK(fabs(tiny - 1e-9 * 180 / STP_PI) < 1e-13);
}

void test_measures_of_areas(test_state* test)
{
    stp_vec3d square[] = {{5e5, 1, 0}, {5e5 + 2, 1, 0}, {5e5 + 2, 1, 3}, {5e5, 1, 3}};
    double around;
    CHECK(is_near(stp_measure_area(square, 4, &around), 6) && is_near(around, 10));
    CHECK(stp_measure_area(square, 2, &around) == 0 && is_near(around, 4));
    CHECK(stp_measure_area(square, 0, &around) == 0 && around == 0);
}

void test_measures_in_units_and_axes_of_the_file(test_state* test)
{
    static const struct {
        double metres;
        const char* name;
    } units[] = {{1, "m"},
                 {0.001, "mm"},
                 {0.01, "cm"},
                 {0.0254, "in"},
                 {0.3048, "ft"},
                 {0, ""},
                 {1200.0 / 3937, "us-ft"},
                 {7, ""}};
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        stp_measuring m = {.unit_metres = units[i].metres, .up = 'y'};
        CHECK(strcmp(stp_measure_unit(&m), units[i].name) == 0);
    }
    stp_measuring z_up = {.unit_metres = 0.001, .up = 'z'}, y_up = {.up = 'y'};
    stp_vec3d p = {1, 2, 3}; // was (1, -3, 2) with z up: importing turns z to y
    stp_vec3d q = stp_measure_coordinates(&z_up, p), r = stp_measure_coordinates(&y_up, p);
    CHECK(q.x == 1 && q.y == -3 && q.z == 2);
    CHECK(r.x == 1 && r.y == 2 && r.z == 3);
    stp_measuring x_up = {.up = 'x'};
    q = stp_measure_coordinates(&x_up, p); // importing turned x to y and y to -x
    CHECK(q.x == 2 && q.y == -1 && q.z == 3);
    char text[32];
    stp_measure_text(&z_up, 1234.5678, 6, text, sizeof(text));
    CHECK(strcmp(text, "1234.57 mm") == 0);
    stp_measure_text(&y_up, 0.5, 99, text, sizeof(text));
    CHECK(strcmp(text, "0.5") == 0);
    stp_measure_text(&z_up, 1234.5678, 6, text, 5);
    CHECK(strcmp(text, "1234") == 0);
}

void test_measures_in_the_unit_that_is_shown(test_state* test)
{
    char text[64];
    stp_measuring feet = {.unit_metres = 0.001, .shown_metres = 0.3048, .up = 'y'};
    CHECK(strcmp(stp_measure_unit(&feet), "ft") == 0);
    CHECK(is_near(stp_measure_factor(&feet), 0.001 / 0.3048));
    stp_measure_text(&feet, 304.8, 6, text, sizeof(text));
    CHECK(strcmp(text, "1 ft") == 0);
    // a file without a unit keeps its numbers
    stp_measuring unknown = {.shown_metres = 0.3048, .up = 'y'};
    CHECK(stp_measure_factor(&unknown) == 1.0 && stp_measure_unit(&unknown)[0] == 0);
    stp_measuring same = {.unit_metres = 0.0254, .shown_metres = 0.0254, .up = 'y'};
    CHECK(stp_measure_factor(&same) == 1.0 && strcmp(stp_measure_unit(&same), "in") == 0);
    stp_measuring own = {.unit_metres = 0.01, .up = 'y'};
    CHECK(stp_measure_factor(&own) == 1.0 && strcmp(stp_measure_unit(&own), "cm") == 0);
}
