// SPDX-License-Identifier: MIT
#include "base/core/processor.h"
#include "base/math/math.h"
#include "lod/cloud_candidates.h"
#include "lod/point_normals_kernels.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    GRAIN = 1024,     ///< cells
    POINT_GRAIN = 64, ///< points with few neighbours
    BATCH = 64,       ///< points whose normals are computed together
    LANES = STP_CELL_LANES,
    CELL_POINTS = 16, ///< maximum points of a cell that are tested
    MIN_NEIGHBOURS = 4,
    DOUBLINGS = 4, ///< maximum enlargement of the radius, for points with fewer neighbours
};

/// Below this sum of products of two eigenvalues over their squared sum, points lie in a line: a
/// sixth as wide as it is long. A disk has 1/4.
#define LINE 0.027f

// copies write whole vectors
_Static_assert(27 * CELL_POINTS + LANES <= STP_NEAR_POINTS_MAX, "a window fits into a list");

typedef struct normal_loop {
    const stp_cell_rows* rows;
    float squared_radius;
    const stp_normal_kernels* kernels;
    float* normals;
    uint8_t* missing;     ///< by candidate: whether it needs a normal (stp_normal_search)
    const uint32_t* list; ///< sorted points that need one, for estimate_listed
    uint32_t reach;       ///< radius in cells
} normal_loop;

/// Sums of points whose normals are computed together.
typedef struct sum_batch {
    uint32_t count;
    uint32_t index[BATCH]; ///< candidates
    float sums[BATCH][STP_NORMAL_SUMS];
} sum_batch;

/// Extracts the remaining eigenvector of a matrix (stp_normal_kernels); 0 if there is none.
static stp_vec3 direction_of(const float m[STP_NORMAL_MATRIX])
{
    // the diagonal of a projection holds the squares of the direction's coordinates
    float xx = m[0], yy = m[3], zz = m[5];
    stp_vec3 n = {xx, m[1], m[2]};
    if (yy > xx && yy >= zz) {
        n = (stp_vec3){m[1], yy, m[4]};
    } else if (zz > xx) {
        n = (stp_vec3){m[2], m[4], zz};
    }
    n = stp_normalize(n);
    return n.y < 0.0f ? stp_scale(n, -1.0f) : n;
}

/// Whether points lie in a line, so that their plane may be turned about it.
static bool are_in_line(const float s[STP_NORMAL_SUMS])
{
    float weight = 1.0f / s[0], x = s[1] * weight, y = s[2] * weight, z = s[3] * weight;
    float xx = s[4] * weight - x * x, xy = s[5] * weight - x * y, xz = s[6] * weight - x * z;
    float yy = s[7] * weight - y * y, yz = s[8] * weight - y * z, zz = s[9] * weight - z * z;
    float products = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz);
    float trace = xx + yy + zz;
    return products < LINE * trace * trace;
}

/// Sets the normals of a batch. A line only gives one to points without any.
static void set_normals(const normal_loop* s, sum_batch* batch)
{
    float matrices[BATCH][STP_NORMAL_MATRIX];
    assert(batch->count <= BATCH);
    s->kernels->project((const float(*)[STP_NORMAL_SUMS])batch->sums, batch->count, matrices);
    for (uint32_t i = 0; i < batch->count; ++i) {
        uint32_t index = batch->index[i];
        stp_vec3 normal = direction_of(matrices[i]);
        bool line = are_in_line(batch->sums[i]);
        if (stp_dot(normal, normal) > 0.0f && (s->missing[index] == STP_NORMAL_NONE || !line)) {
            memcpy(s->normals + 3 * (size_t)index, &normal, sizeof(normal));
            s->missing[index] = line ? STP_NORMAL_OF_LINE : STP_NORMAL_KNOWN;
        }
    }
    batch->count = 0;
}

static void copy_vectors(float* to, const float* from, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += LANES) {
        memcpy(to + i, from + i, LANES * sizeof(*to));
    }
}

/// Adds the points of some cells to a list: all of a cell's points, or an even choice of them, so
/// that dense cells neither take long nor hide sparse ones.
static void add_cells(const stp_cell_rows* rows, uint32_t begin, uint32_t end,
                      stp_near_points* near)
{
    assert(begin <= end && end <= rows->cell_count);
    assert(near->count + (end - begin) * CELL_POINTS + LANES <= STP_NEAR_POINTS_MAX);
    uint32_t first = rows->starts[begin], size = rows->starts[end] - first;
    if (size <= CELL_POINTS) {
        copy_vectors(near->x + near->count, rows->x + first, size);
        copy_vectors(near->y + near->count, rows->y + first, size);
        copy_vectors(near->z + near->count, rows->z + first, size);
        near->count += size;
        return;
    }
    for (uint32_t cell = begin; cell < end; ++cell) {
        uint32_t last = rows->starts[cell + 1];
        uint32_t stride = (last - rows->starts[cell] + CELL_POINTS - 1) / CELL_POINTS;
        for (uint32_t at = rows->starts[cell]; at < last; at += stride) {
            near->x[near->count] = rows->x[at];
            near->y[near->count] = rows->y[at];
            near->z[near->count++] = rows->z[at];
        }
    }
}

