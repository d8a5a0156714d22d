// SPDX-License-Identifier: MIT
//
// Boilers, turbines, ducts and mills.
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

void part_tube_wall(shaper* s, const double* p)
{
    int tubes = shaper_amount(s, (int)(p[0] / p[2])), sides = shaper_sides(s, 12, 4);
    double step = p[0] / tubes;
    for (int i = 0; i < tubes; ++i) {
        double x = p[0] * ((i + 0.5) / tubes - 0.5), out = i % 7 == 3 ? 0.25 : 0.0;
        stp_vec3d path[6] = {
            {x, 0, 0},           {x, 0.3 * p[1], 0}, {x, 0.34 * p[1], out}, {x, 0.4 * p[1], out},
            {x, 0.44 * p[1], 0}, {x, p[1], 0}};
        shape_tube(s, path, 6, 0.36 * step, sides, SHAPE_OPEN);
        shape_box(s, x + 0.5 * step, 0.5 * p[1], 0, 0.3 * step, p[1], 0.006);
    }
    int stays = shaper_amount(s, (int)(p[1] / 2.5)); // buckstays
    for (int i = 0; i < stays; ++i) {
        double y = p[1] * (i + 0.5) / stays;
        shape_beam(s, PROFILE_I, vec3d(-0.5 * p[0], y, -0.35), vec3d(0.5 * p[0], y, -0.35), 0.4,
                   0.25, 0.015);
        int clips = shaper_amount(s, 20);
        for (int k = 0; k < clips; ++k) {
            stp_affine at = shaper_push(
                s, place_along(vec3d(p[0] * ((k + 0.5) / clips - 0.5), y, -0.15), vec3d(0, 0, -1)));
            shape_box(s, 0, 0, 0, 0.1, 0.2, 0.02);
            detail_hexagon_head(s, 0.024);
            shaper_pop(s, at);
        }
    }
    for (int end = 0; end < 2; ++end) {
        shape_straight(s, vec3d(-0.5 * p[0], end * p[1], 0), vec3d(0.5 * p[0], end * p[1], 0), 0.16,
                       shaper_sides(s, 28, 6));
    }
}

void part_tube_bank(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[2]), rows = shaper_amount(s, (int)p[3]),
        passes = (int)p[4];
    double h = p[1], r = p[5], pitch = p[0] / columns, deep = 4.0 * r;
    int sides = shaper_sides(s, 10, 4), bend = shaper_sides(s, 5, 2);
    for (int i = 0; i < columns; ++i) {
        double x = p[0] * ((i + 0.5) / columns - 0.5);
        for (int row = 0; row < rows; ++row) {
            stp_vec3d corner[40], path[240];
            int n = 0;
            for (int pass = 0; pass < passes && n + 2 < 40; ++pass) {
                double z = deep * (pass * rows + row), low = 0.1 * h + 1.2 * r * row, high = h;
                corner[n++] = vec3d(x, pass & 1 ? low : high, z);
                corner[n++] = vec3d(x, pass & 1 ? high : low, z);
            }
            n = shape_round_path(corner, n, 1.6 * r, bend, path, 240);
            shape_tube(s, path, n, r, sides, SHAPE_OPEN);
        }
        shape_bar(s, vec3d(x + 0.5 * pitch, 0.6 * h, 0),
                  vec3d(x + 0.5 * pitch, 0.6 * h, deep * passes * rows), 0.05, 0.008);
    }
    shape_straight(s, vec3d(-0.5 * p[0], h, 0), vec3d(0.5 * p[0], h, 0), 0.2,
                   shaper_sides(s, 28, 6));
    shape_straight(s, vec3d(-0.5 * p[0], h, deep * passes * rows),
                   vec3d(0.5 * p[0], h, deep * passes * rows), 0.2, shaper_sides(s, 28, 6));
}

// A blade: a twisted profile of five points over the height, both sides.
static stp_vec3d blade_surface(double u, double v, const void* user)
{
    const double* p = user; // root, tip, chord, twist
    double r = p[0] + (p[1] - p[0]) * v, turn = p[3] * v;
    double a = (u - 0.5) * p[2], bow = 0.35 * p[2] * (0.25 - (u - 0.5) * (u - 0.5)) * 4.0;
    double c = turn_cosine(0.08 + turn), d = turn_sine(0.08 + turn);
    return vec3d(r, a * c - bow * d, a * d + bow * c);
}

