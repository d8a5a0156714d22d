// SPDX-License-Identifier: MIT
// Measurements between points of a scene, in the unit and axes of the source file.
// Measures between points of a scene, in the unit and with the axes of the file it came from.
#pragma once

#include "base/math.h"

/// Unit and up axis of the source file (internally, y is up).
typedef struct stp_measuring {
    double unit_metres; ///< 0: unknown
    /// Metres per displayed unit; 0, or if the file's unit is unknown: the file's own unit.
    double shown_metres;
    char up; ///< 'x', 'y' or 'z'
} stp_measuring;

typedef struct stp_distance {
    double length;     ///< lengths are in units of the file
    double horizontal; ///< its part along the ground
    double height;     ///< of the second point above the first
    double slope;      ///< degrees above the horizon, -90 to 90; 0 where length is 0
} stp_distance;

stp_distance stp_measure_distance(stp_vec3d from, stp_vec3d to);

/// Angle between the directions from `corner` to two points: 0 to 180 degrees; 0 if either
/// coincides with `corner`.
double stp_measure_angle(stp_vec3d from, stp_vec3d corner, stp_vec3d to);

/// Area of a polygon's projection along its normal (Newell's method), and its perimeter; the area
/// is 0 for fewer than 3 points.
double stp_measure_area(const stp_vec3d* points, size_t count, double* circumference);

/// Coordinates of a point in the axes of the file. The inverse of the importer's up-axis
/// conversion.
stp_vec3d stp_measure_coordinates(const stp_measuring* measuring, stp_vec3d point);

/// Factor from lengths of the file to lengths in the displayed unit.
double stp_measure_factor(const stp_measuring* measuring);

/// Name of the displayed unit: "m", "mm", "cm", "km", "in", "ft", "yd", "mi", "us-ft"; "" if it is
/// none of these or unknown.
const char* stp_measure_unit(const stp_measuring* measuring);

/// "12.345 m": a length with its unit and `digits` significant digits (1 to 17), truncated to
/// `size` bytes.
void stp_measure_text(const stp_measuring* measuring, double length, int digits, char* text,
                      size_t size);
