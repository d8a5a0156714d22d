// SPDX-License-Identifier: MIT
// Large triangles that extend behind the eye: OpenGL and CPU draw the same, at the same depth.
#include "support_gl.h"
#include "tests.h"

#include "base/math/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 200, PIXELS = WIDTH * HEIGHT, VIEWS = 16 };

/// A floor, and a much larger dark ground slightly below it.
static void add_floor(made_picture* p)
{
    static const double sides[] = {60.0, 3000.0}, heights[] = {-5.0, -5.1};
    for (uint32_t i = 0; i < 2; ++i) {
        made_picture_add(p, -1.5707963267948966, (stp_vec3d){37.0 * i, heights[i], 411.0 * i},
                         NULL);
        for (int k = 0; k < 9; ++k) {
            p->scene.edges[i].transform.m[k / 3][k % 3] *= sides[i];
        }
    }
    p->scene.material_count = 2;
    p->scene.materials[1] = p->scene.materials[0];
    p->scene.materials[1].base_color[0] = 0.1f;
    p->scene.meshes[1].material = 1;
}

/// From above the middle of the floor, looking slightly down.
static void set_view(stp_view* view, uint64_t number)
{
    double u[3];
    for (uint64_t k = 0; k < 3; ++k) {
        u[k] = (double)(stp_rng_hash(number, k) >> 11) * 0x1p-53;
    }
    double away = 6.28 * u[0], far = 10.0 + 15.0 * u[1];
    view->eye = (stp_vec3d){far * sin(away), 0.0, far * cos(away)};
    view->target = (stp_vec3d){view->eye.x - sin(away), -0.1 - 0.4 * u[2], view->eye.z - cos(away)};
    view->fov_degrees = 70.0;
    view->width = WIDTH;
    view->height = HEIGHT;
}

static stp_result draw(made_picture* p, stp_renderer* renderer, uint8_t* pixels, float* depth)
{
    stp_image image = {WIDTH, HEIGHT, pixels};
    stp_result result =
        stp_renderer_draw(renderer, &p->view, &p->list, &p->style, &image, &p->stats);
    if (result == STP_OK) {
        memcpy(depth, stp_renderer_depth(renderer), PIXELS * sizeof(*depth));
    }
    return result;
}

static void compare(test_state* test, made_gl* m, uint8_t* const pixels[2], float* const depths[2])
{
    made_picture* p = &m->picture;
    CHECK_EQUAL(STP_OK, stp_select(p->context, p->store, &p->view, &p->quality, &p->list));
    CHECK_EQUAL(STP_OK, draw(p, p->renderer, pixels[0], depths[0]));
    CHECK_EQUAL(STP_OK, draw(p, m->renderer, pixels[1], depths[1]));
    int different = 0, apart = 0, floor = 0;
    for (size_t i = 0; i < PIXELS; ++i) {
        different += abs(pixels[0][4 * i] - pixels[1][4 * i]) > 6 ? 1 : 0;
        if (pixels[0][4 * i] > 250 && pixels[1][4 * i] > 250) {
            floor += 1; // the ground's depth is 2 in 100 more
            apart += fabsf(depths[0][i] - depths[1][i]) > 1e-3f * depths[0][i] ? 1 : 0;
        }
    }
    CHECK(floor > PIXELS / 4);
    CHECK(different <= 8); // along the floor's far edges
    CHECK_EQUAL(0, apart);
}

void test_gl_draws_floors_that_reach_behind_the_eye(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin_with(&m, add_floor, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    uint8_t* bytes = malloc((size_t)2 * 4 * PIXELS);
    float* numbers = malloc((size_t)2 * PIXELS * sizeof(*numbers));
    if (bytes != NULL && numbers != NULL) {
        uint8_t* const pixels[2] = {bytes, bytes + (size_t)4 * PIXELS};
        float* const depths[2] = {numbers, numbers + PIXELS};
        for (uint64_t i = 0; i < VIEWS; ++i) {
            set_view(&m.picture.view, i);
            compare(test, &m, pixels, depths);
        }
    }
    free(bytes);
    free(numbers);
    made_gl_end(&m);
}
