// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

// Smooth interpolation in a table of (place, value).
static double curve(const double (*table)[2], int count, double x)
{
    for (int i = 0; i + 1 < count; ++i) {
        if (x <= table[i + 1][0]) {
            double t = (x - table[i][0]) / (table[i + 1][0] - table[i][0]);
            t = t < 0.0 ? 0.0 : t * t * (3.0 - 2.0 * t);
            return table[i][1] + (table[i + 1][1] - table[i][1]) * t;
        }
    }
    return table[count - 1][1];
}

static stp_vec3d body_surface(double u, double v, const void* user)
{
    static const double heights[8][2] = {{0, 0.62},    {0.06, 0.78}, {0.28, 0.98}, {0.45, 1.42},
                                         {0.66, 1.45}, {0.86, 1.05}, {0.96, 0.98}, {1, 0.7}};
    static const double widths[5][2] = {
        {0, 0.68}, {0.12, 0.86}, {0.5, 0.9}, {0.9, 0.86}, {1, 0.72}};
    const double* p = user;
    double x = p[0] + (p[1] - p[0]) * u, a = p[2] + (p[3] - p[2]) * v;
    double side = 2.0 * a - 1.0, reach = side < 0.0 ? -side : side;
    double high = curve(heights, 8, x), wide = curve(widths, 5, x), y, z;
    double top = high > 1.0 ? 0.68 : 0.86; // the roof is narrower than the body
    if (reach < 0.5) {
        double t = reach / 0.5;
        z = wide * top * t;
        y = high - 0.05 * t * t;
    } else {
        double t = (reach - 0.5) / 0.5, out = t < 0.5 ? t * 2.0 : 1.0;
        z = wide * (top + (1.0 - top) * out * (2.0 - out)) - 0.06 * (t - 0.5) * (t - 0.5);
        y = (high - 0.05) * (1.0 - t) + 0.24 * t;
    }
    double lift = 1.0 + p[4];
    return vec3d(4.4 * (x - 0.5), y * lift, (side < 0.0 ? -z : z) * lift);
}

void part_body_panel(shaper* s, const double* p)
{
    int columns = shaper_sides(s, (int)p[5], 2), rows = shaper_sides(s, (int)p[6], 2);
    shape_sheet(s, body_surface, p, columns, rows, p[4] > 0.01 ? 0.004 : 0.0008);
    double inner[5] = {p[0] + 0.01, p[1] - 0.01, p[2] + 0.004, p[3] - 0.004, p[4] - 0.03};
    int ribs = shaper_amount(s, (int)p[7]), sides = shaper_sides(s, 6, 4);
    for (int i = 0; i < ribs; ++i) { // stiffeners behind the sheet, and the spot welds along them
        stp_vec3d path[13];
        for (int k = 0; k <= 12; ++k) {
            path[k] = body_surface((i + 0.5) / ribs, k / 12.0, inner);
        }
        shape_tube(s, path, 13, 0.012, sides, SHAPE_CAPPED);
        int welds = shaper_amount(s, 12);
        for (int k = 0; k < welds; ++k) {
            stp_vec3d at = body_surface((i + 0.5) / ribs, (k + 0.5) / welds, inner);
            stp_affine before = shaper_move(s, at.x, at.y, at.z);
            shape_ball(s, 0.006, 0.005, shaper_sides(s, 6, 4));
            shaper_pop(s, before);
        }
    }
}

static stp_vec3d floor_surface(double u, double v, const void* user)
{
    const double* p = user;
    double tunnel = 0.16 * turn_sine(0.5 * (v < 0.4 ? 0 : v > 0.6 ? 1 : (v - 0.4) * 5.0));
    double bead = 0.008 * turn_sine(u * 14.0) * turn_sine(v * 9.0);
    return vec3d(p[0] * (u - 0.5), 0.25 + tunnel + bead, p[1] * (0.5 - v));
}

