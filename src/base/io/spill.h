// SPDX-License-Identifier: MIT
//
// Memory backed by a file: data too large to keep in memory goes to an anonymous file in a folder
// and is read back through its mapping, so that the system may drop it from memory at any time. It
// does not count as the context's memory. The file vanishes with the process, however it ends.
#pragma once

#include "base/core/context.h"

typedef struct stp_spill stp_spill;

/// `folder` must exist. @return STP_OK, STP_ERROR_IO (logged, with the system's reason),
/// OUT_OF_MEMORY
STP_MUST_USE stp_result stp_spill_create(stp_context* context, const char* folder,
                                         stp_spill** spill);
/// Creates another spill in the same folder, to be destroyed sooner.
STP_MUST_USE stp_result stp_spill_create_sibling(const stp_spill* other, stp_spill** spill);
void stp_spill_destroy(stp_spill* spill);

/// `size` zeroed bytes, 64-byte aligned, valid until the spill is destroyed. Reserves disk space
/// first: a full disk gives NULL and a logged STP_ERROR_IO, never a signal. Any thread.
void* stp_spill_alloc(stp_spill* spill, size_t size);

/// Lets the system evict all written data from memory; it is read again when needed. Any thread.
void stp_spill_release_pages(stp_spill* spill);

/// The same for pages that lie wholly in a range of it. Any thread.
void stp_spill_forget(const void* memory, size_t size);
