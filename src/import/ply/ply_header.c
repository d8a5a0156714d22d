// SPDX-License-Identifier: MIT
#include "import/ply/ply.h"

#include <assert.h>
#include <string.h>

#define HEADER_LIMIT ((size_t)1 << 20) ///< maximum bytes of a header

size_t stp_ply_type_size(stp_ply_type type)
{
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    assert((unsigned)type < sizeof(sizes) / sizeof(sizes[0]));
    return sizes[type];
}

// The remaining words of a header line.
typedef struct line {
    stp_text at;
} line;

static bool next_word(line* l, stp_text* begin, stp_text* end)
{
    *begin = stp_skip_blanks(l->at);
    *end = stp_skip_word(*begin);
    l->at = *end;
    return *end > *begin;
}

static bool read_type(line* l, stp_ply_type* type)
{
    static const char* const names[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    stp_text begin, end;
    if (!next_word(l, &begin, &end)) {
        return false;
    }
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); ++i) {
        if (stp_word_is(begin, end, names[i][0]) || stp_word_is(begin, end, names[i][1])) {
            *type = (stp_ply_type)i;
            return true;
        }
    }
    return false;
}

static stp_result copy_word(stp_ply* ply, stp_text begin, stp_text end, const char** copy)
{
    *copy =
        stp_arena_copy_text(&ply->import->scene->text, (const char*)begin, (size_t)(end - begin));
    return *copy != NULL ? STP_OK : stp_fail_memory(ply->context);
}

static stp_result fail_line(const stp_ply* ply, stp_text at, const char* expected)
{
    stp_text end = at;
    while (*end != '\n' && *end != '\r') {
        ++end;
    }
    int length = end - at < 80 ? (int)(end - at) : 80;
    return stp_fail(ply->context, STP_ERROR_FORMAT, "%s: header: \"%.*s\": expected %s",
                    ply->import->path, length, (const char*)at, expected);
}

static stp_result read_format(stp_ply* ply, line* l, stp_text start)
{
    stp_text begin, end;
    (void)next_word(l, &begin, &end);
    if (stp_word_is(begin, end, "ascii")) {
        ply->encoding = STP_PLY_ASCII;
    } else if (stp_word_is(begin, end, "binary_little_endian")) {
        ply->encoding = STP_PLY_LITTLE;
    } else if (stp_word_is(begin, end, "binary_big_endian")) {
        ply->encoding = STP_PLY_BIG;
    } else {
        return fail_line(ply, start, "ascii, binary_little_endian or binary_big_endian");
    }
    return STP_OK;
}

static stp_result read_element(stp_ply* ply, line* l, stp_text start)
{
    stp_text begin, end;
    int64_t count;
    bool named = next_word(l, &begin, &end);
    if (!named || stp_read_integer(l->at, &count) == NULL || count < 0) {
        return fail_line(ply, start, "the name of an element and its count");
    }
    if (!STP_MAKE_ROOM(ply->context, ply->elements, ply->element_capacity,
                       ply->element_count + 1)) {
        return stp_fail_memory(ply->context);
    }
    stp_ply_element* element = &ply->elements[ply->element_count++];
    *element = (stp_ply_element){.count = (uint64_t)count};
    return copy_word(ply, begin, end, &element->name);
}

static stp_result read_property(stp_ply* ply, line* l, stp_text start)
{
    stp_ply_element* element =
        ply->element_count > 0 ? &ply->elements[ply->element_count - 1] : NULL;
    if (element == NULL) {
        return fail_line(ply, start, "an element before the first property");
    }
    stp_ply_property property = {0};
    stp_text begin, end;
    line before = *l;
    property.is_list = next_word(l, &begin, &end) && stp_word_is(begin, end, "list");
    if (!property.is_list) {
        *l = before;
    }
    bool good = !property.is_list ||
                (read_type(l, &property.count_type) && property.count_type < STP_PLY_FLOAT32);
    if (!good || !read_type(l, &property.type) || !next_word(l, &begin, &end)) {
        return fail_line(ply, start, "a type (char to double, or a list of them) and a name");
    }
    stp_result result = copy_word(ply, begin, end, &property.name);
    if (result != STP_OK) {
        return result;
    }
    if (!STP_MAKE_ROOM(ply->context, element->properties, element->property_capacity,
                       element->property_count + 1)) {
        return stp_fail_memory(ply->context);
    }
    property.offset = element->row_size;
    element->has_lists |= property.is_list;
    element->row_size += stp_ply_type_size(property.is_list ? property.count_type : property.type);
    element->properties[element->property_count++] = property;
    return STP_OK;
}

static stp_result read_comment(stp_ply* ply, line* l)
{
    stp_text begin, end;
    if (!next_word(l, &begin, &end) || !stp_word_is(begin, end, "texturefile")) {
        return STP_OK;
    }
    begin = stp_skip_blanks(end);
    for (end = begin; *end != '\n' && *end != '\r';) {
        ++end;
    }
    if (!STP_MAKE_ROOM(ply->context, ply->textures, ply->texture_capacity,
                       ply->texture_count + 1)) {
        return stp_fail_memory(ply->context);
    }
    return copy_word(ply, begin, end, &ply->textures[ply->texture_count++]);
}

static stp_result read_line(stp_ply* ply, stp_text start, bool* done)
{
    line l = {start};
    stp_text begin, end;
    if (!next_word(&l, &begin, &end)) {
        return STP_OK;
    }
    if (stp_word_is(begin, end, "format")) {
        return read_format(ply, &l, start);
    }
    if (stp_word_is(begin, end, "element")) {
        return read_element(ply, &l, start);
    }
    if (stp_word_is(begin, end, "property")) {
        return read_property(ply, &l, start);
    }
    if (stp_word_is(begin, end, "comment")) {
        return read_comment(ply, &l);
    }
    *done = stp_word_is(begin, end, "end_header");
    return STP_OK; // other lines are comments: "obj_info", and comments without the keyword
}

stp_result stp_ply_read_header(stp_ply* ply)
{
    const stp_mapped_file* file = &ply->import->file;
    size_t size = file->size < HEADER_LIMIT ? file->size : HEADER_LIMIT;
    size_t whole = size > 0 ? stp_whole_lines(file->bytes, size) : 0;
    bool done = false;
    size_t at = 0;
    while (at < whole && !done) {
        stp_result result = read_line(ply, file->bytes + at, &done);
        if (result != STP_OK) {
            return result;
        }
        at = (size_t)((stp_text)memchr(file->bytes + at, '\n', whole - at) - file->bytes) + 1;
    }
    assert(at <= whole && (at == 0 || file->bytes[at - 1] == '\n'));
    ply->body = at;
    if (!done && file->size > HEADER_LIMIT) {
        return stp_fail(ply->context, STP_ERROR_FORMAT, "%s: its header has no end_header",
                        ply->import->path);
    }
    return done ? STP_OK
                : stp_fail(ply->context, STP_ERROR_TRUNCATED, "%s: ends before end_header",
                           ply->import->path);
}

void stp_ply_destroy(stp_ply* ply)
{
    for (size_t i = 0; i < ply->element_count; ++i) {
        stp_free(ply->context, ply->elements[i].properties);
    }
    stp_free(ply->context, ply->elements);
    stp_free(ply->context, ply->textures);
}
