// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // madvise
#include "builder/work_segment.h"

#include "base/io/bytes.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define LARGEST_RESULT ((uint64_t)1 << 46)
enum { HEAD = STP_WORK_HEAD_SIZE, SEALED = HEAD - 8, MAGIC_SIZE = 8, MAX_SEGMENTS = 1000000 };

static const char segment_magic[MAGIC_SIZE + 1] = "STPwork\n";
static const char result_mark[MAGIC_SIZE + 1] = "STPmade\n";

void stp_work_seal_head(unsigned char head[STP_WORK_HEAD_SIZE])
{
    stp_write_u64(head + SEALED, stp_checksum(&(stp_bytes){head, SEALED}, 1));
}

static bool is_sealed(const unsigned char head[STP_WORK_HEAD_SIZE])
{
    return stp_read_u64(head + SEALED) == stp_checksum(&(stp_bytes){head, SEALED}, 1);
}

void stp_work_segment_name(uint32_t number, char name[STP_WORK_NAME_SIZE])
{
    assert(number < MAX_SEGMENTS && "names have six digits");
    snprintf(name, STP_WORK_NAME_SIZE, "segment-%06u", number);
}

uint32_t stp_work_segment_number(const char* name)
{
    static const char prefix[] = "segment-";
    size_t length = sizeof(prefix) - 1;
    if (strncmp(name, prefix, length) != 0 || strlen(name) != length + 6) {
        return UINT32_MAX;
    }
    uint32_t number = 0;
    for (const char* c = name + length; *c != 0; ++c) {
        if (*c < '0' || *c > '9') {
            return UINT32_MAX;
        }
        number = 10 * number + (uint32_t)(*c - '0');
    }
    return number;
}

size_t stp_work_record_bytes(uint64_t size)
{
    return size > LARGEST_RESULT ? 0 : HEAD + (((size_t)size + 63) & ~(size_t)63);
}

static stp_result fail_io(const stp_work_place* place, uint32_t number, const char* what)
{
    int reason = errno;
    char name[STP_WORK_NAME_SIZE];
    stp_work_segment_name(number, name);
    return stp_fail(place->context, STP_ERROR_IO, "%s/%s: cannot be %s: %s", place->path, name,
                    what, strerror(reason));
}

static bool write_at(int file, const void* bytes, size_t size, size_t offset)
{
    const unsigned char* from = bytes;
    while (size > 0) {
        ssize_t done = pwrite(file, from, size, (off_t)offset);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            errno = done == 0 ? ENOSPC : errno;
            return false;
        }
        from += done;
        size -= (size_t)done;
        offset += (size_t)done;
    }
    return true;
}

// Fewer bytes than `size` at the end of the file; -1 on failure.
static ssize_t read_at(int file, void* bytes, size_t size, size_t offset)
{
    size_t got = 0;
    while (got < size) {
        ssize_t done = pread(file, (unsigned char*)bytes + got, size - got, (off_t)(offset + got));
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done < 0) {
            return -1;
        }
        if (done == 0) {
            break;
        }
        got += (size_t)done;
    }
    return (ssize_t)got;
}

static stp_result map(const stp_work_place* place, size_t capacity, stp_work_segment* segment)
{
    void* bytes = mmap(NULL, capacity, PROT_READ, MAP_SHARED, segment->file, 0);
    if (bytes == MAP_FAILED) {
        return fail_io(place, segment->number, "mapped");
    }
    segment->bytes = bytes;
    segment->capacity = capacity;
    return STP_OK;
}

stp_result stp_work_segment_create(const stp_work_place* place, uint32_t number, size_t capacity,
                                   stp_work_segment* segment)
{
    assert(capacity >= 2 * HEAD && capacity % HEAD == 0 && "no room for a result");
    if (number >= MAX_SEGMENTS) {
        return stp_fail(place->context, STP_ERROR_LIMIT, "%s: has more than %d segments",
                        place->path, MAX_SEGMENTS);
    }
    char name[STP_WORK_NAME_SIZE];
    stp_work_segment_name(number, name);
    int file = openat(place->folder, name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) {
        return fail_io(place, number, "made");
    }
    unsigned char head[HEAD] = {0};
    memcpy(head, segment_magic, MAGIC_SIZE);
    stp_write_u32(head + 8, STP_WORK_VERSION);
    stp_work_seal_head(head);
    *segment = (stp_work_segment){.number = number, .file = file, .used = HEAD};
    stp_result result = write_at(file, head, HEAD, 0) ? STP_OK : fail_io(place, number, "written");
    result = result == STP_OK ? map(place, capacity, segment) : result;
    if (result != STP_OK) {
        close(file);
        (void)unlinkat(place->folder, name, 0);
    }
    return result;
}

static stp_work_kind kind_of(const unsigned char* head, size_t size)
{
    if (memcmp(head, segment_magic, size < MAGIC_SIZE ? size : MAGIC_SIZE) != 0) {
        return STP_WORK_FOREIGN;
    }
    bool whole = size == HEAD && is_sealed(head) && stp_read_u32(head + 8) == STP_WORK_VERSION;
    return whole ? STP_WORK_SEGMENT : STP_WORK_USELESS;
}

