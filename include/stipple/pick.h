// SPDX-License-Identifier: MIT
//
// What a pixel shows: exact, from original triangles and points, whatever splats the picture was drawn with.
#pragma once

#include <stipple/model.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { STP_HIT_ATTRIBUTES = 32 }; ///< room for attributes of later versions

typedef enum stp_hit_snap {
    STP_HIT_SNAP_NONE,
    STP_HIT_SNAP_VERTEX,
    STP_HIT_SNAP_EDGE
} stp_hit_snap;

typedef struct stp_hit {
    size_t struct_size;
    bool hit; ///< false: the ray meets nothing, and the rest is zero
    /// Something on the ray was not loaded (streaming, or a file that ends early): there may be something nearer.
    bool incomplete;
    bool is_point;      ///< a point, not a triangle
    double distance;    ///< from the eye; in parallel projection, from the plane of the eye
    stp_vec3d position; ///< scene space
    stp_vec3d normal;   ///< of the triangle, facing the eye; zero of a point
    stp_hit_snap snap;  ///< what is near enough to snap to: 8 pixels
    stp_vec3d snapped;  ///< the vertex or the place on an edge; else the position
    /// The lowest object that it belongs to, STP_NO_OBJECT where the tree does not say; and the lowest of those above that
    /// stands in the scene by itself (stp_object_info.placed), for stp_model_set_appearance.
    uint32_t object, placed_object;
    const char* material; ///< name; NULL: none
    uint32_t
        attributes; ///< of a point: which of the values are known, a bit each. Not of streamed callbacks
    double values[STP_HIT_ATTRIBUTES]; ///< by stp_attribute
} stp_hit;

/// Finds what a place of a picture shows: pixels from the left and the top edge (the middle of the first pixel is 0.5, 0.5).
/// What is hidden or cut away by the view's sections is not met; points are met within two pixels.
/// @return STP_OK, whether anything is hit or not; STP_ERROR_ARGUMENT (a view that cannot be used), STP_ERROR_LIMIT,
/// STP_ERROR_FORMAT (damaged data), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_pick(stp_model* model, const stp_view* view, double x,
                                               double y, stp_hit* hit);

#ifdef __cplusplus
}
#endif
