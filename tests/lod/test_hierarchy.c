// SPDX-License-Identifier: MIT
#include "hierarchy_helpers.h"
#include "tests.h"

#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "capture/capture_internal.h"
#include "lod/blue/children.h"
#include "raster/splats.h"

enum { LEVELS = 10, PER_LEVEL = 600, EVERY = 29 };

static stp_vec3d surfel_position(const stp_splats* s, uint32_t i)
{
    const uint16_t* v = s->positions + 3 * (size_t)i;
    double step = (double)s->step;
    return (stp_vec3d){(double)s->origin.x + step * v[0], (double)s->origin.y + step * v[1],
                       (double)s->origin.z + step * v[2]};
}

static float final_radius(const stp_splats* s)
{
    return s->table.radius[s->table.size - 1];
}

static const double flake[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                   {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

// Distance of a point from a sphere flake: six copies of half the size, `levels` levels deep.
static double flake_distance(stp_vec3d p, int level, double best)
{
    double length = sqrt(stp_dotd(p, p));
    if (level == 0) {
        return fabs(length - 1.0);
    }
    if (length - 2.0 > best) { // the whole flake lies within radius 2
        return best;
    }
    for (int i = 0; i < 6; ++i) {
        stp_vec3d in = {(p.x - flake[i][0]) * 2.0, (p.y - flake[i][1]) * 2.0,
                        (p.z - flake[i][2]) * 2.0};
        double d = 0.5 * flake_distance(in, level - 1, 2.0 * best);
        best = d < best ? d : best;
    }
    return best;
}

static double largest_distance(const stp_splats* s, int level)
{
    double largest = 0.0;
    for (uint32_t i = 0; i < s->count; i += EVERY) {
        double d = flake_distance(surfel_position(s, i), level, 1.0);
        largest = d > largest ? d : largest;
    }
    return largest;
}

// Nested sphere flake: each level is captured from the surfels of the level below. Surfels stay on
// the spheres, whose smallest is a thousandth of the whole: only the rounding of the position grids
// adds up. The distance from surface to candidates stays below the spacing of surfels.
void test_ten_levels_of_spheres_do_not_grow(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    CHECK(context != NULL && hierarchy_begin(context, &h, true, 10));
    uint32_t object = h.shape;
    stp_affine copies[6];
    for (int i = 0; i < 6; ++i) {
        copies[i] = scale_and_move(0.5, 0.5, 0.5, flake[i][0], flake[i][1], flake[i][2]);
    }
    uint32_t objects[LEVELS + 1] = {object};
    for (int level = 1; level <= LEVELS; ++level) {
        CHECK(add_copies(&h, objects[level - 1], copies, 6, level < LEVELS, &objects[level]));
    }
    CHECK(hierarchy_finish(&h));
    double rounding = 0.0;
    for (int level = 0; level <= LEVELS; ++level) {
        uint32_t node = h.scene->objects[objects[level]].node;
        stp_blue_report report;
        uint32_t wanted = level == 0 ? 8000 : 9 * PER_LEVEL;
        CHECK_EQUAL(STP_OK, hierarchy_make(&h, node, PER_LEVEL, wanted, &report));
        const stp_splats* s = &h.made[node];
        CHECK(s->count > PER_LEVEL * 9 / 10);
        CHECK(report.candidate_count > 5 * s->count);
        // the mesh lies up to 0.02 inside the sphere; each grid rounds by half a step on each axis
        rounding = 0.5 * rounding + 0.8661 * (double)s->step;
        double allowed = 0.02 * ldexp(1.0, -level) + rounding + 1e-6;
        CHECK(largest_distance(s, level) <= allowed);
        CHECK(s->candidate_radius < 0.6f * final_radius(s));
    }
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}

enum { PICTURE = 128 };

// Draws all surfels from +z and counts the covered pixels inside and outside the square [-half,
// half]^2.
static void draw_from_above(const stp_splats* s, double half, uint32_t* inside, uint32_t* outside,
                            double margin)
{
    static uint64_t pixels[PICTURE * PICTURE];
    memset(pixels, 0xFF, sizeof(pixels));
    stp_raster_target target = {PICTURE, PICTURE, PICTURE, pixels};
    float scale = (float)(PICTURE / (2.2 * half)), middle = PICTURE / 2;
    stp_raster_camera camera = {
        .matrix = {{{scale, 0, 0, middle},
                    {0, -scale, 0, middle},
                    {0, 0, (float)(0.1 / half), 1.5f},
                    {0, 0, 0, 1}}},
        .view = {{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}},
        .pixel_scale = scale,
        .parallel = true,
        .nearness_limit = 4.0f,
    };
    stp_raster_splats splats = {.positions = s->positions,
                                .normals = s->normals,
                                .end = s->count,
                                .origin = s->origin,
                                .step = s->step,
                                .radius = final_radius(s) + s->candidate_radius,
                                .coverages = s->coverages + 0};
    for (uint32_t k = 0; k + 1 < s->octave_count; ++k) {
        splats.coverages += s->octave_ends[k];
    }
    stp_raster_draw_splats(&target, 0, PICTURE, &camera, &splats, 0);
    *inside = *outside = 0;
    for (int i = 0; i < PICTURE * PICTURE; ++i) {
        double x = fabs((i % PICTURE + 0.5) / PICTURE - 0.5) * 2.2 * half;
        double y = fabs((i / PICTURE + 0.5) / PICTURE - 0.5) * 2.2 * half;
        bool covered = pixels[i] != STP_RASTER_EMPTY;
        *inside += x < half && y < half && !covered;
        *outside += (x > half + margin || y > half + margin) && covered;
    }
}

// Thin plates side by side, four times as many at each level: no holes after ten captures, no
// overhang beyond the border above a disk's radius, and both sides are covered.
void test_ten_levels_of_plates_stay_whole(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    CHECK(context != NULL && hierarchy_begin(context, &h, false, 12));
    stp_affine first = scale_and_move(1, 1, 0.01, 0, 0, 0);
    uint32_t objects[LEVELS + 1];
    CHECK(add_copies(&h, h.shape, &first, 1, true, &objects[0]));
    for (int level = 1; level <= LEVELS; ++level) {
        double d = ldexp(1.0, level - 1);
        stp_affine copies[4];
        for (int i = 0; i < 4; ++i) {
            copies[i] = scale_and_move(1, 1, 1, i % 2 == 0 ? d : -d, i / 2 == 0 ? d : -d, 0);
        }
        CHECK(add_copies(&h, objects[level - 1], copies, 4, level < LEVELS, &objects[level]));
    }
    CHECK(hierarchy_finish(&h));
    for (int level = 0; level <= LEVELS; ++level) {
        uint32_t node = h.scene->objects[objects[level]].node;
        uint32_t wanted = level == 0 ? 8000 : 9 * PER_LEVEL;
        CHECK_EQUAL(STP_OK, hierarchy_make(&h, node, PER_LEVEL, wanted, NULL));
        const stp_splats* s = &h.made[node];
        uint32_t upper = 0, holes, beyond;
        for (uint32_t i = 0; i < s->count; ++i) {
            stp_vec3 n = stp_octahedral_decode(s->normals[2 * i], s->normals[2 * i + 1]);
            stp_vec3d p = surfel_position(s, i);
            CHECK(fabs(p.x) < ldexp(1.0001, level) && fabs(p.y) < ldexp(1.0001, level));
            CHECK(fabsf(n.z) > 0.99f);
            upper += n.z > 0.0f;
        }
        CHECK(upper > s->count * 2 / 5 && upper < s->count * 3 / 5);
        double half = ldexp(1.0, level);
        draw_from_above(s, half, &holes, &beyond, (double)(final_radius(s) + s->candidate_radius));
        CHECK_EQUAL(0, holes);
        CHECK_EQUAL(0, beyond);
        CHECK(s->candidate_radius < 0.6f * final_radius(s));
    }
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}
