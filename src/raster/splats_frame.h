// SPDX-License-Identifier: MIT
//
// Constants of a call, and the rules for coverage, that all kernels of the splat rasteriser share.
#pragma once

#include "base/splats/coverage.h"
#include "base/splats/splat_codes.h"
#include "raster/splats.h"

#include <assert.h>
#include <string.h>

enum {
    SPLAT_BATCH = 16,
    SPLAT_BLOCK = 4,         ///< disks of at most this width and height are drawn as one block
    SPLAT_EXTENT_LIMIT = 512 ///< half a side; larger disks are drawn in double precision
};

#define SPLAT_MIN_NEARNESS 1e-30f
#define SPLAT_FAR 1e6f ///< pixels: centres are clamped to it, so that they fit an integer

typedef enum splat_kind {
    SPLAT_NONE,   ///< not drawn: outside the picture, or not wanted
    SPLAT_PIXEL,  ///< only the centre's pixel
    SPLAT_DISK,   ///< not classified further yet
    SPLAT_SMALL,  ///< within a block of 4 x 4 pixels inside the target
    SPLAT_WIDE,   ///< larger, or across the border of the target
    SPLAT_LARGE,  ///< close to the eye or very large
    SPLAT_HIDDEN, ///< behind the occluder
} splat_kind;

/// Constants of a call.
typedef struct stp_splat_frame {
    const stp_raster_target* target;
    const stp_raster_splats* splats;
    const stp_raster_camera* camera;
    int32_t row_begin, row_end;
    uint32_t first_id;
    float x[4], y[4], n[4], w[4]; ///< rows of the raster matrix after the position grid
    float turn[3][3];             ///< view rotation without its scale
    float radius_px;              ///< projected radius times W
    float pixels;                 ///< added to the projected radius
    float center_x, center_y;     ///< where the view axis meets the screen
    float inverse_scale;          ///< 1 / pixel_scale; 0 in parallel projection
    float slope_factor,
        slope_constant;          ///< change of nearness a pixel: factor * nearness + constant
    float rim_depth, back_depth; ///< in radii
    float near_w, far_w;         ///< disks with far_w < W < near_w are close to the eye
    float nearest, farthest;     ///< range of W that is drawn
    float nearness_limit;
    float beside[4];       ///< length of a step from a ball's centre to each side, per radius
    float occluder[3][4];  ///< rows of the occluder's matrix after the position grid
    float occluder_radius; ///< projected radius times its W
    uint32_t seed;         ///< added to a splat's index in the hash for holes
    /// NULL, or how transparent splats are drawn (splats_transparent.c)
    const struct stp_transparent_splats* glass;
} stp_splat_frame;

/// Sixteen splats. Lanes that are not drawn are undefined.
typedef struct splat_batch {
    float px[SPLAT_BATCH], py[SPLAT_BATCH], pz[SPLAT_BATCH]; ///< grid or object position
    int32_t part[SPLAT_BATCH];                               ///< drawn share of the disk, of 255
    int32_t halvings[SPLAT_BATCH]; ///< halvings of the radius: first wanted, then actual
    float size[SPLAT_BATCH];       ///< resulting factor on the radius
    float own[SPLAT_BATCH];        ///< the splat's own factor on the frame's radius; else 1
    uint32_t stretched;            ///< one bit per lane: not a disk
    float stretch[SPLAT_BATCH];    ///< stp_shape_stretch of stretched splats
    stp_shape_axis smaller[SPLAT_BATCH];
    uint32_t clips;            ///< one bit per lane: the disk is clipped
    uint8_t code[SPLAT_BATCH]; ///< coverage codes of clipped disks
    float ex[SPLAT_BATCH], ey[SPLAT_BATCH], low[SPLAT_BATCH],
        high[SPLAT_BATCH];                  ///< clipped disks: low <= ex u + ey v <= high
    float nu[SPLAT_BATCH], nv[SPLAT_BATCH]; ///< octahedral normal
    float sx[SPLAT_BATCH], sy[SPLAT_BATCH], nearness[SPLAT_BATCH], radius[SPLAT_BATCH];
    int32_t kind[SPLAT_BATCH], large[SPLAT_BATCH];
    int32_t x0[SPLAT_BATCH], y0[SPLAT_BATCH], x1[SPLAT_BATCH], y1[SPLAT_BATCH]; ///< box, inclusive
    int32_t cx[SPLAT_BATCH], cy[SPLAT_BATCH]; ///< the centre's pixel
    float u0[SPLAT_BATCH], v0[SPLAT_BATCH];   ///< centre of pixel (x0, y0) from the splat's centre
    float a[SPLAT_BATCH], b[SPLAT_BATCH], c[SPLAT_BATCH], p[SPLAT_BATCH], q[SPLAT_BATCH],
        limit[SPLAT_BATCH]; ///< the conic: u (a u + b v + p) + v (c v + q) <= limit
    float gx[SPLAT_BATCH], gy[SPLAT_BATCH],
        g_limit[SPLAT_BATCH]; ///< slope of nearness, and its clamp
    float rim[SPLAT_BATCH];   ///< loss of nearness towards the rim, by value of the conic
} splat_batch;

