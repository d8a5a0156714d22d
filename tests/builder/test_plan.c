// SPDX-License-Identifier: MIT
// The plan: which nodes get splats, in which order, and how many.
#include "tests.h"

#include "builder/set_plan.h"
#include "scene/partition.h"

#include <string.h>

// A flat sheet of `size` unit squares along each side.
static uint32_t add_sheet(stp_scene* scene, uint32_t size)
{
    stp_context* context = scene->context;
    uint32_t row = size + 1, index = STP_NONE;
    stp_mesh mesh = {.vertex_count = row * row, .triangle_count = 2 * size * size};
    mesh.positions = STP_NEW_ARRAY(context, float, (size_t)3 * row * row);
    mesh.indices = STP_NEW_ARRAY(context, uint32_t, (size_t)6 * size * size);
    for (uint32_t i = 0; i < row * row; ++i) {
        mesh.positions[3 * i] = (float)(i % row);
        mesh.positions[3 * i + 1] = 0.0f;
        mesh.positions[3 * i + 2] = (float)(i / row);
    }
    for (uint32_t i = 0; i < size * size; ++i) {
        uint32_t a = i / size * row + i % size;
        const uint32_t corners[6] = {a, a + row, a + 1, a + 1, a + row, a + row + 1};
        memcpy(mesh.indices + 6 * (size_t)i, corners, sizeof(corners));
    }
    return stp_scene_add_mesh(scene, &mesh, &index) == STP_OK ? index : STP_NONE;
}

static uint32_t add_object(stp_scene* scene, uint32_t parent, uint32_t mesh, double x,
                           uint32_t flags)
{
    uint32_t index = STP_NONE;
    stp_object object = {.parent = parent, .transform = stp_affine_identity(), .flags = flags};
    object.transform.m[0][3] = x;
    if (stp_scene_add_object(scene, &object, &index) != STP_OK ||
        (mesh != STP_NONE &&
         stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) != STP_OK)) {
        return STP_NONE;
    }
    return index;
}

static bool make_plan_by(stp_scene* scene, uint64_t threshold, stp_splat_rule rule,
                         stp_build_plan* plan)
{
    static const uint8_t shading_of_material[16] = {0};
    static const stp_shading shadings[1] = {{0}};
    stp_blue_desc blue = {0};
    stp_build_plan_desc desc = {.blue = &blue,
                                .rule = rule,
                                .shading_of_material = shading_of_material,
                                .shadings = shadings,
                                .threshold = threshold};
    return stp_build_plan_make(scene, &desc, plan) == STP_OK;
}

static bool make_plan(stp_scene* scene, uint64_t threshold, stp_build_plan* plan)
{
    return make_plan_by(scene, threshold, (stp_splat_rule){0}, plan);
}

static uint64_t triangles_of(const stp_scene* scene, const stp_build_plan* plan, uint32_t step)
{
    return scene->nodes[plan->steps[step].node].triangle_count;
}

// Whether each step waits for all steps whose results it may use, and for no later one.
static bool waits_for_what_it_uses(const stp_scene* scene, const stp_build_plan* plan)
{
    uint32_t* last =
        calloc(scene->node_count, sizeof(*last)); // by node: the end of the steps at or below it
    bool good = last != NULL;
    for (uint32_t i = 0; good && i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        uint32_t step = plan->step_of[i], below = 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = scene->edges[node->first_edge + k].node;
            bool rests = (scene->nodes[child].flags & STP_OBJECT_MOVING) == 0;
            below = rests && last[child] > below ? last[child] : below;
        }
        good = step == STP_NONE || (plan->steps[step].needs == below && below <= step);
        last[i] = step != STP_NONE && step >= below ? step + 1 : below;
    }
    free(last);
    return good;
}

