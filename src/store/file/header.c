// SPDX-License-Identifier: MIT
// Reads the first bytes of a file: header and section table. Trusts nothing.
#include "base/io/bytes.h"
#include "store/file/tables.h"

#include <assert.h>
#include <string.h>

static stp_result fail_format(const stp_store* store, const char* what)
{
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: %s", store->path, what);
}

static stp_result check_magic(const stp_store* store)
{
    const unsigned char* bytes = store->file.bytes;
    size_t size = store->file.size;
    size_t known = size < STP_STORE_MAGIC_BYTES ? size : STP_STORE_MAGIC_BYTES;
    if (known != 0 && memcmp(bytes, STP_STORE_MAGIC, known) != 0) {
        bool damaged = known >= 4 && memcmp(bytes, STP_STORE_MAGIC, 4) == 0;
        return fail_format(store, damaged ? "was damaged by a transfer that changed line ends"
                                          : "is not a .stip file");
    }
    if (size < STP_STORE_HEADER_BYTES) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends after %zu bytes, within its header of %d", store->path, size,
                        STP_STORE_HEADER_BYTES);
    }
    return STP_OK;
}

static stp_result check_sizes(const stp_store* store)
{
    if (store->file_bytes > INT64_MAX || store->data_offset > store->file_bytes ||
        store->data_offset % STP_STORE_ALIGNMENT != 0) {
        return fail_format(store, "the data offset in the header lies outside of the file");
    }
    if (store->file.size > store->file_bytes) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: has %zu bytes, but its header says %llu", store->path,
                        store->file.size, (unsigned long long)store->file_bytes);
    }
    uint64_t needed = store->desc.accept_partial ? store->data_offset : store->file_bytes;
    if (store->file.size < needed && store->desc.accept_partial) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends after %zu of %llu bytes, within its directory: the first %llu "
                        "bytes are needed to show anything",
                        store->path, store->file.size, (unsigned long long)store->file_bytes,
                        (unsigned long long)needed);
    }
    if (store->file.size < needed) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED, "%s: ends after %zu of %llu bytes",
                        store->path, store->file.size, (unsigned long long)store->file_bytes);
    }
    return STP_OK;
}

// Offsets of the fields are those of docs/format.md, Header.
static stp_result read_fields(stp_store* store)
{
    const unsigned char* p = store->file.bytes;
    if (stp_read_u16(p + 8) > STP_STORE_MAJOR) {
        return stp_fail(store->context, STP_ERROR_VERSION,
                        "%s: has format version %u; this reader supports versions up to %d",
                        store->path, stp_read_u16(p + 8), STP_STORE_MAJOR);
    }
    if (stp_read_u32(p + 124) != stp_store_crc(0, p, 124)) {
        return fail_format(store, "the checksum of the header is wrong");
    }
    if (stp_read_u16(p + 8) != STP_STORE_MAJOR || stp_read_u32(p + 12) != STP_STORE_HEADER_BYTES) {
        return fail_format(store, "the version or size of the header is invalid");
    }
    store->minor = stp_read_u16(p + 10);
    store->file_bytes = stp_read_u64(p + 16);
    store->data_offset = stp_read_u64(p + 24);
    store->section_count = stp_read_u32(p + 32);
    store->directory.root = stp_read_u32(p + 40);
    store->directory.unit_metres = stp_read_f64(p + 48);
    store->directory.up = (char)p[56];
    bool reserved = stp_read_u32(p + 44) != 0;
    for (int i = 57; i < 124; ++i) {
        reserved = reserved || p[i] != 0;
    }
    if (reserved) {
        return fail_format(store, "a reserved field of the header is not zero");
    }
    return STP_OK;
}

static bool are_zero(const unsigned char* bytes, uint64_t begin, uint64_t end)
{
    assert(begin <= end);
    for (uint64_t i = begin; i < end; ++i) {
        if (bytes[i] != 0) {
            return false;
        }
    }
    return true;
}

// A section must start right after the one before. Its records must be at least as large as this
// version requires.
static const char* find_section_fault(const stp_store* store, const stp_store_section* section,
                                      uint64_t end)
{
    const stp_store_table* table = stp_store_table_of(section->type);
    if (section->offset != stp_store_align(end, STP_STORE_ALIGNMENT) ||
        section->offset > store->data_offset ||
        section->size > store->data_offset - section->offset) {
        return "does not start right after the previous section";
    }
    if (!are_zero(store->file.bytes, end, section->offset)) {
        return "has padding before it that is not zero";
    }
    if ((section->flags & ~(uint32_t)(STP_SECTION_CRITICAL | STP_SECTION_PACKED)) != 0) {
        return "has flags that this version does not define";
    }
    if (section->record_size == 0 ||
        !(stp_store_is_packed(section)
              ? stp_store_can_pack(section)
              : section->size % section->record_size == 0 &&
                    section->size / section->record_size == section->count)) {
        return "has the wrong size for its records";
    }
    if (table->record_size > section->record_size || section->count >= STP_STORE_NONE) {
        return "has records that are too short, or too many";
    }
    if (section->type == STP_SECTION_PAGES && stp_store_is_packed(section)) {
        return "is packed, but the table of page checksums cannot be";
    }
    if (section->type < STP_SECTION_END && store->known[section->type] != NULL) {
        return "occurs twice";
    }
    return NULL;
}

static stp_result read_sections(stp_store* store)
{
    const unsigned char* p = store->file.bytes;
    uint64_t end =
        STP_STORE_HEADER_BYTES + (uint64_t)store->section_count * STP_STORE_SECTION_BYTES;
    if (store->section_count > STP_STORE_SECTION_LIMIT || end > store->data_offset) {
        return fail_format(store, "the section table does not fit before the data");
    }
    store->section_end = end;
    assert(end <= store->file.size && "read_fields and check_sizes come first");
    if (stp_read_u32(p + 36) !=
        stp_store_crc(0, p + STP_STORE_HEADER_BYTES, (size_t)end - STP_STORE_HEADER_BYTES)) {
        return fail_format(store, "the checksum of the section table is wrong");
    }
    stp_store_codec codec = {.input = p, .offset = STP_STORE_HEADER_BYTES};
    for (uint32_t i = 0; i < store->section_count; ++i) {
        stp_store_section* section = &store->sections[i];
        stp_store_code_section(&codec, section);
        const char* fault = find_section_fault(store, section, end);
        if (fault != NULL) {
            return stp_fail(store->context, STP_ERROR_FORMAT, "%s: section %u of type %u %s",
                            store->path, i, section->type, fault);
        }
        if (stp_store_table_of(section->type)->record_size != 0) {
            store->known[section->type] = section;
        } else if ((section->flags & STP_SECTION_CRITICAL) != 0) {
            return stp_fail(store->context, STP_ERROR_UNSUPPORTED,
                            "%s: needs a reader that knows sections of type %u", store->path,
                            section->type);
        }
        end = section->offset + section->size;
    }
    if (store->data_offset != stp_store_align(end, STP_STORE_ALIGNMENT) ||
        !are_zero(p, end, store->data_offset)) {
        return fail_format(store, "the data does not start right after the sections");
    }
    return STP_OK;
}

stp_result stp_store_read_header(stp_store* store)
{
    stp_result result = check_magic(store);
    if (result == STP_OK) {
        result = read_fields(store);
    }
    if (result == STP_OK) {
        result = check_sizes(store);
    }
    result = result == STP_OK ? read_sections(store) : result;
    assert((result != STP_OK || store->data_offset <= store->file.size) && "directory is mapped");
    return result;
}
