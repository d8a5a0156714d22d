// SPDX-License-Identifier: MIT
#include "import/text/text_columns.h"

#include "import/reading/place_sample.h"
#include "import/reading/scan_values.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define HEADER_LINES 100 ///< the first point must be in one of these lines
#define SAMPLES 500      ///< maximum number of sampled lines
#define MIN_LINE 6       ///< bytes of a point and its line end
#define WINDOW 4096      ///< bytes in which a sampled line must begin

typedef enum token_kind { TOKEN_WORD, TOKEN_INTEGER, TOKEN_FRACTION } token_kind;

typedef struct row {
    uint32_t count, numbers;
    double values[STP_COLUMNS_MAX];
    uint8_t kinds[STP_COLUMNS_MAX];
} row;

typedef struct samples {
    row* rows;
    size_t count;
    uint32_t columns;
} samples;

// Column names in header lines.
static const struct {
    const char* name;
    uint8_t column;
} known_names[] = {
    {"x", STP_COLUMN_X},
    {"y", STP_COLUMN_Y},
    {"z", STP_COLUMN_Z},
    {"easting", STP_COLUMN_X},
    {"northing", STP_COLUMN_Y},
    {"height", STP_COLUMN_Z},
    {"elevation", STP_COLUMN_Z},
    {"r", STP_COLUMN_R},
    {"g", STP_COLUMN_G},
    {"b", STP_COLUMN_B},
    {"red", STP_COLUMN_R},
    {"green", STP_COLUMN_G},
    {"blue", STP_COLUMN_B},
    {"rf", STP_COLUMN_R},
    {"gf", STP_COLUMN_G},
    {"bf", STP_COLUMN_B},
    {"i", STP_COLUMN_INTENSITY},
    {"intensity", STP_COLUMN_INTENSITY},
    {"reflectance", STP_COLUMN_INTENSITY},
    {"scalar_intensity", STP_COLUMN_INTENSITY},
    {"nx", STP_COLUMN_NX},
    {"ny", STP_COLUMN_NY},
    {"nz", STP_COLUMN_NZ},
    {"normal_x", STP_COLUMN_NX},
    {"normal_y", STP_COLUMN_NY},
    {"normal_z", STP_COLUMN_NZ},
    {"class", STP_COLUMN_CLASS},
    {"label", STP_COLUMN_CLASS},
    {"classification", STP_COLUMN_CLASS},
    {"scalar_classification", STP_COLUMN_CLASS},
};

// The column of a name; STP_COLUMN_SKIP if the name is unknown.
static uint8_t column_named(stp_text begin, stp_text end)
{
    while (end - begin >= 2 && *begin == '"' && end[-1] == '"') {
        begin += 1;
        end -= 1;
    }
    for (size_t i = 0; i < sizeof(known_names) / sizeof(known_names[0]); ++i) {
        if (stp_word_is(begin, end, known_names[i].name)) {
            return known_names[i].column;
        }
    }
    return STP_COLUMN_SKIP;
}

// Drops columns after the last used one and validates the rest. @return as stp_columns_parse
static const char* check_columns(stp_columns* c)
{
    uint32_t uses[STP_COLUMN_SLOTS + 1] = {0}, all = c->count;
    assert(all <= STP_COLUMNS_MAX);
    while (c->count > 0 && c->roles[c->count - 1] == STP_COLUMN_SKIP) {
        c->count -= 1;
    }
    for (uint32_t i = 0; i < c->count; ++i) {
        uses[c->roles[i]] += 1;
    }
    assert(c->count <= all && "columns are only dropped");
    c->unused = uses[STP_COLUMN_SKIP] + all - c->count;
    for (int i = 0; i < STP_COLUMN_SLOTS; ++i) {
        if (uses[i] > 1) {
            return "a column is named twice";
        }
    }
    if (uses[STP_COLUMN_X] + uses[STP_COLUMN_Y] + uses[STP_COLUMN_Z] != 3) {
        return "x, y and z must be among the columns";
    }
    uint32_t colors = uses[STP_COLUMN_R] + uses[STP_COLUMN_G] + uses[STP_COLUMN_B];
    uint32_t normals = uses[STP_COLUMN_NX] + uses[STP_COLUMN_NY] + uses[STP_COLUMN_NZ];
    return colors % 3 != 0    ? "r, g and b must be given together"
           : normals % 3 != 0 ? "nx, ny and nz must be given together"
                              : NULL;
}

