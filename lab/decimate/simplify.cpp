// SPDX-License-Identifier: MIT
#include "lab/decimate/simplify.h"

#include <assert.h>
#include <exception>
#include <meshoptimizer.h>

namespace
{
const size_t stride = 3 * sizeof(float);
const float any_error = 1e9f; // relative to the model's size: only the count ends it
} // namespace

uint64_t stp_simplify_bytes(size_t index_count, size_t vertex_count)
{
    return 40 * static_cast<uint64_t>(index_count) + 160 * static_cast<uint64_t>(vertex_count);
}

int stp_simplify_weld(uint32_t* out, const uint32_t* indices, size_t index_count,
                      const float* positions, size_t vertex_count)
{
    try {
        meshopt_generateShadowIndexBuffer(out, indices, index_count, positions, vertex_count,
                                          stride, stride);
        return 0;
    } catch (const std::exception&) {
        return -1;
    }
}

int stp_simplify_triangles(uint32_t* out, size_t* out_count, const uint32_t* indices,
                           size_t index_count, const float* positions, size_t vertex_count,
                           size_t wanted)
{
    assert(index_count % 3 == 0 && "whole triangles");
    try {
        *out_count =
            meshopt_simplify(out, indices, index_count, positions, vertex_count, stride,
                             wanted < index_count ? wanted : index_count, any_error, 0, nullptr);
        return 0;
    } catch (const std::exception&) {
        *out_count = 0;
        return -1;
    }
}
