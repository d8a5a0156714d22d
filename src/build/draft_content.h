// SPDX-License-Identifier: MIT
// A scene that is still being built, as the writer wants it: what is there of it, and points for the rest.
#pragma once

#include "build/content.h"

/// What there is of a scene.
typedef struct stp_draft_state {
    const stp_scene* scene;      ///< finished; partitioned or not
    const stp_coded_mesh* coded; ///< one a mesh; without bytes: not there yet. NULL: none is
    const stp_splats* sets;
    uint32_t set_count;
    const uint32_t* set_of_node; ///< STP_NONE: that node's set is not there. NULL: none is
} stp_draft_state;

/// Makes a scene of what is there, with the same nodes and objects. A mesh that is not coded yet is a few of its points
/// instead, and so are large ones where drawing all of them would take long; what is below a set of surfels counts
/// nothing there, as it is drawn from near only. Shadings and parameters are the caller's to add.
/// @return STP_OK; STP_ERROR_LIMIT where there is more to look at than a picture has time for, not logged;
/// STP_ERROR_OUT_OF_MEMORY (nothing is left to destroy)
STP_MUST_USE stp_result stp_draft_content_create(stp_context* context, const stp_draft_state* state,
                                                 stp_build_content* content);
