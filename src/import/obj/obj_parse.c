// SPDX-License-Identifier: MIT
// Cuts OBJ text into chunks of whole lines and parses them on all threads.
#include "import/obj/obj.h"
#include "import/reading/place_sample.h"
#include "import/reading/point_columns.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define CHUNKS_PER_THREAD 4 ///< chunks in memory until they are moved to the scratch file

void* stp_obj_grow(stp_context* context, stp_obj_array* array, size_t count, size_t size)
{
    assert(array->count <= array->capacity && size > 0);
    return stp_make_room(context, &array->items, &array->capacity, array->count + count, size)
               ? (unsigned char*)array->items + array->count * size
               : NULL;
}

static void parse_chunks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_obj* obj = user;
    for (size_t i = begin; i < end; ++i) {
        stp_obj_parse_chunk(obj->context, &obj->chunks[obj->parsed + i], obj->origin);
    }
}

// Parses a few chunks at a time and moves their data before the next ones.
static stp_result parse_into_scratch(stp_obj* obj)
{
    stp_result result = STP_OK;
    size_t maximum = CHUNKS_PER_THREAD * (size_t)stp_context_thread_count(obj->context);
    while (result == STP_OK && obj->parsed < obj->chunk_count) {
        size_t left = obj->chunk_count - obj->parsed, count = left < maximum ? left : maximum;
        stp_parallel_for(obj->context, count, 1, parse_chunks, obj);
        for (size_t i = 0; result == STP_OK && i < count; ++i) {
            stp_obj_chunk* chunk = &obj->chunks[obj->parsed++];
            bool broken = chunk->out_of_memory || chunk->error != NULL;
            result = broken ? STP_OK : stp_obj_move_chunk(obj, chunk);
            if (broken) {
                return STP_OK; // report() returns the error
            }
        }
    }
    return result;
}

// The end of a chunk of at least `size` bytes: after a line end without a preceding backslash.
static stp_text chunk_end(stp_text begin, size_t size, stp_text end)
{
    assert(begin < end && size > 0);
    if ((size_t)(end - begin) <= size) {
        return end;
    }
    stp_text stop = memchr(begin + size - 1, '\n', (size_t)(end - begin) - size + 1);
    while (stop != NULL && stp_obj_is_continued(begin, stop)) {
        stop = memchr(stop + 1, '\n', (size_t)(end - stop) - 1);
    }
    return stop != NULL ? stop + 1 : end;
}

static stp_result split_chunks(stp_obj* obj, size_t chunk_size)
{
    stp_text bytes = obj->import->file.bytes;
    size_t size = obj->import->file.size;
    if (size == 0) {
        return STP_OK; // no chunks: perhaps nothing was mapped either
    }
    size_t whole = stp_whole_lines(bytes, size);
    // a last line that continues one before it must stay with it
    if (whole < size) {
        size_t start = whole;
        while (start > 0 && stp_obj_is_continued(bytes, bytes + start - 1)) {
            start = stp_whole_lines(bytes, start - 1);
        }
        whole = start;
    }
    assert(whole <= size && (whole == 0 || bytes[whole - 1] == '\n'));
    size_t limit = whole / chunk_size + 2;
    obj->chunks = STP_NEW_ZEROED(obj->context, stp_obj_chunk, limit);
    if (obj->chunks == NULL) {
        return stp_fail_memory(obj->context);
    }
    for (stp_text at = bytes; at < bytes + whole;) {
        stp_text end = chunk_end(at, chunk_size, bytes + whole);
        obj->chunks[obj->chunk_count++] = (stp_obj_chunk){.begin = at, .end = end};
        at = end;
    }
    if (whole < size) {
        size_t length = size - whole;
        obj->tail = stp_alloc(obj->context, length + 1);
        if (obj->tail == NULL) {
            return stp_fail_memory(obj->context);
        }
        memcpy(obj->tail, bytes + whole, length);
        obj->tail[length] = '\n';
        if (whole == 0) {
            stp_text_end_lines(obj->tail, length);
        }
        obj->chunks[obj->chunk_count++] =
            (stp_obj_chunk){.begin = obj->tail, .end = obj->tail + length + 1};
    }
    assert(obj->chunk_count <= limit && "all but the last hold chunk_size bytes");
    return STP_OK;
}

