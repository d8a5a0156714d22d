// SPDX-License-Identifier: MIT
//
// Progress for people and programs: a redrawn bar, or one JSON object per line. At most ten updates
// per second; JSON also reports the beginning and end of each stage.
#pragma once

#include <stipple/base.h>

#include <stdbool.h>
#include <stdio.h>

typedef enum progress_style { PROGRESS_NONE, PROGRESS_BAR, PROGRESS_JSON } progress_style;

/// Growth rate of a value, weighted towards recent values.
typedef struct progress_speed {
    bool begun;
    double start_ms, last_ms;
    double last_value;
    double per_ms; ///< 0: not known yet
} progress_speed;

typedef struct progress_state {
    progress_style style;
    FILE* stream;
    bool drawn; ///< a bar is on the terminal's last line
    stp_progress_report report;
    progress_speed way;  ///< speed of the whole, or of the stage if the whole is unknown
    progress_speed rate; ///< speed at which the stage processes the items it counts
    double stage_start_ms, shown_ms;
} progress_state;

/// `name`: auto|bar|json|none; NULL: auto, a bar if the stream is a terminal. @return false if it
/// is none of these
bool progress_choose(progress_state* state, const char* name, FILE* stream);
void progress_report(progress_state* state, const stp_progress_report* report);
/// Same, at a given time.
void progress_report_at(progress_state* state, const stp_progress_report* report, double now_ms);
/// Removes the bar.
void progress_clear(progress_state* state);

/// Remaining time of the whole, or of the stage if the whole is not known; negative: not known yet.
double progress_remaining_s(const progress_state* state);
