// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

#if defined(__x86_64__)

#include <immintrin.h>

// Sums in the same order as the portable variant's, without fused multiply-add.
static inline __m256 sum_of_products(__m256 a, __m256 b, __m256 c, __m256 d, __m256 e, __m256 f)
{
    __m256 sum = _mm256_add_ps(_mm256_mul_ps(a, b), _mm256_mul_ps(c, d));
    return _mm256_add_ps(sum, _mm256_mul_ps(e, f));
}

static inline __m256 squared_distance(const stp_near_query* query, const float* x, const float* y,
                                      const float* z)
{
    __m256 dx = _mm256_sub_ps(_mm256_set1_ps(query->x), _mm256_loadu_ps(x));
    __m256 dy = _mm256_sub_ps(_mm256_set1_ps(query->y), _mm256_loadu_ps(y));
    __m256 dz = _mm256_sub_ps(_mm256_set1_ps(query->z), _mm256_loadu_ps(z));
    return sum_of_products(dx, dx, dy, dy, dz, dz);
}

// Which of eight normals agree.
static inline unsigned test_sides(const stp_near_query* query, const float* nx, const float* ny,
                                  const float* nz)
{
    __m256 agreement =
        sum_of_products(_mm256_set1_ps(query->nx), _mm256_loadu_ps(nx), _mm256_set1_ps(query->ny),
                        _mm256_loadu_ps(ny), _mm256_set1_ps(query->nz), _mm256_loadu_ps(nz));
    __m256 least = _mm256_set1_ps(query->least_agreement);
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(agreement, least, _CMP_GE_OQ));
}

static inline unsigned test_limit(__m256 squared, float limit)
{
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(squared, _mm256_set1_ps(limit), _CMP_LE_OQ));
}

static stp_near_finding find_nearest(const stp_near_surfels* surfels, const stp_near_query* query,
                                     stp_near_finding found)
{
    for (uint32_t i = 0; i < surfels->count; i += 8) {
        __m256 squared = squared_distance(query, surfels->x + i, surfels->y + i, surfels->z + i);
        unsigned near = test_limit(squared, found.squared);
        near &= surfels->count - i < 8 ? (1u << (surfels->count - i)) - 1u : 0xffu;
        if (near != 0) {
            near &= test_sides(query, surfels->nx + i, surfels->ny + i, surfels->nz + i);
            float distances[8];
            _mm256_storeu_ps(distances, squared);
            for (; near != 0; near &= near - 1) {
                uint32_t lane = (uint32_t)__builtin_ctz(near);
                found = stp_nearer(found, surfels->index[i + lane], distances[lane]);
            }
        }
    }
    return found;
}

static uint32_t test_samples(const stp_grid* samples, uint32_t begin, uint32_t end,
                             const stp_near_query* query)
{
    __m256 squared =
        squared_distance(query, samples->x + begin, samples->y + begin, samples->z + begin);
    unsigned near = test_limit(squared, query->limit);
    near &= end - begin < 8 ? (1u << (end - begin)) - 1u : 0xffu;
    if (near == 0) {
        return 0;
    }
    return near & test_sides(query, samples->nx + begin, samples->ny + begin, samples->nz + begin);
}

const stp_near_kernels stp_near_kernels_avx2 = {find_nearest, test_samples, 8};

#endif
