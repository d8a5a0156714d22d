// SPDX-License-Identifier: MIT
#include "support_built.h"

#include "base/math/rng.h"
#include "draw/support_store.h"
#include "select/pick_ray.h"
#include "select/sections.h"
#include "store/clusters/clusters.h"

#include <math.h>
#include <stdlib.h>

static double random_between(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

/// Moeller and Trumbore 1997: an algorithm that differs from the library's. @return the distance,
/// or infinity
static double visit_object(const stp_ray* ray, const stp_vec3d c[3])
{
    stp_vec3d a = stp_subd(c[1], c[0]), b = stp_subd(c[2], c[0]);
    stp_vec3d p = stp_crossd(ray->direction, b);
    double det = stp_dotd(a, p);
    stp_vec3d from = stp_subd(ray->origin, c[0]), q = stp_crossd(from, a);
    double u = stp_dotd(from, p) / det, v = stp_dotd(ray->direction, q) / det;
    double t = stp_dotd(b, q) / det;
    return fabs(det) > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 ? t : HUGE_VAL;
}

/// Nearest hit over all shown triangles.
static double meet_all(stp_context* context, stp_store* store, const built_places* places,
                       const built_places* hidden, const stp_pick_desc* desc)
{
    double nearest = HUGE_VAL;
    for (uint32_t i = 0; i < places->count; ++i) {
        const stp_instance* place = &places->places[i];
        stp_clusters clusters;
        stp_decoded_mesh mesh;
        if (built_has(hidden, place) ||
            stp_store_get_clusters(store, place->part.index, &clusters) != STP_OK ||
            stp_clusters_decode(context, &clusters, &mesh) != STP_OK) {
            continue;
        }
        for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
            stp_vec3d c[3];
            for (int k = 0; k < 3; ++k) {
                const float* p = mesh.positions + 9 * (size_t)t + 3 * k;
                stp_vec3d local = {(double)p[0], (double)p[1], (double)p[2]};
                c[k] = stp_affine_point(&place->transform, local);
            }
            double at = visit_object(&desc->ray, c);
            stp_vec3d p = stp_addd(desc->ray.origin, stp_scaled(desc->ray.direction, at));
            if (at >= desc->ray.nearest && at <= desc->ray.farthest && at < nearest &&
                !stp_sections_exclude(desc->sections, p)) {
                nearest = at;
            }
        }
        stp_decoded_mesh_destroy(context, &mesh);
    }
    return nearest;
}

static stp_ray random_ray(uint64_t seed, const stp_boxd* box)
{
    stp_vec3d p[2];
    for (uint64_t i = 0; i < 2; ++i) {
        p[i] = (stp_vec3d){random_between(seed, 3 * i, box->min.x, box->max.x),
                           random_between(seed, 3 * i + 1, box->min.y, box->max.y),
                           random_between(seed, 3 * i + 2, box->min.z, box->max.z)};
    }
    stp_vec3d way = stp_normalized(stp_subd(p[1], p[0]));
    return (stp_ray){.origin = stp_subd(p[0], stp_scaled(way, 20.0)),
                     .direction = way,
                     .nearest = random_between(seed, 7, 0.0, 20.0),
                     .farthest = HUGE_VAL};
}

