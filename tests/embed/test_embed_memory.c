// SPDX-License-Identifier: MIT
// Any failed allocation is reported once and leaks nothing; limits hold; contexts are independent.
#include "support_embed.h"

#include "program/present/headless.h"

#include <dirent.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

enum { PIXELS = EMBED_SIDE * EMBED_SIDE * 4 };

#ifdef STP_SANITIZED
static const bool is_sanitized = true;
#else
static const bool is_sanitized = false;
#endif

/// Opens, calls every query, draws and picks.
static stp_result use_model(stp_context* context, const stp_model_desc* desc, uint8_t* pixels)
{
    stp_model* model = NULL;
    stp_model_info info = {0};
    stp_view view = embed_view();
    stp_hit hit = {0};
    uint32_t object;
    stp_result result = stp_model_open(context, desc, &model);
    result = result == STP_OK ? stp_model_get_info(model, &info) : result;
    result = result == STP_OK ? stp_model_find_object(model, "box", 0, &object) : result;
    if (result == STP_OK) {
        result = stp_model_set_appearance(model, object, STP_APPEARANCE_GHOST);
    }
    result = result == STP_OK ? embed_draw(model, NULL, pixels) : result;
    result = result == STP_OK ? stp_model_pick(model, &view, 48, 20, &hit) : result;
    stp_model_close(model);
    return result;
}

/// Fails each allocation in turn, later only every `stride`-th; `forever`: and all after it. @return
/// NULL, or the problem
static const char* fail_allocations(stp_result (*use)(stp_context*, void*), void* user, int stride,
                                    bool forever)
{
    bool done = false;
    for (int n = 0; !done; n += 1 + n / stride) {
        test_heap heap = TEST_HEAP(n);
        heap.forever = forever;
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_result result = context != NULL ? use(context, user) : STP_ERROR_OUT_OF_MEMORY;
        done = heap.count <= n;
        if (context != NULL) {
            stp_context_destroy(context);
        }
        if (heap.live_bytes != 0) {
            return "memory is left";
        }
        if (done ? result != STP_OK : result != STP_OK && result != STP_ERROR_OUT_OF_MEMORY) {
            fprintf(stderr, "allocation %d: %s: %s\n", n, stp_result_string(result), log.text);
            return "another result";
        }
        if (context != NULL && log.errors != (result != STP_OK)) {
            fprintf(stderr, "allocation %d: %d errors: %s\n", n, log.errors, log.text);
            return "not said once";
        }
    }
    return NULL;
}

typedef struct used_model {
    stp_model_desc desc;
    uint8_t pixels[PIXELS];
} used_model;

static stp_result use_again(stp_context* context, void* user)
{
    used_model* used = user;
    return use_model(context, &used->desc, used->pixels);
}

void test_embed_models_survive_failing_allocator(test_state* test)
{
    static used_model used;
    size_t size = 0;
    void* bytes = embed_build_town(true, &size);
    used.desc = (stp_model_desc){.bytes = bytes, .size = size};
    const char* fault = bytes != NULL ? fail_allocations(use_again, &used, 100, false) : "no model";
    used.desc.stream = true;
    fault = fault == NULL ? fail_allocations(use_again, &used, 20, true) : fault;
    free(bytes);
    if (fault != NULL) {
        fprintf(stderr, "%s\n", fault);
    }
    CHECK(fault == NULL);
}

static stp_result build_town(stp_context* context, void* user)
{
    stp_builder* builder = NULL;
    stp_write_desc desc = {.threshold = 100, .folder = user};
    stp_result result = stp_builder_create(context, NULL, &builder);
    result = result == STP_OK ? stp_builder_add_file(builder, "nothing.glb") : result;
    stp_builder_destroy(builder);
    builder = NULL;
    result = result == STP_OK ? stp_builder_create(context, NULL, &builder) : result;
    result = result == STP_OK ? embed_add_town(builder, true) : result;
    result = result == STP_OK ? stp_builder_write(builder, &desc, NULL) : result;
    stp_builder_destroy(builder);
    return result;
}

static int count_entries(const char* folder)
{
    int count = 0;
    DIR* listed = opendir(folder);
    for (struct dirent* entry; listed != NULL && (entry = readdir(listed)) != NULL;) {
        count += entry->d_name[0] != '.';
    }
    if (listed != NULL) {
        closedir(listed);
    }
    return count;
}

