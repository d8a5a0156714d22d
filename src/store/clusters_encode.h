// SPDX-License-Identifier: MIT
// The stages of coding a mesh: an order in space, one cluster gathered after the other, its bytes.
#pragma once

#include "store/clusters_layout.h"

enum { CLUSTER_SLOTS = 1024 };

typedef enum cluster_group { GROUP_SMOOTH, GROUP_FACE, GROUP_PLAIN, GROUP_COUNT } cluster_group;

/// A cluster on its way.
typedef struct cluster_maker {
    const stp_store_mesh* mesh;
    double inverse_step;
    double texcoord_inverses[2];
    uint32_t present;
    uint32_t
        key_channels[STP_CLUSTER_CHANNELS]; ///< by which vertices are told apart, but for normals
    uint32_t key_count;
    // of the cluster
    uint32_t triangle_count, vertex_count;
    int32_t values[STP_CLUSTER_CHANNELS][STP_CLUSTER_VERTICES];
    bool has_normal[STP_CLUSTER_VERTICES];
    uint8_t corners[STP_CLUSTER_TRIANGLES][3];
    uint8_t groups[STP_CLUSTER_TRIANGLES];
    uint16_t slots[CLUSTER_SLOTS],
        next[STP_CLUSTER_VERTICES]; ///< vertices by hash, plus 1; 0: none
} cluster_maker;

/// The triangles of a mesh along a Hilbert curve through their middles: `items` hold them in their low 32 bits,
/// and have room for the mesh's triangles, as `scratch` has. @return `items` or `scratch`
uint64_t* clusters_sort(const stp_store_mesh* mesh, uint64_t* items, uint64_t* scratch);

void cluster_maker_begin(cluster_maker* maker);
/// @return false where the triangle does not fit in any more
bool cluster_maker_add(cluster_maker* maker, uint32_t triangle);
/// Sorts triangles into groups, and vertices with normals to the front.
void cluster_maker_finish(cluster_maker* maker, clusters_entry* entry);

/// The most bytes that clusters_pack writes.
enum {
    CLUSTER_MOST_BYTES =
        64 + 3 * STP_CLUSTER_TRIANGLES + STP_CLUSTER_CHANNELS * (4 * STP_CLUSTER_VERTICES + 8)
};
/// Writes a finished cluster's bytes and the place of its positions. @return bytes written, a multiple of 4
size_t clusters_pack(const cluster_maker* maker, clusters_entry* entry, unsigned char* bytes);
