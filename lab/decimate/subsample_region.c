// SPDX-License-Identifier: MIT
#include "base/splats/coverage.h"
#include "lab/decimate/subsample_attempt.h"

#include <assert.h>
#include <string.h>

enum {
    UNKNOWNS = 6, ///< coefficients of a quadric over a plane
    ROUNDS = 3,   ///< maximum rounds of fitting and growing
    FIT_MIN = 8   ///< minimum number of points to fit a quadric
};
#define RATIO_MAX 4.0f ///< maximum ratio of the axes of a candidate

/// A frame of unit vectors at a point, and the weight of distances across x.
typedef struct frame {
    stp_vec3d origin, x, y, normal;
    double ratio;
} frame;

typedef struct region {
    uint32_t count;
    double low, high;    ///< range of heights over the plane
    double reach;        ///< distance of the farthest point
    double major, minor; ///< axes that contain the points with their margins
    uint64_t area;       ///< sum of the weights
} region;

static frame make_frame(const stp_subsample_field* field, uint32_t seed)
{
    stp_vec3 normal = field->own[seed].normal;
    stp_disk_axes axes = stp_disk_axes_across(normal);
    return (frame){.origin = stp_to_double(stp_subsample_position(field, seed)),
                   .x = stp_to_double(axes.x),
                   .y = stp_to_double(axes.y),
                   .normal = stp_to_double(normal),
                   .ratio = 1.0};
}

static bool push(stp_subsample_scratch* s, uint64_t item)
{
    if (!STP_MAKE_ROOM(s->context, s->heap, s->heap_capacity, (size_t)s->heap_count + 1)) {
        return false;
    }
    uint64_t* heap = s->heap;
    uint32_t at = s->heap_count++;
    for (; at > 0 && heap[(at - 1) / 2] > item; at = (at - 1) / 2) {
        heap[at] = heap[(at - 1) / 2];
    }
    heap[at] = item;
    return true;
}

