// SPDX-License-Identifier: MIT
//
// Progress for people and programs: a bar that is redrawn, or one JSON object a line. At most ten times a second,
// besides each stage's begin and end.
#pragma once

#include <stipple/base.h>

#include <stdbool.h>
#include <stdio.h>

typedef enum progress_style { PROGRESS_NONE, PROGRESS_BAR, PROGRESS_JSON } progress_style;

/// How fast a value grows, mostly of late.
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
    progress_speed way;  ///< of the whole; of the stage where the whole is not known
    progress_speed rate; ///< of what the stage counts
    double stage_start_ms, shown_ms;
} progress_state;

/// `name`: auto|bar|json|none; NULL: auto, a bar where the stream is a terminal. @return false where it is none of them
bool progress_choose(progress_state* state, const char* name, FILE* stream);
void progress_report(progress_state* state, const stp_progress_report* report);
/// The same at a given time.
void progress_report_at(progress_state* state, const stp_progress_report* report, double now_ms);
/// Takes the bar away.
void progress_clear(progress_state* state);

/// What is left of the whole, or of the stage where the whole is not known; negative: not known yet.
double progress_remaining_s(const progress_state* state);
