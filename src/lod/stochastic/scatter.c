// SPDX-License-Identifier: MIT
#include "lod/stochastic/scatter.h"

#include <assert.h>

enum { NEWTON_STEPS = 6 };
#define ROOT_THREE 1.7320508075688772
#define IS_ROOT 0.1 // maximum remainder of the polynomial, relative to its largest term
// two eigenvalues count as alike if their ratio is above this
#define ALIKE 0.1
#define CERTAIN 1e-24 // relative to powers of the trace; below it, no direction is distinct

void stp_scatter_add(stp_scatter* s, double x, double y, double z)
{
    s->count += 1.0;
    s->x += x;
    s->y += y;
    s->z += z;
    s->xx += x * x;
    s->xy += x * y;
    s->xz += x * z;
    s->yy += y * y;
    s->yz += y * z;
    s->zz += z * z;
}

void stp_scatter_merge(stp_scatter* s, const stp_scatter* other, double weight,
                       const double from[3])
{
    assert(!(weight < 0.0));
    double x = from[0], y = from[1], z = from[2], n = other->count;
    s->count += weight * n;
    s->x += weight * (other->x + n * x);
    s->y += weight * (other->y + n * y);
    s->z += weight * (other->z + n * z);
    s->xx += weight * (other->xx + 2.0 * x * other->x + n * x * x);
    s->xy += weight * (other->xy + x * other->y + y * other->x + n * x * y);
    s->xz += weight * (other->xz + x * other->z + z * other->x + n * x * z);
    s->yy += weight * (other->yy + 2.0 * y * other->y + n * y * y);
    s->yz += weight * (other->yz + y * other->z + z * other->y + n * y * z);
    s->zz += weight * (other->zz + 2.0 * z * other->z + n * z * z);
}

void stp_scatter_matrix(const stp_scatter* s, double matrix[6])
{
    double each = s->count > 0.0 ? 1.0 / s->count : 0.0;
    double x = s->x * each, y = s->y * each, z = s->z * each;
    matrix[0] = s->xx * each - x * x;
    matrix[1] = s->xy * each - x * y;
    matrix[2] = s->xz * each - x * z;
    matrix[3] = s->yy * each - y * y;
    matrix[4] = s->yz * each - y * z;
    matrix[5] = s->zz * each - z * z;
}

/// Coefficients of the characteristic polynomial: l^3 - sum l^2 + squares l - det = 0.
typedef struct cubic {
    double sum, squares, det;
} cubic;

static cubic cubic_of(const double m[6])
{
    return (cubic){
        .sum = m[0] + m[3] + m[5],
        .squares =
            (m[0] * m[3] - m[1] * m[1]) + (m[0] * m[5] - m[2] * m[2]) + (m[3] * m[5] - m[4] * m[4]),
        .det = m[0] * (m[3] * m[5] - m[4] * m[4]) - m[1] * (m[1] * m[5] - m[4] * m[2]) +
               m[2] * (m[1] * m[4] - m[3] * m[2]),
    };
}

/// cos(acos(c) / 3), between 1/2 and 1: the root of 4 t^3 - 3 t = c, by Newton's method starting
/// above it.
static double cosine_of_third(double c)
{
    c = c > -1.0 ? (c < 1.0 ? c : 1.0) : -1.0;
    double t = 0.5 + 0.5 * sqrt(0.5 * (1.0 + c)) + 0.05 * sqrt(1.0 + c);
    for (int i = 0; i < NEWTON_STEPS; ++i) {
        double slope = 12.0 * t * t - 3.0;
        t -= slope > 0.0 ? ((4.0 * t * t - 3.0) * t - c) / slope : 0.0;
    }
    return t > 0.5 ? (t < 1.0 ? t : 1.0) : 0.5;
}

