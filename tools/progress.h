// SPDX-License-Identifier: MIT
//
// Progress on stderr: a bar that is redrawn, or one JSON object a line. At most ten times a second.
#pragma once

#include <stdbool.h>

typedef enum progress_style { PROGRESS_NONE, PROGRESS_BAR, PROGRESS_JSON } progress_style;

typedef struct progress_state {
    progress_style style;
    bool drawn;        ///< a bar is on the terminal's last line
    const char* stage; ///< static text
    double fraction;
    double stage_start_ms, shown_ms;
} progress_state;

/// `name`: auto|bar|json|none; NULL: auto. @return false where it is none of them
bool progress_choose(progress_state* state, const char* name, bool terminal);
void progress_report(progress_state* state, const char* stage, double fraction);
/// Takes the bar away.
void progress_clear(progress_state* state);
