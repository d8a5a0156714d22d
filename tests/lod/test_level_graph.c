// SPDX-License-Identifier: MIT
// Levels of triangles: their mixtures have no cracks, and errors and spheres nest.
#include "tests.h"

#include "base/core/sort.h"
#include "base/math/rng.h"
#include "lod/levels/level_graph.h"

#include <math.h>
#include <string.h>

enum { AROUND = 120, ACROSS = 60, VERTICES = AROUND * ACROSS, TRIANGLES = 2 * VERTICES };

static float positions[3 * VERTICES];
static uint32_t indices[3 * TRIANGLES];

/// A closed torus of radii 1 and 0.4 with small waves.
static stp_level_source make_torus(void)
{
    for (uint32_t i = 0; i < AROUND; ++i) {
        for (uint32_t k = 0; k < ACROSS; ++k) {
            double a = 2.0 * STP_PI * i / AROUND, b = 2.0 * STP_PI * k / ACROSS;
            double thick = 0.4 + 0.01 * sin(9.0 * a) * cos(5.0 * b), wide = 1.0 + thick * cos(b);
            float* p = positions + 3 * (size_t)(i * ACROSS + k);
            p[0] = (float)(wide * cos(a));
            p[1] = (float)(thick * sin(b));
            p[2] = (float)(wide * sin(a));
            uint32_t v[4] = {i * ACROSS + k, (i + 1) % AROUND * ACROSS + k,
                             i * ACROSS + (k + 1) % ACROSS,
                             (i + 1) % AROUND * ACROSS + (k + 1) % ACROSS};
            const uint32_t two[6] = {v[0], v[2], v[1], v[1], v[2], v[3]};
            memcpy(indices + 6 * (size_t)(i * ACROSS + k), two, sizeof(two));
        }
    }
    return (stp_level_source){.vertex_count = VERTICES,
                              .triangle_count = TRIANGLES,
                              .positions = positions,
                              .indices = indices};
}

static stp_level_desc describe(void)
{
    return stp_level_defaults(3.0);
}

/// What an eye allows at a group's sphere.
static double allow(const stp_level_graph* g, uint32_t group, stp_vec3d eye, double per_distance)
{
    const stp_level_group* of = &g->groups[group];
    double distance = stp_lengthd(stp_subd(of->center, eye)) - of->radius;
    return per_distance * fmax(distance, 0.0);
}

static bool is_drawn(const stp_level_graph* g, uint32_t cluster, stp_vec3d eye, double per_distance)
{
    const stp_level_cluster* c = &g->clusters[cluster];
    double made = c->made_by != STP_LEVEL_NONE ? allow(g, c->made_by, eye, per_distance) : 0.0;
    double used = c->used_by != STP_LEVEL_NONE ? allow(g, c->used_by, eye, per_distance) : 0.0;
    return stp_level_is_drawn(g, cluster, made, used);
}

/// Whether the drawn triangles are closed: each edge is walked as often one way as the other.
static bool is_closed(const stp_level_graph* g, stp_vec3d eye, double per_distance,
                      uint32_t* triangles)
{
    static uint64_t edges[6 * TRIANGLES], scratch[6 * TRIANGLES];
    size_t count = 0;
    *triangles = 0;
    for (uint32_t i = 0; i < g->cluster_count; ++i) {
        const stp_level_cluster* c = &g->clusters[i];
        if (!is_drawn(g, i, eye, per_distance)) {
            continue;
        }
        *triangles += c->triangle_count;
        if (*triangles > TRIANGLES) {
            return false;
        }
        for (uint32_t t = c->first_triangle; t < c->first_triangle + c->triangle_count; ++t) {
            for (size_t k = 0; k < 3; ++k) {
                uint64_t a = g->indices[3 * (size_t)t + k];
                uint64_t b = g->indices[3 * (size_t)t + (k + 1) % 3];
                edges[count++] = a < b ? a << 33 | b << 1 : b << 33 | a << 1 | 1;
            }
        }
    }
    const uint64_t* sorted = stp_sort_u64(edges, scratch, count, 0, 64);
    for (size_t i = 0; i < count;) {
        int64_t balance = 0;
        uint64_t edge = sorted[i] >> 1;
        for (; i < count && sorted[i] >> 1 == edge; ++i) {
            balance += (sorted[i] & 1) != 0 ? 1 : -1;
        }
        if (balance != 0) {
            return false;
        }
    }
    return true;
}

void test_levels_have_no_cracks_in_any_mixture(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_level_source torus = make_torus();
    stp_level_desc desc = describe();
    stp_level_graph g;
    CHECK_EQUAL(STP_OK, stp_level_graph_make(context, &torus, &desc, &g));
    uint32_t least = TRIANGLES, drawn;
    CHECK(is_closed(&g, (stp_vec3d){0}, 0.0, &drawn) && drawn == TRIANGLES); // the originals
    for (uint64_t i = 0; i < 60; ++i) {
        double random[4];
        for (uint64_t k = 0; k < 4; ++k) {
            random[k] = (double)(stp_rng_hash(i, k) >> 40) / 0x1p24;
        }
        double far = 2.0 + 40.0 * random[3];
        stp_vec3d eye = {far * (random[0] - 0.5), far * (random[1] - 0.5), far * (random[2] - 0.5)};
        CHECK(is_closed(&g, eye, pow(10.0, -4.0 + 2.5 * (double)i / 60.0), &drawn));
        least = drawn < least ? drawn : least;
    }
    CHECK(least < TRIANGLES / 50);
    stp_level_graph_destroy(context, &g);
    stp_context_destroy(context);
}