void stp_symmetric_eigenvalues(const double m[6], double eigenvalues[3])
{
    double mean = (m[0] + m[3] + m[5]) / 3.0;
    double a[6] = {m[0] - mean, m[1], m[2], m[3] - mean, m[4], m[5] - mean};
    double off = a[1] * a[1] + a[2] * a[2] + a[4] * a[4];
    double scale = sqrt((a[0] * a[0] + a[3] * a[3] + a[5] * a[5] + 2.0 * off) / 6.0);
    if (!(scale > 0.0)) {
        eigenvalues[0] = eigenvalues[1] = eigenvalues[2] = mean;
        return;
    }
    for (int i = 0; i < 6; ++i) {
        a[i] /= scale;
    }
    double t = cosine_of_third(0.5 * cubic_of(a).det);
    double s = 1.0 - t * t;
    double low = -0.5 * t - 0.5 * ROOT_THREE * sqrt(s > 0.0 ? s : 0.0);
    eigenvalues[2] = mean + 2.0 * scale * t;
    eigenvalues[0] = mean + 2.0 * scale * low;
    double middle = mean - 2.0 * scale * (t + low);
    middle = middle < eigenvalues[2] ? middle : eigenvalues[2];
    eigenvalues[1] = middle > eigenvalues[0] ? middle : eigenvalues[0];
    assert(!(eigenvalues[0] > eigenvalues[1]) && !(eigenvalues[1] > eigenvalues[2]));
}

bool stp_smallest_eigenvalue(const double m[6], double* eigenvalue)
{
    cubic c = cubic_of(m);
    *eigenvalue = 0.0;
    if (!(c.squares > CERTAIN * c.sum * c.sum)) {
        return false; // the points lie on a line
    }
    double x = c.det > 0.0 ? c.det / c.squares : 0.0;
    // at a root, the last two terms cancel; they are the largest ones of the polynomial
    double left = x * x * (c.sum - x), largest = c.squares * x;
    if (!(left <= IS_ROOT * largest)) {
        return false;
    }
    *eigenvalue = x;
    return true;
}

stp_vec3d stp_symmetric_eigenvector(const double m[6], double eigenvalue)
{
    // normal of two rows of (matrix - eigenvalue)
    const stp_vec3d rows[3] = {{m[0] - eigenvalue, m[1], m[2]},
                               {m[1], m[3] - eigenvalue, m[4]},
                               {m[2], m[4], m[5] - eigenvalue}};
    stp_vec3d best = {0};
    for (int i = 0; i < 3; ++i) {
        stp_vec3d across = stp_crossd(rows[i], rows[(i + 1) % 3]);
        best = stp_dotd(across, across) > stp_dotd(best, best) ? across : best;
    }
    double sum = fabs(m[0]) + fabs(m[3]) + fabs(m[5]);
    bool certain = stp_dotd(best, best) > CERTAIN * (sum * sum) * (sum * sum);
    stp_vec3d direction = stp_normalized(best);
    bool given = certain && stp_dotd(direction, direction) > 0.5;
    return given ? direction : (stp_vec3d){0.0, 1.0, 0.0};
}

double stp_scatter_flatness(const double matrix[6])
{
    double e[3], sum = matrix[0] + matrix[3] + matrix[5];
    stp_symmetric_eigenvalues(matrix, e);
    assert(!(3.0 * e[0] > sum + 1e-6 * fabs(sum)) && "the smallest is at most the mean");
    return sum > 0.0 && e[0] > 0.0 ? e[0] / sum : 0.0;
}

bool stp_scatter_is_flat(const double matrix[6], double threshold)
{
    double minimum, sum = matrix[0] + matrix[3] + matrix[5];
    if (!(sum > 0.0)) {
        return true; // all points coincide
    }
    return stp_smallest_eigenvalue(matrix, &minimum) && minimum <= threshold * sum;
}

bool stp_scatter_is_edge(const double e[3])
{
    bool alike = e[0] > ALIKE * e[1];
    double twice = 2.0 * e[0];
    return alike && e[2] > ALIKE * twice && ALIKE * e[2] < twice;
}
