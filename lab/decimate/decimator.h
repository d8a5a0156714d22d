// SPDX-License-Identifier: MIT
// Methods that replace many points by few splats, to compare with Progressive Splatting (Wu, Zhang,
// Kobbelt 2005, 6).
#pragma once

#include "base/core/context.h"
#include "lod/psp/ellipse.h"

/// Input. Arrays belong to the caller and are only read.
typedef struct stp_decimate_input {
    uint32_t count;
    const float* positions;    ///< 3 per point; finite
    const float* normals;      ///< NULL, or 3 per point: unit, or zero if unknown
    const uint8_t* colors;     ///< NULL: white, or 3 per point, sRGB
    const uint32_t* triangles; ///< NULL, or 3 point indices each; used only by `mesh`
    uint32_t triangle_count;
} stp_decimate_input;

/// Output. Freed by stp_decimate_output_destroy, also after a failure.
typedef struct stp_decimate_output {
    stp_ellipse* ellipses;
    uint8_t* colors; ///< 3 per splat or, for `mesh`, 3 per vertex; sRGB
    uint32_t count;  ///< number of splats
    // only for `mesh`; then `count` is 0
    float* vertices; ///< 3 per vertex
    uint32_t vertex_count;
    uint32_t* triangles; ///< 3 vertex indices each
    uint32_t triangle_count;
} stp_decimate_output;

/// Replaces points by about `target` splats; each decimator documents its accuracy. Deterministic:
/// the same bytes for any number of threads.
/// @param target at least 1
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, STP_ERROR_LIMIT (more than 2^30
///         points; `subsample`: 2^27 or more), STP_ERROR_ARGUMENT (`mesh` without triangles); all
///         logged
typedef stp_result (*stp_decimate_function)(stp_context* context, const stp_decimate_input* input,
                                            uint32_t target, stp_decimate_output* output);

/// One ellipse per cell of an octree (Pajarola 2003). Opens the largest cell first, until no cell
/// can be opened without exceeding `target`: at least target - 6 splats, if there are that many
/// cells with distinct points.
STP_MUST_USE stp_result stp_decimate_by_octree(stp_context* context,
                                               const stp_decimate_input* input, uint32_t target,
                                               stp_decimate_output* output);
/// One ellipse per cell of one octree level (Wu, Zhang, Kobbelt 2005, 6.1): the level whose number
/// of cells is nearest to `target`.
STP_MUST_USE stp_result stp_decimate_by_octree_level(stp_context* context,
                                                     const stp_decimate_input* input,
                                                     uint32_t target, stp_decimate_output* output);
/// Contracts pairs of neighbouring points by quadric error (Pauly, Gross, Kobbelt 2002, 3.2).
STP_MUST_USE stp_result stp_decimate_by_quadric(stp_context* context,
                                                const stp_decimate_input* input, uint32_t target,
                                                stp_decimate_output* output);
/// Collapses edges of the welded triangles by quadric error (Garland, Heckbert 1997;
/// lod/levels/collapse.h), until `target` vertices are left, or one or two fewer. More remain only
/// if every collapse would turn a triangle over. Vertices move; each keeps the mean colour of the
/// points that were at one of its places.
STP_MUST_USE stp_result stp_decimate_by_mesh(stp_context* context, const stp_decimate_input* input,
                                             uint32_t target, stp_decimate_output* output);
/// The first points of the exact order, each wide enough for the points nearest to it.
STP_MUST_USE stp_result stp_decimate_by_blue(stp_context* context, const stp_decimate_input* input,
                                             uint32_t target, stp_decimate_output* output);
/// Chooses splats that cover all points, then moves them (Wu, Kobbelt 2004).
STP_MUST_USE stp_result stp_decimate_by_subsample(stp_context* context,
                                                  const stp_decimate_input* input, uint32_t target,
                                                  stp_decimate_output* output);

void stp_decimate_output_destroy(stp_context* context, stp_decimate_output* output);
