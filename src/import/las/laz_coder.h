// SPDX-License-Identifier: MIT
//
// The arithmetic decoder of LAZ: adaptive models of symbols and bits, and differences of integers
// made of them. All of it is inlined into the loops over points: a decoder that is a local variable
// stays in registers.
//
// Method: A. Said, Introduction to Arithmetic Coding, Theory and Practice, HPL-2004-76 (periodic
// updates, decoding by table). The constants, the order of updates and the integer differences are
// those of LASzip files.
//
// The state is an interval [0, length) and a `value` in it. A symbol takes a part of the interval
// in proportion to its share of 32768; the last symbol takes the rest. For any input, value <
// length holds after each step, and no symbol takes more than three bytes, so bounds are checked
// once for many symbols (stp_laz_ensure).
#pragma once

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/// Function calls would move the decoder from registers to memory; inlining makes it 1.5 times as
/// fast.
#define STP_LAZ_INLINE static inline __attribute__((always_inline))

enum {
    STP_LAZ_TAIL = 1024,      ///< bytes of the buffer in which the end of the input is read
    STP_LAZ_MAX_ENSURED = 512 ///< maximum bytes per stp_laz_ensure
};

typedef struct stp_laz_decoder {
    const unsigned char *at, *end; ///< readable range
    const unsigned char* last;     ///< end of the input; in the tail, of its copy there
    unsigned char* tail;           ///< STP_LAZ_TAIL bytes
    uint32_t value, length;
    uint32_t epoch; ///< models of another epoch are reset before use
    bool failed;    ///< read past the end, or invalid data
} stp_laz_decoder;

/// Counts of symbols, their cumulative shares, and a table that finds the symbol of a share.
typedef struct stp_laz_model {
    uint16_t* shares; ///< symbols + 1: the last is above every share
    uint16_t* counts; ///< symbols
    uint16_t* table;  ///< initial guess for each range of shares
    uint32_t left;    ///< symbols until shares are recomputed
    uint32_t cycle, total, epoch;
    uint16_t symbols;
    uint8_t shift; ///< shift from a share to its table index
} stp_laz_model;

typedef struct stp_laz_bit {
    uint32_t zero_share, zero_count, count, cycle, left;
    uint32_t epoch;
} stp_laz_bit;

enum { STP_LAZ_HIGH_BITS = 8, STP_LAZ_MAX_BITS = 32, STP_LAZ_MAX_CONTEXTS = 22 };

/// Decodes differences of 16- or 32-bit integers from their predictions. The size k comes first, by
/// context.
typedef struct stp_laz_integer {
    stp_laz_model sizes[STP_LAZ_MAX_CONTEXTS];
    stp_laz_model corrections[STP_LAZ_MAX_BITS]; ///< by k, from 1 on
    stp_laz_bit bit;                             ///< k = 0: 0 or 1
    uint32_t k;                                  ///< size of the difference decoded last
} stp_laz_integer;

/// Allocates the numbers of models. If `bytes` is NULL, it only counts them: models are made twice.
typedef struct stp_laz_pool {
    unsigned char* bytes;
    size_t used;
} stp_laz_pool;

void stp_laz_model_make(stp_laz_pool* pool, stp_laz_model* model, unsigned symbols);
void stp_laz_models_make(stp_laz_pool* pool, stp_laz_model* models, size_t count, unsigned symbols);
/// `bits`: 16 or 32.
void stp_laz_integer_make(stp_laz_pool* pool, stp_laz_integer* integer, unsigned bits,
                          unsigned contexts);

/// Makes all symbols equally likely.
void stp_laz_model_reset(stp_laz_model* model, uint32_t epoch);
/// Recomputes the shares from the counts.
void stp_laz_model_update(stp_laz_model* model);
void stp_laz_bit_reset(stp_laz_bit* bit, uint32_t epoch);
void stp_laz_bit_update(stp_laz_bit* bit);

/// A decoder over [bytes, bytes + size). `tail`: STP_LAZ_TAIL bytes that live as long as it.
stp_laz_decoder stp_laz_decoder_begin(const unsigned char* bytes, size_t size, unsigned char* tail,
                                      uint32_t epoch);
/// Copies the rest of the input to the tail and appends zeros. Fails beyond that.
stp_laz_decoder stp_laz_refill(stp_laz_decoder decoder);

/// Whether the input was valid so far.
static inline bool stp_laz_is_good(const stp_laz_decoder* d)
{
    return !d->failed && d->at <= d->last;
}

/// Ensures that `bytes` can be read without further checks: three per symbol, and four for reading
/// ahead, which the caller includes.
STP_LAZ_INLINE void stp_laz_ensure(stp_laz_decoder* d, size_t bytes)
{
    assert(bytes >= 4 && bytes <= STP_LAZ_MAX_ENSURED);
    if ((size_t)(d->end - d->at) < bytes) {
        *d = stp_laz_refill(*d);
    }
}

