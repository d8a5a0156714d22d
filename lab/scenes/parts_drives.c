// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

enum { MOST_TEETH = 120 };

void detail_gear(shaper* s, double radius, double width, int teeth)
{
    double outline[4 * MOST_TEETH][2];
    int n = teeth < 6 ? 6 : teeth < MOST_TEETH ? teeth : MOST_TEETH;
    double add = 2.0 * radius / n, root = radius - 1.1 * add, tip = radius + 0.9 * add;
    static const double at[4] = {0.0, 0.18, 0.34, 0.52}, high[4] = {0, 1, 1, 0};
    for (int i = 0; i < 4 * n; ++i) {
        double turns = (i / 4 + at[i % 4]) / n, r = high[i % 4] > 0 ? tip : root;
        outline[i][0] = r * turn_cosine(turns);
        outline[i][1] = r * turn_sine(turns);
    }
    shape_prism(s, (const double(*)[2])outline, 4 * n, 0.25 * radius, width);
}

void detail_bearing(shaper* s, double bore, double outer, double width)
{
    double middle = 0.5 * (bore + outer), ball = 0.28 * (outer - bore), w = width;
    int sides = shaper_sides(s, 32, 6), balls = shaper_amount(s, (int)(3.0 * middle / ball));
    double inner_ring[8][2] = {{bore, 0},
                               {middle - 0.7 * ball, 0},
                               {middle - 0.7 * ball, 0.3 * w},
                               {middle - 0.95 * ball, 0.5 * w},
                               {middle - 0.7 * ball, 0.7 * w},
                               {middle - 0.7 * ball, w},
                               {bore, w},
                               {bore, 0}};
    double outer_ring[8][2] = {{outer, 0},
                               {outer, w},
                               {middle + 0.7 * ball, w},
                               {middle + 0.7 * ball, 0.7 * w},
                               {middle + 0.95 * ball, 0.5 * w},
                               {middle + 0.7 * ball, 0.3 * w},
                               {middle + 0.7 * ball, 0},
                               {outer, 0}};
    shape_lathe(s, (const double(*)[2])inner_ring, 8, sides);
    shape_lathe(s, (const double(*)[2])outer_ring, 8, sides);
    int ball_sides = shaper_sides(s, 12, 4);
    for (int i = 0; i < balls; ++i) {
        double turns = (double)i / balls;
        stp_affine before =
            shaper_move(s, middle * turn_cosine(turns), 0.5 * w, middle * turn_sine(turns));
        shape_ball(s, ball, 2.0 * ball, ball_sides);
        shaper_pop(s, before);
    }
}

void detail_motor(shaper* s, double r, double l)
{
    int sides = shaper_sides(s, 32, 8), fins = shaper_amount(s, 36);
    double body[8][2] = {{0, 0},
                         {0.8 * r, 0},
                         {0.88 * r, 0.06 * l},
                         {0.88 * r, 0.8 * l},
                         {0.95 * r, 0.8 * l},
                         {0.95 * r, 0.96 * l},
                         {0.8 * r, l},
                         {0, l}};
    shape_lathe(s, (const double(*)[2])body, 8, sides);
    for (int i = 0; i < fins; ++i) {
        stp_affine before = shaper_push(s, place_by_turn(0, 0, 0, (double)i / fins));
        shape_box(s, 0.93 * r, 0.43 * l, 0, 0.14 * r, 0.72 * l, 0.02 * r);
        shaper_pop(s, before);
    }
    shape_box(s, 0, 0.5 * l, 1.05 * r, 0.7 * r, 0.3 * l, 0.4 * r);
    for (int side = -1; side <= 1; side += 2) {
        shape_box(s, -0.95 * r, 0.2 * l, side * 0.6 * r, 0.12 * r, 0.2 * l, 0.3 * r);
        shape_box(s, -0.95 * r, 0.65 * l, side * 0.6 * r, 0.12 * r, 0.2 * l, 0.3 * r);
    }
    stp_affine before = shaper_move(s, 0, -0.35 * l, 0);
    shape_cylinder(s, 0.2 * r, 0.4 * l, shaper_sides(s, 16, 5));
    shaper_pop(s, before);
    before = shaper_move(s, 0, 0.02 * l, 0);
    detail_bearing(s, 0.22 * r, 0.5 * r, 0.08 * l); // within the end shield
    detail_bolt_ring(s, 0.72 * r, 6, 0.06 * r, 0.05 * l);
    shaper_move(s, 0, 0.1 * l, 0);
    shape_ring_solid(s, 0.4 * r, 0.8 * r, 0.6 * l, sides); // stator, hidden
    shaper_pop(s, before);
    int slots = shaper_amount(s, 24);
    for (int i = 0; i < slots; ++i) { // the fan cover's grille
        before = shaper_push(s, place_by_turn(0, 0, 0, (double)i / slots));
        shape_box(s, 0.55 * r, 1.005 * l, 0, 0.6 * r, 0.01 * l, 0.02 * r);
        shaper_pop(s, before);
    }
}

