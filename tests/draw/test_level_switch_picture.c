// SPDX-License-Identifier: MIT
// How much a picture changes when the drawn levels change: approaches a square through its levels,
// each of another colour, and draws the selections of two consecutive frames from one place.
#include "support_store.h"
#include "tests.h"

#include "draw/draw.h"
#include "program/measure/popping.h"

enum { SIDE = 96, PIXELS = SIDE * SIDE };

static stp_store* open_levels(stp_context* context, made_scene* s)
{
    static const uint8_t dark[3] = {90, 90, 90}, bright[3] = {170, 170, 170};
    *s = (made_scene){.node_count = 2,
                      .edge_count = 1,
                      .part_count = 1,
                      .mesh_count = 1,
                      .material_count = 1,
                      .shading_count = 1,
                      .set_count = 2};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->sets[0] = made_square_set(context, 4, dark);
    s->sets[1] = made_square_set(context, 5, bright);
    s->meshes[0] = made_square(0);
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->edges[0] = (stp_store_edge){0, stp_affine_identity()};
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    s->nodes[0] = (stp_store_node){.part_count = 1, .set = 1, .triangle_count = 2, .bounds = flat};
    s->nodes[1] = (stp_store_node){.edge_count = 1, .set = 0, .triangle_count = 2, .bounds = flat};
    return made_open(context, s);
}

/// Change of the picture's blocks between the selections of consecutive frames.
static stp_result approach(stp_context* context, stp_store* store, stp_policy policy,
                           stp_popping* popping)
{
    static uint8_t pixels[2][4 * PIXELS];
    stp_image before = {SIDE, SIDE, pixels[0]}, after = {SIDE, SIDE, pixels[1]};
    stp_renderer* renderer;
    stp_draw_list list = {0};
    stp_draw_style style = {0};
    stp_draw_stats stats;
    stp_quality quality = {.splat_size = 3, .policy = policy, .early_switch = 2};
    stp_result result = stp_draw_cpu_create(context, store, &renderer);
    bool first = true;
    for (double distance = 24.0; distance > 3.0 && result == STP_OK; distance *= 0.996) {
        stp_view view = {.eye = {0.1 * distance, 0, distance},
                         .up = {0, 1, 0},
                         .fov_degrees = 35,
                         .near_distance = 0.1,
                         .width = SIDE,
                         .height = SIDE};
        if (!first) {
            result = stp_renderer_draw(renderer, &view, &list, &style, &before, &stats);
        }
        result = result == STP_OK ? stp_select(context, store, &view, &quality, &list) : result;
        result = result == STP_OK
                     ? stp_renderer_draw(renderer, &view, &list, &style, &after, &stats)
                     : result;
        if (!first && result == STP_OK) {
            result = stp_popping_add(context, popping, &before, &after, &after, &after);
        }
        first = false;
    }
    stp_draw_list_destroy(context, &list);
    stp_renderer_destroy(renderer);
    return result;
}

// Switching changes a block at once; blending changes it by at most a quarter of that per frame.
void test_level_switch_pops_a_quarter_as_much_as_switching(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_scene scene;
    stp_store* store = open_levels(context, &scene);
    CHECK(store != NULL);
    double all[2];
    for (int i = 0; i < 2; ++i) {
        stp_popping popping;
        CHECK_EQUAL(STP_OK, stp_popping_create(context, &popping));
        CHECK_EQUAL(STP_OK, approach(context, store,
                                     i == 0 ? STP_POLICY_INSERTION : STP_POLICY_SWITCH, &popping));
        all[i] = stp_popping_percentile(&popping, 1.0);
        stp_popping_destroy(context, &popping);
    }
    CHECK(all[1] > 40.0 && all[0] < 0.25 * all[1]);
    for (int i = 0; i < 2; ++i) {
        made_free_set(context, &scene.sets[i]);
    }
    stp_store_close(store);
    stp_context_destroy(context);
}
