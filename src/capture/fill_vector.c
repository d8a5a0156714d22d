// SPDX-License-Identifier: MIT
//
// Eight pixels at a time. Most are seen by the view that saw their neighbours. The others are
// queued until there are eight of them, tested in all views, and queued again for the four
// surrounding pixels.
#include "base/math/f32x8.h"
#include "capture/fill_kernel.h"

#include <assert.h>

enum { LANES = 8 };

/// Eight points.
typedef struct points {
    f32x8 p[3];
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
static inline f32x8 sum_of_products(const float a[3], const f32x8 b[3])
{
    f32x8 sum = f32x8_add(f32x8_mul(f32x8_set(a[0]), b[0]), f32x8_mul(f32x8_set(a[1]), b[1]));
    return f32x8_add(sum, f32x8_mul(f32x8_set(a[2]), b[2]));
}

static inline f32x8 normal_part8(i32x8 normals, int part)
{
    i32x8 up = i32x8_left(normals, 22 - 10 * part);
    return i32x8_to_float(i32x8_right_signed(up, 22));
}

/// Places of eight points in a view.
typedef struct places {
    f32x8 x, y, nearness;
} places;

static inline places project_eight(const stp_fill_view* look, const points* points8)
{
    return (places){
        f32x8_add(sum_of_products(look->x, points8->p), f32x8_set(look->x_shift)),
        f32x8_add(sum_of_products(look->y, points8->p), f32x8_set(look->y_shift)),
        f32x8_add(sum_of_products(look->z, points8->p), f32x8_set(1.5f)),
    };
}

/// Offset from a place to the middle of its pixel.
static inline f32x8 to_middle(i32x8 pixel, f32x8 place)
{
    f32x8 middle = f32x8_add(i32x8_to_float(pixel), f32x8_set(0.5f));
    return f32x8_sub(middle, place);
}

/// Tests the surface shown by eight pixels, in the lanes that are set.
static inline i32x8 test_surface(const stp_fill_query* q, const stp_fill_view* look,
                                 const places* at, i32x8 column, i32x8 row, i32x8 candidate,
                                 i32x8 lanes)
{
    i32x8 normals = i32x8_gather_pairs(q->surface, 1, candidate, lanes);
    f32x8 nearness = i32x8_as_float(i32x8_gather_pairs(q->surface, 0, candidate, lanes));
    f32x8 across = to_middle(column, at->x), along = to_middle(row, at->y);
    f32x8 deep = f32x8_mul(f32x8_sub(nearness, at->nearness), f32x8_set(look->pixels_per_nearness));
    f32x8 squared = f32x8_add(f32x8_mul(across, across), f32x8_mul(along, along));
    squared = f32x8_add(squared, f32x8_mul(deep, deep));
    f32x8 parts[3] = {normal_part8(normals, 0), normal_part8(normals, 1), normal_part8(normals, 2)};
    f32x8 facing = sum_of_products(q->toward, parts);
    i32x8 near = f32x8_less_equal(squared, f32x8_set(1.0f));
    return i32x8_and(near, f32x8_less(f32x8_set(0.0f), facing));
}

/// Which of the points are represented by the pixel at an offset from their place in a view.
static inline unsigned test_places(const stp_fill_query* q, const stp_fill_view* look,
                                   const places* at, float dx, float dy, unsigned asked)
{
    const f32x8 zero = f32x8_set(0.0f);
    f32x8 x = f32x8_add(at->x, f32x8_set(dx));
    f32x8 y = f32x8_add(at->y, f32x8_set(dy));
    i32x8 within = i32x8_and(f32x8_less_equal(zero, x), f32x8_less(x, f32x8_set(look->width)));
    within = i32x8_and(within, f32x8_less_equal(zero, y));
    within = i32x8_and(within, f32x8_less(y, f32x8_set(look->height)));
    i32x8 column = i32x8_and(f32x8_truncate(x), within);
    i32x8 row = i32x8_and(f32x8_truncate(y), within);
    i32x8 word = i32x8_mul(row, i32x8_set((int)look->words_per_row));
    word = i32x8_add(word, i32x8_right(column, 5));
    const i32x8 all = i32x8_set(-1);
    i32x8 covered = i32x8_gather_pairs(look->words, 0, word, all);
    i32x8 bit = i32x8_left_by(i32x8_set(1), i32x8_and(column, i32x8_set(31)));
    i32x8 hit = i32x8_equal(i32x8_and(covered, bit), bit);
    hit = i32x8_and(hit, within);
    if ((i32x8_signs(hit) & asked) == 0) {
        return 0;
    }
    i32x8 below = i32x8_and(covered, i32x8_sub(bit, i32x8_set(1)));
    i32x8 first = i32x8_gather_pairs(look->words, 1, word, all);
    i32x8 candidate = i32x8_add(first, i32x8_count_bits(below));
    i32x8 known = test_surface(q, look, at, column, row, candidate, hit);
    known = i32x8_and(known, hit);
    return i32x8_signs(known) & asked;
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
        out.p[k] = f32x8_load(p[k]);
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

static inline void scan_eight(scan* s, uint64_t* pixels, unsigned there, float column, float y)
{
    const stp_fill_query* q = s->query;
    assert(s->unseen.count < LANES && s->alone.count < LANES && "queues have room for eight");
    static const float centres[LANES] = {0.5f, 1.5f, 2.5f, 3.5f, 4.5f, 5.5f, 6.5f, 7.5f};
    const i32x8 ones = i32x8_set(-1);
    i32x8 upper = i32x8_load_upper(pixels);
    unsigned empty = i32x8_signs(i32x8_equal(upper, ones));
    unsigned asked = there & ~empty;
    if (asked == 0) {
        return;
    }
    f32x8 z = i32x8_as_float(i32x8_xor(upper, ones));
    f32x8 x = f32x8_add(f32x8_set(column), f32x8_load(centres));
    points points8;
    for (int k = 0; k < 3; ++k) {
        f32x8 across = f32x8_mul(x, f32x8_set(q->x[k]));
        f32x8 sum = f32x8_add(across, f32x8_set(y * q->y[k]));
        sum = f32x8_add(sum, f32x8_mul(z, f32x8_set(q->z[k])));
        points8.p[k] = f32x8_add(sum, f32x8_set(q->origin[k]));
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
        f32x8_store(p[k], points8.p[k]);
    }
    for (; left != 0; left &= left - 1) {
        unsigned lane = (unsigned)__builtin_ctz(left);
        push(&s->unseen, (const float(*)[LANES])p, lane, pixels + lane);
    }
    if (s->unseen.count >= LANES) {
        search_views(s);
    }
}

void stp_fill_drop_vector(const stp_fill_query* query, uint32_t first_row,
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
