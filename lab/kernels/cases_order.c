// SPDX-License-Identifier: MIT
// Orders: places on a curve, the tree of gaps, and the grid of chosen points.
#include "lab/kernels/kernel_cases.h"
#include "order/curve.h"
#include "order/near_grid.h"
#include "order/tree.h"

#include <float.h>

enum { POINTS = 1 << 15, INSERTIONS = 256, CHOSEN = 1 << 14, QUERIES = 1 << 11 };

static const stp_curve curve = {.scale = 1.0f, .quanta = (float)((1 << STP_CURVE_BITS) - 1)};

bool kernel_make_cells(kernel_case* c)
{
    c->input = kernel_random_floats(c, 1, 3 * POINTS, 0.0f, 1.0f);
    return c->input != NULL && kernel_set_output(c, POINTS * sizeof(uint16_t), POINTS);
}

void kernel_run_cells(kernel_case* c)
{
    stp_curve_kernels_select()->cells(&curve, c->input, POINTS, c->output);
}

bool kernel_make_places(kernel_case* c)
{
    stp_record* records = STP_ARENA_ARRAY(c->arena, stp_record, POINTS);
    for (uint32_t i = 0; records != NULL && i < POINTS; ++i) {
        records[i] = (stp_record){kernel_random(2, 3 * i, 0.0f, 1.0f),
                                  kernel_random(2, 3 * i + 1, 0.0f, 1.0f),
                                  kernel_random(2, 3 * i + 2, 0.0f, 1.0f), i};
    }
    c->input = records;
    return records != NULL && kernel_set_output(c, POINTS * sizeof(uint64_t), POINTS);
}

void kernel_run_places(kernel_case* c)
{
    stp_curve_kernels_select()->places(&curve, c->input, POINTS, c->output);
}

/// Leaves are runs of points along z.
static stp_tree* make_tree(kernel_case* c)
{
    stp_tree* tree = stp_arena_alloc(c->arena, sizeof(*tree));
    if (tree == NULL || stp_tree_create(c->arena->context, tree, POINTS, false, false) != STP_OK) {
        return NULL;
    }
    c->input = tree;
    for (uint32_t i = 0; i < POINTS; ++i) {
        stp_leaf* leaf = &tree->leaves[i / STP_LEAF_SIZE];
        leaf->x[i % STP_LEAF_SIZE] = kernel_random(3, i, 0.0f, 0.1f);
        leaf->y[i % STP_LEAF_SIZE] = kernel_random(4, i, 0.0f, 0.1f);
        leaf->z[i % STP_LEAF_SIZE] = (float)i / (float)POINTS;
        leaf->gap[i % STP_LEAF_SIZE] = FLT_MAX;
    }
    return tree;
}

bool kernel_make_fit(kernel_case* c)
{
    const stp_tree* tree = make_tree(c);
    if (tree != NULL) {
        c->output = tree->levels[0];
        c->output_bytes = tree->level_sizes[0] * sizeof(*tree->levels[0]);
        c->elements = POINTS;
    }
    return tree != NULL;
}

void kernel_run_fit(kernel_case* c)
{
    const stp_team team = stp_team_create(c->arena->context, 1);
    stp_tree_fit(c->input, stp_tree_kernels_select(), &team);
}

bool kernel_make_insert(kernel_case* c)
{
    const stp_tree* tree = make_tree(c);
    if (tree != NULL) {
        c->output = tree->leaves;
        c->output_bytes = tree->leaf_count * sizeof(*tree->leaves);
        c->elements = INSERTIONS;
    }
    return tree != NULL;
}

/// Nothing is chosen.
void kernel_reset_insert(kernel_case* c)
{
    stp_leaf* leaves = c->output;
    for (uint32_t i = 0; i < POINTS; ++i) {
        leaves[i / STP_LEAF_SIZE].gap[i % STP_LEAF_SIZE] = FLT_MAX;
    }
    kernel_run_fit(c);
}

/// Inserts the farthest point again and again.
void kernel_run_insert(kernel_case* c)
{
    stp_tree* tree = c->input;
    const stp_tree_kernels* kernels_here = stp_tree_kernels_select();
    uint32_t position = 0;
    for (int i = 0; i < INSERTIONS; ++i) {
        const stp_leaf* leaf = &tree->leaves[position / STP_LEAF_SIZE];
        uint32_t lane = position % STP_LEAF_SIZE;
        const stp_chosen chosen = {.x = leaf->x[lane], .y = leaf->y[lane], .z = leaf->z[lane]};
        kernels_here->insert(tree, &chosen, 0.0f);
        position = kernels_here->farthest(tree);
    }
}

void kernel_destroy_tree(kernel_case* c)
{
    if (c->input != NULL) {
        stp_tree_destroy(c->arena->context, c->input);
    }
}

typedef struct near_grid_input {
    stp_near_grid grid;
    float queries[3 * QUERIES];
} near_grid_input;

bool kernel_make_near_grid(kernel_case* c)
{
    near_grid_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL ||
        stp_near_grid_create(c->arena->context, &in->grid, (float[3]){0, 0, 0}, 1.0f) != STP_OK) {
        return false;
    }
    c->input = in;
    for (uint32_t i = 0; i < CHOSEN; ++i) {
        if (stp_near_grid_add(&in->grid, kernel_random(5, 3 * i, 0.0f, 1.0f),
                              kernel_random(5, 3 * i + 1, 0.0f, 1.0f),
                              kernel_random(5, 3 * i + 2, 0.0f, 0.1f)) != STP_OK) {
            return false;
        }
    }
    for (uint32_t i = 0; i < 3 * QUERIES; ++i) {
        in->queries[i] = kernel_random(6, i, 0.0f, i % 3 == 2 ? 0.1f : 1.0f);
    }
    return kernel_set_output(c, QUERIES * sizeof(float), QUERIES);
}

void kernel_run_near_grid(kernel_case* c)
{
    const near_grid_input* in = c->input;
    stp_near_grid_nearest_select()(&in->grid, in->queries, QUERIES, c->output);
}

void kernel_destroy_near_grid(kernel_case* c)
{
    near_grid_input* in = c->input;
    if (in != NULL) {
        stp_near_grid_destroy(&in->grid);
    }
}
