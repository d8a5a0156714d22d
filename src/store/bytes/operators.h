// SPDX-License-Identifier: MIT
//
// Splats of progressive sets, each coded as its difference from the splat that it replaces
// (docs/format.md, Operators; Wu, Zhang, Kobbelt 2005, 5). Lossless.
#pragma once

#include "base/splats/progressive.h"
#include "base/splats/splat_columns.h"

#include <stddef.h>

/// Columns of a set that is encoded as operators (STP_SPLATS_*).
enum { STP_OPERATOR_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS };

/// Splats [begin, end) of a set whose earlier splats are known.
typedef struct stp_operator_run {
    const stp_splats* set; ///< its columns have room up to `end`
    uint32_t begin, end;
    uint32_t base; ///< encoding: number of base splats before `begin`
} stp_operator_run;

/// Encodes the splats of a run, which must be part of a valid set (stp_progressive_is_valid). Any
/// thread.
/// @param parents indices of the splats that the splits in the run replace, in order
/// @return bytes written; 0 if `room` is too small
size_t stp_operators_encode(const stp_operator_run* run, const uint32_t* parents, void* bytes,
                            size_t room);

/// State of a reader between runs.
typedef struct stp_operator_reader {
    stp_progressive_queue queue; ///< parents whose splits are still to come
    uint32_t base;               ///< base splats so far
    uint32_t parent;             ///< parent of the last splat; UINT32_MAX: none
} stp_operator_reader;

/// Starts after the first `count` splats of a set.
/// @param ranges the set's column of ranges; decoding writes to it through the set
/// @param room one index per splat up to the end of reading; the caller's
void stp_operators_begin(stp_operator_reader* reader, const uint32_t* ranges, uint32_t count,
                         uint32_t* room);

/// Registers splats [begin, end), already in the set's columns. They must follow the splats that
/// `reader` has seen.
void stp_operators_skip(stp_operator_reader* reader, uint32_t begin, uint32_t end);

/// Decodes the splats of a run into the columns of the set. Runs must be consecutive. Safe for any
/// input; check materials, shapes and ranges afterwards. Any thread.
/// @return false if the bytes are not exactly one valid run
bool stp_operators_decode(const stp_operator_run* run, stp_operator_reader* reader,
                          const void* bytes, size_t size);
