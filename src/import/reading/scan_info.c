// SPDX-License-Identifier: MIT
#include "import/reading/scan_info.h"

#include "import/reading/text.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DEPTH = 32 };

stp_scan_field* stp_scan_add_field(stp_scan_info* info, const char* name, size_t name_size,
                                   const char* type, bool kept)
{
    assert(info->field_count <= STP_SCAN_FIELDS && name_size > 0);
    if (info->field_count == STP_SCAN_FIELDS) {
        info->unnamed += 1;
        return NULL;
    }
    stp_scan_field* f = &info->fields[info->field_count++];
    *f = (stp_scan_field){.type = type, .count = 1, .kept = kept};
    size_t length = strnlen(name, name_size < STP_SCAN_NAME ? name_size : STP_SCAN_NAME - 1);
    memcpy(f->name, name, length);
    return f;
}

// Whether a WKT keyword is a coordinate system that can represent the whole.
static bool is_system(stp_text at, stp_text end)
{
    static const char* const words[] = {
        "projcs",   "projcrs",     "projectedcrs", "geogcs",   "geogcrs", "geographiccrs",
        "geodcrs",  "geoccs",      "geodeticcrs",  "local_cs", "engcrs",  "engineeringcrs",
        "compd_cs", "compoundcrs", "boundcrs",     "sourcecrs"};
    for (size_t i = 0; i < sizeof(words) / sizeof(words[0]); ++i) {
        if (stp_word_is(at, end, words[i])) {
            return true;
        }
    }
    return false;
}

static void copy_quoted(const char* quote, char* to, size_t size)
{
    assert(*quote == '"' && size > 0);
    size_t length = strcspn(quote + 1, "\"");
    length = length < size ? length : size - 1;
    memcpy(to, quote + 1, length);
    to[length] = '\0';
}

// The code in AUTHORITY["EPSG","32610"] or ID["EPSG",32610], starting at its bracket; 0: none.
static uint32_t read_code(const char* bracket)
{
    static const char owner[] = "\"EPSG\"";
    assert(*bracket == '[' || *bracket == '(');
    const char* at = bracket + 1 + strspn(bracket + 1, " \t\r\n");
    if (strncmp(at, owner, sizeof(owner) - 1) != 0) {
        return 0;
    }
    at += sizeof(owner) - 1;
    at += strspn(at, " \t\r\n,\"");
    unsigned long code = strtoul(at, NULL, 10);
    return code <= 999999 ? (uint32_t)code : 0;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

static bool is_compound(stp_text at, stp_text end)
{
    return stp_word_is(at, end, "compd_cs") || stp_word_is(at, end, "compoundcrs") ||
           stp_word_is(at, end, "boundcrs") || stp_word_is(at, end, "sourcecrs");
}

typedef struct wkt_scan {
    bool systems[MAX_DEPTH], compounds[MAX_DEPTH]; ///< kinds of the open words, by depth
    int depth, best; ///< number of open words; depth of the code that was found
} wkt_scan;

// Uses a system's own code, or for a compound system without a code that of its first part. Codes
// of its components (datums, units, the base geographic system) are nested deeper, or below
// keywords that are not systems.
static void open_word(wkt_scan* s, stp_text word, stp_text end, const char* bracket,
                      stp_system_identity* found)
{
    int depth = s->depth;
    assert(depth >= 0 && depth < MAX_DEPTH && s->best <= MAX_DEPTH);
    bool code = stp_word_is(word, end, "authority") || stp_word_is(word, end, "id");
    bool counts = code && depth > 0 && s->systems[depth - 1] && depth < s->best;
    uint32_t number = counts ? read_code(bracket) : 0;
    if (number != 0) {
        found->epsg = number;
        s->best = depth;
    }
    s->systems[depth] = is_system(word, end) && (depth == 0 || s->compounds[depth - 1]);
    s->compounds[depth] = s->systems[depth] && is_compound(word, end);
    s->depth += 1;
}

static void identify_wkt(const char* text, stp_system_identity* found)
{
    wkt_scan s = {.best = MAX_DEPTH};
    const char *word = text, *end = text;
    for (const char* at = text; *at != '\0' && s.depth < MAX_DEPTH; ++at) {
        if (is_letter(*at)) {
            word = at;
            at += strspn(at, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") - 1;
            end = at + 1;
        } else if (*at == '"') {
            if (found->name[0] == '\0') {
                copy_quoted(at, found->name, sizeof(found->name));
            }
            at += 1 + strcspn(at + 1, "\"");
            if (*at == '\0') {
                return;
            }
        } else if (*at == '[' || *at == '(') {
            open_word(&s, (stp_text)word, (stp_text)end, at, found);
            word = end = at;
        } else if (*at == ']' || *at == ')') {
            s.depth -= s.depth > 0;
        }
    }
}

stp_system_identity stp_system_identify(const char* text)
{
    stp_system_identity found = {.epsg = 0};
    if (text == NULL) {
        return found;
    }
    if (strncmp(text, "EPSG:", 5) == 0) {
        unsigned long code = strtoul(text + 5, NULL, 10);
        found.epsg = code <= 999999 ? (uint32_t)code : 0;
        return found;
    }
    identify_wkt(text, &found);
    return found;
}
