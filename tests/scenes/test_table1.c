// SPDX-License-Identifier: MIT
//
// The numbers of Table 1 of Brandt et al. 2019, for parts of the scene `paper`.
#include "support_scenes.h"

#include "lab/scenes/city.h"
#include "lab/scenes/terrain.h"
#include "lab/scenes/trees.h"

#include <math.h>

static bool within(uint64_t value, double wanted, double tolerance)
{
    return fabs((double)value - wanted) <= tolerance * wanted;
}

// Plans alone: counted before any triangle is made.
void test_city_is_planned_to_table1(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    city_plan plan;
    city_plan_begin(&plan, context, &(scene_options){.scale = 1.0});
    city_plan_make(&plan);
    CHECK(!plan.failed);
    CHECK_EQUAL(26878, plan.piece_count);
    CHECK_EQUAL(33167, plan.objects);
    uint64_t unique = 0, all = 0;
    for (size_t i = 0; i < plan.piece_count; ++i) {
        unique += plan.triangles[i];
    }
    for (size_t i = 0; i < plan.item_count; ++i) {
        all += plan.items[i].piece != STP_NONE ? plan.triangles[plan.items[i].piece] : 0;
    }
    CHECK(within(unique, 40.35e6, 0.001));
    CHECK(within(all, 62.93e6, 0.001));
    city_plan_end(&plan);
    stp_context_destroy(context);
}

void test_city_meshes_are_as_planned_and_all_different(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    scene_options options = {.scale = 1.0 / 64.0};
    stp_scene* scene = make_scene(context, "city", options.scale, 0);
    CHECK(scene != NULL);
    city_plan plan;
    city_plan_begin(&plan, context, &options);
    city_plan_make(&plan);
    scene_sums sums = sum_scene(scene);
    uint64_t unique = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        unique += scene->meshes[i].triangle_count;
    }
    CHECK_EQUAL(420, scene->mesh_count); // none was merged with another
    CHECK_EQUAL(518, sums.objects);
    CHECK(within(unique, 40.35e6 / 64.0, 0.002));
    CHECK_EQUAL(plan.piece_count, scene->mesh_count);
    for (size_t i = 0; i < plan.piece_count; ++i) {
        CHECK_EQUAL(plan.triangles[i], scene->meshes[i].triangle_count);
    }
    city_plan_end(&plan);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Every kind of piece, also those missing in a small city.
void test_city_pieces_are_counted_as_made(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (int kind = 0; kind < CITY_KINDS; ++kind) {
        city_piece piece = {.kind = (city_kind)kind, .seed = 5, .sizes = {3.0, 2.5, 1.2, 0.4}};
        mesh_builder builder;
        mesh_builder_init(&builder, context);
        piece.sizes[1] = piece.kind == CITY_TREE ? 2000 : piece.sizes[1];
        city_make_piece(&builder, &piece);
        CHECK(!builder.failed && builder.index_count > 0);
        CHECK_EQUAL(builder.index_count / 3, count_triangles(city_make_piece, &piece));
        for (size_t i = 0; i < builder.index_count; ++i) {
            CHECK(builder.indices[i] < builder.vertex_count);
        }
        mesh_builder_destroy(&builder);
    }
    stp_context_destroy(context);
}

void test_trees_have_exactly_the_triangles_wanted(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    uint64_t sum = 0;
    for (uint32_t kind = 0; kind < TREE_KINDS; ++kind) {
        CHECK(tree_triangles(kind) >= 40000 && tree_triangles(kind) <= 70000);
        sum += tree_triangles(kind);
        tree_recipe recipe = {.kind = kind, .triangles = kind == 0 ? tree_triangles(0) : 3000};
        mesh_builder builder;
        mesh_builder_init(&builder, context);
        tree_make(&builder, &recipe);
        CHECK(!builder.failed && builder.colors != NULL);
        CHECK_EQUAL(3 * (size_t)recipe.triangles, builder.index_count);
        mesh_builder_destroy(&builder);
    }
    CHECK_EQUAL(TREE_TRIANGLES, sum);
    stp_context_destroy(context);
}

