// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "base/splats/prefix_table.h"
#include "draw/support_store.h"
#include "select/select.h"
#include "select/view_frame.h"

static const uint8_t grey[3] = {128, 128, 128};

// A root with splats over a square and, below it, the square itself twice: at the splats and,
// moving, a little above.
static void make_scene(stp_context* context, made_scene* s)
{
    *s = (made_scene){.node_count = 3,
                      .edge_count = 2,
                      .part_count = 2,
                      .material_count = 1,
                      .shading_count = 1,
                      .mesh_count = 1,
                      .set_count = 1};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[0] = made_square_set(context, 5, grey);
    s->parts[0] = s->parts[1] = (stp_store_part){STP_STORE_PART_MESH, 0};
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    s->nodes[0] = (stp_store_node){
        .part_count = 1, .set = STP_STORE_NONE, .triangle_count = 2, .bounds = flat};
    s->nodes[1] = s->nodes[0];
    s->nodes[1].first_part = 1;
    s->nodes[1].flags = 1; // moves
    s->edges[0] = (stp_store_edge){0, stp_affine_identity()};
    s->edges[1] = (stp_store_edge){1, stp_affine_identity()};
    s->edges[1].transform.m[2][3] = 0.5;
    s->nodes[2] = (stp_store_node){
        .edge_count = 2, .set = 0, .triangle_count = 4, .bounds = {{-1, -1, 0}, {1, 1, 0.5}}};
}

static stp_view view_from(double distance)
{
    return (stp_view){
        .eye = {0, 0, distance}, .up = {0, 1, 0}, .fov_degrees = 90, .width = 200, .height = 200};
}

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_draw_list list;
} fixture;

static bool set_up(fixture* f)
{
    static test_log log;
    *f = (fixture){.context = test_context(NULL, 1, &log)};
    if (f->context == NULL) {
        return false;
    }
    make_scene(f->context, &f->scene);
    f->store = made_open(f->context, &f->scene);
    if (f->store == NULL) {
        fprintf(stderr, "%s\n", log.text);
    }
    return f->store != NULL;
}

static void tear_down(fixture* f)
{
    made_free_set(f->context, &f->scene.sets[0]);
    stp_draw_list_destroy(f->context, &f->list);
    stp_store_close(f->store);
    stp_context_destroy(f->context);
}

void test_select_prefix_follows_the_pixel(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    // a pixel at depth z is z / 100 units wide here; r = s d_p / 2 with the depth of the box's
    // nearest face
    const stp_splats* splats = stp_store_describe_splat_set(f.store, 0);
    for (int step = 0; step < 30; ++step) {
        double distance = 4.0 + 3.0 * step;
        stp_view view = view_from(distance);
        stp_quality quality = {.splat_size = (float)(2 + step % 4), .early_switch = 1};
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
        double r = 0.5 * (2 + step % 4) * (distance - 0.5) / 100.0;
        bool enough = r >= (double)splats->table.radius[splats->table.size - 1];
        CHECK_EQUAL(2, f.list.count);
        stp_draw_item moving = f.list.items[1];
        CHECK_EQUAL(STP_DRAW_MESH, moving.kind);
        CHECK(moving.transform.m[2][3] == 0.5 || !enough);
        if (!enough) {
            CHECK_EQUAL(STP_DRAW_MESH, f.list.items[0].kind);
            CHECK_EQUAL(4, f.list.triangle_count);
            CHECK_EQUAL(2, moving.first_id);
            continue;
        }
        stp_draw_item item = f.list.items[0];
        CHECK_EQUAL(STP_DRAW_SPLATS, item.kind);
        CHECK_EQUAL(stp_prefix_table_count(&splats->table, (float)r), item.prefix);
        CHECK_EQUAL(item.prefix, f.list.splat_count);
        CHECK_EQUAL(item.prefix, moving.first_id);
        CHECK((double)item.radius <= r + 0.001 + 1e-6);
        CHECK((double)item.radius >= 0.001);
    }
    tear_down(&f);
}

