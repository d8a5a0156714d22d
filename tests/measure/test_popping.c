// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/measure/popping.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 45, HEIGHT = 26, PIXELS = WIDTH * HEIGHT, COLUMNS = 6, ROWS = 4 };

typedef struct pictures {
    uint8_t bytes[4][PIXELS * 4];
    stp_image images[4];
} pictures;

static void make_pictures(pictures* p, uint32_t seed)
{
    uint32_t state = seed * 2654435761U + 1U;
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < PIXELS * 4; ++k) {
            state = state * 1664525U + 1013904223U;
            p->bytes[i][k] = (uint8_t)(state >> 24);
        }
        p->images[i] = (stp_image){WIDTH, HEIGHT, p->bytes[i]};
    }
}

static stp_result add(stp_context* context, stp_popping* popping, const pictures* p)
{
    return stp_popping_add(context, popping, &p->images[0], &p->images[1], &p->images[2],
                           &p->images[3]);
}

static int compare_doubles(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

// Mean change of the block, straight from the definition.
static double change_of(const uint8_t* before, const uint8_t* after, int column, int row)
{
    double sum = 0.0;
    int count = 0;
    for (int y = 8 * row; y < 8 * row + 8 && y < HEIGHT; ++y) {
        for (int x = 8 * column; x < 8 * column + 8 && x < WIDTH; ++x) {
            const uint8_t *a = before + 4 * (y * WIDTH + x), *b = after + 4 * (y * WIDTH + x);
            for (int c = 0; c < 3; ++c) {
                sum += fabs(floor(a[c] * a[3] / 255.0 + 0.5) - floor(b[c] * b[3] / 255.0 + 0.5));
            }
            count += 3;
        }
    }
    return sum / count;
}

void test_popping_follows_its_definition(test_state* test)
{
    static pictures p;
    static double values[3 * COLUMNS * ROWS];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_popping popping;
        CHECK_EQUAL(STP_OK, stp_popping_create(context, &popping));
        CHECK(stp_popping_percentile(&popping, 1.0) == 0.0);
        size_t count = 0;
        for (uint32_t seed = 0; seed < 3; ++seed) {
            make_pictures(&p, seed);
            CHECK_EQUAL(STP_OK, add(context, &popping, &p));
            for (int i = 0; i < COLUMNS * ROWS; ++i) {
                double beyond = change_of(p.bytes[0], p.bytes[1], i % COLUMNS, i / COLUMNS) -
                                change_of(p.bytes[2], p.bytes[3], i % COLUMNS, i / COLUMNS);
                values[count++] = beyond > 0.0 ? beyond : 0.0;
            }
            double sum = 0.0;
            for (size_t i = count - COLUMNS * ROWS; i < count; ++i) {
                sum += values[i];
            }
            CHECK(fabs(popping.last_mean - sum / (COLUMNS * ROWS)) <= 0.5 / 192 + 1e-9);
        }
        CHECK_EQUAL(count, popping.total);
        qsort(values, count, sizeof(values[0]), compare_doubles);
        CHECK(values[0] <= 0.0 && values[count - 1] > 1.0); // both kinds occur
        for (size_t i = 1; i <= count; ++i) {               // the i-th smallest
            double part = ((double)i - 0.5) / (double)count;
            CHECK(fabs(stp_popping_percentile(&popping, part) - values[i - 1]) <= 0.5 / 192 + 1e-9);
        }
        CHECK(stp_popping_percentile(&popping, 1.0) >= stp_popping_percentile(&popping, 0.999));
        stp_popping_destroy(context, &popping);
        stp_context_destroy(context);
    }
}

void test_popping_of_the_reference_is_none(test_state* test)
{
    static pictures p;
    stp_context* context = test_context(NULL, 2, NULL);
    stp_popping popping;
    CHECK_EQUAL(STP_OK, stp_popping_create(context, &popping));
    make_pictures(&p, 9);
    memcpy(p.bytes[2], p.bytes[0], sizeof(p.bytes[0]));
    memcpy(p.bytes[3], p.bytes[1], sizeof(p.bytes[0]));
    CHECK_EQUAL(STP_OK, add(context, &popping, &p));
    CHECK(stp_popping_percentile(&popping, 1.0) == 0.0);
    // a still approximation of a moving reference does not pop
    memcpy(p.bytes[1], p.bytes[0], sizeof(p.bytes[0]));
    CHECK_EQUAL(STP_OK, add(context, &popping, &p));
    CHECK(stp_popping_percentile(&popping, 1.0) == 0.0);
    // the maximum: black turns white
    for (int i = 0; i < 4; ++i) {
        memset(p.bytes[i], i == 1 ? 255 : 0, sizeof(p.bytes[i]));
    }
    CHECK_EQUAL(STP_OK, add(context, &popping, &p));
    CHECK(stp_popping_percentile(&popping, 1.0) == 255.0);
    CHECK(stp_popping_percentile(&popping, 0.5) == 0.0);
    stp_popping_destroy(context, &popping);
    stp_context_destroy(context);
}

void test_popping_refuses_pictures_of_other_sizes_and_lacks_memory(test_state* test)
{
    static pictures p;
    make_pictures(&p, 1);
    p.images[2].height -= 1;
    test_log log = {.errors = 0};
    stp_context* logging = test_context(NULL, 1, &log);
    stp_popping popping;
    CHECK_EQUAL(STP_OK, stp_popping_create(logging, &popping));
    CHECK_EQUAL(STP_ERROR_ARGUMENT, add(logging, &popping, &p));
    CHECK(log.errors == 1 && strstr(log.text, "45x26") != NULL &&
          strstr(log.text, "45x25") != NULL);
    stp_popping_destroy(logging, &popping);
    stp_context_destroy(logging);
    p.images[2].height += 1;
    bool passed = false;
    for (int fail = 0; fail < 40 && !passed; ++fail) {
        test_heap heap = TEST_HEAP(fail);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_result result = stp_popping_create(context, &popping);
            result = result == STP_OK ? add(context, &popping, &p) : result;
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            passed = result == STP_OK;
            stp_popping_destroy(context, &popping);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(passed);
}
