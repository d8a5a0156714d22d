// SPDX-License-Identifier: MIT
#include "base/math/f32x8.h"
#include "lod/neighbours_kernels.h"

#include <assert.h>
#include <string.h>

#define ANY_AGREEMENT (-2.0f) // below any dot product of two normals
#define LIST_SIZE 128u        // surfels around a cell of samples; rarely more

static inline i32x8 find_cells(const stp_grid* grid, const float* coordinates)
{
    f32x8 cell = f32x8_sub(f32x8_load(coordinates), f32x8_set(grid->offset));
    cell = f32x8_mul(cell, f32x8_set(grid->inverse_cell));
    cell = f32x8_min(f32x8_max(cell, f32x8_set(-1e9f)), f32x8_set(1e9f));
    return f32x8_truncate(f32x8_floor(cell));
}

// Which of eight numbers are the same as that of the first lane of another eight.
static inline i32x8 equal_first(i32x8 a, i32x8 first)
{
    return i32x8_equal(a, i32x8_repeat_first(first));
}

static uint32_t find_run(const stp_grid* samples, uint32_t begin, uint32_t end)
{
    assert(begin < end && end <= samples->count);
    i32x8 x = find_cells(samples, samples->x + begin), y = find_cells(samples, samples->y + begin),
          z = find_cells(samples, samples->z + begin);
    i32x8 first_x = x, first_y = y, first_z = z;
    for (uint32_t run = begin;;) {
        i32x8 same = i32x8_and(equal_first(x, first_x), equal_first(y, first_y));
        same = i32x8_and(same, equal_first(z, first_z));
        uint32_t other = ~i32x8_signs(same) & 0xff;
        uint32_t same_count = other != 0 ? (uint32_t)__builtin_ctz(other) : STP_NEAR_LANES;
        if (other != 0 || end - run <= STP_NEAR_LANES) {
            return run + (same_count < end - run ? same_count : end - run);
        }
        run += STP_NEAR_LANES;
        x = find_cells(samples, samples->x + run);
        y = find_cells(samples, samples->y + run);
        z = find_cells(samples, samples->z + run);
    }
}

// Surfels as columns.
typedef struct surfel_columns {
    const float *x, *y, *z, *nx, *ny, *nz;
    const uint32_t* index;
} surfel_columns;

// Eight samples and their nearest surfels so far.
typedef struct eight_samples {
    vector3x8 place, normal;
    f32x8 minimum;
    i32x8 surfel;
} eight_samples;

static inline eight_samples load_samples(const stp_grid* samples, uint32_t at, stp_near_rule rule)
{
    return (eight_samples){vector3x8_load(samples->x + at, samples->y + at, samples->z + at),
                           vector3x8_load(samples->nx + at, samples->ny + at, samples->nz + at),
                           f32x8_set(rule.limit), i32x8_set(-1)};
}

// Branch-free: whether one of eight samples is nearer cannot be predicted.
static inline void test_surfel(eight_samples* e, vector3x8 place, const vector3x8* normal,
                               i32x8 index, f32x8 agreed)
{
    vector3x8 d = vector3x8_subtract(e->place, place);
    f32x8 squared = vector3x8_dot(d, d);
    i32x8 lower = i32x8_equal(i32x8_min_unsigned(index, e->surfel), index);
    i32x8 tie = i32x8_and(f32x8_equal(squared, e->minimum), lower);
    i32x8 nearer = i32x8_or(f32x8_less(squared, e->minimum), tie);
    if (normal != NULL) {
        i32x8 facing = f32x8_less_equal(agreed, vector3x8_dot(e->normal, *normal));
        nearer = i32x8_and(nearer, facing);
    }
    e->minimum = f32x8_select(nearer, squared, e->minimum);
    e->surfel = i32x8_select(nearer, index, e->surfel);
}

static inline void test_surfels(eight_samples* a, eight_samples* b, const surfel_columns* from,
                                uint32_t begin, uint32_t end, bool sides, f32x8 agreed)
{
    for (uint32_t i = begin; i < end; ++i) {
        vector3x8 place = vector3x8_set(from->x[i], from->y[i], from->z[i]), facing;
        const vector3x8* normal = NULL;
        if (sides) {
            facing = vector3x8_set(from->nx[i], from->ny[i], from->nz[i]);
            normal = &facing;
        }
        i32x8 index = i32x8_set((int)from->index[i]);
        test_surfel(a, place, normal, index, agreed);
        if (b != NULL) {
            test_surfel(b, place, normal, index, agreed);
        }
    }
}

static inline void store_nearest(uint32_t* nearest, uint32_t count, i32x8 surfel)
{
    assert(count > 0 && "counts above eight mean all lanes");
    int32_t all[STP_NEAR_LANES];
    i32x8_store(all, surfel);
    memcpy(nearest, all, (count < STP_NEAR_LANES ? count : STP_NEAR_LANES) * sizeof(*nearest));
}

