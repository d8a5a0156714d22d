// SPDX-License-Identifier: MIT
// Radii of points: they reach to the corners of Voronoi cells, close the gaps between the rings of
// a scanner and of a thinned grid, and leave borders where they are.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/prefix_table.h"
#include "lod/blue/blue.h"
#include "lod/blue/growths.h"
#include "lod/grid.h"
#include "lod/set_columns.h"
#include "scene/scene.h"

#include <string.h>

enum { POINTS_MAX = 4096, SAMPLES = 120 };

typedef struct cloud {
    uint32_t count;
    float positions[3 * POINTS_MAX], normals[3 * POINTS_MAX];
    uint8_t growths[POINTS_MAX];
} cloud;

static void add(cloud* c, double x, double z)
{
    float* p = c->positions + 3 * (size_t)c->count;
    float* n = c->normals + 3 * (size_t)c->count++;
    p[0] = (float)x;
    p[1] = 0.25f * (float)x; // a slope
    p[2] = (float)z;
    stp_vec3 normal = stp_normalize((stp_vec3){-0.25f, 1.0f, 0.0f});
    memcpy(n, &normal, sizeof(normal));
}

static stp_growth_desc describe(const cloud* c, float spacing, bool smaller)
{
    return (stp_growth_desc){.positions = c->positions,
                             .normals = c->normals,
                             .count = c->count,
                             .sparse_count = c->count,
                             .spacing = spacing,
                             .radius = 0.70710678f * spacing,
                             .smaller = smaller};
}

static bool find(cloud* c, uint32_t threads, float spacing, bool smaller)
{
    stp_context* context = test_context(NULL, threads, NULL);
    stp_growth_desc desc = describe(c, spacing, smaller);
    bool found = stp_growths_find(context, &desc, c->growths) == STP_OK;
    stp_context_destroy(context);
    return found;
}

static void make_grid(cloud* c, uint32_t side, double step, double left_out)
{
    c->count = 0;
    for (uint32_t i = 0; i < side * side; ++i) {
        if ((double)(stp_rng_hash(5, i) >> 11) * 0x1p-53 >= left_out) {
            add(c, step * (double)(i % side), step * (double)(i / side));
        }
    }
}

// Every point of an even grid is as large as its set. Those along the border are not larger.
void test_growths_of_an_even_grid_are_plain(test_state* test)
{
    static cloud c;
    make_grid(&c, 30, 1.0, 0.0);
    CHECK(find(&c, 1, 1.0308f, true));
    for (uint32_t i = 0; i < c.count; ++i) {
        bool across = i % 30 > 0 && i % 30 < 29, along = i / 30 > 0 && i / 30 < 29;
        bool inner = across && along;
        CHECK(c.growths[i] <= STP_GROWTH_PLAIN + (across || along ? 0 : 1)); // or a corner
        CHECK(!inner || c.growths[i] == STP_GROWTH_PLAIN);
    }
}

// The distance in the plane from a point to the farthest place that is nearest to it, of many.
static void measure_cells(const cloud* c, double size, float* reach)
{
    memset(reach, 0, c->count * sizeof(*reach));
    for (int i = 0; i < SAMPLES * SAMPLES; ++i) {
        float x = (float)(size * (i % SAMPLES + 0.5) / SAMPLES);
        float z = (float)(size * (i / SAMPLES + 0.5) / SAMPLES), nearest = INFINITY;
        uint32_t owner = 0;
        for (uint32_t k = 0; k < c->count; ++k) {
            const float* p = c->positions + 3 * (size_t)k;
            float dx = (x - p[0]) * sqrtf(1.0625f), dz = z - p[2], square = dx * dx + dz * dz;
            owner = square < nearest ? k : owner;
            nearest = stp_min(nearest, square);
        }
        reach[owner] = stp_max(reach[owner], sqrtf(nearest));
    }
}

// Radii reach as far as brute force says, at most a step of half an octave farther.
void test_growths_agree_with_brute_force(test_state* test)
{
    static cloud c;
    static float reach[POINTS_MAX];
    c.count = 0;
    for (uint32_t i = 0; i < 400; ++i) {
        add(&c, 10.0 * (double)(stp_rng_hash(1, i) >> 11) * 0x1p-53,
            10.0 * (double)(stp_rng_hash(2, i) >> 11) * 0x1p-53);
    }
    CHECK(find(&c, 1, 0.6f, true));
    measure_cells(&c, 10.0, reach);
    uint32_t inner = 0, right = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        const float* p = c.positions + 3 * (size_t)i;
        float radius = 0.6f * 0.70710678f * stp_growth_factor(c.growths[i]);
        if (p[0] > 1.0f && p[0] < 9.0f && p[2] > 1.0f && p[2] < 9.0f) {
            inner += 1;
            right += radius * 1.08f >= reach[i] && radius <= reach[i] * 1.5f + 0.1f ? 1 : 0;
        }
    }
    CHECK(inner > 200 && right * 100 >= inner * 97);
}