void part_turbine_rotor(shaper* s, const double* p)
{
    double r = p[0], length = p[1];
    int stages = shaper_amount(s, (int)p[2]);
    stp_affine before = shaper_push(s, place_along(vec3d(-0.5 * length, 0, 0), vec3d(1, 0, 0)));
    double shaft[8][2] = {{0, -0.15 * length},       {0.18 * r, -0.15 * length}, {0.18 * r, 0},
                          {0.34 * r, 0.05 * length}, {0.34 * r, 0.95 * length},  {0.18 * r, length},
                          {0.18 * r, 1.15 * length}, {0, 1.15 * length}};
    shape_lathe(s, (const double(*)[2])shaft, 8, shaper_sides(s, 48, 8));
    int columns = shaper_sides(s, 5, 2), rows = shaper_sides(s, 5, 1);
    for (int stage = 0; stage < stages; ++stage) {
        double t = (stage + 0.5) / stages, grow = 0.45 + 0.55 * (t < 0.5 ? 1 - 2 * t : 2 * t - 1);
        double tip = r * grow, root = 0.36 * r, chord = 0.45 * length / stages;
        stp_affine disc = shaper_move(s, 0, length * (0.06 + 0.88 * t), 0);
        shape_ring_solid(s, 0.33 * r, root + 0.01, 0.9 * chord, shaper_sides(s, 48, 8));
        shaper_move(s, 0, 0.45 * chord, 0);
        double blade[4] = {root, tip, chord, 0.08};
        int blades = shaper_amount(s, (int)p[3]);
        for (int i = 0; i < blades; ++i) {
            stp_affine at = shaper_push(s, place_by_turn(0, 0, 0, (double)i / blades));
            shape_sheet(s, blade_surface, blade, columns, rows, 0.004 + 0.1 * chord);
            shaper_pop(s, at);
        }
        shaper_pop(s, disc);
    }
    for (int end = 0; end < 2; ++end) {
        stp_affine at = shaper_move(s, 0, end ? 1.05 * length : -0.09 * length, 0);
        detail_bearing(s, 0.18 * r, 0.34 * r, 0.04 * length);
        shaper_pop(s, at);
    }
    shaper_move(s, 0, 1.15 * length, 0);
    detail_flange_pair(s, 0.2 * r);
    shaper_pop(s, before);
}

void part_turbine_casing(shaper* s, const double* p)
{
    double r = p[0], length = p[1], profile[48][2];
    int n = 0, rows = 14, sides = shaper_sides(s, 72, 12);
    for (int side = 0; side < 2; ++side) {
        for (int i = 0; i <= rows; ++i, ++n) {
            double t = (double)(side ? rows - i : i) / rows, middle = 2.0 * t - 1.0;
            double out = r * (0.55 + 0.55 * middle * middle);
            out = i == (side ? rows : 0) || i == (side ? 0 : rows) ? 0.3 * r : out;
            profile[n][0] = out - (side ? 0.06 * r : 0.0);
            profile[n][1] = length * t + (side ? (t < 0.5 ? 0.05 : -0.05) * r : 0.0);
        }
    }
    stp_affine before = shaper_push(s, place_along(vec3d(-0.5 * length, 0, 0), vec3d(1, 0, 0)));
    shape_lathe(s, (const double(*)[2])profile, n, sides);
    shaper_pop(s, before);
    for (int side = -1; side <= 1; side += 2) { // the horizontal joint with its bolts
        shape_box(s, 0, 0, side * 0.95 * r, 0.96 * length, 0.2, 0.5 * r);
        int bolts = shaper_amount(s, (int)(length / 0.16));
        for (int i = 0; i < bolts; ++i) {
            stp_affine at =
                shaper_move(s, 0.94 * length * ((i + 0.5) / bolts - 0.5), 0.1, side * 1.08 * r);
            detail_bolt(s, 0.07, 0.3);
            shaper_pop(s, at);
        }
    }
    for (int i = 0; i < 6; ++i) { // steam pipes out of the upper half
        double x = length * ((i + 0.5) / 6 - 0.5);
        stp_vec3d corner[3] = {{x, 0.5 * r, 0},
                               {x, 1.5 * r, 0},
                               {x, 1.5 * r, (i & 1 ? 2.2 : -2.2) * r}},
                  path[40];
        int count = shape_round_path(corner, 3, 0.3 * r, shaper_sides(s, 8, 2), path, 40);
        shape_tube(s, path, count, 0.14 * r, shaper_sides(s, 28, 6), SHAPE_OPEN);
        stp_affine at = shaper_move(s, x, 1.1 * r, 0);
        detail_flange_pair(s, 0.14 * r);
        shaper_pop(s, at);
    }
    shape_box(s, 0, -1.1 * r, 0, 0.8 * length, 1.2 * r, 1.4 * r);
}

