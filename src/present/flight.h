// SPDX-License-Identifier: MIT
//
// A path of the camera through a scene: keys at times, and what lies between them. As JSON:
//
//   { "fov": 60, "fps": 60, "keys": [ { "t": 0, "eye": [0, 2, 30], "target": [0, 2, 0], "up": [0, 1, 0] }, ... ] }
//
// `t` in seconds. Eye and target follow Catmull-Rom splines, also where keys are not evenly spaced in time; up vectors
// are mixed and have unit length. fov (60), fps (60) and up (0, 1, 0) may be missing.
#pragma once

#include "base/context.h"

#include <stipple/view.h>

typedef struct stp_flight_key {
    double t; ///< seconds
    stp_vec3d eye, target, up;
} stp_flight_key;

typedef struct stp_flight {
    double fov_degrees; ///< vertical
    double fps;
    stp_flight_key* keys; ///< at least one, t ascending; from stp_alloc
    size_t key_count;
} stp_flight;

#define STP_FLIGHT_BYTES_MOST ((size_t)1 << 24) ///< of a file
#define STP_FLIGHT_SECONDS_MOST 86400.0         ///< from the first key to the last

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_FORMAT (not JSON; a value missing, of the wrong kind or out of range; times
/// not ascending; an eye at its target), STP_ERROR_LIMIT (a file too large), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_flight_read(stp_context* context, const char* path, stp_flight* flight);
/// The same from memory; `name` begins the message of a failure.
STP_MUST_USE stp_result stp_flight_parse(stp_context* context, const char* name,
                                         const unsigned char* bytes, size_t size,
                                         stp_flight* flight);
/// Writes aside and renames. @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_flight_write(stp_context* context, const char* path,
                                         const stp_flight* flight);
void stp_flight_destroy(stp_context* context, stp_flight* flight);

/// Frames at so many a second, from the first key to the last one; at least 1.
uint32_t stp_flight_frame_count(const stp_flight* flight, double fps);

/// Sets eye, target, up and the angle of `view`, and parallel projection off. Before the first key and after the last
/// one the camera rests there.
void stp_flight_look(const stp_flight* flight, double t, stp_view* view);
