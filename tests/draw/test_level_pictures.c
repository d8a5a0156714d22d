// SPDX-License-Identifier: MIT
// Pictures of levels of triangles have no holes, and show what the originals show; and the views
// that must not show levels.
#include "tests.h"

#include "base/math/rng.h"
#include "builder/support_level_scenes.h"
#include "draw/draw.h"
#include "select/sections.h"
#include "select/select_internal.h"
#include "select/visibility.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 128, PIXELS = SIDE * SIDE, STEPS = 60 };

/// Pictures of a scene: by originals, and with levels.
typedef struct pictures {
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_view view;
    stp_quality quality;
    uint8_t reference[4 * PIXELS], pixels[4 * PIXELS];
    float reference_depths[PIXELS], depths[PIXELS]; ///< nearness
} pictures;

static bool begin_pictures(pictures* p, level_scene* make, bool splats)
{
    const level_build build = {.make = make, .no_splats = !splats};
    *p = (pictures){.context = test_context(NULL, 2, NULL), .quality = {.splat_size = 1}};
    p->view = (stp_view){.up = {0, 1, 0}, .fov_degrees = 45, .width = SIDE, .height = SIDE};
    p->store = level_build_open(p->context, &build);
    return p->store != NULL && stp_draw_cpu_create(p->context, p->store, &p->renderer) == STP_OK;
}

static void end_pictures(pictures* p)
{
    stp_renderer_destroy(p->renderer);
    stp_draw_list_destroy(p->context, &p->list);
    stp_store_close(p->store);
    stp_context_destroy(p->context);
}

static stp_result draw(pictures* p, const stp_quality* quality, uint8_t* pixels, float* depths)
{
    const stp_draw_style style = {.headlight = true};
    stp_image image = {SIDE, SIDE, pixels};
    stp_draw_stats stats;
    stp_result result = stp_select(p->context, p->store, &p->view, quality, &p->list);
    result = result == STP_OK
                 ? stp_renderer_draw(p->renderer, &p->view, &p->list, &style, &image, &stats)
                 : result;
    if (result == STP_OK) {
        memcpy(depths, stp_renderer_depth(p->renderer), PIXELS * sizeof(*depths));
    }
    return result;
}

static stp_result draw_both(pictures* p)
{
    const stp_quality originals = {.splat_size = 1, .reference = true};
    stp_result result = draw(p, &originals, p->reference, p->reference_depths);
    return result == STP_OK ? draw(p, &p->quality, p->pixels, p->depths) : result;
}

/// Items of the list that are levels, or are not.
static uint32_t count_items(const pictures* p, bool levels)
{
    uint32_t count = 0;
    for (size_t i = 0; i < p->list.count; ++i) {
        count += p->list.items[i].is_level == levels ? 1 : 0;
    }
    return count;
}

/// What is wrong with a picture.
typedef struct faults {
    uint32_t covered[2]; ///< pixels of the reference, and of the picture
    uint32_t checked, holes, deep;
    double difference; ///< mean of the colours' differences, 0 to 255
} faults;

/// Compares pixels around which the reference is covered: `around` pixels to each side.
static faults find_faults(const pictures* p, int around, double depth_tolerance)
{
    faults f = {0};
    for (size_t i = 0; i < PIXELS; ++i) {
        f.covered[0] += p->reference[4 * i + 3] != 0 ? 1 : 0;
        f.covered[1] += p->pixels[4 * i + 3] != 0 ? 1 : 0;
    }
    for (int y = around; y < SIDE - around; ++y) {
        for (int x = around; x < SIDE - around; ++x) {
            size_t at = (size_t)(y * SIDE + x);
            float low = HUGE_VALF, high = 0.0f;
            for (int k = 0; k < (2 * around + 1) * (2 * around + 1); ++k) {
                int dx = k % (2 * around + 1) - around, dy = k / (2 * around + 1) - around;
                float nearness = p->reference_depths[(y + dy) * SIDE + x + dx];
                low = fminf(low, nearness);
                high = fmaxf(high, nearness);
            }
            if (!(low > 0.0f)) {
                continue;
            }
            double is = (double)p->depths[at];
            f.checked += 1;
            f.holes += p->pixels[4 * at + 3] == 0 ? 1 : 0;
            f.deep += is < (double)low * (1.0 - depth_tolerance) ||
                              is > (double)high * (1.0 + depth_tolerance)
                          ? 1
                          : 0;
            for (size_t c = 0; c < 3; ++c) {
                f.difference += abs(p->pixels[4 * at + c] - p->reference[4 * at + c]) / 3.0;
            }
        }
    }
    f.difference /= f.checked > 0 ? f.checked : 1;
    return f;
}