void part_generator(shaper* s, const double* p)
{
    double r = p[0], length = p[1];
    int slots = shaper_amount(s, (int)p[2]), bars = shaper_sides(s, 8, 3);
    stp_affine before = shaper_push(s, place_along(vec3d(-0.5 * length, 0, 0), vec3d(1, 0, 0)));
    int plates = shaper_amount(s, 60);
    for (int i = 0; i < plates; ++i) { // laminations of the stator
        stp_affine at = shaper_move(s, 0, length * (0.1 + 0.8 * i / plates), 0);
        shape_ring_solid(s, 0.55 * r, 0.9 * r, 0.7 * length / plates, shaper_sides(s, 48, 8));
        shaper_pop(s, at);
    }
    for (int i = 0; i < slots; ++i) { // windings with their end turns
        double a = (double)i / slots, b = a + 0.18;
        stp_vec3d path[9];
        for (int k = 0; k < 9; ++k) {
            double t = k < 3 ? a : k > 5 ? b : a + (b - a) * (k - 2) / 4.0;
            double y = k < 3 ? 0.05 + 0.4 * k : k > 5 ? 0.85 - 0.4 * (k - 6) : 0.98;
            double out = (k > 2 && k < 6 ? 0.75 : 0.58) * r;
            path[k] = vec3d(out * turn_cosine(t), length * y, out * turn_sine(t));
        }
        shape_tube(s, path, 9, 0.018 * r, bars, SHAPE_CAPPED);
    }
    shape_cylinder(s, 0.5 * r, length, shaper_sides(s, 48, 8)); // the rotor
    shape_ring_solid(s, 0.92 * r, r, length, shaper_sides(s, 64, 10));
    for (int end = 0; end < 2; ++end) {
        stp_affine at = shaper_move(s, 0, end ? length : -0.05, 0);
        shape_ring_solid(s, 0.3 * r, 1.05 * r, 0.06, shaper_sides(s, 64, 10));
        shaper_move(s, 0, 0.06, 0);
        detail_bolt_ring(s, 0.98 * r, 48, 0.04, 0.12);
        detail_bearing(s, 0.2 * r, 0.3 * r, 0.2);
        shaper_pop(s, at);
    }
    shaper_pop(s, before);
    shape_box(s, 0, -0.9 * r, 0, length, 0.5 * r, 1.9 * r);
    int ribs = shaper_amount(s, 14);
    for (int i = 0; i < ribs; ++i) {
        before = shaper_push(
            s, place_along(vec3d(length * ((i + 0.5) / ribs - 0.5), 0, 0), vec3d(1, 0, 0)));
        shape_ring_solid(s, r, 1.06 * r, 0.03, shaper_sides(s, 64, 10));
        shaper_pop(s, before);
    }
}

// A rectangular duct between two points, of plates with stiffeners and flanges.
static void duct(shaper* s, stp_vec3d from, stp_vec3d to, double w, double h)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way)), t = 0.006;
    stp_affine before = shaper_push(s, place_along(from, way));
    for (int side = -1; side <= 1; side += 2) {
        shape_box(s, side * 0.5 * h, 0.5 * length, 0, t, length, w);
        shape_box(s, 0, 0.5 * length, side * 0.5 * w, h, length, t);
    }
    int ribs = shaper_amount(s, 1 + (int)(length / 0.8)), bolts = shaper_amount(s, 16);
    for (int i = 0; i <= ribs; ++i) {
        double y = length * i / ribs;
        for (int side = -1; side <= 1; side += 2) {
            shape_beam(s, PROFILE_L, vec3d(side * (0.5 * h + 0.04), y, -0.5 * w),
                       vec3d(side * (0.5 * h + 0.04), y, 0.5 * w), 0.08, 0.08, 0.006);
            shape_beam(s, PROFILE_L, vec3d(-0.5 * h, y, side * (0.5 * w + 0.04)),
                       vec3d(0.5 * h, y, side * (0.5 * w + 0.04)), 0.08, 0.08, 0.006);
            for (int k = 0; i % 4 == 0 && k < bolts; ++k) {
                stp_affine at = shaper_move(s, side * (0.5 * h + 0.05), y + 0.006,
                                            w * ((k + 0.5) / bolts - 0.5));
                detail_hexagon_head(s, 0.016);
                shaper_pop(s, at);
            }
        }
    }
    shaper_pop(s, before);
}

