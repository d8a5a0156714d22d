// SPDX-License-Identifier: MIT
#include "draw/gl/conversions.h"

#include "base/core/context.h"

#include <assert.h>

void stp_gl_conversions_destroy(stp_context* context, stp_gl_conversions* c)
{
    stp_free(context, c->sources);
    stp_free(context, c->pieces);
    *c = (stp_gl_conversions){0};
}

stp_gl_source* stp_gl_conversions_begin(stp_gl_conversions* c, const stp_gl_pool* pool,
                                        uint32_t entry, uint64_t words)
{
    assert(stp_gl_pool_has(pool, entry) && "room was taken first");
    assert(c->left == 0 && "the item before is complete");
    c->source_count = c->piece_count > 0 ? c->source_count : 0;
    if (!STP_MAKE_ROOM(pool->context, c->sources, c->source_capacity, c->source_count + 1)) {
        (void)stp_fail_memory(pool->context);
        return NULL;
    }
    c->address = pool->entries[entry].address;
    c->left = words;
    stp_gl_source* source = &c->sources[c->source_count++];
    source->entry = entry;
    return source;
}

static stp_result report_change(const stp_gl_pool* pool)
{
    return stp_fail(pool->context, STP_ERROR_FORMAT,
                    "gl: data changed while it was uploaded: its file was overwritten");
}

stp_result stp_gl_conversions_end(const stp_gl_conversions* c, const stp_gl_pool* pool)
{
    return c->left == 0 ? STP_OK : report_change(pool);
}

stp_result stp_gl_conversions_add(stp_gl_conversions* c, stp_gl_pool* pool, stp_gl_piece piece)
{
    assert(c->source_count > 0 && piece.words > 0 && piece.words <= POOL_PART_WORDS);
    stp_result result = STP_OK;
    if (piece.words > c->left) {
        return report_change(pool);
    }
    if (piece.words > POOL_PART_WORDS - c->words) {
        result = stp_gl_conversions_send(c, pool);
    }
    if (result == STP_OK &&
        !STP_MAKE_ROOM(pool->context, c->pieces, c->piece_capacity, c->piece_count + 1)) {
        result = stp_fail_memory(pool->context);
    }
    if (result != STP_OK) {
        return result;
    }
    piece.source = (uint32_t)c->source_count - 1;
    piece.address = c->address;
    piece.offset = c->words;
    c->pieces[c->piece_count++] = piece;
    c->address += piece.words;
    c->words += piece.words;
    c->left -= piece.words;
    return STP_OK;
}

stp_result stp_gl_conversions_add_range(stp_gl_conversions* c, stp_gl_pool* pool,
                                        stp_gl_convert* convert, size_t begin, size_t end,
                                        uint32_t each)
{
    assert(each > 0 && each <= GL_PIECE_WORDS);
    const size_t most = GL_PIECE_WORDS / each;
    stp_result result = STP_OK;
    for (size_t at = begin; at < end && result == STP_OK;) {
        size_t count = end - at < most ? end - at : most;
        stp_gl_piece piece = {
            .convert = convert, .begin = at, .end = at + count, .words = (uint32_t)count * each};
        result = stp_gl_conversions_add(c, pool, piece);
        at += count;
    }
    return result;
}

typedef struct batch {
    const stp_gl_conversions* c;
    uint32_t* words;
} batch;

static void convert_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    const batch* b = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_gl_piece* piece = &b->c->pieces[i];
        piece->convert(&b->c->sources[piece->source], piece, b->words + piece->offset);
    }
}

/// Copies each item's pieces to the pool, which follow each other there, too.
static void copy_pieces(const stp_gl_conversions* c, stp_gl_pool* pool,
                        const stp_gl_ring_part* part)
{
    for (size_t i = 0, next; i < c->piece_count; i = next) {
        uint32_t words = 0;
        for (next = i; next < c->piece_count && c->pieces[next].source == c->pieces[i].source;
             ++next) {
            assert(c->pieces[next].address == c->pieces[i].address + words);
            words += c->pieces[next].words;
        }
        stp_gl_pool_copy(pool, part, c->pieces[i].offset, c->pieces[i].address, words);
    }
}

stp_result stp_gl_conversions_send(stp_gl_conversions* c, stp_gl_pool* pool)
{
    stp_gl_ring_part part;
    if (c->piece_count == 0) {
        return STP_OK;
    }
    if (!stp_gl_pool_write(pool, c->words, &part)) {
        stp_gl_conversions_drop(c, pool);
        return stp_fail(pool->context, STP_ERROR_UNSUPPORTED,
                        "gl: the graphics context was lost while data was uploaded");
    }
    batch b = {.c = c, .words = part.memory};
    stp_parallel_for(pool->context, c->piece_count, 1, convert_pieces, &b);
    copy_pieces(c, pool, &part);
    stp_gl_ring_mark(pool->gl, &pool->ring);
    // the last item may get more pieces
    c->sources[0] = c->sources[c->source_count - 1];
    c->source_count = 1;
    c->piece_count = 0;
    c->words = 0;
    return STP_OK;
}

void stp_gl_conversions_cancel(stp_gl_conversions* c, stp_gl_pool* pool)
{
    assert(c->source_count > 0 && "an item has begun");
    stp_gl_pool_drop(pool, c->sources[--c->source_count].entry);
    c->left = 0;
}

void stp_gl_conversions_drop(stp_gl_conversions* c, stp_gl_pool* pool)
{
    for (size_t i = 0; i < c->source_count; ++i) {
        bool unfinished = i + 1 == c->source_count && c->left > 0;
        if (c->piece_count > 0 || unfinished) {
            stp_gl_pool_drop(pool, c->sources[i].entry);
        }
    }
    c->source_count = c->piece_count = 0;
    c->words = 0;
    c->left = 0;
}
