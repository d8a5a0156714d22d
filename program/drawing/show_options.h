// SPDX-License-Identifier: MIT
// What is shown of a scene: sections, and hidden, isolated or ghosted objects, from the command
// line and from viewpoints beside the model.
#pragma once

#include "program/options/command.h"
#include "program/present/viewpoints.h"
#include "select/visibility.h"
#include "store/outline/outline.h"

typedef struct show_options {
    option_texts sections, boxes, hide, isolate, ghost;
} show_options;

enum { SHOW_OPTION_ROOM = 6 };

/// Fills a table of SHOW_OPTION_ROOM entries (ends with a NULL name). @return it
const option* show_options_table(option* table, show_options* options);

/// Checks the option texts, as far as possible without a scene. @return 0, or 2 (message printed)
int show_options_check(const show_options* options);

/// What is shown of an open scene. All zero at first.
typedef struct scene_show {
    stp_context* context;
    stp_store* store;
    stp_outline* outline;       ///< NULL: names are not needed
    stp_visibility* visibility; ///< NULL: all is shown
} scene_show;

/// Makes the outline if it does not exist yet. Failures are logged.
STP_MUST_USE stp_result scene_show_outline(scene_show* show, stp_outline** outline);
/// Applies the options; sections are added to those of `view`. @return 0, 1 or 2, with the message
/// printed
int scene_show_apply(scene_show* show, const show_options* options, stp_view* view);
/// Applies a viewpoint: hidden, isolated and ghosted objects. Objects that no longer exist are
/// skipped with a warning.
STP_MUST_USE stp_result scene_show_viewpoint(scene_show* show, const stp_viewpoint* viewpoint);
void scene_show_destroy(scene_show* show);
