// SPDX-License-Identifier: MIT
// Progressive splats (src/lod/psp): neighbours and ellipses against brute force, forests, merge
// order.
#include "psp_helpers.h"

#include "base/math/rng.h"
#include "lod/psp/initial.h"
#include "lod/psp/kd_tree.h"

#include <stdlib.h>
#include <string.h>

enum { POINTS = 2000, K = 8 };

static float positions[3 * POINTS], normals[3 * POINTS], areas[POINTS];
static uint8_t colors[3 * POINTS];

static double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

// Points on a sphere of radius 1 along a spiral, half of them red.
static stp_psp_points make_sphere(void)
{
    for (uint32_t i = 0; i < POINTS; ++i) {
        double y = 1.0 - 2.0 * ((double)i + 0.5) / POINTS, around = 2.399963229728653 * i;
        double across = sqrt(1.0 - y * y);
        const float at[3] = {(float)(across * cos(around)), (float)y,
                             (float)(across * sin(around))};
        memcpy(positions + 3 * i, at, sizeof(at));
        memcpy(normals + 3 * i, at, sizeof(at));
        areas[i] = 12.566f / POINTS;
        colors[3 * i] = 255;
        colors[3 * i + 1] = colors[3 * i + 2] = at[0] > 0.0f ? 0 : 255;
    }
    return (stp_psp_points){.count = POINTS,
                            .positions = positions,
                            .normals = normals,
                            .colors = colors,
                            .areas = areas};
}

static void make_random(uint64_t seed)
{
    for (uint32_t i = 0; i < 3 * POINTS; ++i) { // some coincide
        positions[i] = (float)(floor(unit(seed, i / 6 * 3 + i % 3) * 64.0) / 64.0);
    }
}

void test_psp_finds_nearest_points(test_state* test)
{
    static uint32_t near[K * POINTS];
    for (uint32_t threads = 1; threads < 4; threads += 2) {
        stp_context* context = test_context(NULL, threads, NULL);
        make_random(threads);
        CHECK_EQUAL(STP_OK, stp_find_nearest_points(context, positions, POINTS, K, near));
        for (uint32_t i = 0; i < POINTS; i += 7) {
            float last = -1.0f;
            uint32_t before = 0, closer = 0, as_near = 0;
            for (uint32_t k = 0; k < K; ++k) {
                uint32_t n = near[K * i + k];
                CHECK(n < POINTS && n != i);
                float d = 0.0f;
                for (int c = 0; c < 3; ++c) {
                    float x = positions[3 * n + (uint32_t)c] - positions[3 * i + (uint32_t)c];
                    d += x * x;
                }
                CHECK(d > last || (d == last && n > before));
                last = d;
                before = n;
            }
            for (uint32_t n = 0; n < POINTS; ++n) {
                float d = 0.0f;
                for (int c = 0; c < 3; ++c) {
                    float x = positions[3 * n + (uint32_t)c] - positions[3 * i + (uint32_t)c];
                    d += x * x;
                }
                closer += n != i && d < last ? 1 : 0;
                as_near += n != i && d == last ? 1 : 0;
            }
            CHECK(closer < K &&
                  closer + as_near >= K); // among equally near ones, any may be listed
        }
        stp_context_destroy(context);
    }
    // fewer than requested
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, stp_find_nearest_points(context, positions, 3, K, near));
    CHECK(near[0] != UINT32_MAX && near[1] != UINT32_MAX && near[2] == UINT32_MAX);
    stp_context_destroy(context);
}

