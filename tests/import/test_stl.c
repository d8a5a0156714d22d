// SPDX-License-Identifier: MIT
#include "formats_test.h"

#include "base/io/bytes.h"

#include <math.h>

// A tetrahedron: four facets with four positions.
static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const int facets[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

static size_t make_binary(unsigned char* out, const char* header)
{
    memset(out, 0, 84 + 4 * 50);
    memcpy(out, header, strlen(header));
    stp_write_u32(out + 80, 4);
    for (size_t f = 0; f < 4; ++f) {
        for (size_t c = 0; c < 3; ++c) {
            for (size_t i = 0; i < 3; ++i) {
                float value = corners[facets[f][c]][i];
                value = value == 0.0f && f % 2 != 0 ? -0.0f : value; // the same place
                stp_write_f32(out + 84 + 50 * f + 12 + 12 * c + 4 * i, value);
            }
        }
    }
    return 84 + 4 * 50;
}

static size_t make_ascii(char* out, size_t size, const char* name)
{
    size_t length = (size_t)snprintf(out, size, "solid %s\r\n", name);
    for (int f = 0; f < 4; ++f) {
        length +=
            (size_t)snprintf(out + length, size - length, "facet normal 0 0 0\n outer loop\n");
        for (int c = 0; c < 3; ++c) {
            const float* p = corners[facets[f][c]];
            length += (size_t)snprintf(out + length, size - length, "  VERTEX %g %.3f %e\n",
                                       (double)p[0], (double)p[1], (double)p[2]);
        }
        length += (size_t)snprintf(out + length, size - length, " endloop\nendfacet\n");
    }
    return length + (size_t)snprintf(out + length, size - length, "endsolid %s\n", name);
}

static int is_tetrahedron(const stp_mesh* mesh)
{
    int good = mesh->vertex_count == 4 && mesh->triangle_count == 4 && mesh->normals == NULL;
    for (size_t f = 0; f < 4 && good; ++f) {
        for (size_t c = 0; c < 3; ++c) {
            const float* p = mesh->positions + 3 * mesh->indices[3 * f + c];
            const float* wanted = corners[facets[f][c]];
            good = good && p[0] == wanted[0] && p[1] == wanted[1] && p[2] == wanted[2];
        }
    }
    return good;
}

void test_stl_binary(test_state* test)
{
    static const char* const headers[] = {"made by a test", "solid but binary",
                                          "solid facet endsolid"};
    for (size_t i = 0; i < 3; ++i) {
        unsigned char bytes[512];
        size_t size = make_binary(bytes, headers[i]);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.stl", bytes, size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(is_tetrahedron(&scene->meshes[0]));
        CHECK(strcmp(scene->up, "z") == 0);
        stp_scene_destroy(scene);
        // bytes after the last facet are ignored
        scene = import_bytes(context, "a.stl", bytes, size + 7, &result);
        CHECK(scene != NULL && is_tetrahedron(&scene->meshes[0]));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_stl_ascii(test_state* test)
{
    char text[4096];
    size_t size = make_ascii(text, sizeof(text), "part one");
    size += make_ascii(text + size, sizeof(text) - size, "two");
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    // recognised by content, not by extension
    stp_scene* scene = import_bytes(context, "a.bin", text, size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(3, scene->object_count);
    CHECK(strcmp(scene->objects[1].name, "part one") == 0);
    CHECK(strcmp(scene->objects[2].name, "two") == 0);
    CHECK(is_tetrahedron(&scene->meshes[0]) && is_tetrahedron(&scene->meshes[1]));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_stl_solids_without_a_name(test_state* test)
{
    char text[4096];
    size_t size = make_ascii(text, sizeof(text), "");
    size += make_ascii(text + size, sizeof(text) - size, "named");
    size += make_ascii(text + size, sizeof(text) - size, "");
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.stl", text, size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(3, scene->object_count); // the first one is the root's own
    CHECK(strcmp(scene->objects[1].name, "named") == 0 && scene->objects[2].name == NULL);
    CHECK_EQUAL(3, scene->part_count);
    for (uint32_t i = 0; i < 3; ++i) {
        CHECK_EQUAL(1, scene->objects[i].part_count);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_stl_bad_input_is_one_sentence(test_state* test)
{
    unsigned char bytes[512];
    size_t size = make_binary(bytes, "x");
    unsigned char many[512];
    memcpy(many, bytes, size);
    stp_write_u32(many + 80, 0xffffffff);
    static const char two[] = "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid\n";
    static const char within[] = "solid a\nfacet\nvertex 0 0 0\nvertex 1 0 0\nsolid b\n";
    static const char word[] = "solid\nfacet\nvertex 0 0 zero\n";
    const struct {
        const void* bytes;
        size_t size;
        stp_result result;
        const char* says;
    } cases[] = {
        {"", 0, STP_ERROR_TRUNCATED, "shorter"},
        {bytes, 83, STP_ERROR_TRUNCATED, "shorter"},
        {bytes, size - 1, STP_ERROR_TRUNCATED, "after 3"},
        {many, size, STP_ERROR_TRUNCATED, "4294967295"},
        {two, strlen(two), STP_ERROR_FORMAT, "line 5"},
        {within, strlen(within), STP_ERROR_FORMAT, "line 5"},
        {word, strlen(word), STP_ERROR_FORMAT, "line 3"},
        {two, 24, STP_ERROR_TRUNCATED, "within a facet"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.stl", cases[i].bytes, cases[i].size, &result);
        if (result != cases[i].result || strstr(log.text, cases[i].says) == NULL) {
            fprintf(stderr, "case %zu says: %s\n", i, log.text);
        }
        CHECK(scene == NULL);
        CHECK_EQUAL(cases[i].result, result);
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, cases[i].says) != NULL);
        stp_context_destroy(context);
    }
}

void test_stl_survives_truncation(test_state* test)
{
    unsigned char bytes[512];
    CHECK(survives_truncation("a.stl", bytes, make_binary(bytes, "solid")));
    char text[4096];
    CHECK(survives_truncation("a.stl", text, make_ascii(text, sizeof(text), "s")));
}

void test_stl_survives_failing_allocator(test_state* test)
{
    unsigned char bytes[512];
    CHECK(survives_failing_allocator("a.stl", bytes, make_binary(bytes, "b")));
    char text[4096];
    CHECK(survives_failing_allocator("a.stl", text, make_ascii(text, sizeof(text), "s")));
}
