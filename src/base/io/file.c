// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // realpath
#define _DEFAULT_SOURCE   // madvise
#include "base/io/file.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define BUFFER_SIZE ((size_t)1 << 20)
#define MAX_ATTEMPTS 100u
#define NAME_ROOM 48u // maximum length of a temporary file's suffix

stp_result stp_file_map_open(stp_context* context, const char* path, stp_mapped_file* file,
                             int* kept)
{
    *file = (stp_mapped_file){0};
    *kept = -1;
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat status;
    if (descriptor < 0 || fstat(descriptor, &status) != 0) {
        stp_result result = stp_fail(context, STP_ERROR_IO, "%s: %s", path, strerror(errno));
        if (descriptor >= 0) {
            close(descriptor);
        }
        return result;
    }
    if (!S_ISREG(status.st_mode)) {
        close(descriptor);
        return stp_fail(context, STP_ERROR_IO, "%s: is not a regular file", path);
    }
    size_t size = (size_t)status.st_size;
    void* bytes = size != 0 ? mmap(NULL, size, PROT_READ, MAP_PRIVATE, descriptor, 0) : NULL;
    int reason = errno;
    if (bytes == MAP_FAILED) {
        close(descriptor);
        return stp_fail(context, STP_ERROR_IO, "%s: cannot be mapped: %s", path, strerror(reason));
    }
    *file = (stp_mapped_file){.bytes = bytes, .size = size};
    *kept = descriptor;
    return STP_OK;
}

stp_result stp_file_map(stp_context* context, const char* path, stp_mapped_file* file)
{
    int descriptor;
    stp_result result = stp_file_map_open(context, path, file, &descriptor);
    stp_file_close(descriptor);
    return result;
}

bool stp_file_read_at(int descriptor, uint64_t offset, void* bytes, size_t size)
{
    unsigned char* to = bytes;
    while (size > 0) {
        ssize_t got = pread(descriptor, to, size, (off_t)offset);
        if (got <= 0 && !(got < 0 && errno == EINTR)) {
            return false;
        }
        size_t read = got > 0 ? (size_t)got : 0;
        to += read;
        size -= read;
        offset += read;
    }
    return true;
}

size_t stp_file_peek(const char* path, void* bytes, size_t size)
{
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat status;
    size_t read = 0;
    if (descriptor >= 0 && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) {
        size = (uint64_t)status.st_size < size ? (size_t)status.st_size : size;
        read = stp_file_read_at(descriptor, 0, bytes, size) ? size : 0;
    }
    stp_file_close(descriptor);
    return read;
}

void stp_file_close(int descriptor)
{
    if (descriptor >= 0) {
        close(descriptor);
    }
}

void stp_file_expect_random(const stp_mapped_file* file)
{
    if (file->bytes != NULL) { // only a hint: failure does not matter
        (void)posix_madvise((void*)(uintptr_t)file->bytes, file->size, POSIX_MADV_RANDOM);
    }
}

void stp_file_evict(const stp_mapped_file* file)
{
    if (file->bytes != NULL) { // posix_madvise would do nothing
        size_t before = (uintptr_t)file->bytes % (size_t)sysconf(_SC_PAGESIZE);
        (void)madvise((void*)((uintptr_t)file->bytes - before), file->size + before, MADV_DONTNEED);
    }
}

void stp_file_unmap(stp_mapped_file* file)
{
    if (file->bytes != NULL) {
        munmap((void*)(uintptr_t)file->bytes, file->size);
    }
    *file = (stp_mapped_file){0};
}

struct stp_file_writer {
    stp_context* context;
    char* path;
    char* temporary;
    int descriptor;
    uint64_t written; ///< bytes handed to the system; the buffer follows them
    size_t buffered;
    unsigned char* buffer;
};

static void free_writer(stp_file_writer* writer)
{
    stp_free(writer->context, writer->buffer);
    stp_free(writer->context, writer->temporary);
    stp_free(writer->context, writer->path);
    stp_free(writer->context, writer);
}

