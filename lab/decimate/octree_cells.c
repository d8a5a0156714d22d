// SPDX-License-Identifier: MIT
#include "lab/decimate/octree_cells.h"

#include "base/core/jobs.h"
#include "base/core/sort.h"
#include "lab/decimate/point_disks.h"

#include <assert.h>

enum { GRAIN = 4096, CHILDREN = 8 };

/// Spreads 21 bits to every third bit.
static uint64_t spread(uint64_t x)
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

typedef struct coder {
    const float* positions;
    double low[3], per_unit;
    uint64_t* codes;
} coder;

static void code_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const coder* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        c->codes[i] = 0;
        for (int k = 0; k < 3; ++k) {
            double at = ((double)c->positions[3 * i + (size_t)k] - c->low[k]) * c->per_unit;
            uint64_t whole = at > 0.0 ? (uint64_t)at : 0;
            uint64_t last = (1u << STP_OCTREE_LEVELS) - 1;
            c->codes[i] |= spread(whole < last ? whole : last) << k;
        }
    }
}

/// Sorts stably by 32 bits of the codes.
static bool sort_by(stp_octree_cells* t, const uint64_t* codes, unsigned shift, uint64_t* items,
                    uint64_t* scratch)
{
    size_t count = t->input->count;
    for (size_t i = 0; i < count; ++i) {
        items[i] = (codes[t->order[i]] >> shift & 0xffffffffu) << 32 | t->order[i];
    }
    const uint64_t* sorted = stp_parallel_sort_u64(t->context, items, scratch, count, 32, 32);
    for (size_t i = 0; sorted != NULL && i < count; ++i) {
        t->order[i] = (uint32_t)sorted[i];
    }
    return sorted != NULL;
}

#ifndef NDEBUG
static bool is_ascending(const uint64_t* codes, size_t count)
{
    for (size_t i = 1; i < count; ++i) {
        if (codes[i - 1] > codes[i]) {
            return false;
        }
    }
    return true;
}
#endif

stp_result stp_octree_cells_make(stp_octree_cells* t)
{
    size_t count = t->input->count;
    stp_box box = stp_decimate_box(t->input);
    double wide = (double)box.max.x - (double)box.min.x, y = (double)box.max.y - (double)box.min.y,
           z = (double)box.max.z - (double)box.min.z;
    wide = y > wide ? y : wide;
    wide = z > wide ? z : wide;
    uint64_t* codes = STP_NEW_ARRAY(t->context, uint64_t, count + 1);
    uint64_t* scratch = STP_NEW_ARRAY(t->context, uint64_t, count + 1);
    t->codes = STP_NEW_ARRAY(t->context, uint64_t, count + 1);
    t->order = STP_NEW_ARRAY(t->context, uint32_t, count + 1);
    bool made = codes != NULL && scratch != NULL && t->codes != NULL && t->order != NULL;
    coder c = {.positions = t->input->positions,
               .low = {(double)box.min.x, (double)box.min.y, (double)box.min.z},
               .per_unit = wide > 0.0 ? (double)(1u << STP_OCTREE_LEVELS) / wide : 0.0,
               .codes = codes};
    for (uint32_t i = 0; made && i < count; ++i) {
        t->order[i] = i;
    }
    if (made) {
        stp_parallel_for(t->context, count, GRAIN, code_some, &c);
        made = sort_by(t, codes, 0, t->codes, scratch) && sort_by(t, codes, 32, t->codes, scratch);
    }
    for (size_t i = 0; made && i < count; ++i) {
        t->codes[i] = codes[t->order[i]];
    }
    assert(!made || is_ascending(t->codes, count));
    stp_free(t->context, codes);
    stp_free(t->context, scratch);
    return made ? STP_OK : stp_fail_memory(t->context);
}

/// Bits of a code that select the cell of a level.
static uint64_t cell_of(uint64_t code, uint32_t level)
{
    assert(level <= STP_OCTREE_LEVELS);
    return code >> 3 * (STP_OCTREE_LEVELS - level);
}

