// SPDX-License-Identifier: MIT
#include "order/tree.h"

#include "base/core/processor.h"

#include <assert.h>

const stp_tree_kernels* stp_tree_kernels_select(void)
{
    return STP_VARIANT(stp_processor_detect(), &stp_tree_kernels);
}

void stp_tree_resize(stp_tree* tree, uint32_t point_count)
{
    assert(point_count > 0);
    tree->point_count = point_count;
    tree->leaf_count = (point_count - 1) / STP_LEAF_SIZE + 1;
    tree->level_count = 0;
    uint32_t size = tree->leaf_count;
    do {
        assert(tree->level_count < STP_TREE_LEVELS);
        size = (size - 1) / STP_BRANCH_SIZE + 1;
        tree->level_sizes[tree->level_count++] = size;
    } while (size > 1);
}

stp_result stp_tree_create(stp_context* context, stp_tree* tree, uint32_t point_count, bool normals,
                           bool lazy)
{
    *tree = (stp_tree){0};
    stp_tree_resize(tree, point_count);
    bool complete = true;
    tree->leaves = STP_NEW_ARRAY(context, stp_leaf, tree->leaf_count);
    complete = complete && tree->leaves != NULL;
    if (normals) {
        tree->normals = STP_NEW_ARRAY(context, stp_leaf_normals, tree->leaf_count);
        complete = complete && tree->normals != NULL;
    }
    if (lazy) {
        tree->pending = STP_NEW_ZEROED(context, stp_pending, tree->leaf_count);
        complete = complete && tree->pending != NULL;
    }
    if (lazy && normals) {
        tree->facing = STP_NEW_ARRAY(context, stp_facing, tree->level_sizes[0]);
        complete = complete && tree->facing != NULL;
    }
    for (uint32_t level = 0; level < tree->level_count; ++level) {
        tree->levels[level] = STP_NEW_ARRAY(context, stp_branch, tree->level_sizes[level]);
        complete = complete && tree->levels[level] != NULL;
    }
    if (!complete) {
        stp_tree_destroy(context, tree);
        return stp_fail_memory(context);
    }
    return STP_OK;
}

void stp_tree_destroy(stp_context* context, stp_tree* tree)
{
    stp_free(context, tree->leaves);
    stp_free(context, tree->normals);
    stp_free(context, tree->facing);
    stp_free(context, tree->pending);
    for (uint32_t level = 0; level < STP_TREE_LEVELS; ++level) {
        stp_free(context, tree->levels[level]);
    }
    *tree = (stp_tree){0};
}

typedef struct fit_job {
    stp_tree* tree;
    const stp_tree_kernels* kernels;
    uint32_t level;
} fit_job;

static void run_fit(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const fit_job* job = user;
    job->kernels->fit(job->tree, job->level, begin, end);
}

// Lanes past the end copy the position and normal of the last point, so that boxes stay tight.
// Their gap is -1, so that they are never chosen.
static void fill_last_leaf(stp_tree* tree)
{
    assert(tree->point_count > 0 && tree->level_sizes[tree->level_count - 1] == 1);
    uint32_t last = (tree->point_count - 1) % STP_LEAF_SIZE, index = tree->leaf_count - 1;
    stp_leaf* leaf = &tree->leaves[index];
    for (uint32_t i = last + 1; i < STP_LEAF_SIZE; ++i) {
        leaf->x[i] = leaf->x[last];
        leaf->y[i] = leaf->y[last];
        leaf->z[i] = leaf->z[last];
        leaf->gap[i] = -1.0f;
        if (tree->normals != NULL) {
            stp_leaf_normals* normals = &tree->normals[index];
            normals->x[i] = normals->x[last];
            normals->y[i] = normals->y[last];
            normals->z[i] = normals->z[last];
        }
    }
}

void stp_tree_fit(stp_tree* tree, const stp_tree_kernels* kernels, const stp_team* team)
{
    enum { GRAIN = 256 };
    fill_last_leaf(tree);
    for (uint32_t level = 0; level < tree->level_count; ++level) {
        fit_job job = {tree, kernels, level};
        uint32_t size = tree->level_sizes[level];
        stp_team_run(team, size, GRAIN, run_fit, &job);
    }
}

float stp_tree_gap(const stp_tree* tree)
{
    const stp_branch* top = &tree->levels[tree->level_count - 1][0];
    float gap = top->gap[0];
    for (int i = 1; i < STP_BRANCH_SIZE; ++i) {
        gap = gap > top->gap[i] ? gap : top->gap[i];
    }
    return gap;
}

size_t stp_tree_push_scratch(const stp_tree* tree, uint32_t count)
{
    return (size_t)STP_BRANCH_SIZE * count * tree->level_count;
}
