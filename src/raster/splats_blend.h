// SPDX-License-Identifier: MIT
//
// A splat filter, in two passes after the visibility buffer: first the plane that each pixel shows, that of its own splat;
// then all splats whose planes agree with it are added up, weighted by how close to their centres the pixel lies
// (Zwicker et al. 2001; Botsch et al. 2005).
//
// A plane is written by the one splat that is visible there. Sums are of whole numbers and additions atomic. So neither
// depends on who does it when.
#pragma once

#include "raster/splat_texture.h"
#include "raster/splats.h"

#include <stdatomic.h>

enum {
    STP_BLEND_COLORS = 16384, ///< values of a channel
    STP_BLEND_WEIGHT = 64,    ///< in the middle of a disk
};
/// Sums of weights up to here are of colours that cannot have overflowed.
#define STP_BLEND_LIMIT (UINT32_MAX / STP_BLEND_COLORS)

/// How far from a pixel's plane a splat's may lie there, in radii. What lies farther off is another thing.
#define STP_BLEND_AWAY 1.5f

/// What a pixel shows.
typedef struct stp_raster_plane {
    uint32_t id;    ///< of the splat that is visible; UINT32_MAX: none
    float nearness; ///< of its plane, at the pixel; FLT_MAX: not known
    float right,
        down; ///< change of nearness a pixel; not numbers: a splat too small to have a plane
} stp_raster_plane;

typedef struct stp_raster_blend {
    uint32_t width, height;
    stp_raster_plane* planes; ///< of each pixel
    uint32_t first_id;        ///< of splat 0
    // For stp_raster_blend_splats:
    _Atomic uint64_t*
        sums; ///< two a pixel: red and green, blue and weight, the latter in the upper halves
    /// The colours of up to 16 splats whose centres are at (x, y) on the screen: values below STP_BLEND_COLORS.
    void (*colors)(void* user, uint32_t first, uint32_t count, const float* x, const float* y,
                   uint32_t (*out)[3]);
    void* user;
    const stp_splat_texture* texture; ///< of weights; NULL: nearly a Gaussian
} stp_raster_blend;

/// Fills in the planes of pixels that show one of the splats. Those that are hundreds of pixels wide or close to the eye are
/// left out, here and below. `splats` as for stp_raster_draw_splats, without occluder and `hidden`.
void stp_raster_find_planes(const stp_raster_blend* blend, const stp_raster_camera* camera,
                            const stp_raster_splats* splats);

/// Adds splats to the pixels whose planes they belong to. An occluder may be made of the planes' nearness, where splats count as
/// STP_BLEND_AWAY radii nearer.
void stp_raster_blend_splats(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats);