void part_underbody(shaper* s, const double* p)
{
    shape_sheet(s, floor_surface, p, shaper_sides(s, 90, 6), shaper_sides(s, 50, 6), 0.0012);
    for (int side = -1; side <= 1; side += 2) {
        shape_beam(s, PROFILE_U, vec3d(-0.5 * p[0], 0.2, side * 0.3 * p[1]),
                   vec3d(0.5 * p[0], 0.2, side * 0.3 * p[1]), 0.1, 0.08, 0.002);
        for (int axle = -1; axle <= 1; axle += 2) {
            stp_affine at = shaper_move(s, axle * 1.3, 0.3, side * 0.55);
            shape_coil(s, 0.06, 0.007, 0.04, 7, shaper_sides(s, 20, 6), shaper_sides(s, 8, 4));
            shape_cylinder(s, 0.03, 0.4, shaper_sides(s, 16, 5));
            shaper_pop(s, at);
            shape_straight(s, vec3d(axle * 1.3, 0.3, 0), vec3d(axle * 1.3, 0.3, side * 0.75), 0.03,
                           shaper_sides(s, 14, 4));
        }
    }
    int ribs = shaper_amount(s, (int)p[2]);
    for (int i = 0; i < ribs; ++i) {
        double x = p[0] * ((i + 0.5) / ribs - 0.5);
        shape_beam(s, PROFILE_U, vec3d(x, 0.19, -0.45 * p[1]), vec3d(x, 0.19, 0.45 * p[1]), 0.06,
                   0.05, 0.0012);
    }
    stp_vec3d corner[5] = {{-1.2, 0.2, 0.1},
                           {0.4, 0.2, 0.1},
                           {0.8, 0.22, 0.4},
                           {1.9, 0.25, 0.4},
                           {2.2, 0.25, 0.4}},
              path[60];
    int n = shape_round_path(corner, 5, 0.1, shaper_sides(s, 5, 2), path, 60);
    shape_tube(s, path, n, 0.028, shaper_sides(s, 16, 5), SHAPE_CAPPED); // exhaust
    for (int line = 0; line < 8; ++line) {                               // brake and fuel lines
        double z = -0.2 - 0.012 * line;
        shape_straight(s, vec3d(-1.9, 0.23, z), vec3d(1.8, 0.23, z), 0.003, shaper_sides(s, 6, 3));
    }
}

// Wheels lie around z: the local y of a lathe along z.
void part_wheel(shaper* s, const double* p)
{
    double r = p[0], w = p[1];
    int spokes = (int)p[2];
    stp_affine before = shaper_push(s, place_along(vec3d(0, 0, -0.5 * w), vec3d(0, 0, 1)));
    double rim[9][2] = {{0.66 * r, 0},       {0.7 * r, 0},        {0.6 * r, 0.2 * w},
                        {0.6 * r, 0.8 * w},  {0.7 * r, w},        {0.66 * r, w},
                        {0.57 * r, 0.8 * w}, {0.57 * r, 0.2 * w}, {0.66 * r, 0}};
    shape_lathe(s, (const double(*)[2])rim, 9, shaper_sides(s, 64, 10));
    shaper_move(s, 0, 0.75 * w, 0);
    shape_ring_solid(s, 0.08 * r, 0.2 * r, 0.15 * w, shaper_sides(s, 32, 6));
    detail_bolt_ring(s, 0.14 * r, 5, 0.014, 0.03);
    detail_bearing(s, 0.08 * r, 0.16 * r, 0.12 * w);
    for (int i = 0; i < spokes; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            double a = (i + 0.12 * side) / spokes, b = (i + 0.2 * side) / spokes;
            stp_vec3d spoke[4];
            for (int k = 0; k < 4; ++k) {
                double t = k / 3.0, turns = a + (b - a) * t, out = r * (0.18 + 0.4 * t);
                spoke[k] = vec3d(out * turn_cosine(turns), 0.1 * w + 0.06 * w * turn_sine(0.5 * t),
                                 out * turn_sine(turns));
            }
            shape_tube(s, spoke, 4, 0.028 * r, shaper_sides(s, 10, 4), SHAPE_CAPPED);
        }
    }
    shaper_pop(s, before);
    before = shaper_push(s, place_along(vec3d(0, 0, -0.1 * w), vec3d(0, 0, 1)));
    shape_ring_solid(s, 0.15 * r, 0.48 * r, 0.03, shaper_sides(s, 48, 8)); // brake disc
    shaper_pop(s, before);
}

