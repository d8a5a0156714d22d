// SPDX-License-Identifier: MIT
#include "lod/decimate/distinct.h"

#include "base/rng.h"
#include "lod/grid.h"

#include <string.h>

static uint64_t hash_place(const float* p)
{
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        float value = p[k] + 0.0f; // -0 is 0
        uint32_t bits;
        memcpy(&bits, &value, sizeof(bits));
        hash = stp_rng_hash(hash, bits);
    }
    return hash;
}

static bool is_same(const float* a, const float* b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void add_point(const stp_decimate_input* input, size_t point, uint32_t place,
                      stp_distinct* d)
{
    stp_color_mean_add(&d->means[place], input, point, 1.0);
    for (size_t k = 0; k < 3 && d->normals != NULL; ++k) {
        d->normals[3 * (size_t)place + k] += input->normals[3 * point + k];
    }
}

stp_result stp_distinct_make(stp_context* context, const stp_decimate_input* input, stp_distinct* d)
{
    size_t count = input->count, mask = 15;
    while (mask + 1 < 2 * count) {
        mask = 2 * mask + 1;
    }
    *d = (stp_distinct){
        .positions = STP_NEW_ARRAY(context, float, 3 * count + 1),
        .normals = input->normals != NULL ? STP_NEW_ZEROED(context, float, 3 * count + 1) : NULL,
        .means = STP_NEW_ZEROED(context, stp_color_mean, count + 1)};
    uint32_t* slots = STP_NEW_ZEROED(context, uint32_t, mask + 1); // a place + 1
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, count + 1);
    bool made = d->positions != NULL && d->means != NULL && slots != NULL && order != NULL &&
                (input->normals == NULL || d->normals != NULL);
    stp_result result = made ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result = stp_sort_spatially(context, input->positions, input->count, order);
    }
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        const float* p = input->positions + 3 * (size_t)order[i];
        size_t slot = hash_place(p) & mask;
        while (slots[slot] != 0 && !is_same(d->positions + 3 * ((size_t)slots[slot] - 1), p)) {
            slot = (slot + 1) & mask;
        }
        if (slots[slot] == 0) {
            memcpy(d->positions + 3 * (size_t)d->count, p, 3 * sizeof(*p));
            slots[slot] = ++d->count;
        }
        add_point(input, order[i], slots[slot] - 1, d);
    }
    stp_free(context, slots);
    stp_free(context, order);
    return result;
}

void stp_distinct_destroy(stp_context* context, stp_distinct* d)
{
    stp_free(context, d->positions);
    stp_free(context, d->normals);
    stp_free(context, d->means);
    *d = (stp_distinct){0};
}
