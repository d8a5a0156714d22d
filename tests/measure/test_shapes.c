// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/rng.h"
#include "lab/measure/shape_tree.h"

#include <math.h>
#include <string.h>

enum { ANGLES = 512, SHAPES = 700 };

// Between -1 and 1.
static double random_number(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-52 - 1.0;
}

static stp_vec3d random_vector(uint64_t seed, uint64_t index, double size)
{
    return (stp_vec3d){size * random_number(seed, 3 * index),
                       size * random_number(seed, 3 * index + 1),
                       size * random_number(seed, 3 * index + 2)};
}

// A disk at a random position and orientation, with axes of these lengths.
static stp_disk_shape make_disk(uint64_t seed, double larger, double smaller)
{
    stp_vec3d u = stp_normalized(random_vector(seed, 1, 1.0));
    stp_vec3d v = stp_normalized(stp_crossd(u, random_vector(seed, 2, 1.0)));
    return (stp_disk_shape){stp_to_float(random_vector(seed, 3, 1.0)),
                            stp_to_float(stp_scaled(u, larger)),
                            stp_to_float(stp_scaled(v, smaller))};
}

typedef struct long_vector {
    long double x[3];
} long_vector;

static long_vector widen(stp_vec3 v)
{
    return (long_vector){{(long double)v.x, (long double)v.y, (long double)v.z}};
}

