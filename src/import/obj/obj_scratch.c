// SPDX-License-Identifier: MIT
// Reading an OBJ file takes several times its size: corners by chunk, by mesh, and by position. If
// that is large compared to the memory limit, the data goes to a temporary file.
#include "import/obj/obj.h"

#include <assert.h>
#include <string.h>

#define SHARE 2 ///< reciprocal share of the scene's memory: larger files use a scratch file
enum { CHUNK_ARRAYS = 8, LINE = 64 };

typedef struct sized_array {
    stp_obj_array* array;
    size_t item;
} sized_array;

static void list_arrays(stp_obj_chunk* chunk, sized_array list[CHUNK_ARRAYS])
{
    const sized_array all[CHUNK_ARRAYS] = {
        {&chunk->positions, 3 * sizeof(float)},    {&chunk->colors, 3 * sizeof(float)},
        {&chunk->texcoords, 2 * sizeof(float)},    {&chunk->normals, 3 * sizeof(float)},
        {&chunk->corners, sizeof(stp_obj_corner)}, {&chunk->polygons, sizeof(uint32_t)},
        {&chunk->points, sizeof(uint32_t)},        {&chunk->events, sizeof(stp_obj_event)},
    };
    memcpy(list, all, sizeof(all));
}

static size_t padded_size(const sized_array* a)
{
    return (a->array->count * a->item + LINE - 1) & ~(size_t)(LINE - 1);
}

stp_result stp_obj_open_scratch(stp_obj* obj)
{
    const stp_scene* scene = obj->import->scene;
    bool large = scene->spill != NULL && obj->import->file.size > scene->spill_above / SHARE;
    return large ? stp_spill_create_sibling(scene->spill, &obj->scratch) : STP_OK;
}

stp_result stp_obj_move_chunk(stp_obj* obj, stp_obj_chunk* chunk)
{
    assert(!chunk->in_scratch);
    sized_array arrays[CHUNK_ARRAYS];
    list_arrays(chunk, arrays);
    size_t size = 0;
    for (int i = 0; i < CHUNK_ARRAYS; ++i) {
        size += padded_size(&arrays[i]);
    }
    unsigned char* at = stp_obj_alloc(obj, size, 1);
    if (at == NULL) {
        return stp_obj_no_room(obj);
    }
    const unsigned char* end = at + size;
    for (int i = 0; i < CHUNK_ARRAYS; ++i) {
        stp_obj_array* array = arrays[i].array;
        if (array->count != 0) {
            memcpy(at, array->items, array->count * arrays[i].item);
        }
        stp_free(obj->context, array->items);
        array->items = at;
        array->capacity = array->count;
        at += padded_size(&arrays[i]);
    }
    assert(at == end && "the arrays fill it");
    (void)end;
    chunk->in_scratch = true;
    return STP_OK;
}

void stp_obj_free_chunk(const stp_obj* obj, stp_obj_chunk* chunk)
{
    sized_array arrays[CHUNK_ARRAYS];
    list_arrays(chunk, arrays);
    for (int i = 0; i < CHUNK_ARRAYS; ++i) {
        if (!chunk->in_scratch) {
            stp_free(obj->context, arrays[i].array->items);
        }
        *arrays[i].array = (stp_obj_array){0};
    }
}

void* stp_obj_alloc(stp_obj* obj, size_t count, size_t size)
{
    assert(size > 0);
    if (obj->scratch == NULL || count > SIZE_MAX / size) {
        return stp_alloc_array(obj->context, count, size);
    }
    void* memory = obj->scratch_full ? NULL : stp_spill_alloc(obj->scratch, count * size);
    obj->scratch_full |= memory == NULL;
    return memory;
}

stp_result stp_obj_no_room(const stp_obj* obj)
{
    return obj->scratch_full ? STP_ERROR_IO : stp_fail_memory(obj->context);
}

void stp_obj_free(const stp_obj* obj, void* memory)
{
    if (obj->scratch == NULL) {
        stp_free(obj->context, memory);
    }
}
