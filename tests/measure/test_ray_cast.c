// SPDX-License-Identifier: MIT
// Rays through many instanced meshes, against brute force over all triangles.
#include "tests.h"

#include "base/math/rng.h"
#include "lab/measure/ray_cast.h"

#include <math.h>
#include <string.h>

enum { FIRST = 300, SECOND = 90, PARTS = 40, RAYS = 2000, TURN = 48, RISE = 24 };

// Between -1 and 1.
static double random_number(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-52 - 1.0;
}

static stp_vec3d random_vector(uint64_t seed, uint64_t index)
{
    return (stp_vec3d){random_number(seed, 3 * index), random_number(seed, 3 * index + 1),
                       random_number(seed, 3 * index + 2)};
}

/// Two meshes, one with indices and one without, and their instances: rotated, scaled, mirrored,
/// one flattened.
typedef struct world {
    float first[9 * FIRST], second[9 * SECOND];
    uint32_t indices[3 * FIRST];
    stp_cast_mesh meshes[2];
    stp_cast_part parts[PARTS];
} world;

static void make_world(world* w)
{
    for (size_t i = 0; i < FIRST + SECOND; ++i) {
        float* to = i < FIRST ? w->first + 9 * i : w->second + 9 * (i - FIRST);
        stp_vec3d at = random_vector(1, i);
        for (size_t k = 0; k < 9; ++k) {
            double base = k % 3 == 0 ? at.x : k % 3 == 1 ? at.y : at.z;
            to[k] = (float)(base + 0.3 * random_number(2, 9 * i + k));
        }
    }
    for (uint32_t i = 0; i < 3 * FIRST; ++i) {
        w->indices[i] = 3 * FIRST - 1 - i;
    }
    w->meshes[0] = (stp_cast_mesh){w->first, w->indices, FIRST};
    w->meshes[1] = (stp_cast_mesh){w->second, NULL, SECOND};
    for (uint32_t i = 0; i < PARTS; ++i) {
        w->parts[i].mesh = i % 2;
        for (int k = 0; k < 12; ++k) {
            double entry = random_number(3, 12 * (uint64_t)i + (uint64_t)k);
            w->parts[i].transform.m[k / 4][k % 4] = k % 4 == 3 ? 1000.0 + 5.0 * entry : entry;
        }
    }
    memset(w->parts[7].transform.m[1], 0, 3 * sizeof(double)); // flattened: never hit
}

/// A ray that starts between or beside the parts.
static stp_cast_ray make_ray(uint64_t index)
{
    double spread = index % 3 == 0 ? 12.0 : 5.0;
    stp_vec3d origin = stp_scaled(random_vector(4, index), spread);
    origin = stp_addd(origin, (stp_vec3d){1000.0, 1000.0, 1000.0});
    stp_vec3d direction = stp_normalized(random_vector(5, index));
    if (index % 50 == 0) { // along an axis
        direction = (stp_vec3d){index % 100 == 0 ? 1.0 : 0.0, index % 100 == 0 ? 0.0 : -1.0, 0.0};
    }
    return (stp_cast_ray){origin, direction, index % 5 == 0 ? 1.0 : 0.0, 20.0};
}

/// Where a ray hits a triangle (Möller, Trumbore 1997); infinity: no hit.
static double meet_triangle(const stp_cast_ray* ray, const stp_vec3d c[3])
{
    stp_vec3d u = stp_subd(c[1], c[0]), v = stp_subd(c[2], c[0]);
    stp_vec3d p = stp_crossd(ray->direction, v);
    double determinant = stp_dotd(u, p);
    if (determinant == 0.0) {
        return (double)INFINITY;
    }
    stp_vec3d from = stp_subd(ray->origin, c[0]), q = stp_crossd(from, u);
    double a = stp_dotd(from, p) / determinant, b = stp_dotd(ray->direction, q) / determinant;
    double t = stp_dotd(v, q) / determinant;
    return a >= 0.0 && b >= 0.0 && a + b <= 1.0 && t >= ray->nearest && t < ray->farthest
               ? t
               : (double)INFINITY;
}

/// Corners of all triangles, and a ball around those of each part.
static stp_vec3d places[PARTS][FIRST][3], middles[PARTS];
static double radii[PARTS];

