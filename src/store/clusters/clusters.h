// SPDX-License-Identifier: MIT
//
// Original triangles as clusters: up to 128 neighbouring triangles with up to 256 vertices.
// Positions are quantised on the mesh's power-of-two grid, with an origin per cluster. Vertices
// that neighbouring clusters share round to the same position, so no cracks appear. Pieces of a split
// mesh use the same step, so this holds between them too. docs/format.md is the authority on the
// bytes.
//
// The triangles of a cluster form three groups, by the normals that light them:
//
//   smooth   each corner has its vertex's normal
//   face     all corners have the first corner's normal
//   plain    the normal of the triangle's plane
//
// So hard edges need no extra vertices, and flat parts hardly any normals.
//
// Loose parts (leaves, needles, twigs) share no vertex with anything else. A cluster of loose parts
// has the same number of vertices in each part and stores its numbers in two layers: one per part,
// one per vertex. If all parts have the same triangles, it stores them once. Positions there may be
// multiples of several steps.
#pragma once

#include "base/core/context.h"
#include "base/core/processor.h"
#include "base/math/math.h"

#include <assert.h>
#include <string.h>

enum {
    STP_CLUSTER_TRIANGLES = 128,
    STP_CLUSTER_VERTICES = 256,
    STP_CLUSTER_NORMAL_LIMIT = 511, ///< octahedral code of 1
    /// Code of full intensity; codes are the square root of the linear value.
    STP_CLUSTER_COLOR_LIMIT = 255,
    STP_CLUSTER_ALPHA_LIMIT = 255,
};

/// A mesh as arrays of floats.
typedef struct stp_store_mesh {
    const char* name;
    uint32_t vertex_count, triangle_count, material;
    stp_box bounds;
    const float* positions;    ///< 3 per vertex
    const int16_t* normals;    ///< NULL (flat), or octahedral, 2 per vertex, 32767 is 1
    const float* texcoords[2]; ///< NULL, or 2 per vertex
    const uint16_t* colors;    ///< NULL, or 4 per vertex, linear, 65535 is 1
    const uint32_t* indices;   ///< 3 per triangle, each below vertex_count
    double area;   ///< total area of its triangles, in square units of its space; not stored
    bool is_piece; ///< a piece of a larger mesh: its borders round like the whole's; not stored
} stp_store_mesh;

/// Vertex index of a corner (3 per triangle). Always below vertex_count, because a mapped file can
/// be overwritten after its check.
static inline uint32_t stp_store_mesh_corner(const stp_store_mesh* mesh, size_t corner)
{
    assert(corner < 3 * (size_t)mesh->triangle_count);
    uint32_t vertex = *(const volatile uint32_t*)(mesh->indices + corner); // read once
    return vertex < mesh->vertex_count ? vertex : 0;
}

/// A coded mesh: what the writer stores as one block. `bytes` may lie in a mapped file.
typedef struct stp_coded_mesh {
    const void* bytes;
    size_t size;
    uint32_t cluster_count, triangle_count, vertex_count; ///< vertices: sum over clusters
    stp_box bounds;                                       ///< box around the quantised positions
} stp_coded_mesh;

/// Codes a mesh on the grid of `step` (base/math/position_grid.h) into memory of the context (stp_free
/// of `bytes`). Pieces of a split mesh get the step of the whole. Arrays are as in stp_store_mesh:
/// floats, with normals as 16-bit octahedral codes. Deterministic; may run inside jobs. Reorders
/// triangles. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT
STP_MUST_USE stp_result stp_clusters_encode(stp_context* context, const stp_store_mesh* mesh,
                                            double step, stp_coded_mesh* coded);

/// Like stp_clusters_encode, but cluster i is triangles [ends[i - 1], ends[i]) of the mesh, in their
/// order; `ends` ascend to its triangle_count, so there is at least one. Loose parts are coded like
/// other triangles. Within a cluster of a mesh without normals the triangles keep their order, and
/// each has the normal of its rounded plane. With normals, they are sorted into smooth, face and
/// plain ones. @return as stp_clusters_encode; STP_ERROR_LIMIT too for a cluster of more than 128
/// triangles or, after rounding, 256 vertices (with normals, 254 may be too many)
STP_MUST_USE stp_result stp_clusters_encode_ranges(stp_context* context, const stp_store_mesh* mesh,
                                                   double step, const uint32_t* ends,
                                                   uint32_t count, stp_coded_mesh* coded);

