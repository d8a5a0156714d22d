// SPDX-License-Identifier: MIT
//
// A Roman city, after the Pompeii of Brandt et al. 2019, 5.1: streets and insulae of houses; each
// wall, roof, door and table is a separate object. First all pieces are planned, then triangles
// are counted and fitted, and only then made.
#pragma once

#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/scene_random.h"

typedef enum city_kind {
    CITY_WALL,       ///< length, height, thickness, openings (city_openings)
    CITY_ROOF,       ///< width, run, rise, size of a tile: tiles of clay, the eave at z = 0
    CITY_FLOOR,      ///< width, depth, stone: slabs
    CITY_BASIN,      ///< width, depth: a pool with a rim
    CITY_DOOR,       ///< width, height: two leaves with panels and studs
    CITY_TABLE,      ///< width, depth, height
    CITY_COUNTER,    ///< length: of a tavern, with jars let in
    CITY_SHRINE,     ///< height
    CITY_COUCH,      ///< length
    CITY_MILL,       ///< height: of a bakery
    CITY_BED,        ///< width, depth: plants
    CITY_AWNING,     ///< width, depth: cloth
    CITY_STALL,      ///< width, depth: crates and baskets
    CITY_CART,       ///< length
    CITY_PAVING,     ///< width, length: rough polygonal stones
    CITY_KERB,       ///< length: pavement and its stones
    CITY_STEPS,      ///< width, count: stepping stones across a street
    CITY_RAMPART,    ///< length, height: of the city wall
    CITY_TOWER,      ///< side, height
    CITY_PODIUM,     ///< width, depth, height: with stairs in front
    CITY_ARCHITRAVE, ///< length, height
    CITY_GABLE,      ///< width, height, thickness
    CITY_ARCADE,     ///< length, height, thickness: arches on piers
    CITY_SEATS,  ///< radii within and without, angle in turns, height: a wedge of an amphitheatre
    CITY_BEAMS,  ///< width, run: timber under a roof
    CITY_COLUMN, ///< height, radius, order 0..2; instances share the pieces from here on
    CITY_AMPHORA,
    CITY_STATUE,
    CITY_FOUNTAIN,
    CITY_TREE, ///< kind (0: oak, 1: cypress), triangles
    CITY_KINDS
} city_kind;

typedef enum city_openings {
    OPEN_NONE,
    OPEN_DOOR,
    OPEN_WINDOWS,
    OPEN_DOOR_WINDOWS,
    OPEN_SHOPS,
    OPEN_ROOMS, ///< a row of doors
} city_openings;

typedef enum city_paint {
    PAINT_WHITE,
    PAINT_CREAM,
    PAINT_OCHRE,
    PAINT_RED,
    PAINT_ROSE,
    PAINT_GREY,
    PAINT_TUFA,
    PAINT_BASALT,
    PAINT_KERB,
    PAINT_TILE,
    PAINT_TILE_DARK,
    PAINT_TILE_PALE,
    PAINT_WOOD,
    PAINT_WOOD_DARK,
    PAINT_WOOD_PALE,
    PAINT_MARBLE,
    PAINT_MARBLE_GREY,
    PAINT_MOSAIC,
    PAINT_TERRAZZO,
    PAINT_BRICK,
    PAINT_PLANTS,
    PAINT_SOIL,
    PAINT_CLOTH_RED,
    PAINT_CLOTH_BLUE,
    PAINT_CLOTH_YELLOW,
    PAINT_CLAY,
    PAINT_BRONZE,
    PAINT_TREE,
    PAINT_COUNT
} city_paint;

/// Parameters of one mesh.
typedef struct city_piece {
    city_kind kind;
    uint32_t paint;
    uint64_t seed;
    double sizes[4];
} city_piece;

/// A placed piece, or a group (piece STP_NONE).
typedef struct city_item {
    const char* name; ///< static text
    uint32_t parent;  ///< item; STP_NONE: the city
    uint32_t piece;
    stp_affine place;
} city_item;

/// A place where a tree or an amphora may stand.
typedef struct city_spot {
    uint32_t parent;
    double x, y, z;
} city_spot;

typedef struct city_plan {
    stp_context* context;
    random_stream random;
    city_piece* pieces;
    city_item* items;
    city_spot *tree_spots, *jar_spots;
    size_t piece_count, item_count, tree_spot_count, jar_spot_count;
    size_t piece_capacity, item_capacity, tree_spot_capacity, jar_spot_capacity;
    uint32_t columns[3], amphora, statue, fountain, trees[2]; ///< pieces that instances share
    uint32_t group;                                           ///< parent of the next items
    uint64_t unique_wanted, objects_wanted, triangles_wanted, unique_triangles_wanted;
    uint64_t objects;    ///< items that are not groups
    uint64_t* triangles; ///< triangles of each piece, counted by city_plan_make
    bool failed;
} city_plan;

/// Starts with the shared pieces.
void city_plan_begin(city_plan* plan, stp_context* context, const scene_options* options);
void city_plan_end(city_plan* plan);
/// Plans the whole city: fills the plan up to the wanted numbers and fits the size of tiles.
void city_plan_make(city_plan* plan);

/// Adds a group below the current one (or below the city, `top`) and makes it current.
/// @return the previous one
uint32_t city_enter(city_plan* plan, const char* name, bool top, stp_affine place);
/// An instance of a piece in the current group.
void city_show(city_plan* plan, const char* name, uint32_t piece, stp_affine place);
/// Adds a piece, which has four sizes, and shows it once.
void city_put(city_plan* plan, const char* name, city_kind kind, uint32_t paint, double a, double b,
              double c, double d, stp_affine place);
void city_tree_spot(city_plan* plan, double x, double y, double z);
void city_jar_spot(city_plan* plan, double x, double y, double z);

/// A house on a lot of that width and depth; the street runs along z = 0.
void city_plan_house(city_plan* plan, double width, double depth);
/// Forum, temples, basilica on about 140 m x 120 m around the origin.
void city_plan_forum(city_plan* plan);
void city_plan_temple(city_plan* plan, double width, double depth, int order);
void city_plan_amphitheatre(city_plan* plan);

/// A mesh_maker of a city_piece.
void city_make_piece(mesh_builder* builder, const void* piece);
/// Triangles of a roof, by formula.
uint64_t city_roof_triangles(const city_piece* roof);

// Makers of pieces, in city_walls.c and city_furniture.c.
void city_make_wall(mesh_builder* builder, const city_piece* piece);
void city_make_roof(mesh_builder* builder, const city_piece* piece);
void city_make_furniture(mesh_builder* builder, const city_piece* piece);
