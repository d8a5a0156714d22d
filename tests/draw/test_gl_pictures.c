// SPDX-License-Identifier: MIT
// OpenGL pictures equal CPU pictures, for all content and styles.
#include "support_gl.h"
#include "tests.h"

#include "base/math/rng.h"
#include "draw/gl/gl_renderer.h"
#include "image/image_codecs.h"
#include "store/support_mesh.h"

#include <stdlib.h>
#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE, POINTS = 2000, MAX_CALLS = 8 };

/// Draws both, and compares.
static void compare(test_state* test, made_gl* m)
{
    CHECK_EQUAL(STP_OK, made_picture_draw(&m->picture));
    uint64_t covered = m->picture.stats.covered_pixels, splats = m->picture.stats.listed_splats;
    CHECK(covered > 300);
    CHECK_EQUAL(STP_OK, made_gl_draw(m));
    uint64_t more = m->picture.stats.covered_pixels;
    CHECK_EQUAL(splats, m->picture.stats.listed_splats);
    CHECK(m->picture.stats.splats <= splats && (splats == 0) == (m->picture.stats.splats == 0));
    CHECK(more + 4 >= covered && covered + 4 >= more);
    CHECK(m->picture.stats.draw_calls >= 1 && m->picture.stats.draw_calls <= MAX_CALLS);
    int different = made_count_different(m->pixels, m->picture.pixels, 6);
    CHECK(different <= PIXELS / 100);
}

void test_gl_pictures_match_the_cpu_in_every_style(test_state* test)
{
    static const stp_draw_style styles[] = {
        {.supersample = 1},
        {.headlight = true, .background = true, .background_color = {30, 90, 200}},
        {.supersample = 2, .background = true, .background_color = {9, 9, 9}},
        {.splat_scale = 0.5f},
        {.eye_dome = 1.0f},
        {.ambient_occlusion = 0.5f},
        {.supersample = 2, .eye_dome = 1.0f, .background = true},
        {.pixel_filter = true},
        {.pixel_filter = true, .eye_dome = 1.0f, .background = true},
        {.pixel_filter = true, .supersample = 2},
    };
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    m.picture.quality.splat_size = 3;
    for (size_t i = 0; i < sizeof(styles) / sizeof(styles[0]); ++i) {
        m.picture.style = styles[i];
        compare(test, &m);
    }
    made_gl_end(&m);
}

void test_gl_pictures_have_two_eyes(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    m.picture.view.eye_distance = 0.4;
    m.picture.quality.splat_size = 2;
    compare(test, &m);
    m.picture.style.supersample = 2;
    compare(test, &m);
    int different = 0; // the eyes see different pictures
    for (int y = 0; y < PICTURE_SIDE; ++y) {
        const uint8_t* row = m.pixels + (size_t)4 * PICTURE_SIDE * (size_t)y;
        different += memcmp(row, row + 2 * PICTURE_SIDE, 2 * PICTURE_SIDE) != 0 ? 1 : 0;
    }
    CHECK(different > PICTURE_SIDE / 4);
    made_gl_end(&m);
}

void test_gl_pictures_accumulate(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, m.pixels};
    made_picture* p = &m.picture;
    p->style.supersample = 2;
    for (uint32_t i = 1; i <= 6; ++i) {
        CHECK_EQUAL(STP_OK, made_picture_accumulate(p));
        uint64_t covered = p->stats.covered_pixels;
        CHECK_EQUAL(STP_OK, stp_renderer_accumulate(m.renderer, &p->view, &p->quality, &p->style,
                                                    &p->list, &image, &p->stats));
        CHECK_EQUAL(i < 4 ? i : 4, p->stats.samples);
        CHECK(covered > 100 && p->stats.covered_pixels + PIXELS / 100 >= covered);
        CHECK(p->stats.covered_pixels <= covered + PIXELS / 100);
        CHECK(made_count_different(m.pixels, p->pixels, 6) <= PIXELS / 100);
    }
    p->style.supersample = 1; // a frame that is not part of the mean
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    p->style.supersample = 2;
    do {
        CHECK_EQUAL(STP_OK, stp_renderer_accumulate(m.renderer, &p->view, &p->quality, &p->style,
                                                    &p->list, &image, &p->stats));
    } while (p->stats.samples < 4);
    CHECK(made_count_different(m.pixels, p->pixels, 6) <= PIXELS / 100);
    p->view.eye.x += 0.1; // it no longer rests
    CHECK_EQUAL(STP_OK, stp_renderer_accumulate(m.renderer, &p->view, &p->quality, &p->style,
                                                &p->list, &image, &p->stats));
    CHECK_EQUAL(1, p->stats.samples);
    made_gl_end(&m);
}

