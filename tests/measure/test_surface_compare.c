// SPDX-License-Identifier: MIT
#include "tests.h"

#include "lab/measure/surface_compare.h"

enum { SIZE = 16 };

// A square from 2 to 13 at depth 2, on an empty background.
static void make_square(float* nearness)
{
    for (int i = 0; i < SIZE * SIZE; ++i) {
        int x = i % SIZE, y = i / SIZE;
        nearness[i] = x >= 2 && x <= 13 && y >= 2 && y <= 13 ? 0.5f : 0.0f;
    }
}

void test_surface_compare_counts_each_error_once(test_state* test)
{
    float reference[SIZE * SIZE], other[SIZE * SIZE];
    make_square(reference);
    make_square(other);
    stp_surface_frame a = {SIZE, SIZE, reference}, b = {SIZE, SIZE, other};
    stp_surface_errors errors;
    stp_surface_compare(&a, &b, 0.001, 2.0, &errors);
    CHECK_EQUAL(144, errors.covered);
    CHECK_EQUAL(0, errors.holes + errors.wrong_depth + errors.extra);

    other[8 * SIZE + 8] = 0.0f;    // a hole well inside
    other[2 * SIZE + 8] = 0.0f;    // missing at the silhouette: not a hole
    other[5 * SIZE + 5] = 0.4f;    // a surface behind
    other[6 * SIZE + 5] = 0.4996f; // behind by less than two pixels' size: allowed
    other[7 * SIZE + 5] = 0.6f;    // in front: not this kind of error
    other[0] = 0.5f;               // outside
    stp_surface_compare(&a, &b, 0.001, 2.0, &errors);
    CHECK_EQUAL(144, errors.covered);
    CHECK_EQUAL(1, errors.holes);
    CHECK_EQUAL(1, errors.wrong_depth);
    CHECK_EQUAL(1, errors.extra);
    CHECK_EQUAL(64, errors.interior);       // all except a border of two pixels
    CHECK_EQUAL(144 - 2 + 1, errors.drawn); // two are missing and one is outside
}

void test_surface_compare_allows_depth_found_nearby(test_state* test)
{
    // the reference has a step: the surface behind may show up to two pixels across it
    float reference[SIZE * SIZE], other[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; ++i) {
        reference[i] = i % SIZE < 8 ? 1.0f : 0.1f;
        other[i] = i % SIZE < 5 ? 1.0f : 0.1f; // the step is three pixels off
    }
    stp_surface_frame a = {SIZE, SIZE, reference}, b = {SIZE, SIZE, other};
    stp_surface_errors errors;
    stp_surface_compare(&a, &b, 0.001, 2.0, &errors);
    CHECK_EQUAL(SIZE, errors.wrong_depth); // only the third column
    CHECK_EQUAL(0, errors.holes);
}
