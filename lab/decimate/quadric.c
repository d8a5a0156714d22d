// SPDX-License-Identifier: MIT
#include "lab/decimate/contraction.h"

#include <assert.h>

/// relative to the mean curvature: added in all directions, so that the minimum is unique
#define FLAT 1e-3

void stp_quadric_add_plane(stp_quadric* q, stp_vec3d p, stp_vec3d n)
{
    assert(fabs(stp_dotd(n, n) - 1.0) < 1e-3 && "a unit normal");
    double away = -stp_dotd(p, n);
    const double plane[6] = {n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z};
    for (int i = 0; i < 6; ++i) {
        q->a[i] += plane[i];
    }
    q->b = stp_addd(q->b, stp_scaled(n, away));
    q->c += away * away;
}

stp_quadric stp_quadric_sum(const stp_quadric* a, const stp_quadric* b)
{
    stp_quadric q = {.b = stp_addd(a->b, b->b), .c = a->c + b->c};
    for (int i = 0; i < 6; ++i) {
        q.a[i] = a->a[i] + b->a[i];
    }
    return q;
}

static stp_vec3d apply(const stp_quadric* q, stp_vec3d p)
{
    const double* a = q->a;
    return (stp_vec3d){a[0] * p.x + a[1] * p.y + a[2] * p.z, a[1] * p.x + a[3] * p.y + a[4] * p.z,
                       a[2] * p.x + a[4] * p.y + a[5] * p.z};
}

double stp_quadric_at(const stp_quadric* q, stp_vec3d p)
{
    double value = stp_dotd(p, apply(q, p)) + 2.0 * stp_dotd(q->b, p) + q->c;
    return value > 0.0 ? value : 0.0;
}

double stp_quadric_planes(const stp_quadric* q)
{
    return q->a[0] + q->a[3] + q->a[5];
}

stp_vec3d stp_quadric_minimum(const stp_quadric* q, stp_vec3d start, double reach)
{
    assert(!(reach < 0.0));
    double planes = stp_quadric_planes(q), extra = FLAT / 3.0 * planes;
    if (!(planes > 0.0)) {
        return start;
    }
    // (A + extra) d = -(A start + b), by Cholesky: A has no negative eigenvalues
    stp_vec3d r = stp_scaled(stp_addd(apply(q, start), q->b), -1.0);
    double d0 = q->a[0] + extra, l10 = q->a[1] / d0, l20 = q->a[2] / d0;
    double d1 = q->a[3] + extra - l10 * q->a[1], m = q->a[4] - l20 * q->a[1], l21 = m / d1;
    double d2 = q->a[5] + extra - l20 * q->a[2] - l21 * m;
    assert(d0 > 0.0 && d1 > 0.0 && d2 > 0.0 && "positive definite");
    double y = r.y - l10 * r.x, z = (r.z - l20 * r.x - l21 * y) / d2;
    stp_vec3d d = {.z = z};
    d.y = y / d1 - l21 * z;
    d.x = r.x / d0 - l10 * d.y - l20 * z;
    return stp_dotd(d, d) <= reach * reach ? stp_addd(start, d) : start;
}
