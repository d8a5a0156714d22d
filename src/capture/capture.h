// SPDX-License-Identifier: MIT
//
// External visibility (Brandt 3.1): a subtree seen from outside, by parallel projection from all around. Each
// covered pixel is a candidate: a point of visible surface that may become a surfel.
#pragma once

#include "scene/scene.h"

typedef struct stp_capture_desc {
    uint32_t direction_count; ///< default 8: the box's corners. 14: and its faces. 26: and its edges' middles.
                              ///< Any other: well spread over the sphere.
    uint32_t resolution;      ///< pixels along the longer side of the widest picture; one scale for all
                              ///< directions. Default: chosen so that about `wanted_candidates` come out.
    uint64_t wanted_candidates; ///< for the automatic resolution; default 1.75 million
} stp_capture_desc;

/// Candidates as columns, in a fixed order (direction, row, column): independent of threads.
typedef struct stp_candidates {
    uint32_t count;
    float* positions;    ///< 3 each, in the node's space minus `origin`
    float* normals;      ///< 3 each, unit, facing the viewer
    uint8_t* colors;     ///< RGBA each, sRGB: base colour with texture and vertex colour; alpha of a blended one
    uint32_t* materials; ///< scene material
    stp_vec3d origin;    ///< centre of the captured box: positions are relative to it
    double pixel_size;   ///< side of a capture pixel, scene units
    uint32_t resolution, direction_count;
    uint64_t covered_pixels, triangle_views; ///< for reports
    double raster_ms, resolve_ms;
} stp_candidates;

/// Captures the parts (their transforms relative to the captured node's space).
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_capture_parts(const stp_scene* scene, const stp_placed_part* parts,
                                          size_t part_count, const stp_capture_desc* desc,
                                          stp_candidates* candidates);
void stp_candidates_destroy(stp_context* context, stp_candidates* candidates);

/// The directions a desc stands for: unit vectors from the object towards the viewer, `count` of them, for a
/// box of the given half extents. Pure; no libm.
void stp_capture_directions(uint32_t count, stp_vec3d half_extent, stp_vec3d* directions);