static long double long_dot(long_vector a, long_vector b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static long_vector long_step(long_vector a, long_vector b, long double factor)
{
    for (int k = 0; k < 3; ++k) {
        a.x[k] += factor * b.x[k];
    }
    return a;
}

// A disk in long double, with the smaller axis made exactly perpendicular to the larger.
typedef struct long_disk {
    long_vector center, larger, smaller;
} long_disk;

static long_disk widen_disk(const stp_disk_shape* disk)
{
    long_disk d = {widen(disk->center), widen(disk->larger), widen(disk->smaller)};
    long double length = long_dot(d.larger, d.larger);
    if (length > 0.0L) {
        d.smaller = long_step(d.smaller, d.larger, -long_dot(d.smaller, d.larger) / length);
    }
    return d;
}

static long double distance_at(const long_disk* d, long_vector point, long double angle)
{
    long_vector at = long_step(d->center, d->larger, cosl(angle));
    at = long_step(at, d->smaller, sinl(angle));
    long_vector away = long_step(point, at, -1.0L);
    return sqrtl(long_dot(away, away));
}

// Samples the whole boundary and narrows the best interval.
static long double distance_to_boundary(const long_disk* d, long_vector point)
{
    const long double step = 2.0L * 3.14159265358979323846264L / (long double)ANGLES;
    long double best = distance_at(d, point, 0.0L);
    int best_angle = 0;
    for (int i = 1; i < ANGLES; ++i) {
        long double distance = distance_at(d, point, step * (long double)i);
        best_angle = distance < best ? i : best_angle;
        best = distance < best ? distance : best;
    }
    long double low = step * (long double)(best_angle - 1);
    long double high = step * (long double)(best_angle + 1);
    for (int i = 0; i < 120; ++i) {
        long double a = low + (high - low) / 3.0L, b = high - (high - low) / 3.0L;
        if (distance_at(d, point, a) < distance_at(d, point, b)) {
            high = b;
        } else {
            low = a;
        }
    }
    return fminl(best, distance_at(d, point, low));
}

static long double distance_by_search(const stp_disk_shape* disk, stp_vec3d point)
{
    long_disk d = widen_disk(disk);
    long_vector p = {{(long double)point.x, (long double)point.y, (long double)point.z}};
    long_vector away = long_step(p, d.center, -1.0L);
    long double a = long_dot(d.larger, d.larger), b = long_dot(d.smaller, d.smaller);
    long double distance = distance_to_boundary(&d, p);
    if (a > 0.0L && b > 0.0L) {
        long double s = long_dot(away, d.larger) / a, t = long_dot(away, d.smaller) / b;
        if (s * s + t * t <= 1.0L) {
            long_vector rest = long_step(long_step(away, d.larger, -s), d.smaller, -t);
            distance = sqrtl(long_dot(rest, rest));
        }
    }
    return distance;
}

static bool agrees(const stp_disk_shape* disk, stp_vec3d point)
{
    double distance = sqrt(stp_disk_distance_squared(disk, point, (double)INFINITY));
    long double found = distance_by_search(disk, point);
    bool good = fabsl((long double)distance - found) <= 1e-9L * (found + 1.0L);
    if (!good) {
        fprintf(stderr, "distance %.17g, by search %.17Lg\n", distance, found);
    }
    return good;
}

void test_disk_distances_agree_with_search(test_state* test)
{
    for (uint64_t seed = 0; seed < 300; ++seed) {
        double larger = 0.5 + 0.45 * random_number(seed, 100);
        double ratio = seed % 3 == 0 ? 1.0 : 0.5 + 0.499 * random_number(seed, 101);
        stp_disk_shape disk = make_disk(seed, larger, larger * ratio);
        CHECK(agrees(&disk, random_vector(seed, 50, 0.1 + 3.0 * (double)(seed % 2))));
    }
}

// Searching thin ellipses by angle is inaccurate; points above and beyond their ends have simple
// distances.
void test_disk_distances_of_degenerate_disks(test_state* test)
{
    const double limit = (double)INFINITY;
    stp_disk_shape point = {{1, 2, 3}, {0, 0, 0}, {0, 0, 0}};
    CHECK(stp_disk_distance_squared(&point, (stp_vec3d){1, 2, 5}, limit) == 4.0);
    stp_disk_shape segment = {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}};
    CHECK(stp_disk_distance_squared(&segment, (stp_vec3d){1, 3, 4}, limit) == 25.0);
    CHECK(stp_disk_distance_squared(&segment, (stp_vec3d){-5, 0, 4}, limit) == 25.0);
    stp_disk_shape round = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
    CHECK(stp_disk_distance_squared(&round, (stp_vec3d){0, 0, 0}, limit) == 0.0);
    CHECK(stp_disk_distance_squared(&round, (stp_vec3d){1, 1, -3}, limit) == 9.0);
    CHECK(fabs(stp_disk_distance_squared(&round, (stp_vec3d){3, 4, 4}, limit) - 25.0) < 1e-12);
    static const float thin[] = {1e-3f, 1e-6f, 1e-12f, 1e-30f, 1e-44f};
    for (int i = 0; i < 5; ++i) {
        stp_disk_shape disk = {{0, 0, 0}, {2, 0, 0}, {0, thin[i], 0}};
        double b = (double)thin[i];
        double end = stp_disk_distance_squared(&disk, (stp_vec3d){5, 0, 4}, limit);
        CHECK(fabs(end - 25.0) < 1e-12);
        double side = stp_disk_distance_squared(&disk, (stp_vec3d){0, 3, 4}, limit);
        CHECK(fabs(side - ((3.0 - b) * (3.0 - b) + 16.0)) < 1e-12);
        // near a segment the distance is that of the segment, up to the width
        double skew = sqrt(stp_disk_distance_squared(&disk, (stp_vec3d){1, 1, 1}, limit));
        CHECK(skew <= sqrt(2.0) + 1e-12 && skew >= sqrt(2.0) - b - 1e-12);
        double corner = sqrt(stp_disk_distance_squared(&disk, (stp_vec3d){4, 1, 1}, limit));
        CHECK(corner <= sqrt(6.0) + 1e-12 && corner >= sqrt(6.0) - b - 1e-12);
    }
    stp_disk_shape large = {{0, 0, 0}, {1e30f, 0, 0}, {0, 1e-30f, 0}};
    double far = stp_disk_distance_squared(&large, (stp_vec3d){0, 1e30, 0}, limit);
    CHECK(fabs(far / 1e60 - 1.0) < 1e-12);
}