void part_tyre(shaper* s, const double* p)
{
    double r = p[0], w = p[1],
           profile[12][2] = {{0.68 * r, 0.06 * w}, {0.8 * r, -0.02 * w}, {0.93 * r, 0.04 * w},
                             {0.98 * r, 0.12 * w}, {0.98 * r, 0.88 * w}, {0.93 * r, 0.96 * w},
                             {0.8 * r, 1.02 * w},  {0.68 * r, 0.94 * w}, {0.66 * r, 0.9 * w},
                             {0.66 * r, 0.1 * w},  {0.68 * r, 0.06 * w}};
    stp_affine before = shaper_push(s, place_along(vec3d(0, 0, -0.5 * w), vec3d(0, 0, 1)));
    shape_lathe(s, (const double(*)[2])profile, 11, shaper_sides(s, 72, 12));
    int blocks = shaper_amount(s, (int)p[2]);
    for (int i = 0; i < blocks; ++i) {
        stp_affine at = shaper_push(s, place_by_turn(0, 0, 0, (double)i / blocks));
        for (int k = 0; k < 4; ++k) {
            shape_box(s, 0.985 * r, w * (0.2 + 0.2 * k), (k & 1 ? 0.3 : -0.3) * r / blocks,
                      0.03 * r, 0.16 * w, 4.5 * r / blocks);
        }
        shaper_pop(s, at);
    }
    shaper_pop(s, before);
}

static stp_vec3d cushion(double u, double v, const void* user)
{
    const double* p = user; // width, length, bulge
    double fat = turn_sine(0.5 * u) * turn_sine(0.5 * v),
           seam = 0.006 * turn_sine(u * 2.0) * turn_sine(u * 2.0);
    return vec3d(p[1] * (v - 0.5), p[2] * fat - seam, p[0] * (u - 0.5));
}

void part_seats(shaper* s, const double* p)
{
    int seats = (int)p[0];
    double pad[3] = {0.5, 0.52, 0.12};
    for (int i = 0; i < seats; ++i) {
        double x = i < 2 ? -0.15 : 0.75, z = (i & 1 ? 0.5 : -0.5) * p[1];
        stp_affine before = shaper_move(s, x, 0.52, z);
        shape_sheet(s, cushion, pad, shaper_sides(s, 24, 4), shaper_sides(s, 24, 4), 0.05);
        shaper_push(s, (stp_affine){{{0.28, -0.96, 0, 0.28}, {0.96, 0.28, 0, 0.33}, {0, 0, 1, 0}}});
        shape_sheet(s, cushion, pad, shaper_sides(s, 24, 4), shaper_sides(s, 24, 4), 0.05);
        shaper_move(s, 0.42, 0, 0);
        shape_ball(s, 0.12, 0.1, shaper_sides(s, 18, 6));
        shaper_pop(s, before);
        for (int rail = -1; rail <= 1; rail += 2) {
            shape_bar(s, vec3d(x - 0.3, 0.42, z + 0.18 * rail),
                      vec3d(x + 0.3, 0.42, z + 0.18 * rail), 0.03, 0.04);
        }
    }
    shape_box(s, -0.75, 0.85, 0, 0.3, 0.25, 1.35); // dashboard
    stp_affine wheel =
        shaper_push(s, place_along(vec3d(-0.5, 0.88, -0.5 * p[1]), vec3d(1, 0.5, 0)));
    shape_torus(s, 0.18, 0.014, shaper_sides(s, 36, 8), shaper_sides(s, 10, 4));
    shaper_pop(s, wheel);
}

