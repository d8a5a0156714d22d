// SPDX-License-Identifier: MIT
//
// What a ray meets first among the triangles of meshes, each of which may stand in many places: a
// tree of boxes over places, and one over the triangles of each mesh. Many rays, any thread.
#pragma once

#include "measure/box_tree.h"

/// Arrays are the caller's, must outlive the caster, and are only read. All numbers are finite.
typedef struct stp_cast_mesh {
    const float* positions;  ///< 3 a vertex
    const uint32_t* indices; ///< 3 a triangle; NULL: three vertices a triangle, one after the other
    uint32_t triangle_count; ///< below 2^31
} stp_cast_mesh;

/// A mesh in a place.
typedef struct stp_cast_part {
    uint32_t mesh;
    stp_affine transform; ///< from the mesh to where rays are
} stp_cast_part;

typedef struct stp_caster stp_caster;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (2^31 parts, or triangles of a mesh),
///         STP_ERROR_CANCELLED; logged. The same answers for any number of threads
STP_MUST_USE stp_result stp_caster_create(stp_context* context, const stp_cast_mesh* meshes,
                                          uint32_t mesh_count, const stp_cast_part* parts,
                                          uint32_t part_count, stp_caster** caster);
void stp_caster_destroy(stp_context* context, stp_caster* caster);

/// The box of all that rays may meet; empty where that is nothing. Up to a part in a million
/// larger.
stp_boxd stp_caster_bounds(const stp_caster* caster);

/// The corners of a triangle where it stands.
void stp_caster_corners(const stp_caster* caster, uint32_t part, uint32_t triangle,
                        stp_vec3d corners[3]);

/// Points origin + t direction with t from `nearest` (not below 0) to `farthest`.
typedef struct stp_cast_ray {
    stp_vec3d origin, direction; ///< direction of any length but 0
    double nearest, farthest;
} stp_cast_ray;

typedef struct stp_cast_hit {
    double distance; ///< t of the ray
    uint32_t part, triangle;
    double share[3]; ///< of the triangle's corners, 1 in all
} stp_cast_hit;

/// Finds the nearest triangle, whichever side it shows. No ray slips through between two triangles
/// of a mesh that share an edge (Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, 2013).
/// Of two that are equally near, either is met, always the same.
/// @param keeps  NULL, or tells whether what was met is there; a ray goes on where it is not
/// @return whether anything is met
bool stp_caster_meet(const stp_caster* caster, const stp_cast_ray* ray,
                     bool (*keeps)(const stp_cast_hit* hit, void* user), void* user,
                     stp_cast_hit* hit);
