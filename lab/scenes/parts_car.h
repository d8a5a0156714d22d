// SPDX-License-Identifier: MIT
// Parts of a car factory; see parts.h for their parameters.
#pragma once

#include "lab/scenes/assembly.h"

/// A patch of a car's skin (4.4 m along x, the nose at -2.2): from, to along the car and around it
/// (0: left sill, 0.5: middle of the roof, 1: right sill), offset outwards, columns and rows of
/// faces, ribs behind.
void part_body_panel(shaper* s, const double* p);
void part_underbody(shaper* s, const double* p);   ///< length, width, ribs
void part_wheel(shaper* s, const double* p);       ///< radius, width, spokes
void part_tyre(shaper* s, const double* p);        ///< radius, width, blocks
void part_seats(shaper* s, const double* p);       ///< seats, spacing
void part_engine(shaper* s, const double* p);      ///< cylinders, bore
void part_robot_base(shaper* s, const double* p);  ///< radius, height
void part_robot_arm(shaper* s, const double* p);   ///< length, radius (along x)
void part_robot_wrist(shaper* s, const double* p); ///< length, radius (along x)
void part_weld_gun(shaper* s, const double* p);    ///< size
void part_robot_hoses(shaper* s, const double* p); ///< reach, height, hoses
void part_press_frame(shaper* s, const double* p); ///< width, height, depth
void part_press_drive(shaper* s, const double* p); ///< width, height, depth
void part_die(shaper* s, const double* p);         ///< width, depth, height, columns, rows
void part_jig(shaper* s, const double* p);         ///< length, width, clamps
void part_shelf_rack(shaper* s, const double* p);  ///< length, height, depth, levels