void test_picks_are_the_nearest_of_all_triangles(test_state* test)
{
    uint32_t hits = 0, misses = 0;
    for (uint64_t seed = 30; seed < 32; ++seed) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_store* store = context != NULL ? built_open(context, seed, false) : NULL;
        stp_visibility* visibility;
        stp_outline* outline;
        stp_outline_item item;
        bool ready;
        static built_places all, hidden;
        stp_affine identity = stp_affine_identity();
        CHECK(store != NULL);
        const stp_store_directory* d = stp_store_get_directory(store);
        all.count = hidden.count = 0;
        CHECK(built_unfold(store, d->root, &identity, &all));
        CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
        CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
        CHECK_EQUAL(STP_OK, stp_visibility_create(context, store, &visibility));
        CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, 9, &item));
        stp_placed_node placed = {item.node, item.transform};
        CHECK(built_unfold(store, item.node, &item.transform, &hidden));
        CHECK_EQUAL(STP_OK, stp_visibility_set(visibility, &placed, STP_SHOW_NOT));
        stp_sections sections = {0};
        stp_boxd box = d->nodes[d->root].bounds;
        CHECK(stp_sections_add_plane(&sections, stp_scaled(stp_addd(box.min, box.max), 0.6),
                                     (stp_vec3d){1, 2, 0.5}));
        for (uint64_t i = 0; i < 150; ++i) {
            stp_pick_desc desc = {.ray = random_ray(stp_rng_hash(seed, i), &box),
                                  .sections = &sections,
                                  .visibility = visibility};
            if (i % 2 == 0) { // at something
                stp_vec3d way = stp_subd(all.places[i % all.count].center, desc.ray.origin);
                desc.ray.direction = stp_normalized(way);
            }
            stp_pick pick;
            CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
            double nearest = meet_all(context, store, &all, &hidden, &desc);
            CHECK(pick.hit == (nearest < HUGE_VAL));
            hits += pick.hit ? 1 : 0;
            misses += pick.hit ? 0 : 1;
            if (!pick.hit) {
                continue;
            }
            CHECK(fabs(pick.distance - nearest) < 1e-7);
            CHECK(fabs(visit_object(&desc.ray, pick.corners) - nearest) < 1e-7);
            CHECK(stp_dotd(pick.normal, desc.ray.direction) <= 0.0);
            // the object found contains the part, and so does the node at the end of the path
            stp_instance place = stp_instance_of_part(store, pick.part, &pick.holder.transform);
            static built_places own;
            own.count = 0;
            CHECK_EQUAL(STP_OK,
                        stp_outline_find(outline, pick.part, &pick.holder.transform, &item));
            CHECK(item.depth > 0);
            CHECK(built_unfold(store, item.node, &item.transform, &own) && built_has(&own, &place));
            stp_outline_item child;
            uint32_t count = 1;
            for (uint64_t k = 0; count == 1; ++k) { // and none of its descendants
                CHECK_EQUAL(STP_OK, stp_outline_children(outline, &item, k, 1, &child, &count));
                own.count = 0;
                CHECK(count == 0 || child.node == STP_STORE_NONE ||
                      (built_unfold(store, child.node, &child.transform, &own) &&
                       !built_has(&own, &place)));
            }
            uint32_t node = d->root;
            for (uint32_t k = 0; k < pick.path_count; ++k) {
                CHECK(pick.path[k] < d->nodes[node].edge_count);
                node = d->edges[d->nodes[node].first_edge + pick.path[k]].node;
            }
            CHECK_EQUAL(pick.holder.node, node);
        }
        stp_visibility_destroy(visibility);
        stp_outline_destroy(outline);
        stp_store_close(store);
        stp_context_destroy(context);
    }
    CHECK(hits > 60 && misses > 30);
}

