// SPDX-License-Identifier: MIT
#include "builder/work.h"

#include "builder/work_internal.h"

#include <assert.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#define SEGMENT_BYTES ((size_t)256 << 20)
#define MIN_SEGMENT_BYTES ((size_t)1024)
#define NO_SEGMENT UINT32_MAX
enum { LARGE_PART = 4 }; ///< results larger than 1/LARGE_PART of a segment get a separate segment

#define RELEASE_BYTES (UINT64_C(128) << 20) // bytes verified between releases of mapped pages

struct stp_work {
    stp_context* context;
    char* path;
    stp_work_folder folder;
    size_t segment_bytes;
    pthread_mutex_t mutex;   ///< guards the members below, except statistics
    pthread_cond_t finished; ///< a pending result became good or absent
    stp_work_index index;
    stp_work_segment* segments;
    size_t segment_capacity;
    uint32_t segment_count;
    uint32_t current; ///< segment for small results
    uint32_t next_number;
    bool failed; ///< e.g. the disk is full; reported once
    atomic_uint_fast64_t found, found_bytes, stored, stored_bytes, damaged;
};

static stp_result grow_segments(stp_work* work)
{
    if (!STP_MAKE_ROOM(work->context, work->segments, work->segment_capacity,
                       (size_t)work->segment_count + 1)) {
        return stp_fail_memory(work->context);
    }
    return STP_OK;
}

// A key is stored again only if the earlier result is damaged, so the later one counts.
static stp_result add_found(const stp_work_head* head, size_t offset, void* user)
{
    stp_work* work = user;
    stp_work_entry* entry = stp_work_index_add(work->context, &work->index, head->key);
    if (entry == NULL) {
        return stp_fail_memory(work->context);
    }
    entry->size = head->size;
    entry->checksum = head->checksum;
    entry->offset = offset;
    entry->segment = work->segment_count;
    entry->state = STP_WORK_UNVERIFIED;
    return STP_OK;
}

static stp_result take_up_segment(stp_work* work, uint32_t number, bool fresh)
{
    const stp_work_place* place = &work->folder.place;
    stp_work_segment segment;
    stp_work_kind kind;
    stp_result result = grow_segments(work);
    result = result == STP_OK ? stp_work_segment_open(place, number, &segment, &kind) : result;
    if (result != STP_OK) {
        return result;
    }
    char name[STP_WORK_NAME_SIZE];
    stp_work_segment_name(number, name);
    if (kind == STP_WORK_FOREIGN) {
        stp_warn(place->context, "%s/%s: is not a segment of a build; ignored", place->path, name);
    } else if (kind == STP_WORK_USELESS || fresh) {
        stp_work_segment_close(&segment);
        (void)unlinkat(place->folder, name, 0);
    } else {
        result = stp_work_segment_scan(place, work->segment_bytes, &segment, add_found, work);
        if (result != STP_OK) {
            stp_work_segment_close(&segment);
            return result;
        }
        if (work->current != NO_SEGMENT) {
            stp_work_segment_finish(&work->segments[work->current]);
        }
        work->current = work->segment_count;
        work->segments[work->segment_count++] = segment;
    }
    return STP_OK;
}

static stp_result take_up_segments(stp_work* work, bool fresh)
{
    uint32_t* numbers = NULL;
    size_t count = 0;
    stp_result result = stp_work_folder_list(&work->folder, &numbers, &count);
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        assert((i == 0 || numbers[i - 1] < numbers[i]) && "later segments must win");
        result = take_up_segment(work, numbers[i], fresh);
        work->next_number = numbers[i] + 1;
    }
    stp_free(work->context, numbers);
    return result;
}

static void destroy(stp_work* work)
{
    for (uint32_t i = 0; i < work->segment_count; ++i) {
        assert(work->segments[i].writers == 0 && "closed while a result is written");
        stp_work_segment_close(&work->segments[i]);
    }
    stp_free(work->context, work->segments);
    stp_work_index_destroy(work->context, &work->index);
    pthread_cond_destroy(&work->finished);
    pthread_mutex_destroy(&work->mutex);
    stp_free(work->context, work->path);
    stp_free(work->context, work);
}

