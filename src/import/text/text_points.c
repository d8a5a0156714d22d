// SPDX-License-Identifier: MIT
#include "import/text/text_points.h"

#include "base/core/atomic_limits.h"
#include "import/reading/scan_values.h"
#include "import/text/text_scan.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define RELEASE_EVERY 32 ///< pairs of blocks, after which pages are released

typedef enum line_kind { LINE_POINT, LINE_EMPTY, LINE_COUNT, LINE_BAD } line_kind;

// Scale of colours and intensities.
typedef struct scales {
    double color; ///< the value that is white
    stp_intensity_range intensity;
} scales;

typedef struct reading {
    stp_text_points* points;
    scales scales;
    double color_factor, intensity_factor; ///< to 255ths, to 65535ths
    size_t first_block, end_block;
    stp_column_ranges* ranges; ///< a worker each
    atomic_uint_fast64_t declared, count_lines, lines, not_finite;
    atomic_uint_fast64_t first_bad; ///< the first line that cannot be read
    atomic_uint_fast64_t last_full; ///< the last line that is not blank
} reading;

stp_point_columns_desc stp_text_points_wants(const stp_columns* columns)
{
    bool intensity = stp_columns_have(columns, STP_COLUMN_INTENSITY);
    bool class = stp_columns_have(columns, STP_COLUMN_CLASS);
    return (stp_point_columns_desc){.normals = stp_columns_have(columns, STP_COLUMN_NX),
                                    .colors = stp_columns_have(columns, STP_COLUMN_R),
                                    .attributes = (uint32_t)intensity << STP_ATTRIBUTE_INTENSITY |
                                                  (uint32_t) class << STP_ATTRIBUTE_CLASS};
}

static scales choose_scales(const stp_column_ranges* r, bool color_fractions)
{
    double bright = fmax(fmax(r->high[STP_COLUMN_R], r->high[STP_COLUMN_G]), r->high[STP_COLUMN_B]);
    return (scales){.color = stp_color_white(bright, color_fractions),
                    .intensity = stp_intensity_find_range(r->low[STP_COLUMN_INTENSITY],
                                                          r->high[STP_COLUMN_INTENSITY])};
}

static inline void widen(stp_column_ranges* r, int column, double value)
{
    stp_range_add(value, &r->low[column], &r->high[column]);
}

// Columns other than the position.
static inline void fill_columns(const reading* r, size_t cell, const double* v,
                                stp_column_ranges* ranges)
{
    const stp_point_set* set = &r->points->cloud->set;
    if (set->colors != NULL) {
        uint8_t* color = set->colors + 4 * cell;
        for (int i = 0; i < 3; ++i) {
            color[i] = (uint8_t)stp_quantize(v[STP_COLUMN_R + i] * r->color_factor, 255.0);
            widen(ranges, STP_COLUMN_R + i, v[STP_COLUMN_R + i]);
        }
        color[3] = 255;
    }
    uint16_t* intensities = set->attributes[STP_ATTRIBUTE_INTENSITY];
    if (intensities != NULL) {
        double above = v[STP_COLUMN_INTENSITY] - r->scales.intensity.low;
        intensities[cell] = (uint16_t)stp_quantize(above * r->intensity_factor, 65535.0);
        widen(ranges, STP_COLUMN_INTENSITY, v[STP_COLUMN_INTENSITY]);
    }
    if (set->normals != NULL) {
        stp_vec3 n = stp_normalize(
            (stp_vec3){(float)v[STP_COLUMN_NX], (float)v[STP_COLUMN_NY], (float)v[STP_COLUMN_NZ]});
        n = stp_is_finite(n) ? n : (stp_vec3){0};
        memcpy(set->normals + 3 * cell, &n, sizeof(n));
    }
    uint8_t* classes = set->attributes[STP_ATTRIBUTE_CLASS];
    if (classes != NULL) {
        classes[cell] = (uint8_t)stp_quantize(v[STP_COLUMN_CLASS], 255.0);
    }
}

