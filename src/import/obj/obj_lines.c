// SPDX-License-Identifier: MIT
// Parses the lines of a chunk of OBJ text to arrays.
#include "import/obj/obj.h"

#include <assert.h>
#include <math.h>
#include <string.h>

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
    assert(chunk->positions.count > chunk->colors.count && "the position was added before");
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
        position[i] = (float)(n[i] - p->origin[i]); // if not finite, the scene drops its faces
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
    assert(size == 2 || size == 3);
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
    bool good = index < 0 && index >= -STP_OBJ_INDEX_LIMIT && relative < STP_OBJ_INDEX_LIMIT;
    assert(!good || ((*out & STP_OBJ_RELATIVE) != 0 && *out != STP_OBJ_ABSENT));
    return good;
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

// As read_index, for texture coordinates and normals: some programs write 0 for none.
static inline stp_text read_optional_index(stp_text at, size_t count, uint32_t* out, bool* good)
{
    if (at[0] == '0' && !stp_is_digit(at[1])) {
        *out = STP_OBJ_ABSENT;
        return at + 1;
    }
    return read_index(at, count, out, good);
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
        at = read_optional_index(at, chunk->texcoords.count, &corner->texcoord, good);
        if (!*good) {
            return at;
        }
    }
    if (*at == '/') {
        ++at;
        if (!stp_is_blank(*at) && *at != '\n') {
            at = read_optional_index(at, chunk->normals.count, &corner->normal, good);
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
        assert(at < end);
        stp_text stop = *at == '\n' ? at : memchr(at, '\n', (size_t)(end - at));
        if (comment || stop + 1 >= end || !stp_obj_is_continued(at, stop)) {
            return stop + 1;
        }
        at = stop + 1;
    }
}

void stp_obj_parse_chunk(stp_context* context, stp_obj_chunk* chunk, const double origin[3])
{
    parser p = {.context = context, .chunk = chunk, .origin = origin};
    assert(chunk->begin < chunk->end && chunk->end[-1] == '\n');
    stp_text at = chunk->begin;
    while (at < chunk->end) {
        stp_text line = at;
        at = read_line(&p, line);
        if (at == NULL) {
            return;
        }
        at = skip_line(&p, line, at);
    }
}
