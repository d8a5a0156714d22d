// SPDX-License-Identifier: MIT
// Merge forests of method psp, for its tests.
#pragma once

#include "tests.h"

#include "lod/psp/forest.h"

#include <math.h>

/// Whether merges are in order, and all splats are valid.
static inline bool psp_is_forest(const stp_psp_forest* f)
{
    for (uint32_t i = 0; i < f->merge_count; ++i) {
        stp_psp_merge m = f->merges[i];
        if (m.left >= m.right || m.right >= f->point_count + i || f->parents[m.left] != i ||
            f->parents[m.right] != i || !(m.error >= 0.0) || m.level < m.error ||
            (i > 0 && m.level < f->merges[i - 1].level)) {
            return false;
        }
    }
    for (uint32_t i = 0; i < f->point_count + f->merge_count; ++i) {
        const stp_ellipse* e = &f->ellipses[i];
        if (!stp_is_finite(e->center) || !stp_is_finite(e->major) || !(e->minor > 0.0f) ||
            !(fabsf(stp_length(e->normal) - 1.0f) < 1e-3f)) {
            return false;
        }
    }
    return true;
}

/// Lists the splats at the time when `count` are left, ascending.
/// @param splats space for `count` or the number of roots, whichever is larger
/// @return `count`, clamped to at least the number of roots and at most the number of points
static inline uint32_t psp_cut(const stp_psp_forest* forest, uint32_t count, uint32_t* splats)
{
    uint32_t points = forest->point_count, merges = forest->merge_count, found = 0;
    uint32_t done = count < points ? points - count : 0;
    done = done < merges ? done : merges;
    for (uint32_t i = 0; i < points + done; ++i) {
        if (forest->parents[i] >= done) {
            splats[found++] = i;
        }
    }
    return found;
}
