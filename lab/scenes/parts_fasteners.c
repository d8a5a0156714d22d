// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

static void hexagon(double radius, double outline[6][2])
{
    for (int i = 0; i < 6; ++i) {
        outline[i][0] = radius * turn_cosine(i / 6.0);
        outline[i][1] = radius * turn_sine(i / 6.0);
    }
}

// `sides` is a parameter so that all bolts of a ring look alike.
static void bolt(shaper* s, double diameter, double length, int sides)
{
    double outline[6][2], r = 0.5 * diameter;
    hexagon(0.9 * diameter, outline);
    stp_affine seat = shaper_move(s, 0, 0.18 * diameter, 0);
    shape_prism(s, (const double(*)[2])outline, 6, 0, 0.6 * diameter);
    shaper_pop(s, seat);
    shape_ring_solid(s, r * 1.05, diameter, 0.18 * diameter, sides);
    seat = shaper_move(s, 0, -length, 0);
    shape_cylinder(s, 0.86 * r, length, sides);
    double thread = length < 1.2 * diameter ? length : 1.2 * diameter;
    shape_thread(s, r, 0.24 * diameter, thread, sides);
    shaper_move(s, 0, 0.35 * diameter, 0);
    shape_prism(s, (const double(*)[2])outline, 6, r, 0.7 * diameter);
    shaper_pop(s, seat);
}

void detail_bolt(shaper* s, double diameter, double length)
{
    bolt(s, diameter, length, shaper_sides(s, 8, 4));
}

void detail_hexagon_head(shaper* s, double diameter)
{
    double outline[6][2];
    hexagon(0.9 * diameter, outline);
    shape_prism(s, (const double(*)[2])outline, 6, 0, 0.6 * diameter);
}

void detail_bolt_ring(shaper* s, double radius, int count, double diameter, double length)
{
    int bolts = shaper_amount(s, count), sides = shaper_sides(s, 8, 4);
    for (int i = 0; i < bolts; ++i) {
        double turns = (double)i / bolts;
        stp_affine ring = shaper_move(s, radius * turn_cosine(turns), 0, radius * turn_sine(turns));
        bolt(s, diameter, length, sides);
        shaper_pop(s, ring);
    }
}

static int bolts_of(double pipe_radius)
{
    int count = 4 * (int)(1.0 + pipe_radius * 18.0);
    return count > 32 ? 32 : count;
}

void detail_flange_pair(shaper* s, double r)
{
    double t = 0.014 + 0.12 * r, outer = 1.55 * r + 0.035, neck = r + 0.35 * (outer - r),
           h = 2.2 * t;
    double profile[12][2] = {{0.92 * r, -h},  {r, -h},      {neck, -t},       {outer, -t},
                             {outer, -0.002}, {1.2 * r, 0}, {1.2 * r, 0.002}, {outer, 0.004},
                             {outer, t},      {neck, t},    {r, h},           {0.92 * r, h}};
    shape_lathe(s, (const double(*)[2])profile, 12, shaper_sides(s, 28, 6));
    stp_affine face = shaper_move(s, 0, t, 0);
    double bolt_circle = 0.5 * (neck + outer) + 0.1 * (outer - neck);
    detail_bolt_ring(s, bolt_circle, bolts_of(r), 0.28 * (outer - r), 2.0 * t + 0.1 * r);
    shaper_pop(s, face);
}

void detail_blind_flange(shaper* s, double r)
{
    double t = 0.014 + 0.12 * r, outer = 1.55 * r + 0.035;
    double profile[8][2] = {{0.92 * r, -2.2 * t}, {r, -2.2 * t}, {1.2 * r, -t},      {outer, -t},
                            {outer, t},           {r, t},        {0.9 * r, 1.1 * t}, {0, 1.1 * t}};
    shape_lathe(s, (const double(*)[2])profile, 8, shaper_sides(s, 28, 6));
    stp_affine face = shaper_move(s, 0, t, 0);
    detail_bolt_ring(s, 0.5 * (r + outer) + 0.1 * (outer - r), bolts_of(r), 0.26 * (outer - r),
                     2.0 * t);
    shaper_pop(s, face);
}

