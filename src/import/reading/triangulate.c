// SPDX-License-Identifier: MIT
#include "import/reading/triangulate.h"

#include "base/math/math.h"

#include <assert.h>
#include <math.h>

// Point-in-triangle tests per corner: polygons with up to about as many concave corners are
// triangulated exactly.
#define TESTS_PER_CORNER 4096

typedef struct flat_point {
    double x, y;
} flat_point;

// A polygon in its plane: a ring of the remaining corners.
typedef struct ring {
    flat_point* points;
    uint32_t* next;
    uint32_t* previous;
    uint32_t* reflex; ///< the concave corners; ones that became convex are dropped when visited
    uint32_t reflex_count;
    uint64_t tests_left;
} ring;

static stp_vec3d corner_position(const float* positions, uint32_t corner)
{
    const float* p = positions + 3 * (size_t)corner;
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

// Twice the vector area (Newell), relative to the first corner.
static stp_vec3d polygon_normal(const float* positions, const uint32_t* corners, uint32_t count)
{
    stp_vec3d sum = {0, 0, 0};
    stp_vec3d first = corner_position(positions, corners[0]);
    stp_vec3d last = stp_subd(corner_position(positions, corners[1]), first);
    for (uint32_t i = 2; i < count; ++i) {
        stp_vec3d point = stp_subd(corner_position(positions, corners[i]), first);
        sum = stp_addd(sum, stp_crossd(last, point));
        last = point;
    }
    return sum;
}

// Projects along the axis with the largest area, so that the polygon turns counter-clockwise.
static flat_point flatten(stp_vec3d p, stp_vec3d normal)
{
    double ax = fabs(normal.x), ay = fabs(normal.y), az = fabs(normal.z);
    if (ax >= ay && ax >= az) {
        return normal.x >= 0.0 ? (flat_point){p.y, p.z} : (flat_point){p.z, p.y};
    }
    if (ay >= az) {
        return normal.y >= 0.0 ? (flat_point){p.z, p.x} : (flat_point){p.x, p.z};
    }
    return normal.z >= 0.0 ? (flat_point){p.x, p.y} : (flat_point){p.y, p.x};
}

static double turn(flat_point a, flat_point b, flat_point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool is_reflex(const ring* r, uint32_t corner)
{
    return turn(r->points[r->previous[corner]], r->points[corner], r->points[r->next[corner]]) <
           0.0;
}

static bool same_point(flat_point a, flat_point b)
{
    return a.x == b.x && a.y == b.y;
}

// Whether the corner is an ear: it is convex and its triangle contains no concave corner. If a
// polygon touches itself (a hole joined by a bridge), a concave corner at a corner of the triangle
// may be on either side: `touching` treats it as outside.
static bool is_ear(ring* r, uint32_t corner, bool touching)
{
    uint32_t before = r->previous[corner], after = r->next[corner];
    flat_point a = r->points[before], b = r->points[corner], c = r->points[after];
    if (turn(a, b, c) < 0.0) {
        return false;
    }
    for (uint32_t i = 0; i < r->reflex_count;) {
        uint32_t other = r->reflex[i];
        r->tests_left -= r->tests_left > 0;
        if (r->next[other] == other || !is_reflex(r, other)) {
            r->reflex[i] = r->reflex[--r->reflex_count]; // already clipped, or convex by now
            continue;
        }
        assert(r->next[r->previous[other]] == other && "it is still in the ring");
        flat_point p = r->points[other];
        bool own = other == before || other == after;
        bool touches = same_point(p, a) || same_point(p, b) || same_point(p, c);
        if (!own && !(touching && touches) && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 &&
            turn(c, a, p) >= 0.0) {
            return false;
        }
        i += 1;
    }
    return true;
}

static void clip_ears(ring* r, const uint32_t* corners, uint32_t count, uint32_t* triangles)
{
    uint32_t at = 0, left = count, misses = 0;
    while (left > 3) {
        // no ear after two rounds, so the polygon is not simple: clip anyway
        bool clips = misses / 2 >= left || r->tests_left == 0 || is_ear(r, at, misses >= left);
        if (!clips) {
            at = r->next[at];
            misses += 1;
            continue;
        }
        uint32_t before = r->previous[at], after = r->next[at];
        assert(r->next[before] == at && r->previous[after] == at && before != after);
        *triangles++ = corners[before];
        *triangles++ = corners[at];
        *triangles++ = corners[after];
        r->next[before] = after;
        r->previous[after] = before;
        r->next[at] = at;
        at = r->tests_left == 0 ? before : after;
        left -= 1;
        misses = 0;
    }
    assert(r->next[r->next[r->next[at]]] == at && "three corners are left");
    *triangles++ = corners[r->previous[at]];
    *triangles++ = corners[at];
    *triangles = corners[r->next[at]];
}

static void make_fan(const uint32_t* corners, uint32_t count, uint32_t* triangles)
{
    for (uint32_t i = 2; i < count; ++i) {
        *triangles++ = corners[0];
        *triangles++ = corners[i - 1];
        *triangles++ = corners[i];
    }
}

// Whether all corners turn the same way. A star that winds around twice passes too; it has no
// correct triangulation.
static bool is_convex(const float* positions, const uint32_t* corners, uint32_t count,
                      stp_vec3d normal)
{
    stp_vec3d base = corner_position(positions, corners[0]);
    flat_point a = flatten(stp_subd(corner_position(positions, corners[count - 2]), base), normal);
    flat_point b = flatten(stp_subd(corner_position(positions, corners[count - 1]), base), normal);
    for (uint32_t i = 0; i < count; ++i) {
        flat_point c = flatten(stp_subd(corner_position(positions, corners[i]), base), normal);
        if (turn(a, b, c) < 0.0) {
            return false;
        }
        a = b;
        b = c;
    }
    return true;
}

static bool clip_concave(stp_context* context, const float* positions, const uint32_t* corners,
                         uint32_t count, stp_vec3d normal, uint32_t* triangles)
{
    ring r = {.points = STP_NEW_ARRAY(context, flat_point, count),
              .next = STP_NEW_ARRAY(context, uint32_t, count),
              .previous = STP_NEW_ARRAY(context, uint32_t, count),
              .reflex = STP_NEW_ARRAY(context, uint32_t, count),
              .tests_left = (uint64_t)count * TESTS_PER_CORNER};
    bool ready = r.points != NULL && r.next != NULL && r.previous != NULL && r.reflex != NULL;
    if (ready) {
        stp_vec3d base = corner_position(positions, corners[0]);
        for (uint32_t i = 0; i < count; ++i) {
            r.points[i] = flatten(stp_subd(corner_position(positions, corners[i]), base), normal);
            r.next[i] = i + 1 < count ? i + 1 : 0;
            r.previous[i] = i > 0 ? i - 1 : count - 1;
        }
        for (uint32_t i = 0; i < count; ++i) {
            if (is_reflex(&r, i)) {
                r.reflex[r.reflex_count++] = i;
            }
        }
        assert(r.reflex_count <= count);
        clip_ears(&r, corners, count, triangles);
    }
    stp_free(context, r.points);
    stp_free(context, r.next);
    stp_free(context, r.previous);
    stp_free(context, r.reflex);
    return ready;
}

// Most non-triangles are quads: choose the diagonal whose halves face the same way.
static void split_quad(const float* positions, const uint32_t* corners, uint32_t* triangles)
{
    stp_vec3d a = corner_position(positions, corners[0]);
    stp_vec3d b = stp_subd(corner_position(positions, corners[1]), a);
    stp_vec3d c = stp_subd(corner_position(positions, corners[2]), a);
    stp_vec3d d = stp_subd(corner_position(positions, corners[3]), a);
    bool other = stp_dotd(stp_crossd(b, c), stp_crossd(c, d)) < 0.0;
    uint32_t turned[4] = {corners[1], corners[2], corners[3], corners[0]};
    make_fan(other ? turned : corners, 4, triangles);
}

bool stp_triangulate(stp_context* context, const float* positions, const uint32_t* corners,
                     uint32_t count, uint32_t* triangles)
{
    assert(count >= 3);
    if (count == 3) {
        make_fan(corners, 3, triangles);
        return true;
    }
    if (count == 4) {
        split_quad(positions, corners, triangles);
        return true;
    }
    stp_vec3d normal = polygon_normal(positions, corners, count);
    if (is_convex(positions, corners, count, normal)) {
        make_fan(corners, count, triangles);
        return true;
    }
    return clip_concave(context, positions, corners, count, normal, triangles);
}
