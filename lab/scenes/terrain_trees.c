// SPDX-License-Identifier: MIT
#include "lab/scenes/noise.h"
#include "lab/scenes/scene_random.h"
#include "lab/scenes/terrain.h"
#include "lab/scenes/trees.h"

#include <assert.h>
#include <stdlib.h>

enum {
    FOREST_TILES = 130
}; // half of all tiles have none (Table 1: tile LODs have 93k surfels on average)

typedef struct tile_weight {
    double weight;
    uint32_t tile;
} tile_weight;

static double center_of(uint32_t index, uint32_t count)
{
    return TILE_SIZE * ((double)index + 0.5 - 0.5 * (double)count);
}

static int compare_weights(const void* left, const void* right)
{
    const tile_weight *a = left, *b = right;
    if (a->weight > b->weight || a->weight < b->weight) {
        return a->weight > b->weight ? -1 : 1;
    }
    return a->tile < b->tile ? -1 : a->tile > b->tile;
}

static int compare_trees(const void* left, const void* right)
{
    const terrain_tree *a = left, *b = right;
    if (a->tile != b->tile) {
        return a->tile < b->tile ? -1 : 1;
    }
    if (a->kind != b->kind) {
        return a->kind < b->kind ? -1 : 1;
    }
    if (a->x < b->x || a->x > b->x) {
        return a->x < b->x ? -1 : 1;
    }
    return a->z < b->z ? -1 : a->z > b->z;
}

// Weights of all tiles, densest forest first; -1 on sites.
static void weigh_tiles(uint64_t seed, tile_weight weights[TILE_COUNT])
{
    for (uint32_t i = 0; i < TILE_COUNT; ++i) {
        double x = center_of(i % TILE_COLUMNS, TILE_COLUMNS);
        double z = center_of(i / TILE_COLUMNS, TILE_ROWS);
        double wood = 0.5 + 0.5 * noise2_octaves(seed + 50, x / 1100.0, z / 1100.0, 3);
        bool built = terrain_site_distance(x, z) < 0.6 * TILE_SIZE;
        weights[i] = (tile_weight){built ? -1.0 : wood, i};
    }
    qsort(weights, TILE_COUNT, sizeof(*weights), compare_weights);
}

// Tree kind at a place: kinds form groves and mix at their borders.
static uint32_t choose_kind(uint64_t seed, random_stream* random, double x, double z)
{
    uint32_t best = 0;
    double most = -1e9;
    for (uint32_t k = 0; k < TREE_KINDS; ++k) {
        double likes = noise2(seed + 60 + k, x / 300.0, z / 300.0) + 1.1 * random_unit(random);
        if (likes > most) {
            most = likes;
            best = k;
        }
    }
    return best;
}

// A place on the tile where a tree can stand; if none of 24 candidates is good, the last.
static void choose_place(const terrain_map* map, random_stream* random, uint32_t tile, double* x,
                         double* z)
{
    for (int attempt = 0; attempt < 24; ++attempt) {
        *x = center_of(tile % TILE_COLUMNS, TILE_COLUMNS) + TILE_SIZE * (random_unit(random) - 0.5);
        *z = center_of(tile / TILE_COLUMNS, TILE_ROWS) + TILE_SIZE * (random_unit(random) - 0.5);
        if (terrain_site_distance(*x, *z) > 25.0 && terrain_road_distance(map, *x, *z) > 13.0) {
            return;
        }
    }
}

// Equalises the kinds: surplus trees of one kind become trees of others.
static void balance_kinds(terrain_tree* trees, uint32_t count)
{
    uint32_t counts[TREE_KINDS] = {0}, wanted[TREE_KINDS];
    for (uint32_t i = 0; i < count; ++i) {
        counts[trees[i].kind] += 1;
    }
    for (uint32_t k = 0; k < TREE_KINDS; ++k) {
        wanted[k] = count / TREE_KINDS + (k < count % TREE_KINDS ? 1 : 0);
    }
    uint32_t lacking = 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t kind = trees[i].kind;
        while (lacking < TREE_KINDS && counts[lacking] >= wanted[lacking]) {
            lacking += 1;
        }
        if (lacking < TREE_KINDS && counts[kind] > wanted[kind]) {
            counts[kind] -= 1;
            counts[lacking] += 1;
            trees[i].kind = lacking;
        }
    }
}

terrain_tree* terrain_plant_trees(stp_context* context, const terrain_map* map, uint32_t count)
{
    terrain_tree* trees = STP_NEW_ARRAY(context, terrain_tree, (size_t)count + 1);
    if (trees == NULL) {
        return NULL;
    }
    tile_weight weights[TILE_COUNT];
    weigh_tiles(map->seed, weights);
    double sum = 0.0;
    for (int i = 0; i < FOREST_TILES; ++i) {
        weights[i].weight = weights[i].weight * weights[i].weight;
        sum += weights[i].weight;
    }
    random_stream root = random_begin(map->seed + 77);
    uint32_t made = 0;
    double due = 0.0;
    for (int i = 0; i < FOREST_TILES; ++i) {
        due += weights[i].weight / sum * (double)count;
        uint32_t until = i + 1 == FOREST_TILES ? count : (uint32_t)due;
        for (; made < until && made < count; ++made) {
            random_stream random = random_fork(&root, made);
            terrain_tree* tree = &trees[made];
            tree->tile = weights[i].tile;
            choose_place(map, &random, tree->tile, &tree->x, &tree->z);
            tree->kind = choose_kind(map->seed, &random, tree->x, tree->z);
        }
    }
    assert(made == count && "every tree has a place");
    balance_kinds(trees, count);
    qsort(trees, count, sizeof(*trees), compare_trees);
    return trees;
}
