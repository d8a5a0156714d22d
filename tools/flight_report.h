// SPDX-License-Identifier: MIT
// What a flight was like: figures as JSON and as text, and plots.
#pragma once

#include "flight_run.h"

/// The keys of `fly --json` that are of the flight itself. NULL where memory runs out.
json_t* flight_describe(const flight_record* record);
/// What loading did, of a flight under a limit of memory: the object `residency`. NULL where memory runs out.
json_t* flight_describe_residency(const flight_record* record, const stp_residency* residency);
/// A table on stdout.
void flight_print(const flight_record* record);

/// Frame time, size of splats, splats and triangles over the flight, and popping and SSIM where they were measured.
/// `budget_ms` 0: none. Failures are logged.
STP_MUST_USE stp_result flight_plot(stp_context* context, const char* path,
                                    const flight_record* record, double budget_ms);
