// SPDX-License-Identifier: MIT
#pragma once

#include "base/context.h"
#include "store/outline.h"

/// A prototype: what stands wherever its node does.
typedef struct stp_outline_prototype {
    uint32_t node, object;
} stp_outline_prototype;

typedef enum stp_outline_phase {
    STP_OUTLINE_BEGIN,
    STP_OUTLINE_COUNT, ///< children of each object
    STP_OUTLINE_SUM,
    STP_OUTLINE_SORT,
    STP_OUTLINE_READY
} stp_outline_phase;

struct stp_outline {
    stp_context* context;
    stp_store* store;
    const stp_store_directory* directory;
    stp_outline_phase phase;
    uint32_t next;          ///< of the phase
    uint32_t running;       ///< sum so far
    uint32_t* places;       ///< while it is made: where the next child of each parent goes
    uint32_t* order;        ///< objects by their parents; without prototypes
    uint32_t ordered_count; ///< of them
    stp_outline_prototype* prototypes; ///< by node
    size_t prototype_count, prototype_capacity;
    uint8_t*
        uses_prototypes; ///< of each node: whether a prototype's node is it or below it; NULL: there are none
};

/// The range of `order` with the children of an object, or of the scene (STP_STORE_NONE).
STP_MUST_USE stp_result stp_outline_range(stp_outline* outline, uint32_t parent, uint32_t* first,
                                          uint32_t* end);
/// The first prototype with this node; STP_STORE_NONE: there is none.
uint32_t stp_outline_prototype_of(const stp_outline* outline, uint32_t node);
/// A child of an item. @return false where it would be too deep
bool stp_outline_descend(const stp_outline_item* item, uint32_t object, uint32_t node,
                         const stp_affine* transform, stp_outline_item* child);
