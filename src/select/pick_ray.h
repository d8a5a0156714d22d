// SPDX-License-Identifier: MIT
//
// Finds the first original triangle or point that a ray hits, whichever level the picture shows.
// Traverses boxes from the root, nearest first. Cut-out materials below their alpha cutoff, and
// transparent ones with alpha 0, are not hit.
#pragma once

#include "select/visibility.h"

#include <stipple/view.h>

/// Points origin + t direction, t from `nearest` to `farthest`.
typedef struct stp_ray {
    stp_vec3d origin, direction; ///< unit direction
    double nearest, farthest;
} stp_ray;

/// Ray through a point of a picture (a pixel's centre: column + 0.5, row + 0.5), from the near
/// plane. With two eyes, of the eye whose half contains the point. @return false if the view is
/// invalid, or the point not finite or too far outside
bool stp_ray_of_pixel(const stp_view* view, double x, double y, stp_ray* ray);

/// Width of a pixel at a distance on the ray: base + slope distance, in scene units.
void stp_pixel_width(const stp_view* view, double* base, double* slope);

typedef struct stp_pick_desc {
    stp_ray ray;
    const stp_sections* sections;     ///< optional; geometry they cut away is not hit
    const stp_visibility* visibility; ///< optional; hidden objects are not hit
    bool through_ghosts;              ///< ghosts are not hit either
    /// Backs of single-sided materials (STP_SHADING_FRONT_ONLY) are hit. They are also while there
    /// are sections: what a picture does not show is not hit.
    bool back_faces;
    /// Points (of point sets) are hit within base + slope t of the ray, scene units; both 0: never.
    double point_base, point_slope;
} stp_pick_desc;

enum { STP_PICK_DEPTH = 64 }; ///< maximum stored edges of a path

typedef struct stp_pick {
    bool hit;
    bool incomplete; ///< a mesh or point set on the ray is not resident: there may be a nearer hit
    double distance; ///< t of the ray
    stp_vec3d position; ///< on the ray; for a point, the point's own position
    stp_vec3d normal;   ///< unit, of the triangle's plane, facing the origin of the ray
    stp_store_part part;
    uint32_t element;     ///< triangle (as clusters have them) or point
    stp_vec3d corners[3]; ///< corners of the triangle, scene space; for a point, its position
    bool inner[3];        ///< whether the edge from this corner to the next lies within a flat face
    uint32_t material;    ///< index in the store
    stp_placed_node holder;        ///< node that contains the part
    uint32_t path[STP_PICK_DEPTH]; ///< path from the root: edge (slot) of each node
    uint32_t path_count;           ///< number of edges; above STP_PICK_DEPTH if not all are stored
    uint64_t tests;                ///< boxes, triangles and points tested
} stp_pick;

/// @return STP_OK, whether or not anything is hit; STP_ERROR_ARGUMENT (invalid ray),
/// STP_ERROR_LIMIT (too much geometry on the ray), STP_ERROR_FORMAT (a damaged block),
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_pick_ray(stp_context* context, stp_store* store,
                                     const stp_pick_desc* desc, stp_pick* pick);

typedef enum stp_snap_kind { STP_SNAP_NONE, STP_SNAP_VERTEX, STP_SNAP_EDGE } stp_snap_kind;

/// Snap target of a pick: the triangle's nearest corner, else the nearest point on its edges that
/// are not within a flat face, if within `reach` of the hit; else the hit itself. In scene units.
stp_snap_kind stp_pick_snap(const stp_pick* pick, double reach, stp_vec3d* position);
