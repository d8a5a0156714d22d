// SPDX-License-Identifier: MIT
// Triangle kernels with vectors of four numbers in compiler notation: SSE2, NEON, or others
// that the CPU has.
#include "raster/triangles_four.h"
#include "raster/triangles_internal.h"
#include "raster/triangles_narrow.h"

/// Deinterleaves three vectors: a b c a b c ...
static inline void lanes_load3(const void* source, lanes_int out[3])
{
    int32_t words[3 * LANES];
    memcpy(words, source, sizeof(words));
    for (int k = 0; k < 3; ++k) {
        out[k] = (lanes_int){words[k], words[k + 3], words[k + 6], words[k + 9]};
    }
}

static inline lanes_int lanes_min(lanes_int a, lanes_int b)
{
    return lanes_select(a < b, a, b);
}

static inline lanes_int lanes_max(lanes_int a, lanes_int b)
{
    return lanes_select(a > b, a, b);
}

static inline uint32_t lanes_sign_bits(lanes_int a)
{
    lanes_uint bits = (lanes_uint)a >> 31;
    return bits[0] | bits[1] << 1 | bits[2] << 2 | bits[3] << 3;
}

/// Rounds doubles to float: first `low`, then `high`.
static inline lanes_float lanes_narrow(lanes_real low, lanes_real high)
{
    return (lanes_float){(float)low[0], (float)low[1], (float)high[0], (float)high[1]};
}

static inline lanes_int lanes_round(lanes_float a)
{
    lanes_int out;
    for (int lane = 0; lane < LANES; ++lane) {
        out[lane] = stp_triangle_snap((double)a[lane]);
    }
    return out;
}

static inline void lanes_write(uint64_t* pixels, uint32_t bits, lanes_int nearness, uint32_t id)
{
    lanes_write_each(pixels, bits, nearness, id);
}

#include "raster/triangles_lanes.h"

const stp_triangle_kernels stp_triangle_kernels_portable = {
    .find_range = find_range,
    .transform = transform_vertices,
    .draw_chunk = draw_chunk,
    .draw_one = draw_one,
};