// A bound never hides a distance below it.
void test_disk_distances_below_a_bound_are_exact(test_state* test)
{
    for (uint64_t seed = 0; seed < 2000; ++seed) {
        stp_disk_shape disk = make_disk(seed, 1.0, 0.1 + 0.05 * random_number(seed, 9));
        stp_vec3d p = random_vector(seed, 50, 2.0);
        double exact = stp_disk_distance_squared(&disk, p, (double)INFINITY);
        CHECK(stp_disk_distance_squared(&disk, p, exact) == exact);
        CHECK(stp_disk_distance_squared(&disk, p, 2.0 * exact) == exact);
        CHECK(stp_disk_distance_squared(&disk, p, 0.5 * exact) >= 0.5 * exact);
        CHECK(stp_disk_distance_squared(&disk, p, 0.0) <= exact * (1.0 + 1e-9));
    }
}

// Minimises over the places of a triangle, which is convex.
static double triangle_by_search(const stp_vec3d c[3], stp_vec3d p)
{
    double best = (double)INFINITY, u0 = 0.5, v0 = 0.5, size = 0.5;
    for (int round = 0; round < 60; ++round, size *= 0.75) {
        double best_u = u0, best_v = v0;
        for (int i = -4; i <= 4; ++i) {
            for (int k = -4; k <= 4; ++k) {
                double u = fmin(fmax(u0 + size * i / 4, 0.0), 1.0);
                double v = fmin(fmax(v0 + size * k / 4, 0.0), 1.0 - u);
                stp_vec3d at = stp_addd(c[0], stp_scaled(stp_subd(c[1], c[0]), u));
                at = stp_subd(p, stp_addd(at, stp_scaled(stp_subd(c[2], c[0]), v)));
                double distance = stp_dotd(at, at);
                if (distance < best) {
                    best = distance;
                    best_u = u;
                    best_v = v;
                }
            }
        }
        u0 = best_u;
        v0 = best_v;
    }
    return best;
}

void test_triangle_distances_agree_with_search(test_state* test)
{
    for (uint64_t seed = 0; seed < 300; ++seed) {
        stp_vec3d c[3];
        for (uint64_t k = 0; k < 3; ++k) {
            c[k] = random_vector(seed, k, 1.0);
        }
        c[2] = seed % 10 == 0 ? c[1] : c[2];
        c[1] = seed % 50 == 0 ? c[0] : c[1];
        stp_vec3d p = random_vector(seed, 7, 2.0);
        double distance = stp_triangle_distance_squared(c, p), found = triangle_by_search(c, p);
        CHECK(distance <= found + 1e-9 && distance >= found - 1e-5);
    }
}

static stp_disk_shape disks[SHAPES];
static float positions[9 * SHAPES];
static uint32_t indices[3 * SHAPES];

static stp_shapes make_shapes(uint64_t seed, uint32_t disk_count, uint32_t triangle_count,
                              bool in_one_place)
{
    for (uint32_t i = 0; i < disk_count; ++i) {
        double size = i % 7 == 0 ? 0.0 : 0.02 + 0.02 * random_number(seed, i);
        disks[i] = make_disk(in_one_place ? seed : seed + 1000 * i, i % 31 == 0 ? 20 * size : size,
                             0.5 * size);
    }
    for (uint32_t i = 0; i < 9 * triangle_count; ++i) {
        double at = random_number(seed + 5, i / 9 * 3 + i % 3);
        positions[i] = (float)(in_one_place ? 0.25 : at + 0.05 * random_number(seed + 6, i));
    }
    for (uint32_t i = 0; i < 3 * triangle_count; ++i) {
        indices[i] = 3 * triangle_count - 1 - i;
    }
    return (stp_shapes){disks, disk_count, positions, indices, triangle_count};
}