static double random_number(uint64_t step, uint64_t index)
{
    return (double)(stp_rng_hash(step, index) >> 40) / 0x1p24;
}

/// Distance of a step: most are near.
static double distance_of(uint64_t step)
{
    const uint64_t near = STEPS - 10;
    return step < near ? 0.002 * pow(1.5e4, (double)step / (double)near)
                       : 30.0 * pow(100.0, (double)(step - near) / 9.0);
}

/// A view from a random side, at a distance from a ball around the origin.
static void look_from(pictures* p, uint64_t step, double radius, double distance)
{
    double y = 2.0 * random_number(step, 0) - 1.0, a = 2.0 * STP_PI * random_number(step, 1);
    double flat = sqrt(1.0 - y * y), far = radius + distance;
    stp_vec3d target = {random_number(step, 2) - 0.5, random_number(step, 3) - 0.5,
                        random_number(step, 4) - 0.5};
    p->view.eye = (stp_vec3d){far * flat * cos(a), far * y, far * flat * sin(a)};
    p->view.target = stp_scaled(target, 0.8 * radius);
}

// From touching to a thousand diagonals.
static void check_flight(test_state* test, level_scene* make, double radius, bool splats)
{
    static pictures p;
    CHECK(begin_pictures(&p, make, splats));
    uint32_t with_levels = 0;
    for (uint64_t i = 0; i < STEPS; ++i) {
        double pixel = 2.0 * tan(STP_PI / 8.0) / SIDE;
        int size = i % 4 == 3 ? 3 : 1;
        look_from(&p, i, radius, radius * distance_of(i));
        p.quality.splat_size = (float)size;
        CHECK_EQUAL(STP_OK, draw_both(&p));
        // the depths of splats are not those of the surface
        faults f = find_faults(&p, 2 * size, splats ? 1.0 : 4.0 * pixel * size);
        CHECK_EQUAL(0, f.holes);
        CHECK_EQUAL(0, f.deep);
        CHECK(size > 1 || f.checked < 300 || f.difference < 4.0);
        CHECK(size > 1 || f.covered[0] < 100 || f.covered[1] >= f.covered[0] * 4 / 5);
        with_levels += count_items(&p, true) > 0 ? 1 : 0;
    }
    CHECK(with_levels > STEPS / 2);
    end_pictures(&p);
}

void test_level_pictures_of_a_torus_have_no_holes(test_state* test)
{
    check_flight(test, level_scene_torus, 1.5, false);
}

void test_level_pictures_with_splats_have_no_holes(test_state* test)
{
    check_flight(test, level_scene_torus, 1.5, true);
}

// A torus in a ball that is open at its top: much of both is hidden, but seen through the opening.
void test_level_pictures_show_what_openings_show(test_state* test)
{
    check_flight(test, level_scene_open_ball, 1.8, false);
}

void test_level_pictures_in_parallel_projection_have_no_holes(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, false));
    for (uint64_t i = 0; i < 12; ++i) {
        look_from(&p, i, 1.5, 3.0);
        p.view.ortho_height = 0.5 * pow(1.4, (double)i);
        CHECK_EQUAL(STP_OK, draw_both(&p));
        faults f = find_faults(&p, 2, 1.0);
        CHECK(f.holes == 0 && (f.checked < 300 || f.difference < 4.0));
        CHECK(i < 6 || count_items(&p, true) > 0);
    }
    end_pictures(&p);
}

/// Selects. @return the number of items that are levels
static uint32_t select_levels(test_state* test, pictures* p)
{
    CHECK_EQUAL(STP_OK, stp_select(p->context, p->store, &p->view, &p->quality, &p->list));
    return count_items(p, true);
}

// A view in which levels are drawn.
static void look_well(pictures* p)
{
    p->view.eye = (stp_vec3d){0.5, 2.5, 2.0};
    p->view.target = (stp_vec3d){0.5, 0, 0};
    p->view.sections.count = 0;
    p->quality = (stp_quality){.splat_size = 2};
}

