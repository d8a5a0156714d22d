// SPDX-License-Identifier: MIT
// Progressive splats (src/lod/psp): one queue against brute force, and pieces against one queue.
#include "psp_helpers.h"

#include "base/math/rng.h"
#include "lod/psp/initial.h"
#include "lod/psp/kd_tree.h"
#include "lod/psp/metric.h"
#include "lod/psp/scale.h"

#include <stdlib.h>
#include <string.h>

enum { FEW = 220, MANY = 12000, K = 8 };

static float positions[3 * MANY], normals[3 * MANY];
static uint8_t colors[3 * MANY];

static double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

// A sphere with bumps, at random.
static stp_psp_points make_bumps(uint32_t count, uint64_t seed)
{
    for (uint32_t i = 0; i < count; ++i) {
        double p[3], square = 2.0;
        for (uint64_t n = 0; square > 1.0 || square < 0.01; ++n) {
            square = 0.0;
            for (uint64_t k = 0; k < 3; ++k) {
                p[k] = 2.0 * unit(seed, 3 * (1000 * (uint64_t)i + n) + k) - 1.0;
                square += p[k] * p[k];
            }
        }
        double away = 1.0 / sqrt(square);
        away *= 1.0 + 0.1 * sin(9.0 * p[0] * away) * sin(8.0 * p[1] * away);
        for (uint32_t k = 0; k < 3; ++k) {
            positions[3 * i + k] = (float)(away * p[k]);
            normals[3 * i + k] = (float)(p[k] / sqrt(square));
            colors[3 * i + k] = (uint8_t)stp_rng_below(seed + 1, 3 * i + k, 256);
        }
    }
    return (stp_psp_points){
        .count = count, .positions = positions, .normals = normals, .colors = colors};
}

// The greedy merge, implemented naively.
typedef struct plain {
    stp_psp_shared shared;
    const stp_psp_metric_table* metric;
    stp_psp_splat splats[FEW];
    double states[FEW + 1][STP_PSP_STATE_MAX / sizeof(double)];
    bool linked[FEW][FEW], dead[FEW];
} plain;

static float plain_error(plain* p, uint32_t a, uint32_t b)
{
    return stp_psp_pair_error(&p->shared, p->metric, &p->splats[a], p->states[a], &p->splats[b],
                              p->states[b]);
}

// Merges the linked pair with the smallest error; among equal ones, the pair with the lower keys.
// The lower one represents both.
static bool plain_merge(plain* p, uint32_t id, stp_psp_merge* made)
{
    float minimum = HUGE_VALF;
    uint32_t left = 0, right = 0;
    for (uint32_t a = 0; a < FEW; ++a) {
        for (uint32_t b = a + 1; b < FEW; ++b) {
            float error =
                p->linked[a][b] && !p->dead[a] && !p->dead[b] ? plain_error(p, a, b) : HUGE_VALF;
            if (error < minimum) {
                minimum = error;
                left = a;
                right = b;
            }
        }
    }
    if (!(minimum < HUGE_VALF)) {
        return false;
    }
    stp_psp_splat merged = {0};
    stp_psp_merge_pair(&p->shared, p->metric, &p->splats[left], p->states[left], &p->splats[right],
                       p->states[right], &merged, p->states[FEW]);
    uint32_t l = p->splats[left].id, r = p->splats[right].id;
    *made =
        (stp_psp_merge){.left = l < r ? l : r, .right = l < r ? r : l, .error = (double)minimum};
    merged.id = id;
    p->splats[left] = merged;
    memcpy(p->states[left], p->states[FEW], sizeof(p->states[left]));
    p->dead[right] = true;
    for (uint32_t i = 0; i < FEW; ++i) {
        bool linked = i != left && (p->linked[left][i] || p->linked[right][i]);
        p->linked[left][i] = p->linked[i][left] = linked;
    }
    return true;
}

static plain all; // large

