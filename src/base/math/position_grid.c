// SPDX-License-Identifier: MIT
//
// The step is a power of two, so only the exponents of lengths matter. The smallest triangles
// determine the step. They are found in two ways: the median edge of runs of consecutive triangles,
// which are mostly neighbours, so that a few slivers do not make a whole mesh expensive; and the
// shortest twentieth of all edges, for inputs without a useful order.
#include "base/math/position_grid.h"

#include <assert.h>
#include <float.h>
#include <stdbool.h>
#include <string.h>

enum {
    RUN_TRIANGLES = 32,
    OCTAVES = 2048, // exponents of a double
    EXPONENT_BIAS = 1023,
    // the step is at most 1/64 of the short edges, so that quantised triangles keep their normals
    MARGIN = 6,
    // 1/16 if edge lengths differ a lot, so that large triangles cost fewer bytes
    MIN_MARGIN = 4,
    // and 1/16384 of the mesh's size, as large triangles often touch small ones of other meshes
    SIZE_DIGITS = 14,
    WIDE = 7, // the margin shrinks from this many octaves between short and typical edges on
    FLOAT_DIGITS = 23,
    NUMBER_BITS = 29, // a coordinate is less than 2^30 steps
    STEP_MIN = -149,  // exponent of the smallest float
    // 2^31 steps stay finite; scenes need no larger numbers (scene/finish_steps.h)
    STEP_MAX = 96,
};

typedef struct octave_counts {
    uint32_t count[OCTAVES];   ///< squared lengths per exponent
    uint32_t minimum, maximum; ///< exponents counted so far
    uint64_t total;
} octave_counts;

static uint32_t exponent_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return (uint32_t)(bits >> 52) & (OCTAVES - 1);
}

static double power_of_two(int exponent)
{
    assert(exponent > -EXPONENT_BIAS && exponent <= EXPONENT_BIAS && "a normal number");
    uint64_t bits = (uint64_t)(exponent + EXPONENT_BIAS) << 52;
    double value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static void add_all(octave_counts* sum, const octave_counts* counts)
{
    for (uint32_t i = counts->minimum; i <= counts->maximum && counts->total != 0; ++i) {
        sum->count[i] += counts->count[i];
    }
    sum->minimum = counts->minimum < sum->minimum ? counts->minimum : sum->minimum;
    sum->maximum = counts->maximum > sum->maximum ? counts->maximum : sum->maximum;
    sum->total += counts->total;
}

static void clear(octave_counts* counts)
{
    for (uint32_t i = counts->minimum; i <= counts->maximum && counts->total != 0; ++i) {
        counts->count[i] = 0;
    }
    counts->minimum = OCTAVES - 1;
    counts->maximum = 0;
    counts->total = 0;
}

static void add(octave_counts* counts, uint32_t octave)
{
    counts->count[octave] += 1;
    counts->minimum = octave < counts->minimum ? octave : counts->minimum;
    counts->maximum = octave > counts->maximum ? octave : counts->maximum;
    counts->total += 1;
}

/// Octave of the element at `rank` in ascending order; `rank` is below the count.
static uint32_t octave_at(const octave_counts* counts, uint64_t rank)
{
    assert(rank < counts->total);
    uint64_t below = 0;
    for (uint32_t i = counts->minimum; i < counts->maximum; ++i) {
        below += counts->count[i];
        if (below > rank) {
            return i;
        }
    }
    return counts->maximum;
}

static void add_edge(octave_counts* run, const float* a, const float* b)
{
    double x = (double)a[0] - (double)b[0], y = (double)a[1] - (double)b[1],
           z = (double)a[2] - (double)b[2];
    double square = x * x + y * y + z * z;
    if (square > 0.0) {
        add(run, exponent_of(square));
    }
}

typedef struct reach {
    float minimum[3], maximum[3];
} reach;

static void add_corner(reach* r, const float* p)
{
    for (int k = 0; k < 3; ++k) {
        r->minimum[k] = p[k] < r->minimum[k] ? p[k] : r->minimum[k];
        r->maximum[k] = p[k] > r->maximum[k] ? p[k] : r->maximum[k];
    }
}

static double largest_number(const reach* r)
{
    double largest = 0.0;
    for (int k = 0; k < 3; ++k) {
        largest = -(double)r->minimum[k] > largest ? -(double)r->minimum[k] : largest;
        largest = (double)r->maximum[k] > largest ? (double)r->maximum[k] : largest;
    }
    return largest;
}

static double longest_side(const reach* r)
{
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
        double side = (double)r->maximum[k] - (double)r->minimum[k];
        longest = side > longest ? side : longest;
    }
    return longest;
}

