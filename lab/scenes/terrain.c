// SPDX-License-Identifier: MIT
#include "lab/scenes/terrain.h"

#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/noise.h"
#include "lab/scenes/scene_random.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/trees.h"

#include <assert.h>
#include <stdio.h>

// Every other row of a tile's vertices is shifted by half a cell; a strip of n cells has n + n + 1
// triangles. 54 strips of 91 triangles are the 4,914 of Brandt et al. 2019, 5.1.

static double smooth_step(double x)
{
    x = x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
    return x * x * (3.0 - 2.0 * x);
}

double terrain_height(const terrain_map* map, double x, double z)
{
    uint64_t seed = map->seed;
    double flat = smooth_step(terrain_site_distance(x, z) / 260.0);
    double road = smooth_step((terrain_road_distance(map, x, z) - 6.0) / 60.0);
    double broad =
        46.0 * noise2(seed, x / 900.0, z / 900.0) + 18.0 * noise2(seed + 1, x / 370.0, z / 370.0);
    double end_x = 0.5 * TILE_SIZE * TILE_COLUMNS - (x < 0.0 ? -x : x);
    double end_z = 0.5 * TILE_SIZE * TILE_ROWS - (z < 0.0 ? -z : z);
    double edge =
        smooth_step((end_x < end_z ? end_x : end_z) / 300.0); // copies join at level edges
    double fine = 4.0 * noise2_octaves(seed + 2, x / 90.0, z / 90.0, 3);
    double height = edge * flat * (broad + fine * road);
    return height - (1.0 - flat) * (0.12 + 0.03 * noise2(seed + 9, x / 11.0, z / 11.0));
}

// Grass, drier in some places, bare earth near the sites.
static void choose_color(mesh_builder* builder, uint64_t seed, double x, double z)
{
    double dry = 0.5 + 0.5 * noise2_octaves(seed + 20, x / 160.0, z / 160.0, 4);
    double patch = 0.9 + 0.2 * noise2(seed + 30, x / 9.0, z / 9.0);
    double earth = 1.0 - smooth_step(terrain_site_distance(x, z) / 60.0);
    double red = 0.085 + 0.12 * dry, green = 0.135 + 0.055 * dry, blue = 0.035 + 0.04 * dry;
    red += earth * (0.26 - red);
    green += earth * (0.22 - green);
    blue += earth * (0.15 - blue);
    mesh_builder_color(builder, red * patch, green * patch, blue * patch);
}

static void put_vertex(mesh_builder* builder, const terrain_tile* t, double x, double z)
{
    if (builder->counting) {
        mesh_builder_vertex(builder, (stp_vec3){0}, (stp_vec3){0});
        return;
    }
    const double step = 2.0;
    double left = TILE_SIZE * ((double)t->column - 0.5 * TILE_COLUMNS);
    double back = TILE_SIZE * ((double)t->row - 0.5 * TILE_ROWS);
    double height = terrain_height(t->map, left + x, back + z);
    double slope_x = terrain_height(t->map, left + x + step, back + z) - height;
    double slope_z = terrain_height(t->map, left + x, back + z + step) - height;
    choose_color(builder, t->map->seed, left + x, back + z);
    mesh_builder_vertex(builder, point3(x, height, z), point3(-slope_x, step, -slope_z));
}

// Row 0 has a vertex at each end of each cell, row 1 at both sides and the middles, and so on.
static uint32_t put_row(mesh_builder* builder, const terrain_tile* t, int row)
{
    uint32_t first = (uint32_t)builder->vertex_count;
    double z = TILE_SIZE * row / t->strips, cell = TILE_SIZE / t->cells;
    bool shifted = row % 2 == 1;
    for (int i = 0; i <= t->cells + (shifted ? 1 : 0); ++i) {
        double x = cell * (shifted ? (double)i - 0.5 : (double)i);
        x = x < 0.0 ? 0.0 : i >= t->cells && x > TILE_SIZE - 0.25 * cell ? TILE_SIZE : x;
        put_vertex(builder, t, x, z);
    }
    return first;
}

