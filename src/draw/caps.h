// SPDX-License-Identifier: MIT
//
// Caps fill solids where sections cut them. A cap is computed from original triangles,
// regardless of the drawn level. A plane cuts the closed surface of a solid in closed outlines; a
// point of the plane is inside the solid if outlines wind around it. Open surfaces have no inside,
// so they get no cap.
//
//   solid       a mesh whose edges all cancel (each is used equally often in both directions), or
//               that is closed except for cracks (caps_internal.h). Pieces of a mesh (same name and
//               material) are tested together
//   outlines    segments in scene space, kept while sections and visibility stay the same
//   fill        for each pixel, how often outlines wind around the point of the plane that it shows
//
// Shared by all backends, which draw the caps into their pictures where they are nearest.
#pragma once

#include "select/view_frame.h"
#include "select/visibility.h"
#include "store/file/store.h"

typedef struct stp_caps stp_caps;

/// Caps in the picture of one eye; the arrays belong to the caps.
typedef struct stp_cap_picture {
    const float* nearness; ///< one per pixel, like the picture's depths; 0: no cap
    const uint8_t* pixels; ///< RGBA, valid where nearness is above 0
    bool any;              ///< whether a pixel shows a cap; if not, the arrays may be NULL
} stp_cap_picture;

STP_MUST_USE stp_result stp_caps_create(stp_context* context, stp_store* store, stp_caps** caps);
void stp_caps_destroy(stp_caps* caps); ///< NULL is allowed

/// Finds the outlines of the sections' cuts, unless they are cached. `visibility` may be NULL:
/// everything is shown. Hidden objects and ghosts have no caps. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY, or what reading the store returns; logged
STP_MUST_USE stp_result stp_caps_find(stp_caps* caps, const stp_sections* sections,
                                      const stp_visibility* visibility);

/// Nearness function of a picture: offset + scale / depth, or offset + scale * depth in parallel
/// projection.
typedef struct stp_cap_depth {
    double scale, offset;
} stp_cap_depth;

/// Fills the last found outlines. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_caps_fill(stp_caps* caps, const stp_view_frame* frame, bool headlight,
                                      const stp_cap_depth* depth, stp_cap_picture* picture);