/// Chooses the step from the octaves of two squared edge lengths, the mesh's size, and its largest
/// coordinate.
static double choose(int shortest, int typical, double size, double largest)
{
    int wide = (typical - shortest) / 2 - WIDE; // octaves of lengths
    int margin = MARGIN - (wide > 0 ? (wide + 1) / 2 : 0);
    margin = margin < MIN_MARGIN ? MIN_MARGIN : margin;
    int low = (shortest - EXPONENT_BIAS - ((shortest - EXPONENT_BIAS) & 1)) / 2;
    int top = (int)exponent_of(largest) - EXPONENT_BIAS;
    int finest = (int)exponent_of(size) - EXPONENT_BIAS - SIZE_DIGITS;
    int step = size > 0.0 && finest < low - margin ? finest : low - margin;
    // finer than the float precision of the largest coordinate only as far as needed
    if (step < top - FLOAT_DIGITS) {
        step = low - MIN_MARGIN < top - FLOAT_DIGITS ? low - MIN_MARGIN : top - FLOAT_DIGITS;
    }
    step = step > top - NUMBER_BITS ? step : top - NUMBER_BITS;
    step = step < STEP_MAX ? step : STEP_MAX;
    assert((step == STEP_MAX || largest < power_of_two(step + NUMBER_BITS + 1)) &&
           "coordinates are below 2^30 steps");
    return power_of_two(step > STEP_MIN ? step : STEP_MIN);
}

double stp_choose_grid_step(const float* positions, const uint32_t* indices,
                            uint32_t triangle_count)
{
    octave_counts run, all;
    memset(&run, 0, sizeof(run));
    memset(&all, 0, sizeof(all));
    clear(&run);
    clear(&all);
    uint32_t shortest = OCTAVES - 1;
    reach whole = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (uint32_t t = 0; t < triangle_count; ++t) {
        const float* p[3];
        for (size_t k = 0; k < 3; ++k) {
            p[k] = positions + 3 * (size_t)indices[3 * (size_t)t + k];
            add_corner(&whole, p[k]);
        }
        for (int k = 0; k < 3; ++k) {
            add_edge(&run, p[k], p[(k + 1) % 3]);
        }
        bool ends = (t + 1) % RUN_TRIANGLES == 0 || t + 1 == triangle_count;
        if (ends && run.total != 0 && (run.total >= RUN_TRIANGLES || shortest == OCTAVES - 1)) {
            uint32_t median = octave_at(&run, run.total / 2);
            shortest = median < shortest ? median : shortest;
        }
        if (ends) {
            add_all(&all, &run);
            clear(&run);
        }
    }
    double largest = largest_number(&whole);
    if (all.total == 0) { // all triangles are degenerate: use the float precision
        int top = (int)exponent_of(largest);
        return largest > 0.0
                   ? choose(2 * top - EXPONENT_BIAS, 2 * top - EXPONENT_BIAS, 0.0, largest)
                   : 1.0;
    }
    uint32_t low = octave_at(&all, all.total / 20);
    return choose((int)(low < shortest ? low : shortest), (int)octave_at(&all, all.total / 2),
                  longest_side(&whole), largest);
}
