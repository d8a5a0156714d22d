// SPDX-License-Identifier: MIT
#include "scene_helpers.h"
#include "tests.h"

static bool add_user(stp_scene* scene, uint32_t parent, stp_affine at, uint32_t flags,
                     uint32_t used, uint32_t* index)
{
    return add_object(scene, parent, at, flags, index) && stp_scene_add_use(scene, used) == STP_OK;
}

static size_t count_placed(const stp_scene* scene, uint32_t node, stp_affine* last)
{
    stp_placed_part* parts = NULL;
    size_t count = 0;
    if (stp_scene_flatten(scene, node, 100000, &parts, &count) != STP_OK) {
        return SIZE_MAX;
    }
    if (count > 0 && last != NULL) {
        *last = parts[count - 1].transform;
    }
    stp_free(scene->context, parts);
    return count;
}

void test_prototypes_are_seen_only_where_used(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, motor, hidden, line, pump, bare, inner;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 3, 0.0f, &mesh));
    // a motor of two parts, with a transform that must not count
    CHECK(add_object(scene, STP_NONE, make_translation(0, 99, 0), STP_OBJECT_PROTOTYPE, &motor));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK(add_mesh_object(scene, motor, make_translation(0, 2, 0), mesh, &inner));
    // a line with a prototype of its own, which uses both
    CHECK(add_object(scene, STP_NONE, make_translation(10, 0, 0), 0, &line));
    CHECK(add_object(scene, line, make_translation(0, 77, 0), STP_OBJECT_PROTOTYPE, &pump));
    CHECK(add_user(scene, pump, make_translation(0, 0, 1), 0, motor, &hidden));
    CHECK(add_user(scene, pump, make_translation(0, 0, 2), 0, motor, NULL));
    CHECK(add_user(scene, line, make_translation(0, 0, 100), 0, pump, NULL));
    CHECK(add_user(scene, line, make_translation(0, 0, 200), 0, motor, &bare));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(scene->objects[motor].node, scene->objects[bare].node);
    CHECK_EQUAL(scene->objects[motor].node, scene->objects[hidden].node);
    CHECK_EQUAL(1, scene->nodes[scene->root].edge_count); // only the line
    stp_affine last = {0};
    CHECK_EQUAL(2, count_placed(scene, scene->objects[motor].node, &last));
    CHECK(last.m[1][3] == 2.0);
    CHECK_EQUAL(4, count_placed(scene, scene->objects[pump].node, NULL));
    CHECK_EQUAL(6, count_placed(scene, scene->root, &last));
    CHECK(last.m[0][3] == 10.0 && last.m[1][3] == 2.0 && last.m[2][3] == 200.0);
    CHECK_EQUAL(18, scene->nodes[scene->root].triangle_count);
    CHECK(scene->nodes[scene->root].bounds.max.y == 3.0);
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            CHECK(scene->edges[node->first_edge + k].node < i);
        }
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_uses_join_what_the_object_has(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, wheel, car, moving, planted;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &wheel)); // also visible
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &car));
    CHECK_EQUAL(STP_OK, stp_scene_add_use(scene, wheel));
    CHECK(add_mesh_object(scene, car, make_translation(0, 1, 0), mesh, NULL));
    CHECK(add_user(scene, STP_NONE, stp_affine_identity(), STP_OBJECT_MOVING, car, &moving));
    CHECK(add_user(scene, STP_NONE, stp_affine_identity(), 0, car, &planted));
    for (int i = 0; i < 5; ++i) {
        stp_affine at = make_translation(i, 0, 0);
        CHECK_EQUAL(STP_OK, stp_scene_add_instance(scene, &at));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(3, count_placed(scene, scene->objects[car].node, NULL));
    CHECK_EQUAL(3, count_placed(scene, scene->objects[moving].node, NULL));
    CHECK(scene->objects[moving].node != scene->objects[car].node);
    CHECK_EQUAL(STP_OBJECT_MOVING, scene->nodes[scene->objects[moving].node].flags);
    CHECK_EQUAL(15, count_placed(scene, scene->objects[planted].node, NULL));
    CHECK_EQUAL(5, scene->nodes[scene->objects[planted].node].edge_count);
    CHECK_EQUAL(1 + 3 + 3 + 15, count_placed(scene, scene->root, NULL));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_objects_cannot_contain_themselves(test_state* test)
{
    for (int variant = 0; variant < 2; ++variant) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_scene* scene = NULL;
        uint32_t mesh, a, b, inner;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        CHECK(add_strip(scene, 1, 0.0f, &mesh));
        CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &a));
        CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &b));
        CHECK(add_object(scene, a, stp_affine_identity(), 0, &inner));
        if (variant == 0) { // its own ancestor
            CHECK(add_user(scene, inner, stp_affine_identity(), 0, a, NULL));
        } else { // a contains b, and b contains a
            CHECK_EQUAL(STP_OK, stp_scene_add_use(scene, b));
            CHECK(add_user(scene, b, stp_affine_identity(), 0, a, NULL));
        }
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_scene_finish(scene));
        CHECK_EQUAL(1, log.errors);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Each object uses the previous one twice: 2^30 parts, 31 nodes. Also a chain far deeper than the
// stack.
void test_uses_nest_to_any_depth(test_state* test)
{
    enum { DOUBLINGS = 30, DEPTH = 30000 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, last, deep;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &last));
    deep = last;
    for (int i = 0; i < DOUBLINGS; ++i) {
        uint32_t whole;
        uint32_t flags = i < DOUBLINGS - 1 ? STP_OBJECT_PROTOTYPE : 0;
        CHECK(add_object(scene, STP_NONE, stp_affine_identity(), flags, &whole));
        CHECK(add_user(scene, whole, stp_affine_identity(), 0, last, NULL));
        CHECK(add_user(scene, whole, make_translation((double)(1 << i), 0, 0), 0, last, NULL));
        last = whole;
    }
    for (int i = 0; i < DEPTH; ++i) {
        uint32_t outer;
        CHECK(add_object(scene, STP_NONE, stp_affine_identity(), STP_OBJECT_PROTOTYPE, &outer));
        CHECK(add_user(scene, outer, make_translation(0, 1, 0), 0, deep, NULL));
        deep = outer;
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(1 + DOUBLINGS + DEPTH + 1, scene->node_count);
    CHECK_EQUAL(1u << DOUBLINGS, scene->nodes[scene->objects[last].node].triangle_count);
    CHECK(scene->nodes[scene->objects[deep].node].bounds.min.y == DEPTH);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
