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

#include "base/math/math.h"
#include "lod/levels/collapse.h"

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
    /// it replaces
    double error;
    stp_vec3d center; ///< of a sphere around all originals that it stands for, which contains the
    double radius;    ///< spheres of the groups that made its clusters
    uint32_t level;   ///< from 1
} stp_level_group;

typedef struct stp_level_graph {
    uint32_t vertex_count, triangle_count, cluster_count, group_count;
    float* positions;  ///< 3 per vertex: those of the mesh, then new ones
    uint32_t* indices; ///< 3 per triangle
    uint32_t* tags;    ///< one per triangle: that of an original at its place
    stp_level_cluster* clusters;
    stp_level_group* groups; ///< by level
    size_t vertex_capacity, triangle_capacity, tag_capacity, cluster_capacity, group_capacity;
} stp_level_graph;

typedef struct stp_level_desc {
    double first_error; ///< largest error of a collapse at level 1, in units; above 0
    double growth;      ///< factor on it from level to level; above 1
    double last_error;  ///< no level goes farther
    /// Groups that keep more than this share of their triangles wait for the next level; below 1
    double most_kept;
    double border_weight, least_cosine; ///< as in stp_collapse_desc
} stp_level_desc;

/// Proven values for a mesh of this diagonal.
stp_level_desc stp_level_defaults(double diagonal);

/// Makes the levels. `mesh` is read only: welded by position, so that triangles that touch share
/// vertices; tags NULL: numbers of the triangles; locked is ignored. The same result for any number of
/// threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (more than 2^31 corners in
/// all); logged. Destroy the graph in either case
STP_MUST_USE stp_result stp_level_graph_make(stp_context* context, const stp_collapse_mesh* mesh,
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
