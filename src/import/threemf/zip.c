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
    LOCATOR_SIZE = 20,    // before the record at the end: where the 64-bit record is
    END64_SIZE = 56,      // of the 64-bit record
    EXTRA64 = 1,          // extra field of an entry with 64-bit sizes
    STORED = 0,
    DEFLATED = 8,
    ENCRYPTED = 1,   // flag
    EXPANSION = 1032 // DEFLATE makes at most this many bytes of one
};
#define END_MARK UINT32_C(0x06054b50)
#define LOCATOR_MARK UINT32_C(0x07064b50)
#define END64_MARK UINT32_C(0x06064b50)
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

typedef struct directory {
    uint64_t start, end, count; ///< bytes [start, end) of the file, and entries
} directory;

// Where the directory is. Fields of the record at the end that are too small for their values are
// in a 64-bit record.
static stp_result find_directory(const stp_zip* zip, const unsigned char* end, directory* d)
{
    const unsigned char* bytes = zip->import->file.bytes;
    uint64_t at = (uint64_t)(end - bytes);
    *d = (directory){.start = stp_read_u32(end + 16), .end = at, .count = stp_read_u16(end + 10)};
    bool full =
        d->start == UINT32_MAX || d->count == UINT16_MAX || stp_read_u32(end + 12) == UINT32_MAX;
    if (full && at >= LOCATOR_SIZE && stp_read_u32(end - LOCATOR_SIZE) == LOCATOR_MARK) {
        uint64_t limit = at - LOCATOR_SIZE, record = stp_read_u64(end - LOCATOR_SIZE + 8);
        if (record > limit || limit - record < END64_SIZE ||
            stp_read_u32(bytes + record) != END64_MARK) {
            return fail(zip, "has a damaged directory");
        }
        *d = (directory){.start = stp_read_u64(bytes + record + 48),
                         .end = record,
                         .count = stp_read_u64(bytes + record + 32)};
    }
    bool good = d->start <= d->end && d->count <= (d->end - d->start) / DIRECTORY_ENTRY;
    return good ? STP_OK : fail(zip, "has a damaged directory");
}

// Replaces the fields of an entry that are full by those of its 64-bit extra field. @return false
// if the field is too short for them
static bool read_extra(const unsigned char* extra, size_t size, stp_zip_entry* entry)
{
    uint64_t* fields[] = {&entry->size, &entry->packed, &entry->header};
    for (size_t at = 0; size - at >= 4;) {
        const unsigned char* field = extra + at + 4;
        size_t length = stp_read_u16(extra + at + 2), used = 0;
        if (length > size - at - 4) {
            return true; // some writers pad the extra fields
        }
        for (size_t i = 0; i < 3 && stp_read_u16(extra + at) == EXTRA64; ++i) {
            if (*fields[i] == UINT32_MAX) {
                if (length - used < 8) {
                    return false;
                }
                *fields[i] = stp_read_u64(field + used);
                used += 8;
            }
        }
        at += 4 + length;
        assert(at <= size && used <= length);
    }
    return true;
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
    size_t extra = DIRECTORY_ENTRY + entry->name_length, extra_size = stp_read_u16(at + 30);
    *used = extra + extra_size + stp_read_u16(at + 32);
    if ((stp_read_u16(at + 8) & ENCRYPTED) != 0) {
        return stp_fail(zip->import->context, STP_ERROR_UNSUPPORTED, "%s: is encrypted",
                        zip->import->path);
    }
    bool good = *used <= left && read_extra(at + extra, extra_size, entry);
    return good ? STP_OK : fail(zip, "has a damaged directory");
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
    directory d;
    stp_result result = find_directory(zip, end, &d);
    if (result != STP_OK) {
        return result;
    }
    zip->entries = STP_NEW_ARRAY(import->context, stp_zip_entry, (size_t)d.count + 1);
    if (zip->entries == NULL) {
        return stp_fail_memory(import->context);
    }
    for (uint64_t at = d.start; zip->count < d.count; ++zip->count) {
        size_t used = 0;
        result =
            read_entry(zip, bytes + at, (size_t)(d.end - at), &zip->entries[zip->count], &used);
        if (result != STP_OK) {
            return result;
        }
        at += used;
        assert(at <= d.end);
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
        memcpy(out, data, (size_t)entry->size);
        return true;
    }
    struct libdeflate_decompressor* unpacker = libdeflate_alloc_decompressor();
    size_t made = 0;
    bool good = unpacker != NULL &&
                libdeflate_deflate_decompress(unpacker, data, (size_t)entry->packed, out,
                                              (size_t)entry->size, &made) == LIBDEFLATE_SUCCESS &&
                made == entry->size;
    if (unpacker != NULL) {
        libdeflate_free_decompressor(unpacker);
    }
    return good;
}

stp_result stp_zip_unpack(stp_zip* zip, const stp_zip_entry* entry, unsigned char** bytes,
                          size_t* size, const char** reason)
{
    stp_context* context = zip->import->context;
    const unsigned char* data = find_data(zip, entry);
    bool stored = entry->method == STORED;
    *bytes = NULL;
    if (!stored && entry->method != DEFLATED) {
        *reason = "its compression is not supported";
        return STP_ERROR_UNSUPPORTED;
    }
    bool plausible = data != NULL && (stored ? entry->size == entry->packed
                                             : entry->size / EXPANSION <= entry->packed);
    zip->unpacked += plausible ? entry->size : 0; // entries may share their bytes
    if (!plausible || zip->unpacked / EXPANSION > zip->import->file.size) {
        *reason = "it is not in the file";
        return STP_ERROR_FORMAT;
    }
    unsigned char* out = stp_alloc(context, (size_t)entry->size + 1);
    if (out == NULL) {
        return stp_fail_memory(context);
    }
    if (!unpack(data, entry, out) || libdeflate_crc32(0, out, (size_t)entry->size) != entry->crc) {
        stp_free(context, out);
        *reason = "it is damaged";
        return STP_ERROR_FORMAT;
    }
    *bytes = out;
    *size = (size_t)entry->size;
    return STP_OK;
}

stp_result stp_zip_read(stp_zip* zip, const stp_zip_entry* entry, unsigned char** bytes,
                        size_t* size)
{
    const char* reason = NULL;
    stp_result result = stp_zip_unpack(zip, entry, bytes, size, &reason);
    if (result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY) {
        return result;
    }
    assert(reason != NULL);
    if (result == STP_ERROR_UNSUPPORTED) {
        return stp_fail(zip->import->context, result,
                        "%s: \"%.*s\" is compressed by method %u, which is not supported",
                        zip->import->path, (int)entry->name_length, entry->name, entry->method);
    }
    return stp_fail(zip->import->context, result, "%s: \"%.*s\" cannot be read: %s",
                    zip->import->path, (int)entry->name_length, entry->name, reason);
}
