// SPDX-License-Identifier: MIT
// The order within leaves, and the points of a set that are kept
// (src/lod/stochastic/spread_order.c, trim.c), against brute force.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "lod/stochastic/leaf_passes.h"

#include <math.h>
#include <string.h>

enum { POINTS = 3000 };

static uint32_t place(uint64_t seed, uint64_t index)
{
    return (uint32_t)(stp_rng_hash(seed, index) & 0xFFFFu);
}

/// A sheet; for odd seeds, nine tenths of it in one corner.
static void make_points(uint16_t* at, uint64_t seed)
{
    for (uint64_t i = 0; i < POINTS; ++i) {
        uint32_t shift = seed % 2 == 1 && i % 10 != 0 ? 3 : 0;
        at[3 * i] = (uint16_t)(place(seed, 3 * i) >> shift);
        at[3 * i + 1] = (uint16_t)(20000 + (at[3 * i] >> 3));
        at[3 * i + 2] = (uint16_t)(place(seed, 3 * i + 1) >> shift);
    }
}

/// Squared distance in a leaf with periodic boundaries, in units of its side.
static double distance(const uint16_t* a, const uint16_t* b, const stp_leaf_cell* leaf)
{
    double sum = 0.0, width = (double)stp_leaf_width(leaf->depth);
    for (int k = 0; k < 3; ++k) {
        double d = fabs((double)a[k] - (double)b[k]) / width;
        d = d > 0.5 ? 1.0 - d : d;
        sum += d * d;
    }
    return sum;
}

// Each of the first points of a leaf is the farthest from the previous ones.
void test_spread_order_takes_the_farthest(test_state* test)
{
    static uint16_t at[3 * POINTS];
    static uint32_t ranked[POINTS];
    static bool met[POINTS];
    const double close = 3.0 / 65536.0 * 4.0; // squared distances have 15 bits
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 4; ++seed) {
        make_points(at, seed);
        stp_leaf_desc desc = stp_leaf_desc_default();
        stp_leaf_octree o;
        CHECK_EQUAL(STP_OK, stp_leaf_octree_make(context, at, POINTS, &desc, seed, &o));
        stp_spread_order_make(context, at, &o, ranked);
        for (uint32_t l = 0; l < o.leaf_count; ++l) {
            const stp_leaf_cell* leaf = &o.leaves[l];
            const uint32_t* mine = ranked + leaf->begin;
            uint32_t count = leaf->end - leaf->begin, maximum = count > 4 ? count / 4 : 0;
            for (uint32_t n = 1; n < maximum; n += 1 + n / 8) {
                double farthest = 0.0, taken = 0.0;
                for (uint32_t i = n; i < count; ++i) {
                    double nearest = 3.0;
                    for (uint32_t k = 0; k < n; ++k) {
                        double d =
                            distance(at + 3 * (size_t)mine[i], at + 3 * (size_t)mine[k], leaf);
                        nearest = d < nearest ? d : nearest;
                    }
                    farthest = nearest > farthest ? nearest : farthest;
                    taken = i == n ? nearest : taken;
                }
                CHECK(taken >= farthest - close);
            }
        }
        // after placement, the octaves draw each leaf's points in that order
        memset(met, 0, sizeof(met));
        uint32_t octaves = stp_leaf_octaves(POINTS);
        stp_spread_order_place(context, ranked, POINTS, &o);
        for (uint32_t l = 0; l < o.leaf_count; ++l) {
            const uint32_t* next = ranked + o.leaves[l].begin;
            for (uint32_t octave = 0; octave < octaves; ++octave) {
                for (uint32_t i = o.leaves[l].begin; i < o.leaves[l].end; ++i) {
                    if (stp_leaf_octave_of(i + 1, octaves) == octave) {
                        CHECK_EQUAL(*next, o.order[i]);
                        CHECK(!met[*next]);
                        met[*next++] = true;
                    }
                }
            }
        }
        stp_leaf_octree_destroy(context, &o);
    }
    stp_context_destroy(context);
}

// Exactly the requested number, the first points of each leaf; sparse leaves keep all before dense
// ones keep more.
void test_trimmed_leaves_are_as_dense_as_they_can_be(test_state* test)
{
    enum { LEAVES = 50 };
    for (uint64_t seed = 0; seed < 8; ++seed) {
        stp_leaf_cell leaves[LEAVES];
        static stp_leaf_properties properties[LEAVES];
        static uint32_t ranked[LEAVES * 100];
        uint32_t all = 0;
        for (uint32_t l = 0; l < LEAVES; ++l) {
            uint32_t count = 1 + (uint32_t)(stp_rng_hash(seed, l) % 99);
            leaves[l] = (stp_leaf_cell){.begin = all, .end = all + count, .depth = 3};
            properties[l] = (stp_leaf_properties){.normal = {0, 1, 0}};
            properties[l].area = (float)(10 + stp_rng_hash(seed, 100 + l) % 500);
            properties[l].flatness = (float)l;
            for (uint32_t i = 0; i < count; ++i) {
                ranked[all + i] = 1000 * l + i;
            }
            all += count;
        }
        const uint32_t wanteds[] = {1, all / 7, all / 2, all - 1};
        uint32_t wanted = wanteds[seed % 4], kept = 0;
        stp_leaf_octree o = {.leaf_count = LEAVES, .leaves = leaves};
        uint32_t had[LEAVES];
        for (uint32_t l = 0; l < LEAVES; ++l) {
            had[l] = leaves[l].end - leaves[l].begin;
        }
        stp_leaf_trim(&o, properties, ranked, wanted);
        // densities of points: the highest of leaves that kept all, and the lowest of the others
        double thickest = 0.0, thinnest = HUGE_VAL;
        for (uint32_t l = 0; l < o.leaf_count; ++l) {
            uint32_t was = (uint32_t)properties[l].flatness,
                     count = leaves[l].end - leaves[l].begin;
            CHECK_EQUAL(kept, leaves[l].begin);
            CHECK(count > 0 && count <= had[was]);
            for (uint32_t i = 0; i < count; ++i) {
                CHECK_EQUAL(1000 * was + i, ranked[kept + i]);
            }
            kept += count;
            if (count == had[was]) {
                thickest = fmax(thickest, ((double)count - 1.0) / (double)properties[l].area);
            } else {
                thinnest = fmin(thinnest, ((double)count + 1.0) / (double)properties[l].area);
            }
        }
        CHECK_EQUAL(wanted, kept);
        CHECK(thickest <= thinnest * 1.5);
    }
}
