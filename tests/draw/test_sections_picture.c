// SPDX-License-Identifier: MIT
// Pictures with sections, and with ghosts.
#include "support_picture.h"

#include "select/sections.h"
#include "store/clusters/clusters.h"

#include <math.h>
#include <string.h>

static const uint8_t white[3] = {255, 255, 255};
static const double pixels_a_unit = 16.0; // pixels per unit of length in z = 0

typedef enum made_of { OF_TRIANGLES, OF_CLUSTERS, OF_SPLATS, OF_KINDS } made_of;

/// A square of triangles, clusters or splats.
static bool open_square(made_picture* p, made_of kind, uint32_t threads)
{
    stp_coded_mesh coded = {0};
    if (!made_picture_begin(p, NULL, threads)) {
        return false;
    }
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, kind == OF_SPLATS ? white : NULL);
    if (kind == OF_CLUSTERS) {
        if (stp_clusters_encode(p->context, &p->scene.meshes[0], 0x1p-10, &coded) != STP_OK) {
            return false;
        }
        p->scene.coded_meshes = &coded;
    }
    p->quality.splat_size = kind == OF_SPLATS ? 4.0f : 1.0f;
    bool opened = made_picture_open(p) == STP_OK;
    stp_coded_mesh_destroy(p->context, &coded);
    p->scene.coded_meshes = NULL;
    return opened;
}

static bool is_covered(const made_picture* p, int x, int y)
{
    return made_picture_pixel(p, x, y)[3] != 0;
}

void test_sections_cut_triangles_clusters_and_splats_alike(test_state* test)
{
    for (int kind = 0; kind < OF_KINDS; ++kind) {
        made_picture p;
        static uint8_t whole[sizeof(p.pixels)];
        CHECK(open_square(&p, (made_of)kind, 2));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        memcpy(whole, p.pixels, sizeof(whole));
        // a plane that does not reach the square: the same bytes
        CHECK(
            stp_sections_add_plane(&p.view.sections, (stp_vec3d){1.5, 0, 0}, (stp_vec3d){1, 0, 0}));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(memcmp(whole, p.pixels, sizeof(whole)) == 0);
        for (size_t i = 0; i < p.list.count; ++i) {
            CHECK_EQUAL(0, p.list.items[i].sections); // and no tests of fragments
        }
        // a slanted plane: exact for triangles, within a splat's radius for splats
        CHECK(
            stp_sections_add_plane(&p.view.sections, (stp_vec3d){0.2, 0, 0}, (stp_vec3d){2, 1, 0}));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        double room = kind == OF_SPLATS ? 4.0 : 1e-3;
        uint32_t gone = 0;
        for (int y = 0; y < PICTURE_SIDE; ++y) {
            for (int x = 0; x < PICTURE_SIDE; ++x) {
                double sx = (x + 0.5 - PICTURE_SIDE / 2) / pixels_a_unit;
                double sy = -(y + 0.5 - PICTURE_SIDE / 2) / pixels_a_unit;
                double beyond = ((sx - 0.2) * 2 + sy) / sqrt(5) * pixels_a_unit;
                bool before = whole[4 * (y * PICTURE_SIDE + x) + 3] != 0;
                CHECK(!is_covered(&p, x, y) || beyond <= room);
                CHECK(!before || beyond > -room || is_covered(&p, x, y));
                gone += before && !is_covered(&p, x, y) ? 1 : 0;
            }
        }
        CHECK(gone > 200);
        // beyond another plane nothing is left, and no node is opened
        CHECK(
            stp_sections_add_plane(&p.view.sections, (stp_vec3d){0, 0, -1}, (stp_vec3d){0, 0, 1}));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, p.list.count);
        CHECK_EQUAL(0, p.stats.covered_pixels);
        p.view.sections.planes[0].normal = (stp_vec3d){0, 0, 0};
        CHECK_EQUAL(STP_ERROR_ARGUMENT, made_picture_draw(&p));
        made_picture_end(&p);
    }
}

