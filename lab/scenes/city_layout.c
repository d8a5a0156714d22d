// SPDX-License-Identifier: MIT
//
// The map of the city: 10 x 8 insulae between straight streets, walls around them, the forum in the
// middle. Blocks closest to the forum come first, so a small city is its centre. Then amounts are
// fitted to Table 1.
#include "lab/scenes/city.h"

#include <stdlib.h>

enum { BLOCKS_X = 10, BLOCKS_Z = 8, BLOCKS = BLOCKS_X * BLOCKS_Z };
#define PITCH_X 78.0
#define PITCH_Z 73.0
#define BLOCK_X 70.0
#define BLOCK_Z 66.0

typedef enum block_use { USE_HOUSES, USE_FORUM, USE_ARENA, USE_TEMPLE, USE_ORCHARD } block_use;

typedef struct block {
    int column, row;
    double distance; ///< from the forum
} block;

static block_use use_of(const block* b)
{
    int x = b->column, z = b->row;
    if ((x == 4 || x == 5) && (z == 3 || z == 4)) {
        return USE_FORUM;
    }
    if (x >= 8 && z <= 1) {
        return USE_ARENA;
    }
    if ((x == 2 && z == 1) || (x == 6 && z == 6) || (x == 1 && z == 5)) {
        return USE_TEMPLE;
    }
    return (x == 9 && z >= 6) || (x == 0 && z == 0) || (x == 0 && z == 7) ? USE_ORCHARD
                                                                          : USE_HOUSES;
}

static double block_x(const block* b)
{
    return -0.5 * PITCH_X * BLOCKS_X + PITCH_X * b->column + 0.5 * (PITCH_X - BLOCK_X);
}

static double block_z(const block* b)
{
    return -0.5 * PITCH_Z * BLOCKS_Z + PITCH_Z * b->row + 0.5 * (PITCH_Z - BLOCK_Z);
}

static int compare_blocks(const void* left, const void* right)
{
    const block *a = left, *b = right;
    if (a->distance < b->distance || a->distance > b->distance) {
        return a->distance < b->distance ? -1 : 1;
    }
    return a->column != b->column ? a->column - b->column : a->row - b->row;
}

// Whether this block and the next form one place without a street between them.
static bool is_joined(const block* b, int columns, int rows)
{
    block beside = {.column = b->column + columns, .row = b->row + rows};
    block_use use = use_of(b);
    return (use == USE_FORUM || use == USE_ARENA) && use_of(&beside) == use;
}

// Pavements around the block; the roads to the south and west, their crossing, stepping stones; the
// ground.
static void plan_streets(city_plan* plan, const block* b)
{
    double road_x = PITCH_X - BLOCK_X, road_z = PITCH_Z - BLOCK_Z;
    bool west = !is_joined(b, -1, 0), south = !is_joined(b, 0, -1);
    city_enter(plan, "streets", true, place_at(block_x(b), 0, block_z(b)));
    city_put(plan, "ground", CITY_FLOOR, PAINT_SOIL, PITCH_X, PITCH_Z, 6.0, 0,
             place_at(-road_x, -0.05, -road_z));
    if (south) {
        city_put(plan, "pavement", CITY_KERB, PAINT_KERB, BLOCK_X, 0, 0, 0, place_at(0, 0, -1.4));
        city_put(plan, "paving", CITY_PAVING, PAINT_BASALT, road_z - 2.8, BLOCK_X, 0, 0,
                 place_turned(0, 0, -1.4, 0.25, 1.0));
        city_put(plan, "stepping stones", CITY_STEPS, PAINT_BASALT, road_z - 2.8, 3, 0, 0,
                 place_turned(1.0, 0, 1.4 - road_z, -0.25, 1.0));
    }
    if (!is_joined(b, 0, 1)) {
        city_put(plan, "pavement", CITY_KERB, PAINT_KERB, BLOCK_X, 0, 0, 0,
                 place_turned(BLOCK_X, 0, BLOCK_Z + 1.4, 0.5, 1.0));
    }
    if (west) {
        city_put(plan, "pavement", CITY_KERB, PAINT_KERB, BLOCK_Z, 0, 0, 0,
                 place_turned(-1.4, 0, BLOCK_Z, 0.25, 1.0));
        city_put(plan, "paving", CITY_PAVING, PAINT_BASALT, road_x - 2.8, BLOCK_Z, 0, 0,
                 place_at(1.4 - road_x, 0, 0));
        city_put(plan, "stepping stones", CITY_STEPS, PAINT_BASALT, road_x - 2.8, 4, 0, 0,
                 place_at(1.4 - road_x, 0, 1.0));
    }
    if (!is_joined(b, 1, 0)) {
        city_put(plan, "pavement", CITY_KERB, PAINT_KERB, BLOCK_Z, 0, 0, 0,
                 place_turned(BLOCK_X + 1.4, 0, 0, -0.25, 1.0));
    }
    if (west && south) {
        city_put(plan, "paving", CITY_PAVING, PAINT_BASALT, road_x, road_z, 0, 0,
                 place_at(-road_x, 0, -road_z));
    }
}

