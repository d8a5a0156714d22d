// SPDX-License-Identifier: MIT
//
// Which way splats are drawn: measured once, on the context itself, with splats of three sizes.
#pragma once

#include "draw/gl/raster_pass.h"

struct gl_renderer;

enum { SPLAT_WAYS = 2, SPLAT_SIZES = 3 };

typedef struct gl_splat_choice {
    stp_gl_splats wanted;
    stp_gl_splats used; ///< by the last frame
    bool measured;
    gl_splat_source source;                   ///< of the sample that is drawn
    uint64_t pixels;                          ///< of the picture that was measured
    double fixed_ns[SPLAT_WAYS];              ///< whatever is drawn
    double splat_ns[SPLAT_WAYS][SPLAT_SIZES]; ///< more, each
} gl_splat_choice;

/// Diameters in pixels that are measured.
extern const float gl_splat_sizes[SPLAT_SIZES];

/// Measures unless that is done. Draws into the visibility buffer, and leaves it as it falls; waits.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_splat_choice_measure(struct gl_renderer* r);

/// The way that takes least time for so many splats of a size, as far as it is known, or the one that is wanted.
stp_gl_splats gl_splat_choice_find(const struct gl_renderer* r, uint64_t splats, float size);

/// All splats of the frame that commands draw into the visibility buffer, in the way that is chosen, but for large ones, which
/// are noted. `late`: a second time, when commands have changed. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_splat_choice_draw(struct gl_renderer* r, bool late);
/// The large ones that were noted.
void gl_splat_choice_draw_large(struct gl_renderer* r);
