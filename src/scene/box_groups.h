// SPDX-License-Identifier: MIT
// A hierarchy of boxes: neighbours share a group, and the size of groups is limited.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

/// Has either children or members: the boxes order[first] to order[first + count - 1].
typedef struct stp_group {
    uint32_t first, count;             ///< all boxes below it
    uint32_t first_child, child_count; ///< child_count 0: has `count` members
    uint32_t depth;                    ///< number of splits above it
} stp_group;

/// Group 0 contains all; children have higher indices than parents. Initialise to zero; reusable.
typedef struct stp_grouping {
    uint32_t* order;
    stp_group* groups;
    size_t group_count;
    size_t order_capacity, group_capacity;
} stp_grouping;

enum { STP_GROUP_LIMIT = 256 };

/// Groups `count` boxes (at least 1), with at most `maximum` (2 to STP_GROUP_LIMIT) members or
/// children each. Boxes may coincide, have no volume, or have any size. Time O(count log count).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_group_boxes(stp_context* context, const stp_boxd* boxes, uint32_t count,
                                        uint32_t maximum, stp_grouping* grouping);
void stp_grouping_destroy(stp_context* context, stp_grouping* grouping);
