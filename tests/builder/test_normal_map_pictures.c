// SPDX-License-Identifier: MIT
// Pictures of built surfaces with normal maps: triangles and splats are lit by them, and disks lie
// as without them.
#include "support_level_scenes.h"
#include "tests.h"

#include "draw/draw.h"
#include "select/select.h"

#include <stdlib.h>
#include <string.h>

enum { CELLS = 120, SIDE = 96, TEXELS = 64, WAVES = 4 };

typedef enum map_kind {
    MAP_NONE,
    MAP_QUADRANTS, ///< tilted up and right, up and left, down and right, down and left
    MAP_WAVES,     ///< waves along u
} map_kind;

static bool add_map(stp_scene* scene, map_kind kind, uint32_t* index)
{
    stp_texture texture = {.width = TEXELS, .height = TEXELS};
    texture.wrap_u = texture.wrap_v = STP_WRAP_CLAMP;
    texture.texels = stp_alloc(scene->context, TEXELS * TEXELS * 4);
    if (texture.texels == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < TEXELS * TEXELS; ++i) {
        bool left = i % TEXELS < TEXELS / 2, above = i / TEXELS < TEXELS / 2;
        const uint8_t tilted[4] = {left ? 176 : 80, above ? 176 : 80, 220, 255};
        double turn = 6.283185307 * WAVES / TEXELS, lean = 0.8 * sin(turn * (i % TEXELS + 0.5));
        const uint8_t wave[4] = {(uint8_t)(127.5 + 127.5 * lean), 128,
                                 (uint8_t)(127.5 + 127.5 * sqrt(1.0 - lean * lean)), 255};
        memcpy(texture.texels + 4 * (size_t)i, kind == MAP_WAVES ? wave : tilted, 4);
    }
    return stp_scene_add_texture(scene, &texture, index) == STP_OK;
}

/// A white sheet with this map.
static bool add_sheet(stp_scene* scene, map_kind map)
{
    stp_material m = stp_material_default();
    uint32_t material = 0;
    m.metallic = 0.0f;
    m.front_only = true;
    return (map == MAP_NONE || add_map(scene, map, &m.normal_texture.texture)) &&
           stp_scene_add_material(scene, &m, &material) == STP_OK &&
           level_scene_add_textured_sheet(scene, CELLS, material);
}

static bool make_plain(stp_scene* scene)
{
    return add_sheet(scene, MAP_NONE);
}

static bool make_mapped(stp_scene* scene)
{
    return add_sheet(scene, MAP_QUADRANTS);
}

static bool make_wavy(stp_scene* scene)
{
    return add_sheet(scene, MAP_WAVES);
}

/// Draws the triangles, or splats of this size. @return covered pixels; 0: it failed
static uint64_t draw_size(stp_context* context, stp_store* store, float splat_size, uint8_t* pixels)
{
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats = {0};
    stp_image image = {SIDE, SIDE, pixels};
    const stp_view view = {
        .eye = {0, 0, 5}, .up = {0, 1, 0}, .fov_degrees = 24, .width = SIDE, .height = SIDE};
    const stp_quality quality = {
        .splat_size = splat_size, .reference = splat_size < 1.0f, .splats_only = true};
    bool drawn = stp_draw_cpu_create(context, store, &renderer) == STP_OK &&
                 stp_renderer_draw_selected(renderer, &view, &quality, &(stp_draw_style){0}, &list,
                                            &image, &stats) == STP_OK;
    stp_draw_list_destroy(context, &list);
    stp_renderer_destroy(renderer);
    return drawn ? stats.covered_pixels : 0;
}

static uint64_t draw(stp_context* context, stp_store* store, uint8_t* pixels)
{
    return draw_size(context, store, 0.0f, pixels);
}

