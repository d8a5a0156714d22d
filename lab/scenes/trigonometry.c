// SPDX-License-Identifier: MIT
#include "lab/scenes/trigonometry.h"

#include <stdint.h>

static const double tau = 6.28318530717958647692;

// Taylor series on [-pi/4, pi/4], highest power first; the first omitted term is below 1e-16.
static double series(const double* coefficients, int count, double x)
{
    double sum = coefficients[0];
    for (int i = 1; i < count; ++i) {
        sum = sum * x + coefficients[i];
    }
    return sum;
}

static double near_sine(double x)
{
    static const double coefficients[] = {
        -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
        -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0,        1.0};
    return x * series(coefficients, 8, x * x);
}

static double near_cosine(double x)
{
    static const double coefficients[] = {1.0 / 20922789888000.0,
                                          -1.0 / 87178291200.0,
                                          1.0 / 479001600.0,
                                          -1.0 / 3628800.0,
                                          1.0 / 40320.0,
                                          -1.0 / 720.0,
                                          1.0 / 24.0,
                                          -1.0 / 2.0,
                                          1.0};
    return series(coefficients, 9, x * x);
}

// Sine of `turns` plus `quarters` quarter turns.
static double quarter_sine(double turns, int64_t quarters)
{
    double scaled = turns * 4.0;
    int64_t nearest = (int64_t)(scaled < 0.0 ? scaled - 0.5 : scaled + 0.5);
    double rest = (scaled - (double)nearest) * (tau / 4.0);
    switch ((nearest + quarters) & 3) {
    case 0:
        return near_sine(rest);
    case 1:
        return near_cosine(rest);
    case 2:
        return -near_sine(rest);
    default:
        return -near_cosine(rest);
    }
}

double turn_sine(double turns)
{
    return quarter_sine(turns, 0);
}

double turn_cosine(double turns)
{
    return quarter_sine(turns, 1);
}

double sine(double radians)
{
    return quarter_sine(radians / tau, 0);
}

double cosine(double radians)
{
    return quarter_sine(radians / tau, 1);
}