void part_motors(shaper* s, const double* p)
{
    int count = shaper_amount(s, (int)p[0]);
    for (int i = 0; i < count; ++i) {
        stp_affine before = shaper_push(
            s, place_along(vec3d((i - 0.5 * (count - 1)) * p[2], 1.1 * p[1], -1.5 * p[1]),
                           vec3d(0, 0, 1)));
        // feet down: the motor's -x
        shaper_push(s, place_by_turn(0, 0, 0, 0.0));
        detail_motor(s, p[1], 3.0 * p[1]);
        shaper_pop(s, before);
        shape_box(s, (i - 0.5 * (count - 1)) * p[2], 0.05 * p[1], 0, 2.0 * p[1], 0.1 * p[1],
                  2.4 * p[1]);
    }
}

// A shell of 1.2 cm plates, so that the interior is really inside.
static void housing(shaper* s, double w, double h, double d)
{
    double t = 0.012;
    shape_box(s, 0, 0.5 * t, 0, w, t, d);
    shape_box(s, 0, h - 0.5 * t, 0, w, t, d);
    for (int side = -1; side <= 1; side += 2) {
        shape_box(s, side * 0.5 * (w - t), 0.5 * h, 0, t, h - 2 * t, d);
        shape_box(s, 0, 0.5 * h, side * 0.5 * (d - t), w - 2 * t, h - 2 * t, t);
        shape_box(s, 0, 0.5 * h, side * (0.5 * d + 0.02), w * 1.06, 0.03, 0.04); // joint
    }
    int ribs = shaper_amount(s, 8), screws = shaper_amount(s, 18);
    for (int i = 0; i < ribs; ++i) {
        double x = w * ((i + 0.5) / ribs - 0.5);
        shape_box(s, x, 0.5 * h, 0, 0.012, 0.9 * h, d + 0.06);
    }
    for (int i = 0; i < screws; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            stp_affine at = shaper_move(s, w * ((i + 0.5) / screws - 0.5), 0.5 * h + 0.015,
                                        side * (0.5 * d + 0.025));
            detail_bolt(s, 0.014, 0.04);
            shaper_pop(s, at);
        }
    }
}

void detail_gearbox(shaper* s, double w, double h, double d)
{
    housing(s, w, h, d);
    static const double at[4] = {-0.33, -0.08, 0.14, 0.36}, size[4] = {0.11, 0.19, 0.09, 0.2};
    for (int i = 0; i < 4; ++i) {
        stp_affine shaft =
            shaper_push(s, place_along(vec3d(at[i] * w, 0.5 * h, -0.45 * d), vec3d(0, 0, 1)));
        double r = size[i] * w < 0.42 * h ? size[i] * w : 0.42 * h;
        shape_cylinder(s, 0.24 * r, 0.9 * d, shaper_sides(s, 20, 5));
        detail_bearing(s, 0.25 * r, 0.6 * r, 0.07 * d);
        shaper_move(s, 0, 0.15 * d, 0);
        detail_gear(s, r, 0.2 * d, shaper_amount(s, 24 + (int)(120 * size[i])));
        shaper_move(s, 0, 0.3 * d, 0);
        detail_gear(s, 0.6 * r, 0.2 * d, shaper_amount(s, 18 + (int)(60 * size[i])));
        shaper_move(s, 0, 0.36 * d, 0);
        detail_bearing(s, 0.25 * r, 0.6 * r, 0.07 * d);
        shaper_pop(s, shaft);
    }
    for (int side = -1; side <= 1; side += 2) { // covers where shafts come out
        stp_affine cover = shaper_push(
            s, place_along(vec3d(0.36 * w * side, 0.5 * h, 0.5 * d * side), vec3d(0, 0, side)));
        shape_ring_solid(s, 0.06 * w, 0.13 * w, 0.03, shaper_sides(s, 28, 6));
        detail_bolt_ring(s, 0.11 * w, 8, 0.012, 0.04);
        shape_cylinder(s, 0.05 * w, 0.2 * d, shaper_sides(s, 20, 5));
        shaper_pop(s, cover);
    }
}