static stp_result fail_io(const stp_file_writer* writer, const char* what)
{
    return stp_fail(writer->context, STP_ERROR_IO, "%s: cannot be %s: %s", writer->path, what,
                    strerror(errno));
}

// Resolves links first: renaming would replace the link itself, even /dev/stdout.
static stp_result resolve_link(stp_file_writer* writer)
{
    struct stat status;
    if (lstat(writer->path, &status) != 0 || !S_ISLNK(status.st_mode)) {
        return STP_OK;
    }
    char* target = realpath(writer->path, NULL);
    if (target == NULL) {
        return fail_io(writer, "written");
    }
    size_t length = strlen(target) + NAME_ROOM;
    char* path = stp_alloc(writer->context, length);
    if (path != NULL) {
        snprintf(path, length, "%s", target);
        stp_free(writer->context, writer->path);
        writer->path = path;
    }
    free(target);
    return path != NULL ? STP_OK : stp_fail_memory(writer->context);
}

// Leaves files of other writers of the path, and of killed processes, alone. Follows no link.
// @return the descriptor; -1 on failure
static int open_beside(const char* path, char* temporary, size_t size)
{
    for (unsigned attempt = 0; attempt < MAX_ATTEMPTS; ++attempt) {
        int length = snprintf(temporary, size, "%s.tmp-%ld-%u", path, (long)getpid(), attempt);
        if (length < 0 || (size_t)length >= size) {
            errno = ENAMETOOLONG;
            return -1;
        }
        int descriptor = open(temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) {
            return descriptor;
        }
    }
    return -1;
}

bool stp_file_create_temporary(const char* path, char* temporary, size_t size)
{
    int descriptor = open_beside(path, temporary, size);
    stp_file_close(descriptor);
    return descriptor >= 0;
}

static stp_result open_temporary(stp_file_writer* writer)
{
    size_t length = strlen(writer->path) + NAME_ROOM;
    writer->temporary = stp_alloc(writer->context, length);
    if (writer->temporary == NULL) {
        return stp_fail_memory(writer->context);
    }
    struct stat status;
    if (stat(writer->path, &status) == 0 && !S_ISREG(status.st_mode)) {
        return stp_fail(writer->context, STP_ERROR_IO, "%s: is not a regular file", writer->path);
    }
    writer->descriptor = open_beside(writer->path, writer->temporary, length);
    return writer->descriptor >= 0 ? STP_OK : fail_io(writer, "written");
}

stp_result stp_file_writer_open(stp_context* context, const char* path, stp_file_writer** writer)
{
    if (*path == '\0') {
        return stp_fail(context, STP_ERROR_IO, "the output file name is empty");
    }
    size_t length = strlen(path) + 1;
    stp_file_writer* made = STP_NEW_ZEROED(context, stp_file_writer, 1);
    if (made == NULL) {
        return stp_fail_memory(context);
    }
    made->context = context;
    made->path = stp_alloc(context, length);
    made->buffer = stp_alloc(context, BUFFER_SIZE);
    if (made->path == NULL || made->buffer == NULL) {
        free_writer(made);
        return stp_fail_memory(context);
    }
    snprintf(made->path, length, "%s", path);
    stp_result result = resolve_link(made);
    if (result == STP_OK) {
        result = open_temporary(made);
    }
    if (result != STP_OK) {
        free_writer(made);
        return result;
    }
    *writer = made;
    return STP_OK;
}

static stp_result write_all(stp_file_writer* writer, const unsigned char* bytes, size_t size,
                            uint64_t offset)
{
    while (size > 0) {
        ssize_t done = pwrite(writer->descriptor, bytes, size, (off_t)offset);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            return fail_io(writer, "written");
        }
        bytes += done;
        size -= (size_t)done;
        offset += (uint64_t)done;
    }
    return STP_OK;
}

