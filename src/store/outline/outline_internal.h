// SPDX-License-Identifier: MIT
#pragma once

#include "base/core/context.h"
#include "store/outline/outline.h"

/// A prototype: its children appear wherever its node is used.
typedef struct stp_outline_prototype {
    uint32_t node, object;
} stp_outline_prototype;

typedef enum stp_outline_phase {
    STP_OUTLINE_BEGIN,
    STP_OUTLINE_COUNT, ///< counting the children of each object
    STP_OUTLINE_SUM,
    STP_OUTLINE_SORT,
    STP_OUTLINE_READY
} stp_outline_phase;

struct stp_outline {
    stp_context* context;
    stp_store* store;
    const stp_store_directory* directory;
    stp_outline_phase phase;
    uint32_t next;                     ///< position within the phase
    uint32_t running;                  ///< running sum
    uint32_t* places;                  ///< during sorting: destination of each parent's next child
    uint32_t* order;                   ///< objects sorted by parent, without prototypes
    uint32_t ordered_count;            ///< length of `order`
    stp_outline_prototype* prototypes; ///< once ready, sorted by node, then by object
    size_t prototype_count, prototype_capacity;
    /// For each node, whether a prototype's node is at or below it; NULL: no prototypes.
    uint8_t* uses_prototypes;
};

/// The range of `order` with the children of an object, or of the scene (STP_STORE_NONE).
STP_MUST_USE stp_result stp_outline_range(stp_outline* outline, uint32_t parent, uint32_t* first,
                                          uint32_t* end);
/// The first prototype with this node; STP_STORE_NONE if there is none.
uint32_t stp_outline_prototype_of(const stp_outline* outline, uint32_t node);
