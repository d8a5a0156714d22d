// SPDX-License-Identifier: MIT
// Splats of textured materials have the roughness, metal and emission of their texels.
#include "support_level_scenes.h"
#include "tests.h"

#include "builder/shadings.h"
#include "capture/capture_internal.h"
#include "draw/draw.h"
#include "scene/bulk.h"
#include "scene/looks.h"
#include "select/select.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 120, SIDE = 96 };

// Two by two texels: roughness is green, metal is blue.
static const uint8_t surface_texels[16] = {0, 40,  0,   255, 0, 200, 255, 255,
                                           0, 128, 128, 255, 0, 255, 0,   255};
static const uint8_t glow_texels[16] = {0, 0, 0, 255, 255, 0, 0, 255, 0, 0, 128, 255, 0, 0, 0, 255};

static bool add_texture(stp_scene* scene, const uint8_t* texels, uint32_t* index)
{
    stp_texture texture = {.width = 2, .height = 2, .nearest = true};
    texture.wrap_u = texture.wrap_v = STP_WRAP_CLAMP;
    texture.texels = stp_alloc(scene->context, 16);
    if (texture.texels == NULL) {
        return false;
    }
    memcpy(texture.texels, texels, 16);
    return stp_scene_add_texture(scene, &texture, index) == STP_OK;
}

static bool make_sheet(stp_scene* scene)
{
    stp_material m = stp_material_default();
    uint32_t material = 0;
    m.emissive[0] = m.emissive[1] = m.emissive[2] = 0.5f;
    m.base_color[1] = m.base_color[2] = 0.3f;
    return add_texture(scene, surface_texels, &m.metallic_roughness_texture.texture) &&
           add_texture(scene, glow_texels, &m.emissive_texture.texture) &&
           stp_scene_add_material(scene, &m, &material) == STP_OK &&
           level_scene_add_textured_sheet(scene, CELLS, material);
}

static float linear_of(uint8_t value)
{
    double x = value / 255.0;
    return (float)(x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4));
}

/// The quadrant of the texture at a place; -1: near its border, or the sheet's.
static int texel_at(double x, double y)
{
    bool clear = fabs(x) > 0.1 && fabs(y) > 0.1;
    return !clear ? -1 : (x > 0.0 ? 1 : 0) + (y < 0.0 ? 2 : 0);
}

static bool has_texel(const stp_shading* s, int texel)
{
    const uint8_t *surface = surface_texels + 4 * texel, *glow = glow_texels + 4 * texel;
    float worst = fmaxf(fabsf(s->roughness - (float)surface[1] / 255.0f),
                        fabsf(s->metallic - (float)surface[2] / 255.0f));
    for (int c = 0; c < 3; ++c) {
        worst = fmaxf(worst, fabsf(s->emissive[c] - 0.5f * linear_of(glow[c])));
    }
    return worst < 1e-3f;
}

void test_splats_have_the_surface_of_their_texel(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    const level_build build = {.make = make_sheet, .no_levels = true};
    stp_store* store = level_build_open(context, &build);
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t checked = 0;
    CHECK(d->set_count > 0);
    for (uint32_t i = 0; i < d->set_count; ++i) {
        stp_splats set;
        CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &set));
        for (uint32_t k = 0; k < set.count; ++k) {
            stp_vec3d at = stp_splat_place(&set, k);
            int texel = texel_at(at.x, at.y);
            if (texel >= 0) {
                CHECK(set.materials[k] < d->shading_count);
                CHECK(has_texel(&d->shadings[set.materials[k]], texel));
                checked += 1;
            }
        }
    }
    CHECK(checked > 1000);
    stp_store_close(store);
    stp_context_destroy(context);
}

/// Draws and returns the picture's pixels.
static bool draw(stp_context* context, stp_store* store, bool reference, uint8_t* pixels)
{
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_image image = {SIDE, SIDE, pixels};
    const stp_view view = {
        .eye = {0, 0, 5}, .up = {0, 1, 0}, .fov_degrees = 24, .width = SIDE, .height = SIDE};
    const stp_quality quality = {
        .splat_size = 1, .reference = reference, .splats_only = !reference};
    bool drawn = stp_draw_cpu_create(context, store, &renderer) == STP_OK &&
                 stp_renderer_draw_selected(renderer, &view, &quality, &(stp_draw_style){0}, &list,
                                            &image, &stats) == STP_OK &&
                 stats.covered_pixels > SIDE * SIDE / 2 && (reference || stats.triangles == 0);
    stp_draw_list_destroy(context, &list);
    stp_renderer_destroy(renderer);
    return drawn;
}

