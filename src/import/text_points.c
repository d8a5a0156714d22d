// SPDX-License-Identifier: MIT
#include "import/text_points.h"

#include "import/intensity.h"
#include "import/text_scan.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define RELEASE_EVERY 64 ///< blocks, after which pages are released

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
    size_t first_block;
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
    bool fractions = bright <= 1.0 && color_fractions;
    return (scales){.color = bright > 255.0 ? 65535.0
                             : fractions    ? 1.0
                                            : 255.0,
                    .intensity = stp_intensity_find_range(r->low[STP_COLUMN_INTENSITY],
                                                          r->high[STP_COLUMN_INTENSITY])};
}

static inline void widen(stp_column_ranges* r, int column, double value)
{
    r->low[column] = value < r->low[column] ? value : r->low[column];
    r->high[column] = value > r->high[column] ? value : r->high[column];
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
    return stp_is_blank(c) || c == '\n' || stp_separates(c);
}

static inline stp_text skip_value(stp_text at)
{
    while (!ends_value(*at)) {
        ++at;
    }
    return at;
}

// Reads the columns of a line. @return the rest of the text, or NULL
static inline stp_text read_values(const stp_columns* columns, stp_text at, double* values)
{
    for (uint32_t i = 0; i < columns->count; ++i) {
        at = stp_skip_blanks(at);
        if (i > 0 && stp_separates(*at)) {
            at = stp_skip_blanks(at + 1);
        }
        uint8_t role = columns->roles[i];
        if (role == STP_COLUMN_SKIP) {
            at = skip_value(at);
            continue;
        }
        at = *at != '\n' ? stp_scan_number(at, &values[role]) : NULL;
        if (at == NULL || !ends_value(*at)) {
            return NULL;
        }
    }
    return at;
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

static void lower_to(atomic_uint_fast64_t* place, uint64_t value)
{
    uint_fast64_t old = atomic_load(place);
    while (value < old && !atomic_compare_exchange_weak(place, &old, value)) {
    }
}

static void raise_to(atomic_uint_fast64_t* place, uint64_t value)
{
    uint_fast64_t old = atomic_load(place);
    while (value > old && !atomic_compare_exchange_weak(place, &old, value)) {
    }
}

// A block's contribution to the totals.
typedef struct tally {
    uint64_t lines, not_finite, last_full, first_bad;
} tally;

static void read_other_line(reading* r, stp_text at, uint64_t line, tally* t)
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

static void read_block(reading* r, const stp_text_block* b, stp_column_ranges* all)
{
    stp_column_ranges ranges = *all;
    const stp_text_points* p = r->points;
    uint64_t end_line = p->first_line + p->cloud->set.point_count, line = b->first_line;
    stp_text at = b->begin;
    tally t = {.first_bad = UINT64_MAX};
    for (; line < p->first_line; ++line) {
        at = stp_next_line(at);
    }
    for (; at < b->end && line < end_line; ++line) {
        double v[STP_COLUMN_SLOTS];
        size_t cell = (size_t)(line - p->first_line);
        stp_text rest = read_values(&p->columns, at, v);
        if (rest == NULL) {
            read_other_line(r, at, line, &t);
            at = stp_next_line(at);
            continue;
        }
        t.last_full = line;
        if (p->zero_is_empty && v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0) {
            stp_cloud_leave_empty(p->cloud, cell);
        } else if (stp_cloud_place(p->cloud, cell, v)) {
            fill_columns(r, cell, v, &ranges);
            t.lines += 1;
        } else {
            t.lines += 1;
            t.not_finite += 1;
        }
        at = stp_next_line(rest);
    }
    *all = ranges;
    atomic_fetch_add(&r->lines, t.lines);
    atomic_fetch_add(&r->not_finite, t.not_finite);
    lower_to(&r->first_bad, t.first_bad);
    raise_to(&r->last_full, t.last_full);
}

static void read_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    reading* r = user;
    for (size_t i = begin; i < end; ++i) {
        if (i % RELEASE_EVERY == RELEASE_EVERY - 1) {
            stp_point_columns_release(r->points->cloud->import, &r->points->cloud->set);
        }
        read_block(r, &r->points->blocks->blocks[r->first_block + i], &r->ranges[worker]);
        stp_progress_add(r->points->cloud->import->context, 1);
    }
}

static stp_result read_once(reading* r, stp_column_ranges* all)
{
    const stp_text_points* p = r->points;
    stp_context* context = p->cloud->import->context;
    uint32_t workers = stp_context_thread_count(context);
    uint64_t last_line = p->first_line + p->cloud->set.point_count - 1;
    size_t end_block = stp_text_blocks_find(p->blocks, last_line) + 1;
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
    stp_loop_report report = {
        .stage = "import", .unit = "blocks", .total = end_block - r->first_block};
    stp_result result =
        stp_parallel_for_reported(context, end_block - r->first_block, 1, read_blocks, r, &report);
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
    stp_losses_add(&p->cloud->import->losses, STP_LOSS_POINT, p->not_finite);
    return report_bad_line(&r);
}
