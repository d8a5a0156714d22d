// SPDX-License-Identifier: MIT
// Parts of bakery lines; see parts.h for their parameters.
#pragma once

#include "lab/scenes/assembly.h"

void part_mesh_belt(shaper* s,
                    const double* p);         ///< length, width, height, pitch (wire mesh on rods)
void part_donuts(shaper* s, const double* p); ///< columns, rows, radius, pitch, glazed
void part_tray(shaper* s, const double* p);   ///< columns, rows, pitch
void part_mixer(shaper* s, const double* p);  ///< radius, height
void part_mixer_bowl(shaper* s, const double* p);    ///< radius, height
void part_funnel(shaper* s, const double* p);        ///< width, height, outlet
void part_oven_shell(shaper* s, const double* p);    ///< length, width, height
void part_oven_nozzles(shaper* s, const double* p);  ///< length, width, height, columns, rows
void part_oven_burner(shaper* s, const double* p);   ///< length, burners, height
void part_sheeter(shaper* s, const double* p);       ///< width, rollers, radius
void part_proofer_frame(shaper* s, const double* p); ///< length, width, height
void part_swings(shaper* s, const double* p);        ///< columns, rows, width, pitch
void part_spiral_belt(shaper* s, const double* p);   ///< radius, height, turns, width
void part_spiral_drum(shaper* s, const double* p);   ///< radius, height
void part_guards(shaper* s, const double* p);        ///< length, height (perforated doors)
void part_tray_rack(shaper* s, const double* p);     ///< shelves, width, depth, height
void part_cutter(shaper* s, const double* p);        ///< width, knives
void part_boxes(shaper* s, const double* p);         ///< columns, layers, size