void test_embed_builders_survive_failing_allocator(test_state* test)
{
    char folder[] = "stp_embed_XXXXXX";
    CHECK(mkdtemp(folder) != NULL);
    const char* fault = fail_allocations(build_town, folder, 8, false);
    fault = fault == NULL ? fail_allocations(build_town, folder, 16, true) : fault;
    int left = count_entries(folder);
    rmdir(folder);
    if (fault != NULL) {
        fprintf(stderr, "%s\n", fault);
    }
    CHECK(fault == NULL);
    CHECK_EQUAL(0, left);
}

void test_embed_streams_under_a_limit(test_state* test)
{
    static uint8_t whole[PIXELS], streamed[PIXELS];
    size_t size = 0;
    void* bytes = embed_build_town(true, &size);
    stp_model_desc desc = {.bytes = bytes, .size = size};
    stp_context* context = NULL;
    stp_context_desc limited = {.thread_count = 1, .memory_limit_bytes = 8 << 20};
    stp_model* model = NULL;
    stp_stream_info info = {0};
    stp_paint_desc paint = {.complete = true};
    CHECK(bytes != NULL && stp_context_create(&context, &limited) == STP_OK);
    stp_result plain = use_model(context, &desc, whole);
    desc.stream = true;
    desc.stream_bytes = 2 << 20;
    stp_result opened = stp_model_open(context, &desc, &model);
    stp_result drawn = opened == STP_OK ? embed_draw(model, &paint, streamed) : opened;
    stp_result asked = opened == STP_OK ? stp_model_get_stream(model, &info) : opened;
    stp_paint_desc reference = {.triangles_only = true};
    stp_result refused = opened == STP_OK ? embed_draw(model, &reference, streamed) : opened;
    stp_model_close(model);
    uint64_t peak = stp_context_peak_bytes(context);
    stp_context_destroy(context);
    free(bytes);
    CHECK(plain == STP_OK && drawn == STP_OK && asked == STP_OK);
    CHECK(info.loaded > 0 && info.read_bytes > 0 && info.missing == 0 && info.damaged == 0);
    CHECK(info.peak_bytes <= info.limit_bytes && info.limit_bytes <= 2 << 20);
    CHECK(peak <= limited.memory_limit_bytes);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, refused);
}

typedef struct thread_work {
    uint32_t threads;
    uint8_t pixels[PIXELS];
    void* bytes;
    size_t size;
    stp_result result;
} thread_work;

static void* build_and_draw(void* user)
{
    thread_work* work = user;
    work->bytes = embed_build_town_on(work->threads, true, &work->size);
    stp_context* context = test_context(NULL, work->threads, NULL);
    stp_model_desc desc = {.bytes = work->bytes, .size = work->size};
    work->result = use_model(context, &desc, work->pixels);
    stp_context_destroy(context);
    return NULL;
}

void test_embed_threads_have_contexts_of_their_own(test_state* test)
{
    static thread_work works[2] = {{.threads = 1}, {.threads = 3}};
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, build_and_draw, &works[1]) == 0);
    build_and_draw(&works[0]);
    pthread_join(thread, NULL);
    bool alike = works[0].bytes != NULL && works[1].bytes != NULL &&
                 works[0].size == works[1].size &&
                 memcmp(works[0].bytes, works[1].bytes, works[0].size) == 0 &&
                 memcmp(works[0].pixels, works[1].pixels, PIXELS) == 0;
    stp_result results[2] = {works[0].result, works[1].result};
    free(works[0].bytes);
    free(works[1].bytes);
    CHECK(alike && results[0] == STP_OK && results[1] == STP_OK);
}

static void* use_whole_model(void* user)
{
    thread_work* work = user;
    stp_context* context = test_context(NULL, work->threads, NULL);
    stp_model_desc desc = {.bytes = work->bytes, .size = work->size};
    desc.point_coloring =
        (stp_point_coloring){.by_attribute = true, .attribute = STP_ATTRIBUTE_INTENSITY};
    work->result = use_model(context, &desc, work->pixels);
    desc.stream = true;
    work->result = work->result == STP_OK ? use_model(context, &desc, work->pixels) : work->result;
    stp_context_destroy(context);
    return NULL;
}

