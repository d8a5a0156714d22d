// SPDX-License-Identifier: MIT
// Parses OBJ text to arrays, one chunk of whole lines at a time.
#include "import/obj.h"

#include <math.h>
#include <string.h>

#define CHUNKS_PER_THREAD 4 // that are in memory until they are moved to the scratch file

void* stp_obj_grow(stp_context* context, stp_obj_array* array, size_t count, size_t size)
{
    if (array->items == NULL || array->capacity - array->count < count) {
        void* items =
            stp_grow_array(context, array->items, &array->capacity, array->count + count, size);
        if (items == NULL) {
            return NULL;
        }
        array->items = items;
    }
    return (unsigned char*)array->items + array->count * size;
}

// Parser state of a chunk that persists between lines.
typedef struct parser {
    stp_context* context;
    stp_obj_chunk* chunk;
    const double* origin;
} parser;

static void* grow(parser* p, stp_obj_array* array, size_t count, size_t size)
{
    void* items = stp_obj_grow(p->context, array, count, size);
    p->chunk->out_of_memory |= items == NULL;
    return items;
}

// Records the error of the line; @return NULL, which ends the parsing.
static stp_text fail(parser* p, stp_text at, const char* error)
{
    p->chunk->error = error;
    p->chunk->error_at = at;
    return NULL;
}

// Whether the line continues: its last non-blank character is a backslash.
static bool is_continued(stp_text line, stp_text end)
{
    while (end > line && stp_is_blank(end[-1])) {
        --end;
    }
    return end > line && end[-1] == '\\';
}

// After the last element of a line: a backslash at the line's end joins the next line. @return the
// next element, or a position where *at is '\n' or not an element
static stp_text next_element(parser* p, stp_text at)
{
    at = stp_skip_blanks(at);
    while (*at == '\\') {
        stp_text next = stp_skip_blanks(at + 1);
        if (*next != '\n') {
            break;
        }
        if (next + 1 >= p->chunk->end) {
            return next;
        }
        at = stp_skip_blanks(next + 1);
    }
    return at;
}

// Reads up to `limit` numbers. @return the text after the last
static stp_text read_numbers(parser* p, stp_text at, double* numbers, int limit, int* count)
{
    *count = 0;
    while (*count < limit) {
        at = next_element(p, at);
        if (*at == '\n') {
            break;
        }
        stp_text next = stp_read_number(at, &numbers[*count]);
        if (next == NULL) {
            break;
        }
        at = next;
        *count += 1;
    }
    return at;
}

static bool add_color(parser* p, const double* rgb)
{
    stp_obj_chunk* chunk = p->chunk;
    size_t before = chunk->positions.count - 1;
    size_t missing = before - chunk->colors.count;
    float* colors = grow(p, &chunk->colors, missing + 1, 3 * sizeof(float));
    if (colors == NULL) {
        return false;
    }
    for (size_t i = 0; i < 3 * missing; ++i) {
        colors[i] = STP_OBJ_NO_COLOR;
    }
    for (size_t i = 0; i < 3; ++i) {
        float value = rgb != NULL ? (float)rgb[i] : STP_OBJ_NO_COLOR;
        bool good = rgb == NULL || (isfinite(value) && value >= 0.0f);
        colors[3 * missing + i] = good ? value : 0.0f;
        chunk->color_max = good && value > chunk->color_max ? value : chunk->color_max;
    }
    chunk->colors.count += missing + 1;
    return true;
}