/// Pictures of one list by both backends.
static void compare_list(test_state* test, made_gl* m)
{
    made_picture* p = &m->picture;
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, m->pixels};
    CHECK_EQUAL(STP_OK, stp_renderer_draw(p->renderer, &p->view, &p->list, &p->style, &p->image,
                                          &p->stats));
    uint64_t covered = p->stats.covered_pixels;
    CHECK_EQUAL(STP_OK,
                stp_renderer_draw(m->renderer, &p->view, &p->list, &p->style, &image, &p->stats));
    CHECK(covered > 100 && p->stats.covered_pixels + 4 >= covered);
    CHECK(made_count_different(m->pixels, p->pixels, 6) <= PIXELS / 100);
}

void test_gl_pictures_have_sections_and_ghosts(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    made_picture* p = &m.picture;
    p->view.sections.count = 2;
    p->view.sections.planes[0] = (stp_section_plane){{1, 0.4, 0}, 0.5};
    p->view.sections.planes[1] = (stp_section_plane){{0, 0, 1}, 0.3};
    for (int parallel = 0; parallel < 2; ++parallel) {
        p->view.ortho_height = parallel != 0 ? 4.0 : 0.0;
        p->quality.splat_size = 3;
        CHECK_EQUAL(STP_OK, stp_select(p->context, p->store, &p->view, &p->quality, &p->list));
        compare_list(test, &m);
        for (size_t i = 0; i < p->list.count; ++i) {
            p->list.items[i].ghost = i % 2 == 0;
        }
        compare_list(test, &m);
    }
    made_gl_end(&m);
}

static uint8_t texels[3][4 * 16 * 16];

/// Squares with every kind of triangle material.
static void add_materials(made_picture* p)
{
    static const int16_t normals[] = {0, 0, 9000, 0, 0, 12000, -9000, 4000};
    static const uint16_t colors[] = {65535, 0,     0,     65535, 0,     65535, 0,     20000,
                                      0,     20000, 65535, 50000, 40000, 40000, 65535, 65535};
    made_scene* s = &p->scene;
    for (size_t i = 0; i < 16 * 16; ++i) {
        for (size_t t = 0; t < 3; ++t) {
            uint64_t bits = stp_rng_hash(t, i);
            memcpy(texels[t] + 4 * i, &bits, 4);
        }
        texels[0][4 * i + 3] = (i % 16 + i / 16) % 8 < 4 ? 255 : 0;
    }
    s->texture_count = 3;
    for (uint32_t t = 0; t < 3; ++t) {
        s->textures[t] = (stp_store_texture){
            .width = 16, .height = 16, .wrap_u = t, .wrap_v = 2 - t, .texels = texels[t]};
    }
    s->textures[2].nearest = 1;
    s->material_count = 6;
    for (uint32_t i = 0; i < 6; ++i) {
        s->materials[i] = made_material();
        s->materials[i].base_color_texture.texture = i > 0 ? (i - 1) % 3 : STP_STORE_NONE;
        s->materials[i].base_color_texture.transform[0][0] = 1.7f;
        s->materials[i].metallic = 0.5f;
    }
    s->materials[1].alpha = STP_STORE_MASK;
    s->materials[2].alpha = STP_STORE_BLEND;
    s->materials[3].metallic_roughness_texture.texture = 1;
    s->materials[4].emissive_texture.texture = 2;
    s->materials[4].emissive[0] = s->materials[4].emissive[1] = 0.4f;
    s->materials[4].normal_scale = 0.7f; // with normals of corners, and without
    s->materials[4].normal_texture.texture = 0;
    s->materials[4].normal_texture.transform[0][0] =
        s->materials[4].normal_texture.transform[1][1] = 1.0f;
    s->materials[5].normal_scale = -1.0f;
    s->materials[5].normal_texture.texture = 1;
    s->materials[5].normal_texture.transform[0][1] = 1.0f; // mirrored
    s->materials[5].normal_texture.transform[1][0] = 1.5f;
    static const stp_vec3d places[] = {{-1, 1, 0},    {1, 1, 0.5}, {0, 0, -1},
                                       {-1, -1, 0.4}, {1, -1, 0},  {0, 2, 0.2}};
    for (uint32_t i = 0; i < 6; ++i) {
        made_picture_add(p, 0.3 * (double)i - 0.5, places[i], NULL);
        s->meshes[i].material = i;
        s->meshes[i].normals = i % 2 == 0 ? normals : NULL;
        s->meshes[i].colors = i > 1 ? colors : NULL;
    }
}

