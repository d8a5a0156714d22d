// SPDX-License-Identifier: MIT
// Vectors of four numbers, with NEON.
#include "draw/cpu/shade.h"

#include <arm_neon.h>

#define LANES 4

typedef int32_t lanes_int __attribute__((vector_size(16)));
typedef float lanes_float __attribute__((vector_size(16)));

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int){base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)vbslq_f32((uint32x4_t)mask, (float32x4_t)a, (float32x4_t)b);
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float)vsqrtq_f32((float32x4_t)a);
}

/// Bit i: the sign of number i.
static inline uint32_t lanes_mask(lanes_int a)
{
    const lanes_int places = {0, 1, 2, 3};
    uint32x4_t signs = vshrq_n_u32((uint32x4_t)a, 31);
    return vaddvq_u32(vshlq_u32(signs, (int32x4_t)places));
}

/// Upper halves of pixels.
static inline lanes_int lanes_upper(const uint64_t* from)
{
    return (lanes_int)vld2q_s32((const int32_t*)(const void*)from).val[1];
}

/// Transposed surfaces: field k of all.
static inline void lanes_turn(const stp_cpu_shade_surface* surfaces, const uint32_t* index,
                              lanes_float field[16])
{
    for (int k = 0; k < 16; k += 4) {
        float32x4_t row[4];
        for (int i = 0; i < 4; ++i) {
            row[i] = vld1q_f32((const float*)&surfaces[index[i]] + k);
        }
        float32x4x2_t a = vzipq_f32(row[0], row[2]), b = vzipq_f32(row[1], row[3]);
        float32x4x2_t c = vzipq_f32(a.val[0], b.val[0]), d = vzipq_f32(a.val[1], b.val[1]);
        field[k] = (lanes_float)c.val[0];
        field[k + 1] = (lanes_float)c.val[1];
        field[k + 2] = (lanes_float)d.val[0];
        field[k + 3] = (lanes_float)d.val[1];
    }
}

#include "draw/cpu/shade_lanes.h"

const stp_cpu_shade_kernels stp_cpu_shade_kernels_vector = {merge_row, light_all, spread_row,
                                                            find_depths};
