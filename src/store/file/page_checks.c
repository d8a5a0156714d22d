// SPDX-License-Identifier: MIT
// Checksums of the directory: of whole sections and of their pages. Page checksums allow reading a
// few bytes of a large section without verifying all of it.
#include "base/io/bytes.h"
#include "store/file/tables.h"

#include <assert.h>

static uint64_t page_count_of(const stp_store_section* section)
{
    return section->type == STP_SECTION_PAGES || stp_store_is_packed(section)
               ? 0
               : (section->size + STP_STORE_PAGE_BYTES - 1) / STP_STORE_PAGE_BYTES;
}

// Number of pages of the sections before this one, or of all sections for NULL.
static uint64_t first_page_of(const stp_store* store, const stp_store_section* section)
{
    uint64_t pages = 0;
    for (uint32_t i = 0; i < store->section_count && &store->sections[i] != section; ++i) {
        pages += page_count_of(&store->sections[i]);
    }
    return pages;
}

// One bit per page, then one per section.
static stp_result make_marks(stp_store* store)
{
    if (store->pages_checked != NULL) {
        return STP_OK;
    }
    uint64_t bits = first_page_of(store, NULL) + store->section_count;
    store->pages_checked = STP_NEW_ZEROED(store->context, uint8_t, (size_t)(bits / 8 + 1));
    return store->pages_checked != NULL ? STP_OK : stp_fail_memory(store->context);
}

static bool is_marked(const stp_store* store, uint64_t bit)
{
    return (store->pages_checked[bit / 8] >> bit % 8 & 1) != 0;
}

static void mark(stp_store* store, uint64_t bit)
{
    store->pages_checked[bit / 8] |= (uint8_t)(1u << bit % 8);
}

stp_result stp_store_verify_section(stp_store* store, const stp_store_section* section)
{
    const unsigned char* bytes = store->file.bytes + section->offset;
    if (stp_store_is_packed(section)) {
        return stp_store_check_packed(store, section, UINT64_MAX);
    }
    store->bytes_checked += section->size;
    if (stp_store_crc(0, bytes, (size_t)section->size) != section->crc) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the checksum of the section of type %u is wrong", store->path,
                        section->type);
    }
    return STP_OK;
}

stp_result stp_store_verify_page_table(stp_store* store)
{
    const stp_store_section* table = store->known[STP_SECTION_PAGES];
    if (table == NULL || store->page_table_checked) {
        return STP_OK;
    }
    stp_result result = stp_store_verify_section(store, table);
    if (result == STP_OK && table->count != first_page_of(store, NULL)) {
        result = stp_fail(store->context, STP_ERROR_FORMAT,
                          "%s: has checksums for %llu pages but its sections have %llu",
                          store->path, (unsigned long long)table->count,
                          (unsigned long long)first_page_of(store, NULL));
    }
    store->page_table_checked = result == STP_OK;
    return result;
}

// For files without page checksums.
static stp_result verify_once(stp_store* store, const stp_store_section* section)
{
    uint64_t bit = first_page_of(store, NULL) + (uint64_t)(section - store->sections);
    if (is_marked(store, bit)) {
        return STP_OK;
    }
    stp_result result = stp_store_verify_section(store, section);
    if (result == STP_OK) {
        mark(store, bit);
    }
    return result;
}

static stp_result verify_page(stp_store* store, const stp_store_section* section, uint64_t page)
{
    const stp_store_section* table = store->known[STP_SECTION_PAGES];
    uint64_t bit = first_page_of(store, section) + page;
    if (is_marked(store, bit)) {
        return STP_OK;
    }
    uint64_t begin = page * STP_STORE_PAGE_BYTES, end = begin + STP_STORE_PAGE_BYTES;
    assert(begin < section->size && bit < table->count);
    end = end < section->size ? end : section->size;
    const unsigned char* bytes = store->file.bytes;
    uint32_t wanted = stp_read_u32(bytes + table->offset + bit * table->record_size);
    store->bytes_checked += end - begin;
    if (stp_store_crc(0, bytes + section->offset + begin, (size_t)(end - begin)) != wanted) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the checksum of page %llu of the section of type %u is wrong",
                        store->path, (unsigned long long)page, section->type);
    }
    mark(store, bit);
    return STP_OK;
}

stp_result stp_store_verify_range(stp_store* store, const stp_store_section* section,
                                  uint64_t offset, uint64_t size)
{
    assert(stp_store_is_packed(section) ||
           (offset <= section->size && size <= section->size - offset));
    if (stp_store_is_packed(section)) {
        return stp_store_unpack_range(store, section, offset, size);
    }
    stp_result result = make_marks(store);
    if (result != STP_OK || size == 0) {
        return result;
    }
    if (store->known[STP_SECTION_PAGES] == NULL || section->type == STP_SECTION_PAGES) {
        return verify_once(store, section);
    }
    result = stp_store_verify_page_table(store);
    uint64_t last = (offset + size - 1) / STP_STORE_PAGE_BYTES;
    for (uint64_t page = offset / STP_STORE_PAGE_BYTES; result == STP_OK && page <= last; ++page) {
        result = verify_page(store, section, page);
    }
    return result;
}
