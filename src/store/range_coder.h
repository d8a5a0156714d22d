// SPDX-License-Identifier: MIT
//
// A binary arithmetic coder whose probabilities follow what was coded (docs/format.md, Operators).
// One function codes a bit in both directions, so that a reader and a writer of a format are one
// text. After Martin. Range encoding: an algorithm for removing redundancy from a digitised
// message. 1979.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    STP_BIT_SETTLED = 60, ///< after so many bits, a probability follows at a constant rate
    STP_BIT_EVEN = 0x8000,
};

/// The probability that a bit is 0, of 2^16, and how many bits it is based on.
typedef struct stp_bit_model {
    uint16_t zero, seen;
} stp_bit_model;

typedef struct stp_range_coder {
    bool encoding;
    bool failed;          ///< encoding: out of room
    uint32_t range, code; ///< code: of the bytes read
    uint64_t low;         ///< encoding
    uint64_t held; ///< encoding: bytes that a carry may still change: one, then so many of 0xFF
    uint8_t first_held;
    const unsigned char* input;
    unsigned char* output;
    size_t size,
        at; ///< bytes there are, or room; bytes used. A decoder may pass the end, where it reads zeros
} stp_range_coder;

void stp_range_encode_begin(stp_range_coder* coder, unsigned char* output, size_t room);
/// Ends what was encoded. @return its bytes; 0 if there was not enough room
size_t stp_range_encode_end(stp_range_coder* coder);
void stp_range_decode_begin(stp_range_coder* coder, const unsigned char* input, size_t size);
/// Whether what was decoded ends where an encoder ended it, and only zeros follow.
bool stp_range_decode_ends_well(const stp_range_coder* coder);

void stp_range_put_byte(stp_range_coder* coder);

static inline void stp_range_normalize(stp_range_coder* c)
{
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

/// The range of a bit 0 is `bound`. @return the bit, which is `bit` where the coder encodes
static inline uint32_t stp_range_code_split(stp_range_coder* c, uint32_t bound, uint32_t bit)
{
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

/// Codes a bit by a model, which learns it.
static inline uint32_t stp_range_code_bit(stp_range_coder* c, stp_bit_model* model, uint32_t bit)
{
    uint32_t share = model->zero >> 4;
    bit = stp_range_code_split(c, (c->range >> 12) * (share > 0 ? share : 1), bit);
    uint32_t part = 2u * model->seen + 3u; // twice the bits seen, and 1.5 more
    model->zero = (uint16_t)(bit == 0 ? model->zero + 2u * (65535u - model->zero) / part
                                      : model->zero - 2u * model->zero / part);
    model->seen = (uint16_t)(model->seen + (model->seen < STP_BIT_SETTLED ? 1u : 0u));
    return bit;
}

/// Codes `count` bits, at most 16, that are as likely 0 as 1; the highest first.
static inline uint32_t stp_range_code_plain(stp_range_coder* c, uint32_t count, uint32_t value)
{
    uint32_t made = 0;
    for (uint32_t i = count; i-- > 0;) {
        made = made << 1 | stp_range_code_split(c, c->range >> 1, value >> i & 1u);
    }
    return made;
}