stp_result stp_work_open_with(stp_context* context, const char* folder, bool fresh,
                              size_t segment_bytes, stp_work** work)
{
    assert(segment_bytes >= MIN_SEGMENT_BYTES && segment_bytes % 64 == 0);
    *work = NULL;
    stp_work* made = STP_NEW_ZEROED(context, stp_work, 1);
    char* path = STP_NEW_ARRAY(context, char, strlen(folder) + 1);
    if (made == NULL || path == NULL) {
        stp_free(context, made);
        stp_free(context, path);
        return stp_fail_memory(context);
    }
    memcpy(path, folder, strlen(folder) + 1);
    made->context = context;
    made->path = path;
    made->segment_bytes = segment_bytes;
    made->current = NO_SEGMENT;
    pthread_mutex_init(&made->mutex, NULL);
    pthread_cond_init(&made->finished, NULL);
    stp_result result = stp_work_folder_open(context, path, &made->folder);
    if (result != STP_OK) {
        destroy(made);
        return result;
    }
    result = take_up_segments(made, fresh);
    if (result != STP_OK) {
        stp_work_folder_close(&made->folder, false);
        destroy(made);
        return result;
    }
    *work = made;
    return STP_OK;
}

stp_result stp_work_open(stp_context* context, const char* folder, bool fresh, stp_work** work)
{
    return stp_work_open_with(context, folder, fresh, SEGMENT_BYTES, work);
}

void stp_work_close(stp_work* work, bool remove)
{
    if (work == NULL) {
        return;
    }
    for (uint32_t i = 0; remove && i < work->segment_count; ++i) {
        char name[STP_WORK_NAME_SIZE];
        stp_work_segment_name(work->segments[i].number, name);
        (void)unlinkat(work->folder.place.folder, name, 0);
    }
    stp_work_folder_close(&work->folder, remove);
    destroy(work);
}

static const unsigned char* bytes_of(const stp_work* work, const stp_work_entry* entry)
{
    assert(entry->segment < work->segment_count && "the entry has no result");
    assert(entry->size <= work->segments[entry->segment].capacity - entry->offset);
    return work->segments[entry->segment].bytes + entry->offset;
}

// Finds a key's entry, and verifies its checksum if that was not done yet: it may be good, absent
// or pending. The mutex is held on entry and return, and released in between. NULL: there is none.
static stp_work_entry* find_verified(stp_work* work, stp_hash key)
{
    stp_work_entry* entry = stp_work_index_find(&work->index, key);
    if (entry == NULL || entry->state != STP_WORK_UNVERIFIED) {
        return entry;
    }
    stp_bytes bytes = {bytes_of(work, entry), (size_t)entry->size};
    uint64_t expected = entry->checksum;
    pthread_mutex_unlock(&work->mutex);
    bool good = stp_checksum(&bytes, 1) == expected;
    pthread_mutex_lock(&work->mutex);
    entry = stp_work_index_find(&work->index, key);
    if (entry->state == STP_WORK_UNVERIFIED) { // no other thread was faster
        entry->state = good ? STP_WORK_GOOD : STP_WORK_ABSENT;
        atomic_fetch_add(good ? &work->found : &work->damaged, 1);
        atomic_fetch_add(&work->found_bytes, good ? bytes.size : 0);
    }
    return entry;
}

const void* stp_work_find(stp_work* work, stp_hash key, size_t* size)
{
    const void* bytes = NULL;
    *size = 0;
    pthread_mutex_lock(&work->mutex);
    const stp_work_entry* entry = find_verified(work, key);
    if (entry != NULL && entry->state == STP_WORK_GOOD) {
        bytes = bytes_of(work, entry);
        *size = (size_t)entry->size;
    }
    pthread_mutex_unlock(&work->mutex);
    assert((uintptr_t)bytes % 64 == 0 && "columns are used in place");
    return bytes;
}

