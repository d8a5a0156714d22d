// SPDX-License-Identifier: MIT
#include "capture/fill.h"

#include <string.h>

#define QUERY_GRAIN ((size_t)4096)

// Of the corners, faces and edges of a cube, those that were not drawn: 8 and 14 directions are the first of
// them (capture.h); a spiral shares none.
static uint32_t find_directions(uint32_t count, stp_vec3d* directions)
{
    stp_vec3d all[STP_CAPTURE_FILL_DIRECTIONS];
    stp_capture_directions(STP_CAPTURE_FILL_DIRECTIONS, all);
    uint32_t shared = count == 8 || count == 14 ? count : 0;
    uint32_t left = STP_CAPTURE_FILL_DIRECTIONS - shared;
    memcpy(directions, all + shared, left * sizeof(all[0]));
    return left;
}

// Puts the bands of the further views behind the first ones'.
static stp_result append_bands(stp_capture_job* job, const stp_capture_job* first)
{
    stp_context* context = job->scene->context;
    size_t count = first->band_count + job->band_count;
    stp_capture_band* bands = STP_NEW_ARRAY(context, stp_capture_band, count);
    if (bands == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < job->band_count; ++i) {
        job->bands[i].view += first->view_count;
    }
    if (first->band_count > 0) {
        memcpy(bands, first->bands, first->band_count * sizeof(*bands));
    }
    if (job->band_count > 0) {
        memcpy(bands + first->band_count, job->bands, job->band_count * sizeof(*bands));
    }
    stp_free(context, first->bands);
    stp_free(context, job->bands);
    job->bands = bands;
    job->band_count = count;
    job->covered_pixels += first->covered_pixels;
    return STP_OK;
}

stp_result stp_capture_draw_fill(stp_capture_job* job, uint32_t count, double pixel_size)
{
    stp_vec3d directions[STP_CAPTURE_FILL_DIRECTIONS];
    uint32_t more = find_directions(count, directions);
    stp_capture_job first = *job;
    job->views = first.views + first.view_count;
    job->bands = NULL;
    job->band_count = 0;
    job->covered_pixels = 0;
    stp_capture_set_views(job, directions, more, pixel_size);
    stp_result result = stp_capture_draw(job);
    if (result == STP_OK) {
        result = append_bands(job, &first);
    }
    if (result != STP_OK) { // what was drawn first is still the job's, to be dropped by its owner
        stp_capture_drop_bands(job);
        job->bands = first.bands;
        job->band_count = first.band_count;
        job->covered_pixels = first.covered_pixels;
    }
    job->views = first.views;
    job->view_count = first.view_count + more;
    return result;
}

typedef struct cell_point {
    float position[3], normal[3];
} cell_point;

// A hash table of cells twice as wide as the distance that is asked for. Points of a cell lie together, and so do
// cells that are neighbours along x: most questions stay within a cache line or two.
typedef struct cell_grid {
    const stp_candidates* candidates;
    double scale; ///< cells per unit
    float reach;  ///< distance within which a candidate stands for another
    uint32_t mask;
    uint32_t* starts; ///< of each slot, and one more
    cell_point* points;
} cell_grid;

static int64_t cell_of(const cell_grid* grid, float coordinate)
{
    double at = (double)coordinate * grid->scale + 0x1p31;
    return at > 0.0 && at < 0x1p32 ? (int64_t)at : 0;
}

static uint32_t slot_of(const cell_grid* grid, int64_t x, int64_t y, int64_t z)
{
    uint64_t key =
        (uint64_t)y * UINT64_C(0xC2B2AE3D27D4EB4F) ^ (uint64_t)z * UINT64_C(0x165667B19E3779F9);
    key ^= key >> 29;
    key *= UINT64_C(0xBF58476D1CE4E5B9);
    return ((uint32_t)(key >> 32) + (uint32_t)x) & grid->mask;
}

static uint32_t slot_of_point(const cell_grid* grid, uint32_t point)
{
    const float* p = grid->candidates->positions + 3 * (size_t)point;
    return slot_of(grid, cell_of(grid, p[0]), cell_of(grid, p[1]), cell_of(grid, p[2]));
}

