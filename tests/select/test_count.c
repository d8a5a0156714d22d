// SPDX-License-Identifier: MIT
// Splat counts with several sets drawn because of hidden objects: distribution, and content drawn
// beside them.
#include "tests.h"

#include "draw/support_store.h"
#include "select/select.h"

#include <string.h>

static const uint8_t grey[3] = {128, 128, 128};

enum { SMALL, LARGE, PLAIN, HIDDEN, ROOT, NODES }; // PLAIN and HIDDEN have no sets
enum { SMALL_SPLATS = 64, LARGE_SPLATS = 256, ROOT_SPLATS = 1024 };

typedef struct parts {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_visibility* visibility;
    stp_draw_list list;
    stp_view view;
    uint32_t splats[NODES]; ///< number of splats of each node in the list
} parts;

static bool set_up(parts* p, test_heap* heap)
{
    *p = (parts){.context = test_context(heap, 1, NULL)};
    if (p->context == NULL) {
        return false;
    }
    made_scene* s = &p->scene;
    *s = (made_scene){.node_count = NODES,
                      .edge_count = ROOT,
                      .part_count = ROOT,
                      .material_count = 1,
                      .shading_count = 1,
                      .mesh_count = 1,
                      .set_count = 3};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[SMALL] = made_square_set(p->context, 3, grey);
    s->sets[LARGE] = made_square_set(p->context, 4, grey);
    s->sets[2] = made_square_set(p->context, 5, grey);
    for (uint32_t i = 0; i < ROOT; ++i) {
        s->parts[i] = (stp_store_part){STP_STORE_PART_MESH, 0};
        s->nodes[i] = (stp_store_node){.first_part = i,
                                       .part_count = 1,
                                       .set = i < PLAIN ? i : STP_STORE_NONE,
                                       .triangle_count = 2,
                                       .bounds = {{-1, -1, 0}, {1, 1, 0}}};
        s->edges[i] = (stp_store_edge){i, stp_affine_identity()};
        s->edges[i].transform.m[2][3] = i;
    }
    for (int k = 0; k < 3; ++k) {
        s->edges[LARGE].transform.m[k][k] = 2.0; // four times the area
    }
    s->nodes[ROOT] = (stp_store_node){.edge_count = ROOT,
                                      .set = 2,
                                      .triangle_count = 2 * ROOT,
                                      .bounds = {{-2, -2, 0}, {2, 2, 3}}};
    p->store = made_open(p->context, s);
    p->view = (stp_view){
        .eye = {0, 0, 50}, .up = {0, 1, 0}, .fov_degrees = 60, .width = 200, .height = 200};
    return p->store != NULL &&
           stp_visibility_create(p->context, p->store, &p->visibility) == STP_OK;
}

static void tear_down(parts* p)
{
    stp_draw_list_destroy(p->context, &p->list);
    stp_visibility_destroy(p->visibility);
    stp_store_close(p->store);
    for (uint32_t i = 0; i < 3; ++i) {
        made_free_set(p->context, &p->scene.sets[i]);
    }
    stp_context_destroy(p->context);
}

static stp_result show(parts* p, uint32_t node, stp_show show)
{
    stp_placed_node placed = {node, p->scene.edges[node].transform};
    return stp_visibility_set(p->visibility, &placed, show);
}

static stp_result draw(parts* p, uint64_t count)
{
    stp_quality quality = {.splat_count = count, .visibility = p->visibility};
    stp_result result = stp_select(p->context, p->store, &p->view, &quality, &p->list);
    memset(p->splats, 0, sizeof(p->splats));
    for (size_t i = 0; i < p->list.count && result == STP_OK; ++i) {
        const stp_draw_item* item = &p->list.items[i];
        if (item->kind == STP_DRAW_SPLATS) {
            p->splats[item->index < 2 ? item->index : ROOT] += item->prefix;
        }
    }
    return result;
}