bool stp_work_is_intact(stp_work* work)
{
    bool intact = true;
    uint64_t unreleased = 0;
    for (size_t i = 0; i < work->index.count && intact; ++i) {
        const stp_work_entry* entry = &work->index.entries[i];
        if (entry->state == STP_WORK_GOOD) {
            stp_bytes bytes = {bytes_of(work, entry), (size_t)entry->size};
            intact = stp_checksum(&bytes, 1) == entry->checksum;
            unreleased += entry->size;
        }
        if (unreleased >= RELEASE_BYTES) {
            stp_work_release_pages(work);
            unreleased = 0;
        }
    }
    stp_work_release_pages(work);
    return intact;
}

// Creates a file with room for at least one result. It becomes the current one unless created for
// that result alone.
static stp_result add_segment(stp_work* work, size_t capacity, bool alone, uint32_t* segment)
{
    stp_result result = grow_segments(work);
    if (result != STP_OK) {
        return result;
    }
    result = stp_work_segment_create(&work->folder.place, work->next_number, capacity,
                                     &work->segments[work->segment_count]);
    if (result != STP_OK) {
        return result;
    }
    work->next_number += 1;
    *segment = work->segment_count++;
    if (!alone) {
        if (work->current != NO_SEGMENT && work->segments[work->current].writers == 0) {
            stp_work_segment_finish(&work->segments[work->current]);
        }
        work->current = *segment;
    }
    return STP_OK;
}

// Reserves room for a result and writes its header. The mutex must be held.
static stp_result reserve(stp_work* work, const stp_work_head* head, uint32_t* segment,
                          size_t* offset)
{
    size_t needed = stp_work_record_bytes(head->size);
    stp_result result = STP_OK;
    const stp_work_segment* current =
        work->current != NO_SEGMENT ? &work->segments[work->current] : NULL;
    *segment = work->current;
    if (needed > work->segment_bytes / LARGE_PART) {
        result = add_segment(work, STP_WORK_HEAD_SIZE + needed, true, segment);
    } else if (current == NULL || current->used + needed > current->capacity) {
        result = add_segment(work, work->segment_bytes, false, segment);
    }
    return result == STP_OK ? stp_work_segment_reserve(&work->folder.place,
                                                       &work->segments[*segment], head, offset)
                            : result;
}

// Writes a result's bytes into the reserved space; releases the mutex during that.
static stp_result write_bytes(stp_work* work, const stp_work_head* head, uint32_t segment,
                              size_t offset, const stp_bytes* parts, size_t part_count)
{
    stp_work_segment copy = work->segments[segment];
    work->segments[segment].writers += 1;
    pthread_mutex_unlock(&work->mutex);
    bool written = stp_work_segment_write(&copy, offset, parts, part_count);
    int reason = errno;
    pthread_mutex_lock(&work->mutex);
    stp_work_segment* s = &work->segments[segment];
    assert(s->writers > 0 && s->number == copy.number);
    s->writers -= 1;
    stp_result result = written ? STP_OK : STP_ERROR_IO;
    if (!written) {
        stp_work_segment_take_back(s, offset, head->size);
        if (!work->failed) {
            result = stp_work_segment_fail_write(&work->folder.place, copy.number, reason);
        }
    }
    if (segment != work->current && s->writers == 0) {
        stp_work_segment_finish(s);
    }
    return result;
}

// Writes a result claimed by this thread (its entry is pending). The mutex is held on entry and
// return.
static stp_result write_result(stp_work* work, const stp_work_head* head, const stp_bytes* parts,
                               size_t part_count)
{
    uint32_t segment = NO_SEGMENT;
    size_t offset = 0;
    stp_result result = work->failed ? STP_ERROR_IO : reserve(work, head, &segment, &offset);
    result =
        result == STP_OK ? write_bytes(work, head, segment, offset, parts, part_count) : result;
    work->failed = work->failed || result == STP_ERROR_IO;
    stp_work_entry* entry = stp_work_index_find(&work->index, head->key);
    assert(entry->state == STP_WORK_PENDING && "another thread changed a claimed entry");
    entry->size = head->size;
    entry->checksum = head->checksum;
    entry->offset = offset;
    entry->segment = segment;
    entry->state = result == STP_OK ? STP_WORK_GOOD : STP_WORK_ABSENT;
    if (result == STP_OK) {
        atomic_fetch_add(&work->stored, 1);
        atomic_fetch_add(&work->stored_bytes, head->size);
    }
    pthread_cond_broadcast(&work->finished);
    return result;
}

