// SPDX-License-Identifier: MIT
#include "lod/blue/stencil.h"

#include <assert.h>

// A disk with at least this much surface counts as solid: single cells may be missed by the
// samples.
#define NEARLY_SOLID 0.94f

stp_stencil stp_stencil_make(void)
{
    stp_stencil stencil = {0};
    for (int row = 0; row < 8; ++row) {
        for (int column = 0; column < 8; ++column) {
            int u = 2 * column - 7, v = 2 * row - 7; // centre of the cell, in eighths of the radius
            uint64_t bit = (uint64_t)1 << (8 * row + column);
            if (u * u + v * v > 64) {
                continue;
            }
            stencil.disk |= bit;
            int far_u = u < 0 ? -u : u, far_v = v < 0 ? -v : v;
            int quadrant = (u < 0) + 2 * (v < 0);
            stencil.sectors[2 * quadrant] |= far_u >= far_v ? bit : 0;
            stencil.sectors[2 * quadrant + 1] |= far_v >= far_u ? bit : 0;
        }
    }
    assert(__builtin_popcountll(stencil.disk) == 52);
    return stencil;
}

float stp_stencil_fraction(const stp_stencil* stencil, uint64_t cells)
{
    if (stp_stencil_is_solid(stencil, cells)) {
        return 1.0f;
    }
    float fraction = (float)__builtin_popcountll(cells & stencil->disk) /
                     (float)__builtin_popcountll(stencil->disk);
    assert(fraction <= 1.0f);
    return fraction >= NEARLY_SOLID ? 1.0f : fraction;
}
