// SPDX-License-Identifier: MIT
// The sweep of a simulated scanner: it turns around the vertical, and at each column looks from 60 degrees below
// the horizon to the zenith, upwards, with equal angles.
#pragma once

#include "scan_target.h"

/// What the scanner is told.
typedef struct scan_settings {
    uint32_t columns; ///< rays a turn
    uint32_t rows;    ///< rays of a column
    double noise;     ///< standard deviation of ranges, metres
    double range;     ///< nothing farther is met, metres
    uint64_t seed;
} scan_settings;

/// Sets columns and rows. @param resolution  up to 30: degrees between rays; above: rays a turn
void scan_settings_set_resolution(scan_settings* settings, double resolution);

/// What came of one ray.
typedef struct scan_point {
    bool hit;
    uint16_t intensity; ///< 65535: all light comes back
    uint8_t color[3];   ///< sRGB
    uint32_t row;       ///< from below
    uint32_t column;    ///< of the turn
    uint32_t object;    ///< of the truth: which use of a mesh
    float normal[3];    ///< of the truth, facing the scanner
    float range_error;  ///< of the truth: how much too far the point lies, metres
    double place[3];    ///< as measured, metres, z up
    double time;        ///< number of the ray, over all stations
} scan_point;

/// The direction in which a cell of the sweep looks, z up.
stp_vec3d scan_direction(const scan_settings* settings, uint32_t column, uint32_t row);
/// Its elevation in degrees.
double scan_elevation(const scan_settings* settings, uint32_t row);

/// Sweeps `count` columns from `first` on at station `station` (a number) that stands at `origin`.
/// Column after column, each `rows` points. The same for any number of threads.
void scan_sweep(const scan_target* target, const scan_settings* settings, uint32_t station,
                stp_vec3d origin, uint32_t first, uint32_t count, scan_point* points);