void part_gearbox(shaper* s, const double* p)
{
    detail_gearbox(s, p[0], p[1], p[2]);
}

void part_fan(shaper* s, const double* p)
{
    double r = p[0], w = p[1];
    int blades = shaper_amount(s, (int)p[2]), sides = shaper_sides(s, 48, 8);
    stp_affine before = shaper_push(s, place_along(vec3d(0, 1.4 * r, -0.5 * w), vec3d(0, 0, 1)));
    shape_ring_solid(s, 1.25 * r, 1.3 * r, w, sides);
    shape_ring_solid(s, 0.6 * r, 1.3 * r, 0.01, sides);
    shape_cylinder(s, 0.12 * r, 2.4 * w, shaper_sides(s, 20, 5));
    shape_ring_solid(s, 0.1 * r, r, 0.012, sides);
    for (int i = 0; i < blades; ++i) {
        stp_affine turn = shaper_push(s, place_by_turn(0, 0, 0, (double)i / blades));
        shaper_push(s, place_by_turn(0.8 * r, 0.5 * w, 0, 0.09));
        shape_box(s, 0, 0, 0, 0.45 * r, 0.9 * w, 0.006);
        shaper_pop(s, turn);
    }
    shaper_move(s, 0, 1.5 * w, 0);
    detail_bearing(s, 0.12 * r, 0.25 * r, 0.1 * w);
    shaper_move(s, 0, 0.8 * w, 0);
    detail_motor(s, 0.5 * r, 1.4 * r);
    shaper_pop(s, before);
    shape_box(s, 0, 0.2 * r, 0.2 * w, 2.2 * r, 0.4 * r, 2.0 * w);
}

void part_roller_conveyor(shaper* s, const double* p)
{
    double length = p[0], w = 0.5 * p[1], h = p[2];
    int rollers = shaper_amount(s, (int)(length / p[3])), sides = shaper_sides(s, 18, 5);
    int legs = shaper_amount(s, 1 + (int)(length / 2.0));
    for (int side = -1; side <= 1; side += 2) {
        shape_beam(s, PROFILE_U, vec3d(-0.5 * length, h - 0.06, side * w),
                   vec3d(0.5 * length, h - 0.06, side * w), 0.12, 0.05, 0.004);
        for (int i = 0; i <= legs; ++i) {
            double x = (length - 0.2) * ((double)i / legs - 0.5);
            shape_beam(s, PROFILE_U, vec3d(x, 0, side * w), vec3d(x, h - 0.12, side * w), 0.08,
                       0.04, 0.004);
            shape_box(s, x, 0.006, side * w, 0.16, 0.012, 0.12);
            stp_affine foot = shaper_move(s, x + 0.05, 0.012, side * (w + 0.03));
            detail_bolt(s, 0.012, 0.03);
            shaper_pop(s, foot);
        }
    }
    for (int i = 0; i < rollers; ++i) {
        double x = length * ((i + 0.5) / rollers - 0.5);
        stp_affine before = shaper_push(s, place_along(vec3d(x, h - 0.03, -w), vec3d(0, 0, 1)));
        shape_cylinder(s, 0.006, 2 * w, shaper_sides(s, 8, 3));
        shaper_move(s, 0, 0.03, 0);
        double drum[6][2] = {{0.008, 0},
                             {0.024, 0},
                             {0.025, 0.003},
                             {0.025, 2 * w - 0.063},
                             {0.024, 2 * w - 0.06},
                             {0.008, 2 * w - 0.06}};
        shape_lathe(s, (const double(*)[2])drum, 6, sides);
        detail_gear(s, 0.03, 0.008, shaper_amount(s, 14));
        shaper_pop(s, before);
    }
}