/// Lower bound on the area of ellipses around points of a plane: the ellipse whose scatter matrix
/// has the largest determinant over all point weights.
static float bound_area(const stp_vec3* points, uint32_t count, stp_vec3 x, stp_vec3 y)
{
    double u[16], v[16], weight[16], det = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        u[i] = (double)stp_dot(points[i], x);
        v[i] = (double)stp_dot(points[i], y);
        weight[i] = 1.0 / count;
    }
    for (int round = 0; round < 2000; ++round) {
        double mu = 0.0, mv = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;
        for (uint32_t i = 0; i < count; ++i) {
            mu += weight[i] * u[i];
            mv += weight[i] * v[i];
        }
        for (uint32_t i = 0; i < count; ++i) {
            uu += weight[i] * (u[i] - mu) * (u[i] - mu);
            uv += weight[i] * (u[i] - mu) * (v[i] - mv);
            vv += weight[i] * (v[i] - mv) * (v[i] - mv);
        }
        det = uu * vv - uv * uv;
        for (uint32_t i = 0; i < count; ++i) {
            double a = u[i] - mu, b = v[i] - mv;
            weight[i] *= (vv * a * a - 2.0 * uv * a * b + uu * b * b) / (2.0 * det);
        }
    }
    return (float)(2.0 * 3.14159265358979 * sqrt(det));
}

/// The ellipse around two others has almost minimal area.
void test_psp_ellipses_are_small(test_state* test)
{
    for (uint64_t seed = 0; seed < 300; ++seed) {
        stp_vec3 n = {0, 0, 1}, points[16];
        stp_ellipse pair[2];
        for (uint64_t i = 0; i < 2; ++i) {
            float angle = 6.2831853f * (float)unit(seed, 8 * i),
                  major = 0.2f + (float)unit(seed, 8 * i + 1);
            pair[i] = (stp_ellipse){
                .center = {(float)unit(seed, 8 * i + 2), (float)unit(seed, 8 * i + 3), 0},
                .normal = n,
                .major = {major * cosf(angle), major * sinf(angle), 0},
                .minor = major * (0.1f + 0.9f * (float)unit(seed, 8 * i + 4))};
            stp_ellipse_sample(&pair[i], points + 8 * i);
        }
        stp_ellipse e = stp_ellipse_cover(pair[seed % 2].center, n, points, 16, 1e-6f);
        float ratio =
            stp_ellipse_area(&e) / bound_area(points, 16, (stp_vec3){1, 0, 0}, (stp_vec3){0, 1, 0});
        CHECK(ratio > 0.999f && ratio < 1.12f);
    }
}

void test_psp_ellipses_cover(test_state* test)
{
    for (uint64_t seed = 0; seed < 200; ++seed) {
        stp_vec3 points[16], n = stp_normalize((stp_vec3){(float)unit(seed, 100) - 0.5f,
                                                          (float)unit(seed, 101) - 0.5f,
                                                          (float)unit(seed, 102) + 0.01f});
        float stretch = seed % 3 == 0 ? 0.0f : 1.0f; // or all in a line
        for (uint32_t i = 0; i < 16; ++i) {
            points[i] = (stp_vec3){(float)unit(seed, 3 * i), stretch * (float)unit(seed, 3 * i + 1),
                                   stretch * (float)unit(seed, 3 * i + 2)};
        }
        stp_vec3 center = {0.5f, 0.5f * stretch, 0.5f * stretch};
        stp_ellipse e = stp_ellipse_cover(center, n, points, 16, 1e-6f);
        float length = stp_length(e.major), maximum = 0.0f;
        CHECK(e.minor > 0.0f && e.minor <= length * 1.0001f && fabsf(stp_dot(e.major, n)) < 1e-5f);
        stp_vec3 x = stp_scale(e.major, 1.0f / length), y = stp_cross(n, x);
        for (uint32_t i = 0; i < 16; ++i) {
            stp_vec3 d = stp_sub(points[i], e.center);
            float u = stp_dot(d, x) / length, v = stp_dot(d, y) / e.minor;
            CHECK(u * u + v * v <= 1.0005f);
            maximum = fmaxf(maximum, u * u + v * v);
        }
        CHECK(maximum > 0.999f); // one lies on the boundary
        stp_vec3 samples[STP_ELLIPSE_SAMPLES];
        stp_ellipse_sample(&e, samples);
        for (int i = 0; i < STP_ELLIPSE_SAMPLES; ++i) {
            stp_vec3 d = stp_sub(samples[i], e.center);
            float u = stp_dot(d, x) / length, v = stp_dot(d, y) / e.minor;
            CHECK(fabsf(u * u + v * v - 1.0f) < 1e-3f && fabsf(stp_dot(d, n)) < 1e-5f);
        }
        float area = stp_ellipse_area(&e) / (3.14159265f * length * e.minor);
        CHECK(fabsf(area - 1.0f) < 1e-5f);
    }
    // the eigenvector of the smallest eigenvalue
    for (uint64_t seed = 0; seed < 200; ++seed) {
        double m[6], values[3];
        for (uint64_t i = 0; i < 6; ++i) {
            m[i] = unit(seed + 1000, i) - 0.3;
        }
        stp_vec3d v = stp_scatter_eigenvector(m, values);
        double value = values[0];
        CHECK(values[0] <= values[1] && values[1] <= values[2]);
        const double applied[3] = {m[0] * v.x + m[1] * v.y + m[2] * v.z,
                                   m[1] * v.x + m[3] * v.y + m[4] * v.z,
                                   m[2] * v.x + m[4] * v.y + m[5] * v.z};
        CHECK(fabs(applied[0] - value * v.x) + fabs(applied[1] - value * v.y) +
                  fabs(applied[2] - value * v.z) <
              1e-9);
        CHECK(fabs(v.x * v.x + v.y * v.y + v.z * v.z - 1.0) < 1e-9);
        CHECK(fabs(values[0] + values[1] + values[2] - m[0] - m[3] - m[5]) < 1e-9);
    }
}

