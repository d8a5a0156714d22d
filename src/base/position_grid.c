// SPDX-License-Identifier: MIT
//
// The step is a power of two, so only the exponents of lengths matter. The smallest triangles
// determine the step. They are found in two ways: the median edge of runs of consecutive triangles,
// which are mostly neighbours, so that a few slivers do not make a whole mesh expensive; and the
// shortest twentieth of all edges, for inputs without a useful order.
#include "base/position_grid.h"

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
    LEAST_MARGIN = 4,
    // and 1/16384 of the mesh's size, as large triangles often touch small ones of other meshes
    SIZE_DIGITS = 14,
    WIDE = 7, // the margin shrinks from this many octaves between short and typical edges on
    FLOAT_DIGITS = 23,
    NUMBER_BITS = 29,  // a coordinate is less than 2^30 steps
    STEP_LEAST = -149, // exponent of the smallest float
    // 2^31 steps stay finite; scenes need no larger numbers (scene/distance_limit.h)
    STEP_MOST = 96,
};

typedef struct octave_counts {
    uint32_t count[OCTAVES]; ///< squared lengths per exponent
    uint32_t least, most;    ///< exponents counted so far
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
    uint64_t bits = (uint64_t)(exponent + EXPONENT_BIAS) << 52;
    double value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static void add_all(octave_counts* sum, const octave_counts* counts)
{
    for (uint32_t i = counts->least; i <= counts->most && counts->total != 0; ++i) {
        sum->count[i] += counts->count[i];
    }
    sum->least = counts->least < sum->least ? counts->least : sum->least;
    sum->most = counts->most > sum->most ? counts->most : sum->most;
    sum->total += counts->total;
}

static void clear(octave_counts* counts)
{
    for (uint32_t i = counts->least; i <= counts->most && counts->total != 0; ++i) {
        counts->count[i] = 0;
    }
    counts->least = OCTAVES - 1;
    counts->most = 0;
    counts->total = 0;
}

static void add(octave_counts* counts, uint32_t octave)
{
    counts->count[octave] += 1;
    counts->least = octave < counts->least ? octave : counts->least;
    counts->most = octave > counts->most ? octave : counts->most;
    counts->total += 1;
}

/// Octave of the element at `rank` in ascending order; `rank` is below the count.
static uint32_t octave_at(const octave_counts* counts, uint64_t rank)
{
    uint64_t below = 0;
    for (uint32_t i = counts->least; i < counts->most; ++i) {
        below += counts->count[i];
        if (below > rank) {
            return i;
        }
    }
    return counts->most;
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
    float least[3], most[3];
} reach;

static void add_corner(reach* r, const float* p)
{
    for (int k = 0; k < 3; ++k) {
        r->least[k] = p[k] < r->least[k] ? p[k] : r->least[k];
        r->most[k] = p[k] > r->most[k] ? p[k] : r->most[k];
    }
}

static double largest_number(const reach* r)
{
    double largest = 0.0;
    for (int k = 0; k < 3; ++k) {
        largest = -(double)r->least[k] > largest ? -(double)r->least[k] : largest;
        largest = (double)r->most[k] > largest ? (double)r->most[k] : largest;
    }
    return largest;
}

static double longest_side(const reach* r)
{
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
        double side = (double)r->most[k] - (double)r->least[k];
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
    margin = margin < LEAST_MARGIN ? LEAST_MARGIN : margin;
    int low = (shortest - EXPONENT_BIAS - ((shortest - EXPONENT_BIAS) & 1)) / 2;
    int top = (int)exponent_of(largest) - EXPONENT_BIAS;
    int finest = (int)exponent_of(size) - EXPONENT_BIAS - SIZE_DIGITS;
    int step = size > 0.0 && finest < low - margin ? finest : low - margin;
    // finer than the float precision of the largest coordinate only as far as needed
    if (step < top - FLOAT_DIGITS) {
        step = low - LEAST_MARGIN < top - FLOAT_DIGITS ? low - LEAST_MARGIN : top - FLOAT_DIGITS;
    }
    step = step > top - NUMBER_BITS ? step : top - NUMBER_BITS;
    step = step < STEP_MOST ? step : STEP_MOST;
    return power_of_two(step > STEP_LEAST ? step : STEP_LEAST);
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
