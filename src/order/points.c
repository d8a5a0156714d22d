// SPDX-License-Identifier: MIT
//
// Points along a Morton curve. First all points are dealt out to 16^3 cells, together with their
// positions so that later reading is sequential; then each cell is sorted on its own, in cache, and
// written to its leaves.
#include "order/points.h"

#include "base/math.h"
#include "base/sort.h"

#include <string.h>

enum {
    CELL_COUNT = 4096,    // 4 bits an axis
    FINE_BITS = 6,        // an axis, within a cell
    FINEST_BITS = 10,     // an axis, only where more points than a leaf holds agree so far
    QUANTUM_BITS = 20,    // 4 + 6 + 10
    CHUNK_SIZE = 1 << 16, // points dealt out by one thread at a time
};

typedef struct record {
    float x, y, z;
    uint32_t id;
} record;

typedef struct bounds_job {
    const float* positions;
    stp_box* boxes; // one a chunk
    bool* finite;
} bounds_job;

static void measure_chunk(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const bounds_job* job = user;
    stp_box box = stp_box_empty();
    float poison = 0.0f; // becomes not-a-number with the first coordinate that is not finite
    for (size_t i = begin; i < end; ++i) {
        const float* p = job->positions + 3 * i;
        stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
        poison += (p[0] * 0.0f + p[1] * 0.0f) + p[2] * 0.0f;
    }
    job->boxes[begin / CHUNK_SIZE] = box;
    job->finite[begin / CHUNK_SIZE] = poison == 0.0f;
}

// The power of two that brings `extent` to [1, 2), as far as single precision reaches.
static float unit_scale(double extent)
{
    if (!(extent > 0.0)) {
        return 1.0f;
    }
    int exponent = 0;
    (void)frexp(extent, &exponent); // exact everywhere: it only takes the number apart
    exponent = 1 - exponent;
    exponent = exponent < -126 ? -126 : exponent > 126 ? 126 : exponent;
    return ldexpf(1.0f, exponent);
}

