// SPDX-License-Identifier: MIT
// The level switch: every point is always drawn completely by some level, and splats
// never appear or disappear in groups.
#include "fovea_factor.h"
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "base/splats/prefix_table.h"
#include "draw/support_store.h"
#include "select/select.h"
#include "select/view_frame.h"

static const uint8_t grey[3] = {128, 128, 128};

enum { COARSE = 0, FINE = 1, COARSE_SIDE = 5, FINE_SIDE = 7 };

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_draw_list list;
    double scale; ///< pixels per unit of x/z, of the view drawn last
    double size;
    stp_fovea fovea; ///< fovea of the next selection
} fixture;

// A square with 1,024 splats, below it the same one with 16,384, below that (or in the same node)
// its triangles.
static bool set_up(fixture* f, bool points)
{
    *f = (fixture){.context = test_context(NULL, 1, NULL)};
    if (f->context == NULL) {
        return false;
    }
    made_scene* s = &f->scene;
    s->node_count = 2;
    s->edge_count = s->part_count = s->material_count = s->shading_count = 1;
    s->set_count = 2;
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->sets[COARSE] = made_square_set(f->context, COARSE_SIDE, grey);
    s->sets[FINE] = made_square_set(f->context, FINE_SIDE, grey);
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    s->nodes[0] =
        (stp_store_node){.part_count = 1, .set = FINE, .triangle_count = 2, .bounds = flat};
    float* positions = NULL;
    if (points) {
        uint32_t count = s->sets[FINE].count + 1;
        positions = STP_NEW_ZEROED(f->context, float, 3 * (size_t)count);
        s->point_set_count = 1;
        s->point_sets[0] = (stp_store_point_set){.point_count = count, .positions = positions};
        s->parts[0] = (stp_store_part){STP_STORE_PART_POINTS, 0};
        s->nodes[0].triangle_count = 0;
        s->nodes[0].point_count = count;
    } else {
        s->mesh_count = 1;
        s->meshes[0] = made_square(0);
        s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    }
    s->nodes[1] = s->nodes[0];
    s->nodes[1].part_count = 0;
    s->nodes[1].edge_count = 1;
    s->nodes[1].set = COARSE;
    s->edges[0] = (stp_store_edge){0, stp_affine_identity()};
    f->store = made_open(f->context, s);
    stp_free(f->context, positions);
    return f->store != NULL;
}

static void tear_down(fixture* f)
{
    made_free_set(f->context, &f->scene.sets[COARSE]);
    made_free_set(f->context, &f->scene.sets[FINE]);
    stp_draw_list_destroy(f->context, &f->list);
    stp_store_close(f->store);
    stp_context_destroy(f->context);
}

static stp_result look(fixture* f, const stp_view* view, float size, stp_policy policy)
{
    stp_quality quality = {
        .splat_size = size, .policy = policy, .fovea = f->fovea, .early_switch = 1};
    stp_view eye = stp_view_of_eye(view, 0);
    stp_view_frame frame;
    f->scale = stp_view_frame_make(&eye, &frame) ? frame.scale : 0.0;
    f->size = (double)size;
    return stp_select(f->context, f->store, view, &quality, &f->list);
}

static const stp_draw_item* find_item(const fixture* f, stp_draw_kind kind, uint32_t index)
{
    for (size_t i = 0; i < f->list.count; ++i) {
        if (f->list.items[i].kind == kind && f->list.items[i].index == index) {
            return &f->list.items[i];
        }
    }
    return NULL;
}

// Number of splats of a set drawn at a depth: the index of the first that is not drawn.
static uint32_t count_drawn(const fixture* f, uint32_t set, double depth, uint32_t* first_missing)
{
    const stp_draw_item* item = find_item(f, STP_DRAW_SPLATS, set);
    *first_missing = 0;
    if (item == NULL || item->run_count == 0) {
        return *first_missing = item != NULL ? item->prefix : 0;
    }
    uint32_t drawn = 0;
    bool missing = false;
    for (uint32_t i = 0; i < item->run_count; ++i) {
        stp_draw_run run = f->list.runs[item->first_run + i];
        bool there = depth >= (double)run.nearest && depth <= (double)run.farthest;
        drawn += there ? run.end - run.begin : 0;
        missing = missing || !there;
        *first_missing = missing ? *first_missing : run.end;
    }
    return drawn;
}

