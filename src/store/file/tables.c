// SPDX-License-Identifier: MIT
// Decodes the texts and the records of a section.
#include "store/file/tables.h"

#include <assert.h>
#include <string.h>

stp_result stp_store_read_text(stp_store* store, uint32_t type, stp_store_text* text)
{
    const stp_store_section* section = store->known[type];
    *text = (stp_store_text){.context = store->context};
    if (section == NULL || section->size == 0) {
        return STP_OK;
    }
    const unsigned char* content = NULL;
    stp_result result = stp_store_find_content(store, section, &content);
    if (result == STP_OK) {
        result = stp_store_is_packed(section)
                     ? stp_store_unpack_range(store, section, 0, stp_store_content_bytes(section))
                     : stp_store_verify_section(store, section);
    }
    if (result != STP_OK) {
        return result;
    }
    text->size = (size_t)stp_store_content_bytes(section);
    if (!stp_store_is_packed(section)) {
        // A copy keeps its final zero byte even if the mapped file is overwritten.
        if (store->tables[type] == NULL) {
            store->tables[type] = stp_alloc(store->context, text->size);
        }
        if (store->tables[type] == NULL) {
            return stp_fail_memory(store->context);
        }
        content = memcpy(store->tables[type], content, text->size);
    }
    text->stored = (const char*)content;
    text->checked = true;
    if (section->record_size != 1 || text->stored[text->size - 1] != '\0') {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the texts of type %u do not end with a zero byte", store->path, type);
    }
    return STP_OK;
}

// Decodes records [first, first + count).
static stp_result decode_records(stp_store* store, const stp_store_section* section,
                                 stp_store_text* text, const unsigned char* bytes, uint32_t first,
                                 uint32_t count)
{
    const stp_store_table* table = stp_store_table_of(section->type);
    char* elements = store->tables[section->type];
    assert(first <= store->counts[section->type] && count <= store->counts[section->type] - first);
    for (uint32_t i = first; i < first + count; ++i, bytes += section->record_size) {
        stp_store_codec codec = {.input = bytes, .text = text};
        table->code(&codec, elements + i * table->element_size);
        assert(codec.offset == table->record_size && "a record has exactly its fields");
        if (codec.fault != NULL) {
            return stp_fail(store->context, STP_ERROR_FORMAT, "%s: %s %u %s", store->path,
                            table->name, i, codec.fault);
        }
    }
    return STP_OK;
}

// Decodes page by page.
static stp_result decode_packed(stp_store* store, const stp_store_section* section,
                                stp_store_text* text)
{
    unsigned char* content = stp_alloc(store->context, STP_STORE_CHUNK_BYTES);
    uint64_t pages = stp_store_packed_page_count(section);
    uint32_t records = STP_STORE_CHUNK_BYTES / section->record_size;
    stp_result result =
        content != NULL ? stp_store_open_packed(store, section) : stp_fail_memory(store->context);
    for (uint64_t page = 0; page < pages && result == STP_OK; ++page) {
        size_t size = stp_store_page_size(section, page);
        result = stp_store_read_page(store, section, page, content);
        if (result == STP_OK) {
            result = decode_records(store, section, text, content, (uint32_t)page * records,
                                    (uint32_t)(size / section->record_size));
        }
    }
    stp_free(store->context, content);
    return result;
}

stp_result stp_store_read_table(stp_store* store, uint32_t type, stp_store_text* text)
{
    const stp_store_section* section = store->known[type];
    const stp_store_table* table = stp_store_table_of(type);
    assert(table->code != NULL && store->tables[type] == NULL && "read once, or freed");
    if (section == NULL || section->count == 0) {
        return STP_OK;
    }
    bool packed = stp_store_is_packed(section);
    stp_result result = packed ? STP_OK : stp_store_verify_section(store, section);
    if (result != STP_OK) {
        return result;
    }
    char* elements = stp_alloc_zeroed(store->context, (size_t)section->count, table->element_size);
    if (elements == NULL) {
        return stp_fail_memory(store->context);
    }
    store->tables[type] = elements;
    store->counts[type] = (uint32_t)section->count;
    return packed ? decode_packed(store, section, text)
                  : decode_records(store, section, text, store->file.bytes + section->offset, 0,
                                   store->counts[type]);
}