/// Allowed error of a level at depth 1, scene units; 0: no level is drawn.
static double error_of_levels(test_state* test, pictures* p, float splat_size)
{
    double error = 0.0;
    p->quality.splat_size = splat_size;
    CHECK(select_levels(test, p) > 0);
    for (size_t i = 0; i < p->list.count; ++i) {
        if (p->list.items[i].is_level) {
            error = (double)p->list.items[i].level_per_depth;
        }
    }
    return error;
}

void test_errors_of_levels_grow_with_the_root_of_the_splat_size(test_state* test)
{
    CHECK(fabs(stp_select_level_error(2) - 1.4) < 1e-9);
    CHECK(fabs(stp_select_level_error(1) - 0.35) < 1e-9);
    CHECK(fabs(stp_select_level_error(8) - 2.8) < 1e-9);
    CHECK(fabs(stp_select_level_error(18) - 4.2) < 1e-9);
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, false)); // without splats levels are always drawn
    const double pixel = 2.0 * tan(22.5 * STP_PI / 180.0) / SIDE;
    for (float size = 1.0f; size <= 18.0f; size += 1.0f) {
        look_well(&p);
        p.view.eye = (stp_vec3d){0.5, 25, 20}; // small triangles
        double error = error_of_levels(test, &p, size);
        CHECK(fabs(error - stp_select_level_error((double)size) * pixel) < 1e-6 * error);
    }
    end_pictures(&p);
}

// From nearby, triangles of the allowed error cover many pixels each: finer ones are drawn.
void test_levels_of_large_triangles_are_finer(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, false));
    const double pixel = 2.0 * tan(22.5 * STP_PI / 180.0) / SIDE;
    double last = HUGE_VAL;
    uint32_t between = 0;
    for (double far = 1.0; far < 12.0; far *= 1.05) {
        p.view.sections.count = 0;
        p.view.eye = (stp_vec3d){0.5, 2.5 * far, 2.0 * far};
        p.view.target = (stp_vec3d){0.5, 0, 0};
        double error = error_of_levels(test, &p, 18) / pixel; // pixels
        CHECK(error > 1.4 * (1.0 - 1e-6) && error < 4.2 * (1.0 + 1e-6));
        CHECK(far > 1.0 || error < 1.5);
        CHECK(error > 0.97 * last || last == HUGE_VAL); // farther ones may be coarser
        between += error > 1.5 && error < 4.1 ? 1 : 0;
        last = error;
    }
    CHECK(between > 2 && last > 4.1);
    end_pictures(&p);
}

// Large splats have many fragments, so a set is left for levels already where larger errors are
// allowed.
void test_large_splats_give_way_to_levels_earlier(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, true));
    look_well(&p);
    CHECK(select_levels(test, &p) > 0);
    const stp_select_graph* graph = p.list.graph;
    uint32_t opened = 0;
    for (uint32_t i = 0; i < graph->node_count; ++i) {
        const float* opens = graph->opens_below + 2 * (size_t)i;
        // radii, as the errors that go with them
        double fine = (double)opens[0], coarse = (double)opens[1];
        fine *= stp_select_level_error(STP_OPENS_FINE) / STP_OPENS_FINE;
        coarse *= stp_select_level_error(STP_OPENS_COARSE) / STP_OPENS_COARSE;
        opened += fine > 0.0 && coarse > 1.9 * fine ? 1 : 0; // errors are powers of two apart
        CHECK(coarse >= 0.999 * fine);
    }
    CHECK(opened > 0);
    end_pictures(&p);
}

void test_levels_are_not_drawn_where_the_quality_forbids_them(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, true));
    const stp_quality qualities[] = {
        {.splat_size = 1, .reference = true},
        {.splat_size = 1, .method = STP_METHOD_BLUE},
        {.splat_size = 1, .splats_only = true},
        {.splat_size = 1, .nodes_only = true},
        {.splat_size = 1, .splat_count = 500},
        {.splat_size = 1, .policy = STP_POLICY_PAPER},
        {.splat_size = 1, .policy = STP_POLICY_SWITCH},
    };
    for (size_t i = 0; i < sizeof(qualities) / sizeof(qualities[0]); ++i) {
        look_well(&p);
        CHECK(select_levels(test, &p) > 0);
        p.quality = qualities[i];
        CHECK_EQUAL(0, select_levels(test, &p));
        CHECK(count_items(&p, false) > 0);
    }
    end_pictures(&p);
}

