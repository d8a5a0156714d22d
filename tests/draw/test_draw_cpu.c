// SPDX-License-Identifier: MIT
#include "support_store.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/math.h"
#include "draw/draw.h"
#include "program/present/picture_file.h"

#include <string.h>
#include <sys/stat.h>

enum { SIDE = 64 };

static const uint8_t red[3] = {255, 0, 0};

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_draw_stats stats;
    stp_view view;
    stp_quality quality;
    stp_draw_style style;
    stp_image image;
    uint8_t pixels[SIDE * SIDE * 4];
} fixture;

// An empty scene, seen from the front in parallel projection: the square from -1 to 1 fills the
// middle half of the picture.
static bool begin(fixture* f, test_heap* heap, uint32_t threads)
{
    *f = (fixture){.context = test_context(heap, threads, NULL)};
    f->scene.material_count = f->scene.shading_count = 1;
    f->scene.materials[0] = made_material();
    f->scene.materials[0].flags = STP_SHADING_UNLIT;
    f->scene.shadings[0] = (stp_shading){.roughness = 1, .flags = STP_SHADING_UNLIT};
    f->view = (stp_view){
        .eye = {0, 0, 5}, .up = {0, 1, 0}, .ortho_height = 4, .width = SIDE, .height = SIDE};
    f->image = (stp_image){SIDE, SIDE, f->pixels};
    f->quality.early_switch =
        1; // there are few triangles per splat: splats are drawn as long as they cover
    return f->context != NULL;
}

static void add_node(fixture* f, stp_store_part_kind kind, uint32_t index, uint32_t splats)
{
    made_scene* s = &f->scene;
    s->parts[s->part_count] = (stp_store_part){kind, index};
    s->nodes[s->node_count++] = (stp_store_node){.first_part = s->part_count++,
                                                 .part_count = 1,
                                                 .set = splats,
                                                 .triangle_count = 2,
                                                 .bounds = {{-1, -1, -1}, {1, 1, 1}}};
}

static void add_square(fixture* f)
{
    f->scene.meshes[f->scene.mesh_count] = made_square(0);
    add_node(f, STP_STORE_PART_MESH, f->scene.mesh_count++, STP_STORE_NONE);
}

// Opens the scene, selects and draws.
static stp_result draw(fixture* f)
{
    stp_result result = STP_OK;
    if (f->store == NULL) {
        f->store = made_open(f->context, &f->scene);
        result = f->store == NULL ? STP_ERROR_OUT_OF_MEMORY
                                  : stp_draw_cpu_create(f->context, f->store, &f->renderer);
    }
    if (result == STP_OK) {
        result = stp_select(f->context, f->store, &f->view, &f->quality, &f->list);
    }
    if (result == STP_OK) {
        result =
            stp_renderer_draw(f->renderer, &f->view, &f->list, &f->style, &f->image, &f->stats);
    }
    return result;
}

static void end(fixture* f)
{
    for (uint32_t i = 0; i < f->scene.set_count; ++i) {
        made_free_set(f->context, &f->scene.sets[i]);
    }
    stp_renderer_destroy(f->renderer);
    stp_draw_list_destroy(f->context, &f->list);
    if (f->store != NULL) {
        stp_store_close(f->store);
    }
    stp_context_destroy(f->context);
}

static const uint8_t* pixel(const fixture* f, int x, int y)
{
    return f->pixels + 4 * (y * SIDE + x);
}

static bool has_color(const uint8_t* p, int r, int g, int b, int a)
{
    return abs(p[0] - r) <= 1 && abs(p[1] - g) <= 1 && abs(p[2] - b) <= 1 && p[3] == a;
}

static stp_store_texture quarters(void)
{
    static const uint8_t texels[] = {255, 0, 0,   255, 0,   255, 0,   255,
                                     0,   0, 255, 255, 255, 255, 255, 255};
    return (stp_store_texture){.width = 2, .height = 2, .nearest = 1, .texels = texels};
}