// `limit` is after a line end.
static stp_text next_line(stp_text at, stp_text limit)
{
    assert(at < limit);
    return (stp_text)memchr(at, '\n', (size_t)(limit - at)) + 1;
}

// Adds the first finite position of at most `lines` lines that start in [at, end).
static void sample_lines(stp_text at, stp_text end, stp_text limit, size_t lines,
                         stp_place_sample* places)
{
    uint32_t before = places->count;
    for (size_t i = 0; i < lines && at < end && places->count == before; ++i) {
        stp_text start = stp_skip_blanks(at);
        double n[3] = {0};
        if (start[0] == 'v' && stp_is_blank(start[1])) {
            stp_text next = start + 1;
            for (int k = 0; k < 3 && next != NULL; ++k) {
                next = stp_read_number(next, &n[k]);
            }
            if (next != NULL) { // else the parser reports an error
                stp_place_sample_add(places, n);
            }
        }
        at = next_line(start, limit);
    }
}

// The first finite position and some from all over the file choose the origin.
static void find_origin(stp_obj* obj)
{
    enum { LINES = 64 }; // most lines to search in a part of the file
    stp_place_sample places = {0};
    double middle[3];
    for (size_t i = 0; i < obj->chunk_count && places.count == 0; ++i) {
        sample_lines(obj->chunks[i].begin, obj->chunks[i].end, obj->chunks[i].end, SIZE_MAX,
                     &places);
    }
    if (places.count > 0) { // the tail is not beside the others
        size_t last = obj->chunk_count - 1;
        last -= obj->tail != NULL && last > 0;
        stp_text begin = obj->chunks[0].begin, end = obj->chunks[last].end;
        for (uint32_t i = 0; i < STP_PLACE_SAMPLES; ++i) {
            stp_text at = begin + stp_place_sample_index(i, (size_t)(end - begin));
            stp_text stop = begin + stp_place_sample_index(i + 1, (size_t)(end - begin));
            at = at == begin || at[-1] == '\n' ? at : next_line(at, end);
            sample_lines(at, stop, end, LINES, &places);
        }
    }
    stp_place_sample_choose(&places, middle);
    stp_import_choose_origin(middle, obj->origin);
}

// Reports the first error of the file, independent of threads.
static stp_result report(const stp_obj* obj)
{
    const char* path = obj->import->path;
    uint64_t lines = 0;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        const stp_obj_chunk* chunk = &obj->chunks[i];
        if (chunk->out_of_memory) {
            return stp_fail_memory(obj->context);
        }
        if (chunk->error != NULL) {
            assert(chunk->error_at >= chunk->begin && chunk->error_at < chunk->end);
            for (size_t k = 0; k < i; ++k) {
                const stp_obj_chunk* before = &obj->chunks[k];
                lines += stp_line_number(before->begin, (size_t)(before->end - before->begin)) - 1;
            }
            lines += stp_line_number(chunk->begin, (size_t)(chunk->error_at - chunk->begin));
            return stp_fail(obj->context, STP_ERROR_FORMAT, "%s: line %llu: %s", path,
                            (unsigned long long)lines, chunk->error);
        }
    }
    return STP_OK;
}

stp_result stp_obj_parse(stp_obj* obj, size_t chunk_size)
{
    assert(chunk_size > 0 && obj->chunk_count == 0);
    stp_result result = split_chunks(obj, chunk_size);
    if (result != STP_OK) {
        return result;
    }
    find_origin(obj);
    if (obj->scratch != NULL) {
        result = parse_into_scratch(obj);
    } else {
        stp_parallel_for(obj->context, obj->chunk_count, 1, parse_chunks, obj);
    }
    return result == STP_OK ? report(obj) : result;
}