static double radius_drawn(const fixture* f, uint32_t set)
{
    return (double)find_item(f, STP_DRAW_SPLATS, set)->radius;
}

// Whether a set covers to the required radius at a depth, with sufficiently large splats: up to two
// pixels candidates are covered with their whole area, from four pixels on with half of it.
static bool is_complete(const fixture* f, uint32_t set, double depth)
{
    const stp_splats* splats = stp_store_describe_splat_set(f->store, set);
    uint32_t prefix;
    count_drawn(f, set, depth, &prefix);
    if (prefix == 0) {
        return false;
    }
    double covers = (double)stp_prefix_table_radius(&splats->table, prefix);
    double wanted = 0.5 * f->size * depth / f->scale;
    double share = 0.5 + 0.5 * fmin(fmax((4.0 - f->size) / 2.0, 0.0), 1.0);
    return covers <= wanted * (1.0 + 1e-4) &&
           radius_drawn(f, set) >=
               (covers + share * (double)splats->candidate_radius) * (1.0 - 1e-5);
}

static bool mesh_is_complete(const fixture* f, double depth)
{
    const stp_draw_item* item = find_item(f, STP_DRAW_MESH, 0);
    return item != NULL && stp_draw_share(item, (float)depth) >= 1.0f;
}

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

// Views from all sides and distances, most of them flat over the square, so that it spans a range
// of depths.
static stp_view random_view(uint64_t round)
{
    double distance = exp(uniform(round, 0, -1.0, 4.5)), turn = uniform(round, 1, 0.0, 6.3);
    double lift = distance * pow(uniform(round, 2, 0.05, 1.0), 2.0);
    return (stp_view){.eye = {distance * cos(turn), distance * sin(turn), lift + 0.001},
                      .target = {uniform(round, 3, -0.5, 0.5), uniform(round, 4, -0.5, 0.5), 0},
                      .up = {0, 0, 1},
                      .fov_degrees = uniform(round, 5, 20.0, 90.0),
                      .near_distance = 1e-3,
                      .width = 320,
                      .height = 200};
}

// Depth of each of 25 visible points of the square, and the factor on the splat size there.
static int list_seen(const stp_view* view, const stp_fovea* fovea, double depths[25],
                     double factors[25])
{
    stp_view_frame frame;
    int count = 0;
    if (!stp_view_frame_make(view, &frame)) {
        return 0;
    }
    double half = 0.5 * sqrt(frame.width * frame.width + frame.height * frame.height);
    for (int i = 0; i < 25; ++i) {
        stp_vec3d p = {i % 5 * 0.5 - 1.0, i / 5 * 0.5 - 1.0, 0};
        stp_vec3d q = stp_subd(p, frame.eye);
        double z = stp_dotd(q, frame.forward);
        double x = frame.scale * stp_dotd(q, frame.right) / z;
        double y = frame.scale * stp_dotd(q, frame.down) / z;
        if (z >= frame.near_distance && fabs(x) < frame.center_x && fabs(y) < frame.center_y) {
            depths[count] = z;
            factors[count++] = fovea_factor_at(fovea, sqrt(x * x + y * y) / half);
        }
    }
    return count;
}

// The finest level that is complete at a depth: 0, 1, or 2 for the triangles; -1: none.
static int find_complete(const fixture* f, double depth)
{
    return mesh_is_complete(f, depth)      ? 2
           : is_complete(f, FINE, depth)   ? 1
           : is_complete(f, COARSE, depth) ? 0
                                           : -1;
}