void test_sections_do_not_depend_on_threads_nor_passes(test_state* test)
{
    for (int kind = 0; kind < OF_KINDS; ++kind) {
        static uint8_t first[PICTURE_SIDE * PICTURE_SIDE * 4];
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            made_picture p;
            CHECK(open_square(&p, (made_of)kind, threads));
            stp_view whole = p.view;
            CHECK(stp_sections_add_plane(&p.view.sections, (stp_vec3d){0.3, 0, 0},
                                         (stp_vec3d){1, 3, 0}));
            stp_view cut = p.view;
            for (int i = 0; i < 3;
                 ++i) { // the pyramid is of the uncut picture, then of the cut one
                p.view = i == 0 ? whole : cut;
                CHECK_EQUAL(STP_OK, made_picture_draw(&p));
                if (i == 1 && threads == 1) {
                    memcpy(first, p.pixels, sizeof(first));
                }
                CHECK(i == 0 || memcmp(first, p.pixels, sizeof(first)) == 0);
            }
            made_picture_end(&p);
        }
    }
}

/// Share of the square's pixels that is drawn, with any kind of content.
static double covered_part(const made_picture* p, double* weight)
{
    uint32_t covered = 0;
    *weight = 0.0;
    for (int y = 17; y < 47; ++y) {
        for (int x = 17; x < 47; ++x) {
            covered += is_covered(p, x, y) ? 1 : 0;
            *weight += made_picture_pixel(p, x, y)[3] / 255.0 / 900.0;
        }
    }
    return covered / 900.0;
}

void test_ghosts_cover_a_part_and_become_smooth_at_rest(test_state* test)
{
    for (int kind = 0; kind < OF_KINDS; ++kind) {
        made_picture p;
        stp_visibility* visibility;
        double weight,
            maximum = kind == OF_SPLATS ? 0.65 : 0.3; // this grid's disks overlap sixfold
        CHECK(open_square(&p, (made_of)kind, 2));
        CHECK_EQUAL(STP_OK, stp_visibility_create(p.context, p.store, &visibility));
        stp_visibility_reset(visibility, STP_SHOW_GHOST);
        p.quality.visibility = visibility;
        static uint8_t before[sizeof(p.pixels)];
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        double part = covered_part(&p, &weight);
        CHECK(part > 0.12 && part < maximum);
        memcpy(before, p.pixels, sizeof(before));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(memcmp(before, p.pixels, sizeof(before)) == 0); // no flicker
        p.style.ghost = 0.6f;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        part = covered_part(&p, &weight);
        CHECK(part > 0.45 && part < 0.4 + 1.1 * maximum);
        p.style.ghost = 0.0f;
        p.style.supersample = 8;
        for (int i = 0; i < 64; ++i) {
            CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
        }
        part = covered_part(&p, &weight);
        CHECK(part > 0.95 && weight > 0.12 && weight < maximum);
        stp_visibility_reset(visibility, STP_SHOW_NOT);
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p)); // another list: starts again
        CHECK_EQUAL(0, p.list.count);
        CHECK(covered_part(&p, &weight) == 0.0);
        p.quality.visibility = NULL;
        stp_visibility_destroy(visibility);
        made_picture_end(&p);
    }
}

void test_cut_pictures_of_ghosts_survive_any_allocation_failing(test_state* test)
{
    bool failed = true;
    for (int n = 0; failed; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        stp_visibility* visibility;
        CHECK(made_picture_begin(&p, &heap, 1));
        made_picture_add(&p, 0.0, (stp_vec3d){0, 0, 0}, white);
        made_picture_add(&p, 0.0, (stp_vec3d){0, 0, -1}, NULL);
        p.quality.splat_size = 4.0f;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, stp_visibility_create(p.context, p.store, &visibility));
        stp_visibility_reset(visibility, STP_SHOW_GHOST);
        p.quality.visibility = visibility;
        CHECK(stp_sections_add_plane(&p.view.sections, (stp_vec3d){0, 0, 0}, (stp_vec3d){1, 0, 0}));
        heap.count = 0;
        heap.fail_at = n;
        stp_result result = made_picture_draw(&p);
        failed = result != STP_OK;
        CHECK(!failed || result == STP_ERROR_OUT_OF_MEMORY);
        heap.fail_at = -1;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p)); // the next picture is complete
        CHECK(!is_covered(&p, PICTURE_SIDE / 2 + 8, 20) && p.stats.covered_pixels > 50);
        stp_visibility_destroy(visibility);
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