void test_draw_cpu_textures_are_the_right_way_up(test_state* test)
{
    fixture f;
    CHECK(begin(&f, NULL, 1));
    add_square(&f);
    f.scene.texture_count = 1;
    f.scene.textures[0] = quarters();
    f.scene.materials[0].base_color_texture.texture = 0;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(has_color(pixel(&f, 20, 20), 255, 0, 0, 255)); // first texel: top left
    CHECK(has_color(pixel(&f, 44, 20), 0, 255, 0, 255));
    CHECK(has_color(pixel(&f, 20, 44), 0, 0, 255, 255));
    CHECK(has_color(pixel(&f, 44, 44), 255, 255, 255, 255));
    CHECK(has_color(pixel(&f, 8, 20), 0, 0, 0, 0));
    CHECK_EQUAL(32 * 32, f.stats.covered_pixels);
    f.view.eye.z = -5; // from behind, left and right are swapped; both sides are drawn
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(has_color(pixel(&f, 20, 20), 0, 255, 0, 255));
    CHECK(has_color(pixel(&f, 20, 44), 255, 255, 255, 255));
    end(&f);
}

void test_draw_cpu_splats_fill_the_square(test_state* test)
{
    fixture f;
    CHECK(begin(&f, NULL, 2));
    f.scene.meshes[f.scene.mesh_count++] = made_square(0);
    f.scene.sets[f.scene.set_count++] = made_square_set(f.context, 6, red);
    add_node(&f, STP_STORE_PART_MESH, 0, 0);
    for (int size = 1; size <= 8; size *= 2) {
        f.quality.splat_size = (float)size;
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK_EQUAL(size > 1, f.stats.splats > 0); // the order has too few splats for one per pixel
        int reach = size;
        for (int i = 0; i < SIDE * SIDE && size > 1; ++i) {
            int x = i % SIDE, y = i / SIDE;
            bool inside = x >= 16 && x < 48 && y >= 16 && y < 48;
            bool outside = x < 16 - reach || x >= 48 + reach || y < 16 - reach || y >= 48 + reach;
            CHECK(!inside || has_color(pixel(&f, x, y), 255, 0, 0, 255));
            CHECK(!outside || pixel(&f, x, y)[3] == 0);
        }
    }
    end(&f);
}

// A sheet of splats in z = 0 and a square of triangles at `z`, with the view of begin() or in
// perspective.
static bool begin_paving(fixture* f, bool perspective, double z)
{
    if (!begin(f, NULL, 1)) {
        return false;
    }
    if (perspective) {
        f->view.ortho_height = 0;
        f->view.fov_degrees = 2.0 * 21.8014094863518; // the same picture of the plane z = 0
    }
    made_scene* s = &f->scene;
    s->sets[s->set_count++] = made_square_set(f->context, 5, red);
    add_square(f);
    add_square(f);
    s->nodes[0].set = 0;
    s->nodes[0].bounds = s->nodes[1].bounds = (stp_boxd){{-1, -1, 0}, {1, 1, 0}};
    s->edge_count = 2;
    s->edges[0] = (stp_store_edge){0, stp_affine_identity()};
    s->edges[1] = (stp_store_edge){1, stp_affine_identity()};
    s->edges[1].transform.m[2][3] = z;
    s->nodes[s->node_count++] = (stp_store_node){.edge_count = 2,
                                                 .set = STP_STORE_NONE,
                                                 .triangle_count = 4,
                                                 .bounds = {{-1, -1, -0.03}, {1, 1, 0.5}}};
    f->quality.splat_size = 4;
    return true;
}

// Thin paving drawn as splats covers the ground right below it, drawn as triangles, and does not
// show through objects well in front of it. Depths are those of the triangles themselves.
void test_draw_cpu_paving_covers_the_ground(test_state* test)
{
    for (int variant = 0; variant < 4; ++variant) {
        fixture f;
        bool perspective = variant % 2 == 1, covered = variant >= 2;
        CHECK(begin_paving(&f, perspective, covered ? 0.5 : -0.03)); // a quarter of a splat
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(f.stats.splats > 0 && f.stats.triangles == 2);
        enum { FIRST = 18, MIDDLE = 28 };
        int reds = 0;
        for (int i = 0; i < MIDDLE * MIDDLE; ++i) {
            reds += has_color(pixel(&f, FIRST + i % MIDDLE, FIRST + i / MIDDLE), 255, 0, 0, 255)
                        ? 1
                        : 0;
        }
        CHECK(covered ? reds == 0 : reds > MIDDLE * MIDDLE * 97 / 100);
        size_t at = FIRST * SIDE + FIRST;
        float mixed = stp_renderer_depth(f.renderer)[at];
        f.quality.reference = true;
        CHECK_EQUAL(STP_OK, draw(&f));
        float alone = stp_renderer_depth(f.renderer)[at];
        CHECK(!covered || !perspective || fabsf(mixed / alone - 1.0f) < 1e-6f);
        end(&f);
    }
}

