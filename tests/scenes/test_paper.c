// SPDX-License-Identifier: MIT
//
// Content of the views of `paper`, from plans, without making triangles.
#include "support_scenes.h"

#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/paper.h"
#include "lab/scenes/terrain.h"
#include "lab/scenes/trees.h"

#include <math.h>

#define ASPECT (16.0 / 9.0)

// Whether a sphere may be visible: it intersects all four half spaces of the frustum, which has no
// far plane.
static bool is_seen(const paper_view* view, stp_vec3d center, double radius)
{
    stp_vec3d gaze = stp_normalized(stp_subd(view->target, view->eye));
    stp_vec3d right = stp_normalized(stp_crossd(gaze, (stp_vec3d){0, 1, 0}));
    stp_vec3d up = stp_crossd(right, gaze), to = stp_subd(center, view->eye);
    double tall = tan(0.5 * view->fov_degrees * STP_PI / 180.0), wide = tall * ASPECT;
    double z = stp_dotd(to, gaze), x = fabs(stp_dotd(to, right)), y = fabs(stp_dotd(to, up));
    return z > -radius && x - wide * z < radius * sqrt(1.0 + wide * wide) &&
           y - tall * z < radius * sqrt(1.0 + tall * tall);
}

// A part's triangles, assumed to be evenly distributed over its site.
static double seen_of_site(const paper_view* view, const terrain_site* site, double triangles)
{
    int seen = 0;
    for (int i = 0; i < 400; ++i) {
        double u = (i % 20 + 0.5) / 10.0 - 1.0, v = (i / 20 + 0.5) / 10.0 - 1.0;
        stp_vec3d p = {site->x + u * site->half_width, 4.0, site->z + v * site->half_depth};
        seen += is_seen(view, p, 3.0) ? 1 : 0;
    }
    return triangles * seen / 400.0;
}

void test_paper_views_hold_what_table3_says(test_state* test)
{
    static const double site_triangles[SITE_COUNT] = {62.93e6, 75.85e6, 267.80e6, 186.00e6};
    stp_context* context = test_context(NULL, 1, NULL);
    terrain_map map;
    terrain_map_make(&map, 0);
    terrain_tree* trees = terrain_plant_trees(context, &map, 30000);
    CHECK(trees != NULL);
    double sums[PAPER_VIEWS] = {0};
    for (int i = 0; i < 30000; ++i) {
        stp_vec3d middle = {trees[i].x, terrain_height(&map, trees[i].x, trees[i].z) + 8.0,
                            trees[i].z};
        for (int v = 0; v < PAPER_VIEWS; ++v) {
            sums[v] += is_seen(&paper_views[v], middle, 6.0) ? tree_triangles(trees[i].kind) : 0;
        }
    }
    for (int v = 0; v < PAPER_VIEWS; ++v) {
        for (int s = 0; s < SITE_COUNT; ++s) {
            sums[v] += seen_of_site(&paper_views[v], &terrain_sites[s], site_triangles[s]);
        }
        if (sums[v] < paper_views[v].table3_triangles) {
            fprintf(stderr, "view %s holds %.1f M of %.1f M\n", paper_views[v].name, sums[v] * 1e-6,
                    paper_views[v].table3_triangles * 1e-6);
        }
    }
    stp_free(context, trees);
    stp_context_destroy(context);
    for (int v = 0; v < PAPER_VIEWS; ++v) {
        CHECK(sums[v] >= paper_views[v].table3_triangles);
    }
}

// 43 of the 441 copies are 100 G triangles.
void test_paper_huge_views_hold_100_g_triangles(test_state* test)
{
    for (int v = 0; v < PAPER_VIEWS; ++v) {
        int seen = 0;
        for (int i = 0; i < 441; ++i) {
            stp_vec3d center = {TILE_SIZE * TILE_COLUMNS * (i % 21 - 10), 0.0,
                                TILE_SIZE * TILE_ROWS * (i / 21 - 10)};
            seen += is_seen(&paper_views[v], center, 0.0) ? 1 : 0;
        }
        CHECK(seen >= 43);
    }
}

// Table 1's totals exceed the sums of its rows: by 0.08 M unique triangles, and 305 objects, one of
// them unique.
void test_pylons_make_up_the_totals_of_table1(test_state* test)
{
    size_t triangles = count_triangles(pylon_make, NULL);
    CHECK(triangles >= 50000 && triangles <= 80000);
    double unique = 1.73e6 + 40.35e6 + 3.97e6 + 27.70e6 + 12.40e6 + (double)triangles;
    CHECK(fabs(unique - 86.23e6) < 0.001 * 86.23e6);
    double all = 1.74e9 + 62.93e6 + 75.85e6 + 267.80e6 + 186.00e6 + 305.0 * (double)triangles;
    CHECK(fabs(all - 2.35e9) < 0.001 * 2.35e9);
    CHECK_EQUAL(28397, 524 + 26878 + 179 + 511 + 304 + 1);
    CHECK_EQUAL(77495, 30518 + 33167 + 1708 + 7237 + 4560 + 305);
}
