// SPDX-License-Identifier: MIT
// Columns, octaves, prefix tables and shape codes of sets, for all methods.
#pragma once

#include "base/core/context.h"
#include "base/splats/splat_codes.h"
#include "base/splats/splat_columns.h"

#include <assert.h>

/// Frees the columns of a set, which were allocated with stp_alloc.
void stp_splats_destroy(stp_context* context, stp_splats* splats);

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

// Octaves and prefix tables of sets whose splats have ranges of levels.

/// Sets the octave ends of a set of `count` splats. Octaves grow fourfold.
void stp_set_octaves_make(stp_splats* set);

/// Fills the prefix table of a set with octaves. A prefix reaches the highest level of the splats
/// after it, rounded up as ranges are.
/// @param highest_left for each splat an upper bound, never rising, of the highest levels of it and
///         all after it
/// @param scale factor from those bounds to levels
/// @param reach the level that all splats reach
void stp_set_table_make(stp_splats* set, const float* highest_left, float scale, float reach);

// Codes of elliptical splats (base/splats/splat_codes.h).

enum { STP_SHAPE_GUESSES = 256 };

/// Directions of the smaller radius by their codes.
typedef struct stp_shape_directions {
    stp_shape_axis smaller[STP_SHAPE_TURN];
    uint8_t guesses[STP_SHAPE_GUESSES]; ///< codes from which to search, by the slope of the axis
} stp_shape_directions;

void stp_shape_directions_make(stp_shape_directions* directions);

/// Code whose smaller radius is most nearly perpendicular to an axis; the lower one on ties.
uint32_t stp_shape_direction(const stp_shape_directions* directions, stp_shape_axis along);

/// Code of an ellipse in a set without marks for large triangles. A disk may represent any normals.
/// @param larger, smaller radii in steps of the set
/// @param major direction of the larger radius, of any length
/// @param normal octahedral code of the splat's normal
uint32_t stp_shape_of_ellipse(const stp_shape_directions* directions, float larger, float smaller,
                              stp_vec3 major, const int8_t normal[2]);
/// The same, from the codes of the radii (stp_shape_code).
uint32_t stp_shape_of_codes(const stp_shape_directions* directions, uint32_t larger,
                            uint32_t smaller, stp_vec3 major, const int8_t normal[2]);
