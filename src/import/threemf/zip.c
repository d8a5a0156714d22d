// SPDX-License-Identifier: MIT
#include "import/threemf/zip.h"

#include "base/io/bytes.h"

#include <assert.h>
#include <libdeflate.h>
#include <string.h>
#include <strings.h>

enum {
    END_SIZE = 22, // of the record at the end, without its comment
    COMMENT_MAX = 65535,
    DIRECTORY_ENTRY = 46, // bytes without names
    LOCAL_HEADER = 30,    // bytes without names
    STORED = 0,
    DEFLATED = 8,
    ENCRYPTED = 1,   // flag
    EXPANSION = 1032 // DEFLATE makes at most this many bytes of one
};
#define END_MARK UINT32_C(0x06054b50)
#define ENTRY_MARK UINT32_C(0x02014b50)
#define LOCAL_MARK UINT32_C(0x04034b50)

static stp_result fail(const stp_zip* zip, const char* what)
{
    return stp_fail(zip->import->context, STP_ERROR_FORMAT, "%s: its ZIP archive %s",
                    zip->import->path, what);
}

// The last end record whose comment reaches the end of the file.
static const unsigned char* find_end(const unsigned char* bytes, size_t size)
{
    size_t most = size < END_SIZE + COMMENT_MAX ? size : END_SIZE + COMMENT_MAX;
    for (size_t back = END_SIZE; back <= most; ++back) {
        const unsigned char* at = bytes + size - back;
        if (stp_read_u32(at) == END_MARK && END_SIZE + (size_t)stp_read_u16(at + 20) == back) {
            return at;
        }
    }
    return NULL;
}

static stp_result read_entry(const stp_zip* zip, const unsigned char* at, size_t left,
                             stp_zip_entry* entry, size_t* used)
{
    if (left < DIRECTORY_ENTRY || stp_read_u32(at) != ENTRY_MARK) {
        return fail(zip, "has a damaged directory");
    }
    *entry = (stp_zip_entry){.name = (const char*)at + DIRECTORY_ENTRY,
                             .name_length = stp_read_u16(at + 28),
                             .method = stp_read_u16(at + 10),
                             .crc = stp_read_u32(at + 16),
                             .packed = stp_read_u32(at + 20),
                             .size = stp_read_u32(at + 24),
                             .header = stp_read_u32(at + 42)};
    *used = DIRECTORY_ENTRY + entry->name_length + stp_read_u16(at + 30) + stp_read_u16(at + 32);
    if ((stp_read_u16(at + 8) & ENCRYPTED) != 0) {
        return stp_fail(zip->import->context, STP_ERROR_UNSUPPORTED, "%s: is encrypted",
                        zip->import->path);
    }
    return *used <= left ? STP_OK : fail(zip, "has a damaged directory");
}

stp_result stp_zip_open(stp_zip* zip, stp_import* import)
{
    *zip = (stp_zip){.import = import};
    const unsigned char* bytes = import->file.bytes;
    size_t size = import->file.size;
    const unsigned char* end = size >= END_SIZE ? find_end(bytes, size) : NULL;
    if (end == NULL) {
        return fail(zip, "has no directory: the file was truncated, or is not ZIP");
    }
    size_t count = stp_read_u16(end + 10), start = stp_read_u32(end + 16);
    size_t directory = (size_t)(end - bytes);
    if (count == UINT16_MAX || start == UINT32_MAX) {
        return stp_fail(import->context, STP_ERROR_UNSUPPORTED,
                        "%s: is a 64-bit ZIP archive, which is not supported", import->path);
    }
    if (start > directory || count > (directory - start) / DIRECTORY_ENTRY) {
        return fail(zip, "has a damaged directory");
    }
    zip->entries = STP_NEW_ARRAY(import->context, stp_zip_entry, count + 1);
    if (zip->entries == NULL) {
        return stp_fail_memory(import->context);
    }
    for (size_t at = start; zip->count < count; ++zip->count) {
        size_t used = 0;
        stp_result result =
            read_entry(zip, bytes + at, directory - at, &zip->entries[zip->count], &used);
        if (result != STP_OK) {
            return result;
        }
        at += used;
        assert(at <= directory);
    }
    return STP_OK;
}

void stp_zip_close(stp_zip* zip)
{
    if (zip->import != NULL) {
        stp_free(zip->import->context, zip->entries);
    }
    *zip = (stp_zip){0};
}

const stp_zip_entry* stp_zip_find(const stp_zip* zip, const char* path)
{
    path += path[0] == '/';
    size_t length = strlen(path);
    for (size_t i = 0; i < zip->count; ++i) {
        const stp_zip_entry* entry = &zip->entries[i];
        size_t slash = entry->name_length > 0 && entry->name[0] == '/';
        if (entry->name_length - slash == length &&
            strncasecmp(entry->name + slash, path, length) == 0) {
            return entry;
        }
    }
    return NULL;
}

// The packed bytes of an entry; NULL if they are not in the file.
static const unsigned char* find_data(const stp_zip* zip, const stp_zip_entry* entry)
{
    const unsigned char* bytes = zip->import->file.bytes;
    size_t size = zip->import->file.size;
    if (entry->header > size || size - entry->header < LOCAL_HEADER ||
        stp_read_u32(bytes + entry->header) != LOCAL_MARK) {
        return NULL;
    }
    const unsigned char* at = bytes + entry->header;
    size_t skipped = LOCAL_HEADER + (size_t)stp_read_u16(at + 26) + stp_read_u16(at + 28);
    size_t left = size - entry->header;
    return skipped <= left && entry->packed <= left - skipped ? at + skipped : NULL;
}

static bool unpack(const unsigned char* data, const stp_zip_entry* entry, unsigned char* out)
{
    if (entry->method == STORED) {
        memcpy(out, data, entry->size);
        return true;
    }
    struct libdeflate_decompressor* unpacker = libdeflate_alloc_decompressor();
    size_t made = 0;
    bool good = unpacker != NULL &&
                libdeflate_deflate_decompress(unpacker, data, entry->packed, out, entry->size,
                                              &made) == LIBDEFLATE_SUCCESS &&
                made == entry->size;
    if (unpacker != NULL) {
        libdeflate_free_decompressor(unpacker);
    }
    return good;
}

stp_result stp_zip_read(stp_zip* zip, const stp_zip_entry* entry, unsigned char** bytes,
                        size_t* size)
{
    stp_context* context = zip->import->context;
    const unsigned char* data = find_data(zip, entry);
    bool stored = entry->method == STORED;
    *bytes = NULL;
    if (!stored && entry->method != DEFLATED) {
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "%s: \"%.*s\" is compressed by method %u, which is not supported",
                        zip->import->path, (int)entry->name_length, entry->name, entry->method);
    }
    bool plausible =
        stored ? entry->size == entry->packed : entry->size / EXPANSION <= entry->packed;
    zip->unpacked += entry->size; // entries may share their bytes
    plausible = plausible && zip->unpacked / EXPANSION <= zip->import->file.size;
    if (data == NULL || !plausible) {
        return fail(zip, "has an entry that is not in the file");
    }
    unsigned char* out = stp_alloc(context, (size_t)entry->size + 1);
    if (out == NULL) {
        return stp_fail_memory(context);
    }
    if (!unpack(data, entry, out) || libdeflate_crc32(0, out, entry->size) != entry->crc) {
        stp_free(context, out);
        return stp_fail(context, STP_ERROR_FORMAT, "%s: \"%.*s\" is damaged", zip->import->path,
                        (int)entry->name_length, entry->name);
    }
    *bytes = out;
    *size = entry->size;
    return STP_OK;
}