static void find_corners(const world* w, const stp_caster* caster)
{
    for (uint32_t part = 0; part < PARTS; ++part) {
        uint32_t count = w->meshes[w->parts[part].mesh].triangle_count;
        for (uint32_t i = 0; i < count; ++i) {
            stp_caster_corners(caster, part, i, places[part][i]);
        }
        middles[part] = places[part][0][0];
        for (uint32_t i = 0; i < 3 * count; ++i) {
            stp_vec3d away = stp_subd(places[part][i / 3][i % 3], middles[part]);
            radii[part] = fmax(radii[part], sqrt(stp_dotd(away, away)));
        }
    }
}

/// Whether the line of a ray, of unit direction, may meet a part.
static bool comes_near(const stp_cast_ray* ray, uint32_t part)
{
    stp_vec3d aside = stp_crossd(ray->direction, stp_subd(middles[part], ray->origin));
    return sqrt(stp_dotd(aside, aside)) <= radii[part] + 1e-3;
}

/// The nearest of all triangles, except parts whose number modulo `skip` is 1.
static double meet_all(const world* w, const stp_cast_ray* ray, uint32_t skip)
{
    double nearest = (double)INFINITY;
    for (uint32_t part = 0; part < PARTS; ++part) {
        if (part == 7 || part % skip == 1 || !comes_near(ray, part)) {
            continue;
        }
        for (uint32_t i = 0; i < w->meshes[w->parts[part].mesh].triangle_count; ++i) {
            nearest = fmin(nearest, meet_triangle(ray, places[part][i]));
        }
    }
    return nearest;
}

static bool keeps(const stp_cast_hit* hit, void* user)
{
    return hit->part % *(const uint32_t*)user != 1;
}

void test_ray_cast_meets_the_nearest_triangle(test_state* test)
{
    static world w;
    make_world(&w);
    stp_context* context = test_context(NULL, 2, NULL);
    stp_caster* caster;
    CHECK(stp_caster_create(context, w.meshes, 2, w.parts, PARTS, &caster) == STP_OK);
    find_corners(&w, caster);
    uint32_t met = 0, missed = 0;
    for (uint64_t i = 0; i < RAYS; ++i) {
        stp_cast_ray ray = make_ray(i);
        uint32_t skip = i % 2 == 0 ? UINT32_MAX : 3;
        stp_cast_hit hit;
        bool hits = stp_caster_intersect(caster, &ray, skip == 3 ? keeps : NULL, &skip, &hit);
        double wanted = meet_all(&w, &ray, skip == 3 ? 3 : PARTS + 1);
        CHECK(hits == isfinite(wanted));
        missed += hits ? 0 : 1;
        if (!hits) {
            continue;
        }
        met += 1;
        CHECK(fabs(hit.distance - wanted) < 1e-9);
        stp_vec3d c[3], place = {0};
        stp_caster_corners(caster, hit.part, hit.triangle, c);
        for (int k = 0; k < 3; ++k) {
            place = stp_addd(place, stp_scaled(c[k], hit.share[k]));
        }
        place = stp_subd(place, stp_addd(ray.origin, stp_scaled(ray.direction, hit.distance)));
        CHECK(stp_dotd(place, place) < 1e-18);
    }
    CHECK(met > RAYS / 8 && missed > RAYS / 8);
    stp_caster_destroy(context, caster);
    stp_context_destroy(context);
}