void part_engine(shaper* s, const double* p)
{
    int cylinders = (int)p[0];
    double bore = p[1], length = cylinders * bore * 1.25;
    shape_box(s, 0, 0.45, 0, length + 0.08, 0.3, 0.3);
    shape_box(s, 0, 0.28, 0, length, 0.14, 0.24);
    shape_box(s, 0, 0.68, 0, length + 0.04, 0.14, 0.28);
    for (int i = 0; i < cylinders; ++i) {
        double x = (i - 0.5 * (cylinders - 1)) * bore * 1.25;
        stp_affine at = shaper_move(s, x, 0.42, 0);
        shape_ring_solid(s, 0.48 * bore, 0.56 * bore, 0.17,
                         shaper_sides(s, 32, 6)); // within the block
        shape_cylinder(s, 0.47 * bore, 0.07, shaper_sides(s, 32, 6));
        shaper_move(s, 0, -0.12, 0);
        detail_bearing(s, 0.03, 0.05, 0.03);
        shaper_pop(s, at);
        stp_vec3d corner[4] = {{x, 0.66, 0.14}, {x, 0.66, 0.3}, {x, 0.4, 0.34}, {0, 0.3, 0.36}},
                  path[40];
        int n = shape_round_path(corner, 4, 0.05, shaper_sides(s, 6, 2), path, 40);
        shape_tube(s, path, n, 0.02, shaper_sides(s, 16, 5), SHAPE_CAPPED);
        at = shaper_move(s, x, 0.75, 0);
        shape_cylinder(s, 0.02, 0.06, shaper_sides(s, 16, 5));
        detail_bolt_ring(s, 0.035, 4, 0.008, 0.03);
        shaper_pop(s, at);
    }
    for (int i = 0; i < 5; ++i) { // belt drive
        double a = i / 5.0;
        stp_affine at =
            shaper_push(s, place_along(vec3d(0.5 * length + 0.05, 0.45 + 0.15 * turn_cosine(a),
                                             0.13 * turn_sine(a)),
                                       vec3d(1, 0, 0)));
        shape_ring_solid(s, 0.015, 0.05 + 0.01 * i, 0.025, shaper_sides(s, 32, 6));
        detail_gear(s, 0.045, 0.02, 30);
        shaper_pop(s, at);
    }
    stp_affine box = shaper_move(s, -0.5 * length - 0.25, 0.25, 0);
    detail_gearbox(s, 0.4, 0.32, 0.3);
    shaper_pop(s, box);
}

static void robot_drive(shaper* s, double r)
{
    shape_cylinder(s, r, 0.9 * r, shaper_sides(s, 40, 8));
    detail_bolt_ring(s, 0.85 * r, 16, 0.06 * r, 0.1 * r);
    stp_affine at = shaper_move(s, 0, 0.9 * r, 0);
    detail_gear(s, 0.7 * r, 0.08 * r, 60);
    detail_bearing(s, 0.3 * r, 0.6 * r, 0.2 * r);
    shaper_move(s, 0, 0.1 * r, 0);
    detail_motor(s, 0.5 * r, 1.4 * r);
    shaper_pop(s, at);
}

void part_robot_base(shaper* s, const double* p)
{
    double r = p[0], h = p[1];
    double body[9][2] = {{0, 0},
                         {1.3 * r, 0},
                         {1.3 * r, 0.06 * h},
                         {1.05 * r, 0.1 * h},
                         {0.9 * r, 0.4 * h},
                         {1.0 * r, 0.55 * h},
                         {1.0 * r, 0.8 * h},
                         {0.7 * r, h},
                         {0, h}};
    shape_lathe(s, (const double(*)[2])body, 9, shaper_sides(s, 64, 10));
    stp_affine at = shaper_move(s, 0, 0.06 * h, 0);
    detail_bolt_ring(s, 1.2 * r, 12, 0.1 * r, 0.2 * r);
    shaper_pop(s, at);
    for (int side = -1; side <= 1; side += 2) {
        at = shaper_push(s,
                         place_along(vec3d(0.1 * r, 0.85 * h, side * 0.5 * r), vec3d(0, 0, side)));
        robot_drive(s, 0.6 * r);
        shaper_pop(s, at);
    }
}

