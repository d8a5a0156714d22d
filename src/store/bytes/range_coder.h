// SPDX-License-Identifier: MIT
//
// An adaptive binary arithmetic coder (docs/format.md, Operators). One function codes a bit in both
// directions, so reader and writer of a format share their code. After Martin. Range encoding: an
// algorithm for removing redundancy from a digitised message. 1979.
#pragma once

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    STP_BIT_SETTLED = 60, ///< from this many bits on, a probability adapts at a constant rate
    STP_BIT_EVEN = 0x8000,
};

/// The probability that a bit is 0, in units of 2^-16, and the number of bits seen.
typedef struct stp_bit_model {
    uint16_t zero, seen;
} stp_bit_model;

typedef struct stp_range_coder {
    bool encoding;
    bool failed;          ///< encoding: no room left
    uint32_t range, code; ///< code: value of the bytes read
    uint64_t low;         ///< encoding
    uint64_t held; ///< encoding: bytes that a carry may still change: one byte, then a run of 0xFF
    uint8_t first_held;
    const unsigned char* input;
    unsigned char* output;
    size_t size,
        at; ///< bytes available or room; bytes used. A decoder reads zeros past the end
} stp_range_coder;

void stp_range_encode_begin(stp_range_coder* coder, unsigned char* output, size_t room);
/// Finishes encoding. @return the size in bytes; 0 if there was not enough room
size_t stp_range_encode_end(stp_range_coder* coder);
void stp_range_decode_begin(stp_range_coder* coder, const unsigned char* input, size_t size);
/// Whether the decoder ended where the encoder did, followed only by zeros.
bool stp_range_decode_ends_well(const stp_range_coder* coder);

void stp_range_put_byte(stp_range_coder* coder);

static inline void stp_range_normalize(stp_range_coder* c)
{
    assert(c->range != 0 && "or the loop would not end");
    while (c->range < 1u << 24) {
        c->range <<= 8;
        if (c->encoding) {
            stp_range_put_byte(c);
        } else {
            c->code = c->code << 8 | (c->at < c->size ? c->input[c->at] : 0u);
            c->at += 1;
        }
    }
}

/// A bit of 0 takes the range `bound`. @return the bit; when encoding, it is `bit`
static inline uint32_t stp_range_code_split(stp_range_coder* c, uint32_t bound, uint32_t bit)
{
    assert(bound > 0 && bound < c->range);
    if (!c->encoding) {
        bit = c->code >= bound ? 1 : 0;
        c->code -= bit != 0 ? bound : 0;
    } else if (bit != 0) {
        c->low += bound;
    }
    c->range = bit != 0 ? c->range - bound : bound;
    stp_range_normalize(c);
    return bit;
}

/// Codes a bit with a model and updates the model.
static inline uint32_t stp_range_code_bit(stp_range_coder* c, stp_bit_model* model, uint32_t bit)
{
    assert(model->seen <= STP_BIT_SETTLED);
    uint32_t share = model->zero >> 4;
    bit = stp_range_code_split(c, (c->range >> 12) * (share > 0 ? share : 1), bit);
    uint32_t part = 2u * model->seen + 3u; // 2 (bits seen + 1.5)
    model->zero = (uint16_t)(bit == 0 ? model->zero + 2u * (65535u - model->zero) / part
                                      : model->zero - 2u * model->zero / part);
    model->seen = (uint16_t)(model->seen + (model->seen < STP_BIT_SETTLED ? 1u : 0u));
    return bit;
}

/// Codes `count` bits (at most 16) with equal probabilities, highest first.
static inline uint32_t stp_range_code_plain(stp_range_coder* c, uint32_t count, uint32_t value)
{
    assert(count <= 16 && value >> count == 0);
    uint32_t made = 0;
    for (uint32_t i = count; i-- > 0;) {
        made = made << 1 | stp_range_code_split(c, c->range >> 1, value >> i & 1u);
    }
    return made;
}
