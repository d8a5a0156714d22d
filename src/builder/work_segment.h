// SPDX-License-Identifier: MIT
//
// A segment file of the work folder: a header, then results, each with its own header. All
// headers have 64 bytes and end with their own checksum.
//
//   segment header:  0 magic 8 | 8 version u32 | 12 zero | 56 checksum u64
//   result header:   0 mark 8 | 8 key 16 | 24 size u64 | 32 checksum of the bytes u64 |
//                    40 zero | 56 checksum u64
//
// A result's header is written when its room is reserved. So if a kill interrupts writing its
// bytes, later results are still found; the checksum detects the incomplete one.
#pragma once

#include "base/core/context.h"
#include "base/io/hash.h"

enum { STP_WORK_VERSION = 1, STP_WORK_HEAD_SIZE = 64 };

/// The folder of the segments.
typedef struct stp_work_place {
    stp_context* context;
    const char* path; ///< for messages
    int folder;       ///< descriptor
} stp_work_place;

typedef struct stp_work_segment {
    uint32_t number;
    int file;                   ///< -1: closed for writing
    uint32_t writers;           ///< results in progress
    const unsigned char* bytes; ///< the whole segment, mapped
    size_t capacity;            ///< bytes mapped
    size_t used; ///< bytes used by results with their headers; the next one starts here
} stp_work_segment;

/// The content of a result's header.
typedef struct stp_work_head {
    stp_hash key;
    uint64_t size, checksum;
} stp_work_head;

enum { STP_WORK_NAME_SIZE = 24 };
void stp_work_segment_name(uint32_t number, char name[STP_WORK_NAME_SIZE]);
/// The number in a segment's file name; UINT32_MAX for other names.
uint32_t stp_work_segment_number(const char* name);

/// Bytes that a result of `size` bytes takes with its header; 0 if too large.
size_t stp_work_record_bytes(uint64_t size);

/// Creates a file and maps `capacity` bytes, which its results may fill. @return STP_OK,
/// STP_ERROR_IO, or STP_ERROR_LIMIT if there are too many segments (logged)
STP_MUST_USE stp_result stp_work_segment_create(const stp_work_place* place, uint32_t number,
                                                size_t capacity, stp_work_segment* segment);

typedef enum stp_work_kind {
    STP_WORK_SEGMENT, ///< a segment of this version
    STP_WORK_USELESS, ///< a segment of another version, or its header is damaged
    STP_WORK_FOREIGN, ///< another program's file: ignore it
} stp_work_kind;

/// Opens the file for appending and returns its kind. Only STP_WORK_SEGMENT leaves it open, not
/// mapped yet.
STP_MUST_USE stp_result stp_work_segment_open(const stp_work_place* place, uint32_t number,
                                              stp_work_segment* segment, stp_work_kind* kind);

/// Called for each result; `offset` is that of its bytes.
typedef stp_result (*stp_work_visit)(const stp_work_head* head, size_t offset, void* user);

/// Reads all headers of an opened segment, truncates incomplete data after the last whole result,
/// and maps at least `capacity` bytes. @return the result of `visit`, STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_work_segment_scan(const stp_work_place* place, size_t capacity,
                                              stp_work_segment* segment, stp_work_visit visit,
                                              void* user);

/// Writes a result's header at `used` and advances `used` behind the result. There must be room.
STP_MUST_USE stp_result stp_work_segment_reserve(const stp_work_place* place,
                                                 stp_work_segment* segment,
                                                 const stp_work_head* head, size_t* offset);
/// Writes the bytes of a reserved result. `segment` is a copy, so that other threads can reserve
/// meanwhile. @return false on a system error (errno; not logged)
bool stp_work_segment_write(const stp_work_segment* segment, size_t offset, const stp_bytes* parts,
                            size_t part_count);
/// Logs a write error of a segment. `reason`: its errno. @return STP_ERROR_IO
stp_result stp_work_segment_fail_write(const stp_work_place* place, uint32_t number, int reason);
/// Takes back a reserved result if it is the last one.
void stp_work_segment_take_back(stp_work_segment* segment, size_t offset, uint64_t size);

/// Releases the memory of mapped bytes; they are read again when used.
void stp_work_segment_release_pages(const stp_work_segment* segment);

/// Closes the file for writing; the mapping stays.
void stp_work_segment_finish(stp_work_segment* segment);
void stp_work_segment_close(stp_work_segment* segment);

/// Stores a header's checksum.
void stp_work_seal_head(unsigned char head[STP_WORK_HEAD_SIZE]);