void part_robot_arm(shaper* s, const double* p)
{
    double l = p[0], r = p[1];
    double body[8][2] = {{0, -0.1 * l},       {0.9 * r, -0.06 * l}, {1.1 * r, 0.05 * l},
                         {0.8 * r, 0.25 * l}, {0.7 * r, 0.7 * l},   {0.95 * r, 0.95 * l},
                         {0.7 * r, 1.06 * l}, {0, 1.08 * l}};
    stp_affine before = shaper_push(s, place_along(vec3d(0, 0, 0), vec3d(1, 0, 0)));
    shape_lathe(s, (const double(*)[2])body, 8, shaper_sides(s, 40, 8));
    shaper_pop(s, before);
    before = shaper_push(s, place_along(vec3d(l, 0, -1.2 * r), vec3d(0, 0, 1)));
    robot_drive(s, 1.0 * r);
    shaper_pop(s, before);
    for (int i = 0; i < 6; ++i) {
        stp_affine rib =
            shaper_push(s, place_along(vec3d(l * (0.2 + 0.1 * i), 0, 0), vec3d(1, 0, 0)));
        shape_torus(s, 0.8 * r, 0.06 * r, shaper_sides(s, 32, 6), shaper_sides(s, 8, 4));
        shaper_pop(s, rib);
    }
}

void part_robot_wrist(shaper* s, const double* p)
{
    double l = p[0], r = p[1];
    stp_affine before = shaper_push(s, place_along(vec3d(0, 0, 0), vec3d(1, 0, 0)));
    shape_cylinder(s, r, l, shaper_sides(s, 32, 6));
    shaper_move(s, 0, l, 0);
    shape_ring_solid(s, 0.3 * r, 1.1 * r, 0.3 * r, shaper_sides(s, 32, 6));
    detail_bolt_ring(s, 0.8 * r, 8, 0.1 * r, 0.3 * r);
    detail_bearing(s, 0.5 * r, 0.9 * r, 0.3 * r);
    shaper_pop(s, before);
}

void part_weld_gun(shaper* s, const double* p)
{
    double k = p[0];
    shape_box(s, 0.25 * k, 0, 0, 0.3 * k, 0.25 * k, 0.2 * k);
    for (int side = -1; side <= 1; side += 2) {
        stp_vec3d corner[4] = {{0.3 * k, side * 0.1 * k, 0},
                               {0.5 * k, side * 0.35 * k, 0},
                               {0.95 * k, side * 0.35 * k, 0},
                               {1.0 * k, side * 0.03 * k, 0}},
                  path[40];
        int n = shape_round_path(corner, 4, 0.08 * k, shaper_sides(s, 6, 2), path, 40);
        shape_tube(s, path, n, 0.035 * k, shaper_sides(s, 16, 5), SHAPE_CAPPED);
        stp_affine tip = shaper_push(s, place_along(path[n - 1], vec3d(0, -side, 0)));
        shape_cylinder(s, 0.015 * k, 0.05 * k, shaper_sides(s, 16, 5));
        shaper_pop(s, tip);
    }
    stp_affine drive = shaper_push(s, place_along(vec3d(0.1 * k, 0.25 * k, 0), vec3d(0, 1, 0)));
    detail_motor(s, 0.1 * k, 0.3 * k);
    shaper_pop(s, drive);
}

void part_robot_hoses(shaper* s, const double* p)
{
    int hoses = shaper_amount(s, (int)p[2]);
    for (int i = 0; i < hoses; ++i) {
        double z = 0.16 + 0.03 * (i % 3), y = 0.02 * (i / 3);
        stp_vec3d corner[6] = {{-0.5, 0.1, z},
                               {-0.5, 0.4 * p[1], z},
                               {-0.2, p[1] + y, z},
                               {0.5 * p[0], p[1] + 0.2 + y, z},
                               {p[0], p[1] - 0.1 + y, z},
                               {p[0] + 0.2, 0.8 * p[1] + y, 0}},
                  path[80];
        int n = shape_round_path(corner, 6, 0.12, shaper_sides(s, 6, 2), path, 80);
        shape_tube(s, path, n, 0.012 + 0.004 * (i % 3), shaper_sides(s, 12, 4), SHAPE_CAPPED);
    }
    for (int i = 0; i < 4; ++i) {
        stp_affine at = shaper_push(
            s, place_along(vec3d(p[0] * 0.22 * (i + 0.5), p[1] + 0.15, 0.18), vec3d(1, 0, 0)));
        shape_ring_solid(s, 0.07, 0.085, 0.04, shaper_sides(s, 24, 6));
        shaper_pop(s, at);
    }
}