const char* stp_columns_parse(const char* names, stp_columns* columns)
{
    *columns = (stp_columns){0};
    for (const char* at = names;;) {
        size_t length = strcspn(at, ",");
        stp_text begin = (stp_text)at;
        uint8_t column = column_named(begin, begin + length);
        bool skipped = length == 1 && *at == '-';
        if (column == STP_COLUMN_SKIP && !skipped) {
            return "valid columns are x, y, z, r, g, b, intensity, nx, ny, nz, class, and - for "
                   "others";
        }
        if (columns->count == STP_COLUMNS_MAX) {
            return "more than 32 columns";
        }
        columns->roles[columns->count++] = column;
        if (at[length] == '\0') {
            return check_columns(columns);
        }
        at += length + 1;
    }
}

stp_column_ranges stp_column_ranges_empty(void)
{
    stp_column_ranges r;
    for (int i = 0; i < STP_COLUMN_SLOTS; ++i) {
        r.low[i] = (double)INFINITY;
        r.high[i] = -(double)INFINITY;
    }
    return r;
}

static bool is_comment(stp_text at)
{
    return *at == '#' || (at[0] == '/' && at[1] == '/');
}

static stp_text end_of_token(stp_text at)
{
    while (!stp_is_blank(*at) && !stp_separates(*at) && *at != '\n') {
        ++at;
    }
    return at;
}

static void read_row(stp_text at, row* r)
{
    r->count = r->numbers = 0;
    for (at = stp_skip_blanks(at); *at != '\n' && r->count < STP_COLUMNS_MAX;) {
        stp_text end = end_of_token(at);
        double value = 0.0;
        stp_text next = end > at ? stp_read_number(at, &value) : NULL;
        bool number = next == end && next != NULL;
        token_kind kind = number ? TOKEN_INTEGER : TOKEN_WORD;
        for (stp_text c = at; number && c < end; ++c) {
            kind = (*c < '0' || *c > '9') && *c != '-' && *c != '+' ? TOKEN_FRACTION : kind;
        }
        r->values[r->count] = value;
        r->kinds[r->count++] = (uint8_t)kind;
        r->numbers += number;
        at = stp_skip_blanks(end);
        at = stp_separates(*at) ? stp_skip_blanks(at + 1) : at;
    }
    assert(r->numbers <= r->count && r->count <= STP_COLUMNS_MAX);
}

// Reads a line's words as column names. @return whether they are `wanted` valid columns
static bool read_header(stp_text at, uint32_t wanted, stp_columns* columns)
{
    *columns = (stp_columns){0};
    at = stp_skip_blanks(at);
    while (*at == '#' || *at == '/') {
        ++at;
    }
    stp_text line = stp_skip_blanks(at);
    bool separated = false;
    for (at = line; *at != '\n'; ++at) {
        separated = separated || stp_separates(*at);
    }
    for (at = line; *at != '\n' && columns->count < STP_COLUMNS_MAX;) {
        stp_text end = at;
        while (*end != '\n' && (separated ? !stp_separates(*end) : !stp_is_blank(*end))) {
            ++end;
        }
        stp_text last = end;
        while (last > at && stp_is_blank(last[-1])) {
            --last;
        }
        columns->roles[columns->count++] = column_named(at, last);
        at = stp_skip_blanks(end + stp_separates(*end));
    }
    return columns->count == wanted && check_columns(columns) == NULL;
}

