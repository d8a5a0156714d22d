// SPDX-License-Identifier: MIT
//
// Parts of plants, the granularity of a purchase list. Makers take the mesh's parameters in the
// order listed here; lengths are metres. Each stands at the origin on y = 0 unless noted.
#pragma once

#include "lab/scenes/assembly.h"

// Details, for use within parts. They lie along y, at the origin.

/// Hexagon bolt with washer, thread and nut: the seat of the head at y = 0, the shank downwards.
void detail_bolt(shaper* s, double diameter, double length);
/// Only the head, where the rest is out of sight.
void detail_hexagon_head(shaper* s, double diameter);
void detail_bolt_ring(shaper* s, double radius, int count, double diameter, double length);
/// Two weld-neck flanges face to face at y = 0, gasket and bolts included.
void detail_flange_pair(shaper* s, double pipe_radius);
/// One flange closed by a blind one.
void detail_blind_flange(shaper* s, double pipe_radius);
/// Gate valve in a pipe along y; its stem and wheel point along x.
void detail_valve(shaper* s, double pipe_radius);
/// Pipe shoe below a pipe along z whose axis is at the origin, standing on a leg of `height`.
void detail_pipe_support(shaper* s, double pipe_radius, double height);
/// Motor with cooling fins, fan cover, terminal box and feet; the shaft along y.
void detail_motor(shaper* s, double radius, double length);
/// A spur gear with bore and key.
void detail_gear(shaper* s, double radius, double width, int teeth);
/// Ball bearing: rings, balls and cage.
void detail_bearing(shaper* s, double bore, double outer, double width);
/// A tube rail on posts from one point to another, with knee rail and toe board.
void detail_railing(shaper* s, stp_vec3d from, stp_vec3d to);
/// A lattice girder between two points: four chords of angle profile and zigzag diagonals.
void detail_lattice(shaper* s, stp_vec3d from, stp_vec3d to, double width, int panels);
/// A gear train with shafts and bearings, in a closed housing.
void detail_gearbox(shaper* s, double width, double height, double depth);

// Piping
void part_pipe_run(shaper* s, const double* p);      ///< radius, x, y, z, height, loops, valves
void part_pipe_rack(shaper* s, const double* p);     ///< length, width, pipes, radius, height
void part_valve_station(shaper* s, const double* p); ///< length, valves, radius
void part_pump_skid(shaper* s, const double* p);     ///< length, pumps, radius

// Steelwork
void part_frame(shaper* s, const double* p); ///< x, y, z, bays x, storeys, bays z, profile height
void part_floor(shaper* s, const double* p); ///< x, z, opening x, opening z (grating)
void part_railings(shaper* s, const double* p);       ///< x, z
void part_stairs(shaper* s, const double* p);         ///< height, storeys
void part_cladding(shaper* s, const double* p);       ///< length, height, pitch, depth
void part_roof_truss(shaper* s, const double* p);     ///< span, length, bays, rise
void part_lattice_bridge(shaper* s, const double* p); ///< length, width, height, rise, panels
void part_lattice_mast(shaper* s, const double* p);   ///< height, width, panels, arms
void part_ladder(shaper* s, const double* p);         ///< height, radius of the wall
void part_slab(shaper* s, const double* p);           ///< x, z, thickness, tiles x, tiles z
void part_fence(shaper* s, const double* p);          ///< x, z, height
void part_box_rows(shaper* s, const double* p);       ///< x, z, columns, rows, width, height, depth

// Drives
void part_motors(shaper* s, const double* p);          ///< count, radius, spacing
void part_gearbox(shaper* s, const double* p);         ///< width, height, depth
void part_fan(shaper* s, const double* p);             ///< radius, width, blades
void part_roller_conveyor(shaper* s, const double* p); ///< length, width, height, pitch
void part_belt_conveyor(shaper* s, const double* p);   ///< length, width, height
void part_chain(shaper* s, const double* p);           ///< length, pitch, strands, wheel radius
void part_crane(shaper* s, const double* p);           ///< span, height

// Electrics
void part_cable_tray(shaper* s, const double* p);    ///< length, width, cables, levels, height
void part_cabinets(shaper* s, const double* p);      ///< count, height
void part_cabinet_wires(shaper* s, const double* p); ///< count, height
void part_transformer(shaper* s, const double* p);   ///< length, height, width
void part_insulators(shaper* s, const double* p); ///< columns, rows, pitch x, pitch z, height, base
void part_wires(shaper* s, const double* p);      ///< length, width, count, height, sag
void part_lamps(shaper* s, const double* p);      ///< x, z, columns, rows, height

// Process equipment
void part_tank(shaper* s, const double* p);           ///< radius, height, nozzles
void part_vessel(shaper* s, const double* p);         ///< radius, length, nozzles, height
void part_heat_exchanger(shaper* s, const double* p); ///< radius, length, tubes
void part_tube_wall(shaper* s, const double* p);      ///< width, height, pitch
void part_tube_bank(shaper* s, const double* p); ///< width, height, columns, rows, passes, radius
void part_turbine_rotor(shaper* s, const double* p);  ///< radius, length, stages, blades
void part_turbine_casing(shaper* s, const double* p); ///< radius, length
void part_generator(shaper* s, const double* p);      ///< radius, length, slots
void part_duct(shaper* s, const double* p);           ///< x, y, z, width, height
void part_hoppers(shaper* s, const double* p);        ///< columns, rows, pitch, height, leg
void part_plates(shaper* s, const double* p);         ///< width, height, depth, plates
void part_cooling_shell(shaper* s, const double* p);  ///< height, base radius, throat radius
void part_cooling_legs(shaper* s, const double* p);   ///< radius, height, legs
void part_cooling_fill(shaper* s, const double* p);   ///< radius, height, pitch
void part_chimney(shaper* s, const double* p);        ///< height, base radius, top radius
void part_mill(shaper* s, const double* p);           ///< radius, height
void part_burners(shaper* s, const double* p);        ///< columns, rows, pitch, radius

// Bakery lines

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

// Car factory

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