static bool begin_plain(stp_context* context, const stp_psp_points* points,
                        const stp_psp_desc* desc)
{
    static stp_ellipse ellipses[FEW];
    static uint32_t near[K * FEW];
    stp_box box = stp_box_empty();
    memset(&all, 0, sizeof(all));
    if (stp_psp_make_initial(context, points, K, ellipses, near) != STP_OK) {
        return false;
    }
    for (uint32_t i = 0; i < FEW; ++i) {
        stp_box_add(&box, ellipses[i].center);
    }
    float diagonal = stp_length(stp_sub(box.max, box.min));
    float scale = stp_psp_choose_scale(diagonal);
    all.metric = stp_psp_metric_find(desc->metric);
    all.shared = (stp_psp_shared){.context = context,
                                  .points = points,
                                  .desc = *desc,
                                  .scale = scale,
                                  .minimum = 1e-9f * (scale * diagonal)};
    all.shared.middle =
        stp_scale(stp_add(stp_scale(box.min, 0.5f), stp_scale(box.max, 0.5f)), scale);
    if (all.metric->open != NULL && !all.metric->open(&all.shared)) {
        return false;
    }
    for (uint32_t i = 0; i < FEW; ++i) {
        stp_psp_splat* s = &all.splats[i];
        s->ellipse = stp_psp_scale_ellipse(&ellipses[i], 1.0f / scale);
        s->area = stp_ellipse_area(&s->ellipse);
        s->id = s->key = i;
        if (all.metric->begin != NULL) {
            all.metric->begin(&all.shared, i, s, all.states[i]);
        }
        for (uint32_t k = 0; k < K; ++k) {
            all.linked[i][near[K * i + k]] = all.linked[near[K * i + k]][i] = true;
        }
    }
    return true;
}

void test_psp_one_queue_is_greedy(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    for (int n = 0; n < 6; ++n) {
        stp_psp_points points = make_bumps(FEW, (uint64_t)n);
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_forest f;
        desc.metric = (stp_psp_metric)(n % 2);
        desc.eager = n % 3 != 0;
        if (n >= 4) { // a flat grid: all errors of many pairs are equal
            for (uint32_t i = 0; i < FEW; ++i) {
                const float at[3] = {(float)(i % 15), (float)(i / 15), 2.0f};
                memcpy(positions + 3 * i, at, sizeof(at));
            }
            points.normals = NULL;
        }
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 5, &f));
        CHECK(begin_plain(context, &points, &desc));
        double level = 0.0, unit_error = stp_psp_error_unit(all.metric->power, all.shared.scale);
        for (uint32_t m = 0; m < f.merge_count; ++m) {
            stp_psp_merge made;
            CHECK(plain_merge(&all, FEW + m, &made));
            CHECK_EQUAL(made.left, f.merges[m].left);
            CHECK_EQUAL(made.right, f.merges[m].right);
            CHECK(made.error * unit_error == f.merges[m].error);
            level = f.merges[m].error > level ? f.merges[m].error : level;
            CHECK(f.merges[m].level == level);
        }
        CHECK(f.merge_count > FEW / 2);
        if (all.metric->close != NULL) {
            all.metric->close(&all.shared);
        }
        stp_psp_forest_destroy(context, &f);
    }
    stp_context_destroy(context);
}

// Whether a cut has the same splats as decimation, in any order.
static bool same_splats(const stp_psp_forest* f, const uint32_t* cut, uint32_t count,
                        const stp_psp_splats* s)
{
    if (s->count != count) {
        return false;
    }
    uint64_t sums[2] = {0};
    for (uint32_t i = 0; i < count; ++i) {
        for (int side = 0; side < 2; ++side) {
            const stp_ellipse* e = side == 0 ? &f->ellipses[cut[i]] : &s->ellipses[i];
            const uint8_t* c = side == 0 ? f->colors + 3 * (size_t)cut[i] : s->colors + 3 * i;
            uint32_t words[11];
            memcpy(words, e, sizeof(*e));
            words[10] = (uint32_t)c[0] << 16 | (uint32_t)c[1] << 8 | c[2];
            uint64_t hash = 0;
            for (int w = 0; w < 11; ++w) {
                hash = stp_rng_hash(hash, words[w]);
            }
            sums[side] += hash;
        }
    }
    return sums[0] == sums[1];
}

