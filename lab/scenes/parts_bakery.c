// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

// Wire coils across the belt, hooked into each other over cross rods, on sprocket chains.
void part_mesh_belt(shaper* s, const double* p)
{
    enum { MOST_POINTS = 200 };
    double length = p[0], w = p[1], h = p[2], pitch = p[3];
    int rows = shaper_amount(s, (int)(length / pitch)), sides = shaper_sides(s, 5, 3);
    int waves = shaper_amount(s, (int)(w / 0.014));
    waves = waves > MOST_POINTS / 2 - 1 ? MOST_POINTS / 2 - 1 : waves;
    for (int i = 0; i < rows; ++i) {
        double x = length * ((i + 0.5) / rows - 0.5);
        stp_vec3d path[MOST_POINTS];
        for (int k = 0; k <= 2 * waves; ++k) {
            double z = w * (0.5 * k / waves - 0.5), out = (k & 1 ? 0.7 : -0.7) * pitch;
            path[k] = vec3d(x + out, h + (k & 1 ? 0.0015 : -0.0015), z);
        }
        shape_tube(s, path, 2 * waves + 1, 0.0007, sides, SHAPE_CAPPED);
        shape_straight(s, vec3d(x, h, -0.5 * w), vec3d(x, h, 0.5 * w), 0.0014, sides);
    }
    for (int side = -1; side <= 1; side += 2) {
        int links = shaper_amount(s, (int)(length / 0.05));
        for (int i = 0; i < links; ++i) {
            double x = length * ((i + 0.5) / links - 0.5);
            shape_box(s, x, h, side * (0.5 * w + 0.012 + 0.004 * (i & 1)), 0.055, 0.02, 0.003);
        }
        shape_beam(s, PROFILE_L, vec3d(-0.5 * length, h - 0.03, side * (0.5 * w + 0.03)),
                   vec3d(0.5 * length, h - 0.03, side * (0.5 * w + 0.03)), 0.04, 0.04, 0.003);
    }
    int supports = shaper_amount(s, 1 + (int)(length / 0.6));
    for (int i = 0; i < supports; ++i) {
        double x = length * ((i + 0.5) / supports - 0.5);
        shape_straight(s, vec3d(x, h - 0.03, -0.5 * w), vec3d(x, h - 0.03, 0.5 * w), 0.02,
                       shaper_sides(s, 14, 4));
    }
}

void part_donuts(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[0]), rows = shaper_amount(s, (int)p[1]);
    double r = p[2], lift = p[4] > 0.0 ? 0.006 : 0.0, tube = p[4] > 0.0 ? 0.42 : 0.45;
    int sides = shaper_sides(s, 26, 6), tube_sides = shaper_sides(s, 14, 4);
    for (int i = 0; i < columns * rows; ++i) {
        double x = (i % columns - 0.5 * (columns - 1)) * p[3];
        double z = (i / columns - 0.5 * (rows - 1)) * p[3];
        double grow = shaper_between(s, 0.92, 1.04);
        double aside = shaper_between(s, -0.004, 0.004), turns = shaper_random(s);
        stp_affine before = shaper_push(s, place_by_turn(x + aside, 0.45 * r + lift, z, turns));
        shape_torus(s, 0.62 * r * grow, tube * r * grow, sides, tube_sides);
        shaper_pop(s, before);
    }
}

static stp_vec3d tray_surface(double u, double v, const void* user)
{
    const double* p = user; // half length, half width, cells along, cells across
    double edge = u < v ? u : v;
    edge = 1.0 - u < edge ? 1.0 - u : edge;
    edge = 1.0 - v < edge ? 1.0 - v : edge;
    double dent = turn_sine(0.5 * u * p[2]) * turn_sine(0.5 * v * p[3]);
    double y = edge < 0.02 ? 0.025 * (1.0 - edge / 0.02) : -0.006 * dent * dent;
    return vec3d((u - 0.5) * 2.0 * p[0], 0.008 + y, (0.5 - v) * 2.0 * p[1]);
}