// "v x y z", "v x y z w", and the widespread "v x y z r g b" (with or without a fourth, alpha).
static stp_text read_position(parser* p, stp_text line, stp_text at)
{
    double n[7];
    int count;
    at = read_numbers(p, at, n, 7, &count);
    if (count < 3) {
        return fail(p, line, "expected three coordinates");
    }
    float* position = grow(p, &p->chunk->positions, 1, 3 * sizeof(float));
    if (position == NULL) {
        return NULL;
    }
    for (int i = 0; i < 3; ++i) {
        position[i] = (float)(n[i] - p->origin[i]);
        if (!isfinite(position[i])) {
            return fail(p, line, "a coordinate is not finite");
        }
    }
    p->chunk->positions.count += 1;
    if (count >= 6 || p->chunk->colors.count != 0) {
        return add_color(p, count >= 6 ? n + 3 : NULL) ? at : NULL;
    }
    return at;
}

// Texture coordinates and normals: invalid values become zero, because the shape does not depend on
// them.
static stp_text read_attribute(parser* p, stp_text at, stp_obj_array* array, int size)
{
    double n[3] = {0};
    int count;
    at = read_numbers(p, at, n, size, &count);
    float* values = grow(p, array, 1, (size_t)size * sizeof(float));
    if (values == NULL) {
        return NULL;
    }
    bool good = count > (size == 3 ? 2 : 0);
    for (int i = 0; i < size; ++i) {
        float value = i < count ? (float)n[i] : 0.0f;
        bool finite = isfinite(value);
        values[i] = finite ? value : 0.0f;
        good = good && finite;
    }
    p->chunk->bad_attributes += !good;
    array->count += 1;
    return at;
}

// Encodes an index of a corner. False if it is 0 or out of range.
static bool encode_index(int64_t index, size_t count, uint32_t* out)
{
    if (index > 0) {
        *out = (uint32_t)(index - 1);
        return index <= STP_OBJ_INDEX_LIMIT;
    }
    int64_t relative = (int64_t)count + index;
    *out = (uint32_t)(STP_OBJ_RELATIVE_ZERO + relative);
    return index < 0 && index >= -STP_OBJ_INDEX_LIMIT && relative < STP_OBJ_INDEX_LIMIT;
}

static inline stp_text read_index(stp_text at, size_t count, uint32_t* out, bool* good)
{
    // most indices are short and positive
    uint32_t sum = 0;
    stp_text start = at;
    unsigned digit;
    while ((digit = (unsigned)(*at - '0')) < 10 && at - start < 9) {
        sum = sum * 10 + digit;
        ++at;
    }
    if (at > start && sum != 0 && digit >= 10 && sum <= STP_OBJ_INDEX_LIMIT) {
        *out = sum - 1;
        return at;
    }
    int64_t value;
    at = stp_read_integer(start, &value);
    *good = at != NULL && encode_index(value, count, out);
    return at;
}

// "p", "p/t", "p//n" or "p/t/n".
static stp_text read_corner(parser* p, stp_text at, stp_obj_corner* corner, bool* good)
{
    const stp_obj_chunk* chunk = p->chunk;
    corner->texcoord = corner->normal = STP_OBJ_ABSENT;
    at = read_index(at, chunk->positions.count, &corner->position, good);
    if (!*good || *at != '/') {
        return at;
    }
    ++at;
    if (*at != '/' && !stp_is_blank(*at) && *at != '\n') {
        at = read_index(at, chunk->texcoords.count, &corner->texcoord, good);
        if (!*good) {
            return at;
        }
    }
    if (*at == '/') {
        ++at;
        if (!stp_is_blank(*at) && *at != '\n') {
            at = read_index(at, chunk->normals.count, &corner->normal, good);
        }
    }
    return at;
}

