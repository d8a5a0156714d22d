// SPDX-License-Identifier: MIT
//
// Breakpoints are evenly spaced along the log-log curve of radius over count. Between two of them
// the radius is a straight line in log-log space, raised where the true radius would exceed it.
// Logarithms are computed here because the C library's differ in the last bits between machines.
#include "base/splats/prefix_table.h"

#include "base/math/math.h"

#include <assert.h>
#include <string.h>

enum { BLOCKS = 64 }; // blocks per segment; each is checked as a whole

static const double margin = 1.000001; // covers all rounding errors

static double log2_of(double x)
{
    assert(x > 0.0 && x <= DBL_MAX);
    int exponent = 0;
    double m = frexp(x, &exponent); // exact: takes the number apart
    if (m < 0.70710678118654752) {
        m *= 2.0;
        exponent -= 1;
    }
    double t = (m - 1.0) / (m + 1.0), square = t * t, sum = 0.0; // log m = 2 atanh t, |t| < 0.172
    for (int k = 15; k >= 1; k -= 2) {
        sum = sum * square + 1.0 / k;
    }
    return exponent + 2.0 * t * sum * 1.4426950408889634;
}

static double exp2_of(double x)
{
    if (x < -1000.0 || x > 1000.0) {
        return x < 0.0 ? 0.0 : DBL_MAX;
    }
    int whole = (int)(x < 0.0 ? x - 0.5 : x + 0.5);
    double t = (x - whole) * 0.69314718055994531, sum = 1.0; // |t| < 0.35
    for (int k = 13; k >= 1; --k) {
        sum = 1.0 + sum * t / k;
    }
    return ldexp(sum, whole);
}

// A part of the table between two breakpoints.
typedef struct segment {
    double first, last; // counts
    double radius;      // at `first`
    double slope;       // slope of log radius over log count; 0 if the line is flat
} segment;

static segment segment_between(double first, double first_radius, double last, double last_radius)
{
    segment s = {first, last, first_radius, 0.0};
    if (first_radius > 0.0 && last_radius > 0.0 && first_radius < (double)INFINITY &&
        last > first) {
        s.slope = log2_of(last_radius / first_radius) / log2_of(last / first);
    }
    return s;
}

static double radius_on(const segment* s, double count)
{
    return s->slope == 0.0 ? s->radius : s->radius * exp2_of(s->slope * log2_of(count / s->first));
}

// Weight of a step from a prefix of `count` with radius `cover` to one of `next` with `next_cover`:
// the product of both ratios.
static double weigh(uint32_t count, float cover, uint32_t next, float next_cover)
{
    return (double)next / count * (double)(cover > next_cover ? cover / next_cover : 1.0f);
}

// Places breakpoints from the end backwards, so that count and radius together change by a factor
// of about `step` from one to the next, and a sudden drop of the radius has one on either side.
// Writes them in descending order.
// @return their number, or STP_PREFIX_TABLE_SIZE + 1 if there are too many
static uint32_t place_breakpoints(uint32_t* counts, const float* radii, uint32_t count,
                                  float final_radius, double step)
{
    assert(count > 0 && step > 1.0 && "steps grow until the breakpoints fit");
    float cover = final_radius, last_cover = final_radius;
    uint32_t size = 1;
    counts[0] = count;
    for (uint32_t n = count - 1; n >= 1; --n) {
        float cover_after = cover;
        cover = stp_max(cover, radii[n]);
        uint32_t last = counts[size - 1];
        if (n != 1 && weigh(n, cover, last, last_cover) < step) {
            continue;
        }
        bool falls = cover > cover_after && weigh(n, cover, n + 1, cover_after) >= sqrt(step);
        if (size + 2 > STP_PREFIX_TABLE_SIZE) {
            return STP_PREFIX_TABLE_SIZE + 1;
        }
        if (falls && n + 1 < last) {
            counts[size++] = n + 1;
        }
        counts[size++] = n;
        last_cover = cover;
    }
    return size;
}

// Sets the counts. @return the size
static uint32_t choose_breakpoints(stp_prefix_table* table, const float* radii, uint32_t count,
                                   float final_radius)
{
    uint32_t counts[STP_PREFIX_TABLE_SIZE], size;
    if (count <= STP_PREFIX_TABLE_SIZE) {
        for (uint32_t i = 0; i < count; ++i) {
            table->count[i] = i + 1;
        }
        return count;
    }
    double step = exp2_of(1.5 * log2_of(count) / (STP_PREFIX_TABLE_SIZE - 2)); // r ~ 1 / sqrt(n)
    do {
        size = place_breakpoints(counts, radii, count, final_radius, step);
        step = step * sqrt(sqrt(step));
    } while (size > STP_PREFIX_TABLE_SIZE);
    assert(counts[0] == count && counts[size - 1] == 1 && "from one splat to all");
    for (uint32_t i = 0; i < size; ++i) {
        table->count[i] = counts[size - 1 - i];
    }
    return size;
}