static double distance_to_all(const stp_shapes* s, stp_vec3d p)
{
    double best = (double)INFINITY;
    for (size_t i = 0; i < s->disk_count; ++i) {
        best = fmin(best, stp_disk_distance_squared(&s->disks[i], p, (double)INFINITY));
    }
    for (size_t i = 0; i < s->triangle_count; ++i) {
        stp_vec3d corners[3];
        stp_triangle_corners(s->positions, s->indices, i, corners);
        best = fmin(best, stp_triangle_distance_squared(corners, p));
    }
    return best;
}

void test_shape_tree_agrees_with_trying_all(test_state* test)
{
    static const uint32_t counts[][2] = {{1, 0}, {0, 1}, {3, 2}, {4, 0}, {65, 64}, {SHAPES, 300}};
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
        for (int kind = 0; kind < 2; ++kind) {
            stp_shapes shapes = make_shapes(c, counts[c][0], counts[c][1], kind == 1);
            stp_shape_tree tree;
            CHECK_EQUAL(STP_OK, stp_shape_tree_create(context, &shapes, &tree));
            uint32_t hint = UINT32_MAX;
            for (uint32_t i = 0; i < 300; ++i) {
                stp_vec3d p = random_vector(c + 70, i, i % 3 == 0 ? 0.2 : 2.0);
                p = i % 5 == 0 && counts[c][0] > 0 ? stp_to_double(disks[0].center) : p;
                double all = distance_to_all(&shapes, p);
                CHECK(stp_shape_tree_distance_squared(&tree, p, NULL) == all);
                CHECK(stp_shape_tree_distance_squared(&tree, p, &hint) == all);
                CHECK(hint < tree.count);
            }
            stp_shape_tree_destroy(context, &tree);
        }
    }
    stp_shapes none = {0};
    stp_shape_tree tree;
    CHECK_EQUAL(STP_OK, stp_shape_tree_create(context, &none, &tree));
    CHECK(isinf(stp_shape_tree_distance_squared(&tree, (stp_vec3d){0}, NULL)));
    stp_shape_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

void test_shape_tree_is_the_same_for_any_threads(test_state* test)
{
    stp_shape_tree trees[3];
    stp_context* contexts[3];
    stp_shapes shapes = make_shapes(3, SHAPES, SHAPES, false);
    for (uint32_t i = 0; i < 3; ++i) {
        contexts[i] = test_context(NULL, i + 1, NULL);
        CHECK(contexts[i] != NULL);
        CHECK_EQUAL(STP_OK, stp_shape_tree_create(contexts[i], &shapes, &trees[i]));
    }
    for (uint32_t i = 1; i < 3; ++i) {
        CHECK_EQUAL(trees[0].depth, trees[i].depth);
        CHECK(memcmp(trees[0].order, trees[i].order, trees[0].count * sizeof(uint32_t)) == 0);
        size_t nodes = ((size_t)2 << trees[0].depth) - 1;
        CHECK(memcmp(trees[0].boxes, trees[i].boxes, nodes * sizeof(stp_shape_box)) == 0);
    }
    for (uint32_t i = 0; i < 3; ++i) {
        stp_shape_tree_destroy(contexts[i], &trees[i]);
        stp_context_destroy(contexts[i]);
    }
}

void test_shape_tree_refuses_non_finite_input(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    for (int kind = 0; kind < 4; ++kind) {
        stp_shapes shapes = make_shapes(3, 20, 20, false);
        float* numbers[] = {&disks[7].center.y, &disks[19].larger.z, &disks[0].smaller.x,
                            &positions[31]};
        *numbers[kind] = kind % 2 == 0 ? NAN : INFINITY;
        stp_shape_tree tree;
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_shape_tree_create(context, &shapes, &tree));
        CHECK(strstr(log.text, "non-finite") != NULL);
    }
    stp_context_destroy(context);
}
