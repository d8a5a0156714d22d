// SPDX-License-Identifier: MIT
#include "lod/blue/growths.h"

#include "base/core/processor.h"
#include "lod/blue/growths_kernels.h"
#include "lod/grid.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    LEVELS = 3,         ///< grids, each with cells twice as wide
    FINE_POINTS = 24,   ///< points of a bucket that are compared: the first of the order
    COARSE_POINTS = 32, ///< the same for wide gaps
    VOLUME =
        6, ///< from so many steep neighbours on, wide gaps are those of leaves, not of a surface
    OUTSTANDING = 2, ///< how far a growth may be above the median around it
    ENOUGH = 3,      ///< so many points of a cell tell a median
    GRAIN = 1024     ///< buckets
};

#define FINE_CELL 2.5f    // side of a cell, in spacings
#define FIRST 0.6f        // neighbours within so many sides of a cell cut first
#define STEEP_WITHIN 0.8f // where steep neighbours count, in sides of a cell
#define CLOSED 3.0f       // a cell that reaches less far there is closed, in covered distances
#define HOLE 2.0f         // how far it then counts
#define TOLERANCE 1.06f   // radii that are this much too small are good enough

_Static_assert(27 * COARSE_POINTS + STP_GROWTH_LANES <= STP_AROUND_MAX, "neighbours fit");

static const float factors[STP_GROWTHS] = {0.125f,    0.176777f, 0.25f,     0.353553f, 0.5f,
                                           0.707107f, 1.0f,      1.414214f, 2.0f,      2.828427f,
                                           4.0f,      5.656854f, 8.0f};

float stp_growth_factor(uint32_t growth)
{
    assert(growth < STP_GROWTHS);
    return factors[growth];
}

const stp_growth_kernels* stp_growth_kernels_select(void)
{
#if defined(__x86_64__)
    if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
        return &stp_growth_kernels_avx2;
    }
#endif
    return &stp_growth_kernels_portable;
}

typedef struct gap_search {
    const stp_growth_desc* desc;
    const stp_growth_kernels* kernels;
    stp_grid grids[LEVELS]; ///< of all points, then of sparse ones
    stp_cell_limits limits;
    float thresholds[STP_GROWTHS]; ///< how far each growth is enough
    uint8_t* found;                ///< growth of each point, in the order of the fine grid
    uint8_t* growths;              ///< the same, and not far above those around it
} gap_search;

/// The cells of a grid around a place, and the points in them.
typedef struct surroundings {
    const stp_grid* grid;
    uint32_t limit;  ///< points of a bucket that count
    int32_t cell[3]; ///< the middle one
    bool known;      ///< whether there is one
    uint32_t count;
    uint32_t begins[27], ends[27]; ///< ranges of points
    stp_around around;             ///< the same points
} surroundings;

static void add_range(surroundings* s, uint32_t begin, uint32_t end)
{
    assert(s->count < 27);
    s->begins[s->count] = begin;
    s->ends[s->count] = end;
    s->count += begin != end ? 1 : 0;
}

/// Adds the first points of each of consecutive buckets.
static inline void add_buckets(surroundings* s, uint32_t bucket, uint32_t count)
{
    const uint32_t* starts = s->grid->starts + bucket;
    if (starts[count] - starts[0] <= s->limit) { // mostly
        add_range(s, starts[0], starts[count]);
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t points = starts[i + 1] - starts[i];
        add_range(s, starts[i], starts[i] + (points < s->limit ? points : s->limit));
    }
}

/// Moves to the 27 cells around a place. Cells of a row that are of one block are consecutive
/// buckets. @return whether they are others than before
static bool move_to(surroundings* s, stp_vec3 place)
{
    const stp_grid* grid = s->grid;
    int32_t x = stp_grid_cell(grid, place.x), y = stp_grid_cell(grid, place.y),
            z = stp_grid_cell(grid, place.z);
    if (s->known && s->cell[0] == x && s->cell[1] == y && s->cell[2] == z) {
        return false; // mostly
    }
    s->known = true;
    s->cell[0] = x, s->cell[1] = y, s->cell[2] = z;
    s->count = 0;
    int32_t split = ((x - 1) | 3) + 1; // where the next block begins
    uint32_t first = split > x + 1 ? 3 : (uint32_t)(split - (x - 1));
    for (int i = 0; i < 9; ++i) {
        int32_t row = y + i % 3 - 1, layer = z + i / 3 - 1;
        add_buckets(s, stp_grid_bucket(grid, x - 1, row, layer), first);
        if (first < 3) {
            add_buckets(s, stp_grid_bucket(grid, split, row, layer), 3 - first);
        }
    }
    return true;
}

