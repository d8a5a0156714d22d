// SPDX-License-Identifier: MIT
// PLY: colours of all types, faces with colours or texture coordinates of their own, and files whose
// elements or rows are in an unusual form.
#include "formats_test.h"
#include "points_test.h"

#include <math.h>

#define QUAD                                                                                       \
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"     \
    "property list uchar int vertex_indices\n"
#define WHOLE "%d 0 0 %.0f %.0f %.0f\n"
#define PARTS "%d 0 0 %.9g %.9g %.9g\n"
#define PLACES "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"

static stp_scene* import_ply(stp_context* context, const char* text, stp_result* result)
{
    return import_bytes(context, "a.ply", text, strlen(text), result);
}

// 8-bit colours in wider types, 16-bit ones, and the full range of a type.
void test_ply_colors_of_every_type(test_state* test)
{
    static const struct {
        const char* type;
        double factor;
        const char* form;
    } cases[] = {
        {"uchar", 1.0, WHOLE},         {"short", 1.0, WHOLE},    {"ushort", 1.0, WHOLE},
        {"int", 1.0, WHOLE},           {"uint", 1.0, WHOLE},     {"float", 1.0, WHOLE},
        {"float", 1.0 / 255.0, PARTS}, {"double", 257.0, PARTS}, {"ushort", 257.0, WHOLE},
        {"int", 257.0, WHOLE},         {"uint", 257.0, WHOLE},   {"uint", 16843009.0, WHOLE},
        {"int", 8421504.498, WHOLE},   {"short", 128.498, WHOLE}};
    static const uint8_t wanted[9] = {200, 100, 50, 0, 255, 0, 10, 20, 250};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char text[1024];
        const char* t = cases[i].type;
        int length = snprintf(text, sizeof(text),
                              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                              "float y\nproperty float z\nproperty %s red\nproperty %s green\n"
                              "property %s blue\nend_header\n",
                              t, t, t);
        for (int k = 0; k < 3; ++k) {
            const uint8_t* c = wanted + 3 * k;
            double f = cases[i].factor;
            length += snprintf(text + length, sizeof(text) - (size_t)length, cases[i].form, k,
                               c[0] * f, c[1] * f, c[2] * f);
        }
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_ply(context, text, &result);
        CHECK_EQUAL(STP_OK, result);
        for (size_t k = 0; k < 9; ++k) {
            int got = scene->point_sets[0].colors[4 * (k / 3) + k % 3];
            CHECK_EQUAL(wanted[k], got);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

static int has_color(const stp_mesh* mesh, size_t triangle, unsigned r, unsigned g, unsigned b)
{
    const unsigned rgba[4] = {r, g, b, 65535};
    for (size_t i = 0; i < 12; ++i) {
        uint32_t vertex = mesh->indices[3 * triangle + i / 4];
        if (mesh->colors == NULL || mesh->colors[4 * vertex + i % 4] != rgba[i % 4]) {
            return 0;
        }
    }
    return 1;
}

void test_ply_colors_of_faces(test_state* test)
{
    static const char* const types[] = {"uchar", "int", "float"};
    for (int i = 0; i < 3; ++i) {
        char text[1024];
        snprintf(text, sizeof(text),
                 "ply\nformat ascii 1.0\n" QUAD "property %s red\nproperty %s green\n"
                 "property %s blue\nend_header\n" PLACES "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n",
                 types[i], types[i], types[i]);
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_ply(context, text, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(scene_is_sound(scene));
        const stp_mesh* mesh = &scene->meshes[0];
        CHECK_EQUAL(2, mesh->triangle_count);
        CHECK_EQUAL(6, mesh->vertex_count);
        CHECK(has_color(mesh, 0, 65535, 0, 0) && has_color(mesh, 1, 0, 0, 65535));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK(survives_truncation("a.ply", text, strlen(text)));
        CHECK(survives_failing_allocator("a.ply", text, strlen(text)));
    }
}

// Colours of vertices have priority, and faces of one colour share their vertices.
void test_ply_colors_of_faces_and_vertices(test_state* test)
{
    static const char both[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 1\nproperty list uchar int vertex_indices\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nend_header\n0 0 0 255 0 0\n1 0 0 255 0 0\n"
        "0 1 0 255 0 0\n3 0 1 2 0 255 0\n";
    static const char same[] = "ply\nformat ascii 1.0\n" QUAD "property uchar red\n"
                               "property uchar green\nproperty uchar blue\nend_header\n" PLACES
                               "3 0 1 2 0 0 255\n3 0 2 3 0 0 255\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_ply(context, both, &result);
    CHECK(scene != NULL && has_color(&scene->meshes[0], 0, 65535, 0, 0));
    stp_scene_destroy(scene);
    scene = import_ply(context, same, &result);
    CHECK(scene != NULL && scene->meshes[0].vertex_count == 4);
    CHECK(has_color(&scene->meshes[0], 1, 0, 0, 65535));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Elements of faces have properties of their own, and all colours have the scale of their element; a
// face without colours is white.
void test_ply_elements_of_faces_have_their_own_colors(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
        "property float red\nproperty float green\nproperty float blue\nelement face 1\n"
        "property list uchar int vertex_indices\nelement face 1\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 1 2\n0 255 0 3 0 1 2\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_ply(context, text, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    CHECK_EQUAL(1, scene->mesh_count);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(3, mesh->triangle_count);
    CHECK(has_color(mesh, 0, 65535, 0, 0) && has_color(mesh, 1, 65535, 65535, 65535));
    CHECK(has_color(mesh, 2, 0, 65535, 0));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_failing_allocator("a.ply", text, strlen(text)));
}

static int write_picture(const char* name, unsigned char red)
{
    const unsigned char tga[18 + 4] = {
        [2] = 2, [12] = 1, [14] = 1, [16] = 32, [17] = 0x28, [20] = red, [21] = 255};
    FILE* file = fopen(name, "wb");
    size_t written = file != NULL ? fwrite(tga, 1, sizeof(tga), file) : 0;
    return file != NULL && fclose(file) == 0 && written == sizeof(tga);
}

static stp_scene* import_file(stp_context* context, const char* text)
{
    stp_scene* scene = NULL;
    FILE* file = fopen("a.ply", "w");
    int good = file != NULL && fputs(text, file) >= 0;
    good = (file == NULL || fclose(file) == 0) && good;
    if (good && stp_scene_create(context, &scene) == STP_OK &&
        stp_import_file(scene, "a.ply", &(stp_import_desc){0}) == STP_OK) {
        return scene;
    }
    stp_scene_destroy(scene);
    return NULL;
}

// Texture coordinates of corners; a face with four corners, one of them concave, keeps them.
void test_ply_texture_coordinates_of_corners(test_state* test)
{
    static const char text[] = "ply\nformat ascii 1.0\ncomment TextureFile t.tga\n" QUAD
                               "property list uchar float texcoord\nend_header\n" PLACES
                               "3 0 1 2 6 0 0 1 0 1 1\n4 0 1 2 3 8 0 0 0.5 0 0.5 1 0 1\n";
    CHECK(write_picture("t.tga", 77));
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = import_file(context, text);
    CHECK(scene != NULL && scene_is_sound(scene));
    CHECK_EQUAL(0, log.warnings);
    CHECK_EQUAL(1, scene->mesh_count);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(3, mesh->triangle_count);
    CHECK_EQUAL(6, mesh->vertex_count); // corner 0 has the same coordinates in both
    for (size_t t = 0; t < 3; ++t) {
        for (size_t c = 0; c < 3; ++c) {
            uint32_t v = mesh->indices[3 * t + c];
            float scale = t == 0 ? 1.0f : 0.5f;
            CHECK(mesh->texcoords[0][2 * v] == scale * mesh->positions[3 * v]);
            CHECK(mesh->texcoords[0][2 * v + 1] == 1.0f - mesh->positions[3 * v + 1]);
        }
    }
    const stp_material* material = &scene->materials[mesh->material];
    CHECK_EQUAL(77, scene->textures[material->base_color_texture.texture].texels[0]);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Faces name one of several pictures, or none.
void test_ply_pictures_of_faces(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\ncomment TextureFile t0.tga\ncomment TextureFile t1.tga\n"
        "comment TextureFile t1.tga\n"
        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 5\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
        "property int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1 1\n"
        "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 1 2 6 0 0 1 0 1 1 1\n3 0 1 2 0 -1\n"
        "3 0 1 2 6 0 0 1 0 1 1 2\n";
    CHECK(write_picture("t0.tga", 10) && write_picture("t1.tga", 20));
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = import_file(context, text);
    CHECK(scene != NULL && scene_is_sound(scene));
    CHECK_EQUAL(4, scene->mesh_count);
    CHECK_EQUAL(2, scene->texture_count); // the third is the second
    static const unsigned counts[] = {1, 2, 1, 1}, reds[] = {10, 20, 20};
    for (int i = 0; i < 4; ++i) {
        const stp_material* material = &scene->materials[scene->meshes[i].material];
        uint32_t texture = material->base_color_texture.texture;
        CHECK_EQUAL(counts[i], scene->meshes[i].triangle_count);
        CHECK(i < 3 ? scene->textures[texture].texels[0] == reds[i] : texture == STP_NONE);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_ply_faces_before_vertices(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n3 0 1 2 0 255 0\n0 0 0\n1 0 0\n0 1 0\n"
        "3 2 1 0\n";
    static const unsigned char binary[] =
        "ply\nformat binary_little_endian 1.0\nelement face 1\n"
        "property list uchar uchar vertex_indices\nelement vertex 3\nproperty uchar x\n"
        "property uchar y\nproperty uchar z\nend_header\n\3\0\1\2\0\0\0\1\0\0\0\1";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_ply(context, text, &result);
    CHECK(scene != NULL && scene_is_sound(scene));
    CHECK_EQUAL(2, scene->mesh_count);
    CHECK_EQUAL(1, scene->meshes[0].triangle_count);
    CHECK(has_color(&scene->meshes[0], 0, 0, 65535, 0));
    CHECK_EQUAL(1, scene->meshes[1].triangle_count);
    stp_scene_destroy(scene);
    scene = import_bytes(context, "a.ply", binary, sizeof(binary), &result); // and its zero byte
    CHECK(scene != NULL && scene->mesh_count == 1 && scene->meshes[0].triangle_count == 1);
    CHECK(scene->meshes[0].positions[7] == 1.0f);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_truncation("a.ply", text, strlen(text)));
    CHECK(survives_failing_allocator("a.ply", text, strlen(text)));
}

// If there are as many lines as rows, each is a row; otherwise, rows may be anywhere.
void test_ply_rows_that_are_longer_than_the_header(test_state* test)
{
    static const char header[] =
        "ply\nformat ascii 1.0\n" QUAD "property uchar flags\nend_header\n";
    static const struct {
        const char* rows;
        int warnings;
    } cases[] = {{"0 0 0 7\n1 0 0\n1 1 0\n\n0 1 0\n3 0 1 2 9 1 1 1 1\n3 0 2 3 9 1 1\n", 1},
                 {"0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2 9 3 0 2 3 9", 0}};
    for (int i = 0; i < 2; ++i) {
        char text[512];
        snprintf(text, sizeof(text), "%s%s", header, cases[i].rows);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_ply(context, text, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(2, scene->meshes[0].triangle_count);
        CHECK(scene->meshes[0].positions[10] == 1.0f);
        CHECK_EQUAL(cases[i].warnings, log.warnings);
        CHECK(i != 0 || strstr(log.warning, "3 rows have more values") != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Such vertices cost their faces; the first finite one chooses the origin, in texts and binary files.
void test_ply_vertices_that_are_not_finite(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty "
        "double z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\nnan 0 0\n"
        "500000.125 0 0\n500001 0 0\n500000 1 0\n0 inf 0\n3 0 1 2\n3 1 2 3\n5 0 1 2 3 4\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_ply(context, text, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(stp_scene_finish(scene) == STP_OK);
    CHECK(scene->meshes[0].triangle_count >= 1);
    CHECK(scene->nodes[scene->root].bounds.min.x == 500000.0);
    CHECK(strstr(log.warning, "with corners that are not finite") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Doubles that floats cannot hold are 0, as those that are not finite.
void test_ply_texture_coordinates_beyond_floats(test_state* test)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty double texture_u\nproperty double texture_v\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0 1e300 1e300\n1 0 0 0.5 -1e300\n"
        "0 1 0 nan 0.25\n3 0 1 2\n";
    static const float wanted[6] = {0.0f, 0.0f, 0.5f, 0.0f, 0.0f, 0.75f};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_ply(context, text, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(memcmp(scene->meshes[0].texcoords[0], wanted, sizeof(wanted)) == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
