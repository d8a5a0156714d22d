// SPDX-License-Identifier: MIT
//
// Measures between points of a scene, in the unit and with the axes of the file it came from.
#pragma once

#include "base/math.h"

/// How a scene's numbers are read: the unit of the file, and the axis that it has upwards (inside, y is up).
typedef struct stp_measuring {
    double unit_metres; ///< 0: unknown
    /// Metres of the unit that lengths are shown in; 0, or where the file's is unknown: the file's own.
    double shown_metres;
    char up; ///< 'x', 'y' or 'z'
} stp_measuring;

typedef struct stp_distance {
    double length;     ///< all lengths in units of the file
    double horizontal; ///< its part along the ground
    double height;     ///< the second point above the first
    double slope;      ///< degrees above the horizon, -90 to 90; 0 where length is 0
} stp_distance;

stp_distance stp_measure_distance(stp_vec3d from, stp_vec3d to);

/// Between the ways from `corner` to two other points: 0 to 180 degrees; 0 where one of them is none.
double stp_measure_angle(stp_vec3d from, stp_vec3d corner, stp_vec3d to);

/// Area of a polygon's projection along its own normal (Newell's), and its circumference; below 3 points the area is 0.
double stp_measure_area(const stp_vec3d* points, size_t count, double* circumference);

/// A point's coordinates as the file had them: its up axis is undone. The inverse of what importing does.
stp_vec3d stp_measure_coordinates(const stp_measuring* measuring, stp_vec3d point);

/// Factor from lengths of the file to lengths in the unit that is shown.
double stp_measure_factor(const stp_measuring* measuring);

/// Name of the unit that is shown: "m", "mm", "cm", "km", "in", "ft", "yd", "mi", "us-ft"; "" where the unit is none of these or unknown.
const char* stp_measure_unit(const stp_measuring* measuring);

/// "12.345 m": a length with its unit, `digits` significant digits (1 to 17), cut to `size` bytes.
void stp_measure_text(const stp_measuring* measuring, double length, int digits, char* text,
                      size_t size);