void terrain_make_tile(mesh_builder* builder, const void* parameters)
{
    const terrain_tile* t = parameters;
    uint32_t cells = (uint32_t)t->cells, above = put_row(builder, t, 0);
    for (int row = 1; row <= t->strips; ++row) {
        uint32_t below = put_row(builder, t, row);
        // the row with one vertex more
        uint32_t wide = row % 2 == 1 ? below : above, narrow = row % 2 == 1 ? above : below;
        for (uint32_t i = 0; i <= cells; ++i) {
            uint32_t a = wide + i, b = wide + i + 1, c = narrow + i;
            mesh_builder_triangle(builder, wide == below ? a : b, wide == below ? b : a, c);
            if (i < cells) {
                mesh_builder_triangle(builder, wide == below ? c : b, wide == below ? b : c, c + 1);
            }
        }
        above = below;
    }
}

static stp_result make_tiles(stp_scene* scene, const scene_options* options, const terrain_map* map,
                             uint32_t* first_mesh)
{
    terrain_tile* tiles = STP_NEW_ARRAY(scene->context, terrain_tile, TILE_COUNT);
    mesh_recipe* recipes = STP_NEW_ARRAY(scene->context, mesh_recipe, TILE_COUNT);
    uint32_t material;
    stp_result result = add_plain_material(scene, "ground", 0xffffff, 0.95, &material);
    if (result == STP_OK && (tiles == NULL || recipes == NULL)) {
        result = stp_fail_memory(scene->context);
    }
    double fineness = options->scale < 1.0 ? sqrt(options->scale) : 1.0;
    int strips = 2 * (int)(0.5 * TILE_STRIPS * fineness + 0.5),
        cells = (int)(TILE_CELLS * fineness + 0.5);
    for (uint32_t i = 0; result == STP_OK && i < TILE_COUNT; ++i) {
        tiles[i] = (terrain_tile){.column = i % TILE_COLUMNS,
                                  .row = i / TILE_COLUMNS,
                                  .strips = strips < 2 ? 2 : strips,
                                  .cells = cells < 2 ? 2 : cells,
                                  .map = map};
        recipes[i] = (mesh_recipe){"terrain tile", terrain_make_tile, &tiles[i], material};
    }
    result = result == STP_OK ? make_meshes(scene, recipes, TILE_COUNT, first_mesh) : result;
    stp_free(scene->context, recipes);
    stp_free(scene->context, tiles);
    return result;
}

stp_result terrain_add_tree_meshes(stp_scene* scene, uint64_t seed, double detail,
                                   uint32_t* first_mesh)
{
    stp_material material = stp_material_default();
    material.name = "bark and leaves";
    material.metallic = 0.0f;
    material.roughness = 0.9f;
    material.double_sided = true;
    uint32_t index;
    tree_recipe trees[TREE_KINDS];
    mesh_recipe recipes[TREE_KINDS];
    stp_result result = stp_scene_add_material(scene, &material, &index);
    for (uint32_t i = 0; i < TREE_KINDS; ++i) {
        double wanted = detail < 1.0 ? detail * tree_triangles(i) : tree_triangles(i);
        trees[i] =
            (tree_recipe){.kind = i,
                          .seed = seed,
                          .triangles = 2 * (uint32_t)(wanted < 400.0 ? 200.0 : 0.5 * wanted)};
        recipes[i] = (mesh_recipe){tree_name(i), tree_make, &trees[i], index};
    }
    return result == STP_OK ? make_meshes(scene, recipes, TREE_KINDS, first_mesh) : result;
}

