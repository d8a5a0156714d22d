// SPDX-License-Identifier: MIT
// Files: mapped for reading; written to a temporary file and renamed.
#pragma once

#include "base/core/context.h"

/// A read of one byte of a mapped file may make this much resident: Linux maps all cached pages in
/// an aligned range around a page fault (`fault_around_bytes`).
enum { STP_FAULT_AROUND = 64 << 10 };

/// A whole file in memory. `bytes` is NULL for an empty file.
typedef struct stp_mapped_file {
    const unsigned char* bytes;
    size_t size;
} stp_mapped_file;

/// Maps `path` for reading. Directories, devices and pipes are rejected.
/// @return STP_OK, or STP_ERROR_IO (logged, with the system's reason)
STP_MUST_USE stp_result stp_file_map(stp_context* context, const char* path, stp_mapped_file* file);
/// Also keeps the file open for reading: the caller closes `descriptor`, which is -1 on failure.
STP_MUST_USE stp_result stp_file_map_open(stp_context* context, const char* path,
                                          stp_mapped_file* file, int* descriptor);
/// Reads a range of an open file. Any thread. @return false if the range does not exist or cannot
/// be read
bool stp_file_read_at(int descriptor, uint64_t offset, void* bytes, size_t size);
void stp_file_close(int descriptor);
/// Reads the first bytes of a regular file, at most `size`. @return bytes read; 0 for an unreadable
/// file, a folder, a device or a pipe
size_t stp_file_peek(const char* path, void* bytes, size_t size);
/// Announces random access to a small part of the file: disables read-ahead.
void stp_file_expect_random(const stp_mapped_file* file);
/// Drops the file's pages from memory. The mapping stays valid; pages are read again when needed.
/// Any thread, also while others read. `file` may be the end of a mapped one.
void stp_file_evict(const stp_mapped_file* file);
void stp_file_unmap(stp_mapped_file* file);

/// A file being written. Bytes go to `path`.tmp-<process>-<number>, which is renamed to `path` on
/// commit, or removed. Opening fails if `path` exists and is not a regular file (a folder, a
/// device).
typedef struct stp_file_writer stp_file_writer;

STP_MUST_USE stp_result stp_file_writer_open(stp_context* context, const char* path,
                                             stp_file_writer** writer);
/// Appends bytes, buffered.
STP_MUST_USE stp_result stp_file_writer_append(stp_file_writer* writer, const void* bytes,
                                               size_t size);
/// Replaces bytes already appended; `offset` + `size` must not pass the end.
STP_MUST_USE stp_result stp_file_writer_patch(stp_file_writer* writer, uint64_t offset,
                                              const void* bytes, size_t size);
/// Bytes appended so far.
uint64_t stp_file_writer_size(const stp_file_writer* writer);
/// Syncs, renames to the final name and ends the writer. On failure the temporary file is removed.
STP_MUST_USE stp_result stp_file_writer_commit(stp_file_writer* writer);
/// Commits without syncing, for files that need not survive a power loss.
STP_MUST_USE stp_result stp_file_writer_commit_passing(stp_file_writer* writer);
/// Removes the temporary file and ends the writer. NULL is allowed.
void stp_file_writer_abort(stp_file_writer* writer);

/// Creates an empty file beside `path` with a unique name (`path`.tmp-<process>-<number>), for a
/// child process to write.
/// @return false on failure (see errno; ENAMETOOLONG if `size` is too small for the name)
bool stp_file_create_temporary(const char* path, char* temporary, size_t size);

/// Free disk space beside `path` in bytes; UINT64_MAX if unknown.
uint64_t stp_file_room(const char* path);

/// Removes temporary files that killed writers of `path` left: those whose process no longer
/// exists.
void stp_file_remove_stale(stp_context* context, const char* path);