/// Frees the result of stp_clusters_encode and stp_clusters_encode_ranges.
void stp_coded_mesh_destroy(stp_context* context, stp_coded_mesh* coded);

/// A coded mesh opened for reading: pointers into its bytes.
typedef struct stp_clusters {
    const unsigned char* bytes; ///< NULL: no mesh
    size_t size;
    uint32_t cluster_count, triangle_count, vertex_count;
    uint32_t present; ///< STP_COLUMN_*
    float step, texcoord_steps[2];
    stp_processor processor; ///< whose kernel unpacks positions
} stp_clusters;

/// Checks every count, size and index of a coded mesh. The functions below require it.
/// @return NULL, or the error
const char* stp_clusters_open(const void* bytes, size_t size, stp_clusters* clusters);

/// Restores the result of stp_clusters_encode from an opened mesh.
stp_coded_mesh stp_clusters_describe(const stp_clusters* clusters);

typedef enum stp_cluster_channel {
    STP_CLUSTER_X,
    STP_CLUSTER_Y,
    STP_CLUSTER_Z,
    STP_CLUSTER_NORMAL_U,
    STP_CLUSTER_NORMAL_V,
    STP_CLUSTER_TEXCOORDS, ///< u, v of set 0, then of set 1
    STP_CLUSTER_COLORS = STP_CLUSTER_TEXCOORDS + 4,
    STP_CLUSTER_CHANNELS = STP_CLUSTER_COLORS + 4
} stp_cluster_channel;

typedef enum stp_cluster_layout {
    STP_CLUSTER_PLAIN,
    STP_CLUSTER_GROUPED,  ///< each value is the sum of a per-part and an own value
    STP_CLUSTER_REPEATED, ///< the same; own values repeat in every part
} stp_cluster_layout;

/// A run of integers of equal width, lowest bit first. With b(i) = bits [i width, (i + 1) width),
/// value i is origin + b(i) 2^shift. In parts of `group` values it is origin + (b(i / group) +
/// own(i)) 2^shift, where own(i) has own_width bits, at index i or (repeated) at i mod group.
typedef struct stp_cluster_run {
    const unsigned char* bits; ///< 8 bytes are readable from the first byte of any value
    const unsigned char* own;
    int32_t origin;
    uint32_t width; ///< at most 32
    uint8_t own_width, shift, group;
    uint8_t layout; ///< stp_cluster_layout
} stp_cluster_run;

typedef struct stp_cluster {
    uint32_t first_triangle; ///< index in the mesh
    uint32_t triangle_count, vertex_count;
    /// Number of smooth triangles, which come first, and of face triangles after them. The rest are
    /// plain.
    uint32_t smooth_count, face_count;
    uint32_t normal_count;  ///< the first vertices have normals, the others none
    const uint8_t* indices; ///< 3 per triangle of the first `period`: see stp_cluster_corners
    uint32_t period; ///< triangles after which the pattern repeats, with indices raised by `stride`
    uint32_t stride;
    stp_cluster_run runs[STP_CLUSTER_CHANNELS]; ///< absent channels have no bits and read as 0
} stp_cluster;

/// Opens a cluster; `index` must be below cluster_count. Validates everything but indices again,
/// because a mapped file can be overwritten at any time. An invalid cluster becomes one vertex and
/// no triangles. All functions below stay within the mapped bytes and the STP_CLUSTER_* limits.
void stp_clusters_get(const stp_clusters* clusters, uint32_t index, stp_cluster* cluster);
/// Same, in less time: only positions and indices; what else it has reads as absent.
void stp_clusters_get_shape(const stp_clusters* clusters, uint32_t index, stp_cluster* cluster);
/// A box around the cluster, computed without opening it; at most twice as large as the tight box.
stp_box stp_clusters_bounds(const stp_clusters* clusters, uint32_t index);
uint32_t stp_clusters_first_triangle(const stp_clusters* clusters, uint32_t index);
/// Number of triangles of a cluster, at most STP_CLUSTER_TRIANGLES.
uint32_t stp_clusters_triangles(const stp_clusters* clusters, uint32_t index);
/// The cluster that contains triangle `triangle` (below triangle_count).
uint32_t stp_clusters_find(const stp_clusters* clusters, uint32_t triangle);
/// Prefetches a cluster's bytes.
void stp_clusters_prefetch(const stp_clusters* clusters, uint32_t index);

