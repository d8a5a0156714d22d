// SPDX-License-Identifier: MIT
#include "lab/scenes/mesh_shapes.h"

#include "base/math/rng.h"
#include "lab/scenes/mesh_shapes_patch.h"
#include "lab/scenes/trigonometry.h"

#include <assert.h>
#include <string.h>

double shaper_random(shaper* s)
{
    return (double)(stp_rng_hash(s->seed, s->draws++) >> 11) * (1.0 / 9007199254740992.0);
}

double shaper_between(shaper* s, double low, double high)
{
    return low + (high - low) * shaper_random(s);
}

// Rounds up or down at random. The randomness derives from the shapes made so far, not from a
// counter: arguments of one call may be evaluated in any order.
static int round_by_chance(const shaper* s, double value)
{
    double chance = (double)(stp_rng_hash(~s->seed, s->vertices) >> 11) / 9007199254740992.0;
    int whole = (int)value;
    return whole + (chance < value - (double)whole ? 1 : 0);
}

int shaper_sides(shaper* s, int base, int least)
{
    int sides = round_by_chance(s, base * s->tessellation);
    return sides < least ? least : sides > SHAPE_MOST_SIDES ? SHAPE_MOST_SIDES : sides;
}

int shaper_amount(shaper* s, int base)
{
    int amount = s->amount >= 1.0 ? base : round_by_chance(s, base * s->amount);
    return amount < 1 ? 1 : amount;
}

stp_affine shaper_push(shaper* s, stp_affine local)
{
    stp_affine before = s->place;
    s->place = stp_affine_multiply(before, local);
    return before;
}

stp_affine shaper_move(shaper* s, double x, double y, double z)
{
    return shaper_push(s, place_at(x, y, z));
}

void shaper_pop(shaper* s, stp_affine place)
{
    s->place = place;
}

stp_affine place_by_turn(double x, double y, double z, double turns)
{
    double c = turn_cosine(turns), d = turn_sine(turns);
    return (stp_affine){{{c, 0, d, x}, {0, 1, 0, y}, {-d, 0, c, z}}};
}

stp_affine place_along(stp_vec3d point, stp_vec3d direction)
{
    stp_vec3d y = stp_normalized(direction);
    bool upright = y.x * y.x + y.z * y.z < 1e-12;
    stp_vec3d z =
        upright ? vec3d(0, 0, y.y < 0 ? -1 : 1) : stp_normalized(stp_crossd(vec3d(0, 1, 0), y));
    stp_vec3d x = stp_crossd(y, z);
    return (stp_affine){
        {{x.x, y.x, z.x, point.x}, {x.y, y.y, z.y, point.y}, {x.z, y.z, z.z, point.z}}};
}

const shape_ring* shape_circle(shaper* s, int sides)
{
    assert(sides > 0 && sides <= SHAPE_MOST_SIDES && "a ring has room for no more");
    shape_ring* ring = &s->rings[sides % SHAPE_RINGS];
    if (ring->sides != sides) {
        ring->sides = sides;
        for (int i = 0; i <= sides; ++i) {
            double turns = (double)(i % sides) / sides;
            ring->cosine[i] = turn_cosine(turns);
            ring->sine[i] = turn_sine(turns);
        }
    }
    return ring;
}

void shaper_reserve(shaper* s, uint64_t vertices, uint64_t triangles)
{
    mesh_builder* b = s->builder;
    mesh_builder_make_room(b, (size_t)vertices, 3 * (size_t)triangles);
}

// Far below the designed detail, omits random shapes, except for the first ones of a mesh, which
// are its body.
static bool left_out(shaper* s)
{
    enum { BODY = 8 };
    if (s->keep >= 1.0 || s->shapes++ < BODY) {
        return false;
    }
    return (double)(stp_rng_hash(s->seed ^ UINT64_C(0x5a), s->shapes) >> 11) >=
           s->keep * 9007199254740992.0;
}

bool shape_begin(shaper* s, uint64_t vertices, uint64_t triangles, shape_patch* patch)
{
    if (left_out(s)) {
        return false;
    }
    s->vertices += vertices;
    s->triangles += triangles;
    mesh_builder* b = s->builder;
    if (b == NULL || !mesh_builder_make_room(b, (size_t)vertices, 3 * (size_t)triangles)) {
        return false;
    }
    *patch = (shape_patch){.position = b->positions + 3 * b->vertex_count,
                           .normal = b->normals + 3 * b->vertex_count,
                           .index = b->indices + b->index_count,
                           .first = (uint32_t)b->vertex_count,
                           .place = s->place};
    b->vertex_count += (size_t)vertices;
    b->index_count += 3 * (size_t)triangles;
    return true;
}