// A node is opened where its triangles are fewer than eight for each splat that is needed, and at
// most where its splats could cover eight times, or a given number of times, better than
// necessary.
void test_select_opens_sooner_where_triangles_are_few(test_state* test)
{
    const struct {
        uint32_t triangles; // below the node
        float early_switch;
        double times;
    } cases[] = {{100, 0, 8},       {2000, 1, 1}, {200, 3, 3},
                 {1022, 0, 2.8284}, {2046, 0, 2}, {4094, 0, 1.41421},
                 {4094, 1.2f, 1.2}, {8190, 0, 1}, {60000, 0, 1}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        fixture f;
        CHECK(set_up(&f));
        stp_store_close(f.store);
        f.scene.nodes[0].triangle_count = cases[i].triangles;
        f.scene.nodes[2].triangle_count = cases[i].triangles + 2;
        f.store = made_open(f.context, &f.scene);
        CHECK(f.store != NULL);
        const stp_splats* splats = stp_store_describe_splat_set(f.store, 0);
        double minimum = (double)splats->table.radius[splats->table.size - 1] * cases[i].times;
        int own = 0, opened = 0;
        for (double distance = 4.0; distance < 200.0; distance *= 1.02) {
            stp_view view = view_from(distance);
            stp_quality quality = {.splat_size = 4,
                                   .policy = STP_POLICY_SWITCH,
                                   .early_switch = cases[i].early_switch};
            CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
            double r = 0.5 * 4 * (distance - 0.5) / 100.0;
            if (fabs(r - minimum) < 1e-3 * minimum) {
                continue;
            }
            bool has_own = f.list.items[0].kind == STP_DRAW_SPLATS;
            CHECK_EQUAL(r > minimum, has_own);
            own += has_own;
            opened += !has_own;
        }
        CHECK(own > 5 && opened > 5);
        tear_down(&f);
    }
}

void test_select_opens_what_contains_the_eye(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    stp_view view = view_from(0.25);
    stp_quality quality = {.splat_size = 64};
    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
    CHECK_EQUAL(0, f.list.splat_count);
    CHECK_EQUAL(2, f.list.triangle_count); // the other one is behind the eye
    tear_down(&f);
}

// From inside, a node is opened, except points that are all splats.
void test_select_keeps_clouds_around_the_eye(test_state* test)
{
    for (int kept = 0; kept < 2; ++kept) {
        fixture f = {.context = test_context(NULL, 1, NULL)};
        CHECK(f.context != NULL);
        make_scene(f.context, &f.scene);
        uint32_t count = f.scene.sets[0].count, points = kept ? count : count + 1;
        float* positions = STP_NEW_ZEROED(f.context, float, 3 * ((size_t)count + 1));
        CHECK(positions != NULL);
        f.scene.point_sets[0] =
            (stp_store_point_set){.point_count = points, .positions = positions};
        f.scene.parts[0] = (stp_store_part){STP_STORE_PART_POINTS, 0};
        f.scene.nodes[0] = f.scene.nodes[2];
        f.scene.nodes[0].edge_count = 0;
        f.scene.nodes[0].part_count = 1;
        f.scene.nodes[0].triangle_count = 0;
        f.scene.nodes[0].point_count = points;
        f.scene.node_count = f.scene.part_count = f.scene.point_set_count = 1;
        f.scene.edge_count = f.scene.mesh_count = 0;
        f.store = made_open(f.context, &f.scene);
        CHECK(f.store != NULL);
        stp_view view = view_from(0.25);
        stp_quality quality = {.splat_size = 1};
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
        CHECK_EQUAL(1, f.list.count);
        CHECK_EQUAL(kept ? STP_DRAW_SPLATS : STP_DRAW_POINTS, f.list.items[0].kind);
        CHECK_EQUAL(points, f.list.splat_count);
        CHECK(!kept || f.list.items[0].radius >= f.scene.sets[0].candidate_radius);
        stp_free(f.context, positions);
        tear_down(&f);
    }
}

// Moving nodes are drawn by their own splats, also below drawn nodes: once each, in their place,
// together with their descendants.
void test_select_draws_what_moves_by_its_own_splats(test_state* test)
{
    for (int variant = 0; variant < 4; ++variant) {
        fixture f = {.context = test_context(NULL, 1, NULL)};
        CHECK(f.context != NULL);
        make_scene(f.context, &f.scene);
        made_scene* s = &f.scene;
        s->sets[1] = made_square_set(f.context, 3, grey);
        s->set_count = 2;
        s->nodes[1].set = 1;
        bool with_root_set = variant % 2 == 0, nested = variant >= 2;
        s->nodes[2].set = with_root_set ? 0 : STP_STORE_NONE;
        if (nested) { // the moving node contains another moving one, and is below a static one
            s->nodes[4] = s->nodes[2];
            s->nodes[2] = s->nodes[1];
            s->nodes[2].edge_count = 1;
            s->nodes[2].triangle_count = 4;
            s->nodes[2].bounds.max.z = 0.5;
            s->nodes[3] = (stp_store_node){.first_edge = 1,
                                           .edge_count = 1,
                                           .set = STP_STORE_NONE,
                                           .triangle_count = 4,
                                           .bounds = {{-1, -1, 0}, {1, 1, 1}}};
            s->nodes[4].first_edge = 2;
            s->nodes[4].triangle_count = 6;
            s->nodes[4].bounds.max.z = 1;
            s->nodes[2].first_part = 2;
            s->parts[2] = s->parts[1];
            s->part_count = 3;
            s->node_count = 5;
            s->edges[2] = (stp_store_edge){0, stp_affine_identity()};
            s->edges[3] = (stp_store_edge){3, stp_affine_identity()};
            s->edges[0] = (stp_store_edge){1, stp_affine_identity()};
            s->edges[0].transform.m[2][3] = 0.5;
            s->edges[1] = (stp_store_edge){2, s->edges[0].transform};
            s->edge_count = 4;
        }
        f.store = made_open(f.context, s);
        CHECK(f.store != NULL);
        stp_view view = view_from(40);
        CHECK_EQUAL(STP_OK,
                    stp_select(f.context, f.store, &view,
                               &(stp_quality){.splat_size = 4, .early_switch = 1}, &f.list));
        uint32_t resting = 0, moving[2] = {0};
        for (size_t i = 0; i < f.list.count; ++i) {
            const stp_draw_item* item = &f.list.items[i];
            double z = item->transform.m[2][3];
            bool own = item->kind == STP_DRAW_SPLATS && item->index == 1;
            resting += item->kind == (with_root_set ? STP_DRAW_SPLATS : STP_DRAW_MESH) &&
                       item->index == 0 && z == 0.0;
            moving[0] += own && z == 0.5;
            moving[1] += own && z == 1.0;
        }
        CHECK_EQUAL(nested ? 3 : 2, f.list.count);
        CHECK_EQUAL(1, resting);
        CHECK_EQUAL(1, moving[0]);
        CHECK_EQUAL(nested, moving[1]);
        made_free_set(f.context, &s->sets[1]);
        tear_down(&f);
    }
}