void test_splats_of_textured_surfaces_look_like_triangles(test_state* test)
{
    static uint8_t pixels[2][4 * SIDE * SIDE];
    stp_context* context = test_context(NULL, 2, NULL);
    const level_build build = {.make = make_sheet, .no_levels = true};
    stp_store* store = level_build_open(context, &build);
    CHECK(store != NULL && draw(context, store, true, pixels[0]) &&
          draw(context, store, false, pixels[1]));
    int different = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        int worst = 0;
        for (int c = 0; c < 3; ++c) {
            int off = abs(pixels[0][4 * i + c] - pixels[1][4 * i + c]);
            worst = off > worst ? off : worst;
        }
        different += worst > 6 ? 1 : 0;
    }
    CHECK(different < SIDE * SIDE / 12); // along the borders of texels
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_looks_are_few(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    stp_material m = stp_material_default();
    m.emissive[0] = m.emissive[1] = m.emissive[2] = 1.0f;
    for (int kind = 0; kind < 2; ++kind) { // every value of two channels
        stp_texture texture = {.width = 256, .height = 256};
        texture.texels = stp_alloc(context, 256 * 256 * 4);
        CHECK(texture.texels != NULL);
        for (uint32_t i = 0; i < 256 * 256; ++i) {
            const uint8_t texel[4] = {(uint8_t)(i * 7), (uint8_t)i, (uint8_t)(i >> 8), 255};
            memcpy(texture.texels + 4 * (size_t)i, texel, 4);
        }
        texture.texels[0] = (uint8_t)kind; // two different textures
        uint32_t* use =
            kind == 0 ? &m.metallic_roughness_texture.texture : &m.emissive_texture.texture;
        CHECK_EQUAL(STP_OK, stp_scene_add_texture(scene, &texture, use));
    }
    uint32_t material = 0;
    CHECK_EQUAL(STP_OK, stp_scene_add_material(scene, &m, &material));
    CHECK(level_scene_add_textured_sheet(scene, CELLS, material));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_OK, stp_scene_find_looks(scene));
    CHECK(scene->look_count == 1 && scene->variant_count > 8 &&
          scene->variant_count <= STP_LOOK_VARIANTS);
    for (uint32_t i = 0; i < scene->variant_count; ++i) {
        stp_variant v = stp_scene_get_variant(scene, i);
        CHECK(v.roughness >= 0.0f && v.roughness <= 1.0f && v.metallic >= 0.0f &&
              v.metallic <= 1.0f && v.emissive[0] >= 0.0f && v.emissive[0] <= 1.0f);
    }
    const stp_look_bins* surfaces = stp_look_surface(scene, scene->looks);
    for (int i = 0; i <= 10; ++i) { // bins hold what is put into them, within half a step
        float metal = (float)i / 10.0f, roughness = 1.0f - metal;
        uint32_t bin = stp_look_surface_bin(surfaces, metal, roughness);
        CHECK(fabsf(surfaces->values[bin][0] - metal) < 0.26f);
        CHECK(fabsf(surfaces->values[bin][1] - roughness) < 0.11f);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

/// A scene of `count` materials that share one texture for surfaces and glows, with a mesh each.
static stp_scene* make_shared(stp_context* context, uint32_t count)
{
    stp_scene* scene = NULL;
    stp_material m = stp_material_default();
    m.emissive[0] = m.emissive[1] = m.emissive[2] = 1.0f;
    bool made = stp_scene_create(context, &scene) == STP_OK &&
                add_texture(scene, surface_texels, &m.emissive_texture.texture);
    m.metallic_roughness_texture = m.emissive_texture;
    for (uint32_t i = 0; i < count && made; ++i) {
        stp_mesh mesh = {.vertex_count = 3, .triangle_count = 1};
        mesh.positions = stp_alloc_array(context, 9, sizeof(float));
        mesh.indices = stp_alloc_array(context, 3, sizeof(uint32_t));
        for (uint32_t k = 0; k < 3; ++k) {
            mesh.indices[k] = k;
            memcpy(mesh.positions + 3 * (size_t)k,
                   (float[3]){(float)(k == 1) + (float)i, (float)(k == 2), 0.0f}, 12);
        }
        m.roughness = 1.0f - (float)i / (float)count;
        made = stp_scene_add_material(scene, &m, &mesh.material) == STP_OK &&
               stp_scene_add_mesh(scene, &mesh, NULL) == STP_OK;
    }
    if (made) {
        return scene;
    }
    stp_scene_destroy(scene);
    return NULL;
}

void test_looks_share_the_bins_of_textures(test_state* test)
{
    enum { COUNT = 40 };
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_shared(context, COUNT);
    CHECK(scene != NULL && stp_scene_find_looks(scene) == STP_OK);
    CHECK_EQUAL(COUNT, scene->look_count);
    for (uint32_t i = 0; i < COUNT; ++i) {
        const stp_look* look = &scene->looks[i];
        CHECK(look->surface == scene->looks[0].surface && look->glow == scene->looks[0].glow);
        CHECK_EQUAL(i * stp_look_variants(scene, look), look->first_variant);
        for (uint32_t k = 0; k < stp_look_variants(scene, look); ++k) {
            CHECK_EQUAL(look->material,
                        stp_scene_get_variant(scene, look->first_variant + k).material);
        }
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static int stop(const stp_progress_report* report, void* user)
{
    (void)report;
    (void)user;
    return 1;
}

void test_looks_can_be_cancelled(test_state* test)
{
    stp_context* context = NULL;
    const stp_context_desc desc = {.thread_count = 1, .progress = stop};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    stp_scene* scene = make_shared(context, 2);
    CHECK(scene != NULL);
    CHECK_EQUAL(STP_ERROR_CANCELLED, stp_scene_find_looks(scene));
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

/// Stops once some texels were read.
static int stop_within(const stp_progress_report* report, void* user)
{
    *(uint64_t*)user = report->total;
    return report->done > 0 && report->done < report->total;
}

/// A large texture is read in runs, between which the build can be cancelled.
void test_looks_of_a_large_texture_can_be_cancelled(test_state* test)
{
    enum { WIDE = 4096, HIGH = 300 };
    stp_context* context = NULL;
    uint64_t texels = 0;
    const stp_context_desc desc = {
        .thread_count = 1, .progress = stop_within, .progress_user = &texels};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    stp_scene* scene = make_shared(context, 1);
    CHECK(scene != NULL);
    uint32_t large = scene->materials[scene->meshes[0].material].metallic_roughness_texture.texture;
    stp_texture* texture = &scene->textures[large];
    scene->bulk_bytes -= stp_texture_bytes(texture);
    stp_free(context, texture->texels);
    texture->texels = stp_alloc_array(context, WIDE, 4 * HIGH);
    CHECK(texture->texels != NULL);
    memset(texture->texels, 0, (size_t)WIDE * 4 * HIGH);
    texture->width = WIDE;
    texture->height = HIGH;
    scene->bulk_bytes += stp_texture_bytes(texture);
    CHECK_EQUAL(STP_ERROR_CANCELLED, stp_scene_find_looks(scene));
    CHECK(texels >= (uint64_t)WIDE * HIGH);
    stp_shading_set set;
    CHECK_EQUAL(STP_ERROR_CANCELLED, stp_make_shadings(scene, false, &set));
    CHECK(set.of_material == NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static bool add_point(stp_scene* scene, uint32_t material)
{
    stp_point_set set = {.point_count = 1, .material = material};
    set.positions = stp_alloc_array(scene->context, 3, sizeof(float));
    memset(set.positions, 0, 3 * sizeof(float));
    return stp_scene_add_point_set(scene, &set, NULL) == STP_OK;
}

void test_variants_leave_room_for_growths(test_state* test)
{
    const uint32_t counts[] = {4, 40, 200, 250}; // of textured materials
    for (int i = 0; i < 4; ++i) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = make_shared(context, counts[i]);
        stp_shading_set set;
        CHECK(scene != NULL && add_point(scene, 0) && stp_scene_find_looks(scene) == STP_OK);
        CHECK((scene->variant_count > 256) == (i > 0));
        CHECK_EQUAL(STP_OK, stp_make_shadings(scene, true, &set));
        CHECK_EQUAL(i < 3, set.has_growths); // 13 and 250 do not fit
        uint8_t own = set.of_material[scene->looks[0].material];
        bool alike = true;
        for (uint32_t k = 0; k < stp_look_variants(scene, &scene->looks[0]); ++k) {
            alike = alike && set.of_material[stp_look_index(scene, scene->looks, 0, k)] == own;
        }
        CHECK(i == 3 || alike == (i > 0));
        stp_free(context, set.of_material);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_textures_of_colors_only_are_those_of_base_colors(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = make_shared(context, 2);
    CHECK(scene != NULL && stp_scene_find_looks(scene) == STP_OK);
    for (int i = 0; i < 4; ++i) {
        stp_capture_textures* textures = NULL;
        scene->materials[2].base_color_texture.texture = i < 2 ? STP_NONE : 0;
        CHECK_EQUAL(STP_OK, stp_capture_textures_create(scene, i % 2 == 1, &textures));
        CHECK_EQUAL(i != 1, textures->pyramids[0].level_count != 0); // emission or base colour
        CHECK_EQUAL(i % 2 == 0, textures->surfaces[0].level_count != 0);
        stp_capture_textures_destroy(textures);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
