// SPDX-License-Identifier: MIT
// Storage for arrays that grow with the number of points: memory, or a temporary file whose pages
// the system may evict at any time (base/io/spill.h).
#pragma once

#include "base/core/context.h"
#include "base/io/spill.h"

#include <pthread.h>

/// Shared by all rooms of a merge.
typedef struct stp_psp_storage {
    stp_context* context;
    stp_spill* beside; ///< storage files go to the same folder; NULL: memory
    pthread_mutex_t mutex;
    bool full; ///< an allocation in a file failed, which was logged; no further ones are tried
} stp_psp_storage;

/// Arrays with one lifetime.
typedef struct stp_psp_room {
    stp_psp_storage* storage;
    stp_spill* file; ///< NULL: in memory
} stp_psp_room;

void stp_psp_storage_begin(stp_psp_storage* storage, stp_context* context, stp_spill* beside);
void stp_psp_storage_end(stp_psp_storage* storage);
/// Reports a failed allocation: a full disk, already logged, or out of memory, which this logs.
stp_result stp_psp_storage_fail(stp_psp_storage* storage);

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged). Closed by stp_psp_room_close
STP_MUST_USE stp_result stp_psp_room_open(stp_psp_storage* storage, stp_psp_room* room);
/// Allocates `count` elements of `size` bytes, uninitialised; NULL on failure, or after an earlier
/// failure (stp_psp_storage_fail). Any thread.
void* stp_psp_room_alloc(const stp_psp_room* room, size_t count, size_t size);
/// Frees an array in memory; one in a file stays until the room is closed. NULL is allowed.
void stp_psp_room_free(const stp_psp_room* room, void* array);
/// Closes the file, after all arrays were freed. An unopened room is allowed.
void stp_psp_room_close(stp_psp_room* room);
/// Lets the system evict pages of the room's file, and of `beside`; they are read again when
/// needed. No effect for memory. Any thread.
void stp_psp_room_release(const stp_psp_room* room);

#define STP_PSP_NEW(room, type, count) ((type*)stp_psp_room_alloc((room), (count), sizeof(type)))
