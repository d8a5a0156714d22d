// SPDX-License-Identifier: MIT
//
// A splat filter in two passes after the visibility buffer. The first stores the plane that each
// pixel shows: that of its visible splat. The second sums all splats whose planes agree with it,
// weighted by how close to their centres the pixel lies (Zwicker et al. 2001; Botsch et al. 2005).
//
// Only the visible splat writes a pixel's plane. Sums are integers and additions atomic. So neither
// depends on the order of threads.
#pragma once

#include "raster/splat_texture.h"
#include "raster/splats.h"

#include <stdatomic.h>

enum {
    STP_BLEND_COLORS = 16384, ///< values of a channel
    STP_BLEND_WEIGHT = 64,    ///< at the centre of a disk
};
/// Up to this sum of weights, the colour sums cannot have overflowed.
#define STP_BLEND_LIMIT (UINT32_MAX / STP_BLEND_COLORS)

/// Tolerance between a pixel's plane and a splat's, in radii. Splats farther off belong to another
/// surface.
#define STP_BLEND_AWAY 1.5f

/// Surface shown by a pixel.
typedef struct stp_raster_plane {
    uint32_t id;    ///< id of the visible splat; UINT32_MAX: none
    float nearness; ///< nearness of its plane at the pixel; FLT_MAX: unknown
    float right,
        down; ///< change of nearness per pixel; NaN: a splat too small to have a plane
} stp_raster_plane;

typedef struct stp_raster_blend {
    uint32_t width, height;
    stp_raster_plane* planes; ///< one per pixel
    uint32_t first_id;        ///< id of splat 0
    // For stp_raster_blend_splats:
    /// Two a pixel: red and green, blue and weight, the latter in the upper halves
    _Atomic uint64_t* sums;
    /// Writes the colours of up to 16 splats whose centres are at (x, y) on the screen to `out`:
    /// values below STP_BLEND_COLORS.
    void (*colors)(void* user, uint32_t first, uint32_t count, const float* x, const float* y,
                   uint32_t (*out)[3]);
    void* user;
    const stp_splat_texture* texture; ///< texture of weights; NULL: nearly a Gaussian
} stp_raster_blend;

/// Stores the planes of pixels that show one of the splats. Splats hundreds of pixels wide or close
/// to the eye are skipped, here and below. `splats` as for stp_raster_draw_splats, without occluder
/// and `hidden`.
void stp_raster_find_planes(const stp_raster_blend* blend, const stp_raster_camera* camera,
                            const stp_raster_splats* splats);

/// Adds splats to the pixels whose planes they match. An occluder may be built from the planes'
/// nearness, with splats counting as STP_BLEND_AWAY radii nearer.
void stp_raster_blend_splats(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats);