static stp_result make_grid(stp_context* context, cell_grid* grid, uint32_t count)
{
    uint32_t slots = 64;
    while (slots < count && slots < UINT32_C(1) << 30) {
        slots *= 2;
    }
    grid->mask = slots - 1;
    grid->starts = STP_NEW_ZEROED(context, uint32_t, (size_t)slots + 1);
    grid->points = STP_NEW_ARRAY(context, cell_point, count);
    if (grid->starts == NULL || grid->points == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        grid->starts[slot_of_point(grid, i)] += 1;
    }
    uint32_t sum = 0;
    for (uint32_t slot = 0; slot <= slots; ++slot) { // ends first; filling turns them into starts
        sum += grid->starts[slot];
        grid->starts[slot] = sum;
    }
    for (uint32_t i = count; i-- > 0;) {
        cell_point* point = &grid->points[--grid->starts[slot_of_point(grid, i)]];
        memcpy(point->position, grid->candidates->positions + 3 * (size_t)i,
               sizeof(point->position));
        memcpy(point->normal, grid->candidates->normals + 3 * (size_t)i, sizeof(point->normal));
    }
    return STP_OK;
}

static bool slot_has_stand_in(const cell_grid* grid, uint32_t slot, const float* p, const float* n)
{
    float least = grid->reach * grid->reach;
    for (uint32_t k = grid->starts[slot]; k < grid->starts[slot + 1]; ++k) {
        const float* q = grid->points[k].position;
        const float* m = grid->points[k].normal;
        float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
        if ((x * x + y * y) + z * z <= least && (n[0] * m[0] + n[1] * m[1]) + n[2] * m[2] > 0.0f) {
            return true;
        }
    }
    return false;
}

// Whether a candidate of the first views stands for this one. Cells are twice the reach wide, so eight hold
// all that is near enough.
static bool has_stand_in(const cell_grid* grid, uint32_t point)
{
    const float* p = grid->candidates->positions + 3 * (size_t)point;
    const float* n = grid->candidates->normals + 3 * (size_t)point;
    int64_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = cell_of(grid, p[k] - grid->reach);
        high[k] = cell_of(grid, p[k] + grid->reach);
    }
    for (int64_t z = low[2]; z <= high[2]; ++z) {
        for (int64_t y = low[1]; y <= high[1]; ++y) {
            for (int64_t x = low[0]; x <= high[0]; ++x) {
                if (slot_has_stand_in(grid, slot_of(grid, x, y, z), p, n)) {
                    return true;
                }
            }
        }
    }
    return false;
}

typedef struct query {
    const cell_grid* grid;
    uint32_t first;
    uint8_t* keep; ///< of each candidate from `first` on
} query;

static void query_range(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    query* q = user;
    for (size_t i = begin; i < end; ++i) {
        q->keep[i] = !has_stand_in(q->grid, q->first + (uint32_t)i);
    }
}

static void move_candidate(stp_candidates* c, size_t from, size_t to)
{
    memmove(c->positions + 3 * to, c->positions + 3 * from, 3 * sizeof(float));
    memmove(c->normals + 3 * to, c->normals + 3 * from, 3 * sizeof(float));
    memmove(c->colors + 4 * to, c->colors + 4 * from, 4);
    c->materials[to] = c->materials[from];
}

stp_result stp_capture_keep_missing(stp_context* context, stp_candidates* candidates,
                                    uint32_t first)
{
    size_t more = candidates->count - first;
    if (more == 0) {
        return STP_OK;
    }
    float reach = (float)candidates->pixel_size;
    cell_grid grid = {.candidates = candidates, .scale = 0.5 / (double)reach, .reach = reach};
    uint8_t* keep = STP_NEW_ARRAY(context, uint8_t, more);
    stp_result result = keep != NULL ? make_grid(context, &grid, first) : stp_fail_memory(context);
    if (result == STP_OK) {
        query q = {&grid, first, keep};
        stp_parallel_for(context, more, QUERY_GRAIN, query_range, &q);
        size_t kept = first;
        for (size_t i = 0; i < more; ++i) {
            if (keep[i] != 0) {
                move_candidate(candidates, first + i, kept++);
            }
        }
        candidates->count = (uint32_t)kept;
    }
    stp_free(context, grid.starts);
    stp_free(context, grid.points);
    stp_free(context, keep);
    return result;
}