stp_result stp_points_measure(stp_points* points, const stp_team* team)
{
    size_t chunks = ((size_t)points->count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    stp_box* boxes = STP_NEW_ARRAY(team->context, stp_box, chunks);
    bool* finite = STP_NEW_ARRAY(team->context, bool, chunks);
    if (boxes == NULL || finite == NULL) {
        stp_free(team->context, boxes);
        stp_free(team->context, finite);
        return stp_fail_memory(team->context);
    }
    bounds_job job = {points->positions, boxes, finite};
    stp_team_run(team, points->count, CHUNK_SIZE, measure_chunk, &job);
    stp_box box = stp_box_empty();
    bool all_finite = true;
    for (size_t i = 0; i < chunks; ++i) {
        stp_box_add(&box, boxes[i].min);
        stp_box_add(&box, boxes[i].max);
        all_finite = all_finite && finite[i];
    }
    stp_free(team->context, boxes);
    stp_free(team->context, finite);
    if (!all_finite) {
        return stp_fail(team->context, STP_ERROR_ARGUMENT,
                        "order: the positions of points must be finite numbers");
    }
    double x = (double)box.max.x - (double)box.min.x, y = (double)box.max.y - (double)box.min.y,
           z = (double)box.max.z - (double)box.min.z;
    double extent = x > y ? x : y;
    points->box = box;
    points->scale = unit_scale(extent > z ? extent : z);
    return STP_OK;
}

typedef struct sort_job {
    const stp_points* points;
    stp_tree* tree;
    uint32_t* ids;
    stp_vec3 low;      // of the box, scaled
    float quanta;      // cells of the finest grid per scaled unit
    uint16_t* cells;   // of each point
    uint32_t* offsets; // [chunk][cell]: where the chunk's next point of that cell goes
    uint32_t* starts;  // [cell], and the end
    record* records;   // by cell
    uint64_t* items;   // [worker][2][largest cell]
    size_t item_stride;
} sort_job;

static inline uint32_t quantize(float value, float low, float quanta)
{
    float at = (value - low) * quanta;
    uint32_t whole = (uint32_t)at;
    return whole < (1u << QUANTUM_BITS) ? whole : (1u << QUANTUM_BITS) - 1;
}

// Spreads 10 bits to every third place.
static inline uint32_t spread_bits(uint32_t v)
{
    v = (v | v << 16) & 0x030000FFu;
    v = (v | v << 8) & 0x0300F00Fu;
    v = (v | v << 4) & 0x030C30C3u;
    return (v | v << 2) & 0x09249249u;
}

static inline uint32_t interleave(uint32_t x, uint32_t y, uint32_t z)
{
    return spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

static void count_cells(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const sort_job* job = user;
    const stp_points* points = job->points;
    uint32_t* counts = job->offsets + begin / CHUNK_SIZE * CELL_COUNT;
    memset(counts, 0, CELL_COUNT * sizeof(counts[0]));
    int shift = QUANTUM_BITS - 4;
    for (size_t i = begin; i < end; ++i) {
        const float* p = points->positions + 3 * i;
        uint32_t x = quantize(p[0] * points->scale, job->low.x, job->quanta) >> shift;
        uint32_t y = quantize(p[1] * points->scale, job->low.y, job->quanta) >> shift;
        uint32_t z = quantize(p[2] * points->scale, job->low.z, job->quanta) >> shift;
        uint32_t cell = interleave(x, y, z);
        job->cells[i] = (uint16_t)cell;
        counts[cell] += 1;
    }
}

// Turns counts into places. @return the size of the largest cell
static uint32_t place_cells(const sort_job* job, size_t chunks)
{
    uint32_t sum = 0, largest = 0;
    for (size_t cell = 0; cell < CELL_COUNT; ++cell) {
        job->starts[cell] = sum;
        for (size_t chunk = 0; chunk < chunks; ++chunk) {
            uint32_t* entry = &job->offsets[chunk * CELL_COUNT + cell];
            uint32_t count = *entry;
            *entry = sum;
            sum += count;
        }
        uint32_t size = sum - job->starts[cell];
        largest = largest > size ? largest : size;
    }
    job->starts[CELL_COUNT] = sum;
    return largest;
}

static void deal_out(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const sort_job* job = user;
    uint32_t* next = job->offsets + begin / CHUNK_SIZE * CELL_COUNT;
    float scale = job->points->scale;
    for (size_t i = begin; i < end; ++i) {
        const float* p = job->points->positions + 3 * i;
        job->records[next[job->cells[i]]++] =
            (record){p[0] * scale, p[1] * scale, p[2] * scale, (uint32_t)i};
    }
}

// Sorts items by their upper halves; equal ones keep their order.
static uint64_t* sort_items(uint64_t* items, uint64_t* scratch, size_t count, unsigned bits)
{
    if (count > 48) {
        return stp_sort_u64(items, scratch, count, 32, bits);
    }
    for (size_t i = 1; i < count; ++i) { // lower halves ascend, so whole items may be compared
        uint64_t item = items[i];
        size_t at = i;
        for (; at > 0 && items[at - 1] > item; --at) {
            items[at] = items[at - 1];
        }
        items[at] = item;
    }
    return items;
}

// The bits of a record's place from `shift` upwards, interleaved.
static inline uint64_t place_of(const sort_job* job, const record* r, unsigned shift, unsigned bits)
{
    uint32_t mask = (1u << bits) - 1;
    return interleave(quantize(r->x, job->low.x, job->quanta) >> shift & mask,
                      quantize(r->y, job->low.y, job->quanta) >> shift & mask,
                      quantize(r->z, job->low.z, job->quanta) >> shift & mask);
}

// Sorts runs of equal items that do not fit in a leaf by the remaining bits.
static void refine_runs(const sort_job* job, const record* records, uint64_t* items,
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
            run[i] = place_of(job, &records[index], 0, FINEST_BITS) << 32 | index;
        }
        uint64_t* sorted = sort_items(run, scratch, end - begin, 3 * FINEST_BITS);
        if (sorted != run) {
            memcpy(run, sorted, (end - begin) * sizeof(run[0]));
        }
    }
}

