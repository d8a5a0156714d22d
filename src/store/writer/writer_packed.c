// SPDX-License-Identifier: MIT
// Writes packed sections: gathers them page by page, compresses on all threads, writes in order.
#include "base/io/bytes.h"
#include "store/bytes/deflate.h"
#include "store/bytes/packed.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <string.h>

enum { PAGES_AT_ONCE = 16 }; ///< pages compressed at once

typedef struct packed_page {
    size_t size;        ///< size of its content
    size_t stored_size; ///< 0: out of memory
    uint32_t crc;
} packed_page;

struct stp_store_packing {
    stp_store_writing* w;
    stp_store_section* section;
    size_t page_bytes; ///< size of every page but the last one
    unsigned char *content, *stored;
    size_t room; ///< capacity of `content` and `stored` in pages
    packed_page pages[PAGES_AT_ONCE];
    size_t count;  ///< pages gathered; the last one may be incomplete
    size_t filled; ///< bytes of the last one
    unsigned char* table;
    uint64_t table_bytes, written; ///< size of `table`; number of entries filled in
    stp_store_packer** packers;    ///< one per thread, created on first use
    uint32_t thread_count;
};

stp_result stp_store_packing_begin(stp_store_writing* w, stp_store_section* section)
{
    assert(w->packing == NULL && "sections do not overlap");
    stp_store_packing* p = STP_NEW_ZEROED(w->context, stp_store_packing, 1);
    w->packing = p;
    if (p == NULL) {
        return stp_fail_memory(w->context);
    }
    uint64_t pages = stp_store_packed_page_count(section);
    p->w = w;
    p->section = section;
    p->page_bytes = stp_store_packed_page_bytes(section);
    p->room = pages < PAGES_AT_ONCE ? (size_t)pages : PAGES_AT_ONCE;
    assert(p->room >= 1 && "empty sections are not packed");
    p->table_bytes = stp_store_packed_table_bytes(section);
    p->thread_count = stp_context_thread_count(w->context);
    p->content = stp_alloc_array(w->context, p->room, p->page_bytes);
    p->stored = stp_alloc_array(w->context, p->room, p->page_bytes);
    p->table = stp_alloc_zeroed(w->context, (size_t)p->table_bytes, 1);
    p->packers = STP_NEW_ZEROED(w->context, stp_store_packer*, p->thread_count);
    if (p->content == NULL || p->stored == NULL || p->table == NULL || p->packers == NULL) {
        return stp_fail_memory(w->context);
    }
    return stp_file_writer_append(w->file, p->table, (size_t)p->table_bytes);
}

void stp_store_packing_destroy(stp_store_writing* w)
{
    stp_store_packing* p = w->packing;
    w->packing = NULL;
    if (p == NULL) {
        return;
    }
    for (uint32_t i = 0; p->packers != NULL && i < p->thread_count; ++i) {
        stp_store_packer_destroy(p->packers[i]);
    }
    stp_free(w->context, p->packers);
    stp_free(w->context, p->table);
    stp_free(w->context, p->stored);
    stp_free(w->context, p->content);
    stp_free(w->context, p);
}

static void pack_pages(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_store_packing* p = user;
    if (p->packers[worker] == NULL) {
        p->packers[worker] = stp_store_packer_create();
    }
    for (size_t i = begin; i < end && p->packers[worker] != NULL; ++i) {
        packed_page* page = &p->pages[i];
        unsigned char* out = p->stored + i * p->page_bytes;
        page->stored_size =
            stp_store_pack(p->packers[worker], p->content + i * p->page_bytes, page->size, out);
        page->crc = stp_store_crc(0, out, page->stored_size);
    }
}

/// Compresses and writes the gathered pages.
static stp_result flush(stp_store_packing* p)
{
    stp_result result = STP_OK;
    stp_parallel_for(p->w->context, p->count, 1, pack_pages, p);
    for (size_t i = 0; i < p->count && result == STP_OK; ++i) {
        packed_page* page = &p->pages[i];
        if (page->stored_size == 0) {
            result = stp_fail_memory(p->w->context);
            break;
        }
        assert((p->written + 1) * STP_STORE_CHUNK_ENTRY <= p->table_bytes);
        unsigned char* entry = p->table + p->written * STP_STORE_CHUNK_ENTRY;
        stp_write_u32(entry, (uint32_t)page->stored_size);
        stp_write_u32(entry + 4, page->crc);
        p->written += 1;
        result =
            stp_file_writer_append(p->w->file, p->stored + i * p->page_bytes, page->stored_size);
    }
    p->count = 0;
    return result;
}

stp_result stp_store_packing_add(stp_store_packing* p, const void* bytes, size_t size)
{
    const unsigned char* next = bytes;
    stp_result result = STP_OK;
    while (size != 0 && result == STP_OK) {
        if (p->count == 0 || p->filled == p->page_bytes) {
            result = p->count == p->room ? flush(p) : STP_OK;
            if (result != STP_OK) {
                break;
            }
            p->pages[p->count++] = (packed_page){0};
            p->filled = 0;
        }
        size_t left = p->page_bytes - p->filled, step = size < left ? size : left;
        memcpy(p->content + (p->count - 1) * p->page_bytes + p->filled, next, step);
        p->filled += step;
        p->pages[p->count - 1].size = p->filled;
        next += step;
        size -= step;
    }
    return result;
}

stp_result stp_store_packing_end(stp_store_packing* p)
{
    stp_store_section* section = p->section;
    stp_result result = flush(p);
    if (result == STP_OK) {
        assert(p->written * STP_STORE_CHUNK_ENTRY == p->table_bytes && "every page is written");
        result =
            stp_file_writer_patch(p->w->file, section->offset, p->table, (size_t)p->table_bytes);
    }
    section->size = stp_file_writer_size(p->w->file) - section->offset;
    section->crc = stp_store_crc(0, p->table, (size_t)p->table_bytes);
    return result;
}
