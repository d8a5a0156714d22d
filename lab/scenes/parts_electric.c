// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

// A porcelain insulator with sheds.
static void insulator(shaper* s, double radius, double height, int sheds)
{
    enum { MOST_SHEDS = 20 };
    double profile[4 * MOST_SHEDS + 4][2];
    int n = 0, count = shaper_amount(s, sheds < MOST_SHEDS ? sheds : MOST_SHEDS);
    profile[n][0] = 0;
    profile[n++][1] = 0;
    for (int i = 0; i < count; ++i) {
        double y = height * i / count, step = height / count, out = i & 1 ? 0.85 : 1.0;
        double rows[4][2] = {{0.45, 0.0}, {0.5, 0.4}, {out, 0.5}, {0.5, 0.75}};
        for (int k = 0; k < 4; ++k, ++n) {
            profile[n][0] = radius * rows[k][0];
            profile[n][1] = y + step * rows[k][1];
        }
    }
    profile[n][0] = 0.45 * radius;
    profile[n++][1] = height;
    profile[n][0] = 0;
    profile[n++][1] = height;
    shape_lathe(s, (const double(*)[2])profile, n, shaper_sides(s, 18, 6));
}

void part_cable_tray(shaper* s, const double* p)
{
    double length = p[0], w = p[1], h = p[4];
    int levels = (int)p[3], cables = shaper_amount(s, (int)p[2]);
    int rungs = shaper_amount(s, (int)(length / 0.3)), sides = shaper_sides(s, 6, 3);
    int points = 2 + shaper_amount(s, (int)(length / 1.5));
    points = points > 96 ? 96 : points;
    for (int level = 0; level < levels; ++level) {
        double y = h + 0.35 * level;
        for (int side = -1; side <= 1; side += 2) {
            shape_beam(s, PROFILE_U, vec3d(-0.5 * length, y, side * 0.5 * w),
                       vec3d(0.5 * length, y, side * 0.5 * w), 0.1, 0.03, 0.0015);
        }
        for (int i = 0; i < rungs; ++i) {
            shape_box(s, length * ((i + 0.5) / rungs - 0.5), y - 0.04, 0, 0.03, 0.015, w);
        }
        for (int i = 0; i < cables; ++i) {
            stp_vec3d path[96];
            double r = shaper_between(s, 0.005, 0.016), z = w * (0.9 * shaper_random(s) - 0.45);
            double up = y - 0.03 + r + 0.06 * shaper_random(s);
            double from = shaper_random(s) < 0.3 ? shaper_random(s) * 0.5 : 0.0;
            for (int k = 0; k < points; ++k) {
                double t = from + (1.0 - from) * k / (points - 1.0);
                double sag = 0.008 * shaper_random(s), wander = 0.03 * (shaper_random(s) - 0.5);
                path[k] = vec3d(length * (t - 0.5), up + sag, z + wander);
            }
            shape_tube(s, path, points, r, sides, SHAPE_CAPPED);
        }
    }
    int hangers = shaper_amount(s, 1 + (int)(length / 2.0));
    for (int i = 0; i <= hangers; ++i) {
        double x = (length - 0.1) * ((double)i / hangers - 0.5), top = h + 0.35 * levels + 0.3;
        shape_beam(s, PROFILE_U, vec3d(x, h - 0.1, 0.5 * w + 0.05), vec3d(x, top, 0.5 * w + 0.05),
                   0.06, 0.04, 0.003);
        for (int level = 0; level < levels; ++level) {
            double y = h + 0.35 * level - 0.07;
            shape_beam(s, PROFILE_U, vec3d(x, y, -0.5 * w), vec3d(x, y, 0.5 * w), 0.04, 0.04,
                       0.003);
        }
    }
}

