// SPDX-License-Identifier: MIT
// Each part of finishing, against its definition.
#include "candidate_helpers.h"
#include "tests.h"

#include "lod/neighbours.h"

static double random_in(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

void test_position_grids_hold_their_box(test_state* test)
{
    static const double offsets[] = {0.0, 1.0, -3.0, 500000.0, -6e6, 1e9};
    static const double sizes[] = {1e-6, 0.01, 1.0, 65535.0, 3e5};
    for (uint64_t i = 0; i < 30 * 40; ++i) {
        double offset = offsets[i % 6], size = sizes[i / 6 % 5] * random_in(1, i, 0.5, 2.0);
        stp_boxd box = {.min = {offset + random_in(2, i, 0, size), offset, -offset},
                        .max = {0, 0, 0}};
        box.max = (stp_vec3d){box.min.x + size * random_in(3, i, 0, 1), box.min.y + size,
                              box.min.z + size * random_in(4, i, 0, 1)};
        stp_vec3 origin;
        float step;
        stp_choose_position_grid(box, 0.0, &origin, &step);
        int exponent;
        CHECK(frexpf(step, &exponent) == 0.5f); // a power of two
        double low[3] = {box.min.x, box.min.y, box.min.z},
               high[3] = {box.max.x, box.max.y, box.max.z};
        double start[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
        double widest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(floor(start[axis] / (double)step) * (double)step == start[axis]); // on the grid
            CHECK(start[axis] <= low[axis]);
            CHECK(floor((high[axis] - start[axis]) / (double)step + 0.5) <= 65535.0);
            widest = high[axis] - low[axis] > widest ? high[axis] - low[axis] : widest;
        }
        // a finer grid would not fit, or floats are too coarse for it
        CHECK(widest / (double)step > 65535.0 / 4.0 || fabs(offset) / (double)step > 1e4);
        CHECK((double)step >= widest / 65535.0);
    }
}

void test_position_grid_of_a_point_is_finite(test_state* test)
{
    stp_boxd box = {{2, 3, 4}, {2, 3, 4}};
    stp_vec3 origin;
    float step;
    stp_choose_position_grid(box, 0.001, &origin, &step);
    CHECK(step >= 0.001f && step < 0.002f);
    stp_choose_position_grid(box, 0.0, &origin, &step);
    CHECK(step > 0.0f && origin.x <= 2.0f && isfinite(origin.x));
}

void test_octaves_halve_the_radius(test_state* test)
{
    enum { COUNT = 5000 };
    static float envelope[COUNT];
    envelope[0] = INFINITY;
    for (int i = 1; i < COUNT; ++i) {
        envelope[i] = 10.0f / sqrtf((float)i);
    }
    uint32_t ends[STP_OCTAVE_LIMIT];
    uint32_t size = stp_choose_octaves(envelope, 0.0f, HUGE_VAL, COUNT, ends);
    CHECK(size >= 6 && size <= 8);
    CHECK_EQUAL(COUNT, ends[size - 1]);
    uint64_t entries = 0;
    for (uint32_t i = 0; i < size; ++i) {
        CHECK(i == 0 || ends[i] > ends[i - 1]);
        entries += ends[i];
        float wanted = envelope[COUNT - 1] * (float)(1 << (size - 1 - i));
        CHECK(i == size - 1 || envelope[ends[i]] < wanted);
        CHECK(i == size - 1 || envelope[ends[i] - 1] >= wanted);
    }
    CHECK(entries < COUNT * 4 / 3 + 10);
}

// Nearly coincident points of a scan have tiny insertion radii; their disks are not smaller.
void test_octaves_end_where_disks_do_not_shrink(test_state* test)
{
    enum { COUNT = 3000 };
    static float envelope[COUNT];
    envelope[0] = INFINITY;
    for (int i = 1; i < COUNT; ++i) {
        envelope[i] = i < 2000 ? 10.0f / sqrtf((float)i) : envelope[i - 1] * 0.95f;
    }
    uint32_t ends[STP_OCTAVE_LIMIT], entries = 0;
    uint32_t size = stp_choose_octaves(envelope, 0.2f, HUGE_VAL, COUNT, ends);
    for (uint32_t i = 0; i < size; ++i) {
        entries += ends[i];
    }
    CHECK(size >= 3 && entries < 2 * COUNT);
}

// In a random order, even nearly all points may need large disks to cover.
void test_octaves_leave_crowded_prefixes_out(test_state* test)
{
    enum { COUNT = 5000 };
    static float envelope[COUNT];
    envelope[0] = INFINITY;
    for (int i = 1; i < COUNT; ++i) {
        envelope[i] =
            i < COUNT - 40 ? 10.0f / (1.0f + 0.1f * (float)i / COUNT) : envelope[i - 1] * 0.8f;
        envelope[i] = i < 20 ? 100.0f / (float)i : envelope[i];
    }
    uint32_t ends[STP_OCTAVE_LIMIT], crowded = 0;
    const double maximum = 1e4;
    for (int limited = 0; limited < 2; ++limited) {
        uint32_t size =
            stp_choose_octaves(envelope, 0.0f, limited != 0 ? maximum : HUGE_VAL, COUNT, ends);
        CHECK(size >= 2 && ends[size - 1] == COUNT);
        for (uint32_t i = 0; i + 1 < size; ++i) {
            double disk = (double)envelope[ends[i]];
            bool over = STP_PI * disk * disk * ends[i] > maximum;
            crowded += over ? 1 : 0;
            CHECK(!over || limited == 0);
            CHECK(ends[i] < ends[i + 1]);
        }
    }
    CHECK(crowded >= 3);
}

void test_octaves_of_odd_orders(test_state* test)
{
    uint32_t ends[STP_OCTAVE_LIMIT];
    float one[] = {INFINITY};
    CHECK_EQUAL(1, stp_choose_octaves(one, 0.0f, HUGE_VAL, 1, ends));
    CHECK_EQUAL(1, ends[0]);
    float same[] = {INFINITY, 2, 2, 2, 2};
    CHECK_EQUAL(2, stp_choose_octaves(same, 0.0f, HUGE_VAL, 5, ends));
    CHECK_EQUAL(1, ends[0]);
    CHECK_EQUAL(5, ends[1]);
    float zeros[] = {INFINITY, 0, 0};
    CHECK_EQUAL(1, stp_choose_octaves(zeros, 0.0f, HUGE_VAL, 3, ends));
    CHECK_EQUAL(3, ends[0]);
    float jump[] = {INFINITY, 1e30f, 1e-30f, 1e-30f}; // more halvings than octaves are allowed
    uint32_t size = stp_choose_octaves(jump, 0.0f, HUGE_VAL, 4, ends);
    CHECK(size >= 2 && size <= STP_OCTAVE_LIMIT);
    for (uint32_t i = 1; i < size; ++i) {
        CHECK(ends[i] > ends[i - 1]);
    }
    CHECK_EQUAL(4, ends[size - 1]);
    float many[64];
    many[0] = INFINITY;
    for (int i = 1; i < 64; ++i) {
        many[i] = many[i - 1] > 1e38f ? 1e18f : many[i - 1] * 0.5f;
    }
    CHECK_EQUAL(STP_OCTAVE_LIMIT, stp_choose_octaves(many, 0.0f, HUGE_VAL, 64, ends));
    CHECK_EQUAL(64, ends[STP_OCTAVE_LIMIT - 1]);
    CHECK_EQUAL(64 - STP_OCTAVE_LIMIT + 1, ends[0]);
}

void test_stencil_squares_touch_the_right_cells(test_state* test)
{
    for (uint64_t i = 0; i < 20000; ++i) {
        float u = (float)random_in(7, i, -1.6, 1.6), v = (float)random_in(8, i, -1.6, 1.6);
        float half = i % 3 == 0 ? 0.0f : (float)random_in(9, i, 0.0, 1.5);
        uint64_t cells = stp_stencil_cells(u, v, half);
        for (int cell = 0; cell < 64; ++cell) {
            float u0 = (float)(cell % 8) * 0.25f - 1.0f, v0 = (float)(cell / 8) * 0.25f - 1.0f;
            float centre = fmaxf(fabsf(u - u0 - 0.125f), fabsf(v - v0 - 0.125f)), margin = 1e-5f;
            bool clearly = centre < half - margin || centre < 0.125f - margin;
            // if only one axis reaches a centre, the neighbouring cell on the other axis counts as
            // the own one
            bool perhaps = centre < fmaxf(half, 0.125f) + margin;
            bool got = (cells >> cell & 1) != 0;
            CHECK(!clearly || got);
            CHECK(perhaps || !got);
        }
    }
    CHECK_EQUAL(0, stp_stencil_cells(NAN, 0, 0.1f));
}

static uint64_t cells_where(bool (*inside)(double u, double v))
{
    uint64_t cells = 0;
    for (int i = 0; i < 200; ++i) {
        for (int j = 0; j < 200; ++j) {
            double u = (i + 0.5) / 100.0 - 1.0, v = (j + 0.5) / 100.0 - 1.0;
            cells |= inside(u, v) ? stp_stencil_cells((float)u, (float)v, 0.0f) : 0;
        }
    }
    return cells;
}

static bool in_all(double u, double v)
{
    (void)u, (void)v;
    return true;
}
static bool in_half(double u, double v)
{
    return 0.3 * u + 0.7 * v > -0.01;
}
static bool in_corner(double u, double v)
{
    return u + 0.4 * v > -0.01 && v - 0.4 * u > -0.01;
}
static bool in_wire(double u, double v)
{
    return fabs(u - 0.5 * v) < 0.12;
}
static bool in_fence(double u, double v)
{
    return fabs(fmod(u + 1.0, 0.6)) < 0.1 || fabs(fmod(v + 1.0, 0.6)) < 0.1;
}

void test_stencils_tell_plates_from_wires(test_state* test)
{
    stp_stencil stencil = stp_stencil_make();
    CHECK_EQUAL(52, __builtin_popcountll(stencil.disk));
    CHECK(stp_stencil_fraction(&stencil, cells_where(in_all)) == 1.0f);
    CHECK(stp_stencil_fraction(&stencil, cells_where(in_half)) == 1.0f);
    CHECK(stp_stencil_fraction(&stencil, cells_where(in_corner)) == 1.0f);
    float wire = stp_stencil_fraction(&stencil, cells_where(in_wire));
    CHECK(wire > 0.15f && wire < 0.45f);
    float fence = stp_stencil_fraction(&stencil, cells_where(in_fence));
    CHECK(fence > 0.4f && fence < 0.95f);
    CHECK(stp_stencil_fraction(&stencil, 0) == 0.0f);
}

typedef struct cloud {
    float positions[3 * 3000], normals[3 * 3000];
    uint32_t count;
} cloud;

static void make_cloud(cloud* c, uint64_t seed, uint32_t count, double clumping)
{
    c->count = count;
    for (uint32_t i = 0; i < count; ++i) {
        double spread = i % 2 == 0 ? 1.0 : clumping;
        stp_vec3 n = stp_normalize((stp_vec3){(float)random_in(seed, 7 * i + 3, -1, 1),
                                              (float)random_in(seed, 7 * i + 4, -1, 1),
                                              (float)random_in(seed, 7 * i + 5, -1, 1)});
        for (uint32_t axis = 0; axis < 3; ++axis) {
            c->positions[3 * i + axis] =
                (float)(0.017 + spread * random_in(seed, 7 * i + axis, -1, 1));
        }
        memcpy(c->normals + 3 * (size_t)i, &n, sizeof(n));
    }
}

void test_grids_hold_each_point_in_its_cell(test_state* test)
{
    static cloud points;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (int variant = 0; variant < 4; ++variant) {
        make_cloud(&points, (uint64_t)variant, variant == 3 ? 1 : 2000, variant == 2 ? 1e-4 : 1.0);
        stp_grid grid;
        float cell = variant == 0 ? 0.05f : 0.4f;
        CHECK_EQUAL(STP_OK, stp_grid_create(context, points.positions, points.normals, points.count,
                                            cell, 0.3f * cell, &grid));
        CHECK_EQUAL(points.count, grid.starts[(size_t)grid.mask + 1]);
        uint8_t seen[3000] = {0};
        for (uint32_t bucket = 0; bucket <= grid.mask; ++bucket) {
            for (uint32_t at = grid.starts[bucket]; at < grid.starts[bucket + 1]; ++at) {
                const float* p = points.positions + 3 * (size_t)grid.index[at];
                CHECK(p[0] == grid.x[at] && p[1] == grid.y[at] && p[2] == grid.z[at]);
                CHECK(points.normals[3 * (size_t)grid.index[at] + 2] == grid.nz[at]);
                CHECK_EQUAL(bucket, stp_grid_bucket(&grid, stp_grid_cell(&grid, p[0]),
                                                    stp_grid_cell(&grid, p[1]),
                                                    stp_grid_cell(&grid, p[2])));
                CHECK(at == grid.starts[bucket] || grid.index[at] > grid.index[at - 1]);
                seen[grid.index[at]] += 1;
            }
        }
        for (uint32_t i = 0; i < points.count; ++i) {
            CHECK_EQUAL(1, seen[i]);
        }
        stp_grid_destroy(context, &grid);
        CHECK_EQUAL(STP_OK, stp_grid_create_uncrowded(context, points.positions, points.normals,
                                                      points.count, cell, &grid));
        // a cluster requires smaller cells
        CHECK(variant == 2 ? grid.cell < 0.01f : grid.cell == cell);
        stp_grid plain;
        CHECK_EQUAL(STP_OK, stp_grid_create(context, points.positions, NULL, points.count,
                                            grid.cell, 0.0f, &plain));
        CHECK(memcmp(plain.x, grid.x, points.count * sizeof(float)) == 0);
        CHECK(memcmp(plain.index, grid.index, points.count * sizeof(uint32_t)) == 0);
        for (uint32_t i = 0; i < points.count + STP_GRID_LANES; ++i) {
            CHECK(plain.nx[i] == 0.0f && plain.ny[i] == 0.0f && plain.nz[i] == 0.0f);
        }
        stp_grid_destroy(context, &plain);
        stp_grid_destroy(context, &grid);
    }
    stp_context_destroy(context);
}

void test_thinned_grids_take_every_third_point_of_each_place(test_state* test)
{
    static cloud points;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    make_cloud(&points, 7, 2000, 1.0);
    stp_grid grid, thin;
    CHECK_EQUAL(STP_OK, stp_grid_create(context, points.positions, points.normals, points.count,
                                        0.4f, 0.2f, &grid));
    CHECK_EQUAL(STP_OK, stp_grid_thin(context, &grid, 3, 0.7f, &thin));
    CHECK_EQUAL((points.count + 2) / 3, thin.count);
    CHECK_EQUAL(thin.count, thin.starts[(size_t)thin.mask + 1]);
    uint8_t seen[3000] = {0};
    for (uint32_t bucket = 0; bucket <= thin.mask; ++bucket) {
        for (uint32_t at = thin.starts[bucket]; at < thin.starts[bucket + 1]; ++at) {
            const float* p = points.positions + 3 * (size_t)thin.index[at];
            CHECK(p[0] == thin.x[at] && p[1] == thin.y[at] && p[2] == thin.z[at]);
            CHECK(points.normals[3 * (size_t)thin.index[at] + 2] == thin.nz[at]);
            CHECK_EQUAL(bucket,
                        stp_grid_bucket(&thin, stp_grid_cell(&thin, p[0]),
                                        stp_grid_cell(&thin, p[1]), stp_grid_cell(&thin, p[2])));
            seen[thin.index[at]] += 1;
        }
    }
    for (uint32_t i = 0; i < grid.count; ++i) {
        CHECK_EQUAL(i % 3 == 0, seen[grid.index[i]]);
    }
    stp_grid_destroy(context, &thin);
    stp_grid_destroy(context, &grid);
    stp_context_destroy(context);
}

static float agreement_of(const cloud* a, uint32_t i, const cloud* b, uint32_t k)
{
    const float *n = a->normals + 3 * (size_t)i, *m = b->normals + 3 * (size_t)k;
    return n[0] * m[0] + n[1] * m[1] + n[2] * m[2];
}

static float squared_between(const cloud* a, uint32_t i, const cloud* b, uint32_t k)
{
    const float *p = a->positions + 3 * (size_t)i, *q = b->positions + 3 * (size_t)k;
    float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
    return x * x + y * y + z * z;
}

void test_nearest_surfels_agree_with_brute_force(test_state* test)
{
    static cloud surfels, samples;
    static uint32_t nearest[3000];
    for (int variant = 0; variant < 6; ++variant) {
        // with 1: nearly all in one block, more than one batch
        make_cloud(&surfels, 5, 900, variant % 3 == 1 ? 1e-2 : 1.0);
        make_cloud(&samples, 6, 3000, variant % 3 == 1 ? 1e-2 : 1.0);
        float radius = variant % 3 == 2 ? 1.2f : 0.15f, cell = 2.002f * radius;
        stp_context* context = test_context(NULL, variant < 3 ? 1 : 3, NULL);
        stp_grid grid, sample_grid;
        CHECK(context != NULL);
        CHECK_EQUAL(STP_OK, stp_grid_create(context, surfels.positions, surfels.normals,
                                            surfels.count, cell, 0.0f, &grid));
        CHECK_EQUAL(STP_OK, stp_grid_create(context, samples.positions, samples.normals,
                                            samples.count, cell, 0.5f * cell, &sample_grid));
        stp_nearest_search search = {
            .surfels = &grid, .samples = &sample_grid, .radius = radius, .nearest = nearest};
        stp_nearest_search_run(context, &search);
        for (uint32_t at = 0; at < samples.count; ++at) {
            uint32_t best = UINT32_MAX, i = sample_grid.index[at];
            float minimum = radius * radius;
            for (uint32_t k = 0; k < surfels.count; ++k) {
                float squared = squared_between(&samples, i, &surfels, k);
                if (squared <= minimum && (squared < minimum || best == UINT32_MAX) &&
                    agreement_of(&samples, i, &surfels, k) >= 0.0f) {
                    minimum = squared;
                    best = k;
                }
            }
            CHECK_EQUAL(best, nearest[at]);
        }
        stp_grid_destroy(context, &sample_grid);
        stp_grid_destroy(context, &grid);
        stp_context_destroy(context);
    }
}

void test_disks_agree_with_brute_force(test_state* test)
{
    static cloud surfels, samples;
    static stp_disk disks[3000];
    static uint16_t fractions[3000];
    static uint32_t visit[3000];
    stp_stencil stencil = stp_stencil_make();
    make_cloud(&surfels, 15, 300, 1.0);
    make_cloud(&samples, 16, 3000, 1.0);
    for (uint32_t i = 0; i < samples.count; ++i) {
        fractions[i] = (uint16_t)(i * 20);
    }
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_grid grid;
        CHECK(context != NULL);
        CHECK_EQUAL(STP_OK, stp_grid_create(context, samples.positions, samples.normals,
                                            samples.count, 0.25f, 0.03f, &grid));
        CHECK_EQUAL(STP_OK, stp_sort_spatially(context, surfels.positions, surfels.count, visit));
        memset(disks, 0xff, sizeof(disks));
        stp_disk_search search = {.samples = &grid,
                                  .fractions = fractions,
                                  .footprint = 0.03f,
                                  .positions = surfels.positions,
                                  .normals = surfels.normals,
                                  .visit = visit,
                                  .count = surfels.count,
                                  .radius = 0.2f,
                                  .stencil = &stencil,
                                  .disks = disks};
        stp_disk_search_run(context, &search);
        uint32_t total = 0;
        for (uint32_t k = 0; k < surfels.count; ++k) {
            uint32_t minimum = 0, maximum = 0;
            uint64_t sum = 0;
            for (uint32_t i = 0; i < samples.count; ++i) {
                float distance = sqrtf(squared_between(&samples, i, &surfels, k));
                if (agreement_of(&samples, i, &surfels, k) >= 0.0f) {
                    minimum += distance < 0.2299f;
                    maximum += distance < 0.2301f;
                    sum += distance < 0.23f ? fractions[i] : 0;
                }
            }
            CHECK(disks[k].count >= minimum && disks[k].count <= maximum);
            CHECK(minimum != maximum || disks[k].count != minimum || disks[k].fractions == sum);
            CHECK((disks[k].cells == 0) == (disks[k].count == 0) || disks[k].cells == 0);
            CHECK((disks[k].cells & ~stencil.disk) == 0);
            total += disks[k].count;
        }
        CHECK(total > 1000);
        stp_grid_destroy(context, &grid);
        stp_context_destroy(context);
    }
}

