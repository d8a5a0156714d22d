// SPDX-License-Identifier: MIT
//
// Eight pixels at a time. Most are seen by the view that saw their neighbours. The others are
// queued until there are eight of them, tested in all views, and queued again for the four
// surrounding pixels.
#include "capture/fill_kernel.h"

#if defined(__x86_64__)

#include <assert.h>
#include <immintrin.h>

enum { LANES = 8 };

/// Eight points.
typedef struct points {
    __m256 p[3];
} points;

/// A queue of points, with the places of their pixels.
typedef struct queue {
    uint32_t count;
    float p[3][2 * LANES];
    uint64_t* pixels[2 * LANES];
} queue;

typedef struct scan {
    const stp_fill_query* query;
    uint32_t favourite;
    queue unseen, alone; ///< not seen by the favourite view; by no view
} scan;

// Sums in the order of the portable variant.
static inline __m256 sum_of_products(const float a[3], const __m256 b[3])
{
    __m256 sum = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(a[0]), b[0]),
                               _mm256_mul_ps(_mm256_set1_ps(a[1]), b[1]));
    return _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(a[2]), b[2]));
}

static inline __m256i count_bits(__m256i x)
{
    const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1,
                                           2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
    const __m256i low = _mm256_set1_epi8(15);
    __m256i bytes =
        _mm256_add_epi8(_mm256_shuffle_epi8(table, _mm256_and_si256(x, low)),
                        _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi32(x, 4), low)));
    __m256i pairs = _mm256_maddubs_epi16(bytes, _mm256_set1_epi8(1));
    return _mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
}

static inline __m256 normal_part8(__m256i normals, int part)
{
    __m256i up = _mm256_slli_epi32(normals, 22 - 10 * part);
    return _mm256_cvtepi32_ps(_mm256_srai_epi32(up, 22));
}

/// Places of eight points in a view.
typedef struct places {
    __m256 x, y, nearness;
} places;

static inline places project_eight(const stp_fill_view* look, const points* points8)
{
    return (places){
        _mm256_add_ps(sum_of_products(look->x, points8->p), _mm256_set1_ps(look->x_shift)),
        _mm256_add_ps(sum_of_products(look->y, points8->p), _mm256_set1_ps(look->y_shift)),
        _mm256_add_ps(sum_of_products(look->z, points8->p), _mm256_set1_ps(1.5f)),
    };
}

/// Offset from a place to the middle of its pixel.
static inline __m256 to_middle(__m256i pixel, __m256 place)
{
    __m256 middle = _mm256_add_ps(_mm256_cvtepi32_ps(pixel), _mm256_set1_ps(0.5f));
    return _mm256_sub_ps(middle, place);
}

/// Tests the surface shown by eight pixels, in the lanes that are set.
static inline __m256 test_surface(const stp_fill_query* q, const stp_fill_view* look,
                                  const places* at, __m256i column, __m256i row, __m256i candidate,
                                  __m256i lanes)
{
    const int* surface = (const int*)q->surface;
    __m256i normals =
        _mm256_mask_i32gather_epi32(_mm256_setzero_si256(), surface + 1, candidate, lanes, 8);
    __m256 nearness = _mm256_castsi256_ps(
        _mm256_mask_i32gather_epi32(_mm256_setzero_si256(), surface, candidate, lanes, 8));
    __m256 across = to_middle(column, at->x), along = to_middle(row, at->y);
    __m256 deep = _mm256_mul_ps(_mm256_sub_ps(nearness, at->nearness),
                                _mm256_set1_ps(look->pixels_per_nearness));
    __m256 squared = _mm256_add_ps(_mm256_mul_ps(across, across), _mm256_mul_ps(along, along));
    squared = _mm256_add_ps(squared, _mm256_mul_ps(deep, deep));
    __m256 parts[3] = {normal_part8(normals, 0), normal_part8(normals, 1),
                       normal_part8(normals, 2)};
    __m256 facing = sum_of_products(q->toward, parts);
    __m256 near = _mm256_cmp_ps(squared, _mm256_set1_ps(1.0f), _CMP_LE_OQ);
    return _mm256_and_ps(near, _mm256_cmp_ps(facing, _mm256_setzero_ps(), _CMP_GT_OQ));
}