/// Transforms a row of a matrix by position = origin + step * value.
void stp_splats_fold_row(const float row[4], const stp_raster_splats* splats, float out[4]);

typedef uint64_t (*splat_kernel)(const stp_splat_frame* frame);
uint64_t stp_splats_draw_portable(const stp_splat_frame* frame);
uint64_t stp_splats_draw_vector(const stp_splat_frame* frame);
uint64_t stp_splats_draw_wide(const stp_splat_frame* frame);

/// stp_raster_test_splats, for a frame with only the fields the occluder needs.
bool stp_splats_test_portable(const stp_splat_frame* frame, uint16_t* bits);
bool stp_splats_test_vector(const stp_splat_frame* frame, uint16_t* bits);
bool stp_splats_test_wide(const stp_splat_frame* frame, uint16_t* bits);
void stp_splats_test_frame(stp_splat_frame* frame, const stp_raster_splats* splats);

/// Draws splat `index` with a ray per pixel in double precision.
uint64_t stp_splats_draw_large(const stp_splat_frame* frame, uint32_t index);
/// Draws a fragment of a transparent splat of `frame->glass`. @return whether it was kept
bool stp_transparent_store(const stp_splat_frame* frame, uint32_t index, int32_t x, int32_t y,
                           float nearness);
bool stp_splats_make_frame(stp_splat_frame* frame, const stp_raster_target* target,
                           uint32_t row_begin, uint32_t row_end, const stp_raster_camera* camera,
                           const stp_raster_splats* splats, uint32_t first_id);

/// Factor on the radius of a splat without a shape.
static inline float splat_growth(const stp_raster_splats* splats, uint32_t index)
{
    return splats->materials != NULL
               ? 1.0f + splats->growths[splats->materials[index]] * splats->growth_share
               : 1.0f;
}

/// Whether a fragment of a splat with holes is kept. Hashes the splat (index and seed) and the
/// fragment's place in it, so that holes move with the surface.
static inline bool splat_has_fragment(uint32_t coverage, uint32_t index, int32_t dx, int32_t dy)
{
    uint32_t h = index * 0x9E3779B1u + 0x7F4A7C15u;
    h ^= (uint32_t)dx * 0x85EBCA6Bu + (uint32_t)dy * 0xC2B2AE35u;
    h ^= h >> 15;
    h *= 0x2C1B3C6Du;
    h ^= h >> 13;
    h *= 0x297A2D39u;
    return h >> 24 < coverage + (coverage >> 7);
}

/// How often to halve the radius of a disk with a small coverage (of 255).
static inline uint32_t splat_halvings(uint32_t coverage)
{
    return (uint32_t)(coverage < 64) + (uint32_t)(coverage < 16) + (uint32_t)(coverage < 4);
}

static inline uint8_t splat_code(const stp_raster_splats* splats, uint8_t code)
{
    return splats->plain_coverages ? stp_coverage_of_plain[code] : code;
}

/// Coverage of a splat's disk, between those of two octaves: a share of 255 or, from SPLAT_CLIP on,
/// a clipping code.
#define SPLAT_CLIP 256u
static inline uint32_t splat_part(const stp_raster_splats* splats, uint32_t index)
{
    if (splats->coverages == NULL) {
        return 255u;
    }
    uint8_t own = splat_code(splats, splats->coverages[index]);
    if (index < splats->low_count) {
        uint8_t low = splat_code(splats, splats->low_coverages[index]);
        uint32_t share = splats->low_share;
        if (!stp_coverage_clips(own) && !stp_coverage_clips(low)) {
            uint32_t part = stp_coverage_share(own), other = stp_coverage_share(low);
            return (other * share + part * (256u - share) + 128u) >> 8;
        }
        own = (index * 0x9E3779B1u + 0x7F4A7C15u) >> 24 < share ? low : own;
    }
    return stp_coverage_clips(own) ? SPLAT_CLIP + own : stp_coverage_share(own);
}

/// Share of its centre's pixel that a clipped splat draws, of 255.
static inline uint32_t splat_clip_share(uint32_t part)
{
    assert(part > SPLAT_CLIP && stp_coverage_clips((uint8_t)(part - SPLAT_CLIP)));
    return (uint32_t)(stp_coverage_area((uint8_t)(part - SPLAT_CLIP)) * 255.0f + 0.5f);
}

/// Share of a splat's pixels that is drawn after halving its radius, of 255.
static inline uint32_t splat_coverage(const stp_raster_splats* splats, uint32_t part,
                                      int32_t halvings)
{
    uint32_t coverage = part << 2 * halvings;
    assert(halvings >= 0 && coverage <= 255u && "halvings keep the drawn area");
    return splats->share > 0.0f ? (uint32_t)((float)coverage * splats->share + 0.5f) : coverage;
}

/// Twice the radius, in pixels, that halving must leave. Varies per splat, so that not all shrink
/// at the same depth.
static inline float splat_min_diameter(uint32_t index)
{
    return 1.5f + (float)(index * 0x9E3779B1u >> 24) * (1.5f / 256.0f);
}

static inline void splat_store(uint64_t* pixel, uint64_t value)
{
    if (value < *pixel) {
        *pixel = value;
    }
}
