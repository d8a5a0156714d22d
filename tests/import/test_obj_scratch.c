// SPDX-License-Identifier: MIT
//
// OBJ files that are large compared to the memory limit: temporary files do not change the result.
#include "spilled_import.h"

#include "import/obj/obj.h"

#include <math.h>

enum { SIDE = 160, GROUPS = 12, CHUNK = 1 << 15 };

// One sheet of SIDE x SIDE squares, whose rows belong to groups of very different sizes; one uses
// few positions that are far apart. Faces refer to texture coordinates and normals, some by
// negative indices.
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

static stp_result read_sheet(stp_context* context, stp_scene* scene, const void* bytes, size_t size)
{
    stp_import import = {.context = context,
                         .scene = scene,
                         .path = "sheet.obj",
                         .file = {bytes, size},
                         .alone = true};
    stp_object root = {.name = "sheet.obj", .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_object(scene, &root, &import.root);
    return result == STP_OK ? stp_obj_read(&import, CHUNK) : result;
}

static spilled_import import_sheet(stp_context* context, const char* text, bool spills)
{
    return import_spilled(context, read_sheet, text, strlen(text), spills);
}

void test_obj_scratch_changes_nothing_but_memory(test_state* test)
{
    char* text = write_sheet();
    CHECK(text != NULL);
    spilled_import plain = {0};
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        for (int spills = 0; spills < 2; ++spills) {
            stp_context* context = test_context(NULL, threads, NULL);
            spilled_import now = import_sheet(context, text, spills == 1);
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
    for (size_t megabytes = 2; megabytes <= 14; megabytes += 4) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        file_limit limit;
        CHECK(file_limit_begin(&limit, megabytes << 20));
        spilled_import now = import_sheet(context, text, true);
        file_limit_end(&limit);
        CHECK_EQUAL(now.result == STP_OK ? 0 : 1, log.errors);
        CHECK(megabytes > 2 || now.result == STP_ERROR_IO);
        CHECK(now.result == STP_OK || now.result == STP_ERROR_IO);
        CHECK_EQUAL(0, now.left_bytes);
        stp_context_destroy(context);
    }
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
            spilled_import now = import_sheet(context, text, true);
            CHECK(now.result == STP_OK || now.result == STP_ERROR_OUT_OF_MEMORY);
            done = now.result == STP_OK;
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
    free(text);
}
