// SPDX-License-Identifier: MIT
//
// The arithmetic encoder of LAZ, for tests. It shares the decoder's models but implements their use
// independently.
#pragma once

#include "las_writer.h"

#include "import/las/laz_items.h"

#include <assert.h>
#include <stdlib.h>

typedef struct laz_encoder {
    las_buffer out;
    uint32_t base, length;
} laz_encoder;

static inline laz_encoder laz_encoder_begin(void)
{
    return (laz_encoder){.length = UINT32_MAX};
}

// Selects the interval's part [low, low + length). A carry propagates back through the bytes.
static inline void laz_narrow(laz_encoder* e, uint32_t low, uint32_t length)
{
    uint32_t before = e->base;
    e->base += low;
    e->length = length;
    for (size_t i = e->out.size; e->base < before && i-- > 0;) {
        e->out.bytes[i] += 1;
        if (e->out.bytes[i] != 0) {
            break;
        }
    }
    while (e->length < 1u << 24) {
        unsigned char top = (unsigned char)(e->base >> 24);
        las_put(&e->out, &top, 1);
        e->base <<= 8;
        e->length <<= 8;
    }
}

static inline void laz_put_symbol(laz_encoder* e, stp_laz_model* m, unsigned symbol)
{
    if (m->epoch != 1) {
        stp_laz_model_reset(m, 1);
    }
    assert(symbol < m->symbols && "the model has the symbol");
    uint32_t unit = e->length >> 15, low = m->shares[symbol] * unit;
    bool last = symbol + 1u == m->symbols;
    laz_narrow(e, low, (last ? e->length : m->shares[symbol + 1] * unit) - low);
    m->counts[symbol] += 1;
    m->left -= 1;
    if (m->left == 0) {
        stp_laz_model_update(m);
    }
}

static inline void laz_put_bit(laz_encoder* e, stp_laz_bit* m, unsigned bit)
{
    if (m->epoch != 1) {
        stp_laz_bit_reset(m, 1);
    }
    uint32_t low = m->zero_share * (e->length >> 13);
    m->zero_count += bit == 0;
    laz_narrow(e, bit ? low : 0, bit ? e->length - low : low);
    m->left -= 1;
    if (m->left == 0) {
        stp_laz_bit_update(m);
    }
}

static inline void laz_put_bits(laz_encoder* e, uint32_t value, unsigned bits)
{
    if (bits > 19) {
        laz_put_bits(e, value & 0xFFFF, 16);
        value >>= 16;
        bits -= 16;
    }
    assert(value >> bits == 0 && "the value fits into its bits");
    uint32_t unit = e->length >> bits;
    laz_narrow(e, value * unit, unit);
}

/// Encodes the difference of `value` from `expected`, modulo 2^bits.
static inline void laz_put_integer(laz_encoder* e, stp_laz_integer* m, int32_t expected,
                                   int32_t value, unsigned context, unsigned bits)
{
    int64_t c = bits == 16 ? (int16_t)(uint16_t)(value - expected)
                           : (int32_t)((uint32_t)value - (uint32_t)expected);
    uint64_t size = (uint64_t)(c <= 0 ? -c : c - 1);
    unsigned k = 0;
    while (size >> k != 0) {
        k += 1;
    }
    m->k = k;
    laz_put_symbol(e, &m->sizes[context], k);
    if (k == 0) {
        laz_put_bit(e, &m->bit, (unsigned)c);
        return;
    }
    if (k == 32) {
        return;
    }
    uint32_t code = (uint32_t)(c < 0 ? c + ((int64_t)1 << k) - 1 : c - 1);
    unsigned low = k > 8 ? k - 8 : 0;
    laz_put_symbol(e, &m->corrections[k], code >> low);
    if (low > 0) {
        laz_put_bits(e, code & ((1u << low) - 1), low);
    }
}

/// Ends the stream with bytes that the decoder reads ahead.
static inline void laz_encoder_end(laz_encoder* e)
{
    for (int i = 0; i < 4; ++i) {
        unsigned char top = (unsigned char)(e->base >> 24);
        las_put(&e->out, &top, 1);
        e->base <<= 8;
    }
}

static inline bool laz_fits(int64_t value)
{
    return value >= INT32_MIN && value <= INT32_MAX;
}