void test_plans_make_shared_nodes_once(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    uint32_t sheet = add_sheet(scene, 30); // 1,800 triangles
    for (int i = 0; i < 500; ++i) {
        CHECK(add_object(scene, STP_NONE, sheet, 100.0 * i, 0) != STP_NONE);
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_build_plan plan;
    CHECK(make_plan(scene, 1000, &plan));
    CHECK_EQUAL(2, plan.step_count); // the sheet, and the whole
    CHECK_EQUAL(1800, triangles_of(scene, &plan, 0));
    CHECK_EQUAL(225, plan.steps[0].splat_count); // one for eight triangles
    CHECK_EQUAL(900000, triangles_of(scene, &plan, 1));
    CHECK_EQUAL(50000, plan.steps[1].splat_count);
    CHECK(plan.steps[0].height < plan.steps[1].height);
    CHECK(waits_for_what_it_uses(scene, &plan));
    CHECK(plan.steps[0].needs == 0 && plan.steps[1].needs == 1);
    CHECK(!stp_hash_equal(plan.steps[0].key, plan.steps[1].key));
    stp_build_plan_destroy(context, &plan);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Beside a point far away, a cloud would lie on a few steps of the whole's grid of positions: its
// own set is the topmost.
void test_plans_leave_out_coarse_grids(test_state* test)
{
    enum { POINTS = 5000 };
    for (int far = 0; far < 2; ++far) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        float* positions = STP_NEW_ARRAY(context, float, 3 * POINTS);
        CHECK(positions != NULL);
        for (int i = 0; i < POINTS; ++i) {
            positions[3 * i] = (float)(i % 71) * 0.5f;
            positions[3 * i + 1] = 0.0f;
            positions[3 * i + 2] = (float)(i / 71) * 0.5f;
        }
        positions[0] = far != 0 ? 4e6f : 1e4f;
        stp_point_set points = {.point_count = POINTS, .positions = positions};
        uint32_t index;
        CHECK_EQUAL(STP_OK, stp_scene_add_point_set(scene, &points, &index));
        stp_object object = {.parent = STP_NONE, .transform = stp_affine_identity()};
        CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &object, NULL));
        CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){0}));
        stp_build_plan plan;
        CHECK(make_plan(scene, 1000, &plan));
        CHECK_EQUAL(far != 0 ? 2 : 3, plan.step_count);
        CHECK_EQUAL(far != 0, plan.step_of[scene->root] == STP_NONE);
        stp_build_plan_destroy(context, &plan);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// A maximum is no target: a small part keeps its ratio.