static bool all_within(const samples* s, uint32_t column, double low, double high)
{
    assert(column < s->columns);
    for (size_t i = 0; i < s->count; ++i) {
        const row* r = &s->rows[i];
        if (r->kinds[column] == TOKEN_WORD ||
            !(r->values[column] >= low && r->values[column] <= high)) {
            return false;
        }
    }
    return true;
}

static bool any_fraction(const samples* s, uint32_t column, uint32_t count)
{
    assert(column + count <= s->columns);
    for (size_t i = 0; i < s->count * count; ++i) {
        if (s->rows[i / count].kinds[column + i % count] == TOKEN_FRACTION) {
            return true;
        }
    }
    return false;
}

// Whether a column has only whole numbers up to a maximum, as 117 or 117.000.
static bool all_whole(const samples* s, uint32_t column, double maximum)
{
    bool whole = all_within(s, column, 0.0, maximum);
    for (size_t i = 0; i < s->count && whole; ++i) {
        whole = floor(s->rows[i].values[column]) == s->rows[i].values[column];
    }
    return whole;
}

static bool are_colors(const samples* s, uint32_t column, double maximum)
{
    bool whole = true, parts = true, points = any_fraction(s, column, 3);
    maximum = points ? 255.0 : maximum;
    for (uint32_t c = column; c < column + 3; ++c) {
        whole = whole && all_whole(s, c, maximum);
        parts = parts && all_within(s, c, 0.0, 1.0);
    }
    return whole || (parts && points);
}

// Whether columns are unit vectors, some perhaps zero, and not all of them unsigned whole numbers.
static bool are_normals(const samples* s, uint32_t column)
{
    assert(column + 3 <= s->columns);
    bool any = false, negative = false;
    for (size_t i = 0; i < s->count; ++i) {
        const double* n = s->rows[i].values + column;
        double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        if (square != 0.0 && !(fabs(square - 1.0) < 0.02)) {
            return false;
        }
        any = any || square != 0.0;
        negative = negative || n[0] < 0.0 || n[1] < 0.0 || n[2] < 0.0;
    }
    return any && (negative || any_fraction(s, column, 3));
}

static uint32_t free_run(const stp_columns* c, uint32_t begin)
{
    uint32_t length = 0;
    while (begin + length < c->count && c->roles[begin + length] == STP_COLUMN_SKIP) {
        length += 1;
    }
    return length;
}

static void set_triple(stp_columns* c, uint32_t at, uint8_t first)
{
    assert(at + 3 <= c->count && first + 3 <= STP_COLUMN_SLOTS);
    for (uint8_t i = 0; i < 3; ++i) {
        c->roles[at + i] = first + i;
    }
}

static void guess_colors(const samples* s, bool intensity_first, stp_columns* c)
{
    for (uint32_t begin = 3; begin + 3 <= c->count; ++begin) {
        uint32_t length = free_run(c, begin);
        if (length < 3 || !are_colors(s, begin, length == 3 ? 65535.0 : 255.0)) {
            continue;
        }
        bool later = intensity_first && length > 3 && are_colors(s, begin + 1, 255.0);
        set_triple(c, begin + later, STP_COLUMN_R);
        return;
    }
}

// x, y, z, then normals, colours and an intensity, by their values.
static void guess(const samples* s, bool intensity_first, stp_columns* c)
{
    assert(s->columns >= 3 && s->columns <= STP_COLUMNS_MAX && "the first line is a point");
    *c = (stp_columns){.count = s->columns};
    memset(c->roles, STP_COLUMN_SKIP, sizeof(c->roles));
    set_triple(c, 0, STP_COLUMN_X);
    for (uint32_t i = 3; i + 3 <= c->count; ++i) {
        if (are_normals(s, i)) {
            set_triple(c, i, STP_COLUMN_NX);
            break;
        }
    }
    guess_colors(s, intensity_first, c);
    for (uint32_t i = 3; i < c->count; ++i) {
        bool numbers = all_within(s, i, -(double)INFINITY, (double)INFINITY);
        if (c->roles[i] == STP_COLUMN_SKIP && numbers) {
            c->roles[i] = STP_COLUMN_INTENSITY;
            break;
        }
    }
    const char* wrong = check_columns(c);
    assert(wrong == NULL && "x, y and z occur once, the others in triples");
    (void)wrong;
}

