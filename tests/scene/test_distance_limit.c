// SPDX-License-Identifier: MIT
// Invalid or extremely distant geometry must not spoil the rest of a scene.
#include "scene_helpers.h"
#include "tests.h"

#include "scene/finish_steps.h"

static const float nowhere[] = {NAN, INFINITY, -INFINITY, 1e19f, -3e38f};
enum { NOWHERE = sizeof(nowhere) / sizeof(nowhere[0]) };

void test_triangles_without_finite_positions_are_left_out(test_state* test)
{
    for (int k = 0; k < NOWHERE; ++k) {
        for (uint32_t vertex = 0; vertex < 12; vertex += vertex == 2 ? 7 : 1) {
            test_log log = {0};
            stp_context* context = test_context(NULL, 1, &log);
            stp_scene* scene = NULL;
            uint32_t bad, good;
            CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
            stp_mesh mesh = make_strip_mesh(context, 10, 0.0f);
            CHECK(mesh.positions != NULL && mesh.indices != NULL);
            mesh.positions[3 * vertex + (uint32_t)k % 3] = nowhere[k];
            CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &mesh, &bad));
            CHECK(add_strip(scene, 5, 0.0f, &good));
            CHECK_EQUAL(STP_OK,
                        stp_scene_add_object(scene,
                                             &(stp_object){.name = "bent",
                                                           .parent = STP_NONE,
                                                           .transform = stp_affine_identity()},
                                             NULL));
            CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, bad}));
            CHECK(add_mesh_object(scene, STP_NONE, make_translation(1, 0, 0), good, NULL));
            CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
            uint32_t users = vertex < 2 ? vertex + 1 : vertex > 9 ? 12 - vertex : 3;
            CHECK_EQUAL(15 - users, scene->nodes[scene->root].triangle_count);
            stp_boxd box = scene->nodes[scene->root].bounds;
            CHECK(box.min.x >= 0.0 && box.max.x <= 5.5 && box.max.y <= 1.0 && box.max.z == 0.0);
            CHECK(strstr(log.warning, "object 0 (bent): ") == log.warning);
            CHECK_EQUAL(0, log.errors);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}

