// SPDX-License-Identifier: MIT
//
// Round shapes: surfaces of revolution, tubes along paths, threads and coils.
#include "lab/scenes/mesh_shapes_patch.h"
#include "lab/scenes/trigonometry.h"

#include <assert.h>

enum { MOST_PROFILE = 96 };
static const double smooth_cosine = 0.72; // cosine of the largest angle of a smooth edge

// A piece of a profile, with the normals at both ends.
typedef struct lathe_piece {
    double low[2], high[2]; // radius, height
    double low_normal[2], high_normal[2];
} lathe_piece;

// Pieces of zero length, or on the axis, are skipped.
static int make_pieces(const double (*profile)[2], int count, lathe_piece* pieces)
{
    assert(count >= 2 && count <= MOST_PROFILE + 1 && "pieces would be left out");
    int made = 0;
    for (int i = 0; i + 1 < count && made < MOST_PROFILE; ++i) {
        double dr = profile[i + 1][0] - profile[i][0], dy = profile[i + 1][1] - profile[i][1];
        double size = sqrt(dr * dr + dy * dy);
        if (size > 0.0 && (profile[i][0] > 0.0 || profile[i + 1][0] > 0.0)) {
            pieces[made++] = (lathe_piece){{profile[i][0], profile[i][1]},
                                           {profile[i + 1][0], profile[i + 1][1]},
                                           {dy / size, -dr / size},
                                           {dy / size, -dr / size}};
        }
    }
    bool closed = profile[0][0] == profile[count - 1][0] && profile[0][1] == profile[count - 1][1];
    double flat[MOST_PROFILE][2];
    for (int i = 0; i < made; ++i) {
        flat[i][0] = pieces[i].low_normal[0];
        flat[i][1] = pieces[i].low_normal[1];
    }
    for (int i = 0; i < made; ++i) {
        int next = i + 1 < made ? i + 1 : closed ? 0 : -1;
        if (next < 0 || flat[i][0] * flat[next][0] + flat[i][1] * flat[next][1] < smooth_cosine) {
            continue;
        }
        double r = flat[i][0] + flat[next][0], y = flat[i][1] + flat[next][1];
        double size = sqrt(r * r + y * y);
        pieces[i].high_normal[0] = pieces[next].low_normal[0] = r / size;
        pieces[i].high_normal[1] = pieces[next].low_normal[1] = y / size;
    }
    return made;
}

static void put_row(shape_patch* p, const shape_ring* ring, int sides, const double at[2],
                    const double normal[2])
{
    for (int i = 0; i < sides; ++i) {
        double c = ring->cosine[i], d = ring->sine[i];
        patch_vertex(p, at[0] * c, at[1], at[0] * d, normal[0] * c, normal[1], normal[0] * d);
    }
}

static bool same_row(const lathe_piece* a, const lathe_piece* b)
{
    return a->high[0] == b->low[0] && a->high[1] == b->low[1] &&
           a->high_normal[0] == b->low_normal[0] && a->high_normal[1] == b->low_normal[1];
}

void shape_lathe(shaper* s, const double (*profile)[2], int count, int sides)
{
    lathe_piece pieces[MOST_PROFILE];
    int made = make_pieces(profile, count, pieces);
    uint64_t n = (uint64_t)sides, vertices = 0, triangles = 0;
    for (int i = 0; i < made; ++i) {
        vertices += i > 0 && same_row(&pieces[i - 1], &pieces[i]) ? n : 2 * n;
        triangles += pieces[i].low[0] > 0.0 && pieces[i].high[0] > 0.0 ? 2 * n : n;
    }
    shape_patch p;
    if (!shape_begin(s, vertices, triangles, &p)) {
        return;
    }
    const shape_ring* ring = shape_circle(s, sides);
    uint32_t row = p.first;
    for (int i = 0; i < made; ++i) {
        const lathe_piece* piece = &pieces[i];
        if (i == 0 || !same_row(&pieces[i - 1], piece)) {
            row += i > 0 ? (uint32_t)sides : 0;
            put_row(&p, ring, sides, piece->low, piece->low_normal);
        }
        put_row(&p, ring, sides, piece->high, piece->high_normal);
        for (uint32_t k = 0; k < (uint32_t)sides; ++k) {
            uint32_t next = k + 1 < (uint32_t)sides ? k + 1 : 0;
            uint32_t low = row, high = row + (uint32_t)sides;
            if (piece->high[0] > 0.0) {
                patch_triangle(&p, low + k, high + k, high + next);
            }
            if (piece->low[0] > 0.0) {
                patch_triangle(&p, low + k, high + next, low + next);
            }
        }
        row += (uint32_t)sides;
    }
}

void shape_cylinder(shaper* s, double radius, double height, int sides)
{
    double profile[4][2] = {{0, 0}, {radius, 0}, {radius, height}, {0, height}};
    shape_lathe(s, (const double(*)[2])profile, 4, sides);
}

