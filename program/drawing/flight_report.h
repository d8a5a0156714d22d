// SPDX-License-Identifier: MIT
// Results of a flight: figures as JSON and text, and plots.
#pragma once

#include "program/drawing/flight_run.h"

/// The keys of `fly --json` about the flight itself. NULL if memory runs out.
json_t* flight_describe(const flight_record* record);
/// Loading statistics of a flight with a memory limit: the object `residency`. NULL if memory runs
/// out.
json_t* flight_describe_residency(const flight_record* record, const stp_residency* residency);
/// A table on stdout.
void flight_print(const flight_record* record);

/// Plots frame time, splat size, splats and triangles over the flight, and popping and SSIM if
/// measured. `budget_ms` 0: none. Failures are logged.
STP_MUST_USE stp_result flight_plot(stp_context* context, const char* path,
                                    const flight_record* record, double budget_ms);
