// SPDX-License-Identifier: MIT
#include "base/math/color.h"
#include "base/math/rng.h"
#include "lab/decimate/subsample_field.h"

#include <assert.h>
#include <string.h>

enum { KEY_WORDS = 6 };

/// The bits of a position and a normal; 0 and -0 are one number.
typedef struct point_key {
    uint32_t words[KEY_WORDS];
} point_key;

static point_key make_key(const float* positions, const float* normals, size_t point)
{
    point_key key;
    float values[KEY_WORDS] = {0};
    for (size_t c = 0; c < 3; ++c) {
        values[c] = positions[3 * point + c] + 0.0f;
        values[3 + c] = normals != NULL ? normals[3 * point + c] + 0.0f : 0.0f;
    }
    memcpy(key.words, values, sizeof(key.words));
    return key;
}

static uint64_t hash_key(const point_key* key)
{
    uint64_t hash = 0;
    for (int i = 0; i < KEY_WORDS; i += 2) {
        hash = stp_rng_hash(hash, (uint64_t)key->words[i] << 32 | key->words[i + 1]);
    }
    return hash;
}

/// Finds the number of an equal point, or inserts a new one.
static uint32_t find_or_add(stp_subsample_unique* u, uint32_t* table, size_t mask,
                            const stp_decimate_input* input, size_t point)
{
    point_key key = make_key(input->positions, input->normals, point);
    size_t slot = (size_t)hash_key(&key) & mask;
    for (; table[slot] != UINT32_MAX; slot = (slot + 1) & mask) {
        point_key other = make_key(u->positions, u->normals, table[slot]);
        if (memcmp(&key, &other, sizeof(key)) == 0) {
            return table[slot];
        }
    }
    assert(u->count < mask && "a slot is always free");
    uint32_t number = table[slot] = u->count++;
    memcpy(u->positions + 3 * (size_t)number, input->positions + 3 * point, 3 * sizeof(float));
    if (u->normals != NULL) {
        memcpy(u->normals + 3 * (size_t)number, input->normals + 3 * point, 3 * sizeof(float));
    }
    if (u->colors != NULL) {
        u->colors[number] = (stp_subsample_color){{0}, 0.0f};
    }
    return number;
}

stp_result stp_subsample_unique_make(stp_context* context, const stp_decimate_input* input,
                                     stp_subsample_unique* u)
{
    size_t count = input->count, slots = 4;
    while (slots < 2 * count) {
        slots *= 2;
    }
    *u = (stp_subsample_unique){.positions = STP_NEW_ARRAY(context, float, 3 * count + 1)};
    bool made = u->positions != NULL;
    if (made && input->normals != NULL) {
        u->normals = STP_NEW_ARRAY(context, float, 3 * count + 1);
        made = u->normals != NULL;
    }
    if (made && input->colors != NULL) {
        u->colors = STP_NEW_ARRAY(context, stp_subsample_color, count + 1);
        made = u->colors != NULL;
    }
    uint32_t* table = made ? STP_NEW_ARRAY(context, uint32_t, slots) : NULL;
    if (table == NULL) {
        return stp_fail_memory(context);
    }
    memset(table, 0xff, slots * sizeof(*table));
    for (size_t i = 0; i < count; ++i) {
        uint32_t number = find_or_add(u, table, slots - 1, input, i);
        for (size_t c = 0; u->colors != NULL && c < 3; ++c) {
            u->colors[number].sum[c] += stp_srgb8_to_linear(input->colors[3 * i + c]);
        }
        if (u->colors != NULL) {
            u->colors[number].count += 1.0f;
        }
    }
    stp_free(context, table);
    return STP_OK;
}

void stp_subsample_unique_destroy(stp_context* context, stp_subsample_unique* unique)
{
    stp_free(context, unique->positions);
    stp_free(context, unique->normals);
    stp_free(context, unique->colors);
    *unique = (stp_subsample_unique){0};
}

void stp_subsample_mean_color(const stp_subsample_color* sum, uint8_t color[3])
{
    assert(sum->count > 0.0f);
    for (int c = 0; c < 3; ++c) {
        color[c] = stp_linear_to_srgb8(sum->sum[c] / sum->count);
    }
}
