// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"

enum { MOST_POINTS = 256 };

// A pipe along corners, with welds, flange pairs, supports and bends of five steps.
static void pipe(shaper* s, const stp_vec3d* corners, int count, double r)
{
    stp_vec3d path[MOST_POINTS];
    int n = shape_round_path(corners, count, 3.0 * r, shaper_sides(s, 7, 2), path, MOST_POINTS);
    int sides = shaper_sides(s, r > 0.1 ? 28 : 18, 5);
    shape_tube(s, path, n, r, sides, SHAPE_OPEN);
    shape_tube(s, path, n, 0.97 * r, sides, SHAPE_OPEN);
}

static void along(shaper* s, stp_vec3d from, stp_vec3d to, double r, double ground)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way));
    bool level = way.y * way.y < 0.01 * length * length;
    int flanges = shaper_amount(s, 1 + (int)(length / 9.0)), supports = 1 + (int)(length / 4.0);
    for (int i = 0; i < flanges && length > 8.0 * r; ++i) {
        double t = (i + 0.5) / flanges;
        stp_affine before = shaper_push(s, place_along(stp_addd(from, stp_scaled(way, t)), way));
        detail_flange_pair(s, r);
        shaper_pop(s, before);
    }
    supports = shaper_amount(s, supports);
    for (int i = 0; level && i < supports; ++i) {
        stp_vec3d at = stp_addd(from, stp_scaled(way, (i + 0.25) / supports));
        bool across = way.z * way.z > way.x * way.x;
        stp_affine before = shaper_push(s, place_by_turn(at.x, at.y, at.z, across ? 0 : 0.25));
        double leg = at.y - ground; // higher ones hang on steelwork
        detail_pipe_support(s, r, leg < 2.6 ? leg : 0.0);
        shaper_pop(s, before);
    }
    int welds = shaper_amount(s, 1 + (int)(length / 3.0));
    for (int i = 0; i < welds; ++i) {
        stp_affine before = shaper_push(
            s, place_along(stp_addd(from, stp_scaled(way, (i + 0.8) / (welds + 1.0))), way));
        shape_torus(s, r, 0.004 + 0.02 * r, shaper_sides(s, r > 0.1 ? 28 : 18, 5), 5);
        shaper_pop(s, before);
    }
}

void part_pipe_run(shaper* s, const double* p)
{
    double r = p[0], x = p[1], y = p[2], z = p[3], h = p[4], bend = 6.5 * r + 0.1;
    int loops = (int)p[5], valves = (int)p[6], n = 0;
    stp_vec3d corner[MOST_POINTS / 8];
    corner[n++] = vec3d(0, h, 0);
    for (int i = 0; i < loops && n < 20; ++i) { // expansion loops
        double at = x * (i + 0.5) / loops, half = bend, out = (i & 1 ? -2.2 : 2.2) * bend;
        corner[n++] = vec3d(at - half, h, 0);
        corner[n++] = vec3d(at - half, h + (out < 0 ? -out : out), 0);
        corner[n++] = vec3d(at + half, h + (out < 0 ? -out : out), 0);
        corner[n++] = vec3d(at + half, h, 0);
    }
    corner[n++] = vec3d(x, h, 0);
    if (y != 0.0) {
        corner[n++] = vec3d(x, h + y, 0);
    }
    if (z != 0.0) {
        corner[n++] = vec3d(x, h + y, z);
    }
    pipe(s, corner, n, r);
    for (int i = 0; i + 1 < n; ++i) {
        along(s, corner[i], corner[i + 1], r, 0.0);
    }
    valves = shaper_amount(s, valves);
    for (int i = 0; i < valves; ++i) {
        double at = x * (i + 0.2 + 0.5 * shaper_random(s)) / valves;
        stp_affine before = shaper_push(s, place_along(vec3d(at, h, 0), vec3d(1, 0, 0)));
        detail_valve(s, r);
        stp_affine tee = shaper_move(s, 0, 5.0 * r, 0); // a branch with a reducer and a blind end
        shaper_push(s, place_along(vec3d(0, 0, 0), vec3d(0, 0, i & 1 ? -1 : 1)));
        double branch[5][2] = {
            {0.7 * r, 0}, {0.7 * r, 2 * r}, {0.45 * r, 3 * r}, {0.45 * r, 4 * r}, {0.4 * r, 4 * r}};
        shape_lathe(s, (const double(*)[2])branch, 5, shaper_sides(s, 20, 5));
        shaper_move(s, 0, 4 * r, 0);
        detail_blind_flange(s, 0.45 * r);
        shaper_pop(s, tee);
        shaper_pop(s, before);
    }
}

