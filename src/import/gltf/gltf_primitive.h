// SPDX-License-Identifier: MIT
// One primitive of a mesh while it is read.
#pragma once

#include "import/gltf/gltf_accessor.h"
#include "import/gltf/gltf_draco.h"

/// Modes of a primitive (3.7.2.1).
typedef enum stp_gltf_mode {
    STP_GLTF_POINTS,
    STP_GLTF_LINES,
    STP_GLTF_LINE_LOOP,
    STP_GLTF_LINE_STRIP,
    STP_GLTF_TRIANGLES,
    STP_GLTF_TRIANGLE_STRIP,
    STP_GLTF_TRIANGLE_FAN,
} stp_gltf_mode;

/// Location of a primitive's vertices, and the ones it uses.
typedef struct stp_gltf_vertices {
    const json_t* attributes;
    size_t count; ///< all there are
    stp_gltf_selection selection;
    stp_draco_mesh* draco; ///< NULL: not compressed
    const json_t* draco_attributes;
} stp_gltf_vertices;

/// Result of reading a primitive. It owns the arrays until the scene takes them.
typedef struct stp_gltf_primitive {
    size_t variant;
    size_t index; ///< within its mesh
    stp_gltf_mode mode;
    bool present; ///< `mesh` holds triangles, or `points` holds points (mode STP_GLTF_POINTS)
    stp_mesh mesh;
    stp_point_set points;
    stp_result result;
    char* error; ///< copies of a scope's messages; NULL: none
    char* warning;
} stp_gltf_primitive;

/// Reads an attribute of the selected vertices into `values` (stp_alloc); NULL if the primitive
/// lacks it, or (with a warning) if it has too few elements. `components` holds the allowed range
/// and receives the actual number.
STP_MUST_USE stp_result stp_gltf_attribute(stp_gltf_scope* scope, const stp_gltf_vertices* vertices,
                                           const char* name, uint32_t components[2],
                                           float** values);

// gltf_index.c

/// Makes the triangle list of a primitive and selects the vertices it uses. `indices` and the
/// selection's map come from stp_alloc, also on failure.
STP_MUST_USE stp_result stp_gltf_triangles(stp_gltf_scope* scope, const json_t* primitive,
                                           stp_gltf_mode mode, stp_gltf_vertices* vertices,
                                           uint32_t** indices, size_t* triangle_count);
/// Selects the vertices used by a primitive of points.
STP_MUST_USE stp_result stp_gltf_points(stp_gltf_scope* scope, const json_t* primitive,
                                        stp_gltf_vertices* vertices);

// gltf_pose.c

/// Moves positions and normals (may be NULL) to the rest pose of the variant's morph weights and
/// skin.
STP_MUST_USE stp_result stp_gltf_pose(stp_gltf_scope* scope, const json_t* mesh,
                                      const json_t* primitive, const stp_gltf_variant* variant,
                                      const stp_gltf_vertices* vertices, float* positions,
                                      float* normals);

// gltf_primitive.c

/// Reads one primitive; its variant and index are already set.
STP_MUST_USE stp_result stp_gltf_read_primitive(stp_gltf_scope* scope,
                                                stp_gltf_primitive* primitive);
void stp_gltf_free_primitive(stp_context* context, stp_gltf_primitive* primitive);
