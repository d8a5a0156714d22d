// SPDX-License-Identifier: MIT
#include "scene_helpers.h"
#include "tests.h"

// Two equal assemblies (written out twice, with copies of their meshes) and one that differs in a
// transform.
static bool add_assembly(stp_scene* scene, stp_affine transform, double gap, uint32_t* index)
{
    uint32_t bolt, plate, child;
    return add_strip(scene, 2, 0.0f, &bolt) && add_strip(scene, 5, 1.0f, &plate) &&
           add_mesh_object(scene, STP_NONE, transform, plate, index) &&
           add_mesh_object(scene, *index, make_translation(0, gap, 0), bolt, &child) &&
           add_mesh_object(scene, *index, make_translation(0, 2 * gap, 0), bolt, &child);
}

void test_identical_subtrees_become_one_node(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    uint32_t a, b, c;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_assembly(scene, make_translation(1, 0, 0), 3.0, &a));
    CHECK(add_assembly(scene, make_translation(2, 0, 0), 3.0, &b));
    CHECK(add_assembly(scene, make_translation(3, 0, 0), 4.0, &c));
    CHECK_EQUAL(6, scene->mesh_count);
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(2, scene->mesh_count); // copies merged
    CHECK_EQUAL(scene->objects[a].node, scene->objects[b].node);
    CHECK(scene->objects[a].node != scene->objects[c].node);
    CHECK_EQUAL(scene->objects[a + 1].node, scene->objects[c + 1].node); // the bolts are still one
    CHECK_EQUAL(4, scene->node_count); // bolt, two assemblies, root
    const stp_node* root = &scene->nodes[scene->root];
    CHECK_EQUAL(3, root->edge_count);
    CHECK_EQUAL(27, root->triangle_count);
    for (size_t i = 0; i < scene->node_count; ++i) { // children have lower indices
        const stp_node* node = &scene->nodes[i];
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            CHECK(scene->edges[node->first_edge + k].node < i);
        }
    }
    // x: plate of 7 vertices from 1 to 4, moved by 1..3; y: strips of height 1, bolts moved by up
    // to 8
    CHECK(root->bounds.min.x == 1.0 && root->bounds.max.x == 7.0);
    CHECK(root->bounds.min.y == 0.0 && root->bounds.max.y == 9.0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_different_meshes_are_not_merged(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    enum { COUNT = 8 };
    uint32_t material;
    stp_material other = stp_material_default();
    other.roughness = 0.5f;
    CHECK_EQUAL(STP_OK, stp_scene_add_material(scene, &other, &material));
    for (int i = 0; i < COUNT; ++i) {
        stp_mesh mesh = make_strip_mesh(context, 4, 0.0f);
        CHECK(mesh.positions != NULL && mesh.indices != NULL);
        size_t n = mesh.vertex_count;
        mesh.material = i == 1 ? material : 0;
        mesh.normals = i == 2 ? STP_NEW_ZEROED(context, float, 3 * n) : NULL;
        mesh.texcoords[0] = i == 3 ? STP_NEW_ZEROED(context, float, 2 * n) : NULL;
        mesh.texcoords[1] = i == 4 ? STP_NEW_ZEROED(context, float, 2 * n) : NULL;
        mesh.colors = i == 5 ? STP_NEW_ZEROED(context, uint16_t, 4 * n) : NULL;
        mesh.positions[0] += i == 6 ? 1e-6f : 0.0f;
        if (i == 7) {
            uint32_t swap = mesh.indices[1];
            mesh.indices[1] = mesh.indices[2];
            mesh.indices[2] = swap;
        }
        uint32_t index;
        CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &mesh, &index));
        CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), index, NULL));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(COUNT, scene->mesh_count);
    CHECK_EQUAL(COUNT + 1, scene->node_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_instances_share_one_node(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, object, child;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 3, 0.0f, &mesh));
    CHECK(add_mesh_object(scene, STP_NONE, make_translation(0, 0, 5), mesh, &object));
    for (int i = 0; i < 1000; ++i) {
        stp_affine at = make_translation(10.0 * i, 0, 0);
        CHECK_EQUAL(STP_OK, stp_scene_add_instance(scene, &at));
    }
    CHECK(add_mesh_object(scene, object, make_translation(0, -7, 0), mesh,
                          &child)); // once, not a thousand times
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    const stp_node* node = &scene->nodes[scene->objects[object].node];
    CHECK_EQUAL(1001, node->edge_count);
    CHECK_EQUAL(3 * 1001, node->triangle_count);
    CHECK_EQUAL(3, scene->node_count); // the strip, the object, the root
    CHECK(node->bounds.max.x == 9990.0 + 2.0 && node->bounds.min.y == -7.0);
    CHECK(scene->nodes[scene->root].bounds.max.z == 5.0);
    stp_placed_part* parts = NULL;
    size_t count = 0;
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 2000, &parts, &count));
    CHECK_EQUAL(1001, count);
    stp_free(context, parts);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_empty_scenes_have_no_root(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (int variant = 0; variant < 4; ++variant) {
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        uint32_t mesh = 0, object = STP_NONE;
        if (variant >= 1) { // empty objects
            CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &object));
            CHECK(add_object(scene, object, stp_affine_identity(), 0, NULL));
        }
        if (variant >= 2) { // a mesh without triangles
            CHECK(add_strip(scene, 0, 0.0f, &mesh));
            CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
        }
        if (variant == 3) { // instances of nothing
            stp_affine at = stp_affine_identity();
            CHECK_EQUAL(STP_OK, stp_scene_add_instance(scene, &at));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(STP_NONE, scene->root);
        CHECK_EQUAL(0, scene->node_count);
        stp_placed_part* parts = NULL;
        size_t count = 7;
        CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 10, &parts, &count));
        CHECK_EQUAL(0, count);
        stp_free(context, parts);
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}

