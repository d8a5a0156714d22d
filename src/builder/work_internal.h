// SPDX-License-Identifier: MIT
// Parts of the work folder: its files, and the table of the results in them.
#pragma once

#include "base/core/context.h"
#include "base/io/hash.h"
#include "builder/work_segment.h"

// Index of the work folder's results by key. One thread at a time.

typedef enum stp_work_state {
    STP_WORK_ABSENT,     ///< no result: new, damaged, dropped, or writing failed
    STP_WORK_PENDING,    ///< a thread is writing it
    STP_WORK_UNVERIFIED, ///< from a previous build, checksum not verified yet
    STP_WORK_GOOD,
} stp_work_state;

typedef struct stp_work_entry {
    stp_hash key;
    uint64_t size, checksum;
    uint64_t offset; ///< position of its bytes in its segment
    uint32_t segment;
    stp_work_state state;
} stp_work_entry;

typedef struct stp_work_index {
    stp_work_entry* entries;
    size_t count, capacity;
    uint32_t* slots; ///< linear probing: entry + 1; 0: free
    size_t slot_count;
} stp_work_index;

void stp_work_index_destroy(stp_context* context, stp_work_index* index);
/// NULL: not found. Entries move when one is added.
stp_work_entry* stp_work_index_find(const stp_work_index* index, stp_hash key);
/// The entry of the key, added as STP_WORK_ABSENT if missing; NULL if memory runs out.
stp_work_entry* stp_work_index_add(stp_context* context, stp_work_index* index, stp_hash key);

// The work folder itself: creates, locks, lists and removes it.

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
