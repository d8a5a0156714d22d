// SPDX-License-Identifier: MIT
#include "draw/gl/pool.h"

#include "base/core/context.h"

#include <assert.h>

enum {
    WORD = 4,
    RING_BYTES = 1 << 24,
    PAGE_SHIFT_MIN = 18, ///< words: 1 MiB
    PAGE_SHIFT_MAX = 29, ///< eight pages fill the addresses
};

/// Smallest page size with which one page holds the whole scene, and eight hold `limit`; at most
/// the size of a block that shaders can read. Shaders read one page fastest, and must be compiled
/// again for more.
static uint32_t choose_shift(const stp_gl* gl, uint64_t limit, uint64_t scene_bytes)
{
    GLint64 maximum = 0;
    uint64_t wanted = scene_bytes < limit ? scene_bytes : limit;
    uint32_t shift = PAGE_SHIFT_MIN;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &maximum);
    while (
        shift < PAGE_SHIFT_MAX && (int64_t)8 << shift <= maximum &&
        ((uint64_t)WORD << shift < wanted || ((uint64_t)WORD * POOL_PAGES_MAX << shift) < limit)) {
        shift += 1;
    }
    return shift;
}

/// Words of the first page. A small scene gets no more than it needs: some drivers clear all of it.
static uint32_t choose_first(uint32_t page_shift, uint64_t scene_bytes)
{
    uint32_t shift = PAGE_SHIFT_MIN;
    while (shift < page_shift && (uint64_t)WORD << shift < scene_bytes) {
        shift += 1;
    }
    return 1u << shift;
}

stp_result stp_gl_pool_create(stp_context* context, const stp_gl* gl, size_t entry_count,
                              uint64_t limit_bytes, uint64_t scene_bytes, stp_gl_pool* pool)
{
    *pool = (stp_gl_pool){.context = context,
                          .gl = gl,
                          .spans.context = context,
                          .entry_count = entry_count,
                          .first_used = POOL_NONE,
                          .last_used = POOL_NONE};
    pool->page_shift = choose_shift(gl, limit_bytes, scene_bytes);
    pool->first_words = choose_first(pool->page_shift, scene_bytes);
    assert(pool->first_words <= 1u << pool->page_shift && "pages have equal ranges of addresses");
    uint64_t maximum = (uint64_t)POOL_PAGES_MAX << pool->page_shift;
    pool->limit_words = limit_bytes / WORD < maximum ? limit_bytes / WORD : maximum;
    pool->entries = STP_NEW_ARRAY(context, stp_gl_entry, entry_count + 1);
    if (pool->entries == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < entry_count; ++i) {
        pool->entries[i] = (stp_gl_entry){.address = POOL_NONE};
    }
    if (!stp_gl_ring_create(gl, RING_BYTES, &pool->ring)) {
        stp_gl_pool_destroy(pool);
        return stp_fail(context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: graphics memory cannot be mapped for uploads of %d MiB",
                        RING_BYTES >> 20);
    }
    return STP_OK;
}

void stp_gl_pool_destroy(stp_gl_pool* pool)
{
    if (pool->gl == NULL) {
        return;
    }
    stp_gl_ring_destroy(pool->gl, &pool->ring);
    pool->gl->DeleteBuffers((GLsizei)pool->page_count, pool->pages);
    stp_gl_spans_destroy(&pool->spans);
    stp_free(pool->context, pool->entries);
    *pool = (stp_gl_pool){0};
}

void stp_gl_pool_begin_frame(stp_gl_pool* pool)
{
    pool->frame += 1;
}

static void unlink_entry(stp_gl_pool* pool, const stp_gl_entry* entry)
{
    if (entry->previous != POOL_NONE) {
        pool->entries[entry->previous].next = entry->next;
    } else {
        pool->first_used = entry->next;
    }
    if (entry->next != POOL_NONE) {
        pool->entries[entry->next].previous = entry->previous;
    } else {
        pool->last_used = entry->previous;
    }
}

static void append_entry(stp_gl_pool* pool, uint32_t index)
{
    stp_gl_entry* entry = &pool->entries[index];
    entry->previous = pool->last_used;
    entry->next = POOL_NONE;
    entry->used_frame = pool->frame;
    if (pool->last_used != POOL_NONE) {
        pool->entries[pool->last_used].next = index;
    } else {
        pool->first_used = index;
    }
    pool->last_used = index;
}

void stp_gl_pool_use(stp_gl_pool* pool, uint32_t entry)
{
    assert(entry < pool->entry_count && stp_gl_pool_has(pool, entry));
    if (pool->entries[entry].used_frame != pool->frame) {
        unlink_entry(pool, &pool->entries[entry]);
        append_entry(pool, entry);
    }
}

