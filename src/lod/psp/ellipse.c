// SPDX-License-Identifier: MIT
#include "lod/psp/ellipse.h"

#include "base/splats/coverage.h"

#include <assert.h>
#include <string.h>

#define PI 3.14159265358979323846f
#define THIN 1e-3f ///< minimum minor axis, relative to the major axis
/// Minimum product of the two larger eigenvalues, relative to the squared trace; below it,
/// precision is lost
#define CERTAIN 1e-5
/// Minimum determinant of the scatter, relative to its squared trace; below it, points form a line
#define LINE 1e-6f

enum { SWEEPS_MAX = 32, NEWTON_MAX = 16, ROUNDS = 6 };

float stp_ellipse_area(const stp_ellipse* ellipse)
{
    return PI * stp_length(ellipse->major) * ellipse->minor;
}

void stp_ellipse_sample(const stp_ellipse* e, stp_vec3 samples[STP_ELLIPSE_SAMPLES])
{
    // cosines of multiples of an eighth of a turn
    static const float across[STP_ELLIPSE_SAMPLES] = {1,  0.70710678f,  0, -0.70710678f,
                                                      -1, -0.70710678f, 0, 0.70710678f};
    float length = stp_length(e->major);
    stp_vec3 minor = length > 0.0f ? stp_scale(stp_cross(e->normal, e->major), e->minor / length)
                                   : (stp_vec3){0};
    for (int i = 0; i < STP_ELLIPSE_SAMPLES; ++i) {
        stp_vec3 along = stp_scale(e->major, across[i]);
        stp_vec3 beside = stp_scale(minor, across[(i + 6) % STP_ELLIPSE_SAMPLES]);
        samples[i] = stp_add(e->center, stp_add(along, beside));
    }
}

stp_ellipse_fit stp_ellipse_fit_begin(stp_vec3 center, stp_vec3 normal)
{
    assert(!(stp_dot(normal, normal) > 1.01f) && "the normal is a unit vector");
    stp_disk_axes axes = stp_disk_axes_across(normal);
    return (stp_ellipse_fit){.center = center, .normal = normal, .x = axes.x, .y = axes.y};
}

static inline void scatter(stp_ellipse_fit* f, stp_vec3 point)
{
    stp_vec3 d = stp_sub(point, f->center);
    double u = (double)stp_dot(d, f->x), v = (double)stp_dot(d, f->y);
    f->xx += u * u;
    f->xy += u * v;
    f->yy += v * v;
}

void stp_ellipse_fit_scatter(stp_ellipse_fit* fit, stp_vec3 point)
{
    scatter(fit, point);
}

void stp_ellipse_fit_orient(stp_ellipse_fit* f, float minimum)
{
    assert(minimum > 0.0f && !(f->xx < 0.0) && !(f->yy < 0.0));
    // eigenvalues of the scatter, and the direction of the larger one
    double half = 0.5 * (f->xx - f->yy), root = sqrt(half * half + f->xy * f->xy);
    double mean = 0.5 * (f->xx + f->yy);
    double large = mean + root, small = mean - root > 0.0 ? mean - root : 0.0;
    double along = half >= 0.0 ? half + root : f->xy, beside = half >= 0.0 ? f->xy : root - half;
    double length = sqrt(along * along + beside * beside);
    float c = length > 0.0 ? (float)(along / length) : 1.0f;
    float s = length > 0.0 ? (float)(beside / length) : 0.0f;
    float ratio = large > 0.0 ? (float)sqrt(small / large) : 1.0f;
    f->ratio = ratio < THIN ? THIN : ratio;
    assert(f->ratio <= 1.0f && "the minor axis is the shorter one");
    f->major = stp_add(stp_scale(f->x, c), stp_scale(f->y, s));
    f->minor = stp_cross(f->normal, f->major);
    f->scale = minimum / f->ratio;
}

/// Squared scale at which the ellipse passes through a point.
static inline float squared_scale(const stp_ellipse_fit* f, stp_vec3 point)
{
    stp_vec3 d = stp_sub(point, f->center);
    float u = stp_dot(d, f->major), v = stp_dot(d, f->minor) / f->ratio;
    return u * u + v * v;
}

void stp_ellipse_fit_expand(stp_ellipse_fit* fit, stp_vec3 point)
{
    float away = sqrtf(squared_scale(fit, point));
    fit->scale = away > fit->scale ? away : fit->scale;
}

stp_ellipse stp_ellipse_fit_end(const stp_ellipse_fit* f)
{
    return (stp_ellipse){.center = f->center,
                         .normal = f->normal,
                         .major = stp_scale(f->major, f->scale),
                         .minor = f->scale * f->ratio};
}

enum { MOST = STP_ELLIPSE_COVER_MAX };

enum { LANES = 4, FOURS = MOST / LANES };

/// Four floats as one vector; all machines use the same order of operations.
typedef float four __attribute__((vector_size(LANES * sizeof(float))));
typedef int32_t four_masks __attribute__((vector_size(LANES * sizeof(int32_t))));

