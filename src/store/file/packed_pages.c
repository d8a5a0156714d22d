// SPDX-License-Identifier: MIT
// Reads packed sections page by page, each page once.
#include "base/io/bytes.h"
#include "store/bytes/packed.h"
#include "store/file/tables.h"

#include <assert.h>
#include <string.h>

static stp_store_packed* state_of(stp_store* store, const stp_store_section* section)
{
    assert(section >= store->sections && section < store->sections + store->section_count);
    return &store->packed[section - store->sections];
}

static stp_result fail_page(const stp_store* store, const stp_store_section* section, uint64_t page,
                            const char* what)
{
    return stp_fail(store->context, STP_ERROR_FORMAT,
                    "%s: the %s of page %llu of the section of type %u is wrong", store->path, what,
                    (unsigned long long)page, section->type);
}

stp_result stp_store_open_packed(stp_store* store, const stp_store_section* section)
{
    stp_store_packed* state = state_of(store, section);
    if (state->offsets != NULL) {
        return STP_OK;
    }
    uint64_t pages = stp_store_packed_page_count(section);
    uint64_t table = stp_store_packed_table_bytes(section);
    const unsigned char* entry = store->file.bytes + section->offset;
    store->bytes_checked += table;
    if (stp_store_crc(0, entry, (size_t)table) != section->crc) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the checksum of the section of type %u is wrong", store->path,
                        section->type);
    }
    uint64_t* offsets = STP_NEW_ARRAY(store->context, uint64_t, (size_t)pages + 1);
    if (offsets == NULL) {
        return stp_fail_memory(store->context);
    }
    uint64_t end = section->offset + table;
    for (uint64_t i = 0; i < pages; ++i, entry += STP_STORE_CHUNK_ENTRY) {
        offsets[i] = end;
        end += stp_read_u32(entry); // fewer than 2^32 pages, each smaller than 2^32 bytes
    }
    offsets[pages] = end;
    if (end != section->offset + section->size) {
        stp_free(store->context, offsets);
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the pages of the section of type %u do not fill it", store->path,
                        section->type);
    }
    state->offsets = offsets;
    return STP_OK;
}

size_t stp_store_page_size(const stp_store_section* section, uint64_t page)
{
    assert(page < stp_store_packed_page_count(section));
    uint32_t page_bytes = stp_store_packed_page_bytes(section);
    uint64_t left = stp_store_content_bytes(section) - page * page_bytes;
    return left < page_bytes ? (size_t)left : page_bytes;
}

stp_result stp_store_read_page(stp_store* store, const stp_store_section* section, uint64_t page,
                               void* out)
{
    const uint64_t* offsets = state_of(store, section)->offsets;
    assert(offsets != NULL && "stp_store_open_packed comes first");
    assert(offsets[page + 1] <= section->offset + section->size);
    const unsigned char* entry = store->file.bytes + section->offset + page * STP_STORE_CHUNK_ENTRY;
    const unsigned char* stored = store->file.bytes + offsets[page];
    uint64_t stored_size = offsets[page + 1] - offsets[page];
    size_t size = stp_store_page_size(section, page);
    store->bytes_checked += stored_size;
    if (stored_size > size) {
        return fail_page(store, section, page, "size");
    }
    if (stp_store_crc(0, stored, (size_t)stored_size) != stp_read_u32(entry + 4)) {
        return fail_page(store, section, page, "checksum");
    }
    if (stored_size == size) {
        memcpy(out, stored, size);
        return STP_OK;
    }
    if (!stp_store_unpack(&store->unpacker, stored, (size_t)stored_size, out, size)) {
        return store->unpacker == NULL ? stp_fail_memory(store->context)
                                       : fail_page(store, section, page, "compression");
    }
    return STP_OK;
}

stp_result stp_store_check_packed(stp_store* store, const stp_store_section* section,
                                  uint64_t pages)
{
    unsigned char* content = stp_alloc(store->context, STP_STORE_CHUNK_BYTES);
    uint64_t count = stp_store_packed_page_count(section);
    stp_result result =
        content != NULL ? stp_store_open_packed(store, section) : stp_fail_memory(store->context);
    for (uint64_t page = 0; result == STP_OK && page < count && page < pages; ++page) {
        result = stp_store_read_page(store, section, page, content);
    }
    stp_free(store->context, content);
    return result;
}

stp_result stp_store_find_content(stp_store* store, const stp_store_section* section,
                                  const unsigned char** content)
{
    stp_store_packed* state = state_of(store, section);
    if (!stp_store_is_packed(section)) {
        *content = store->file.bytes + section->offset;
        return STP_OK;
    }
    stp_result result = stp_store_open_packed(store, section);
    if (result == STP_OK && state->content == NULL) {
        uint64_t pages = stp_store_packed_page_count(section);
        unsigned char* bytes = STP_NEW_ARRAY(store->context, unsigned char,
                                             (size_t)stp_store_content_bytes(section) + 1);
        uint8_t* here = STP_NEW_ZEROED(store->context, uint8_t, (size_t)pages / 8 + 1);
        if (bytes == NULL || here == NULL) {
            stp_free(store->context, bytes);
            stp_free(store->context, here);
            return stp_fail_memory(store->context);
        }
        state->content = bytes;
        state->here = here;
    }
    *content = state->content;
    return result;
}

stp_result stp_store_unpack_range(stp_store* store, const stp_store_section* section,
                                  uint64_t offset, uint64_t size)
{
    const unsigned char* content = NULL;
    stp_result result = stp_store_find_content(store, section, &content);
    if (result != STP_OK || size == 0) {
        return result;
    }
    stp_store_packed* state = state_of(store, section);
    uint32_t page_bytes = stp_store_packed_page_bytes(section);
    uint64_t last = (offset + size - 1) / page_bytes;
    for (uint64_t page = offset / page_bytes; result == STP_OK && page <= last; ++page) {
        if ((state->here[page / 8] >> page % 8 & 1) == 0) {
            result = stp_store_read_page(store, section, page, state->content + page * page_bytes);
            state->here[page / 8] |= (uint8_t)((result == STP_OK ? 1u : 0u) << page % 8);
        }
    }
    return result;
}

void stp_store_free_packed(stp_store* store)
{
    for (uint32_t i = 0; i < store->section_count && i < STP_STORE_SECTION_LIMIT; ++i) {
        stp_free(store->context, store->packed[i].offsets);
        stp_free(store->context, store->packed[i].content);
        stp_free(store->context, store->packed[i].here);
    }
    stp_store_unpacker_destroy(store->unpacker);
}
