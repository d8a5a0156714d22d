// SPDX-License-Identifier: MIT
//
// Points far from the rest of their set, such as one at 0, 0, 0 in a survey of national coordinates.
// Positions are stored on a grid over the box of a node. So strays get nodes of their own, and the
// rest keeps its precision.
#pragma once

#include "scene/partition_steps.h"

typedef struct stp_strays {
    uint32_t count;  ///< 0: none
    stp_box rest;    ///< all other points lie in it
    double width;    ///< longest side of the box of most points
    double distance; ///< of the farthest stray from `rest`
} stp_strays;

/// Finds strays: at most one of 32 points (or a single one of eight and more), each at least eight
/// widths from the box of most others. The time is that of a sample where there are none.
stp_strays stp_strays_find(const stp_point_set* points);

bool stp_is_stray(const stp_strays* strays, const float position[3]);

/// Warns once if point sets have strays: how many, and how far away.
void stp_strays_report(const stp_scene* scene);

/// Groups strays that lie within a width of the rest from each other, at most 4,096 groups: reorders
/// `places` (count of strays) and fills ends[0] to ends[*group_count - 1], where groups end.
/// @param ends  room for as many as there are strays
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_strays_group(stp_context* context, const stp_strays* strays,
                                         stp_place* places, uint32_t* ends, uint32_t* group_count);
