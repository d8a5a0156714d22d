// SPDX-License-Identifier: MIT
//
// Popping: how much pictures of an approximation change between consecutive frames beyond what the references of the same
// two frames do.
//
// Pictures are composited on black and cut into blocks of 8 x 8 pixels (smaller ones at the right and bottom border). How
// much a block changes is the mean over its pixels and channels of |after - before|, 0 to 255; its popping is that of
// the approximation less that of the reference, at least 0.
#pragma once

#include "base/context.h"

#include <stipple/image.h>

enum {
    STP_POPPING_BLOCK = 8,
    STP_POPPING_UNITS = 192, ///< values are kept as multiples of 1/192: exact for whole blocks
    STP_POPPING_VALUES = 255 * STP_POPPING_UNITS + 1,
};

/// How many blocks had which popping.
typedef struct stp_popping {
    uint64_t* counts; ///< STP_POPPING_VALUES
    uint64_t total;
    double last_mean; ///< of the blocks of the pair added last
    uint16_t* values; ///< of the blocks of one pair
    size_t value_capacity;
} stp_popping;

STP_MUST_USE stp_result stp_popping_create(stp_context* context, stp_popping* popping);
void stp_popping_destroy(stp_context* context, stp_popping* popping);

/// Adds the blocks of a pair of frames. All four pictures have one size. The same counts for any number of threads.
/// @return STP_OK, STP_ERROR_ARGUMENT (sizes differ; logged), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_popping_add(stp_context* context, stp_popping* popping,
                                        const stp_image* before, const stp_image* after,
                                        const stp_image* reference_before,
                                        const stp_image* reference_after);

/// The least value that so large a part of all blocks does not exceed: 0.999 for the 99.9th percentile, 1 for the
/// largest. 0 before the first pair.
double stp_popping_percentile(const stp_popping* popping, double part);