// Pieces of any size: exactly as many splats as requested, the same for any number of threads and
// either queue.
void test_psp_pieces_do_not_depend_on_threads(test_state* test)
{
    static uint32_t cut[MANY];
    enum { COUNT = 3000 };
    stp_psp_points points = make_bumps(COUNT, 7);
    for (int n = 0; n < 8; ++n) {
        stp_psp_desc desc = stp_psp_desc_default();
        uint32_t target = n < 4 ? 60 : n < 6 ? 1500 : 2900;
        stp_psp_forest first = {0};
        desc.metric = (stp_psp_metric)(n % 2);
        desc.piece_size = n % 4 < 2 ? 64 : 8;
        stp_context* contexts[4];
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            stp_context* context = contexts[threads] = test_context(NULL, threads, NULL);
            stp_psp_forest f;
            stp_psp_splats left;
            desc.eager = threads != 2;
            CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, target, &f));
            CHECK_EQUAL(COUNT - target, f.merge_count);
            CHECK(psp_is_forest(&f));
            CHECK_EQUAL(target, psp_cut(&f, target, cut));
            CHECK_EQUAL(STP_OK, stp_psp_decimate(context, &points, &desc, target, &left));
            CHECK(same_splats(&f, cut, target, &left));
            stp_psp_splats_destroy(context, &left);
            if (threads == 1) {
                first = f;
                continue;
            }
            size_t splats = 2 * COUNT - target;
            CHECK(memcmp(f.merges, first.merges, f.merge_count * sizeof(*f.merges)) == 0);
            CHECK(memcmp(f.ellipses, first.ellipses, splats * sizeof(*f.ellipses)) == 0);
            CHECK(memcmp(f.colors, first.colors, 3 * splats) == 0);
            stp_psp_forest_destroy(context, &f);
        }
        stp_psp_forest_destroy(contexts[1], &first);
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            stp_context_destroy(contexts[threads]);
        }
    }
}

// Splats represent the points' surface, and each point belongs to one splat.
void test_psp_splats_keep_the_area_of_their_points(test_state* test)
{
    enum { COUNT = 900, TARGET = 40 };
    float places[3 * COUNT], areas[COUNT];
    double sum = 0.0, left_sum = 0.0;
    for (uint32_t i = 0; i < COUNT; ++i) {
        places[3 * i] = (float)(i % 30);
        places[3 * i + 1] = 0.01f * (float)(stp_rng_hash(3, i) % 100);
        places[3 * i + 2] = (float)(i / 30);
        areas[i] = 0.5f + 0.25f * (float)(i % 5);
        sum += (double)areas[i];
    }
    const stp_psp_points points = {.count = COUNT, .positions = places, .areas = areas};
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = STP_PSP_REGIONS;
    desc.piece_size = 64;
    desc.connect_components = true;
    stp_context* context = test_context(NULL, 2, NULL);
    stp_psp_splats left;
    CHECK_EQUAL(STP_OK, stp_psp_decimate(context, &points, &desc, TARGET, &left));
    CHECK_EQUAL(TARGET, left.count);
    CHECK_EQUAL(0, left.firsts[0]);
    for (uint32_t i = 0; i < TARGET; ++i) {
        left_sum += (double)left.areas[i];
        CHECK(left.areas[i] > 0.0f && left.firsts[i] < COUNT);
        CHECK(i == 0 || left.firsts[i] > left.firsts[i - 1]);
    }
    CHECK(fabs(left_sum - sum) < 1e-4 * sum);
    stp_psp_splats_destroy(context, &left);
    stp_context_destroy(context);
}

// Mean distance of points from the splats that represent them.
static double mean_distance(const stp_psp_forest* f, uint32_t count)
{
    uint32_t done = f->point_count - count;
    double sum = 0.0;
    for (uint32_t i = 0; i < f->point_count; ++i) {
        uint32_t splat = i;
        while (f->parents[splat] < done) {
            splat = f->point_count + f->parents[splat];
        }
        const stp_ellipse* e = &f->ellipses[splat];
        stp_vec3 d = stp_sub(f->ellipses[i].center, e->center);
        sum += fabs((double)stp_dot(d, e->normal));
    }
    return sum / f->point_count;
}

// Pieces give about the result of one queue, also before the last merge. If there are few merges,
// seams of small pieces count most.
void test_psp_pieces_are_as_good_as_one_queue(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_psp_points points = make_bumps(MANY, 3);
    for (int metric = 0; metric < 2; ++metric) {
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_forest one, many;
        desc.metric = (stp_psp_metric)metric;
        desc.piece_size = MANY;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 200, &one));
        desc.piece_size = 512;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 200, &many));
        CHECK(memcmp(one.merges, many.merges, one.merge_count * sizeof(*one.merges)) != 0);
        for (uint32_t count = 200; count <= 3200; count *= 4) {
            double ratio = mean_distance(&many, count) / mean_distance(&one, count);
            CHECK(ratio > 0.95 && ratio < (count < MANY / 4 ? 1.05 : 1.15));
        }
        stp_psp_forest_destroy(context, &one);
        stp_psp_forest_destroy(context, &many);
    }
    stp_context_destroy(context);
}

