// SPDX-License-Identifier: MIT
// Large triangles of a node (src/builder/node_triangles.c): opaque ones of everything below it that
// rests, in the node's space.
#include "tests.h"

#include "builder/method_sets.h"

#include <math.h>

enum { SHAPES = 3 };

/// A right triangle with legs of length 2: its level is the square root of 2.
static stp_result add_triangle(stp_scene* scene, uint32_t material, uint32_t* index)
{
    static const float corners[9] = {0, 0, 0, 2, 0, 0, 0, 2, 0};
    stp_mesh mesh = {.vertex_count = 3, .triangle_count = 1, .material = material};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 9);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < 9; ++i) {
        mesh.positions[i] = corners[i];
        mesh.indices[i / 3] = i / 3;
    }
    return stp_scene_add_mesh(scene, &mesh, index);
}

/// An object with a mesh, scaled and moved along x.
static stp_result add_object(stp_scene* scene, uint32_t parent, uint32_t mesh, double scale,
                             double x, uint32_t flags, uint32_t* index)
{
    stp_object object = {.parent = parent, .transform = stp_affine_identity(), .flags = flags};
    for (int k = 0; k < 3; ++k) {
        object.transform.m[k][k] = scale;
    }
    object.transform.m[0][3] = x;
    stp_result result = stp_scene_add_object(scene, &object, index);
    return result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) : result;
}

/// A triangle, one of three times its size, one within that of six times, a large moving one, and a
/// large transparent one.
static stp_result make_scene(stp_scene* scene)
{
    stp_material glass = stp_material_default();
    glass.alpha_mode = STP_ALPHA_BLEND;
    uint32_t material, opaque = 0, clear = 0, top, middle, other;
    stp_result result = stp_scene_add_material(scene, &glass, &material);
    result = result == STP_OK ? add_triangle(scene, 0, &opaque) : result;
    result = result == STP_OK ? add_triangle(scene, material, &clear) : result;
    result = result == STP_OK ? add_object(scene, STP_NONE, opaque, 1, 0, 0, &top) : result;
    result = result == STP_OK ? add_object(scene, top, opaque, 3, 10, 0, &middle) : result;
    result = result == STP_OK ? add_object(scene, middle, opaque, 2, 5, 0, &other) : result;
    result =
        result == STP_OK ? add_object(scene, top, opaque, 9, 7, STP_OBJECT_MOVING, &other) : result;
    result = result == STP_OK ? add_object(scene, top, clear, 9, 8, 0, &other) : result;
    return result == STP_OK ? stp_scene_finish(scene) : result;
}

void test_node_triangles_are_the_large_ones_that_rest(test_state* test)
{
    static const double sizes[SHAPES] = {1, 3, 6}, places[SHAPES] = {0, 10, 25};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK, make_scene(scene));
    uint32_t root = scene->objects[0].node;
    for (double level = 0.0; level < 10.0; level += 0.1) {
        uint32_t expected = 0;
        for (int i = 0; i < SHAPES; ++i) {
            expected += sizes[i] * sqrt(2.0) > level;
        }
        uint32_t count = stp_count_node_triangles(scene, root, level);
        stp_node_triangles taken;
        CHECK_EQUAL(expected, count);
        CHECK_EQUAL(STP_OK, stp_take_node_triangles(scene, root, level, count, &taken));
        CHECK_EQUAL(count, taken.count);
        for (uint32_t t = 0; t < count; ++t) {
            const float* c = taken.corners + 9 * (size_t)t;
            double size = 0.5 * (double)(c[3] - c[0]);
            int which = size < 2.0 ? 0 : size < 5.0 ? 1 : 2;
            CHECK(size == sizes[which] && (double)c[0] == places[which]);
            CHECK(c[6] == c[0] && c[7] == (float)(2.0 * size) && c[8] == 0.0f);
        }
        stp_node_triangles_destroy(context, &taken);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_node_triangles_survive_failing_allocator(test_state* test)
{
    bool done = false;
    for (int n = 0; !done; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_scene* scene = NULL;
        stp_node_triangles taken = {0};
        if (context == NULL) {
            continue;
        }
        stp_result result = stp_scene_create(context, &scene);
        result = result == STP_OK ? make_scene(scene) : result;
        if (result == STP_OK) {
            uint32_t root = scene->objects[0].node;
            result = stp_take_node_triangles(scene, root, 0.0, SHAPES, &taken);
        }
        done = result == STP_OK;
        CHECK(done || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(done ? SHAPES : 0, taken.count);
        stp_node_triangles_destroy(context, &taken);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
