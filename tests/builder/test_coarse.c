// SPDX-License-Identifier: MIT
// Coarse ellipses in built files: few splats are drawn by them, and stay near the silhouette.
#include "same_files.h"
#include "support_level_scenes.h"

#include "draw/draw.h"
#include "select/camera.h"

#include <stdlib.h>
#include <unistd.h>

enum { SIDE = 96 };

typedef struct picture {
    uint8_t pixels[4 * SIDE * SIDE];
    uint64_t splats;  ///< drawn states and prefixes
    bool of_ellipses; ///< all items are of the coarse method
} picture;

static stp_result draw(stp_context* context, stp_store* store, stp_quality quality, picture* made)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    stp_view view = {.width = SIDE, .height = SIDE, .fov_degrees = 40};
    stp_image image = {SIDE, SIDE, made->pixels};
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_draw_style style = {0};
    stp_result result = stp_camera_frame("iso", &d->nodes[d->root].bounds, &view)
                            ? stp_draw_cpu_create(context, store, &renderer)
                            : STP_ERROR_ARGUMENT;
    result = result == STP_OK ? stp_select(context, store, &view, &quality, &list) : result;
    result = result == STP_OK ? stp_renderer_draw(renderer, &view, &list, &style, &image, &stats)
                              : result;
    made->splats = 0;
    made->of_ellipses = list.count > 0;
    for (size_t i = 0; i < list.count; ++i) {
        made->splats += list.items[i].prefix - list.items[i].split_count;
        uint32_t first = d->methods[d->method_count - 1].first_set;
        made->of_ellipses = made->of_ellipses && list.items[i].index >= first;
    }
    stp_renderer_destroy(renderer);
    stp_draw_list_destroy(context, &list);
    return result;
}

/// Pixels that picture `a` covers and `b` does not.
static uint32_t count_outside(const picture* a, const picture* b)
{
    uint32_t outside = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        outside += a->pixels[4 * i + 3] > 127 && b->pixels[4 * i + 3] <= 127;
    }
    return outside;
}

void test_few_splats_stay_near_the_silhouette(test_state* test)
{
    static picture original, nothing, ellipses, disks;
    stp_context* context = test_context(NULL, 2, NULL);
    const level_build build = {.make = level_scene_torus, .coarse = true, .no_levels = true};
    stp_store* store = level_build_open(context, &build);
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(1, stp_store_offered_methods(d));
    CHECK_EQUAL(2, d->method_count);
    CHECK_EQUAL(STP_OK, draw(context, store, (stp_quality){.reference = true}, &original));
    double whole = count_outside(&original, &nothing);
    CHECK(whole > SIDE * SIDE / 8.0);
    static const struct {
        uint64_t splats;
        double outside, missing; ///< at most, of the silhouette
    } cases[] = {{10, 0.5, 0.1}, {30, 0.3, 0.05}, {80, 0.2, 0.02}};
    for (int i = 0; i < 3; ++i) {
        stp_quality quality = {.splat_count = cases[i].splats};
        CHECK_EQUAL(STP_OK, draw(context, store, quality, &ellipses));
        CHECK_EQUAL(cases[i].splats, ellipses.splats);
        CHECK(ellipses.of_ellipses);
        quality.method = STP_METHOD_BLUE;
        CHECK_EQUAL(STP_OK, draw(context, store, quality, &disks));
        CHECK_EQUAL(cases[i].splats, disks.splats);
        CHECK(!disks.of_ellipses);
        double outside = count_outside(&ellipses, &original) / whole;
        double missing = count_outside(&original, &ellipses) / whole;
        double of_disks = count_outside(&disks, &original) / whole;
        printf("%d splats: %.3f outside, %.3f missing; disks: %.3f outside\n", (int)cases[i].splats,
               outside, missing, of_disks);
        CHECK(outside <= cases[i].outside && missing <= cases[i].missing);
        CHECK(outside < 0.8 * of_disks);
    }
    const stp_quality more = {.splat_count = 400};
    CHECK_EQUAL(STP_OK, draw(context, store, more, &disks));
    CHECK(disks.splats == more.splat_count && !disks.of_ellipses);
    stp_store_close(store);
    stp_context_destroy(context);
}

// Only uppermost sets have coarse ones: states of up to a 28th of their surfels.
void test_coarse_ellipses_are_of_uppermost_sets(test_state* test)
{
    enum { NODES = 256 };
    bool open[NODES] = {false};
    stp_context* context = test_context(NULL, 2, NULL);
    const level_build build = {.make = level_scene_copies, .coarse = true, .no_levels = true};
    stp_store* store = level_build_open(context, &build);
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK(d->method_count == 2 && d->node_count <= NODES);
    printf("%u sets, %u coarse ones\n", d->methods[0].set_count, d->methods[1].set_count);
    CHECK(d->methods[1].set_count >= 1 && d->methods[1].set_count < d->methods[0].set_count);
    open[d->root] = true;
    for (uint32_t i = d->node_count; i-- > 0;) { // parents before children; nothing moves
        uint32_t own = d->nodes[i].set, set = stp_store_set_of(d, 1, i);
        CHECK((set != STP_STORE_NONE) == (open[i] && own != STP_STORE_NONE));
        for (uint32_t k = 0; k < d->nodes[i].edge_count; ++k) {
            uint32_t child = d->edges[d->nodes[i].first_edge + k].node;
            open[child] = open[child] || (open[i] && own == STP_STORE_NONE);
        }
        if (set != STP_STORE_NONE) {
            uint32_t all = stp_store_describe_splat_set(store, own)->count;
            uint32_t count = stp_store_describe_splat_set(store, set)->count;
            CHECK(count <= all / 14 && count >= all / 14 - 12);
        }
    }
    stp_store_close(store);
    stp_context_destroy(context);
}

// The same bytes with any number of threads.
void test_coarse_ellipses_do_not_depend_on_threads(test_state* test)
{
    char folder[] = "stp_coarse_XXXXXX";
    char paths[2][64];
    CHECK(mkdtemp(folder) != NULL);
    for (uint32_t i = 0; i < 2; ++i) {
        const level_build build = {.make = level_scene_two_tori,
                                   .coarse = true,
                                   .no_levels = true,
                                   .leaf_triangles = 4000};
        stp_context* context = test_context(NULL, 1 + 2 * i, NULL);
        snprintf(paths[i], sizeof(paths[i]), "%s/%u.stip", folder, i);
        CHECK_EQUAL(STP_OK, level_build_to(context, &build, paths[i], NULL));
        stp_context_destroy(context);
    }
    CHECK(same_files(paths[0], paths[1]));
    unlink(paths[0]);
    unlink(paths[1]);
    rmdir(folder);
}