// The good result of a key, or a pending entry that this thread must write. The mutex must be held.
// NULL: out of memory.
static stp_work_entry* claim(stp_work* work, stp_hash key, bool* write)
{
    for (;;) {
        stp_work_entry* entry = find_verified(work, key);
        entry = entry != NULL ? entry : stp_work_index_add(work->context, &work->index, key);
        if (entry != NULL && entry->state == STP_WORK_PENDING) {
            pthread_cond_wait(&work->finished, &work->mutex);
            continue;
        }
        *write = entry != NULL && entry->state == STP_WORK_ABSENT;
        if (*write) {
            entry->state = STP_WORK_PENDING;
        }
        return entry;
    }
}

static stp_result store(stp_work* work, const stp_work_head* head, const stp_bytes* parts,
                        size_t part_count, const void** stored)
{
    bool write = false;
    if (work->failed) {
        return STP_ERROR_IO;
    }
    if (claim(work, head->key, &write) == NULL) {
        return stp_fail_memory(work->context);
    }
    stp_result result = write ? write_result(work, head, parts, part_count) : STP_OK;
    if (result == STP_OK && stored != NULL) {
        *stored = bytes_of(work, stp_work_index_find(&work->index, head->key));
    }
    return result;
}

stp_result stp_work_store(stp_work* work, stp_hash key, const stp_bytes* parts, size_t part_count,
                          const void** stored)
{
    stp_work_head head = {.key = key};
    for (size_t i = 0; i < part_count; ++i) {
        if (parts[i].size > SIZE_MAX / 2 - head.size) {
            return stp_fail_memory(work->context);
        }
        head.size += parts[i].size;
    }
    if (stp_work_record_bytes(head.size) == 0) {
        return stp_fail(work->context, STP_ERROR_LIMIT, "%s: a result of %llu bytes is too large",
                        work->path, (unsigned long long)head.size);
    }
    head.checksum = stp_checksum(parts, part_count);
    pthread_mutex_lock(&work->mutex);
    stp_result result = store(work, &head, parts, part_count, stored);
    pthread_mutex_unlock(&work->mutex);
    return result;
}

void stp_work_drop(stp_work* work, stp_hash key)
{
    pthread_mutex_lock(&work->mutex);
    stp_work_entry* entry = stp_work_index_find(&work->index, key);
    if (entry != NULL && (entry->state == STP_WORK_GOOD || entry->state == STP_WORK_UNVERIFIED)) {
        entry->state = STP_WORK_ABSENT;
        atomic_fetch_add(&work->damaged, 1);
    }
    pthread_mutex_unlock(&work->mutex);
}

void stp_work_release_pages(stp_work* work)
{
    pthread_mutex_lock(&work->mutex);
    for (uint32_t i = 0; i < work->segment_count; ++i) {
        stp_work_segment_release_pages(&work->segments[i]);
    }
    pthread_mutex_unlock(&work->mutex);
}

stp_context* stp_work_get_context(const stp_work* work)
{
    return work->context;
}

static uint64_t count_held(const stp_work* work)
{
    uint64_t held = 0;
    for (size_t i = 0; i < work->index.count; ++i) {
        stp_work_state state = work->index.entries[i].state;
        held += state == STP_WORK_GOOD || state == STP_WORK_UNVERIFIED ? 1 : 0;
    }
    return held;
}

void stp_work_get_report(const stp_work* work, stp_work_report* report)
{
    *report = (stp_work_report){
        .found = atomic_load(&work->found),
        .found_bytes = atomic_load(&work->found_bytes),
        .stored = atomic_load(&work->stored),
        .stored_bytes = atomic_load(&work->stored_bytes),
        .damaged = atomic_load(&work->damaged),
        .held = count_held(work),
    };
}