STP_LAZ_INLINE void stp_laz_renormalise(stp_laz_decoder* d)
{
    assert(d->length > 0 && d->value < d->length);
    unsigned shift = (unsigned)__builtin_clz(d->length) & 24u;
    uint32_t next;
    memcpy(&next, d->at, 4);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    next = __builtin_bswap32(next);
#endif
    d->value = (uint32_t)(((uint64_t)d->value << 32 | next) << shift >> 32);
    d->length <<= shift;
    d->at += shift >> 3;
}

STP_LAZ_INLINE uint32_t stp_laz_symbol(stp_laz_decoder* d, stp_laz_model* m)
{
    if (m->epoch != d->epoch) {
        stp_laz_model_reset(m, d->epoch);
    }
    uint32_t unit = d->length >> 15;
    uint32_t share = d->value / unit;
    uint32_t symbol = m->table[share >> m->shift];
    while (m->shares[symbol + 1] <= share) {
        symbol += 1;
    }
    assert(symbol < m->symbols && m->shares[symbol] <= share);
    uint32_t low = m->shares[symbol] * unit, high = m->shares[symbol + 1] * unit;
    high = symbol + 1u == m->symbols ? d->length : high;
    d->value -= low;
    d->length = high - low;
    stp_laz_renormalise(d);
    m->counts[symbol] = (uint16_t)(m->counts[symbol] + 1);
    m->left -= 1;
    if (m->left == 0) {
        stp_laz_model_update(m);
    }
    return symbol;
}

STP_LAZ_INLINE uint32_t stp_laz_bit_symbol(stp_laz_decoder* d, stp_laz_bit* m)
{
    if (m->epoch != d->epoch) {
        stp_laz_bit_reset(m, d->epoch);
    }
    uint32_t low = m->zero_share * (d->length >> 13);
    bool one = d->value >= low;
    d->value -= one ? low : 0;
    d->length = one ? d->length - low : low;
    m->zero_count += !one;
    stp_laz_renormalise(d);
    m->left -= 1;
    if (m->left == 0) {
        stp_laz_bit_update(m);
    }
    return one;
}

/// 1 to 19 equally likely bits.
STP_LAZ_INLINE uint32_t stp_laz_few_bits(stp_laz_decoder* d, unsigned bits)
{
    assert(bits >= 1 && bits <= 19);
    d->length >>= bits;
    uint32_t value = d->value / d->length;
    d->value -= value * d->length;
    stp_laz_renormalise(d);
    return value;
}

STP_LAZ_INLINE uint32_t stp_laz_raw_bits(stp_laz_decoder* d, unsigned bits)
{
    if (bits <= 19) {
        return stp_laz_few_bits(d, bits);
    }
    uint32_t low = stp_laz_few_bits(d, 16);
    return low | stp_laz_few_bits(d, bits - 16) << 16;
}

/// The difference that was decoded, as a number to be added modulo 2^32 (or 2^16).
STP_LAZ_INLINE uint32_t stp_laz_difference(stp_laz_decoder* d, stp_laz_integer* m, unsigned context)
{
    assert(context < STP_LAZ_MAX_CONTEXTS);
    uint32_t k = stp_laz_symbol(d, &m->sizes[context]);
    m->k = k;
    if (k == 0) {
        return stp_laz_bit_symbol(d, &m->bit);
    }
    if (k >= STP_LAZ_MAX_BITS) {
        return (uint32_t)1 << 31;
    }
    uint32_t c = stp_laz_symbol(d, &m->corrections[k]);
    if (k > STP_LAZ_HIGH_BITS) {
        unsigned low_bits = k - STP_LAZ_HIGH_BITS;
        c = c << low_bits | stp_laz_raw_bits(d, low_bits);
    }
    // the upper half stands for 2^(k-1) + 1 to 2^k, the lower for -(2^k - 1) to -2^(k-1)
    return c >> (k - 1) != 0 ? c + 1 : c - ((uint32_t)1 << k) + 1;
}

/// Approximate median of five recent values: each new value replaces the largest or the smallest.
typedef struct stp_laz_median {
    int32_t values[5];  ///< in order
    uint32_t drops_low; ///< 1: the next value takes the place of the smallest
} stp_laz_median;

static inline int32_t stp_laz_smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t stp_laz_larger(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

STP_LAZ_INLINE void stp_laz_median_add(stp_laz_median* m, int32_t v)
{
    int32_t middle = m->values[2];
    uint32_t low = m->drops_low;
    int32_t a = m->values[low], b = m->values[low + 1], c = m->values[low + 2],
            d = m->values[low + 3];
    m->drops_low = low != 0 ? v > middle : v >= middle;
    m->values[0] = stp_laz_smaller(a, v);
    m->values[1] = stp_laz_larger(a, stp_laz_smaller(b, v));
    m->values[2] = stp_laz_larger(b, stp_laz_smaller(c, v));
    m->values[3] = stp_laz_larger(c, stp_laz_smaller(d, v));
    m->values[4] = stp_laz_larger(d, v);
    assert(m->values[0] <= m->values[1] && m->values[1] <= m->values[2]);
    assert(m->values[2] <= m->values[3] && m->values[3] <= m->values[4]);
}
