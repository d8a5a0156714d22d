// SPDX-License-Identifier: MIT
//
// The work folder: results of a build, each stored under a hash of its inputs. A build killed at
// any moment finds them again. Results are appended to segment files, each with a checksum. A
// result that a kill left incomplete is discarded.
//
//   FILE.stip.work/  lock  segment-000000  segment-000001 ...
//
//   segment:  | magic, version | key 16, size 8, checksum 8 | bytes, padded to 64 | key ... |
// A segment holds up to 256 MiB; a large result has its own. Each segment is mapped once at full
// size, so results never move while the file grows. Opening reads only the headers of results.
#pragma once

#include "base/core/context.h"
#include "base/io/hash.h"

typedef struct stp_work stp_work;

typedef struct stp_work_report {
    uint64_t found, found_bytes;   ///< results taken from previous builds
    uint64_t stored, stored_bytes; ///< results added
    uint64_t damaged;              ///< results with a wrong checksum or invalid content
    uint64_t held;                 ///< results in the folder, used or not
} stp_work_report;

/// Opens or creates the folder and locks it. `fresh` empties it first. Only removes files of its
/// own kind. @return STP_OK; STP_ERROR_IO (logged): no permission, disk full; STP_ERROR_BUSY
/// (logged): another build uses it; STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_work_open(stp_context* context, const char* folder, bool fresh,
                                      stp_work** work);
/// The same with a different segment size (a multiple of 64, at least 1024), for tests.
STP_MUST_USE stp_result stp_work_open_with(stp_context* context, const char* folder, bool fresh,
                                           size_t segment_bytes, stp_work** work);

/// The bytes stored under `key`: 64-byte aligned, mapped, valid until the directory is closed.
/// NULL: none. Verifies the checksum on first use. Any thread.
const void* stp_work_find(stp_work* work, stp_hash key, size_t* size);

/// Stores the concatenated parts as one result; `stored` (may be NULL) receives the mapped bytes.
/// An existing key keeps its first content. Any thread. @return STP_OK, STP_ERROR_IO (logged once:
/// if the disk is full, later calls fail silently), STP_ERROR_LIMIT: too large, or too many
/// segments (logged), STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_work_store(stp_work* work, stp_hash key, const stp_bytes* parts,
                                       size_t part_count, const void** stored);

/// Drops a result whose content is invalid: it is no longer found, and can be stored again.
/// Pointers to it stay readable. Any thread.
void stp_work_drop(stp_work* work, stp_hash key);

/// Whether every result in use still matches its checksum. Reads all of them. Not thread-safe.
bool stp_work_is_intact(stp_work* work);

/// Releases the memory of mapped results; they stay readable and are read again when used. Any
/// thread, while others read.
void stp_work_release_pages(stp_work* work);

stp_context* stp_work_get_context(const stp_work* work);
void stp_work_get_report(const stp_work* work, stp_work_report* report);

/// Unlocks and closes. `remove` deletes all results, and the directory if it is otherwise empty.
/// NULL is allowed.
void stp_work_close(stp_work* work, bool remove);
