// SPDX-License-Identifier: MIT
// Named views, and the flights of lab/scenes/flights: each scene has them, and no eye is inside a wall.
#include "support_scenes.h"
#include "support_sight.h"

#include "program/present/flight.h"

#include <math.h>
#include <string.h>

enum { STEPS = 5 }; // positions tested between two keys

// Scene to test: the full scene takes too long. `reach` is the maximum distance of an eye from that
// scene, as a fraction of its diagonal.
typedef struct trial {
    const char *name, *made; ///< `made` stands at the same places
    double scale, reach;
    bool ground; ///< the ground extends everywhere
} trial;

static const trial trials[] = {
    {"boxes", "boxes", 1, 2, false},
    {"spheres", "spheres", 1, 1, false},
    {"one-mesh", "one-mesh", 0.001, 1, false},
    {"power-plant", "power-plant", 0.001, 1, true},
    {"twenty-million", "twenty-million", 0.001, 1, true},
    {"forest", "forest", 0.005, 3, true},
    {"city-small", "city-small", 1, 1, false},
    {"city", "city", 0.0625, 2, false},
    {"terrain", "terrain", 0.001, 1, true},
    {"bakery-line", "bakery-line", 0.001, 1, false},
    {"car-factory", "car-factory", 0.001, 1, true},
    {"paper", "paper", 0.0005, 1, true},
    {"paper-huge", "paper", 0.0005, 1, true},
};
enum { TRIALS = sizeof(trials) / sizeof(trials[0]) };

static stp_result read_flight(stp_context* context, const char* name, stp_flight* f)
{
    char path[512];
    snprintf(path, sizeof(path), "%s/lab/scenes/flights/%s.json", STP_TEST_SOURCE_DIR, name);
    return stp_flight_read(context, path, f);
}

// Fault of a camera at this position and direction; NULL: none.
static const char* judge_stand(const sight* s, const trial* tried, stp_vec3d eye, stp_vec3d target)
{
    const stp_boxd* box = &s->scene->nodes[s->scene->root].bounds;
    stp_vec3d across = stp_subd(box->max, box->min);
    double diagonal = sqrt(stp_dotd(across, across)), far = tried->reach * diagonal;
    if (eye.x < box->min.x - far || eye.y < box->min.y - far || eye.z < box->min.z - far ||
        eye.x > box->max.x + far || eye.y > box->max.y + far || eye.z > box->max.z + far) {
        return "is far from the scene";
    }
    if (sight_is_inside(s, tried->ground, eye)) {
        return "is inside of something";
    }
    stp_vec3d gaze = stp_normalized(stp_subd(target, eye));
    return sight_look(s, eye, gaze).distance < fmin(2.0, 0.01 * diagonal) ? "looks at a wall"
                                                                          : NULL;
}

static void check_stand(test_state* test, const sight* s, const trial* tried, const char* what,
                        stp_vec3d eye, stp_vec3d target)
{
    const char* fault = judge_stand(s, tried, eye, target);
    if (fault != NULL) {
        fprintf(stderr, "%s, %s: (%g, %g, %g) %s\n", tried->name, what, eye.x, eye.y, eye.z, fault);
    }
    CHECK(fault == NULL);
}

static void check_trial(test_state* test, const trial* tried)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_scene(context, tried->made, tried->scale, 0);
    sight s;
    CHECK(scene != NULL && sight_open(&s, scene));
    CHECK(scene->view_count > 0);
    for (size_t i = 0; i < scene->view_count; ++i) {
        const stp_scene_view* view = &scene->views[i];
        CHECK(view->name != NULL && view->fov_degrees > 5.0 && view->fov_degrees < 120.0);
        check_stand(test, &s, tried, view->name, view->eye, view->target);
    }
    stp_flight f;
    CHECK(read_flight(context, tried->name, &f) == STP_OK);
    for (size_t i = 0; i + 1 < f.key_count; ++i) {
        for (int k = 0; k <= STEPS; ++k) {
            stp_view view = {0};
            stp_flight_get_view(
                &f, f.keys[i].t + (f.keys[i + 1].t - f.keys[i].t) * (double)k / STEPS, &view);
            check_stand(test, &s, tried, "flight", view.eye, view.target);
        }
    }
    stp_flight_destroy(context, &f);
    sight_close(&s);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static void check_named(test_state* test, const char* name)
{
    for (int i = 0; i < TRIALS; ++i) {
        if (strcmp(trials[i].name, name) == 0) {
            check_trial(test, &trials[i]);
        }
    }
}

void test_every_named_scene_has_a_flight(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (const scene_recipe* recipe = scene_recipes(); recipe->name != NULL; ++recipe) {
        int found = 0;
        for (int i = 0; i < TRIALS; ++i) {
            found += strcmp(trials[i].name, recipe->name) == 0;
        }
        stp_flight f = {0};
        bool read = read_flight(context, recipe->name, &f) == STP_OK;
        if (found != 1 || !read || f.key_count < 2) {
            fprintf(stderr, "%s: no flight, or no trial of it here\n", recipe->name);
        }
        CHECK_EQUAL(1, found);
        CHECK(read && f.key_count >= 2);
        stp_flight_destroy(context, &f);
    }
    stp_context_destroy(context);
}

void test_views_and_flights_of_small_scenes_stay_outside_objects(test_state* test)
{
    check_named(test, "boxes");
    check_named(test, "spheres");
    check_named(test, "one-mesh");
    check_named(test, "forest");
    check_named(test, "terrain");
}

void test_views_and_flights_of_cities_stay_outside_objects(test_state* test)
{
    check_named(test, "city-small");
    check_named(test, "city");
}

void test_views_and_flights_of_plants_stay_outside_objects(test_state* test)
{
    check_named(test, "power-plant");
    check_named(test, "twenty-million");
}

void test_views_and_flights_of_factories_stay_outside_objects(test_state* test)
{
    check_named(test, "car-factory");
    check_named(test, "bakery-line");
}

void test_views_and_flight_of_paper_stay_outside_objects(test_state* test)
{
    check_named(test, "paper");
}

void test_views_and_flight_of_paper_huge_stay_outside_objects(test_state* test)
{
    check_named(test, "paper-huge");
}
