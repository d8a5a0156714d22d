// SPDX-License-Identifier: MIT
// Methods that replace many points by few splats, to compare with Progressive Splatting (Wu, Zhang,
// Kobbelt 2005, 6).
#pragma once

#include "base/context.h"
#include "lod/psp/ellipse.h"

/// What is replaced. Arrays belong to the caller and are only read.
typedef struct stp_decimate_input {
    uint32_t count;
    const float* positions;    ///< 3 a point; finite
    const float* normals;      ///< NULL, or 3 a point: unit, or zero where unknown
    const uint8_t* colors;     ///< NULL: white, or 3 a point, sRGB
    const uint32_t* triangles; ///< NULL, or 3 point indices each; used by `mesh` alone
    uint32_t triangle_count;
} stp_decimate_input;

/// What replaces it. Freed by stp_decimate_output_destroy, also after a failure.
typedef struct stp_decimate_output {
    stp_ellipse* ellipses;
    uint8_t* colors; ///< 3 a splat or, of `mesh`, 3 a vertex; sRGB
    uint32_t count;  ///< of splats
    // of `mesh` alone; then `count` is 0
    float* vertices; ///< 3 a vertex
    uint32_t vertex_count;
    uint32_t* triangles; ///< 3 vertices each
    uint32_t triangle_count;
} stp_decimate_output;

/// Replaces points by about `target` splats; each decimator says how near it comes. Deterministic:
/// the same bytes for any number of threads.
/// @param target at least 1
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, STP_ERROR_LIMIT (2^30 points and
///         more), STP_ERROR_ARGUMENT (`mesh`
///         without triangles); all logged
typedef stp_result (*stp_decimate_function)(stp_context* context, const stp_decimate_input* input,
                                            uint32_t target, stp_decimate_output* output);

/// One ellipse for each cell of an octree (Pajarola 2003). The largest cell is opened first, until
/// no cell can be opened without passing `target`: at least target - 6 splats, where there are so
/// many cells with different points.
STP_MUST_USE stp_result stp_decimate_by_octree(stp_context* context,
                                               const stp_decimate_input* input, uint32_t target,
                                               stp_decimate_output* output);
/// One ellipse for each cell of one level of the octree (Wu, Zhang, Kobbelt 2005, 6.1): that whose
/// number of cells is nearest to `target`.
STP_MUST_USE stp_result stp_decimate_by_octree_level(stp_context* context,
                                                     const stp_decimate_input* input,
                                                     uint32_t target, stp_decimate_output* output);
/// Pairs of neighbouring points are contracted by quadric error (Pauly, Gross, Kobbelt 2002, 3.2).
STP_MUST_USE stp_result stp_decimate_by_quadric(stp_context* context,
                                                const stp_decimate_input* input, uint32_t target,
                                                stp_decimate_output* output);
/// Edges of the triangles are collapsed by quadric error (Garland, Heckbert 1997), by
/// libmeshoptimizer, until `target` vertices are left. There may be a few more or fewer at borders,
/// and many more where no edge can be collapsed without changing what is connected. Vertices keep
/// their places and colours. The same bytes on any machine need the same libmeshoptimizer.
STP_MUST_USE stp_result stp_decimate_by_mesh(stp_context* context, const stp_decimate_input* input,
                                             uint32_t target, stp_decimate_output* output);
/// The first points of the exact order, each as wide as the points nearest to it need.
STP_MUST_USE stp_result stp_decimate_by_blue(stp_context* context, const stp_decimate_input* input,
                                             uint32_t target, stp_decimate_output* output);
/// Splats are chosen to cover all points, then moved (Wu, Kobbelt 2004).
STP_MUST_USE stp_result stp_decimate_by_subsample(stp_context* context,
                                                  const stp_decimate_input* input, uint32_t target,
                                                  stp_decimate_output* output);

void stp_decimate_output_destroy(stp_context* context, stp_decimate_output* output);
