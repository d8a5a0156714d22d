// SPDX-License-Identifier: MIT
// Writing fragments with vectors of at most eight numbers: one row, and pixel by pixel where not all
// are written. Included by these variants, after the type lanes_int.
#pragma once

#include <stddef.h>
#include <stdint.h>

static inline void lanes_write(uint64_t* pixels, uint32_t bits, lanes_int nearness, uint32_t id);

/// The pixels of `bits`, one by one.
static inline void lanes_write_each(uint64_t* pixels, uint32_t bits, lanes_int nearness,
                                    uint32_t id)
{
    for (; bits != 0; bits &= bits - 1) {
        int lane = __builtin_ctz(bits);
        uint64_t pixel = (uint64_t) ~(uint32_t)nearness[lane] << 32 | id;
        pixels[lane] = pixel < pixels[lane] ? pixel : pixels[lane];
    }
}

static inline void lanes_write_narrow(uint64_t* pixels, size_t stride, uint32_t bits,
                                      lanes_int nearness, uint32_t id)
{
    (void)stride; // only one row fits
    lanes_write(pixels, bits, nearness, id);
}
