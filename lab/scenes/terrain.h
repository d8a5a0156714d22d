// SPDX-License-Identifier: MIT
//
// The ground of scene `paper`: 20 x 13 tiles around the origin, with hills, flat sites, roads and
// forests. See scene_add_terrain in lab/scenes/scenes.h.
#pragma once

#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/scenes.h"

#define TILE_SIZE 255.0 // metres
enum { TILE_COLUMNS = 20, TILE_ROWS = 13, TILE_COUNT = TILE_COLUMNS * TILE_ROWS };

/// Site of a part: flat ground around (x, z), with these half extents.
typedef struct terrain_site {
    double x, z, half_width, half_depth;
} terrain_site;

enum { SITE_CITY, SITE_CAR_FACTORY, SITE_BAKERY, SITE_POWER_PLANTS, SITE_COUNT };
extern const terrain_site terrain_sites[SITE_COUNT];

enum { ROAD_COUNT = 6, ROAD_SEGMENTS = 258, ROAD_PIECES = 40, ROAD_RUN = 8 };

/// Input of the height function: the roads as polylines, with boxes around runs of pieces.
typedef struct terrain_map {
    uint64_t seed;
    double points[ROAD_COUNT][ROAD_PIECES + 1][2];
    double boxes[ROAD_COUNT][ROAD_PIECES / ROAD_RUN][4]; ///< minimum x and z, maximum x and z
} terrain_map;

void terrain_map_make(terrain_map* map, uint64_t seed);
/// Height of the ground.
double terrain_height(const terrain_map* map, double x, double z);
/// Metres to the nearest site; 0 within one.
double terrain_site_distance(double x, double z);
/// Metres to the centre of the nearest road; 100 if none is nearer.
double terrain_road_distance(const terrain_map* map, double x, double z);

/// A point of road `road`, at `t` in 0..1 along it. `direction` (along the ground) may be NULL.
stp_vec3d terrain_road_point(int road, double t, stp_vec3d* direction);
/// Length of a road in metres, for sharing out segments.
double terrain_road_length(int road);

/// A tile: a hexagonal grid. The paper's has 54 strips of 45 cells: 4,914 triangles.
enum { TILE_STRIPS = 54, TILE_CELLS = 45 };
typedef struct terrain_tile {
    uint32_t column, row;
    int strips, cells;
    const terrain_map* map;
} terrain_tile;

/// A mesh_maker of a terrain_tile.
void terrain_make_tile(mesh_builder* builder, const void* tile);

/// Triangles of each road segment for about `triangles` in all. @return their sum
uint64_t terrain_count_roads(const terrain_map* map, uint64_t triangles,
                             uint64_t counts[ROAD_SEGMENTS]);
/// Adds 258 meshes and their objects below `parent`, with `triangles` triangles in all.
STP_MUST_USE stp_result terrain_add_roads(stp_scene* scene, uint32_t parent, const terrain_map* map,
                                          uint64_t triangles);
/// Adds a mesh for each kind of tree, with `detail` (at most 1) times its triangles, at least 400.
STP_MUST_USE stp_result terrain_add_tree_meshes(stp_scene* scene, uint64_t seed, double detail,
                                                uint32_t* first_mesh);

/// A tree on the ground.
typedef struct terrain_tree {
    uint32_t tile, kind;
    double x, z; ///< relative to the whole terrain
} terrain_tree;

/// Plants `count` trees in forests, the same number of each kind; sorted by tile, then kind. The
/// caller frees the array (stp_free); NULL if out of memory.
terrain_tree* terrain_plant_trees(stp_context* context, const terrain_map* map, uint32_t count);
