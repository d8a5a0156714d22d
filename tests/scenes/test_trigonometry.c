// SPDX-License-Identifier: MIT
#include "tests.h"

#include "lab/scenes/scene_random.h"
#include "lab/scenes/trigonometry.h"

#include <math.h>

void test_scene_sines_are_those_of_libm(test_state* test)
{
    double worst = 0.0;
    for (int i = -40000; i <= 40000; ++i) {
        double x = i * 0.000997;
        worst = fmax(worst, fabs(sine(x) - sin(x)));
        worst = fmax(worst, fabs(cosine(x) - cos(x)));
    }
    CHECK(worst < 1e-14);
    CHECK(turn_cosine(0.25) == 0.0 && turn_sine(0.25) == 1.0 && turn_sine(0.5) == 0.0);
    CHECK(turn_cosine(-3.5) == -1.0 && turn_sine(-0.25) == -1.0);
}

void test_scene_random_streams_are_uniform_and_apart(test_state* test)
{
    random_stream root = random_begin(7);
    random_stream a = random_fork(&root, 1), b = random_fork(&root, 2);
    double sum = 0.0, product = 0.0;
    for (int i = 0; i < 20000; ++i) {
        double x = random_unit(&a), y = random_between(&b, -1.0, 1.0);
        CHECK(x >= 0.0 && x < 1.0 && y >= -1.0 && y < 1.0);
        sum += x;
        product += (x - 0.5) * y;
    }
    CHECK(fabs(sum / 20000.0 - 0.5) < 0.01);
    CHECK(fabs(product / 20000.0) < 0.01);
    random_stream again = random_fork(&root, 1);
    CHECK(random_bits(&again) == stp_rng_hash(a.seed, 0));
}
