// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/present/navigate.h"

#include <math.h>

void test_scale_bars_are_round_and_fit(test_state* test)
{
    for (int i = 0; i < 2000; ++i) {
        double pixel = pow(10.0, -9.0 + 0.009 * i);
        stp_scale_bar bar = stp_scale_bar_make(pixel, 160.0);
        CHECK(bar.pixels <= 160.0 * (1.0 + 1e-12) && bar.pixels > 160.0 / 2.5 * (1.0 - 1e-12));
        CHECK(fabs(bar.length - bar.pixels * pixel) <= 1e-12 * bar.length);
        double digits = bar.length / pow(10.0, floor(log10(bar.length) + 1e-9));
        CHECK(fabs(digits - 1.0) < 1e-9 || fabs(digits - 2.0) < 1e-9 || fabs(digits - 5.0) < 1e-9);
    }
    CHECK(stp_scale_bar_make(0.01, 100.0).length == 1.0);
    CHECK(stp_scale_bar_make(0.01, 99.0).length == 0.5);
}

void test_scale_bars_of_no_picture(test_state* test)
{
    static const double bad[] = {0.0, -1.0, (double)NAN, (double)INFINITY};
    for (int i = 0; i < 4; ++i) {
        CHECK(stp_scale_bar_make(bad[i], 100.0).length == 0.0);
        CHECK(stp_scale_bar_make(1.0, bad[i]).length == 0.0);
    }
}