void stp_gl_pool_drop(stp_gl_pool* pool, uint32_t entry)
{
    assert(entry < pool->entry_count && stp_gl_pool_has(pool, entry) && "dropped once");
    stp_gl_entry* dropped = &pool->entries[entry];
    unlink_entry(pool, dropped);
    stp_gl_spans_release(&pool->spans, dropped->span);
    dropped->address = POOL_NONE;
}

/// Creates a buffer of `count` words.
static bool make_page(stp_gl_pool* pool, uint32_t count)
{
    assert(pool->page_count < POOL_PAGES_MAX && count > 0 && count % SPANS_UNIT == 0);
    const stp_gl* gl = pool->gl;
    GLuint* page = &pool->pages[pool->page_count];
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    gl->CreateBuffers(1, page);
    gl->NamedBufferStorage(*page, (GLsizeiptr)count * WORD, NULL, 0);
    if (gl->GetError() != GL_NO_ERROR ||
        !stp_gl_spans_add_region(&pool->spans, pool->page_count << pool->page_shift, count)) {
        gl->DeleteBuffers(1, page);
        return false;
    }
    gl->ObjectLabel(GL_BUFFER, *page, -1, "page");
    pool->page_count += 1;
    return true;
}

/// Words of another page: 0 if the limit allows none.
static uint32_t find_page_words(const stp_gl_pool* pool)
{
    uint32_t size = 1u << pool->page_shift;
    if (pool->page_count == 0 && pool->first_words < size) {
        size = pool->first_words;
    }
    uint64_t left = pool->limit_words -
                    (pool->limit_words < pool->spans.total ? pool->limit_words : pool->spans.total);
    uint32_t count = left < size ? (uint32_t)left / SPANS_UNIT * SPANS_UNIT : size;
    return pool->page_count < POOL_PAGES_MAX ? count : 0;
}

/// Adds a buffer if the limit allows one. If memory is short, it is smaller; after a smaller first
/// one, so are the addresses of all later ones.
static bool add_page(stp_gl_pool* pool)
{
    uint32_t count = find_page_words(pool);
    if (count == 0) {
        return false;
    }
    bool made = make_page(pool, count);
    while (!made && count > 1u << PAGE_SHIFT_MIN) {
        count = count / 2 / SPANS_UNIT * SPANS_UNIT;
        while (pool->page_count == 0 && pool->page_shift > PAGE_SHIFT_MIN &&
               1u << pool->page_shift > count) {
            pool->page_shift -= 1;
        }
        count = count < 1u << pool->page_shift ? count : 1u << pool->page_shift;
        made = make_page(pool, count);
    }
    if (!made) {
        pool->limit_words = pool->spans.total; // out of memory: continue with the existing pages
    }
    return made;
}

bool stp_gl_pool_take(stp_gl_pool* pool, uint32_t entry, uint64_t words)
{
    assert(entry < pool->entry_count && !stp_gl_pool_has(pool, entry) && "it has no place yet");
    stp_gl_entry* taken = &pool->entries[entry];
    words = words > 0 ? words : 1; // empty entries have a place, too
    if (words > 1u << pool->page_shift) {
        return false;
    }
    uint32_t span = stp_gl_spans_take(&pool->spans, (uint32_t)words);
    while (span == SPANS_NONE) {
        uint32_t oldest = pool->first_used;
        if (!add_page(pool)) {
            if (oldest == POOL_NONE || pool->entries[oldest].used_frame == pool->frame) {
                return false;
            }
            stp_gl_pool_drop(pool, oldest);
        }
        span = stp_gl_spans_take(&pool->spans, (uint32_t)words);
    }
    taken->span = span;
    taken->address = stp_gl_spans_first(&pool->spans, span);
    assert(stp_gl_spans_count(&pool->spans, span) >= words && taken->address != POOL_NONE);
    append_entry(pool, entry);
    return true;
}

bool stp_gl_pool_write(stp_gl_pool* pool, uint64_t words, stp_gl_ring_part* part)
{
    assert(words > 0 && words <= POOL_PART_WORDS && "half of the ring at most");
    return stp_gl_ring_take(pool->gl, &pool->ring, words * WORD, part);
}

void stp_gl_pool_copy(stp_gl_pool* pool, const stp_gl_ring_part* part, uint32_t offset,
                      uint32_t address, uint64_t words)
{
    uint32_t place = address & ((1u << pool->page_shift) - 1);
    assert(words > 0 && offset + words <= POOL_PART_WORDS && address != POOL_NONE);
    pool->gl->CopyNamedBufferSubData(pool->ring.buffer, pool->pages[address >> pool->page_shift],
                                     part->offset + (GLintptr)offset * WORD, (GLintptr)place * WORD,
                                     (GLsizeiptr)(words * WORD));
}