void part_tray(shaper* s, const double* p)
{
    double size[4] = {0.5 * p[0] * p[2] + 0.03, 0.5 * p[1] * p[2] + 0.03, p[0], p[1]};
    shape_sheet(s, tray_surface, size, shaper_sides(s, (int)(p[0] * 9), 4),
                shaper_sides(s, (int)(p[1] * 9), 4), 0.0012);
    stp_vec3d rim[5] = {{-size[0], 0.033, -size[1]},
                        {size[0], 0.033, -size[1]},
                        {size[0], 0.033, size[1]},
                        {-size[0], 0.033, size[1]},
                        {-size[0], 0.033, -size[1]}};
    for (int i = 0; i < 4; ++i) {
        shape_straight(s, rim[i], rim[i + 1], 0.003, shaper_sides(s, 8, 3));
    }
    for (int side = -1; side <= 1; side += 2) { // handles
        stp_vec3d corner[4] = {{side * size[0], 0.03, -0.06},
                               {side * (size[0] + 0.04), 0.03, -0.06},
                               {side * (size[0] + 0.04), 0.03, 0.06},
                               {side * size[0], 0.03, 0.06}};
        stp_vec3d path[30];
        int n = shape_round_path(corner, 4, 0.015, shaper_sides(s, 6, 2), path, 30);
        shape_tube(s, path, n, 0.004, shaper_sides(s, 8, 3), SHAPE_CAPPED);
    }
}

void part_mixer_bowl(shaper* s, const double* p)
{
    double r = p[0], h = p[1];
    double bowl[14][2] = {{0, 0.02},
                          {0.7 * r, 0.03},
                          {0.9 * r, 0.1 * h},
                          {0.98 * r, 0.3 * h},
                          {r, 0.6 * h},
                          {r, h},
                          {1.06 * r, h},
                          {1.06 * r, 1.03 * h},
                          {0.99 * r, 1.03 * h},
                          {0.99 * r, 0.6 * h},
                          {0.97 * r, 0.3 * h},
                          {0.89 * r, 0.11 * h},
                          {0.69 * r, 0.045},
                          {0, 0.035}};
    shape_lathe(s, (const double(*)[2])bowl, 14, shaper_sides(s, 72, 10));
    shape_coil(s, 0.5 * r, 0.05 * r, 0.35 * h, shaper_amount(s, 3), shaper_sides(s, 40, 8),
               shaper_sides(s, 14, 4)); // the kneading spiral
    stp_affine under = shaper_move(s, 0, -0.1, 0);
    detail_gear(s, 0.95 * r, 0.06, 110);
    detail_bearing(s, 0.3 * r, 0.5 * r, 0.08);
    shaper_pop(s, under);
    for (int i = 0; i < 4; ++i) {
        stp_affine wheel = shaper_push(
            s, place_along(vec3d((i & 1 ? 0.7 : -0.7) * r, -0.2, (i & 2 ? 0.7 : -0.7) * r),
                           vec3d(0, 0, 1)));
        shape_ring_solid(s, 0.02, 0.1, 0.05, shaper_sides(s, 28, 6));
        detail_bearing(s, 0.02, 0.05, 0.05);
        shaper_pop(s, wheel);
    }
}

void part_mixer(shaper* s, const double* p)
{
    double r = p[0], h = p[1];
    shape_box(s, -1.7 * r, 0.45 * h, 0, 1.0 * r, 0.9 * h, 1.8 * r);
    shape_box(s, -0.7 * r, 0.95 * h, 0, 3.0 * r, 0.28 * h, 1.2 * r);
    shape_box(s, -0.4 * r, 0.05, 0, 3.6 * r, 0.1, 2.2 * r);
    stp_affine head = shaper_move(s, 0, 0.8 * h, 0);
    detail_motor(s, 0.3 * r, 1.0 * r);
    shaper_push(s, place_at(-1.0 * r, 0.02 * h, 0));
    detail_gearbox(s, 0.9 * r, 0.24 * h, 0.9 * r);
    shaper_pop(s, head);
    head = shaper_move(s, -1.7 * r, 0.15 * h, 0);
    detail_gearbox(s, 0.8 * r, 0.4 * h, 1.2 * r);
    shaper_pop(s, head);
    int slots = shaper_amount(s, 40);
    for (int i = 0; i < slots; ++i) { // louvres
        shape_box(s, -2.2 * r, 0.1 * h + 0.7 * h * i / slots, 0, 0.01, 0.006, 1.2 * r);
    }
    for (int i = 0; i < 9; ++i) { // safety guard over the bowl
        stp_vec3d hoop[13];
        for (int k = 0; k <= 12; ++k) {
            double turns = -0.25 + 0.5 * k / 12.0;
            hoop[k] = vec3d(r * (0.2 + 0.1 * i) * turn_cosine(turns), 0.72 * h,
                            r * (0.2 + 0.1 * i) * turn_sine(turns));
        }
        shape_tube(s, hoop, 13, 0.006, shaper_sides(s, 8, 3), SHAPE_CAPPED);
    }
}