static stp_text read_face(parser* p, stp_text line, stp_text at)
{
    stp_obj_chunk* chunk = p->chunk;
    size_t first = chunk->corners.count;
    for (;;) {
        at = next_element(p, at);
        if (*at == '\n' || *at == '#') {
            break;
        }
        stp_obj_corner* corner = grow(p, &chunk->corners, 1, sizeof(stp_obj_corner));
        if (corner == NULL) {
            return NULL;
        }
        bool good = true;
        at = read_corner(p, at, corner, &good);
        if (!good || (!stp_is_blank(*at) && *at != '\n' && *at != '\\')) {
            return fail(p, line, "expected corners like 1, 1/2, 1//3 or 1/2/3, without index 0");
        }
        chunk->corners.count += 1;
    }
    if (chunk->corners.count > UINT32_MAX) {
        return fail(p, line, "the line has 2^32 corners or more");
    }
    if (chunk->corners.count - first < 3) {
        chunk->corners.count = first;
        chunk->small_faces += 1;
        return at;
    }
    uint32_t* end = grow(p, &chunk->polygons, 1, sizeof(uint32_t));
    if (end == NULL) {
        return NULL;
    }
    *end = (uint32_t)chunk->corners.count;
    chunk->polygons.count += 1;
    return at;
}

static stp_text read_points(parser* p, stp_text line, stp_text at)
{
    for (;;) {
        at = next_element(p, at);
        if (*at == '\n' || *at == '#') {
            return at;
        }
        uint32_t* point = grow(p, &p->chunk->points, 1, sizeof(uint32_t));
        if (point == NULL) {
            return NULL;
        }
        stp_obj_corner corner;
        bool good = true;
        at = read_corner(p, at, &corner, &good);
        if (!good || (!stp_is_blank(*at) && *at != '\n' && *at != '\\')) {
            return fail(p, line, "expected indices of positions, other than 0");
        }
        *point = corner.position;
        p->chunk->points.count += 1;
    }
}

static stp_text read_event(parser* p, stp_text at, stp_obj_event_kind kind)
{
    stp_obj_chunk* chunk = p->chunk;
    stp_obj_event* event = grow(p, &chunk->events, 1, sizeof(stp_obj_event));
    if (event == NULL) {
        return NULL;
    }
    at = stp_skip_blanks(at);
    stp_text end = memchr(at, '\n', (size_t)(chunk->end - at));
    stp_text last = end;
    while (last > at && stp_is_blank(last[-1])) {
        --last;
    }
    size_t length = (size_t)(last - at);
    *event = (stp_obj_event){.kind = kind,
                             .text = at,
                             .length = length < 4096 ? (uint32_t)length : 4096,
                             .polygon = chunk->polygons.count};
    chunk->events.count += 1;
    return end;
}

// Less common elements, by name.
static stp_text read_other(parser* p, stp_text line, stp_text at)
{
    static const char* const curves[] = {"vp",   "cstype", "deg",  "bmat", "step", "curv", "curv2",
                                         "surf", "parm",   "trim", "hole", "scrv", "sp",   "end"};
    stp_text end = stp_skip_word(at);
    switch (end - at == 1 ? *at : 0) {
    case 'o':
        return read_event(p, end, STP_OBJ_OBJECT);
    case 'g':
        return read_event(p, end, STP_OBJ_GROUP);
    case 'p':
        return read_points(p, line, end);
    case 'l':
        p->chunk->line_elements += 1;
        return end;
    default:
        break;
    }
    if (stp_word_is(at, end, "usemtl")) {
        return read_event(p, end, STP_OBJ_MATERIAL);
    }
    if (stp_word_is(at, end, "mtllib")) {
        return read_event(p, end, STP_OBJ_LIBRARY);
    }
    if (stp_word_is(at, end, "fo")) {
        return read_face(p, line, end); // the old name of f
    }
    for (size_t i = 0; i < sizeof(curves) / sizeof(curves[0]); ++i) {
        p->chunk->curves += stp_word_is(at, end, curves[i]);
    }
    return end;
}

static stp_text read_line(parser* p, stp_text line)
{
    stp_text at = stp_skip_blanks(line);
    if (at[0] == 'v') {
        if (stp_is_blank(at[1])) {
            return read_position(p, line, at + 1);
        }
        if (at[1] == 't' && stp_is_blank(at[2])) {
            return read_attribute(p, at + 2, &p->chunk->texcoords, 2);
        }
        if (at[1] == 'n' && stp_is_blank(at[2])) {
            return read_attribute(p, at + 2, &p->chunk->normals, 3);
        }
    } else if (at[0] == 'f' && stp_is_blank(at[1])) {
        return read_face(p, line, at + 1);
    }
    return *at == '\n' || *at == '#' ? at : read_other(p, line, at);
}

