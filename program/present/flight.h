// SPDX-License-Identifier: MIT
//
// A camera path through a scene: keys at times, interpolated. As JSON:
//
//   { "fov": 60, "fps": 60,
//     "keys": [ { "t": 0, "eye": [0, 2, 30], "target": [0, 2, 0], "up": [0, 1, 0] }, ... ] }
//
// `t` is in seconds. Eye and target follow Catmull-Rom splines, also for keys unevenly spaced in
// time. Up vectors are interpolated and normalised. fov (60), fps (60) and up (0, 1, 0) are
// optional.
#pragma once

#include "base/core/context.h"

#include <stipple/view.h>

typedef struct stp_flight_key {
    double t; ///< seconds
    stp_vec3d eye, target, up;
} stp_flight_key;

typedef struct stp_flight {
    double fov_degrees; ///< vertical
    double fps;
    stp_flight_key* keys; ///< at least one, in ascending order of t; from stp_alloc
    size_t key_count;
} stp_flight;

#define STP_FLIGHT_BYTES_MAX ((size_t)1 << 24) ///< size limit of a file
#define STP_FLIGHT_SECONDS_MAX 86400.0         ///< from the first key to the last

/// Reads a flight from a file. @return STP_OK, STP_ERROR_IO, STP_ERROR_FORMAT (not JSON; a value
/// missing, of the wrong type or out of range; times not ascending; an eye at its target),
/// STP_ERROR_LIMIT (file too large), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_flight_read(stp_context* context, const char* path, stp_flight* flight);
/// Parses a flight from memory; `name` begins the error message.
STP_MUST_USE stp_result stp_flight_parse(stp_context* context, const char* name,
                                         const unsigned char* bytes, size_t size,
                                         stp_flight* flight);
/// Writes to a temporary file and renames it. @return STP_OK, STP_ERROR_IO,
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_flight_write(stp_context* context, const char* path,
                                         const stp_flight* flight);
void stp_flight_destroy(stp_context* context, stp_flight* flight);

/// Number of frames at `fps` from the first key to the last; at least 1.
uint32_t stp_flight_frame_count(const stp_flight* flight, double fps);

/// Sets eye, target, up and the angle of `view`, and turns parallel projection off. Before the
/// first key and after the last, the camera stays at that key.
void stp_flight_get_view(const stp_flight* flight, double t, stp_view* view);
