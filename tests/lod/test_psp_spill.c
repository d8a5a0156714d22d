// SPDX-License-Identifier: MIT
// Progressive splats of points in files (src/lod/psp/room.h): the same as in memory, for any
// number of threads; a failure is reported once.
#include "tests.h"

#include "base/math/rng.h"
#include "lod/psp/forest.h"

#include <math.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <sys/resource.h>

enum { MOST = 10000 };

static float positions[3 * MOST], normals[3 * MOST], areas[MOST];
static uint8_t colors[4 * MOST];

// A wavy sheet, in no order.
static stp_psp_points make_sheet(uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        float x = (float)stp_rng_below(1, i, 100000) * 1e-3f;
        float y = (float)stp_rng_below(2, i, 100000) * 1e-3f;
        positions[3 * i] = x;
        positions[3 * i + 1] = y;
        positions[3 * i + 2] = 3.0f * sinf(0.2f * x) * sinf(0.3f * y);
        normals[3 * i] = normals[3 * i + 1] = 0.0f;
        normals[3 * i + 2] = i % 7 == 0 ? 0.0f : 1.0f;
        areas[i] = 0.5f + 0.25f * (float)(i % 5);
        for (uint32_t k = 0; k < 4; ++k) {
            colors[4 * i + k] = (uint8_t)stp_rng_below(3, 4 * i + k, 256);
        }
    }
    return (stp_psp_points){.count = count,
                            .positions = positions,
                            .normals = normals,
                            .colors = colors,
                            .color_bytes = 4,
                            .areas = areas};
}

static bool are_equal(const stp_psp_splats* a, const stp_psp_splats* b)
{
    size_t n = a->count;
    return a->count == b->count && n > 0 &&
           memcmp(a->ellipses, b->ellipses, n * sizeof(*a->ellipses)) == 0 &&
           memcmp(a->colors, b->colors, 3 * n) == 0 &&
           memcmp(a->areas, b->areas, n * sizeof(*a->areas)) == 0 &&
           memcmp(a->firsts, b->firsts, n * sizeof(*a->firsts)) == 0;
}

void test_psp_spilled_splats_are_the_same(test_state* test)
{
    stp_psp_points points = make_sheet(MOST);
    for (int n = 0; n < 6; ++n) {
        stp_psp_desc desc = stp_psp_desc_default();
        desc.metric = (stp_psp_metric)(n % 3);
        desc.piece_size = n < 3 ? 64 : 0;
        desc.connect_components = true;
        stp_context* plain = test_context(NULL, 2, NULL);
        stp_psp_splats in_memory, spilled;
        CHECK_EQUAL(STP_OK, stp_psp_decimate(plain, &points, &desc, 300, &in_memory));
        uint64_t plain_bytes = stp_context_peak_bytes(plain);
        // threads take pieces: each number of them for each metric, and one where there is one piece
        uint32_t first = n < 3 ? 1 : (uint32_t)n - 2, last = n < 3 ? 3 : first;
        for (uint32_t threads = first; threads <= last; ++threads) {
            stp_context* context = test_context(NULL, threads, NULL);
            CHECK_EQUAL(STP_OK, stp_spill_create(context, ".", &desc.spill));
            CHECK_EQUAL(STP_OK, stp_psp_decimate(context, &points, &desc, 300, &spilled));
            CHECK(are_equal(&in_memory, &spilled));
            // only the pieces of each thread stay in memory
            CHECK(desc.piece_size == 0 || stp_context_peak_bytes(context) < plain_bytes / 2);
            stp_psp_splats_destroy(context, &spilled);
            stp_spill_destroy(desc.spill);
            stp_context_destroy(context);
        }
        stp_psp_splats_destroy(plain, &in_memory);
        stp_context_destroy(plain);
    }
}

void test_psp_spilled_splats_survive_failing_allocator(test_state* test)
{
    stp_psp_points points = make_sheet(300);
    bool made = false;
    for (int n = 1; !made && n < 4000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_psp_desc desc = stp_psp_desc_default();
        desc.metric = (stp_psp_metric)(n % 3);
        desc.piece_size = 48;
        desc.connect_components = true;
        if (context != NULL && stp_spill_create(context, ".", &desc.spill) == STP_OK) {
            stp_psp_splats s = {0};
            stp_result result = stp_psp_decimate(context, &points, &desc, 3, &s);
            made = result == STP_OK && heap.count <= n;
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            CHECK_EQUAL(result == STP_OK ? 0 : 1, log.errors);
            stp_psp_splats_destroy(context, &s);
            stp_spill_destroy(desc.spill);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}

// A limit on the size of files simulates a full disk: at the tree, or later, in pieces on all
// threads. One message reports it.
void test_psp_spilled_splats_say_that_the_disk_is_full(test_state* test)
{
    enum { SMALLEST = 4 << 20 }; // bytes of the smallest part of a file
    struct rlimit old, limit;
    static float many[3 * 300000];
    for (uint32_t i = 0; i < 3 * 300000; ++i) {
        many[i] = (float)stp_rng_below(4, i, 1 << 20);
    }
    stp_psp_points points = {.count = 300000, .positions = many};
    CHECK(getrlimit(RLIMIT_FSIZE, &old) == 0);
    for (uint32_t parts = 0; parts < 4; ++parts) {
        test_heap heap = TEST_HEAP(-1);
        test_log log = {0};
        stp_context* context = test_context(&heap, 3, &log);
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_splats s = {0};
        CHECK_EQUAL(STP_OK, stp_spill_create(context, ".", &desc.spill));
        void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
        limit = (struct rlimit){.rlim_cur = parts * SMALLEST, .rlim_max = old.rlim_max};
        CHECK(setrlimit(RLIMIT_FSIZE, &limit) == 0);
        stp_result result = stp_psp_decimate(context, &points, &desc, 100, &s);
        CHECK(setrlimit(RLIMIT_FSIZE, &old) == 0);
        (void)signal(SIGXFSZ, handler);
        CHECK_EQUAL(STP_ERROR_IO, result);
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, ".: no room for") != NULL);
        stp_psp_splats_destroy(context, &s);
        stp_spill_destroy(desc.spill);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
