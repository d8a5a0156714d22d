// SPDX-License-Identifier: MIT
// When it pays to open a node, whose content has levels of triangles, instead of drawing its own
// splats: a property of the node, found once.
//
// For an allowed error, a node can be drawn by a prefix of its splats, or by its parts and children.
// The work of the cheaper of both is kept for errors from the node's size down, in powers of two:
// once where small splats are wanted, and once where large ones are, which have many fragments.
#include "base/splats/prefix_table.h"
#include "select/select_internal.h"

#include <assert.h>

enum { ERRORS = STP_LEVEL_ERRORS, SIZES = 2 };

#define NODE_WORK 32.0  // of visiting a node and preparing its items, in triangles
#define LEVEL_WORK 0.75 // of a triangle of a level: many face away
#define PREFERENCE 2.0  // levels look better than splats of the same size, and may take more work
// of a splat of STP_OPENS_COARSE pixels (docs/notes/2026-11-level-errors.md)
#define COARSE_WORK 18.0

typedef struct finder {
    const stp_selection* s;
    const stp_select_graph* graph;
    float* works;              ///< SIZES x ERRORS per node
    double* sizes;             ///< per node: the error of its first entry
    double radii[SIZES];       ///< radius of a splat that goes with an error of 1
    double splat_works[SIZES]; ///< of such a splat, in triangles
} finder;

/// Work of a node for each error and size.
typedef struct works {
    double at[SIZES][ERRORS];
} works;

static const float* works_of(const finder* f, uint32_t node, int size)
{
    return f->works + ERRORS * (SIZES * (size_t)node + (size_t)size);
}

/// Adds the works of a child. @param scale  from its units to the node's
static void add_child(const finder* f, uint32_t child, double scale, double node_size, works* sum)
{
    double size = f->sizes[child] * scale;
    // entry 0 of the sum is for this entry of the child's
    double first = size > 0.0 && node_size > 0.0 ? log2(size / node_size) : HUGE_VAL;
    for (int k = 0; k < ERRORS; ++k) {
        double at = stp_clampd(first + (double)k, 0.0, (double)(ERRORS - 1));
        int below = (int)at, above = below + 1 < ERRORS ? below + 1 : below;
        double part = at - (double)below;
        for (int size_class = 0; size_class < SIZES; ++size_class) {
            const float* of = works_of(f, child, size_class);
            sum->at[size_class][k] += (1.0 - part) * (double)of[below] + part * (double)of[above];
        }
    }
}

/// Work of a node that is opened.
static works find_open(const finder* f, uint32_t index)
{
    const stp_store_directory* d = f->s->directory;
    const stp_store_node* node = &d->nodes[index];
    works open = {0};
    double own = NODE_WORK;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = d->parts[node->first_part + i];
        own += part.kind != STP_STORE_PART_MESH
                   ? STP_SPLAT_WORK *
                         (double)stp_store_describe_point_set(f->s->store, part.index)->point_count
                   : (double)stp_store_describe_mesh(f->s->store, part.index)->triangle_count;
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[node->first_edge + i];
        if ((f->graph->moving[edge->node] & STP_NODE_MOVES) == 0) {
            add_child(f, edge->node, stp_affine_scale(&edge->transform), f->sizes[index], &open);
        }
    }
    const float* counts = f->graph->level_counts;
    bool has_levels = f->graph->level_rows[index] != STP_STORE_NONE;
    if (has_levels) {
        counts += ERRORS * (size_t)f->graph->level_rows[index];
    }
    double error = f->sizes[index];
    for (int k = 0; k < ERRORS; ++k, error *= 0.5) {
        // levels stand for all below; what they do not replace is little
        bool levels = has_levels && error >= (double)f->graph->level_floors[index];
        for (int size = 0; size < SIZES; ++size) {
            open.at[size][k] =
                levels ? NODE_WORK + LEVEL_WORK * (double)counts[k] : open.at[size][k] + own;
        }
    }
    return open;
}

/// Work of the prefix of a node's set that suffices for an error; infinite if none does.
static double find_splats(const finder* f, uint32_t index, double error, int size)
{
    uint32_t set = stp_select_set_of(f->s, index);
    const stp_splats* splats =
        set != STP_STORE_NONE ? stp_store_describe_splat_set(f->s->store, set) : NULL;
    double radius = f->radii[size] * error;
    if (splats == NULL || splats->count == 0 || radius < f->graph->reaches[index]) {
        return HUGE_VAL;
    }
    return NODE_WORK +
           f->splat_works[size] *
               (double)stp_prefix_table_count(&splats->table, (float)fmin(radius, (double)FLT_MAX));
}

/// Fills the works of a node. @param opens  receives for each size the largest radius below which
/// opening always takes less than PREFERENCE times the work of splats
static void find_node(const finder* f, uint32_t index, float opens[SIZES])
{
    works open = find_open(f, index);
    for (int size = 0; size < SIZES; ++size) {
        double error = f->sizes[index], below = 0.0;
        float* kept = f->works + ERRORS * (SIZES * (size_t)index + (size_t)size);
        for (int k = 0; k < ERRORS; ++k, error *= 0.5) {
            double opened = open.at[size][k], splats = find_splats(f, index, error, size);
            kept[k] = (float)fmin(fmin(opened, splats), (double)FLT_MAX);
            if (splats < HUGE_VAL) {
                below = opened < PREFERENCE * splats ? fmax(below, error) : 0.0;
            }
        }
        opens[size] = (float)(f->radii[size] * below);
    }
}

/// Radius in pixels of a splat of a size that goes with a level's error of one pixel.
static double radius_of_error(double splat_size)
{
    return 0.5 * splat_size / stp_select_level_error(splat_size);
}

stp_result stp_select_find_level_works(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* d = s->directory;
    uint32_t count = d->level_count > 0 ? d->node_count : 0;
    finder f = {.s = s,
                .graph = graph,
                .works = STP_NEW_ARRAY(s->context, float, ERRORS* SIZES*(size_t)count + 1),
                .sizes = STP_NEW_ARRAY(s->context, double, (size_t)count + 1),
                .radii = {radius_of_error(STP_OPENS_FINE), radius_of_error(STP_OPENS_COARSE)},
                .splat_works = {STP_SPLAT_WORK, COARSE_WORK}};
    bool good = f.works != NULL && f.sizes != NULL;
    for (uint32_t i = 0; i < d->node_count; ++i) {
        graph->opens_below[2 * (size_t)i] = graph->opens_below[2 * (size_t)i + 1] = 0.0f;
    }
    for (uint32_t i = 0; good && i < count; ++i) {
        f.sizes[i] = stp_select_node_diagonal(&d->nodes[i]);
        find_node(&f, i, graph->opens_below + 2 * (size_t)i);
    }
    stp_free(s->context, f.works);
    stp_free(s->context, f.sizes);
    return good ? STP_OK : stp_fail_memory(s->context);
}
