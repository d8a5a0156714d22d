// SPDX-License-Identifier: MIT
// The stages of coding a mesh: an order in space, one cluster gathered after the other, its bytes.
#pragma once

#include "store/clusters_layout.h"

enum { CLUSTER_SLOTS = 1024 };

/// To the nearest whole number, upwards where two are, of a size that clusters can hold.
int32_t clusters_round(double value);

/// A vertex on the mesh's grid; or of a cluster.
typedef struct cluster_place {
    int32_t at[3];
    uint32_t normal; ///< two octahedral numbers, 16 bits each
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

/// Rounds all vertices of a mesh, whose numbers are not too large for it, and takes over their normals.
void clusters_place_vertices(const stp_store_mesh* mesh, double inverse_step,
                             cluster_place* places);

/// What is loose is of a class: not 0.
static inline uint32_t clusters_part_class(uint32_t triangles, uint32_t vertices)
{
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

/// A cluster on its way.
typedef struct cluster_maker {
    const stp_store_mesh* mesh;
    const cluster_place* places; ///< of the mesh's vertices
    double inverse_step;
    double texcoord_inverses[2];
    uint32_t present;
    uint32_t extra_channels[STP_CLUSTER_CHANNELS]; ///< that tell vertices apart beside their places
    uint32_t extra_count;
    // of the cluster
    uint32_t triangle_count, vertex_count;
    uint32_t shift;                               ///< positions are multiples of 2^shift steps
    uint32_t group;                               ///< vertices of a part; 0: not of loose parts
    cluster_place vertices[STP_CLUSTER_VERTICES]; ///< normals as they are stored
    int32_t values[STP_CLUSTER_CHANNELS]
                  [STP_CLUSTER_VERTICES]; ///< of places and normals: once finished
    bool has_normal[STP_CLUSTER_VERTICES];
    uint8_t corners[STP_CLUSTER_TRIANGLES][3];
    uint8_t groups[STP_CLUSTER_TRIANGLES];
    uint16_t slots[CLUSTER_SLOTS],
        next[STP_CLUSTER_VERTICES]; ///< vertices by hash, plus 1; 0: none
} cluster_maker;

/// The triangles of a mesh along a Hilbert curve through their middles: `items` hold them in their low 32 bits,
/// and have room for the mesh's triangles, as `scratch` has. @return `items` or `scratch`
uint64_t* clusters_sort(const stp_store_mesh* mesh, const cluster_place* places, uint64_t* items,
                        uint64_t* scratch);

/// Puts loose parts last, one class after the other, each along the curve; `order` as clusters_sort makes it, with
/// room for the same in `scratch`. Above each triangle's number: the class of its part, 0 for what is not loose.
/// May exchange the two.
stp_result clusters_sort_parts(stp_context* context, const stp_store_mesh* mesh,
                               const cluster_place* places, uint64_t** order, uint64_t** scratch);

void cluster_maker_begin(cluster_maker* maker);
/// @return false where the triangle does not fit in any more
bool cluster_maker_add(cluster_maker* maker, uint32_t triangle);
/// Fills a cluster with loose parts of one class: `triangles` has `count` of them, in the low 32 bits.
/// @return false where they are better added one by one
bool cluster_maker_take_parts(cluster_maker* maker, const uint64_t* triangles, uint32_t count,
                              uint32_t part_class);
/// Sorts triangles into groups, and vertices with normals to the front.
void cluster_maker_finish(cluster_maker* maker, clusters_entry* entry);

/// The most bytes that clusters_pack writes.
enum {
    CLUSTER_MOST_BYTES =
        3 * STP_CLUSTER_TRIANGLES + STP_CLUSTER_CHANNELS * (8 * STP_CLUSTER_VERTICES + 16)
};
/// Writes a finished cluster's bytes and the place of its positions. @return bytes written, a multiple of 4
size_t clusters_pack(const cluster_maker* maker, clusters_entry* entry, unsigned char* bytes);