static bool is_full(const city_plan* plan)
{
    const uint64_t house = 62; // pieces of a large one
    uint64_t trade = plan->unique_wanted / 32;
    return plan->piece_count + (trade > house ? trade : house) >= plan->unique_wanted;
}

// Two rows of lots back to back.
static void plan_houses(city_plan* plan, const block* b)
{
    city_enter(plan, "insula", true, place_at(block_x(b), 0, block_z(b)));
    uint32_t insula = plan->group;
    for (int side = 0; side < 2; ++side) {
        for (double at = 0.0; BLOCK_X - at > 1.0 && !is_full(plan);) {
            double width = random_between(&plan->random, 9.5, 18.5);
            width = BLOCK_X - at - width < 9.5 ? BLOCK_X - at : width;
            plan->group = insula;
            city_enter(plan, "house", false,
                       side == 0 ? place_at(at, 0, 0)
                                 : place_turned(at + width, 0, BLOCK_Z, 0.5, 1.0));
            city_plan_house(plan, width, 0.5 * BLOCK_Z);
            at += width;
        }
    }
}

static void plan_orchard(city_plan* plan, const block* b)
{
    city_enter(plan, "orchard", true, place_at(block_x(b), 0, block_z(b)));
    for (int i = 0; i < 56; ++i) {
        double x = BLOCK_X * (i % 8 + 0.5) / 8.0, z = BLOCK_Z * (i / 8 + 0.5) / 7.0;
        city_tree_spot(plan, x, 0, z);
    }
    for (int i = 0; i < 14 && !is_full(plan); ++i) {
        city_put(plan, "vines", CITY_BED, PAINT_PLANTS, BLOCK_X - 6.0, 1.4, 0, 0,
                 place_at(3.0, 0, 4.6 * i + 1.0));
    }
}

static void plan_temple_block(city_plan* plan, const block* b)
{
    double x = block_x(b) + 0.5 * BLOCK_X, z = block_z(b) + 0.5 * BLOCK_Z;
    city_enter(plan, "temple", true, place_at(x, 0, z));
    city_plan_temple(plan, 15.0 + b->column, 28.0, 1);
    for (int i = 0; i < 12; ++i) {
        city_tree_spot(plan, -26.0 + 52.0 * (i % 2), 0, -25.0 + 10.0 * (i / 2));
    }
    for (int i = 0; i < 36; ++i) {
        city_put(plan, "precinct paving", CITY_FLOOR, PAINT_TERRAZZO, 10.0, 10.0, 1.2, 0,
                 place_at(-30.0 + 10.0 * (i % 6), 0, -30.0 + 10.0 * (i / 6)));
    }
}

static void plan_block(city_plan* plan, const block* b)
{
    plan_streets(plan, b);
    switch (use_of(b)) {
    case USE_FORUM:
        if (b->column == 4 && b->row == 3) {
            city_enter(plan, "forum", true, place_at(0, 0, 0));
            city_plan_forum(plan);
        }
        break;
    case USE_ARENA:
        if (b->column == 8 && b->row == 1) {
            city_enter(plan, "amphitheatre", true,
                       place_at(block_x(b) + BLOCK_X + 4.0, 0, block_z(b) - 3.5));
            city_plan_amphitheatre(plan);
        }
        break;
    case USE_TEMPLE:
        plan_temple_block(plan, b);
        break;
    case USE_ORCHARD:
        plan_orchard(plan, b);
        break;
    default:
        plan_houses(plan, b);
        break;
    }
}

