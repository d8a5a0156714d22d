// SPDX-License-Identifier: MIT
//
// Measures between points of a scene, in the unit and with the axes of the file it came from. Any thread.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How to read a scene's numbers: unit and up axis of the file (inside, y is up).
typedef struct stp_measuring {
    double unit_metres; ///< metres of one unit of the file; 0: unknown
    /// Metres of the unit that texts use; 0, or where the file's is unknown: the file's own.
    double shown_metres;
    char up; ///< 'x', 'y' or 'z'
} stp_measuring;

typedef struct stp_distance {
    double length;     ///< all lengths in units of the file
    double horizontal; ///< its part along the ground
    double height;     ///< the second point above the first
    double slope;      ///< degrees above the horizon, -90 to 90; 0 where length is 0
} stp_distance;

STP_API stp_distance stp_measure_distance(stp_vec3d from, stp_vec3d to);

/// The angle at `corner` between the directions to two other points: 0 to 180 degrees; 0 where one of them is the
/// corner itself.
STP_API double stp_measure_angle(stp_vec3d from, stp_vec3d corner, stp_vec3d to);

/// Area of a polygon's projection along its own normal (Newell's), and its circumference. Below 3 points the area
/// is 0.
STP_API double stp_measure_area(const stp_vec3d* points, size_t count, double* circumference);

/// A point's coordinates as the file has them: with its own up axis.
STP_API stp_vec3d stp_measure_coordinates(const stp_measuring* measuring, stp_vec3d point);

/// "12.345 m": a length (units of the file) with its unit, `digits` significant digits (1 to 17), cut to `size`
/// bytes including the final zero.
STP_API void stp_measure_text(const stp_measuring* measuring, double length, int digits, char* text,
                              size_t size);

#ifdef __cplusplus
}
#endif
