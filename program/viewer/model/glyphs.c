// SPDX-License-Identifier: MIT
#include "program/viewer/model/glyphs.h"

#include <assert.h>
#include <string.h>

const uint16_t glyphs_always[] = {0x20,   0x17F,  0x370,  0x3FF,  0x400,  0x52F,  0x2010, 0x2030,
                                  0x20AC, 0x20AC, 0x2190, 0x21FF, 0x25A0, 0x25FF, 0};

static bool is_always(uint32_t point)
{
    for (const uint16_t* range = glyphs_always; *range != 0; range += 2) {
        if (point >= range[0] && point <= range[1]) {
            return true;
        }
    }
    return point < 0x20;
}

/// The code point at `text` and its length; 0 if it is invalid.
static uint32_t read_point(const unsigned char* text, size_t* length)
{
    static const uint32_t minimum[] = {0, 0, 0x80, 0x800, 0x10000};
    unsigned char c = text[0];
    size_t n = c < 0x80 ? 1 : c >= 0xF0 ? 4 : c >= 0xE0 ? 3 : c >= 0xC0 ? 2 : 0;
    *length = 1;
    if (n <= 1 || c >= 0xF8) {
        return n == 1 && c < 0x80 ? c : 0;
    }
    uint32_t point = c & (0xFFu >> (n + 1));
    for (size_t i = 1; i < n; ++i) {
        if ((text[i] & 0xC0) != 0x80) { // also at the end of the text
            return 0;
        }
        point = point << 6 | (text[i] & 0x3Fu);
    }
    *length = n;
    bool half = point >= 0xD800 && point <= 0xDFFF;
    return point < minimum[n] || half ? 0 : point;
}

static bool add(glyph_set* set, uint16_t point)
{
    size_t at = set->count;
    while (at > 0 && set->points[at - 1] >= point) {
        at -= 1;
    }
    if ((at < set->count && set->points[at] == point) || set->count == GLYPHS_MAX) {
        return false;
    }
    memmove(set->points + at + 1, set->points + at, (set->count - at) * sizeof(set->points[0]));
    set->points[at] = point;
    set->count += 1;
    return true;
}

bool glyphs_note(glyph_set* set, const char* text)
{
    const unsigned char* at = (const unsigned char*)text;
    bool any = false;
    while (*at != 0) {
        size_t length;
        uint32_t point = read_point(at, &length);
        if (point >= 0x80 && point < 0xFFFE && !is_always(point)) {
            any = add(set, (uint16_t)point) || any;
        }
        at += length;
    }
    return any;
}

const uint16_t* glyphs_make_ranges(glyph_set* set)
{
    size_t n = 0;
    for (size_t i = 0; i < set->count; ++i) {
        assert((i == 0 || set->points[i - 1] < set->points[i]) && "ascending, each once");
        if (n > 0 && set->ranges[n - 1] + 1 == set->points[i]) {
            set->ranges[n - 1] = set->points[i];
        } else {
            set->ranges[n++] = set->points[i];
            set->ranges[n++] = set->points[i];
        }
    }
    set->ranges[n] = 0;
    return set->ranges;
}