// For every visible point of the square, in any view, with and without zones, one level is complete
// at its depth.
void test_level_switch_leaves_no_depth_without_a_complete_one(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, false));
    int by[3] = {0}, runs = 0;
    double depths[25], factors[25];
    for (uint64_t round = 0; round < 1200; ++round) {
        stp_view view = random_view(round / 4);
        float size = (float)uniform(round / 4, 6, 1.0, 6.0);
        view.eye_distance = round % 4 >= 2 ? uniform(round, 7, 0.001, 0.3) : 0.0;
        f.fovea = (stp_fovea){.count = round % 2 * 2, .zones = {{0.2f, 1.5f}, {0.9f, 5}}};
        CHECK_EQUAL(STP_OK, look(&f, &view, size, STP_POLICY_INSERTION));
        runs += f.list.run_count > 0;
        for (uint32_t eye = 0; eye < stp_view_eye_count(&view); ++eye) {
            stp_view one = stp_view_of_eye(&view, eye);
            int count = list_seen(&one, &f.fovea, depths, factors);
            for (int i = 0; i < count; ++i) {
                f.size = (double)size * factors[i];
                int level = find_complete(&f, depths[i]);
                CHECK(level >= 0);
                by[level] += 1;
            }
        }
    }
    CHECK(by[0] > 500 && by[1] > 500 && by[2] > 500 && runs > 50);
    tear_down(&f);
}

// From the list for two eyes, each eye gets content at least as fine as from its own list.
void test_level_switch_of_two_eyes_is_that_of_the_nearer(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, false));
    double depths[25], factors[25];
    int finer = 0, all = 0;
    for (uint64_t round = 0; round < 300; ++round) {
        stp_view view = random_view(round);
        view.eye_distance = uniform(round, 7, 0.01, 1.0) * sqrt(stp_dotd(view.eye, view.eye));
        f.fovea = (stp_fovea){.count = round % 2 * 2, .zones = {{0.2f, 1.5f}, {0.9f, 5}}};
        for (uint32_t eye = 0; eye < 2; ++eye) {
            stp_view one = stp_view_of_eye(&view, eye);
            int levels[25];
            uint32_t missing, alone[25];
            CHECK_EQUAL(STP_OK, look(&f, &one, 3.0f, STP_POLICY_INSERTION));
            int count = list_seen(&one, &f.fovea, depths, factors);
            for (int i = 0; i < count; ++i) {
                levels[i] = find_complete(&f, depths[i]);
                alone[i] =
                    levels[i] < 2 ? count_drawn(&f, (uint32_t)levels[i], depths[i], &missing) : 0;
            }
            CHECK_EQUAL(STP_OK, look(&f, &view, 3.0f, STP_POLICY_INSERTION));
            for (int i = 0; i < count; ++i) {
                int level = find_complete(&f, depths[i]);
                CHECK(level >= levels[i]);
                all += 1;
                if (level == levels[i] && level < 2) {
                    uint32_t now = count_drawn(&f, (uint32_t)level, depths[i], &missing);
                    CHECK(now >= alone[i]);
                    finer += now > alone[i];
                }
            }
        }
    }
    CHECK(all > 2000 && finer > 10 && finer < all);
    tear_down(&f);
}

// Towards the square in steps of 0.25 %: at the depth of a point on it, the drawn share of each
// level changes gradually; switching changes all of it.
void test_level_switch_comes_and_goes_by_degrees(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, false));
    for (int policy = 0; policy < 2; ++policy) {
        double maximum = 0.0, last[3] = {-1};
        for (double distance = 100.0; distance > 6.0; distance *= 0.9975) {
            stp_view view = {.eye = {0, -0.8 * distance, 0.6 * distance},
                             .up = {0, 0, 1},
                             .fov_degrees = 60,
                             .near_distance = 1e-3,
                             .width = 400,
                             .height = 400};
            CHECK_EQUAL(STP_OK, look(&f, &view, 1.0f,
                                     policy == 0 ? STP_POLICY_INSERTION : STP_POLICY_SWITCH));
            const stp_draw_item* mesh = find_item(&f, STP_DRAW_MESH, 0);
            uint32_t missing;
            double now[3] = {
                (double)count_drawn(&f, COARSE, distance, &missing) / 1024.0,
                (double)count_drawn(&f, FINE, distance, &missing) / 16384.0,
                mesh != NULL ? (double)stp_draw_share(mesh, (float)distance) : 0.0,
            };
            for (int k = 0; k < 3; ++k) {
                maximum = last[0] < 0.0 ? maximum : fmax(maximum, fabs(now[k] - last[k]));
                last[k] = now[k];
            }
        }
        CHECK(policy == 0 ? maximum < 0.2 : maximum > 0.9);
    }
    tear_down(&f);
}

