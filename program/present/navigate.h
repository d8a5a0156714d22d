// SPDX-License-Identifier: MIT
//
// Arithmetic of the viewer's navigation, without a window or a clock: an interactive camera that
// orbits, zooms to the cursor and flies; dragged planes; the scale bar. Everything is in doubles,
// so nothing jitters far from the origin.
//
// Directions are stored as angles, so up stays up. Azimuth 0 and elevation 0 look from the front
// (from +z); an elevation of a quarter turn looks down with -z up in the picture, as in the
// standard views (select/camera.h).
#pragma once

#include "select/farthest.h"

#include <stipple/view.h>

typedef struct stp_navigator {
    stp_vec3d eye;
    double azimuth, elevation, roll; ///< radians; elevation within a quarter turn
    double fov_degrees;              ///< vertical
    double ortho_height;         ///< picture height in scene units; above 0: parallel projection
    double reach;                ///< distance to the visible surface: it scales speeds
    stp_vec3d pivot;             ///< centre of orbits
    bool pivot_chosen;           ///< the user chose it: it stays
    double speed;                ///< flight speed factor; initially 1
    double min_reach, max_reach; ///< limits of `reach` and `ortho_height`
    uint32_t width, height;      ///< pixels
} stp_navigator;

/// The axes of a camera.
typedef struct stp_navigator_axes {
    stp_vec3d right, up, back; ///< unit; `back` points towards the viewer
} stp_navigator_axes;

/// Looks from the "iso" direction at the whole box, whose size also gives the limits of the reach.
void stp_navigator_init(stp_navigator* n, const stp_boxd* scene, uint32_t width, uint32_t height);

/// Takes position, direction and projection from a view. Its target becomes the pivot.
void stp_navigator_read_view(stp_navigator* n, const stp_view* view);
/// Sets position, direction, projection and size of `view`; the rest is unchanged.
void stp_navigator_write_view(const stp_navigator* n, stp_view* view);

stp_navigator_axes stp_navigator_get_axes(const stp_navigator* n);
/// Size of a pixel at a depth along the view axis.
double stp_navigator_pixel(const stp_navigator* n, double depth);
/// The point at a depth along the view axis that a picture position shows (pixels, y down).
stp_vec3d stp_navigator_point(const stp_navigator* n, double x, double y, double depth);
/// Projects a point, with its depth. @return false if it is not in front of the eye
bool stp_navigator_project(const stp_navigator* n, stp_vec3d point, double* x, double* y,
                           double* depth);

/// Orbits around the pivot, which keeps its place in the picture. Takes the pointer's movement in
/// pixels; the picture's height is half a turn.
void stp_navigator_orbit(stp_navigator* n, double dx, double dy);
/// The same by angles: the content turns right, down and clockwise. Radians.
void stp_navigator_orbit_by(stp_navigator* n, double right, double down, double clockwise);
/// Chooses the centre of an orbit that begins at a surface point (NULL: there is none). A pivot
/// stays if it is in the picture and the user chose it or it has a similar depth. Otherwise it
/// becomes the surface point, or without one, if it is outside, the point in the middle of the
/// picture.
void stp_navigator_begin_orbit(stp_navigator* n, const stp_vec3d* seen);
void stp_navigator_choose_pivot(stp_navigator* n, stp_vec3d pivot);

/// Turns the camera in place. Radians, to the right and down.
void stp_navigator_turn(stp_navigator* n, double right, double down);
/// Pans so that a point at `depth` follows the pointer.
void stp_navigator_pan(stp_navigator* n, double dx, double dy, double depth);
/// Moves towards a point (factor below 1) or away from it; the point keeps its place in the
/// picture.
void stp_navigator_zoom(stp_navigator* n, stp_vec3d point, double factor);
/// Flies for some time: right, up (the world's) and forward, each -1 to 1. `faster`: speed factor.
void stp_navigator_fly(stp_navigator* n, const double move[3], double seconds, double faster);
/// Adapts to the distance of the visible surface, smoothly. `distance` not above 0: nothing is
/// visible.
void stp_navigator_adapt_speed(stp_navigator* n, double distance, double seconds);
void stp_navigator_change_speed(stp_navigator* n, double steps);

/// Moves, without turning, so that the box clipped by `sections` (NULL: none) fits the picture
/// (stp_camera_fit). The pivot becomes the centre of the box.
void stp_navigator_frame(stp_navigator* n, const stp_boxd* box, const stp_sections* sections);
/// The same for the visible content of a file; `placed`: of this object only, or NULL.
void stp_navigator_frame_content(stp_navigator* n, const stp_farthest_store* content,
                                 const stp_placed_node* placed, stp_vec3d pivot,
                                 const stp_sections* sections);
/// Turns to a standard view without moving. @return false if no standard view has that name
bool stp_navigator_turn_to(stp_navigator* n, const char* name);
/// Turns to a standard view ("front", "iso", ...) and frames the box. @return false if no standard
/// view has that name
bool stp_navigator_face(stp_navigator* n, const char* name, const stp_boxd* box,
                        const stp_sections* sections);
/// Switches between perspective and parallel projection: objects at the pivot's depth keep their
/// size.
void stp_navigator_switch_projection(stp_navigator* n);

/// Interpolates between two cameras, `part` 0..1.
stp_navigator stp_navigator_mix(const stp_navigator* from, const stp_navigator* to, double part);

// A device with six axes (a SpaceMouse), of which the hand moves a cap.

/// Deflections of the cap from rest; 1 is far, and a higher sensitivity gives more. Axes point
/// right, up and forward, away from the hand.
typedef struct stp_six_axes {
    double moves[3];
    double turns[3]; ///< about these axes: pitch, front up (the cap leans back); yaw, to the left;
                     ///< roll, clockwise (the cap leans right)
} stp_six_axes;

/// The cap is the camera: it flies (stp_navigator_fly) and turns in place, for some time. A roll
/// counts only if it is the largest deflection, so that a hand does not tilt the horizon by
/// accident.
void stp_navigator_fly_six(stp_navigator* n, const stp_six_axes* axes, double seconds);
/// The cap is the content: it moves, and turns about the pivot. A roll counts as above.
void stp_navigator_hold_six(stp_navigator* n, const stp_six_axes* axes, double seconds);

// Dragging a plane along its normal with the pointer.

enum { STP_PLANE_CORNERS_MAX = 6 };

/// Intersection of a plane and a box: a convex polygon, in order around it. @return the number of
/// its corners; 0: no intersection
int stp_plane_intersect_box(stp_vec3d point, stp_vec3d normal, const stp_boxd* box,
                            stp_vec3d corners[STP_PLANE_CORNERS_MAX]);

/// How far an anchor moves along a unit direction to follow the pointer between two picture
/// positions (pixels, y down). If the camera looks along the direction, moving up moves it away
/// from the viewer. 0 if the anchor is not in front of the eye.
double stp_plane_drag(const stp_navigator* n, stp_vec3d anchor, stp_vec3d direction,
                      const double from[2], const double to[2]);

// Length of a scale bar: a round number that fits the available width.

typedef struct stp_scale_bar {
    double length; ///< 1, 2 or 5 times a power of ten; 0: no bar
    double pixels; ///< its width
} stp_scale_bar;

/// The longest bar of at most `max_pixels`, if a pixel is `pixel` units wide. No bar if either is
/// not positive and finite.
stp_scale_bar stp_scale_bar_make(double pixel, double max_pixels);
