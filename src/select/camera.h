// SPDX-License-Identifier: MIT
// Standard views: front, right, top, iso, ... framing a box or the content of a scene.
#pragma once

#include "select/farthest.h"

#include <stipple/view.h>

/// Margin on each side of what is framed, as a share of the picture's width or height.
#define STP_CAMERA_MARGIN 0.04

/// Vertical field of view of views that are chosen automatically, degrees.
#define STP_CAMERA_FOV 40.0
/// Vertical field of view of cameras that are placed without one, degrees.
#define STP_CAMERA_PLACED_FOV 60.0

/// Names of the standard views, NULL-terminated: front back left right top bottom iso, and the 26
/// directions "d0".."d25", which are as far as possible from those of the capture.
const char* const* stp_camera_names(void);
bool stp_camera_is_standard(const char* name);

/// Turns a view to a standard direction: sets eye and target, one unit apart, and up. Does not place
/// it. A fov of 0 becomes STP_CAMERA_FOV. @return false if no standard view has that name
bool stp_camera_face(const char* name, stp_view* view);

/// Sets eye, target and up of `view` to a standard view that fits the box (see stp_camera_face and
/// stp_camera_fit).
/// @return false if no standard view has that name
bool stp_camera_frame(const char* name, const stp_boxd* box, stp_view* view);

/// Moves the eye, without turning it, to the nearest position from which every corner of the box,
/// clipped by the view's sections, lies in the picture with a margin of STP_CAMERA_MARGIN. At least
/// two opposite sides of that frame are touched; along the other axis the margins are equal. In
/// parallel projection the height changes too.
///
/// Reads the directions, fov, width, height, eye_distance, ortho_height and sections. The target
/// becomes the point on the view axis closest to the centre of the box. An empty box is replaced by
/// a cube of side 2. If the sections clip the whole box, or are invalid, they are ignored.
void stp_camera_fit(stp_view* view, const stp_boxd* box);

/// As stp_camera_fit, but fits what the graph contains, not the corners of its bounds. If memory
/// runs out, the bounds are fitted.
void stp_camera_fit_content(stp_context* context, const stp_farthest_graph* graph, stp_view* view);
/// The same for the visible content of a file; `placed`: for this object only, or NULL.
void stp_camera_fit_store(const stp_farthest_store* content, const stp_placed_node* placed,
                          stp_view* view);
