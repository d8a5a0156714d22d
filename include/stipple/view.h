// SPDX-License-Identifier: MIT
//
// Camera, size and section planes of a picture.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Range of stp_view.fov_degrees.
#define STP_FOV_DEGREES_MIN 1e-3
#define STP_FOV_DEGREES_MAX 179.9

enum { STP_SECTION_PLANES = 14 }; ///< eight, plus the six of a box

/// A section plane in scene space: the half space normal . p > distance is cut away.
typedef struct stp_section_plane {
    stp_vec3d normal; ///< any length above 0
    double distance;
} stp_section_plane;

/// Section planes: everything beyond any of them is cut away.
typedef struct stp_sections {
    uint32_t count;
    stp_section_plane planes[STP_SECTION_PLANES];
} stp_sections;

/// A pinhole camera. Pixel (x, y) covers [x, x + 1) x [y, y + 1), y down; its centre is at + 0.5.
typedef struct stp_view {
    stp_vec3d eye, target; ///< scene space, to 1e24 in size; must differ
    /// Scene space, any length; need not be orthogonal to the viewing direction. If it is zero or
    /// parallel to that, a coordinate axis is used instead.
    stp_vec3d up;
    /// Vertical, STP_FOV_DEGREES_MIN to STP_FOV_DEGREES_MAX; ignored where ortho_height is set
    double fov_degrees;
    /// Parallel projection: height of the picture in scene units, above 0; 0: perspective
    double ortho_height;
    double near_distance;   ///< near plane distance; 0: derived from the distance to the target
    uint32_t width, height; ///< pixels, at least 1
    /// 0: one eye. Above 0: distance of two eyes with parallel viewing directions, centred at
    /// `eye`; each has half the width, the left eye's half is on the left.
    double eye_distance;
    stp_sections sections; ///< optional planes that cut the scene open
} stp_view;

#ifdef __cplusplus
}
#endif
