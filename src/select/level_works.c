// SPDX-License-Identifier: MIT
// When it pays to open a node, whose content has levels of triangles, instead of drawing its own
// splats: a property of the node, found once.
//
// For an allowed error, a node can be drawn by a prefix of its splats, or by its parts and children.
// The work of the cheaper of both is kept for errors from the node's size down, in powers of two.
#include "base/splats/prefix_table.h"
#include "select/select_internal.h"

#include <assert.h>

enum { ERRORS = 24 };

#define NODE_WORK 32.0  // of visiting a node and preparing its items, in triangles
#define LEVEL_WORK 0.75 // of a triangle of a level: many face away
#define PREFERENCE 2.0  // levels look better than splats of the same size, and may take more work
#define RADIUS_SHARE (0.5 / STP_LEVEL_ERROR) // radius of a splat that goes with an error of 1

typedef struct finder {
    const stp_selection* s;
    const stp_select_graph* graph;
    float* works;  ///< ERRORS per node
    double* sizes; ///< per node: the error of its first entry
} finder;

/// Work of a node where errors up to `error` (node units) are allowed.
static double work_at(const finder* f, uint32_t node, double error)
{
    const float* works = f->works + ERRORS * (size_t)node;
    double size = f->sizes[node];
    if (!(size > 0.0) || !(error > 0.0)) {
        return (double)works[ERRORS - 1];
    }
    double at = log2(size / error);
    if (!(at > 0.0)) {
        return (double)works[0];
    }
    if (at >= ERRORS - 1) {
        return (double)works[ERRORS - 1];
    }
    int below = (int)at;
    double part = at - below;
    return (1.0 - part) * (double)works[below] + part * (double)works[below + 1];
}

/// Triangles of a node's levels that are drawn where one error is allowed.
static double count_drawn(const stp_store_directory* d, const stp_selection* s, uint32_t node,
                          double error)
{
    double count = 0.0;
    for (uint32_t i = d->level_starts[node]; i < d->level_starts[node + 1]; ++i) {
        const stp_store_level* level = &d->levels[i];
        if ((double)level->most <= error || (double)level->least > error) {
            continue;
        }
        uint32_t clusters = 0;
        for (uint32_t k = 0; k < level->cluster_count; ++k) {
            const stp_store_level_cluster* c = &d->level_clusters[level->first_cluster + k];
            bool made =
                c->made_by == STP_STORE_NONE || (double)d->level_groups[c->made_by].error <= error;
            bool used =
                c->used_by != STP_STORE_NONE && (double)d->level_groups[c->used_by].error <= error;
            clusters += made && !used ? 1 : 0;
        }
        double each = (double)stp_store_describe_mesh(s->store, level->mesh)->triangle_count /
                      (double)level->cluster_count;
        count += each * clusters;
    }
    return count;
}

/// Work of a node that is opened.
static double find_open(const finder* f, uint32_t index, double error)
{
    const stp_store_directory* d = f->s->directory;
    const stp_store_node* node = &d->nodes[index];
    bool levels = d->level_starts[index] < d->level_starts[index + 1] &&
                  error >= (double)f->graph->level_floors[index];
    double work = NODE_WORK;
    if (levels) { // they stand for all below; what they do not replace is little
        return work + LEVEL_WORK * count_drawn(d, f->s, index, error);
    }
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = d->parts[node->first_part + i];
        if (part.kind != STP_STORE_PART_MESH) {
            work += STP_SPLAT_WORK *
                    (double)stp_store_describe_point_set(f->s->store, part.index)->point_count;
        } else {
            work += (double)stp_store_describe_mesh(f->s->store, part.index)->triangle_count;
        }
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[node->first_edge + i];
        double scale = stp_affine_scale(&edge->transform);
        if ((f->graph->moving[edge->node] & STP_NODE_MOVES) == 0) {
            work += work_at(f, edge->node, scale > 0.0 ? error / scale : HUGE_VAL);
        }
    }
    return work;
}

/// Work of the prefix of a node's set that suffices for an error; infinite if none does.
static double find_splats(const finder* f, uint32_t index, double error)
{
    uint32_t set = stp_select_set_of(f->s, index);
    const stp_splats* splats =
        set != STP_STORE_NONE ? stp_store_describe_splat_set(f->s->store, set) : NULL;
    double radius = RADIUS_SHARE * error;
    if (splats == NULL || splats->count == 0 || radius < f->graph->reaches[index]) {
        return HUGE_VAL;
    }
    return NODE_WORK + STP_SPLAT_WORK * (double)stp_prefix_table_count(
                                            &splats->table, (float)fmin(radius, (double)FLT_MAX));
}

/// Fills the works of a node. @return the largest error below which opening always takes less than
/// PREFERENCE times the work of splats
static double find_node(const finder* f, uint32_t index)
{
    double error = f->sizes[index], opens = 0.0;
    for (int k = 0; k < ERRORS; ++k, error *= 0.5) {
        double open = find_open(f, index, error), splats = find_splats(f, index, error);
        f->works[ERRORS * (size_t)index + (size_t)k] =
            (float)fmin(fmin(open, splats), (double)FLT_MAX);
        if (splats < HUGE_VAL) {
            opens = open < PREFERENCE * splats ? fmax(opens, error) : 0.0;
        }
    }
    return opens;
}

stp_result stp_select_find_level_works(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* d = s->directory;
    uint32_t count = d->level_count > 0 ? d->node_count : 0;
    finder f = {.s = s,
                .graph = graph,
                .works = STP_NEW_ARRAY(s->context, float, ERRORS*(size_t)count + 1),
                .sizes = STP_NEW_ARRAY(s->context, double, (size_t)count + 1)};
    bool good = f.works != NULL && f.sizes != NULL;
    for (uint32_t i = 0; i < d->node_count; ++i) {
        graph->opens_below[i] = 0.0f;
    }
    for (uint32_t i = 0; good && i < count; ++i) {
        const stp_boxd* box = &d->nodes[i].bounds;
        f.sizes[i] = stp_boxd_is_empty(*box) ? 0.0 : stp_lengthd(stp_subd(box->max, box->min));
        graph->opens_below[i] = (float)(RADIUS_SHARE * find_node(&f, i));
    }
    stp_free(s->context, f.works);
    stp_free(s->context, f.sizes);
    return good ? STP_OK : stp_fail_memory(s->context);
}
