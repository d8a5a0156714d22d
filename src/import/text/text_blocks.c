// SPDX-License-Identifier: MIT
#include "import/text/text_blocks.h"

#include "import/text/text_scan.h"

#include <assert.h>
#include <string.h>

#define SPAN ((size_t)1 << 20)
#define CHUNK ((size_t)128)

typedef struct span {
    size_t first; ///< behind its first line end; 0: it has none
    size_t lines; ///< line ends in it
} span;

typedef struct counting {
    stp_text bytes;
    size_t size;
    span* spans;
} counting;

static void count_lines(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    counting* c = user;
    for (size_t i = begin; i < end; ++i) {
        size_t from = i * SPAN, to = c->size - from < SPAN ? c->size : from + SPAN, lines = 0;
        size_t at = from;
        for (; to - at >= CHUNK; at += CHUNK) { // a sum that fits a byte becomes vector code
            uint8_t sum = 0;
            for (size_t k = 0; k < CHUNK; ++k) {
                sum = (uint8_t)(sum + (c->bytes[at + k] == '\n'));
            }
            lines += sum;
        }
        for (; at < to; ++at) {
            lines += c->bytes[at] == '\n';
        }
        assert(lines <= to - from);
        stp_text found = memchr(c->bytes + from, '\n', to - from);
        c->spans[i] = (span){found != NULL ? (size_t)(found - c->bytes) + 1 : 0, lines};
    }
}

// Turns spans into blocks; a span without a line end belongs to the previous block.
static void make_blocks(stp_text_blocks* b, const counting* c, size_t span_count)
{
    uint64_t line = 0;
    for (size_t i = 0; i < span_count; ++i) {
        const span* s = &c->spans[i];
        size_t begin = i == 0 ? 0 : s->first;
        if (i == 0 || (s->first != 0 && s->first < c->size)) {
            stp_text at = c->bytes + begin;
            if (b->count > 0) {
                b->blocks[b->count - 1].end = at;
            }
            b->blocks[b->count++] = (stp_text_block){at, c->bytes + c->size, i == 0 ? 0 : line + 1};
        }
        line += s->lines;
    }
    b->line_count = line;
}

#ifndef NDEBUG
// Whether no block is empty, each ends with a line, and lines are numbered without a gap.
static bool are_blocks_in_order(const stp_text_blocks* b)
{
    for (size_t i = 0; i < b->count; ++i) {
        const stp_text_block* block = &b->blocks[i];
        if (block->begin >= block->end || block->end[-1] != '\n' ||
            block->first_line >= (i + 1 < b->count ? b->blocks[i + 1].first_line : b->line_count)) {
            return false;
        }
    }
    return true;
}
#endif

// Copies the last lines, so that in-place readers can read past their end.
static stp_result copy_tail(stp_text_blocks* b, stp_text bytes, size_t size, size_t* whole_size)
{
    size_t whole = size > STP_SCAN_MARGIN ? stp_whole_lines(bytes, size - STP_SCAN_MARGIN) : 0;
    size_t rest = size - whole;
    b->tail = stp_alloc(b->context, rest + 1 + STP_SCAN_MARGIN);
    if (b->tail == NULL) {
        return stp_fail_memory(b->context);
    }
    memcpy(b->tail, bytes + whole, rest);
    memset(b->tail + rest, '\n', 1 + STP_SCAN_MARGIN);
    assert(whole == 0 || (bytes[whole - 1] == '\n' && rest >= STP_SCAN_MARGIN));
    *whole_size = whole;
    return STP_OK;
}

stp_result stp_text_blocks_create(stp_context* context, stp_text bytes, size_t size,
                                  stp_text_blocks* b)
{
    *b = (stp_text_blocks){.context = context};
    if (size == 0) {
        return STP_OK;
    }
    counting c = {.bytes = bytes};
    stp_result result = copy_tail(b, bytes, size, &c.size);
    size_t span_count = (c.size + SPAN - 1) / SPAN;
    if (result != STP_OK) {
        return result;
    }
    b->blocks = STP_NEW_ARRAY(context, stp_text_block, span_count + 1);
    c.spans = STP_NEW_ARRAY(context, span, span_count + 1);
    if (b->blocks == NULL || c.spans == NULL) {
        stp_free(context, c.spans);
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, span_count, 1, count_lines, &c);
    make_blocks(b, &c, span_count);
    assert(b->count <= span_count && "one more is free for the tail");
    stp_free(context, c.spans);
    size_t rest = size - c.size;
    bool ended = b->tail[rest - 1] == '\n';
    size_t tail_size = rest + !ended;
    b->blocks[b->count++] = (stp_text_block){b->tail, b->tail + tail_size, b->line_count};
    for (size_t i = 0; i < tail_size; ++i) {
        b->line_count += b->tail[i] == '\n';
    }
    assert(are_blocks_in_order(b));
    return STP_OK;
}

void stp_text_blocks_destroy(stp_text_blocks* b)
{
    if (b->context != NULL) {
        stp_free(b->context, b->blocks);
        stp_free(b->context, b->tail);
    }
    *b = (stp_text_blocks){0};
}

size_t stp_text_blocks_find(const stp_text_blocks* b, uint64_t line)
{
    size_t low = 0, high = b->count;
    assert(line < b->line_count && "the line exists");
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (b->blocks[middle].first_line <= line) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(b->blocks[low].first_line <= line);
    assert(low + 1 == b->count || line < b->blocks[low + 1].first_line);
    return low;
}

stp_text stp_text_blocks_line(const stp_text_blocks* b, uint64_t line)
{
    const stp_text_block* block = &b->blocks[stp_text_blocks_find(b, line)];
    stp_text at = block->begin;
    for (uint64_t i = block->first_line; i < line; ++i) {
        at = stp_next_line(at);
    }
    assert(at < block->end);
    return at;
}

void stp_line_cursor_skip(stp_line_cursor* cursor, uint64_t count)
{
    const stp_text_blocks* b = cursor->blocks;
    uint64_t line = cursor->line + count;
    assert(line <= b->line_count && "not behind the end");
    if (line == b->line_count) {
        *cursor = (stp_line_cursor){b, b->count - 1, b->blocks[b->count - 1].end, line};
        return;
    }
    size_t block = stp_text_blocks_find(b, line);
    if (block != cursor->block) {
        const stp_text_block* to = &b->blocks[block];
        *cursor = (stp_line_cursor){b, block, to->begin, to->first_line};
    }
    for (; cursor->line < line; ++cursor->line) {
        cursor->at = stp_next_line(cursor->at);
    }
}