// Adds an object per tree kind on the tile, with an instance per tree.
static stp_result add_tile_trees(stp_scene* scene, const terrain_tree* trees, size_t count,
                                 uint32_t parent, const terrain_tile* t, uint32_t first_mesh)
{
    stp_affine still = stp_affine_identity();
    stp_result result = STP_OK;
    double left = TILE_SIZE * ((double)t->column - 0.5 * TILE_COLUMNS);
    double back = TILE_SIZE * ((double)t->row - 0.5 * TILE_ROWS);
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        if (i == 0 || trees[i].kind != trees[i - 1].kind) {
            result = add_mesh_object(scene, tree_name(trees[i].kind), parent, &still,
                                     first_mesh + trees[i].kind);
        }
        random_stream random = random_begin(t->map->seed ^ ((uint64_t)trees[i].tile << 32 | i));
        double size = random_between(&random, 0.75, 1.2);
        double ground = terrain_height(t->map, trees[i].x, trees[i].z) - 0.15;
        stp_affine place =
            place_turned(trees[i].x - left, ground, trees[i].z - back, random_unit(&random), size);
        result = result == STP_OK ? stp_scene_add_instance(scene, &place) : result;
    }
    return result;
}

static stp_result add_tiles(stp_scene* scene, const terrain_map* map, uint32_t parent,
                            const terrain_tree* trees, size_t tree_count, uint32_t first_tile,
                            uint32_t first_tree)
{
    stp_result result = STP_OK;
    size_t at = 0;
    for (uint32_t i = 0; result == STP_OK && i < TILE_COUNT; ++i) {
        terrain_tile t = {.column = i % TILE_COLUMNS, .row = i / TILE_COLUMNS, .map = map};
        stp_affine place = place_at(TILE_SIZE * ((double)t.column - 0.5 * TILE_COLUMNS), 0,
                                    TILE_SIZE * ((double)t.row - 0.5 * TILE_ROWS));
        char name[32];
        uint32_t object = (uint32_t)scene->object_count;
        snprintf(name, sizeof(name), "tile %u,%u", t.column, t.row);
        result = add_mesh_object(scene, name, parent, &place, first_tile + i);
        size_t end = at;
        while (end < tree_count && trees[end].tile == i) {
            end += 1;
        }
        if (result == STP_OK) {
            result = add_tile_trees(scene, trees + at, end - at, object, &t, first_tree);
        }
        at = end;
    }
    assert((result != STP_OK || at == tree_count) && "trees are sorted by tile");
    return result;
}

// Table 1: 1.73 M unique triangles, of which tiles have 1.278 M and trees 0.348 M.
#define ROAD_TRIANGLES 104740u
#define TREES 30000.0

stp_result scene_add_terrain(stp_scene* scene, uint32_t parent, const stp_affine* place,
                             const scene_options* options, uint32_t* object)
{
    uint32_t top, first_tile, first_tree;
    double detail = 16.0 * options->scale;
    terrain_map map;
    terrain_map_make(&map, options->seed);
    stp_result result = add_group(scene, "Terrain", parent, place, &top);
    if (object != NULL) {
        *object = top;
    }
    result = result == STP_OK ? make_tiles(scene, options, &map, &first_tile) : result;
    result = result == STP_OK ? terrain_add_tree_meshes(scene, options->seed, detail, &first_tree)
                              : result;
    uint32_t count = (uint32_t)(TREES * options->scale + 0.5);
    terrain_tree* trees = NULL;
    if (result == STP_OK) {
        trees = terrain_plant_trees(scene->context, &map, count);
        result = trees != NULL ? STP_OK : stp_fail_memory(scene->context);
    }
    result = result == STP_OK ? add_tiles(scene, &map, top, trees, count, first_tile, first_tree)
                              : result;
    stp_free(scene->context, trees);
    double road = ROAD_TRIANGLES * (options->scale < 1.0 ? options->scale : 1.0);
    return result == STP_OK ? terrain_add_roads(scene, top, &map, (uint64_t)road) : result;
}
