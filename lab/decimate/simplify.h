// SPDX-License-Identifier: MIT
// libmeshoptimizer's simplifier, which is C++ and may throw.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Approximate maximum memory of the calls below, in bytes.
uint64_t stp_simplify_bytes(size_t index_count, size_t vertex_count);

/// Makes triangles use one common vertex of coincident ones. @return 0, or -1 if out of memory
int stp_simplify_weld(uint32_t* out, const uint32_t* indices, size_t index_count,
                      const float* positions, size_t vertex_count);

/// Collapses edges, least quadric error first, until `wanted` indices are left, or none can be
/// collapsed. Vertices keep their positions.
/// @param out space for `index_count` indices
/// @param out_count receives the remaining number of indices
/// @return 0, or -1 if out of memory
int stp_simplify_triangles(uint32_t* out, size_t* out_count, const uint32_t* indices,
                           size_t index_count, const float* positions, size_t vertex_count,
                           size_t wanted);

#ifdef __cplusplus
}
#endif
