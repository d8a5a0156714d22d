// SPDX-License-Identifier: MIT
#include "laz_encoder.h"

#include <assert.h>
#include <string.h>

typedef struct wave_models {
    stp_laz_model packet, kinds[4];
    stp_laz_integer offset, size, place, direction;
} wave_models;

typedef struct pointwise {
    stp_laz_model changed, angles[2], returns[256], classes[256], users[256], extra[16];
    stp_laz_integer intensity, source, x, y, z;
    stp_laz_time time;
    stp_laz_rgb rgb;
    wave_models wave;
    uint16_t intensities[16];
    int32_t heights[8];
    stp_laz_median x_steps[16], y_steps[16];
    unsigned wave_kind;
} pointwise;

static const uint8_t contexts[8][8] = {
    {15, 14, 13, 12, 11, 10, 9, 8},  {14, 0, 1, 3, 6, 10, 10, 9},
    {13, 1, 2, 4, 7, 11, 11, 10},    {12, 3, 4, 5, 8, 12, 12, 11},
    {11, 6, 7, 8, 9, 13, 13, 12},    {10, 10, 11, 12, 13, 14, 14, 13},
    {9, 10, 11, 12, 13, 14, 15, 14}, {8, 9, 10, 11, 12, 13, 14, 15},
};

static void make(stp_laz_pool* pool, pointwise* p)
{
    stp_laz_model_make(pool, &p->changed, 64);
    stp_laz_models_make(pool, p->angles, 2, 256);
    stp_laz_models_make(pool, p->returns, 256, 256);
    stp_laz_models_make(pool, p->classes, 256, 256);
    stp_laz_models_make(pool, p->users, 256, 256);
    stp_laz_models_make(pool, p->extra, 16, 256);
    stp_laz_integer_make(pool, &p->intensity, 16, 4);
    stp_laz_integer_make(pool, &p->source, 16, 1);
    stp_laz_integer_make(pool, &p->x, 32, 2);
    stp_laz_integer_make(pool, &p->y, 32, 22);
    stp_laz_integer_make(pool, &p->z, 32, 20);
    stp_laz_time_make(pool, &p->time, 1);
    stp_laz_rgb_make(pool, &p->rgb);
    stp_laz_model_make(pool, &p->wave.packet, 256);
    stp_laz_models_make(pool, p->wave.kinds, 4, 4);
    stp_laz_integer_make(pool, &p->wave.offset, 32, 1);
    stp_laz_integer_make(pool, &p->wave.size, 32, 1);
    stp_laz_integer_make(pool, &p->wave.place, 32, 1);
    stp_laz_integer_make(pool, &p->wave.direction, 32, 3);
}

static void put_values(laz_encoder* e, pointwise* p, const unsigned char* last,
                       const unsigned char* now, unsigned r, unsigned n)
{
    unsigned m = contexts[n][r];
    uint16_t intensity = (uint16_t)(now[12] | now[13] << 8);
    int source = now[18] | now[19] << 8, last_source = last[18] | last[19] << 8;
    bool new_bits = last[14] != now[14];
    bool new_intensity = p->intensities[m] != intensity;
    unsigned changed = (new_bits ? 32u : 0) | (new_intensity ? 16u : 0) |
                       (last[15] != now[15] ? 8u : 0) | (last[16] != now[16] ? 4u : 0) |
                       (last[17] != now[17] ? 2u : 0) | (source != last_source ? 1u : 0);
    laz_put_symbol(e, &p->changed, changed);
    if (new_bits) {
        laz_put_symbol(e, &p->returns[last[14]], now[14]);
    }
    if (new_intensity) {
        laz_put_integer(e, &p->intensity, p->intensities[m], intensity, m < 3 ? m : 3, 16);
        p->intensities[m] = intensity;
    }
    if (changed & 8) {
        laz_put_symbol(e, &p->classes[last[15]], now[15]);
    }
    if (changed & 4) {
        laz_put_symbol(e, &p->angles[now[14] >> 6 & 1], (unsigned)(now[16] - last[16]) & 255);
    }
    if (changed & 2) {
        laz_put_symbol(e, &p->users[last[17]], now[17]);
    }
    if (changed & 1) {
        laz_put_integer(e, &p->source, last_source, source, 0, 16);
    }
}

