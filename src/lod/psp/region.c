// SPDX-License-Identifier: MIT
#include "lod/psp/region.h"

#include "base/splats/coverage.h"

#include <assert.h>

#define PI 3.14159265358979323846
#define THIN 1e-3  ///< minimum minor axis, as a fraction of the major axis
#define FACES 1e-3 ///< minimum length of a mean normal that gives a direction
#define OUTLINE 0.25
#define NORMALS 0.5
#define COLORS 4.0
#define THICKNESS 2.0

/// Covariance of positions along two directions; their variance if both are equal.
static double spread_along(const stp_psp_region* r, const double a[3], const double b[3])
{
    double sum = 0.0;
    for (int i = 0, at = 0; i < 3; ++i) {
        for (int k = i; k < 3; ++k, ++at) {
            double c =
                r->squares[at] / r->area - r->position[i] * r->position[k] / (r->area * r->area);
            sum += i == k ? c * a[i] * b[i] : c * (a[i] * b[k] + a[k] * b[i]);
        }
    }
    return sum;
}

stp_psp_region stp_psp_region_of(const stp_psp_sample* s)
{
    const double p[3] = {(double)s->position.x, (double)s->position.y, (double)s->position.z};
    const double n[3] = {(double)s->normal.x, (double)s->normal.y, (double)s->normal.z};
    stp_psp_region r = {
        .area = (double)s->area,
        .normal = {s->area * s->normal.x, s->area * s->normal.y, s->area * s->normal.z}};
    double own =
        r.area / (4.0 * PI); // variance of a disk of this area: a quarter of its squared radius
    for (int i = 0, at = 0; i < 3; ++i) {
        float color = (float)s->color[i] / 255.0f;
        r.position[i] = r.area * p[i];
        r.color[i] = s->area * color;
        r.color_squares += r.area * (double)color * (double)color;
        for (int k = i; k < 3; ++k) {
            r.squares[at++] = r.area * (p[i] * p[k] + own * ((i == k ? 1.0 : 0.0) - n[i] * n[k]));
        }
    }
    return r;
}

stp_psp_region stp_psp_region_add(const stp_psp_region* a, const stp_psp_region* b)
{
    stp_psp_region r = {.area = a->area + b->area,
                        .color_squares = a->color_squares + b->color_squares};
    for (int i = 0; i < 3; ++i) {
        r.position[i] = a->position[i] + b->position[i];
        r.normal[i] = a->normal[i] + b->normal[i];
        r.color[i] = a->color[i] + b->color[i];
    }
    for (int i = 0; i < 6; ++i) {
        r.squares[i] = a->squares[i] + b->squares[i];
    }
    return r;
}

void stp_psp_region_turn(stp_psp_region* region)
{
    for (int k = 0; k < 3; ++k) {
        region->normal[k] = -region->normal[k];
    }
}

stp_ellipse stp_psp_region_ellipse(const stp_psp_region* r, stp_vec3 fallback)
{
    stp_vec3 n = {r->normal[0], r->normal[1], r->normal[2]};
    float length = stp_length(n);
    n = (double)length > FACES * r->area ? stp_scale(n, 1.0f / length) : fallback;
    stp_disk_axes axes = stp_disk_axes_across(n);
    const double x[3] = {(double)axes.x.x, (double)axes.x.y, (double)axes.x.z};
    const double y[3] = {(double)axes.y.x, (double)axes.y.y, (double)axes.y.z};
    double xx = spread_along(r, x, x), xy = spread_along(r, x, y), yy = spread_along(r, y, y);
    double half = 0.5 * (xx - yy), root = sqrt(half * half + xy * xy), mean = 0.5 * (xx + yy);
    double large = fmax(mean + root, 0.0), small = fmax(mean - root, 0.0);
    assert(!(small > large) && "the first axis is the longer one");
    double along = half >= 0.0 ? half + root : xy, beside = half >= 0.0 ? xy : root - half;
    double norm = sqrt(along * along + beside * beside);
    double major = 2.0 * sqrt(large); // the variance along an axis is a quarter of its square
    double c = norm > 0.0 ? along / norm : 1.0, s = norm > 0.0 ? beside / norm : 0.0;
    return (stp_ellipse){
        .center = {(float)(r->position[0] / r->area), (float)(r->position[1] / r->area),
                   (float)(r->position[2] / r->area)},
        .normal = n,
        .major =
            stp_add(stp_scale(axes.x, (float)(c * major)), stp_scale(axes.y, (float)(s * major))),
        .minor = (float)fmax(2.0 * sqrt(small), THIN * major)};
}

double stp_psp_region_error(const stp_psp_region* r, const stp_ellipse* e)
{
    const double n[3] = {(double)e->normal.x, (double)e->normal.y, (double)e->normal.z};
    double faces = 0.0, mean = 0.0;
    for (int k = 0; k < 3; ++k) {
        faces += (double)r->normal[k] * (double)r->normal[k];
        mean += (double)r->color[k] * (double)r->color[k];
    }
    double major = (double)stp_length(e->major), area = PI * major * (double)e->minor;
    return OUTLINE * area + NORMALS * fmax(r->area - faces / r->area, 0.0) +
           COLORS * fmax(r->color_squares - mean / r->area, 0.0) +
           THICKNESS * sqrt(fmax(spread_along(r, n, n), 0.0)) * major + fmax(area - r->area, 0.0);
}
