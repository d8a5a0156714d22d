// SPDX-License-Identifier: MIT
//
// Writes a `.stip`: the directory first, then data from coarse to fine, so that any prefix of the
// file shows the whole scene. Writes a temporary file, syncs and renames it.
#pragma once

#include "store/file/content.h"

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (invalid content),
/// STP_ERROR_LIMIT (too many blocks or breakpoints) (logged; an existing file stays unchanged)
STP_MUST_USE stp_result stp_store_write(stp_context* context, const stp_store_content* content,
                                        const char* path);