// A requested number of splats is the total over all sets.
void test_select_counts_splats_of_what_moves(test_state* test)
{
    fixture f = {.context = test_context(NULL, 1, NULL)};
    CHECK(f.context != NULL);
    make_scene(f.context, &f.scene);
    f.scene.sets[1] = made_square_set(f.context, 3, grey);
    f.scene.set_count = 2;
    f.scene.nodes[1].set = 1;
    f.store = made_open(f.context, &f.scene);
    CHECK(f.store != NULL);
    // squares of one size, of 1,024 and 64 splats: while both have splats left, their shares are
    // equal
    const uint32_t counts[] = {1, 2, 3, 50, 51, 127, 1023, 1024, 1025, 1088, 5000};
    for (int i = 0; i < 11; ++i) {
        for (int turned = 0; turned < 2; ++turned) { // shares are equal if nothing is visible
            stp_view view = view_from(50);
            view.target.z = turned != 0 ? 100 : 0;
            stp_quality quality = {.splat_count = counts[i]};
            CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
            uint32_t all = counts[i] < 1088 ? counts[i] : 1088, prefixes[2] = {0};
            CHECK_EQUAL(all, f.list.splat_count);
            CHECK_EQUAL(0, f.list.triangle_count);
            CHECK_EQUAL(counts[i] > 1 ? 2 : 1, f.list.count);
            for (size_t k = 0; k < f.list.count; ++k) {
                prefixes[f.list.items[k].index] = f.list.items[k].prefix;
            }
            uint32_t half = all / 2 < 64 ? all / 2 : 64;
            CHECK(prefixes[1] == half || (all % 2 == 1 && prefixes[1] == half + 1));
        }
    }
    made_free_set(f.context, &f.scene.sets[1]);
    tear_down(&f);
}

void test_select_culls_by_every_side(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    const stp_vec3d targets[] = {{20, 0, 10}, {-20, 0, 10}, {0, 20, 10}, {0, -20, 10}, {0, 0, 20}};
    stp_quality quality = {.splat_size = 1};
    for (int parallel = 0; parallel < 2; ++parallel) {
        for (int i = 0; i < 5; ++i) {
            stp_view view = view_from(10);
            view.target = targets[i];
            view.up = i == 2 || i == 3 ? (stp_vec3d){1, 0, 0} : view.up;
            view.fov_degrees = 40;
            if (parallel != 0) {
                view.ortho_height = 2;
                view.eye = (stp_vec3d){i == 4 ? 9.0 : targets[i].x, targets[i].y, 10};
                view.target = (stp_vec3d){view.eye.x, view.eye.y, 0};
            }
            CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
            CHECK_EQUAL(0, f.list.count);
            CHECK_EQUAL(1, f.list.node_count);
        }
    }
    stp_view view = view_from(10);
    view.target = (stp_vec3d){9, 0, 1}; // a corner of the square is still in the picture
    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
    CHECK_EQUAL(2, f.list.count);
    tear_down(&f);
}

