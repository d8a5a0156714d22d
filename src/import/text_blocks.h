// SPDX-License-Identifier: MIT
//
// A text cut into blocks of whole lines, which threads read one by one.
#pragma once

#include "base/context.h"
#include "import/text.h"

typedef struct stp_text_block {
    stp_text begin, end; ///< ends behind a line end, with STP_SCAN_MARGIN readable bytes behind it
    uint64_t first_line; ///< from 0
} stp_text_block;

typedef struct stp_text_blocks {
    stp_context* context;
    stp_text_block* blocks;
    size_t count;
    uint64_t line_count; ///< of all; a last line without an end counts
    unsigned char* tail; ///< a copy of the last lines, with room behind it
} stp_text_blocks;

/// Finds the lines on all threads. `bytes` must stay. Destroy it in any case.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_text_blocks_create(stp_context* context, stp_text bytes, size_t size,
                                               stp_text_blocks* blocks);
void stp_text_blocks_destroy(stp_text_blocks* blocks);

/// The block that holds a line below line_count.
size_t stp_text_blocks_find(const stp_text_blocks* blocks, uint64_t line);
/// Where a line below line_count begins.
stp_text stp_text_blocks_line(const stp_text_blocks* blocks, uint64_t line);

/// Where the line behind this one begins.
static inline stp_text stp_next_line(stp_text at)
{
    while (*at != '\n') {
        ++at;
    }
    return at + 1;
}

/// Runs through lines one after the other.
typedef struct stp_line_cursor {
    const stp_text_blocks* blocks;
    size_t block;
    stp_text at; ///< where the line begins
} stp_line_cursor;

/// Begins at a line below line_count.
static inline stp_line_cursor stp_line_cursor_at(const stp_text_blocks* blocks, uint64_t line)
{
    return (stp_line_cursor){blocks, stp_text_blocks_find(blocks, line),
                             stp_text_blocks_line(blocks, line)};
}

/// Steps to the next line, which must be there.
static inline void stp_line_cursor_next(stp_line_cursor* cursor)
{
    cursor->at = stp_next_line(cursor->at);
    if (cursor->at == cursor->blocks->blocks[cursor->block].end &&
        cursor->block + 1 < cursor->blocks->count) {
        cursor->block += 1;
        cursor->at = cursor->blocks->blocks[cursor->block].begin;
    }
}
