// SPDX-License-Identifier: MIT
#include "scene_helpers.h"
#include "tests.h"

enum { STRIPS = 24, STRIP_TRIANGLES = 500 };

// Strips of which every third repeats the first, a duplicate texture, and points.
static bool add_bulk(stp_scene* scene)
{
    for (int i = 0; i < STRIPS; ++i) {
        uint32_t mesh;
        if (!add_strip(scene, STRIP_TRIANGLES, i % 3 == 0 ? 0.0f : (float)i, &mesh) ||
            !add_mesh_object(scene, STP_NONE, make_translation(0, 0, i), mesh, NULL)) {
            return false;
        }
    }
    for (int i = 0; i < 2; ++i) {
        uint8_t* texels = STP_NEW_ZEROED(scene->context, uint8_t, 4 * 64 * 64);
        stp_texture texture = {.width = 64, .height = 64, .texels = texels};
        if (texels == NULL || stp_scene_add_texture(scene, &texture, NULL) != STP_OK) {
            return false;
        }
        float* positions = STP_NEW_ZEROED(scene->context, float, 3 * 100);
        stp_point_set points = {.point_count = 100, .positions = positions};
        if (positions == NULL || stp_scene_add_point_set(scene, &points, NULL) != STP_OK) {
            return false;
        }
    }
    return true;
}

void test_scenes_move_bulk_to_the_spill(test_state* test)
{
    for (int above = 0; above < 3; ++above) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_spill* spill = NULL;
        stp_scene *scene = NULL, *plain = NULL;
        CHECK(context != NULL && stp_spill_create(context, ".", &spill) == STP_OK);
        CHECK(stp_scene_create(context, &plain) == STP_OK && add_bulk(plain));
        CHECK(stp_scene_create(context, &scene) == STP_OK);
        const unsigned char* before = stp_spill_alloc(spill, 1);
        uint64_t limit = above == 0 ? 0 : above == 1 ? 100000 : UINT64_MAX;
        stp_scene_use_spill(scene, spill, limit);
        CHECK(add_bulk(scene));
        CHECK(scene->bulk_bytes <= limit);
        uint64_t distinct = (1 + STRIPS * 2 / 3) * (uint64_t)STRIP_TRIANGLES * 24 + 16384 + 1200;
        const unsigned char* after = stp_spill_alloc(spill, 1); // all of it fits in a chunk
        uint64_t spilled = (uint64_t)(after - before) - 64;
        if (above == 0) { // nothing is written twice
            CHECK(spilled >= distinct && spilled < distinct + 8192);
        }
        CHECK_EQUAL(above == 2, spilled == 0);
        for (size_t i = 0; i < scene->mesh_count; ++i) {
            const stp_mesh *a = &scene->meshes[i], *b = &plain->meshes[i];
            CHECK_EQUAL(b->vertex_count, a->vertex_count);
            CHECK(memcmp(a->positions, b->positions, 12 * (size_t)a->vertex_count) == 0);
            CHECK(memcmp(a->indices, b->indices, 12 * (size_t)a->triangle_count) == 0);
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(STP_OK, stp_scene_finish(plain));
        CHECK_EQUAL(1 + STRIPS * 2 / 3, scene->mesh_count);
        CHECK_EQUAL(plain->mesh_count, scene->mesh_count);
        CHECK_EQUAL(plain->node_count, scene->node_count);
        CHECK(scene->bulk_bytes <= plain->bulk_bytes);
        stp_scene_destroy(plain);
        stp_scene_destroy(scene);
        stp_spill_destroy(spill);
        stp_context_destroy(context);
    }
}

void test_spilling_scenes_survive_failing_allocator(test_state* test)
{
    bool made = false;
    int failures = 0;
    for (int n = 0; !made && n < 1000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_spill* spill = NULL;
            stp_scene* scene = NULL;
            if (stp_spill_create(context, ".", &spill) == STP_OK &&
                stp_scene_create(context, &scene) == STP_OK) {
                stp_scene_use_spill(scene, spill, 50000);
                made = add_bulk(scene) && stp_scene_finish(scene) == STP_OK;
            }
            failures += !made;
            CHECK(log.errors <= 1);
            stp_scene_destroy(scene);
            stp_spill_destroy(spill);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 30);
}
