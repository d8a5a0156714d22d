// SPDX-License-Identifier: MIT
// Vectors of four numbers, as compiler vector types: SSE2, NEON, or others.
#include "base/core/processor.h"
#include "draw/cpu/shade.h"

#define LANES 4

typedef int32_t lanes_int __attribute__((vector_size(16)));
typedef float lanes_float __attribute__((vector_size(16)));

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int){base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)((mask & (lanes_int)a) | (~mask & (lanes_int)b));
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}

/// Bit i: the sign of number i.
static inline uint32_t lanes_mask(lanes_int a)
{
    return (uint32_t)((a[0] & 1) | (a[1] & 2) | (a[2] & 4) | (a[3] & 8));
}

/// Upper halves of pixels.
static inline lanes_int lanes_upper(const uint64_t* from)
{
    return (lanes_int){(int32_t)(from[0] >> 32), (int32_t)(from[1] >> 32), (int32_t)(from[2] >> 32),
                       (int32_t)(from[3] >> 32)};
}

/// Transposed surfaces: field k of all.
static inline void lanes_turn(const stp_cpu_shade_surface* surfaces, const uint32_t* index,
                              lanes_float field[16])
{
    const float* s[4];
    for (int i = 0; i < 4; ++i) {
        s[i] = surfaces[index[i]].color;
    }
    for (int k = 0; k < 16; ++k) {
        field[k] = (lanes_float){s[0][k], s[1][k], s[2][k], s[3][k]};
    }
}

#include "draw/cpu/shade_lanes.h"

const stp_cpu_shade_kernels stp_cpu_shade_kernels_portable = {merge_row, light_all, spread_row,
                                                              find_depths};

const stp_cpu_shade_kernels* stp_cpu_choose_shade_kernels(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_cpu_shade_kernels);
}
