// SPDX-License-Identifier: MIT
#include "store/bytes/range_coder.h"

#include <assert.h>

enum { CODE_BYTES = 4 };

static void emit(stp_range_coder* c, uint32_t byte)
{
    if (c->at < c->size) {
        c->output[c->at] = (unsigned char)byte;
    } else {
        c->failed = true;
    }
    c->at += 1;
}

void stp_range_put_byte(stp_range_coder* c)
{
    uint32_t carry = (uint32_t)(c->low >> 32);
    assert(c->encoding && carry <= 1);
    uint32_t top = (uint32_t)(c->low >> 24) & 0xFFu;
    if (top != 0xFFu || carry != 0 || c->held == 0) {
        if (c->held > 0) {
            emit(c, (c->first_held + carry) & 0xFFu);
        }
        for (; c->held > 1; --c->held) {
            emit(c, (0xFFu + carry) & 0xFFu);
        }
        c->first_held = (uint8_t)top;
        c->held = 0;
    }
    c->held += 1;
    c->low = (c->low & 0xFFFFFFu) << 8;
}

void stp_range_encode_begin(stp_range_coder* coder, unsigned char* output, size_t room)
{
    *coder =
        (stp_range_coder){.encoding = true, .range = UINT32_MAX, .output = output, .size = room};
}

size_t stp_range_encode_end(stp_range_coder* c)
{
    for (int i = 0; i < CODE_BYTES + 1; ++i) { // the last call emits the held bytes
        stp_range_put_byte(c);
    }
    return c->failed ? 0 : c->at;
}

void stp_range_decode_begin(stp_range_coder* c, const unsigned char* input, size_t size)
{
    *c = (stp_range_coder){.range = UINT32_MAX, .input = input, .size = size};
    for (; c->at < CODE_BYTES; c->at += 1) {
        c->code = c->code << 8 | (c->at < size ? input[c->at] : 0u);
    }
}

bool stp_range_decode_ends_well(const stp_range_coder* c)
{
    assert(!c->encoding);
    for (size_t i = c->at; i < c->size; ++i) {
        if (c->input[i] != 0) {
            return false;
        }
    }
    return c->at <= c->size && c->code == 0;
}