// A time that this sequence reaches by 32 bits.
static inline void laz_put_near_time(laz_encoder* e, stp_laz_time* t, int32_t step,
                                     unsigned unchanged)
{
    int32_t* d = &t->differences[t->last];
    if (*d == 0) {
        laz_put_symbol(e, &t->start, unchanged);
        laz_put_integer(e, &t->integer, 0, step, 0, 32);
        *d = step;
        t->extremes[t->last] = 0;
        return;
    }
    int64_t factor = (int64_t)((double)step / *d + (step / *d < 0 ? -0.5 : 0.5));
    factor = factor > 500 ? 500 : factor < -10 ? -10 : factor;
    bool extreme = factor == 0 || factor == 500 || factor == -10;
    unsigned context = factor == 1    ? 1
                       : factor == 0  ? 7
                       : factor < -9  ? 6
                       : factor < 0   ? 5
                       : factor < 10  ? 2
                       : factor < 500 ? 3
                                      : 4;
    laz_put_symbol(e, &t->factor, (unsigned)(factor >= 0 ? factor : 500 - factor));
    laz_put_integer(e, &t->integer, (int32_t)((uint32_t)factor * (uint32_t)*d), step, context, 32);
    t->extremes[t->last] = factor == 1 ? 0 : t->extremes[t->last] + extreme;
    if (t->extremes[t->last] > 3 && extreme) {
        t->extremes[t->last] = 0;
        *d = step;
    }
}

static inline void laz_put_time(laz_encoder* e, stp_laz_time* t, uint64_t time, unsigned unchanged)
{
    unsigned jump = t->differences[t->last] == 0 ? 1 + unchanged : 511 + unchanged;
    stp_laz_model* m = t->differences[t->last] == 0 ? &t->start : &t->factor;
    int64_t step = (int64_t)(time - t->times[t->last]);
    if (unchanged != 0 && step == 0) {
        laz_put_symbol(e, m, jump == 2 ? 0 : 511);
        return;
    }
    if (laz_fits(step)) {
        laz_put_near_time(e, t, (int32_t)step, unchanged);
        t->times[t->last] = time;
        return;
    }
    for (unsigned i = 1; i < 4; ++i) {
        if (laz_fits((int64_t)(time - t->times[(t->last + i) & 3]))) {
            laz_put_symbol(e, m, jump + i);
            t->last = (t->last + i) & 3;
            laz_put_time(e, t, time, unchanged);
            return;
        }
    }
    laz_put_symbol(e, m, jump);
    laz_put_integer(e, &t->integer, (int32_t)(t->times[t->last] >> 32), (int32_t)(time >> 32), 8,
                    32);
    laz_put_bits(e, time & 0xFFFF, 16);
    laz_put_bits(e, time >> 16 & 0xFFFF, 16);
    t->next = t->last = (t->next + 1) & 3;
    t->times[t->last] = time;
    t->differences[t->last] = 0;
    t->extremes[t->last] = 0;
}

static inline unsigned laz_byte_from(int value, int near)
{
    return (unsigned)(value - (near < 0 ? 0 : near > 255 ? 255 : near)) & 255;
}

static inline void laz_put_rgb(laz_encoder* e, stp_laz_rgb* m, const uint16_t last[3],
                               const uint16_t now[3])
{
    bool grey = now[0] == now[1] && now[0] == now[2];
    int a[3][2], b[3][2]; // before and now, low and high
    unsigned used = grey ? 0 : 64;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 2; ++k) {
            a[i][k] = last[i] >> (8 * k) & 255;
            b[i][k] = now[i] >> (8 * k) & 255;
            used |= a[i][k] != b[i][k] && (i == 0 || !grey) ? 1u << (2 * i + k) : 0;
        }
    }
    laz_put_symbol(e, &m->used, used);
    for (int k = 0; k < 2; ++k) {
        if (used >> k & 1) {
            laz_put_symbol(e, &m->bytes[k], laz_byte_from(b[0][k], a[0][k]));
        }
    }
    for (int k = 0; k < 2; ++k) {
        int step = b[0][k] - a[0][k];
        if (used >> (2 + k) & 1) {
            laz_put_symbol(e, &m->bytes[2 + k], laz_byte_from(b[1][k], step + a[1][k]));
        }
        if (used >> (4 + k) & 1) {
            step = (step + b[1][k] - a[1][k]) / 2;
            laz_put_symbol(e, &m->bytes[4 + k], laz_byte_from(b[2][k], step + a[2][k]));
        }
    }
}

static inline unsigned laz_even(unsigned k, unsigned maximum)
{
    return k < maximum ? k & ~1u : maximum;
}
