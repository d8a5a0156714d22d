// SPDX-License-Identifier: MIT
//
// Memory that lies in a file: what is too large to keep is written to a nameless file in a folder and read back
// through its mapping, so that the system may drop it from memory at any time. It is not counted as the
// context's memory. The file vanishes with the process, however that ends.
#pragma once

#include "base/context.h"

typedef struct stp_spill stp_spill;

/// `folder` must exist. @return STP_OK, STP_ERROR_IO (logged, with the system's reason), OUT_OF_MEMORY
STP_MUST_USE stp_result stp_spill_create(stp_context* context, const char* folder,
                                         stp_spill** spill);
/// Another one in the same folder, to be destroyed sooner.
STP_MUST_USE stp_result stp_spill_create_beside(const stp_spill* other, stp_spill** spill);
void stp_spill_destroy(stp_spill* spill);

/// `size` bytes, 64-byte aligned, zero, valid until the spill is destroyed. Room on the disk is reserved first:
/// a full disk is NULL and a logged STP_ERROR_IO, never a signal. Any thread.
void* stp_spill_alloc(stp_spill* spill, size_t size);

/// Lets the system drop all of it from memory, once it is written; it is read again when needed. Any thread.
void stp_spill_release_pages(stp_spill* spill);

/// Bytes given out so far.
uint64_t stp_spill_bytes(const stp_spill* spill);