static stp_result flush(stp_file_writer* writer)
{
    stp_result result = write_all(writer, writer->buffer, writer->buffered, writer->written);
    if (result == STP_OK) {
        writer->written += writer->buffered;
        writer->buffered = 0;
    }
    return result;
}

stp_result stp_file_writer_append(stp_file_writer* writer, const void* bytes, size_t size)
{
    if (size == 0) {
        return STP_OK;
    }
    if (writer->buffered + size > BUFFER_SIZE) {
        stp_result result = flush(writer);
        if (result != STP_OK) {
            return result;
        }
    }
    if (size > BUFFER_SIZE) {
        assert(writer->buffered == 0 && "large writes follow the buffer's bytes");
        stp_result result = write_all(writer, bytes, size, writer->written);
        writer->written += result == STP_OK ? size : 0;
        return result;
    }
    assert(writer->buffered + size <= BUFFER_SIZE && "flushed before");
    memcpy(writer->buffer + writer->buffered, bytes, size);
    writer->buffered += size;
    return STP_OK;
}

stp_result stp_file_writer_patch(stp_file_writer* writer, uint64_t offset, const void* bytes,
                                 size_t size)
{
    assert(offset + size <= stp_file_writer_size(writer));
    stp_result result = flush(writer);
    return result == STP_OK ? write_all(writer, bytes, size, offset) : result;
}

uint64_t stp_file_writer_size(const stp_file_writer* writer)
{
    return writer->written + writer->buffered;
}

// Makes the rename durable by syncing the folder's entry. Some file systems refuse; ignore that.
static void sync_folder(const stp_file_writer* writer)
{
    size_t length = strlen(writer->path) + 1;
    char* copy = stp_alloc(writer->context, length);
    if (copy != NULL) {
        memcpy(copy, writer->path, length);
        int folder = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (folder >= 0) {
            (void)fsync(folder);
            close(folder);
        }
        stp_free(writer->context, copy);
    }
}

static stp_result commit(stp_file_writer* writer, bool lasts)
{
    assert(writer->descriptor >= 0 && writer->temporary != NULL && "opened");
    stp_result result = flush(writer);
    if (result == STP_OK && lasts && fsync(writer->descriptor) != 0 && errno != EINVAL) {
        result = fail_io(writer, "written");
    }
    if (close(writer->descriptor) != 0 && result == STP_OK) {
        result = fail_io(writer, "written");
    }
    if (result == STP_OK && rename(writer->temporary, writer->path) != 0) {
        result = fail_io(writer, "renamed to its final name");
    }
    if (result == STP_OK && lasts) {
        sync_folder(writer);
    } else if (result != STP_OK) {
        (void)unlink(writer->temporary);
    }
    free_writer(writer);
    return result;
}

stp_result stp_file_writer_commit(stp_file_writer* writer)
{
    return commit(writer, true);
}

stp_result stp_file_writer_commit_passing(stp_file_writer* writer)
{
    return commit(writer, false);
}

void stp_file_writer_abort(stp_file_writer* writer)
{
    if (writer != NULL) {
        close(writer->descriptor);
        (void)unlink(writer->temporary);
        free_writer(writer);
    }
}

uint64_t stp_file_room(const char* path)
{
    char folder[PATH_MAX];
    const char* slash = strrchr(path, '/');
    size_t length =
        slash != NULL ? (size_t)(slash - path) + 1 : 0; // includes the slash: it may be the root
    if (length >= sizeof(folder)) {
        return UINT64_MAX;
    }
    snprintf(folder, sizeof(folder), "%.*s", length > 0 ? (int)length : 1, length > 0 ? path : ".");
    struct statvfs status;
    if (statvfs(folder, &status) != 0) {
        return UINT64_MAX;
    }
    uint64_t blocks = status.f_bavail, size = status.f_frsize;
    return size > 0 && blocks > UINT64_MAX / size ? UINT64_MAX : blocks * size;
}
