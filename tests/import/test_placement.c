// SPDX-License-Identifier: MIT
#include "tests.h"

#include "import/reading/import.h"
#include "scene/partition.h"

#include <math.h>
#include <string.h>

typedef struct placement_log {
    int warnings, errors;
    char text[512];
} placement_log;

static void log_message(stp_log_level level, const char* message, void* user)
{
    placement_log* log = user;
    log->errors += level == STP_LOG_ERROR;
    log->warnings += level == STP_LOG_WARNING;
    snprintf(log->text, sizeof(log->text), "%s", message);
}

static stp_result import_text(stp_scene* scene, const char* name, const char* text, double unit)
{
    const stp_import_desc desc = {.unit_metres = unit};
    return stp_import_memory(scene, name, text, strlen(text), &desc);
}

static const char metres[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0,\"translation\":[500000.0625,20,-4500000.25]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

static const char unsaid[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

void test_inputs_of_several_units_make_one_scene(test_state* test)
{
    // a file with a unit, then one without; and in the other order; with a warning
    for (int variant = 0; variant < 3; ++variant) {
        placement_log log = {0};
        stp_context* context = NULL;
        stp_scene* scene = NULL;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &(stp_context_desc){.log = log_message,
                                                                             .log_user = &log}));
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        double unit = variant == 2 ? 0.001 : 0.0;
        const char* texts[2] = {variant == 1 ? unsaid : metres, variant == 1 ? metres : unsaid};
        const char* names[2] = {variant == 1 ? "a.obj" : "a.gltf",
                                variant == 1 ? "b.gltf" : "b.obj"};
        CHECK_EQUAL(STP_OK, import_text(scene, names[0], texts[0], unit));
        CHECK_EQUAL(0, log.warnings);
        uint32_t second = (uint32_t)scene->object_count;
        CHECK_EQUAL(STP_OK, import_text(scene, names[1], texts[1], unit));
        CHECK_EQUAL(variant == 2 ? 0 : 1, log.warnings);
        CHECK(variant == 2 || strncmp(log.text, names[1], strlen(names[1])) == 0);
        CHECK_EQUAL(0, log.errors);
        CHECK(scene->unit_metres == 1.0);
        CHECK(scene->objects[second].transform.m[0][0] == (variant == 2 ? 0.001 : 1.0));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_first_known_unit_is_that_of_the_scene(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK_EQUAL(STP_OK, import_text(scene, "a.obj", unsaid, 0.0));
    CHECK_EQUAL(STP_OK, import_text(scene, "b.obj", unsaid, 0.0254));
    uint32_t third = (uint32_t)scene->object_count;
    CHECK_EQUAL(STP_OK, import_text(scene, "c.gltf", metres, 0.0));
    CHECK(scene->unit_metres == 0.0254);
    CHECK(fabs(scene->objects[third].transform.m[2][2] - 1.0 / 0.0254) < 1e-12);
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    // the site in inches, from its metres
    CHECK(fabs(scene->nodes[scene->root].bounds.min.z + 4500000.25 / 0.0254) < 1e-3);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A site in a national grid: hundreds of kilometres east, thousands north, with details of a tenth
// of a millimetre.
void test_far_sites_keep_their_millimetres(test_state* test)
{
    enum { COUNT = 40 };
    static char text[COUNT * 200];
    double expected[3 * COUNT][3];
    size_t length = 0;
    for (int i = 0; i < 3 * COUNT; ++i) {
        expected[i][0] = 512345.1234 + 0.0007 * i;
        expected[i][1] = 37.0001 * (i % 3);
        expected[i][2] = -5412345.4321 + (i % 3 == 2 ? 0.0101 : 0.0) - i;
        length += (size_t)snprintf(text + length, sizeof(text) - length, "v %.4f %.4f %.4f\n",
                                   expected[i][0], expected[i][1], expected[i][2]);
    }
    for (int i = 0; i < COUNT; ++i) {
        length += (size_t)snprintf(text + length, sizeof(text) - length, "o %d\nf %d %d %d\n", i,
                                   3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK_EQUAL(STP_OK, import_text(scene, "site.obj", text, 1.0));
    CHECK_EQUAL(STP_OK, import_text(scene, "machine.gltf", metres, 0.0));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_partition_desc desc = {.leaf_triangles = 3, .child_count = 3};
    CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    CHECK_EQUAL(STP_OK, stp_scene_flatten(scene, scene->root, 1000, &parts, &part_count));
    int found = 0, machine = 0;
    for (size_t i = 0; i < part_count; ++i) {
        const stp_mesh* mesh = &scene->meshes[parts[i].part.index];
        for (size_t k = 0; k < 3 * (size_t)mesh->triangle_count; ++k) {
            const float* p = mesh->positions + 3 * (size_t)mesh->indices[k];
            stp_vec3d at = stp_affine_point(&parts[i].transform,
                                            (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
            machine += at.x == 500000.0625 && at.y == 20.0 && at.z == -4500000.25;
            for (int v = 0; v < 3 * COUNT; ++v) {
                found += fabs(at.x - expected[v][0]) < 2e-4 && fabs(at.y - expected[v][1]) < 2e-4 &&
                         fabs(at.z - expected[v][2]) < 2e-4;
            }
        }
    }
    CHECK_EQUAL(3 * COUNT, found);
    CHECK_EQUAL(1, machine);
    stp_free(context, parts);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_corrections_replace_what_an_input_says(test_state* test)
{
    // glTF is in metres, with y up; as a correction, -x is up and the unit is a foot
    for (int corrects = 0; corrects < 2; ++corrects) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        const stp_import_desc desc = {.up = 'X', .unit_metres = 0.3048, .corrects = corrects};
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.gltf", metres, sizeof(metres) - 1, &desc));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_boxd box = scene->nodes[scene->root].bounds;
        CHECK(scene->unit_metres == (corrects ? 0.3048 : 1.0));
        CHECK(scene->up[0] == (corrects ? 'x' : 'y'));
        CHECK(fabs((corrects ? -box.max.y : box.min.x) - 500000.0625) < 2.0);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_importers_list_the_formats_that_they_read(test_state* test)
{
    static const char* const models[] = {"a.las", "b.LAZ", "c.copc.laz", "d.e57",      "e.Glb",
                                         "f.fbx", "g.dxf", "h.xyz",      "dir.x/i.obj"};
    static const char* const others[] = {"a.wrl",     "b.step", "c.txt", "d.stip", "las",
                                         "dir.obj/e", "f.png",  ".",     ""};
    for (size_t i = 0; i < sizeof(models) / sizeof(models[0]); ++i) {
        CHECK(stp_import_lists(models[i]));
    }
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); ++i) {
        CHECK(!stp_import_lists(others[i]));
    }
    // an empty file of each listed suffix is empty or damaged, not of an unknown format
    for (const stp_importer* const* i = stp_importers(); *i != NULL; ++i) {
        for (const char* at = stp_importer_listed(*i); *at != 0;) {
            char name[32];
            int length = (int)strcspn(at, " ");
            snprintf(name, sizeof(name), "a.%.*s", length, at);
            at += length + (at[length] == ' ');
            stp_context* context = test_context(NULL, 1, NULL);
            stp_scene* scene = NULL;
            CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
            stp_result result = stp_import_memory(scene, name, "", 0, &(stp_import_desc){0});
            CHECK(result != STP_ERROR_UNSUPPORTED);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}
