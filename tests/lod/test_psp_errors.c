// SPDX-License-Identifier: MIT
// Errors of merges (src/lod/psp/metric*.c) against formulas (1) and (2) of Wu, Zhang, Kobbelt 2005:
// values computed by hand, and the formulas written again, over ellipses and lists of points.
#include "psp_helpers.h"

#include "base/math/rng.h"
#include "lod/psp/metric.h"

#include <string.h>

enum { CLOUD = 300 };

static const double pi = 3.14159265358979323846;

static double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

/// |a - b| is at most `share` of |b|.
static bool is_near(double a, double b, double share)
{
    return fabs(a - b) <= share * fabs(b);
}

static double length_between(stp_vec3 a, stp_vec3 b)
{
    double x = (double)a.x - (double)b.x, y = (double)a.y - (double)b.y,
           z = (double)a.z - (double)b.z;
    return sqrt(x * x + y * y + z * z);
}

/// Formula (2): length of the edge x both areas x squared difference of the normals.
static double formula_2(const stp_ellipse* l, const stp_ellipse* r)
{
    static const stp_vec3 zero = {0};
    double left = pi * length_between(l->major, zero) * (double)l->minor;
    double right = pi * length_between(r->major, zero) * (double)r->minor;
    double turn = length_between(l->normal, r->normal);
    return length_between(l->center, r->center) * left * right * turn * turn;
}

/// The sum in formula (1) for the plane that makes it smallest: the smallest root of the
/// characteristic polynomial of the points' scatter, in closed form.
static double sum_squares(double (*points)[3], uint32_t count)
{
    double mean[3] = {0}, m[3][3] = {{0}};
    for (uint32_t i = 0; i < count; ++i) {
        for (int a = 0; a < 3; ++a) {
            mean[a] += points[i][a] / count;
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) {
                m[a][b] += (points[i][a] - mean[a]) * (points[i][b] - mean[b]);
            }
        }
    }
    double third = (m[0][0] + m[1][1] + m[2][2]) / 3.0, squares = 0.0;
    for (int a = 0; a < 3; ++a) {
        m[a][a] -= third;
        for (int b = 0; b < 3; ++b) {
            squares += m[a][b] * m[a][b];
        }
    }
    // as squares include those of the shifted diagonal, the three roots lie within 2 `spread`
    double spread = sqrt(squares / 6.0);
    if (spread == 0.0) {
        return third;
    }
    double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    double cosine = fmax(-1.0, fmin(1.0, determinant / (2.0 * spread * spread * spread)));
    double least = third + 2.0 * spread * cos(acos(cosine) / 3.0 + 2.0 * pi / 3.0);
    return fmax(least, 0.0);
}

/// Splats that a test merges one by one.
typedef struct bench {
    stp_psp_points points;
    stp_psp_shared shared;
    const stp_psp_metric_table* metric;
    double states[16][STP_PSP_STATE_MAX / sizeof(double)];
    stp_psp_splat splats[16];
    uint32_t count;
} bench;

/// Without points for STP_PSP_NORMALS. False if out of memory.
static bool begin_bench(bench* b, stp_context* context, stp_psp_metric metric,
                        const float* positions, uint32_t count)
{
    *b = (bench){.points = {.count = count, .positions = positions},
                 .shared = {.context = context,
                            .desc = stp_psp_desc_default(),
                            .scale = 1.0f,
                            .minimum = 1e-6f},
                 .metric = stp_psp_metric_find(metric)};
    b->shared.points = &b->points;
    return b->metric->open == NULL || b->metric->open(&b->shared);
}

static void end_bench(bench* b)
{
    if (b->metric->close != NULL) {
        b->metric->close(&b->shared);
    }
}

