// SPDX-License-Identifier: MIT
// Turns the visible part of a scene into a few elliptical splats of method psp.
#pragma once

#include "capture/silhouettes.h"
#include "program/options/command.h"
#include "scene/scene.h"
#include "store/file/store.h"

#include <stipple/image.h>
#include <stipple/view.h>

typedef struct view_splats {
    stp_store* store;    ///< holds the splats; NULL: the view sees nothing
    uint32_t candidates; ///< pixels of the surface that were merged
    uint32_t splats;
    // outline of the visible content, finer than the picture
    bool has_outline;
    stp_silhouette outline;
    stp_vec3d origin; ///< origin of the outline's coordinates, in the scene
} view_splats;

/// Captures a parallel view at two by two pixels per picture pixel at the usual size, and merges
/// every second pixel (STP_PSP_REGIONS) until `count` splats remain. At most 128 pixels per splat
/// are used, or 2^18 if that is more. The result does not depend on the number of threads.
/// @param view a parallel view that shows the whole scene; its sections are ignored
/// @return STP_OK, STP_ERROR_LIMIT (more than 2^22 uses of parts), or another failure; logged. The
///         caller destroys the result
STP_MUST_USE stp_result view_splats_make(const stp_scene* scene, const stp_view* view,
                                         uint32_t count, view_splats* made);
void view_splats_destroy(stp_context* context, view_splats* made);

/// Cuts a picture of the view to the captured outline: splats at the border of a face overhang, and
/// leave gaps where they are few. Gaps take the colours of their neighbours. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result view_splats_trim(stp_context* context, const view_splats* made,
                                         const stp_view* view, stp_image* image);