void test_empty_branches_are_left_out(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, hollow, full;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &hollow));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &full));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_NONE, scene->objects[hollow].node);
    CHECK_EQUAL(1, scene->nodes[scene->root].edge_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_deep_trees_need_no_stack(test_state* test)
{
    enum { DEPTH = 50000 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, parent = STP_NONE;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    for (int i = 0; i < DEPTH; ++i) {
        CHECK(add_object(scene, parent, make_translation(0, 1, 0), 0, &parent));
    }
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(DEPTH + 1, scene->node_count);
    stp_placed_part* parts = NULL;
    size_t count = 0;
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 10, &parts, &count));
    CHECK_EQUAL(1, count);
    CHECK(parts[0].transform.m[1][3] == DEPTH);
    CHECK(scene->nodes[scene->root].bounds.min.y == DEPTH);
    stp_free(context, parts);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A tree of two equal children at each level shares down to one node per level, and places 2^depth
// parts.
void test_flatten_stops_at_the_limit(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = NULL;
    uint32_t mesh;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    enum { DEPTH = 10, COUNT = (1 << (DEPTH + 1)) - 1 };
    for (uint32_t i = 0; i < COUNT; ++i) { // a heap: the parent of i is (i - 1) / 2
        uint32_t parent = i == 0 ? STP_NONE : (i - 1) / 2;
        uint32_t level = 0;
        while ((2u << level) <= i + 1) {
            level += 1;
        }
        stp_affine at = make_translation(i % 2 == 0 ? 0.0 : (double)(COUNT >> level), 0, 0);
        CHECK(add_object(scene, parent, at, 0, NULL));
        if (i >= COUNT / 2) {
            CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
        }
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK(scene->node_count < 4 * DEPTH);
    CHECK_EQUAL(1 << DEPTH, scene->nodes[scene->root].triangle_count);
    stp_placed_part* parts = NULL;
    size_t count = 0;
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 1 << DEPTH, &parts, &count));
    CHECK_EQUAL(1 << DEPTH, count);
    stp_free(context, parts);
    CHECK_EQUAL(0, log.errors);
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_scene_flatten(scene, scene->root, (1 << DEPTH) - 1, &parts, &count));
    CHECK_EQUAL(1, log.errors);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_flatten_keeps_order_and_flags(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t meshes[3], top, moving, below;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    for (int i = 0; i < 3; ++i) {
        CHECK(add_strip(scene, 1, (float)i, &meshes[i]));
    }
    CHECK(add_object(scene, STP_NONE, make_translation(100, 0, 0), 0, &top));
    CHECK(add_mesh_object(scene, top, stp_affine_identity(), meshes[0], NULL));
    CHECK(add_object(scene, top, make_translation(0, 10, 0), STP_OBJECT_MOVING, &moving));
    CHECK(add_mesh_object(scene, moving, make_translation(0, 0, 1), meshes[1], &below));
    CHECK(add_mesh_object(scene, top, stp_affine_identity(), meshes[2], NULL));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_placed_part* parts = NULL;
    size_t count = 0;
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 10, &parts, &count));
    CHECK_EQUAL(3, count);
    for (uint32_t i = 0; i < 3; ++i) { // as in the input; everything below a moving object moves
        CHECK_EQUAL(meshes[i], parts[i].part.index);
        CHECK_EQUAL(i == 1 ? STP_OBJECT_MOVING : 0, parts[i].flags);
    }
    CHECK(parts[1].transform.m[0][3] == 100 && parts[1].transform.m[1][3] == 10 &&
          parts[1].transform.m[2][3] == 1);
    stp_free(context, parts);
    // relative to the moving node itself, its parts do not move
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->objects[moving].node, 10, &parts, &count));
    CHECK_EQUAL(1, count);
    CHECK_EQUAL(0, parts[0].flags);
    CHECK(parts[0].transform.m[0][3] == 0 && parts[0].transform.m[2][3] == 1);
    stp_free(context, parts);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_moving_and_resting_copies_stay_apart(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, resting, moving;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), mesh, &resting));
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), STP_OBJECT_MOVING, &moving));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK(scene->objects[resting].node != scene->objects[moving].node);
    CHECK_EQUAL(STP_OBJECT_MOVING, scene->nodes[scene->objects[moving].node].flags);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_bounds_are_those_of_used_vertices(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t index;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    stp_mesh mesh = make_strip_mesh(context, 20, 0.0f);
    CHECK(mesh.positions != NULL && mesh.indices != NULL);
    mesh.triangle_count = 2; // vertices 0..3 only
    CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &mesh, &index));
    CHECK(add_mesh_object(scene, STP_NONE, stp_affine_identity(), index, NULL));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK(scene->meshes[0].bounds.max.x == 1.5f);
    CHECK(scene->nodes[scene->root].bounds.max.x == 1.5);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Everything a scene can contain, so that each allocation is reached once.