void test_select_reference_and_exact_counts(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    stp_view view = view_from(50);
    stp_quality quality = {.splat_size = 4, .reference = true};
    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
    CHECK_EQUAL(0, f.list.splat_count);
    CHECK_EQUAL(4, f.list.triangle_count);
    const uint32_t counts[] = {1, 7, 64, 1023, 1024, 5000};
    for (int i = 0; i < 6; ++i) {
        quality = (stp_quality){.splat_count = counts[i]};
        view.eye.z = 0.3; // also where the eye is too close
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
        CHECK_EQUAL(counts[i] < 1024 ? counts[i] : 1024, f.list.splat_count);
    }
    tear_down(&f);
}

void test_select_paper_policy_follows_the_formula(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    stp_view view = view_from(20.6); // pixels of 0.201, so r = 0.402 for 4 pixels
    stp_quality quality = {.splat_size = 4, .policy = STP_POLICY_PAPER};
    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
    CHECK_EQUAL(16, f.list.splat_count); // 256 (0.1 / 0.402)^2 = 15.8
    CHECK(fabsf(f.list.items[0].radius - 0.402f) < 1e-5f);
    view = view_from(2.5); // 1,600 would be needed, 1,024 are there
    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
    CHECK_EQUAL(0, f.list.splat_count);
    tear_down(&f);
}

void test_select_refuses_invalid_views(test_state* test)
{
    fixture f;
    CHECK(set_up(&f));
    stp_quality quality = {.splat_size = 1};
    for (int i = 0; i < 6; ++i) {
        stp_view view = view_from(5);
        view.width = i == 0 ? 0 : view.width;
        view.fov_degrees = i == 1 ? 180 : i == 2 ? -1 : view.fov_degrees;
        view.target.z = i == 3 ? 5 : 0;
        view.eye.x = i == 4 ? (double)NAN : 0;
        view.up = i == 5 ? (stp_vec3d){0, 0, 1} : view.up; // along the gaze: still a view
        stp_result expected = i == 5 ? STP_OK : STP_ERROR_ARGUMENT;
        CHECK_EQUAL(expected, stp_select(f.context, f.store, &view, &quality, &f.list));
    }
    tear_down(&f);
}

void test_select_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        fixture f = {.context = test_context(&heap, 1, NULL)};
        CHECK(f.context != NULL);
        make_scene(f.context, &f.scene);
        f.store = made_open(f.context, &f.scene);
        CHECK(f.store != NULL);
        stp_view view = view_from(50);
        stp_quality quality = {.splat_size = 4};
        heap.fail_at = heap.count + n;
        stp_result result = stp_select(f.context, f.store, &view, &quality, &f.list);
        heap.fail_at = -1;
        bool right = result == STP_OK ? f.list.count == 2 : result == STP_ERROR_OUT_OF_MEMORY;
        int before = heap.count;
        right = right && stp_select(f.context, f.store, &view, &quality, &f.list) == STP_OK;
        right =
            right && (result != STP_OK || heap.count == before); // a second call allocates nothing
        tear_down(&f);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(right);
        if (result == STP_OK) {
            CHECK(n >= 2);
            break;
        }
    }
}

void test_select_depth_bounds_what_is_seen(test_state* test)
{
    // random boxes: points of the box in the picture are never nearer than the returned depth
    uint32_t random = 12345;
    for (int round = 0; round < 300; ++round) {
        double v[9];
        for (int k = 0; k < 9; ++k) {
            random = random * 1664525u + 1013904223u;
            v[k] = (double)(random >> 8) / 16777216.0 * 4.0 - 2.0;
        }
        stp_view view = {.eye = {v[0], v[1], v[2]},
                         .target = {v[3], v[4], v[5]},
                         .up = {0, 1, 0},
                         .fov_degrees = 70,
                         .width = 160,
                         .height = 90,
                         .ortho_height = round % 4 == 3 ? 1.5 : 0.0,
                         .near_distance = 0.01};
        stp_boxd box = {{v[6], v[7], v[8]}, {v[6] + 0.5, v[7] + 1.0, v[8] + 0.2}};
        stp_view_frame frame;
        CHECK(stp_view_frame_make(&view, &frame));
        double depth = 0.0, farthest = 0.0;
        bool sees = stp_view_frame_depths(&frame, &box, &depth, &farthest);
        for (int i = 0; i < 500; ++i) {
            stp_vec3d p = {box.min.x + 0.5 * (i % 8) / 7, box.min.y + (i / 8 % 8) / 7.0,
                           box.min.z + 0.2 * (i / 64) / 7};
            stp_vec3d q = stp_subd(p, frame.eye);
            double z = stp_dotd(q, frame.forward), w = frame.parallel ? 1.0 : z;
            double x = frame.center_x + frame.scale * stp_dotd(q, frame.right) / w;
            double y = frame.center_y + frame.scale * stp_dotd(q, frame.down) / w;
            bool seen = z >= frame.near_distance && x >= 0 && x < 160 && y >= 0 && y < 90;
            CHECK(!seen || (sees && z >= depth - 1e-9));
        }
    }
}