void part_press_frame(shaper* s, const double* p)
{
    double w = p[0], h = p[1], d = p[2];
    for (int i = 0; i < 4; ++i) {
        double x = (i & 1 ? 0.42 : -0.42) * w, z = (i & 2 ? 0.42 : -0.42) * d;
        shape_box(s, x, 0.5 * h, z, 0.16 * w, h, 0.16 * d);
        stp_affine rod = shaper_move(s, x, h, z); // tie rods
        shape_cylinder(s, 0.04 * w, 0.08 * h, shaper_sides(s, 28, 6));
        shape_thread(s, 0.045 * w, 0.02 * w, 0.07 * h, shaper_sides(s, 28, 6));
        shape_ring_solid(s, 0.04 * w, 0.07 * w, 0.03 * h, 6);
        shaper_pop(s, rod);
    }
    shape_box(s, 0, 0.08 * h, 0, w, 0.16 * h, d);
    shape_box(s, 0, 0.9 * h, 0, w, 0.2 * h, d);
    detail_railing(s, vec3d(-0.5 * w, h, -0.5 * d), vec3d(0.5 * w, h, -0.5 * d));
    detail_railing(s, vec3d(-0.5 * w, h, 0.5 * d), vec3d(0.5 * w, h, 0.5 * d));
    stp_affine ladder = shaper_move(s, 0.5 * w, 0, 0);
    part_ladder(s, PARAMETERS(h, 0));
    shaper_pop(s, ladder);
    int bolts = shaper_amount(s, 40);
    for (int i = 0; i < bolts; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            stp_affine at = shaper_push(
                s, place_along(vec3d(w * ((i + 0.5) / bolts - 0.5), 0.82 * h, side * 0.5 * d),
                               vec3d(0, 0, side)));
            detail_bolt(s, 0.04, 0.1);
            shaper_pop(s, at);
        }
    }
}

void part_press_drive(shaper* s, const double* p)
{
    double w = p[0], h = p[1], d = p[2];
    shape_box(s, 0, 0.58 * h, 0, 0.66 * w, 0.12 * h, 0.66 * d); // the ram
    for (int i = 0; i < 4; ++i) {
        stp_affine at =
            shaper_move(s, (i & 1 ? 0.25 : -0.25) * w, 0.64 * h, (i & 2 ? 0.25 : -0.25) * d);
        shape_cylinder(s, 0.06 * w, 0.2 * h, shaper_sides(s, 40, 8));
        shape_ring_solid(s, 0.07 * w, 0.1 * w, 0.12 * h, shaper_sides(s, 40, 8));
        detail_bolt_ring(s, 0.085 * w, 12, 0.03, 0.08);
        shaper_pop(s, at);
    }
    stp_affine gears =
        shaper_push(s, place_along(vec3d(-0.2 * w, 0.92 * h, -0.3 * d), vec3d(0, 0, 1)));
    detail_gear(s, 0.14 * w, 0.1 * d, 90); // within the crown
    shaper_push(s, place_by_turn(0.0, 0, 0.19 * w, 0.01));
    detail_gear(s, 0.05 * w, 0.1 * d, 30);
    shaper_pop(s, gears);
    gears = shaper_push(s, place_along(vec3d(0, 0.94 * h, 0.52 * d), vec3d(0, 0, 1)));
    shape_ring_solid(s, 0.05 * w, 0.18 * w, 0.08 * d, shaper_sides(s, 64, 10)); // flywheel
    shaper_move(s, 0.25 * w, 0, 0);
    detail_motor(s, 0.08 * w, 0.2 * w);
    shaper_pop(s, gears);
}

static stp_vec3d die_surface(double u, double v, const void* user)
{
    const double* p = user;
    double y = turn_sine(0.5 * u) * turn_sine(0.5 * v);
    return vec3d(p[0] * (u - 0.5), p[2] * (0.6 + 0.4 * y + 0.05 * turn_sine(2.0 * u + v)),
                 p[1] * (0.5 - v));
}

