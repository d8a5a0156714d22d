// SPDX-License-Identifier: MIT
//
// Sorts points along a Morton curve into the leaves of a tree. First, all points are bucketed into
// 16^3 cells together with their positions, so that later reads are sequential. Then each cell is
// sorted in cache and turned into leaves. If normals matter, points of a cell that face differently
// are kept apart, so that a leaf holds one side of a thin wall and not both. A leaf of 32 points is
// as large as 32 records, so all of this happens in the memory of the leaves: a leaf is written
// once the records in its place have been read.
#include "base/core/processor.h"
#include "base/core/sort.h"
#include "base/math/math.h"
#include "order/curve.h"
#include "order/points.h"

#include <assert.h>
#include <string.h>

enum {
    CHUNK_SIZE = 1 << 16, // points that a thread buckets at a time
    TASK_CELLS = 8,       // cells that a thread sorts at a time
    TASKS = STP_CURVE_CELLS / TASK_CELLS,
    SIDE_BITS = 3,
    AHEAD = 32, // prefetch distance for normals
};

_Static_assert(sizeof(stp_leaf) == STP_LEAF_SIZE * sizeof(stp_record), "sorted in place");

// Leaves that a task shares with its neighbours.
typedef struct shared_leaves {
    stp_leaf first, last;
} shared_leaves;

typedef struct sort_job {
    const stp_points* points;
    const stp_curve_kernels* kernels;
    stp_curve curve;
    stp_tree* tree;
    stp_record* records; // in the memory of the leaves
    uint32_t* ids;
    uint16_t* cells;       // per point
    uint32_t* offsets;     // [chunk][cell]: where the chunk's next point of that cell goes
    uint32_t* starts;      // [cell], and the end
    shared_leaves* shared; // [task]
    uint64_t* items;       // [worker][2][largest cell]
    stp_record* copies;    // [worker][largest cell]
    stp_vec3* normals;     // [worker][largest cell]; NULL where sides do not matter
    size_t largest;
} sort_job;

const stp_curve_kernels* stp_curve_kernels_select(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_curve_kernels);
}

static void count_cells(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const sort_job* job = user;
    uint32_t* counts = job->offsets + begin / CHUNK_SIZE * STP_CURVE_CELLS;
    memset(counts, 0, STP_CURVE_CELLS * sizeof(counts[0]));
    enum { BLOCK = 512 };
    for (size_t block = begin; block < end; block += BLOCK) {
        size_t block_end = end - block < BLOCK ? end : block + BLOCK;
        job->kernels->cells(&job->curve, job->points->positions + 3 * block, block_end - block,
                            job->cells + block);
        for (size_t i = block; i < block_end; ++i) {
            counts[job->cells[i]] += 1;
        }
    }
}

// Turns counts into offsets.
static void place_cells(sort_job* job, size_t chunks)
{
    uint32_t sum = 0;
    for (size_t cell = 0; cell < STP_CURVE_CELLS; ++cell) {
        job->starts[cell] = sum;
        for (size_t chunk = 0; chunk < chunks; ++chunk) {
            uint32_t* entry = &job->offsets[chunk * STP_CURVE_CELLS + cell];
            uint32_t count = *entry;
            *entry = sum;
            sum += count;
        }
        uint32_t size = sum - job->starts[cell];
        job->largest = job->largest > size ? job->largest : size;
    }
    assert(sum == job->points->count);
    job->starts[STP_CURVE_CELLS] = sum;
}

static void distribute(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const sort_job* job = user;
    uint32_t* next = job->offsets + begin / CHUNK_SIZE * STP_CURVE_CELLS;
    float scale = job->curve.scale;
    for (size_t i = begin; i < end; ++i) {
        const float* p = job->points->positions + 3 * i;
        job->records[next[job->cells[i]]++] =
            (stp_record){p[0] * scale, p[1] * scale, p[2] * scale, (uint32_t)i};
    }
}