static stp_vec3d funnel_side(double u, double v, const void* user)
{
    const double* p = user; // half above, half below, height
    double t = v * v * (3.0 - 2.0 * v), half = p[1] + (p[0] - p[1]) * t;
    return vec3d((2.0 * u - 1.0) * half, p[2] * v, half);
}

void part_funnel(shaper* s, const double* p)
{
    double side[3] = {0.5 * p[0], 0.5 * p[2], p[1]};
    stp_affine up = shaper_move(s, 0, 1.3, 0);
    for (int face = 0; face < 4; ++face) {
        stp_affine turn = shaper_push(s, place_by_turn(0, 0, 0, 0.25 * face));
        shape_sheet(s, funnel_side, side, shaper_sides(s, 16, 2), shaper_sides(s, 40, 4), 0.002);
        shape_bar(s, vec3d(-side[0], p[1], side[0]), vec3d(side[0], p[1], side[0]), 0.04, 0.04);
        int screws = shaper_amount(s, 16);
        for (int i = 0; i < screws; ++i) {
            stp_affine at =
                shaper_push(s, place_along(vec3d(p[2] * ((i + 0.5) / screws - 0.5), 0.03, side[1]),
                                           vec3d(0, 0, 1)));
            detail_bolt(s, 0.008, 0.02);
            shaper_pop(s, at);
        }
        shaper_pop(s, turn);
    }
    for (int i = 0; i < 2; ++i) { // star rollers and augers within
        stp_affine roller = shaper_push(
            s, place_along(vec3d((i - 0.5) * 0.6 * p[2], 0.04, -0.5 * p[2]), vec3d(0, 0, 1)));
        detail_gear(s, 0.25 * p[2], p[2], 12);
        shape_coil(s, 0.3 * p[2], 0.01, 0.1 * p[2], shaper_amount(s, 10), shaper_sides(s, 24, 6),
                   6);
        shaper_move(s, 0, p[2] + 0.05, 0);
        detail_motor(s, 0.1, 0.35);
        shaper_pop(s, roller);
    }
    shaper_pop(s, up);
    for (int i = 0; i < 4; ++i) {
        double x = i & 1 ? side[0] : -side[0], z = i & 2 ? side[0] : -side[0];
        shape_beam(s, PROFILE_TUBE, vec3d(x, 0, z), vec3d(x, 1.3 + p[1], z), 0.05, 0.05, 0);
    }
}

void part_oven_shell(shaper* s, const double* p)
{
    double l = p[0], w = p[1], h = p[2];
    int panels = shaper_amount(s, (int)(l / 0.5)), screws = shaper_amount(s, 14);
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < panels; ++i) {
            double x = l * ((i + 0.5) / panels - 0.5), width = l / panels - 0.004;
            shape_box(s, x, 0.55 * h + 0.2, side * 0.5 * w, width, 0.85 * h, 0.0015); // outer skin
            shape_box(s, x, 0.55 * h + 0.2, side * (0.5 * w - 0.1), width, 0.85 * h, 0.001);
            shape_box(s, x, h + 0.2, side * 0.25 * w, width, 0.0015, 0.5 * w - 0.004);
            shape_box(s, x, 0.2, side * 0.25 * w, width, 0.0015, 0.5 * w - 0.004);
            shape_box(s, x, 0.5 * h, side * (0.5 * w + 0.012), 0.3, 0.24, 0.02); // inspection door
            shape_straight(s, vec3d(x - 0.05, 0.5 * h + 0.16, side * (0.5 * w + 0.04)),
                           vec3d(x + 0.05, 0.5 * h + 0.16, side * (0.5 * w + 0.04)), 0.008,
                           shaper_sides(s, 10, 4));
            for (int k = 0; k < screws; ++k) {
                stp_affine at = shaper_push(
                    s,
                    place_along(vec3d(x + 0.48 * width, 0.3 + 0.8 * h * k / screws, side * 0.5 * w),
                                vec3d(0, 0, side)));
                detail_bolt(s, 0.008, 0.03);
                shaper_pop(s, at);
            }
        }
        for (int k = 0; k < 3; ++k) {
            double y = 0.25 + 0.45 * k * h;
            shape_beam(s, PROFILE_U, vec3d(-0.5 * l, y, side * (0.5 * w - 0.05)),
                       vec3d(0.5 * l, y, side * (0.5 * w - 0.05)), 0.08, 0.06, 0.004);
        }
    }
    int legs = 2 + (int)(l / 1.5);
    for (int i = 0; i < legs; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            double x = (l - 0.2) * ((double)i / (legs - 1) - 0.5);
            shape_beam(s, PROFILE_TUBE, vec3d(x, 0, side * 0.45 * w),
                       vec3d(x, 0.25, side * 0.45 * w), 0.1, 0.1, 0);
            shape_thread(s, 0.012, 0.004, 0.1, shaper_sides(s, 12, 4));
        }
    }
}

