// SPDX-License-Identifier: MIT
#include "support_reader.h"

#include <string.h>

void slow_reader_create(slow_reader* reader, const unsigned char* bytes, uint64_t size, bool open)
{
    *reader = (slow_reader){.bytes = bytes, .size = size, .open = open, .wrong_at = UINT64_MAX};
    pthread_mutex_init(&reader->mutex, NULL);
    pthread_cond_init(&reader->moved, NULL);
}

void slow_reader_destroy(slow_reader* reader)
{
    pthread_cond_destroy(&reader->moved);
    pthread_mutex_destroy(&reader->mutex);
}

void slow_reader_let_go(slow_reader* reader, uint32_t count)
{
    pthread_mutex_lock(&reader->mutex);
    reader->open = reader->open || count == UINT32_MAX;
    reader->tickets += count == UINT32_MAX ? 0 : count;
    pthread_cond_broadcast(&reader->moved);
    pthread_mutex_unlock(&reader->mutex);
}

void slow_reader_await(slow_reader* reader, uint32_t waiting)
{
    pthread_mutex_lock(&reader->mutex);
    while (reader->waiting < waiting) {
        pthread_cond_wait(&reader->moved, &reader->mutex);
    }
    pthread_mutex_unlock(&reader->mutex);
}

bool slow_reader_read(void* user, uint64_t offset, void* bytes, size_t size)
{
    slow_reader* reader = user;
    pthread_mutex_lock(&reader->mutex);
    reader->waiting += 1;
    pthread_cond_broadcast(&reader->moved);
    while (!reader->open && reader->tickets == 0) {
        pthread_cond_wait(&reader->moved, &reader->mutex);
    }
    reader->tickets -= reader->open ? 0 : 1;
    reader->waiting -= 1;
    reader->reads += 1;
    pthread_mutex_unlock(&reader->mutex);
    if (offset > reader->size || size > reader->size - offset) {
        return false;
    }
    memcpy(bytes, reader->bytes + offset, size);
    if (reader->wrong_at >= offset && reader->wrong_at - offset < size) {
        ((unsigned char*)bytes)[reader->wrong_at - offset] ^= 1;
    }
    return true;
}

uint32_t residency_settle(stp_residency* residency, const stp_data_request* wants, size_t count)
{
    uint32_t updates = 1;
    stp_residency_update(residency, wants, count);
    while (stp_residency_wait(residency)) {
        stp_residency_update(residency, wants, count);
        updates += 1;
    }
    return updates;
}
