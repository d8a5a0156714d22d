// SPDX-License-Identifier: MIT
// A flight through a scene: first drawn in one go and timed, then, as far as asked for, once more for pictures and for
// comparison with references, at the same sizes of splats: what is done with pictures takes no time of the flight.
#pragma once

#include "frame.h"

#include "measure/image_compare.h"
#include "present/flight.h"

#define FLIGHT_FRAMES_MOST 1000000

/// Takes a frame's picture. Failures must be logged or printed.
typedef stp_result (*flight_sink)(void* user, const stp_image* image, uint32_t frame);

typedef struct flight_plan {
    const stp_flight* flight;
    uint32_t
        frame_count; ///< evenly over the flight, its first and last moment included; 0: at its fps
    stp_view view;   ///< size; an angle above 0 instead of the flight's
    stp_quality quality;
    double budget_ms; ///< 0: none
    stp_controller controller;
    uint32_t reference_every; ///< 0: never
    bool popping;
    flight_sink sink; ///< NULL: pictures are not wanted
    void* sink_user;
} flight_plan;

typedef struct flight_quality {
    uint32_t frame;
    stp_image_quality quality;
} flight_quality;

/// From smallest to largest: ranks of what frames had.
typedef struct flight_ranks {
    double p50, p95, p99, max;
} flight_ranks;

typedef struct flight_record {
    uint32_t frame_count;
    double* times; ///< of the flight, seconds
    frame_figures* frames;
    flight_quality* qualities;
    uint32_t quality_count;
    double budget_ms; ///< 0: none
    bool has_popping;
    double popping_p50, popping_p999, popping_max;
    double* poppings; ///< of each frame, the mean over its blocks, from the one before
} flight_record;

/// Flies. The record is the caller's, also where that fails (flight_record_destroy). Failures are logged.
STP_MUST_USE stp_result flight_run(frame_maker* maker, const flight_plan* plan,
                                   flight_record* record);
void flight_record_destroy(stp_context* context, flight_record* record);

/// How many frames a plan has, at least 1.
uint32_t flight_count_frames(const flight_plan* plan);

typedef double (*flight_value)(const frame_figures* figures);
double flight_frame_ms(const frame_figures* figures);
double flight_splats(const frame_figures* figures);
double flight_triangles(const frame_figures* figures);
double flight_splat_size(const frame_figures* figures);
double flight_draw_calls(const frame_figures* figures);
double flight_extra_splats(const frame_figures* figures);

/// The ranks of one value: the least that is not exceeded by so large a part of the frames. All 0 where memory runs out.
flight_ranks flight_rank(const flight_record* record, flight_value value);