void part_cabinets(shaper* s, const double* p)
{
    int count = shaper_amount(s, (int)p[0]);
    double h = p[1], w = 0.8, d = 0.6, t = 0.0015;
    for (int i = 0; i < count; ++i) {
        double x = (i - 0.5 * (count - 1)) * w;
        shape_box(s, x, 0.05, 0, w, 0.1, d);
        shape_box(s, x, h - 0.5 * t, 0, w - 0.004, t, d);
        shape_box(s, x, 0.5 * h, -0.5 * d, w - 0.004, h - 0.1, t);
        for (int side = -1; side <= 1; side += 2) {
            shape_box(s, x + side * (0.5 * w - 0.003), 0.5 * h, 0, t, h - 0.1, d);
        }
        shape_box(s, x, 0.5 * h + 0.05, 0.5 * d, w - 0.01, h - 0.12, t); // door
        shape_box(s, x + 0.33, 0.5 * h, 0.5 * d + 0.02, 0.03, 0.16, 0.03);
        int slots = shaper_amount(s, 60), lamps = shaper_amount(s, 12);
        for (int k = 0; k < slots; ++k) {
            shape_box(s, x + 0.3 * (k % 2 ? 0.5 : -0.5), 0.2 + 0.008 * k, 0.5 * d + 0.002, 0.25,
                      0.003, 0.004);
        }
        for (int k = 0; k < lamps; ++k) {
            stp_affine at = shaper_push(
                s, place_along(vec3d(x + 0.08 * (k % 6) - 0.2, h - 0.3 - 0.12 * (k / 6), 0.5 * d),
                               vec3d(0, 0, 1)));
            shape_cylinder(s, 0.012, 0.02, shaper_sides(s, 16, 5));
            shaper_pop(s, at);
        }
    }
}

void part_cabinet_wires(shaper* s, const double* p)
{
    int count = shaper_amount(s, (int)p[0]);
    double h = p[1];
    for (int i = 0; i < count; ++i) {
        double x = (i - 0.5 * (count - 1)) * 0.8;
        int rails = shaper_amount(s, 6);
        for (int rail = 0; rail < rails; ++rail) {
            double y = 0.3 + (h - 0.5) * rail / rails;
            shape_box(s, x, y, -0.2, 0.66, 0.035, 0.008);
            int terminals = shaper_amount(s, 40), sides = shaper_sides(s, 6, 3);
            for (int k = 0; k < terminals; ++k) {
                double tx = x + 0.016 * k - 0.32;
                shape_box(s, tx, y, -0.16, 0.012, 0.06 + 0.03 * (k % 3), 0.06);
                double way[4];
                for (int n = 0; n < 4; ++n) {
                    way[n] = shaper_random(s);
                }
                stp_vec3d wire[5] = {{tx, y - 0.04, -0.15},
                                     {tx, y - 0.08 - 0.04 * way[0], -0.13},
                                     {x + 0.36, y - 0.1 - 0.03 * way[1], -0.14},
                                     {x + 0.37, y - 0.2, -0.15 + 0.03 * way[2]},
                                     {x + 0.37, 0.12, -0.15 + 0.03 * way[3]}};
                shape_tube(s, wire, 5, 0.0018, sides, SHAPE_OPEN);
            }
        }
    }
}

