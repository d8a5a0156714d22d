// SPDX-License-Identifier: MIT
// Texts of records: position, length, and limits on their use.
#include "store/file/tables.h"

#include <assert.h>
#include <string.h>

#define USES_ALWAYS (UINT64_C(1) << 24) // total bytes of texts that any file may use
#define USES_OF_EACH 16                 // plus this many times the section's size
#define EACH_USE 256                    // plus this many bytes per use

const char* stp_store_use_text(stp_store_text* text, const char* at)
{
    assert(at >= text->stored && (size_t)(at - text->stored) < text->size);
    size_t left = text->size - (size_t)(at - text->stored);
    size_t maximum = left < STP_STORE_TEXT_LIMIT + 1 ? left : STP_STORE_TEXT_LIMIT + 1;
    size_t length = strnlen(at, maximum);
    if (length > STP_STORE_TEXT_LIMIT) {
        return "has a text of more than 4095 bytes";
    }
    text->used += length;
    text->uses += 1;
    if (text->used > USES_ALWAYS + USES_OF_EACH * (uint64_t)text->size + EACH_USE * text->uses) {
        return "shares texts of too many bytes in total";
    }
    return NULL;
}

stp_result stp_store_verify_text(stp_store* store, uint32_t type, stp_store_text* uses,
                                 const char* text)
{
    const stp_store_section* section = store->known[type];
    if (text == NULL) {
        return STP_OK;
    }
    const unsigned char* content = NULL;
    stp_result result = stp_store_find_content(store, section, &content);
    if (result != STP_OK) {
        return result;
    }
    const char* first = (const char*)content;
    uint64_t begin = (uint64_t)(text - first), size = stp_store_content_bytes(section);
    assert(begin < size && "the text lies in this section");
    uint64_t maximum = begin + STP_STORE_TEXT_LIMIT + 1, end = size < maximum ? size : maximum;
    bool ended = false;
    for (uint64_t at = begin; at < end && !ended && result == STP_OK;) {
        uint64_t next = (at / STP_STORE_PAGE_BYTES + 1) * STP_STORE_PAGE_BYTES;
        next = next < size ? next : size;
        result = stp_store_verify_range(store, section, at, next - at);
        ended = result == STP_OK && memchr(first + at, 0, (size_t)(next - at)) != NULL;
        at = next;
    }
    if (result != STP_OK) {
        return result;
    }
    if (!ended && end == size) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the texts of type %u do not end with a zero byte", store->path, type);
    }
    uses->stored = first;
    uses->size = (size_t)size;
    const char* fault = stp_store_use_text(uses, text);
    return fault == NULL
               ? STP_OK
               : stp_fail(store->context, STP_ERROR_FORMAT, "%s: a record %s", store->path, fault);
}