static stp_vec3d belt_surface(double u, double v, const void* user)
{
    const double* p = user; // length, width, radius
    double straight = p[0], round = 3.14159265358979 * p[2], total = 2 * straight + 2 * round;
    double at = u * total, z = p[1] * (0.5 - v);
    if (at < straight) {
        return vec3d(at - 0.5 * straight, p[2], z);
    }
    if (at < straight + round) {
        double t = 0.25 - 0.5 * (at - straight) / round;
        return vec3d(0.5 * straight + p[2] * turn_cosine(t), p[2] * turn_sine(t), z);
    }
    if (at < 2 * straight + round) {
        return vec3d(0.5 * straight - (at - straight - round), -p[2], z);
    }
    double t = 0.75 - 0.5 * (at - 2 * straight - round) / round;
    return vec3d(p[2] * turn_cosine(t) - 0.5 * straight, p[2] * turn_sine(t), z);
}

void part_belt_conveyor(shaper* s, const double* p)
{
    double length = p[0], h = p[2], r = 0.16;
    double belt[3] = {length, p[1], r};
    stp_affine before = shaper_move(s, 0, h - r, 0);
    shape_sheet(s, belt_surface, belt, shaper_sides(s, 120, 24), shaper_sides(s, 3, 1), 0.004);
    shaper_pop(s, before);
    int idlers = shaper_amount(s, (int)(length / 0.5)), sides = shaper_sides(s, 16, 5);
    for (int i = 0; i < idlers; ++i) {
        double x = length * ((i + 0.5) / idlers - 0.5), w = 0.5 * p[1];
        for (int low = 0; low < 2; ++low) {
            double y = low ? h - 2 * r - 0.03 : h - 0.035;
            shape_straight(s, vec3d(x, y, -w), vec3d(x, y, w), 0.03, sides);
            shape_straight(s, vec3d(x, y, -w - 0.06), vec3d(x, y, w + 0.06), 0.008, 6);
            shape_bar(s, vec3d(x, y - 0.1, -w - 0.06), vec3d(x, y - 0.1, w + 0.06), 0.05, 0.05);
        }
    }
    for (int end = -1; end <= 1; end += 2) {
        stp_affine drum = shaper_push(
            s, place_along(vec3d(end * 0.5 * length, h - r, -0.5 * p[1] - 0.1), vec3d(0, 0, 1)));
        shape_cylinder(s, r - 0.006, p[1] + 0.2, shaper_sides(s, 32, 8));
        detail_bearing(s, 0.04, 0.1, 0.05);
        shaper_move(s, 0, -0.3, 0);
        detail_motor(s, 0.12, 0.35);
        shaper_pop(s, drum);
    }
    for (int side = -1; side <= 1; side += 2) {
        double z = side * (0.5 * p[1] + 0.07);
        shape_beam(s, PROFILE_U, vec3d(-0.5 * length, h - r, z), vec3d(0.5 * length, h - r, z), 0.2,
                   0.06, 0.005);
        int legs = 1 + (int)(length / 3.0);
        for (int i = 0; i <= legs && h < 3.0; ++i) {
            double x = (length - 0.4) * ((double)i / legs - 0.5);
            shape_beam(s, PROFILE_TUBE, vec3d(x, 0, z), vec3d(x, h - r, z), 0.06, 0.06, 0);
        }
    }
}

// Two plates and a pin.
static void link(shaper* s, double pitch, int sides)
{
    double t = 0.12 * pitch, r = 0.3 * pitch;
    for (int side = -1; side <= 1; side += 2) {
        shape_box(s, 0.5 * pitch, 0, side * 0.42 * pitch, pitch, 1.6 * r, t);
    }
    stp_affine pin = shaper_push(s, place_along(vec3d(0, 0, -0.5 * pitch), vec3d(0, 0, 1)));
    shape_cylinder(s, 0.4 * r, pitch, sides);
    shaper_move(s, 0, 0.15 * pitch, 0);
    shape_ring_solid(s, 0.45 * r, r, 0.7 * pitch, sides);
    shaper_pop(s, pin);
}