void test_draw_cpu_colors_blend_between_octaves(test_state* test)
{
    fixture f;
    CHECK(begin(&f, NULL, 1));
    stp_splats s = made_square_set(f.context, 5, red);
    stp_free(f.context, s.colors);
    stp_free(f.context, s.coverages);
    s.octave_count = 2; // 256 splats in black, then all 1,024 in white
    s.octave_ends[0] = 256;
    s.octave_ends[1] = 1024;
    s.colors = STP_NEW_ARRAY(f.context, uint8_t, 3 * 1280);
    s.coverages = STP_NEW_ARRAY(f.context, uint8_t, 1280);
    CHECK(s.colors != NULL && s.coverages != NULL);
    memset(s.colors, 0, 3 * 256);
    memset(s.colors + 3 * 256, 255, 3 * 1024);
    memset(s.coverages, 255, 1280);
    f.scene.meshes[f.scene.mesh_count++] = made_square(0);
    f.scene.sets[f.scene.set_count++] = s;
    add_node(&f, STP_STORE_PART_MESH, 0, 0);
    const struct {
        uint32_t splats;
        int expected; // grey level of the earlier splats
    } cases[] = {{200, 0}, {256, 0}, {640, 188}, {1024, 255}};
    for (int i = 0; i < 4; ++i) {
        f.quality.splat_count = cases[i].splats;
        f.style.splat_scale = 0.01f; // single pixels
        CHECK_EQUAL(STP_OK, draw(&f));
        int matching = 0, white = 0;
        for (int k = 0; k < SIDE * SIDE; ++k) {
            const uint8_t* p = f.pixels + 4 * k;
            matching += p[3] == 255 && abs(p[0] - cases[i].expected) <= 1;
            white += p[3] == 255 && p[0] == 255;
        }
        CHECK(matching >= 200);
        CHECK((cases[i].splats > 256) == (white > 0));
    }
    end(&f);
}

void test_draw_cpu_masks_and_blends(test_state* test)
{
    static const uint8_t texels[] = {255, 255, 255, 255, 255, 255, 255, 0};
    fixture f;
    CHECK(begin(&f, NULL, 1));
    add_square(&f);
    f.scene.texture_count = 1;
    f.scene.textures[0] =
        (stp_store_texture){.width = 2, .height = 1, .nearest = 1, .texels = texels};
    f.scene.materials[0].base_color_texture.texture = 0;
    f.scene.materials[0].alpha = STP_STORE_MASK;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK_EQUAL(32 * 16, f.stats.covered_pixels);
    CHECK(pixel(&f, 20, 30)[3] == 255 && pixel(&f, 44, 30)[3] == 0);
    end(&f);

    CHECK(begin(&f, NULL, 1));
    add_square(&f);
    f.scene.materials[0].alpha = STP_STORE_BLEND;
    f.scene.materials[0].base_color[3] = 0.25f;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK_EQUAL(1024, f.stats.covered_pixels); // a layer
    CHECK_EQUAL(64, pixel(&f, 30, 30)[3]);
    f.style.transparency = STP_TRANSPARENCY_PATTERN;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(f.stats.covered_pixels > 248 &&
          f.stats.covered_pixels < 264); // a quarter of 1,024, evenly
    f.style.supersample = 8;
    CHECK_EQUAL(STP_OK, draw(&f));
    int sum = 0;
    for (int i = 0; i < 32 * 32; ++i) {
        sum += pixel(&f, 16 + i % 32, 16 + i / 32)[3];
    }
    CHECK(abs(sum / 1024 - 64) <= 2);
    end(&f);
}

