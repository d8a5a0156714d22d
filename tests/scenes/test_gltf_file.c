// SPDX-License-Identifier: MIT
#include "support_scenes.h"

#include "import/reading/import.h"
#include "lab/scenes/compose.h"
#include "lab/scenes/gltf_plan.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/solids.h"

#include <math.h>
#include <unistd.h>

static void make_box(mesh_builder* builder, const void* parameters)
{
    (void)parameters;
    mesh_builder_color(builder, 0.5, 0.25, 1.0);
    solid_box(builder, point3(0, 0, 0), point3(1, 2, 3));
}

// A prototype with a child, used at two places, one of them within another use; sheared instances,
// which are no rotation; an object with two parts; a name that needs escapes.
static bool make_difficult_scene(stp_scene* scene)
{
    uint32_t mesh, first, second;
    stp_affine still = stp_affine_identity(), moved = place_at(5, 0, 0);
    mesh_recipe recipe = {"box \"a\\b\"\n", make_box, NULL, 0};
    stp_object prototype = {
        .name = "prototype", .parent = STP_NONE, .transform = still, .flags = STP_OBJECT_PROTOTYPE};
    stp_affine leaning = {{{1, 0.5, 0, 0}, {0, 1, 0, 9}, {0, 0, 1, 0}}};
    stp_affine turned = place_turned(0, 0, 20, 0.15, -2.0);
    return make_meshes(scene, &recipe, 1, &mesh) == STP_OK &&
           stp_scene_add_object(scene, &prototype, &first) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK &&
           add_mesh_object(scene, "child", first, &moved, mesh) == STP_OK &&
           add_group(scene, "user", STP_NONE, &moved, &second) == STP_OK &&
           stp_scene_add_use(scene, first) == STP_OK &&
           add_group(scene, "user of a user", STP_NONE, &turned, NULL) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK &&
           stp_scene_add_use(scene, second) == STP_OK &&
           add_mesh_object(scene, "leaning", STP_NONE, &still, mesh) == STP_OK &&
           stp_scene_add_instance(scene, &leaning) == STP_OK &&
           stp_scene_add_instance(scene, &moved) == STP_OK &&
           add_mesh_object(scene, "instanced", STP_NONE, &moved, mesh) == STP_OK &&
           stp_scene_add_instance(scene, &turned) == STP_OK &&
           stp_scene_add_instance(scene, &moved) == STP_OK &&
           add_mesh_object(scene, "twice", STP_NONE, &still, mesh) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK;
}

static bool nearly(double a, double b)
{
    return fabs(a - b) < 1e-5;
}

void test_gltf_file_writes_out_what_is_used(test_state* test)
{
    char folder[] = "stipple-gltf-XXXXXX", path[128];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/scene.glb", folder);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene *scene = NULL, *read = NULL;
    gltf_figures figures;
    CHECK(stp_scene_create(context, &scene) == STP_OK && make_difficult_scene(scene));
    CHECK(gltf_file_write(scene, path, &figures) == STP_OK);
    CHECK_EQUAL(1, figures.files);
    CHECK_EQUAL(1, figures.meshes);
    CHECK(stp_scene_finish(scene) == STP_OK);
    CHECK(stp_scene_create(context, &read) == STP_OK);
    CHECK(stp_import_file(read, path, &(stp_import_desc){0}) == STP_OK);
    CHECK(stp_scene_finish(read) == STP_OK);
    scene_sums a = sum_scene(scene), b = sum_scene(read);
    CHECK_EQUAL(a.objects, b.objects);
    CHECK_EQUAL(11, b.objects); // 2 in the use, 3 in the use of the use, 2, 2, 2
    CHECK_EQUAL(1, b.unique_objects);
    CHECK(read->meshes[0].colors != NULL && read->meshes[0].colors[0] == 32768);
    stp_boxd p = scene->nodes[scene->root].bounds, q = read->nodes[read->root].bounds;
    CHECK(nearly(p.min.x, q.min.x) && nearly(p.min.y, q.min.y) && nearly(p.min.z, q.min.z));
    CHECK(nearly(p.max.x, q.max.x) && nearly(p.max.y, q.max.y) && nearly(p.max.z, q.max.z));
    stp_scene_destroy(read);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    unlink(path);
    CHECK(rmdir(folder) == 0);
}

// Ten uses of ten uses of ...: 10^8 nodes.
void test_gltf_file_refuses_unbounded_expansion(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = NULL;
    uint32_t mesh, below;
    mesh_recipe recipe = {"box", make_box, NULL, 0};
    stp_affine still = stp_affine_identity();
    CHECK(stp_scene_create(context, &scene) == STP_OK);
    CHECK(make_meshes(scene, &recipe, 1, &mesh) == STP_OK);
    CHECK(add_group(scene, "top", STP_NONE, &still, &below) == STP_OK);
    CHECK(add_mesh_object(scene, "box", below, &still, mesh) == STP_OK);
    for (int level = 0; level < 8; ++level) {
        uint32_t above;
        CHECK(add_group(scene, "level", STP_NONE, &still, &above) == STP_OK);
        for (int i = 0; i < 10; ++i) {
            CHECK(add_group(scene, "use", above, &still, NULL) == STP_OK);
            CHECK(stp_scene_add_use(scene, below) == STP_OK);
        }
        below = above;
    }
    CHECK_EQUAL(STP_ERROR_LIMIT, gltf_file_write(scene, "stipple-never.glb", NULL));
    CHECK_EQUAL(1, log.errors);
    CHECK(access("stipple-never.glb", F_OK) != 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_gltf_file_leaves_nothing_where_it_fails(test_state* test)
{
    char folder[] = "stipple-gltf-XXXXXX", path[128];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/scene.gltf", folder);
    bool done = false;
    for (int n = 0; !done && n < 300; ++n) {
        test_heap heap = TEST_HEAP(-1);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_scene* scene = NULL;
        CHECK(stp_scene_create(context, &scene) == STP_OK && make_difficult_scene(scene));
        heap.fail_at = heap.count + n;
        done = gltf_file_write(scene, path, NULL) == STP_OK;
        CHECK(done || access(path, F_OK) != 0);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
    unlink(path);
    snprintf(path, sizeof(path), "%s/scene.bin", folder);
    unlink(path);
    CHECK(rmdir(folder) == 0);
}