void test_growths_are_the_same_for_any_number_of_threads(test_state* test)
{
    static cloud c;
    static uint8_t first[POINTS_MAX];
    make_grid(&c, 60, 0.5, 0.4);
    CHECK(find(&c, 1, 0.6f, true));
    memcpy(first, c.growths, c.count);
    for (uint32_t threads = 2; threads <= 5; ++threads) {
        CHECK(find(&c, threads, 0.6f, true));
        CHECK(memcmp(first, c.growths, c.count) == 0);
    }
}

// A point alone in the air above others stays as large as its set.
void test_growths_of_lonely_points_are_plain(test_state* test)
{
    static cloud c;
    make_grid(&c, 20, 1.0, 0.0);
    add(&c, 10.5, 10.5);
    c.positions[3 * (c.count - 1) + 1] += 6.0f;
    CHECK(find(&c, 1, 1.0f, true));
    CHECK(c.growths[c.count - 1] <= STP_GROWTH_PLAIN);
}

enum { PATCH = 12 }; ///< points in a row of a thin patch

/// A thin patch of points, a few in each cell of 2.5, and a dense one `away` from it.
static void make_patches(cloud* c, double away)
{
    c->count = 0;
    for (uint32_t i = 0; i < PATCH * PATCH; ++i) {
        add(c, 1.2 * (i % PATCH), 1.2 * (i / PATCH));
    }
    for (uint32_t i = 0; i < 600; ++i) {
        add(c, away + 0.25 * (i % 20), 0.25 * (i / 20));
    }
}

/// How many cells with a point of the dense patch have the bucket of one with a point of the other.
static uint32_t count_shared_buckets(const cloud* c)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_grid grid;
    uint32_t shared = 0;
    if (stp_grid_create(context, c->positions, NULL, c->count, 2.5f, 0.0f, &grid) == STP_OK) {
        for (size_t bucket = 0; bucket <= grid.mask; ++bucket) {
            bool thin = false, dense = false;
            for (uint32_t at = grid.starts[bucket]; at < grid.starts[bucket + 1]; ++at) {
                bool of_thin = grid.index[at] < PATCH * PATCH;
                thin = thin || of_thin;
                dense = dense || !of_thin;
            }
            shared += thin && dense ? 1 : 0;
        }
        stp_grid_destroy(context, &grid);
    }
    stp_context_destroy(context);
    return shared;
}

// Points far away change nothing, also where their cells of the grid share buckets.
void test_growths_do_not_depend_on_places_far_away(test_state* test)
{
    static cloud c;
    static uint8_t first[PATCH * PATCH];
    uint32_t found = 0, grown = 0;
    for (uint32_t i = 0; i < 1000 && found < 6; ++i) { // in turn without shared buckets, and with
        make_patches(&c, 1000.0 + 10.0 * i);
        if ((count_shared_buckets(&c) > 0) == (found % 2 == 1)) {
            CHECK(find(&c, 1, 1.0f, true));
            if (found++ == 0) {
                memcpy(first, c.growths, sizeof(first));
            }
            CHECK(memcmp(first, c.growths, sizeof(first)) == 0);
        }
    }
    for (uint32_t i = 0; i < PATCH * PATCH; ++i) {
        grown += first[i] > STP_GROWTH_PLAIN ? 1 : 0;
    }
    CHECK_EQUAL(6, found);
    CHECK(grown * 2 > PATCH * PATCH);
}

// Wide gaps are those of the first points, which lie a spacing apart; drawing covers a little around
// each point anyway, so radii are smaller by that.
void test_growths_of_a_sparse_prefix_reach_as_far(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    c.count = 0;
    for (uint32_t i = 0; i < 100; ++i) {
        add(&c, 3.0 * (i % 10), 3.0 * (i / 10));
    }
    for (uint32_t i = 0; i < 100; ++i) { // a pair of points at each place
        add(&c, 3.0 * (i % 10) + 0.25, 3.0 * (i / 10));
    }
    stp_growth_desc desc = describe(&c, 1.0f, true);
    desc.sparse_count = 100;
    for (uint32_t k = 0; k < 2; ++k) {
        desc.covered = k == 0 ? 0.0f : 0.5f;
        CHECK_EQUAL(STP_OK, stp_growths_find(context, &desc, c.growths));
        for (uint32_t i = 0; i < 200; ++i) {
            uint32_t x = i % 10, z = i % 100 / 10;
            bool inner = x > 0 && x < 9 && z > 0 && z < 9;
            double reach =
                (double)desc.covered + (double)(desc.radius * stp_growth_factor(c.growths[i]));
            CHECK(!inner || (reach * 1.08 >= 2.0 && reach < 3.4)); // to the corner of the cell
        }
    }
    stp_context_destroy(context);
}

