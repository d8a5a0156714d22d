// SPDX-License-Identifier: MIT
// Files: mapped for reading, written aside and renamed.
#pragma once

#include "base/context.h"

/// A whole file as memory. `bytes` is NULL where the file is empty.
typedef struct stp_mapped_file {
    const unsigned char* bytes;
    size_t size;
} stp_mapped_file;

/// Maps `path` for reading. Directories, devices and pipes are refused.
/// @return STP_OK, or STP_ERROR_IO (logged, with the system's reason)
STP_MUST_USE stp_result stp_file_map(stp_context* context, const char* path, stp_mapped_file* file);
/// The same, and leaves the file open for reading besides: `descriptor` is the caller's to close, and -1 on failure.
STP_MUST_USE stp_result stp_file_map_open(stp_context* context, const char* path,
                                          stp_mapped_file* file, int* descriptor);
/// Reads a part of an open file. Any thread. @return false where it has no such part, or cannot be read
bool stp_file_read_at(int descriptor, uint64_t offset, void* bytes, size_t size);
void stp_file_close(int descriptor);
/// Reads the first bytes of a regular file, at most `size`. @return how many; 0 of what cannot be read, or is a folder, a
/// device or a pipe
size_t stp_file_peek(const char* path, void* bytes, size_t size);
/// Says that few places of the file will be read, in no order: nothing is read ahead.
void stp_file_expect_random(const stp_mapped_file* file);
/// Gives back the memory that holds what has been read of the file; it stays readable, and is read again where
/// needed. Any thread, while others read.
void stp_file_forget(const stp_mapped_file* file);
void stp_file_unmap(stp_mapped_file* file);

/// A file in the making: bytes go to `path`.tmp-<process>-<number>, which becomes `path` at commit or
/// vanishes. What stands at `path` and is no regular file (a folder, a device) is refused at once.
typedef struct stp_file_writer stp_file_writer;

STP_MUST_USE stp_result stp_file_writer_open(stp_context* context, const char* path,
                                             stp_file_writer** writer);
/// Appends, through a buffer.
STP_MUST_USE stp_result stp_file_writer_append(stp_file_writer* writer, const void* bytes,
                                               size_t size);
/// Replaces bytes already appended; `offset` + `size` must not pass the end.
STP_MUST_USE stp_result stp_file_writer_patch(stp_file_writer* writer, uint64_t offset,
                                              const void* bytes, size_t size);
/// Bytes appended so far.
uint64_t stp_file_writer_size(const stp_file_writer* writer);
/// Syncs, renames to the final name and ends the writer. On failure the temporary file is removed.
STP_MUST_USE stp_result stp_file_writer_commit(stp_file_writer* writer);
/// The same without syncing, for what need not outlast a loss of power.
STP_MUST_USE stp_result stp_file_writer_commit_passing(stp_file_writer* writer);
/// Removes the temporary file and ends the writer. NULL is allowed.
void stp_file_writer_abort(stp_file_writer* writer);

/// Makes an empty file beside `path` of a name nobody else uses (`path`.tmp-<process>-<number>), for a child to write.
/// @return false where it cannot be made (errno says why; ENAMETOOLONG where `size` is too small for the name)
bool stp_file_create_beside(const char* path, char* temporary, size_t size);

/// How many bytes the disk still takes beside `path`; UINT64_MAX where it does not say.
uint64_t stp_file_room(const char* path);

/// Removes what killed writers of `path` left beside it: their temporary files, where no such process lives.
void stp_file_remove_stale(stp_context* context, const char* path);
