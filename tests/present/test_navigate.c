// SPDX-License-Identifier: MIT
// The interactive camera: its invariants hold near the origin and at survey coordinates.
#include "tests.h"

#include "base/math/rng.h"
#include "program/present/navigate.h"

#include <math.h>

static const stp_vec3d places[] = {{0, 0, 0}, {512345.25, 312.5, -5412345.75}};
enum { PLACES = 2, ROUNDS = 200 };

/// A sequence of random numbers.
typedef struct dice {
    uint64_t seed, index;
} dice;

static double random_in(dice* d, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(d->seed, d->index++) >> 11) * 0x1p-53;
}

static double distance(stp_vec3d a, stp_vec3d b)
{
    stp_vec3d d = stp_subd(a, b);
    return sqrt(stp_dotd(d, d));
}

static stp_boxd box_at(stp_vec3d place)
{
    return (stp_boxd){stp_subd(place, (stp_vec3d){4, 2, 3}), stp_addd(place, (stp_vec3d){4, 2, 3})};
}

/// A random position around the box, with a random direction.
static stp_navigator any_camera(dice* rng, stp_vec3d place)
{
    stp_navigator n;
    stp_boxd box = box_at(place);
    stp_navigator_init(&n, &box, 640, 400);
    n.azimuth = random_in(rng, -3, 3);
    n.elevation = random_in(rng, -1.5, 1.5);
    n.roll = random_in(rng, -0.5, 0.5);
    n.fov_degrees = random_in(rng, 20, 90);
    n.ortho_height = random_in(rng, 0, 1) < 0.3 ? random_in(rng, 1, 30) : 0.0;
    n.eye = stp_addd(place, (stp_vec3d){random_in(rng, -20, 20), random_in(rng, -9, 9),
                                        random_in(rng, -20, 20)});
    return n;
}

/// Distance of two points in the picture.
static double apart(const stp_navigator* n, stp_vec3d point, double x, double y)
{
    double px, py, depth;
    (void)stp_navigator_project(n, point, &px, &py, &depth);
    return hypot(px - x, py - y);
}

void test_navigate_points_and_pixels_are_inverses(test_state* test)
{
    dice rng = {1, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        double x = random_in(&rng, 0, 640), y = random_in(&rng, 0, 400);
        double depth = random_in(&rng, 0.1, 50), px, py, found;
        stp_vec3d point = stp_navigator_point(&n, x, y, depth);
        CHECK(stp_navigator_project(&n, point, &px, &py, &found));
        CHECK(fabs(px - x) < 1e-5 && fabs(py - y) < 1e-5 && fabs(found - depth) < 1e-7);
        stp_navigator_axes a = stp_navigator_get_axes(&n);
        stp_vec3d right = stp_crossd(a.up, a.back);
        CHECK(distance(right, a.right) < 1e-12 && fabs(stp_dotd(a.up, a.up) - 1.0) < 1e-12);
    }
}

void test_navigate_returns_views_as_set(test_state* test)
{
    dice rng = {2, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]), again = n;
        stp_view view = {0}, second = {0};
        n.elevation = i % 20 == 0 ? copysign(0.5 * STP_PI, n.elevation) : n.elevation;
        n.roll = i % 5 == 0 ? 0.0 : n.roll;
        stp_navigator_write_view(&n, &view);
        stp_navigator_read_view(&again, &view);
        stp_navigator_write_view(&again, &second);
        CHECK(distance(view.eye, second.eye) == 0.0 && distance(view.up, second.up) < 1e-6);
        CHECK(distance(view.target, second.target) < 1e-6 * n.reach);
        CHECK(view.ortho_height == second.ortho_height && view.width == 640 && view.height == 400);
        CHECK(distance(again.pivot, view.target) == 0.0 && !again.pivot_chosen);
    }
}

void test_navigate_orbit_keeps_distance_and_place_of_the_pivot(test_state* test)
{
    dice rng = {3, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        n.pivot = stp_navigator_point(&n, random_in(&rng, 0, 640), random_in(&rng, 0, 400), 12.5);
        double before = distance(n.eye, n.pivot), x, y, depth;
        CHECK(stp_navigator_project(&n, n.pivot, &x, &y, &depth));
        for (int k = 0; k < 20; ++k) {
            stp_navigator_orbit(&n, random_in(&rng, -50, 50), random_in(&rng, -50, 50));
        }
        CHECK(fabs(distance(n.eye, n.pivot) - before) < 1e-7);
        CHECK(apart(&n, n.pivot, x, y) < 1e-4);
        CHECK(fabs(n.elevation) <= 0.5 * STP_PI);
    }
    // half a turn over the picture's height
    stp_navigator n = any_camera(&rng, places[0]);
    n.azimuth = 0.1;
    stp_navigator_orbit(&n, -400.0, 0.0);
    CHECK(fabs(fabs(n.azimuth - 0.1) - STP_PI) < 1e-12);
}

