// SPDX-License-Identifier: MIT
//
// Morton curve kernels, compiled once per instruction set: plain loops that compilers vectorise.
// The includer defines KERNELS, the name of the table.
#include "order/curve.h"

static void cells(const stp_curve* curve, const float* restrict positions, size_t count,
                  uint16_t* restrict out)
{
    const stp_curve c = *curve;
    for (size_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * i;
        out[i] =
            (uint16_t)stp_curve_place(&c, p[0] * c.scale, p[1] * c.scale, p[2] * c.scale,
                                      STP_CURVE_BITS - STP_CURVE_CELL_BITS, STP_CURVE_CELL_BITS);
    }
}

static void places(const stp_curve* curve, const stp_record* restrict records, size_t count,
                   uint64_t* restrict items)
{
    const stp_curve c = *curve;
    for (size_t i = 0; i < count; ++i) {
        const stp_record* r = &records[i];
        uint64_t place =
            stp_curve_place(&c, r->x, r->y, r->z, STP_CURVE_FINEST_BITS, STP_CURVE_FINE_BITS);
        items[i] = place << 32 | i;
    }
}

const stp_curve_kernels KERNELS = {cells, places};
