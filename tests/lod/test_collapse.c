// SPDX-License-Identifier: MIT
// Edge collapses by quadric error.
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "lod/levels/collapse.h"
#include "lod/levels/plane_quadric.h"

#include <math.h>
#include <string.h>

enum { SIDE = 33, VERTICES = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };

typedef struct grid {
    float positions[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    uint32_t tags[TRIANGLES];
    uint8_t locked[VERTICES];
    stp_collapse_mesh mesh;
} grid;

/// A square of SIDE x SIDE vertices from 0 to 1, bent by `height` times a wave.
static void make_grid(grid* g, float height)
{
    memset(g, 0, sizeof(*g));
    uint32_t t = 0;
    for (uint32_t y = 0; y < SIDE; ++y) {
        for (uint32_t x = 0; x < SIDE; ++x) {
            float* p = g->positions + 3 * (y * SIDE + x);
            p[0] = (float)x / (SIDE - 1);
            p[1] = (float)y / (SIDE - 1);
            p[2] = height * sinf(5.0f * p[0]) * cosf(4.0f * p[1]);
            if (x + 1 < SIDE && y + 1 < SIDE) {
                uint32_t v = y * SIDE + x;
                const uint32_t two[6] = {v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE};
                memcpy(g->indices + 3 * t, two, sizeof(two));
                g->tags[t] = t;
                g->tags[t + 1] = t + 1;
                t += 2;
            }
        }
    }
    g->mesh = (stp_collapse_mesh){.vertex_count = VERTICES,
                                  .triangle_count = TRIANGLES,
                                  .positions = g->positions,
                                  .indices = g->indices,
                                  .tags = g->tags,
                                  .locked = g->locked};
}

static stp_vec3d place_of(const stp_collapse_mesh* m, uint32_t vertex)
{
    const float* p = m->positions + 3 * (size_t)vertex;
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

static stp_vec3d cross_of(const stp_collapse_mesh* m, uint32_t triangle)
{
    const uint32_t* c = m->indices + 3 * (size_t)triangle;
    stp_vec3d a = place_of(m, c[0]);
    return stp_crossd(stp_subd(place_of(m, c[1]), a), stp_subd(place_of(m, c[2]), a));
}

static double area_of(const stp_collapse_mesh* m)
{
    double area = 0.0;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        area += 0.5 * stp_lengthd(cross_of(m, t));
    }
    return area;
}

static const stp_collapse_desc to_the_end = {
    .error_limit = HUGE_VAL, .border_weight = 1.0, .least_cosine = 0.2};

void test_collapse_keeps_a_square(test_state* test)
{
    static grid g;
    stp_context* context = test_context(NULL, 1, NULL);
    make_grid(&g, 0.0f);
    stp_collapse_desc desc = to_the_end;
    desc.error_limit = 1e-6;
    double error;
    CHECK_EQUAL(STP_OK, stp_collapse(context, &g.mesh, &desc, &error));
    CHECK(error <= 1e-6);
    CHECK(g.mesh.triangle_count >= 2 && g.mesh.triangle_count <= 8);
    CHECK(fabs(area_of(&g.mesh) - 1.0) < 1e-5);
    for (uint32_t t = 0; t < g.mesh.triangle_count; ++t) {
        CHECK(cross_of(&g.mesh, t).z > 0.0); // none is turned over
        CHECK(g.tags[t] < TRIANGLES && (t == 0 || g.tags[t - 1] < g.tags[t]));
    }
    stp_context_destroy(context);
}

void test_collapse_stops_at_each_limit(test_state* test)
{
    static grid g;
    stp_context* context = test_context(NULL, 1, NULL);
    for (int i = 0; i < 3; ++i) {
        stp_collapse_desc desc = to_the_end;
        desc.triangle_target = i == 0 ? 500 : 0;
        desc.vertex_target = i == 1 ? 300 : 0;
        desc.error_limit = i == 2 ? 0.002 : HUGE_VAL;
        double error;
        make_grid(&g, 0.1f);
        CHECK_EQUAL(STP_OK, stp_collapse(context, &g.mesh, &desc, &error));
        uint32_t used = 0;
        static uint8_t seen[VERTICES];
        memset(seen, 0, sizeof(seen));
        for (uint32_t k = 0; k < 3 * g.mesh.triangle_count; ++k) {
            used += seen[g.indices[k]] == 0 ? 1 : 0;
            seen[g.indices[k]] = 1;
        }
        CHECK(i != 0 || (g.mesh.triangle_count <= 500 && g.mesh.triangle_count >= 497));
        CHECK(i != 1 || (used <= 300 && used >= 298));
        CHECK(i != 2 || (error <= 0.002 && error > 0.001 && g.mesh.triangle_count < TRIANGLES / 2));
        CHECK(fabs(area_of(&g.mesh) / 1.05 - 1.0) < 0.05);
        // the wave, within a few times the mean distance
        for (uint32_t v = 0; v < VERTICES; ++v) {
            const float* p = g.positions + 3 * v;
            float wave = 0.1f * sinf(5.0f * p[0]) * cosf(4.0f * p[1]);
            CHECK(seen[v] == 0 || fabs((double)(p[2] - wave)) < 5.0 * error + 1e-6);
        }
    }
    stp_context_destroy(context);
}

// Meshes that share locked vertices still meet.
void test_collapse_keeps_locked_vertices(test_state* test)
{
    static grid g;
    static float before[3 * VERTICES];
    stp_context* context = test_context(NULL, 1, NULL);
    make_grid(&g, 0.1f);
    for (uint32_t i = 0; i < SIDE; ++i) {
        g.locked[i * SIDE] = 1;
    }
    memcpy(before, g.positions, sizeof(before));
    double error;
    CHECK_EQUAL(STP_OK, stp_collapse(context, &g.mesh, &to_the_end, &error));
    CHECK(g.mesh.triangle_count < TRIANGLES / 8);
    static uint8_t used[VERTICES];
    for (uint32_t i = 0; i < 3 * g.mesh.triangle_count; ++i) {
        used[g.indices[i]] = 1;
    }
    for (uint32_t i = 0; i < SIDE; ++i) {
        uint32_t v = i * SIDE;
        CHECK(used[v] == 1 && memcmp(before + 3 * v, g.positions + 3 * v, 3 * sizeof(float)) == 0);
    }
    stp_context_destroy(context);
}

// The first collapse is the cheapest of all edges, found one by one from the planes around them.
void test_collapse_begins_with_the_cheapest_edge(test_state* test)
{
    enum { COUNT = 12 };
    stp_context* context = test_context(NULL, 1, NULL);
    for (uint64_t seed = 0; seed < 200; ++seed) {
        // a closed double fan of random points: COUNT around, one above, one below
        float positions[3 * (COUNT + 2)];
        uint32_t indices[6 * COUNT];
        for (uint32_t v = 0; v < COUNT + 2; ++v) {
            double angle = 2.0 * STP_PI * v / COUNT;
            const double place[3] = {v < COUNT ? cos(angle) : 0.0, v < COUNT ? sin(angle) : 0.0,
                                     v < COUNT    ? 0.0
                                     : v == COUNT ? 1.0
                                                  : -1.0};
            for (uint64_t k = 0; k < 3; ++k) {
                double random = (double)(stp_rng_hash(seed * 64 + v, k) >> 40) / 0x1p24;
                positions[3 * v + k] = (float)(place[k] + 0.2 * random);
            }
        }
        for (uint32_t i = 0; i < COUNT; ++i) {
            uint32_t next = (i + 1) % COUNT;
            const uint32_t two[6] = {i, next, COUNT, next, i, COUNT + 1};
            memcpy(indices + (size_t)6 * i, two, sizeof(two));
        }
        stp_collapse_mesh m = {.vertex_count = COUNT + 2,
                               .triangle_count = 2 * COUNT,
                               .positions = positions,
                               .indices = indices};
        double cheapest = HUGE_VAL, weight = 0.0, area = area_of(&m);
        for (uint32_t a = 0; a < COUNT + 2; ++a) {
            for (uint32_t b = a + 1; b < COUNT + 2; ++b) {
                bool edge = false;
                stp_plane_quadric sum = {0};
                for (uint32_t t = 0; t < m.triangle_count; ++t) {
                    const uint32_t* c = indices + (size_t)3 * t;
                    stp_vec3d normal = cross_of(&m, t);
                    double twice = stp_lengthd(normal);
                    normal = stp_scaled(normal, 1.0 / twice);
                    int has = 0;
                    for (int k = 0; k < 3; ++k) {
                        if (c[k] == a || c[k] == b) {
                            has += 1;
                            stp_plane_quadric_add(&sum, normal,
                                                  -stp_dotd(normal, place_of(&m, c[0])),
                                                  0.5 * twice, 0.5 * twice);
                        }
                    }
                    edge = edge || has == 2;
                }
                stp_vec3d pa = place_of(&m, a), pb = place_of(&m, b), best;
                stp_vec3d middle = stp_scaled(stp_addd(pa, pb), 0.5);
                double cost =
                    fmin(stp_plane_quadric_error(&sum, pa), stp_plane_quadric_error(&sum, pb));
                if (stp_plane_quadric_minimum(&sum, middle, &best) &&
                    stp_lengthd(stp_subd(best, middle)) < 2.0 * stp_lengthd(stp_subd(pa, pb))) {
                    cost = fmin(cost, stp_plane_quadric_error(&sum, best));
                }
                weight = edge && cost < cheapest ? sum.weight : weight;
                cheapest = edge ? fmin(cheapest, cost) : cheapest;
            }
        }
        stp_collapse_desc desc = {
            .triangle_target = 2 * COUNT - 1, .error_limit = HUGE_VAL, .least_cosine = -1.0};
        double error;
        CHECK_EQUAL(STP_OK, stp_collapse(context, &m, &desc, &error));
        CHECK_EQUAL(2 * COUNT - 2, m.triangle_count);
        double lost = fmax(area - area_of(&m), 0.0); // a quarter of its square counts
        CHECK(fabs(error - sqrt(cheapest + 0.25 * lost * lost / weight)) < 1e-5 * error + 1e-9);
    }
    stp_context_destroy(context);
}

/// The mean, with the weak pull that makes the minimum unique.
static double pulled_error(const stp_plane_quadric* q, stp_vec3d p, stp_vec3d near)
{
    stp_vec3d away = stp_subd(p, near);
    return stp_plane_quadric_error(q, p) + 1e-3 * stp_dotd(away, away);
}

// A quadric's minimum is where no step lowers its sum.
void test_plane_quadrics_have_their_minimum_there(test_state* test)
{
    for (uint64_t seed = 0; seed < 500; ++seed) {
        stp_plane_quadric q = {0};
        double sum = 0.0;
        for (uint64_t i = 0; i < 5; ++i) {
            double r[5];
            for (uint64_t k = 0; k < 5; ++k) {
                r[k] = (double)(stp_rng_hash(seed * 16 + i, k) >> 40) / 0x1p23 - 1.0;
            }
            stp_vec3d normal = stp_normalized((stp_vec3d){r[0], r[1], r[2] + 0.01});
            double weight = 1.1 + r[4], distance = r[3]; // at the origin
            stp_plane_quadric_add(&q, normal, distance, weight, weight);
            sum += weight * distance * distance;
        }
        CHECK(fabs(stp_plane_quadric_error(&q, (stp_vec3d){0}) - sum / q.weight) < 1e-12);
        stp_vec3d best, near = {0.1, 0.2, -0.3};
        CHECK(stp_plane_quadric_minimum(&q, near, &best));
        for (int k = 0; k < 12; ++k) {
            double step = (k < 6 ? 0.3 : 1e-3) * (k % 2 == 0 ? 1.0 : -1.0);
            int axis = k / 2 % 3;
            stp_vec3d there =
                stp_addd(best, (stp_vec3d){axis == 0 ? step : 0.0, axis == 1 ? step : 0.0,
                                           axis == 2 ? step : 0.0});
            CHECK(pulled_error(&q, best, near) < pulled_error(&q, there, near));
        }
    }
}

// A vertex with very many triangles costs no square of their number, and none gets more.
void test_collapse_bounds_fans(test_state* test)
{
    enum { RIM = 20000 };
    static float positions[3 * (RIM + 1)];
    static uint32_t indices[3 * RIM], degrees[RIM + 1];
    for (uint32_t i = 0; i < RIM; ++i) {
        double angle = 2.0 * STP_PI * i / RIM;
        positions[3 * i] = (float)cos(angle);
        positions[3 * i + 1] = (float)sin(angle);
        positions[3 * i + 2] = 0.0f;
        const uint32_t t[3] = {i, (i + 1) % RIM, RIM};
        memcpy(indices + 3 * (size_t)i, t, sizeof(t));
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_collapse_mesh m = {
        .vertex_count = RIM + 1, .triangle_count = RIM, .positions = positions, .indices = indices};
    stp_collapse_desc desc = to_the_end;
    desc.error_limit = 0.01;
    double error;
    CHECK_EQUAL(STP_OK, stp_collapse(context, &m, &desc, &error));
    CHECK(m.triangle_count < 200 && fabs(area_of(&m) - STP_PI) < 0.05);
    for (uint32_t i = 0; i < 3 * m.triangle_count; ++i) {
        degrees[m.indices[i]] += 1;
        CHECK(degrees[m.indices[i]] <= STP_COLLAPSE_FAN);
    }
    stp_context_destroy(context);
}

void test_collapse_survives_failing_allocator(test_state* test)
{
    static grid g, whole;
    bool made = false;
    make_grid(&whole, 0.1f);
    for (int n = 1; !made && n < 100; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        make_grid(&g, 0.1f);
        if (context != NULL) {
            double error;
            stp_result result = stp_collapse(context, &g.mesh, &to_the_end, &error);
            made = result == STP_OK && heap.count <= n;
            CHECK(result == STP_OK ||
                  (result == STP_ERROR_OUT_OF_MEMORY &&
                   memcmp(g.positions, whole.positions, sizeof(g.positions)) == 0 &&
                   memcmp(g.indices, whole.indices, sizeof(g.indices)) == 0));
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
