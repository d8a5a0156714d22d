// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

#if defined(__x86_64__)

#include <assert.h>
#include <immintrin.h>

#define ANY_AGREEMENT (-2.0f) // below any dot product of two normals
#define LIST_SIZE 128u        // surfels around a cell of samples; rarely more

typedef struct vector3 {
    __m256 x, y, z;
} vector3;

static inline vector3 load_vectors(const float* x, const float* y, const float* z)
{
    return (vector3){_mm256_loadu_ps(x), _mm256_loadu_ps(y), _mm256_loadu_ps(z)};
}

static inline vector3 repeat_vector(float x, float y, float z)
{
    return (vector3){_mm256_set1_ps(x), _mm256_set1_ps(y), _mm256_set1_ps(z)};
}

static inline vector3 subtract(vector3 a, vector3 b)
{
    return (vector3){_mm256_sub_ps(a.x, b.x), _mm256_sub_ps(a.y, b.y), _mm256_sub_ps(a.z, b.z)};
}

// Sums in the same order as the portable variant's, without fused multiply-add.
static inline __m256 dot(vector3 a, vector3 b)
{
    __m256 sum = _mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y));
    return _mm256_add_ps(sum, _mm256_mul_ps(a.z, b.z));
}

static inline __m256i find_cells(const stp_grid* grid, const float* coordinates)
{
    __m256 cell = _mm256_sub_ps(_mm256_loadu_ps(coordinates), _mm256_set1_ps(grid->offset));
    cell = _mm256_mul_ps(cell, _mm256_set1_ps(grid->inverse_cell));
    cell = _mm256_min_ps(_mm256_max_ps(cell, _mm256_set1_ps(-1e9f)), _mm256_set1_ps(1e9f));
    return _mm256_cvttps_epi32(_mm256_floor_ps(cell));
}

// Which of eight numbers are the same as that of the first lane of another eight.
static inline __m256i equal_first(__m256i a, __m256i first)
{
    return _mm256_cmpeq_epi32(a, _mm256_broadcastd_epi32(_mm256_castsi256_si128(first)));
}

static uint32_t find_run(const stp_grid* samples, uint32_t begin, uint32_t end)
{
    assert(begin < end && end <= samples->count);
    __m256i x = find_cells(samples, samples->x + begin),
            y = find_cells(samples, samples->y + begin),
            z = find_cells(samples, samples->z + begin);
    __m256i first_x = x, first_y = y, first_z = z;
    for (uint32_t run = begin;;) {
        __m256i same = _mm256_and_si256(equal_first(x, first_x), equal_first(y, first_y));
        same = _mm256_and_si256(same, equal_first(z, first_z));
        uint32_t other = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(same)) & 0xff;
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
    vector3 place, normal;
    __m256 minimum;
    __m256i surfel;
} eight_samples;

static inline eight_samples load_samples(const stp_grid* samples, uint32_t at, stp_near_rule rule)
{
    return (eight_samples){load_vectors(samples->x + at, samples->y + at, samples->z + at),
                           load_vectors(samples->nx + at, samples->ny + at, samples->nz + at),
                           _mm256_set1_ps(rule.limit), _mm256_set1_epi32(-1)};
}

// Branch-free: whether one of eight samples is nearer cannot be predicted.
static inline void test_surfel(eight_samples* e, vector3 place, const vector3* normal,
                               __m256i index, __m256 agreed)
{
    vector3 d = subtract(e->place, place);
    __m256 squared = dot(d, d);
    __m256 lower =
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_min_epu32(index, e->surfel), index));
    __m256 tie = _mm256_and_ps(_mm256_cmp_ps(squared, e->minimum, _CMP_EQ_OQ), lower);
    __m256 nearer = _mm256_or_ps(_mm256_cmp_ps(squared, e->minimum, _CMP_LT_OQ), tie);
    if (normal != NULL) {
        __m256 facing = _mm256_cmp_ps(dot(e->normal, *normal), agreed, _CMP_GE_OQ);
        nearer = _mm256_and_ps(nearer, facing);
    }
    e->minimum = _mm256_blendv_ps(e->minimum, squared, nearer);
    e->surfel = _mm256_castps_si256(
        _mm256_blendv_ps(_mm256_castsi256_ps(e->surfel), _mm256_castsi256_ps(index), nearer));
}