void shape_ring_solid(shaper* s, double inner, double outer, double height, int sides)
{
    double profile[5][2] = {{inner, 0}, {outer, 0}, {outer, height}, {inner, height}, {inner, 0}};
    shape_lathe(s, (const double(*)[2])profile, 5, sides);
}

void shape_torus(shaper* s, double radius, double tube, int sides, int tube_sides)
{
    double profile[MOST_PROFILE][2];
    int n = tube_sides < MOST_PROFILE ? tube_sides : MOST_PROFILE - 1;
    for (int i = 0; i <= n; ++i) {
        double turns = (double)(i % n) / n;
        profile[i][0] = radius + tube * turn_cosine(turns);
        profile[i][1] = tube * turn_sine(turns);
    }
    shape_lathe(s, (const double(*)[2])profile, n + 1, sides);
}

void shape_ball(shaper* s, double radius, double height, int sides)
{
    double profile[MOST_PROFILE][2];
    int n = sides / 2 < 2 ? 2 : sides / 2 < MOST_PROFILE - 1 ? sides / 2 : MOST_PROFILE - 1;
    for (int i = 0; i <= n; ++i) {
        double turns = 0.5 * i / n;
        profile[i][0] = i == 0 || i == n ? 0.0 : radius * turn_sine(turns);
        profile[i][1] = -0.5 * height * turn_cosine(turns);
    }
    shape_lathe(s, (const double(*)[2])profile, n + 1, sides);
}

// Transports the frame from ring to ring by two reflections (Wang et al. 2008, Computation of
// rotation minimizing frames), which need no trigonometry.
static stp_vec3d carry(stp_vec3d side, stp_vec3d step, stp_vec3d old_way, stp_vec3d new_way)
{
    double c1 = stp_dotd(step, step);
    if (c1 < 1e-20) {
        return side;
    }
    stp_vec3d r = stp_subd(side, stp_scaled(step, 2.0 / c1 * stp_dotd(step, side)));
    stp_vec3d t = stp_subd(old_way, stp_scaled(step, 2.0 / c1 * stp_dotd(step, old_way)));
    stp_vec3d v = stp_subd(new_way, t);
    double c2 = stp_dotd(v, v);
    return c2 < 1e-20 ? r : stp_subd(r, stp_scaled(v, 2.0 / c2 * stp_dotd(v, r)));
}

static stp_vec3d way_at(const stp_vec3d* points, int count, int i)
{
    stp_vec3d in = i > 0 ? stp_normalized(stp_subd(points[i], points[i - 1])) : vec3d(0, 0, 0);
    stp_vec3d out =
        i + 1 < count ? stp_normalized(stp_subd(points[i + 1], points[i])) : vec3d(0, 0, 0);
    return stp_normalized(stp_addd(in, out));
}

static void put_cap(shape_patch* p, uint32_t at, int sides, bool far)
{
    for (uint32_t k = 1; k + 1 < (uint32_t)sides; ++k) {
        patch_triangle(p, at, far ? at + k + 1 : at + k, far ? at + k : at + k + 1);
    }
}

static void put_tube_ring(shape_patch* p, const shape_ring* ring, int sides, double radius,
                          stp_vec3d at, stp_vec3d x, stp_vec3d z, const stp_vec3d* flat)
{
    for (int k = 0; k < sides; ++k) {
        double c = ring->cosine[k], d = ring->sine[k];
        stp_vec3d n = {c * x.x + d * z.x, c * x.y + d * z.y, c * x.z + d * z.z};
        stp_vec3d q = stp_addd(at, stp_scaled(n, radius));
        n = flat != NULL ? *flat : n;
        patch_vertex(p, q.x, q.y, q.z, n.x, n.y, n.z);
    }
}

void shape_tube(shaper* s, const stp_vec3d* points, int count, double radius, int sides,
                shape_ends ends)
{
    assert(count >= 2 && sides >= 3 && "a tube has two ends and an inside");
    uint64_t n = (uint64_t)sides, rows = (uint64_t)count, caps = ends == SHAPE_CAPPED ? 2 : 0;
    shape_patch p;
    if (!shape_begin(s, n * (rows + caps), 2 * n * (rows - 1) + caps * (n - 2), &p)) {
        return;
    }
    const shape_ring* ring = shape_circle(s, sides);
    stp_vec3d way = way_at(points, count, 0), first_way = way;
    stp_affine frame = place_along(points[0], way);
    stp_vec3d x = {frame.m[0][0], frame.m[1][0], frame.m[2][0]}, first_x = x;
    for (int i = 0; i < count; ++i) {
        stp_vec3d ahead = way_at(points, count, i);
        if (i > 0) {
            x = carry(x, stp_subd(points[i], points[i - 1]), way, ahead);
            uint32_t low = p.first + (uint32_t)((i - 1) * sides), high = low + (uint32_t)sides;
            for (uint32_t k = 0; k < (uint32_t)sides; ++k) {
                uint32_t next = k + 1 < (uint32_t)sides ? k + 1 : 0;
                patch_quad(&p, low + k, high + k, high + next, low + next);
            }
        }
        way = ahead;
        put_tube_ring(&p, ring, sides, radius, points[i], x, stp_crossd(x, way), NULL);
    }
    if (ends == SHAPE_CAPPED) {
        uint32_t at = p.first + (uint32_t)(count * sides);
        stp_vec3d back = stp_scaled(first_way, -1.0);
        put_tube_ring(&p, ring, sides, radius, points[0], first_x, stp_crossd(first_x, first_way),
                      &back);
        put_cap(&p, at, sides, false);
        put_tube_ring(&p, ring, sides, radius, points[count - 1], x, stp_crossd(x, way), &way);
        put_cap(&p, at + (uint32_t)sides, sides, true);
    }
}