void test_navigate_zoom_keeps_the_point_under_the_cursor(test_state* test)
{
    dice rng = {4, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        double x = random_in(&rng, 0, 640), y = random_in(&rng, 0, 400), px, py, depth;
        stp_vec3d point = stp_navigator_point(&n, x, y, random_in(&rng, 1, 30));
        double before = distance(n.eye, point), height = n.ortho_height;
        double factor = random_in(&rng, 0.5, 2.0);
        stp_navigator_zoom(&n, point, factor);
        CHECK(apart(&n, point, x, y) < 1e-4);
        if (height > 0.0) {
            CHECK(fabs(n.ortho_height - height * factor) < 1e-9 * height);
        } else {
            CHECK(fabs(distance(n.eye, point) - before * factor) < 1e-7);
        }
        for (int k = 0; k < 500; ++k) { // never through it
            stp_navigator_zoom(&n, point, 0.8);
        }
        CHECK(stp_navigator_project(&n, point, &px, &py, &depth));
        CHECK(isfinite(n.eye.x) && n.reach >= n.min_reach);
    }
}

void test_navigate_pan_keeps_the_point_under_the_cursor(test_state* test)
{
    dice rng = {5, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        double x = random_in(&rng, 0, 640), y = random_in(&rng, 0, 400), depth = 7.0;
        stp_vec3d point = stp_navigator_point(&n, x, y, depth);
        stp_vec3d pivot = n.pivot;
        n.pivot_chosen = i % 2 == 0;
        stp_navigator_pan(&n, 31.0, -17.0, depth);
        CHECK(apart(&n, point, x + 31.0, y - 17.0) < 1e-4);
        CHECK((distance(pivot, n.pivot) == 0.0) == n.pivot_chosen);
    }
}

void test_navigate_flight_scales_with_what_is_seen(test_state* test)
{
    const double forward[3] = {0, 0, 1}, up[3] = {0, 1, 0};
    stp_navigator n, far;
    stp_boxd box = box_at(places[1]);
    stp_navigator_init(&n, &box, 640, 400);
    far = n;
    far.reach = 10.0 * n.reach;
    stp_vec3d start = n.eye;
    stp_navigator_fly(&n, forward, 0.1, 1.0);
    stp_navigator_fly(&far, forward, 0.1, 1.0);
    double step = distance(n.eye, start);
    CHECK(step > 0.0 && fabs(distance(far.eye, start) / step - 10.0) < 1e-6);
    stp_navigator again = n;
    start = n.eye;
    stp_navigator_fly(&again, forward, 0.1, 5.0); // faster
    CHECK(fabs(distance(again.eye, start) / step - 5.0) < 1e-6);
    again = n;
    stp_navigator_change_speed(&again, 2.0);
    stp_navigator_fly(&again, forward, 0.1, 1.0);
    CHECK(fabs(distance(again.eye, start) / step - 1.5625) < 1e-6);
    again = n;
    stp_navigator_fly(&again, up, 0.2, 1.0); // the world's up, for any view direction
    CHECK(again.eye.x == start.x && again.eye.z == start.z && again.eye.y > start.y);
    // distances are adapted smoothly, by their ratio; without a visible surface, nothing changes
    double before = n.reach;
    stp_navigator_adapt_speed(&n, 0.0, 1.0);
    CHECK(n.reach == before);
    stp_navigator_adapt_speed(&n, 0.01 * before, 0.05);
    CHECK(n.reach < before && n.reach > 0.02 * before);
    for (int i = 0; i < 100; ++i) {
        stp_navigator_adapt_speed(&n, 0.01 * before, 0.05);
    }
    CHECK(fabs(n.reach / (0.01 * before) - 1.0) < 0.01);
    stp_navigator_change_speed(&n, 1000.0);
    CHECK(n.speed <= 100.0);
    stp_navigator_change_speed(&n, -2000.0);
    CHECK(n.speed >= 0.01);
}

static bool shows_box(const stp_navigator* n, const stp_boxd* box, double* maximum)
{
    bool inside = true;
    *maximum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        stp_vec3d p = {(corner & 1) != 0 ? box->max.x : box->min.x,
                       (corner & 2) != 0 ? box->max.y : box->min.y,
                       (corner & 4) != 0 ? box->max.z : box->min.z};
        double x, y, depth;
        inside = stp_navigator_project(n, p, &x, &y, &depth) && inside;
        double part = fmax(fabs(x / 320.0 - 1.0), fabs(y / 200.0 - 1.0));
        *maximum = fmax(*maximum, part);
    }
    return inside && *maximum <= 1.0;
}

void test_navigate_frames_boxes_from_any_direction(test_state* test)
{
    dice rng = {6, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        stp_boxd box = box_at(places[i % PLACES]);
        double azimuth = n.azimuth, maximum;
        stp_navigator_frame(&n, &box, NULL);
        CHECK(n.azimuth == azimuth && shows_box(&n, &box, &maximum) && maximum > 0.9);
        CHECK(distance(n.pivot, places[i % PLACES]) < 1e-6);
    }
    stp_navigator n = any_camera(&rng, places[0]), before = n;
    stp_boxd none = stp_boxd_empty();
    stp_navigator_frame(&n, &none, NULL);
    CHECK(distance(n.eye, before.eye) == 0.0);
}