void shape_box(shaper* s, double x, double y, double z, double width, double height, double depth)
{
    shape_patch p;
    if (!shape_begin(s, 24, 12, &p)) {
        return;
    }
    double half[3] = {0.5 * width, 0.5 * height, 0.5 * depth};
    uint32_t at = p.first;
    for (int axis = 0; axis < 3; ++axis) {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int side = -1; side <= 1; side += 2) {
            for (int corner = 0; corner < 4; ++corner) {
                double q[3], n[3] = {0, 0, 0};
                q[axis] = side * half[axis];
                q[u] = (corner == 1 || corner == 2 ? half[u] : -half[u]) * side;
                q[v] = corner >= 2 ? half[v] : -half[v];
                n[axis] = side;
                patch_vertex(&p, x + q[0], y + q[1], z + q[2], n[0], n[1], n[2]);
            }
            patch_quad(&p, at, at + 1, at + 2, at + 3);
            at += 4;
        }
    }
}

void shape_bar(shaper* s, stp_vec3d from, stp_vec3d to, double height, double width)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way));
    stp_affine before = shaper_push(s, place_along(from, way));
    shape_box(s, 0, 0.5 * length, 0, height, length, width);
    shaper_pop(s, before);
}

// A beam's section: outline and triangles that fill it.
typedef struct section {
    int corners;
    double outline[12][2];
    uint8_t fill[10][3];
} section;

static section make_section(shape_profile profile, double h, double w, double t)
{
    double x = 0.5 * h, z = 0.5 * w, u = 0.5 * t;
    switch (profile) {
    case PROFILE_I:
        return (section){12,
                         {{x, -z},
                          {x, z},
                          {x - t, z},
                          {x - t, u},
                          {t - x, u},
                          {t - x, z},
                          {-x, z},
                          {-x, -z},
                          {t - x, -z},
                          {t - x, -u},
                          {x - t, -u},
                          {x - t, -z}},
                         {{0, 1, 2}, {0, 2, 11}, {10, 3, 4}, {10, 4, 9}, {8, 5, 6}, {8, 6, 7}}};
    case PROFILE_U:
        return (section){8,
                         {{x, -z},
                          {x, z},
                          {x - t, z},
                          {x - t, t - z},
                          {t - x, t - z},
                          {t - x, z},
                          {-x, z},
                          {-x, -z}},
                         {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 7}, {7, 4, 5}, {7, 5, 6}}};
    case PROFILE_L:
        return (section){6,
                         {{x, -z}, {x, t - z}, {t - x, t - z}, {t - x, z}, {-x, z}, {-x, -z}},
                         {{0, 1, 2}, {0, 2, 5}, {5, 2, 3}, {5, 3, 4}}};
    case PROFILE_T:
        return (section){
            8,
            {{x, -z}, {x, z}, {x - t, z}, {x - t, u}, {-x, u}, {-x, -u}, {x - t, -u}, {x - t, -z}},
            {{0, 1, 2}, {0, 2, 7}, {6, 3, 4}, {6, 4, 5}}};
    case PROFILE_TUBE:
    default:
        return (section){4, {{x, -z}, {x, z}, {-x, z}, {-x, -z}}, {{0, 1, 2}, {0, 2, 3}}};
    }
}

static int fill_count(shape_profile profile)
{
    static const int counts[] = {6, 6, 4, 4, 2};
    return counts[profile];
}

void shape_beam(shaper* s, shape_profile profile, stp_vec3d from, stp_vec3d to, double height,
                double width, double thickness)
{
    section cut = make_section(profile, height, width, thickness);
    int n = cut.corners, fill = fill_count(profile);
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way));
    stp_affine before = shaper_push(s, place_along(from, way));
    shape_patch p;
    if (shape_begin(s, 6 * (uint64_t)n, 2 * (uint64_t)(n + fill), &p)) {
        uint32_t at = p.first;
        for (int i = 0; i < n; ++i, at += 4) {
            const double *a = cut.outline[i], *b = cut.outline[(i + 1) % n];
            double dx = b[0] - a[0], dz = b[1] - a[1], size = sqrt(dx * dx + dz * dz);
            double nx = dz / size, nz = -dx / size;
            patch_vertex(&p, a[0], 0, a[1], nx, 0, nz);
            patch_vertex(&p, a[0], length, a[1], nx, 0, nz);
            patch_vertex(&p, b[0], length, b[1], nx, 0, nz);
            patch_vertex(&p, b[0], 0, b[1], nx, 0, nz);
            patch_quad(&p, at, at + 1, at + 2, at + 3);
        }
        for (int end = 0; end < 2; ++end, at += (uint32_t)n) {
            for (int i = 0; i < n; ++i) {
                patch_vertex(&p, cut.outline[i][0], end * length, cut.outline[i][1], 0, 2 * end - 1,
                             0);
            }
            for (int i = 0; i < fill; ++i) {
                const uint8_t* f = cut.fill[i];
                patch_triangle(&p, at + f[0], at + f[end ? 2 : 1], at + f[end ? 1 : 2]);
            }
        }
    }
    shaper_pop(s, before);
}