// 260 tiles of 4,914 triangles, 6 kinds of trees, 258 segments of roads; 30,000 trees as planted.
void test_terrain_is_planned_to_table1(test_state* test)
{
    terrain_map map;
    terrain_map_make(&map, 0);
    terrain_tile tile = {.strips = TILE_STRIPS, .cells = TILE_CELLS, .map = &map};
    CHECK_EQUAL(4914, count_triangles(terrain_make_tile, &tile));
    uint64_t counts[ROAD_SEGMENTS], roads = terrain_count_roads(&map, 104740, counts);
    for (int i = 0; i < ROAD_SEGMENTS; ++i) {
        CHECK(counts[i] >= 100 && counts[i] <= 5200);
    }
    uint64_t ground = TILE_COUNT * 4914 + roads;
    CHECK(within(ground + TREE_TRIANGLES, 1.73e6, 0.001));
    stp_context* context = test_context(NULL, 1, NULL);
    terrain_tree* trees = terrain_plant_trees(context, &map, 30000);
    CHECK(trees != NULL);
    uint64_t sum = ground;
    bool wooded[TILE_COUNT] = {false};
    for (int i = 0; i < 30000; ++i) {
        sum += tree_triangles(trees[i].kind);
        wooded[trees[i].tile] = true;
        CHECK(terrain_site_distance(trees[i].x, trees[i].z) > 0.0);
    }
    CHECK(within(sum, 1.74e9, 0.001));
    int bare = 0;
    for (int i = 0; i < TILE_COUNT; ++i) {
        bare += wooded[i] ? 0 : 1;
    }
    CHECK_EQUAL(130, bare);
    stp_free(context, trees);
    stp_context_destroy(context);
}

void test_terrain_has_the_objects_planned(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = make_scene(context, "terrain", 1.0 / 64.0, 0);
    CHECK(scene != NULL);
    scene_sums sums = sum_scene(scene);
    CHECK_EQUAL(524, sums.unique_objects);
    CHECK_EQUAL(260 + 258 + 469, sums.objects); // 30,000 / 64 trees
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// The vertices of two tiles along their common edge are the same, to the bit.
void test_terrain_tiles_join_without_cracks(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    scene_options options = {.scale = 0.05, .seed = 3};
    stp_affine still = stp_affine_identity();
    CHECK(stp_scene_create(context, &scene) == STP_OK);
    CHECK(scene_add_terrain(scene, STP_NONE, &still, &options, NULL) == STP_OK);
    for (uint32_t i = 0; i < TILE_COUNT; ++i) {
        for (int axis = 0; axis < 2; ++axis) {
            uint32_t step = axis == 0 ? 1 : TILE_COLUMNS;
            bool last = axis == 0 ? i % TILE_COLUMNS == TILE_COLUMNS - 1 : i + step >= TILE_COUNT;
            if (last) {
                continue;
            }
            const stp_mesh *a = &scene->meshes[i], *b = &scene->meshes[i + step];
            size_t k = 0, matched = 0;
            for (size_t v = 0; v < a->vertex_count; ++v) {
                const float* p = a->positions + 3 * v;
                if (p[2 * axis] < 255.0f) {
                    continue;
                }
                for (; k < b->vertex_count; ++k) {
                    const float* q = b->positions + 3 * k;
                    if (!(q[2 * axis] > 0.0f) && !(q[2 - 2 * axis] < p[2 - 2 * axis])) {
                        matched +=
                            !(q[1] < p[1]) && !(q[1] > p[1]) && !(q[2 - 2 * axis] > p[2 - 2 * axis])
                                ? 1
                                : 0;
                        break;
                    }
                }
                matched += 1000000;
            }
            CHECK(matched > 1000000 && matched % 1000000 == matched / 1000000);
        }
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