void part_transformer(shaper* s, const double* p)
{
    double l = p[0], h = p[1], w = p[2];
    shape_box(s, 0, 0.3 + 0.5 * h, 0, l, h, w);
    shape_box(s, 0, 0.3 + h, 0, l * 1.04, 0.06, w * 1.06);
    int bolts = shaper_amount(s, 60);
    for (int i = 0; i < bolts; ++i) {
        for (int side = -1; side <= 1; side += 2) {
            stp_affine at =
                shaper_move(s, l * ((i + 0.5) / bolts - 0.5), 0.33 + h, side * 0.515 * w);
            detail_bolt(s, 0.02, 0.08);
            shaper_pop(s, at);
        }
    }
    int banks = shaper_amount(s, 10), fins = shaper_amount(s, 26);
    for (int side = -1; side <= 1; side += 2) {
        for (int bank = 0; bank < banks; ++bank) {
            double x = l * ((bank + 0.5) / banks - 0.5);
            for (int fin = 0; fin < fins; ++fin) {
                shape_box(s, x, 0.4 + 0.5 * h, side * (0.5 * w + 0.15 + 0.035 * fin),
                          0.7 * l / banks, 0.8 * h, 0.012);
            }
            shape_straight(s, vec3d(x, 0.4 + 0.88 * h, side * 0.5 * w),
                           vec3d(x, 0.4 + 0.88 * h, side * (0.6 * w + 0.9)), 0.05,
                           shaper_sides(s, 14, 5));
            shape_straight(s, vec3d(x, 0.5, side * 0.5 * w), vec3d(x, 0.5, side * (0.6 * w + 0.9)),
                           0.05, shaper_sides(s, 14, 5));
        }
    }
    stp_affine tank =
        shaper_push(s, place_along(vec3d(-0.4 * l, h + 1.9, -0.3 * w), vec3d(1, 0, 0)));
    shape_cylinder(s, 0.45, 0.7 * l, shaper_sides(s, 40, 8));
    detail_blind_flange(s, 0.3);
    shaper_pop(s, tank);
    for (int i = -1; i <= 1; ++i) {
        shape_beam(s, PROFILE_I, vec3d(0.25 * l * i, h + 0.3, -0.3 * w),
                   vec3d(0.25 * l * i, h + 1.5, -0.3 * w), 0.15, 0.15, 0.01);
    }
    for (int wheel = 0; wheel < 4; ++wheel) {
        stp_affine at = shaper_push(s, place_along(vec3d((wheel & 1 ? 0.4 : -0.4) * l, 0.15,
                                                         (wheel & 2 ? 0.35 : -0.35) * w),
                                                   vec3d(0, 0, 1)));
        shape_ring_solid(s, 0.04, 0.15, 0.12, shaper_sides(s, 28, 6));
        shaper_pop(s, at);
    }
}

void part_insulators(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[0]), rows = (int)p[1];
    double h = p[4], base = p[5];
    for (int i = 0; i < columns; ++i) {
        for (int k = 0; k < rows; ++k) {
            stp_affine at = shaper_move(s, (i - 0.5 * (columns - 1)) * p[2], base,
                                        (k - 0.5 * (rows - 1)) * p[3]);
            insulator(s, 0.12 * h, h, 11);
            stp_affine head = shaper_move(s, 0, h, 0);
            shape_cylinder(s, 0.05 * h, 0.1 * h, shaper_sides(s, 20, 5));

            shaper_pop(s, head);
            if (base > 0.5) {
                shaper_move(s, 0, -base, 0);
                detail_lattice(s, vec3d(0, 0, 0), vec3d(0, base, 0), 0.35, 4);
            }
            shaper_pop(s, at);
        }
    }
}

void part_wires(shaper* s, const double* p)
{
    enum { STEPS = 24 };
    int count = shaper_amount(s, (int)p[2]), sides = shaper_sides(s, 8, 3);
    for (int i = 0; i < count; ++i) {
        stp_vec3d path[STEPS + 1];
        double z = count > 1 ? p[1] * ((double)i / (count - 1) - 0.5) : 0;
        for (int k = 0; k <= STEPS; ++k) {
            double t = (double)k / STEPS;
            path[k] = vec3d(p[0] * (t - 0.5), p[3] - 4.0 * p[4] * t * (1.0 - t), z);
        }
        shape_tube(s, path, STEPS + 1, 0.016, sides, SHAPE_CAPPED);
    }
}

void part_lamps(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[2]), rows = (int)p[3];
    for (int i = 0; i < columns; ++i) {
        for (int k = 0; k < rows; ++k) {
            stp_affine at = shaper_move(s, p[0] * ((i + 0.5) / columns - 0.5), p[4],
                                        p[1] * ((k + 0.5) / rows - 0.5));
            shape_box(s, 0, 0, 0, 1.5, 0.05, 0.16);
            for (int tube = -1; tube <= 1; tube += 2) {
                shape_straight(s, vec3d(-0.7, -0.04, tube * 0.04), vec3d(0.7, -0.04, tube * 0.04),
                               0.013, shaper_sides(s, 10, 4));
            }
            shape_straight(s, vec3d(-0.5, 0, 0), vec3d(-0.5, 1.2, 0), 0.003, 4);
            shape_straight(s, vec3d(0.5, 0, 0), vec3d(0.5, 1.2, 0), 0.003, 4);
            shaper_pop(s, at);
        }
    }
}