/// Mean green value of a quarter of the picture, away from its border.
static double mean_of(const uint8_t* pixels, int quarter)
{
    double sum = 0.0;
    for (int i = 0; i < 32 * 32; ++i) {
        int x = i % 32 + (quarter % 2 != 0 ? 56 : 8), y = i / 32 + (quarter / 2 != 0 ? 56 : 8);
        sum += pixels[4 * (y * SIDE + x) + 1];
    }
    return sum / (32.0 * 32.0);
}

void test_normal_maps_light_triangles(test_state* test)
{
    static uint8_t plain[4 * SIDE * SIDE], mapped[4 * SIDE * SIDE];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store =
        level_build_open(context, &(level_build){.make = make_plain, .no_levels = true});
    CHECK(store != NULL && draw(context, store, plain) > 0);
    CHECK_EQUAL(0, stp_store_get_directory(store)->texture_count);
    stp_store_close(store);
    store = level_build_open(context, &(level_build){.make = make_mapped, .no_levels = true});
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_material* m = &d->materials[stp_store_describe_mesh(store, 0)->material];
    CHECK(m->normal_scale == 1.0f && m->normal_texture.texture == 0 && d->texture_count == 1);
    CHECK(draw(context, store, mapped) > 0);
    double own = mean_of(plain, 0);
    for (int i = 0; i < 2; ++i) { // light comes from above, more of it from the left
        CHECK(mean_of(mapped, i) > mean_of(mapped, 2 + i) + 30.0);
        CHECK(mean_of(mapped, 2 + i) < own - 20.0);
        CHECK(fabs(mean_of(mapped, 2 * i) - mean_of(mapped, 2 * i + 1)) > 20.0);
    }
    stp_store_close(store);
    stp_context_destroy(context);
}

/// Mean difference of green values, away from the border.
static double find_difference(const uint8_t* a, const uint8_t* b)
{
    double sum = 0.0;
    for (int i = 0; i < 80 * 80; ++i) {
        int at = 4 * ((i / 80 + 8) * SIDE + i % 80 + 8) + 1;
        sum += abs(a[at] - b[at]);
    }
    return sum / (80.0 * 80.0);
}

void test_normal_maps_light_splats(test_state* test)
{
    static uint8_t triangles[4 * SIDE * SIDE], lit[4 * SIDE * SIDE], plain[4 * SIDE * SIDE];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* mapped =
        level_build_open(context, &(level_build){.make = make_wavy, .no_levels = true});
    stp_store* own =
        level_build_open(context, &(level_build){.make = make_plain, .no_levels = true});
    CHECK(mapped != NULL && own != NULL && draw(context, mapped, triangles) > 0);
    for (float size = 2.0f; size <= 4.0f; size += 1.0f) {
        uint64_t covered = draw_size(context, mapped, size, lit);
        CHECK(covered > 0);
        CHECK_EQUAL(draw_size(context, own, size, plain), covered); // no more holes
        double before = find_difference(plain, triangles), now = find_difference(lit, triangles);
        CHECK(before > 15.0 && now < 0.4 * before);
    }
    stp_store_close(mapped);
    stp_store_close(own);
    stp_context_destroy(context);
}

/// Disks lie across their normals: turned ones would leave holes.
void test_normal_maps_do_not_turn_splats(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* stores[2];
    stp_splats sets[2];
    for (int i = 0; i < 2; ++i) {
        stores[i] = level_build_open(
            context, &(level_build){.make = i == 0 ? make_plain : make_mapped, .no_levels = true});
        CHECK(stores[i] != NULL);
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(stores[i], 0, &sets[i]));
    }
    CHECK(sets[0].count > 100);
    CHECK_EQUAL(sets[0].count, sets[1].count);
    CHECK(memcmp(sets[0].positions, sets[1].positions, 6 * (size_t)sets[0].count) == 0);
    CHECK(memcmp(sets[0].normals, sets[1].normals, 2 * (size_t)sets[0].count) == 0);
    CHECK(sets[0].light_octaves == 0 && sets[1].light_octaves != 0);
    stp_store_close(stores[0]);
    stp_store_close(stores[1]);
    stp_context_destroy(context);
}
