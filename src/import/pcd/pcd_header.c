// SPDX-License-Identifier: MIT
#include "import/pcd/pcd.h"
#include "import/reading/text.h"

#include <assert.h>
#include <string.h>

#define LINES_MAX 64                   ///< maximum lines of a header, comments included
#define COUNT_LIMIT (INT64_C(1) << 48) ///< more points than any file can hold

typedef struct header {
    stp_import* import;
    stp_pcd* pcd;
    uint32_t counts[4]; ///< words of FIELDS, SIZE, TYPE, COUNT
    int64_t width, height, points;
    uint64_t line;
} header;

static stp_result fail_line(const header* h, const char* what)
{
    return stp_fail(h->import->context, STP_ERROR_FORMAT, "%s: line %llu: %s", h->import->path,
                    (unsigned long long)h->line + 1, what);
}

// Reads one word of the four lines that describe fields. @return NULL, or the error
static const char* take_word(header* h, int kind, uint32_t index, stp_text at, stp_text end)
{
    assert(index < STP_PCD_FIELDS && at < end);
    stp_pcd_field* f = &h->pcd->fields[index];
    size_t length = (size_t)(end - at);
    int64_t value = -1;
    if (kind == 0) {
        length = length < sizeof(f->name) ? length : sizeof(f->name) - 1;
        memcpy(f->name, at, length);
        f->name[length] = '\0';
        return NULL;
    }
    if (kind == 2) {
        f->type = (char)*at;
        bool known = length == 1 && (*at == 'I' || *at == 'U' || *at == 'F');
        return known ? NULL : "expected type I, U or F";
    }
    bool number = stp_read_integer(at, &value) == end;
    if (kind == 1) {
        f->size = (uint32_t)value;
        bool known = number && (value == 1 || value == 2 || value == 4 || value == 8);
        return known ? NULL : "expected size 1, 2, 4 or 8";
    }
    f->count = (uint32_t)value;
    return number && value > 0 && value <= 4096 ? NULL : "expected a count from 1 to 4096";
}

static stp_result read_words(header* h, int kind, stp_text at)
{
    uint32_t count = 0;
    for (at = stp_skip_blanks(at); *at != '\n'; at = stp_skip_blanks(at)) {
        stp_text end = stp_skip_word(at);
        const char* wrong = count < STP_PCD_FIELDS ? take_word(h, kind, count, at, end)
                                                   : "there are more than 64 fields";
        if (wrong != NULL) {
            return fail_line(h, wrong);
        }
        count += 1;
        at = end;
    }
    h->counts[kind] = count;
    return STP_OK;
}

static bool read_count(stp_text at, int64_t* count)
{
    stp_text end = stp_read_integer(at, count);
    return end != NULL && *stp_skip_blanks(end) == '\n' && *count >= 0 && *count < COUNT_LIMIT;
}

static stp_result read_encoding(header* h, stp_text at)
{
    stp_text begin = stp_skip_blanks(at), end = stp_skip_word(begin);
    static const char* const names[] = {"ascii", "binary", "binary_compressed"};
    for (int i = 0; i < 3; ++i) {
        if (stp_word_is(begin, end, names[i])) {
            h->pcd->encoding = (stp_pcd_encoding)i;
            return STP_OK;
        }
    }
    return fail_line(h, "expected DATA ascii, binary or binary_compressed");
}

static stp_result read_line(header* h, stp_text at, bool* last)
{
    static const char* const lists[] = {"fields", "size", "type", "count"};
    at = stp_skip_blanks(at);
    stp_text end = stp_skip_word(at);
    for (int i = 0; i < 4; ++i) {
        if (stp_word_is(at, end, lists[i]) || (i == 0 && stp_word_is(at, end, "columns"))) {
            return read_words(h, i, end);
        }
    }
    bool good = true;
    if (stp_word_is(at, end, "width")) {
        good = read_count(end, &h->width);
    } else if (stp_word_is(at, end, "height")) {
        good = read_count(end, &h->height);
    } else if (stp_word_is(at, end, "points")) {
        good = read_count(end, &h->points);
    } else if (stp_word_is(at, end, "data")) {
        *last = true;
        return read_encoding(h, end);
    }
    // VERSION, VIEWPOINT and comments are ignored
    return good ? STP_OK : fail_line(h, "expected a count below 2^48");
}

// Checks that the four lists match and make a row.
static stp_result check_lists(header* h)
{
    stp_pcd* pcd = h->pcd;
    uint32_t count = h->counts[0];
    bool counted = h->counts[3] != 0;
    if (count == 0 || h->counts[1] != count || h->counts[2] != count ||
        (counted && h->counts[3] != count)) {
        return stp_fail(h->import->context, STP_ERROR_FORMAT,
                        "%s: its header has %u FIELDS, %u SIZE, %u TYPE and %u COUNT",
                        h->import->path, count, h->counts[1], h->counts[2], h->counts[3]);
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_pcd_field* f = &pcd->fields[i];
        f->count = counted ? f->count : 1;
        assert(f->count > 0 && f->size > 0 && (f->size & (f->size - 1)) == 0);
        f->offset = pcd->row_size;
        pcd->row_size += f->size * f->count;
        if (f->type == 'F' && f->size < 4) {
            return stp_fail(h->import->context, STP_ERROR_FORMAT,
                            "%s: field %u is a float of %u bytes", h->import->path, i + 1, f->size);
        }
    }
    pcd->field_count = count;
    bool sized = h->width >= 0 && h->height >= 0 && h->width < (int64_t)1 << 40 &&
                 h->height < (int64_t)1 << 22;
    int64_t area = sized ? h->width * h->height : -1;
    assert(area >= -1 && "the product does not overflow");
    if (h->points < 0 && area < 0) {
        return stp_fail(h->import->context, STP_ERROR_FORMAT,
                        "%s: its header has neither POINTS nor WIDTH and HEIGHT", h->import->path);
    }
    pcd->point_count = (uint64_t)(h->points >= 0 ? h->points : area);
    if (h->points >= 0 && area >= 0 && area != h->points) {
        return stp_fail(h->import->context, STP_ERROR_FORMAT,
                        "%s: its header has %lld POINTS, but WIDTH times HEIGHT is %lld",
                        h->import->path, (long long)h->points, (long long)area);
    }
    return STP_OK;
}

stp_result stp_pcd_read_header(stp_import* import, stp_pcd* pcd)
{
    header h = {.import = import, .pcd = pcd, .width = -1, .height = -1, .points = -1};
    stp_text bytes = import->file.bytes;
    size_t size = import->file.size;
    *pcd = (stp_pcd){0};
    bool last = false;
    for (h.line = 0; !last && h.line < LINES_MAX; ++h.line) {
        size_t left = size - pcd->body;
        stp_text at = bytes + pcd->body, end = left > 0 ? memchr(at, '\n', left) : NULL;
        if (end == NULL) {
            return stp_fail(import->context, STP_ERROR_TRUNCATED, "%s: ends in its header",
                            import->path);
        }
        stp_result result = read_line(&h, at, &last);
        if (result != STP_OK) {
            return result;
        }
        pcd->body = (size_t)(end - bytes) + 1;
    }
    assert(pcd->body <= size && (pcd->body == 0 || bytes[pcd->body - 1] == '\n'));
    pcd->body_line = h.line;
    return last ? check_lists(&h)
                : stp_fail(import->context, STP_ERROR_FORMAT,
                           "%s: none of its first %d lines begins with DATA", import->path,
                           LINES_MAX);
}
