// SPDX-License-Identifier: MIT
//
// Progress for people and programs: a bar that is redrawn, or one JSON object a line. At most ten times a second.
#pragma once

#include <stdbool.h>
#include <stdio.h>

typedef enum progress_style { PROGRESS_NONE, PROGRESS_BAR, PROGRESS_JSON } progress_style;

typedef struct progress_state {
    progress_style style;
    FILE* stream;
    bool drawn;        ///< a bar is on the terminal's last line
    const char* stage; ///< static text
    double fraction;
    double stage_start_ms, shown_ms;
} progress_state;

/// `name`: auto|bar|json|none; NULL: auto, a bar where the stream is a terminal. @return false where it is none of them
bool progress_choose(progress_state* state, const char* name, FILE* stream);
void progress_report(progress_state* state, const char* stage, double fraction);
/// Takes the bar away.
void progress_clear(progress_state* state);