static uint64_t pop(stp_subsample_scratch* s)
{
    assert(s->heap_count > 0);
    uint64_t *heap = s->heap, first = heap[0], last = heap[--s->heap_count];
    uint32_t at = 0, count = s->heap_count;
    for (uint32_t child = 1; child < count; child = 2 * at + 1) {
        child += child + 1 < count && heap[child + 1] < heap[child] ? 1 : 0;
        if (heap[child] >= last) {
            break;
        }
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = last;
    return first;
}

/// A squared distance and a point, packed into one sort key. Equally distant points are ordered
/// starting at the seed, so that size limits of regions around coincident points do not all cut off
/// the same points.
static uint64_t make_item(const stp_subsample_field* field, const frame* f, uint32_t seed,
                          uint32_t point)
{
    stp_vec3d d = stp_subd(stp_to_double(stp_subsample_position(field, point)), f->origin);
    double u = stp_dotd(d, f->x), v = stp_dotd(d, f->y) * f->ratio;
    float square = (float)(u * u + v * v);
    uint32_t bits;
    square = square < FLT_MAX ? square : FLT_MAX; // also if NaN
    memcpy(&bits, &square, sizeof(bits));
    return (uint64_t)bits << 32 | (point >= seed ? point - seed : point + (field->count - seed));
}

/// Takes points by distance as long as they fit in the slab.
static bool grow(const stp_subsample_field* field, stp_subsample_scratch* s, uint32_t seed,
                 const frame* f, double width, uint32_t maximum, int list, region* r)
{
    stp_vec3 facing = stp_to_float(f->normal);
    *r = (region){0};
    s->heap_count = 0;
    s->visited[seed] = ++s->region;
    if (!push(s, 0)) {
        return false;
    }
    while (s->heap_count > 0 && r->count < maximum) {
        uint32_t after = (uint32_t)pop(s), left = field->count - seed;
        uint32_t point = after < left ? seed + after : after - left;
        assert(point < field->count);
        stp_vec3d d = stp_subd(stp_to_double(stp_subsample_position(field, point)), f->origin);
        double height = stp_dotd(d, f->normal);
        double low = height < r->low ? height : r->low, high = height > r->high ? height : r->high;
        if (!(high - low <= width) && r->count > 0) {
            break;
        }
        r->low = low;
        r->high = high;
        if (r->count == s->capacity[list]) {
            if (!STP_MAKE_ROOM(s->context, s->members[list], s->capacity[list],
                               (size_t)r->count + 1)) {
                return false;
            }
        }
        s->members[list][r->count++] = point;
        double u = stp_dotd(d, f->x), v = stp_dotd(d, f->y) * f->ratio, margin;
        double distance = sqrt(u * u + v * v);
        margin = (double)field->margins[point];
        r->reach = fmax(r->reach, distance);
        r->major = fmax(r->major, distance + margin);
        r->minor = fmax(r->minor, distance / f->ratio + margin);
        r->area += field->weights[point];
        for (uint32_t n = field->starts[point]; n < field->starts[point + 1]; ++n) {
            uint32_t next = field->neighbours[n];
            if (s->visited[next] != s->region && stp_subsample_same_side(field, next, facing)) {
                s->visited[next] = s->region;
                if (!push(s, make_item(field, f, seed, next))) {
                    return false;
                }
            }
        }
    }
    return true;
}

/// Solves symmetric equations by elimination. @return false if there is no unique solution
static bool solve(double m[UNKNOWNS][UNKNOWNS + 1], double solution[UNKNOWNS])
{
    for (int i = 0; i < UNKNOWNS; ++i) {
        if (!(m[i][i] > 1e-9 * m[0][0])) {
            return false;
        }
        for (int r = i + 1; r < UNKNOWNS; ++r) {
            double factor = m[r][i] / m[i][i];
            for (int c = i; c <= UNKNOWNS; ++c) {
                m[r][c] -= factor * m[i][c];
            }
        }
    }
    for (int i = UNKNOWNS - 1; i >= 0; --i) {
        double sum = m[i][UNKNOWNS];
        for (int c = i + 1; c < UNKNOWNS; ++c) {
            sum -= m[i][c] * solution[c];
        }
        solution[i] = sum / m[i][i];
    }
    return true;
}

/// Fits a height of q0 + q1 u + q2 v + q3 u u + q4 u v + q5 v v to points, in units of the reach.
static bool fit_quadric(const stp_subsample_field* field, const uint32_t* members, const region* r,
                        const frame* f, double q[UNKNOWNS])
{
    double m[UNKNOWNS][UNKNOWNS + 1] = {{0}};
    if (r->count < FIT_MIN || !(r->reach > 0.0)) {
        return false;
    }
    for (uint32_t i = 0; i < r->count; ++i) {
        stp_vec3d d = stp_subd(stp_to_double(stp_subsample_position(field, members[i])), f->origin);
        double u = stp_dotd(d, f->x) / r->reach, v = stp_dotd(d, f->y) / r->reach;
        const double row[UNKNOWNS + 1] = {
            1.0, u, v, u * u, u * v, v * v, stp_dotd(d, f->normal) / r->reach};
        for (int a = 0; a < UNKNOWNS; ++a) {
            for (int b = a; b <= UNKNOWNS; ++b) {
                m[a][b] += row[a] * row[b];
            }
        }
    }
    for (int a = 1; a < UNKNOWNS; ++a) {
        for (int b = 0; b < a; ++b) {
            m[a][b] = m[b][a];
        }
    }
    return solve(m, q);
}

/// Tangent plane of a quadric at the seed, with x along its minimum curvature, and the axis ratio
/// that makes heights at both ends of an ellipse equal.
static bool turn_frame(const double q[UNKNOWNS], frame* f)
{
    stp_vec3d n = stp_subd(f->normal, stp_addd(stp_scaled(f->x, q[1]), stp_scaled(f->y, q[2])));
    n = stp_normalized(n);
    // principal curvatures of q3 u u + q4 u v + q5 v v
    double half = 0.5 * (q[3] - q[5]), mixed = 0.5 * q[4], mean = 0.5 * (q[3] + q[5]);
    double root = sqrt(half * half + mixed * mixed);
    double along = half >= 0.0 ? half + root : mixed, beside = half >= 0.0 ? mixed : root - half;
    stp_vec3d high = stp_addd(stp_scaled(f->x, along), stp_scaled(f->y, beside));
    double large = fabs(mean + root), small = fabs(mean - root);
    stp_vec3d steep = high;
    if (small > large) { // the other one bends more
        double other = small;
        small = large;
        large = other;
        steep = stp_crossd(f->normal, high);
    }
    stp_vec3d y = stp_normalized(stp_subd(steep, stp_scaled(n, stp_dotd(steep, n))));
    if (!(stp_dotd(n, n) > 0.5) || !(stp_dotd(y, y) > 0.5)) {
        return false;
    }
    const double maximum = (double)(RATIO_MAX * RATIO_MAX);
    f->ratio = large > small * maximum ? (double)RATIO_MAX : sqrt(large / small);
    assert(f->ratio >= 1.0 && f->ratio <= (double)RATIO_MAX);
    f->normal = n;
    f->y = y;
    f->x = stp_crossd(y, n);
    return true;
}

uint32_t stp_subsample_find_region(const stp_subsample_field* field, stp_subsample_scratch* s,
                                   uint32_t seed, double tolerance, uint32_t maximum,
                                   stp_subsample_candidate* shape, const uint32_t** members)
{
    assert(seed < field->count && maximum > 0 && tolerance >= 0.0);
    region best, other;
    frame f = make_frame(field, seed), turned = f;
    double q[UNKNOWNS];
    if (!grow(field, s, seed, &f, 2.0 * tolerance, maximum, 0, &best)) {
        return 0;
    }
    for (int round = 0; round < ROUNDS; ++round) {
        turned = f;
        if (!fit_quadric(field, s->members[0], &best, &f, q) || !turn_frame(q, &turned) ||
            !stp_subsample_same_side(field, seed, stp_to_float(turned.normal))) {
            break;
        }
        if (!grow(field, s, seed, &turned, 2.0 * tolerance, maximum, 1, &other)) {
            return 0;
        }
        if (other.area <= best.area) {
            break;
        }
        uint32_t* list = s->members[0];
        size_t capacity = s->capacity[0];
        s->members[0] = s->members[1];
        s->capacity[0] = s->capacity[1];
        s->members[1] = list;
        s->capacity[1] = capacity;
        best = other;
        f = turned;
    }
    stp_vec3d middle = stp_addd(f.origin, stp_scaled(f.normal, 0.5 * (best.low + best.high)));
    *shape = (stp_subsample_candidate){.center = stp_to_float(middle),
                                       .normal = stp_to_float(f.normal),
                                       .axis = stp_to_float(f.x),
                                       .ratio = (float)f.ratio,
                                       .major = (float)best.major,
                                       .minor = (float)best.minor};
    *members = s->members[0];
    return best.count;
}