/// Points in a plane with weights of sum 1, their mean, and their scatter about it.
typedef struct weighted {
    four x[FOURS], y[FOURS], weight[FOURS];
    float mean_x, mean_y, xx, xy, yy;
} weighted;

static inline four fill(float value)
{
    return (four){value, value, value, value};
}

static inline four lesser(four a, four b)
{
    four_masks less = a < b;
    return (four)(((four_masks)a & less) | ((four_masks)b & ~less));
}

static inline float add_up(const four a[FOURS])
{
    four sum = (a[0] + a[2]) + (a[1] + a[3]);
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static inline float find_least(const four a[FOURS])
{
    four minimum = lesser(lesser(a[0], a[2]), lesser(a[1], a[3]));
    float x = minimum[0] < minimum[2] ? minimum[0] : minimum[2];
    float y = minimum[1] < minimum[3] ? minimum[1] : minimum[3];
    return x < y ? x : y;
}

static inline void find_spread(weighted* w)
{
    assert(!(fabsf(add_up(w->weight) - 1.0f) > 1e-3f) && "weights of sum 1");
    four a[FOURS], b[FOURS], c[FOURS];
    for (int i = 0; i < FOURS; ++i) {
        a[i] = w->weight[i] * w->x[i];
        b[i] = w->weight[i] * w->y[i];
    }
    w->mean_x = add_up(a);
    w->mean_y = add_up(b);
    four x = fill(w->mean_x), y = fill(w->mean_y);
    for (int i = 0; i < FOURS; ++i) {
        four dx = w->x[i] - x, dy = w->y[i] - y;
        a[i] = w->weight[i] * (dx * dx);
        b[i] = w->weight[i] * (dx * dy);
        c[i] = w->weight[i] * (dy * dy);
    }
    w->xx = add_up(a);
    w->xy = add_up(b);
    w->yy = add_up(c);
}

/// Increases the weights of points far from the mean, relative to the spread. The scatter converges
/// to the shape of the smallest enclosing ellipse (the dual problem; Dette, Pepelyshev, Zhigljavsky
/// 2008).
/// @return false if the points lie on a line
static inline bool reweigh(weighted* w)
{
    float det = w->xx * w->yy - w->xy * w->xy, both = w->xx + w->yy;
    if (!(det > LINE * both * both)) {
        return false;
    }
    four xx = fill(w->yy / det), xy = fill(-2.0f * w->xy / det), yy = fill(w->xx / det);
    four mean_x = fill(w->mean_x), mean_y = fill(w->mean_y), far[FOURS];
    for (int i = 0; i < FOURS; ++i) {
        four x = w->x[i] - mean_x, y = w->y[i] - mean_y;
        four away = xx * (x * x) + xy * (x * y) + yy * (y * y); // the weighted mean is 2
        far[i] = (four)((four_masks)away & (away > fill(0.0f)));
    }
    four half = fill(0.5f * find_least(far));
    for (int i = 0; i < FOURS; ++i) {
        w->weight[i] *= far[i] - half;
    }
    four share = fill(1.0f / add_up(w->weight));
    for (int i = 0; i < FOURS; ++i) {
        w->weight[i] *= share;
    }
    return true;
}

/// Moves the centre almost to that of the smallest enclosing ellipse, and gives the scatter the
/// shape of this ellipse.
static void find_smallest(stp_ellipse_fit* f, const stp_vec3* points, size_t count)
{
    float x[MOST], y[MOST], weight[MOST];
    for (size_t i = 0; i < MOST; ++i) { // pads with the last point, of weight 0
        stp_vec3 d = stp_sub(points[i < count ? i : count - 1], f->center);
        x[i] = stp_dot(d, f->x);
        y[i] = stp_dot(d, f->y);
        weight[i] = i < count ? 1.0f / (float)count : 0.0f;
    }
    weighted w;
    memcpy(w.x, x, sizeof(x));
    memcpy(w.y, y, sizeof(y));
    memcpy(w.weight, weight, sizeof(weight));
    find_spread(&w);
    for (int round = 0; round < ROUNDS && reweigh(&w); ++round) {
        find_spread(&w);
    }
    stp_vec3 along = stp_scale(f->x, w.mean_x), beside = stp_scale(f->y, w.mean_y);
    f->center = stp_add(f->center, stp_add(along, beside));
    f->xx = (double)w.xx;
    f->xy = (double)w.xy;
    f->yy = (double)w.yy;
}

stp_ellipse stp_ellipse_cover(stp_vec3 center, stp_vec3 normal, const stp_vec3* points,
                              size_t count, float minimum)
{
    assert(count <= STP_ELLIPSE_COVER_MAX && minimum > 0.0f);
    stp_ellipse_fit fit = stp_ellipse_fit_begin(center, normal);
    if (count > 0) {
        find_smallest(&fit, points, count);
    }
    stp_ellipse_fit_orient(&fit, minimum);
    float maximum = 0.0f;
    for (size_t i = 0; i < count; ++i) {
        float square = squared_scale(&fit, points[i]);
        maximum = square > maximum ? square : maximum;
    }
    maximum = sqrtf(maximum);
    fit.scale = maximum > fit.scale ? maximum : fit.scale;
    return stp_ellipse_fit_end(&fit);
}

/// Jacobi rotation: rotates rows and columns p and q of a symmetric matrix so that a[p][q] becomes
/// 0.
static void turn(double a[3][3], double v[3][3], int p, int q)
{
    if (a[p][q] == 0.0) {
        return;
    }
    double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < 3; ++k) {
        double kp = a[k][p], kq = a[k][q];
        a[k][p] = c * kp - s * kq;
        a[k][q] = s * kp + c * kq;
    }
    for (int k = 0; k < 3; ++k) {
        double pk = a[p][k], qk = a[q][k];
        a[p][k] = c * pk - s * qk;
        a[q][k] = s * pk + c * qk;
        double vp = v[k][p], vq = v[k][q];
        v[k][p] = c * vp - s * vq;
        v[k][q] = s * vp + c * vq;
    }
}

