// SPDX-License-Identifier: MIT
#include "tests.h"

#include "import/reading/import.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

typedef struct resolve_case {
    const char* file;
    const char* reference;
    const char* path; // NULL: rejected
} resolve_case;

void test_import_resolve_stays_in_folder(test_state* test)
{
    const resolve_case cases[] = {
        {"folder/a.gltf", "b.bin", "folder/b.bin"},
        {"a.gltf", "b.bin", "b.bin"},
        {"/x/a.gltf", "t/./c d.png", "/x/t/c d.png"},
        {"folder/a.gltf", "t//u\\v.png", "folder/t/u/v.png"},
        {"folder/a.gltf", "t/../b.bin", "folder/b.bin"},
        {"folder/a.gltf", "t/u/../../b.bin", "folder/b.bin"},
        {"folder/a.gltf", "..b/.c", "folder/..b/.c"},
        {"folder/a.gltf", "../b.bin", NULL},
        {"folder/a.gltf", "..", NULL},
        {"folder/a.gltf", "./../b.bin", NULL},
        {"folder/a.gltf", "t/../../b.bin", NULL},
        {"folder/a.gltf", "t\\..\\..\\b.bin", NULL},
        {"folder/a.gltf", "t//../../b.bin", NULL},
        {"folder/a.gltf", "/etc/passwd", NULL},
        {"folder/a.gltf", "\\\\server\\share", NULL},
        {"folder/a.gltf", "C:\\b.bin", NULL},
        {"folder/a.gltf", "c:b.bin", NULL},
        {"folder/a.gltf", "https://example.com/b.bin", NULL},
        {"folder/a.gltf", "file:b.bin", NULL},
        {"folder/a.gltf", "b\n.bin", NULL},
        {"folder/a.gltf", "", NULL},
        {"folder/a.gltf", "t/..", NULL},
        {"folder/a.gltf", ".", NULL},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_scene* scene;
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        stp_import import = {.context = context, .scene = scene, .path = cases[i].file};
        const char* path;
        stp_result result = stp_import_resolve(&import, cases[i].reference, &path);
        CHECK_EQUAL(cases[i].path != NULL ? STP_OK : STP_ERROR_FORMAT, result);
        CHECK_EQUAL(result == STP_OK ? 0 : 1, log.errors);
        CHECK(result != STP_OK || strcmp(path, cases[i].path) == 0);
        stp_folder_listings_close(context, &import.folders);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_import_resolve_optional_warns(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import import = {.context = context, .scene = scene, .path = "no/such/folder/a.gltf"};
    const char* path = "";
    CHECK_EQUAL(STP_OK, stp_import_resolve_optional(&import, "images[0]", "b.png", &path));
    CHECK(path == NULL);
    CHECK_EQUAL(STP_OK, stp_import_resolve_optional(&import, "images[0]", "../b.png", &path));
    CHECK(path == NULL);
    CHECK_EQUAL(0, log.errors);
    stp_folder_listings_close(context, &import.folders);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static int write_file(const char* path)
{
    FILE* file = fopen(path, "w");
    return file != NULL && fclose(file) == 0;
}

// Names that differ in case, or lack a query. A folder that exists as written is the one.
void test_import_resolve_finds_similar_names(test_state* test)
{
    static const char* const pairs[][2] = {{"tex/A.PNG", "tex/a.PNG"},
                                           {"Tex/B.png", "Tex/b.png"},
                                           {"tEx/b.png?v=1", "Tex/b.png"},
                                           {"tex/b.png", NULL},
                                           {"none/a.png", NULL}};
    CHECK((mkdir("Tex", 0700) == 0 || errno == EEXIST) && write_file("Tex/b.png"));
    CHECK((mkdir("tex", 0700) == 0 || errno == EEXIST) && write_file("tex/a.PNG"));
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import import = {.context = context, .scene = scene, .path = "a.gltf"};
    for (size_t i = 0; i < sizeof(pairs) / sizeof(pairs[0]); ++i) {
        const char* path;
        CHECK_EQUAL(STP_OK, stp_import_resolve_optional(&import, "p", pairs[i][0], &path));
        CHECK(pairs[i][1] == NULL ? path == NULL : path != NULL && !strcmp(path, pairs[i][1]));
    }
    size_t used = import.folders.next;
    for (int i = 0; i < 100; ++i) {
        char name[32];
        const char* path;
        snprintf(name, sizeof(name), "tex/%d.png", i);
        CHECK_EQUAL(STP_OK, stp_import_resolve_optional(&import, "p", name, &path));
        CHECK(path == NULL && import.folders.next == used); // the folder is read once
    }
    stp_folder_listings_close(context, &import.folders);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_import_turns_axes_and_units(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import import = {.context = context, .scene = scene, .path = "a"};
    stp_object root = {.parent = STP_NONE, .transform = stp_affine_identity()};
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &root, &import.root));
    stp_import_set_axes(&import, 'z', 0.001);
    stp_vec3d up = stp_affine_point(&scene->objects[0].transform, (stp_vec3d){1, 2, 3});
    CHECK(up.x == 1.0 && up.y == 3.0 && up.z == -2.0);
    CHECK(scene->unit_metres == 0.001 && strcmp(scene->up, "z") == 0);

    // a second file in metres joins a scene in millimetres
    CHECK_EQUAL(STP_OK, stp_scene_add_object(scene, &root, &import.root));
    stp_import_set_axes(&import, 'y', 1.0);
    stp_vec3d far = stp_affine_point(&scene->objects[1].transform, (stp_vec3d){1, 2, 3});
    CHECK(far.x == 1000.0 && far.y == 2000.0 && far.z == 3000.0);
    CHECK(scene->unit_metres == 0.001);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_import_refuses_unknown_files(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    const stp_import_desc desc = {0};
    CHECK_EQUAL(STP_ERROR_IO, stp_import_file(scene, "no/such/file.gltf", &desc));
    CHECK_EQUAL(1, log.errors);
    CHECK_EQUAL(STP_ERROR_IO, stp_import_file(scene, "/", &desc));
    CHECK_EQUAL(2, log.errors);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
