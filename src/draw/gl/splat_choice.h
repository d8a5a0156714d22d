// SPDX-License-Identifier: MIT
//
// Chooses how splats are drawn, by measuring once in the context with splats of three sizes.
#pragma once

#include "draw/gl/raster_pass.h"

struct stp_gl_renderer;

enum { SPLAT_WAYS = 2, SPLAT_SIZES = 3 };

typedef struct stp_gl_splat_choice {
    stp_gl_splats wanted;
    stp_gl_splats used; ///< path of the last frame
    bool measured;
    stp_gl_splat_source source;               ///< splat commands of the current sample
    uint64_t pixels;                          ///< number of pixels of the measured picture
    double fixed_ns[SPLAT_WAYS];              ///< fixed cost
    double splat_ns[SPLAT_WAYS][SPLAT_SIZES]; ///< additional cost per splat of each size
} stp_gl_splat_choice;

/// Measured diameters in pixels.
extern const float stp_gl_splat_sizes[SPLAT_SIZES];

/// Measures once. Draws into the visibility buffer, which is undefined afterwards; waits.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_splat_choice_measure(struct stp_gl_renderer* r);

/// The fastest known path for this many splats of a size, or the requested path.
stp_gl_splats stp_gl_splat_choice_find(const struct stp_gl_renderer* r, uint64_t splats,
                                       float size);

/// Draws all splats of the frame into the visibility buffer. Uses the selected path; large splats
/// are queued. `late`: again, after the commands have changed. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_splat_choice_draw(struct stp_gl_renderer* r, bool late);
/// Draws the queued large splats.
void stp_gl_splat_choice_draw_large(struct stp_gl_renderer* r);
