// SPDX-License-Identifier: MIT
//
// The work directory: results of a build, each under the hash of what it was made from. A build killed at any
// moment finds them again. Results are appended to segment files with a checksum each; what a kill left half
// written is not there when the directory is opened the next time.
//
//   FILE.stip.work/  lock  segment-000000  segment-000001 ...
//
//   segment:  | magic, version | key 16, size 8, checksum 8 | bytes, padded to 64 | key ... |
//
// A segment holds up to 256 MiB, and a large result has one of its own. Each is mapped once, in full, so what was
// given out stays where it is while the file grows. Opening reads the heads of the results only.
#pragma once

#include "base/context.h"
#include "base/hash.h"

typedef struct stp_work stp_work;

typedef struct stp_work_report {
    uint64_t found, found_bytes;   ///< results taken from former builds
    uint64_t stored, stored_bytes; ///< results added
    uint64_t damaged;              ///< results whose checksum was wrong: made again
} stp_work_report;

/// Opens or makes the folder and locks it. `fresh` empties it first. Only files of its own kind are ever removed.
/// @return STP_OK; STP_ERROR_IO (logged): no permission, disk full; STP_ERROR_BUSY (logged): another build is at work there;
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_work_open(stp_context* context, const char* folder, bool fresh,
                                      stp_work** work);
/// The same with segments of another size (a multiple of 64, at least 1024), for tests.
STP_MUST_USE stp_result stp_work_open_with(stp_context* context, const char* folder, bool fresh,
                                           size_t segment_bytes, stp_work** work);

/// The bytes stored under `key`, 64-byte aligned, mapped, valid until the directory is closed; NULL: none. The
/// checksum is verified the first time. Any thread.
const void* stp_work_find(stp_work* work, stp_hash key, size_t* size);

/// Stores the pieces, one after the other, as one result, and gives its mapped bytes (`stored` may be NULL). A
/// key stored already keeps its first content. Any thread.
/// @return STP_OK, STP_ERROR_IO (logged once: where the disk is full, all that follow fail too, silently),
/// STP_ERROR_OUT_OF_MEMORY (logged)
typedef stp_bytes stp_work_piece;
STP_MUST_USE stp_result stp_work_store(stp_work* work, stp_hash key, const stp_work_piece* pieces,
                                       size_t piece_count, const void** stored);

/// Takes a result for damaged, one that cannot be what its key says: it is found no more, and may be stored anew.
/// What was given out stays readable. Any thread.
void stp_work_forget(stp_work* work, stp_hash key);

/// Whether every result in use still matches its checksum. Reads all of them. Not thread-safe.
bool stp_work_is_intact(stp_work* work);

/// Gives back the memory that holds mapped results; they stay readable, and are read again where needed. Any thread,
/// while others read.
void stp_work_release_pages(stp_work* work);

stp_context* stp_work_get_context(const stp_work* work);
void stp_work_get_report(const stp_work* work, stp_work_report* report);

/// Unlocks and closes; `remove` deletes all results, and the directory where nothing else is in it. NULL is allowed.
void stp_work_close(stp_work* work, bool remove);