/// Copies the points around, in whole vectors.
static void copy_points(surroundings* s)
{
    const float *x = s->grid->x, *y = s->grid->y, *z = s->grid->z;
    stp_around* to = &s->around;
    uint32_t next = 0;
    for (uint32_t r = 0; r < s->count; ++r) {
        uint32_t begin = s->begins[r], count = s->ends[r] - begin;
        assert(next + count + STP_GROWTH_LANES <= STP_AROUND_MAX);
        for (uint32_t i = 0; i < count; i += STP_GROWTH_LANES) {
            memcpy(to->x + next + i, x + begin + i, STP_GROWTH_LANES * sizeof(float));
            memcpy(to->y + next + i, y + begin + i, STP_GROWTH_LANES * sizeof(float));
            memcpy(to->z + next + i, z + begin + i, STP_GROWTH_LANES * sizeof(float));
        }
        next += count;
    }
    for (; next % STP_GROWTH_LANES != 0; ++next) {
        to->x[next] = to->y[next] = to->z[next] = INFINITY;
    }
    to->count = next;
}

static void begin_surroundings(surroundings* s, const stp_grid* grid, uint32_t limit)
{
    s->grid = grid;
    s->limit = limit;
    s->known = false;
}

static void begin_cell(const stp_growth_desc* d, uint32_t index, stp_plane_cell* cell)
{
    const float *p = d->positions + 3 * (size_t)index, *n = d->normals + 3 * (size_t)index;
    *cell = (stp_plane_cell){
        .point = {p[0], p[1], p[2]}, .normal = {n[0], n[1], n[2]}, .beyond = INFINITY};
    stp_vec3 axis =
        fabsf(n[0]) < 0.6f ? (stp_vec3){1.0f, 0.0f, 0.0f} : (stp_vec3){0.0f, 1.0f, 0.0f};
    cell->across = stp_normalize(stp_cross(cell->normal, axis));
    cell->along = stp_cross(cell->normal, cell->across);
}

static uint8_t growth_for(const gap_search* s, float reach)
{
    uint32_t growth = 0;
    for (int k = 0; k < STP_GROWTHS - 1; ++k) {
        growth += s->thresholds[k] < reach ? 1 : 0;
    }
    return (uint8_t)(growth < STP_GROWTH_PLAIN && !s->desc->smaller ? STP_GROWTH_PLAIN : growth);
}

/// Cuts the cell of a point by the points around, in ever wider cells of grids until it is closed.
static void find_cell(const gap_search* s, surroundings levels[LEVELS], stp_plane_cell* cell)
{
    float seen = 0.0f; // flat neighbours up to here have cut, squared
    for (int i = 0; i < LEVELS; ++i) {
        surroundings* level = &levels[i];
        if (move_to(level, cell->point)) {
            copy_points(level);
        }
        float side = level->grid->cell, first = i == 0 ? FIRST * side : side;
        float steep = i == 0 ? STEEP_WITHIN * side : 0.0f;
        s->kernels->cut(&level->around, seen, first * first, steep * steep, cell);
        if (cell->least * side >= 2.0f || cell->steep >= VOLUME) {
            break;
        }
        seen = 0.5f * side * side; // flat ones are up to sqrt(2) times as far away
    }
}

static void search_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    const stp_grid* grid = &s->grids[0];
    surroundings levels[LEVELS];
    for (int i = 0; i < LEVELS; ++i) {
        begin_surroundings(&levels[i], &s->grids[i], i == 0 ? FINE_POINTS : COARSE_POINTS);
    }
    for (uint32_t at = grid->starts[begin]; at < grid->starts[end]; ++at) {
        stp_plane_cell cell;
        begin_cell(s->desc, grid->index[at], &cell);
        find_cell(s, levels, &cell);
        s->found[at] = growth_for(s, s->kernels->reach(&s->limits, &cell));
    }
}

