// SPDX-License-Identifier: MIT
#include "base/core/atomic_limits.h"
#include "base/io/bytes.h"
#include "base/io/hash.h"
#include "import/e57/e57.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

#define HEADER_SIZE 48
#define GRAIN ((size_t)1024) ///< pages

typedef struct checking {
    const unsigned char* bytes;
    atomic_uint_fast64_t first_bad;
} checking;

static uint32_t read_big_endian(const unsigned char* p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static void check_pages(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    checking* c = user;
    for (size_t i = begin; i < end; ++i) {
        const unsigned char* page = c->bytes + i * STP_E57_PAGE;
        if (stp_crc32c(page, STP_E57_PAYLOAD) != read_big_endian(page + STP_E57_PAYLOAD)) {
            stp_atomic_min(&c->first_bad, i);
            return;
        }
    }
}

static stp_result check_all_pages(const stp_e57* e57, size_t page_count)
{
    const stp_import* import = e57->import;
    checking c = {.bytes = import->file.bytes};
    atomic_init(&c.first_bad, page_count);
    stp_parallel_for(import->context, page_count, GRAIN, check_pages, &c);
    size_t bad = atomic_load(&c.first_bad);
    assert(bad <= page_count);
    return bad == page_count
               ? STP_OK
               : stp_fail(import->context, STP_ERROR_FORMAT,
                          "%s: page %zu of %zu is damaged: its checksum does not match",
                          import->path, bad + 1, page_count);
}

stp_result stp_e57_open_pages(stp_e57* e57)
{
    const stp_import* import = e57->import;
    const unsigned char* bytes = import->file.bytes;
    if (import->file.size < HEADER_SIZE) {
        return stp_fail(import->context, STP_ERROR_TRUNCATED,
                        "%s: is shorter than the header of an E57 file", import->path);
    }
    if (memcmp(bytes, "ASTM-E57", 8) != 0) {
        return stp_fail(import->context, STP_ERROR_FORMAT, "%s: has no E57 signature",
                        import->path);
    }
    uint32_t major = stp_read_u32(bytes + 8);
    uint64_t size = stp_read_u64(bytes + 16), page_size = stp_read_u64(bytes + 40);
    if (major != 1 || page_size != STP_E57_PAGE) {
        return stp_fail(import->context, STP_ERROR_UNSUPPORTED,
                        "%s: has version %u and pages of %llu bytes: only version 1 with pages of "
                        "1024 bytes is supported",
                        import->path, major, (unsigned long long)page_size);
    }
    if (size > import->file.size) {
        return stp_fail(import->context, STP_ERROR_TRUNCATED,
                        "%s: its header says %llu bytes, but it ends after %zu", import->path,
                        (unsigned long long)size, import->file.size);
    }
    if (size == 0 || size % STP_E57_PAGE != 0) {
        return stp_fail(import->context, STP_ERROR_FORMAT,
                        "%s: its header says %llu bytes, which is not a whole number of pages",
                        import->path, (unsigned long long)size);
    }
    e57->logical_size = size / STP_E57_PAGE * STP_E57_PAYLOAD;
    e57->xml_logical = stp_e57_logical(e57, stp_read_u64(bytes + 24));
    e57->xml_length = stp_read_u64(bytes + 32);
    if (e57->xml_logical == UINT64_MAX || e57->xml_length > e57->logical_size - e57->xml_logical) {
        return stp_fail(import->context, STP_ERROR_FORMAT,
                        "%s: its XML section lies outside the file", import->path);
    }
    assert(e57->xml_logical + e57->xml_length <= e57->logical_size);
    return check_all_pages(e57, (size_t)(size / STP_E57_PAGE));
}

uint64_t stp_e57_logical(const stp_e57* e57, uint64_t physical)
{
    uint64_t within = physical % STP_E57_PAGE;
    uint64_t logical = physical / STP_E57_PAGE * STP_E57_PAYLOAD + within;
    return within < STP_E57_PAYLOAD && logical < e57->logical_size ? logical : UINT64_MAX;
}

size_t stp_e57_peek(const stp_e57* e57, uint64_t logical, const unsigned char** bytes)
{
    if (logical >= e57->logical_size) {
        return 0;
    }
    size_t within = (size_t)(logical % STP_E57_PAYLOAD);
    *bytes = e57->import->file.bytes + (size_t)(logical / STP_E57_PAYLOAD) * STP_E57_PAGE + within;
    assert(*bytes + (STP_E57_PAYLOAD - within) <= e57->import->file.bytes + e57->import->file.size);
    return STP_E57_PAYLOAD - within;
}

bool stp_e57_copy(const stp_e57* e57, uint64_t logical, void* bytes, size_t size)
{
    unsigned char* out = bytes;
    while (size > 0) {
        const unsigned char* from = NULL;
        size_t held = stp_e57_peek(e57, logical, &from);
        held = held < size ? held : size;
        if (held == 0) {
            return false;
        }
        memcpy(out, from, held);
        out += held;
        logical += held;
        size -= held;
    }
    return true;
}