void part_duct(shaper* s, const double* p)
{
    stp_vec3d corner = vec3d(p[0], 0, 0), up = vec3d(p[0], p[1], 0), end = vec3d(p[0], p[1], p[2]);
    duct(s, vec3d(0, 0, 0), corner, p[3], p[4]);
    if (p[1] != 0.0) {
        duct(s, corner, up, p[3], p[4]);
    }
    if (p[2] != 0.0) {
        duct(s, up, end, p[3], p[4]);
    }
}

static stp_vec3d hopper_side(double u, double v, const void* user)
{
    const double* p = user; // half width above, half width below, height
    double half = p[1] + (p[0] - p[1]) * v;
    return vec3d((2.0 * u - 1.0) * half, p[2] * v, half);
}

void part_hoppers(shaper* s, const double* p)
{
    int columns = (int)p[0], rows = (int)p[1];
    double pitch = p[2], h = p[3], leg = p[4], side[3] = {0.49 * pitch, 0.12 * pitch, h};
    for (int i = 0; i < columns * rows; ++i) {
        double x = (i % columns - 0.5 * (columns - 1)) * pitch,
               z = (i / columns - 0.5 * (rows - 1)) * pitch;
        stp_affine at = shaper_move(s, x, leg, z);
        for (int face = 0; face < 4; ++face) {
            stp_affine turn = shaper_push(s, place_by_turn(0, 0, 0, 0.25 * face));
            shape_sheet(s, hopper_side, side, shaper_sides(s, 4, 1), shaper_sides(s, 6, 1), 0.008);
            int ribs = shaper_amount(s, 6);
            for (int k = 0; k < ribs; ++k) {
                double v = (k + 0.5) / ribs, half = side[1] + (side[0] - side[1]) * v;
                shape_beam(s, PROFILE_L, vec3d(-half, h * v, half + 0.04),
                           vec3d(half, h * v, half + 0.04), 0.08, 0.08, 0.006);
            }
            shaper_pop(s, turn);
        }
        shape_ring_solid(s, 0.1 * pitch, 0.17 * pitch, 0.04, shaper_sides(s, 32, 6));
        detail_bolt_ring(s, 0.15 * pitch, 16, 0.02, 0.06);
        shaper_push(s, place_along(vec3d(0, -0.3, -0.2), vec3d(0, 0, 1)));
        detail_motor(s, 0.12, 0.4);
        shaper_pop(s, at);
        shape_beam(s, PROFILE_I, vec3d(x + 0.5 * pitch, 0, z + 0.5 * pitch),
                   vec3d(x + 0.5 * pitch, leg + h, z + 0.5 * pitch), 0.25, 0.25, 0.015);
    }
}

void part_plates(shaper* s, const double* p)
{
    int plates = shaper_amount(s, (int)p[3]);
    for (int i = 0; i < plates; ++i) { // collecting plates, and discharge wires between them
        double z = p[2] * ((i + 0.5) / plates - 0.5), wave[4] = {p[0], p[1], 0.5, 0.04};
        stp_affine at = shaper_move(s, 0, 0, z);
        part_cladding(s, wave);
        shaper_pop(s, at);
        int wires = shaper_amount(s, (int)(p[0] / 0.2)), sides = shaper_sides(s, 6, 3);
        for (int k = 0; k < wires; ++k) {
            double x = p[0] * ((k + 0.5) / wires - 0.5), mid = z + 0.5 * p[2] / plates;
            shape_straight(s, vec3d(x, 0, mid), vec3d(x, p[1], mid), 0.0015, sides);
        }
    }
}

