// SPDX-License-Identifier: MIT
#include "base/math/math.h"

#include <assert.h>
#include <string.h>

double stp_affine_stretch(const stp_affine* a)
{
    double b[3][3], rows = 0.0, trace = 0.0; // b: squared lengths after the map, over their trace
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            b[i][k] = a->m[0][i] * a->m[0][k] + a->m[1][i] * a->m[1][k] + a->m[2][i] * a->m[2][k];
        }
        double row = fabs(b[i][0]) + fabs(b[i][1]) + fabs(b[i][2]); // Gershgorin's bound
        rows = row > rows ? row : rows;
        trace += b[i][i];
    }
    if (!(trace > 0.0) || trace > DBL_MAX) {
        return 0.0;
    }
    double bound = 1.0, factor = trace; // largest eigenvalue <= (trace of b^64)^(1/64)
    for (int power = 0; power < 6; ++power) {
        double squared[3][3], sum = 0.0;
        for (int i = 0; i < 9; ++i) {
            b[i / 3][i % 3] /= factor;
        }
        for (int i = 0; i < 9; ++i) {
            int r = i / 3, c = i % 3;
            squared[r][c] = b[r][0] * b[0][c] + b[r][1] * b[1][c] + b[r][2] * b[2][c];
            sum += r == c ? squared[r][c] : 0.0;
        }
        memcpy(b, squared, sizeof(b));
        double root = factor;
        for (int k = 0; k < power; ++k) {
            root = sqrt(root);
        }
        bound *= root;
        factor = sum;
    }
    for (int k = 0; k < 6; ++k) {
        factor = sqrt(factor);
    }
    bound *= factor;
    assert((trace < 1e-290 || !((bound < rows ? bound : rows) < trace / 3.0 * (1.0 - 1e-9))) &&
           "the largest eigenvalue is at least their mean");
    return sqrt(bound < rows ? bound : rows);
}
