// SPDX-License-Identifier: MIT
//
// Which sides of surfaces are drawn. Backs of single-sided materials of glTF
// (STP_SHADING_FRONT_ONLY) are not, unless the style or a section wants them.
#pragma once

#include "draw/draw.h"
#include "select/view_frame.h"

/// Splats of these materials are left out if they face away by more than the angle of this sine.
/// Others close the outlines of round surfaces (BACK_SINE in shaders/interface.h).
#define STP_BACK_SINE 0.25f

/// Whether backs of all materials are drawn.
static inline bool stp_draws_backs(const stp_draw_style* style, const stp_sections* sections)
{
    return style->back_faces || sections->count > 0;
}

/// From where an item is seen, in item space less `offset`; in parallel projection the direction
/// there. @return false: the item is flat
bool stp_find_item_eye(const stp_view_frame* frame, const stp_affine* transform,
                       const float offset[3], float eye[3]);

typedef enum stp_front_only {
    STP_FRONT_ONLY_NONE,
    STP_FRONT_ONLY_SOME,
    STP_FRONT_ONLY_ALL, ///< no splat of another shading
} stp_front_only;

/// Per splat shading (256 bytes): whether its splats are drawn from the front only.
stp_front_only stp_front_only_of_shadings(const stp_store_directory* directory,
                                          uint8_t front_only[256]);