// Surfels of all ranges in one list. Copies may write eight values past the end.
typedef struct surfel_list {
    float x[LIST_SIZE + 8], y[LIST_SIZE + 8], z[LIST_SIZE + 8];
    float nx[LIST_SIZE + 8], ny[LIST_SIZE + 8], nz[LIST_SIZE + 8];
    uint32_t index[LIST_SIZE + 8];
} surfel_list;

static inline void copy_eight(float* to, const float* from)
{
    f32x8_store(to, f32x8_load(from));
}

// Copies the surfels of all ranges. @return their number; LIST_SIZE + 1 if there are too many
static inline uint32_t list_surfels(surfel_list* list, const stp_grid* surfels,
                                    const stp_near_ranges* ranges, bool sides)
{
    uint32_t count = 0;
    for (uint32_t range = 0; range < ranges->count; ++range) {
        uint32_t begin = ranges->begins[range], end = ranges->ends[range];
        if (end - begin > LIST_SIZE - count) {
            return LIST_SIZE + 1;
        }
        for (uint32_t i = begin, to = count; i < end; i += 8, to += 8) {
            copy_eight(list->x + to, surfels->x + i);
            copy_eight(list->y + to, surfels->y + i);
            copy_eight(list->z + to, surfels->z + i);
            if (sides) {
                copy_eight(list->nx + to, surfels->nx + i);
                copy_eight(list->ny + to, surfels->ny + i);
                copy_eight(list->nz + to, surfels->nz + i);
            }
            memcpy(list->index + to, surfels->index + i, STP_NEAR_LANES * sizeof(uint32_t));
        }
        count += end - begin;
        assert(count <= LIST_SIZE);
    }
    return count;
}

// Compiled twice: with normals, and without them.
static inline __attribute__((always_inline)) void
find_nearest_of(const stp_grid* surfels, const stp_near_ranges* ranges, const stp_grid* samples,
                uint32_t begin, uint32_t end, stp_near_rule rule, bool sides, uint32_t* nearest)
{
    surfel_list list;
    stp_near_ranges whole = {
        .count = 1, .begins = {0}, .ends = {list_surfels(&list, surfels, ranges, sides)}};
    surfel_columns from = {list.x, list.y, list.z, list.nx, list.ny, list.nz, list.index};
    if (whole.ends[0] > LIST_SIZE) {
        from = (surfel_columns){surfels->x,  surfels->y,  surfels->z,    surfels->nx,
                                surfels->ny, surfels->nz, surfels->index};
    } else {
        ranges = &whole;
    }
    f32x8 agreed = f32x8_set(rule.min_agreement);
    uint32_t at = begin;
    for (; end - at > STP_NEAR_LANES; at += end - at < 16 ? end - at : 16) {
        eight_samples a = load_samples(samples, at, rule);
        eight_samples b = load_samples(samples, at + 8, rule);
        for (uint32_t range = 0; range < ranges->count; ++range) {
            test_surfels(&a, &b, &from, ranges->begins[range], ranges->ends[range], sides, agreed);
        }
        store_nearest(nearest + at, 8, a.surfel);
        store_nearest(nearest + at + 8, end - at - 8, b.surfel);
    }
    if (at < end) {
        eight_samples a = load_samples(samples, at, rule);
        for (uint32_t range = 0; range < ranges->count; ++range) {
            test_surfels(&a, NULL, &from, ranges->begins[range], ranges->ends[range], sides,
                         agreed);
        }
        store_nearest(nearest + at, end - at, a.surfel);
    }
}

static void find_nearest(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t begin, uint32_t end, stp_near_rule rule,
                         uint32_t* nearest)
{
    if (rule.min_agreement > ANY_AGREEMENT) {
        find_nearest_of(surfels, ranges, samples, begin, end, rule, true, nearest);
    } else {
        find_nearest_of(surfels, ranges, samples, begin, end, rule, false, nearest);
    }
}

// One axis of stp_stencil_cells: the first and the last cell of eight squares; @return which
// squares touch any cell
static inline i32x8 span_cells(f32x8 centre, f32x8 half, i32x8* first, i32x8* last)
{
    f32x8 four = f32x8_set(4.0f);
    f32x8 low = f32x8_mul(four, f32x8_sub(centre, half));
    f32x8 high = f32x8_mul(four, f32x8_add(centre, half));
    f32x8 own = f32x8_add(f32x8_mul(four, centre), four);
    low = f32x8_min(f32x8_add(low, f32x8_set(4.5f)), own);
    high = f32x8_max(f32x8_add(high, f32x8_set(3.5f)), own);
    *first = f32x8_truncate(f32x8_max(low, f32x8_set(0.0f)));
    *last = f32x8_truncate(f32x8_min(high, f32x8_set(7.0f)));
    return i32x8_and(f32x8_less_equal(f32x8_set(0.0f), high), f32x8_less(low, f32x8_set(8.0f)));
}

