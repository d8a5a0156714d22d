// SPDX-License-Identifier: MIT
// Holes and hashed alpha depend on the drawn item, not on its index in the list.
#include "support_picture.h"
#include "tests.h"

#include "base/splats/coverage.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE, BYTES = SIDE * SIDE * 4 };

static const uint8_t grey[3] = {200, 200, 200};

// Two squares side by side, half transparent.
static void make_pair(made_picture* p, const uint8_t* color, uint8_t coverage)
{
    made_picture_add(p, 0.0, (stp_vec3d){-1.2, 0, 0}, color);
    made_picture_add(p, 0.0, (stp_vec3d){1.2, 0, 0}, color);
    p->scene.materials[0].alpha = STP_STORE_BLEND;
    p->scene.materials[0].base_color[3] = 0.5f;
    for (uint32_t k = 0; color != NULL && k < 2; ++k) {
        memset(p->scene.sets[k].coverages, coverage, p->scene.sets[k].count);
    }
    p->quality.splat_size = 4;
}

// The list without its first item and with different ids.
static void drop_first(stp_draw_list* list)
{
    list->count -= 1;
    memmove(list->items, list->items + 1, list->count * sizeof(list->items[0]));
    for (size_t i = 0; i < list->count; ++i) {
        list->items[i].first_id = (uint32_t)(100000 * i);
    }
}

void test_dither_does_not_depend_on_what_else_is_drawn(test_state* test)
{
    for (int variant = 0; variant < 2; ++variant) {
        static uint8_t both[BYTES];
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 1));
        make_pair(&p, variant == 1 ? grey : NULL, stp_coverage_of_share(0.5));
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK((variant == 1) == (p.stats.splats > 0));
        memcpy(both, p.pixels, BYTES);
        uint64_t covered = p.stats.covered_pixels;
        drop_first(&p.list);
        CHECK_EQUAL(STP_OK,
                    stp_renderer_draw(p.renderer, &p.view, &p.list, &p.style, &p.image, &p.stats));
        uint64_t rest = p.stats.covered_pixels;
        CHECK(rest > 300 && rest < covered - 300);
        int same = 0, there = 0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            bool shown = p.pixels[4 * i + 3] != 0;
            there += shown ? 1 : 0;
            same += shown && both[4 * i + 3] != 0 ? 1 : 0;
        }
        CHECK_EQUAL(there, same);
        made_picture_end(&p);
    }
}

// Two copies of a mesh have different holes: through two panes of half coverage, a quarter is
// visible.
void test_dither_of_instances_differs(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 1));
    p.view.fov_degrees = 0;
    p.view.ortho_height = 4;
    p.style.transparency = STP_TRANSPARENCY_PATTERN;
    p.scene.materials[0].alpha = STP_STORE_BLEND;
    p.scene.materials[0].base_color[3] = 0.5f;
    made_picture_add(&p, 0.0, (stp_vec3d){0, 0, 0}, NULL);
    p.scene.edges[1] = p.scene.edges[0];
    p.scene.edges[1].transform.m[2][3] = -0.5;
    p.scene.edge_count = 2;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(p.stats.covered_pixels > 720 && p.stats.covered_pixels < 816); // three quarters of 1,024
    made_picture_end(&p);
}

// Each sample of a pixel is decided separately, so coverage becomes a mean.
void test_dither_of_samples_differs(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 1));
    make_pair(&p, grey, stp_coverage_of_share(0.27));
    p.style.supersample = 4;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    int levels[256] = {0}, inner = 0;
    for (int y = 24; y < 40; ++y) {
        for (int x = 4; x < 24; ++x) {
            int alpha = made_picture_pixel(&p, x, y)[3];
            inner += 1;
            levels[alpha] += 1;
        }
    }
    CHECK(levels[0] + levels[255] < inner / 6);
    made_picture_end(&p);
}

// In two passes with occluders, or in one.
void test_dither_is_the_same_in_two_passes(test_state* test)
{
    static uint8_t once[BYTES];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_pair(&p, grey, 128);
    made_picture_add(&p, 0.0, (stp_vec3d){0, 0, -4}, grey);
    made_picture_add(&p, 0.0, (stp_vec3d){0, 0.2, 2}, NULL);
    p.scene.material_count = 2;
    p.scene.materials[1] = made_material();
    p.scene.meshes[3].material = 1;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, stp_select(p.context, p.store, &p.view, &p.quality, &p.list));
    CHECK_EQUAL(STP_OK,
                stp_renderer_draw(p.renderer, &p.view, &p.list, &p.style, &p.image, &p.stats));
    memcpy(once, p.pixels, BYTES);
    uint64_t all = p.stats.fragments;
    int hidden = 0;
    for (int i = 0; i < 6; ++i) { // two views in turn: the pyramid is of the other one
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, memcmp(once, p.pixels, BYTES));
        hidden += p.stats.fragments < all ? 1 : 0;
        made_picture other = p;
        static uint8_t pixels[BYTES];
        other.image.pixels = pixels;
        other.view.eye.x += i % 2 == 0 ? 2.0 : -2.0;
        CHECK_EQUAL(STP_OK, made_picture_draw(&other));
        p.list = other.list;
    }
    CHECK(hidden > 0);
    made_picture_end(&p);
}