void test_count_is_shared_by_area(test_state* test)
{
    static parts p;
    CHECK(set_up(&p, NULL));
    CHECK_EQUAL(STP_OK, draw(&p, 100));
    CHECK_EQUAL(100, p.splats[ROOT]);
    CHECK_EQUAL(1, p.list.count);
    CHECK_EQUAL(STP_OK, show(&p, HIDDEN, STP_SHOW_NOT));
    uint32_t small = 0, large = 0;
    for (uint32_t n = 1; n < SMALL_SPLATS + LARGE_SPLATS + 9; ++n) {
        uint32_t all = n < SMALL_SPLATS + LARGE_SPLATS ? n : SMALL_SPLATS + LARGE_SPLATS;
        CHECK_EQUAL(STP_OK, draw(&p, n));
        CHECK_EQUAL(all, p.list.splat_count);
        CHECK_EQUAL(all, p.splats[SMALL] + p.splats[LARGE]);
        CHECK(p.splats[LARGE] > 0 && (n < 2 || p.splats[SMALL] > 0));
        CHECK(p.splats[SMALL] >= small &&
              p.splats[LARGE] >= large); // a larger total gives no set less
        small = p.splats[SMALL];
        large = p.splats[LARGE];
        bool left = small < SMALL_SPLATS && large < LARGE_SPLATS && n > 2;
        CHECK(!left || abs((int)large - 4 * (int)small) <= 3);
    }
    CHECK_EQUAL(STP_OK, draw(&p, UINT64_MAX));
    CHECK_EQUAL(SMALL_SPLATS + LARGE_SPLATS, p.list.splat_count);
    CHECK_EQUAL(STP_OK, show(&p, LARGE, STP_SHOW_NOT)); // the others get its share
    CHECK_EQUAL(STP_OK, draw(&p, 50));
    CHECK(p.splats[SMALL] == 50 && p.list.splat_count == 50);
    CHECK_EQUAL(STP_OK, show(&p, SMALL, STP_SHOW_GHOST));
    CHECK_EQUAL(STP_OK, draw(&p, 50));
    CHECK(p.splats[SMALL] == 50 && p.list.splat_count == 50);
    tear_down(&p);
}

// The square without a set, alone.
void test_count_leaves_triangles_where_there_are_no_splats(test_state* test)
{
    static parts p;
    CHECK(set_up(&p, NULL));
    CHECK_EQUAL(STP_OK, show(&p, HIDDEN, STP_SHOW_NOT));
    const uint64_t counts[] = {1, 2, 100, UINT64_MAX};
    for (int i = 0; i < 4; ++i) {
        CHECK_EQUAL(STP_OK, draw(&p, counts[i]));
        CHECK_EQUAL(2, p.list.triangle_count);
        bool plain = false;
        for (size_t k = 0; k < p.list.count; ++k) {
            const stp_draw_item* item = &p.list.items[k];
            plain = plain || (item->kind == STP_DRAW_MESH && item->transform.m[2][3] == PLAIN);
        }
        CHECK(plain);
    }
    CHECK_EQUAL(STP_OK, show(&p, HIDDEN, STP_SHOW));
    CHECK_EQUAL(STP_OK, draw(&p, UINT64_MAX));
    CHECK(p.list.triangle_count == 0 && p.list.splat_count == ROOT_SPLATS);
    tear_down(&p);
}

// Shares are for visible content in any view; content that a section removes gets none.
void test_count_does_not_depend_on_the_eye(test_state* test)
{
    static parts p;
    CHECK(set_up(&p, NULL));
    CHECK_EQUAL(STP_OK, show(&p, HIDDEN, STP_SHOW_NOT));
    const stp_vec3d targets[] = {{0, 0, 0}, {10, 0, 40}, {0, 0, 100}, {2, 2, 49}};
    const stp_vec3d eyes[] = {{0, 0, 50}, {0, 0, 0.5}, {9, 9, 9}};
    for (int i = 0; i < 12; ++i) {
        p.view.target = targets[i % 4];
        p.view.eye = eyes[i / 4];
        p.view.ortho_height = i % 2;
        CHECK_EQUAL(STP_OK, draw(&p, 101));
        CHECK_EQUAL(101, p.list.splat_count);
        CHECK(p.splats[SMALL] == 20 && p.splats[LARGE] == 81);
    }
    p.view.sections =
        (stp_sections){.count = 1, .planes = {{.normal = {0, 0, 1}, .distance = 0.5}}};
    CHECK_EQUAL(STP_OK, draw(&p, 101));
    CHECK(p.splats[SMALL] == 0 || p.splats[LARGE] == 0);
    CHECK_EQUAL(p.splats[SMALL] > 0 ? SMALL_SPLATS : 101, p.list.splat_count);
    tear_down(&p);
}

void test_count_survives_failing_allocator(test_state* test)
{
    static parts p;
    bool failed = true;
    for (int n = 0; failed; ++n) {
        test_heap heap = TEST_HEAP(-1);
        CHECK(set_up(&p, &heap));
        CHECK_EQUAL(STP_OK, show(&p, HIDDEN, STP_SHOW_NOT));
        heap.fail_at = heap.count + n;
        stp_result result = draw(&p, 101);
        heap.fail_at = -1;
        failed = result != STP_OK;
        CHECK(!failed || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK(failed || n >= 10);
        CHECK_EQUAL(STP_OK, draw(&p, 101));
        CHECK_EQUAL(101, p.list.splat_count);
        tear_down(&p);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
