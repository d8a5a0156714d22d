// SPDX-License-Identifier: MIT
// Chooses the stations of a simulated scanner, so that each sees much that the others do not.
#pragma once

#include "lab/scan/scan_sweep.h"

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
