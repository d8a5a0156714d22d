// SPDX-License-Identifier: MIT
#include "support_scenes.h"

#include "base/io/file.h"
#include "import/reading/import.h"
#include "lab/scenes/compose.h"
#include "lab/scenes/gltf_plan.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#define TEST_SCALE (1.0 / 4096.0)

// Scenes with machines are large at any scale; they have separate tests.
static const scene_recipe* next_quick(const scene_recipe* recipe)
{
    static const char* const slow[] = {"power-plant", "bakery-line", "paper",         "paper-huge",
                                       "car-factory", "bakery",      "twenty-million"};
    for (size_t i = 0; recipe->name != NULL && i < sizeof(slow) / sizeof(slow[0]); ++i) {
        if (strcmp(recipe->name, slow[i]) == 0) {
            recipe += 1;
            i = SIZE_MAX; // begin again
        }
    }
    return recipe;
}

// Scenes whose smallest form is too large for a quick test.
static double test_scale(const char* name)
{
    return strcmp(name, "boxes") == 0 ? 1.0 : TEST_SCALE;
}

void test_scenes_are_the_same_for_any_number_of_threads(test_state* test)
{
    for (const scene_recipe* recipe = next_quick(scene_recipes()); recipe->name != NULL;
         recipe = next_quick(recipe + 1)) {
        stp_hash hashes[3];
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            stp_context* context = test_context(NULL, threads, NULL);
            uint64_t seed = threads == 3 ? 5 : 0;
            stp_scene* scene = make_scene(context, recipe->name, test_scale(recipe->name), seed);
            CHECK(scene != NULL && scene->view_count > 0 && scene->root != STP_NONE);
            hashes[threads - 1] = hash_scene(scene);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
        CHECK(stp_hash_equal(hashes[0], hashes[1]));
        bool random = strcmp(recipe->name, "spheres") != 0;
        CHECK(stp_hash_equal(hashes[0], hashes[2]) == !random);
    }
}

