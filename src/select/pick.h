// SPDX-License-Identifier: MIT
//
// What a ray meets first, exactly and whatever the picture shows it as: original triangles and points, found from the
// root down through boxes, nearest first. Where the alpha of a cut-out material is below its cutoff, or that of a
// transparent one is 0, nothing is met.
#pragma once

#include "select/visibility.h"

#include <stipple/view.h>

/// Points origin + t direction, t from `nearest` to `farthest`.
typedef struct stp_ray {
    stp_vec3d origin, direction; ///< direction of unit length
    double nearest, farthest;
} stp_ray;

/// The ray through a point of a picture (a pixel's centre: column + 0.5, row + 0.5), from the near plane on. With two eyes,
/// of the eye whose half it lies in. @return false where the view is none
bool stp_ray_of_pixel(const stp_view* view, double x, double y, stp_ray* ray);

/// How wide a pixel is on the ray at a distance: base + slope distance, scene units.
void stp_pixel_width(const stp_view* view, double* base, double* slope);

typedef struct stp_pick_desc {
    stp_ray ray;
    const stp_sections* sections;     ///< NULL: nothing is cut away. What is, is not met
    const stp_visibility* visibility; ///< NULL: all is shown. What is hidden is not met
    bool through_ghosts;              ///< nor what is a ghost
    /// Points (of point sets) are met within base + slope t of the ray, scene units; both 0: none are.
    double point_base, point_slope;
} stp_pick_desc;

enum { STP_PICK_DEPTH = 64 }; ///< edges kept of a path

typedef struct stp_pick {
    bool hit;
    bool
        incomplete; ///< a mesh or points on the way are not resident: there may be something nearer
    double distance;    ///< t of the ray
    stp_vec3d position; ///< of the ray there; of a point, the point's own
    stp_vec3d normal;   ///< unit, of the triangle's plane, facing the origin of the ray
    stp_store_part part;
    uint32_t element;     ///< triangle (as clusters have them) or point
    stp_vec3d corners[3]; ///< of the triangle, scene space
    bool inner[3];        ///< whether the edge from that corner to the next lies within a flat face
    uint32_t material;    ///< of the store
    stp_placed_node thing;         ///< the node that has the part
    uint32_t path[STP_PICK_DEPTH]; ///< from the root: which edge of each node (slot)
    uint32_t path_count;           ///< of edges; above STP_PICK_DEPTH where not all are kept
    uint64_t tests;                ///< boxes, triangles and points looked at
} stp_pick;

/// @return STP_OK, whether anything is met or not; STP_ERROR_ARGUMENT (not a ray), STP_ERROR_LIMIT (too much lies on
/// it), STP_ERROR_FORMAT (a damaged block), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_pick_ray(stp_context* context, stp_store* store,
                                     const stp_pick_desc* desc, stp_pick* pick);

typedef enum stp_snap_kind { STP_SNAP_NONE, STP_SNAP_VERTEX, STP_SNAP_EDGE } stp_snap_kind;

/// The corner of a picked triangle within `reach` of where it was met, else the nearest point of those of its edges that
/// are not within a flat face, else the place itself; in scene units.
stp_snap_kind stp_pick_snap(const stp_pick* pick, double reach, stp_vec3d* position);