static void plan_ramparts(city_plan* plan)
{
    double half_x = 0.5 * PITCH_X * BLOCKS_X + 4.0, half_z = 0.5 * PITCH_Z * BLOCKS_Z + 4.0;
    city_enter(plan, "city wall", true, place_at(0, 0, 0));
    for (int side = 0; side < 4; ++side) {
        bool long_side = side % 2 == 0;
        double length = 2.0 * (long_side ? half_x : half_z), out = long_side ? half_z : half_x;
        int pieces = (int)(length / 39.0);
        stp_affine turn = place_turned(0, 0, 0, 0.25 * side, 1.0);
        for (int i = 0; i < pieces; ++i) {
            double at = -0.5 * length + length * i / pieces;
            bool gate = i == pieces / 2;
            stp_affine place = stp_affine_multiply(turn, place_at(at, 0, -out));
            if (gate) {
                city_put(plan, "gate", CITY_ARCADE, PAINT_TUFA, length / pieces, 8.0, 5.0, 0,
                         place);
            } else {
                city_put(plan, "rampart", CITY_RAMPART, PAINT_TUFA, length / pieces, 7.0, 0, 0,
                         place);
            }
            stp_affine corner = stp_affine_multiply(turn, place_at(at - 3.0, 0, -out - 2.0));
            city_put(plan, "tower", CITY_TOWER, PAINT_TUFA, 7.0, gate ? 13.0 : 10.5, 0, 0, corner);
        }
    }
}

// Puts the missing unique objects along the built streets.
static void plan_stalls(city_plan* plan, const block* blocks, int built)
{
    for (int i = 0; built > 0 && plan->piece_count < plan->unique_wanted && !plan->failed; ++i) {
        const block* b = &blocks[i % built];
        double x = block_x(b) + random_between(&plan->random, 1.0, BLOCK_X - 4.0);
        double z = block_z(b) + (i / built % 2 == 0 ? -1.35 : BLOCK_Z + 0.2);
        if (i < built) {
            city_enter(plan, "street trade", true, place_at(0, 0, 0));
        }
        if (i % 11 == 0) {
            city_put(plan, "cart", CITY_CART, PAINT_WOOD, 2.1, 0, 0, 0, place_at(x, 0, z - 1.6));
        } else {
            city_put(plan, "goods", CITY_STALL, PAINT_WOOD_PALE, 2.2, 0.9, 0, 0,
                     place_at(x, 0.4, z));
        }
    }
}

static void count_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    city_plan* plan = user;
    for (size_t i = begin; i < end; ++i) {
        plan->triangles[i] = count_triangles(city_make_piece, &plan->pieces[i]);
    }
}

// Roofs have tiles of different sizes, so that the total changes gradually.
static void set_tiles(city_plan* plan, double tile)
{
    for (size_t i = 0; i < plan->piece_count; ++i) {
        city_piece* piece = &plan->pieces[i];
        if (piece->kind == CITY_ROOF) {
            piece->sizes[3] = tile * (0.85 + 0.3 * (double)(piece->seed >> 40) / 16777216.0);
        }
    }
}

// Finds the tile size that gives the wanted number of unique triangles: counts fall as tiles grow.
static void fit_tiles(city_plan* plan)
{
    uint64_t* triangles = plan->triangles;
    uint64_t others = 0;
    for (size_t i = 0; i < plan->piece_count; ++i) {
        others += plan->pieces[i].kind != CITY_ROOF ? triangles[i] : 0;
    }
    double low = 0.1, high = 3.0;
    for (int step = 0; step < 40; ++step) {
        double tile = 0.5 * (low + high);
        uint64_t sum = others;
        set_tiles(plan, tile);
        for (size_t i = 0; i < plan->piece_count; ++i) {
            sum += plan->pieces[i].kind == CITY_ROOF ? city_roof_triangles(&plan->pieces[i]) : 0;
        }
        if (sum > plan->unique_triangles_wanted) {
            low = tile;
        } else {
            high = tile;
        }
    }
    set_tiles(plan, high);
    for (size_t i = 0; i < plan->piece_count; ++i) {
        triangles[i] = plan->pieces[i].kind == CITY_ROOF ? city_roof_triangles(&plan->pieces[i])
                                                         : triangles[i];
    }
}

