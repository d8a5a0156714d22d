// SPDX-License-Identifier: MIT
// The sweep of a simulated scanner. A standing scanner turns around the vertical; each column goes
// upwards from 60 degrees below the horizon to the zenith, with equal angles. A flying scanner
// looks down; each column goes from 30 degrees left to 30 degrees right.
#pragma once

#include "lab/scan/scan_target.h"

/// Settings of the scanner.
typedef struct scan_settings {
    bool airborne;
    uint32_t columns; ///< columns per sweep
    uint32_t rows;    ///< rays per column
    double noise;     ///< standard deviation of ranges, metres
    double range;     ///< nothing farther is met, metres
    double half;      ///< distance at which half of the light comes back, metres
    uint64_t seed;
} scan_settings;

/// A sweep: from a station, or along a line of flight.
typedef struct scan_station {
    uint32_t number; ///< from 1
    uint32_t columns, rows;
    stp_vec3d place; ///< metres, z up, without the file's shift
    stp_vec3d along; ///< flight line: horizontal vector from `place` to its end; else 0
} scan_station;

/// Sets the rows, and the columns of a standing scanner.
/// @param resolution up to 30: degrees between rays; above: rays per turn.
/// @return degrees between rays
double scan_settings_set_resolution(scan_settings* settings, double resolution);

/// Result of one ray.
typedef struct scan_point {
    bool hit;
    uint16_t intensity; ///< 65535: all light comes back
    uint8_t color[3];   ///< sRGB
    uint32_t row;       ///< from below, or from the left
    uint32_t column;    ///< index within the turn, or along the flight
    uint32_t object;    ///< ground truth: which use of a mesh
    float normal[3];    ///< ground truth: surface normal, facing the scanner
    float range_error;  ///< ground truth: measured minus true distance, metres
    float angle;        ///< degrees: elevation, or from below the flight to the right
    double place[3];    ///< as measured, metres, z up
    double time;        ///< number of the ray, over all stations
} scan_point;

/// The ray of a cell.
typedef struct scan_ray {
    stp_vec3d origin, direction; ///< z up, unit length
    double angle;                ///< as scan_point has it
} scan_ray;

scan_ray scan_ray_of(const scan_settings* settings, const scan_station* station, uint32_t column,
                     uint32_t row);

/// Sweeps `count` columns starting at `first`, column by column, each with `rows` points. The
/// result does not depend on the number of threads.
void scan_sweep(const scan_target* target, const scan_settings* settings,
                const scan_station* station, uint32_t first, uint32_t count, scan_point* points);

// Chooses the stations of a simulated scanner, so that each sees much that the others do not.

enum { SCAN_MAX_STATIONS = 256 };

typedef struct scan_placing {
    uint32_t count; ///< number of stations, 1..SCAN_MAX_STATIONS
    double height;  ///< above the floor, metres; 0: 1.8, in small models a tenth of their diagonal
    double range;   ///< nothing farther is seen, metres
    uint64_t seed;
} scan_placing;

/// Chooses stations on floors with free space, or around the model if more is visible from there.
/// The result does not depend on the number of threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result scan_place_stations(const scan_target* target, const scan_placing* placing,
                                            stp_vec3d* stations);

/// Plans parallel flight lines along the model that overlap by a fifth above its highest point, and
/// sets the columns of a sweep so that rays are equally far apart along and across the flight.
/// @param height above the highest point, metres; 0: chosen for that overlap
/// @param step degrees between rays
/// @return STP_OK, or STP_ERROR_LIMIT (more than 65,535 columns; logged)
STP_MUST_USE stp_result scan_plan_flight(const scan_target* target, double height, double step,
                                         uint32_t count, scan_settings* settings,
                                         scan_station* lines);
