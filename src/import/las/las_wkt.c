// SPDX-License-Identifier: MIT
// Units in well-known text (WKT 1 and 2): nested KEYWORD["name", ..., KEYWORD[...]]. A unit counts
// only directly in a projected or vertical system, or in one of its axes.
#include "import/las/las.h"
#include "import/reading/text.h"

#include <assert.h>
#include <string.h>

enum { MAX_DEPTH = 32 };

typedef enum word_kind {
    OTHER,
    AXIS,
    UNIT,
    HORIZONTAL,
    VERTICAL,
    GEOGRAPHIC,
    GEODETIC,   ///< geographic, unless its axes are Cartesian
    GEOCENTRIC, ///< Cartesian axes from the centre of the Earth
    COMPOUND
} word_kind;

static word_kind kind_of_word(stp_text at, stp_text end)
{
    static const struct {
        const char* word;
        word_kind kind;
    } words[] = {
        {"axis", AXIS},
        {"unit", UNIT},
        {"lengthunit", UNIT},
        {"projcs", HORIZONTAL},
        {"projcrs", HORIZONTAL},
        {"projectedcrs", HORIZONTAL},
        {"local_cs", HORIZONTAL},
        {"engcrs", HORIZONTAL},
        {"engineeringcrs", HORIZONTAL},
        {"geoccs", GEOCENTRIC},
        {"vert_cs", VERTICAL},
        {"vertcs", VERTICAL},
        {"vertcrs", VERTICAL},
        {"verticalcrs", VERTICAL},
        {"geogcs", GEOGRAPHIC},
        {"geogcrs", GEOGRAPHIC},
        {"geographiccrs", GEOGRAPHIC},
        {"geodcrs", GEODETIC},
        {"geodeticcrs", GEODETIC},
        {"compd_cs", COMPOUND},
        {"compoundcrs", COMPOUND},
        {"boundcrs", COMPOUND},
        {"sourcecrs", COMPOUND},
    };
    for (size_t i = 0; i < sizeof(words) / sizeof(words[0]); ++i) {
        if (stp_word_is(at, end, words[i].word)) {
            return words[i].kind;
        }
    }
    return OTHER;
}

static bool is_letter(unsigned char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

// The end of a quoted text; a quote in it is doubled, which reads as two texts here.
static stp_text skip_quoted(stp_text at, stp_text end)
{
    assert(at < end && *at == '"');
    for (at += 1; at < end && *at != '"'; ++at) {
    }
    return at < end ? at + 1 : end;
}

static bool contains(stp_text at, stp_text end, const char* word)
{
    for (size_t length = strlen(word); (size_t)(end - at) >= length; ++at) {
        if (stp_word_is(at, at + length, word)) {
            return true;
        }
    }
    return false;
}

// Metres of a foot by its name; 1 for other units.
static double foot_named(stp_text at, stp_text end)
{
    bool foot = contains(at, end, "foot") || contains(at, end, "feet") || contains(at, end, "ft");
    return !foot ? 1.0 : contains(at, end, "us") ? 1200.0 / 3937.0 : 0.3048;
}

// "name", factor. Some files give feet the factor 1; then the name is right.
static double read_factor(stp_text at, stp_text end)
{
    double value;
    while (at < end && *at != '"') {
        at += 1;
    }
    stp_text name = at;
    at = at < end ? skip_quoted(at, end) : end;
    double named = foot_named(name, at);
    while (at < end && (stp_is_blank(*at) || *at == ',' || *at == '\n')) {
        at += 1;
    }
    bool good = at < end && stp_read_number(at, &value) != NULL;
    value = good && value == 1.0 ? named : good ? value : 0.0;
    return value > 1e-6 && value < 1e6 ? value : 0.0;
}

typedef struct scanner {
    word_kind stack[MAX_DEPTH];
    int depth;
    bool cartesian, geodetic, geocentric;
    double length; ///< the unit of a geodetic or geocentric system
    stp_las_units units;
} scanner;

static void open_word(scanner* s, word_kind kind, stp_text at, stp_text end)
{
    assert(s->depth >= 0 && s->depth < MAX_DEPTH);
    word_kind parent = s->depth > 0 ? s->stack[s->depth - 1] : COMPOUND;
    word_kind owner = parent == AXIS && s->depth > 1 ? s->stack[s->depth - 2] : parent;
    if (kind == UNIT && owner == HORIZONTAL) {
        s->units.horizontal = read_factor(at, end);
    } else if (kind == UNIT && owner == VERTICAL) {
        s->units.vertical = read_factor(at, end);
    } else if (kind == UNIT && (owner == GEODETIC || owner == GEOCENTRIC)) {
        s->length = read_factor(at, end);
    }
    s->geocentric = s->geocentric || (kind == GEOCENTRIC && parent == COMPOUND);
    s->units.geographic = s->units.geographic || (kind == GEOGRAPHIC && parent == COMPOUND);
    s->geodetic = s->geodetic || (kind == GEODETIC && parent == COMPOUND);
    s->stack[s->depth++] = kind;
}

stp_las_units stp_las_wkt_units(const char* text, size_t size)
{
    scanner s = {.depth = 0};
    stp_text at = (stp_text)text, end = at + size, word = at;
    while (at < end) {
        if (*at == '"') {
            at = skip_quoted(at, end);
            word = at;
        } else if (is_letter(*at)) {
            for (word = at; at < end && is_letter(*at); ++at) {
            }
            s.cartesian = s.cartesian || stp_word_is(word, at, "cartesian");
        } else if (*at == '[' || *at == '(') {
            if (s.depth == MAX_DEPTH) {
                break;
            }
            open_word(&s, kind_of_word(word, at), at, end);
            at += 1;
            word = at;
        } else {
            s.depth -= (*at == ']' || *at == ')') && s.depth > 0;
            at += 1;
            word = at;
        }
    }
    s.units.geographic = s.units.geographic || (s.geodetic && !s.cartesian);
    if ((s.geocentric || (s.geodetic && s.cartesian)) && s.units.horizontal == 0.0) {
        s.units.horizontal = s.length > 0.0 ? s.length : 1.0;
    }
    return s.units;
}