void part_die(shaper* s, const double* p)
{
    shape_sheet(s, die_surface, p, shaper_sides(s, (int)p[3], 4), shaper_sides(s, (int)p[4], 4), 0);
    shape_box(s, 0, 0.25 * p[2], 0, p[0] * 1.1, 0.5 * p[2], p[1] * 1.1);
    for (int i = 0; i < 4; ++i) {
        stp_affine at =
            shaper_move(s, (i & 1 ? 0.5 : -0.5) * p[0], 0.5 * p[2], (i & 2 ? 0.5 : -0.5) * p[1]);
        shape_cylinder(s, 0.06, p[2], shaper_sides(s, 28, 6));
        shape_coil(s, 0.09, 0.012, 0.05, 8, shaper_sides(s, 24, 6), shaper_sides(s, 8, 4));
        shaper_pop(s, at);
    }
}

void part_jig(shaper* s, const double* p)
{
    double l = p[0], w = p[1];
    int clamps = shaper_amount(s, (int)p[2]);
    for (int side = -1; side <= 1; side += 2) {
        shape_beam(s, PROFILE_TUBE, vec3d(-0.5 * l, 0.3, side * 0.5 * w),
                   vec3d(0.5 * l, 0.3, side * 0.5 * w), 0.2, 0.12, 0);
        for (int i = 0; i < 4; ++i) {
            shape_beam(s, PROFILE_TUBE, vec3d(l * (i / 3.0 - 0.5), 0, side * 0.5 * w),
                       vec3d(l * (i / 3.0 - 0.5), 0.2, side * 0.5 * w), 0.15, 0.15, 0);
        }
    }
    for (int i = 0; i < clamps; ++i) {
        double x = l * ((i / 2 + 0.5) / (0.5 * clamps + 0.5) - 0.5), side = i & 1 ? 1 : -1;
        stp_affine at = shaper_move(s, x, 0.4, side * 0.5 * w);
        shape_box(s, 0, 0.2, 0, 0.08, 0.4, 0.1);
        shape_cylinder(s, 0.04, 0.3, shaper_sides(s, 24, 6));
        shape_bar(s, vec3d(0, 0.4, 0), vec3d(0, 0.5, -side * 0.3), 0.05, 0.03);
        detail_bolt_ring(s, 0.035, 4, 0.01, 0.04);
        shaper_pop(s, at);
    }
}

void part_shelf_rack(shaper* s, const double* p)
{
    int bays = 1 + (int)(p[0] / 2.7), levels = (int)p[3];
    for (int i = 0; i <= bays; ++i) {
        double x = p[0] * ((double)i / bays - 0.5);
        for (int side = -1; side <= 1; side += 2) {
            shape_beam(s, PROFILE_U, vec3d(x, 0, side * 0.5 * p[2]),
                       vec3d(x, p[1], side * 0.5 * p[2]), 0.1, 0.08, 0.003);
        }
        for (int k = 0; k < 2 * levels; ++k) {
            double y = p[1] * k / (2.0 * levels);
            shape_beam(s, PROFILE_U, vec3d(x, y, (k & 1 ? 0.5 : -0.5) * p[2]),
                       vec3d(x, y + p[1] / (2.0 * levels), (k & 1 ? -0.5 : 0.5) * p[2]), 0.03, 0.03,
                       0.002);
        }
        for (int level = 1; i < bays && level <= levels; ++level) {
            double y = p[1] * level / (levels + 1.0), next = x + p[0] / bays;
            for (int side = -1; side <= 1; side += 2) {
                shape_beam(s, PROFILE_TUBE, vec3d(x, y, side * 0.5 * p[2]),
                           vec3d(next, y, side * 0.5 * p[2]), 0.12, 0.05, 0);
            }
            int boxes = shaper_amount(s, 6);
            for (int k = 0; k < boxes; ++k) {
                stp_affine at = shaper_move(s, x + p[0] / bays * (k + 0.5) / boxes, y + 0.06, 0);
                shape_box(s, 0, 0.2, 0, 0.36, 0.4, 0.9 * p[2]);
                detail_bolt_ring(s, 0.12, 10, 0.02, 0.06); // contents of the boxes
                shaper_pop(s, at);
            }
        }
    }
}
