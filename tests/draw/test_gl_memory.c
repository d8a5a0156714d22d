// SPDX-License-Identifier: MIT
// GPU memory and uploads: limits hold, pictures are complete as soon as possible, and nothing
// leaks.
#include "support_gl.h"
#include "tests.h"

#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE, OCTAVES = 3 };

/// Gives a set octaves, each with colours of its own.
static void add_octaves(stp_context* context, stp_splats* s)
{
    static const uint32_t ends[OCTAVES] = {64, 256, 1024};
    size_t total = 0, at = 0;
    for (int k = 0; k < OCTAVES; ++k) {
        total += ends[k];
        s->octave_ends[k] = ends[k];
    }
    s->octave_count = OCTAVES;
    uint8_t color[3] = {s->colors[0], s->colors[1], s->colors[2]};
    stp_free(context, s->colors);
    stp_free(context, s->coverages);
    s->colors = STP_NEW_ARRAY(context, uint8_t, 3 * total);
    s->coverages = STP_NEW_ARRAY(context, uint8_t, total);
    for (int k = 0; k < OCTAVES && s->colors != NULL && s->coverages != NULL; ++k) {
        for (uint32_t i = 0; i < ends[k]; ++i, ++at) {
            for (int c = 0; c < 3; ++c) {
                s->colors[3 * at + (size_t)c] = (uint8_t)(color[c] - 20 * k);
            }
            s->coverages[at] = 255;
        }
    }
}

/// Sheets beside each other, each with splats in octaves.
static void add_sheets(made_picture* p)
{
    for (int i = 0; i < 6; ++i) {
        const uint8_t color[3] = {(uint8_t)(100 + 20 * i), 240, 130};
        made_picture_add(p, 0.4 * i, (stp_vec3d){3 * (i % 3) - 3, 3 * (i / 3) - 1.5, -0.3 * i},
                         color);
        add_octaves(p->context, &p->scene.sets[i]);
    }
}

static bool begin(test_state* test, made_gl* m, const stp_draw_gl_desc* settings, test_heap* heap)
{
    bool begun = made_gl_begin_or_skip(test, m, add_sheets, settings, heap);
    m->picture.quality.splat_size = 1;
    m->picture.view.eye.z = 15;
    return begun;
}

void test_gl_uploads_keep_to_their_budget(test_state* test)
{
    // the finest octave alone exceeds the budget, but is uploaded anyway
    enum { BUDGET = 2048, LARGEST = 768 * 9, URGENT = 6 * (64 * 4 + 64 * 9) };
    const stp_draw_gl_desc settings = {.upload_bytes = BUDGET};
    static uint8_t whole[4 * PIXELS], first[4 * PIXELS];
    made_gl m;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(m.picture.list.splat_count > 1000);
    CHECK_EQUAL(0, stp_draw_gl_get_stats(m.renderer).missing);
    memcpy(whole, m.pixels, sizeof(whole));
    uint64_t covered = m.picture.stats.covered_pixels;
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &settings));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    memcpy(first, m.pixels, sizeof(first));
    stp_draw_gl_stats stats = stp_draw_gl_get_stats(m.renderer);
    CHECK(stats.missing > 0);
    CHECK(stats.uploaded_bytes <= LARGEST + URGENT);
    // the picture is coarser, without holes
    CHECK(m.picture.stats.covered_pixels >= covered);
    int frames = 0;
    for (; stats.missing > 0 && frames < 100; ++frames) {
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        stats = stp_draw_gl_get_stats(m.renderer);
        CHECK(stats.uploaded_bytes <= LARGEST);
        CHECK(stats.uploaded_bytes > 0 || stats.missing == 0);
    }
    CHECK(frames > 1);
    CHECK_EQUAL(0, made_count_different(whole, m.pixels, 0));
    CHECK(made_count_different(first, whole, 0) > 20);
    // without a budget everything is uploaded at once
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, NULL));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(0, made_count_different(whole, m.pixels, 0));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(0, stp_draw_gl_get_stats(m.renderer).uploaded_bytes);
    made_gl_end(&m);
}

