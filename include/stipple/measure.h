// SPDX-License-Identifier: MIT
//
// Measurements between points of a scene, in the source file's unit and axes. Callable from any
// thread.
#pragma once

#include <stipple/types.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Unit and up axis of the source file (inside the library, y is up). Where a function takes a
/// pointer to it, NULL means no unit and y.
typedef struct stp_measuring {
    double unit_metres; ///< metres per unit of the file; 0: unknown
    /// Metres per unit of formatted texts; 0, or if the file's unit is unknown: the file's unit.
    double shown_metres;
    char up; ///< 'x', 'y' or 'z'
} stp_measuring;

typedef struct stp_distance {
    double length;     ///< all lengths in units of the file
    double horizontal; ///< horizontal component
    double height;     ///< height of the second point above the first
    double slope;      ///< degrees above the horizon, -90 to 90; 0 where length is 0
} stp_distance;

STP_API stp_distance stp_measure_distance(stp_vec3d from, stp_vec3d to);

/// The angle at `corner` between the directions to two other points: 0 to 180 degrees; 0 if one of
/// them equals the corner.
STP_API double stp_measure_angle(stp_vec3d from, stp_vec3d corner, stp_vec3d to);

/// Area of a polygon projected along its own normal (Newell's), and its perimeter (may be NULL). The
/// area of fewer than 3 points is 0.
STP_API double stp_measure_area(const stp_vec3d* points, size_t count, double* perimeter);

/// Coordinates of a point in the file's axes.
STP_API stp_vec3d stp_measure_coordinates(const stp_measuring* measuring, stp_vec3d point);

/// Formats a length in units of the file as "12.345 m", with `digits` significant digits (1 to 17).
/// Truncates to `size` bytes, including the final zero.
STP_API void stp_measure_text(const stp_measuring* measuring, double length, int digits, char* text,
                              size_t size);

#ifdef __cplusplus
}
#endif