void test_draw_cpu_mirrored_parts_are_lit_alike(test_state* test)
{
    static const int16_t normals[] = {6000, 6000, 6000, 6000,
                                      6000, 6000, 6000, 6000}; // +z, slightly tilted
    uint8_t plain[4] = {0};
    for (int round = 0; round < 4; ++round) {
        fixture f;
        CHECK(begin(&f, NULL, 1));
        f.scene.materials[0].flags = 0;
        add_square(&f);
        f.scene.meshes[0].normals = round >= 2 ? normals : NULL;
        stp_affine turn = stp_affine_identity();
        turn.m[0][0] = round % 2 == 1 ? -1.0 : 1.0;
        f.scene.edges[f.scene.edge_count++] = (stp_store_edge){0, turn};
        f.scene.nodes[1] = (stp_store_node){.first_part = 1,
                                            .edge_count = 1,
                                            .set = STP_STORE_NONE,
                                            .triangle_count = 2,
                                            .bounds = {{-1, -1, -1}, {1, 1, 1}}};
        f.scene.node_count = 2;
        f.style.headlight = true; // looks along z: a mirrored x makes no difference
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK_EQUAL(32 * 32, f.stats.covered_pixels);
        CHECK(pixel(&f, 30, 30)[0] > 100);
        if (round % 2 == 0) {
            memcpy(plain, pixel(&f, 30, 30), 4);
        }
        CHECK_EQUAL(0, memcmp(plain, pixel(&f, 30, 30), 4));
        end(&f);
    }
}

void test_draw_cpu_supersamples_edges(test_state* test)
{
    fixture f;
    CHECK(begin(&f, NULL, 3));
    add_square(&f);
    f.style.supersample = 4;
    f.view.eye.x = f.view.target.x = 1.0 / 64.0; // a quarter of a pixel
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(has_color(pixel(&f, 15, 30), 255, 255, 255, 64));
    CHECK(has_color(pixel(&f, 47, 30), 255, 255, 255, 191));
    CHECK(has_color(pixel(&f, 16, 30), 255, 255, 255, 255));
    CHECK(has_color(pixel(&f, 14, 30), 0, 0, 0, 0));
    f.style.background = true; // averaged in linear light: half of white is 188
    f.style.background_color[0] = 0;
    f.view.eye.x = f.view.target.x = 1.0 / 32.0;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(has_color(pixel(&f, 15, 30), 188, 188, 188, 255));
    CHECK(has_color(pixel(&f, 2, 30), 0, 0, 0, 255));
    end(&f);
}

void test_draw_cpu_depth_and_points(test_state* test)
{
    static const float positions[] = {0, 0, 0, 0.5f, 0.5f, 1, -0.5f, 0.5f, -1};
    static const uint8_t colors[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255};
    fixture f;
    CHECK(begin(&f, NULL, 2));
    f.scene.point_sets[f.scene.point_set_count++] =
        (stp_store_point_set){.point_count = 3,
                              .bounds = {{-1, -1, -1}, {1, 1, 1}},
                              .positions = positions,
                              .colors = colors};
    add_node(&f, STP_STORE_PART_POINTS, 0, STP_STORE_NONE);
    f.view = (stp_view){.eye = {0.01, 0.01, 4},
                        .target = {0.01, 0.01, 0},
                        .up = {0, 1, 0},
                        .fov_degrees = 60,
                        .near_distance = 0.5,
                        .width = SIDE,
                        .height = SIDE};
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK_EQUAL(3, f.stats.covered_pixels);
    const float* depth = stp_renderer_depth(f.renderer);
    int found = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const uint8_t* p = f.pixels + 4 * i;
        float expected = p[3] == 0 ? 0.0f : 0.5f / (p[0] == 255 ? 4.0f : p[1] == 255 ? 3.0f : 5.0f);
        CHECK(fabsf(depth[i] - expected) < 1e-6f);
        found += p[3] == 255 && p[0] + p[1] + p[2] == 255;
    }
    CHECK_EQUAL(3, found);
    end(&f);
}

