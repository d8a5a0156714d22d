// SPDX-License-Identifier: MIT
#include "lod/cell_rows.h"

#include "base/core/sort.h"
#include "base/math/math.h"

#include <assert.h>
#include <math.h>

#define GRAIN 16384
#define AHEAD 24 // points to prefetch ahead
#define MIN_CELL 0x1p-100

typedef struct row_sorter {
    stp_cell_rows* rows;
    const float* positions;
    stp_vec3d corner; ///< lowest coordinates
    double inverse_cell;
} row_sorter;

/// Cells count from 1, so that each has neighbours on all sides.
static uint64_t coordinate(const row_sorter* s, double offset)
{
    return (uint64_t)(int64_t)(offset * s->inverse_cell) + 1;
}

static void number_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const row_sorter* s = user;
    const stp_cell_rows* rows = s->rows;
    for (size_t i = begin; i < end; ++i) {
        const float* p = s->positions + 3 * i;
        uint64_t number = coordinate(s, (double)p[2] - s->corner.z);
        number = number << rows->axis_bits[1] | coordinate(s, (double)p[1] - s->corner.y);
        number = number << rows->axis_bits[0] | coordinate(s, (double)p[0] - s->corner.x);
        assert(stp_bit_width(number) + rows->index_bits <= 64 && "choose_cells makes numbers fit");
        rows->items[i] = number << rows->index_bits | i;
    }
}

/// Chooses the corner, and a cell with which numbers fit.
static void choose_cells(row_sorter* s, float cell)
{
    stp_cell_rows* rows = s->rows;
    stp_box box = stp_box_of(s->positions, rows->count);
    s->corner = stp_to_double(box.min);
    stp_vec3d size = stp_subd(stp_to_double(box.max), s->corner);
    const double sizes[3] = {size.x, size.y, size.z};
    rows->index_bits = stp_bit_width(rows->count);
    double side = fmax((double)cell, MIN_CELL);
    for (;; side *= 2.0) {
        s->inverse_cell = 1.0 / side;
        unsigned bits = rows->index_bits;
        for (int k = 0; k < 3; ++k) {
            bool fits = sizes[k] * s->inverse_cell < 0x1p60;
            rows->axis_bits[k] = fits ? stp_bit_width(coordinate(s, sizes[k]) + 1) : 64;
            bits += rows->axis_bits[k];
        }
        if (bits <= 64) {
            return;
        }
    }
}

static void fill_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const row_sorter* s = user;
    const stp_cell_rows* rows = s->rows;
    for (size_t at = begin; at < end; ++at) {
        if (at + AHEAD < end) {
            __builtin_prefetch(s->positions + 3 * (size_t)stp_cell_rows_index(rows, at + AHEAD));
        }
        const float* p = s->positions + 3 * (size_t)stp_cell_rows_index(rows, at);
        rows->x[at] = p[0];
        rows->y[at] = p[1];
        rows->z[at] = p[2];
    }
}

static uint32_t count_cells(const stp_cell_rows* rows)
{
    uint32_t cells = 0;
    uint64_t last = UINT64_MAX;
    for (uint32_t i = 0; i < rows->count; ++i) {
        uint64_t number = rows->items[i] >> rows->index_bits;
        cells += number != last;
        last = number;
    }
    return cells;
}

static stp_result list_cells(stp_context* context, stp_cell_rows* rows)
{
    rows->cell_count = count_cells(rows);
    rows->starts = STP_NEW_ARRAY(context, uint32_t, (size_t)rows->cell_count + 1);
    rows->numbers = STP_NEW_ARRAY(context, uint64_t, (size_t)rows->cell_count + 1);
    if (rows->starts == NULL || rows->numbers == NULL) {
        return stp_fail_memory(context);
    }
    uint32_t cells = 0;
    uint64_t last = UINT64_MAX;
    for (uint32_t i = 0; i < rows->count; ++i) {
        uint64_t number = rows->items[i] >> rows->index_bits;
        if (number != last) {
            assert((cells == 0 || number > last) && "items are sorted by cell");
            rows->numbers[cells] = last = number;
            rows->starts[cells++] = i;
        }
    }
    assert(cells == rows->cell_count);
    rows->starts[cells] = rows->count;
    rows->numbers[cells] = UINT64_MAX; // ends every row
    return STP_OK;
}

static stp_result sort_points(stp_context* context, row_sorter* s)
{
    stp_cell_rows* rows = s->rows;
    size_t stride = ((size_t)rows->count / STP_CELL_LANES + 2) * STP_CELL_LANES;
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, rows->count);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, rows->count);
    rows->items = items;
    stp_result result = items == NULL || scratch == NULL ? stp_fail_memory(context) : STP_OK;
    if (result == STP_OK) {
        stp_parallel_for(context, rows->count, GRAIN, number_points, s);
        unsigned bits = rows->axis_bits[0] + rows->axis_bits[1] + rows->axis_bits[2];
        uint64_t* sorted =
            stp_parallel_sort_u64(context, items, scratch, rows->count, rows->index_bits, bits);
        result = sorted == NULL ? stp_fail_memory(context) : STP_OK;
        rows->items = sorted == scratch ? scratch : items;
    }
    stp_free(context, rows->items == items ? scratch : items);
    rows->x = result == STP_OK ? STP_NEW_ARRAY(context, float, 3 * stride) : NULL;
    if (result == STP_OK && rows->x == NULL) {
        result = stp_fail_memory(context);
    }
    if (result != STP_OK) {
        return result;
    }
    rows->y = rows->x + stride;
    rows->z = rows->y + stride;
    for (size_t i = rows->count; i < stride; ++i) { // read past the end, but never used
        rows->x[i] = rows->y[i] = rows->z[i] = 0.0f;
    }
    stp_parallel_for(context, rows->count, GRAIN, fill_columns, s);
    return STP_OK;
}