// Adds the line to the samples if it has as many columns as the first.
static void take_sample(samples* s, stp_text at)
{
    row* r = &s->rows[s->count];
    if (s->count < SAMPLES && !is_comment(stp_skip_blanks(at))) {
        read_row(at, r);
        s->count += r->count == s->columns && r->numbers >= 3;
    }
}

// Lines from all over the text, at positions that depend on the text alone.
static void take_samples(samples* s, const stp_text_blocks* blocks, size_t first_block,
                         stp_text first)
{
    assert(first_block < blocks->count && s->count <= SAMPLES);
    size_t block_count = blocks->count - first_block;
    size_t each = block_count < SAMPLES ? SAMPLES / block_count : 1;
    size_t step = block_count < SAMPLES ? 1 : (block_count + SAMPLES - 1) / SAMPLES;
    for (size_t i = first_block; i < blocks->count; i += step) {
        const stp_text_block* b = &blocks->blocks[i];
        stp_text begin = i == first_block ? first : b->begin;
        size_t size = (size_t)(b->end - begin);
        size_t places = size / MIN_LINE < each ? size / MIN_LINE + 1 : each;
        for (size_t k = 0; k < places && s->count < SAMPLES; ++k) {
            stp_text at = begin + size / places * k;
            size_t window = (size_t)(b->end - at) < WINDOW ? (size_t)(b->end - at) : WINDOW;
            stp_text found = k > 0 ? memchr(at, '\n', window) : NULL;
            if (k == 0 || (found != NULL && found + 1 < b->end)) {
                take_sample(s, k == 0 ? at : found + 1);
            }
        }
    }
}

typedef struct beginning {
    stp_text at; ///< first line of points; NULL: the file has no points
    uint64_t line, declared;
    size_t block;
    row first;
} beginning;

static void find_beginning(const stp_text_blocks* blocks, beginning* b)
{
    uint64_t lines = blocks->line_count < HEADER_LINES ? blocks->line_count : HEADER_LINES;
    *b = (beginning){0};
    for (b->line = 0; b->line < lines; ++b->line) {
        b->block = stp_text_blocks_find(blocks, b->line);
        stp_text at = stp_text_blocks_line(blocks, b->line);
        if (is_comment(stp_skip_blanks(at))) {
            continue;
        }
        read_row(at, &b->first);
        if (b->first.numbers >= 3) {
            b->at = at;
            return;
        }
        bool count = b->first.count == 1 && b->first.kinds[0] == TOKEN_INTEGER;
        double declared = count ? b->first.values[0] : 0.0;
        b->declared += declared > 0.0 && declared < 1e15 ? (uint64_t)declared : 0;
    }
}

// Whether words have one comma between digits each, as in "1,5;2,5;3" or "1,5 2,5 3".
static bool has_decimal_commas(stp_text at)
{
    uint32_t words = 0, commas = 0;
    for (at = stp_skip_blanks(at); *at != '\n'; ++words) {
        uint32_t own = 0;
        unsigned char before = ' ';
        for (; *at != '\n' && *at != ';' && !stp_is_blank(*at); before = *at++) {
            bool inside = stp_is_digit(before) && stp_is_digit(at[1]);
            if (*at == '.' || (*at == ',' && (!inside || own > 0))) {
                return false;
            }
            own += *at == ',';
        }
        commas += own;
        at = stp_skip_blanks(at);
        at = *at == ';' ? stp_skip_blanks(at + 1) : at;
    }
    return words >= 3 && commas >= 2;
}

