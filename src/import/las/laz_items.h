// SPDX-License-Identifier: MIT
//
// Shared by both kinds of LAZ chunks: GPS times, colours, and the choice of models by the sizes of
// differences.
#pragma once

#include "import/las/laz_coder.h"

#include <assert.h>

enum {
    STP_LAZ_TIME_FACTORS = 511, ///< symbols of factors of the last difference: 0 to 500, -1 to -10
    STP_LAZ_TIME_LARGEST = 500,
    STP_LAZ_TIME_SMALLEST = -10,
    STP_LAZ_TIME_ATTEMPTS = 8 ///< changes of the sequence before one time; writers make one at most
};

/// Four sequences of times that grow by multiples of a difference.
typedef struct stp_laz_time {
    uint64_t times[4]; ///< bits of a double, which are added to as integers
    int32_t differences[4];
    uint32_t extremes[4]; ///< how often in a row no factor was near
    uint32_t last, next;
    stp_laz_model factor, start;
    stp_laz_integer integer;
} stp_laz_time;

/// `unchanged`: 1 if a symbol means that the time equals that of the last point (pointwise), else
/// 0.
static inline void stp_laz_time_make(stp_laz_pool* pool, stp_laz_time* t, unsigned unchanged)
{
    assert(unchanged <= 1);
    stp_laz_model_make(pool, &t->factor, STP_LAZ_TIME_FACTORS + 4 + unchanged);
    stp_laz_model_make(pool, &t->start, 5 + unchanged);
    stp_laz_integer_make(pool, &t->integer, 32, 9);
}

static inline void stp_laz_time_begin(stp_laz_time* t, uint64_t time)
{
    memset(t->times, 0, sizeof(t->times));
    memset(t->differences, 0, sizeof(t->differences));
    memset(t->extremes, 0, sizeof(t->extremes));
    t->last = t->next = 0;
    t->times[0] = time;
}

static inline void stp_laz_time_add(stp_laz_time* t, uint32_t difference)
{
    t->times[t->last] += (uint64_t)(int64_t)(int32_t)difference;
}

// A time far from all sequences starts a new one.
static inline void stp_laz_time_jump(stp_laz_decoder* d, stp_laz_time* t)
{
    uint32_t high = (uint32_t)(t->times[t->last] >> 32) + stp_laz_difference(d, &t->integer, 8);
    uint32_t low = stp_laz_few_bits(d, 16);
    low |= stp_laz_few_bits(d, 16) << 16;
    t->next = (t->next + 1) & 3;
    t->times[t->next] = (uint64_t)high << 32 | low;
    t->last = t->next;
    t->differences[t->last] = 0;
    t->extremes[t->last] = 0;
}

// The next time as a multiple of the last difference, with a correction.
static inline void stp_laz_time_multiply(stp_laz_decoder* d, stp_laz_time* t, int symbol)
{
    int factor = symbol <= STP_LAZ_TIME_LARGEST ? symbol : STP_LAZ_TIME_LARGEST - symbol;
    assert(factor >= STP_LAZ_TIME_SMALLEST && factor <= STP_LAZ_TIME_LARGEST);
    bool extreme = factor == 0 || factor == STP_LAZ_TIME_LARGEST || factor == STP_LAZ_TIME_SMALLEST;
    unsigned context = factor == 1                      ? 1
                       : factor == 0                    ? 7
                       : factor == STP_LAZ_TIME_LARGEST ? 4
                       : factor >= 10                   ? 3
                       : factor > 0                     ? 2
                       : extreme                        ? 6
                                                        : 5;
    uint32_t difference = (uint32_t)factor * (uint32_t)t->differences[t->last];
    difference += stp_laz_difference(d, &t->integer, context);
    stp_laz_time_add(t, difference);
    if (factor == 1) {
        t->extremes[t->last] = 0;
    } else if (extreme) {
        t->extremes[t->last] += 1;
        if (t->extremes[t->last] > 3) {
            t->differences[t->last] = (int32_t)difference;
            t->extremes[t->last] = 0;
        }
    }
}

