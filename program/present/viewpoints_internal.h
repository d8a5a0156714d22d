// SPDX-License-Identifier: MIT
#pragma once

#include "program/present/viewpoints.h"

void stp_viewpoint_destroy(stp_context* context, stp_viewpoint* view);

/// Appends a viewpoint and, on success, takes ownership of its texts and arrays.
/// @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_viewpoints_add(stp_context* context, stp_viewpoints* viewpoints,
                                           stp_viewpoint* added);

/// The lists of objects in the file, by stp_shown_as.
static const char* const stp_viewpoint_lists[] = {"hidden", "isolated", "ghosts"};
