// SPDX-License-Identifier: MIT
// Patches of items that touch.
#include "tests.h"

#include "base/math/rng.h"
#include "lod/levels/mesh_edges.h"
#include "lod/levels/patches.h"

#include <math.h>
#include <string.h>

enum { SIDE = 24, TRIANGLES = 2 * SIDE * SIDE, VERTICES = (SIDE + 1) * (SIDE + 1) };

static uint32_t indices[3 * TRIANGLES], item_of[TRIANGLES];
static float centers[3 * TRIANGLES];

static void make_square(void)
{
    for (uint32_t y = 0; y < SIDE; ++y) {
        for (uint32_t x = 0; x < SIDE; ++x) {
            uint32_t v = y * (SIDE + 1) + x, t = 2 * (y * SIDE + x);
            const uint32_t two[6] = {v, v + 1, v + SIDE + 1, v + 1, v + SIDE + 2, v + SIDE + 1};
            memcpy(indices + (size_t)3 * t, two, sizeof(two));
            for (uint32_t k = 0; k < 2; ++k) {
                centers[3 * (t + k)] = (float)x + 0.33f * (float)(k + 1);
                centers[3 * (t + k) + 1] = (float)y + 0.33f * (float)(k + 1);
                centers[3 * (t + k) + 2] = 0.0f;
                item_of[t + k] = t + k;
            }
        }
    }
}

void test_edges_are_sorted_together(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    make_square();
    stp_mesh_edges edges;
    CHECK(stp_mesh_edges_make(context, indices, TRIANGLES, VERTICES, &edges));
    uint32_t open = 0, shared = 0, before[2] = {0, 0};
    for (uint32_t e = 0, i = 0; e < edges.count; i = edges.ends[e++]) {
        uint32_t ends[2], others[2], end = edges.ends[e];
        stp_edge_ends(indices, edges.corners[i], ends);
        stp_edge_ends(indices, edges.corners[end - 1], others);
        CHECK(end - i == 1 || (end - i == 2 && edges.corners[i] < edges.corners[i + 1]));
        CHECK(ends[0] == others[0] && ends[1] == others[1]);
        CHECK(ends[0] > before[0] || (ends[0] == before[0] && ends[1] > before[1]));
        memcpy(before, ends, sizeof(before));
        open += end - i == 1 ? 1 : 0;
        shared += end - i == 2 ? 1 : 0;
    }
    CHECK_EQUAL(4 * SIDE, open);
    CHECK_EQUAL((3 * TRIANGLES - 4 * SIDE) / 2, shared);
    stp_mesh_edges_destroy(context, &edges);
    stp_context_destroy(context);
}

// Links of random items against every pair of triangles.
void test_patch_links_are_common_edges(test_state* test)
{
    enum { ITEMS = 40 };
    static uint32_t common[ITEMS][ITEMS];
    stp_context* context = test_context(NULL, 1, NULL);
    make_square();
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
        item_of[t] = (uint32_t)(stp_rng_hash(7, t) % ITEMS);
    }
    for (uint32_t a = 0; a < TRIANGLES; ++a) {
        for (uint32_t b = 0; b < TRIANGLES; ++b) {
            uint32_t same = 0;
            for (int i = 0; i < 9; ++i) {
                same += indices[3 * a + (uint32_t)i / 3] == indices[3 * b + (uint32_t)i % 3];
            }
            common[item_of[a]][item_of[b]] += a != b && same == 2 ? 1 : 0;
        }
    }
    stp_patch_links links;
    CHECK_EQUAL(STP_OK, stp_patch_links_make(context, indices, TRIANGLES, VERTICES, item_of, ITEMS,
                                             &links));
    for (uint32_t a = 0; a < ITEMS; ++a) {
        uint32_t k = links.first[a];
        for (uint32_t b = 0; b < ITEMS; ++b) {
            if (a != b && common[a][b] > 0) {
                CHECK(k < links.first[a + 1] && links.neighbours[k] == b &&
                      links.weights[k] == common[a][b]);
                k += 1;
            }
        }
        CHECK_EQUAL(links.first[a + 1], k);
    }
    stp_patch_links_destroy(context, &links);
    stp_context_destroy(context);
}

void test_patches_are_compact(test_state* test)
{
    static uint32_t members[TRIANGLES], ends[TRIANGLES], patch_of[TRIANGLES];
    stp_context* context = test_context(NULL, 1, NULL);
    make_square();
    for (uint32_t maximum = 1; maximum <= 256; maximum *= 4) {
        stp_patch_links links;
        uint32_t patches, begin = 0, cut = 0;
        CHECK_EQUAL(STP_OK, stp_patch_links_make(context, indices, TRIANGLES, VERTICES, item_of,
                                                 TRIANGLES, &links));
        CHECK_EQUAL(STP_OK, stp_grow_patches(context, &links, centers, TRIANGLES, maximum, members,
                                             ends, &patches));
        memset(patch_of, 0xff, sizeof(patch_of));
        for (uint32_t p = 0; p < patches; ++p) {
            CHECK(ends[p] > begin && (p + 1 == patches || ends[p] - begin == maximum));
            for (; begin < ends[p]; ++begin) {
                CHECK(members[begin] < TRIANGLES && patch_of[members[begin]] == UINT32_MAX);
                patch_of[members[begin]] = p;
            }
        }
        CHECK_EQUAL(TRIANGLES, begin);
        for (uint32_t t = 0; t < TRIANGLES; ++t) {
            for (uint32_t k = links.first[t]; k < links.first[t + 1]; ++k) {
                cut += patch_of[t] < patch_of[links.neighbours[k]] ? 1 : 0;
            }
        }
        // a square of m triangles has a border of 4 sqrt(m / 2) edges, which two patches share
        double ideal = 2.0 * sqrt((double)maximum / 2.0) * patches;
        CHECK(maximum == 1 || (double)cut < 1.5 * ideal);
        stp_patch_links_destroy(context, &links);
    }
    stp_context_destroy(context);
}