// Some systems give threads little more.
void test_embed_models_need_a_small_stack(test_state* test)
{
    static thread_work work = {.threads = 1};
    pthread_attr_t attributes;
    pthread_t thread;
    work.bytes = embed_build_town(true, &work.size);
    CHECK(work.bytes != NULL && pthread_attr_init(&attributes) == 0);
    // the sanitizers' frames are larger
    size_t size = is_sanitized ? 1 << 20 : 128 << 10;
    CHECK_EQUAL(0, pthread_attr_setstacksize(&attributes, size));
    CHECK_EQUAL(0, pthread_attr_setguardsize(&attributes, 1 << 20)); // no frame jumps over it
    CHECK_EQUAL(0, pthread_create(&thread, &attributes, use_whole_model, &work));
    pthread_join(thread, NULL);
    pthread_attr_destroy(&attributes);
    free(work.bytes);
    CHECK_EQUAL(STP_OK, work.result);
}

static int stop_at_once(const stp_progress_report* report, void* user)
{
    *(int*)user += 1;
    return strcmp(report->stage, "surfels") == 0;
}

void test_embed_builds_and_pictures_are_cancelled(test_state* test)
{
    static uint8_t before[PIXELS], after[PIXELS];
    char folder[] = "stp_embed_XXXXXX";
    int reports = 0;
    size_t size = 0;
    stp_context_desc desc = {
        .thread_count = 1, .progress = stop_at_once, .progress_user = &reports};
    stp_context* context = NULL;
    CHECK(mkdtemp(folder) != NULL && stp_context_create(&context, &desc) == STP_OK);
    stp_result built = build_town(context, folder);
    int left = count_entries(folder);
    rmdir(folder);
    void* bytes = embed_build_town(false, &size);
    stp_model* model = NULL;
    stp_painter* painter = NULL;
    stp_view view = embed_view();
    stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = before};
    stp_result results[4] = {STP_ERROR_IO, STP_ERROR_IO, STP_ERROR_IO, STP_ERROR_IO};
    if (stp_model_open(context, &(stp_model_desc){.bytes = bytes, .size = size}, &model) ==
            STP_OK &&
        stp_painter_create(model, &(stp_painter_desc){.can_stop = true}, &painter) == STP_OK) {
        results[0] = stp_painter_draw(painter, &view, NULL, &image, NULL);
        stp_painter_set_stopped(painter, true);
        image.pixels = after;
        results[1] = stp_painter_draw(painter, &view, NULL, &image, NULL);
        stp_painter_set_stopped(painter, false);
        results[2] = stp_painter_draw(painter, &view, NULL, &image, NULL);
        results[3] = stp_painter_draw(painter, &view, NULL, NULL, NULL);
    }
    stp_painter_destroy(painter);
    stp_model_close(model);
    stp_context_destroy(context);
    free(bytes);
    CHECK(reports > 0);
    CHECK_EQUAL(STP_ERROR_CANCELLED, built);
    CHECK_EQUAL(0, left);
    CHECK_EQUAL(STP_OK, results[0]);
    CHECK_EQUAL(STP_ERROR_CANCELLED, results[1]);
    CHECK_EQUAL(STP_OK, results[2]);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, results[3]);
    CHECK(memcmp(before, after, PIXELS) == 0);
}

typedef struct stopping {
    stp_painter* painter;
    atomic_bool done;
} stopping;

static void* toggle_stopped(void* user)
{
    stopping* s = user;
    for (bool stopped = true; !atomic_load(&s->done); stopped = !stopped) {
        stp_painter_set_stopped(s->painter, stopped);
    }
    return NULL;
}