void test_gl_pictures_have_materials(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, add_materials, NULL, NULL)) {
        return;
    }
    compare(test, &m);
    CHECK(m.picture.stats.draw_calls >= 2);     // one more with per-fragment tests
    m.picture.view.eye = (stp_vec3d){2, 1, 12}; // from far away: smaller mip levels
    m.picture.style.supersample = 2;
    compare(test, &m);
    made_gl_end(&m);
}

static unsigned char* png;

/// A square with a texture of one colour, whose file is a hundredth of its texels.
static void add_flat_texture(made_picture* p)
{
    enum { SIDE = 1024 };
    made_scene* s = &p->scene;
    uint8_t* pixels = malloc((size_t)4 * SIDE * SIDE);
    stp_image image = {SIDE, SIDE, pixels};
    size_t size = 0;
    if (pixels != NULL) {
        memset(pixels, 200, (size_t)4 * SIDE * SIDE);
    }
    if (pixels != NULL &&
        stp_image_encode_png(p->context, &image, STP_IMAGE_SMALL, &png, &size) == STP_OK) {
        s->textures[s->texture_count++] = (stp_store_texture){.width = SIDE,
                                                              .height = SIDE,
                                                              .encoding = STP_IMAGE_PNG,
                                                              .encoded = png,
                                                              .encoded_size = size};
        s->materials[0] = made_material();
        s->materials[0].base_color_texture.texture = 0;
        s->material_count = 1;
        made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, NULL);
    }
    free(pixels);
}

/// With a second page, shaders are compiled again and take longer.
void test_gl_textures_from_small_files_fit_one_page(test_state* test)
{
    made_gl m;
    png = NULL;
    if (!made_gl_begin_or_skip(test, &m, add_flat_texture, NULL, NULL)) {
        return;
    }
    CHECK(m.picture.scene.texture_count == 1);
    compare(test, &m);
    const stp_gl_pool* pool = &((stp_gl_renderer*)m.renderer)->pool;
    CHECK(pool->spans.total * 4 >= 5 << 20);
    CHECK_EQUAL(1, pool->page_count);
    stp_free(m.picture.context, png);
    made_gl_end(&m);
}

/// Opaque triangles, triangles with per-fragment tests, and splats.
static void add_all_kinds(made_picture* p)
{
    static const uint8_t color[3] = {200, 90, 20};
    add_materials(p);
    made_picture_add(p, 0.4, (stp_vec3d){0, 1.2, 0.3}, color);
    made_picture_add(p, -0.4, (stp_vec3d){0.2, -1.2, -0.3}, color);
}

void test_gl_pictures_of_all_kinds_for_two_eyes_take_no_more_calls(test_state* test)
{
    static const stp_filter filters[] = {STP_FILTER_NONE, STP_FILTER_EWA, STP_FILTER_BLEND};
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, add_all_kinds, NULL, NULL)) {
        return;
    }
    m.picture.view.eye_distance = 0.3;
    m.picture.quality.splat_size = 3;
    m.picture.style.transparency = STP_TRANSPARENCY_PATTERN;
    for (int i = 0; i < 3; ++i) {
        m.picture.style.filter = filters[i];
        if (filters[i] != STP_FILTER_BLEND) { // the CPU does not draw these
            compare(test, &m);
        }
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(m.picture.stats.splats > 50 && m.picture.stats.triangles >= 10);
        CHECK_EQUAL(MAX_CALLS, m.picture.stats.draw_calls);
    }
    made_gl_end(&m);
}