// Sorts items by their upper halves in two passes; stable. A cell holds few points, so this
// minimises the digit counters rather than the moves.
static uint64_t* sort_items(uint64_t* items, uint64_t* scratch, size_t count, unsigned bits)
{
    enum { DIGITS = 1 << (3 * STP_CURVE_FINE_BITS + SIDE_BITS + 1) / 2 };
    assert(bits <= 3 * STP_CURVE_FINE_BITS + SIDE_BITS);
    if (count <= 48) {
        for (size_t i = 1; i < count; ++i) { // lower halves ascend: comparing items is stable
            uint64_t item = items[i];
            size_t at = i;
            for (; at > 0 && items[at - 1] > item; --at) {
                items[at] = items[at - 1];
            }
            items[at] = item;
        }
        return items;
    }
    unsigned low_bits = (bits + 1) / 2, high = 32 + low_bits;
    uint32_t mask = (1u << low_bits) - 1, low_sum = 0, high_sum = 0;
    uint32_t low_starts[DIGITS], high_starts[DIGITS];
    memset(low_starts, 0, (mask + 1) * sizeof(low_starts[0]));
    memset(high_starts, 0, (mask + 1) * sizeof(high_starts[0]));
    for (size_t i = 0; i < count; ++i) {
        low_starts[items[i] >> 32 & mask] += 1;
        high_starts[items[i] >> high] += 1;
    }
    for (uint32_t digit = 0; digit <= mask; ++digit) {
        uint32_t low_size = low_starts[digit], high_size = high_starts[digit];
        low_starts[digit] = low_sum;
        high_starts[digit] = high_sum;
        low_sum += low_size;
        high_sum += high_size;
    }
    for (size_t i = 0; i < count; ++i) {
        scratch[low_starts[items[i] >> 32 & mask]++] = items[i];
    }
    for (size_t i = 0; i < count; ++i) {
        items[high_starts[scratch[i] >> high]++] = scratch[i];
    }
    return items;
}

// Whether more than a leaf of sorted items are equal. Branch-free, as it runs for every point.
static bool has_long_runs(const uint64_t* items, size_t count)
{
    uint32_t found = 0;
    for (size_t i = STP_LEAF_SIZE; i < count; ++i) {
        found |= (uint32_t)(items[i] >> 32) == (uint32_t)(items[i - STP_LEAF_SIZE] >> 32);
    }
    return found != 0;
}

// Sorts runs of equal items longer than a leaf by the remaining bits.
static void refine_runs(const sort_job* job, const stp_record* records, uint64_t* items,
                        uint64_t* scratch, size_t count)
{
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && items[end] >> 32 == items[begin] >> 32; ++end) {
        }
        if (end - begin <= STP_LEAF_SIZE) {
            continue;
        }
        uint64_t* run = items + begin;
        for (size_t i = 0; i < end - begin; ++i) {
            uint32_t index = (uint32_t)run[i];
            const stp_record* r = &records[index];
            uint64_t place =
                stp_curve_place(&job->curve, r->x, r->y, r->z, 0, STP_CURVE_FINEST_BITS);
            run[i] = place << 32 | index;
        }
        uint64_t* sorted = stp_sort_u64(run, scratch, end - begin, 32, 3 * STP_CURVE_FINEST_BITS);
        if (sorted != run) {
            memcpy(run, sorted, (end - begin) * sizeof(run[0]));
        }
    }
}

// The axis and sign of a normal's largest component: 0..5. Branch-free: branches would be
// unpredictable.
static uint64_t side_of(const float n[3])
{
    float x = fabsf(n[0]), y = fabsf(n[1]), z = fabsf(n[2]);
    unsigned axis = (1u - ((unsigned)(x >= y) & (unsigned)(x >= z))) * (2u - (unsigned)(y >= z));
    return 2 * axis + (n[axis] < 0.0f);
}