/// Which of the points are represented by the pixel at an offset from their place in a view.
static inline unsigned test_places(const stp_fill_query* q, const stp_fill_view* look,
                                   const places* at, float dx, float dy, unsigned asked)
{
    const __m256 zero = _mm256_setzero_ps();
    __m256 x = _mm256_add_ps(at->x, _mm256_set1_ps(dx));
    __m256 y = _mm256_add_ps(at->y, _mm256_set1_ps(dy));
    __m256 within = _mm256_and_ps(_mm256_cmp_ps(x, zero, _CMP_GE_OQ),
                                  _mm256_cmp_ps(x, _mm256_set1_ps(look->width), _CMP_LT_OQ));
    within = _mm256_and_ps(within, _mm256_cmp_ps(y, zero, _CMP_GE_OQ));
    within = _mm256_and_ps(within, _mm256_cmp_ps(y, _mm256_set1_ps(look->height), _CMP_LT_OQ));
    __m256i lanes = _mm256_castps_si256(within);
    __m256i column = _mm256_and_si256(_mm256_cvttps_epi32(x), lanes);
    __m256i row = _mm256_and_si256(_mm256_cvttps_epi32(y), lanes);
    __m256i word = _mm256_mullo_epi32(row, _mm256_set1_epi32((int)look->words_per_row));
    word = _mm256_add_epi32(word, _mm256_srli_epi32(column, 5));
    const int* words = (const int*)look->words;
    __m256i covered = _mm256_i32gather_epi32(words, word, 8);
    __m256i bit =
        _mm256_sllv_epi32(_mm256_set1_epi32(1), _mm256_and_si256(column, _mm256_set1_epi32(31)));
    __m256i hit = _mm256_cmpeq_epi32(_mm256_and_si256(covered, bit), bit);
    hit = _mm256_and_si256(hit, lanes);
    if (((unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(hit)) & asked) == 0) {
        return 0;
    }
    __m256i below = _mm256_and_si256(covered, _mm256_sub_epi32(bit, _mm256_set1_epi32(1)));
    __m256i first = _mm256_i32gather_epi32(words + 1, word, 8);
    __m256i candidate = _mm256_add_epi32(first, count_bits(below));
    __m256 known = test_surface(q, look, at, column, row, candidate, hit);
    known = _mm256_and_ps(known, _mm256_castsi256_ps(hit));
    return (unsigned)_mm256_movemask_ps(known) & asked;
}

static inline void push(queue* to, const float p[3][LANES], unsigned lane, uint64_t* pixel)
{
    assert(to->count < 2 * LANES);
    for (int k = 0; k < 3; ++k) {
        to->p[k][to->count] = p[k][lane];
    }
    to->pixels[to->count++] = pixel;
}

// Takes the last points from a queue, up to eight, and copies them to `p` and `pixels`.
static points pop(queue* from, float p[3][LANES], uint64_t* pixels[LANES], unsigned* asked)
{
    uint32_t count = from->count < LANES ? from->count : LANES;
    assert(count > 0);
    from->count -= count;
    points out;
    for (int k = 0; k < 3; ++k) {
        memcpy(p[k], from->p[k] + from->count, LANES * sizeof(float));
        out.p[k] = _mm256_loadu_ps(p[k]);
    }
    memcpy(pixels, from->pixels + from->count, LANES * sizeof(uint64_t*));
    *asked = (1u << count) - 1u;
    return out;
}

static void search_around(scan* s)
{
    float p[3][LANES];
    uint64_t* pixels[LANES];
    unsigned asked;
    points points8 = pop(&s->alone, p, pixels, &asked);
    unsigned known = 0;
    for (uint32_t i = 0; i < s->query->view_count && known != asked; ++i) {
        places at = project_eight(&s->query->looks[i], &points8);
        for (int corner = 0; corner < 4 && known != asked; ++corner) {
            float dx = (corner & 1) != 0 ? 0.5f : -0.5f, dy = (corner & 2) != 0 ? 0.5f : -0.5f;
            known |= test_places(s->query, &s->query->looks[i], &at, dx, dy, asked & ~known);
        }
    }
    for (; known != 0; known &= known - 1) {
        *pixels[__builtin_ctz(known)] = STP_RASTER_EMPTY;
    }
}

