// SPDX-License-Identifier: MIT
// Triangle kernels with vectors of four numbers, with NEON.
#include "raster/pixels_write.h"
#include "raster/triangles_four.h"
#include "raster/triangles_internal.h"
#include "raster/triangles_narrow.h"

/// Deinterleaves three vectors: a b c a b c ...
static inline void lanes_load3(const void* source, lanes_int out[3])
{
    int32x4x3_t columns = vld3q_s32((const int32_t*)source);
    for (int k = 0; k < 3; ++k) {
        out[k] = (lanes_int)columns.val[k];
    }
}

static inline lanes_int lanes_min(lanes_int a, lanes_int b)
{
    return (lanes_int)vminq_s32((int32x4_t)a, (int32x4_t)b);
}

static inline lanes_int lanes_max(lanes_int a, lanes_int b)
{
    return (lanes_int)vmaxq_s32((int32x4_t)a, (int32x4_t)b);
}

static inline uint32_t lanes_sign_bits(lanes_int a)
{
    uint32x4_t signs = vshrq_n_u32((uint32x4_t)a, 31);
    return vaddvq_u32(vshlq_u32(signs, (int32x4_t)lanes_index()));
}

/// Rounds doubles to float: first `low`, then `high`.
static inline lanes_float lanes_narrow(lanes_real low, lanes_real high)
{
    return (lanes_float)vcvt_high_f32_f64(vcvt_f32_f64((float64x2_t)low), (float64x2_t)high);
}

static inline lanes_int lanes_round(lanes_float a)
{
    return (lanes_int)vcvtnq_s32_f32((float32x4_t)a);
}

static inline void lanes_write(uint64_t* pixels, uint32_t bits, lanes_int nearness, uint32_t id)
{
    if (bits == LANES_ALL) {
        stp_pixels_write_four(pixels, (int32x4_t)~nearness, stp_pixel_ids_of(id));
        return;
    }
    lanes_write_each(pixels, bits, nearness, id);
}

#include "raster/triangles_lanes.h"

const stp_triangle_kernels stp_triangle_kernels_vector = {
    .find_range = find_range,
    .transform = transform_vertices,
    .draw_chunk = draw_chunk,
    .draw_one = draw_one,
};