void part_mill(shaper* s, const double* p)
{
    double r = p[0], h = p[1];
    double body[10][2] = {{0, 0},       {1.2 * r, 0},        {1.2 * r, 0.1 * h},  {r, 0.12 * h},
                          {r, 0.6 * h}, {0.9 * r, 0.75 * h}, {0.45 * r, 0.9 * h}, {0.4 * r, h},
                          {0.3 * r, h}, {0.3 * r, 0.9 * h}};
    shape_lathe(s, (const double(*)[2])body, 10, shaper_sides(s, 64, 10));
    detail_bolt_ring(s, 1.1 * r, 36, 0.05, 0.2);
    for (int i = 0; i < 3; ++i) { // rollers with their springs, within and through the housing
        stp_affine at = shaper_push(s, place_by_turn(0, 0.3 * h, 0, i / 3.0));
        stp_affine roller = shaper_push(s, place_along(vec3d(0.3 * r, 0, 0), vec3d(1, 0.3, 0)));
        shape_cylinder(s, 0.3 * r, 0.35 * r, shaper_sides(s, 40, 8));
        detail_bearing(s, 0.1 * r, 0.25 * r, 0.3 * r);
        shaper_pop(s, roller);
        shaper_push(s, place_along(vec3d(0.95 * r, 0.1 * h, 0), vec3d(1, 0, 0)));
        detail_flange_pair(s, 0.3 * r);
        shape_coil(s, 0.15 * r, 0.03 * r, 0.07 * r, shaper_amount(s, 9), shaper_sides(s, 24, 6),
                   shaper_sides(s, 10, 4));
        shaper_pop(s, at);
    }
    stp_affine gear = shaper_move(s, 0, 0.05 * h, 0);
    detail_gear(s, 0.9 * r, 0.06 * h, 110);
    shaper_pop(s, gear);
    gear = shaper_push(s, place_along(vec3d(1.9 * r, 0.15 * h, 0), vec3d(1, 0, 0)));
    detail_motor(s, 0.45 * r, 1.3 * r);
    shaper_pop(s, gear);
    gear = shaper_move(s, 1.45 * r, 0, 0);
    detail_gearbox(s, 0.7 * r, 0.3 * h, 0.8 * r);
    shaper_pop(s, gear);
    for (int i = 0; i < 4; ++i) {
        double c = turn_cosine(i / 4.0 + 0.125), d = turn_sine(i / 4.0 + 0.125);
        shape_straight(s, vec3d(0.35 * r * c, 0.85 * h, 0.35 * r * d),
                       vec3d(0.6 * r * c, 1.6 * h, 0.6 * r * d), 0.12 * r, shaper_sides(s, 24, 6));
    }
}

void part_burners(shaper* s, const double* p)
{
    int columns = (int)p[0], rows = (int)p[1];
    double r = p[3];
    for (int i = 0; i < columns * rows; ++i) {
        double x = (i % columns - 0.5 * (columns - 1)) * p[2], y = (i / columns) * p[2];
        stp_affine at = shaper_push(s, place_along(vec3d(x, y, 0), vec3d(0, 0, -1)));
        double throat[8][2] = {{0.9 * r, -0.6}, {1.2 * r, -0.6}, {1.2 * r, 0.8},  {0.7 * r, 1.4},
                               {0.5 * r, 1.4},  {0.5 * r, 2.0},  {0.45 * r, 2.0}, {0.45 * r, -0.4}};
        shape_lathe(s, (const double(*)[2])throat, 8, shaper_sides(s, 40, 8));
        int vanes = shaper_amount(s, 18);
        for (int k = 0; k < vanes; ++k) {
            stp_affine vane = shaper_push(s, place_by_turn(0, 0, 0, (double)k / vanes));
            shape_box(s, 0.8 * r, 0.1, 0, 0.5 * r, 0.4, 0.004);
            shaper_pop(s, vane);
        }
        shaper_move(s, 0, 0.8, 0);
        detail_bolt_ring(s, 1.1 * r, 20, 0.024, 0.06);
        shaper_move(s, 0, 1.2, 0);
        detail_flange_pair(s, 0.45 * r);
        shaper_pop(s, at);
        stp_vec3d corner[3] = {{x, y, -2.2}, {x, y, -2.8}, {x, y - 2.0, -2.8}}, path[30];
        int n = shape_round_path(corner, 3, 0.5, shaper_sides(s, 8, 2), path, 30);
        shape_tube(s, path, n, 0.42 * r, shaper_sides(s, 28, 6), SHAPE_OPEN);
    }
}
