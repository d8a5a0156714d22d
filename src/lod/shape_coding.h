// SPDX-License-Identifier: MIT
// Codes of elliptical splats (base/splats/splat_codes.h).
#pragma once

#include "base/splats/splat_codes.h"

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