static inline bool ends_value(unsigned char c)
{
    const uint64_t ends = UINT64_C(1) << ' ' | UINT64_C(1) << '\t' | UINT64_C(1) << '\r' |
                          UINT64_C(1) << '\v' | UINT64_C(1) << '\f' | UINT64_C(1) << '\n' |
                          UINT64_C(1) << ',' | UINT64_C(1) << ';';
    return c < 64 && (ends >> c & 1) != 0;
}

// From the end of a value to the next one; most files have a single blank or separator between.
static inline stp_text next_value(stp_text at)
{
    bool single = *at == ' ' ? !stp_separates(at[1]) : stp_separates(*at);
    if (single && at[1] > ' ') {
        return at + 1;
    }
    at = stp_skip_blanks(at);
    return stp_separates(*at) ? stp_skip_blanks(at + 1) : at;
}

static inline stp_text skip_value(stp_text at)
{
    while (!ends_value(*at)) {
        ++at;
    }
    return at;
}

// Reads a column of a line. @return what follows it, or NULL
static inline __attribute__((always_inline)) stp_text
read_value(const stp_columns* columns, uint32_t column, stp_text at, double* values)
{
    at = column > 0 ? next_value(at) : stp_skip_blanks(at);
    uint8_t role = columns->roles[column];
    if (role == STP_COLUMN_SKIP) {
        return skip_value(at);
    }
    assert(role < STP_COLUMN_SLOTS);
    at = *at != '\n' ? stp_scan_number(at, &values[role]) : NULL;
    return at != NULL && ends_value(*at) ? at : NULL;
}

// Reads the columns of a line. @return the rest of the text, or NULL
static stp_text read_values(const stp_columns* columns, stp_text at, double* values)
{
    for (uint32_t i = 0; i < columns->count && at != NULL; ++i) {
        at = read_value(columns, i, at, values);
    }
    return at;
}

// The same for two lines in turn: where a value ends depends on all before it, so the processor
// would wait for each, but has the other line's value to work on.
static inline void read_two(const stp_columns* columns, const stp_text at[2],
                            double values[2][STP_COLUMN_SLOTS], stp_text rest[2])
{
    stp_text first = at[0], second = at[1];
    for (uint32_t i = 0; i < columns->count; ++i) {
        first = read_value(columns, i, first, values[0]);
        second = read_value(columns, i, second, values[1]);
        if (first == NULL || second == NULL) {
            first = read_values(columns, at[0], values[0]);
            second = read_values(columns, at[1], values[1]);
            break;
        }
    }
    rest[0] = first;
    rest[1] = second;
}

// The kind of a line without a point.
static line_kind classify_line(stp_text at, uint64_t* count)
{
    int64_t value;
    at = stp_skip_blanks(at);
    if (*at == '\n' || *at == '#' || (at[0] == '/' && at[1] == '/')) {
        return LINE_EMPTY;
    }
    stp_text end = stp_read_integer(at, &value);
    if (end == NULL || *stp_skip_blanks(end) != '\n' || value < 0) {
        return LINE_BAD;
    }
    *count = (uint64_t)value;
    return LINE_COUNT;
}

// A block's contribution to the totals.
typedef struct line_counts {
    uint64_t lines, not_finite, last_full, first_bad;
} line_counts;

static void read_other_line(reading* r, stp_text at, uint64_t line, line_counts* t)
{
    const stp_text_points* p = r->points;
    uint64_t count = 0;
    line_kind kind = classify_line(at, &count);
    stp_cloud_leave_empty(p->cloud, (size_t)(line - p->first_line));
    if (kind == LINE_COUNT && !p->strict) {
        atomic_fetch_add(&r->declared, count);
        atomic_fetch_add(&r->count_lines, 1);
    } else if ((kind != LINE_EMPTY || p->strict) && line < t->first_bad) {
        t->first_bad = line;
    }
    t->last_full = *stp_skip_blanks(at) != '\n' ? line : t->last_full;
}

static void merge_ranges(stp_column_ranges* all, const stp_column_ranges* more)
{
    for (int c = 0; c < STP_COLUMN_SLOTS; ++c) {
        all->low[c] = fmin(all->low[c], more->low[c]);
        all->high[c] = fmax(all->high[c], more->high[c]);
    }
}

