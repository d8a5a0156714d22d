// SPDX-License-Identifier: MIT
//
// A camera that a person moves: around a pivot, towards the cursor, or in flight. Plain data and arithmetic: no window, no
// clock. All of it in doubles and relative to what is looked at, so that nothing trembles far from the origin.
//
// Directions are kept as angles, so that up stays up: azimuth 0 and elevation 0 look from the front (from +z), elevation of
// a quarter turn looks down with -z up in the picture, as standard views do (present/camera.h).
#pragma once

#include "base/math.h"

#include <stipple/view.h>

typedef struct stp_navigator {
    stp_vec3d eye;
    double azimuth, elevation, roll; ///< radians; elevation within a quarter turn
    double fov_degrees;              ///< vertical
    double ortho_height;             ///< of the picture; parallel projection where above 0
    double reach;                    ///< distance to what is seen: it scales speeds
    stp_vec3d pivot;                 ///< what orbits turn about
    bool pivot_chosen;               ///< by somebody: it stays where it is
    double speed;                    ///< of flight, times what follows from `reach`; 1 at first
    double least_reach, most_reach;
    uint32_t width, height; ///< pixels
} stp_navigator;

/// The axes of a camera.
typedef struct stp_navigator_axes {
    stp_vec3d right, up, back; ///< unit; `back` from what is seen to the eye
} stp_navigator_axes;

/// Looks from the direction of "iso" at the whole box, which also says what is far and what is near.
void stp_navigator_init(stp_navigator* n, const stp_boxd* scene, uint32_t width, uint32_t height);

/// Takes a view's place, direction and projection. Its target becomes the pivot.
void stp_navigator_take(stp_navigator* n, const stp_view* view);
/// Sets place, direction, projection and size; the rest stays as it is.
void stp_navigator_give(const stp_navigator* n, stp_view* view);

stp_navigator_axes stp_navigator_get_axes(const stp_navigator* n);
/// Side of a pixel at a depth along the gaze.
double stp_navigator_pixel(const stp_navigator* n, double depth);
/// The point at a depth along the gaze that a place of the picture shows (pixels, y down).
stp_vec3d stp_navigator_point(const stp_navigator* n, double x, double y, double depth);
/// Where a point is shown, and its depth. @return false where it is not before the eye
bool stp_navigator_project(const stp_navigator* n, stp_vec3d point, double* x, double* y,
                           double* depth);

/// Turns around the pivot, which stays where it is in the picture. Pixels that the hand moved; the picture's height is half
/// a turn.
void stp_navigator_orbit(stp_navigator* n, double dx, double dy);
/// What an orbit that begins at a point of a surface turns about, where nobody chose: the point, except where the pivot is
/// in the picture and about as far.
void stp_navigator_begin_orbit(stp_navigator* n, const stp_vec3d* seen);
void stp_navigator_choose_pivot(stp_navigator* n, stp_vec3d pivot);

/// Turns the head. Radians, to the right and down.
void stp_navigator_look(stp_navigator* n, double right, double down);
/// Moves sideways, so that a point at `depth` follows the hand.
void stp_navigator_pan(stp_navigator* n, double dx, double dy, double depth);
/// Comes nearer to a point (factor below 1) or goes away from it; it stays where it is in the picture.
void stp_navigator_zoom(stp_navigator* n, stp_vec3d point, double factor);
/// Flies for some time: right, up (the world's) and forward, each from -1 to 1. Times `faster`.
void stp_navigator_fly(stp_navigator* n, const double move[3], double seconds, double faster);
/// Takes in how far what is seen is, soon but not at once. Not above 0: nothing is.
void stp_navigator_see(stp_navigator* n, double distance, double seconds);
void stp_navigator_change_speed(stp_navigator* n, double steps);

/// Moves, without turning, to where what `sections` (NULL: none) leave of a box fits the picture (stp_camera_fit). The
/// pivot becomes the middle of the box.
void stp_navigator_frame(stp_navigator* n, const stp_boxd* box, const stp_sections* sections);
/// Turns to a standard view ("front", "iso", ...) and frames the box. @return false if no standard view has that name
bool stp_navigator_face(stp_navigator* n, const char* name, const stp_boxd* box,
                        const stp_sections* sections);
/// Between perspective and parallel projection: what is at the pivot's depth keeps its size.
void stp_navigator_switch_projection(stp_navigator* n);

/// From one camera to another, part 0..1 of the way.
stp_navigator stp_navigator_mix(const stp_navigator* from, const stp_navigator* to, double part);