void part_oven_nozzles(shaper* s, const double* p)
{
    int columns = shaper_amount(s, shaper_sides(s, (int)p[3], 4));
    int rows = shaper_amount(s, shaper_sides(s, (int)p[4], 4));
    for (int low = 0; low < 2; ++low) { // above and below the belt
        stp_affine before = shaper_move(s, 0, p[2] + (low ? -0.25 : 0.25), 0);
        shape_perforated(s, p[0], p[1], 0.0015, columns, rows, 0.006, 8);
        shape_box(s, 0, low ? -0.12 : 0.12, 0, p[0], 0.0015, p[1]);
        shaper_pop(s, before);
    }
}

void part_oven_burner(shaper* s, const double* p)
{
    int burners = shaper_amount(s, (int)p[1]);
    for (int i = 0; i < burners; ++i) {
        double x = p[0] * ((i + 0.5) / burners - 0.5);
        stp_affine before = shaper_push(s, place_along(vec3d(x, p[2], 0.3), vec3d(0, 0, 1)));
        shape_ring_solid(s, 0.03, 0.09, 0.3, shaper_sides(s, 32, 6));
        detail_flange_pair(s, 0.05);
        shaper_move(s, 0, 0.35, 0);
        detail_motor(s, 0.08, 0.25);
        shaper_pop(s, before);
        before = shaper_push(s, place_along(vec3d(x + 0.15, p[2], 0.4), vec3d(0, 1, 0)));
        detail_valve(s, 0.02);
        shaper_pop(s, before);
        stp_vec3d corner[3] = {
            {x + 0.15, p[2] + 0.08, 0.4}, {x + 0.15, p[2] + 0.5, 0.4}, {x + 0.15, p[2] + 0.5, 0.1}};
        stp_vec3d path[24];
        int n = shape_round_path(corner, 3, 0.05, shaper_sides(s, 6, 2), path, 24);
        shape_tube(s, path, n, 0.02, shaper_sides(s, 14, 4), SHAPE_OPEN);
    }
    shape_straight(s, vec3d(-0.5 * p[0], p[2] + 0.5, 0.1), vec3d(0.5 * p[0], p[2] + 0.5, 0.1), 0.04,
                   shaper_sides(s, 20, 5));
}

void part_sheeter(shaper* s, const double* p)
{
    double w = p[0], r = p[2];
    int rollers = shaper_amount(s, (int)p[1]);
    for (int i = 0; i < rollers; ++i) {
        stp_affine before =
            shaper_push(s, place_along(vec3d((i / 2) * 2.6 * r - 0.6,
                                             1.0 + (i & 1 ? 1.02 * r : -1.02 * r), -0.5 * w),
                                       vec3d(0, 0, 1)));
        shape_cylinder(s, r, w, shaper_sides(s, 48, 8));
        shape_cylinder(s, 0.3 * r, w + 0.2, shaper_sides(s, 20, 5));
        detail_bearing(s, 0.3 * r, 0.7 * r, 0.05);
        shaper_move(s, 0, w + 0.06, 0);
        detail_gear(s, 1.0 * r, 0.04, 28);
        detail_bearing(s, 0.3 * r, 0.7 * r, 0.05);
        shaper_pop(s, before);
    }
    for (int side = -1; side <= 1; side += 2) {
        shape_box(s, -0.1, 0.95, side * (0.5 * w + 0.03), 1.8, 0.9, 0.02);
        for (int i = 0; i < 10; ++i) {
            stp_affine at =
                shaper_push(s, place_along(vec3d(-0.9 + 0.17 * i, 1.35, side * (0.5 * w + 0.04)),
                                           vec3d(0, 0, side)));
            detail_bolt(s, 0.012, 0.03);
            shaper_pop(s, at);
        }
    }
    stp_affine drive = shaper_move(s, -0.4, 0.1, 0.5 * w + 0.35);
    detail_gearbox(s, 0.6, 0.45, 0.4);
    shaper_pop(s, drive);
}