/// Adds an ellipse with half axes `major` (a vector in its plane) and `minor`; returns its number.
static uint32_t add_ellipse(bench* b, stp_vec3 center, stp_vec3 normal, stp_vec3 major, float minor)
{
    uint32_t at = b->count++;
    stp_psp_splat* s = &b->splats[at];
    *s = (stp_psp_splat){.ellipse = {center, normal, major, minor}, .key = at};
    s->area = stp_ellipse_area(&s->ellipse);
    if (b->metric->begin != NULL) {
        b->metric->begin(&b->shared, at, s, b->states[at]);
    }
    return at;
}

static uint32_t merge_two(bench* b, uint32_t left, uint32_t right)
{
    uint32_t at = b->count++;
    stp_psp_merge_pair(&b->shared, b->metric, &b->splats[left], b->states[left], &b->splats[right],
                       b->states[right], &b->splats[at], b->states[at]);
    return at;
}

static double error_of(const bench* b, uint32_t left, uint32_t right)
{
    return (double)stp_psp_pair_error(&b->shared, b->metric, &b->splats[left], b->states[left],
                                      &b->splats[right], b->states[right]);
}

// Disks of radius 2 and 1, centres 5 apart (3, 4, 0). Their normals (0, 0, 1) and (0.6, 0, 0.8)
// differ by (-0.6, 0, 0.2), squared 0.4. So (2) is 5 x 4 pi x pi x 0.4 = 8 pi^2.
//
// Ellipses with half axes 3 and 1, 2 and 0.5, so areas 3 pi and pi, centres 7 apart (2, 3, 6). Their
// normals (0, 0, 1) and (0, 0.8, 0.6) differ by (0, -0.8, 0.4), squared 0.8. So (2) is 7 x 3 pi x
// pi x 0.8 = 16.8 pi^2.
void test_psp_normals_error_is_formula_2(test_state* test)
{
    bench b;
    CHECK(begin_bench(&b, NULL, STP_PSP_NORMALS, NULL, 0));
    (void)add_ellipse(&b, (stp_vec3){0, 0, 0}, (stp_vec3){0, 0, 1}, (stp_vec3){2, 0, 0}, 2.0f);
    (void)add_ellipse(&b, (stp_vec3){3, 4, 0}, (stp_vec3){0.6f, 0, 0.8f}, (stp_vec3){0, 1, 0},
                      1.0f);
    CHECK(is_near(error_of(&b, 0, 1), 8.0 * pi * pi, 1e-6));
    CHECK(is_near(formula_2(&b.splats[0].ellipse, &b.splats[1].ellipse), 8.0 * pi * pi, 1e-6));
    CHECK(error_of(&b, 0, 1) == error_of(&b, 1, 0));
    (void)add_ellipse(&b, (stp_vec3){1, 1, 1}, (stp_vec3){0, 0, 1}, (stp_vec3){0, 3, 0}, 1.0f);
    (void)add_ellipse(&b, (stp_vec3){3, 4, 7}, (stp_vec3){0, 0.8f, 0.6f}, (stp_vec3){2, 0, 0},
                      0.5f);
    CHECK(is_near(error_of(&b, 2, 3), 16.8 * pi * pi, 1e-6));
    CHECK(is_near(formula_2(&b.splats[2].ellipse, &b.splats[3].ellipse), 16.8 * pi * pi, 1e-6));
    end_bench(&b);
}

