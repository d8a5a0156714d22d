// SPDX-License-Identifier: MIT
// A graph of a few shared nodes that expands beyond any memory: each traversal ends soon with an
// error message.
#include "tests.h"

#include "draw/support_store.h"
#include "select/pick_ray.h"
#include "select/select.h"
#include "select/visibility.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LEVELS = 40 };

/// Each node contains its child twice, slightly displaced; the last one is a square.
static stp_store* open_doubling(stp_context* context)
{
    static stp_store_node nodes[LEVELS + 1];
    static stp_store_edge edges[2 * LEVELS];
    stp_store_part part = {STP_STORE_PART_MESH, 0};
    stp_store_mesh mesh = made_square(0);
    stp_store_material material = made_material();
    nodes[0] = (stp_store_node){.part_count = 1,
                                .set = STP_STORE_NONE,
                                .triangle_count = 2,
                                .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    for (uint32_t i = 0; i < LEVELS; ++i) {
        for (uint32_t k = 0; k < 2; ++k) {
            edges[2 * i + k] = (stp_store_edge){i, stp_affine_identity()};
            edges[2 * i + k].transform.m[2][3] = 1e-3 * k;
        }
        nodes[i + 1] = nodes[0];
        nodes[i + 1].part_count = 0;
        nodes[i + 1].first_edge = 2 * i;
        nodes[i + 1].edge_count = 2;
        nodes[i + 1].triangle_count = UINT64_C(4) << i;
        nodes[i + 1].bounds.max.z = 1e-3 * (i + 1);
    }
    stp_store_content content = {.directory = {.node_count = LEVELS + 1,
                                               .edge_count = 2 * LEVELS,
                                               .part_count = 1,
                                               .material_count = 1,
                                               .mesh_count = 1,
                                               .nodes = nodes,
                                               .edges = edges,
                                               .parts = &part,
                                               .materials = &material,
                                               .root = LEVELS,
                                               .up = 'y',
                                               .build_json = "{}"},
                                 .meshes = &mesh};
    char path[] = "stipple-doubling-XXXXXX";
    int file = mkstemp(path);
    stp_store* store = NULL;
    if (file >= 0 && (stp_store_write(context, &content, path) != STP_OK ||
                      stp_store_open(context, path, &store) != STP_OK)) {
        store = NULL;
    }
    close(file);
    unlink(path);
    return store;
}

void test_unfolding_graphs_end_with_a_sentence(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_store* store = open_doubling(context);
    CHECK(store != NULL);
    stp_view view = {
        .eye = {0, 0, 4}, .up = {0, 1, 0}, .fov_degrees = 60, .width = 64, .height = 64};
    for (int k = 0; k < 2; ++k) {
        stp_quality quality = {.splat_size = 1, .reference = k == 0};
        stp_draw_list list = {0};
        CHECK_EQUAL(STP_ERROR_LIMIT, stp_select(context, store, &view, &quality, &list));
        CHECK(strstr(log.text, "objects would have to be drawn") != NULL);
        CHECK(list.count <= (1u << 19) + 16 * (3 * LEVELS + 2)); // in proportion to the graph
        CHECK(list.node_count <= (1u << 21) + 16 * (3 * LEVELS + 2));
        stp_draw_list_destroy(context, &list);
    }
    stp_pick pick;
    stp_pick_desc desc = {
        .ray = {.origin = {0.1, 0.2, 4}, .direction = {0, 0, -1}, .farthest = 100}};
    stp_result picked = stp_pick_ray(context, store, &desc, &pick);
    CHECK(picked == STP_OK || picked == STP_ERROR_LIMIT);
    stp_visibility* visibility = NULL;
    CHECK_EQUAL(STP_OK, stp_visibility_create(context, store, &visibility));
    stp_placed_node placed = {.node = 0, .transform = stp_affine_identity()};
    stp_result hidden = stp_visibility_set(visibility, &placed, STP_SHOW_NOT);
    CHECK(hidden == STP_OK || hidden == STP_ERROR_LIMIT);
    stp_visibility_destroy(visibility);
    stp_store_close(store);
    stp_context_destroy(context);
}

/// A node that lists one part many times: it is drawn once.
void test_repeated_parts_are_drawn_once(test_state* test)
{
    enum { PARTS = 5000 };
    static stp_store_part parts[PARTS];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_mesh meshes[] = {made_square(0), made_square(0)};
    stp_store_material material = made_material();
    for (int i = 0; i < PARTS; ++i) {
        parts[i] = (stp_store_part){STP_STORE_PART_MESH, i < PARTS / 2 ? 0 : (uint32_t)i % 2};
    }
    stp_store_node node = {.part_count = PARTS,
                           .set = STP_STORE_NONE,
                           .triangle_count = 2 * PARTS,
                           .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    stp_store_content content = {.directory = {.node_count = 1,
                                               .part_count = PARTS,
                                               .material_count = 1,
                                               .mesh_count = 2,
                                               .nodes = &node,
                                               .parts = parts,
                                               .materials = &material,
                                               .root = 0,
                                               .up = 'y',
                                               .build_json = "{}"},
                                 .meshes = meshes};
    char path[] = "stipple-repeated-XXXXXX";
    int file = mkstemp(path);
    stp_store* store = NULL;
    CHECK(file >= 0 && close(file) == 0);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &content, path));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    stp_view view = {
        .eye = {0, 0, 4}, .up = {0, 1, 0}, .fov_degrees = 60, .width = 64, .height = 64};
    stp_quality quality = {.splat_size = 1};
    stp_draw_list list = {0};
    CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
    CHECK_EQUAL(2, list.count);
    CHECK_EQUAL(4, list.triangle_count);
    stp_draw_list_destroy(context, &list);
    stp_store_close(store);
    unlink(path);
    stp_context_destroy(context);
}