// A stop that is taken back at once leaves no picture with missing parts.
void test_embed_pictures_are_whole_or_cancelled(test_state* test)
{
    enum { PICTURES = 200 };
    static uint8_t whole[PIXELS], pixels[PIXELS];
    static stopping s;
    size_t size = 0;
    void* bytes = embed_build_town(false, &size);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_model* model = NULL;
    stp_view view = embed_view();
    stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = whole};
    pthread_t thread;
    CHECK_EQUAL(STP_OK,
                stp_model_open(context, &(stp_model_desc){.bytes = bytes, .size = size}, &model));
    CHECK_EQUAL(STP_OK,
                stp_painter_create(model, &(stp_painter_desc){.can_stop = true}, &s.painter));
    CHECK_EQUAL(STP_OK, stp_painter_draw(s.painter, &view, NULL, &image, NULL));
    CHECK_EQUAL(0, pthread_create(&thread, NULL, toggle_stopped, &s));
    image.pixels = pixels;
    int different = 0;
    for (int i = 0; i < PICTURES; ++i) {
        stp_result result = stp_painter_draw(s.painter, &view, NULL, &image, NULL);
        different +=
            result == STP_OK ? memcmp(whole, pixels, PIXELS) != 0 : result != STP_ERROR_CANCELLED;
    }
    atomic_store(&s.done, true);
    pthread_join(thread, NULL);
    stp_painter_destroy(s.painter);
    stp_model_close(model);
    stp_context_destroy(context);
    free(bytes);
    CHECK_EQUAL(0, different);
}

static stp_gl_function get_function(const char* name, void* user)
{
    return stp_headless_get_proc_address(name, user);
}

/// Draws with both backends. @return how many pixels differ by more than 2 levels; -1: something
/// failed
static int compare_backends(stp_model* model, stp_headless* headless, uint8_t pixels[2][PIXELS],
                            float* depths, uint32_t* texture)
{
    stp_painter* painters[2] = {NULL, NULL};
    stp_painter_desc descs[2] = {{0}, {.get_proc_address = get_function, .gl_user = headless}};
    stp_view view = embed_view();
    stp_result result = STP_OK;
    for (int i = 0; i < 2 && result == STP_OK; ++i) {
        stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = pixels[i]};
        result = stp_painter_create(model, &descs[i], &painters[i]);
        result =
            result == STP_OK ? stp_painter_draw(painters[i], &view, NULL, &image, NULL) : result;
        result = result == STP_OK
                     ? stp_painter_get_depths(painters[i], depths + i * (PIXELS / 4), PIXELS / 4)
                     : result;
    }
    stp_paint_desc budget = {.budget_ms = 5.0};
    stp_paint_report report = {0};
    for (int i = 0; i < 3 && result == STP_OK; ++i) {
        result = stp_painter_draw(painters[1], &view, &budget, NULL, &report);
    }
    *texture = result == STP_OK ? stp_painter_get_texture(painters[1]) : 0;
    stp_painter_destroy(painters[1]);
    stp_painter_destroy(painters[0]);
    int different = 0;
    for (int i = 0; i < PIXELS; ++i) {
        different += pixels[0][i] - pixels[1][i] > 2 || pixels[1][i] - pixels[0][i] > 2;
    }
    return result == STP_OK && report.splat_size >= 1.0f ? different : -1;
}

void test_embed_opengl_matches_the_cpu(test_state* test)
{
    static uint8_t pixels[2][PIXELS];
    static float depths[2 * PIXELS / 4];
    stp_headless headless = {0};
    if (stp_headless_create(&(stp_headless_desc){.software = true}, &headless) != NULL) {
        SKIP("there is no OpenGL");
    }
    size_t size = 0;
    uint32_t texture = 0;
    void* bytes = embed_build_town(true, &size);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_model* model = NULL;
    stp_model_desc desc = {.bytes = bytes, .size = size};
    int different = stp_model_open(context, &desc, &model) == STP_OK
                        ? compare_backends(model, &headless, pixels, depths, &texture)
                        : -1;
    stp_model_close(model);
    stp_context_destroy(context);
    stp_headless_destroy(&headless);
    free(bytes);
    CHECK(different >= 0 && different < PIXELS / 100 && texture != 0);
    // the box: its front is at z = 1, the eye at 14
    float middle = depths[(EMBED_SIDE * 2 / 3) * EMBED_SIDE + EMBED_SIDE / 2];
    float same = depths[PIXELS / 4 + (EMBED_SIDE * 2 / 3) * EMBED_SIDE + EMBED_SIDE / 2];
    CHECK(middle > 12.9f && middle < 13.1f && same > 12.9f && same < 13.1f);
    CHECK(depths[0] > 1e30f);
}
