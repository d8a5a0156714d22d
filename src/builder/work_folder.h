// SPDX-License-Identifier: MIT
// The folder of the work directory: creates, locks, lists and removes it.
#pragma once

#include "builder/work_segment.h"

/// The created and locked folder. The caller owns the text `place.path`.
typedef struct stp_work_folder {
    stp_work_place place;
    int lock; ///< descriptor of the lock file; locked while open
} stp_work_folder;

/// @return STP_OK; STP_ERROR_IO, or STP_ERROR_BUSY if another build uses the folder (logged)
STP_MUST_USE stp_result stp_work_folder_open(stp_context* context, const char* path,
                                             stp_work_folder* folder);
/// Unlocks. `remove` deletes the lock file, and the folder if it is otherwise empty.
void stp_work_folder_close(stp_work_folder* folder, bool remove);

/// Numbers of the segment files, ascending (stp_free). @return STP_OK, IO, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_work_folder_list(const stp_work_folder* folder, uint32_t** numbers,
                                             size_t* count);