static void hand_wheel(shaper* s, double radius)
{
    shape_torus(s, radius, 0.07 * radius, shaper_sides(s, 40, 6), shaper_sides(s, 8, 4));
    shape_cylinder(s, 0.16 * radius, 0.16 * radius, shaper_sides(s, 16, 5));
    int spokes = 5, sides = shaper_sides(s, 8, 3);
    for (int i = 0; i < spokes; ++i) {
        double c = turn_cosine(i / 5.0), d = turn_sine(i / 5.0);
        stp_vec3d spoke[4] = {{0.1 * radius * c, 0.08 * radius, 0.1 * radius * d},
                              {0.4 * radius * c, 0.08 * radius, 0.4 * radius * d},
                              {0.7 * radius * c, 0.02 * radius, 0.7 * radius * d},
                              {0.97 * radius * c, 0, 0.97 * radius * d}};
        shape_tube(s, spoke, 4, 0.045 * radius, sides, SHAPE_OPEN);
    }
}

void detail_valve(shaper* s, double r)
{
    double l = 2.2 * r + 0.05;
    double body[10][2] = {{0.9 * r, -l},        {r, -l},      {1.1 * r, -0.8 * l},
                          {1.5 * r, -0.45 * l}, {1.7 * r, 0}, {1.5 * r, 0.45 * l},
                          {1.1 * r, 0.8 * l},   {r, l},       {0.9 * r, l},
                          {0.9 * r, l}};
    shape_lathe(s, (const double(*)[2])body, 9, shaper_sides(s, 28, 6));
    for (int end = -1; end <= 1; end += 2) {
        stp_affine before = shaper_move(s, 0, end * l, 0);
        detail_flange_pair(s, r);
        shaper_pop(s, before);
    }
    stp_affine before = shaper_push(s, place_along(vec3d(0, 0, 0), vec3d(1, 0, 0)));
    double bonnet[8][2] = {{1.2 * r, 0},       {1.2 * r, 1.8 * r}, {1.7 * r, 1.9 * r},
                           {1.7 * r, 2.3 * r}, {r, 2.35 * r},      {0.5 * r, 3.2 * r},
                           {0.4 * r, 3.6 * r}, {0, 3.6 * r}};
    shape_lathe(s, (const double(*)[2])bonnet, 8, shaper_sides(s, 24, 6));
    shaper_move(s, 0, 2.3 * r, 0);
    detail_bolt_ring(s, 1.48 * r, 8, 0.2 * r, 0.5 * r);
    shape_bar(s, vec3d(0.5 * r, 0, 0), vec3d(0.35 * r, 3.6 * r, 0), 0.15 * r, 0.3 * r);
    shape_bar(s, vec3d(-0.5 * r, 0, 0), vec3d(-0.35 * r, 3.6 * r, 0), 0.15 * r, 0.3 * r);
    shaper_move(s, 0, 0.8 * r, 0);
    shape_cylinder(s, 0.13 * r, 4.6 * r, shaper_sides(s, 12, 4));
    shape_thread(s, 0.16 * r, 0.12 * r, 4.2 * r, shaper_sides(s, 10, 4));
    shaper_move(s, 0, 2.8 * r, 0);
    hand_wheel(s, 1.7 * r + 0.05);
    shaper_pop(s, before);
}

void detail_pipe_support(shaper* s, double r, double height)
{
    double plate = 2.6 * r + 0.1;
    shape_box(s, 0, -r - 0.01, 0, 1.4 * r, 0.012, 0.3);
    shape_box(s, 0, -r - 0.06, 0, 0.01, 0.1, 0.3);
    if (height > r + 0.15) {
        shape_beam(s, PROFILE_I, vec3d(0, -height, 0), vec3d(0, -r - 0.1, 0), 0.1, 0.1, 0.008);
        shape_box(s, 0, 0.008 - height, 0, plate, 0.016, plate);
        for (int i = 0; i < 4; ++i) {
            stp_affine before = shaper_move(s, (i & 1 ? 0.4 : -0.4) * plate, 0.016 - height,
                                            (i & 2 ? 0.4 : -0.4) * plate);
            detail_bolt(s, 0.016, 0.05);
            shaper_pop(s, before);
        }
    }
    stp_vec3d corners[4] = {{-r - 0.008, -r - 0.08, 0},
                            {-r - 0.008, r + 0.008, 0},
                            {r + 0.008, r + 0.008, 0},
                            {r + 0.008, -r - 0.08, 0}};
    stp_vec3d path[40];
    int n = shape_round_path(corners, 4, r + 0.007, shaper_sides(s, 6, 2), path, 40);
    shape_tube(s, path, n, 0.007, shaper_sides(s, 8, 3), SHAPE_CAPPED);
}
