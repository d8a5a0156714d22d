// SPDX-License-Identifier: MIT
// A disk under test control: reads wait until released, and can fail or return wrong bytes.
#pragma once

#include "store/residency/residency.h"

#include <pthread.h>

typedef struct slow_reader {
    pthread_mutex_t mutex;
    pthread_cond_t moved;
    const unsigned char* bytes;
    uint64_t size; ///< reads beyond it fail
    bool open;     ///< else each read waits for a ticket
    uint32_t tickets;
    uint32_t waiting, reads;
    uint64_t wrong_at; ///< offset of a byte that is returned changed; UINT64_MAX: none
} slow_reader;

void slow_reader_create(slow_reader* reader, const unsigned char* bytes, uint64_t size, bool open);
void slow_reader_destroy(slow_reader* reader);
/// Releases this many reads; UINT32_MAX: all from now on.
void slow_reader_let_go(slow_reader* reader, uint32_t count);
/// Waits until this many reads are waiting.
void slow_reader_await(slow_reader* reader, uint32_t waiting);
/// Read callback for stp_residency_desc.
bool slow_reader_read(void* user, uint64_t offset, void* bytes, size_t size);

/// Updates with the same requests until nothing more arrives. @return the number of updates
uint32_t residency_settle(stp_residency* residency, const stp_data_request* wants, size_t count);