stp_result stp_work_segment_open(const stp_work_place* place, uint32_t number,
                                 stp_work_segment* segment, stp_work_kind* kind)
{
    char name[STP_WORK_NAME_SIZE];
    stp_work_segment_name(number, name);
    *segment = (stp_work_segment){.number = number, .file = -1};
    *kind = STP_WORK_FOREIGN;
    struct stat status;
    if (fstatat(place->folder, name, &status, AT_SYMLINK_NOFOLLOW) != 0) {
        return fail_io(place, number, "opened");
    }
    if (!S_ISREG(status.st_mode)) {
        return STP_OK;
    }
    int file = openat(place->folder, name, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) {
        return fail_io(place, number, "opened");
    }
    unsigned char head[HEAD];
    ssize_t size = read_at(file, head, HEAD, 0);
    if (size < 0) {
        stp_result result = fail_io(place, number, "read");
        close(file);
        return result;
    }
    *kind = kind_of(head, (size_t)size);
    if (*kind == STP_WORK_SEGMENT) {
        segment->file = file;
        segment->used = HEAD;
    } else {
        close(file);
    }
    return STP_OK;
}

static bool parse_head(const unsigned char* bytes, stp_work_head* head)
{
    *head = (stp_work_head){
        .key = {.low = stp_read_u64(bytes + 8), .high = stp_read_u64(bytes + 16)},
        .size = stp_read_u64(bytes + 24),
        .checksum = stp_read_u64(bytes + 32),
    };
    return memcmp(bytes, result_mark, MAGIC_SIZE) == 0 && is_sealed(bytes) &&
           stp_work_record_bytes(head->size) != 0;
}

// Visits the results up to the first one that is not complete within `size` bytes of the file.
static stp_result visit_heads(const stp_work_place* place, size_t size, stp_work_segment* segment,
                              stp_work_visit visit, void* user)
{
    while (size - segment->used >= HEAD) {
        assert(segment->used < size && segment->used % HEAD == 0 && "results are aligned");
        unsigned char bytes[HEAD];
        ssize_t got = read_at(segment->file, bytes, HEAD, segment->used);
        if (got < 0) {
            return fail_io(place, segment->number, "read");
        }
        stp_work_head head;
        if (got != HEAD || !parse_head(bytes, &head) || head.size > size - segment->used - HEAD) {
            return STP_OK;
        }
        stp_result result = visit(&head, segment->used + HEAD, user);
        if (result != STP_OK) {
            return result;
        }
        // the last one may end before its padding
        segment->used += stp_work_record_bytes(head.size);
        if (segment->used >= size) {
            return STP_OK;
        }
    }
    return STP_OK;
}

stp_result stp_work_segment_scan(const stp_work_place* place, size_t capacity,
                                 stp_work_segment* segment, stp_work_visit visit, void* user)
{
    assert(segment->file >= 0 && segment->bytes == NULL && "opened and not mapped yet");
    struct stat status;
    if (fstat(segment->file, &status) != 0 || status.st_size < HEAD) {
        return fail_io(place, segment->number, "read");
    }
    size_t size = (size_t)status.st_size;
    stp_result result = visit_heads(place, size, segment, visit, user);
    if (result == STP_OK && size > segment->used &&
        ftruncate(segment->file, (off_t)segment->used) != 0) {
        result = fail_io(place, segment->number, "written");
    }
    size_t maximum = segment->used > capacity ? segment->used : capacity;
    return result == STP_OK ? map(place, maximum, segment) : result;
}

stp_result stp_work_segment_reserve(const stp_work_place* place, stp_work_segment* segment,
                                    const stp_work_head* head, size_t* offset)
{
    size_t whole = stp_work_record_bytes(head->size);
    assert(segment->file >= 0 && whole != 0 && whole <= segment->capacity - segment->used);
    unsigned char bytes[HEAD] = {0};
    memcpy(bytes, result_mark, MAGIC_SIZE);
    stp_write_u64(bytes + 8, head->key.low);
    stp_write_u64(bytes + 16, head->key.high);
    stp_write_u64(bytes + 24, head->size);
    stp_write_u64(bytes + 32, head->checksum);
    stp_work_seal_head(bytes);
    if (!write_at(segment->file, bytes, HEAD, segment->used)) {
        stp_result result = fail_io(place, segment->number, "written");
        (void)!ftruncate(segment->file, (off_t)segment->used);
        return result;
    }
    *offset = segment->used + HEAD;
    segment->used += whole;
    assert(*offset % HEAD == 0 && segment->used % HEAD == 0 && "results are aligned");
    return STP_OK;
}

bool stp_work_segment_write(const stp_work_segment* segment, size_t offset, const stp_bytes* parts,
                            size_t part_count)
{
    for (size_t i = 0; i < part_count; ++i) {
        if (!write_at(segment->file, parts[i].bytes, parts[i].size, offset)) {
            return false;
        }
        offset += parts[i].size;
    }
    assert(offset <= segment->capacity && "written behind the mapping");
    return true;
}

stp_result stp_work_segment_fail_write(const stp_work_place* place, uint32_t number, int reason)
{
    errno = reason;
    return fail_io(place, number, "written");
}

void stp_work_segment_take_back(stp_work_segment* segment, size_t offset, uint64_t size)
{
    assert(offset >= 2 * HEAD && offset <= segment->used && "not a reserved result");
    size_t begin = offset - HEAD;
    if (segment->used == begin + stp_work_record_bytes(size)) {
        segment->used = begin;
        (void)!ftruncate(segment->file, (off_t)begin); // if this fails, the checksum detects it
    }
}

void stp_work_segment_release_pages(const stp_work_segment* segment)
{
    if (segment->bytes != NULL) { // posix_madvise would do nothing
        (void)madvise((void*)(uintptr_t)segment->bytes, segment->capacity, MADV_DONTNEED);
    }
}

void stp_work_segment_finish(stp_work_segment* segment)
{
    if (segment->file >= 0) {
        close(segment->file);
        segment->file = -1;
    }
}

void stp_work_segment_close(stp_work_segment* segment)
{
    stp_work_segment_finish(segment);
    if (segment->bytes != NULL) {
        munmap((void*)(uintptr_t)segment->bytes, segment->capacity);
    }
    *segment = (stp_work_segment){.file = -1};
}
