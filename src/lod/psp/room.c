// SPDX-License-Identifier: MIT
#include "lod/psp/room.h"

#include <assert.h>

void stp_psp_storage_begin(stp_psp_storage* storage, stp_context* context, stp_spill* beside)
{
    storage->context = context;
    storage->beside = beside;
    storage->full = false;
    pthread_mutex_init(&storage->mutex, NULL);
}

void stp_psp_storage_end(stp_psp_storage* storage)
{
    pthread_mutex_destroy(&storage->mutex);
}

stp_result stp_psp_storage_fail(stp_psp_storage* storage)
{
    return storage->full ? STP_ERROR_IO : stp_fail_memory(storage->context);
}

stp_result stp_psp_room_open(stp_psp_storage* storage, stp_psp_room* room)
{
    *room = (stp_psp_room){.storage = storage};
    return storage->beside != NULL ? stp_spill_create_sibling(storage->beside, &room->file)
                                   : STP_OK;
}

void* stp_psp_room_alloc(const stp_psp_room* room, size_t count, size_t size)
{
    assert(size > 0 && "the size of an element");
    stp_psp_storage* storage = room->storage;
    if (room->file == NULL || count > SIZE_MAX / size) {
        return stp_alloc_array(storage->context, count, size);
    }
    pthread_mutex_lock(&storage->mutex);
    void* array = storage->full ? NULL : stp_spill_alloc(room->file, count * size);
    storage->full |= array == NULL;
    pthread_mutex_unlock(&storage->mutex);
    return array;
}

void stp_psp_room_free(const stp_psp_room* room, void* array)
{
    if (room->file == NULL && array != NULL) {
        stp_free(room->storage->context, array);
    }
}

void stp_psp_room_close(stp_psp_room* room)
{
    stp_spill_destroy(room->file);
    *room = (stp_psp_room){0};
}

void stp_psp_room_release(const stp_psp_room* room)
{
    if (room->file != NULL) {
        assert(room->storage->beside != NULL && "files are siblings of `beside`");
        stp_spill_release_pages(room->file);
        stp_spill_release_pages(room->storage->beside);
    }
}