// Detects a line of points that would be read wrongly. @return NULL, or the rest of a sentence
static const char* find_misreading(stp_text at)
{
    for (stp_text c = at; *c != '\n'; ++c) {
        if (*c == '\r' && *stp_skip_blanks(c) != '\n') {
            return "contains carriage returns: expected a line feed after each point";
        }
    }
    return has_decimal_commas(at) ? "its numbers have decimal commas: expected decimal points"
                                  : NULL;
}

static void choose_columns(const stp_text_blocks* blocks, const beginning* b, const samples* s,
                           bool intensity_first, stp_columns* columns)
{
    for (uint64_t line = b->line; line > 0; --line) {
        if (read_header(stp_text_blocks_line(blocks, line - 1), s->columns, columns)) {
            return;
        }
    }
    guess(s, intensity_first, columns);
}

static void measure(const samples* s, stp_columns_found* found)
{
    uint32_t place[4] = {0}; // columns of x, y, z, and others
    assert(s->count > 0 && found->columns.count <= s->columns);
    found->ranges = stp_column_ranges_empty();
    for (uint32_t c = 0; c < found->columns.count; ++c) {
        uint8_t role = found->columns.roles[c];
        for (size_t i = 0; i < s->count && role != STP_COLUMN_SKIP; ++i) {
            stp_range_add(s->rows[i].values[c], &found->ranges.low[role],
                          &found->ranges.high[role]);
        }
        bool color = role >= STP_COLUMN_R && role <= STP_COLUMN_B;
        found->color_fractions = found->color_fractions || (color && any_fraction(s, c, 1));
        place[role <= STP_COLUMN_Z ? role : 3] = c;
    }
    stp_place_sample places = {0};
    for (uint32_t i = 0; i < STP_PLACE_SAMPLES; ++i) {
        const double* values = s->rows[stp_place_sample_index(i, s->count)].values;
        stp_place_sample_add(&places,
                             (double[3]){values[place[0]], values[place[1]], values[place[2]]});
    }
    stp_place_sample_choose(&places, found->place);
}

stp_result stp_columns_find(stp_import* import, const stp_text_blocks* blocks, bool intensity_first,
                            stp_columns_found* found)
{
    stp_context* context = import->context;
    const char* named = import->desc.columns;
    beginning b;
    *found = (stp_columns_found){0};
    find_beginning(blocks, &b);
    if (b.at == NULL) {
        return stp_fail(context, STP_ERROR_FORMAT,
                        "%s: none of its first %d lines contains a point (three numbers or more)",
                        import->path, HEADER_LINES);
    }
    const char* misread = find_misreading(b.at);
    if (misread != NULL) {
        return stp_fail(context, STP_ERROR_FORMAT, "%s: line %llu: %s", import->path,
                        (unsigned long long)b.line + 1, misread);
    }
    const char* wrong = named != NULL ? stp_columns_parse(named, &found->columns) : NULL;
    if (wrong != NULL) {
        return stp_fail(context, STP_ERROR_FORMAT, "columns %s: %s", named, wrong);
    }
    samples s = {.rows = STP_NEW_ARRAY(context, row, SAMPLES + 1), .columns = b.first.count};
    if (s.rows == NULL) {
        return stp_fail_memory(context);
    }
    s.rows[0] = b.first;
    s.count = 1;
    take_samples(&s, blocks, b.block, b.at);
    stp_result result = STP_OK;
    if (named == NULL) {
        choose_columns(blocks, &b, &s, intensity_first, &found->columns);
    } else if (found->columns.count > s.columns) {
        result =
            stp_fail(context, STP_ERROR_FORMAT, "%s: line %llu: has %u columns, not %u",
                     import->path, (unsigned long long)b.line + 1, s.columns, found->columns.count);
    }
    if (result == STP_OK) {
        found->first_line = b.line;
        found->declared = b.declared;
        measure(&s, found);
    }
    stp_free(context, s.rows);
    return result;
}