static int compare_numbers(const void* a, const void* b)
{
    uint32_t x = *(const uint32_t*)a, y = *(const uint32_t*)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

void test_psp_merges_a_sphere(test_state* test)
{
    static uint32_t cut[POINTS], other[POINTS];
    stp_psp_points points = make_sphere();
    stp_context* context = test_context(NULL, 2, NULL);
    for (int metric = 0; metric < 3; ++metric) {
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_forest f, eager;
        desc.metric = (stp_psp_metric)metric;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 60, &f));
        CHECK(f.merge_count == POINTS - 60 && psp_is_forest(&f));
        // the order of removal from the queue has no effect
        desc.eager = !desc.eager;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 60, &eager));
        CHECK(memcmp(f.merges, eager.merges, f.merge_count * sizeof(*f.merges)) == 0);
        CHECK(memcmp(f.ellipses, eager.ellipses, sizeof(*f.ellipses) * (2 * POINTS - 60)) == 0);
        // any number of splats shows the sphere: near its surface, facing outwards, about its area,
        // half red
        for (uint32_t count = 60; count <= POINTS;
             count = count * 2 < POINTS ? count * 2 : POINTS) {
            double area = 0.0, red = 0.0;
            CHECK_EQUAL(count, psp_cut(&f, count, cut));
            for (uint32_t i = 0; i < count; ++i) {
                const stp_ellipse* e = &f.ellipses[cut[i]];
                float away = stp_length(e->center), own = stp_ellipse_area(e);
                CHECK(away > 0.7f && away < 1.1f);
                CHECK(stp_dot(e->normal, e->center) > 0.6f * away);
                area += (double)own;
                red += f.colors[3 * cut[i] + 1] < 128 ? (double)own : 0.0;
            }
            double ratio = area / (4.0 * 3.14159265358979);
            CHECK(ratio > (metric == 0 ? 1.0 : 0.2) &&
                  ratio < 10.0); // with metric `distances`, splats end at points
            CHECK(red > 0.4 * area && red < 0.6 * area);
            if (count == POINTS) {
                break;
            }
        }
        // each point belongs to one splat of a cut
        CHECK_EQUAL(500, psp_cut(&f, 500, cut));
        uint32_t seen = 0;
        for (uint32_t p = 0; p < POINTS; ++p) {
            uint32_t s = p;
            while (f.parents[s] < POINTS - 500) {
                s = POINTS + f.parents[s];
            }
            seen += bsearch(&s, cut, 500, sizeof(s), compare_numbers) != NULL ? 1 : 0;
        }
        CHECK_EQUAL(POINTS, seen);
        CHECK_EQUAL(60, psp_cut(&f, 2, other)); // there are no fewer
        stp_psp_forest_destroy(context, &f);
        stp_psp_forest_destroy(context, &eager);
    }
    stp_context_destroy(context);
}

