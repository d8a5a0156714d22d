// SPDX-License-Identifier: MIT
// LAZ chunks of formats 0 to 5: one stream with all items of each point in turn. Items that are not
// kept (user data, wave packets, extra bytes) must be decoded, too.
#include "import/las/laz.h"
#include "import/las/laz_items.h"

#include <assert.h>

enum {
    POINT_BYTES = 384, // upper bound for the items of a point, without extra bytes
    BYTE_RUN = 64,     // extra bytes between two bounds checks
    CLASS_MASK = 31,
    // which values change
    NEW_SOURCE = 1,
    NEW_USER = 2,
    NEW_ANGLE = 4,
    NEW_CLASS = 8,
    NEW_INTENSITY = 16,
    NEW_RETURNS = 32
};

// Wave packets: decoded only to stay in sync.
typedef struct wave_models {
    stp_laz_model packet, kinds[4];
    stp_laz_integer offset, size, place, direction;
    uint32_t kind;
} wave_models;

// The last point, and predictions for the next one.
typedef struct last_point {
    int32_t position[3];
    uint8_t bits, class_byte, angle, user; // as the file has them
    uint16_t intensity, source, color[3];
    uint16_t intensities[16];
    int32_t heights[8];
    stp_laz_median x_steps[16], y_steps[16];
} last_point;

struct stp_laz_pointwise {
    stp_laz_decoder decoder;
    stp_laz_model changed, angles[2], returns[256], classes[256], users[256];
    stp_laz_integer intensity, source, x, y, z;
    stp_laz_time time;
    stp_laz_rgb rgb;
    wave_models wave;
    stp_laz_model* extra;
    size_t extra_count;
    last_point last;
    unsigned char tail[STP_LAZ_TAIL];
};

// Contexts by number of returns and return number; the pairs that should not be are there, too.
static const uint8_t return_contexts[8][8] = {
    {15, 14, 13, 12, 11, 10, 9, 8},  {14, 0, 1, 3, 6, 10, 10, 9},
    {13, 1, 2, 4, 7, 11, 11, 10},    {12, 3, 4, 5, 8, 12, 12, 11},
    {11, 6, 7, 8, 9, 13, 13, 12},    {10, 10, 11, 12, 13, 14, 14, 13},
    {9, 10, 11, 12, 13, 14, 15, 14}, {8, 9, 10, 11, 12, 13, 14, 15},
};

void stp_laz_pointwise_make(stp_laz_pool* pool, stp_laz_pointwise* p)
{
    stp_laz_model_make(pool, &p->changed, 64);
    stp_laz_models_make(pool, p->angles, 2, 256);
    stp_laz_models_make(pool, p->returns, 256, 256);
    stp_laz_models_make(pool, p->classes, 256, 256);
    stp_laz_models_make(pool, p->users, 256, 256);
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
    stp_laz_models_make(pool, p->extra, p->extra_count, 256);
}

stp_laz_pointwise* stp_laz_pointwise_create(const stp_las* las)
{
    stp_laz_pointwise* p = STP_NEW_ZEROED(las->context, stp_laz_pointwise, 1);
    if (p == NULL) {
        return NULL;
    }
    assert(las->record_size >= las->layout.size && las->format < 6);
    p->extra_count = las->record_size - las->layout.size;
    p->extra = STP_NEW_ZEROED(las->context, stp_laz_model, p->extra_count + 1);
    if (p->extra == NULL) {
        stp_free(las->context, p);
        return NULL;
    }
    return p;
}

void stp_laz_pointwise_destroy(const stp_las* las, stp_laz_pointwise* p)
{
    if (p != NULL) {
        stp_free(las->context, p->extra);
        stp_free(las->context, p);
    }
}

bool stp_laz_pointwise_begin(stp_laz* laz, const stp_las_block* block, const unsigned char* raw,
                             const unsigned char* bytes, size_t size)
{
    stp_laz_pointwise* p = laz->pointwise;
    last_point* last = &p->last;
    p->decoder = stp_laz_decoder_begin(bytes, size, p->tail, laz->epoch);
    memset(last, 0, sizeof(*last)); // its intensity, too
    for (int i = 0; i < 3; ++i) {
        last->position[i] = block->position[i][0];
        last->color[i] = block->rgb[i][0];
    }
    last->bits = raw[14];
    last->class_byte = raw[15];
    last->angle = raw[16];
    last->user = raw[17];
    last->source = block->source[0];
    stp_laz_time_begin(&p->time, block->time[0]);
    p->wave.kind = 0;
    return true;
}

// Values that change rarely.
STP_LAZ_INLINE void next_values(stp_laz_decoder* d, stp_laz_pointwise* p, last_point* last,
                                unsigned changed)
{
    if (changed & NEW_RETURNS) {
        last->bits = (uint8_t)stp_laz_symbol(d, &p->returns[last->bits]);
    }
    unsigned context = return_contexts[last->bits >> 3 & 7][last->bits & 7];
    if (changed & NEW_INTENSITY) {
        uint32_t step = stp_laz_difference(d, &p->intensity, context < 3 ? context : 3);
        last->intensities[context] = (uint16_t)(last->intensities[context] + step);
    }
    last->intensity = last->intensities[context];
    if (changed & NEW_CLASS) {
        last->class_byte = (uint8_t)stp_laz_symbol(d, &p->classes[last->class_byte]);
    }
    if (changed & NEW_ANGLE) {
        uint32_t step = stp_laz_symbol(d, &p->angles[last->bits >> 6 & 1]);
        last->angle = (uint8_t)(last->angle + step);
    }
    if (changed & NEW_USER) {
        last->user = (uint8_t)stp_laz_symbol(d, &p->users[last->user]);
    }
    if (changed & NEW_SOURCE) {
        last->source = (uint16_t)(last->source + stp_laz_difference(d, &p->source, 0));
    }
}

