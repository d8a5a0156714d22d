// SPDX-License-Identifier: MIT
// Helpers for the sets of all methods.
#pragma once

#include "base/core/context.h"
#include "base/splats/splat_columns.h"

#include <assert.h>

/// Frees the columns of a set, which were allocated with stp_alloc.
void stp_splats_destroy(stp_context* context, stp_splats* surfels);

/// Allocates the columns of a set of `count` splats with shapes and flat colours, and with ranges
/// if `columns` includes them.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_splats_destroy, also after a
/// failure
STP_MUST_USE stp_result stp_splats_make_columns(stp_context* context, stp_splats* splats);

/// Copies values of an attribute between columns: that at from[i] to place to[i], or to place i if
/// `to` is NULL.
void stp_copy_attribute(stp_attribute attribute, const void* column, const uint32_t* from,
                        size_t count, void* to_column, const uint32_t* to);

/// Rounds a coordinate to the position grid of a set.
static inline uint16_t stp_splats_grid_place(float at, float origin, float step)
{
    assert(step > 0.0f);
    float place = (at - origin) / step + 0.5f;
    return place > 0.0f ? (place < 65535.0f ? (uint16_t)place : 65535) : 0;
}