// The lines of a block that are left.
typedef struct cursor {
    stp_text at, end;
    uint64_t line, end_line;
    line_counts counts;
} cursor;

static cursor begin_block(const reading* r, const stp_text_block* b)
{
    const stp_text_points* p = r->points;
    cursor c = {.at = b->begin,
                .end = b->end,
                .line = b->first_line,
                .end_line = p->first_line + p->cloud->set.point_count,
                .counts = {.first_bad = UINT64_MAX}};
    assert(c.at < c.end);
    if (c.line < p->first_line && p->first_at != NULL) {
        assert(p->first_at > b->begin && p->first_at < b->end);
        c.at = p->first_at;
        c.line = p->first_line;
    }
    for (; c.line < p->first_line; ++c.line) {
        c.at = stp_next_line(c.at);
    }
    assert(c.at < c.end && c.line < p->blocks->line_count && "the block has a line to read");
    return c;
}

static inline bool has_line(const cursor* c)
{
    return c->at < c->end && c->line < c->end_line;
}

// Stores the values read from the cursor's line. `rest` is behind its columns, or NULL.
static inline void take_line(reading* r, cursor* c, stp_text rest, const double* v,
                             stp_column_ranges* ranges)
{
    const stp_text_points* p = r->points;
    size_t cell = (size_t)(c->line - p->first_line);
    assert(c->line >= p->first_line && cell < p->cloud->set.point_count);
    if (rest == NULL) {
        read_other_line(r, c->at, c->line, &c->counts);
        c->at = stp_next_line(c->at);
        c->line += 1;
        return;
    }
    c->counts.last_full = c->line;
    if (p->zero_is_empty && v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0) {
        stp_cloud_leave_empty(p->cloud, cell);
    } else if (stp_cloud_place(p->cloud, cell, v)) {
        fill_columns(r, cell, v, ranges);
        c->counts.lines += 1;
    } else {
        c->counts.lines += 1;
        c->counts.not_finite += 1;
    }
    c->at = stp_next_line(rest);
    c->line += 1;
}

static void finish_block(reading* r, cursor* c, stp_column_ranges* ranges)
{
    while (has_line(c)) {
        double v[STP_COLUMN_SLOTS];
        stp_text rest = read_values(&r->points->columns, c->at, v);
        take_line(r, c, rest, v, ranges);
    }
    atomic_fetch_add(&r->lines, c->counts.lines);
    atomic_fetch_add(&r->not_finite, c->counts.not_finite);
    stp_atomic_min(&r->first_bad, c->counts.first_bad);
    stp_atomic_max(&r->last_full, c->counts.last_full);
}

static void read_two_blocks(reading* r, const stp_text_block blocks[2], stp_column_ranges* all)
{
    stp_column_ranges ranges = *all;
    cursor first = begin_block(r, &blocks[0]), second = begin_block(r, &blocks[1]);
    while (has_line(&first) && has_line(&second)) {
        double v[2][STP_COLUMN_SLOTS];
        const stp_text at[2] = {first.at, second.at};
        stp_text rest[2];
        read_two(&r->points->columns, at, v, rest);
        take_line(r, &first, rest[0], v[0], &ranges);
        take_line(r, &second, rest[1], v[1], &ranges);
    }
    finish_block(r, &first, &ranges);
    finish_block(r, &second, &ranges);
    *all = ranges;
}

static void read_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    reading* r = user;
    for (size_t i = begin; i < end; ++i) {
        size_t block = r->first_block + 2 * i;
        if (i % RELEASE_EVERY == RELEASE_EVERY - 1) {
            stp_point_columns_release(r->points->cloud->import, &r->points->cloud->set);
        }
        if (block + 1 < r->end_block) {
            read_two_blocks(r, &r->points->blocks->blocks[block], &r->ranges[worker]);
        } else {
            cursor last = begin_block(r, &r->points->blocks->blocks[block]);
            finish_block(r, &last, &r->ranges[worker]);
        }
        stp_progress_add(r->points->cloud->import->context, block + 1 < r->end_block ? 2 : 1);
    }
}