// Two pairs of concentric disks of one normal: the larger covers the smaller, so the merged splat
// is the larger disk. With radius 2 and 1, at the places and with the normals of the test before,
// (2) is again 8 pi^2.
//
// Two pairs of unit disks, each with centres (-1, 0) and (1, 0) in its plane. The ellipse x^2 p +
// y^2 q = 1 around the samples of both boundaries passes through (1, 1) and (1 + sqrt(1/2),
// sqrt(1/2)), so p = (sqrt 2 - 1) / 2 and q = (3 - sqrt 2) / 2, area pi / sqrt(p q) = 2.46774 pi.
// Centres 5 apart and normals as before: (2) is 5 x (2.46774 pi)^2 x 0.4 = 12.17947 pi^2. The
// smallest ellipse is approximated: areas are up to 5 % above it.
void test_psp_normals_error_of_merged_splats(test_state* test)
{
    bench b;
    CHECK(begin_bench(&b, NULL, STP_PSP_NORMALS, NULL, 0));
    const stp_vec3 up = {0, 0, 1}, tilted = {0.6f, 0, 0.8f}, away = {3, 4, 0};
    for (int k = 0; k < 2; ++k) {
        float radius = k == 0 ? 2.0f : 1.0f;
        stp_vec3 center = k == 0 ? (stp_vec3){0} : away, normal = k == 0 ? up : tilted;
        (void)add_ellipse(&b, center, normal, (stp_vec3){0, radius, 0}, radius);
        (void)add_ellipse(&b, center, normal, (stp_vec3){0, 0.5f * radius, 0}, 0.5f * radius);
        (void)merge_two(&b, b.count - 2, b.count - 1);
    }
    CHECK(is_near((double)b.splats[2].area, 4.0 * pi, 1e-4));
    CHECK(is_near((double)b.splats[5].area, pi, 1e-4));
    CHECK(is_near(error_of(&b, 2, 5), 8.0 * pi * pi, 3e-4));
    CHECK(is_near(error_of(&b, 2, 5), formula_2(&b.splats[2].ellipse, &b.splats[5].ellipse), 1e-5));
    b.count = 0;
    for (int k = 0; k < 2; ++k) {
        stp_vec3 center = k == 0 ? (stp_vec3){0} : away, normal = k == 0 ? up : tilted;
        for (float side = -1.0f; side < 2.0f; side += 2.0f) {
            (void)add_ellipse(&b, stp_add(center, (stp_vec3){0, side, 0}), normal,
                              (stp_vec3){0, 1, 0}, 1.0f);
        }
        (void)merge_two(&b, b.count - 2, b.count - 1);
    }
    double error = error_of(&b, 2, 5), by_hand = 12.17947 * pi * pi;
    CHECK(error >= by_hand * (1.0 - 1e-5) && error <= by_hand * 1.05 * 1.05);
    CHECK(is_near(error, formula_2(&b.splats[2].ellipse, &b.splats[5].ellipse), 1e-5));
    end_bench(&b);
}

// Two pairs of points: (-3, 1, h), (-3, -1, -h) and (3, 1, -h), (3, -1, h), h = 1/2. Their mean is
// 0; sums of squares are 36, 4 and 4 h^2, sums of products 0. So z = 0 is the plane of the least sum
// of squared distances, 4 h^2 = 1. The pairs' splats are 6 apart: (1) is 6 x 1 = 6.
//
// The same points, 10 farther along y: eight points with sums of squares 72, 208 and 8 h^2 about
// their mean, and sums of products 0. The two saddles are 10 apart: (1) is 10 x 2 = 20.
//
// Any two points lie on planes, and so do any three: their (1) is 0.
void test_psp_distances_error_is_formula_1(test_state* test)
{
    static const float positions[8 * 3] = {-3, 1,  0.5f, -3, -1, -0.5f, 3, 1,  -0.5f, 3, -1, 0.5f,
                                           -3, 11, 0.5f, -3, 9,  -0.5f, 3, 11, -0.5f, 3, 9,  0.5f};
    double points[8][3];
    for (uint32_t i = 0; i < 24; ++i) {
        points[i / 3][i % 3] = (double)positions[i];
    }
    stp_context* context = test_context(NULL, 1, NULL);
    bench b;
    CHECK(begin_bench(&b, context, STP_PSP_DISTANCES, positions, 8));
    for (uint32_t i = 0; i < 8; ++i) {
        const float* p = positions + 3 * (size_t)i;
        (void)add_ellipse(&b, (stp_vec3){p[0], p[1], p[2]}, (stp_vec3){0, 0, 1},
                          (stp_vec3){1, 0, 0}, 1.0f);
    }
    CHECK(error_of(&b, 0, 1) < 1e-6 && error_of(&b, 0, 6) < 1e-6); // two disks
    for (uint32_t i = 0; i < 8; i += 2) {
        (void)merge_two(&b, i, i + 1);
    }
    CHECK(error_of(&b, 8, 2) < 1e-6); // three points
    CHECK(is_near(error_of(&b, 8, 9), 6.0, 1e-6));
    CHECK(is_near(error_of(&b, 11, 10), 6.0, 1e-6));
    CHECK(is_near(6.0 * sum_squares(points, 4), 6.0, 1e-9));
    uint32_t near = merge_two(&b, 8, 9), far = merge_two(&b, 10, 11);
    CHECK(is_near(error_of(&b, near, far), 20.0, 1e-6));
    CHECK(is_near(10.0 * sum_squares(points, 8), 20.0, 1e-9));
    end_bench(&b);
    stp_context_destroy(context);
}