void test_points_without_finite_positions_are_left_out(test_state* test)
{
    enum { COUNT = 20 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    stp_point_set set = {.point_count = COUNT};
    set.positions = STP_NEW_ZEROED(context, float, 3 * COUNT);
    set.normals = STP_NEW_ZEROED(context, float, 3 * COUNT);
    set.colors = STP_NEW_ZEROED(context, uint8_t, 4 * COUNT);
    uint8_t* classes = STP_NEW_ZEROED(context, uint8_t, COUNT);
    double* times = STP_NEW_ZEROED(context, double, COUNT);
    CHECK(set.positions != NULL && set.normals != NULL && set.colors != NULL);
    CHECK(classes != NULL && times != NULL);
    set.attributes[STP_ATTRIBUTE_CLASS] = classes;
    set.attributes[STP_ATTRIBUTE_TIME] = times;
    for (uint32_t i = 0; i < COUNT; ++i) {
        classes[i] = (uint8_t)i;
        times[i] = 0.5 * i;
        set.positions[3 * i] = set.normals[3 * i] = (float)i;
        set.positions[3 * i + 1] = i % 3 == 0 ? nowhere[i / 3 % NOWHERE] : 0.0f;
        set.colors[4 * i + 3] = (uint8_t)i;
    }
    CHECK_EQUAL(STP_OK, stp_scene_add_point_set(scene, &set, NULL));
    const stp_point_set* kept = &scene->point_sets[0];
    CHECK_EQUAL(13, kept->point_count);
    for (uint32_t i = 0; i < kept->point_count; ++i) {
        uint32_t was = i / 2 * 3 + i % 2 + 1;
        CHECK(kept->positions[3 * i] == (float)was && kept->positions[3 * i + 1] == 0.0f);
        CHECK(kept->normals[3 * i] == (float)was && kept->colors[4 * i + 3] == was);
        CHECK(classes[i] == was && times[i] == 0.5 * was);
    }
    CHECK(kept->bounds.max.x == 19.0f && kept->bounds.max.y == 0.0f);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Objects, uses, instances and whole groups.
void test_objects_out_of_reach_are_left_out(test_state* test)
{
    const double far[] = {1e19, -1e30, 1e300, HUGE_VAL, (double)NAN};
    for (int k = 0; k < 5; ++k) {
        for (int kind = 0; kind < 5; ++kind) {
            test_log log = {0};
            stp_context* context = test_context(NULL, 1, &log);
            stp_scene* scene = NULL;
            uint32_t mesh, group, good;
            CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
            CHECK(add_strip(scene, 8, 0.0f, &mesh));
            CHECK(add_mesh_object(scene, STP_NONE, make_translation(0, 3, 0), mesh, &good));
            CHECK(add_object(scene, STP_NONE, make_translation(0, 0, 0), 0, &group));
            stp_affine away = make_translation(0, far[k], 0);
            if (kind == 1) { // an object that is too large
                away = (stp_affine){{{far[k], 0, 0, 0}, {0, far[k], 0, 0}, {0, 0, 1, 0}}};
            }
            if (kind == 2) {
                CHECK(add_mesh_object(scene, group, make_translation(1, 0, 0), mesh, NULL));
                CHECK_EQUAL(STP_OK,
                            stp_scene_add_instance(
                                scene, &(stp_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}));
                CHECK_EQUAL(STP_OK, stp_scene_add_instance(scene, &away));
            } else if (kind == 3) {
                CHECK(add_mesh_object(scene, group, make_translation(1, 0, 0), mesh, NULL));
                CHECK(add_object(scene, STP_NONE, away, 0, NULL));
                CHECK_EQUAL(STP_OK, stp_scene_add_use(scene, good));
            } else {
                uint32_t parent = group;
                CHECK(kind != 4 || add_object(scene, group, away, 0, &parent));
                CHECK(add_mesh_object(scene, parent, kind == 4 ? make_translation(5, 0, 0) : away,
                                      mesh, NULL));
                CHECK(add_mesh_object(scene, group, make_translation(1, 0, 0), mesh, NULL));
            }
            CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
            CHECK_EQUAL(16, scene->nodes[scene->root].triangle_count);
            CHECK(scene->nodes[scene->root].bounds.max.x == 5.5);
            CHECK(scene->nodes[scene->root].bounds.max.y == 4.0);
            const char* says = kind == 3 ? "object 3 (no name) " : "object 2 (no name) ";
            CHECK(strstr(log.warning, says) == log.warning);
            CHECK(strstr(log.warning, "it is left out") != NULL);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}

void test_scenes_out_of_reach_are_empty(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = NULL;
    uint32_t mesh;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 8, 0.0f, &mesh));
    for (int i = 0; i < 5; ++i) {
        CHECK(add_mesh_object(scene, STP_NONE, make_translation(0, 1e20 * (i + 1), 0), mesh, NULL));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_NONE, scene->root);
    CHECK(strstr(log.warning, "left out, and 4 more") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_scenes_shorten_long_names(test_state* test)
{
    static char name[STP_SCENE_TEXT_LIMIT + 3];
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    memset(name, 'a', STP_SCENE_TEXT_LIMIT);
    stp_object object = {.name = name, .parent = STP_NONE, .transform = make_translation(0, 0, 0)};
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &object, NULL));
    memcpy(name + STP_SCENE_TEXT_LIMIT - 1, "\xC3\xA4", 2); // the cut would part a letter
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &object, NULL));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_SCENE_TEXT_LIMIT, strlen(scene->objects[0].name));
    CHECK_EQUAL(STP_SCENE_TEXT_LIMIT - 1, strlen(scene->objects[1].name));
    CHECK(strstr(log.warning, "names of more than 4064 bytes are shortened (1)") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
