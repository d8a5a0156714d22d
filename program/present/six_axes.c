// SPDX-License-Identifier: MIT
#include "program/present/navigate.h"

#include <math.h>

// At full deflection, per second.
static const double held_move = 0.6; // heights of the picture, and the logarithm of the distance
static const double turn = 1.8;      // radians

/// Turns of the picture: to the right, down, and clockwise. Radians.
typedef struct picture_turns {
    double right, down, clockwise;
} picture_turns;

/// The roll, or 0 if another deflection is as large.
static double deliberate_roll(const stp_six_axes* axes)
{
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        largest = fmax(largest, fabs(axes->moves[i]));
        largest = i < 2 ? fmax(largest, fabs(axes->turns[i])) : largest;
    }
    return fabs(axes->turns[2]) > largest ? axes->turns[2] : 0.0;
}

/// How the cap turns in the picture of a camera, whose own roll tilts azimuth and elevation.
static picture_turns turns_of(const stp_navigator* n, const stp_six_axes* axes, double seconds)
{
    double angle = turn * seconds, c = cos(n->roll), s = sin(n->roll);
    double right = axes->turns[1] * angle, down = axes->turns[0] * angle;
    return (picture_turns){right * c - down * s, right * s + down * c,
                           deliberate_roll(axes) * angle};
}

void stp_navigator_fly_six(stp_navigator* n, const stp_six_axes* axes, double seconds)
{
    picture_turns turns = turns_of(n, axes, seconds);
    stp_navigator_fly(n, axes->moves, seconds, 1.0);
    stp_navigator_turn(n, -turns.right, -turns.down);
    n->roll = remainder(n->roll + turns.clockwise, 2.0 * STP_PI);
}

void stp_navigator_hold_six(stp_navigator* n, const stp_six_axes* axes, double seconds)
{
    double x, y, depth, step = held_move * n->speed * seconds;
    bool before = stp_navigator_project(n, n->pivot, &x, &y, &depth);
    double height = (double)n->height;
    picture_turns turns = turns_of(n, axes, seconds);
    stp_navigator_orbit_by(n, turns.right, turns.down, turns.clockwise);
    stp_navigator_pan(n, axes->moves[0] * step * height, -axes->moves[1] * step * height,
                      before ? fmax(depth, n->min_reach) : n->reach);
    stp_navigator_zoom(n, n->pivot, exp(axes->moves[2] * step));
}