void test_levels_are_not_drawn_where_sections_may_cut(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_torus, true));
    look_well(&p);
    CHECK(stp_sections_add_plane(&p.view.sections, (stp_vec3d){5, 0, 0}, (stp_vec3d){1, 0, 0}));
    CHECK(select_levels(test, &p) > 0); // it does not reach the torus
    CHECK(stp_sections_add_plane(&p.view.sections, (stp_vec3d){0.5, 0, 0}, (stp_vec3d){1, 0, 0}));
    CHECK_EQUAL(0, select_levels(test, &p));
    CHECK(count_items(&p, false) > 0);
    end_pictures(&p);
}

void test_levels_are_not_drawn_of_ghosts_and_partly_hidden_nodes(test_state* test)
{
    static pictures p;
    stp_visibility* visibility = NULL;
    CHECK(begin_pictures(&p, level_scene_two_tori, true));
    look_well(&p);
    p.view.eye = (stp_vec3d){1.5, 4, 4};
    CHECK_EQUAL(STP_OK, stp_visibility_create(p.context, p.store, &visibility));
    p.quality.visibility = visibility;
    CHECK(select_levels(test, &p) > 0);
    const stp_store_directory* d = stp_store_get_directory(p.store);
    const stp_store_node* root = &d->nodes[d->root];
    CHECK(root->edge_count == 2 && d->level_count > 0);
    for (uint32_t i = 0; i < d->level_count; ++i) {
        CHECK_EQUAL(d->root, d->levels[i].node);
    }
    const stp_store_edge* edge = &d->edges[root->first_edge];
    const stp_placed_node first = {edge->node, edge->transform};
    static const stp_show shows[] = {STP_SHOW_NOT, STP_SHOW_GHOST};
    for (int i = 0; i < 2; ++i) {
        CHECK_EQUAL(STP_OK, stp_visibility_set(visibility, &first, shows[i]));
        CHECK_EQUAL(0, select_levels(test, &p));
        CHECK(count_items(&p, false) > 0);
    }
    stp_visibility_reset(visibility, STP_SHOW_GHOST);
    CHECK_EQUAL(0, select_levels(test, &p));
    stp_visibility_reset(visibility, STP_SHOW_NOT);
    CHECK_EQUAL(0, select_levels(test, &p));
    stp_visibility_reset(visibility, STP_SHOW);
    CHECK(select_levels(test, &p) > 0);
    stp_visibility_destroy(visibility);
    end_pictures(&p);
}

void test_levels_from_outside_are_not_drawn_from_inside(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_open_ball, true));
    const stp_store_directory* d = stp_store_get_directory(p.store);
    for (uint32_t i = 0; i < d->level_count; ++i) {
        CHECK_EQUAL(STP_LEVEL_FROM_OUTSIDE, d->levels[i].flags);
    }
    look_well(&p);
    CHECK(select_levels(test, &p) > 0);
    for (int size = 1; size <= 8; size *= 8) {
        p.quality.splat_size = (float)size;
        p.view.eye = (stp_vec3d){0.1, 0.5, 0.2};
        p.view.target = (stp_vec3d){0.3, -1, 0};
        CHECK_EQUAL(0, select_levels(test, &p));
        CHECK_EQUAL(STP_OK, draw_both(&p));
        faults f = find_faults(&p, 2 * size, 1.0);
        CHECK(f.checked > 100 && f.holes == 0);
    }
    // one of two eyes is inside
    p.view.eye = (stp_vec3d){1.2, 0, 0};
    p.view.target = (stp_vec3d){1.2, 0, -1};
    p.view.eye_distance = 1.0;
    CHECK_EQUAL(0, select_levels(test, &p));
    end_pictures(&p);
}

void test_levels_of_sheets_are_drawn_from_inside(test_state* test)
{
    static pictures p;
    CHECK(begin_pictures(&p, level_scene_sheet, true));
    const stp_store_directory* d = stp_store_get_directory(p.store);
    CHECK(d->level_count > 0 && d->levels[0].flags == 0);
    look_well(&p);
    p.view.eye = (stp_vec3d){0.02, 0.019, 0.02};
    p.view.target = (stp_vec3d){1, 0, 1};
    p.quality.splat_size = 8;
    CHECK(select_levels(test, &p) > 0);
    end_pictures(&p);
}
