// SPDX-License-Identifier: MIT
#include "lod/spt/split_errors.h"

#include "base/splats/splat_codes.h"
#include "lod/spt/sequence.h"

#include <assert.h>

enum {
    GRAIN = 8192,  ///< nodes
    RATIO_MAX = 4, ///< of a node's two errors; the smaller one is raised to it
};

/// Maximum of d x / a: the angle x between two points that are a apart, seen from a distance d.
/// Angles beyond that which changes the error from its lowest to its highest share do not count.
#define DIRECTION_FACTOR 1.12

typedef struct maker {
    const stp_point_tree* tree;
    const stp_node_splat* splats;
    double max_allowed;
    uint32_t* codes;
} maker;

/// A node's two errors in steps of its geometric error (STP_ERROR_STEPS).
typedef struct error_steps {
    uint32_t perpendicular, tangential;
} error_steps;

/// The nearest number of steps, between those of the lowest and the whole share.
static uint32_t round_steps(double steps)
{
    double least = (double)STP_ERROR_SHARE_FIRST, most = (double)STP_ERROR_STEPS;
    return (uint32_t)(fmin(fmax(steps, least), most) + 0.5);
}

static error_steps find_steps(const stp_point_tree* tree, uint32_t node)
{
    double error = (double)tree->errors[node];
    if (!(error > 0.0)) { // leaves: no share of nothing matters
        return (error_steps){STP_ERROR_SHARE_FIRST, STP_ERROR_SHARE_FIRST};
    }
    double steps = (double)STP_ERROR_STEPS / error;
    error_steps found = {round_steps(steps * (double)tree->perpendicular[node]),
                         round_steps(steps * (double)tree->tangential[node])};
    uint32_t larger =
        found.perpendicular > found.tangential ? found.perpendicular : found.tangential;
    uint32_t least = (larger + RATIO_MAX - 1) / RATIO_MAX;
    found.perpendicular = found.perpendicular > least ? found.perpendicular : least;
    found.tangential = found.tangential > least ? found.tangential : least;
    return found;
}

double stp_split_overlap(const stp_point_tree* tree, uint32_t node)
{
    error_steps of = find_steps(tree, node);
    uint32_t larger = of.perpendicular > of.tangential ? of.perpendicular : of.tangential;
    uint32_t smaller = of.perpendicular + of.tangential - larger;
    bool depends = smaller < STP_ERROR_STEPS;
    return depends ? 1.0 + DIRECTION_FACTOR * (double)larger / (double)smaller : 1.0;
}

/// Steps of a child's highest level that hold some of its parent's error, and the whole overlap.
static double widen(uint32_t steps, double error, double highest)
{
    double missing = (double)STP_ERROR_STEPS - (double)steps;
    assert(error <= highest);
    return (double)STP_ERROR_STEPS - (highest > 0.0 ? missing * error / highest : missing);
}

static uint32_t join(error_steps own, double above_perpendicular, double above_tangential,
                     const int8_t* normal)
{
    return stp_error_share_code((double)own.perpendicular) |
           stp_error_share_code((double)own.tangential) << 4 |
           stp_error_share_code(above_perpendicular) << 8 |
           stp_error_share_code(above_tangential) << 12 | (uint32_t)(uint8_t)normal[0] << 16 |
           (uint32_t)(uint8_t)normal[1] << 24;
}

// Makes the codes of the children of some nodes.
static void make_codes(size_t begin, size_t end, uint32_t worker, void* user)
{
    const maker* m = user;
    const stp_point_tree* tree = m->tree;
    (void)worker;
    for (uint32_t parent = (uint32_t)begin; parent < end; ++parent) {
        error_steps above = find_steps(tree, parent);
        double error = (double)tree->errors[parent];
        double allowed = m->max_allowed * stp_split_overlap(tree, parent);
        for (uint32_t c = parent + 1; c < tree->ends[parent]; c = tree->ends[c]) {
            double highest = (double)stp_point_sequence_highest(tree, parent, c, allowed);
            m->codes[c] = join(find_steps(tree, c), widen(above.perpendicular, error, highest),
                               widen(above.tangential, error, highest), m->splats[parent].normal);
        }
    }
}

void stp_split_errors_make(stp_context* context, const stp_point_tree* tree,
                           const stp_node_splat* splats, double max_allowed, uint32_t* codes)
{
    const double whole = (double)STP_ERROR_STEPS; // the root has no parent
    maker m = {.tree = tree, .splats = splats, .max_allowed = max_allowed, .codes = codes};
    assert(tree->count > 0);
    codes[0] = join(find_steps(tree, 0), whole, whole, splats[0].normal);
    stp_parallel_for(context, tree->count, GRAIN, make_codes, &m);
}
