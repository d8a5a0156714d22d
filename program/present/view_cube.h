// SPDX-License-Identifier: MIT
//
// The orientation cube in a corner of the picture: where its sides are drawn and which one a click
// hits. Pure arithmetic: no window.
//
// Coordinates are relative to the cube's centre, in half edges, x to the right and y down. Each
// side has a handle at the end of its axis, so sides that face away can be clicked too, unless the
// cube or a nearer handle covers them. In that case two clicks do: one on the opposite side, and
// another once the camera looks straight at it.
#pragma once

#include "program/present/navigate.h"

enum { STP_VIEW_CUBE_SIDES = 6 };

/// Distance from the centre to the farthest part of the cube, handles included.
#define STP_VIEW_CUBE_REACH 2.9
#define STP_VIEW_CUBE_HANDLE 0.42 ///< radius of a handle

typedef struct stp_view_cube_side {
    const char* view; ///< standard view of this side: "front", "left", ...
    int axis;         ///< 0..2 of the scene (y up)
    bool positive;    ///< the side in the positive direction of the axis
    double facing;    ///< cosine between its normal and the direction to the viewer
    bool visible;     ///< its face is drawn and can be clicked
    /// Its handle is drawn and can be clicked; before the faces where `facing` is positive
    bool has_handle;
    double center[2];     ///< centre of the face
    double corners[4][2]; ///< corners of the face, in order around it
    double handle[2];     ///< centre of the handle
} stp_view_cube_side;

typedef struct stp_view_cube {
    stp_view_cube_side sides[STP_VIEW_CUBE_SIDES];
} stp_view_cube;

void stp_view_cube_make(const stp_navigator_axes* axes, stp_view_cube* cube);

/// The side at a position: the last one drawn is hit first. @return its index; -1 if there is none
int stp_view_cube_hit(const stp_view_cube* cube, double x, double y);

/// The view for a click on a side: the side's own, or the opposite one if the camera already looks
/// straight at it.
const char* stp_view_cube_target(const stp_view_cube* cube, int side);
