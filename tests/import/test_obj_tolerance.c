// SPDX-License-Identifier: MIT
// OBJ and MTL files that programs write and other readers accept: what is wrong costs no more than
// itself, and a warning says so.
#include "formats_test.h"

#include <math.h>
#include <sys/stat.h>

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static int write_text(const char* path, const char* text)
{
    FILE* file = fopen(path, "w");
    int good = file != NULL && fputs(text, file) >= 0;
    return file != NULL && fclose(file) == 0 && good;
}

// Imports "a.obj" of the test's folder.
static stp_scene* import_file(stp_context* context)
{
    stp_scene* scene = NULL;
    if (stp_scene_create(context, &scene) == STP_OK &&
        stp_import_file(scene, "a.obj", &(stp_import_desc){0}) == STP_OK) {
        return scene;
    }
    stp_scene_destroy(scene);
    return NULL;
}

void test_obj_missing_attributes_cost_no_face(test_state* test)
{
    static const char* const faces[] = {"f 1/4/7 2/5/8 3/6/9\n", "f 1/0/0 2/0/0 3/0/0\n",
                                        "f 1//-1 2//-1 3//-1\n", "vt 0 0\nf 1/1/1 2/1/1 3/2/1\n"};
    static const int warnings[] = {1, 0, 1, 1};
    for (int i = 0; i < 4; ++i) {
        char text[128];
        int length = snprintf(text, sizeof(text), "%s%s", TRIANGLE, faces[i]);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.obj", text, (size_t)length, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(scene_is_sound(scene));
        CHECK_EQUAL(1, scene->meshes[0].triangle_count);
        CHECK_EQUAL(warnings[i], log.warnings);
        CHECK(warnings[i] == 0 || strstr(log.warning, "do not exist") != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_obj_carriage_returns_end_lines(test_state* test)
{
    static const char text[] = "# mac\rv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.obj", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->meshes[0].triangle_count);
    stp_scene_destroy(scene);
    static const char stl[] = "solid\rfacet\router loop\rvertex 0 0 0\rvertex 1 0 0\rvertex 0 1 0\r"
                              "endloop\rendfacet\rendsolid\r";
    scene = import_bytes(context, "a.stl", stl, strlen(stl), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->meshes[0].triangle_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_truncation("a.obj", text, strlen(text)));
}

// Positions that are not finite cost their faces; the first finite one chooses the origin.
void test_obj_positions_that_are_not_finite(test_state* test)
{
    static const char text[] =
        "v nan 0 0\nv 500000.25 0 0\nv 500001 0 0\nv 500000 1 0\nv 0 1e39 0\n"
        "f 1 2 3\nf 2 3 4\nf 2 3 5\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.obj", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->meshes[0].triangle_count);
    CHECK(stp_scene_finish(scene) == STP_OK);
    CHECK(scene->nodes[scene->root].bounds.min.x == 500000.0);
    CHECK_EQUAL(1, log.warnings);
    CHECK(strstr(log.warning, "2 triangles with corners that are not finite") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_unknown_materials_are_named(test_state* test)
{
    static const char* const texts[] = {TRIANGLE "usemtl nowhere\nf 1 2 3\n",
                                        TRIANGLE "usemtl nowhere\nusemtl too\nf 1 2 3\n",
                                        TRIANGLE "usemtl\nf 1 2 3\n"};
    static const char* const says[] = {"material \"nowhere\"", "\"nowhere\" and others", ""};
    for (int i = 0; i < 3; ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.obj", texts[i], strlen(texts[i]), &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(i < 2, log.warnings);
        CHECK(strstr(log.warning, says[i]) != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// `Tr` is 1 - d, but many programs write `Tr 1` for opaque: alone, it does not hide a material.
void test_mtl_transparency_that_hides_all(test_state* test)
{
    static const struct {
        const char* lines;
        float alpha;
    } cases[] = {{"Tr 1.0\n", 1.0f},        {"Tr 0\n", 1.0f},        {"Tr 0.25\n", 0.75f},
                 {"d 0.5\nTr 1\n", 0.5f},   {"Tr 1\nd 0.5\n", 0.5f}, {"Tr 1\nd 1\n", 1.0f},
                 {"Tr 1.0\nd 0.0\n", 0.0f}, {"d 0\n", 0.0f},         {"Tr 1\nTr 0.25\n", 0.75f}};
    CHECK(write_text("a.obj", "mtllib a.mtl\n" TRIANGLE "usemtl m\nf 1 2 3\n"));
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char text[64];
        snprintf(text, sizeof(text), "newmtl m\n%s", cases[i].lines);
        CHECK(write_text("a.mtl", text));
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = import_file(context);
        CHECK(scene != NULL);
        const stp_material* m = &scene->materials[scene->meshes[0].material];
        CHECK(m->base_color[3] == cases[i].alpha);
        CHECK((m->alpha_mode == STP_ALPHA_OPAQUE) == (cases[i].alpha == 1.0f));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Libraries and pictures with names in other case, with quotes, and a library with a mark.
void test_obj_finds_files_in_other_case(test_state* test)
{
    static const char* const libraries[] = {"Library.MTL", "\"library.mtl\"", "SUB/Library.mtl",
                                            "\"library.mtl\" missing.mtl"};
    static const unsigned char tga[18 + 4] = {
        [2] = 2, [12] = 1, [14] = 1, [16] = 32, [17] = 0x28, [18] = 9, [21] = 255};
    CHECK(mkdir("sub", 0777) == 0);
    CHECK(write_text("library.mtl", "newmtl m\nmap_Kd \"PICTURE one.TGA\"\n"));
    CHECK(write_text("sub/library.mtl", "newmtl m\nmap_Kd Picture One.tga\n"));
    FILE* picture = fopen("Picture one.tga", "wb");
    CHECK(picture != NULL && fwrite(tga, 1, sizeof(tga), picture) == sizeof(tga));
    CHECK(fclose(picture) == 0);
    for (int i = 0; i < 4; ++i) {
        char text[256];
        snprintf(text, sizeof(text), "mtllib %s\n" TRIANGLE "usemtl m\nf 1 2 3\n", libraries[i]);
        CHECK(write_text("a.obj", text));
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_scene* scene = import_file(context);
        CHECK(scene != NULL);
        CHECK_EQUAL(i == 3, log.warnings);
        CHECK_EQUAL(1, scene->texture_count);
        CHECK_EQUAL(9, scene->textures[0].texels[2]);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