void part_proofer_frame(shaper* s, const double* p)
{
    double l = p[0], w = p[1], h = p[2];
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i <= 6; ++i) {
            double x = l * (i / 6.0 - 0.5);
            shape_beam(s, PROFILE_TUBE, vec3d(x, 0, side * 0.5 * w), vec3d(x, h, side * 0.5 * w),
                       0.08, 0.08, 0);
        }
        for (int k = 0; k < 7; ++k) {
            double y = 0.3 + (h - 0.4) * k / 6.0;
            shape_beam(s, PROFILE_U, vec3d(-0.5 * l, y, side * 0.48 * w),
                       vec3d(0.5 * l, y, side * 0.48 * w), 0.06, 0.04, 0.003);
            for (int end = -1; end <= 1; end += 2) {
                stp_affine wheel = shaper_push(
                    s, place_along(vec3d(end * 0.46 * l, y, side * 0.47 * w), vec3d(0, 0, 1)));
                detail_gear(s, 0.14, 0.02, 22);
                detail_bearing(s, 0.03, 0.06, 0.03);
                shaper_pop(s, wheel);
            }
        }
        int links = shaper_amount(s, (int)(6 * l / 0.06));
        for (int i = 0; i < links; ++i) {
            double x = l * ((i % (links / 6 + 1)) / (links / 6 + 1.0) - 0.5),
                   y = 0.44 + (h - 0.4) * (i / (links / 6 + 1)) / 6.0;
            shape_box(s, x, y, side * (0.47 * w + 0.004 * (i & 1)), 0.058, 0.02, 0.003);
            shape_box(s, x + 0.03, y, side * 0.47 * w, 0.012, 0.012, 0.02);
        }
    }
}

void part_swings(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[0]), rows = shaper_amount(s, (int)p[1]);
    for (int i = 0; i < columns * rows; ++i) {
        double x = (i % columns - 0.5 * (columns - 1)) * p[3], y = 0.3 + 0.5 * (i / columns);
        shape_box(s, x, y, 0, 0.28, 0.0015, p[2]);
        int pockets = shaper_amount(s, 10);
        for (int k = 0; k < pockets; ++k) {
            double cup[4][2] = {{0, 0.0}, {0.04, 0.006}, {0.055, 0.03}, {0.058, 0.03}};
            stp_affine at = shaper_move(s, x, y + 0.001, p[2] * ((k + 0.5) / pockets - 0.5));
            shape_lathe(s, (const double(*)[2])cup, 4, shaper_sides(s, 20, 5));
            shaper_pop(s, at);
        }
        for (int side = -1; side <= 1; side += 2) {
            shape_bar(s, vec3d(x - 0.12, y, side * 0.5 * p[2]),
                      vec3d(x, y + 0.14, side * 0.5 * p[2]), 0.02, 0.004);
            shape_bar(s, vec3d(x + 0.12, y, side * 0.5 * p[2]),
                      vec3d(x, y + 0.14, side * 0.5 * p[2]), 0.02, 0.004);
            shape_straight(s, vec3d(x, y + 0.14, side * 0.5 * p[2]),
                           vec3d(x, y + 0.14, side * (0.5 * p[2] + 0.05)), 0.008,
                           shaper_sides(s, 12, 4));
        }
    }
}

