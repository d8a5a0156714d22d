// SPDX-License-Identifier: MIT
#include "scan_e57_pages.h"

#include "base/bytes.h"

uint32_t e57_crc(const unsigned char* bytes, size_t size)
{
    // remainders of four bits, of the polynomial 0x1EDC6F41 with its bits turned around
    static const uint32_t table[16] = {
        0x00000000u, 0x105EC76Fu, 0x20BD8EDEu, 0x30E349B1u, 0x417B1DBCu, 0x5125DAD3u,
        0x61C69362u, 0x7198540Du, 0x82F63B78u, 0x92A8FC17u, 0xA24BB5A6u, 0xB21572C9u,
        0xC38D26C4u, 0xD3D3E1ABu, 0xE330A81Au, 0xF36E6F75u,
    };
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        crc = table[crc & 15u] ^ crc >> 4;
        crc = table[crc & 15u] ^ crc >> 4;
    }
    return ~crc;
}

static void seal(const unsigned char* payload, unsigned char page[E57_PAGE])
{
    uint32_t crc = e57_crc(payload, E57_PAYLOAD);
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
    seal(payload, page);
    return stp_file_writer_patch(pages->writer, number * E57_PAGE, page, E57_PAGE);
}
