// SPDX-License-Identifier: MIT
// Reads single objects from the file; pages are verified and decoded as needed.
#include "store/file/block_table.h"
#include "store/file/tables.h"

#include <assert.h>

static stp_result read_record(stp_store* store, uint32_t index, stp_store_object* object)
{
    const stp_store_section* section = store->known[STP_SECTION_OBJECTS];
    const stp_store_section* texts = store->known[STP_SECTION_OBJECT_TEXT];
    const stp_store_table* table = stp_store_table_of(STP_SECTION_OBJECTS);
    if (store->only_summary || section == NULL || index >= section->count) {
        return store->only_summary ? stp_fail(store->context, STP_ERROR_ARGUMENT,
                                              "%s: was opened only for its summary", store->path)
                                   : stp_store_fail_index(store, "object", index);
    }
    uint64_t offset = (uint64_t)index * section->record_size;
    stp_result result = stp_store_verify_range(store, section, offset, section->record_size);
    if (result != STP_OK) {
        return result;
    }
    const unsigned char *records = NULL, *stored = NULL;
    stp_store_text text = {.context = store->context};
    result = stp_store_find_content(store, section, &records);
    if (result == STP_OK && texts != NULL && texts->record_size == 1) {
        result = stp_store_find_content(store, texts, &stored);
        text.stored = (const char*)stored;
        text.size = (size_t)stp_store_content_bytes(texts);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_store_codec codec = {.input = records + offset, .text = &text};
    table->code(&codec, object);
    assert(codec.offset == table->record_size && "a record has exactly its fields");
    const char* fault = codec.fault;
    if (fault == NULL && object->parent != STP_STORE_NONE && object->parent >= index) {
        fault = "has a parent with a higher index";
    }
    if (fault == NULL && object->node != STP_STORE_NONE &&
        object->node >= store->directory.node_count) {
        fault = "has a node that does not exist";
    }
    return fault == NULL ? STP_OK
                         : stp_fail(store->context, STP_ERROR_FORMAT, "%s: object %u %s",
                                    store->path, index, fault);
}

stp_result stp_store_read_object_place(stp_store* store, uint32_t index, stp_store_object* object)
{
    stp_result result = read_record(store, index, object);
    object->name = object->id = NULL;
    return result;
}

stp_result stp_store_read_object(stp_store* store, uint32_t index, stp_store_object* object)
{
    stp_store_text uses = {.context = store->context};
    stp_result result = read_record(store, index, object);
    if (result == STP_OK) {
        result = stp_store_verify_text(store, STP_SECTION_OBJECT_TEXT, &uses, object->name);
    }
    if (result == STP_OK) {
        result = stp_store_verify_text(store, STP_SECTION_OBJECT_TEXT, &uses, object->id);
    }
    return result;
}
