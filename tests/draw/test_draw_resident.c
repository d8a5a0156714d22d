// SPDX-License-Identifier: MIT
// Pictures of resident data: coarser while data is missing, never with holes, and finally equal to
// those of the whole file.
#include "support_store.h"
#include "tests.h"

#include "base/math/rng.h"
#include "draw/draw.h"
#include "store/file/block_table.h"
#include "store/support_reader.h"

#include <string.h>

enum { WIDTH = 120, HEIGHT = 90, PIXELS = WIDTH * HEIGHT, ROOT_SIDE = 4, CHILD_SIDE = 5 };

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_store* other; ///< the same, not streaming
    stp_renderer *renderer, *whole;
    stp_draw_list list, whole_list;
    stp_residency* residency;
    slow_reader reader;
    uint8_t pixels[4 * PIXELS], expected[4 * PIXELS];
} fixture;

/// Splits a set of one octave into octaves that end at its prefixes of 4^k.
static void divide(stp_context* context, stp_splats* s)
{
    uint64_t entries = 0;
    const uint8_t color[3] = {s->colors[0], s->colors[1], s->colors[2]};
    for (s->octave_count = 0; entries == 0 || s->octave_ends[s->octave_count - 1] < s->count;) {
        uint32_t end = 1u << (2 * s->octave_count);
        s->octave_ends[s->octave_count++] = end;
        entries += end;
    }
    stp_free(context, s->colors);
    stp_free(context, s->coverages);
    s->colors = STP_NEW_ARRAY(context, uint8_t, 3 * entries);
    s->coverages = STP_NEW_ARRAY(context, uint8_t, entries);
    for (uint64_t i = 0; s->colors != NULL && s->coverages != NULL && i < entries; ++i) {
        memcpy(s->colors + 3 * i, color, 3);
        s->coverages[i] = 255;
    }
}

/// A square with a coarse red set, over four squares that have a finer green one and a white,
/// textured mesh.
static void make_scene(stp_context* context, made_scene* s)
{
    static const uint8_t colors[2][3] = {{200, 20, 20}, {20, 200, 20}};
    static const uint8_t texels[16] = {255, 255, 255, 255, 200, 200, 255, 255,
                                       255, 200, 200, 255, 255, 255, 255, 255};
    *s = (made_scene){.node_count = 2,
                      .edge_count = 4,
                      .part_count = 1,
                      .material_count = 1,
                      .shading_count = 1,
                      .texture_count = 1,
                      .mesh_count = 1,
                      .set_count = 2};
    s->materials[0] = made_material();
    s->materials[0].base_color_texture.texture = 0;
    s->textures[0] = (stp_store_texture){.width = 2, .height = 2, .texels = texels};
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[0] = made_square_set(context, ROOT_SIDE, colors[0]);
    s->sets[1] = made_square_set(context, CHILD_SIDE, colors[1]);
    divide(context, &s->sets[0]);
    divide(context, &s->sets[1]);
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->nodes[0] = (stp_store_node){.part_count = 1, .set = 1, .triangle_count = 2, .bounds = flat};
    for (uint32_t i = 0; i < 4; ++i) {
        stp_affine half = {{{0.5, 0, 0, i % 2 == 0 ? -0.5 : 0.5},
                            {0, 0.5, 0, i / 2 == 0 ? -0.5 : 0.5},
                            {0, 0, 0.5, 0}}};
        s->edges[i] = (stp_store_edge){0, half};
    }
    s->nodes[1] = (stp_store_node){.edge_count = 4, .set = 0, .triangle_count = 8, .bounds = flat};
}

static bool set_up(fixture* f, stp_context* context)
{
    *f = (fixture){.context = context};
    make_scene(context, &f->scene);
    f->store = made_open(context, &f->scene);
    f->other = made_open(context, &f->scene);
    made_free_set(context, &f->scene.sets[0]);
    made_free_set(context, &f->scene.sets[1]);
    return f->store != NULL && f->other != NULL &&
           stp_draw_cpu_create(context, f->store, &f->renderer) == STP_OK &&
           stp_draw_cpu_create(context, f->other, &f->whole) == STP_OK;
}

static stp_result stream(fixture* f, bool open, uint64_t limit)
{
    slow_reader_create(&f->reader, f->store->file.bytes, f->store->file.size, open);
    stp_residency_desc desc = {
        .limit_bytes = limit, .read = slow_reader_read, .read_user = &f->reader};
    return stp_residency_create(f->store, &desc, &f->residency);
}

static void tear_down(fixture* f)
{
    stp_renderer_destroy(f->renderer);
    stp_renderer_destroy(f->whole);
    stp_residency_destroy(f->residency);
    slow_reader_destroy(&f->reader);
    stp_draw_list_destroy(f->context, &f->list);
    stp_draw_list_destroy(f->context, &f->whole_list);
    stp_store_close(f->store);
    stp_store_close(f->other);
}

static stp_view close_in_view(double x, double y, double distance)
{
    return (stp_view){.eye = {x, y, distance},
                      .target = {x, y, 0},
                      .up = {0, 1, 0},
                      .fov_degrees = 50,
                      .width = WIDTH,
                      .height = HEIGHT};
}