// Pairs of points far apart, and isolated points: with `connect_components` one splat is
// left.
void test_psp_connects_components(test_state* test)
{
    enum { COUNT = 2000 };
    stp_context* context = test_context(NULL, 2, NULL);
    for (uint32_t i = 0; i < COUNT; ++i) {
        uint32_t pair = i / 2;
        positions[3 * i] = 100.0f * (float)(pair % 10) + (float)(i % 2);
        positions[3 * i + 1] = 100.0f * (float)(pair / 10 % 10);
        positions[3 * i + 2] = 100.0f * (float)(pair / 100);
        const float n[3] = {0.0f, i % 4 < 2 ? 1.0f : -1.0f, 0.0f};
        memcpy(normals + 3 * i, n, sizeof(n));
    }
    stp_psp_points points = {
        .count = COUNT, .positions = positions, .normals = normals, .colors = NULL};
    for (int n = 0; n < 4; ++n) {
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_forest f;
        desc.metric = (stp_psp_metric)(n % 2);
        desc.neighbours = 1;
        desc.piece_size = n < 2 ? 64 : 0;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
        CHECK_EQUAL(COUNT / 2, f.merge_count);
        stp_psp_forest_destroy(context, &f);
        desc.connect_components = true;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
        CHECK_EQUAL(COUNT - 1, f.merge_count);
        CHECK(psp_is_forest(&f));
        stp_psp_forest_destroy(context, &f);
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 30, &f));
        CHECK_EQUAL(COUNT - 30, f.merge_count);
        stp_psp_forest_destroy(context, &f);
        // splats that face apart stay separate if requested
        desc.keep_angle = true;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
        CHECK(f.merge_count < COUNT - 1 && f.merge_count > COUNT / 2);
        for (uint32_t i = 0; i < f.merge_count; ++i) {
            const stp_ellipse *l = &f.ellipses[f.merges[i].left],
                              *r = &f.ellipses[f.merges[i].right];
            CHECK(stp_dot(l->normal, r->normal) >= 0.0f);
        }
        stp_psp_forest_destroy(context, &f);
    }
    stp_context_destroy(context);
}

// No to many points: at one place, on a line, far out, NaN; in pieces and in one queue.
void test_psp_pieces_take_any_points(test_state* test)
{
    static const uint32_t counts[] = {0, 1, 2, 3, 9, 400, 3000};
    stp_context* context = test_context(NULL, 2, NULL);
    for (int shape = 0; shape < 5; ++shape) {
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            for (int metric = 0; metric < 2; ++metric) {
                for (uint32_t i = 0; i < counts[c]; ++i) {
                    float x = (float)i, size = shape == 2 ? 1e30f : shape == 3 ? 1e-20f : 1.0f;
                    positions[3 * i] = shape == 0 ? 5.0f : size * x;
                    positions[3 * i + 1] = shape == 1 ? 0.0f : size * (float)(i * i % 17);
                    positions[3 * i + 2] = size;
                    normals[3 * i] = normals[3 * i + 1] = normals[3 * i + 2] =
                        shape == 4 && i % 5 == 0 ? (float)NAN : 0.0f;
                    if (shape == 4 && i % 7 == 0) {
                        positions[3 * i + i % 3] = i % 2 == 0 ? (float)NAN : HUGE_VALF;
                    }
                }
                stp_psp_points points = {
                    .count = counts[c], .positions = positions, .normals = normals, .colors = NULL};
                stp_psp_desc desc = stp_psp_desc_default();
                stp_psp_forest f;
                desc.metric = (stp_psp_metric)metric;
                desc.connect_components = true;
                desc.piece_size = 16;
                CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
                CHECK(psp_is_forest(&f));
                CHECK_EQUAL(counts[c] > 0 ? counts[c] - 1 : 0, f.merge_count);
                stp_psp_forest_destroy(context, &f);
            }
        }
    }
    stp_context_destroy(context);
}