static stp_result read_once(reading* r, stp_column_ranges* all)
{
    const stp_text_points* p = r->points;
    stp_context* context = p->cloud->import->context;
    uint32_t workers = stp_context_thread_count(context);
    uint64_t last_line = p->first_line + p->cloud->set.point_count - 1;
    assert(last_line < p->blocks->line_count && "there is a line for each cell");
    r->end_block = stp_text_blocks_find(p->blocks, last_line) + 1;
    for (uint32_t i = 0; i < workers; ++i) {
        r->ranges[i] = stp_column_ranges_empty();
    }
    r->color_factor = 255.0 / r->scales.color;
    r->intensity_factor = stp_intensity_factor(r->scales.intensity);
    atomic_init(&r->declared, 0);
    atomic_init(&r->count_lines, 0);
    atomic_init(&r->lines, 0);
    atomic_init(&r->not_finite, 0);
    atomic_init(&r->last_full, 0);
    atomic_init(&r->first_bad, UINT64_MAX);
    r->first_block = stp_text_blocks_find(p->blocks, p->first_line);
    size_t blocks = r->end_block - r->first_block;
    assert(r->first_block < r->end_block && r->end_block <= p->blocks->count);
    stp_loop_report report = {.stage = "import", .unit = "blocks", .total = blocks};
    stp_result result =
        stp_parallel_for_reported(context, (blocks + 1) / 2, 1, read_blocks, r, &report);
    *all = stp_column_ranges_empty();
    for (uint32_t i = 0; i < workers; ++i) {
        merge_ranges(all, &r->ranges[i]);
    }
    return result;
}

// An invalid line in the middle is an error; the last one may be truncated.
static stp_result report_bad_line(const reading* r)
{
    const stp_text_points* p = r->points;
    stp_import* import = p->cloud->import;
    uint64_t bad = atomic_load(&r->first_bad);
    if (bad == UINT64_MAX) {
        return STP_OK;
    }
    if (bad == atomic_load(&r->last_full) && !p->strict && bad > p->first_line) {
        stp_losses_add(&import->losses, STP_LOSS_UNFINISHED_LINE, 1);
        return STP_OK;
    }
    return stp_fail(import->context, STP_ERROR_FORMAT,
                    "%s: line %llu: is not a point: expected numbers in its first %u columns",
                    import->path, (unsigned long long)bad + 1, p->columns.count);
}

stp_result stp_text_points_read(stp_text_points* p)
{
    stp_context* context = p->cloud->import->context;
    if (p->cloud->set.point_count == 0) {
        return STP_OK;
    }
    assert(p->columns.count >= 3 && p->columns.count <= STP_COLUMNS_MAX);
    reading r = {.points = p};
    r.ranges = STP_NEW_ARRAY(context, stp_column_ranges, stp_context_thread_count(context));
    if (r.ranges == NULL) {
        return stp_fail_memory(context);
    }
    stp_column_ranges all;
    r.scales = choose_scales(&p->ranges, p->color_fractions);
    stp_result result = read_once(&r, &all);
    scales right = choose_scales(&all, p->color_fractions);
    if (result == STP_OK &&
        (right.color != r.scales.color || right.intensity.low != r.scales.intensity.low ||
         right.intensity.high != r.scales.intensity.high)) {
        r.scales = right;
        result = read_once(&r, &all);
    }
    stp_free(context, r.ranges);
    if (result != STP_OK) {
        return result;
    }
    p->ranges = all;
    p->declared += atomic_load(&r.declared);
    p->count_lines += atomic_load(&r.count_lines);
    p->lines = atomic_load(&r.lines);
    p->not_finite = atomic_load(&r.not_finite);
    assert(p->not_finite <= p->lines && p->lines <= p->cloud->set.point_count);
    stp_losses_add(&p->cloud->import->losses, STP_LOSS_POINT, p->not_finite);
    return report_bad_line(&r);
}