void test_gl_counts_what_is_missing_of_both_eyes(test_state* test)
{
    static uint8_t whole[4 * PIXELS];
    made_gl m;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    m.picture.view.eye_distance = 0.3;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    memcpy(whole, m.pixels, sizeof(whole));
    for (uint64_t budget = 4096; budget <= 16384; budget += 3072) { // either eye may be drawn last
        const stp_draw_gl_desc settings = {.upload_bytes = budget};
        CHECK_EQUAL(STP_OK, made_gl_renew(&m, &settings));
        stp_draw_gl_stats stats = {.missing = 1};
        for (int frames = 0; stats.missing > 0 && frames < 100; ++frames) {
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            stats = stp_draw_gl_get_stats(m.renderer);
            CHECK((stats.coming > 0) == (stats.missing > 0));
        }
        CHECK_EQUAL(0, made_count_different(whole, m.pixels, 0));
    }
    made_gl_end(&m);
}

void test_gl_uploads_keep_to_their_budget_for_both_eyes(test_state* test)
{
    enum { BUDGET = 8192, FRAMES_MAX = 100 }; // no octave is larger
    const stp_draw_gl_desc settings = {.upload_bytes = BUDGET};
    made_gl m;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    m.picture.view.eye_distance = 0.3;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    uint64_t whole = stp_draw_gl_get_stats(m.renderer).uploaded_bytes, sum = 0;
    CHECK(whole > 4 * BUDGET); // bytes of both eyes, although the second uploads nothing
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &settings));
    stp_draw_gl_stats stats = {.missing = 1};
    for (int frames = 0; stats.missing > 0 && frames < FRAMES_MAX; ++frames) {
        uint64_t before = stats.resident_bytes;
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        stats = stp_draw_gl_get_stats(m.renderer);
        CHECK(stats.uploaded_bytes <= BUDGET);
        CHECK(stats.resident_bytes - before >= stats.uploaded_bytes);
        sum += stats.uploaded_bytes;
    }
    CHECK_EQUAL(whole, sum);
    made_gl_end(&m);
}

/// A view of one whole sheet.
static void look_at(made_gl* m, int sheet)
{
    double x = 3 * (sheet % 3) - 3, y = 3 * (sheet / 3) - 1.5;
    m->picture.view.eye = (stp_vec3d){x, y, 15 - 0.3 * sheet};
    m->picture.view.target = (stp_vec3d){x, y, -0.3 * sheet};
    m->picture.view.fov_degrees = 8;
    m->picture.quality.splat_size = 6;
}

void test_gl_memory_is_reused(test_state* test)
{
    const stp_draw_gl_desc small = {.memory_bytes = 48 << 10};
    static uint8_t whole[6][4 * PIXELS];
    made_gl m;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    for (int i = 0; i < 6; ++i) {
        look_at(&m, i);
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        memcpy(whole[i], m.pixels, sizeof(whole[i]));
    }
    CHECK(stp_draw_gl_get_stats(m.renderer).resident_bytes > small.memory_bytes);
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &small));
    uint64_t uploaded = 0;
    for (int i = 0; i < 18; ++i) {
        look_at(&m, i * 5 % 6);
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        stp_draw_gl_stats stats = stp_draw_gl_get_stats(m.renderer);
        CHECK(stats.resident_bytes <= stats.memory_bytes);
        CHECK(stats.memory_bytes <= small.memory_bytes);
        uploaded += stats.uploaded_bytes;
        if (stats.missing == 0) {
            CHECK_EQUAL(0, made_count_different(whole[i * 5 % 6], m.pixels, 0));
        }
    }
    CHECK(uploaded > small.memory_bytes);
    made_gl_end(&m);
}

void test_gl_pictures_are_coarser_with_little_memory(test_state* test)
{
    const stp_draw_gl_desc tiny = {.memory_bytes = 10 << 10};
    made_gl m;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    uint64_t covered = m.picture.stats.covered_pixels;
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &tiny));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    stp_draw_gl_stats stats = stp_draw_gl_get_stats(m.renderer);
    CHECK(stats.missing > 0 && stats.coming == 0); // it is not uploaded either
    CHECK(m.picture.stats.covered_pixels >= covered);
    // so it is the mean of coarser frames
    made_picture* p = &m.picture;
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, m.pixels};
    p->style.supersample = 2;
    for (uint32_t i = 1; i <= 4; ++i) {
        CHECK_EQUAL(STP_OK, stp_renderer_accumulate(m.renderer, &p->view, &p->quality, &p->style,
                                                    &p->list, &image, &p->stats));
        CHECK_EQUAL(i, p->stats.samples);
    }
    // frames with uploads do not count
    const stp_draw_gl_desc slow = {.upload_bytes = 2048};
    CHECK_EQUAL(STP_OK, made_gl_renew(&m, &slow));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(stp_draw_gl_get_stats(m.renderer).coming > 0);
    made_gl_end(&m);
}