/// End of the points from `begin` that share its cell of a level.
static uint32_t end_of_cell(const stp_octree_cells* t, uint32_t begin, uint32_t end, uint32_t level)
{
    assert(begin < end && end <= t->input->count);
    uint64_t cell = cell_of(t->codes[begin], level);
    uint32_t low = begin + 1, high = end;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (cell_of(t->codes[middle], level) == cell) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static stp_octree_cell make_cell(const stp_octree_cells* t, uint32_t begin, uint32_t end,
                                 uint32_t level)
{
    stp_octree_cell cell = {.begin = begin, .end = end, .level = level};
    stp_box box = stp_box_empty();
    for (uint32_t i = begin; i < end; ++i) {
        const stp_ellipse* disk = &t->disks[t->order[i]];
        float reach = disk->minor;
        stp_vec3 wide = {reach, reach, reach};
        stp_box_add(&box, stp_sub(disk->center, wide));
        stp_box_add(&box, stp_add(disk->center, wide));
    }
    cell.size = stp_length(stp_sub(box.max, box.min));
    return cell;
}

/// Finds the cells on the first level below that splits a cell's points. @return their number: at
/// least 2, or 1 if all points coincide
static uint32_t find_children(const stp_octree_cells* t, const stp_octree_cell* cell,
                              stp_octree_cell children[CHILDREN])
{
    uint64_t differs = t->codes[cell->begin] ^ t->codes[cell->end - 1];
    uint32_t level = cell->level + 1, count = 0;
    while (level <= STP_OCTREE_LEVELS && cell_of(differs, level) == 0) {
        level += 1;
    }
    if (level > STP_OCTREE_LEVELS) {
        return 1;
    }
    for (uint32_t begin = cell->begin; begin < cell->end; begin = children[count++].end) {
        assert(count < CHILDREN);
        children[count].begin = begin;
        children[count].end = end_of_cell(t, begin, cell->end, level);
        children[count].level = level;
    }
    assert(count > 1 && "the level splits the cell");
    return count;
}

static bool is_larger(const stp_octree_cell* a, const stp_octree_cell* b)
{
    return a->size > b->size || (a->size == b->size && a->begin < b->begin);
}

static void sift_down(stp_octree_cell* heap, uint32_t count, stp_octree_cell cell)
{
    uint32_t at = 0;
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        child += child + 1 < count && is_larger(&heap[child + 1], &heap[child]) ? 1 : 0;
        if (!is_larger(&heap[child], &cell)) {
            break;
        }
        heap[at] = heap[child];
    }
    heap[at] = cell;
}

static void push(stp_octree_cell* heap, uint32_t* count, stp_octree_cell cell)
{
    uint32_t at = (*count)++;
    for (; at > 0 && is_larger(&cell, &heap[(at - 1) / 2]); at = (at - 1) / 2) {
        heap[at] = heap[(at - 1) / 2];
    }
    heap[at] = cell;
}

stp_result stp_octree_cells_open(stp_octree_cells* t, uint32_t target)
{
    assert(target > 0);
    uint32_t count = t->input->count, maximum = target < count ? target : count, waiting = 0;
    // cells that may be opened form a heap; final ones are listed in `cells`
    stp_octree_cell* heap = STP_NEW_ARRAY(t->context, stp_octree_cell, (size_t)maximum + 1);
    t->cells = STP_NEW_ARRAY(t->context, stp_octree_cell, (size_t)maximum + 1);
    bool made = heap != NULL && t->cells != NULL;
    if (made && count > 0) {
        push(heap, &waiting, make_cell(t, 0, count, 0));
    }
    while (made && waiting > 0) {
        assert(waiting + t->count <= maximum);
        stp_octree_cell cell = heap[0], children[CHILDREN];
        waiting -= 1;
        sift_down(heap, waiting, heap[waiting]);
        uint32_t found = find_children(t, &cell, children);
        if (found == 1 || waiting + t->count + found > maximum) {
            t->cells[t->count++] = cell;
            continue;
        }
        for (uint32_t i = 0; i < found; ++i) {
            push(heap, &waiting,
                 make_cell(t, children[i].begin, children[i].end, children[i].level));
        }
    }
    stp_free(t->context, heap);
    return made ? STP_OK : stp_fail_memory(t->context);
}

stp_result stp_octree_cells_take_level(stp_octree_cells* t, uint32_t target)
{
    uint32_t count = t->input->count, best = 0;
    // first counts the codes that begin to differ at a level
    uint32_t counts[STP_OCTREE_LEVELS + 1] = {0};
    for (uint32_t i = 1; i < count; ++i) {
        uint64_t differs = t->codes[i - 1] ^ t->codes[i];
        if (differs != 0) {
            counts[STP_OCTREE_LEVELS - (63u - (uint32_t)__builtin_clzll(differs)) / 3] += 1;
        }
    }
    counts[0] = count > 0 ? 1 : 0;
    for (uint32_t level = 1; level <= STP_OCTREE_LEVELS; ++level) {
        counts[level] += counts[level - 1];
        uint32_t away = counts[level] > target ? counts[level] - target : target - counts[level];
        uint32_t minimum = counts[best] > target ? counts[best] - target : target - counts[best];
        best = away < minimum ? level : best;
    }
    t->cells = STP_NEW_ARRAY(t->context, stp_octree_cell, (size_t)counts[best] + 1);
    if (t->cells == NULL) {
        return stp_fail_memory(t->context);
    }
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        end = end_of_cell(t, begin, count, best);
        t->cells[t->count++] = (stp_octree_cell){.begin = begin, .end = end, .level = best};
    }
    assert(t->count == counts[best]);
    return STP_OK;
}

void stp_octree_cells_destroy(stp_octree_cells* t)
{
    stp_free(t->context, t->codes);
    stp_free(t->context, t->order);
    stp_free(t->context, t->cells);
    t->codes = NULL;
    t->order = NULL;
    t->cells = NULL;
    t->count = 0;
}
