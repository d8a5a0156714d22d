// SPDX-License-Identifier: MIT
//
// Levels: simplified triangles of a node, as a graph of clusters that can be mixed without cracks
// (src/lod/levels/level_graph.h). A level is stored as a mesh of clusters. It is no part of any
// node: it stands for the opaque meshes of its node and of all nodes below.
#pragma once

#include <stdint.h>

/// Clusters that were simplified together. Lengths are in units of the node.
typedef struct stp_store_level_group {
    float center[3], radius; ///< sphere around all originals that it stands for
    float error;             ///< of the clusters that it made; above 0
} stp_store_level_group;

typedef struct stp_store_level_cluster {
    /// Group that made it; STP_STORE_NONE: drawn however small the allowed error is.
    uint32_t made_by;
    /// Group that replaces it by fewer triangles; STP_STORE_NONE: none, it is of the coarsest.
    uint32_t used_by;
    /// Number of triangles, from its first on, that are seen from the front alone. At most the
    /// cluster's triangle_count, unless a mapped file was overwritten.
    uint32_t one_sided;
} stp_store_level_cluster;

/// How much all levels of a file are.
typedef struct stp_store_level_figures {
    uint64_t levels, triangles; ///< stored
    uint64_t bytes;             ///< of their meshes
} stp_store_level_figures;

enum {
    STP_LEVEL_FROM_OUTSIDE = 1, ///< lacks what cannot be seen from outside the node's box
};

/// A band of the clusters of a node. The writer reads only `node` and `flags`; the reader makes the
/// other fields.
typedef struct stp_store_level {
    uint32_t node, mesh; ///< of the directory
    uint32_t flags;      ///< STP_LEVEL_*
    /// In level_clusters: one for each cluster of the mesh.
    uint32_t first_cluster, cluster_count;
    /// It draws something only where errors of at least `least` are allowed, and below `most`
    /// (FLT_MAX: without end): the least error of the groups that made its clusters (0: no group
    /// made one of them), and the largest of the groups that use them.
    float least, most;
} stp_store_level;