// Copies the normals of a cell's points and puts their sides above their curve positions.
static void add_sides(const sort_job* job, const stp_record* records, stp_vec3* normals,
                      uint64_t* items, size_t count)
{
    const float* all = job->points->normals;
    for (size_t i = 0; i < count; ++i) {
        if (i + AHEAD < count) {
            const float* next = all + 3 * (size_t)records[i + AHEAD].id;
            __builtin_prefetch(next);
            __builtin_prefetch(next + 2);
        }
        const float* n = all + 3 * (size_t)records[i].id;
        normals[i] = (stp_vec3){n[0], n[1], n[2]};
        items[i] |= side_of(n) << (32 + 3 * STP_CURVE_FINE_BITS);
    }
}

// Points that move from a cell to consecutive lanes of one leaf.
typedef struct cell_points {
    const stp_record* records;
    const stp_vec3* normals; // NULL where sides do not matter
    const uint64_t* sorted;  // lower half: index of the next point
} cell_points;

static void write_lanes(const cell_points* from, uint32_t count, uint32_t lane, stp_leaf* leaf,
                        stp_leaf_normals* normals, uint32_t* ids)
{
    assert(lane + count <= STP_LEAF_SIZE);
    for (uint32_t i = 0; i < count; ++i) {
        const stp_record* r = &from->records[(uint32_t)from->sorted[i]];
        leaf->x[lane + i] = r->x;
        leaf->y[lane + i] = r->y;
        leaf->z[lane + i] = r->z;
        ids[i] = r->id;
    }
    for (uint32_t i = 0; i < count && from->normals != NULL; ++i) {
        const stp_vec3* n = &from->normals[(uint32_t)from->sorted[i]];
        normals->x[lane + i] = n->x;
        normals->y[lane + i] = n->y;
        normals->z[lane + i] = n->z;
    }
}

static void sort_cells(size_t begin, size_t end, uint32_t worker, void* user)
{
    const sort_job* job = user;
    uint64_t* items = job->items + (size_t)worker * 2 * job->largest;
    uint64_t* scratch = items + job->largest;
    stp_record* copies = job->copies + (size_t)worker * job->largest;
    stp_vec3* normals = job->normals != NULL ? job->normals + (size_t)worker * job->largest : NULL;
    shared_leaves* shared = &job->shared[begin / TASK_CELLS];
    // whole leaves are from `own` to `foreign`; the leaves before and after are shared
    uint32_t position = job->starts[begin];
    uint32_t own = (uint32_t)(((uint64_t)position + STP_LEAF_SIZE - 1) / STP_LEAF_SIZE);
    uint32_t foreign = job->starts[end] / STP_LEAF_SIZE;
    stp_leaf leaf;
    for (uint32_t lane = 0; lane < STP_LEAF_SIZE; ++lane) {
        leaf.gap[lane] = INFINITY;
    }
    for (size_t cell = begin; cell < end; ++cell) {
        uint32_t first = job->starts[cell], count = job->starts[cell + 1] - first;
        if (count == 0) { // most cells of small sets
            continue;
        }
        memcpy(copies, job->records + first, count * sizeof(copies[0]));
        job->kernels->places(&job->curve, copies, count, items);
        unsigned bits = 3 * STP_CURVE_FINE_BITS;
        if (normals != NULL) {
            add_sides(job, copies, normals, items, count);
            bits += SIDE_BITS;
        }
        uint64_t* sorted = sort_items(items, scratch, count, bits);
        if (has_long_runs(sorted, count)) {
            refine_runs(job, copies, sorted, scratch, count);
        }
        for (uint32_t done = 0, now; done < count; done += now, position += now) {
            uint32_t lane = position % STP_LEAF_SIZE, index = position / STP_LEAF_SIZE;
            now = count - done < STP_LEAF_SIZE - lane ? count - done : STP_LEAF_SIZE - lane;
            stp_leaf* to = index < own ? &shared->first : index < foreign ? &leaf : &shared->last;
            cell_points from = {copies, normals, sorted + done};
            write_lanes(&from, now, lane, to, normals != NULL ? &job->tree->normals[index] : NULL,
                        job->ids + position);
            if (to == &leaf && lane + now == STP_LEAF_SIZE) {
                memcpy(&job->tree->leaves[index], &leaf, sizeof(leaf));
            }
        }
    }
    assert(position == job->starts[end] && "each point has a place");
}

