// SPDX-License-Identifier: MIT
//
// Golden pictures of typical inputs: a CAD model, foliage, and a cloud, at splat sizes 1, 4 and 16,
// plus a section with caps.
#include "tests.h"

#include "base/rng.h"
#include "build/build_scene.h"
#include "draw/support_golden.h"
#include "lod/method.h"
#include "present/camera.h"
#include "scenes/scenes.h"
#include "select/sections.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, CLOUD_POINTS = 6000 };

static const uint32_t sizes[] = {1, 4, 16};

static const stp_draw_style daylight = {.background = true, .background_color = {219, 224, 230}};

/// Builds an input, with splats for the largest nodes, and opens the file; NULL on failure.
static stp_store* build_and_open(stp_context* context, const char* input, const char* method)
{
    stp_store* store = NULL;
    const stp_method* methods[1] = {NULL};
    for (int i = 0; method != NULL && i < STP_METHOD_COUNT; ++i) {
        methods[0] = strcmp(stp_methods[i].name, method) == 0 ? &stp_methods[i] : methods[0];
    }
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = "a.stip",
                           .methods = methods,
                           .method_count = methods[0] != NULL ? 1 : 0,
                           .threshold = 1,
                           .generate = scene_make_input};
    return stp_build(context, &desc, NULL) == STP_OK &&
                   stp_store_open(context, desc.output, &store) == STP_OK
               ? store
               : NULL;
}

/// A view of a file, by name. @return false if the file has no such view
static bool find_view(const stp_store* store, const char* name, stp_view* view)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    *view = (stp_view){.width = WIDTH, .height = HEIGHT};
    for (uint32_t i = 0; i < d->view_count; ++i) {
        const stp_store_view* v = &d->views[i];
        if (strcmp(v->name, name) == 0) {
            view->eye = v->eye;
            view->target = v->target;
            view->up = v->up;
            view->fov_degrees = v->fov_degrees;
            return true;
        }
    }
    return false;
}

/// Draws a view at all sizes. @return what is wrong, or NULL
static const char* draw_sizes(stp_context* context, stp_store* store, const char* name,
                              const stp_view* view)
{
    const char* wrong = NULL;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]) && wrong == NULL; ++i) {
        char picture[64];
        snprintf(picture, sizeof(picture), "%s_%u", name, sizes[i]);
        wrong = golden_draw(context, store, picture, *view,
                            (stp_quality){.splat_size = (float)sizes[i]}, daylight);
    }
    return wrong;
}

void test_pictures_of_cad_look_as_they_did(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_store* store = build_and_open(context, "scene:power-plant,scale=0.002", NULL);
    stp_view view;
    CHECK(store != NULL && find_view(store, "overview", &view));
    CHECK(draw_sizes(context, store, "cad", &view) == NULL);
    // a section through it, with caps
    stp_draw_style caps = daylight;
    caps.caps = true;
    CHECK(stp_sections_add_plane(&view.sections, view.target, (stp_vec3d){0.2, 0.0, 1.0}));
    CHECK(golden_draw(context, store, "cad_section", view, (stp_quality){.splat_size = 2}, caps) ==
          NULL);
    CHECK(find_view(store, "turbine hall", &view));
    CHECK(golden_draw(context, store, "cad_inside", view, (stp_quality){.splat_size = 1},
                      daylight) == NULL);
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_pictures_of_foliage_look_as_they_did(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_store* store = build_and_open(context, "scene:forest,scale=0.003", NULL);
    stp_view view;
    CHECK(store != NULL && find_view(store, "walk", &view));
    CHECK(draw_sizes(context, store, "foliage", &view) == NULL);
    stp_store_close(store);
    stp_context_destroy(context);
}

/// A dome on a plain: coloured points without normals, as text.
static bool write_cloud(const char* path)
{
    FILE* file = fopen(path, "w");
    for (uint32_t i = 0; file != NULL && i < CLOUD_POINTS; ++i) {
        uint64_t bits = stp_rng_hash(3, i);
        double x = (double)(bits & 0xFFFFF) / 524288.0 - 1.0;
        double z = (double)(bits >> 20 & 0xFFFFF) / 524288.0 - 1.0;
        double rest = 0.36 - x * x - z * z, y = rest > 0.0 ? sqrt(rest) : 0.0;
        unsigned red = rest > 0.0 ? 210 : 90, green = 80 + (unsigned)(140.0 * y);
        fprintf(file, "%.6f %.6f %.6f %u %u 70\n", x, y, z, red, green);
    }
    return file != NULL && fclose(file) == 0;
}

void test_pictures_of_clouds_look_as_they_did(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && write_cloud("cloud.xyz"));
    stp_store* store = build_and_open(context, "cloud.xyz", NULL);
    stp_view view = {.width = WIDTH, .height = HEIGHT, .fov_degrees = 40};
    const stp_boxd box = {{-1, 0, -1}, {1, 0.6, 1}};
    CHECK(store != NULL && stp_camera_frame("iso", &box, &view));
    CHECK(draw_sizes(context, store, "cloud", &view) == NULL);
    stp_store_close(store);
    stp_context_destroy(context);
}
