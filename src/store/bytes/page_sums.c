// SPDX-License-Identifier: MIT
#include "store/bytes/page_sums.h"

#include "store/bytes/deflate.h"

#include <assert.h>

void stp_store_page_sums_begin(stp_store_page_sums* sums, uint32_t type, bool packed)
{
    assert(type < STP_SECTION_END);
    sums->first_pages[type] = sums->count;
    sums->filled = STP_STORE_PAGE_BYTES; // so that the first byte opens a page
    sums->open = type != STP_SECTION_PAGES && !packed;
}

stp_result stp_store_page_sums_add(stp_store_page_sums* sums, const void* bytes, size_t size)
{
    const unsigned char* next = bytes;
    while (sums->open && size != 0) {
        if (sums->filled == STP_STORE_PAGE_BYTES) {
            if (!STP_MAKE_ROOM(sums->context, sums->crcs, sums->capacity, sums->count + 1)) {
                return stp_fail_memory(sums->context);
            }
            sums->crcs[sums->count++] = 0;
            sums->filled = 0;
        }
        assert(sums->count != 0 && sums->filled < STP_STORE_PAGE_BYTES);
        size_t room = STP_STORE_PAGE_BYTES - sums->filled, step = size < room ? size : room;
        uint32_t* crc = &sums->crcs[sums->count - 1];
        *crc = stp_store_crc(*crc, next, step);
        sums->filled += step;
        next += step;
        size -= step;
    }
    return STP_OK;
}

void stp_store_page_sums_replace(stp_store_page_sums* sums, uint32_t type, const void* bytes,
                                 size_t size)
{
    const unsigned char* next = bytes;
    for (size_t page = sums->first_pages[type]; size != 0; ++page) {
        size_t step = size < STP_STORE_PAGE_BYTES ? size : STP_STORE_PAGE_BYTES;
        assert(page < sums->count && "the section was written with this size");
        sums->crcs[page] = stp_store_crc(0, next, step);
        next += step;
        size -= step;
    }
}
