// SPDX-License-Identifier: MIT
//
// The file grows in chunks. Each is reserved on the disk and mapped as a whole; allocations come
// from the newest. A chunk begins with a 64-byte header that links it to the previous one.
#define _GNU_SOURCE // O_TMPFILE, fallocate without writing
#include "base/io/spill.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define LINE ((size_t)64)
#define PAGE_MULTIPLE ((size_t)64 << 10) // a multiple of every page size in use
#define SMALLEST_CHUNK ((size_t)4 << 20)
#define LARGEST_CHUNK ((size_t)256 << 20)
#define MAX_ATTEMPTS 100u
#define NAME_ROOM 48u // maximum length of the file name after the folder

typedef struct chunk_head {
    struct chunk_head* previous;
    size_t size, used; ///< includes the header
} chunk_head;

struct stp_spill {
    stp_context* context;
    char* folder;
    int descriptor;
    pthread_mutex_t mutex;
    chunk_head* newest;
    uint64_t file_size;
};

static size_t round_up(size_t size, size_t multiple)
{
    assert(multiple != 0 && (multiple & (multiple - 1)) == 0 && "a power of two");
    return (size + multiple - 1) & ~(multiple - 1);
}

// Opens an anonymous file if the file system supports it; else a named file, removed immediately.
static int open_nameless(const char* folder, char* path, size_t path_size)
{
    int descriptor = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    bool cannot = errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL;
    for (unsigned i = 0; descriptor < 0 && cannot && i < MAX_ATTEMPTS; ++i) {
        snprintf(path, path_size, "%s/spill.tmp-%ld-%u", folder, (long)getpid(), i);
        descriptor = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        cannot = errno == EEXIST;
        if (descriptor >= 0) {
            (void)unlink(path);
        }
    }
    return descriptor;
}

stp_result stp_spill_create(stp_context* context, const char* folder, stp_spill** spill)
{
    size_t length = strlen(folder) + 1;
    stp_spill* made = STP_NEW_ZEROED(context, stp_spill, 1);
    char* path = stp_alloc(context, length + NAME_ROOM);
    char* copy = stp_alloc(context, length);
    if (made == NULL || path == NULL || copy == NULL) {
        stp_free(context, made);
        stp_free(context, path);
        stp_free(context, copy);
        return stp_fail_memory(context);
    }
    memcpy(copy, folder, length);
    *made = (stp_spill){.context = context, .folder = copy};
    made->descriptor = open_nameless(folder, path, length + NAME_ROOM);
    stp_free(context, path);
    if (made->descriptor < 0) {
        stp_result result =
            stp_fail(context, STP_ERROR_IO, "%s: cannot create a temporary file: %s", folder,
                     strerror(errno));
        stp_free(context, copy);
        stp_free(context, made);
        return result;
    }
    pthread_mutex_init(&made->mutex, NULL);
    *spill = made;
    return STP_OK;
}

stp_result stp_spill_create_sibling(const stp_spill* other, stp_spill** spill)
{
    return stp_spill_create(other->context, other->folder, spill);
}

void stp_spill_destroy(stp_spill* spill)
{
    if (spill == NULL) {
        return;
    }
    while (spill->newest != NULL) {
        chunk_head* chunk = spill->newest;
        spill->newest = chunk->previous;
        munmap(chunk, chunk->size);
    }
    close(spill->descriptor);
    pthread_mutex_destroy(&spill->mutex);
    stp_free(spill->context, spill->folder);
    stp_free(spill->context, spill);
}

// Reserves and maps room for `size` bytes after a chunk's header. @return 0 or the system's error
// code
static int add_chunk(stp_spill* spill, size_t size)
{
    size_t usual = (size_t)(spill->file_size / 8);
    usual = usual < SMALLEST_CHUNK ? SMALLEST_CHUNK : usual > LARGEST_CHUNK ? LARGEST_CHUNK : usual;
    size_t needed = LINE + size;
    size_t whole = round_up(needed > usual ? needed : usual, PAGE_MULTIPLE);
    int reason;
    do {
        reason = posix_fallocate(spill->descriptor, (off_t)spill->file_size, (off_t)whole);
    } while (reason == EINTR);
    if (reason == ENOSPC &&
        whole > round_up(needed, PAGE_MULTIPLE)) { // the request alone may still fit
        whole = round_up(needed, PAGE_MULTIPLE);
        reason = posix_fallocate(spill->descriptor, (off_t)spill->file_size, (off_t)whole);
    }
    if (reason != 0) {
        return reason;
    }
    chunk_head* chunk = mmap(NULL, whole, PROT_READ | PROT_WRITE, MAP_SHARED, spill->descriptor,
                             (off_t)spill->file_size);
    if (chunk == MAP_FAILED) {
        return errno;
    }
    *chunk = (chunk_head){.previous = spill->newest, .size = whole, .used = LINE};
    spill->newest = chunk;
    spill->file_size += whole;
    assert(spill->file_size % PAGE_MULTIPLE == 0 && whole >= needed);
    return 0;
}

void* stp_spill_alloc(stp_spill* spill, size_t size)
{
    static_assert(sizeof(chunk_head) <= LINE, "a chunk's head is one line");
    size_t whole = size <= SIZE_MAX / 4 ? round_up(size > 0 ? size : 1, LINE) : 0;
    int reason = whole != 0 ? 0 : EFBIG;
    unsigned char* memory = NULL;
    pthread_mutex_lock(&spill->mutex);
    if (reason == 0 &&
        (spill->newest == NULL || spill->newest->size - spill->newest->used < whole)) {
        reason = add_chunk(spill, whole);
    }
    if (reason == 0) {
        memory = (unsigned char*)spill->newest + spill->newest->used;
        assert(spill->newest->used % LINE == 0 && whole % LINE == 0);
        spill->newest->used += whole;
        assert(spill->newest->used <= spill->newest->size && "within the chunk");
    }
    pthread_mutex_unlock(&spill->mutex);
    if (reason != 0) {
        (void)stp_fail(spill->context, STP_ERROR_IO,
                       "%s: no room for %zu bytes of temporary data: %s", spill->folder, size,
                       strerror(reason));
    }
    return memory;
}

void stp_spill_release_pages(stp_spill* spill)
{
    pthread_mutex_lock(&spill->mutex);
    for (chunk_head *chunk = spill->newest, *previous; chunk != NULL; chunk = previous) {
        previous = chunk->previous; // the pages are a shared file mapping: written data stays
        (void)madvise(chunk, chunk->size, MADV_DONTNEED);
    }
    pthread_mutex_unlock(&spill->mutex);
}

void stp_spill_forget(const void* memory, size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    size_t before = round_up((uintptr_t)memory, page) - (uintptr_t)memory;
    if (size >= before + page) {
        (void)madvise((unsigned char*)(uintptr_t)memory + before, (size - before) / page * page,
                      MADV_DONTNEED);
    }
}
