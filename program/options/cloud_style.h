// SPDX-License-Identifier: MIT
// Appearance of point clouds: default eye-dome lighting and point size.
#pragma once

#include "draw/draw.h"
#include "program/options/command.h"

/// Strength of eye-dome lighting for clouds, as --eye-dome takes it.
#define CLOUD_EYE_DOME 1.0f

/// Size of original points that are drawn because splats lack an attribute: points, unlike splats,
/// have no size of their own.
#define CLOUD_ORIGINAL_SIZE "3px"
#define CLOUD_ORIGINAL_PIXELS 3.0f

/// Strength for thumbnails: their few, large splats stand apart, and would be outlined.
#define CLOUD_THUMBNAIL_EYE_DOME 0.4f

/// --point-size as given.
typedef struct cloud_point_size {
    bool in_metres;
    double width; ///< pixels or metres; 0: adaptive
} cloud_point_size;

enum { CLOUD_POINT_PIXELS = 64 }; ///< largest point size, pixels

/// `usual`: the default, for the help.
#define OPTION_POINT_SIZE(where, usual)                                                            \
    {                                                                                              \
        .name = "point-size", .type = OPTION_TEXT, .argument = "SIZE",                             \
        .help = "point size: pixels (3, 3px), metres (0.05m), or adaptive, which closes the gaps " \
                "between drawn points; default " usual,                                            \
        .value = (where), .group = "Points"                                                        \
    }

/// Reads 3, 3px, 0.05m or adaptive. @return false if the text is not such a size
bool cloud_style_read_size(const char* text, cloud_point_size* size);

/// Prints the valid sizes. @return 2
int cloud_style_refuse_size(const char* text);

/// Whether the scene has only points.
bool cloud_style_is_cloud(const stp_store* store);

/// Default strength of eye-dome lighting: that of clouds, or 0.
float cloud_style_eye_dome(const stp_store* store);

/// Sets the point size. If the scene has no unit, its units count as metres.
void cloud_style_set_size(const cloud_point_size* size, const stp_store* store,
                          stp_draw_style* style);