void part_spiral_belt(shaper* s, const double* p)
{
    double r = p[0], h = p[1], w = p[3];
    int steps = shaper_amount(s, (int)(p[2] * 6.2832 * r / 0.04)), sides = shaper_sides(s, 5, 3);
    for (int i = 0; i < steps; ++i) { // rods of the belt, wires between them
        double turns = p[2] * i / steps, y = 0.4 + h * i / steps;
        double c = turn_cosine(turns), d = turn_sine(turns);
        shape_straight(s, vec3d((r - 0.5 * w) * c, y, (r - 0.5 * w) * d),
                       vec3d((r + 0.5 * w) * c, y, (r + 0.5 * w) * d), 0.0025, sides);
    }
    for (int k = 0; k < 9; ++k) {
        double out = r + w * (k / 8.0 - 0.5);
        shape_coil(s, 1.0 * out, k == 0 || k == 8 ? 0.008 : 0.003, h / p[2], p[2],
                   shaper_sides(s, 48, 10), sides);
    }
}

void part_spiral_drum(shaper* s, const double* p)
{
    double r = p[0], h = p[1];
    int bars = shaper_amount(s, 80);
    for (int i = 0; i < bars; ++i) {
        double c = turn_cosine((double)i / bars), d = turn_sine((double)i / bars);
        shape_straight(s, vec3d(r * c, 0.3, r * d), vec3d(r * c, h + 0.6, r * d), 0.015,
                       shaper_sides(s, 10, 4));
    }
    for (int i = 0; i < 8; ++i) {
        stp_affine at = shaper_move(s, 0, 0.35 + h * i / 7.0, 0);
        shape_torus(s, r - 0.02, 0.02, shaper_sides(s, 64, 10), shaper_sides(s, 8, 4));
        shaper_pop(s, at);
        double c = turn_cosine(i / 8.0), d = turn_sine(i / 8.0), out = r + 1.1;
        detail_lattice(s, vec3d(out * c, 0, out * d), vec3d(out * c, h + 0.8, out * d), 0.12, 12);
        int arms = shaper_amount(s, 12);
        for (int k = 0; k < arms; ++k) {
            double y = 0.3 + h * k / arms;
            shape_bar(s, vec3d(out * c, y, out * d), vec3d((r + 0.05) * c, y, (r + 0.05) * d), 0.04,
                      0.01);
        }
    }
    shape_cylinder(s, 0.12, h + 1.0, shaper_sides(s, 24, 6));
    stp_affine drive = shaper_move(s, 0, h + 1.0, 0);
    detail_gearbox(s, 0.8, 0.5, 0.6);
    shaper_pop(s, drive);
}

void part_guards(shaper* s, const double* p)
{
    int columns = shaper_amount(s, shaper_sides(s, 24, 4));
    int rows = shaper_amount(s, shaper_sides(s, (int)(24 * p[1]), 4));
    int doors = shaper_amount(s, 1 + (int)(p[0] / 1.0));
    for (int i = 0; i < doors; ++i) {
        double x = p[0] * ((i + 0.5) / doors - 0.5), w = p[0] / doors - 0.02;
        stp_affine sheet = shaper_push(
            s, (stp_affine){{{1, 0, 0, x}, {0, 0, 1, 0.15 + 0.5 * p[1]}, {0, -1, 0, 0}}});
        shape_perforated(s, w - 0.08, p[1] - 0.08, 0.001, columns, rows, 0.3 * w / columns, 8);
        shaper_pop(s, sheet);
        for (int side = -1; side <= 1; side += 2) {
            shape_beam(s, PROFILE_TUBE, vec3d(x + side * 0.5 * w, 0, 0),
                       vec3d(x + side * 0.5 * w, p[1] + 0.2, 0), 0.04, 0.04, 0);
            shape_beam(s, PROFILE_TUBE, vec3d(x - 0.5 * w, 0.15 + (side > 0 ? p[1] : 0), 0),
                       vec3d(x + 0.5 * w, 0.15 + (side > 0 ? p[1] : 0), 0), 0.04, 0.04, 0);
            stp_affine hinge = shaper_move(s, x - 0.5 * w, 0.4 + (side > 0 ? 0.6 * p[1] : 0), 0.03);
            shape_cylinder(s, 0.012, 0.1, shaper_sides(s, 14, 4));
            shaper_pop(s, hinge);
        }
    }
}