static void put_position(laz_encoder* e, pointwise* p, const las_point* last, const las_point* now,
                         unsigned r, unsigned n)
{
    unsigned m = contexts[n][r], single = n == 1, level = n > r ? n - r : r - n;
    int32_t dx = (int32_t)((uint32_t)now->position[0] - (uint32_t)last->position[0]);
    int32_t dy = (int32_t)((uint32_t)now->position[1] - (uint32_t)last->position[1]);
    laz_put_integer(e, &p->x, p->x_steps[m].values[2], dx, single, 32);
    stp_laz_median_add(&p->x_steps[m], dx);
    laz_put_integer(e, &p->y, p->y_steps[m].values[2], dy, single + laz_even(p->x.k, 20), 32);
    stp_laz_median_add(&p->y_steps[m], dy);
    laz_put_integer(e, &p->z, p->heights[level], now->position[2],
                    single + laz_even((p->x.k + p->y.k) / 2, 18), 32);
    p->heights[level] = now->position[2];
}

// Packets of every kind in turn; the values do not matter.
static void put_wave(laz_encoder* e, pointwise* p, size_t index)
{
    unsigned kind = (unsigned)(index % 4);
    laz_put_symbol(e, &p->wave.packet, (unsigned)(index & 255));
    laz_put_symbol(e, &p->wave.kinds[p->wave_kind], kind);
    p->wave_kind = kind;
    if (kind == 2) {
        laz_put_integer(e, &p->wave.offset, 0, (int32_t)index * 977, 0, 32);
    }
    for (unsigned i = 0; i < 4 && kind == 3; ++i) {
        laz_put_bits(e, (uint32_t)(index * 31 + i) & 0xFFFF, 16);
    }
    laz_put_integer(e, &p->wave.size, 0, (int32_t)index, 0, 32);
    laz_put_integer(e, &p->wave.place, 0, -(int32_t)index, 0, 32);
    for (unsigned i = 0; i < 3; ++i) {
        laz_put_integer(e, &p->wave.direction, 0, INT32_MIN, i, 32);
    }
}

void laz_write_pointwise(const las_desc* desc, size_t first, size_t count, las_buffer* out)
{
    unsigned char last[256], now[256];
    bool has_time = desc->format != 0 && desc->format != 2;
    bool has_rgb = desc->format == 2 || desc->format == 3 || desc->format == 5;
    assert(desc->format <= 5 && "newer formats are compressed in layers");
    assert(desc->extra <= 16 && "there is a model per extra byte");
    assert(count > 0 && first + count <= desc->count && "the chunk has points of the file");
    pointwise* p = calloc(1, sizeof(*p));
    stp_laz_pool pool = {0};
    make(&pool, p);
    pool = (stp_laz_pool){.bytes = calloc(1, pool.used)};
    unsigned char* numbers = pool.bytes;
    make(&pool, p);
    size_t size = las_write_record(desc, first, last);
    las_put(out, last, size);
    stp_laz_time_begin(&p->time, desc->points[first].time);
    laz_encoder e = laz_encoder_begin();
    for (size_t i = first + 1; i < first + count; ++i) {
        const las_point *a = &desc->points[i - 1], *b = &desc->points[i];
        las_write_record(desc, i, now);
        unsigned r = now[14] & 7, n = now[14] >> 3 & 7;
        put_values(&e, p, last, now, r, n);
        put_position(&e, p, a, b, r, n);
        if (has_time) {
            laz_put_time(&e, &p->time, b->time, 1);
        }
        if (has_rgb) {
            laz_put_rgb(&e, &p->rgb, a->rgb, b->rgb);
        }
        if (desc->format >= 4) {
            put_wave(&e, p, i);
        }
        for (size_t k = 0; k < desc->extra; ++k) {
            size_t at = size - desc->extra + k;
            laz_put_symbol(&e, &p->extra[k], (unsigned)(now[at] - last[at]) & 255);
        }
        memcpy(last, now, size);
    }
    laz_encoder_end(&e);
    las_put(out, e.out.bytes, e.out.size);
    free(e.out.bytes);
    free(numbers);
    free(p);
}