static void write_lane(const sort_job* job, uint32_t position, const stp_leaf* from)
{
    stp_leaf* leaf = &job->tree->leaves[position / STP_LEAF_SIZE];
    uint32_t lane = position % STP_LEAF_SIZE;
    leaf->x[lane] = from->x[lane];
    leaf->y[lane] = from->y[lane];
    leaf->z[lane] = from->z[lane];
    leaf->gap[lane] = INFINITY;
}

// Fills the shared leaves once all records have been read.
static void write_shared(const sort_job* job)
{
    for (size_t task = 0; task < TASKS; ++task) {
        const shared_leaves* shared = &job->shared[task];
        uint32_t position = job->starts[task * TASK_CELLS],
                 end = job->starts[(task + 1) * TASK_CELLS];
        for (; position < end && position % STP_LEAF_SIZE != 0; ++position) {
            write_lane(job, position, &shared->first);
        }
        uint32_t last = end - end % STP_LEAF_SIZE;
        for (position = position > last ? position : last; position < end; ++position) {
            write_lane(job, position, &shared->last);
        }
    }
}

static void sort_free(stp_context* context, sort_job* job)
{
    stp_free(context, job->cells);
    stp_free(context, job->offsets);
    stp_free(context, job->starts);
    stp_free(context, job->shared);
    stp_free(context, job->items);
    stp_free(context, job->copies);
    stp_free(context, job->normals);
}

static stp_curve make_curve(const stp_points* points)
{
    stp_vec3 low = stp_scale(points->box.min, points->scale);
    stp_vec3 size = stp_sub(stp_scale(points->box.max, points->scale), low);
    float extent = stp_max(stp_max(size.x, size.y), size.z);
    // half a cell less than the box, so that rounding cannot leave it
    float cells = (float)(1u << STP_CURVE_BITS) - 0.5f;
    return (stp_curve){points->scale, extent > 0.0f ? cells / extent : 0.0f, {low.x, low.y, low.z}};
}

stp_result stp_points_sort(const stp_points* points, const stp_team* team, stp_tree* tree,
                           uint32_t* ids)
{
    assert(tree->point_count == points->count);
    assert(tree->normals == NULL || points->normals != NULL);
    stp_context* context = team->context;
    size_t chunks = ((size_t)points->count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    sort_job job = {
        .points = points,
        .kernels = stp_curve_kernels_select(),
        .curve = make_curve(points),
        .tree = tree,
        .records = (stp_record*)(void*)tree->leaves,
        .ids = ids,
    };
    job.cells = STP_NEW_ARRAY(context, uint16_t, points->count);
    job.offsets = STP_NEW_ARRAY(context, uint32_t, chunks * STP_CURVE_CELLS);
    job.starts = STP_NEW_ARRAY(context, uint32_t, STP_CURVE_CELLS + 1);
    job.shared = STP_NEW_ARRAY(context, shared_leaves, TASKS);
    if (job.cells == NULL || job.offsets == NULL || job.starts == NULL || job.shared == NULL) {
        sort_free(context, &job);
        return stp_fail_memory(context);
    }
    stp_team_run(team, points->count, CHUNK_SIZE, count_cells, &job);
    place_cells(&job, chunks);
    job.items = STP_NEW_ARRAY(context, uint64_t, 2 * job.largest * team->threads);
    job.copies = STP_NEW_ARRAY(context, stp_record, job.largest * team->threads);
    if (tree->normals != NULL) {
        job.normals = STP_NEW_ARRAY(context, stp_vec3, job.largest * team->threads);
    }
    if (job.items == NULL || job.copies == NULL || (tree->normals != NULL && job.normals == NULL)) {
        sort_free(context, &job);
        return stp_fail_memory(context);
    }
    stp_team_run(team, points->count, CHUNK_SIZE, distribute, &job);
    stp_team_run(team, STP_CURVE_CELLS, TASK_CELLS, sort_cells, &job);
    write_shared(&job);
    sort_free(context, &job);
    return STP_OK;
}