/// How many points have a growth of at most each index.
typedef struct growth_counts {
    uint32_t at_most[STP_GROWTHS];
} growth_counts;

static growth_counts count_growths(const uint8_t* found, const uint32_t* begins,
                                   const uint32_t* ends, uint32_t ranges)
{
    growth_counts c = {{0}};
    for (uint32_t r = 0; r < ranges; ++r) {
        for (uint32_t at = begins[r]; at < ends[r]; ++at) {
            c.at_most[found[at]] += 1;
        }
    }
    for (uint32_t k = 1; k < STP_GROWTHS; ++k) {
        c.at_most[k] += c.at_most[k - 1];
    }
    return c;
}

/// The largest growth up to a given one that is at most OUTSTANDING above the median of the others.
static uint32_t limit_growth(uint32_t growth, const growth_counts* c)
{
    while (growth > STP_GROWTH_PLAIN &&
           2 * c->at_most[growth - OUTSTANDING - 1] + 1 >= c->at_most[STP_GROWTHS - 1]) {
        growth -= 1;
    }
    return growth;
}

/// Limits growths that are far above those around them, of points in the air, whose neighbours in
/// the plane are not of their surface: those of the same cell, or in 27 cells if these are few.
static void limit_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    const stp_grid* grid = &s->grids[0];
    surroundings around;
    growth_counts own = {{0}}, wide = {{0}}; // of the cell, and of those around
    begin_surroundings(&around, grid, FINE_POINTS);
    for (size_t bucket = begin; bucket < end; ++bucket) {
        uint32_t first = grid->starts[bucket], last = grid->starts[bucket + 1];
        bool enough = last - first >= ENOUGH;
        if (enough) {
            own = count_growths(s->found, &first, &last, 1);
        }
        for (uint32_t at = first; at < last; ++at) {
            uint32_t growth = s->found[at];
            if (!enough && growth > STP_GROWTH_PLAIN &&
                move_to(&around, (stp_vec3){grid->x[at], grid->y[at], grid->z[at]})) {
                wide = count_growths(s->found, around.begins, around.ends, around.count);
            }
            if (growth > STP_GROWTH_PLAIN) {
                growth = limit_growth(growth, enough ? &own : &wide);
            }
            s->growths[grid->index[at]] = (uint8_t)growth;
        }
    }
}

static gap_search make_search(const stp_growth_desc* desc, uint8_t* growths)
{
    float plain = desc->covered + desc->radius;
    gap_search s = {.desc = desc,
                    .kernels = stp_growth_kernels_select(),
                    .limits = {.plain = plain,
                               .closed = 1.0f / (CLOSED * plain),
                               .hole = HOLE * plain,
                               .most = desc->covered + desc->radius * factors[STP_GROWTHS - 1]},
                    .growths = growths};
    for (uint32_t i = 0; i < STP_GROWTHS; ++i) {
        s.thresholds[i] = (desc->covered + desc->radius * factors[i]) * TOLERANCE;
    }
    return s;
}

stp_result stp_growths_find(stp_context* context, const stp_growth_desc* desc, uint8_t* growths)
{
    assert(desc->spacing > 0.0f && desc->radius > 0.0f && desc->sparse_count <= desc->count);
    gap_search s = make_search(desc, growths);
    s.found = STP_NEW_ARRAY(context, uint8_t, desc->count);
    stp_result result = s.found == NULL ? stp_fail_memory(context) : STP_OK;
    float side = FINE_CELL * desc->spacing;
    for (int i = 0; i < LEVELS && result == STP_OK; ++i, side *= 2.0f) {
        result =
            stp_grid_create(context, desc->positions, NULL,
                            i == 0 ? desc->count : desc->sparse_count, side, 0.0f, &s.grids[i]);
    }
    if (result == STP_OK) {
        stp_parallel_for(context, (size_t)s.grids[0].mask + 1, GRAIN, search_buckets, &s);
        stp_parallel_for(context, (size_t)s.grids[0].mask + 1, GRAIN, limit_buckets, &s);
    }
    stp_free(context, s.found);
    for (int i = 0; i < LEVELS; ++i) {
        stp_grid_destroy(context, &s.grids[i]);
    }
    return result;
}
