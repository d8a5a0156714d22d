// SPDX-License-Identifier: MIT
#include "lab/measure/hausdorff.h"

#include <assert.h>

enum {
    GRAIN = 64,
    BLOCK = 1 << 14, ///< triangles or parts measured at a time
    SPLIT = 256,     ///< cells subdivided at a time
};

#define TOLERANCE 1e-3 ///< accepted gap between maximum and bound, relative to the maximum
#define SMALLEST 1e-6  ///< added to it, relative to the largest coordinate: the maximum may be 0

/// A part of a triangle.
typedef struct cell {
    stp_vec3d corners[3];
    stp_vec3d middle;
    double distance; ///< distance of the centre
    double maximum;  ///< upper bound over the cell
} cell;

typedef struct prover {
    stp_context* context;
    const stp_measured_surface* surface;
    const stp_shape_tree* tree;
    stp_hausdorff* found;
    double smallest;
    cell* stack; ///< cells to be subdivided
    size_t count, capacity;
    cell* block;         ///< cells to be measured: BLOCK
    const cell* parents; ///< the block consists of their parts; NULL: of triangles
    size_t first;        ///< first triangle of the block
    uint64_t places;     ///< remaining number of measurements
    double left_out;     ///< largest bound of cells that were not subdivided further
} prover;

static void measure_cell(const prover* p, cell* c, uint32_t* hint)
{
    stp_vec3d sum = stp_addd(stp_addd(c->corners[0], c->corners[1]), c->corners[2]);
    c->middle = stp_scaled(sum, 1.0 / 3.0);
    c->distance = sqrt(stp_shape_tree_distance_squared(p->tree, c->middle, hint));
    assert(*hint < p->tree->count && "the nearest shape");
    double reach = 0.0, farthest = 0.0;
    for (int k = 0; k < 3; ++k) {
        reach = fmax(reach, stp_lengthd(stp_subd(c->corners[k], c->middle)));
        farthest =
            fmax(farthest, stp_shape_tree_distance_squared_to(p->tree, *hint, c->corners[k]));
    }
    c->maximum = fmin(c->distance + reach, sqrt(farthest));
}

// The fourth part is the central one.
static void make_part(const cell* whole, size_t part, cell* c)
{
    const stp_vec3d* w = whole->corners;
    for (size_t k = 0; k < 3; ++k) {
        size_t other = part < 3 ? part : (k + 1) % 3;
        c->corners[k] = stp_scaled(stp_addd(w[k], w[other]), 0.5);
    }
}

static void measure_block(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    prover* p = user;
    uint32_t hint = UINT32_MAX;
    for (size_t i = begin; i < end; ++i) {
        cell* c = &p->block[i];
        if (p->parents == NULL) {
            stp_triangle_corners(p->surface->positions, p->surface->indices, p->first + i,
                                 c->corners);
        } else {
            make_part(&p->parents[i / 4], i % 4, c);
        }
        measure_cell(p, c, &hint);
    }
}

static double limit_of(const prover* p)
{
    return p->found->max * (1.0 + TOLERANCE) + p->smallest;
}

// Measures the block and pushes the cells that may contain a larger distance.
static stp_result measure_cells(prover* p, size_t count)
{
    assert(count <= BLOCK);
    stp_parallel_for(p->context, count, GRAIN, measure_block, p);
    for (size_t i = 0; i < count; ++i) {
        const cell* c = &p->block[i];
        if (c->distance > p->found->max) {
            p->found->max = c->distance;
            p->found->farthest = c->middle;
        }
    }
    if (p->count + count > p->capacity) {
        if (!STP_MAKE_ROOM(p->context, p->stack, p->capacity, p->count + count)) {
            return stp_fail_memory(p->context);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        if (p->block[i].maximum > limit_of(p)) {
            p->stack[p->count++] = p->block[i];
        }
    }
    return STP_OK;
}

// Subdivides cells until the stack is empty. Depth first, so the stack stays short.
static stp_result split_cells(prover* p)
{
    cell parents[SPLIT];
    stp_result result = STP_OK;
    while (p->count > 0 && result == STP_OK) {
        size_t taken = 0;
        while (p->count > 0 && taken < SPLIT) {
            const cell* c = &p->stack[--p->count];
            if (c->maximum > limit_of(p) && p->places >= 4) {
                parents[taken++] = *c;
                p->places -= 4;
            } else if (c->maximum > limit_of(p)) {
                p->left_out = fmax(p->left_out, c->maximum);
            }
        }
        p->parents = parents;
        result = measure_cells(p, 4 * taken);
    }
    return result;
}

static stp_result prove(prover* p)
{
    stp_result result = STP_OK;
    size_t total = p->surface->triangle_count;
    for (size_t first = 0; first < total && result == STP_OK; first += BLOCK) {
        result = stp_progress(p->context, "distances", 1.0);
        p->parents = NULL;
        p->first = first;
        size_t count = total - first < BLOCK ? total - first : BLOCK;
        result = result == STP_OK ? measure_cells(p, count) : result;
        result = result == STP_OK ? split_cells(p) : result;
    }
    p->found->bound = fmax(limit_of(p), p->left_out);
    assert(p->found->bound >= p->found->max);
    return result;
}

static double largest_coordinate(const stp_measured_surface* surface)
{
    double largest = 0.0;
    for (size_t i = 0; i < 3 * surface->vertex_count; ++i) {
        largest = fmax(largest, fabs((double)surface->positions[i]));
    }
    return largest;
}

stp_result stp_hausdorff_prove(stp_context* context, const stp_measured_surface* surface,
                               const stp_shape_tree* tree, uint64_t places,
                               stp_hausdorff* hausdorff)
{
    hausdorff->bound = hausdorff->max;
    if (surface->triangle_count == 0) {
        return STP_OK;
    }
    prover p = {.context = context,
                .surface = surface,
                .tree = tree,
                .found = hausdorff,
                .places = places,
                .smallest = SMALLEST * largest_coordinate(surface),
                .block = STP_NEW_ARRAY(context, cell, BLOCK)};
    stp_result result = p.block != NULL ? prove(&p) : stp_fail_memory(context);
    stp_free(context, p.stack);
    stp_free(context, p.block);
    return result;
}
