// SPDX-License-Identifier: MIT
#include "lod/psp/ellipse.h"

#include "base/coverage.h"

#define PI 3.14159265358979323846f
#define THIN 1e-3f ///< of the major axis: the least minor axis
enum { SWEEPS_MOST = 32 };

float stp_ellipse_area(const stp_ellipse* ellipse)
{
    return PI * stp_length(ellipse->major) * ellipse->minor;
}

void stp_ellipse_sample(const stp_ellipse* e, stp_vec3 samples[STP_ELLIPSE_SAMPLES])
{
    // cosines of eighths of a turn
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

stp_ellipse_fit stp_ellipse_fit_begin(stp_vec3 center, stp_vec3 normal, double xx, double xy,
                                      double yy, float least)
{
    stp_disk_axes axes = stp_disk_axes_across(normal);
    // eigenvalues of the scatter, and the direction of the larger one
    double half = 0.5 * (xx - yy), root = sqrt(half * half + xy * xy), mean = 0.5 * (xx + yy);
    double large = mean + root, small = mean - root > 0.0 ? mean - root : 0.0;
    double along = half >= 0.0 ? half + root : xy, beside = half >= 0.0 ? xy : root - half;
    double length = sqrt(along * along + beside * beside);
    float c = length > 0.0 ? (float)(along / length) : 1.0f;
    float s = length > 0.0 ? (float)(beside / length) : 0.0f;
    float ratio = large > 0.0 ? (float)sqrt(small / large) : 1.0f;
    ratio = ratio < THIN ? THIN : ratio;
    stp_vec3 major = stp_add(stp_scale(axes.x, c), stp_scale(axes.y, s));
    return (stp_ellipse_fit){.center = center,
                             .normal = normal,
                             .major = major,
                             .minor = stp_cross(normal, major),
                             .ratio = ratio,
                             .scale = least / ratio};
}

void stp_ellipse_fit_add(stp_ellipse_fit* fit, stp_vec3 point)
{
    stp_vec3 d = stp_sub(point, fit->center);
    float u = stp_dot(d, fit->major), v = stp_dot(d, fit->minor) / fit->ratio;
    float reach = sqrtf(u * u + v * v);
    fit->scale = reach > fit->scale ? reach : fit->scale;
}

stp_ellipse stp_ellipse_fit_end(const stp_ellipse_fit* fit)
{
    return (stp_ellipse){.center = fit->center,
                         .normal = fit->normal,
                         .major = stp_scale(fit->major, fit->scale),
                         .minor = fit->scale * fit->ratio};
}

stp_ellipse stp_ellipse_cover(stp_vec3 center, stp_vec3 normal, const stp_vec3* points,
                              size_t count, float least)
{
    stp_disk_axes axes = stp_disk_axes_across(normal);
    double xx = 0.0, xy = 0.0, yy = 0.0;
    for (size_t i = 0; i < count; ++i) {
        stp_vec3 d = stp_sub(points[i], center);
        double u = (double)stp_dot(d, axes.x), v = (double)stp_dot(d, axes.y);
        xx += u * u;
        xy += u * v;
        yy += v * v;
    }
    stp_ellipse_fit fit = stp_ellipse_fit_begin(center, normal, xx, xy, yy, least);
    for (size_t i = 0; i < count; ++i) {
        stp_ellipse_fit_add(&fit, points[i]);
    }
    return stp_ellipse_fit_end(&fit);
}

/// Turns rows and columns p and q of a symmetric matrix so that a[p][q] is 0 (Jacobi).
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

stp_vec3d stp_least_direction(const double m[6], double eigenvalues[3])
{
    double a[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < SWEEPS_MOST; ++sweep) {
        double off = fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]);
        if (!(off > 1e-18 * (fabs(a[0][0]) + fabs(a[1][1]) + fabs(a[2][2])))) {
            break;
        }
        turn(a, v, 0, 1);
        turn(a, v, 0, 2);
        turn(a, v, 1, 2);
    }
    int least = a[1][1] < a[0][0] ? 1 : 0;
    least = a[2][2] < a[least][least] ? 2 : least;
    double low = a[(least + 1) % 3][(least + 1) % 3], high = a[(least + 2) % 3][(least + 2) % 3];
    eigenvalues[0] = a[least][least];
    eigenvalues[1] = low < high ? low : high;
    eigenvalues[2] = low < high ? high : low;
    return (stp_vec3d){v[0][least], v[1][least], v[2][least]};
}
