// SPDX-License-Identifier: MIT
// Points sorted by cell: every point once, and around each cell the points that a plain search
// finds.
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "lod/cell_rows.h"

#include <string.h>

enum { POINTS = 700 };

/// Points in a box, some of them in one place.
static void make_points(float positions[3 * POINTS], float scale)
{
    for (uint32_t i = 0; i < POINTS; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            float random = (float)(stp_rng_hash(7 + k, i % 8 == 0 ? 0 : i) >> 40) / 16777216.0f;
            positions[3 * i + k] = scale * (random - 0.5f) * (k == 1 ? 0.2f : 1.0f);
        }
    }
}

/// The cells of all points on each axis, counted from the lowest one.
static void find_cells(const float* positions, double side, int64_t found[3 * POINTS])
{
    for (uint32_t k = 0; k < 3; ++k) {
        float minimum = positions[k];
        for (uint32_t i = 0; i < POINTS; ++i) {
            minimum = stp_min(minimum, positions[3 * i + k]);
        }
        for (uint32_t i = 0; i < POINTS; ++i) {
            double away = (double)positions[3 * i + k] - (double)minimum;
            found[3 * i + k] = (int64_t)(away * (1.0 / side));
        }
    }
}

/// Marks the points of some cells.
static void see_cells(test_state* test, const stp_cell_rows* rows, uint32_t begin, uint32_t end,
                      bool seen[POINTS])
{
    for (uint32_t i = rows->starts[begin]; i < rows->starts[end]; ++i) {
        uint32_t index = stp_cell_rows_index(rows, i);
        CHECK(!seen[index]);
        seen[index] = true;
    }
}

/// Exactly the points whose cells are at most `reach` cells away from that of a sorted point were
/// seen.
static void check_seen(test_state* test, const stp_cell_rows* rows, const int64_t* found,
                       uint32_t at, int64_t reach, const bool seen[POINTS])
{
    uint32_t point = stp_cell_rows_index(rows, at);
    for (uint32_t i = 0; i < POINTS; ++i) {
        bool near = true;
        for (uint32_t k = 0; k < 3; ++k) {
            int64_t d = found[3 * i + k] - found[3 * point + k];
            near = near && d >= -reach && d <= reach;
        }
        CHECK_EQUAL(near, seen[i]);
    }
}

static void check_reach(test_state* test, const stp_cell_rows* rows, const int64_t* found,
                        uint32_t cell, uint32_t cells)
{
    bool seen[POINTS] = {false};
    stp_cell_reach reach = stp_cell_reach_around(rows, rows->numbers[cell], cells);
    for (int64_t z = reach.minimum[2]; z <= reach.largest[2]; ++z) {
        for (int64_t y = reach.minimum[1]; y <= reach.largest[1]; ++y) {
            uint32_t begin, end;
            stp_cell_reach_row(rows, &reach, y, z, &begin, &end);
            see_cells(test, rows, begin, end, seen);
        }
    }
    check_seen(test, rows, found, rows->starts[cell], (int64_t)cells, seen);
}

static void check_window(test_state* test, const int64_t* found, stp_cell_window* window,
                         uint32_t cell)
{
    bool seen[POINTS] = {false};
    stp_cell_window_move(window, cell);
    for (int r = 0; r < STP_CELL_ROWS; ++r) {
        see_cells(test, window->rows, window->begins[r], window->ends[r], seen);
    }
    check_seen(test, window->rows, found, window->rows->starts[cell], 1, seen);
}

void test_cell_rows_find_the_points_around_each_cell(test_state* test)
{
    static float positions[3 * POINTS];
    static int64_t found[3 * POINTS];
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    const float cells[] = {0.03f, 0.2f, 5.0f};
    make_points(positions, 1.0f);
    for (size_t c = 0; c < 3; ++c) {
        stp_cell_rows rows;
        CHECK_EQUAL(STP_OK, stp_cell_rows_make(context, positions, POINTS, cells[c], &rows));
        find_cells(positions, (double)cells[c], found);
        bool seen[POINTS] = {false};
        stp_cell_window window;
        stp_cell_window_start(&rows, 0, &window);
        for (uint32_t cell = 0; cell < rows.cell_count; ++cell) {
            CHECK(rows.starts[cell] < rows.starts[cell + 1]);
            for (uint32_t at = rows.starts[cell]; at < rows.starts[cell + 1]; ++at) {
                uint32_t index = stp_cell_rows_index(&rows, at);
                const float* p = positions + 3 * (size_t)index;
                CHECK(p[0] == rows.x[at] && p[1] == rows.y[at] && p[2] == rows.z[at]);
                CHECK(at == rows.starts[cell] || index > stp_cell_rows_index(&rows, at - 1));
                CHECK(!seen[index]);
                seen[index] = true;
            }
            if (cell % 5 == 0) { // some are skipped
                check_window(test, found, &window, cell);
            }
        }
        CHECK_EQUAL(POINTS, rows.starts[rows.cell_count]);
        for (uint32_t cell = 0; cell < rows.cell_count; cell += 29) {
            for (uint32_t reach = 1; reach <= 16; reach *= 4) {
                check_reach(test, &rows, found, cell, reach);
            }
        }
        stp_cell_rows_destroy(context, &rows);
    }
    stp_context_destroy(context);
}

// Cells so small that their numbers would not fit, and positions as far apart as floats allow.
void test_cell_rows_enlarge_cells_that_are_too_small(test_state* test)
{
    static float positions[3 * POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const float scales[] = {1.0f, 1e38f, 0.0f};
    for (size_t s = 0; s < 3; ++s) {
        make_points(positions, scales[s]);
        positions[0] = s == 1 ? -3.4e38f : positions[0];
        positions[3] = s == 1 ? 3.4e38f : positions[3];
        stp_cell_rows rows;
        CHECK_EQUAL(STP_OK, stp_cell_rows_make(context, positions, POINTS, 0.0f, &rows));
        unsigned bits = rows.index_bits + rows.axis_bits[0] + rows.axis_bits[1] + rows.axis_bits[2];
        CHECK(bits <= 64);
        CHECK(s == 2 ? rows.cell_count == 1 : rows.cell_count > 1);
        stp_cell_window window;
        stp_cell_window_start(&rows, rows.cell_count - 1, &window);
        stp_cell_window_move(&window, rows.cell_count - 1);
        CHECK(window.begins[4] < window.ends[4]); // the row of the cell itself
        stp_cell_rows_destroy(context, &rows);
    }
    stp_context_destroy(context);
}
