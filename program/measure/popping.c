// SPDX-License-Identifier: MIT
#include "program/measure/popping.h"

#include "program/measure/image_compare.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

stp_result stp_popping_create(stp_context* context, stp_popping* popping)
{
    *popping = (stp_popping){.counts = STP_NEW_ZEROED(context, uint64_t, STP_POPPING_VALUES)};
    return popping->counts != NULL ? STP_OK : stp_fail_memory(context);
}

void stp_popping_destroy(stp_context* context, stp_popping* popping)
{
    stp_free(context, popping->counts);
    stp_free(context, popping->values);
    *popping = (stp_popping){0};
}

typedef struct pair {
    const stp_image* images[4]; // before, after; reference before, after
    uint32_t columns;
    uint16_t* values;
} pair;

// Sum of the changes of `count` pixels.
static uint32_t sum_change(const uint8_t* before, const uint8_t* after, uint32_t count)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < count; ++i, before += 4, after += 4) {
        for (int channel = 0; channel < 3; ++channel) {
            int a = stp_composite_on_black(before, channel),
                b = stp_composite_on_black(after, channel);
            sum += (uint32_t)abs(a - b);
        }
    }
    return sum;
}

static void measure_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const pair* p = user;
    uint32_t width = p->images[0]->width, height = p->images[0]->height;
    for (size_t row = begin; row < end; ++row) {
        uint32_t top = (uint32_t)row * STP_POPPING_BLOCK;
        uint32_t bottom = height - top < STP_POPPING_BLOCK ? height : top + STP_POPPING_BLOCK;
        for (uint32_t column = 0; column < p->columns; ++column) {
            uint32_t left = column * STP_POPPING_BLOCK;
            uint32_t across = width - left < STP_POPPING_BLOCK ? width - left : STP_POPPING_BLOCK;
            uint32_t change = 0, expected = 0;
            for (uint32_t y = top; y < bottom; ++y) {
                size_t at = ((size_t)y * width + left) * 4;
                change += sum_change(p->images[0]->pixels + at, p->images[1]->pixels + at, across);
                expected +=
                    sum_change(p->images[2]->pixels + at, p->images[3]->pixels + at, across);
            }
            uint32_t samples = (bottom - top) * across * 3;
            uint32_t beyond = change > expected ? change - expected : 0;
            assert(samples > 0 && beyond <= 255 * samples && "within the histogram");
            p->values[row * p->columns + column] =
                (uint16_t)((beyond * STP_POPPING_UNITS + samples / 2) / samples);
        }
    }
}

stp_result stp_popping_add(stp_context* context, stp_popping* popping, const stp_image* before,
                           const stp_image* after, const stp_image* reference_before,
                           const stp_image* reference_after)
{
    pair p = {.images = {before, after, reference_before, reference_after}};
    for (int i = 1; i < 4; ++i) {
        if (p.images[i]->width != before->width || p.images[i]->height != before->height) {
            return stp_fail(context, STP_ERROR_ARGUMENT,
                            "popping: expected pictures of %ux%u pixels, got one of %ux%u",
                            before->width, before->height, p.images[i]->width, p.images[i]->height);
        }
    }
    p.columns = (uint32_t)(((uint64_t)before->width + STP_POPPING_BLOCK - 1) / STP_POPPING_BLOCK);
    size_t rows = ((size_t)before->height + STP_POPPING_BLOCK - 1) / STP_POPPING_BLOCK;
    size_t blocks = rows * p.columns;
    if (!STP_MAKE_ROOM(context, popping->values, popping->value_capacity, blocks)) {
        return stp_fail_memory(context);
    }
    p.values = popping->values;
    stp_parallel_for(context, rows, 8, measure_rows, &p);
    uint64_t sum = 0;
    for (size_t i = 0; i < blocks; ++i) {
        popping->counts[p.values[i]] += 1;
        sum += p.values[i];
    }
    popping->total += blocks;
    popping->last_mean =
        blocks > 0 ? (double)sum / (double)blocks / (double)STP_POPPING_UNITS : 0.0;
    return STP_OK;
}

double stp_popping_percentile(const stp_popping* popping, double part)
{
    assert(part >= 0.0 && part <= 1.0);
    double wanted = ceil(part * (double)popping->total); // blocks that must not exceed the result
    uint64_t below = 0;
    for (uint32_t value = 0; value < STP_POPPING_VALUES; ++value) {
        below += popping->counts[value];
        if (below > 0 && (double)below >= wanted) {
            return (double)value / STP_POPPING_UNITS;
        }
    }
    return 0.0;
}