static float cloud[3 * CLOUD];

/// Points of a wavy sheet.
static stp_psp_points make_sheet(uint64_t seed)
{
    for (uint32_t i = 0; i < CLOUD; ++i) {
        double x = 3.0 * unit(seed, 2 * i), y = 3.0 * unit(seed, 2 * i + 1);
        const float at[3] = {(float)x, (float)y, (float)(0.4 * sin(2.0 * x) * cos(3.0 * y))};
        memcpy(cloud + 3 * (size_t)i, at, sizeof(at));
    }
    return (stp_psp_points){.count = CLOUD, .positions = cloud};
}

/// Lists the points of a splat of a forest. @return their number, after the first `count`
static uint32_t list_points(const stp_psp_forest* f, uint32_t splat, double (*points)[3],
                            uint32_t count)
{
    if (splat >= f->point_count) {
        const stp_psp_merge* m = &f->merges[splat - f->point_count];
        return list_points(f, m->right, points, list_points(f, m->left, points, count));
    }
    for (uint32_t a = 0; a < 3; ++a) {
        points[count][a] = (double)cloud[3 * splat + a];
    }
    return count + 1;
}

// Every merge of a cloud has the error of the formula in model units, whatever the scale; the
// constants that make planes merge evenly (progressive-splatting.md) are added.
void test_psp_forests_record_the_formulas(test_state* test)
{
    static double points[CLOUD][3];
    for (int k = 0; k < 2; ++k) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_psp_points from = make_sheet((uint64_t)k + 3);
        stp_psp_desc desc = stp_psp_desc_default();
        desc.metric = k == 0 ? STP_PSP_NORMALS : STP_PSP_DISTANCES;
        desc.two_sided = true;
        stp_psp_forest f;
        CHECK_EQUAL(STP_OK, stp_psp_forest_make(context, &from, &desc, 10, &f));
        CHECK_EQUAL(CLOUD - 10, f.merge_count);
        for (uint32_t i = 0; i < f.merge_count; ++i) {
            stp_ellipse l = f.ellipses[f.merges[i].left], r = f.ellipses[f.merges[i].right];
            double length = length_between(l.center, r.center), expected, flat;
            double areas = (double)stp_ellipse_area(&l) * (double)stp_ellipse_area(&r);
            if (k == 0) {
                // normals of points without normals have either sign: the merge turns one
                r.normal = stp_scale(r.normal, stp_dot(l.normal, r.normal) < 0.0f ? -1.0f : 1.0f);
                expected = formula_2(&l, &r);
                flat = 1e-9 * length * areas; // differences of single-precision normals
            } else {
                uint32_t count = list_points(&f, f.merges[i].left, points, 0);
                count = list_points(&f, f.merges[i].right, points, count);
                expected = length * sum_squares(points, count);
                flat = 1.1e-8 * length * sqrt(areas);
            }
            CHECK(fabs(f.merges[i].error - expected) <= 1e-4 * expected + flat);
        }
        stp_psp_forest_destroy(context, &f);
        stp_context_destroy(context);
    }
}
