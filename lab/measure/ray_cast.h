// SPDX-License-Identifier: MIT
//
// Finds the first triangle that a ray hits, among instanced meshes: a bounding volume hierarchy
// over instances, and one over the triangles of each mesh. Thread-safe.
#pragma once

#include "lab/measure/box_tree.h"

/// The arrays belong to the caller, must outlive the caster, and are only read. All numbers are
/// finite.
typedef struct stp_cast_mesh {
    const float* positions;  ///< 3 per vertex
    const uint32_t* indices; ///< 3 per triangle; NULL: three consecutive vertices per triangle
    uint32_t triangle_count; ///< below 2^31
} stp_cast_mesh;

/// An instance of a mesh.
typedef struct stp_cast_part {
    uint32_t mesh;
    stp_affine transform; ///< from the mesh to the space of rays
} stp_cast_part;

typedef struct stp_caster stp_caster;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (2^31 parts, or triangles of a mesh),
///         STP_ERROR_CANCELLED; logged. The same answers for any number of threads
STP_MUST_USE stp_result stp_caster_create(stp_context* context, const stp_cast_mesh* meshes,
                                          uint32_t mesh_count, const stp_cast_part* parts,
                                          uint32_t part_count, stp_caster** caster);
void stp_caster_destroy(stp_context* context, stp_caster* caster);

/// Bounding box of everything rays may hit; empty if there is nothing. Encloses the transformed
/// boxes of the meshes, so it is larger than necessary if parts are rotated.
stp_boxd stp_caster_bounds(const stp_caster* caster);

/// Transformed corners of a triangle.
void stp_caster_corners(const stp_caster* caster, uint32_t part, uint32_t triangle,
                        stp_vec3d corners[3]);

/// Points origin + t direction with t from `nearest` (not below 0) to `farthest`.
typedef struct stp_cast_ray {
    stp_vec3d origin, direction; ///< direction: any non-zero length
    double nearest, farthest;
} stp_cast_ray;

typedef struct stp_cast_hit {
    double distance; ///< t of the ray
    uint32_t part, triangle;
    double share[3]; ///< barycentric coordinates
} stp_cast_hit;

/// Finds the nearest triangle; triangles are two-sided. No ray slips between two triangles of a
/// mesh that share an edge (Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, 2013). Ties
/// are resolved deterministically.
/// @param keeps  NULL, or a test whether a hit counts; otherwise the ray continues
/// @return whether anything is hit
bool stp_caster_intersect(const stp_caster* caster, const stp_cast_ray* ray,
                          bool (*keeps)(const stp_cast_hit* hit, void* user), void* user,
                          stp_cast_hit* hit);
