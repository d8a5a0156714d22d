// SPDX-License-Identifier: MIT
// Cells of points in planes: the same with every instruction set, and as if all neighbours had cut,
// in any order.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "lod/blue/growths_kernels.h"

#include <string.h>

enum { SEEDS = 40, POINTS = 160 };

static float noise(uint64_t seed, uint32_t i)
{
    return (float)(stp_rng_hash(seed, i) >> 40) * 0x1p-23f - 1.0f;
}

/// A layer of points around the middle: thin in one, thick in another; some are in the same place.
static void make_around(uint64_t seed, stp_around* around)
{
    float thickness = 0.1f * (float)(seed % 8), size = 1.0f + (float)(seed % 3);
    memset(around, 0, sizeof(*around));
    around->count = POINTS;
    for (uint32_t i = 0; i < POINTS; ++i) {
        bool padding = i >= POINTS - 3, middle = i % 50 == 7;
        around->x[i] = padding ? INFINITY : middle ? 0.0f : size * noise(seed, 3 * i);
        around->y[i] = padding ? INFINITY : middle ? 0.0f : size * noise(seed, 3 * i + 1);
        around->z[i] = padding ? INFINITY : middle ? 0.0f : thickness * noise(seed, 3 * i + 2);
    }
}

static stp_plane_cell begin_cell(void)
{
    return (stp_plane_cell){.normal = {0.0f, 0.0f, 1.0f},
                            .across = {0.8f, 0.6f, 0.0f},
                            .along = {-0.6f, 0.8f, 0.0f},
                            .beyond = INFINITY};
}

/// Cuts a cell by all points within `middle`, and then by those from half of that on, as the next
/// grid does: squared distances.
static stp_plane_cell cut(const stp_growth_kernels* kernels, const stp_around* around, float first,
                          float middle)
{
    stp_plane_cell cell = begin_cell();
    kernels->cut(around, 0.0f, stp_min(first, middle), 0.8f, &cell);
    kernels->cut(around, 0.5f * middle, middle, 0.0f, &cell);
    return cell;
}

void test_growth_kernels_of_all_processors_agree(test_state* test)
{
    if (stp_processor_detect() < STP_PROCESSOR_VECTOR) {
        SKIP("this processor has no vectors");
    }
    const stp_cell_limits limits = {
        .plain = 0.4f, .closed = 0.8f, .hole = 0.8f, .enclosed = 0.5f, .most = 2.0f};
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        static stp_around around;
        make_around(seed, &around);
        around.count = seed % 5 == 0 ? 16 : POINTS; // few leave cells open
        stp_plane_cell a = cut(&stp_growth_kernels_portable, &around, 0.01f, 0.3f);
        stp_plane_cell b = cut(&STP_VECTOR(stp_growth_kernels), &around, 0.01f, 0.3f);
        CHECK(memcmp(a.nearness, b.nearness, sizeof(a.nearness)) == 0);
        CHECK(a.least == b.least && a.beyond == b.beyond && a.steep == b.steep);
        CHECK(stp_growth_kernels_portable.reach(&limits, &a) ==
              STP_VECTOR(stp_growth_kernels).reach(&limits, &b));
    }
}

/// Whether a cell is the one that all points cut, each by itself.
static bool is_cell_of_all(const stp_plane_cell* cell, const stp_around* around)
{
    double nearness[STP_GROWTH_DIRECTIONS] = {0};
    uint32_t steep = 0;
    for (uint32_t i = 0; i < around->count; ++i) {
        double x = (double)around->x[i], y = (double)around->y[i], z = (double)around->z[i];
        double u = 0.8 * x + 0.6 * y, v = 0.8 * y - 0.6 * x, square = u * u + v * v;
        steep += z * z > square && square + z * z < 0.8 ? 1 : 0;
        if (!(square > 0.0) || z * z > square || around->x[i] == INFINITY) {
            continue;
        }
        for (int k = 0; k < STP_GROWTH_DIRECTIONS; ++k) {
            double turn = 2.0 * STP_PI * k / STP_GROWTH_DIRECTIONS;
            double own = 2.0 * (u * cos(turn) + v * sin(turn)) / square;
            nearness[k] = own > nearness[k] ? own : nearness[k];
        }
    }
    bool same = steep == cell->steep;
    for (int k = 0; k < STP_GROWTH_DIRECTIONS; ++k) {
        double own = (double)cell->nearness[k] > 0.0 ? (double)cell->nearness[k] : 0.0;
        same = same && fabs(own - nearness[k]) <= 1e-5 * (1.0 + nearness[k]);
    }
    return same;
}

// Points that are left out, because nearer ones hide them, would change nothing.
void test_growth_cells_are_those_of_all_points(test_state* test)
{
    const stp_growth_kernels* kernels = stp_growth_kernels_select();
    uint32_t left_out = 0;
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        static stp_around around;
        make_around(seed, &around);
        const float firsts[] = {1e-4f, 0.01f, 0.3f, 100.0f};
        for (uint32_t k = 0; k < 4; ++k) {
            stp_plane_cell cell = cut(kernels, &around, firsts[k], 0.3f);
            CHECK(is_cell_of_all(&cell, &around));
            for (uint32_t i = 0; i < around.count; ++i) { // the cell ends before these
                float square = around.x[i] * around.x[i] + around.y[i] * around.y[i];
                left_out += square < INFINITY && square >= cell.beyond ? 1 : 0;
            }
        }
    }
    CHECK(left_out > 1000);
}

// Points at almost the same place, whose squared distance is not a normal number, do not count.
void test_growth_cells_of_points_at_almost_one_place_are_finite(test_state* test)
{
    const stp_growth_kernels* all[] = {&stp_growth_kernels_portable, stp_growth_kernels_select()};
    static stp_around around;
    make_around(3, &around);
    around.x[0] = 1e-20f, around.y[0] = 2e-21f, around.z[0] = 0.0f;
    for (int i = 0; i < 2; ++i) {
        stp_plane_cell cell = cut(all[i], &around, 0.01f, 0.3f);
        for (int k = 0; k < STP_GROWTH_DIRECTIONS; ++k) {
            CHECK(cell.nearness[k] < 1e6f); // not NaN
        }
        CHECK(cell.least > 0.0f);
    }
}