static stp_result draw_streamed(fixture* f, const stp_view* view, const stp_quality* quality)
{
    stp_image image = {WIDTH, HEIGHT, f->pixels};
    stp_draw_stats stats;
    stp_draw_style style = {.splat_scale = 1};
    return stp_renderer_draw_selected(f->renderer, view, quality, &style, &f->list, &image, &stats);
}

static stp_result draw_whole(fixture* f, const stp_view* view, const stp_quality* quality)
{
    stp_image image = {WIDTH, HEIGHT, f->expected};
    stp_draw_stats stats;
    stp_draw_style style = {.splat_scale = 1};
    return stp_renderer_draw_selected(f->whole, view, quality, &style, &f->whole_list, &image,
                                      &stats);
}

/// Pixels of the expected picture that the other one does not cover.
static uint32_t count_holes(const fixture* f)
{
    uint32_t holes = 0;
    for (size_t i = 0; i < PIXELS; ++i) {
        holes += f->expected[4 * i + 3] != 0 && f->pixels[4 * i + 3] == 0 ? 1 : 0;
    }
    return holes;
}

static bool is_same(const fixture* f)
{
    return memcmp(f->pixels, f->expected, sizeof(f->pixels)) == 0;
}

void test_resident_first_frame_is_the_coarser_prefix(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context));
    CHECK_EQUAL(STP_OK, stream(&f, true, 24000)); // the coarsest octaves of these are pinned
    residency_settle(f.residency, NULL, 0);
    uint32_t here = stp_store_resident_splats(f.store, 0);
    CHECK(here >= 4 && here < 256);
    CHECK_EQUAL(0, stp_store_resident_splats(f.store, 1));
    f.reader.open = false; // reads block from here on
    const double distances[] = {12.0, 3.0, 1.0, 0.3};
    for (int i = 0; i < 4; ++i) {
        stp_view view = close_in_view(0.05, 0.02, distances[i]);
        stp_quality quality = {.splat_size = 1};
        CHECK_EQUAL(STP_OK, draw_streamed(&f, &view, &quality));
        stp_residency_update(f.residency, f.list.requests, f.list.request_count);
        CHECK_EQUAL(1, f.list.count);
        CHECK(f.list.request_count > 0);
        stp_quality prefix = {.splat_size = 1, .splat_count = here};
        CHECK_EQUAL(STP_OK, draw_whole(&f, &view, &prefix));
        CHECK(is_same(&f));
        stp_quality reference = {.splat_size = 1, .reference = true};
        CHECK_EQUAL(STP_OK, draw_whole(&f, &view, &reference));
        CHECK_EQUAL(0, count_holes(&f));
    }
    slow_reader_let_go(&f.reader, UINT32_MAX);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_resident_pictures_have_no_holes(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context));
    for (uint64_t round = 0; round < 8; ++round) {
        CHECK_EQUAL(STP_OK, stream(&f, true, round % 2 == 0 ? 24000 : 0));
        residency_settle(f.residency, NULL, 0);
        f.reader.open = false;
        stp_policy policy = (stp_policy)(round % 4 == 3 ? STP_POLICY_SWITCH : STP_POLICY_INSERTION);
        for (uint64_t frame = 0; frame < 24; ++frame) {
            uint64_t h =
                stp_rng_hash(round / 2, frame / 8); // rests for a while, then moves elsewhere
            stp_view view =
                close_in_view(0.1 * (double)(h % 13) - 0.6, 0.1 * (double)(h >> 8 & 7) - 0.4,
                              0.1 * (double)(1 << (h >> 16 & 7)));
            stp_quality quality = {.splat_size = (float)(1 + (h >> 24 & 1)), .policy = policy};
            stp_quality reference = {.splat_size = 1, .reference = true};
            CHECK_EQUAL(STP_OK, draw_streamed(&f, &view, &quality));
            CHECK_EQUAL(STP_OK, draw_whole(&f, &view, &reference));
            CHECK_EQUAL(0, count_holes(&f));
            stp_residency_update(f.residency, f.list.requests, f.list.request_count);
            slow_reader_let_go(&f.reader, (uint32_t)(stp_rng_hash(round, 99 + frame) % 3));
        }
        // everything that fits is loaded
        slow_reader_let_go(&f.reader, UINT32_MAX);
        stp_view view = close_in_view(0.1, 0.1, 0.8);
        stp_quality quality = {.splat_size = 1, .policy = policy};
        for (int i = 0; i < 40; ++i) {
            CHECK_EQUAL(STP_OK, draw_streamed(&f, &view, &quality));
            residency_settle(f.residency, f.list.requests, f.list.request_count);
        }
        stp_residency_stats stats;
        stp_residency_get_stats(f.residency, &stats);
        CHECK(stats.peak_bytes <= stats.limit_bytes);
        CHECK_EQUAL(STP_OK, draw_whole(&f, &view, &quality));
        CHECK_EQUAL(0, count_holes(&f));
        CHECK(stats.missing > 0 || is_same(&f));
        CHECK(round % 2 == 0 || stats.missing == 0);
        stp_residency_destroy(f.residency);
        slow_reader_destroy(&f.reader);
        f.residency = NULL;
    }
    slow_reader_create(&f.reader, NULL, 0, true);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_resident_selection_is_pure(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context));
    CHECK_EQUAL(STP_OK, stream(&f, true, 0));
    stp_quality quality = {.splat_size = 1};
    stp_view view = close_in_view(0.2, 0.1, 1.5);
    stp_draw_list lists[2] = {{0}, {0}};
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < 2; ++k) { // regardless of data loaded meanwhile
            CHECK_EQUAL(STP_OK, stp_select(context, f.store, &view, &quality, &lists[k]));
            (void)stp_residency_wait(f.residency);
        }
        CHECK_EQUAL(lists[0].count, lists[1].count);
        CHECK_EQUAL(lists[0].request_count, lists[1].request_count);
        for (size_t w = 0; w < lists[0].request_count; ++w) {
            CHECK_EQUAL(lists[0].requests[w].resource, lists[1].requests[w].resource);
            CHECK_EQUAL(lists[0].requests[w].octaves, lists[1].requests[w].octaves);
            for (size_t v = 0; v < w; ++v) { // each exactly once
                CHECK(lists[0].requests[v].resource != lists[0].requests[w].resource);
            }
        }
        stp_residency_update(f.residency, lists[0].requests, lists[0].request_count);
    }
    CHECK_EQUAL(8, lists[0].triangle_count); // the final picture is that of the whole file
    stp_draw_list_destroy(context, &lists[0]);
    stp_draw_list_destroy(context, &lists[1]);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_resident_damage_stays_coarse(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context));
    CHECK_EQUAL(STP_OK, stream(&f, true, 0));
    const stp_store_texture_record* textures = f.store->tables[STP_SECTION_TEXTURES];
    f.reader.wrong_at = stp_store_block_at(f.store, textures[0].block)->offset;
    stp_quality quality = {.splat_size = 1}, reference = {.splat_size = 1, .reference = true};
    stp_view view = close_in_view(0.1, 0.1, 0.4);
    for (int i = 0; i < 10; ++i) {
        CHECK_EQUAL(STP_OK, draw_streamed(&f, &view, &quality));
        residency_settle(f.residency, f.list.requests, f.list.request_count);
    }
    CHECK_EQUAL(1, log.warnings);
    CHECK_EQUAL(0, log.errors);
    CHECK_EQUAL(0, f.list.triangle_count); // a mesh without its texture is not resident
    CHECK(f.list.splat_count > 1000);
    CHECK_EQUAL(STP_OK, draw_whole(&f, &view, &reference));
    CHECK_EQUAL(0, count_holes(&f));
    tear_down(&f);
    stp_context_destroy(context);
}