// No ray leaves a closed ball, not even through its vertices and edges.
void test_ray_cast_slips_through_no_edge(test_state* test)
{
    static float positions[3 * TURN * (RISE + 1)];
    static uint32_t indices[6 * TURN * RISE];
    uint32_t count = 0;
    for (uint32_t i = 0; i < TURN * (RISE + 1); ++i) {
        double a = 6.283185307179586 * (i % TURN) / TURN;
        double b = 3.141592653589793 * (i / TURN) / RISE;
        const double p[3] = {sin(b) * cos(a), sin(b) * sin(a), cos(b)};
        for (size_t k = 0; k < 3; ++k) {
            positions[3 * i + k] = (float)p[k];
        }
    }
    for (uint32_t i = 0; i < TURN * RISE; ++i) {
        uint32_t next = i % TURN + 1 < TURN ? i + 1 : i + 1 - TURN;
        const uint32_t both[6] = {i, i + TURN, next, next, i + TURN, next + TURN};
        memcpy(indices + 6 * i, both, sizeof(both));
        count += 2;
    }
    const stp_cast_mesh mesh = {positions, indices, count};
    const stp_cast_part part = {0, {{{0.3, 0.9, 0.1, 7}, {-0.8, 0.2, 0.3, 8}, {0.2, 0.1, 1.1, 9}}}};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_caster* caster;
    CHECK(stp_caster_create(context, &mesh, 1, &part, 1, &caster) == STP_OK);
    stp_vec3d origin = stp_affine_point(&part.transform, (stp_vec3d){0.1, 0.2, -0.1});
    for (uint32_t i = 0; i < 6 * TURN * RISE; ++i) {
        stp_vec3d corners[3];
        stp_caster_corners(caster, 0, i / 3, corners);
        stp_vec3d middle = stp_scaled(stp_addd(corners[i % 3], corners[(i + 1) % 3]), 0.5);
        const stp_vec3d targets[2] = {corners[i % 3], middle};
        for (int k = 0; k < 2; ++k) {
            stp_cast_ray ray = {origin, stp_subd(targets[k], origin), 0.0, 10.0};
            stp_cast_hit hit;
            CHECK(stp_caster_intersect(caster, &ray, NULL, NULL, &hit));
            CHECK(fabs(hit.distance - 1.0) < 1e-9);
        }
    }
    stp_caster_destroy(context, caster);
    stp_context_destroy(context);
}

// Identical boxes, and boxes that halve in size.
void test_ray_cast_of_odd_boxes(test_state* test)
{
    enum { SAME = 1000, HALVES = 120 };
    static float positions[9 * (SAME + HALVES)];
    for (size_t i = 0; i < SAME + HALVES; ++i) {
        float size = i < SAME ? 1.0f : (float)pow(2.0, -(double)(i - SAME));
        const float corners[9] = {0, 0, size, size, 0, size, 0, size, size};
        memcpy(positions + 9 * i, corners, sizeof(corners));
    }
    const stp_cast_mesh meshes[2] = {{positions, NULL, SAME + HALVES}, {NULL, NULL, 0}};
    const stp_cast_part parts[2] = {{0, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}},
                                    {1, {{{1, 0, 0, 9}, {0, 1, 0, 0}, {0, 0, 1, 0}}}}};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_caster* caster;
    CHECK(stp_caster_create(context, meshes, 2, parts, 2, &caster) == STP_OK);
    CHECK(stp_caster_bounds(caster).max.x == 1.0);
    for (int i = 0; i < HALVES; ++i) {
        double size = pow(2.0, -i);
        stp_cast_ray ray = {
            {0.3 * size, 0.3 * size, size * 0.75}, {0.0, 0.0, 1.0}, 0.0, (double)INFINITY};
        stp_cast_hit hit;
        CHECK(stp_caster_intersect(caster, &ray, NULL, NULL, &hit));
        CHECK(fabs(hit.distance - 0.25 * size) <= 1e-9 * size);
    }
    stp_caster_destroy(context, caster);
    CHECK(stp_caster_create(context, meshes + 1, 1, NULL, 0, &caster) == STP_OK);
    CHECK(stp_boxd_is_empty(stp_caster_bounds(caster)));
    stp_cast_ray ray = {{0, 0, 0}, {0, 0, 1}, 0.0, 1.0};
    stp_cast_hit hit;
    CHECK(!stp_caster_intersect(caster, &ray, NULL, NULL, &hit));
    stp_caster_destroy(context, caster);
    stp_context_destroy(context);
}

void test_ray_cast_without_memory(test_state* test)
{
    static world w;
    make_world(&w);
    bool made = false;
    for (int fail = 0; fail < 100 && !made; ++fail) {
        test_heap heap = TEST_HEAP(fail);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_caster* caster = NULL;
        if (context == NULL) {
            continue;
        }
        stp_result result = stp_caster_create(context, w.meshes, 2, w.parts, PARTS, &caster);
        made = result == STP_OK;
        CHECK(made || (result == STP_ERROR_OUT_OF_MEMORY && caster == NULL && log.errors == 1));
        stp_caster_destroy(context, caster);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
    const stp_cast_mesh large = {w.first, NULL, UINT32_C(1) << 31};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_caster* caster = NULL;
    CHECK(stp_caster_create(context, &large, 1, NULL, 0, &caster) == STP_ERROR_LIMIT);
    stp_context_destroy(context);
}
