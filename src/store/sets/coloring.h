// SPDX-License-Identifier: MIT
//
// Colours points by an attribute and hides classes. The results replace the file's own colours and
// coverages when data is loaded, so renderers need not know:
//
//   colour      from the attribute's value; splats and points without it keep their colour
//   coverage 0  hides a splat. The smallest stored coverage (code 0, 1 of 255) becomes
//               the next one (code 1)
//   alpha 0     hides a point
#pragma once

#include "store/sets/attribute_blocks.h"

typedef struct stp_store_coloring {
    bool by_attribute;
    stp_attribute attribute;
    double low, high; ///< ends of a continuous scale
    bool hides;
    uint8_t shown[256]; ///< whether points of a class are drawn; only read if `hides`
} stp_store_coloring;

/// Whether an attribute is categorical (distinct colours) rather than continuous.
bool stp_attribute_is_distinct(stp_attribute attribute);

/// Sets how a store's points are coloured; NULL or all zero: as stored. Drops loaded data and
/// invalidates pointers to it. Not allowed while a residency is attached. @return STP_OK,
/// STP_ERROR_ARGUMENT (logged)
STP_MUST_USE stp_result stp_store_set_coloring(stp_store* store,
                                               const stp_store_coloring* coloring);
/// The current colouring; never NULL.
const stp_store_coloring* stp_store_get_coloring(const stp_store* store);
