// SPDX-License-Identifier: MIT
//
// Levels of the triangles of a mesh that can be mixed without cracks: a directed acyclic graph of
// clusters and groups, as in Ponchio and Cignoni, "Multiresolution and fast decompression for
// optimal web-based rendering" (2016), and Karis, "Nanite" (2021).
//
//   level 0   clusters of the originals        a a a a | b b b b        groups of neighbours
//   level 1   each group, with fewer triangles  c c    |  c c d d ...   and grouped anew
//
// A group is simplified as a whole. Only vertices that it shares with other groups are locked, and
// these lie elsewhere at the next level, so no edge stays fine for ever. A view draws a cluster if
// the error of the group that made it suffices, and that of the group it is used by does not. Since
// all clusters of a group switch together and its border stays, every mixture is as closed as the
// original.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

enum {
    STP_LEVEL_CLUSTER = 128, ///< most triangles of a cluster
    STP_LEVEL_GROUP = 16,    ///< most clusters of a group
};

#define STP_LEVEL_NONE UINT32_MAX

typedef struct stp_level_cluster {
    uint32_t first_triangle, triangle_count;
    uint32_t made_by; ///< group of which it is a part, simplified; STP_LEVEL_NONE: originals
    uint32_t used_by; ///< group that replaces it by fewer triangles; STP_LEVEL_NONE: the coarsest
} stp_level_cluster;

/// Clusters of a level that are simplified together.
typedef struct stp_level_group {
    /// Error of the clusters it made, in units of the positions; above those of the clusters that
    /// it replaces. The sum of the next two
    double error;
    double moved;     ///< how far surfaces were moved
    double look;      ///< the change of colours and normals
    stp_vec3d center; ///< of a sphere around all originals that it stands for, which contains the
    double radius;    ///< spheres of the groups that made its clusters
    uint32_t level;   ///< from 1
} stp_level_group;

typedef struct stp_level_graph {
    uint32_t vertex_count, triangle_count, cluster_count, group_count;
    float* positions;  ///< 3 per vertex: those of the source, then new ones
    uint32_t* indices; ///< 3 per triangle
    uint32_t* tags;    ///< one per triangle: that of an original at its place
    /// One per triangle: the sides that can be seen from outside (STP_SEEN_*); both, unless
    /// `from_outside`
    uint8_t* sides;
    float* colors;  ///< NULL, or 9 per triangle: red, green, blue of each corner, linear
    float* spreads; ///< 2 per triangle, as in stp_group_mesh
    stp_level_cluster* clusters;
    stp_level_group* groups; ///< by level
    /// Triangles that cannot be seen from outside are left out where errors of `outside_error` and
    /// more are allowed. They are still in `clusters`, with sides 0.
    bool from_outside;
    double outside_error;
    size_t vertex_capacity, triangle_capacity, tag_capacity, side_capacity, color_capacity,
        spread_capacity, cluster_capacity, group_capacity;
} stp_level_graph;

/// The triangles that levels are made of. The caller owns all arrays.
typedef struct stp_level_source {
    uint32_t vertex_count, triangle_count;
    const float* positions;  ///< 3 per vertex, welded by position: triangles that touch share them
    const uint32_t* indices; ///< 3 per triangle, distinct
    /// NULL: the numbers of the triangles. Else borders between tags are kept, and their colours do
    /// not mix
    const uint32_t* tags;
    const uint8_t* front_only; ///< NULL, or per tag: not 0 if backs of its triangles are not drawn
    const uint8_t* locked; ///< NULL, or one per vertex: not 0 if it keeps its place at all levels
    const float* colors;   ///< NULL, or 9 per triangle: red, green, blue of each corner, linear
    const float* spreads;  ///< NULL: none; else as in stp_group_mesh: what the corners do not show
} stp_level_source;

typedef struct stp_level_desc {
    double first_error; ///< largest error of a collapse at level 1, in units; above 0
    double growth;      ///< factor on it from level to level; above 1
    double last_error;  ///< no level goes farther
    /// Groups that keep more than this share of their triangles wait for the next level; below 1
    double most_kept;
    double border_weight, least_cosine; ///< as in stp_collapse_desc
    /// Weights of changes of colour (0 to 1 a channel, as the eye sees it) and of the normal
    /// (radians): the mean change, times the size of a triangle, counts in the error
    double color_weight, normal_weight;
    /// If the first levels spare little even where this error is allowed, no more are made
    double useful_error;
    bool hides; ///< looks for triangles that cannot be seen from outside
} stp_level_desc;

/// Proven values for a mesh of this diagonal.
stp_level_desc stp_level_defaults(double diagonal);

/// Makes the levels. The same result for any number of threads. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (more than 2^31 corners in all); logged. Destroy the
/// graph in either case
STP_MUST_USE stp_result stp_level_graph_make(stp_context* context, const stp_level_source* source,
                                             const stp_level_desc* desc, stp_level_graph* graph);
void stp_level_graph_destroy(stp_context* context, stp_level_graph* graph);

/// Whether a cluster is drawn where errors up to `allowed` may be shown: `made` and `used` are what
/// is allowed at the spheres of the groups that made and use it (ignored if there is none).
static inline bool stp_level_is_drawn(const stp_level_graph* graph, uint32_t cluster, double made,
                                      double used)
{
    const stp_level_cluster* c = &graph->clusters[cluster];
    bool suffices = c->made_by == STP_LEVEL_NONE || graph->groups[c->made_by].error <= made;
    return suffices && (c->used_by == STP_LEVEL_NONE || graph->groups[c->used_by].error > used);
}
