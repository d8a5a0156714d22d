// SPDX-License-Identifier: MIT
//
// A text split into blocks of whole lines for parallel reading.
#pragma once

#include "base/core/context.h"
#include "import/reading/text.h"

#include <assert.h>

typedef struct stp_text_block {
    stp_text begin, end; ///< ends behind a line end, with STP_SCAN_MARGIN readable bytes behind it
    uint64_t first_line; ///< from 0
} stp_text_block;

typedef struct stp_text_blocks {
    stp_context* context;
    stp_text_block* blocks;
    size_t count;
    uint64_t line_count; ///< lines of all blocks; a last line without an end counts
    unsigned char* tail; ///< a copy of the last lines, with room behind it
} stp_text_blocks;

/// Finds the lines on all threads. `bytes` must stay valid. Destroy it in any case. @return STP_OK
/// or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_text_blocks_create(stp_context* context, stp_text bytes, size_t size,
                                               stp_text_blocks* blocks);
void stp_text_blocks_destroy(stp_text_blocks* blocks);

/// The block that contains a line below line_count.
size_t stp_text_blocks_find(const stp_text_blocks* blocks, uint64_t line);
/// Start of a line below line_count.
stp_text stp_text_blocks_line(const stp_text_blocks* blocks, uint64_t line);

/// Start of the next line.
static inline stp_text stp_next_line(stp_text at)
{
    while (*at != '\n') {
        ++at;
    }
    return at + 1;
}

/// Iterates over lines.
typedef struct stp_line_cursor {
    const stp_text_blocks* blocks;
    size_t block;
    stp_text at; ///< start of the line
    uint64_t line;
} stp_line_cursor;

/// Starts at a line below line_count.
static inline stp_line_cursor stp_line_cursor_at(const stp_text_blocks* blocks, uint64_t line)
{
    return (stp_line_cursor){blocks, stp_text_blocks_find(blocks, line),
                             stp_text_blocks_line(blocks, line), line};
}

/// Advances to the next line, which must exist.
static inline void stp_line_cursor_next(stp_line_cursor* cursor)
{
    assert(cursor->block < cursor->blocks->count &&
           cursor->at < cursor->blocks->blocks[cursor->block].end && "at the start of a line");
    cursor->at = stp_next_line(cursor->at);
    cursor->line += 1;
    if (cursor->at == cursor->blocks->blocks[cursor->block].end &&
        cursor->block + 1 < cursor->blocks->count) {
        cursor->block += 1;
        cursor->at = cursor->blocks->blocks[cursor->block].begin;
    }
}

/// Advances by `count` lines, at most to the end of the text, in time proportional to the lines that
/// it passes in the last block.
void stp_line_cursor_skip(stp_line_cursor* cursor, uint64_t count);
