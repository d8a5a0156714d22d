// SPDX-License-Identifier: MIT
// Assigns each point to the nearest chosen point.
#pragma once

#include "lab/decimate/decimator.h"

/// Points of each chosen one, including itself: members from starts[i] to before starts[i + 1],
/// ascending.
typedef struct stp_decimate_cells {
    uint32_t* owners; ///< per point, the number of a chosen one
    uint32_t* starts;
    uint32_t* members;
} stp_decimate_cells;

/// Assigns each point to the nearest chosen one that does not face away from it; if there is none,
/// to the nearest one.
/// @param chosen points that are at least `radius` apart, unless they face apart
/// @param radius maximum distance of any point to the chosen ones
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); freed by stp_decimate_cells_destroy, also
///         after a failure
STP_MUST_USE stp_result stp_decimate_cells_make(stp_context* context,
                                                const stp_decimate_input* input,
                                                const uint32_t* chosen, uint32_t count,
                                                float radius, stp_decimate_cells* cells);
void stp_decimate_cells_destroy(stp_context* context, stp_decimate_cells* cells);
