// SPDX-License-Identifier: MIT
// What one view sees of a scene, as few elliptical splats of method psp.
#pragma once

#include "command.h"

#include "capture/silhouettes.h"
#include "scene/scene.h"
#include "store/store.h"

#include <stipple/image.h>
#include <stipple/view.h>

typedef struct view_splats {
    stp_store* store;    ///< of the splats; NULL: the view sees nothing
    uint32_t candidates; ///< pixels of the surface that were merged
    uint32_t splats;
    // what the view shows anything of, finer than the picture
    bool has_outline;
    stp_silhouette outline;
    stp_vec3d origin; ///< that its positions are relative to
} view_splats;

/// Captures what a parallel view sees, in two by two pixels for each of the picture at its usual
/// size, and merges every second one (STP_PSP_REGIONS) until `count` splats are left. Pixels are at
/// most 128 a splat, or 2^18 where that is more. The result does not depend on the number of
/// threads.
/// @param view a parallel one that shows all of the scene; its sections are not looked at
/// @return STP_OK, STP_ERROR_LIMIT (more than 2^22 uses of parts), or another failure; logged. The
///         caller destroys what was made
STP_MUST_USE stp_result view_splats_make(const stp_scene* scene, const stp_view* view,
                                         uint32_t count, view_splats* made);
void view_splats_destroy(stp_context* context, view_splats* made);

/// Gives a picture of the view the outline of what was captured: splats at the border of a face
/// stand over, and leave pixels between them where they are few. These get the colours beside them.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result view_splats_trim(stp_context* context, const view_splats* made,
                                         const stp_view* view, stp_image* image);