// Two close sheets with opposite normals: never merged with a limit of 90 degrees, merged without a
// limit.
void test_psp_keeps_sides_apart(test_state* test)
{
    enum { SIDE = 20 };
    for (uint32_t i = 0; i < 2 * SIDE * SIDE; ++i) {
        float up = i < SIDE * SIDE ? 1.0f : -1.0f;
        const float at[3] = {(float)(i % SIDE), 0.1f * up, (float)(i / SIDE % SIDE)};
        const float n[3] = {0.0f, up, 0.0f};
        memcpy(positions + 3 * i, at, sizeof(at));
        memcpy(normals + 3 * i, n, sizeof(n));
    }
    stp_psp_points points = {.count = 2 * SIDE * SIDE, .positions = positions, .normals = normals};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_psp_desc desc = stp_psp_desc_default();
    stp_psp_forest f;
    CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 2, &f));
    for (uint32_t i = 0; i < f.merge_count; ++i) {
        const stp_ellipse *l = &f.ellipses[f.merges[i].left], *r = &f.ellipses[f.merges[i].right];
        CHECK(stp_dot(l->normal, r->normal) >= 0.0f);
    }
    CHECK(f.merge_count == 2 * SIDE * SIDE - 2);
    stp_psp_forest_destroy(context, &f);
    desc.min_cosine = -1.0f;
    CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
    CHECK_EQUAL(2 * SIDE * SIDE - 1, f.merge_count);
    stp_psp_forest_destroy(context, &f);
    stp_context_destroy(context);
}

// No points, one, two, many at one place, many on a line.
void test_psp_takes_any_points(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    static const uint32_t counts[] = {0, 1, 2, 3, 100, 1000};
    for (int shape = 0; shape < 3; ++shape) {
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            for (int metric = 0; metric < 3; ++metric) {
                for (uint32_t i = 0; i < counts[c]; ++i) {
                    positions[3 * i] = shape == 0 ? 5.0f : (float)i;
                    positions[3 * i + 1] = shape == 2 ? (float)(i * i % 17) : 0.0f;
                    positions[3 * i + 2] = 1.0f;
                    areas[i] = 1.0f;
                }
                stp_psp_points points = {
                    .count = counts[c], .positions = positions, .areas = areas};
                stp_psp_desc desc = stp_psp_desc_default();
                stp_psp_forest f;
                desc.metric = (stp_psp_metric)metric;
                desc.connect_components = metric == STP_PSP_REGIONS;
                CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &points, &desc, 1, &f));
                CHECK(psp_is_forest(&f));
                CHECK(!desc.connect_components || counts[c] == 0 || f.merge_count == counts[c] - 1);
                for (uint32_t i = 0; i < counts[c] + f.merge_count; ++i) {
                    const stp_ellipse* e = &f.ellipses[i];
                    CHECK(isfinite(e->center.x) && isfinite(e->minor) && e->minor > 0.0f);
                    CHECK(isfinite(stp_length(e->major)) &&
                          fabsf(stp_length(e->normal) - 1.0f) < 1e-3f);
                }
                stp_psp_forest_destroy(context, &f);
            }
        }
    }
    stp_context_destroy(context);
}

void test_psp_survives_failing_allocator(test_state* test)
{
    stp_psp_points points = make_sphere();
    points.count = 300;
    bool made = false;
    for (int n = 1; !made && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_psp_desc desc = stp_psp_desc_default();
        stp_psp_forest f = {0};
        desc.metric = STP_PSP_DISTANCES;
        if (context != NULL) {
            made =
                stp_psp_forest_make(context, &points, &desc, 10, &f) == STP_OK && heap.count <= n;
            stp_psp_forest_destroy(context, &f);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
