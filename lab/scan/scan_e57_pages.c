// SPDX-License-Identifier: MIT
#include "base/io/hash.h"
#include "lab/scan/scan_file.h"

#include <assert.h>
#include <string.h>

static void seal(const unsigned char* payload, unsigned char page[E57_PAGE])
{
    uint32_t crc = stp_crc32c(payload, E57_PAYLOAD);
    memcpy(page, payload, E57_PAYLOAD);
    for (int k = 0; k < 4; ++k) { // the largest part first, unlike all else
        page[E57_PAYLOAD + k] = (unsigned char)(crc >> (24 - 8 * k));
    }
}

uint64_t e57_physical(const e57_pages* pages)
{
    return pages->whole * E57_PAGE + pages->used;
}

uint64_t e57_logical(const e57_pages* pages)
{
    return pages->whole * E57_PAYLOAD + pages->used;
}

static stp_result write_page(e57_pages* pages)
{
    unsigned char page[E57_PAGE];
    seal(pages->payload, page);
    pages->whole += 1;
    pages->used = 0;
    return stp_file_writer_append(pages->writer, page, E57_PAGE);
}

stp_result e57_put(e57_pages* pages, const void* bytes, size_t size)
{
    const unsigned char* from = bytes;
    stp_result result = STP_OK;
    assert(pages->used < E57_PAYLOAD && "full pages are written at once");
    while (size > 0 && result == STP_OK) {
        size_t room = E57_PAYLOAD - pages->used, part = size < room ? size : room;
        memcpy(pages->payload + pages->used, from, part);
        pages->used += part;
        from += part;
        size -= part;
        if (pages->used == E57_PAYLOAD) {
            result = write_page(pages);
        }
    }
    return result;
}

stp_result e57_end_page(e57_pages* pages)
{
    if (pages->used == 0) {
        return STP_OK;
    }
    memset(pages->payload + pages->used, 0, E57_PAYLOAD - pages->used);
    return write_page(pages);
}

stp_result e57_replace_page(e57_pages* pages, uint64_t number, const unsigned char* payload)
{
    unsigned char page[E57_PAGE];
    assert(number < pages->whole && "only a written page can be replaced");
    seal(payload, page);
    return stp_file_writer_patch(pages->writer, number * E57_PAGE, page, E57_PAGE);
}
