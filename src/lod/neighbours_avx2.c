// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

#if defined(__x86_64__)

#include <immintrin.h>

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

// a < b of unsigned numbers
static inline __m256 is_below(__m256i a, __m256i b)
{
    __m256i sign = _mm256_set1_epi32(INT32_MIN);
    return _mm256_castsi256_ps(
        _mm256_cmpgt_epi32(_mm256_xor_si256(b, sign), _mm256_xor_si256(a, sign)));
}

static void find_nearest(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t at, float least_agreement,
                         stp_near_findings* found)
{
    vector3 place = load_vectors(samples->x + at, samples->y + at, samples->z + at);
    vector3 normal = load_vectors(samples->nx + at, samples->ny + at, samples->nz + at);
    __m256 agreed = _mm256_set1_ps(least_agreement);
    __m256 least = _mm256_loadu_ps(found->squared);
    __m256i surfel = _mm256_loadu_si256((const __m256i*)found->surfel);
    for (uint32_t range = 0; range < ranges->count; ++range) {
        for (uint32_t i = ranges->begins[range]; i < ranges->ends[range]; ++i) {
            vector3 d = subtract(place, repeat_vector(surfels->x[i], surfels->y[i], surfels->z[i]));
            __m256 squared = dot(d, d);
            __m256 nearer = _mm256_cmp_ps(squared, least, _CMP_LE_OQ);
            if (_mm256_testz_ps(nearer, nearer)) {
                continue;
            }
            __m256 agreement =
                dot(normal, repeat_vector(surfels->nx[i], surfels->ny[i], surfels->nz[i]));
            __m256i index = _mm256_set1_epi32((int)surfels->index[i]);
            __m256 lower =
                _mm256_or_ps(_mm256_cmp_ps(squared, least, _CMP_LT_OQ), is_below(index, surfel));
            nearer = _mm256_and_ps(nearer, _mm256_cmp_ps(agreement, agreed, _CMP_GE_OQ));
            nearer = _mm256_and_ps(nearer, lower);
            least = _mm256_blendv_ps(least, squared, nearer);
            surfel = _mm256_blendv_epi8(surfel, index, _mm256_castps_si256(nearer));
        }
    }
    _mm256_storeu_ps(found->squared, least);
    _mm256_storeu_si256((__m256i*)found->surfel, surfel);
}

// One axis of stp_stencil_cells: the first and the last cell of eight squares; @return which squares touch any
static inline __m256 find_cells(__m256 centre, __m256 half, __m256i* first, __m256i* last)
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

static uint64_t join_cells(vector3 offset, __m256 footprint, const stp_disk_query* query,
                           unsigned near)
{
    const stp_vec3 *s = &query->tangents[0], *t = &query->tangents[1];
    __m256i first, last;
    __m256 u = dot(offset, repeat_vector(s->x, s->y, s->z));
    __m256 touched = find_cells(u, footprint, &first, &last);
    uint32_t columns[8], first_rows[8], last_rows[8];
    _mm256_storeu_si256((__m256i*)columns, set_bits(first, last));
    __m256 v = dot(offset, repeat_vector(t->x, t->y, t->z));
    touched = _mm256_and_ps(touched, find_cells(v, footprint, &first, &last));
    _mm256_storeu_si256((__m256i*)first_rows, _mm256_slli_epi32(first, 3));
    _mm256_storeu_si256((__m256i*)last_rows,
                        _mm256_sub_epi32(_mm256_set1_epi32(56), _mm256_slli_epi32(last, 3)));
    uint64_t cells = 0;
    for (near &= (unsigned)_mm256_movemask_ps(touched); near != 0; near &= near - 1) {
        unsigned lane = (unsigned)__builtin_ctz(near);
        uint64_t rows = UINT64_MAX << first_rows[lane] & UINT64_MAX >> last_rows[lane];
        cells |= columns[lane] * UINT64_C(0x0101010101010101) & rows;
    }
    return cells;
}

static stp_disk_hits test_samples(const stp_grid* samples, uint32_t begin, uint32_t end,
                                  const stp_disk_query* query)
{
    vector3 place = load_vectors(samples->x + begin, samples->y + begin, samples->z + begin);
    vector3 offset = subtract(place, repeat_vector(query->x, query->y, query->z));
    __m256 limit = _mm256_set1_ps(query->limit);
    unsigned near =
        (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(dot(offset, offset), limit, _CMP_LE_OQ));
    near &= end - begin < 8 ? (1u << (end - begin)) - 1u : 0xffu;
    if (near == 0) {
        return (stp_disk_hits){0};
    }
    vector3 normal = load_vectors(samples->nx + begin, samples->ny + begin, samples->nz + begin);
    __m256 agreement = dot(repeat_vector(query->nx, query->ny, query->nz), normal);
    __m256 least = _mm256_set1_ps(query->least_agreement);
    near &= (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(agreement, least, _CMP_GE_OQ));
    __m256i index = _mm256_loadu_si256((const __m256i*)(samples->index + begin));
    __m256 single = is_below(index, _mm256_set1_epi32((int)query->first_of_sets));
    __m256 footprint = _mm256_blendv_ps(_mm256_set1_ps(query->set_footprint),
                                        _mm256_set1_ps(query->footprint), single);
    return (stp_disk_hits){.near = near,
                           .of_set = near & ~(unsigned)_mm256_movemask_ps(single),
                           .cells = near != 0 ? join_cells(offset, footprint, query, near) : 0};
}

const stp_near_kernels stp_near_kernels_avx2 = {find_nearest, test_samples};

#endif
