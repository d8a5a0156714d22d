// SPDX-License-Identifier: MIT
//
// Oriented disks into the visibility buffer (Brandt 4.2): a pixel belongs to a splat when the ray
// through its centre meets the splat's plane within the radius of its centre. The pixel that holds
// the centre itself is always drawn, so that no surfel vanishes between pixel centres. Both sides
// of a disk are drawn.
//
// The test is the exact conic of the disk's picture, not an approximation of it. Depth follows the
// splat's plane, so overlapping splats meet as the surface does; it never leaves the centre's depth
// by more than the radius, so a disk seen edge-on does not shoot through what stands before or
// behind it.
#pragma once

#include "base/context.h"
#include "raster/occluder.h"
#include "raster/target.h"

#include <stipple/surfels.h>

typedef struct stp_raster_splats {
    const uint16_t* positions; ///< 3 a splat
    const int8_t* normals;     ///< 2 a splat, octahedral; NULL: disks face the eye
    uint32_t begin, end;       ///< range of splats to draw
    stp_vec3 origin;           ///< position = origin + step * value, in object space
    float step;
    float
        radius; ///< of every disk, object space; 0: the centre's pixel only. With shapes: of one step
    float pixels; ///< added to the radius on the screen, at any depth
    const uint32_t*
        shapes; ///< NULL, or 1 a splat (base/splat_codes.h): ellipses with radii of their own
    /// Where not both 0: only splats whose centre is within these depths (W of the matrix) are drawn.
    float nearest, farthest;
    /// How far the rim of a disk lies behind its plane, in radii (0: not at all; the centre never
    /// moves). Where disks overlap, the one with the nearest centre then wins, as in a Voronoi
    /// diagram, and what sticks out of a wall across its edge does not hide the next wall.
    float rim_depth;
    /// How far a disk seen from behind lies behind its plane, in radii: it may fill a hole, but does
    /// not hide what faces the viewer.
    float back_depth;
    /// NULL, or 1 a splat: what is drawn of the disk (base/coverage.h). Down to a quarter (64 of 255) a share makes holes
    /// (hashed), below the radius is halved once or more while it leaves about a pixel, so that what is left is no thinner
    /// and lies where the splat does.
    const uint8_t* coverages;
    bool plain_coverages; ///< shares of 255 instead
    /// Those of another octave for splats below low_count, which count for low_share of 256; 0: none. Shares are mixed; where
    /// either cuts the disk, one of both is taken, by a hash of the index.
    const uint8_t* low_coverages;
    uint32_t low_count, low_share;
    float share;   ///< of the fragments that are drawn, of ghosts; 0: all
    uint32_t seed; ///< of the holes
    const float*
        points; ///< 3 a splat, used where `positions` is NULL (origin and step are ignored)
    /// NULL, or what hides: splats behind it are not drawn. Surfels only.
    const stp_raster_occluder* occluder;
    /// NULL, or a bit a splat (from splat 0 on): those that the occluder hid are set, all others of the range cleared.
    uint16_t* hidden;
    const uint16_t* wanted; ///< NULL, or a bit a splat: only these are drawn
    bool squares;           ///< squares instead of disks (raster/splats_squares_kernel.h)
} stp_raster_splats;

/// Object space to view space: x right, y down, z along the gaze, all in object-space lengths times
/// a common factor; needed for the planes. The raster matrix is the projection after it.
typedef struct stp_raster_camera {
    stp_raster_matrix
        matrix; ///< object space to the screen; in perspective W is proportional to view z
    float view[3]
              [4]; ///< object space to view space (rotation, perhaps a mirror, and uniform scale)
    float pixel_scale; ///< pixels per unit of x/z (perspective), or per unit (parallel)
    bool parallel;
    float nearness_limit;
} stp_raster_camera;

/// The levels of a view: an error allowed, in object space.
typedef struct stp_raster_levels {
    float per_depth; ///< at depth 1 (W of the matrix)
    float least;     ///< nowhere less
    uint32_t divide; ///< splats before it are held against `below`, at any depth; 0: none are
    float below;
    /// NULL, or one for each STP_GROUP_SPLATS splats (from splat 0 on): groups out of the picture are left out; and, where
    /// `one_sided`, those of which all splats face away.
    const stp_splat_group* groups;
    bool one_sided;
    bool beside_triangles;  ///< splats that large triangles replace are left out; with groups
    uint32_t width, height; ///< of the picture
} stp_raster_levels;

/// Sets a bit a splat (from splat 0 on; `begin` is a multiple of 16) for those of [begin, end) whose ranges
/// (base/splat_codes.h) hold the level at their depth, and clears those of the others. Of `splats`, only positions are
/// looked at, and `wanted`: what is not is left out. @return whether any is set
bool stp_raster_pick_levels(const stp_raster_camera* camera, const stp_raster_splats* splats,
                            const uint32_t* ranges, const stp_raster_levels* levels,
                            uint16_t* bits);

/// Clears, among the bits of splats [begin, end) (a bit a splat, from splat 0 on; `begin` is a multiple of 16), those that
/// the occluder hides. Surfels only. @return whether any is left
bool stp_raster_ask_splats(const stp_raster_splats* splats, uint16_t* bits);

/// Draws splats; splat i gets the id first_id + i. With bits for each splat, `begin` is a multiple of 16. Only rows [row_begin, row_end) are touched.
/// @return fragments that passed the disk test
uint64_t stp_raster_draw_splats(const stp_raster_target* target, uint32_t row_begin,
                                uint32_t row_end, const stp_raster_camera* camera,
                                const stp_raster_splats* splats, uint32_t first_id);
