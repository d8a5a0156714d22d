// SPDX-License-Identifier: MIT
// Views with the same name, from several inputs.
#include "scene_helpers.h"
#include "tests.h"

static stp_result finish_views(stp_context* context, const char* const* names, size_t count,
                               stp_scene** scene)
{
    stp_result result = stp_scene_create(context, scene);
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        stp_scene_view view = {.name = names[i], .fov_degrees = 1.0 + (double)i};
        result = stp_scene_add_view(*scene, &view);
    }
    return result == STP_OK ? stp_scene_finish(*scene) : result;
}

void test_views_of_one_name_are_numbered(test_state* test)
{
    static const char* const given[] = {"front",   "side", "front", "front-2", "front",
                                        "front-2", "",     "",      "side-2"};
    static const char* const wanted[] = {"front",     "side", "front-3", "front-2", "front-4",
                                         "front-2-2", "",     "-2",      "side-2"};
    enum { COUNT = sizeof(given) / sizeof(given[0]) };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, finish_views(context, given, COUNT, &scene));
    CHECK_EQUAL(COUNT, scene->view_count);
    for (size_t i = 0; i < COUNT; ++i) {
        CHECK(strcmp(wanted[i], scene->views[i].name) == 0);
        CHECK(scene->views[i].fov_degrees == 1.0 + (double)i);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Unlikely, but a file may contain it: as fast as any other scene.
void test_many_views_of_one_name_are_numbered(test_state* test)
{
    enum { COUNT = 50000 };
    static const char* names[COUNT];
    for (int i = 0; i < COUNT; ++i) {
        names[i] = i % 2 == 0 ? "v" : "v-2";
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, finish_views(context, names, COUNT, &scene));
    CHECK(strcmp(scene->views[COUNT - 2].name, "v-25001") == 0);
    CHECK(strcmp(scene->views[COUNT - 1].name, "v-2-25000") == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_numbering_views_survives_failing_allocator(test_state* test)
{
    static const char* const names[] = {"front", "front", "front"};
    bool done = false;
    for (int n = 0; !done && n < 1000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_scene* scene = NULL;
            stp_result result = finish_views(context, names, 3, &scene);
            done = result == STP_OK;
            CHECK(done || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
}