// A scene with every kind of content: splats below a textured, cut-out square, and points.
static void make_rich(fixture* f)
{
    static const float positions[] = {0, 0, 0.5f, 0.5f, 0.5f, 0.9f, -0.5f, 0.5f, -0.9f};
    static stp_store_texture texture;
    f->scene.materials[0].flags = 0;
    f->scene.materials[0].alpha = STP_STORE_MASK;
    f->scene.texture_count = 1;
    texture = quarters();
    f->scene.textures[0] = texture;
    f->scene.materials[0].base_color_texture.texture = 0;
    f->scene.point_sets[f->scene.point_set_count++] = (stp_store_point_set){
        .point_count = 3, .bounds = {{-1, -1, -1}, {1, 1, 1}}, .positions = positions};
    f->scene.sets[f->scene.set_count++] = made_square_set(f->context, 6, red);
    f->scene.meshes[f->scene.mesh_count] = made_square(0);
    add_node(f, STP_STORE_PART_MESH, f->scene.mesh_count++, STP_STORE_NONE);
    add_node(f, STP_STORE_PART_POINTS, 0, STP_STORE_NONE);
    f->scene.nodes[2] = f->scene.nodes[0]; // a leaf without splats, one with, and the root of all
    f->scene.parts[f->scene.part_count] = f->scene.parts[0];
    f->scene.nodes[2].first_part = f->scene.part_count++;
    f->scene.nodes[2].set = 0;
    for (uint32_t i = 0; i < 3; ++i) {
        f->scene.edges[i] = (stp_store_edge){i, stp_affine_identity()};
        f->scene.edges[i].transform.m[0][3] = 0.3 * i;
        f->scene.edges[i].transform.m[2][3] = -0.4 * i;
    }
    f->scene.edge_count = 3;
    f->scene.nodes[3] = (stp_store_node){.first_part = f->scene.part_count,
                                         .edge_count = 3,
                                         .set = STP_STORE_NONE,
                                         .triangle_count = 4,
                                         .bounds = {{-1, -1, -2}, {2, 1, 1}}};
    f->scene.node_count = 4;
    f->view = (stp_view){
        .eye = {1, 1.5, 4}, .up = {0, 1, 0}, .fov_degrees = 50, .width = SIDE, .height = SIDE};
    f->quality.splat_size = 4;
}

void test_draw_cpu_is_the_same_for_any_number_of_threads(test_state* test)
{
    static uint8_t first[SIDE * SIDE * 4];
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        fixture f;
        CHECK(begin(&f, NULL, threads));
        make_rich(&f);
        f.style.supersample = 2;
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(f.stats.splats > 100 && f.stats.triangles == 2 && f.stats.covered_pixels > 500);
        if (threads == 1) {
            memcpy(first, f.pixels, sizeof(first));
        }
        CHECK_EQUAL(0, memcmp(first, f.pixels, sizeof(first)));
        end(&f);
    }
}

// Each worker has a buffer of the size of the picture, plus a megabyte.
void test_draw_cpu_memory_is_bounded_by_processors_not_threads(test_state* test)
{
    static uint8_t first[SIDE * SIDE * 4];
    uint32_t processors = stp_processor_count();
    for (uint32_t threads = 1; threads < 200 + processors; threads += 199 + processors) {
        fixture f;
        CHECK(begin(&f, NULL, threads));
        make_rich(&f);
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(stp_context_peak_bytes(f.context) < (uint64_t)(processors + 8) << 21);
        if (threads == 1) {
            memcpy(first, f.pixels, sizeof(first));
        }
        CHECK_EQUAL(0, memcmp(first, f.pixels, sizeof(first)));
        end(&f);
    }
}

void test_draw_cpu_warm_frames_do_not_allocate(test_state* test)
{
    fixture f;
    test_heap heap = TEST_HEAP(-1);
    CHECK(begin(&f, &heap, 3));
    make_rich(&f);
    f.style.supersample = 2;
    CHECK_EQUAL(STP_OK, draw(&f));
    static uint8_t first[SIDE * SIDE * 4];
    memcpy(first, f.pixels, sizeof(first));
    int before = heap.count;
    for (int frame = 0; frame < 20; ++frame) {
        f.style.supersample = frame % 2 == 0 ? 1 : 2;
        CHECK_EQUAL(STP_OK, draw(&f));
    }
    CHECK_EQUAL(before, heap.count);
    CHECK_EQUAL(0, memcmp(first, f.pixels, sizeof(first)));
    end(&f);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_draw_cpu_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        fixture f;
        CHECK(begin(&f, &heap, 2));
        make_rich(&f);
        f.store = made_open(f.context, &f.scene);
        CHECK(f.store != NULL);
        heap.fail_at = heap.count + n;
        stp_result result = stp_draw_cpu_create(f.context, f.store, &f.renderer);
        result = result == STP_OK ? draw(&f) : result;
        heap.fail_at = -1;
        if (f.renderer != NULL && result != STP_OK) { // after a failure the next frame is correct
            CHECK_EQUAL(STP_OK, draw(&f));
            CHECK(f.stats.covered_pixels > 300);
        }
        end(&f);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            CHECK(n >= 8);
            break;
        }
    }
}
