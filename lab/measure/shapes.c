// SPDX-License-Identifier: MIT
#include "lab/measure/shapes.h"

#include <assert.h>

enum { NEWTON_STEPS = 200 }; ///< limit; about six are usual

static double square(double x)
{
    return x * x;
}

// Squared distance in the plane of an ellipse from (x, y), outside and with x and y at least 0, to
// its boundary. The nearest place is (a a x / (t + a a), b b y / (t + b b)), where F(t) = (a x / (t
// + a a))^2 + (b y / (t + b b))^2 - 1 is 0. F decreases and is convex, so Newton's method rises to
// the root from any place where F >= 0. t is in units of b b.
static double boundary_distance_squared(double a, double b, double x, double y)
{
    assert(a > 0.0 && b > 0.0 && !(x < 0.0) && !(y < 0.0));
    double r = square(a / b), u = r * (x / a), v = y / b;
    double t = fmax(v - 1.0, u - r);
    for (int i = 0; i < NEWTON_STEPS; ++i) {
        double p = u / (t + r), q = v / (t + 1.0);
        p = t + r > 0.0 ? p : 0.0; // only where u is 0 as well
        q = t + 1.0 > 0.0 ? q : 0.0;
        double value = p * p + q * q - 1.0;
        double slope =
            2.0 * ((p > 0.0 ? p * p / (t + r) : 0.0) + (q > 0.0 ? q * q / (t + 1.0) : 0.0));
        double next = t + value / slope;
        if (!(value > 0.0) || !(next > t)) {
            break;
        }
        t = next;
    }
    double nearest_x = t + r > 0.0 ? r * x / (t + r) : a;
    double nearest_y = t + 1.0 > 0.0 ? y / (t + 1.0) : b;
    return square(x - nearest_x) + square(y - nearest_y);
}

double stp_disk_distance_squared(const stp_disk_shape* disk, stp_vec3d point, double maximum)
{
    stp_vec3d away = stp_subd(point, stp_to_double(disk->center));
    stp_vec3d larger = stp_to_double(disk->larger), smaller = stp_to_double(disk->smaller);
    double a2 = stp_dotd(larger, larger);
    if (!(a2 > 0.0)) {
        return stp_dotd(away, away);
    }
    double a = sqrt(a2), along = stp_dotd(away, larger) / a;
    stp_vec3d rest = stp_subd(away, stp_scaled(larger, along / a));
    smaller = stp_subd(smaller, stp_scaled(larger, stp_dotd(smaller, larger) / a2));
    double b = sqrt(stp_dotd(smaller, smaller)), x = fabs(along);
    if (!(b > 0.0)) {
        return (x > a ? square(x - a) : 0.0) + stp_dotd(rest, rest);
    }
    double across = stp_dotd(rest, smaller) / b, y = fabs(across);
    rest = stp_subd(rest, stp_scaled(smaller, across / b));
    double height = stp_dotd(rest, rest);
    if (square(x / a) + square(y / b) <= 1.0) {
        return height;
    }
    double beyond = sqrt(x * x + y * y) - a; // distance to a circle around the ellipse
    double minimum = height + (beyond > 0.0 ? square(beyond) : 0.0);
    return minimum * (1.0 - 1e-9) > maximum ? minimum
                                            : height + boundary_distance_squared(a, b, x, y);
}

// Squared distance to the segment from `a` along `edge`.
static double segment_distance_squared(stp_vec3d a, stp_vec3d edge, stp_vec3d point)
{
    stp_vec3d away = stp_subd(point, a);
    double length = stp_dotd(edge, edge), t = length > 0.0 ? stp_dotd(away, edge) / length : 0.0;
    t = t > 0.0 ? fmin(t, 1.0) : 0.0;
    assert(t >= 0.0 && t <= 1.0 && "on the segment");
    stp_vec3d left = stp_subd(away, stp_scaled(edge, t));
    return stp_dotd(left, left);
}

double stp_triangle_distance_squared(const stp_vec3d corners[3], stp_vec3d point)
{
    stp_vec3d ab = stp_subd(corners[1], corners[0]), bc = stp_subd(corners[2], corners[1]);
    stp_vec3d ca = stp_subd(corners[0], corners[2]), normal = stp_crossd(ab, bc);
    double length = stp_dotd(normal, normal);
    stp_vec3d away = stp_subd(point, corners[0]);
    bool inside = length > 0.0 && stp_dotd(stp_crossd(ab, away), normal) >= 0.0 &&
                  stp_dotd(stp_crossd(bc, stp_subd(point, corners[1])), normal) >= 0.0 &&
                  stp_dotd(stp_crossd(ca, stp_subd(point, corners[2])), normal) >= 0.0;
    if (inside) {
        return square(stp_dotd(away, normal)) / length;
    }
    double best = segment_distance_squared(corners[0], ab, point);
    best = fmin(best, segment_distance_squared(corners[1], bc, point));
    return fmin(best, segment_distance_squared(corners[2], ca, point));
}

double stp_disk_area(const stp_disk_shape* disk)
{
    stp_vec3d larger = stp_to_double(disk->larger), smaller = stp_to_double(disk->smaller);
    return STP_PI * sqrt(stp_dotd(larger, larger)) * sqrt(stp_dotd(smaller, smaller));
}

double stp_triangle_area(const stp_vec3d corners[3])
{
    stp_vec3d normal =
        stp_crossd(stp_subd(corners[1], corners[0]), stp_subd(corners[2], corners[0]));
    return 0.5 * sqrt(stp_dotd(normal, normal));
}

void stp_triangle_corners(const float* positions, const uint32_t* indices, size_t index,
                          stp_vec3d corners[3])
{
    for (size_t k = 0; k < 3; ++k) {
        const float* p = positions + 3 * (size_t)indices[3 * index + k];
        corners[k] = (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
    }
}