void part_tray_rack(shaper* s, const double* p)
{
    int shelves = shaper_amount(s, (int)p[0]);
    for (int i = 0; i < 4; ++i) {
        double x = (i & 1 ? 0.5 : -0.5) * p[1], z = (i & 2 ? 0.5 : -0.5) * p[2];
        shape_beam(s, PROFILE_TUBE, vec3d(x, 0.12, z), vec3d(x, p[3], z), 0.03, 0.03, 0);
        stp_affine wheel = shaper_push(s, place_along(vec3d(x, 0.06, z - 0.02), vec3d(0, 0, 1)));
        shape_ring_solid(s, 0.012, 0.06, 0.04, shaper_sides(s, 28, 6));
        detail_bearing(s, 0.012, 0.03, 0.04);
        shaper_pop(s, wheel);
    }
    for (int i = 0; i < shelves; ++i) {
        double y = 0.25 + (p[3] - 0.35) * i / shelves;
        for (int side = -1; side <= 1; side += 2) {
            shape_beam(s, PROFILE_L, vec3d(-0.5 * p[1], y, side * 0.5 * p[2]),
                       vec3d(0.5 * p[1], y, side * 0.5 * p[2]), 0.025, 0.025, 0.002);
        }
        for (int wire = 0; wire < 10; ++wire) {
            double x = p[1] * (wire / 9.0 - 0.5);
            shape_straight(s, vec3d(x, y, -0.5 * p[2]), vec3d(x, y, 0.5 * p[2]), 0.003,
                           shaper_sides(s, 6, 3));
        }
    }
}

void part_cutter(shaper* s, const double* p)
{
    int knives = shaper_amount(s, (int)p[1]);
    for (int i = 0; i < knives; ++i) {
        stp_affine at = shaper_push(
            s, place_along(vec3d(0, 1.15, p[0] * ((i + 0.5) / knives - 0.5)), vec3d(0, 0, 1)));
        shape_ring_solid(s, 0.03, 0.12, 0.003, shaper_sides(s, 48, 8));
        detail_bearing(s, 0.025, 0.05, 0.02);
        shaper_pop(s, at);
    }
    shape_straight(s, vec3d(0, 1.15, -0.5 * p[0] - 0.1), vec3d(0, 1.15, 0.5 * p[0] + 0.1), 0.025,
                   shaper_sides(s, 24, 6));
    for (int side = -1; side <= 1; side += 2) { // pneumatic cylinders that press it down
        stp_affine at = shaper_move(s, 0, 1.3, side * 0.5 * p[0]);
        shape_cylinder(s, 0.04, 0.3, shaper_sides(s, 28, 6));
        detail_bolt_ring(s, 0.034, 4, 0.008, 0.3);
        shape_thread(s, 0.012, 0.003, 0.08, shaper_sides(s, 14, 4));
        shaper_pop(s, at);
        shape_beam(s, PROFILE_TUBE, vec3d(0, 0, side * (0.5 * p[0] + 0.1)),
                   vec3d(0, 1.7, side * (0.5 * p[0] + 0.1)), 0.08, 0.08, 0);
    }
    shape_beam(s, PROFILE_TUBE, vec3d(0, 1.66, -0.5 * p[0] - 0.1), vec3d(0, 1.66, 0.5 * p[0] + 0.1),
               0.1, 0.08, 0);
}

void part_boxes(shaper* s, const double* p)
{
    int columns = (int)p[0], layers = shaper_amount(s, (int)p[1]);
    for (int plank = 0; plank < 7; ++plank) { // the pallet
        shape_box(s, 0, 0.13, (plank - 3) * 0.15, 1.2, 0.022, 0.1);
        shape_box(s, (plank % 3 - 1) * 0.5, 0.06, (plank / 3 - 1) * 0.35, 0.14, 0.11, 0.14);
    }
    for (int i = 0; i < columns * columns * layers; ++i) {
        double x = (i % columns - 0.5 * (columns - 1)) * p[2],
               z = (i / columns % columns - 0.5 * (columns - 1)) * p[2] * 0.7;
        double y = 0.15 + 0.6 * p[2] * (i / (columns * columns) + 0.5);
        stp_affine box = shaper_push(s, place_by_turn(x, y, z, shaper_between(s, -0.004, 0.004)));
        shape_box(s, 0, 0, 0, 0.97 * p[2], 0.58 * p[2], 0.67 * p[2]);
        shape_box(s, 0, 0.29 * p[2], 0, 0.97 * p[2], 0.001, 0.05); // tape
        shaper_pop(s, box);
    }
}