static made_mesh wave;
static stp_coded_mesh coded;

/// A sheet of clusters with all vertex attributes.
static void add_clusters(made_picture* p)
{
    made_scene* s = &p->scene;
    if (!made_mesh_create(MADE_WAVE, 30, MADE_NORMALS | MADE_COLORS | MADE_TEXCOORDS, &wave)) {
        return;
    }
    stp_store_mesh mesh = made_mesh_view(&wave);
    stp_box box = stp_box_empty();
    for (uint32_t i = 0; i < wave.vertex_count; ++i) {
        const float* at = wave.positions + 3 * (size_t)i;
        stp_box_add(&box, (stp_vec3){at[0], at[1], at[2]});
    }
    add_materials(p);
    s->node_count = s->edge_count = s->part_count = s->mesh_count = 0;
    if (stp_clusters_encode(p->context, &mesh, 1.0 / 1024, &coded) != STP_OK) {
        return;
    }
    mesh.bounds = coded.bounds;
    mesh.material = 3;
    made_picture_add(p, 0.2, (stp_vec3d){0, 0, 0}, NULL);
    s->meshes[0] = mesh;
    s->nodes[0].triangle_count = mesh.triangle_count;
    s->nodes[0].bounds =
        (stp_boxd){stp_to_double(coded.bounds.min), stp_to_double(coded.bounds.max)};
    s->coded_meshes = &coded;
    stp_vec3 middle = {0.5f * (box.min.x + box.max.x), 0.5f * (box.min.y + box.max.y),
                       0.5f * (box.min.z + box.max.z)};
    double size = (double)(box.max.x - box.min.x); // it lies flat
    p->view.target = (stp_vec3d){(double)middle.x, (double)middle.y, (double)middle.z};
    p->view.eye =
        (stp_vec3d){(double)middle.x, (double)middle.y - 0.4 * size, (double)middle.z + 1.2 * size};
}

void test_gl_pictures_have_clusters(test_state* test)
{
    made_gl m;
    wave = (made_mesh){0};
    coded = (stp_coded_mesh){0};
    if (made_gl_begin_or_skip(test, &m, add_clusters, NULL, NULL)) {
        compare(test, &m);
        m.picture.view.fov_degrees = 12; // some clusters are outside
        compare(test, &m);
        stp_coded_mesh_destroy(m.picture.context, &coded);
        made_gl_end(&m);
    }
    made_mesh_destroy(&wave);
}

/// Two sets of points: with colours and normals, and with neither.
static void add_points(made_picture* p)
{
    static float positions[3 * POINTS];
    static int16_t normals[2 * POINTS];
    static uint8_t colors[4 * POINTS];
    made_scene* s = &p->scene;
    for (uint32_t i = 0; i < 3 * POINTS; ++i) {
        positions[i] = (float)(stp_rng_hash(1, i) >> 40) / 8388608.0f - 1.0f;
    }
    for (uint32_t i = 0; i < 4 * POINTS; ++i) {
        colors[i] = (uint8_t)(i % 4 == 3 ? 255 : stp_rng_hash(2, i / 64));
    }
    for (uint32_t i = 0; i < 2 * POINTS; ++i) {
        normals[i] = (int16_t)(stp_rng_hash(3, i) >> 48);
    }
    s->materials[0].flags = 0;
    for (uint32_t i = 0; i < 2; ++i) {
        s->point_sets[i] = (stp_store_point_set){.point_count = POINTS,
                                                 .bounds = {{-1, -1, -1}, {1, 1, 1}},
                                                 .positions = positions,
                                                 .normals = i == 0 ? normals : NULL,
                                                 .colors = i == 0 ? colors : NULL};
        s->parts[i] = (stp_store_part){STP_STORE_PART_POINTS, i};
        s->nodes[i] = (stp_store_node){.first_part = i,
                                       .part_count = 1,
                                       .set = STP_STORE_NONE,
                                       .point_count = POINTS,
                                       .bounds = {{-1, -1, -1}, {1, 1, 1}}};
        s->edges[i] = (stp_store_edge){i, stp_affine_identity()};
        s->edges[i].transform.m[0][3] = i == 0 ? -0.8 : 0.8;
    }
    s->point_set_count = s->part_count = s->node_count = s->edge_count = 2;
}

