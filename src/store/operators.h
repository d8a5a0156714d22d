// SPDX-License-Identifier: MIT
//
// Splats of progressive sets, each coded by how it differs from the splat that it replaces
// (docs/format.md, Operators; Wu, Zhang, Kobbelt 2005, 5). Nothing is lost.
#pragma once

#include "base/progressive.h"

#include <stipple/surfels.h>

#include <stddef.h>

/// The columns that such a set has (STP_SPLATS_*).
enum { STP_OPERATOR_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS };

/// Splats [begin, end) of a set, all splats before which are known.
typedef struct stp_operator_run {
    const stp_splats* set; ///< its columns have room up to `end`
    uint32_t begin, end;
    uint32_t base; ///< encoding: splats of the base set before `begin`
} stp_operator_run;

/// Codes the splats of a run, which must be part of a valid set (stp_progressive_is_valid). Any
/// thread.
/// @param parents of the splits whose splats are in the run, the first split first
/// @return bytes written; 0 if they are more than `room`
size_t stp_operators_encode(const stp_operator_run* run, const uint32_t* parents, void* bytes,
                            size_t room);

/// What a reader knows of the splits to come.
typedef struct stp_operator_reader {
    stp_progressive_queue queue; ///< parents that wait
    uint32_t base;               ///< splats of the base set so far
    uint32_t parent;             ///< of the last splat; UINT32_MAX: none
} stp_operator_reader;

/// Begins after the first `count` splats of a set.
/// @param ranges of the set; those of the splats to be decoded are written through the set's own
///         column
/// @param room for an index for each splat that there is when the reader ends; the caller's
void stp_operators_begin(stp_operator_reader* reader, const uint32_t* ranges, uint32_t count,
                         uint32_t* room);

/// Takes note of splats [begin, end), which are in the set's columns already. They follow those
/// that `reader` has seen.
void stp_operators_skip(stp_operator_reader* reader, uint32_t begin, uint32_t end);

/// Decodes the splats of a run into the columns of the set. Runs follow each other. Any bytes are
/// safe to decode; materials, shapes and ranges must be judged afterwards. Any thread.
/// @return whether the bytes are exactly such a run
bool stp_operators_decode(const stp_operator_run* run, stp_operator_reader* reader,
                          const void* bytes, size_t size);