void test_plans_follow_the_rule_of_splats(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_object(scene, STP_NONE, add_sheet(scene, 30), 0.0, 0) != STP_NONE);
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    const struct {
        stp_splat_rule rule;
        uint32_t count;
    } cases[] = {{{0.0, 0}, 225},   {{0.0, 200000}, 225}, {{0.0, 100}, 100}, {{2.0, 200000}, 900},
                 {{2.0, 100}, 100}, {{0.01, 0}, 50000},   {{1e6, 0}, 1}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_build_plan plan;
        CHECK(make_plan_by(scene, 1000, cases[i].rule, &plan));
        CHECK_EQUAL(1, plan.step_count);
        CHECK_EQUAL(cases[i].count, plan.steps[0].splat_count);
        stp_build_plan_destroy(context, &plan);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A cloud that is placed once is one set: the node that places it needs none.
void test_plans_make_placed_clouds_once(test_state* test)
{
    for (uint32_t uses = 1; uses <= 2; ++uses) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        float* positions = STP_NEW_ARRAY(context, float, 300);
        CHECK(positions != NULL);
        for (int i = 0; i < 300; ++i) {
            positions[i] = (float)(i * 37 % 101);
        }
        stp_point_set points = {.point_count = 100, .positions = positions};
        uint32_t index;
        CHECK_EQUAL(STP_OK, stp_scene_add_point_set(scene, &points, &index));
        for (uint32_t i = 0; i < uses; ++i) {
            stp_object object = {.parent = STP_NONE, .transform = stp_affine_identity()};
            object.transform.m[0][3] = 674000.0 + 1000.0 * i;
            CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &object, NULL));
            CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_build_plan plan;
        CHECK(make_plan(scene, 1000, &plan));
        CHECK_EQUAL(uses,
                    plan.step_count); // two placements: one set for both, and one for the whole
        CHECK_EQUAL(0, plan.steps[0].splat_count); // all points
        CHECK(uses == 2 || plan.step_of[scene->root] == STP_NONE || scene->node_count == 1);
        CHECK(waits_for_what_it_uses(scene, &plan));
        stp_build_plan_destroy(context, &plan);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_plans_approximate_small_parts_in_groups(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    for (uint32_t i = 0; i < 20; ++i) {
        CHECK(add_object(scene, STP_NONE, add_sheet(scene, 3 + i % 10), 50.0 * i, 0) != STP_NONE);
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_build_plan plan;
    CHECK(make_plan(scene, 1000, &plan));
    CHECK_EQUAL(1, plan.step_count);
    CHECK_EQUAL(scene->root, plan.steps[0].node);
    CHECK_EQUAL(0, plan.step_of[scene->root]);
    stp_build_plan_destroy(context, &plan);
    CHECK(make_plan(scene, 1000000, &plan));
    CHECK_EQUAL(0, plan.step_count);
    stp_build_plan_destroy(context, &plan);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static bool has_step(const stp_scene* scene, const stp_build_plan* plan, uint32_t object)
{
    return plan->step_of[scene->objects[object].node] != STP_NONE;
}

// A set represents the static content of its node and is sized by it; no static content, no set.
void test_plans_make_no_sets_of_what_only_moves(test_state* test)
{
    for (uint32_t with_hall = 0; with_hall < 2; ++with_hall) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        uint32_t line = add_object(scene, STP_NONE, STP_NONE, 0.0, 0);
        uint32_t arm = add_object(scene, line, add_sheet(scene, 40), 2.0, STP_OBJECT_MOVING);
        uint32_t other = add_object(scene, line, add_sheet(scene, 41), 60.0, STP_OBJECT_MOVING);
        uint32_t sheet = with_hall != 0 ? add_sheet(scene, 30) : STP_NONE;
        uint32_t hall = add_object(scene, STP_NONE, sheet, 300.0, 0);
        uint32_t lamp = add_object(scene, hall, add_sheet(scene, 42), 2.0, STP_OBJECT_MOVING);
        CHECK(lamp != STP_NONE);
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_build_plan plan;
        CHECK(make_plan(scene, 1000, &plan));
        CHECK(has_step(scene, &plan, arm) && has_step(scene, &plan, other));
        CHECK(has_step(scene, &plan, lamp));
        CHECK(!has_step(scene, &plan, line)); // it has no static content
        CHECK(!has_step(scene, &plan, hall)); // the root's set represents all static content
        CHECK_EQUAL(3 + with_hall, plan.step_count);
        CHECK(waits_for_what_it_uses(scene, &plan));
        uint32_t root = plan.step_of[scene->root];
        CHECK_EQUAL(with_hall, root != STP_NONE);
        if (with_hall != 0) {
            CHECK_EQUAL(225, plan.steps[root].splat_count); // of the hall's 1,800 triangles
            CHECK_EQUAL(plan.steps[0].height, plan.steps[root].height); // needs no other set
        }
        stp_build_plan_destroy(context, &plan);
        CHECK(make_plan(scene, 2000, &plan)); // there are more triangles, but they move
        CHECK(plan.step_of[scene->root] == STP_NONE);
        CHECK_EQUAL(3, plan.step_count);
        stp_build_plan_destroy(context, &plan);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Groups of copies share the set of the copied node, instead of a set each.
void test_plans_share_the_sets_of_copies(test_state* test)
{
    enum { GROUPS = 6, COPIES = 10, SIZE = 40, TRIANGLES = 2 * SIZE * SIZE };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    uint32_t sheet = add_sheet(scene, SIZE);
    for (uint32_t i = 0; i < GROUPS; ++i) {
        uint32_t group = add_object(scene, STP_NONE, STP_NONE, 10000.0 * i, 0);
        for (uint32_t k = 0; k < COPIES; ++k) { // at other places in each group
            CHECK(add_object(scene, group, sheet, (60.0 + i) * k, 0) != STP_NONE);
        }
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_build_plan plan;
    CHECK(make_plan_by(scene, 1000, (stp_splat_rule){.maximum = 4000}, &plan));
    CHECK_EQUAL(2, plan.step_count);
    CHECK_EQUAL(TRIANGLES, triangles_of(scene, &plan, 0));
    CHECK_EQUAL(GROUPS * COPIES * TRIANGLES, triangles_of(scene, &plan, 1));
    stp_build_plan_destroy(context, &plan);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Nested objects that show the same content get one set, not one each. Moving ones have their own.
void test_plans_leave_out_redundant_sets(test_state* test)
{
    for (uint32_t moving = 0; moving < 2; ++moving) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        uint32_t parent = STP_NONE;
        for (int i = 0; i < 5; ++i) {
            parent = add_object(scene, parent, STP_NONE, 1.0, 0);
        }
        CHECK(add_object(scene, parent, add_sheet(scene, 40), 2.0,
                         moving != 0 ? STP_OBJECT_MOVING : 0) != STP_NONE);
        CHECK(add_object(scene, parent, add_sheet(scene, 41), 60.0, 0) != STP_NONE);
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_build_plan plan;
        CHECK(make_plan(scene, 1000, &plan));
        uint32_t own = 0;
        for (uint32_t i = 0; i < plan.step_count; ++i) {
            own += triangles_of(scene, &plan, i) == 3200;
        }
        CHECK_EQUAL(moving, own);
        CHECK(plan.step_count <= 1 + moving);
        stp_build_plan_destroy(context, &plan);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
