// SPDX-License-Identifier: MIT
// Where arrays lie that grow with the number of points: in memory, or in a temporary file that the
// system may drop from memory at any time (base/spill.h).
#pragma once

#include "base/context.h"
#include "base/spill.h"

#include <pthread.h>

/// What all rooms of a merge share.
typedef struct stp_psp_storage {
    stp_context* context;
    stp_spill* beside; ///< rooms are files beside it; NULL: they are in memory
    pthread_mutex_t mutex;
    bool full; ///< a file had no room, which was logged, once
} stp_psp_storage;

/// Arrays with one lifetime.
typedef struct stp_psp_room {
    stp_psp_storage* storage;
    stp_spill* file; ///< NULL: in memory
} stp_psp_room;

void stp_psp_storage_begin(stp_psp_storage* storage, stp_context* context, stp_spill* beside);
void stp_psp_storage_end(stp_psp_storage* storage);
/// What a missing array is: a full disk, which was logged, or memory that ran out, which this logs.
stp_result stp_psp_storage_fail(stp_psp_storage* storage);

/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged). Closed by stp_psp_room_close
STP_MUST_USE stp_result stp_psp_room_open(stp_psp_storage* storage, stp_psp_room* room);
/// Room for `count` elements of `size` bytes, uninitialised; NULL where there is no room, or was
/// none before (stp_psp_storage_fail). Any thread.
void* stp_psp_room_alloc(const stp_psp_room* room, size_t count, size_t size);
/// Frees an array in memory; one in a file stays until the room is closed. NULL is allowed.
void stp_psp_room_free(const stp_psp_room* room, void* array);
/// Closes the file, after all arrays were freed. A room that was not opened is allowed.
void stp_psp_room_close(stp_psp_room* room);
/// Lets the system drop what lies in a file from memory, and what lies in the file that it is
/// beside; it is read again when needed. Does nothing in memory. Any thread.
void stp_psp_room_release(const stp_psp_room* room);

#define STP_PSP_NEW(room, type, count) ((type*)stp_psp_room_alloc((room), (count), sizeof(type)))