// At one depth the numbers are exact: the content drawn in addition to switching is what the list
// says, and little in total.
void test_level_switch_counts_what_is_drawn_twice(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, false));
    double extra = 0.0, all = 0.0;
    int blended = 0;
    for (double height = 80.0; height > 6.0; height *= 0.99) {
        stp_view view = {
            .eye = {0, 0, 5}, .up = {0, 1, 0}, .ortho_height = height, .width = 300, .height = 300};
        CHECK_EQUAL(STP_OK, look(&f, &view, 1.0f, STP_POLICY_SWITCH));
        uint64_t switched = f.list.splat_count;
        CHECK_EQUAL(0, f.list.extra_splats);
        CHECK_EQUAL(0, f.list.run_count);
        CHECK_EQUAL(STP_OK, look(&f, &view, 1.0f, STP_POLICY_INSERTION));
        CHECK_EQUAL(switched, f.list.splat_count - f.list.extra_splats);
        blended += f.list.extra_splats > 0;
        extra += (double)f.list.extra_splats;
        all += (double)f.list.splat_count;
        double complete = 0;
        complete += is_complete(&f, COARSE, 1.0) + is_complete(&f, FINE, 1.0);
        CHECK(complete > 0.0 || mesh_is_complete(&f, 1.0));
    }
    CHECK(blended > 20);
    CHECK(extra < 0.15 * all);
    tear_down(&f);
}

// A part of a cloud would not be spread evenly: original points appear all at once, when splats
// cover them.
void test_level_switch_shows_original_points_at_once(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, true));
    int together = 0;
    for (double height = 40.0; height > 6.0; height *= 0.99) {
        stp_view view = {
            .eye = {0, 0, 5}, .up = {0, 1, 0}, .ortho_height = height, .width = 300, .height = 300};
        CHECK_EQUAL(STP_OK, look(&f, &view, 1.0f, STP_POLICY_INSERTION));
        const stp_draw_item* points = find_item(&f, STP_DRAW_POINTS, 0);
        const stp_draw_item* fine = find_item(&f, STP_DRAW_SPLATS, FINE);
        CHECK(points == NULL || points->prefix == 16385);
        CHECK(points != NULL || is_complete(&f, FINE, 1.0) || is_complete(&f, COARSE, 1.0));
        together += points != NULL && fine != NULL;
    }
    CHECK(together > 2);
    tear_down(&f);
}

// Triangles are ordered: a larger share contains the smaller shares, and has that fraction of the
// triangles.
void test_level_switch_shares_of_triangles_are_nested(test_state* test)
{
    int kept[11] = {0};
    for (uint32_t i = 0; i < 20000; ++i) {
        bool before = false;
        for (int k = 0; k <= 10; ++k) {
            bool keeps = stp_draw_keeps(i, 0.1f * (float)k);
            CHECK(keeps || !before);
            before = keeps;
            kept[k] += keeps;
        }
    }
    for (int k = 0; k <= 10; ++k) {
        CHECK(abs(kept[k] - 2000 * k) < 300);
    }
    CHECK_EQUAL(0, kept[0]);
    CHECK_EQUAL(20000, kept[10]);
    const stp_draw_item whole = {.kind = STP_DRAW_MESH};
    CHECK(stp_draw_share(&whole, 1e9f) >= 1.0f);
    const stp_draw_item fading = {.switch_begin = 2.0f, .switch_end = 3.0f};
    CHECK(stp_draw_share(&fading, 1.9f) >= 1.0f && stp_draw_share(&fading, 3.1f) <= 0.0f);
    CHECK(fabsf(stp_draw_share(&fading, 2.75f) - 0.25f) < 1e-6f);
}