// Bytes with the bits from the first to the last set.
static inline i32x8 set_bits(i32x8 first, i32x8 last)
{
    i32x8 all = i32x8_set(0xff);
    i32x8 above = i32x8_sub(i32x8_set(7), last);
    return i32x8_and(i32x8_left_by(all, first), i32x8_right_by(all, above));
}

// All cells of eight squares; of those samples that are near.
static inline uint64_t join_cells(f32x8 u, f32x8 v, f32x8 footprint, i32x8 near)
{
    i32x8 first, last, first_row, last_row;
    near = i32x8_and(near, span_cells(u, footprint, &first, &last));
    near = i32x8_and(near, span_cells(v, footprint, &first_row, &last_row));
    i32x8 columns = i32x8_and(set_bits(first, last), near);
    return i32x8_join_bytes(columns, first_row, last_row);
}

static inline void add_fractions(const stp_grid* samples, uint32_t at, uint32_t near,
                                 const uint16_t* fractions, stp_disk* disk)
{
    for (; near != 0; near &= near - 1) {
        disk->fractions += fractions[samples->index[at + (uint32_t)__builtin_ctz(near)]];
    }
}

// Half sides of eight samples' squares. Adds the additional weight of near samples of sets.
static inline f32x8 choose_footprints(const stp_grid* samples, uint32_t at, uint32_t near,
                                      const stp_disk_query* query, stp_disk* disk)
{
    i32x8 index = i32x8_load((const int32_t*)samples->index + at);
    i32x8 first = i32x8_set((int)query->first_of_sets);
    i32x8 of_set = i32x8_equal(i32x8_max_unsigned(index, first), index);
    near &= i32x8_signs(of_set);
    disk->count += (uint32_t)__builtin_popcount(near) * (query->set_weight - 1);
    return f32x8_select(of_set, f32x8_set(query->set_footprint), f32x8_set(query->footprint));
}

static bool scan_disk(const stp_grid* samples, const stp_near_ranges* ranges,
                      const stp_disk_query* query, stp_disk* disk)
{
    const stp_vec3 *s = &query->tangents[0], *t = &query->tangents[1];
    vector3x8 centre = vector3x8_set(query->x, query->y, query->z);
    vector3x8 normal = vector3x8_set(query->nx, query->ny, query->nz);
    vector3x8 across = vector3x8_set(s->x, s->y, s->z), along = vector3x8_set(t->x, t->y, t->z);
    f32x8 limit = f32x8_set(query->limit), agreed = f32x8_set(query->min_agreement);
    bool sides = query->min_agreement > ANY_AGREEMENT;
    f32x8 footprint = f32x8_set(query->footprint);
    i32x8 lanes = i32x8_index();
    for (uint32_t range = 0; range < ranges->count; ++range) {
        uint32_t end = ranges->ends[range];
        assert(end <= samples->count);
        for (uint32_t at = ranges->begins[range]; at < end; at += STP_NEAR_LANES) {
            vector3x8 offset = vector3x8_subtract(
                vector3x8_load(samples->x + at, samples->y + at, samples->z + at), centre);
            i32x8 near = f32x8_less_equal(vector3x8_dot(offset, offset), limit);
            if (sides) {
                vector3x8 other =
                    vector3x8_load(samples->nx + at, samples->ny + at, samples->nz + at);
                near = i32x8_and(near, f32x8_less_equal(agreed, vector3x8_dot(normal, other)));
            }
            i32x8 left = i32x8_greater(i32x8_set((int)(end - at)), lanes);
            near = i32x8_and(near, left);
            uint32_t mask = i32x8_signs(near);
            if (mask == 0) {
                continue;
            }
            disk->count += (uint32_t)__builtin_popcount(mask);
            if (query->fractions != NULL) {
                add_fractions(samples, at, mask, query->fractions, disk);
            }
            if (query->first_of_sets != UINT32_MAX) {
                footprint = choose_footprints(samples, at, mask, query, disk);
            }
            uint64_t cells =
                query->stencil->disk & join_cells(vector3x8_dot(offset, across),
                                                  vector3x8_dot(offset, along), footprint, near);
            if ((cells & ~disk->cells) != 0) {
                disk->cells |= cells;
                disk->full = stp_stencil_is_full(query->stencil, disk->cells);
                if (disk->full && query->until_full) {
                    return true;
                }
            }
        }
    }
    return false;
}

static float nearest_squared(const float* x, const float* y, const float* z, uint32_t count,
                             stp_vec3 place)
{
    assert(count % STP_NEAR_LANES == 0);
    vector3x8 centre = vector3x8_set(place.x, place.y, place.z);
    f32x8 minimum = f32x8_set(FLT_MAX);
    for (uint32_t i = 0; i < count; i += STP_NEAR_LANES) {
        vector3x8 offset = vector3x8_subtract(centre, vector3x8_load(x + i, y + i, z + i));
        minimum = f32x8_min(minimum, vector3x8_dot(offset, offset));
    }
    return f32x8_lowest(minimum);
}

const stp_near_kernels stp_near_kernels_vector = {find_run, find_nearest, scan_disk,
                                                  nearest_squared};