// First count of a block of a segment.
static uint32_t block_begin(uint32_t first, uint32_t last, uint32_t block)
{
    assert(first < last && block <= BLOCKS);
    return first + (uint32_t)((uint64_t)(last - first) * block / BLOCKS);
}

#ifndef NDEBUG
static bool is_monotone(const stp_prefix_table* table)
{
    bool monotone = true;
    for (uint32_t i = 1; i < table->size; ++i) {
        monotone = monotone && table->count[i] > table->count[i - 1] &&
                   !(table->radius[i] > table->radius[i - 1]);
    }
    return monotone;
}
#endif

void stp_prefix_table_make(stp_prefix_table* table, const float* radii, uint32_t count,
                           float final_radius)
{
    assert(!(final_radius < 0.0f));
    *table = (stp_prefix_table){0};
    if (count == 0) {
        return;
    }
    table->size = choose_breakpoints(table, radii, count, final_radius);
    // true radius at the beginning of each block, computed from the end backwards
    float covers[STP_PREFIX_TABLE_SIZE][BLOCKS];
    float cover = final_radius;
    uint32_t at = count;
    table->radius[table->size - 1] = final_radius;
    for (uint32_t i = table->size - 1; i-- > 0;) {
        for (uint32_t block = BLOCKS; block-- > 0;) {
            uint32_t begin = block_begin(table->count[i], table->count[i + 1], block);
            while (at > begin) {
                at -= 1;
                cover = stp_max(cover, radii[at]);
            }
            covers[i][block] = cover;
        }
        table->radius[i] = cover;
    }
    // raise both ends of a segment by the shortfall: then the whole line rises at least that much
    double lift_before = 1.0;
    for (uint32_t i = 0; i + 1 < table->size; ++i) {
        double first = (double)covers[i][0], lift = 1.0;
        double last = i + 2 < table->size ? (double)covers[i + 1][0] : (double)final_radius;
        segment s = segment_between(table->count[i], first, table->count[i + 1], last);
        for (uint32_t block = 0; block < BLOCKS; ++block) {
            uint32_t begin = block_begin(table->count[i], table->count[i + 1], block);
            uint32_t end = block_begin(table->count[i], table->count[i + 1], block + 1);
            if (end > begin && first > 0.0) {
                // compare the true radius at the block's beginning with the line at its end:
                // neither ever increases
                double excess = (double)covers[i][block] / radius_on(&s, end - 1) * margin;
                lift = s.slope != 0.0 && excess > lift ? excess : lift;
            }
        }
        table->radius[i] = (float)(first * (lift > lift_before ? lift : lift_before));
        lift_before = lift;
    }
    if (table->size > 1 && final_radius > 0.0f) {
        table->radius[table->size - 1] = (float)((double)final_radius * lift_before);
    }
    for (uint32_t i = table->size - 1; i-- > 0;) {
        table->radius[i] = stp_max(table->radius[i], table->radius[i + 1]);
    }
    assert(is_monotone(table) && table->count[table->size - 1] == count);
}

static segment segment_of(const stp_prefix_table* table, uint32_t i)
{
    return segment_between(table->count[i], (double)table->radius[i], table->count[i + 1],
                           (double)table->radius[i + 1]);
}

float stp_prefix_table_radius(const stp_prefix_table* table, uint32_t count)
{
    if (table->size == 0 || count == 0) {
        return INFINITY;
    }
    uint32_t low = 0, high = table->size; // the last breakpoint at or below `count`
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        *(table->count[middle] <= count ? &low : &high) = middle;
    }
    if (low + 1 == table->size || table->count[low] == count) {
        return table->radius[low];
    }
    segment s = segment_of(table, low);
    return s.slope == 0.0 ? table->radius[low] : (float)(radius_on(&s, count) * margin);
}

uint32_t stp_prefix_table_count(const stp_prefix_table* table, float radius)
{
    if (table->size == 0) {
        return 0;
    }
    uint32_t low = 0, high = table->size - 1; // the first breakpoint that covers, or the last
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (table->radius[middle] <= radius) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if (low == 0) {
        return table->count[0];
    }
    segment s = segment_of(table, low - 1);
    uint32_t first = table->count[low - 1] + 1, last = table->count[low], count = last;
    if (s.slope != 0.0 && radius > 0.0f) {
        double guess = s.first * exp2_of(log2_of((double)radius / s.radius) / s.slope);
        count = guess < last ? (uint32_t)guess : last;
        count = count < first ? first : count;
    }
    while (count < last && stp_prefix_table_radius(table, count) > radius) {
        count += 1;
    }
    while (count > first && stp_prefix_table_radius(table, count - 1) <= radius) {
        count -= 1;
    }
    return count;
}