/// Makes the set of a cloud, with growths or without.
static bool make_set(stp_context* context, const cloud* c, bool with_growths, stp_splats* splats)
{
    stp_scene* scene = NULL;
    uint32_t index, object;
    stp_point_set set = {.point_count = c->count};
    bool made = stp_scene_create(context, &scene) == STP_OK;
    set.positions = STP_NEW_ARRAY(context, float, 3 * (size_t)c->count);
    memcpy(set.positions, c->positions, 3 * (size_t)c->count * sizeof(float));
    const stp_object whole = {.parent = STP_NONE, .transform = stp_affine_identity()};
    made = made && stp_scene_add_point_set(scene, &set, &index) == STP_OK &&
           stp_scene_add_object(scene, &whole, &object) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}) == STP_OK &&
           stp_scene_finish(scene) == STP_OK;
    static stp_growth_table table;
    for (uint32_t i = 0; i < STP_GROWTHS; ++i) {
        table.of[0][i] = (uint8_t)i;
    }
    stp_blue_desc desc = {.growths = with_growths ? &table : NULL};
    uint8_t shading[4] = {0};
    made = made && stp_blue_make(scene, scene->root, shading, &desc, splats, NULL) == STP_OK;
    stp_scene_destroy(scene);
    return made;
}

/// The share of places that disks cover, drawn with a prefix.
static double covered_share(const stp_splats* s, uint32_t prefix, double low, double high)
{
    double reached = (double)stp_prefix_table_radius(&s->table, prefix);
    uint32_t covered = 0, all = 0;
    for (int i = 0; i < SAMPLES * SAMPLES; ++i) {
        double x = high * (2.0 * (i % SAMPLES + 0.5) / SAMPLES - 1.0);
        double z = high * (2.0 * (i / SAMPLES + 0.5) / SAMPLES - 1.0), far = sqrt(x * x + z * z);
        bool found = false;
        for (uint32_t k = 0; k < prefix && !found && far >= low && far <= high; ++k) {
            stp_vec3d p = stp_splat_place(s, k);
            double growth = s->materials != NULL && s->materials[k] < STP_GROWTHS
                                ? (double)stp_growth_factor(s->materials[k])
                                : 1.0;
            double dx = x - p.x, dz = z - p.z, r = reached + (double)s->candidate_radius * growth;
            found = 1.0625 * dx * dx + dz * dz <= r * r;
        }
        all += far >= low && far <= high ? 1 : 0;
        covered += found ? 1 : 0;
    }
    return (double)covered / (double)all;
}

/// Checks that growths cover a cloud between two distances, at rest and, as far, in motion.
static void check_covered(test_state* test, const cloud* c, double low, double high, double before)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_splats plain, grown;
    CHECK(make_set(context, c, false, &plain) && make_set(context, c, true, &grown));
    memset(plain.materials, STP_GROWTH_PLAIN, plain.count);
    CHECK(covered_share(&plain, plain.count, low, high) < before);
    double rest = covered_share(&grown, grown.count, low, high);
    CHECK(rest > 0.99);
    CHECK(rest >= covered_share(&grown, grown.count / 8, low, high) - 0.005);
    stp_splats_destroy(context, &plain);
    stp_splats_destroy(context, &grown);
    stp_context_destroy(context);
}

// Rings of a scanner: dense along each, ever farther apart.
void test_growths_close_the_gaps_between_rings(test_state* test)
{
    static cloud c;
    c.count = 0;
    for (int ring = 0; ring < 16; ++ring) {
        double radius = 1.0 * pow(1.18, ring);
        for (int i = 0; i < 180; ++i) {
            double turn = 2.0 * STP_PI * i / 180.0;
            add(&c, radius * cos(turn), radius * sin(turn));
        }
    }
    check_covered(test, &c, 1.2, 11.5, 0.9);
}

// A grid of which two thirds are left out at random.
void test_growths_close_the_gaps_of_a_thinned_grid(test_state* test)
{
    static cloud c;
    make_grid(&c, 60, 0.5, 0.67);
    for (uint32_t i = 0; i < c.count; ++i) {
        c.positions[3 * i] -= 15.0f;
        c.positions[3 * i + 1] -= 0.25f * 15.0f;
        c.positions[3 * i + 2] -= 15.0f;
    }
    check_covered(test, &c, 0.0, 13.0, 0.97);
}

// A grid of which most points are left out: most cells that are closed on all sides are covered,
// however uneven they are.
void test_growths_cover_uneven_cells_inside_a_surface(test_state* test)
{
    static cloud c;
    static float reach[POINTS_MAX];
    make_grid(&c, 60, 0.5, 0.85);
    CHECK(find(&c, 1, 0.5f, true));
    measure_cells(&c, 30.0, reach);
    uint32_t inner = 0, covered = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        const float* p = c.positions + 3 * (size_t)i;
        if (p[0] > 3.0f && p[0] < 27.0f && p[2] > 3.0f && p[2] < 27.0f) {
            float radius = 0.5f * 0.70710678f * stp_growth_factor(c.growths[i]);
            inner += 1;
            covered += radius * 1.08f >= reach[i] ? 1 : 0;
        }
    }
    CHECK(inner > 200 && covered * 2 >= inner);
}
