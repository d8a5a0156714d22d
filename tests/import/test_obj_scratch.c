// SPDX-License-Identifier: MIT
//
// OBJ files that are large beside the limit of memory: what is read lies in a temporary file, and changes nothing.
#include "import/formats_test.h"
#include "import/obj.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>

enum { SIDE = 160, GROUPS = 12, CHUNK = 1 << 15 };

// One sheet of SIDE x SIDE squares, whose rows belong to groups of very different sizes; one uses few positions that
// are far apart. Faces name texture coordinates and normals, some of them backwards.
static char* write_sheet(void)
{
    size_t size = (size_t)SIDE * SIDE * 140 + 4096, at = 0;
    char* text = malloc(size);
    if (text == NULL) {
        return NULL;
    }
    for (int i = 0; i < SIDE * SIDE; ++i) {
        int x = i % SIDE, y = i / SIDE;
        at += (size_t)snprintf(text + at, size - at, "v %d %d.%03d %d\nvt 0.%04d 0.%04d\n", x,
                               x * y % 7, i % 1000, y, x, y);
    }
    at += (size_t)snprintf(text + at, size - at, "vn 0 1 0\nvn 0 0.5 1\n");
    for (int y = 0; y + 1 < SIDE; ++y) {
        if (y % 8 == 0) {
            at += (size_t)snprintf(text + at, size - at, "g part%d\nusemtl m%d\n",
                                   y < 96 ? 0 : y % GROUPS, y / 40);
        }
        for (int x = 0; x + 1 < SIDE; ++x) {
            int a = y * SIDE + x + 1, b = a + SIDE;
            at += (size_t)snprintf(text + at, size - at, "f %d/%d/1 %d/%d/%d %d//-1 %d\n", a, a, b,
                                   b, 1 + x % 2, b + 1, a + 1);
        }
    }
    at += (size_t)snprintf(text + at, size - at, "g sparse\nf 1 %d %d\n", SIDE * SIDE,
                           SIDE * SIDE / 2);
    return at < size ? text : NULL;
}

typedef struct outcome {
    stp_result result;
    stp_hash digest;
    size_t peak_bytes, left_bytes;
} outcome;

static outcome import_sheet(stp_context* context, const char* text, bool spills)
{
    outcome out = {.result = STP_OK};
    size_t before = stp_context_live_bytes(context);
    stp_scene* scene = NULL;
    stp_spill* spill = NULL;
    out.result = spills ? stp_spill_create(context, "/tmp", &spill) : STP_OK;
    out.result = out.result != STP_OK ? out.result : stp_scene_create(context, &scene);
    if (out.result == STP_OK && spills) {
        stp_scene_use_spill(scene, spill, 1 << 20);
    }
    stp_import import = {.context = context,
                         .scene = scene,
                         .path = "sheet.obj",
                         .file = {(const unsigned char*)text, strlen(text)},
                         .alone = true};
    stp_object root = {.name = "sheet.obj", .parent = STP_NONE, .transform = stp_affine_identity()};
    if (out.result == STP_OK) {
        out.result = stp_scene_add_object(scene, &root, &import.root);
    }
    if (out.result == STP_OK) {
        out.result = stp_obj_read(&import, CHUNK);
    }
    if (out.result == STP_OK) {
        out.digest = digest_scene(scene);
    }
    stp_scene_destroy(scene);
    stp_spill_destroy(spill);
    out.left_bytes = stp_context_live_bytes(context) - before;
    out.peak_bytes = stp_context_peak_bytes(context);
    return out;
}

void test_obj_scratch_changes_nothing_but_memory(test_state* test)
{
    char* text = write_sheet();
    CHECK(text != NULL);
    outcome plain = {0};
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        for (int spills = 0; spills < 2; ++spills) {
            stp_context* context = test_context(NULL, threads, NULL);
            outcome now = import_sheet(context, text, spills == 1);
            CHECK_EQUAL(STP_OK, now.result);
            plain = threads == 1 && spills == 0 ? now : plain;
            CHECK(stp_hash_equal(now.digest, plain.digest));
            CHECK(spills == 0 || 3 * now.peak_bytes < plain.peak_bytes);
            CHECK_EQUAL(0, now.left_bytes);
            stp_context_destroy(context);
        }
    }
    free(text);
}

void test_obj_scratch_that_is_full_is_one_sentence(test_state* test)
{
    char* text = write_sheet();
    CHECK(text != NULL);
    struct rlimit before;
    CHECK(getrlimit(RLIMIT_FSIZE, &before) == 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (size_t megabytes = 2; megabytes <= 14; megabytes += 4) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        struct rlimit limit = {.rlim_cur = megabytes << 20, .rlim_max = before.rlim_max};
        CHECK(setrlimit(RLIMIT_FSIZE, &limit) == 0);
        outcome now = import_sheet(context, text, true);
        (void)setrlimit(RLIMIT_FSIZE, &before);
        CHECK_EQUAL(now.result == STP_OK ? 0 : 1, log.errors);
        CHECK(megabytes > 2 || now.result == STP_ERROR_IO);
        CHECK(now.result == STP_OK || now.result == STP_ERROR_IO);
        CHECK_EQUAL(0, now.left_bytes);
        stp_context_destroy(context);
    }
    (void)signal(SIGXFSZ, handler);
    free(text);
}

void test_obj_scratch_survives_failing_allocator(test_state* test)
{
    char* text = write_sheet();
    CHECK(text != NULL);
    bool done = false;
    for (int n = 0; !done && n < 100000; n += 1 + n / 4) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            outcome now = import_sheet(context, text, true);
            CHECK(now.result == STP_OK || now.result == STP_ERROR_OUT_OF_MEMORY);
            done = now.result == STP_OK;
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
    free(text);
}