void part_chain(shaper* s, const double* p)
{
    double length = p[0], pitch = p[1], wheel = p[3];
    int strands = (int)p[2], links = shaper_amount(s, (int)(length / pitch)),
        sides = shaper_sides(s, 12, 4);
    for (int strand = 0; strand < strands; ++strand) {
        double z = (strand - 0.5 * (strands - 1)) * 0.8;
        for (int i = 0; i < links; ++i) {
            for (int low = 0; low < 2; ++low) {
                stp_affine before =
                    shaper_move(s, length * ((double)i / links - 0.5), low ? 0 : 2 * wheel, z);
                link(s, pitch, sides);
                shaper_pop(s, before);
            }
        }
        for (int end = -1; end <= 1; end += 2) {
            stp_affine before = shaper_push(
                s, place_along(vec3d(end * 0.5 * length, wheel, z - 0.2 * pitch), vec3d(0, 0, 1)));
            detail_gear(s, wheel, 0.4 * pitch, 6 + (int)(5.0 * wheel / pitch));
            detail_bearing(s, 0.2 * wheel, 0.5 * wheel, 0.8 * pitch);
            shaper_pop(s, before);
        }
    }
}

void part_crane(shaper* s, const double* p)
{
    double span = p[0], h = p[1];
    for (int side = -1; side <= 1; side += 2) {
        shape_beam(s, PROFILE_I, vec3d(-0.5 * span, h, side * 1.4),
                   vec3d(0.5 * span, h, side * 1.4), 1.2, 0.5, 0.02);
        detail_railing(s, vec3d(-0.5 * span, h + 0.6, side * 1.6),
                       vec3d(0.5 * span, h + 0.6, side * 1.6));
        stp_affine before = shaper_push(s, place_by_turn(side * 0.5 * span, h - 0.3, 0, 0));
        shape_box(s, 0, 0, 0, 0.4, 0.5, 5.0);
        for (int i = -1; i <= 1; i += 2) {
            stp_affine wheel =
                shaper_push(s, place_along(vec3d(-0.15, -0.3, 2.0 * i), vec3d(1, 0, 0)));
            shape_ring_solid(s, 0.08, 0.3, 0.2, shaper_sides(s, 32, 8));
            detail_bearing(s, 0.08, 0.16, 0.1);
            shaper_pop(s, wheel);
        }
        shaper_pop(s, before);
    }
    shape_box(s, 2.0, h + 1.0, 0, 3.0, 0.8, 2.4);
    stp_affine drum = shaper_push(s, place_along(vec3d(2.0, h + 1.8, -1.2), vec3d(0, 0, 1)));
    shape_cylinder(s, 0.35, 2.4, shaper_sides(s, 32, 8));
    shape_coil(s, 0.37, 0.012, 0.026, shaper_amount(s, 80), shaper_sides(s, 32, 8), 5);
    shaper_move(s, 0, 2.6, 0);
    detail_motor(s, 0.35, 1.0);
    shaper_pop(s, drum);
    for (int i = 0; i < 8; ++i) {
        double x = 1.7 + 0.08 * i;
        shape_straight(s, vec3d(x, h - 7.0, 0), vec3d(x, h + 1.6, 0), 0.012, 6);
    }
    shape_box(s, 2.0, h - 7.3, 0, 0.8, 0.7, 0.4);
    drum = shaper_push(s, place_along(vec3d(2.0, h - 8.2, -0.05), vec3d(0, 0, 1)));
    shape_torus(s, 0.28, 0.06, shaper_sides(s, 28, 8), shaper_sides(s, 12, 4));
    shaper_pop(s, drum);
    detail_lattice(s, vec3d(-0.5 * span, h - 0.9, 0), vec3d(0.5 * span, h - 0.9, 0), 0.5, 20);
}
