// SPDX-License-Identifier: MIT
// A flight through a scene. The first pass draws and times it; an optional second pass draws the
// same splat sizes for pictures and for comparison with references, so that these do not affect the
// times.
#pragma once

#include "program/drawing/frame.h"
#include "program/measure/image_compare.h"
#include "program/present/flight.h"

#define FLIGHT_FRAMES_MAX 1000000

/// Receives the picture of a frame. Failures must be logged or printed.
typedef stp_result (*flight_sink)(void* user, const stp_image* image, uint32_t frame);

typedef struct flight_plan {
    const stp_flight* flight;
    /// Evenly over the flight, its first and last moment included; 0: at its fps
    uint32_t frame_count;
    stp_view view; ///< size; an angle above 0 instead of the flight's
    stp_quality quality;
    double budget_ms; ///< 0: none
    stp_controller controller;
    uint32_t reference_every; ///< 0: never
    bool popping;
    flight_sink sink; ///< NULL: pictures are not wanted
    void* sink_user;
} flight_plan;

/// How good a compared frame is.
typedef struct flight_quality {
    uint32_t frame;
    stp_image_quality quality; ///< likeness to the originals, drawn like the frame
    /// Truth (docs/measuring.md): covered SSIM to the originals with 16 samples a pixel
    double truth;
    double exact;          ///< truth of the originals with one sample a pixel
    double exact_filtered; ///< the same after the pixel filter
} flight_quality;

/// Quantiles of a value over the frames, from smallest to largest.
typedef struct flight_ranks {
    double p50, p95, p99, max;
} flight_ranks;

typedef struct flight_record {
    uint32_t frame_count;
    double* times;       ///< time of each frame on the flight's clock, seconds
    frame_figures first; ///< the first picture of all, before the flight
    frame_figures* frames;
    flight_quality* qualities;
    uint32_t quality_count;
    double budget_ms; ///< 0: none
    bool has_popping;
    double popping_p50, popping_p999, popping_max;
    double* poppings; ///< of each frame: mean popping of its blocks since the frame before
} flight_record;

/// Flies. The caller owns the record, also on failure (flight_record_destroy). Failures are logged.
STP_MUST_USE stp_result flight_run(frame_maker* maker, const flight_plan* plan,
                                   flight_record* record);
void flight_record_destroy(stp_context* context, flight_record* record);

/// Number of frames of a plan, at least 1.
uint32_t flight_count_frames(const flight_plan* plan);

typedef double (*flight_value)(const frame_figures* figures);
double flight_frame_ms(const frame_figures* figures);
double flight_splats(const frame_figures* figures);
double flight_triangles(const frame_figures* figures);
double flight_splat_size(const frame_figures* figures);
double flight_draw_calls(const frame_figures* figures);
double flight_extra_splats(const frame_figures* figures);

/// The quantiles of one value: the smallest value that so large a share of the frames does not
/// exceed. All 0 if memory runs out.
flight_ranks flight_rank(const flight_record* record, flight_value value);