// Skips to the start of the next line, across lines joined by a backslash. Comments are not joined.
static stp_text skip_line(parser* p, stp_text line, stp_text at)
{
    stp_text end = p->chunk->end;
    bool comment = *stp_skip_blanks(line) == '#';
    for (;;) {
        stp_text stop = *at == '\n' ? at : memchr(at, '\n', (size_t)(end - at));
        if (comment || stop + 1 >= end || !is_continued(at, stop)) {
            return stop + 1;
        }
        at = stop + 1;
    }
}

static void parse_chunk(parser* p)
{
    stp_text at = p->chunk->begin;
    while (at < p->chunk->end) {
        stp_text line = at;
        at = read_line(p, line);
        if (at == NULL) {
            return;
        }
        at = skip_line(p, line, at);
    }
}

static void parse_chunks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_obj* obj = user;
    for (size_t i = begin; i < end; ++i) {
        stp_obj_chunk* chunk = &obj->chunks[obj->parsed + i];
        parse_chunk(&(parser){obj->context, chunk, obj->origin});
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
    if ((size_t)(end - begin) <= size) {
        return end;
    }
    stp_text stop = memchr(begin + size - 1, '\n', (size_t)(end - begin) - size + 1);
    while (stop != NULL && is_continued(begin, stop)) {
        stop = memchr(stop + 1, '\n', (size_t)(end - stop) - 1);
    }
    return stop != NULL ? stop + 1 : end;
}

static stp_result cut_chunks(stp_obj* obj, size_t chunk_size)
{
    stp_text bytes = obj->import->file.bytes;
    size_t size = obj->import->file.size;
    if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) { // a byte order mark
        bytes += 3;
        size -= 3;
    }
    if (size == 0) {
        return STP_OK; // no chunks: perhaps nothing was mapped either
    }
    size_t whole = stp_whole_lines(bytes, size);
    // a last line that continues one before it must stay with it
    if (whole < size) {
        size_t start = whole;
        while (start > 0 && is_continued(bytes, bytes + start - 1)) {
            start = stp_whole_lines(bytes, start - 1);
        }
        whole = start;
    }
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
        obj->chunks[obj->chunk_count++] =
            (stp_obj_chunk){.begin = obj->tail, .end = obj->tail + length + 1};
    }
    return STP_OK;
}

// The first position chooses the origin: coordinates in the millions (national grids) lose digits
// as floats.
static void find_origin(stp_obj* obj)
{
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        stp_text end = obj->chunks[i].end;
        for (stp_text at = obj->chunks[i].begin; at < end;) {
            stp_text start = stp_skip_blanks(at);
            double n[3];
            if (start[0] == 'v' && stp_is_blank(start[1])) {
                at = start + 1;
                for (int k = 0; k < 3 && at != NULL; ++k) {
                    at = stp_read_number(at, &n[k]);
                    bool far = at != NULL && fabs(n[k]) >= 4096.0 && fabs(n[k]) < 1e15;
                    obj->origin[k] = far ? (double)(int64_t)(n[k] / 1024.0) * 1024.0 : 0.0;
                }
                return;
            }
            at = (stp_text)memchr(start, '\n', (size_t)(end - start)) + 1;
        }
    }
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
    stp_result result = cut_chunks(obj, chunk_size);
    if (result != STP_OK) {
        return result;
    }
    find_origin(obj);
    if (obj->scratch != NULL) {
        result = parse_into_scratch(obj);
    } else {
        stp_parallel_for(obj->context, obj->chunk_count, 1, parse_chunks, obj);
    }
    return result != STP_OK ? result : report(obj);
}
