// SPDX-License-Identifier: MIT
// Eigenvalues of scatter matrices (src/lod/stochastic/scatter.c) against an iterative reference.
#include "tests.h"

#include "base/math/rng.h"
#include "lod/psp/ellipse.h"
#include "lod/stochastic/scatter.h"

static double unit(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

/// Scatter matrix of points in a rotated box with the given sides.
static void make_matrix(uint64_t seed, const double sides[3], double matrix[6])
{
    stp_vec3d x =
        stp_normalized((stp_vec3d){unit(seed, 1) - 0.5, unit(seed, 2) - 0.5, unit(seed, 3) - 0.5});
    stp_vec3d y = stp_normalized(stp_crossd(x, (stp_vec3d){unit(seed, 4), 1.0, unit(seed, 5)}));
    stp_vec3d z = stp_crossd(x, y);
    stp_scatter scatter = {0};
    for (uint64_t i = 0; i < 200; ++i) {
        double a = sides[0] * (unit(seed, 10 + 3 * i) - 0.5);
        double b = sides[1] * (unit(seed, 11 + 3 * i) - 0.5);
        double c = sides[2] * (unit(seed, 12 + 3 * i) - 0.5);
        stp_scatter_add(&scatter, a * x.x + b * y.x + c * z.x, a * x.y + b * y.y + c * z.y,
                        a * x.z + b * y.z + c * z.z);
    }
    stp_scatter_matrix(&scatter, matrix);
}

void test_scatter_eigenvalues_are_those_of_jacobi(test_state* test)
{
    for (uint64_t seed = 0; seed < 2000; ++seed) {
        double sides[3], m[6], ours[3], theirs[3];
        for (uint64_t k = 0; k < 3; ++k) { // boxes, plates, rods
            double thin = unit(seed, 1000 + k);
            sides[k] = unit(seed, 2000 + k) < 0.4 ? 1e-4 * thin : thin;
        }
        make_matrix(seed, sides, m);
        stp_symmetric_eigenvalues(m, ours);
        stp_vec3d direction = stp_scatter_eigenvector(m, theirs);
        double sum = m[0] + m[3] + m[5];
        // two nearly equal roots are accurate to half of the digits
        bool apart = theirs[1] - theirs[0] > 1e-3 * sum && theirs[2] - theirs[1] > 1e-3 * sum;
        for (int k = 0; k < 3; ++k) {
            CHECK(fabs(ours[k] - theirs[k]) <= (apart ? 1e-12 : 1e-7) * sum);
        }
        CHECK(ours[0] <= ours[1] && ours[1] <= ours[2]);
        if (theirs[0] < 0.1 * theirs[1] && theirs[1] > 1e-3 * sum) {
            stp_vec3d n = stp_symmetric_eigenvector(m, ours[0]);
            CHECK(fabs(stp_dotd(n, direction)) > 1.0 - 1e-9);
        }
    }
}

void test_scatter_eigenvalues_of_special_matrices(test_state* test)
{
    double e[3];
    const double none[6] = {0}, equal[6] = {2, 0, 0, 2, 0, 2}, pair[6] = {1, 0, 0, 3, 0, 3},
                 line[6] = {0, 0, 0, 0, 0, 5}, low[6] = {1, 0, 0, 1, 0, 3};
    stp_symmetric_eigenvalues(none, e);
    CHECK(e[0] == 0.0 && e[2] == 0.0);
    stp_symmetric_eigenvalues(equal, e);
    CHECK(fabs(e[0] - 2.0) < 1e-12 && fabs(e[2] - 2.0) < 1e-12);
    stp_symmetric_eigenvalues(pair, e);
    CHECK(fabs(e[0] - 1.0) < 1e-7 && fabs(e[1] - 3.0) < 1e-7 && fabs(e[2] - 3.0) < 1e-7);
    stp_symmetric_eigenvalues(low, e);
    CHECK(fabs(e[0] - 1.0) < 1e-7 && fabs(e[1] - 1.0) < 1e-7 && fabs(e[2] - 3.0) < 1e-7);
    stp_symmetric_eigenvalues(line, e);
    CHECK(fabs(e[0]) < 1e-7 && fabs(e[1]) < 1e-7 && fabs(e[2] - 5.0) < 1e-7);
    CHECK(stp_scatter_is_flat(none, 0.005)); // one place
    CHECK(!stp_scatter_is_flat(equal, 0.005));
    stp_vec3d n = stp_symmetric_eigenvector(equal, 2.0); // all directions are equal
    CHECK(n.x == 0.0 && n.y == 1.0 && n.z == 0.0);
}

// The sum of reciprocals gives the smallest root if it is far below the others; otherwise the
// function returns false.
void test_scatter_shortcut_is_checked_by_substitution(test_state* test)
{
    uint32_t flat = 0, not_flat = 0;
    for (uint64_t seed = 0; seed < 4000; ++seed) {
        const double sides[3] = {1.0, 0.2 + unit(seed, 3000),
                                 0.5 * unit(seed, 3001) * unit(seed, 3002)};
        double m[6], theirs[3], minimum, sum;
        make_matrix(seed, sides, m);
        (void)stp_scatter_eigenvector(m, theirs);
        sum = theirs[0] + theirs[1] + theirs[2];
        bool found = stp_smallest_eigenvalue(m, &minimum);
        if (found) { // never above the root, and not far below
            CHECK(minimum <= theirs[0] * (1.0 + 1e-6) && minimum >= 0.75 * theirs[0]);
        } else {
            CHECK(theirs[0] > 0.04 * theirs[1]);
        }
        double share = theirs[0] / sum;
        if (share > 0.007) {
            CHECK(!stp_scatter_is_flat(m, 0.005));
            not_flat += 1;
        } else if (share < 0.005 && theirs[0] < 0.04 * theirs[1]) {
            CHECK(stp_scatter_is_flat(m, 0.005));
            flat += 1;
        }
    }
    CHECK(flat > 500 && not_flat > 500);
}

// Scatter matrices of parts, each from a sample of its points, add up to that of the whole, for any
// origin.
void test_scatter_of_parts_is_that_of_the_whole(test_state* test)
{
    for (uint64_t seed = 0; seed < 200; ++seed) {
        stp_scatter whole = {0}, sum = {0};
        for (uint64_t part = 0; part < 4; ++part) {
            stp_scatter own = {0};
            const double from[3] = {floor(1000.0 * unit(seed, 4 * part)),
                                    floor(900.0 * unit(seed, 4 * part + 1)),
                                    floor(800.0 * unit(seed, 4 * part + 2))};
            double weight = (double)(1 + part % 3);
            for (uint64_t i = 0; i < 20 + 5 * part; ++i) {
                const double p[3] = {floor(64.0 * unit(seed, 100 + 3 * (50 * part + i))),
                                     floor(64.0 * unit(seed, 101 + 3 * (50 * part + i))),
                                     floor(64.0 * unit(seed, 102 + 3 * (50 * part + i)))};
                stp_scatter_add(&own, p[0], p[1], p[2]);
                for (uint64_t k = 0; k <= part % 3; ++k) {
                    stp_scatter_add(&whole, from[0] + p[0], from[1] + p[1], from[2] + p[2]);
                }
            }
            stp_scatter_merge(&sum, &own, weight, from);
        }
        double expected[6], got[6];
        stp_scatter_matrix(&whole, expected);
        stp_scatter_matrix(&sum, got);
        for (int k = 0; k < 6; ++k) {
            CHECK(fabs(expected[k] - got[k]) <= 1e-9 * (expected[0] + expected[3] + expected[5]));
        }
    }
}

// Points near the meeting of two or three planes; on a plane; on a small part of a ball.
void test_scatter_tells_edges(test_state* test)
{
    uint32_t edges = 0, planes = 0, balls = 0;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        stp_scatter edge = {0}, plane = {0}, ball = {0};
        double m[6], e[3];
        for (uint64_t i = 0; i < 60; ++i) {
            double a = unit(seed, 3 * i) - 0.5, b = unit(seed, 3 * i + 1);
            bool up = (stp_rng_hash(seed, 3 * i + 2) & 1) != 0;
            stp_scatter_add(&edge, up ? 0.5 * b : 0.0, up ? 0.0 : 0.5 * b, a);
            stp_scatter_add(&plane, a, b, 0.02 * unit(seed, 900 + i));
            stp_scatter_add(&ball, a, b - 0.5, sqrt(9.0 - a * a - (b - 0.5) * (b - 0.5)));
        }
        const stp_scatter* all[3] = {&edge, &plane, &ball};
        uint32_t* counts[3] = {&edges, &planes, &balls};
        for (int k = 0; k < 3; ++k) {
            stp_scatter_matrix(all[k], m);
            stp_symmetric_eigenvalues(m, e);
            *counts[k] += stp_scatter_is_edge(e) ? 1 : 0;
        }
    }
    CHECK(edges == 200 && planes == 0 && balls == 0);
}