void test_gl_pictures_have_points(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, add_points, NULL, NULL)) {
        return;
    }
    compare(test, &m);
    m.picture.view.ortho_height = 4;
    compare(test, &m);
    made_gl_end(&m);
}

void test_gl_pictures_have_ghosts_of_points(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, add_points, NULL, NULL)) {
        return;
    }
    made_picture* p = &m.picture;
    CHECK_EQUAL(STP_OK, stp_select(p->context, p->store, &p->view, &p->quality, &p->list));
    for (size_t i = 0; i < p->list.count; ++i) {
        p->list.items[i].ghost = true;
    }
    compare_list(test, &m);
    made_gl_end(&m);
}

void test_gl_pictures_stay_where_they_are_drawn(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    made_picture* p = &m.picture;
    stp_gl_renderer* r = (stp_gl_renderer*)m.renderer;
    static uint8_t kept[4 * PIXELS];
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    p->style.background = true;
    for (int i = 0; i < 10; ++i) { // without waiting
        CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(m.renderer, &p->view, &p->quality, &p->style,
                                                       &p->list, NULL, &p->stats));
    }
    CHECK(p->stats.draw_ms > 0 && p->stats.shade_ms > 0);
    CHECK_EQUAL(0, p->stats.covered_pixels); // not known before it is done
    uint64_t splats = p->stats.splats;
    stp_draw_gl_finish_stats(m.renderer, &p->stats);
    CHECK(p->stats.draw_ms > 0 && p->stats.shade_ms > 0);
    CHECK(p->stats.covered_pixels > 100);
    CHECK_EQUAL(splats, p->stats.splats);
    CHECK_EQUAL(0, r->timer.count); // no queries are pending
    uint64_t covered = p->stats.covered_pixels;
    stp_gl_read_texture(&r->gl, stp_draw_gl_texture(m.renderer), GL_RGBA, GL_UNSIGNED_BYTE,
                        PICTURE_SIDE, PICTURE_SIDE, sizeof(kept), kept);
    CHECK(made_count_different(kept, m.pixels, 6) > 100);
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(covered, p->stats.covered_pixels);
    CHECK_EQUAL(0, made_count_different(kept, m.pixels, 0));
    // large pictures are read in bands
    const uint64_t row = UINT64_C(4) * PICTURE_SIDE, bands[] = {1, row, 5 * row + 3, 63 * row};
    for (size_t i = 0; i < sizeof(bands) / sizeof(bands[0]); ++i) {
        memset(kept, 1, sizeof(kept));
        stp_gl_read_texture(&r->gl, stp_draw_gl_texture(m.renderer), GL_RGBA, GL_UNSIGNED_BYTE,
                            PICTURE_SIDE, PICTURE_SIDE, bands[i], kept);
        CHECK_EQUAL(0, made_count_different(kept, m.pixels, 0));
    }
    made_gl_end(&m);
}

void test_gl_depth_matches_the_cpu(test_state* test)
{
    made_gl m;
    if (!made_gl_begin_or_skip(test, &m, NULL, NULL, NULL)) {
        return;
    }
    for (int eyes = 1; eyes <= 2; ++eyes) {
        m.picture.view.eye_distance = eyes > 1 ? 0.3 : 0.0;
        compare(test, &m);
        const float* cpu = stp_renderer_depth(m.picture.renderer);
        const float* gl = stp_renderer_depth(m.renderer);
        int different = 0;
        CHECK(cpu != NULL && gl != NULL && stp_renderer_depth(m.renderer) == gl);
        for (int i = 0; i < PIXELS; ++i) {
            float step = cpu[i] - gl[i];
            different += step > 1e-4f * cpu[i] || -step > 1e-4f * cpu[i] ? 1 : 0;
        }
        CHECK(different <= PIXELS / 200);
    }
    made_gl_end(&m);
}