/// Number `i` of an array of numbers of `width` bits.
static inline uint32_t stp_cluster_bits(const unsigned char* bytes, uint32_t width, uint32_t i)
{
    assert(width <= 32 && i < STP_CLUSTER_VERTICES);
    uint64_t bits;
    uint32_t at = i * width;
    memcpy(&bits, bytes + (at >> 3), sizeof(bits));
    return (uint32_t)((bits >> (at & 7)) & (((uint64_t)1 << width) - 1));
}

/// One value of a run.
static inline int32_t stp_cluster_value(const stp_cluster_run* run, uint32_t i)
{
    uint32_t value;
    if (run->layout == STP_CLUSTER_PLAIN) {
        value = stp_cluster_bits(run->bits, run->width, i);
    } else {
        uint32_t part = i / run->group;
        uint32_t at = run->layout == STP_CLUSTER_GROUPED ? i : i - part * run->group;
        value = stp_cluster_bits(run->bits, run->width, part) +
                stp_cluster_bits(run->own, run->own_width, at);
    }
    return (int32_t)((uint32_t)run->origin + (value << run->shift));
}

/// A triangle's corners (`triangle` counts within the cluster), each below vertex_count.
static inline void stp_cluster_corners(const stp_cluster* cluster, uint32_t triangle,
                                       uint32_t corners[3])
{
    uint32_t part = triangle / cluster->period, first = part * cluster->stride;
    const uint8_t* index = cluster->indices + 3 * (size_t)(triangle - part * cluster->period);
    for (int k = 0; k < 3; ++k) {
        uint32_t corner = first + index[k];
        corners[k] = corner < cluster->vertex_count ? corner : 0;
    }
}

/// The corners of all triangles, each raised by `first`.
void stp_cluster_indices(const stp_cluster* cluster, uint32_t first, uint32_t* indices);

static inline stp_vec3 stp_cluster_position(const stp_clusters* clusters,
                                            const stp_cluster* cluster, uint32_t vertex)
{
    return (stp_vec3){
        (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_X], vertex) * clusters->step,
        (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_Y], vertex) * clusters->step,
        (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_Z], vertex) * clusters->step};
}

/// All positions, 3 floats per vertex.
void stp_cluster_positions(const stp_clusters* clusters, const stp_cluster* cluster,
                           float positions[3 * STP_CLUSTER_VERTICES]);

/// The normals of a triangle's corners (`triangle` counts within the cluster), not of unit length.
/// @return false if the triangle uses its plane's normal
bool stp_cluster_normals(const stp_cluster* cluster, uint32_t triangle, stp_vec3 normals[3]);

static inline stp_vec2 stp_cluster_texcoord(const stp_clusters* clusters,
                                            const stp_cluster* cluster, uint32_t set,
                                            uint32_t vertex)
{
    assert(set < 2);
    const stp_cluster_run* runs = &cluster->runs[STP_CLUSTER_TEXCOORDS + 2 * set];
    return (stp_vec2){(float)stp_cluster_value(&runs[0], vertex) * clusters->texcoord_steps[set],
                      (float)stp_cluster_value(&runs[1], vertex) * clusters->texcoord_steps[set]};
}

/// Linear red, green, blue, alpha; 1 is full intensity.
void stp_cluster_color(const stp_cluster* cluster, uint32_t vertex, float color[4]);

/// A fully decoded mesh: triangles in cluster order, three vertices each. For tools and tests.
typedef struct stp_decoded_mesh {
    uint32_t triangle_count;
    float* positions; ///< 9 per triangle
    /// 9 per triangle, unit length; zero for the planes of degenerate triangles
    float* normals;
    float* texcoords[2]; ///< NULL, or 6 per triangle
    float* colors;       ///< NULL, or 12 per triangle
} stp_decoded_mesh;

STP_MUST_USE stp_result stp_clusters_decode(stp_context* context, const stp_clusters* clusters,
                                            stp_decoded_mesh* mesh);
void stp_decoded_mesh_destroy(stp_context* context, stp_decoded_mesh* mesh);