static inline void test_surfels(eight_samples* a, eight_samples* b, const surfel_columns* from,
                                uint32_t begin, uint32_t end, bool sides, __m256 agreed)
{
    for (uint32_t i = begin; i < end; ++i) {
        vector3 place = repeat_vector(from->x[i], from->y[i], from->z[i]), facing;
        const vector3* normal = NULL;
        if (sides) {
            facing = repeat_vector(from->nx[i], from->ny[i], from->nz[i]);
            normal = &facing;
        }
        __m256i index = _mm256_set1_epi32((int)from->index[i]);
        test_surfel(a, place, normal, index, agreed);
        if (b != NULL) {
            test_surfel(b, place, normal, index, agreed);
        }
    }
}

static inline void store_nearest(uint32_t* nearest, uint32_t count, __m256i surfel)
{
    assert(count > 0 && "counts above eight mean all lanes");
    __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i mask = _mm256_cmpgt_epi32(_mm256_set1_epi32((int)count), lanes);
    _mm256_maskstore_epi32((int*)nearest, mask, surfel);
}

// Surfels of all ranges in one list. Copies may write eight values past the end.
typedef struct surfel_list {
    float x[LIST_SIZE + 8], y[LIST_SIZE + 8], z[LIST_SIZE + 8];
    float nx[LIST_SIZE + 8], ny[LIST_SIZE + 8], nz[LIST_SIZE + 8];
    uint32_t index[LIST_SIZE + 8];
} surfel_list;

static inline void copy_eight(float* to, const float* from)
{
    _mm256_storeu_ps(to, _mm256_loadu_ps(from));
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
            __m256i index = _mm256_loadu_si256((const __m256i*)(surfels->index + i));
            _mm256_storeu_si256((__m256i*)(list->index + to), index);
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
    __m256 agreed = _mm256_set1_ps(rule.min_agreement);
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
static inline __m256 span_cells(__m256 centre, __m256 half, __m256i* first, __m256i* last)
{
    __m256 four = _mm256_set1_ps(4.0f);
    __m256 low = _mm256_mul_ps(four, _mm256_sub_ps(centre, half));
    __m256 high = _mm256_mul_ps(four, _mm256_add_ps(centre, half));
    __m256 own = _mm256_add_ps(_mm256_mul_ps(four, centre), four);
    low = _mm256_min_ps(_mm256_add_ps(low, _mm256_set1_ps(4.5f)), own);
    high = _mm256_max_ps(_mm256_add_ps(high, _mm256_set1_ps(3.5f)), own);
    *first = _mm256_cvttps_epi32(_mm256_max_ps(low, _mm256_setzero_ps()));
    *last = _mm256_cvttps_epi32(_mm256_min_ps(high, _mm256_set1_ps(7.0f)));
    return _mm256_and_ps(_mm256_cmp_ps(high, _mm256_setzero_ps(), _CMP_GE_OQ),
                         _mm256_cmp_ps(low, _mm256_set1_ps(8.0f), _CMP_LT_OQ));
}

// Bytes with the bits from the first to the last set.
static inline __m256i set_bits(__m256i first, __m256i last)
{
    __m256i all = _mm256_set1_epi32(0xff);
    __m256i above = _mm256_sub_epi32(_mm256_set1_epi32(7), last);
    return _mm256_and_si256(_mm256_sllv_epi32(all, first), _mm256_srlv_epi32(all, above));
}

// Four masks of the stencil: columns with those bits set, in rows from the first to the last.
static inline __m256i mask_cells(__m128i columns, __m128i first_row, __m128i last_row)
{
    __m256i all = _mm256_set1_epi64x(-1),
            spread = _mm256_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8, 0, 0, 0, 0, 0,
                                      0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8);
    __m256i below = _mm256_cvtepu32_epi64(_mm_slli_epi32(first_row, 3));
    __m256i above =
        _mm256_cvtepu32_epi64(_mm_sub_epi32(_mm_set1_epi32(56), _mm_slli_epi32(last_row, 3)));
    __m256i rows = _mm256_and_si256(_mm256_sllv_epi64(all, below), _mm256_srlv_epi64(all, above));
    return _mm256_and_si256(rows, _mm256_shuffle_epi8(_mm256_cvtepu32_epi64(columns), spread));
}

