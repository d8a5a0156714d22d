// SPDX-License-Identifier: MIT
// A store that holds one set of splats, for benchmarks of the renderers.
#pragma once

#include "store/store.h"

/// Writes a scratch file of one node whose set of method `spt` this is, and opens it; the file is gone by then.
/// @return STP_OK, or as stp_store_write and stp_store_open
STP_MUST_USE stp_result spt_store_open(stp_context* context, const stp_splats* set,
                                       stp_store** store);
