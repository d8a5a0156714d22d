// SPDX-License-Identifier: MIT
//
// Golden pictures of typical inputs: a CAD model, foliage, and a cloud, at splat sizes 1, 4 and 16,
// plus a section with caps.
#include "support_golden.h"
#include "tests.h"

#include "base/math/rng.h"
#include "builder/build_scene.h"
#include "lab/scenes/scenes.h"
#include "select/camera.h"
#include "select/sections.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, CLOUD_POINTS = 6000 };

static const uint32_t sizes[] = {1, 4, 16};

static const stp_draw_style daylight = {.background = true, .background_color = {219, 224, 230}};

/// A built scene and a view of it.
typedef struct subject {
    stp_context* context;
    stp_store* store;
    stp_view view;
} subject;

/// Builds an input, with splats for the largest nodes, and opens the file. @return false on failure
static bool set_up(const char* input, subject* s)
{
    *s = (subject){.context = test_context(NULL, 2, NULL)};
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = "a.stip",
                           .threshold = 1,
                           .generate = scene_make_input};
    return s->context != NULL && stp_build(s->context, &desc, NULL) == STP_OK &&
           stp_store_open(s->context, desc.output, &s->store) == STP_OK;
}

static void tear_down(subject* s)
{
    stp_store_close(s->store);
    stp_context_destroy(s->context);
}

/// Takes a view of the file, by name. @return false if the file has no such view
static bool find_view(subject* s, const char* name)
{
    const stp_store_directory* d = stp_store_get_directory(s->store);
    stp_view* view = &s->view;
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

/// Draws the view at all sizes. @return what is wrong, or NULL
static const char* draw_sizes(const subject* s, const char* name)
{
    const char* wrong = NULL;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]) && wrong == NULL; ++i) {
        char picture[64];
        snprintf(picture, sizeof(picture), "%s_%u", name, sizes[i]);
        wrong = golden_draw(s->context, s->store, picture, s->view,
                            (stp_quality){.splat_size = (float)sizes[i]}, daylight);
    }
    return wrong;
}

void test_golden_pictures_of_cad(test_state* test)
{
    subject s;
    CHECK(set_up("scene:power-plant,scale=0.002", &s) && find_view(&s, "overview"));
    CHECK(draw_sizes(&s, "cad") == NULL);
    // a section through it, with caps
    stp_draw_style caps = daylight;
    caps.caps = true;
    CHECK(stp_sections_add_plane(&s.view.sections, s.view.target, (stp_vec3d){0.2, 0.0, 1.0}));
    CHECK(golden_draw(s.context, s.store, "cad_section", s.view, (stp_quality){.splat_size = 2},
                      caps) == NULL);
    CHECK(find_view(&s, "turbine hall"));
    CHECK(golden_draw(s.context, s.store, "cad_inside", s.view, (stp_quality){.splat_size = 1},
                      daylight) == NULL);
    tear_down(&s);
}

void test_golden_pictures_of_foliage(test_state* test)
{
    subject s;
    CHECK(set_up("scene:forest,scale=0.003", &s) && find_view(&s, "walk"));
    CHECK(draw_sizes(&s, "foliage") == NULL);
    tear_down(&s);
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

void test_golden_pictures_of_clouds(test_state* test)
{
    subject s;
    CHECK(write_cloud("cloud.xyz") && set_up("cloud.xyz", &s));
    const stp_boxd box = {{-1, 0, -1}, {1, 0.6, 1}};
    s.view = (stp_view){.width = WIDTH, .height = HEIGHT, .fov_degrees = 40};
    CHECK(stp_camera_frame("iso", &box, &s.view));
    CHECK(draw_sizes(&s, "cloud") == NULL);
    tear_down(&s);
}