void test_resident_textures_come_and_go(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    fixture f;
    CHECK(set_up(&f, context));
    stp_quality quality = {.splat_size = 1};
    stp_view near = close_in_view(0.1, 0.1, 0.4);
    CHECK_EQUAL(STP_OK, draw_whole(&f, &near, &quality));
    CHECK(f.whole_list.triangle_count > 0);
    for (int round = 0; round < 3; ++round) { // mipmaps are freed with the texels
        CHECK_EQUAL(STP_OK, stream(&f, true, 0));
        for (int i = 0; i < 6; ++i) {
            CHECK_EQUAL(STP_OK, draw_streamed(&f, &near, &quality));
            residency_settle(f.residency, f.list.requests, f.list.request_count);
        }
        CHECK(is_same(&f));
        stp_residency_destroy(f.residency);
        slow_reader_destroy(&f.reader);
        f.residency = NULL;
        if (round !=
            1) { // the next residency has different texels, with and without a picture in between
            CHECK_EQUAL(STP_OK, draw_streamed(&f, &near, &quality));
            CHECK(is_same(&f));
        }
    }
    slow_reader_create(&f.reader, NULL, 0, true);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_resident_survives_failing_allocator(test_state* test)
{
    bool complete = false;
    for (int fail_at = 0; !complete && fail_at < 300; ++fail_at) {
        test_heap heap = TEST_HEAP(-1);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        CHECK(context != NULL);
        fixture f;
        CHECK(set_up(&f, context));
        heap.count = 0;
        heap.fail_at = fail_at;
        stp_result result = stream(&f, true, 24000);
        stp_quality quality = {.splat_size = 1};
        stp_view view = close_in_view(0.1, 0.1, 0.7);
        for (int i = 0; i < 4 && result == STP_OK; ++i) {
            result = draw_streamed(&f, &view, &quality);
            if (result == STP_OK) {
                residency_settle(f.residency, f.list.requests, f.list.request_count);
            }
        }
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(result == STP_OK ? 0 : 1, log.errors);
        complete = heap.count <= fail_at;
        heap.fail_at = -1;
        tear_down(&f);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(complete);
}