/// The next time; takes at most 64 bytes.
static inline uint64_t stp_laz_time_next(stp_laz_decoder* d, stp_laz_time* t, unsigned unchanged)
{
    for (int i = 0; i < STP_LAZ_TIME_ATTEMPTS; ++i) {
        uint32_t symbol, jump; // symbols from `jump` on change the sequence
        assert(t->last < 4 && t->next < 4);
        if (t->differences[t->last] == 0) {
            symbol = stp_laz_symbol(d, &t->start);
            jump = 1 + unchanged;
            if (symbol + 1 == jump) {
                uint32_t difference = stp_laz_difference(d, &t->integer, 0);
                t->differences[t->last] = (int32_t)difference;
                t->extremes[t->last] = 0;
                stp_laz_time_add(t, difference);
            }
        } else {
            symbol = stp_laz_symbol(d, &t->factor);
            jump = STP_LAZ_TIME_FACTORS + unchanged;
            if (symbol < STP_LAZ_TIME_FACTORS) {
                stp_laz_time_multiply(d, t, (int)symbol);
            }
        }
        if (symbol == jump) {
            stp_laz_time_jump(d, t);
        }
        if (symbol <= jump) {
            return t->times[t->last];
        }
        t->last = (t->last + symbol - jump) & 3;
    }
    d->failed = true;
    return 0;
}

/// Which bytes of a colour change, and by how much.
typedef struct stp_laz_rgb {
    stp_laz_model used;     ///< bit 6: not grey
    stp_laz_model bytes[6]; ///< low and high byte of red, green, blue
} stp_laz_rgb;

static inline void stp_laz_rgb_make(stp_laz_pool* pool, stp_laz_rgb* rgb)
{
    stp_laz_model_make(pool, &rgb->used, 128);
    stp_laz_models_make(pool, rgb->bytes, 6, 256);
}

// A changed byte, decoded as the difference from the clamped `near`.
STP_LAZ_INLINE int stp_laz_byte(stp_laz_decoder* d, stp_laz_model* m, int near)
{
    assert(m->symbols == 256 && "a symbol per byte");
    int clamped = near < 0 ? 0 : near > 255 ? 255 : near;
    return ((int)stp_laz_symbol(d, m) + clamped) & 255;
}

/// The colour that follows `last`; takes at most 21 bytes.
STP_LAZ_INLINE void stp_laz_rgb_next(stp_laz_decoder* d, stp_laz_rgb* m, const uint16_t last[3],
                                     uint16_t next[3])
{
    unsigned used = stp_laz_symbol(d, &m->used);
    int before[3][2], now[3][2]; // low and high bytes
    for (int i = 0; i < 3; ++i) {
        before[i][0] = now[i][0] = last[i] & 255;
        before[i][1] = now[i][1] = last[i] >> 8;
    }
    for (int k = 0; k < 2; ++k) {
        if (used >> k & 1) {
            now[0][k] = stp_laz_byte(d, &m->bytes[k], before[0][k]);
        }
    }
    for (int k = 0; k < 2 && (used >> 6 & 1) != 0; ++k) {
        int step = now[0][k] - before[0][k];
        if (used >> (2 + k) & 1) {
            now[1][k] = stp_laz_byte(d, &m->bytes[2 + k], step + before[1][k]);
        }
        if (used >> (4 + k) & 1) {
            step = (step + now[1][k] - before[1][k]) / 2;
            now[2][k] = stp_laz_byte(d, &m->bytes[4 + k], step + before[2][k]);
        }
    }
    bool grey = (used >> 6 & 1) == 0;
    for (int i = 0; i < 3; ++i) {
        int of = grey ? 0 : i;
        next[i] = (uint16_t)(now[of][0] | now[of][1] << 8);
    }
}

/// Context of y by the size of x's difference, and of z by both: even sizes up to `maximum`.
static inline unsigned stp_laz_size_context(uint32_t k, uint32_t maximum)
{
    return k < maximum ? k & ~1u : maximum;
}
