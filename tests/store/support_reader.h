// SPDX-License-Identifier: MIT
// A disk that tests hold in their hands: reads wait until they are let go, and may fail or bring wrong bytes.
#pragma once

#include "store/residency.h"

#include <pthread.h>

typedef struct slow_reader {
    pthread_mutex_t mutex;
    pthread_cond_t moved;
    const unsigned char* bytes;
    uint64_t size; ///< reads beyond fail
    bool open;     ///< else each read waits for a ticket
    uint32_t tickets;
    uint32_t waiting, reads;
    uint64_t wrong_at; ///< the byte there comes changed; UINT64_MAX: none does
} slow_reader;

void slow_reader_create(slow_reader* reader, const unsigned char* bytes, uint64_t size, bool open);
void slow_reader_destroy(slow_reader* reader);
/// Lets so many reads go; UINT32_MAX: all from now on.
void slow_reader_let_go(slow_reader* reader, uint32_t count);
/// Waits until so many reads wait at once.
void slow_reader_await(slow_reader* reader, uint32_t waiting);
/// For stp_residency_desc.
bool slow_reader_read(void* user, uint64_t offset, void* bytes, size_t size);

/// Updates with the same wants until nothing more comes. @return how many updates it took
uint32_t residency_settle(stp_residency* residency, const stp_want* wants, size_t count);