stp_vec3d stp_scatter_eigenvector(const double m[6], double eigenvalues[3])
{
    double a[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < SWEEPS_MAX; ++sweep) {
        double off = fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]);
        if (!(off > 1e-18 * (fabs(a[0][0]) + fabs(a[1][1]) + fabs(a[2][2])))) {
            break;
        }
        turn(a, v, 0, 1);
        turn(a, v, 0, 2);
        turn(a, v, 1, 2);
    }
    int minimum = a[1][1] < a[0][0] ? 1 : 0;
    minimum = a[2][2] < a[minimum][minimum] ? 2 : minimum;
    double low = a[(minimum + 1) % 3][(minimum + 1) % 3],
           high = a[(minimum + 2) % 3][(minimum + 2) % 3];
    eigenvalues[0] = a[minimum][minimum];
    eigenvalues[1] = low < high ? low : high;
    eigenvalues[2] = low < high ? high : low;
    assert(!(eigenvalues[0] > eigenvalues[1]) && !(eigenvalues[1] > eigenvalues[2]));
    return (stp_vec3d){v[0][minimum], v[1][minimum], v[2][minimum]};
}

/// Smallest root of the characteristic polynomial of a positive semidefinite matrix, by Newton's
/// method from 0. Left of all roots the polynomial is concave, so the steps never overshoot.
/// @return false if convergence is slow or precision is lost: two eigenvalues are almost equal, or
///         two are almost 0
static bool find_smallest_root(const double m[6], double* root)
{
    double sum = m[0] + m[3] + m[5];
    double squares =
        (m[0] * m[3] - m[1] * m[1]) + (m[0] * m[5] - m[2] * m[2]) + (m[3] * m[5] - m[4] * m[4]);
    double det = m[0] * (m[3] * m[5] - m[4] * m[4]) - m[1] * (m[1] * m[5] - m[4] * m[2]) +
                 m[2] * (m[1] * m[4] - m[3] * m[2]);
    double x = 0.0;
    if (!(squares > CERTAIN * sum * sum)) {
        return false;
    }
    for (int step = 0; step < NEWTON_MAX; ++step) {
        double value = ((x - sum) * x + squares) * x - det;
        double slope = (3.0 * x - 2.0 * sum) * x + squares;
        double next = x - value / slope;
        if (!(fabs(next - x) > 1e-15 * sum)) {
            *root = next;
            return true;
        }
        x = next;
    }
    return false;
}

double stp_scatter_eigenvalue(const double m[6])
{
    double eigenvalues[3];
    if (!find_smallest_root(m, &eigenvalues[0])) {
        (void)stp_scatter_eigenvector(m, eigenvalues);
    }
    return eigenvalues[0];
}

stp_vec3d stp_scatter_normal(const double m[6])
{
    double minimum, eigenvalues[3];
    if (find_smallest_root(m, &minimum)) {
        // normal of two rows of (matrix - eigenvalue)
        const stp_vec3d rows[3] = {{m[0] - minimum, m[1], m[2]},
                                   {m[1], m[3] - minimum, m[4]},
                                   {m[2], m[4], m[5] - minimum}};
        stp_vec3d best = {0};
        for (int i = 0; i < 3; ++i) {
            stp_vec3d across = stp_crossd(rows[i], rows[(i + 1) % 3]);
            best = stp_dotd(across, across) > stp_dotd(best, best) ? across : best;
        }
        double sum = m[0] + m[3] + m[5];
        if (stp_dotd(best, best) > CERTAIN * CERTAIN * (sum * sum) * (sum * sum)) {
            return stp_normalized(best);
        }
    }
    return stp_scatter_eigenvector(m, eigenvalues);
}