void test_gl_survives_failing_memory(test_state* test)
{
    static uint8_t whole[4 * PIXELS];
    test_heap heap = TEST_HEAP(-1);
    made_gl m;
    if (!begin(test, &m, NULL, &heap)) {
        return;
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    memcpy(whole, m.pixels, sizeof(whole));
    int failures = 0;
    for (int fail = 0; fail < 200; ++fail) { // every allocation in the creation of a renderer
        heap.fail_at = heap.count + fail;
        stp_result result = made_gl_renew(&m, NULL);
        bool reached = heap.fail_at >= 0 && heap.count > heap.fail_at;
        heap.fail_at = -1;
        CHECK(result == STP_OK || (reached && m.renderer == NULL));
        failures += result != STP_OK ? 1 : 0;
        if (!reached) {
            break;
        }
    }
    CHECK(failures > 3);
    m.picture.style.supersample = 2; // and in the first frame
    for (int fail = 0; fail < 200; fail += 1 + fail / 4) {
        heap.fail_at = heap.count + fail;
        stp_result result = made_gl_draw(&m);
        bool reached = heap.count > heap.fail_at;
        heap.fail_at = -1;
        CHECK(result == STP_OK || (reached && result == STP_ERROR_OUT_OF_MEMORY));
        if (!reached) {
            break;
        }
    }
    m.picture.style.supersample = 1;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(0, made_count_different(whole, m.pixels, 0));
    made_gl_end(&m);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_gl_warm_frames_allocate_nothing(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    made_gl m;
    if (!begin(test, &m, NULL, &heap)) {
        return;
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    int before = heap.count;
    for (int i = 0; i < 20; ++i) {
        m.picture.view.eye.x = 0.001 * i;
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    }
    CHECK_EQUAL(before, heap.count);
    made_gl_end(&m);
}

/// Only the second query finds an error: that after the first buffer.
static GLenum first_buffer_fails(void)
{
    static int calls;
    return ++calls == 2 ? GL_OUT_OF_MEMORY : GL_NO_ERROR;
}

void test_small_gl_scenes_use_one_page(test_state* test)
{
    enum { LIMIT = 64 << 20, SCENE = 20 << 20, WORDS = 1000 };
    made_gl m;
    stp_gl_pool pool;
    if (!begin(test, &m, NULL, NULL)) {
        return;
    }
    stp_gl gl = ((stp_gl_renderer*)m.renderer)->gl;
    CHECK_EQUAL(STP_OK, stp_gl_pool_create(m.picture.context, &gl, 1, LIMIT, SCENE, &pool));
    uint32_t shift = pool.page_shift; // 32 MiB: the next power of two
    CHECK_EQUAL(32 << 20, 4 << shift);
    CHECK(stp_gl_pool_take(&pool, 0, WORDS));
    CHECK_EQUAL(1, pool.page_count);
    stp_gl_pool_destroy(&pool);
    // eight pages hold the limit, however small the scene is
    CHECK_EQUAL(STP_OK, stp_gl_pool_create(m.picture.context, &gl, 1, LIMIT, 1, &pool));
    CHECK_EQUAL(LIMIT / 8, 4 << pool.page_shift);
    // but the first one is no larger than the scene needs, if it needs that little
    CHECK(stp_gl_pool_take(&pool, 0, WORDS));
    CHECK_EQUAL(1 << 20, 4 * pool.spans.total);
    stp_gl_pool_drop(&pool, 0);
    CHECK(stp_gl_pool_take(&pool, 0, 1 << 20)); // 4 MiB
    CHECK_EQUAL(2, pool.page_count);
    stp_gl_pool_destroy(&pool);
    // where memory is short, a page is smaller
    gl.GetError = first_buffer_fails;
    CHECK_EQUAL(STP_OK, stp_gl_pool_create(m.picture.context, &gl, 1, LIMIT, SCENE, &pool));
    CHECK(stp_gl_pool_take(&pool, 0, WORDS));
    CHECK_EQUAL(shift - 1, pool.page_shift);
    CHECK_EQUAL(1, pool.page_count);
    stp_gl_pool_destroy(&pool);
    made_gl_end(&m);
}