void part_pipe_rack(shaper* s, const double* p)
{
    double length = p[0], width = p[1], largest = p[3], h = p[4];
    int pipes = shaper_amount(s, (int)p[2]);
    for (int i = 0; i < pipes; ++i) {
        double size = shaper_random(s);
        size *= shaper_random(s); // small pipes are more frequent
        double r = largest * (0.12 + 0.88 * size);
        double z = width * ((i + 0.5) / pipes - 0.5), y = h + r;
        double in = 0.12 * length * shaper_random(s), out = 0.12 * length * shaper_random(s);
        double down = shaper_between(s, 0.3, 0.7) * h;
        stp_vec3d corner[4] = {{-0.5 * length + in, y - down, z},
                               {-0.5 * length + in, y, z},
                               {0.5 * length - out, y, z},
                               {0.5 * length - out, y - down, z}};
        pipe(s, corner + (i & 1), i % 3 == 0 ? 2 : 3, r);
        along(s, corner[1], corner[2], r, h - 0.02);
        if (i % 4 == 0) {
            stp_affine before =
                shaper_push(s, place_along(vec3d(length * (shaper_random(s) - 0.5) * 0.6, y, z),
                                           vec3d(1, 0, 0)));
            detail_valve(s, r);
            shaper_pop(s, before);
        }
    }
}

void part_valve_station(shaper* s, const double* p)
{
    double length = p[0], r = p[2], h = 1.1;
    int valves = shaper_amount(s, (int)p[1]);
    for (int side = -1; side <= 1; side += 2) {
        stp_vec3d header[2] = {{-0.5 * length, h, side * 1.0}, {0.5 * length, h, side * 1.0}};
        pipe(s, header, 2, 1.6 * r);
        along(s, header[0], header[1], 1.6 * r, 0.0);
        stp_affine end = shaper_push(s, place_along(header[1], vec3d(1, 0, 0)));
        detail_blind_flange(s, 1.6 * r);
        shaper_pop(s, end);
    }
    for (int i = 0; i < valves; ++i) {
        double x = length * ((i + 0.5) / valves - 0.5);
        stp_vec3d link[4] = {{x, h, -1.0}, {x, h + 0.5, -1.0}, {x, h + 0.5, 1.0}, {x, h, 1.0}};
        stp_vec3d path[MOST_POINTS];
        int n = shape_round_path(link, 4, 2.0 * r, shaper_sides(s, 6, 2), path, MOST_POINTS);
        shape_tube(s, path, n, r, shaper_sides(s, 18, 5), SHAPE_OPEN);
        // the wheel upwards: x of the valve's place is up
        stp_affine up = {{{0, 0, 1, x}, {1, 0, 0, h + 0.5}, {0, 1, 0, 0}}};
        stp_affine before = shaper_push(s, up);
        detail_valve(s, r);
        shaper_pop(s, before);
    }
}

void part_pump_skid(shaper* s, const double* p)
{
    double length = p[0], r = p[2];
    int pumps = shaper_amount(s, (int)p[1]);
    for (int side = -1; side <= 1; side += 2) {
        shape_beam(s, PROFILE_U, vec3d(-0.5 * length, 0.1, side * 0.8),
                   vec3d(0.5 * length, 0.1, side * 0.8), 0.2, 0.08, 0.01);
    }
    for (int i = 0; i < pumps; ++i) {
        double x = length * ((i + 0.5) / pumps - 0.5);
        shape_beam(s, PROFILE_U, vec3d(x, 0.1, -0.8), vec3d(x, 0.1, 0.8), 0.16, 0.06, 0.008);
        stp_affine before =
            shaper_push(s, place_along(vec3d(x, 0.3 + 2.2 * r, -0.75), vec3d(0, 0, 1)));
        double volute[8][2] = {{0.8 * r, -0.8 * r}, {r, -0.8 * r},      {1.2 * r, -0.3 * r},
                               {2.1 * r, -0.2 * r}, {2.3 * r, 0.3 * r}, {2.1 * r, 0.8 * r},
                               {0.6 * r, 0.9 * r},  {0, 1.2 * r}};
        shape_lathe(s, (const double(*)[2])volute, 8, shaper_sides(s, 36, 8));
        stp_affine face = shaper_move(s, 0, -0.8 * r, 0);
        detail_flange_pair(s, 0.9 * r);
        shaper_pop(s, face);
        face = shaper_move(s, 0, 0.8 * r, 0);
        detail_bolt_ring(s, 1.8 * r, 12, 0.12 * r, 0.3 * r);
        shape_cylinder(s, 0.2 * r, 3.0 * r, shaper_sides(s, 16, 5));
        shaper_move(s, 0, 1.4 * r, 0);
        shape_ring_solid(s, 0.2 * r, 0.55 * r, 0.5 * r, shaper_sides(s, 24, 6));
        detail_bolt_ring(s, 0.42 * r, 6, 0.06 * r, 0.3 * r);
        shaper_move(s, 0, 1.4 * r, 0);
        detail_motor(s, 1.3 * r, 4.2 * r);
        shaper_pop(s, before);
        before = shaper_move(s, x, 0.3 + 4.6 * r, -0.75 + 0.3 * r);
        detail_flange_pair(s, 0.7 * r);
        shaper_pop(s, before);
        stp_vec3d out[3] = {
            {x, 0.3 + 2.5 * r, -0.75 + 0.3 * r}, {x, 2.2, -0.75 + 0.3 * r}, {x, 2.2, 1.2}};
        pipe(s, out, 3, 0.7 * r);
    }
    stp_vec3d header[2] = {{-0.5 * length, 2.2, 1.2}, {0.5 * length, 2.2, 1.2}};
    pipe(s, header, 2, 1.2 * r);
    along(s, header[0], header[1], 1.2 * r, 0.0);
}