void test_psp_pieces_survive_failing_allocator(test_state* test)
{
    stp_psp_points points = make_bumps(200, 1);
    for (int history = 0; history < 2; ++history) {
        bool made = false;
        for (int n = 1; !made && n < 4000; ++n) {
            test_heap heap = TEST_HEAP(n);
            stp_context* context = test_context(&heap, 1, NULL);
            stp_psp_desc desc = stp_psp_desc_default();
            desc.metric = (stp_psp_metric)(n % 2);
            desc.piece_size = 48;
            desc.connect_components = true;
            desc.min_cosine = 0.99f;
            if (context != NULL && history != 0) {
                stp_psp_forest f = {0};
                made = stp_psp_forest_make(context, &points, &desc, 3, &f) == STP_OK &&
                       heap.count <= n;
                stp_psp_forest_destroy(context, &f);
            } else if (context != NULL) {
                stp_psp_splats s = {0};
                made =
                    stp_psp_decimate(context, &points, &desc, 3, &s) == STP_OK && heap.count <= n;
                stp_psp_splats_destroy(context, &s);
            }
            stp_context_destroy(context);
            CHECK_EQUAL(0, heap.live_bytes);
        }
        CHECK(made);
    }
}

// Newton's method finds the same as Jacobi rotations.
void test_psp_normals_of_scatters(test_state* test)
{
    for (uint64_t seed = 0; seed < 500; ++seed) {
        double m[6] = {0}, values[3];
        double flat = seed % 4 == 0 ? 0.0 : seed % 4 == 1 ? 1e-6 : 1.0; // planes, almost planes
        double thin = seed % 3 == 0 ? 1e-7 : 1.0;                       // almost lines
        for (uint64_t i = 0; i < 9; ++i) {
            double x = unit(seed, 4 * i) - 0.5, y = thin * (unit(seed, 4 * i + 1) - 0.5);
            double z = thin * flat * (unit(seed, 4 * i + 2) - 0.5);
            double p[3] = {0.6 * x + 0.8 * y, 0.8 * x - 0.6 * y + 0.28 * z, z + 0.3 * x};
            for (int a = 0, at = 0; a < 3; ++a) {
                for (int b = a; b < 3; ++b) {
                    m[at++] += p[a] * p[b];
                }
            }
        }
        stp_vec3d turned = stp_scatter_eigenvector(m, values), found = stp_scatter_normal(m);
        CHECK(fabs(stp_dotd(found, found) - 1.0) < 1e-9);
        CHECK(fabs(stp_scatter_eigenvalue(m) - values[0]) <= 1e-9 * values[2]);
        // the quadratic form along the found direction is minimal
        const stp_vec3d rows[3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}};
        stp_vec3d applied = {stp_dotd(rows[0], found), stp_dotd(rows[1], found),
                             stp_dotd(rows[2], found)};
        CHECK(stp_dotd(applied, found) <= values[0] + 1e-9 * values[2]);
        if (values[1] > 1e-3 * values[2] && values[1] > 1.5 * values[0]) {
            CHECK(fabs(stp_dotd(turned, found)) > 1.0 - 1e-6);
        }
    }
}

void test_psp_selects_places(test_state* test)
{
    static stp_kd_point points[1000];
    for (uint64_t seed = 0; seed < 60; ++seed) {
        size_t count = 1 + stp_rng_below(seed, 0, 1000),
               place = stp_rng_below(seed, 1, (uint32_t)count);
        uint32_t kinds = seed % 3 == 0 ? 1 : seed % 3 == 1 ? 5 : 100000; // all equal, few, many
        uint64_t sum = 0;
        int axis = (int)(seed % 3);
        for (uint32_t i = 0; i < count; ++i) {
            float x = (float)stp_rng_below(seed + 100, i, kinds) - 2.0f;
            points[i] = (stp_kd_point){{x, -x, 2.0f * x}, i};
        }
        stp_kd_select(points, count, place, axis, NULL);
        for (size_t i = 0; i < count; ++i) {
            const stp_kd_point *p = &points[i], *q = &points[place];
            bool before =
                p->at[axis] < q->at[axis] || (p->at[axis] == q->at[axis] && p->index < q->index);
            CHECK(i == place || before == (i < place));
            sum += p->index;
        }
        CHECK_EQUAL((uint64_t)count * (count - 1) / 2, sum);
    }
}
