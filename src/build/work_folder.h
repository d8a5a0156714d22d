// SPDX-License-Identifier: MIT
// The work directory's folder: made, locked for one build, listed, removed.
#pragma once

#include "build/work_segment.h"

/// The place made and locked. `place.path` is the caller's text.
typedef struct stp_work_folder {
    stp_work_place place;
    int lock; ///< the lock file's descriptor: locked as long as it is open
} stp_work_folder;

/// @return STP_OK; STP_ERROR_IO, or STP_ERROR_BUSY where another build is at work in the folder (logged)
STP_MUST_USE stp_result stp_work_folder_open(stp_context* context, const char* path,
                                             stp_work_folder* folder);
/// Unlocks. `remove` takes the lock file away, and the folder where nothing else is in it.
void stp_work_folder_close(stp_work_folder* folder, bool remove);

/// Numbers of the files with a segment's name, ascending (stp_free). @return STP_OK, IO, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_work_folder_list(const stp_work_folder* folder, uint32_t** numbers,
                                             size_t* count);