static void show_at_spot(city_plan* plan, const char* name, uint32_t piece, const city_spot* spots,
                         size_t spot_count, uint64_t number, double spread, double size)
{
    random_stream* random = &plan->random;
    const city_spot none = {STP_NONE, 0, 0, 0};
    const city_spot* spot = spot_count > 0 ? &spots[number % spot_count] : &none;
    double round = (double)(spot_count > 0 ? number / spot_count : number);
    double off = spread * (round > 6.0 ? 6.0 : round);
    plan->group = spot->parent;
    double across = random_between(random, -1, 1);
    double along = random_between(random, -1, 1);
    double turns = random_unit(random);
    double grown = random_between(random, 0.85, 1.15);
    city_show(
        plan, name, piece,
        place_turned(spot->x + off * across, spot->y, spot->z + off * along, turns, size * grown));
}

// Adds jars and trees until objects and triangles match: two equations with two unknowns.
static void fill_instances(city_plan* plan)
{
    const uint64_t* triangles = plan->triangles;
    double sum = 0.0,
           tree[2] = {(double)triangles[plan->trees[0]], (double)triangles[plan->trees[1]]};
    for (size_t i = 0; i < plan->item_count; ++i) {
        sum += plan->items[i].piece != STP_NONE ? (double)triangles[plan->items[i].piece] : 0.0;
    }
    double missing = (double)plan->objects_wanted - (double)plan->objects;
    double rest = (double)plan->triangles_wanted - sum, jar = (double)triangles[plan->amphora];
    double mean = 0.5 * (tree[0] + tree[1]), trees = (rest - missing * jar) / (mean - jar);
    trees = trees < 2.0 ? 2.0 : trees > missing - 1.0 ? missing - 1.0 : trees;
    for (uint64_t i = 0; plan->objects < plan->objects_wanted && !plan->failed; ++i) {
        if ((double)i + 0.5 < trees) {
            uint32_t kind = (uint32_t)(i % 2);
            show_at_spot(plan, kind == 0 ? "oak" : "cypress", plan->trees[kind], plan->tree_spots,
                         plan->tree_spot_count, i, 3.5, 0.45);
        } else {
            show_at_spot(plan, "amphora", plan->amphora, plan->jar_spots, plan->jar_spot_count, i,
                         0.45, 1.0);
        }
    }
}

void city_plan_make(city_plan* plan)
{
    block blocks[BLOCKS];
    int built = 0;
    for (int i = 0; i < BLOCKS; ++i) {
        block* b = &blocks[i];
        *b = (block){.column = i % BLOCKS_X, .row = i / BLOCKS_X};
        double x = PITCH_X * (b->column - 4.5), z = PITCH_Z * (b->row - 3.5);
        b->distance = sqrt(x * x + z * z);
    }
    qsort(blocks, BLOCKS, sizeof(*blocks), compare_blocks);
    if (plan->unique_wanted > 15000) {
        plan_ramparts(plan);
    }
    for (int i = 0; i < BLOCKS && !is_full(plan) && !plan->failed; ++i, ++built) {
        bool small = plan->unique_wanted < 1500 && use_of(&blocks[i]) != USE_HOUSES;
        if (!small) { // a small city has no room for a forum
            plan_block(plan, &blocks[i]);
        }
    }
    plan_stalls(plan, blocks, built);
    plan->triangles = STP_NEW_ZEROED(plan->context, uint64_t, plan->piece_count + 1);
    plan->failed = plan->failed || plan->triangles == NULL;
    if (!plan->failed) {
        stp_parallel_for(plan->context, plan->piece_count, 32, count_pieces, plan);
        fit_tiles(plan);
        fill_instances(plan);
    }
}
