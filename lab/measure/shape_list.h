// SPDX-License-Identifier: MIT
// Splats, triangles and points of a file, for measuring distances.
#pragma once

#include "base/math/math.h"
#include "lab/measure/hausdorff.h"
#include "program/files/splat_file.h"
#include "program/options/command.h"
#include "scene/scene.h"
#include "select/select.h"

/// The visible content of a file, along its own axes (tool_own_axes). All zero at first, except the
/// origin.
typedef struct tool_shape_list {
    double origin[3]; ///< to be added to all places
    stp_disk_shape* disks;
    float* positions;  ///< 3 per vertex
    uint32_t* indices; ///< 3 per triangle
    float* points;     ///< 3 per point
    size_t disk_count, vertex_count, triangle_count, point_count;
    /// Capacities in disks, floats, indices and floats
    size_t disk_capacity, position_capacity, index_capacity, point_capacity;
} tool_shape_list;

/// Adds the triangles and points of a scene. @return STP_OK, or a failure that was logged
STP_MUST_USE stp_result tool_shapes_add_scene(tool_shape_list* list, const stp_scene* scene);

/// Adds everything that a file shows, independent of a view: the number of splats of the quality
/// (0: all) by its method, or for a reference the triangles and points.
STP_MUST_USE stp_result tool_shapes_add_store(stp_context* context, tool_shape_list* list,
                                              stp_store* store, const stp_quality* quality);

/// Adds splats of a file.
STP_MUST_USE stp_result tool_shapes_add_splats(stp_context* context, tool_shape_list* list,
                                               const tool_splat_set* splats);

/// Makes disks of zero size from the points.
STP_MUST_USE stp_result tool_shapes_draw_points(stp_context* context, tool_shape_list* list);

/// The bounding box of all triangles and points, without the origin; empty if there are none.
stp_boxd tool_shapes_bounds(const tool_shape_list* list);
stp_shapes tool_shapes_drawn(const tool_shape_list* list);
stp_measured_surface tool_shapes_surface(const tool_shape_list* list);
void tool_shapes_destroy(stp_context* context, tool_shape_list* list);
