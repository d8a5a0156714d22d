// SPDX-License-Identifier: MIT
#include "base/core/printable.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// Decodes the UTF-8 character at `text`; overlong forms are invalid. @return its bytes; 0 if
// invalid
static size_t read_character(const unsigned char* text, uint32_t* code)
{
    static const uint32_t minimum[5] = {0, 0, 0x80, 0x800, 0x10000};
    size_t length = text[0] < 0x80   ? 1
                    : text[0] < 0xC0 ? 0
                    : text[0] < 0xE0 ? 2
                    : text[0] < 0xF0 ? 3
                    : text[0] < 0xF8 ? 4
                                     : 0;
    *code = length <= 1 ? text[0] : text[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; ++i) {
        if ((text[i] & 0xC0) != 0x80) {
            return 0;
        }
        *code = *code << 6 | (text[i] & 0x3F);
    }
    bool valid = length != 0 && *code >= minimum[length] && *code <= 0x10FFFF &&
                 !(*code >= 0xD800 && *code < 0xE000);
    return valid ? length : 0;
}

static bool is_shown(uint32_t code)
{
    bool turns = code == 0x200E || code == 0x200F || (code >= 0x2028 && code <= 0x202E) ||
                 (code >= 0x2066 && code <= 0x2069) || code == 0x061C;
    return code >= 0x20 && !(code >= 0x7F && code < 0xA0) && !turns;
}

size_t stp_make_printable(const char* text, char* out, size_t size)
{
    static const char digits[] = "0123456789abcdef";
    const unsigned char* from = (const unsigned char*)text;
    size_t used = 0;
    while (*from != 0 && size > 0) {
        uint32_t code;
        size_t length = read_character(from, &code);
        bool shown = length != 0 && is_shown(code);
        length = length != 0 ? length : 1;
        size_t needed = shown ? length : 4 * length;
        if (needed >= size - used) {
            break;
        }
        for (size_t i = 0; i < length; ++i) {
            if (shown) {
                out[used++] = (char)from[i];
                continue;
            }
            const char escape[4] = {'\\', 'x', digits[from[i] >> 4], digits[from[i] & 15]};
            memcpy(out + used, escape, sizeof(escape));
            used += sizeof(escape);
        }
        from += length;
    }
    assert((size == 0 || used < size) && "room for the final zero");
    if (size > 0) {
        out[used] = 0;
    }
    return used;
}

size_t stp_find_unprintable(const char* text, size_t size, uint32_t* code, size_t* length)
{
    size_t at = 0;
    while (at < size) {
        unsigned char next[5] = {0};
        memcpy(next, text + at, size - at < 4 ? size - at : 4);
        *length = read_character(next, code);
        if (*length != 0 && *code >= 0x7F && !is_shown(*code)) {
            return at;
        }
        at += *length != 0 ? *length : 1;
    }
    return size;
}

size_t stp_utf8_whole(const char* text, size_t length)
{
    size_t begin = length; // first continuation byte of the last character
    while (begin > 0 && length - begin < 3 && ((unsigned char)text[begin - 1] & 0xC0) == 0x80) {
        begin -= 1;
    }
    if (begin == 0) {
        return length;
    }
    unsigned char first = (unsigned char)text[begin - 1];
    size_t whole = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 1;
    assert(begin <= length && length - begin <= 3);
    return length - begin + 1 < whole ? begin - 1 : length;
}
