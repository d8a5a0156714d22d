// SPDX-License-Identifier: MIT
// Frame times of flights, as `stipple fly --json` reports them, plotted on a canvas.
#pragma once

#include "program/present/canvas.h"

enum { SHEET_FLIGHTS_MAX = 8 };

typedef struct sheet_flight {
    const char* path;
    const char* caption; ///< NULL: the path
    double *times, *frame_ms;
    size_t count;
    double budget_ms; ///< 0: none
} sheet_flight;

/// Reads `path`. Failures are logged by the context. Arrays are from stp_alloc.
STP_MUST_USE stp_result sheet_flight_read(stp_context* context, sheet_flight* flight);
void sheet_flight_destroy(stp_context* context, sheet_flight* flight);

/// Plots all flights over one axis of time, within a box. The other axis is logarithmic if frame
/// times differ by more than a factor of ten.
void sheet_plot(canvas* c, int x, int y, int width, int height, const sheet_flight* flights,
                size_t count);
