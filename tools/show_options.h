// SPDX-License-Identifier: MIT
// What of a scene is shown: sections, and objects that are hidden, isolated or ghosts. From the command line, and from
// viewpoints beside the model.
#pragma once

#include "command.h"

#include "present/viewpoints.h"
#include "select/visibility.h"
#include "store/outline.h"

typedef struct show_options {
    option_texts sections, boxes, hide, isolate, ghost;
    double ghost_share; ///< 0: the default
} show_options;

enum { SHOW_OPTION_ROOM = 8 };

/// Fills a table of SHOW_OPTION_ROOM entries (ends with a NULL name). @return it
const option* show_options_table(option* table, show_options* options);

/// Whether texts are what their options want, as far as can be told without a scene. @return 0, or 2 (message printed)
int show_options_check(const show_options* options);

/// What is shown of an open scene. All zero at first.
typedef struct scene_show {
    stp_context* context;
    stp_store* store;
    stp_outline* outline;       ///< NULL: names were not asked for
    stp_visibility* visibility; ///< NULL: all is shown
} scene_show;

/// The outline, made where it is not yet. Failures are logged.
STP_MUST_USE stp_result scene_show_outline(scene_show* show, stp_outline** outline);
/// What the options say; sections are added to those of `view`. @return 0, 1 or 2, with the message printed
int scene_show_apply(scene_show* show, const show_options* options, stp_view* view);
/// What a viewpoint hides, isolates and makes ghosts. What the scene no longer has is left out, with a warning.
STP_MUST_USE stp_result scene_show_viewpoint(scene_show* show, const stp_viewpoint* viewpoint);
void scene_show_destroy(scene_show* show);