static void write_leaves(const sort_job* job, const record* records, const uint64_t* items,
                         uint32_t first, size_t count)
{
    const float* normals = job->points->normals;
    for (size_t i = 0; i < count; ++i) {
        const record* r = &records[(uint32_t)items[i]];
        uint32_t position = first + (uint32_t)i, lane = position % STP_LEAF_SIZE;
        stp_leaf* leaf = &job->tree->leaves[position / STP_LEAF_SIZE];
        leaf->x[lane] = r->x;
        leaf->y[lane] = r->y;
        leaf->z[lane] = r->z;
        leaf->gap[lane] = INFINITY;
        job->ids[position] = r->id;
        if (job->tree->normals != NULL) {
            enum { AHEAD = 16 };
            if (i + AHEAD < count) {
                __builtin_prefetch(normals + 3 * (size_t)records[(uint32_t)items[i + AHEAD]].id);
            }
            stp_leaf_normals* out = &job->tree->normals[position / STP_LEAF_SIZE];
            const float* n = normals + 3 * (size_t)r->id;
            out->x[lane] = n[0];
            out->y[lane] = n[1];
            out->z[lane] = n[2];
        }
    }
}

static void sort_cells(size_t begin, size_t end, uint32_t worker, void* user)
{
    const sort_job* job = user;
    uint64_t* items = job->items + (size_t)worker * 2 * job->item_stride;
    uint64_t* scratch = items + job->item_stride;
    for (size_t cell = begin; cell < end; ++cell) {
        uint32_t first = job->starts[cell];
        size_t count = job->starts[cell + 1] - first;
        const record* records = job->records + first;
        for (size_t i = 0; i < count; ++i) {
            items[i] = place_of(job, &records[i], FINEST_BITS, FINE_BITS) << 32 | i;
        }
        uint64_t* sorted = sort_items(items, scratch, count, 3 * FINE_BITS);
        refine_runs(job, records, sorted, sorted == items ? scratch : items, count);
        write_leaves(job, records, sorted, first, count);
    }
}

static void sort_free(stp_context* context, sort_job* job)
{
    stp_free(context, job->cells);
    stp_free(context, job->offsets);
    stp_free(context, job->starts);
    stp_free(context, job->records);
    stp_free(context, job->items);
}

stp_result stp_points_sort(const stp_points* points, const stp_team* team, stp_tree* tree,
                           uint32_t* ids)
{
    stp_context* context = team->context;
    float scale = points->scale;
    stp_box box = points->box;
    stp_vec3 low = stp_scale(box.min, scale), high = stp_scale(box.max, scale);
    float extent = stp_max(stp_max(high.x - low.x, high.y - low.y), high.z - low.z);
    size_t chunks = ((size_t)points->count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    sort_job job = {.points = points, .tree = tree, .ids = ids, .low = low};
    job.quanta = extent > 0.0f ? (float)(1u << QUANTUM_BITS) / extent : 0.0f;
    job.cells = STP_NEW_ARRAY(context, uint16_t, points->count);
    job.offsets = STP_NEW_ARRAY(context, uint32_t, chunks * CELL_COUNT);
    job.starts = STP_NEW_ARRAY(context, uint32_t, CELL_COUNT + 1);
    job.records = STP_NEW_ARRAY(context, record, points->count);
    if (job.cells == NULL || job.offsets == NULL || job.starts == NULL || job.records == NULL) {
        sort_free(context, &job);
        return stp_fail_memory(context);
    }
    stp_team_run(team, points->count, CHUNK_SIZE, count_cells, &job);
    job.item_stride = place_cells(&job, chunks);
    job.items = STP_NEW_ARRAY(context, uint64_t, 2 * job.item_stride * team->threads);
    if (job.items == NULL) {
        sort_free(context, &job);
        return stp_fail_memory(context);
    }
    stp_team_run(team, points->count, CHUNK_SIZE, deal_out, &job);
    stp_team_run(team, CELL_COUNT, 8, sort_cells, &job);
    sort_free(context, &job);
    return STP_OK;
}
