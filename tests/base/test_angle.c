// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"

void test_angle_sine_cosine(test_state* test)
{
    double worst = 0.0;
    for (int i = -40000; i <= 40000; ++i) {
        double angle = i * 0.000917 + (i % 7) * 1e-9, sine, cosine;
        stp_sine_cosine(angle, &sine, &cosine);
        worst = fmax(worst, fabs(sine - sin(angle)));
        worst = fmax(worst, fabs(cosine - cos(angle)));
    }
    CHECK(worst < 1e-15);
    double sine, cosine;
    stp_sine_cosine(0.0, &sine, &cosine);
    CHECK(sine == 0.0 && cosine == 1.0);
    stp_sine_cosine(1e6, &sine, &cosine);
    CHECK(fabs(sine - sin(1e6)) < 1e-9 && fabs(cosine - cos(1e6)) < 1e-9);
    stp_sine_cosine(1e7, &sine, &cosine);
    CHECK(isnan(sine) && isnan(cosine));
    stp_sine_cosine((double)NAN, &sine, &cosine);
    CHECK(isnan(sine) && isnan(cosine));
}
