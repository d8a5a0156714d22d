// SPDX-License-Identifier: MIT
// Positions on a Morton curve, in variants per CPU with identical bits.
#pragma once

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

enum {
    STP_CURVE_BITS = 20,        ///< per axis, for the finest cells
    STP_CURVE_CELL_BITS = 4,    ///< per axis, for the cells into which points are bucketed
    STP_CURVE_FINE_BITS = 6,    ///< per axis, within such a cell
    STP_CURVE_FINEST_BITS = 10, ///< per axis, used only if too many points share a cell
    STP_CURVE_CELLS = 1 << 3 * STP_CURVE_CELL_BITS,
};

/// Maps positions to the finest cells: (position * scale - low) * quanta, rounded down.
typedef struct stp_curve {
    float scale, quanta;
    float low[3];
} stp_curve;

/// A point while it is sorted: scaled position and index.
typedef struct stp_record {
    float x, y, z;
    uint32_t id;
} stp_record;

typedef struct stp_curve_kernels {
    /// Computes the cells of `count` positions (3 floats each).
    void (*cells)(const stp_curve* curve, const float* positions, size_t count, uint16_t* cells);
    /// For each record: its curve position within its cell (upper half) and its index in the list
    /// (lower half).
    void (*places)(const stp_curve* curve, const stp_record* records, size_t count,
                   uint64_t* items);
} stp_curve_kernels;

extern const stp_curve_kernels stp_curve_kernels_portable;
extern const stp_curve_kernels stp_curve_kernels_vector;
extern const stp_curve_kernels stp_curve_kernels_wide;

/// The widest kernels that this CPU runs.
const stp_curve_kernels* stp_curve_kernels_select(void);

static inline uint32_t stp_curve_quantize(float value, float low, float quanta)
{
    return (uint32_t)(int32_t)((value - low) * quanta);
}

/// Spreads 10 bits to every third place.
static inline uint32_t stp_curve_spread(uint32_t v)
{
    v = (v | v << 16) & 0x030000FFu;
    v = (v | v << 8) & 0x0300F00Fu;
    v = (v | v << 4) & 0x030C30C3u;
    return (v | v << 2) & 0x09249249u;
}

static inline uint32_t stp_curve_interleave(uint32_t x, uint32_t y, uint32_t z)
{
    return stp_curve_spread(x) | stp_curve_spread(y) << 1 | stp_curve_spread(z) << 2;
}

/// `bits` bits per axis of the finest cell of a scaled position, from bit `shift` up, interleaved.
static inline uint32_t stp_curve_place(const stp_curve* curve, float x, float y, float z, int shift,
                                       int bits)
{
    assert(bits > 0 && bits <= STP_CURVE_FINEST_BITS && shift + bits <= STP_CURVE_BITS);
    uint32_t mask = (1u << bits) - 1;
    return stp_curve_interleave(stp_curve_quantize(x, curve->low[0], curve->quanta) >> shift & mask,
                                stp_curve_quantize(y, curve->low[1], curve->quanta) >> shift & mask,
                                stp_curve_quantize(z, curve->low[2], curve->quanta) >> shift &
                                    mask);
}
