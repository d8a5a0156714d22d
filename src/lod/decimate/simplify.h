// SPDX-License-Identifier: MIT
// libmeshoptimizer's simplifier, which is C++ and may throw.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Bytes that the calls below take at most, about.
uint64_t stp_simplify_bytes(size_t index_count, size_t vertex_count);

/// Makes triangles that use the first of vertices in one place. @return 0, or -1 where memory ran
/// out
int stp_simplify_weld(uint32_t* out, const uint32_t* indices, size_t index_count,
                      const float* positions, size_t vertex_count);

/// Collapses edges, of least quadric error first, until `wanted` indices are left, or none can be
/// collapsed. Vertices stay where they are.
/// @param out room for index_count. @param out_count receives how many are left
/// @return 0, or -1 where memory ran out
int stp_simplify_triangles(uint32_t* out, size_t* out_count, const uint32_t* indices,
                           size_t index_count, const float* positions, size_t vertex_count,
                           size_t wanted);

#ifdef __cplusplus
}
#endif