void test_levels_nest(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_level_source torus = make_torus();
    stp_level_desc desc = describe();
    stp_level_graph g;
    CHECK_EQUAL(STP_OK, stp_level_graph_make(context, &torus, &desc, &g));
    uint32_t next = 0;
    static uint8_t seen[TRIANGLES];
    for (uint32_t i = 0; i < g.cluster_count; ++i) {
        const stp_level_cluster* c = &g.clusters[i];
        CHECK(c->first_triangle == next && c->triangle_count > 0 &&
              c->triangle_count <= STP_LEVEL_CLUSTER);
        next += c->triangle_count;
        if (c->made_by == STP_LEVEL_NONE) { // the originals, each once
            for (uint32_t t = c->first_triangle; t < next; ++t) {
                CHECK(g.tags[t] < TRIANGLES && seen[g.tags[t]] == 0);
                seen[g.tags[t]] = 1;
            }
        } else if (c->used_by != STP_LEVEL_NONE) {
            const stp_level_group *low = &g.groups[c->made_by], *high = &g.groups[c->used_by];
            CHECK(high->error > low->error && high->level > low->level);
            CHECK(stp_lengthd(stp_subd(low->center, high->center)) + low->radius <=
                  high->radius * (1.0 + 1e-9));
        }
    }
    CHECK_EQUAL(next, g.triangle_count);
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
        CHECK_EQUAL(1, seen[t]);
    }
    // what is drawn lies near the torus
    for (double allowed = 0.002; allowed < 0.1; allowed *= 2.0) {
        for (uint32_t i = 0; i < g.cluster_count; ++i) {
            const stp_level_cluster* c = &g.clusters[i];
            for (uint32_t k = 0;
                 k < 3 * c->triangle_count && stp_level_is_drawn(&g, i, allowed, allowed); ++k) {
                const float* p =
                    g.positions + 3 * (size_t)g.indices[3 * (size_t)c->first_triangle + k];
                float around = sqrtf(p[0] * p[0] + p[2] * p[2]) - 1.0f;
                double away = fabs((double)sqrtf(around * around + p[1] * p[1]) - 0.4);
                CHECK(away < 0.0101 + 3.0 * allowed);
            }
        }
    }
    stp_level_graph_destroy(context, &g);
    stp_context_destroy(context);
}

void test_levels_do_not_depend_on_threads(test_state* test)
{
    stp_level_graph graphs[2];
    stp_context* contexts[2];
    stp_level_source torus = make_torus();
    stp_level_desc desc = describe();
    for (uint32_t i = 0; i < 2; ++i) {
        contexts[i] = test_context(NULL, 1 + 2 * i, NULL);
        CHECK_EQUAL(STP_OK, stp_level_graph_make(contexts[i], &torus, &desc, &graphs[i]));
    }
    const stp_level_graph *a = &graphs[0], *b = &graphs[1];
    CHECK(a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
          a->cluster_count == b->cluster_count && a->group_count == b->group_count);
    CHECK(memcmp(a->positions, b->positions, 3 * sizeof(float) * a->vertex_count) == 0);
    CHECK(memcmp(a->indices, b->indices, 3 * sizeof(uint32_t) * a->triangle_count) == 0);
    CHECK(memcmp(a->tags, b->tags, sizeof(uint32_t) * a->triangle_count) == 0);
    CHECK(memcmp(a->clusters, b->clusters, sizeof(*a->clusters) * a->cluster_count) == 0);
    for (uint32_t i = 0; i < a->group_count; ++i) {
        CHECK(a->groups[i].error == b->groups[i].error);
    }
    for (int i = 0; i < 2; ++i) {
        stp_level_graph_destroy(contexts[i], &graphs[i]);
        stp_context_destroy(contexts[i]);
    }
}

void test_levels_take_nothing_and_survive_failing_allocator(test_state* test)
{
    stp_level_desc desc = describe();
    stp_level_source torus = make_torus(), small = torus;
    stp_level_graph g;
    stp_context* plain = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, stp_level_graph_make(plain, &(stp_level_source){0}, &desc, &g));
    CHECK_EQUAL(0, g.cluster_count);
    stp_level_graph_destroy(plain, &g);
    stp_context_destroy(plain);
    small.triangle_count = 1200;
    bool made = false;
    for (int n = 1; !made && n < 5000; n += n < 40 ? 1 : 17) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_result result = stp_level_graph_make(context, &small, &desc, &g);
            made = result == STP_OK && heap.count <= n;
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            stp_level_graph_destroy(context, &g);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
