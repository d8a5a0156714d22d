// SPDX-License-Identifier: MIT
// Normals for meshes that come without.
#include "formats_test.h"

#include "import/reading/smooth.h"

#include <math.h>

enum { SIDES = 24, TRIANGLES = 4 * SIDES };

/// A closed cylinder of radius 1 around y as an ASCII STL file.
static size_t write_cylinder(char* out, size_t size)
{
    size_t length = (size_t)snprintf(out, size, "solid cylinder\n");
    for (int i = 0; i < SIDES; ++i) {
        double a = 2 * 3.14159265358979 * i / SIDES, b = 2 * 3.14159265358979 * (i + 1) / SIDES;
        const double top[2][3] = {{cos(a), 1, sin(a)}, {cos(b), 1, sin(b)}};
        const double bottom[2][3] = {{cos(a), -1, sin(a)}, {cos(b), -1, sin(b)}};
        static const double middle[2][3] = {{0, 1, 0}, {0, -1, 0}};
        const double* facets[4][3] = {{top[0], bottom[1], bottom[0]},
                                      {top[0], top[1], bottom[1]},
                                      {middle[0], top[1], top[0]},
                                      {middle[1], bottom[0], bottom[1]}};
        for (int f = 0; f < 4; ++f) {
            length +=
                (size_t)snprintf(out + length, size - length, "facet normal 0 0 0\nouter loop\n");
            for (int k = 0; k < 3; ++k) { // STL files have z up
                const double* p = facets[f][k];
                length += (size_t)snprintf(out + length, size - length, "vertex %.6f %.6f %.6f\n",
                                           p[0], -p[2], p[1]);
            }
            length += (size_t)snprintf(out + length, size - length, "endloop\nendfacet\n");
        }
    }
    return length + (size_t)snprintf(out + length, size - length, "endsolid cylinder\n");
}

static stp_scene* import_smooth(stp_context* context, double degrees, stp_result* result)
{
    static char text[64 * 1024];
    size_t size = write_cylinder(text, sizeof(text));
    stp_import_desc desc = {.smooth_degrees = degrees};
    stp_scene* scene = NULL;
    *result = stp_scene_create(context, &scene);
    if (*result == STP_OK) {
        *result = stp_import_memory(scene, "a.stl", text, size, &desc);
    }
    if (*result != STP_OK && scene != NULL) {
        stp_scene_destroy(scene);
        scene = NULL;
    }
    return scene;
}

static bool is_near(const float* a, double x, double y, double z)
{
    return fabs((double)a[0] - x) < 1e-3 && fabs((double)a[1] - y) < 1e-3 &&
           fabs((double)a[2] - z) < 1e-3;
}

/// Whether a corner has the normal of the smooth cylinder; z is up in the file.
static bool is_round(const stp_mesh* mesh, uint32_t triangle, uint32_t vertex)
{
    const float* p = mesh->positions + 3 * (size_t)vertex;
    const float* n = mesh->normals + 3 * (size_t)vertex;
    if (triangle % 4 >= 2) { // a cap
        return is_near(n, 0, 0, (double)p[2]);
    }
    return is_near(n, (double)p[0], (double)p[1], 0);
}

void test_smooth_normals_follow_the_surface(test_state* test)
{
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_result result;
        stp_scene* scene = import_smooth(context, 30.0, &result);
        CHECK(scene != NULL && scene->mesh_count == 1);
        const stp_mesh* mesh = &scene->meshes[0];
        CHECK_EQUAL(TRIANGLES, mesh->triangle_count);
        CHECK_EQUAL(4 * SIDES + 2, mesh->vertex_count); // two at each edge of the caps, two middles
        CHECK(mesh->normals != NULL);
        uint32_t wrong = 0;
        for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
            wrong += is_round(mesh, i / 3, mesh->indices[i]) ? 0 : 1;
        }
        CHECK_EQUAL(0, wrong);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_smooth_normals_keep_edges(test_state* test)
{
    static const struct {
        double degrees;
        uint32_t vertices;
    } cases[] = {
        {0.0, 2 * SIDES + 2},   // none: flat
        {5.0, 6 * SIDES + 2},   // sides turn by 15 degrees: four for each, and the caps
        {16.0, 4 * SIDES + 2},  // smooth around, sharp at the caps
        {180.0, 2 * SIDES + 2}, // smooth everywhere
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_smooth(context, cases[i].degrees, &result);
        CHECK(scene != NULL && scene->mesh_count == 1);
        CHECK_EQUAL(cases[i].vertices, scene->meshes[0].vertex_count);
        CHECK((scene->meshes[0].normals != NULL) == (cases[i].degrees > 0.0));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// All columns of a repeated vertex are repeated; normals of the file stay.
void test_smooth_normals_repeat_columns(test_state* test)
{
    static const char* const text = // two faces at a right angle, with texture coordinates
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "f 1/1 2/2 3/3\nf 1/1 4/2 2/2\n";
    static const char* const with_normals =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n";
    stp_context* context = test_context(NULL, 1, NULL);
    const stp_import_desc desc = {.smooth_degrees = 45.0};
    stp_scene* scene = NULL;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK, stp_import_memory(scene, "a.obj", text, strlen(text), &desc));
    CHECK_EQUAL(STP_OK,
                stp_import_memory(scene, "b.obj", with_normals, strlen(with_normals), &desc));
    CHECK_EQUAL(2, scene->mesh_count);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(6, mesh->vertex_count);
    CHECK(mesh->colors != NULL && mesh->texcoords[0] != NULL && mesh->normals != NULL);
    for (uint32_t i = 0; i < 6; ++i) { // colours tell the places
        const uint16_t* c = mesh->colors + 4 * (size_t)mesh->indices[i];
        const float* p = mesh->positions + 3 * (size_t)mesh->indices[i];
        CHECK((p[0] > 0.5f) == (c[1] > 0 && c[0] == 0) && (p[1] > 0.5f) == (c[2] > 0 && c[0] == 0));
        CHECK(
            is_near(mesh->normals + 3 * (size_t)mesh->indices[i], 0, i < 3 ? 0 : 1, i < 3 ? 1 : 0));
    }
    CHECK(is_near(scene->meshes[1].normals, 1, 0, 0));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_smooth_normals_survive_failing_allocator(test_state* test)
{
    bool made = false;
    for (int n = 1; !made && n < 1000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_result result = STP_ERROR_OUT_OF_MEMORY;
        stp_scene* scene = context != NULL ? import_smooth(context, 30.0, &result) : NULL;
        made = result == STP_OK && heap.count <= n;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK(context == NULL || log.errors == (result == STP_OK ? 0 : 1));
        if (scene != NULL) {
            stp_scene_destroy(scene);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
