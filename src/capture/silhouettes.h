// SPDX-License-Identifier: MIT
//
// Binary silhouettes of a capture's views: which pixels show any surface, at any depth. They tell
// whether the background can show through a disk, which the candidates near the disk cannot.
#pragma once

#include "base/math/math.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    STP_SILHOUETTES = 8 ///< views that are kept, the first ones of a capture
};

typedef struct stp_silhouette {
    stp_vec3d toward; ///< unit, towards the viewer
    /// Axes in pixels per scene unit, for positions relative to the candidates' origin
    stp_vec3d right, down;
    double shift_x, shift_y;
    uint32_t width, height;
    uint32_t* words; ///< a bit a pixel, each row of whole words; owned
} stp_silhouette;

static inline uint32_t stp_silhouette_stride(uint32_t width)
{
    return width / 32 + 1;
}

/// Whether anything is seen where a position is, from the silhouette's direction.
static inline bool stp_silhouette_holds(const stp_silhouette* s, stp_vec3d at)
{
    double x = stp_dotd(s->right, at) + s->shift_x, y = stp_dotd(s->down, at) + s->shift_y;
    if (!(x >= 0.0 && y >= 0.0 && x < (double)s->width && y < (double)s->height)) {
        return false;
    }
    uint32_t column = (uint32_t)x, row = (uint32_t)y;
    assert(column / 32 < stp_silhouette_stride(s->width));
    uint32_t word = s->words[(size_t)row * stp_silhouette_stride(s->width) + column / 32];
    return (word >> (column % 32) & 1) != 0;
}
