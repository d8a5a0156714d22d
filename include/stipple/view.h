// SPDX-License-Identifier: MIT
//
// Where the picture is taken from, and how large it is.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { STP_SECTION_PLANES = 14 }; ///< eight, and the six of a box

/// Where normal . p > distance nothing is drawn, in scene space.
typedef struct stp_section_plane {
    stp_vec3d normal; ///< of any length above 0
    double distance;
} stp_section_plane;

/// What of a scene is cut away: what lies beyond any of the planes.
typedef struct stp_sections {
    uint32_t count;
    stp_section_plane planes[STP_SECTION_PLANES];
} stp_sections;

/// A pinhole camera. Pixel (x, y) covers [x, x + 1) x [y, y + 1), y down; its centre is at + 0.5.
typedef struct stp_view {
    stp_vec3d eye, target,
        up; ///< scene space; `up` need not be orthogonal to the gaze, nor of unit length
    double fov_degrees; ///< vertical, 0..180; ignored where ortho_height is set
    double
        ortho_height; ///< height of the picture in scene units, parallel projection; 0: perspective
    double near_distance;   ///< nothing nearer is drawn; 0: chosen from the distance to the target
    uint32_t width, height; ///< pixels, at least 1
    /// 0: one eye. Above 0: two eyes that look the same way, so far apart, `eye` in the middle; each has half the
    /// width, the left eye's half is on the left.
    double eye_distance;
    stp_sections sections; ///< none, or planes that cut the scene open
} stp_view;

#ifdef __cplusplus
}
#endif