void test_scenes_have_unit_normals_and_sound_indices(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    for (const scene_recipe* recipe = next_quick(scene_recipes()); recipe->name != NULL;
         recipe = next_quick(recipe + 1)) {
        stp_scene* scene = make_scene(context, recipe->name, test_scale(recipe->name), 0);
        CHECK(scene != NULL);
        for (size_t i = 0; i < scene->mesh_count; ++i) {
            const stp_mesh* mesh = &scene->meshes[i];
            for (size_t k = 0; k < 3 * (size_t)mesh->triangle_count; ++k) {
                CHECK(mesh->indices[k] < mesh->vertex_count);
            }
            for (size_t k = 0; mesh->normals != NULL && k < mesh->vertex_count; ++k) {
                const float* n = mesh->normals + 3 * k;
                CHECK(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-3f);
            }
        }
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}

static bool sums_equal(scene_sums a, scene_sums b)
{
    return a.objects == b.objects && a.unique_objects == b.unique_objects &&
           a.triangles == b.triangles && a.unique_triangles == b.unique_triangles;
}

static void check_written(test_state* test, const char* name, const char* path)
{
    stp_context* context = test_context(NULL, 2, NULL);
    scene_options options = {.scale = test_scale(name)};
    stp_scene *scene = NULL, *read = NULL;
    CHECK(stp_scene_create(context, &scene) == STP_OK);
    CHECK(scene_make(scene, name, &options) == STP_OK);
    CHECK(gltf_file_write(scene, path, NULL) == STP_OK);
    CHECK(stp_scene_finish(scene) == STP_OK);
    CHECK(stp_scene_create(context, &read) == STP_OK);
    CHECK(stp_import_file(read, path, &(stp_import_desc){0}) == STP_OK);
    CHECK(stp_scene_finish(read) == STP_OK);
    CHECK(sums_equal(sum_scene(scene), sum_scene(read)));
    CHECK_EQUAL(scene->view_count, read->view_count);
    for (size_t i = 0; i < scene->view_count; ++i) {
        const stp_scene_view *a = &scene->views[i], *b = &read->views[i];
        CHECK(strcmp(a->name, b->name) == 0);
        CHECK(fabs(a->eye.x - b->eye.x) < 1e-6 && fabs(a->fov_degrees - b->fov_degrees) < 1e-9);
        stp_vec3d gaze = stp_normalized(stp_subd(a->target, a->eye));
        CHECK(stp_dotd(gaze, stp_subd(b->target, b->eye)) > 1.0 - 1e-9);
    }
    stp_scene_destroy(read);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_scenes_read_back_from_gltf_with_the_same_counts(test_state* test)
{
    char folder[] = "stipple-scene-XXXXXX", path[128];
    CHECK(mkdtemp(folder) != NULL);
    for (const scene_recipe* recipe = next_quick(scene_recipes()); recipe->name != NULL;
         recipe = next_quick(recipe + 1)) {
        for (int form = 0; form < 2; ++form) {
            snprintf(path, sizeof(path), "%s/scene.%s", folder, form == 0 ? "glb" : "gltf");
            printf("scene %s as %s\n", recipe->name, path);
            check_written(test, recipe->name, path);
            unlink(path);
        }
    }
    snprintf(path, sizeof(path), "%s/scene.bin", folder);
    unlink(path);
    CHECK(rmdir(folder) == 0);
}

void test_scene_inputs_have_settings(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    static const struct {
        const char* input;
        size_t objects; ///< 0: refused
    } cases[] = {{"scene:boxes", 28},          {"boxes", 28},
                 {"scene:boxes,scale=8", 217}, {"scene:boxes,seed=3,scale=0.3", 9},
                 {"scene:boxes,scale=0", 0},   {"scene:boxes,scale=nan", 0},
                 {"scene:boxes,scale=2x", 0},  {"scene:boxes,seed=-1", 0},
                 {"scene:boxes,", 0},          {"scene:", 0},
                 {"scene:no such scene", 0}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_scene* scene = NULL;
        CHECK(stp_scene_create(context, &scene) == STP_OK);
        log.errors = 0;
        stp_result result = scene_make_input(scene, cases[i].input, NULL);
        CHECK_EQUAL(cases[i].objects != 0 ? STP_OK : STP_ERROR_ARGUMENT, result);
        CHECK_EQUAL(cases[i].objects != 0 ? 0 : 1, log.errors);
        if (cases[i].objects != 0) {
            CHECK_EQUAL(cases[i].objects, scene->object_count);
        }
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}

// A scene is in metres, regardless of the units of earlier inputs.
void test_scenes_keep_their_size_among_other_inputs(test_state* test)
{
    static const struct {
        double before, after; ///< units of the scene, in metres; 0: unknown
        int warnings;
    } cases[] = {{0.001, 0.001, 0}, {1.0, 1.0, 0}, {0.0, 1.0, 1}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_scene* scene = NULL;
        CHECK(stp_scene_create(context, &scene) == STP_OK);
        stp_affine still = stp_affine_identity();
        CHECK(add_group(scene, "before", STP_NONE, &still, NULL) == STP_OK);
        scene->unit_metres = cases[i].before;
        CHECK(scene_make_input(scene, "scene:boxes", NULL) == STP_OK);
        CHECK(stp_scene_finish(scene) == STP_OK);
        CHECK(scene->unit_metres == cases[i].after);
        CHECK_EQUAL(cases[i].warnings, log.warnings);
        // the boxes are four metres wide, and a view shows them from the front
        const stp_boxd* bounds = &scene->nodes[scene->root].bounds;
        CHECK(fabs((bounds->max.x - bounds->min.x) * scene->unit_metres - 4.0) < 1e-9);
        double away = scene->views[0].eye.z * scene->unit_metres;
        CHECK(away > 4.0 && away < 40.0);
        CHECK(scene->views[0].up.y == 1.0);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_scenes_survive_any_failed_allocation(test_state* test)
{
    for (const scene_recipe* recipe = next_quick(scene_recipes()); recipe->name != NULL;
         recipe = next_quick(recipe + 1)) {
        bool done = false;
        for (int n = 0; !done && n < 300; n += 1 + n / 2) {
            test_heap heap = TEST_HEAP(n);
            stp_context* context = test_context(&heap, 1, NULL);
            if (context == NULL) {
                continue;
            }
            stp_scene* scene = make_scene(context, recipe->name, test_scale(recipe->name), 0);
            done = scene != NULL;
            stp_scene_destroy(scene);
            stp_context_destroy(context);
            CHECK_EQUAL(0, heap.live_bytes);
        }
    }
}
