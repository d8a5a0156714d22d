// SPDX-License-Identifier: MIT
// The stages of coding a mesh: sort triangles along a curve, gather clusters, pack their bytes.
#pragma once

#include "store/clusters/clusters_layout.h"

#include <assert.h>

enum { CLUSTER_SLOTS = 1024 };

/// Rounds to the nearest integer, ties upwards, and clamps to CLUSTERS_NUMBER_LIMIT in magnitude.
int32_t stp_clusters_round(double value);

/// A vertex on the grid of the mesh or of a cluster.
typedef struct cluster_place {
    int32_t at[3];
    uint32_t normal; ///< two 16-bit octahedral components
} cluster_place;

static inline uint32_t clusters_join_normal(int32_t u, int32_t v)
{
    return (uint32_t)(uint16_t)u | (uint32_t)(uint16_t)v << 16;
}

static inline int32_t clusters_normal_u(uint32_t normal)
{
    return (int16_t)(uint16_t)normal;
}

static inline int32_t clusters_normal_v(uint32_t normal)
{
    return (int16_t)(uint16_t)(normal >> 16);
}

/// Rounds all vertices of a mesh and copies their normals. Coordinates must fit the grid.
void stp_clusters_place_vertices(const stp_store_mesh* mesh, double inverse_step,
                                 cluster_place* places);

/// Classes of loose parts start at 1; 0 is not loose.
static inline uint32_t clusters_part_class(uint32_t triangles, uint32_t vertices)
{
    assert(vertices <= 255 && triangles <= UINT32_MAX >> 8);
    return triangles << 8 | vertices;
}

static inline uint32_t clusters_part_triangles(uint32_t part_class)
{
    return part_class >> 8;
}

static inline uint32_t clusters_part_vertices(uint32_t part_class)
{
    return part_class & 255;
}

typedef enum cluster_group { GROUP_SMOOTH, GROUP_FACE, GROUP_PLAIN, GROUP_COUNT } cluster_group;

/// A cluster being gathered.
typedef struct stp_cluster_maker {
    const stp_store_mesh* mesh;
    const cluster_place* places; ///< the mesh's vertices on its grid
    double inverse_step;
    double texcoord_inverses[2];
    uint32_t present;
    /// Channels other than positions that distinguish vertices.
    uint32_t extra_channels[STP_CLUSTER_CHANNELS];
    uint32_t extra_count;
    bool all_plain; ///< all triangles are plain, so they stay in order
    // The current cluster:
    uint32_t triangle_count, vertex_count;
    uint32_t shift;                               ///< positions are multiples of 2^shift steps
    uint32_t group;                               ///< vertices per part; 0: no loose parts
    cluster_place vertices[STP_CLUSTER_VERTICES]; ///< with normals in their stored precision
    /// Positions and normals as channels, once finished.
    int32_t values[STP_CLUSTER_CHANNELS][STP_CLUSTER_VERTICES];
    bool has_normal[STP_CLUSTER_VERTICES];
    uint8_t corners[STP_CLUSTER_TRIANGLES][3];
    uint8_t groups[STP_CLUSTER_TRIANGLES];
    uint16_t slots[CLUSTER_SLOTS],
        next[STP_CLUSTER_VERTICES]; ///< hash chains of vertices: index + 1; 0 ends
} stp_cluster_maker;

/// Sorts the triangles of a mesh along a Hilbert curve through their centres. `items` gets them in
/// its low 32 bits. `items` and `scratch` have room for all triangles. @return `items` or `scratch`
uint64_t* stp_clusters_sort(const stp_store_mesh* mesh, const cluster_place* places,
                            uint64_t* items, uint64_t* scratch);

/// Moves loose parts to the end, class by class, each along the curve. `order` comes from
/// stp_clusters_sort; `scratch` has the same room. Afterwards the bits above a triangle's index hold
/// the class of its part, 0 if it is not loose. May swap the two arrays.
stp_result stp_clusters_sort_parts(stp_context* context, const stp_store_mesh* mesh,
                                   const cluster_place* places, uint64_t** order,
                                   uint64_t** scratch);

void stp_cluster_maker_begin(stp_cluster_maker* maker);
/// @return false if the cluster has no room for the triangle
bool stp_cluster_maker_add(stp_cluster_maker* maker, uint32_t triangle);
/// Fills a cluster with loose parts of one class: `count` triangles, in the low 32 bits of
/// `triangles`. @return false if adding them one by one is better
bool stp_cluster_maker_take_parts(stp_cluster_maker* maker, const uint64_t* triangles,
                                  uint32_t count, uint32_t part_class);
/// Sorts triangles into groups, and vertices with normals to the front.
void stp_cluster_maker_finish(stp_cluster_maker* maker, clusters_entry* entry);

/// Maximum size that stp_clusters_pack writes.
enum {
    CLUSTER_MAX_BYTES =
        3 * STP_CLUSTER_TRIANGLES + STP_CLUSTER_CHANNELS * (8 * STP_CLUSTER_VERTICES + 16)
};
/// Writes a finished cluster and the origin of its positions. @return bytes written, a multiple of
/// 4
size_t stp_clusters_pack(const stp_cluster_maker* maker, clusters_entry* entry,
                         unsigned char* bytes);
