// SPDX-License-Identifier: MIT
#include "tests.h"

#include "capture/covered_pixels.h"

enum { RESOLUTION = 64 };

static const float square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};

void test_covered_pixels_are_those_of_three_pictures(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_box box = {{0, 0, 0}, {1, 1, 0}};
    uint64_t whole, half, tilted, none;
    CHECK_EQUAL(STP_OK,
                stp_count_covered_pixels(context, square, 4, two, 2, box, RESOLUTION, &whole));
    CHECK_EQUAL(RESOLUTION * RESOLUTION, whole); // edge-on from the two other sides
    CHECK_EQUAL(STP_OK,
                stp_count_covered_pixels(context, square, 4, two, 1, box, RESOLUTION, &half));
    CHECK(2 * half >= whole - 2 * RESOLUTION && 2 * half <= whole + 2 * RESOLUTION);
    const float slope[9] = {0, 0, 0, 1, 0, 1, 0, 1, 1};
    const uint32_t one[3] = {0, 1, 2};
    box.max.z = 1;
    CHECK_EQUAL(STP_OK,
                stp_count_covered_pixels(context, slope, 3, one, 1, box, RESOLUTION, &tilted));
    CHECK(2 * tilted >= 3 * (whole - 4 * RESOLUTION) && 2 * tilted <= 3 * whole);
    CHECK_EQUAL(STP_OK,
                stp_count_covered_pixels(context, square, 4, two, 0, box, RESOLUTION, &none));
    CHECK_EQUAL(0, none);
    stp_context_destroy(context);
}

void test_covered_pixels_need_memory(test_state* test)
{
    stp_box box = {{0, 0, 0}, {1, 1, 0}};
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    for (int fail = 0; fail < 16 && result != STP_OK; ++fail) {
        test_heap heap = TEST_HEAP(fail);
        stp_context* context = test_context(&heap, 1, NULL);
        uint64_t count = 0;
        result = context != NULL
                     ? stp_count_covered_pixels(context, square, 4, two, 2, box, RESOLUTION, &count)
                     : STP_ERROR_OUT_OF_MEMORY;
        CHECK(result == STP_ERROR_OUT_OF_MEMORY ||
              (result == STP_OK && count == RESOLUTION * RESOLUTION));
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK_EQUAL(STP_OK, result);
}
