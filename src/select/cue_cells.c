// SPDX-License-Identifier: MIT
#include "base/splats/leaf_runs.h"
#include "select/cues.h"

#include <assert.h>

enum { GROWTHS = 4 * STP_OCTAVE_LIMIT };
#define NONE UINT32_MAX

#define ROUND_UP 0.92 // radii err on the large side: factors of 0.96 to 1.14
/// Radii grow by the fourth root of 2 from step to step.
static const float growths[4] = {1.0f, 1.18920712f, 1.41421356f, 1.68179283f};

uint32_t stp_cue_count(const stp_splats* set, uint32_t first, uint32_t last, uint32_t octaves)
{
    uint32_t all = set->octave_count;
    assert(first <= last && octaves <= all);
    return octaves == 0
               ? 0
               : stp_leaf_until(last, octaves - 1, all) - stp_leaf_until(first, octaves - 1, all);
}

uint32_t stp_cue_octaves(const stp_splats* set, uint32_t here)
{
    uint32_t octaves = set->octave_count;
    while (octaves > 1 && set->octave_ends[octaves - 1] > here) {
        octaves -= 1;
    }
    return octaves;
}

stp_cue_cell stp_cue_cell_make(const stp_leaf_node* node, uint32_t count)
{
    assert(count <= node->count);
    return (stp_cue_cell){.first = node->first, .last = node->first + node->count, .count = count};
}

stp_result stp_cue_add_cell(stp_selection* s, size_t* count, stp_cue_cell cell)
{
    stp_draw_list* list = s->list;
    if (cell.count == 0) {
        return STP_OK;
    }
    if (*count == list->cell_capacity &&
        !STP_MAKE_ROOM(s->context, list->cells, list->cell_capacity, *count + 1)) {
        return stp_fail_memory(s->context);
    }
    list->cells[(*count)++] = cell;
    return STP_OK;
}

/// The cells of each radius step, in curve order.
typedef struct growth_lists {
    float scales[GROWTHS];
    uint32_t heads[GROWTHS], ends[GROWTHS]; ///< first and last cell of a step; NONE: none
} growth_lists;

/// The radius step nearest to the radius that a cell's splats need.
static uint32_t growth_of(const growth_lists* lists, const stp_cue_cell* cell)
{
    assert(cell->count > 0 && cell->count <= cell->last - cell->first &&
           "draws some of its splats");
    float sparser = (float)((double)(cell->last - cell->first) / (double)cell->count);
    float radius = sqrtf(sparser) * (float)ROUND_UP;
    uint32_t growth = 0;
    while (growth + 1 < GROWTHS && radius > lists->scales[growth]) {
        growth += 1;
    }
    return growth;
}

/// Links the cells of each radius step.
static void link_cells(stp_cue_cell* cells, uint32_t count, growth_lists* lists)
{
    for (uint32_t k = 0; k < GROWTHS; ++k) {
        lists->scales[k] = k < 4 ? growths[k] : 2.0f * lists->scales[k - 4];
        lists->heads[k] = lists->ends[k] = NONE;
    }
    for (uint32_t i = 0; i < count; ++i) {
        assert((i == 0 || cells[i - 1].last <= cells[i].first) && "cells are in curve order");
        uint32_t growth = growth_of(lists, &cells[i]);
        cells[i].growth = growth;
        cells[i].next = NONE;
        *(lists->heads[growth] == NONE ? &lists->heads[growth] : &cells[lists->ends[growth]].next) =
            i;
        lists->ends[growth] = i;
    }
}

/// Appends splats of one octave of a cell to the runs of its item, the first of which is
/// `first_run`.
static stp_result add_run(stp_selection* s, stp_leaf_run run, size_t first_run,
                          stp_depth_range drawn)
{
    stp_draw_list* list = s->list;
    assert(run.begin <= run.end);
    if (run.begin == run.end) {
        return STP_OK;
    }
    if (list->run_count > first_run && list->runs[list->run_count - 1].end == run.begin) {
        list->runs[list->run_count - 1].end = run.end;
        return STP_OK;
    }
    return stp_select_add_run(s, run.begin, run.end, drawn);
}

/// Run of an octave's splats that a cell draws: all, or as many as are still needed.
static stp_leaf_run run_of(const stp_splats* set, const stp_cue_cell* cell, uint32_t octave)
{
    stp_leaf_run run =
        stp_leaf_run_of(cell->first, cell->last, octave, set->octave_count, set->count);
    uint32_t before = stp_cue_count(set, cell->first, cell->last, octave);
    uint32_t left = cell->count > before ? cell->count - before : 0;
    run.end = left < run.end - run.begin ? run.begin + left : run.end;
    return run;
}

/// Adds the item of all cells with the same radius step, from `head` on.
static stp_result add_item(stp_selection* s, const stp_splats* set, const stp_cue_cell* cells,
                           uint32_t head, stp_draw_item item, stp_depth_range drawn)
{
    size_t first = s->list->run_count;
    uint32_t splats = 0;
    stp_result result = STP_OK;
    for (uint32_t k = 0; k < set->octave_count; ++k) {
        for (uint32_t i = head; i != NONE && result == STP_OK; i = cells[i].next) {
            stp_leaf_run run = run_of(set, &cells[i], k);
            splats += run.end - run.begin;
            result = add_run(s, run, first, drawn);
        }
    }
    size_t runs = s->list->run_count - first;
    if (result != STP_OK || runs == 0) {
        return result;
    }
    if (s->list->run_count > UINT32_MAX) {
        return stp_fail(s->context, STP_ERROR_LIMIT, "view: too many runs of splats");
    }
    item.prefix = item.full_prefix = s->list->runs[s->list->run_count - 1].end;
    assert(splats <= item.prefix && "runs do not overlap");
    item.split_count = item.prefix - splats;
    item.first_run = (uint32_t)first;
    item.run_count = (uint32_t)runs;
    return stp_select_add_item(s, item, item.prefix);
}

stp_result stp_cue_add_items(stp_selection* s, const stp_splats* set, stp_cue_cell* cells,
                             size_t count, stp_draw_item item, stp_depth_range drawn)
{
    assert(count < NONE);
    growth_lists lists;
    link_cells(cells, (uint32_t)count, &lists);
    stp_result result = STP_OK;
    item.scattered = true;
    for (uint32_t k = 0; k < GROWTHS && result == STP_OK; ++k) {
        if (lists.heads[k] != NONE) {
            item.shape_scale = lists.scales[k];
            result = add_item(s, set, cells, lists.heads[k], item, drawn);
        }
    }
    return result;
}
