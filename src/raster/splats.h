// SPDX-License-Identifier: MIT
//
// Rasterises oriented disks into the visibility buffer (Brandt 4.2). A pixel belongs to a splat if
// the ray through its centre meets the splat's plane within the radius of the splat's centre. The
// pixel that holds the centre is always drawn, so no splat vanishes between pixel centres. Disks
// are two-sided.
//
// The test is the exact conic of the projected disk, not an approximation. Depth follows the
// splat's plane, so overlapping splats intersect as the surface does. Depth is clamped to the
// radius around the centre's depth, so a disk seen edge-on does not poke through surfaces in front
// or behind.
#pragma once

#include "base/core/context.h"
#include "base/splats/splat_columns.h"
#include "raster/occluder.h"
#include "raster/target.h"

typedef struct stp_raster_splats {
    const uint16_t* positions; ///< 3 per splat
    const int8_t* normals;     ///< 2 per splat, octahedral; NULL: disks face the eye
    uint32_t begin, end;       ///< range of splats to draw
    stp_vec3 origin;           ///< position = origin + step * value, in object space
    float step;
    /// Radius of all disks, object space; 0: centre pixels only. With shapes: radius of one step
    float radius;
    float pixels; ///< added to the radius on the screen, at any depth
    /// NULL, or 1 per splat (base/splats/splat_codes.h): ellipses with individual radii
    const uint32_t* shapes;
    /// NULL, or 1 per splat, without shapes: their radii are multiplied by 1 + growths[material] *
    /// growth_share (stp_growth_share)
    const uint8_t* materials;
    const float* growths; ///< 256
    float growth_share;
    /// If not both 0: draw only splats whose centre is within these depths (W of the matrix).
    float nearest, farthest;
    /// How far the rim of a disk lies behind its plane, in radii (0: not at all; the centre never
    /// moves). Among overlapping disks the one with the nearest centre then wins, as in a Voronoi
    /// diagram, and disks that protrude over the edge of a wall do not hide the next wall.
    float rim_depth;
    /// How far a disk seen from behind lies behind its plane, in radii: it may fill a hole but does
    /// not hide front-facing surfaces.
    float back_depth;
    /// NULL, or 1 per splat: coverage codes (base/splats/coverage.h). A share of at least a quarter
    /// (64 of 255) makes holes (hashed). A smaller one halves the radius once or more, as long as
    /// about a pixel is left, so that the remaining part is no thinner and stays at the splat's
    /// position.
    const uint8_t* coverages;
    bool plain_coverages; ///< plain shares of 255
    /// Coverages of another octave for splats below low_count, with a weight of low_share / 256; 0:
    /// none. Shares are blended. If either code clips the disk, a hash of the index selects one of
    /// both.
    const uint8_t* low_coverages;
    uint32_t low_count, low_share;
    float share;         ///< fraction of the fragments drawn, for ghosts; 0: all
    uint32_t seed;       ///< seed of the hash for holes, added to the splat's index
    const float* points; ///< 3 per splat, used if `positions` is NULL (origin and step are ignored)
    /// NULL, or an occluder: splats behind it are not drawn. Splat sets only.
    const stp_raster_occluder* occluder;
    /// NULL, or one bit per splat (from splat 0 on): set for splats that the occluder hid, cleared
    /// for all others of the range.
    uint16_t* hidden;
    const uint16_t* wanted; ///< NULL, or one bit per splat: draw only these
    uint64_t* drawn;        ///< NULL, or a counter of the splats drawn: wanted, seen, not hidden
    bool squares;           ///< draw squares instead of disks (raster/splats_squares_kernel.h)
} stp_raster_splats;

/// Object space to view space: x right, y down, z along the view axis, in object-space lengths
/// times a common factor; needed for the planes. The raster matrix is the projection after it.
typedef struct stp_raster_camera {
    /// Object space to the screen; in perspective W is proportional to view z
    stp_raster_matrix matrix;
    /// Object space to view space (rotation, perhaps a mirror, and uniform scale)
    float view[3][4];
    float pixel_scale; ///< pixels per unit of x/z (perspective), or per unit (parallel)
    bool parallel;
    float nearness_limit;
} stp_raster_camera;

/// Level of detail of a view: the allowed error, in object space.
typedef struct stp_raster_levels {
    float per_depth; ///< at depth 1 (W of the matrix)
    float minimum;   ///< lower bound everywhere
    uint32_t divide; ///< splats before it use `below` at any depth; 0: none
    float below;
    /// NULL, or 1 per splat (base/splats/splat_codes.h): the view direction lowers the levels of
    /// the ranges. Ignored with a minimum: its cut is one of the whole ranges. Requires normals.
    const uint32_t* errors;
    /// NULL, or one per STP_GROUP_SPLATS splats (from splat 0 on): culls groups outside the picture
    /// and, with `one_sided`, groups whose splats all face away.
    const stp_splat_group* groups;
    bool one_sided;
    bool beside_triangles;  ///< skip splats that large triangles replace; requires groups
    uint32_t width, height; ///< size of the picture, pixels
} stp_raster_levels;

/// Sets a bit per splat (from splat 0 on; `begin` is a multiple of 16) for those of [begin, end)
/// whose ranges (base/splats/splat_codes.h) contain the level at their depth, and clears the
/// others. Of `splats`, only positions, `wanted` and, with errors, normals are used: unwanted
/// splats are skipped. @return whether any bit is set
bool stp_raster_pick_levels(const stp_raster_camera* camera, const stp_raster_splats* splats,
                            const uint32_t* ranges, const stp_raster_levels* levels,
                            uint16_t* bits);

/// Clears the bits of splats [begin, end) that the occluder hides (one bit per splat, from splat 0
/// on; `begin` is a multiple of 16). Splat sets only. @return whether any bit is left
bool stp_raster_test_splats(const stp_raster_splats* splats, uint16_t* bits);

/// Draws splats; splat i gets the id first_id + i. If there are bits per splat, `begin` must be a
/// multiple of 16. Only rows [row_begin, row_end) are touched.
/// @return fragments inside the drawn parts of splats, also where something nearer hides them
uint64_t stp_raster_draw_splats(const stp_raster_target* target, uint32_t row_begin,
                                uint32_t row_end, const stp_raster_camera* camera,
                                const stp_raster_splats* splats, uint32_t first_id);