void test_spatial_orders_are_permutations_that_stay_near(test_state* test)
{
    static cloud points;
    static uint32_t order[3000];
    make_cloud(&points, 3, 3000, 1.0);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, stp_sort_spatially(context, points.positions, points.count, order));
    static uint8_t seen[3000];
    double along = 0.0, as_given = 0.0;
    for (uint32_t i = 0; i < points.count; ++i) {
        seen[order[i]] += 1;
        along +=
            i > 0 ? sqrt((double)squared_between(&points, order[i], &points, order[i - 1])) : 0.0;
        as_given += i > 0 ? sqrt((double)squared_between(&points, i, &points, i - 1)) : 0.0;
    }
    for (uint32_t i = 0; i < points.count; ++i) {
        CHECK_EQUAL(1, seen[i]);
    }
    CHECK(along < 0.25 * as_given);
    CHECK_EQUAL(STP_OK, stp_sort_spatially(context, points.positions, 1, order));
    CHECK_EQUAL(0, order[0]);
    stp_context_destroy(context);
}

void test_median_spacing_of_a_row(test_state* test)
{
    float row[3 * 101];
    for (int i = 0; i < 101; ++i) {
        row[3 * i] = (float)i * 0.5f;
        row[3 * i + 1] = row[3 * i + 2] = 0.0f;
    }
    row[3 * 100] = 1000.0f;
    CHECK(stp_median_spacing(row, NULL, 101) == 0.5f);
    CHECK(stp_median_spacing(row, NULL, 1) == 0.0f);
}

// Two sides of a wall: each has its own spacing.
void test_median_spacing_is_that_of_a_side(test_state* test)
{
    enum { COUNT = 1000 };
    static float row[3 * COUNT], normals[3 * COUNT];
    for (int i = 0; i < COUNT; ++i) {
        row[3 * i] = (float)i * 0.5f;
        row[3 * i + 2] = i % 2 == 0 ? 0.0f : -0.125f;
        normals[3 * i + 2] = i % 2 == 0 ? 1.0f : -1.0f;
    }
    CHECK(stp_median_spacing(row, normals, COUNT) == 1.0f);
    CHECK(fabsf(stp_median_spacing(row, NULL, COUNT) - sqrtf(0.25f + 0.015625f)) < 1e-6f);
}
