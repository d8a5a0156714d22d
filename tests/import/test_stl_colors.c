// SPDX-License-Identifier: MIT
// STL: colours of facets in both codings, coordinates of national grids, facets with corners that
// are not finite.
#include "formats_test.h"

#include "base/io/bytes.h"

#include <math.h>

// Facets along a strip, so that neighbours share two corners.
static size_t write_binary(unsigned char* out, const char* header, const uint16_t* bits,
                           uint32_t count)
{
    memset(out, 0, 84 + 50 * count);
    memcpy(out, header, strlen(header));
    stp_write_u32(out + 80, count);
    for (uint32_t f = 0; f < count; ++f) {
        unsigned char* at = out + 84 + 50 * f;
        for (uint32_t c = 0; c < 3; ++c) {
            stp_write_f32(at + 12 + 12 * c, (float)((f + c) / 2));
            stp_write_f32(at + 16 + 12 * c, (float)((f + c) % 2));
        }
        stp_write_u16(at + 48, bits[f]);
    }
    return 84 + 50 * (size_t)count;
}

static stp_scene* import_facets(const char* header, const uint16_t* bits, uint32_t count,
                                stp_context** context)
{
    unsigned char bytes[84 + 50 * 8];
    size_t size = write_binary(bytes, header, bits, count);
    stp_result result;
    *context = test_context(NULL, 1, NULL);
    return import_bytes(*context, "a.stl", bytes, size, &result);
}

static int has_color(const stp_mesh* mesh, size_t triangle, unsigned r, unsigned g, unsigned b)
{
    const unsigned rgb[3] = {r, g, b};
    for (size_t c = 0; c < 9; ++c) {
        uint32_t vertex = mesh->indices[3 * triangle + c / 3];
        if (mesh->colors == NULL || mesh->colors[4 * vertex + c % 3] != rgb[c % 3] ||
            mesh->colors[4 * vertex + 3] != 65535) {
            return 0;
        }
    }
    return 1;
}

void test_stl_colors_of_viscam(test_state* test)
{
    const uint16_t bits[] = {0x8000 | 31 << 10, 0x8000 | 31, 0, 0x001f};
    stp_context* context;
    stp_scene* scene = import_facets("made by a test", bits, 4, &context);
    CHECK(scene != NULL && scene_is_sound(scene));
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(4, mesh->triangle_count);
    CHECK(has_color(mesh, 0, 65535, 0, 0));
    CHECK(has_color(mesh, 1, 0, 0, 65535));
    CHECK(has_color(mesh, 2, 65535, 65535, 65535));
    CHECK(has_color(mesh, 3, 65535, 65535, 65535));
    CHECK_EQUAL(3 + 3 + 4, mesh->vertex_count); // the last two share their edge
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_stl_colors_of_magics(test_state* test)
{
    const uint16_t bits[] = {31, 0x8000, 0x8000 | 31, 31 << 10};
    stp_context* context;
    stp_scene* scene = import_facets("solid COLOR=\1\377\1\377,MATERIAL=", bits, 4, &context);
    CHECK(scene != NULL);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK(has_color(mesh, 0, 65535, 0, 0));
    CHECK(has_color(mesh, 1, 20, 65535, 20));
    CHECK(has_color(mesh, 2, 20, 65535, 20));
    CHECK(has_color(mesh, 3, 0, 0, 65535));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Attributes without bit 15 in any facet are no colours.
void test_stl_attributes_without_colors(test_state* test)
{
    const uint16_t bits[] = {0, 7, 31, 0x7fff};
    stp_context* context;
    stp_scene* scene = import_facets("made by a test", bits, 4, &context);
    CHECK(scene != NULL && scene->meshes[0].colors == NULL);
    CHECK_EQUAL(6, scene->meshes[0].vertex_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_stl_colors_survive_failing_memory(test_state* test)
{
    const uint16_t bits[] = {0x8000, 0x8fff};
    unsigned char bytes[84 + 50 * 2];
    size_t size = write_binary(bytes, "made by a test", bits, 2);
    CHECK(survives_failing_allocator("a.stl", bytes, size));
}

void test_stl_texts_keep_distant_coordinates(test_state* test)
{
    static const char text[] = "solid a\nfacet normal 0 0 1\nouter loop\n"
                               "vertex 500000.125 4500000.5 10\nvertex 500000.375 4500000.5 10\n"
                               "vertex 500000.125 4500000.75 10\nendloop\nendfacet\nendsolid a\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.stl", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(stp_scene_finish(scene) == STP_OK);
    stp_boxd box = scene->nodes[scene->root].bounds;
    CHECK(box.min.x == 500000.125 && box.max.x == 500000.375 && box.min.y == 10.0);
    CHECK(box.min.z == -4500000.75 && box.max.z == -4500000.5);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Both kinds of files: such facets are left out, and the scene warns.
void test_stl_facets_that_are_not_finite(test_state* test)
{
    static const char text[] =
        "solid\nfacet\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
        "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    unsigned char bytes[84 + 50 * 2];
    size_t size = write_binary(bytes, "made by a test", (uint16_t[]){0, 0}, 2);
    stp_write_f32(bytes + 84 + 12, INFINITY);
    for (int i = 0; i < 2; ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.stl", i == 0 ? (const void*)text : bytes,
                                        i == 0 ? strlen(text) : size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(1, scene->meshes[0].triangle_count);
        CHECK(stp_scene_finish(scene) == STP_OK && log.warnings == 1);
        CHECK(strstr(log.warning, "1 triangles with corners that are not finite") != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