stp_result stp_cell_rows_make(stp_context* context, const float* positions, uint32_t count,
                              float cell, stp_cell_rows* rows)
{
    assert(!(cell < 0.0f));
    *rows = (stp_cell_rows){.count = count};
    row_sorter sorter = {.rows = rows, .positions = positions};
    choose_cells(&sorter, cell);
    stp_result result = sort_points(context, &sorter);
    return result == STP_OK ? list_cells(context, rows) : result;
}

void stp_cell_rows_destroy(stp_context* context, stp_cell_rows* rows)
{
    stp_free(context, rows->x);
    stp_free(context, rows->items);
    stp_free(context, rows->numbers);
    stp_free(context, rows->starts);
    *rows = (stp_cell_rows){0};
}

/// First cell from `from` on whose number is at least `number`. Takes ever longer steps first,
/// because it is usually close.
static uint32_t find_cell(const stp_cell_rows* rows, uint32_t from, uint64_t number)
{
    assert(from <= rows->cell_count);
    uint32_t low = from, step = 1, high;
    while (step < rows->cell_count - low && rows->numbers[low + step - 1] < number) {
        low += step;
        step *= 2;
    }
    high = step < rows->cell_count - low ? low + step - 1 : rows->cell_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (rows->numbers[middle] < number) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/// From a cell's number to that of another one in the same column.
static uint64_t row_offset(const stp_cell_rows* rows, int64_t y, int64_t z)
{
    return (((uint64_t)z << rows->axis_bits[1]) + (uint64_t)y) << rows->axis_bits[0];
}

/// From the number of the middle cell of a window to that of a row's middle cell.
static uint64_t offset_of_row(const stp_cell_rows* rows, int row)
{
    return row_offset(rows, row % 3 - 1, row / 3 - 1);
}

void stp_cell_window_start(const stp_cell_rows* rows, uint32_t cell, stp_cell_window* window)
{
    assert(cell < rows->cell_count);
    window->rows = rows;
    for (int r = 0; r < STP_CELL_ROWS; ++r) {
        window->begins[r] = find_cell(rows, 0, rows->numbers[cell] + offset_of_row(rows, r) - 1);
    }
}

void stp_cell_window_move(stp_cell_window* window, uint32_t cell)
{
    const stp_cell_rows* rows = window->rows;
    assert(cell < rows->cell_count);
    for (int r = 0; r < STP_CELL_ROWS; ++r) {
        uint64_t middle = rows->numbers[cell] + offset_of_row(rows, r);
        uint32_t at = window->begins[r];
        while (rows->numbers[at] < middle - 1) {
            at += 1;
        }
        assert((at == 0 || rows->numbers[at - 1] < middle - 1) && "windows only move forward");
        window->begins[r] = at;
        while (rows->numbers[at] <= middle + 1) {
            at += 1;
        }
        assert(at - window->begins[r] <= 3);
        window->ends[r] = at;
    }
}

stp_cell_reach stp_cell_reach_around(const stp_cell_rows* rows, uint64_t number, uint32_t cells)
{
    stp_cell_reach reach = {.number = number};
    unsigned shift = 0;
    for (int k = 0; k < 3; ++k) {
        int64_t maximum = ((int64_t)1 << rows->axis_bits[k]) - 1;
        int64_t at = (int64_t)(number >> shift) & maximum, far = (int64_t)cells;
        reach.minimum[k] = at < far ? -at : -far;
        reach.largest[k] = maximum - at < far ? maximum - at : far;
        shift += rows->axis_bits[k];
    }
    assert(shift + rows->index_bits <= 64 && stp_bit_width(number) <= shift);
    return reach;
}

void stp_cell_reach_row(const stp_cell_rows* rows, stp_cell_reach* reach, int64_t y, int64_t z,
                        uint32_t* begin, uint32_t* end)
{
    assert(reach->minimum[1] <= y && y <= reach->largest[1]);
    assert(reach->minimum[2] <= z && z <= reach->largest[2]);
    uint64_t middle = reach->number + row_offset(rows, y, z);
    assert((reach->next == 0 ||
            rows->numbers[reach->next - 1] < middle + (uint64_t)reach->minimum[0]) &&
           "rows ascend by z, then y");
    *begin = find_cell(rows, reach->next, middle + (uint64_t)reach->minimum[0]);
    *end = find_cell(rows, *begin, middle + (uint64_t)reach->largest[0] + 1);
    reach->next = *end;
}