/// Pads a list with points far away from everything.
static void pad(stp_near_points* near)
{
    assert(near->count <= STP_NEAR_POINTS_MAX && "a multiple of LANES: padding fits");
    for (; near->count % LANES != 0; ++near->count) {
        near->x[near->count] = near->y[near->count] = near->z[near->count] = INFINITY;
    }
}

/// Counts the last sums of a batch in, unless they are of too few neighbours.
static void keep_sums(const normal_loop* s, uint32_t index, sum_batch* batch)
{
    assert(batch->count < BATCH && "full batches are finished at once");
    if (batch->sums[batch->count][0] >= (float)MIN_NEIGHBOURS) {
        batch->index[batch->count++] = index;
        if (batch->count == BATCH) {
            set_normals(s, batch);
        }
    }
}

static void list_around(stp_cell_window* window, uint32_t cell, stp_near_points* near)
{
    stp_cell_window_move(window, cell);
    near->count = 0;
    for (int r = 0; r < STP_CELL_ROWS; ++r) {
        add_cells(window->rows, window->begins[r], window->ends[r], near);
    }
    pad(near);
}

static stp_vec3 point_of(const stp_cell_rows* rows, uint32_t at)
{
    return (stp_vec3){rows->x[at], rows->y[at], rows->z[at]};
}

static void estimate_cells(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_loop* s = user;
    const stp_cell_rows* rows = s->rows;
    stp_cell_window window;
    stp_near_points near;
    sum_batch batch;
    batch.count = 0;
    stp_cell_window_start(rows, (uint32_t)begin, &window);
    for (size_t cell = begin; cell < end; ++cell) {
        bool listed = false;
        for (uint32_t at = rows->starts[cell]; at < rows->starts[cell + 1]; ++at) {
            if (s->missing[stp_cell_rows_index(rows, at)] == STP_NORMAL_KNOWN) {
                continue;
            }
            if (!listed) {
                list_around(&window, (uint32_t)cell, &near);
                listed = true;
            }
            s->kernels->sum_near(&near, s->squared_radius, point_of(rows, at),
                                 batch.sums[batch.count]);
            keep_sums(s, stp_cell_rows_index(rows, at), &batch);
        }
    }
    set_normals(s, &batch);
}

/// Adds what a list contributes to the sums of a point, and empties it.
static void add_list(const normal_loop* s, uint32_t at, stp_near_points* near,
                     float sums[STP_NORMAL_SUMS])
{
    float more[STP_NORMAL_SUMS];
    pad(near);
    s->kernels->sum_near(near, s->squared_radius, point_of(s->rows, at), more);
    for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
        sums[i] += more[i];
    }
    near->count = 0;
}

/// Sums over the neighbours of a sorted point in any number of cells.
static void sum_within_reach(const normal_loop* s, uint32_t at, float sums[STP_NORMAL_SUMS])
{
    const stp_cell_rows* rows = s->rows;
    stp_near_points near;
    near.count = 0;
    memset(sums, 0, STP_NORMAL_SUMS * sizeof(*sums));
    stp_cell_reach reach =
        stp_cell_reach_around(rows, rows->items[at] >> rows->index_bits, s->reach);
    for (int64_t z = reach.minimum[2]; z <= reach.largest[2]; ++z) {
        for (int64_t y = reach.minimum[1]; y <= reach.largest[1]; ++y) {
            uint32_t begin, end;
            stp_cell_reach_row(rows, &reach, y, z, &begin, &end);
            for (uint32_t cell = begin; cell < end; ++cell) {
                if (near.count + CELL_POINTS + LANES > STP_NEAR_POINTS_MAX) {
                    add_list(s, at, &near, sums);
                }
                add_cells(rows, cell, cell + 1, &near);
            }
        }
    }
    add_list(s, at, &near, sums);
}

static void estimate_listed(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_loop* s = user;
    sum_batch batch;
    batch.count = 0;
    for (size_t i = begin; i < end; ++i) {
        sum_within_reach(s, s->list[i], batch.sums[batch.count]);
        keep_sums(s, stp_cell_rows_index(s->rows, s->list[i]), &batch);
    }
    set_normals(s, &batch);
}

