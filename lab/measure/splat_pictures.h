// SPDX-License-Identifier: MIT
// Similarity of pictures of splats and of the original.
#pragma once

#include "program/measure/image_compare.h"
#include "program/options/command.h"
#include "select/select.h"

enum { SPLAT_PICTURES = 7 };

/// The standard views to compare.
extern const char* const splat_picture_views[SPLAT_PICTURES];

/// A scene and the options for drawing it.
typedef struct splat_scene {
    stp_store* store;
    stp_quality quality;
} splat_scene;

typedef struct splat_pictures {
    stp_image_quality views[SPLAT_PICTURES];
    double ssim, ssim_covered; ///< means over the views
} splat_pictures;

/// Draws both from each view, framed by the bounds of the original, with four samples per pixel,
/// and compares. If their up axes differ, the views follow the axes of the files.
/// @param size width and height, pixels
/// @return STP_OK, or a failure that was logged
STP_MUST_USE stp_result splat_pictures_compare(stp_context* context, const splat_scene* splats,
                                               const splat_scene* original, const uint32_t size[2],
                                               splat_pictures* found);