// All cells of eight squares; of those samples that are near.
static inline uint64_t join_cells(__m256 u, __m256 v, __m256 footprint, __m256 near)
{
    __m256i first, last, first_row, last_row;
    near = _mm256_and_ps(near, span_cells(u, footprint, &first, &last));
    near = _mm256_and_ps(near, span_cells(v, footprint, &first_row, &last_row));
    __m256i columns = _mm256_and_si256(set_bits(first, last), _mm256_castps_si256(near));
    __m256i cells = _mm256_or_si256(
        mask_cells(_mm256_castsi256_si128(columns), _mm256_castsi256_si128(first_row),
                   _mm256_castsi256_si128(last_row)),
        mask_cells(_mm256_extracti128_si256(columns, 1), _mm256_extracti128_si256(first_row, 1),
                   _mm256_extracti128_si256(last_row, 1)));
    __m128i half = _mm_or_si128(_mm256_castsi256_si128(cells), _mm256_extracti128_si256(cells, 1));
    return (uint64_t)_mm_cvtsi128_si64(half) | (uint64_t)_mm_extract_epi64(half, 1);
}

static inline void add_fractions(const stp_grid* samples, uint32_t at, uint32_t near,
                                 const uint16_t* fractions, stp_disk* disk)
{
    for (; near != 0; near &= near - 1) {
        disk->fractions += fractions[samples->index[at + (uint32_t)__builtin_ctz(near)]];
    }
}

// Half sides of eight samples' squares. Adds the additional weight of near samples of sets.
static inline __m256 choose_footprints(const stp_grid* samples, uint32_t at, uint32_t near,
                                       const stp_disk_query* query, stp_disk* disk)
{
    __m256i index = _mm256_loadu_si256((const __m256i*)(samples->index + at));
    __m256i first = _mm256_set1_epi32((int)query->first_of_sets);
    __m256 of_set = _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_max_epu32(index, first), index));
    near &= (uint32_t)_mm256_movemask_ps(of_set);
    disk->count += (uint32_t)__builtin_popcount(near) * (query->set_weight - 1);
    return _mm256_blendv_ps(_mm256_set1_ps(query->footprint), _mm256_set1_ps(query->set_footprint),
                            of_set);
}

static bool scan_disk(const stp_grid* samples, const stp_near_ranges* ranges,
                      const stp_disk_query* query, stp_disk* disk)
{
    const stp_vec3 *s = &query->tangents[0], *t = &query->tangents[1];
    vector3 centre = repeat_vector(query->x, query->y, query->z);
    vector3 normal = repeat_vector(query->nx, query->ny, query->nz);
    vector3 across = repeat_vector(s->x, s->y, s->z), along = repeat_vector(t->x, t->y, t->z);
    __m256 limit = _mm256_set1_ps(query->limit), agreed = _mm256_set1_ps(query->min_agreement);
    bool sides = query->min_agreement > ANY_AGREEMENT;
    __m256 footprint = _mm256_set1_ps(query->footprint);
    __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    for (uint32_t range = 0; range < ranges->count; ++range) {
        uint32_t end = ranges->ends[range];
        assert(end <= samples->count);
        for (uint32_t at = ranges->begins[range]; at < end; at += STP_NEAR_LANES) {
            vector3 offset =
                subtract(load_vectors(samples->x + at, samples->y + at, samples->z + at), centre);
            __m256 near = _mm256_cmp_ps(dot(offset, offset), limit, _CMP_LE_OQ);
            if (sides) {
                vector3 other = load_vectors(samples->nx + at, samples->ny + at, samples->nz + at);
                near = _mm256_and_ps(near, _mm256_cmp_ps(dot(normal, other), agreed, _CMP_GE_OQ));
            }
            __m256i left = _mm256_cmpgt_epi32(_mm256_set1_epi32((int)(end - at)), lanes);
            near = _mm256_and_ps(near, _mm256_castsi256_ps(left));
            uint32_t mask = (uint32_t)_mm256_movemask_ps(near);
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
            uint64_t cells = query->stencil->disk &
                             join_cells(dot(offset, across), dot(offset, along), footprint, near);
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
    vector3 centre = repeat_vector(place.x, place.y, place.z);
    __m256 minimum = _mm256_set1_ps(FLT_MAX);
    for (uint32_t i = 0; i < count; i += STP_NEAR_LANES) {
        vector3 offset = subtract(centre, load_vectors(x + i, y + i, z + i));
        minimum = _mm256_min_ps(minimum, dot(offset, offset));
    }
    __m128 half = _mm_min_ps(_mm256_castps256_ps128(minimum), _mm256_extractf128_ps(minimum, 1));
    half = _mm_min_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_min_ss(half, _mm_movehdup_ps(half)));
}

const stp_near_kernels stp_near_kernels_avx2 = {find_run, find_nearest, scan_disk, nearest_squared};

#endif
