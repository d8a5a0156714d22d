// SPDX-License-Identifier: MIT
// Triangles of mesh items: reading them, their colours, and which of their fragments are drawn.
#pragma once

#include "draw/cpu/cpu.h"

/// A triangle with all attributes of its corners.
typedef struct stp_cpu_triangle {
    float position[3][3]; ///< relative to the item's offset
    float texcoord[2][3][2];
    float color[3][4];  ///< linear, 1 is full
    stp_vec3 normal[3]; ///< not of unit length
    bool has_texcoord[2], has_color, has_normal;
} stp_cpu_triangle;

/// 16-bit octahedral; not of unit length.
stp_vec3 stp_cpu_decode_normal(const int16_t* code);

/// Reads triangles; access to neighbours of the previous triangle is faster.
typedef struct stp_cpu_reader {
    const stp_cpu_item* item; ///< item of the last triangle; NULL: none yet
    uint32_t index;           ///< index of the last triangle
    stp_cpu_triangle triangle;
    const stp_cpu_item* cluster_item; ///< mesh of the open cluster; NULL: none
    stp_cluster cluster;
} stp_cpu_reader;

/// Triangle `index` of a mesh item; valid until the next call.
const stp_cpu_triangle* stp_cpu_read_triangle(stp_cpu_reader* reader, const stp_cpu_item* item,
                                              uint32_t index);
/// Reads triangle `index` of a mesh of clusters, from the cluster that holds it.
void stp_cpu_read_from_cluster(const stp_cpu_item* item, const stp_cluster* cluster, uint32_t index,
                               stp_cpu_triangle* out);

stp_vec2 stp_cpu_mesh_uv(const stp_cpu_triangle* triangle, const stp_store_texture_use* use,
                         const float weight[3]);
/// Texels of `pyramid` per item unit along a triangle.
float stp_cpu_mesh_density(const stp_cpu_triangle* triangle, const stp_store_texture_use* use,
                           const stp_texture_pyramid* pyramid);
/// Base colour with texture and vertex colours, at a point of a triangle; a pixel there is
/// `footprint` texels wide.
void stp_cpu_mesh_color(const stp_cpu_item* item, const stp_cpu_triangle* triangle,
                        const float weight[3], float footprint, float out[4]);

/// Cached values of the last fragment's triangle, shared by its fragments.
typedef struct stp_cpu_keep_memory {
    uint32_t triangle; ///< UINT32_MAX: none yet
    float w[3], density;
    uint32_t pattern; ///< key of its alpha thresholds
    stp_cpu_reader reader;
} stp_cpu_keep_memory;

/// Whether a fragment is drawn, for cutout and transparent materials, section planes and ghosts.
typedef struct stp_cpu_keep {
    const stp_cpu_renderer* renderer;
    const stp_cpu_item* item;
    uint32_t first_triangle;
    stp_cpu_keep_memory* memory;
    const stp_cpu_sections* sections;
    uint32_t section_mask; ///< bits of planes that may cut the drawn content
} stp_cpu_keep;

bool stp_cpu_keep_fragment(const void* user, uint32_t triangle, float weight1, float weight2,
                           uint32_t x, uint32_t y);
/// Whether fragments of an item may be dropped by more than section planes.
bool stp_cpu_item_needs_keep(const stp_cpu_item* item);
