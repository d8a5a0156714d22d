// SPDX-License-Identifier: MIT
//
// One segment file of the work directory: a head, then results, each behind a head of its own. All heads have 64
// bytes and end with a checksum of themselves.
//
//   segment head:  0 magic 8 | 8 version u32 | 12 zero | 56 checksum u64
//   result head:   0 mark 8 | 8 key 16 | 24 size u64 | 32 checksum of the bytes u64 | 40 zero | 56 checksum u64
//
// A result's head is written when its place is reserved, so that one whose bytes a kill cut off does not hide the
// ones behind it: its checksum tells.
#pragma once

#include "base/context.h"
#include "base/hash.h"

enum { STP_WORK_VERSION = 1, STP_WORK_HEAD_SIZE = 64 };

/// The folder that segments lie in.
typedef struct stp_work_place {
    stp_context* context;
    const char* path; ///< for messages
    int folder;       ///< its descriptor
} stp_work_place;

typedef struct stp_work_segment {
    uint32_t number;
    int file;                   ///< -1: nothing more will be written to it
    uint32_t writers;           ///< results being written
    const unsigned char* bytes; ///< all of it, mapped
    size_t capacity;            ///< bytes mapped
    size_t used; ///< bytes given to results, heads included; the next one begins here
} stp_work_segment;

/// What a result's head says.
typedef struct stp_work_head {
    stp_hash key;
    uint64_t size, checksum;
} stp_work_head;

enum { STP_WORK_NAME_SIZE = 24 };
void stp_work_segment_name(uint32_t number, char name[STP_WORK_NAME_SIZE]);
/// The number in a segment's name; UINT32_MAX where it is no such name.
uint32_t stp_work_segment_number(const char* name);

/// Bytes that a result of `size` bytes takes in a segment, its head included; 0 where that is too much.
size_t stp_work_record_bytes(uint64_t size);

/// Makes a file with room for `capacity` bytes. @return STP_OK, or STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_work_segment_create(const stp_work_place* place, uint32_t number,
                                                size_t capacity, stp_work_segment* segment);

typedef enum stp_work_kind {
    STP_WORK_SEGMENT, ///< of this version
    STP_WORK_USELESS, ///< of another version, or ended within its head
    STP_WORK_FOREIGN, ///< somebody else's file: leave it alone
} stp_work_kind;

/// Opens the file for appending and tells its kind; only STP_WORK_SEGMENT leaves it open, not mapped yet.
STP_MUST_USE stp_result stp_work_segment_open(const stp_work_place* place, uint32_t number,
                                              stp_work_segment* segment, stp_work_kind* kind);

/// Called for each result; `offset` is that of its bytes.
typedef stp_result (*stp_work_visit)(const stp_work_head* head, size_t offset, void* user);

/// Reads all heads of an opened segment, cuts off what a kill left behind the last whole one, and maps it with room
/// for at least `capacity` bytes. @return what `visit` returns, STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_work_segment_scan(const stp_work_place* place, size_t capacity,
                                              stp_work_segment* segment, stp_work_visit visit,
                                              void* user);

/// Writes a result's head at `used`, which moves on behind the result. There must be room.
STP_MUST_USE stp_result stp_work_segment_reserve(const stp_work_place* place,
                                                 stp_work_segment* segment,
                                                 const stp_work_head* head, size_t* offset);
/// Writes the bytes of a reserved result. `segment` is a copy, so that others may reserve meanwhile. @return false
/// where the system refuses (errno; not logged)
bool stp_work_segment_write(const stp_work_segment* segment, size_t offset, const stp_bytes* pieces,
                            size_t piece_count);
/// Says that a segment cannot be written, for the system's reason.
stp_result stp_work_segment_fail_write(const stp_work_place* place, uint32_t number, int reason);
/// Takes a reserved result back, where it is the last one.
void stp_work_segment_take_back(stp_work_segment* segment, size_t offset, uint64_t size);

/// Gives back the memory of the mapped bytes, which are read again where needed.
void stp_work_segment_release_pages(const stp_work_segment* segment);

/// Ends writing; what is mapped stays.
void stp_work_segment_finish(stp_work_segment* segment);
void stp_work_segment_close(stp_work_segment* segment);

/// Puts a head's checksum where it belongs.
void stp_work_seal_head(unsigned char head[STP_WORK_HEAD_SIZE]);