static bool make_full_scene(stp_context* context, stp_scene** out)
{
    stp_scene* scene = NULL;
    if (stp_scene_create(context, &scene) != STP_OK) {
        return false;
    }
    *out = scene;
    uint32_t mesh, object;
    stp_material material = stp_material_default();
    material.name = "steel";
    uint8_t* texels = STP_NEW_ZEROED(context, uint8_t, 4);
    stp_texture texture = {.name = "rust", .width = 1, .height = 1, .texels = texels};
    stp_scene_view view = {.name = "front"};
    stp_source source = {.path = "a.obj", .format = "obj"};
    if (texels == NULL || stp_scene_add_texture(scene, &texture, NULL) != STP_OK ||
        stp_scene_add_material(scene, &material, NULL) != STP_OK ||
        stp_scene_add_view(scene, &view) != STP_OK ||
        stp_scene_add_source(scene, &source) != STP_OK) {
        return false;
    }
    float* points = STP_NEW_ZEROED(context, float, 6);
    stp_point_set set = {.name = "scan", .point_count = 2, .positions = points};
    if (points == NULL || stp_scene_add_point_set(scene, &set, NULL) != STP_OK) {
        return false;
    }
    for (int i = 0; i < 40; ++i) {
        stp_object named = {.name = "part",
                            .id = "{}",
                            .parent = STP_NONE,
                            .transform = make_translation(i % 5, 0, 0)};
        if (!add_strip(scene, 2, (float)(i % 3), &mesh) ||
            stp_scene_add_object(scene, &named, &object) != STP_OK ||
            stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) != STP_OK ||
            stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, 0}) != STP_OK ||
            stp_scene_add_instance(scene, &named.transform) != STP_OK) {
            return false;
        }
    }
    if (stp_scene_finish(scene) != STP_OK) {
        return false;
    }
    stp_placed_part* parts = NULL;
    size_t count = 0;
    bool flat =
        stp_scene_flatten(scene, scene->root, 1000, &parts, &count) == STP_OK && count == 80;
    stp_free(context, parts);
    return flat;
}

void test_scenes_survive_failing_allocator(test_state* test)
{
    bool made = false;
    int failures = 0;
    for (int n = 0; !made && n < 1000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_scene* scene = NULL;
            made = make_full_scene(context, &scene);
            failures += !made;
            CHECK(log.errors <= 1);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 30);
}

void test_graphs_do_not_depend_on_threads(test_state* test)
{
    size_t nodes[3];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        for (int i = 0; i < 300; ++i) {
            uint32_t mesh;
            CHECK(add_strip(scene, (uint32_t)(1 + i % 7), (float)(i % 11), &mesh));
            CHECK(add_mesh_object(scene, STP_NONE, make_translation(i, 0, 0), mesh, NULL));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(77, scene->mesh_count);
        nodes[threads - 1] = scene->node_count;
        for (uint32_t i = 0; i < 300; ++i) { // the first of its kind stays
            stp_part part = scene->node_parts[scene->nodes[scene->objects[i].node].first_part];
            CHECK_EQUAL(i < 77 ? i : i % 77, part.index);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
    CHECK_EQUAL(nodes[0], nodes[1]);
    CHECK_EQUAL(nodes[0], nodes[2]);
}

void test_root_bounds_are_tight_whatever_turns(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    const double c = sqrt(0.5);
    stp_affine left = {{{c, -c, 0, 0}, {c, c, 0, 0}, {0, 0, 1, 0}}};
    stp_affine right = {{{c, c, 0, 0}, {-c, c, 0, 0}, {0, 0, 1, 0}}};
    uint32_t mesh, outer;
    CHECK(add_strip(scene, 3, 1.0f, &mesh)); // x from 1 to 3, y from 0 to 1
    CHECK(add_object(scene, STP_NONE, left, 0, &outer));
    CHECK(add_mesh_object(scene, outer, right, mesh, NULL));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_boxd box = scene->nodes[scene->root].bounds;
    CHECK(fabs(box.min.x - 1.0) < 1e-9 && fabs(box.max.x - 3.0) < 1e-9);
    CHECK(fabs(box.min.y) < 1e-9 && fabs(box.max.y - 1.0) < 1e-9);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
