// SPDX-License-Identifier: MIT
//
// Popping: how much more an approximation changes between consecutive frames than the reference
// does.
//
// Pictures are composited on black and divided into blocks of 8 x 8 pixels (smaller at the right and
// bottom border). The change of a block is the mean over its pixels and channels of |after -
// before|, 0 to 255. Its popping is the change of the approximation minus that of the reference, at
// least 0.
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

enum {
    STP_POPPING_BLOCK = 8,
    STP_POPPING_UNITS = 192, ///< values are multiples of 1/192: exact for whole blocks
    STP_POPPING_VALUES = 255 * STP_POPPING_UNITS + 1,
};

/// Histogram of the popping of blocks.
typedef struct stp_popping {
    uint64_t* counts; ///< number of blocks per value: STP_POPPING_VALUES
    uint64_t total;
    double last_mean; ///< mean popping of the last pair's blocks, 0 to 255
    uint16_t* values; ///< popping of the last pair's blocks, in units
    size_t value_capacity;
} stp_popping;

STP_MUST_USE stp_result stp_popping_create(stp_context* context, stp_popping* popping);
void stp_popping_destroy(stp_context* context, stp_popping* popping);

/// Adds the blocks of a pair of frames. All four pictures have the same size. The same counts for
/// any number of threads.
/// @return STP_OK, STP_ERROR_ARGUMENT (sizes differ; logged), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_popping_add(stp_context* context, stp_popping* popping,
                                        const stp_image* before, const stp_image* after,
                                        const stp_image* reference_before,
                                        const stp_image* reference_after);

/// Percentile: the smallest value that a fraction `part` of all blocks does not exceed. 0.999 is
/// the 99.9th percentile, 1 the maximum. 0 before the first pair.
double stp_popping_percentile(const stp_popping* popping, double part);