const stp_normal_kernels* stp_normal_kernels_select(void)
{
    return STP_VARIANT_OF_TWO(stp_processor_detect(), &stp_normal_kernels);
}

static normal_loop loop_of(const stp_normal_search* search, float radius)
{
    return (normal_loop){.rows = &search->rows,
                         .squared_radius = radius * radius,
                         .kernels = stp_normal_kernels_select(),
                         .normals = search->candidates->normals,
                         .missing = search->missing};
}

/// Sorts the candidates into cells slightly wider than a radius, and estimates missing normals within it.
static stp_result search_all(stp_normal_search* search, float radius)
{
    const stp_candidates* c = search->candidates;
    assert(!(radius < 0.0f));
    stp_cell_rows_destroy(search->context, &search->rows);
    search->radius = radius;
    stp_result result = stp_cell_rows_make(search->context, c->positions, c->count,
                                           STP_NORMAL_CELL * radius, &search->rows);
    if (result == STP_OK) {
        normal_loop loop = loop_of(search, radius);
        stp_parallel_for(search->context, search->rows.cell_count, GRAIN, estimate_cells, &loop);
    }
    return result;
}

/// Estimates missing normals within `reach` times the radius, without sorting again.
static stp_result search_few(stp_normal_search* search, uint32_t count, uint32_t reach)
{
    uint32_t* list = STP_NEW_ARRAY(search->context, uint32_t, count);
    if (list == NULL) {
        return stp_fail_memory(search->context);
    }
    uint32_t listed = 0;
    for (uint32_t at = 0; at < search->rows.count; ++at) {
        if (search->missing[stp_cell_rows_index(&search->rows, at)] != STP_NORMAL_KNOWN) {
            list[listed++] = at;
        }
    }
    assert(listed == count && "each candidate is in one cell");
    normal_loop loop = loop_of(search, search->radius * (float)reach);
    loop.list = list;
    loop.reach = reach;
    stp_parallel_for(search->context, listed, POINT_GRAIN, estimate_listed, &loop);
    stp_free(search->context, list);
    return STP_OK;
}

static uint32_t count_missing(const stp_normal_search* search)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < search->candidates->count; ++i) {
        count += search->missing[i] != STP_NORMAL_KNOWN ? 1 : 0;
    }
    return count;
}

stp_result stp_normal_search_start(stp_context* context, stp_candidates* candidates, float radius,
                                   stp_normal_search* search)
{
    *search = (stp_normal_search){.context = context, .candidates = candidates};
    search->missing = STP_NEW_ZEROED(context, uint8_t, (size_t)candidates->count + 1);
    if (search->missing == NULL) {
        return stp_fail_memory(context);
    }
    memset(search->missing, STP_NORMAL_NONE, stp_first_of_sets(candidates));
    return search_all(search, radius);
}

stp_result stp_normal_search_finish(stp_normal_search* search)
{
    assert(search->rows.count == search->candidates->count && "the search has started");
    stp_result result = STP_OK;
    uint32_t missing = count_missing(search), reach = 1;
    for (int i = 0; i < DOUBLINGS && missing > 0 && result == STP_OK; ++i) {
        // to find a row takes about as long as to sort some points
        reach *= 2;
        uint64_t rows = (2 * reach + 1) * (2 * reach + 1);
        if (missing * rows <= search->rows.count) {
            result = search_few(search, missing, reach);
        } else {
            result = search_all(search, search->radius * (float)reach);
            reach = 1;
        }
        missing = count_missing(search);
        double done = (double)(i + 1) / DOUBLINGS;
        result = result == STP_OK ? stp_progress(search->context, "normals", done) : result;
    }
    for (uint32_t i = 0; i < search->candidates->count && missing > 0; ++i) {
        if (search->missing[i] == STP_NORMAL_NONE) {
            const float up[3] = {0, 1, 0};
            memcpy(search->candidates->normals + 3 * (size_t)i, up, sizeof(up));
        }
    }
    return result;
}

void stp_normal_search_destroy(stp_normal_search* search)
{
    stp_cell_rows_destroy(search->context, &search->rows);
    stp_free(search->context, search->missing);
    *search = (stp_normal_search){0};
}

stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                      float radius)
{
    if (!(radius > 0.0f) || stp_first_of_sets(candidates) == 0) {
        return STP_OK;
    }
    stp_normal_search search;
    stp_result result = stp_normal_search_start(context, candidates, radius, &search);
    result = result == STP_OK ? stp_normal_search_finish(&search) : result;
    stp_normal_search_destroy(&search);
    return result;
}