void test_navigate_faces_standard_views(test_state* test)
{
    stp_navigator n;
    stp_boxd box = box_at(places[1]);
    stp_navigator_init(&n, &box, 640, 400);
    stp_navigator_axes axes;
    CHECK(stp_navigator_face(&n, "front", &box, NULL));
    axes = stp_navigator_get_axes(&n);
    CHECK(distance(axes.back, (stp_vec3d){0, 0, 1}) < 1e-9);
    CHECK(distance(axes.up, (stp_vec3d){0, 1, 0}) < 1e-9);
    CHECK(stp_navigator_face(&n, "right", &box, NULL));
    CHECK(distance(stp_navigator_get_axes(&n).back, (stp_vec3d){1, 0, 0}) < 1e-9);
    CHECK(stp_navigator_face(&n, "top", &box, NULL));
    axes = stp_navigator_get_axes(&n);
    CHECK(distance(axes.back, (stp_vec3d){0, 1, 0}) < 1e-9);
    CHECK(distance(axes.up, (stp_vec3d){0, 0, -1}) < 1e-9);
    CHECK(stp_navigator_face(&n, "bottom", &box, NULL));
    axes = stp_navigator_get_axes(&n);
    CHECK(distance(axes.up, (stp_vec3d){0, 0, 1}) < 1e-9);
    double azimuth = n.azimuth;
    CHECK(!stp_navigator_face(&n, "inside", &box, NULL) && n.azimuth == azimuth);
}

void test_navigate_projections_show_the_pivot_alike(test_state* test)
{
    dice rng = {7, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator n = any_camera(&rng, places[i % PLACES]);
        n.ortho_height = 0.0;
        n.pivot = stp_navigator_point(&n, 320.0, 200.0, 11.0);
        stp_vec3d beside = stp_navigator_point(&n, 420.0, 260.0, 11.0);
        double height = 0.0;
        for (int k = 0; k < 4; ++k) {
            CHECK(apart(&n, n.pivot, 320.0, 200.0) < 1e-4 &&
                  apart(&n, beside, 420.0, 260.0) < 1e-4);
            stp_navigator_switch_projection(&n);
            CHECK((n.ortho_height > 0.0) == (k % 2 == 0));
            CHECK(k < 2 || k % 2 == 1 || fabs(n.ortho_height - height) < 1e-6 * height);
            height = k % 2 == 0 ? n.ortho_height : height;
        }
    }
}

void test_navigate_orbits_turn_about_what_is_looked_at(test_state* test)
{
    stp_navigator n;
    stp_boxd box = box_at(places[0]);
    stp_navigator_init(&n, &box, 640, 400);
    stp_vec3d middle = n.pivot;
    stp_vec3d near_middle = stp_navigator_point(&n, 300, 180, 0.8 * n.reach);
    stp_navigator_begin_orbit(&n, &near_middle); // about as far: keeps the scene's centre
    CHECK(distance(n.pivot, middle) == 0.0);
    stp_vec3d close = stp_navigator_point(&n, 300, 180, 0.01 * n.reach);
    stp_navigator_begin_orbit(&n, &close); // much nearer: becomes the pivot
    CHECK(distance(n.pivot, close) == 0.0);
    stp_navigator_choose_pivot(&n, middle);
    stp_navigator_begin_orbit(&n, &close); // the user chose a pivot
    CHECK(distance(n.pivot, middle) == 0.0 && n.pivot_chosen);
    stp_navigator_turn(&n, 3.0, 0.0); // it is behind the eye now
    stp_navigator_begin_orbit(&n, NULL);
    CHECK(!n.pivot_chosen && fabs(distance(n.pivot, n.eye) - n.reach) < 1e-9);
}

void test_navigate_glides_from_camera_to_camera(test_state* test)
{
    dice rng = {8, 0};
    for (int i = 0; i < PLACES * ROUNDS; ++i) {
        stp_navigator a = any_camera(&rng, places[i % PLACES]);
        stp_navigator b = any_camera(&rng, places[i % PLACES]);
        stp_navigator start = stp_navigator_mix(&a, &b, 0.0), end = stp_navigator_mix(&a, &b, 1.0);
        CHECK(distance(start.eye, a.eye) < 1e-6 && distance(end.eye, b.eye) == 0.0);
        CHECK(fabs(remainder(start.azimuth - a.azimuth, 2 * STP_PI)) < 1e-9);
        stp_navigator half = stp_navigator_mix(&a, &b, 0.5);
        CHECK(fabs(remainder(half.azimuth - a.azimuth, 2 * STP_PI)) <= 0.5 * STP_PI + 1e-9);
        CHECK(isfinite(half.eye.x) && half.reach > 0.0);
    }
    // the short way round
    stp_navigator a = any_camera(&rng, places[0]), b = a;
    a.azimuth = 3.0;
    b.azimuth = -3.0;
    CHECK(fabs(stp_navigator_mix(&a, &b, 0.5).azimuth) > 3.0);
}
