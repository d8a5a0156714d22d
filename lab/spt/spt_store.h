// SPDX-License-Identifier: MIT
// A store that holds one set of splats, for benchmarks of the renderers.
#pragma once

#include "store/file/store.h"

/// Writes a scratch file with one node that has this set of method `spt`, opens it and unlinks it.
/// @return STP_OK, or as stp_store_write and stp_store_open
STP_MUST_USE stp_result spt_store_open(stp_context* context, const stp_splats* set,
                                       stp_store** store);
