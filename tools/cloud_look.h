// SPDX-License-Identifier: MIT
// What clouds of points look like: eye-dome lighting where nobody chose another strength, and the size of points.
#pragma once

#include "command.h"

#include "draw/draw.h"

/// Strength of eye-dome lighting for clouds, as --eye-dome takes it.
#define CLOUD_EYE_DOME 1.0f

/// Size of original points that are drawn because splats lack an attribute: by themselves they have none.
#define CLOUD_ORIGINAL_SIZE "3px"
#define CLOUD_ORIGINAL_PIXELS 3.0f

/// Strength for thumbnails: their few, large splats stand apart, and would be outlined.
#define CLOUD_THUMBNAIL_EYE_DOME 0.4f

/// --point-size as given.
typedef struct cloud_point_size {
    bool in_metres;
    double width; ///< pixels or metres; 0: adaptive
} cloud_point_size;

enum { CLOUD_POINT_PIXELS = 64 }; ///< most

#define OPTION_POINT_SIZE(where)                                                                   \
    {                                                                                              \
        .name = "point-size", .type = OPTION_TEXT, .argument = "SIZE",                             \
        .help =                                                                                    \
            "width of points: so many pixels (3, 3px) or metres (0.05m), or adaptive, as wide "    \
            "as closes the gaps between those that are drawn; default adaptive",                   \
        .value = (where)                                                                           \
    }

/// Reads 3, 3px, 0.05m or adaptive. @return false if the text is not such a size
bool cloud_look_read_size(const char* text, cloud_point_size* size);

/// Says what sizes there are. @return 2
int cloud_look_refuse_size(const char* text);

/// Whether all of a scene are points.
bool cloud_look_is_cloud(const stp_store* store);

/// The strength of eye-dome lighting that a scene is drawn with by default: that of clouds, or 0.
float cloud_look_eye_dome(const stp_store* store);

/// Gives points a size. Where a scene does not say what its units are, they are taken for metres.
void cloud_look_set_size(const cloud_point_size* size, const stp_store* store,
                         stp_draw_style* style);
