// SPDX-License-Identifier: MIT
// Files of simulated scans: one streaming writer per format, with bounded memory. Written under a
// temporary name and renamed.
#pragma once

#include "base/io/file.h"
#include "lab/scan/scan_sweep.h"

typedef struct scan_file scan_file;

/// A format. Functions are called in this order: begin, then for each station begin_station, add
/// (several times) and end_station, then end. NULL functions are skipped.
typedef struct scan_format {
    const char* ending; ///< extension of file names, such as ".las"
    bool has_truth;     ///< it has columns for the truth
    stp_result (*begin)(scan_file* file);
    stp_result (*begin_station)(scan_file* file, const scan_station* station);
    /// Points of whole columns of the sweep, in order, misses included.
    stp_result (*add)(scan_file* file, const scan_station* station, const scan_point* points,
                      size_t count);
    stp_result (*end_station)(scan_file* file, const scan_station* station);
    stp_result (*end)(scan_file* file);
} scan_format;

extern const scan_format scan_format_las, scan_format_ptx, scan_format_ply, scan_format_e57;

/// The format for a file name; NULL: none.
const scan_format* scan_format_of(const char* path);

/// Parameters of the file.
typedef struct scan_file_desc {
    const char* path;
    double shift[3];   ///< added to all places
    stp_boxd bounds;   ///< approximate bounds of the points, without the shift
    bool truth;        ///< columns of the truth
    uint32_t stations; ///< how many will be written
} scan_file_desc;

struct scan_file {
    stp_context* context;
    stp_file_writer* writer;
    const scan_format* format;
    scan_file_desc desc;
    uint64_t points, misses; ///< so far
    stp_boxd bounds;         ///< bounds of the points so far, without the shift
    // state of the individual writers
    double offset[3];             ///< LAS: to be added to stored coordinates, metres
    stp_boxd stored;              ///< LAS: smallest and largest stored coordinates
    size_t header_size;           ///< PLY: bytes to be written over at the end
    struct scan_e57_state* state; ///< E57
};

/// @return STP_OK, or a failure that was logged; then there is nothing to close
STP_MUST_USE stp_result scan_file_open(stp_context* context, const scan_file_desc* desc,
                                       scan_file* file);
STP_MUST_USE stp_result scan_file_begin_station(scan_file* file, const scan_station* station);
STP_MUST_USE stp_result scan_file_add(scan_file* file, const scan_station* station,
                                      const scan_point* points, size_t count);
STP_MUST_USE stp_result scan_file_end_station(scan_file* file, const scan_station* station);
/// Completes and renames the file. @return STP_OK, or a failure that was logged; then nothing
/// is left
STP_MUST_USE stp_result scan_file_close(scan_file* file);
/// Aborts and leaves no file.
void scan_file_abort(scan_file* file);

// The pages that an E57 file (ASTM E2807) is made of: 1,020 bytes and their CRC-32C. Offsets within
// the file count the checksums (physical) or leave them out (logical).

enum { E57_PAGE = 1024, E57_PAYLOAD = 1020 };

/// Pages being written; the last, incomplete page is buffered here.
typedef struct e57_pages {
    stp_file_writer* writer;
    uint64_t whole; ///< pages written
    size_t used;    ///< buffered bytes of the next page, below E57_PAYLOAD
    unsigned char payload[E57_PAYLOAD];
} e57_pages;

/// Offset of the next byte.
uint64_t e57_physical(const e57_pages* pages);
uint64_t e57_logical(const e57_pages* pages);

STP_MUST_USE stp_result e57_put(e57_pages* pages, const void* bytes, size_t size);
/// Fills the page with zeros and writes it, unless it is empty.
STP_MUST_USE stp_result e57_end_page(e57_pages* pages);
/// Rewrites a whole page.
/// @param payload E57_PAYLOAD bytes
STP_MUST_USE stp_result e57_replace_page(e57_pages* pages, uint64_t page,
                                         const unsigned char* payload);
