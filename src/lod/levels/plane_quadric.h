// SPDX-License-Identifier: MIT
// Quadrics of planes (Garland, Heckbert 1997, 4): the weighted sum of squared distances to them.
#pragma once

#include "base/math/math.h"

/// p' A p + 2 b' p + c, with A symmetric. All zero: no planes.
typedef struct stp_plane_quadric {
    double xx, xy, xz, yy, yz, zz; ///< A
    double x, y, z;                ///< b
    double constant;
    double weight; ///< sum of the weights that count as area
} stp_plane_quadric;

/// Adds the plane normal . p + offset = 0 with unit `normal`, which counts `weight` times in the
/// sum, and `area` in the weight.
static inline void stp_plane_quadric_add(stp_plane_quadric* q, stp_vec3d normal, double offset,
                                         double weight, double area)
{
    double x = weight * normal.x, y = weight * normal.y, z = weight * normal.z;
    q->xx += x * normal.x;
    q->xy += x * normal.y;
    q->xz += x * normal.z;
    q->yy += y * normal.y;
    q->yz += y * normal.z;
    q->zz += z * normal.z;
    q->x += x * offset;
    q->y += y * offset;
    q->z += z * offset;
    q->constant += weight * offset * offset;
    q->weight += area;
}

static inline stp_plane_quadric stp_plane_quadric_sum(const stp_plane_quadric* a,
                                                      const stp_plane_quadric* b)
{
    return (stp_plane_quadric){a->xx + b->xx,        a->xy + b->xy,
                               a->xz + b->xz,        a->yy + b->yy,
                               a->yz + b->yz,        a->zz + b->zz,
                               a->x + b->x,          a->y + b->y,
                               a->z + b->z,          a->constant + b->constant,
                               a->weight + b->weight};
}

/// The weighted sum of squared distances of a point; at least 0.
static inline double stp_plane_quadric_at(const stp_plane_quadric* q, stp_vec3d p)
{
    double x = q->xx * p.x + 2.0 * (q->xy * p.y + q->xz * p.z + q->x);
    double y = q->yy * p.y + 2.0 * (q->yz * p.z + q->y);
    double z = q->zz * p.z + 2.0 * q->z;
    double sum = x * p.x + y * p.y + z * p.z + q->constant;
    return sum > 0.0 ? sum : 0.0;
}

/// The mean for such a sum, by weight; 0 if no plane has an area.
static inline double stp_plane_quadric_mean(const stp_plane_quadric* q, double sum)
{
    return q->weight > 0.0 ? sum / q->weight : 0.0;
}

/// The mean squared distance of a point.
static inline double stp_plane_quadric_error(const stp_plane_quadric* q, stp_vec3d p)
{
    return stp_plane_quadric_mean(q, stp_plane_quadric_at(q, p));
}

/// The point with the least sum, pulled weakly towards `near`, which decides where the planes leave
/// it open. @return false if the planes are degenerate
static inline bool stp_plane_quadric_minimum(const stp_plane_quadric* q, stp_vec3d near,
                                             stp_vec3d* minimum)
{
    // L D L' of A + pull; the pull makes it positive definite
    double pull = 1e-3 * q->weight;
    double d0 = q->xx + pull;
    if (!(d0 > 0.0)) {
        return false;
    }
    double inverse0 = 1.0 / d0, l10 = q->xy * inverse0, l20 = q->xz * inverse0;
    double d1 = q->yy + pull - l10 * q->xy;
    double yz = q->yz - l20 * q->xy;
    if (!(d1 > 0.0)) {
        return false;
    }
    double inverse1 = 1.0 / d1, l21 = yz * inverse1;
    double d2 = q->zz + pull - l20 * q->xz - l21 * yz;
    if (!(d2 > 0.0)) {
        return false;
    }
    double r0 = pull * near.x - q->x;
    double r1 = pull * near.y - q->y - l10 * r0;
    double r2 = pull * near.z - q->z - l20 * r0 - l21 * r1;
    double z = r2 / d2, y = r1 * inverse1 - l21 * z;
    *minimum = (stp_vec3d){r0 * inverse0 - l10 * y - l20 * z, y, z};
    return isfinite(minimum->x) && isfinite(minimum->y) && isfinite(minimum->z);
}
