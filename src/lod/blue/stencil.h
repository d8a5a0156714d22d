// SPDX-License-Identifier: MIT
//
// The part of a surfel's disk that is surface: an 8 x 8 stencil over the square around the disk,
// one bit per cell.
//
//      . . # # # # . .     52 cells count: those with their centre in the disk. The disk is solid
//      . # # # # # # .     if one of its eight sectors of 45 degrees is full from the centre to
//      # # # # # # # #     the rim. This holds inside a plate, but also at its border or corner,
//      # # # # # # # #     where a hole would be worse than a disk that extends beyond it by a
//      # # # # # # # #     part of its radius. Thin or scattered geometry (wires, fences, leaves)
//      # # # # # # # #     has no full sector, and gets the fraction of cells hit.
//      . # # # # # # .
//      . . # # # # . .
#pragma once

#include "base/math/math.h"

#include <assert.h>

typedef struct stp_stencil {
    uint64_t disk;
    uint64_t sectors[8];
} stp_stencil;

stp_stencil stp_stencil_make(void);

/// Cells with centres in the square [u - half, u + half] x [v - half, v + half], and the cell of
/// (u, v) itself. In units of the disk's radius: the disk is within [-1, 1] x [-1, 1].
static inline uint64_t stp_stencil_cells(float u, float v, float half)
{
    assert(!(half < 0.0f));
    // floors of these are the outermost cells
    float u0 = 4.0f * (u - half) + 4.5f, u1 = 4.0f * (u + half) + 3.5f;
    float v0 = 4.0f * (v - half) + 4.5f, v1 = 4.0f * (v + half) + 3.5f;
    float cu = 4.0f * u + 4.0f, cv = 4.0f * v + 4.0f;
    u0 = stp_min(u0, cu), u1 = stp_max(u1, cu), v0 = stp_min(v0, cv), v1 = stp_max(v1, cv);
    if (!(u1 >= 0.0f && v1 >= 0.0f && u0 < 8.0f && v0 < 8.0f)) {
        return 0;
    }
    unsigned column0 = u0 > 0.0f ? (unsigned)u0 : 0, column1 = u1 < 8.0f ? (unsigned)u1 : 7;
    unsigned row0 = v0 > 0.0f ? (unsigned)v0 : 0, row1 = v1 < 8.0f ? (unsigned)v1 : 7;
    uint64_t columns = (0xffu << column0 & 0xffu) & 0xffu >> (7 - column1);
    uint64_t rows = UINT64_MAX << 8 * row0 & UINT64_MAX >> 8 * (7 - row1);
    return columns * UINT64_C(0x0101010101010101) & rows;
}

/// Whether one sector of the disk is full.
static inline bool stp_stencil_is_solid(const stp_stencil* stencil, uint64_t cells)
{
    bool solid = false;
    for (int i = 0; i < 8; ++i) {
        solid = solid || (cells & stencil->sectors[i]) == stencil->sectors[i];
    }
    return solid;
}

/// Whether all cells of the disk are set, except for two that samples may have missed.
static inline bool stp_stencil_is_full(const stp_stencil* stencil, uint64_t cells)
{
    return __builtin_popcountll(stencil->disk & ~cells) <= 2;
}

/// Fraction of the disk that is surface, 0..1; exactly 1 if solid.
float stp_stencil_fraction(const stp_stencil* stencil, uint64_t cells);