STP_LAZ_INLINE void next_position(stp_laz_decoder* d, stp_laz_pointwise* p, last_point* last)
{
    unsigned n = last->bits >> 3 & 7, r = last->bits & 7;
    unsigned context = return_contexts[n][r], level = n > r ? n - r : r - n, single = n == 1;
    assert(context < 16 && level < sizeof(last->heights) / sizeof(last->heights[0]));
    stp_laz_median *x_steps = &last->x_steps[context], *y_steps = &last->y_steps[context];
    uint32_t step = (uint32_t)x_steps->values[2] + stp_laz_difference(d, &p->x, single);
    last->position[0] = (int32_t)((uint32_t)last->position[0] + step);
    stp_laz_median_add(x_steps, (int32_t)step);
    step = (uint32_t)y_steps->values[2] +
           stp_laz_difference(d, &p->y, single + stp_laz_size_context(p->x.k, 20));
    last->position[1] = (int32_t)((uint32_t)last->position[1] + step);
    stp_laz_median_add(y_steps, (int32_t)step);
    unsigned size = single + stp_laz_size_context((p->x.k + p->y.k) / 2, 18);
    step = stp_laz_difference(d, &p->z, size);
    last->position[2] = (int32_t)((uint32_t)last->heights[level] + step);
    last->heights[level] = last->position[2];
}

static void skip_wave(stp_laz_decoder* d, wave_models* w)
{
    (void)stp_laz_symbol(d, &w->packet);
    assert(w->kind < 4);
    w->kind = stp_laz_symbol(d, &w->kinds[w->kind]);
    if (w->kind == 2) {
        (void)stp_laz_difference(d, &w->offset, 0);
    }
    for (int i = 0; i < 4 && w->kind == 3; ++i) { // 64 bits
        (void)stp_laz_few_bits(d, 16);
    }
    (void)stp_laz_difference(d, &w->size, 0);
    (void)stp_laz_difference(d, &w->place, 0);
    for (unsigned i = 0; i < 3; ++i) {
        (void)stp_laz_difference(d, &w->direction, i);
    }
}

static void skip_extra(stp_laz_decoder* d, stp_laz_pointwise* p)
{
    for (size_t i = 0; i < p->extra_count; ++i) {
        if (i % BYTE_RUN == 0) {
            stp_laz_ensure(d, 3 * BYTE_RUN + 4);
        }
        (void)stp_laz_symbol(d, &p->extra[i]);
    }
}

static uint64_t next_time(stp_laz_pointwise* p)
{
    return stp_laz_time_next(&p->decoder, &p->time, 1);
}

static void skip_rest(stp_laz_pointwise* p, bool wave)
{
    if (wave) {
        skip_wave(&p->decoder, &p->wave);
    }
    skip_extra(&p->decoder, p);
}

bool stp_laz_pointwise_next(stp_laz* laz, size_t first, size_t count, stp_las_block* block)
{
    stp_laz_pointwise* p = laz->pointwise;
    assert(first + count <= STP_LAS_BLOCK);
    stp_laz_decoder d = p->decoder;
    last_point* last = &p->last;
    bool has_time = laz->las->layout.time != STP_LAS_NO_FIELD;
    bool has_rgb = laz->las->layout.rgb != STP_LAS_NO_FIELD;
    bool has_wave = laz->las->layout.wave != STP_LAS_NO_FIELD;
    bool has_rest = has_wave || p->extra_count > 0;
    for (size_t i = first; i < first + count; ++i) {
        stp_laz_ensure(&d, POINT_BYTES);
        unsigned changed = stp_laz_symbol(&d, &p->changed);
        if (changed != 0) {
            next_values(&d, p, last, changed);
        }
        next_position(&d, p, last);
        for (int k = 0; k < 3; ++k) {
            block->position[k][i] = last->position[k];
        }
        block->intensity[i] = last->intensity;
        block->return_number[i] = last->bits & 7;
        block->return_count[i] = last->bits >> 3 & 7;
        block->classes[i] = last->class_byte & CLASS_MASK;
        block->angle[i] = stp_las_angle((int8_t)last->angle);
        block->source[i] = last->source;
        if (has_time) {
            p->decoder = d;
            block->time[i] = next_time(p);
            d = p->decoder;
        }
        if (has_rgb) {
            uint16_t next[3];
            stp_laz_rgb_next(&d, &p->rgb, last->color, next);
            for (int k = 0; k < 3; ++k) {
                block->rgb[k][i] = last->color[k] = next[k];
            }
        }
        if (has_rest) {
            p->decoder = d;
            skip_rest(p, has_wave);
            d = p->decoder;
        }
    }
    p->decoder = d;
    return stp_laz_is_good(&d);
}
