// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "import/reading/triangulate.h"

#include <math.h>
#include <stdlib.h>

enum { LIMIT = 4000 };

typedef struct polygon {
    uint32_t count;
    float positions[3 * LIMIT];
    uint32_t corners[LIMIT];
    uint32_t triangles[3 * LIMIT];
} polygon;

static void put(polygon* p, double x, double y)
{
    // a slanted plane, so that no axis is special
    float* out = p->positions + 3 * p->count;
    out[0] = (float)(x - 0.3 * y);
    out[1] = (float)(0.5 * x + 0.2 * y);
    out[2] = (float)(y + 0.1 * x);
    p->corners[p->count] = p->count;
    p->count += 1;
}

static stp_vec3d area(const float* positions, uint32_t a, uint32_t b, uint32_t c)
{
    stp_vec3d p[3];
    uint32_t corner[3] = {a, b, c};
    for (int i = 0; i < 3; ++i) {
        const float* q = positions + 3 * corner[i];
        p[i] = (stp_vec3d){(double)q[0], (double)q[1], (double)q[2]};
    }
    return stp_scaled(stp_crossd(stp_subd(p[1], p[0]), stp_subd(p[2], p[0])), 0.5);
}

// The triangles tile the polygon if none is flipped and their areas add up to its own.
static int tiles(stp_context* context, polygon* p)
{
    if (!stp_triangulate(context, p->positions, p->corners, p->count, p->triangles)) {
        return 0;
    }
    stp_vec3d whole = {0, 0, 0};
    for (uint32_t i = 2; i < p->count; ++i) {
        whole = stp_addd(whole, area(p->positions, 0, i - 1, i));
    }
    double sum = 0.0, size = sqrt(stp_dotd(whole, whole));
    for (uint32_t i = 0; i + 2 < p->count; ++i) {
        const uint32_t* t = p->triangles + 3 * i;
        stp_vec3d a = area(p->positions, t[0], t[1], t[2]);
        if (stp_dotd(a, whole) < -1e-9 * size * size) {
            return 0;
        }
        sum += sqrt(stp_dotd(a, a));
    }
    return fabs(sum - size) < 1e-4 * size;
}

void test_triangulate_polygons(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    polygon* p = calloc(1, sizeof(polygon));
    CHECK(p != NULL);
    for (int turned = 0; turned < 4; ++turned) { // an arrow head, with its notch at each corner in
                                                 // turn
        static const double arrow[4][2] = {{0, 0}, {2, -1}, {0, 3}, {-2, -1}};
        p->count = 0;
        for (int i = 0; i < 4; ++i) {
            put(p, arrow[(i + turned) % 4][0], arrow[(i + turned) % 4][1]);
        }
        CHECK(tiles(context, p));
    }
    for (uint32_t count = 3; count <= 40; ++count) { // convex
        p->count = 0;
        for (uint32_t i = 0; i < count; ++i) {
            put(p, cos(2.0 * STP_PI * i / count), sin(2.0 * STP_PI * i / count));
        }
        CHECK(tiles(context, p));
    }
    for (uint64_t seed = 0; seed < 60; ++seed) { // stars of random radii, both windings
        uint32_t count = 5 + stp_rng_below(seed, 0, 60);
        p->count = 0;
        for (uint32_t i = 0; i < count; ++i) {
            double angle = (seed % 2 == 0 ? 2.0 : -2.0) * STP_PI * i / count;
            double radius = 0.2 + stp_rng_below(seed, i + 1, 1000) / 500.0;
            put(p, radius * cos(angle), radius * sin(angle));
        }
        CHECK(tiles(context, p));
    }
    p->count = 0; // a comb, half of its corners concave
    for (int i = 0; i < LIMIT / 4 - 1; ++i) {
        put(p, i, 0.0);
        put(p, i + 0.25, 0.0);
        put(p, i + 0.25, 5.0);
        put(p, i + 0.75, 5.0);
    }
    put(p, LIMIT / 4 - 1, -1.0);
    put(p, 0.0, -1.0);
    CHECK(tiles(context, p));
    p->count = 0; // a square with a hole, joined by a bridge: two corners occur twice
    static const double bridge[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0},
                                         {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    for (int i = 0; i < 10; ++i) {
        put(p, bridge[i][0], bridge[i][1]);
    }
    CHECK(tiles(context, p));
    free(p);
    stp_context_destroy(context);
}

void test_triangulate_survives_nonsense(test_state* test)
{
    // self-intersecting, all at one point, on a line: any triangles are valid, but in the expected
    // number
    stp_context* context = test_context(NULL, 1, NULL);
    polygon* p = calloc(1, sizeof(polygon));
    CHECK(p != NULL);
    for (uint64_t seed = 0; seed < 50; ++seed) {
        p->count = 0;
        uint32_t count = 3 + stp_rng_below(seed, 0, 30);
        for (uint32_t i = 0; i < count; ++i) {
            put(p, seed % 3 == 0 ? 0 : stp_rng_below(seed, 2 * i + 1, 9),
                stp_rng_below(seed, 2 * i + 2, 9));
        }
        for (uint32_t i = 0; i < 3 * (count - 2); ++i) {
            p->triangles[i] = UINT32_MAX;
        }
        CHECK(stp_triangulate(context, p->positions, p->corners, count, p->triangles));
        for (uint32_t i = 0; i < 3 * (count - 2); ++i) {
            CHECK(p->triangles[i] < count);
        }
    }
    free(p);
    stp_context_destroy(context);
}
