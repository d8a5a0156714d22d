// SPDX-License-Identifier: MIT
//
// Picking: finds the original triangle or point that a pixel shows, whichever splats the picture
// was drawn with.
#pragma once

#include <stipple/model.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { STP_HIT_ATTRIBUTES = 32 }; ///< reserves space for attributes of later versions

typedef enum stp_hit_snap {
    STP_HIT_SNAP_NONE,
    STP_HIT_SNAP_VERTEX,
    STP_HIT_SNAP_EDGE
} stp_hit_snap;

typedef struct stp_hit {
    size_t struct_size;
    /// False: the ray hits nothing; the fields below except `incomplete` are zero, the objects
    /// STP_NO_OBJECT.
    bool hit;
    /// Data on the ray was not loaded (streaming, or a truncated file): there may be a nearer hit.
    bool incomplete;
    bool is_point;      ///< a point, not a triangle
    double distance;    ///< from the eye; in parallel projection, from the eye's plane
    stp_vec3d position; ///< scene space
    stp_vec3d normal;   ///< normal of the triangle, facing the eye; zero for a point
    stp_hit_snap snap;  ///< snap target within 8 pixels
    stp_vec3d snapped;  ///< the vertex or the point on an edge; else the position
    /// Innermost object that contains the hit, STP_NO_OBJECT if unknown; and its innermost placed
    /// ancestor (stp_object_info.placed), for stp_model_set_appearance.
    uint32_t object, placed_object;
    const char* material; ///< name; NULL: none
    uint32_t attributes;  ///< for a point: known values, one bit each. Not for streamed callbacks
    double values[STP_HIT_ATTRIBUTES]; ///< indexed by stp_attribute
} stp_hit;

/// How to pick. All zero: the default.
typedef struct stp_hit_desc {
    size_t struct_size;
    /// Backs of single-sided materials are hit, too: for pictures drawn with
    /// stp_paint_desc.back_faces.
    bool back_faces;
} stp_hit_desc;

/// Picks at a position in the picture, in pixels from the left and top edges (the centre of the
/// first pixel is 0.5, 0.5). Hidden objects and parts cut away by the view's sections are ignored,
/// and so are backs of single-sided materials, unless the view has sections (see
/// stp_hit_desc.back_faces). Points are hit within two pixels.
/// @return STP_OK, whether or not anything is hit; STP_ERROR_ARGUMENT (invalid view),
/// STP_ERROR_LIMIT, STP_ERROR_FORMAT (damaged data), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_model_pick(stp_model* model, const stp_view* view, double x,
                                               double y, stp_hit* hit);
/// The same, as a descriptor says; NULL: the default. Also returns STP_ERROR_UNSUPPORTED if it sets
/// fields that this version of the library lacks.
STP_API STP_MUST_USE stp_result stp_model_pick_with(stp_model* model, const stp_view* view,
                                                    const stp_hit_desc* desc, double x, double y,
                                                    stp_hit* hit);

#ifdef __cplusplus
}
#endif