void shape_straight(shaper* s, stp_vec3d from, stp_vec3d to, double radius, int sides)
{
    stp_vec3d points[2] = {from, to};
    shape_tube(s, points, 2, radius, sides, SHAPE_CAPPED);
}

int shape_round_path(const stp_vec3d* corners, int count, double bend, int steps, stp_vec3d* out,
                     int capacity)
{
    int made = 0;
    for (int i = 0; i < count && made < capacity; ++i) {
        if (i == 0 || i + 1 == count) {
            out[made++] = corners[i];
            continue;
        }
        stp_vec3d a = stp_normalized(stp_subd(corners[i - 1], corners[i]));
        stp_vec3d b = stp_normalized(stp_subd(corners[i + 1], corners[i]));
        double between = stp_dotd(a, b); // cosine of the inner angle
        // distance from the corner to the start of the arc, and the weight that makes it a circle
        double half_tangent = sqrt((1.0 - between) / (1.0 + between + 1e-12));
        double back = bend / half_tangent, weight = sqrt(0.5 * (1.0 - between));
        if (between < -0.9999) {
            out[made++] = corners[i];
            continue;
        }
        stp_vec3d from = stp_addd(corners[i], stp_scaled(a, back));
        stp_vec3d to = stp_addd(corners[i], stp_scaled(b, back));
        for (int k = 0; k <= steps && made < capacity; ++k) {
            double t = (double)k / steps, u = 1.0 - t;
            double w0 = u * u, w1 = 2.0 * weight * t * u, w2 = t * t, sum = w0 + w1 + w2;
            stp_vec3d q = stp_addd(stp_scaled(from, w0 / sum), stp_scaled(to, w2 / sum));
            out[made++] = stp_addd(q, stp_scaled(corners[i], w1 / sum));
        }
    }
    return made;
}

void shape_thread(shaper* s, double radius, double pitch, double length, int sides)
{
    int steps = (int)(length / pitch * sides);
    steps = steps < 1 ? 1 : steps;
    uint64_t rows = (uint64_t)steps + 1;
    shape_patch p;
    if (!shape_begin(s, 4 * rows, 4 * (uint64_t)steps, &p)) {
        return;
    }
    const shape_ring* ring = shape_circle(s, sides);
    double root = radius - 0.6 * pitch, half = 0.5 * pitch,
           slope = 0.6; // about that of a 60 degree thread
    double lean = 0.8574929257, rise = slope * lean;
    for (int i = 0; i <= steps; ++i) {
        double c = ring->cosine[i % sides], d = ring->sine[i % sides];
        double y = (length - pitch) * i / steps;
        double up = lean, out = rise;
        patch_vertex(&p, root * c, y, root * d, out * c, -up, out * d);
        patch_vertex(&p, radius * c, y + half, radius * d, out * c, -up, out * d);
        patch_vertex(&p, radius * c, y + half, radius * d, out * c, up, out * d);
        patch_vertex(&p, root * c, y + pitch, root * d, out * c, up, out * d);
        if (i > 0) {
            uint32_t low = p.first + (uint32_t)(4 * (i - 1)), high = low + 4;
            patch_quad(&p, low, low + 1, high + 1, high);
            patch_quad(&p, low + 2, low + 3, high + 3, high + 2);
        }
    }
}

void shape_coil(shaper* s, double radius, double wire, double pitch, double turns, int sides,
                int wire_sides)
{
    enum { PIECE = 64 };
    int steps = (int)(turns * sides), at = 0;
    stp_vec3d points[PIECE + 1];
    while (at < steps) {
        int n = 0;
        for (; n <= PIECE && at + n <= steps; ++n) {
            double t = (double)(at + n) / sides;
            points[n] = vec3d(radius * turn_cosine(t), pitch * t, radius * turn_sine(t));
        }
        if (n < 2) {
            break;
        }
        shape_tube(s, points, n, wire, wire_sides, SHAPE_OPEN);
        at += n - 1;
    }
}