static void search_views(scan* s)
{
    float p[3][LANES];
    uint64_t* pixels[LANES];
    unsigned asked;
    points points8 = pop(&s->unseen, p, pixels, &asked);
    unsigned known = 0;
    int maximum = 0;
    for (uint32_t i = 0; i < s->query->view_count && known != asked; ++i) {
        places at = project_eight(&s->query->looks[i], &points8);
        unsigned more = test_places(s->query, &s->query->looks[i], &at, 0.0f, 0.0f, asked & ~known);
        if (__builtin_popcount(more) > maximum) {
            maximum = __builtin_popcount(more);
            s->favourite = i;
        }
        known |= more;
    }
    for (unsigned left = asked & ~known; left != 0; left &= left - 1) {
        unsigned lane = (unsigned)__builtin_ctz(left);
        push(&s->alone, (const float(*)[LANES])p, lane, pixels[lane]);
        if (s->alone.count >= LANES) {
            search_around(s);
        }
    }
    for (; known != 0; known &= known - 1) {
        *pixels[__builtin_ctz(known)] = STP_RASTER_EMPTY;
    }
}

// The upper halves of eight pixels.
static inline __m256i load_upper(const uint64_t* pixels)
{
    __m256 a = _mm256_loadu_ps((const float*)pixels);
    __m256 b = _mm256_loadu_ps((const float*)(pixels + 4));
    __m256i mixed = _mm256_castps_si256(_mm256_shuffle_ps(a, b, 0xDD));
    return _mm256_permute4x64_epi64(mixed, 0xD8);
}

static inline void scan_eight(scan* s, uint64_t* pixels, unsigned there, float column, float y)
{
    const stp_fill_query* q = s->query;
    assert(s->unseen.count < LANES && s->alone.count < LANES && "queues have room for eight");
    const __m256i ones = _mm256_set1_epi32(-1);
    __m256i upper = load_upper(pixels);
    unsigned empty =
        (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(upper, ones)));
    unsigned asked = there & ~empty;
    if (asked == 0) {
        return;
    }
    __m256 z = _mm256_castsi256_ps(_mm256_xor_si256(upper, ones));
    __m256 x = _mm256_add_ps(_mm256_set1_ps(column),
                             _mm256_setr_ps(0.5f, 1.5f, 2.5f, 3.5f, 4.5f, 5.5f, 6.5f, 7.5f));
    points points8;
    for (int k = 0; k < 3; ++k) {
        __m256 across = _mm256_mul_ps(x, _mm256_set1_ps(q->x[k]));
        __m256 sum = _mm256_add_ps(across, _mm256_set1_ps(y * q->y[k]));
        sum = _mm256_add_ps(sum, _mm256_mul_ps(z, _mm256_set1_ps(q->z[k])));
        points8.p[k] = _mm256_add_ps(sum, _mm256_set1_ps(q->origin[k]));
    }
    places at = project_eight(&q->looks[s->favourite], &points8);
    unsigned known = test_places(q, &q->looks[s->favourite], &at, 0.0f, 0.0f, asked);
    for (unsigned left = known; left != 0; left &= left - 1) {
        pixels[__builtin_ctz(left)] = STP_RASTER_EMPTY;
    }
    unsigned left = asked & ~known;
    if (left == 0) {
        return;
    }
    float p[3][LANES];
    for (int k = 0; k < 3; ++k) {
        _mm256_storeu_ps(p[k], points8.p[k]);
    }
    for (; left != 0; left &= left - 1) {
        unsigned lane = (unsigned)__builtin_ctz(left);
        push(&s->unseen, (const float(*)[LANES])p, lane, pixels + lane);
    }
    if (s->unseen.count >= LANES) {
        search_views(s);
    }
}

void stp_fill_drop_avx2(const stp_fill_query* query, uint32_t first_row,
                        const stp_raster_target* target)
{
    scan s = {.query = query};
    for (uint32_t row = 0; row < target->height; ++row) {
        uint64_t* pixels = target->pixels + row * target->stride;
        float y = (float)(first_row + row) + 0.5f;
        uint32_t column = 0;
        for (; column + LANES <= target->width; column += LANES) {
            scan_eight(&s, pixels + column, 0xFF, (float)column, y);
        }
        if (column < target->width) {
            uint64_t last[LANES];
            memset(last, 0xFF, sizeof(last));
            memcpy(last, pixels + column, (target->width - column) * sizeof(*pixels));
            scan_eight(&s, last, 0xFF, (float)column, y);
            while (s.unseen.count != 0) { // flush: queued pixels must not outlive their memory
                search_views(&s);
            }
            while (s.alone.count != 0) {
                search_around(&s);
            }
            memcpy(pixels + column, last, (target->width - column) * sizeof(*pixels));
        }
    }
    while (s.unseen.count != 0) {
        search_views(&s);
    }
    while (s.alone.count != 0) {
        search_around(&s);
    }
}

#endif
