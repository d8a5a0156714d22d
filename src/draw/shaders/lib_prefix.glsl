// Prefix tables, and logarithms, as src/base/prefix_table.c.
#include "select_interface.h"

layout(std430, binding = BINDING_SELECT_SETS) readonly buffer Sets { select_set sets[]; };

#define PREFIX_MARGIN 1.000001lf

double log2_of(double x)
{
    uvec2 bits = unpackDouble2x32(x);
    int exponent = int(bits.y >> 20) - 1022;
    double m = packDouble2x32(uvec2(bits.x, (bits.y & 0xFFFFFu) | (1022u << 20))); // 0.5 up to 1
    if (m < 0.70710678118654752lf) {
        m *= 2.0lf;
        exponent -= 1;
    }
    double t = (m - 1.0lf) / (m + 1.0lf), square = t * t, sum = 0.0lf;
    for (int k = 15; k >= 1; k -= 2) {
        sum = sum * square + 1.0lf / double(k);
    }
    return double(exponent) + 2.0lf * t * sum * 1.4426950408889634lf;
}

double exp2_of(double x)
{
    if (x < -1000.0lf || x > 1000.0lf) {
        return x < 0.0lf ? 0.0lf : SELECT_INFINITE;
    }
    int whole = int(x < 0.0lf ? x - 0.5lf : x + 0.5lf);
    double t = (x - double(whole)) * 0.69314718055994531lf, sum = 1.0lf;
    for (int k = 13; k >= 1; --k) {
        sum = 1.0lf + sum * t / double(k);
    }
    return sum * packDouble2x32(uvec2(0u, uint(whole + 1023) << 20));
}

// The slope of log radius over log count between two breakpoints; 0 where it is flat.
double slope_of(uint set, uint at)
{
    double first = double(sets[set].radii[at]), last = double(sets[set].radii[at + 1u]);
    if (!(first > 0.0lf && last > 0.0lf && first < double(3.0e38))) {
        return 0.0lf;
    }
    return log2_of(last / first) / log2_of(double(sets[set].counts[at + 1u]) / double(sets[set].counts[at]));
}

// stp_prefix_table_radius, of a count above 0 and a table that has entries
float prefix_radius(uint set, uint count)
{
    uint low = 0u, high = sets[set].table_size;
    while (high - low > 1u) {
        uint middle = low + (high - low) / 2u;
        if (sets[set].counts[middle] <= count) {
            low = middle;
        } else {
            high = middle;
        }
    }
    float radius = sets[set].radii[low];
    if (low + 1u == sets[set].table_size || sets[set].counts[low] == count) {
        return radius;
    }
    double slope = slope_of(set, low);
    return slope == 0.0lf ? radius
                          : float(double(radius) *
                                  exp2_of(slope * log2_of(double(count) / double(sets[set].counts[low]))) *
                                  PREFIX_MARGIN);
}

// stp_prefix_table_count, of a table that has entries
uint prefix_count(uint set, float radius)
{
    uint low = 0u, high = sets[set].table_size - 1u;
    while (low < high) {
        uint middle = low + (high - low) / 2u;
        if (sets[set].radii[middle] <= radius) {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    if (low == 0u) {
        return sets[set].counts[0];
    }
    uint first = sets[set].counts[low - 1u] + 1u, last = sets[set].counts[low], count = last;
    double slope = slope_of(set, low - 1u);
    if (slope != 0.0lf && radius > 0.0) {
        double from = double(sets[set].counts[low - 1u]), most = double(last);
        double guess = from * exp2_of(log2_of(double(radius) / double(sets[set].radii[low - 1u])) / slope);
        count = guess < most ? uint(guess) : last;
        count = max(count, first);
    }
    for (uint i = 0u; i < 4096u && count < last && prefix_radius(set, count) > radius; ++i) {
        count += 1u;
    }
    for (uint i = 0u; i < 4096u && count > first && prefix_radius(set, count - 1u) <= radius; ++i) {
        count -= 1u;
    }
    return count;
}