void test_picks_of_pixels_hit_what_lies_there(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    static made_scene scene;
    scene = (made_scene){.node_count = 1, .part_count = 2, .material_count = 1, .mesh_count = 1};
    scene.materials[0] = made_material();
    scene.meshes[0] = made_square(0);
    scene.point_set_count = 1;
    static const float points[6] = {0.25f, 0.5f, 1.0f, 9.0f, 9.0f, 9.0f};
    scene.point_sets[0] = (stp_store_point_set){
        .point_count = 2, .bounds = {{0.25f, 0.5f, 1}, {9, 9, 9}}, .positions = points};
    scene.parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    scene.parts[1] = (stp_store_part){STP_STORE_PART_POINTS, 0};
    scene.nodes[0] = (stp_store_node){.part_count = 2,
                                      .set = STP_STORE_NONE,
                                      .triangle_count = 2,
                                      .point_count = 2,
                                      .bounds = {{-1, -1, 0}, {9, 9, 9}}};
    stp_store* store = made_open(context, &scene);
    CHECK(store != NULL);
    stp_view views[] = {
        {.eye = {0, 0, 5}, .up = {0, 1, 0}, .fov_degrees = 40},
        {.eye = {0, 0, 5}, .up = {0, 1, 0}, .ortho_height = 4},
        {.eye = {0, 0, 5}, .up = {0, 1, 0}, .fov_degrees = 40, .eye_distance = 0.1}};
    for (int i = 0; i < 3; ++i) {
        views[i].width = i == 2 ? 400 : 200;
        views[i].height = 200;
        stp_pick_desc desc = {0};
        stp_pick pick;
        CHECK(stp_ray_of_pixel(&views[i], i == 2 ? 300 : 100, 100, &desc.ray));
        CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
        CHECK(pick.hit && pick.part.kind == STP_STORE_PART_MESH && fabs(pick.distance - 5) < 1e-9);
        CHECK(fabs(pick.position.x - (i == 2 ? 0.05 : 0.0)) < 1e-9 &&
              fabs(pick.normal.z - 1) < 1e-9);
        double width = 200.0 / (i == 1 ? 4.0 : 2.0 * 5.0 * tan(20 * STP_PI / 180)); // pixels a unit
        CHECK(stp_ray_of_pixel(&views[i], (i == 2 ? 300 : 100) + width * 1.2, 100, &desc.ray));
        CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
        CHECK(!pick.hit); // beside the square
        // towards the point, which is hit only if points are visible
        stp_vec3d way = stp_subd((stp_vec3d){0.2505, 0.5, 1}, views[i].eye);
        desc.ray = (stp_ray){
            .origin = views[i].eye, .direction = stp_normalized(way), .farthest = HUGE_VAL};
        CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
        CHECK(pick.hit && pick.part.kind == STP_STORE_PART_MESH);
        stp_pixel_width(&views[i], &desc.point_base, &desc.point_slope);
        CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
        CHECK(pick.hit && pick.part.kind == STP_STORE_PART_POINTS && pick.element == 0);
        CHECK(pick.position.x == 0.25 && pick.position.y == 0.5);
        const double far[] = {1e300, -1e300, HUGE_VAL, (double)NAN};
        for (int k = 0; k < 4; ++k) {
            CHECK(!stp_ray_of_pixel(&views[i], far[k], 100, &desc.ray));
            CHECK(!stp_ray_of_pixel(&views[i], 100, far[k], &desc.ray));
        }
    }
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_no_ray_slips_through_shared_edges(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    static made_scene scene;
    scene = (made_scene){.node_count = 1, .part_count = 1, .material_count = 1, .mesh_count = 1};
    scene.materials[0] = made_material();
    scene.meshes[0] = made_square(0);
    scene.nodes[0] = (stp_store_node){.part_count = 1,
                                      .set = STP_STORE_NONE,
                                      .triangle_count = 2,
                                      .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    stp_store* store = made_open(context, &scene);
    CHECK(store != NULL);
    for (uint64_t i = 0; i < 2000; ++i) { // at the diagonal
        double at = random_between(i, 0, -0.99, 0.99);
        stp_vec3d eye = {random_between(i, 1, -3, 3), random_between(i, 2, -3, 3),
                         random_between(i, 3, 0.5, 9)};
        for (int sign = -1; sign <= 1; sign += 2) {
            stp_vec3d way = stp_subd((stp_vec3d){at, sign * at, 0}, eye);
            stp_pick_desc desc = {
                .ray = {.origin = eye, .direction = stp_normalized(way), .farthest = HUGE_VAL}};
            stp_pick pick;
            CHECK_EQUAL(STP_OK, stp_pick_ray(context, store, &desc, &pick));
            CHECK(pick.hit);
            stp_vec3d snapped; // the diagonal is within a flat face
            CHECK_EQUAL(1, pick.inner[0] + pick.inner[1] + pick.inner[2]);
            if (sign > 0 && fabs(at) < 0.8) { // it runs along x = y, or across that
                stp_snap_kind kind = stp_pick_snap(&pick, 0.15, &snapped);
                CHECK(kind == STP_SNAP_NONE || kind == STP_SNAP_EDGE);
            }
        }
    }
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_picks_snap_to_corners_then_edges(test_state* test)
{
    stp_pick pick = {.hit = true, .position = {0.1, 0.02, 0}};
    pick.corners[0] = (stp_vec3d){0, 0, 0};
    pick.corners[1] = (stp_vec3d){1, 0, 0};
    pick.corners[2] = (stp_vec3d){0, 1, 0};
    stp_vec3d p;
    CHECK_EQUAL(STP_SNAP_NONE, stp_pick_snap(&pick, 0.01, &p));
    CHECK(p.x == 0.1 && p.y == 0.02);
    CHECK_EQUAL(STP_SNAP_EDGE, stp_pick_snap(&pick, 0.05, &p));
    CHECK(fabs(p.x - 0.1) < 1e-15 && p.y == 0.0);
    CHECK_EQUAL(STP_SNAP_VERTEX, stp_pick_snap(&pick, 0.2, &p));
    CHECK(p.x == 0.0 && p.y == 0.0);
    pick.hit = false;
    CHECK_EQUAL(STP_SNAP_NONE, stp_pick_snap(&pick, 9.0, &p));
}

void test_picks_refuse_invalid_rays_and_survive_lack_of_memory(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    test_log log = {0};
    stp_context* context = test_context(&heap, 1, &log);
    stp_context* builder = test_context(NULL, 1, NULL);
    stp_store* store = builder != NULL ? built_open(builder, 3, false) : NULL;
    CHECK(context != NULL && store != NULL);
    stp_boxd box =
        stp_store_get_directory(store)->nodes[stp_store_get_directory(store)->root].bounds;
    stp_pick_desc desc = {.ray = {.farthest = HUGE_VAL}};
    stp_pick pick;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_pick_ray(context, store, &desc, &pick));
    CHECK_EQUAL(1, log.errors);
    desc.ray = random_ray(8, &box);
    bool failed = true;
    for (int n = 0; failed; ++n) {
        log.errors = heap.count = 0;
        heap.fail_at = n;
        stp_result result = stp_pick_ray(context, store, &desc, &pick);
        failed = result != STP_OK;
        CHECK(!failed || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1 && !pick.hit));
    }
    stp_store_close(store);
    stp_context_destroy(builder);
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
}
