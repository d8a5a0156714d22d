// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

// A dished end: a quarter ellipse of `steps` rows from the cylinder to the axis.
static int dished(double (*profile)[2], int n, double radius, double y, double rise, int steps)
{
    for (int i = 0; i <= steps; ++i) {
        double turns = 0.25 * i / steps;
        profile[n][0] = i == steps ? 0.0 : radius * turn_cosine(turns);
        profile[n++][1] = y + rise * turn_sine(turns);
    }
    return n;
}

static void manhole(shaper* s, double radius)
{
    double neck[4][2] = {
        {radius, -0.1}, {radius, 0.25}, {0.9 * radius, 0.25}, {0.9 * radius, -0.1}};
    shape_lathe(s, (const double(*)[2])neck, 4, shaper_sides(s, 32, 6));
    stp_affine before = shaper_move(s, 0, 0.25, 0);
    detail_blind_flange(s, radius);
    shaper_pop(s, before);
}

static void nozzle(shaper* s, double radius)
{
    double neck[2][2] = {{radius, -0.1}, {radius, 0.3}};
    shape_lathe(s, (const double(*)[2])neck, 2, shaper_sides(s, 24, 6));
    stp_affine before = shaper_move(s, 0, 0.3, 0);
    detail_flange_pair(s, radius);
    shaper_pop(s, before);
}

// Nozzles and a manhole around a shell that stands along y.
static void shell_fittings(shaper* s, double r, double low, double high, int nozzles)
{
    int count = shaper_amount(s, nozzles);
    for (int i = 0; i < count; ++i) {
        double turns = shaper_random(s), y = shaper_between(s, low, high);
        double c = turn_cosine(turns), d = turn_sine(turns);
        stp_affine before = shaper_push(s, place_along(vec3d(r * c, y, r * d), vec3d(c, 0, d)));
        if (i % 4 == 0) {
            manhole(s, 0.28);
        } else {
            nozzle(s, shaper_between(s, 0.04, 0.15));
        }
        shaper_pop(s, before);
    }
}

void part_tank(shaper* s, const double* p)
{
    double r = p[0], h = p[1], profile[40][2];
    int n = 0, sides = shaper_sides(s, 96, 12), rings = shaper_amount(s, 1 + (int)(h / 2.0));
    profile[n][0] = 0;
    profile[n++][1] = 0;
    profile[n][0] = r;
    profile[n++][1] = 0;
    n = dished(profile, n, r, h, 0.3 * r, 8);
    shape_lathe(s, (const double(*)[2])profile, n, sides);
    for (int i = 0; i < rings; ++i) { // welds and stiffeners
        stp_affine before = shaper_move(s, 0, h * (i + 0.5) / rings, 0);
        shape_torus(s, r, 0.008, sides, 5);
        shaper_pop(s, before);
    }
    shell_fittings(s, r, 0.5, h - 0.4, (int)p[2]);
    double inside[2][2] = {{r - 0.01, h - 0.1}, {r - 0.01, 0.1}}; // the inner wall
    shape_lathe(s, (const double(*)[2])inside, 2, sides);
    part_ladder(s, PARAMETERS(h + 1.0, r));
    int posts = shaper_amount(s, (int)(r * 5.0));
    stp_affine top = shaper_move(s, 0, h, 0);
    for (int i = 0; i < posts; ++i) {
        double a = (double)i / posts, b = (i + 1.0) / posts;
        detail_railing(s, vec3d(0.97 * r * turn_cosine(a), 0, 0.97 * r * turn_sine(a)),
                       vec3d(0.97 * r * turn_cosine(b), 0, 0.97 * r * turn_sine(b)));
    }
    shaper_pop(s, top);
    detail_bolt_ring(s, r + 0.08, 40, 0.04, 0.1);
    shape_ring_solid(s, r, r + 0.16, 0.02, sides);
}

// A drum along x with dished ends, at the origin.
static void drum(shaper* s, double r, double length, int nozzles)
{
    double profile[40][2];
    int n = 0, steps = 7;
    for (int i = 0; i <= steps; ++i, ++n) {
        double turns = 0.25 * i / steps;
        profile[n][0] = r * turn_sine(turns);
        profile[n][1] = -0.5 * r * turn_cosine(turns);
    }
    profile[0][0] = 0;
    n = dished(profile, n, r, length, 0.5 * r, steps);
    stp_affine before = shaper_push(s, place_along(vec3d(-0.5 * length, 0, 0), vec3d(1, 0, 0)));
    shape_lathe(s, (const double(*)[2])profile, n, shaper_sides(s, 64, 10));
    for (int i = 0; i <= 4; ++i) {
        stp_affine weld = shaper_move(s, 0, length * i / 4.0, 0);
        shape_torus(s, r, 0.01, shaper_sides(s, 64, 10), 5);
        shaper_pop(s, weld);
    }
    shell_fittings(s, r, 0.3, length - 0.3, nozzles);
    shaper_pop(s, before);
}

static void saddles(shaper* s, double r, double length, double height)
{
    for (int side = -1; side <= 1; side += 2) {
        double x = side * 0.32 * length;
        shape_box(s, x, 0.5 * (height - 0.8 * r), 0, 0.03, height - 0.8 * r, 1.7 * r);
        shape_box(s, x, 0.02, 0, 0.4, 0.04, 1.8 * r);
        for (int i = 0; i < 5; ++i) {
            shape_box(s, x, 0.5 * (height - 0.9 * r), r * (0.4 * i - 0.8), 0.35, height - 0.9 * r,
                      0.02);
        }
        for (int i = 0; i < 4; ++i) {
            stp_affine at =
                shaper_move(s, x + (i & 1 ? 0.12 : -0.12), 0.04, (i & 2 ? 0.7 : -0.7) * r);
            detail_bolt(s, 0.036, 0.1);
            shaper_pop(s, at);
        }
    }
}

void part_vessel(shaper* s, const double* p)
{
    stp_affine before = shaper_move(s, 0, p[3], 0);
    drum(s, p[0], p[1], (int)p[2]);
    shaper_pop(s, before);
    saddles(s, p[0], p[1], p[3]);
}

void part_heat_exchanger(shaper* s, const double* p)
{
    double r = p[0], length = p[1], h = 1.6 * r + 0.2;
    stp_affine before = shaper_move(s, 0, h, 0);
    drum(s, r, length, 8);
    int tubes = shaper_amount(s, (int)p[2]), sides = shaper_sides(s, 10, 4);
    int across = 1 + (int)sqrt(1.3 * tubes);
    double pitch = 1.76 * r / across, half = 0.44 * length;
    for (int i = 0; i < across * across; ++i) { // the tubes within, in a staggered grid
        double y = (i / across - 0.5 * (across - 1)) * pitch;
        double z = (i % across - 0.5 * (across - 1) + (i / across % 2 ? 0.25 : -0.25)) * pitch;
        if (y * y + z * z < 0.8 * r * r) {
            shape_straight(s, vec3d(-half, y, z), vec3d(half, y, z), 0.36 * pitch, sides);
        }
    }
    int baffles = shaper_amount(s, 9);
    for (int i = 0; i < baffles; ++i) {
        stp_affine at = shaper_push(
            s, place_along(vec3d(2 * half * ((i + 0.5) / baffles - 0.5), 0, 0), vec3d(1, 0, 0)));
        shape_cylinder(s, 0.95 * r, 0.012, shaper_sides(s, 40, 8));
        shaper_pop(s, at);
    }
    for (int end = -1; end <= 1; end += 2) {
        stp_affine at = shaper_push(s, place_along(vec3d(end * half, 0, 0), vec3d(end, 0, 0)));
        shape_ring_solid(s, r, 1.18 * r, 0.1, shaper_sides(s, 64, 10));
        shaper_move(s, 0, 0.1, 0);
        detail_bolt_ring(s, 1.1 * r, 36, 0.035, 0.2);
        shaper_pop(s, at);
    }
    shaper_pop(s, before);
    saddles(s, r, length, h);
}

void part_cooling_shell(shaper* s, const double* p)
{
    double profile[96][2], h = p[0], waist = 0.75 * h, spread = p[1] / p[2];
    int rows = shaper_sides(s, 40, 8), n = 0, sides = shaper_sides(s, 160, 24);
    rows = rows > 44 ? 44 : rows;
    double b = waist * waist / (spread * spread - 1.0);
    for (int side = 0; side < 2; ++side) { // outside upwards, inside downwards
        for (int i = 0; i <= rows; ++i, ++n) {
            double y = 8.0 + (h - 8.0) * (side ? rows - i : i) / rows, from = y - waist;
            double thick = 0.25 + 0.5 * (1.0 - y / h);
            profile[n][0] = p[2] * sqrt(1.0 + from * from / b) - (side ? thick : 0.0);
            profile[n][1] = y;
        }
    }
    profile[n][0] = profile[0][0];
    profile[n++][1] = profile[0][1];
    shape_lathe(s, (const double(*)[2])profile, n, sides);
    for (int i = 0; i < 4; ++i) { // stiffening rings
        stp_affine before = shaper_move(s, 0, h - 0.3 - 0.5 * i, 0);
        shape_torus(s, profile[rows][0] + 0.1, 0.12, sides, 8);
        shaper_pop(s, before);
    }
    stp_affine before = shaper_move(s, 0, h, 0);
    int posts = shaper_amount(s, 120);
    for (int i = 0; i < posts; ++i) {
        double a = (double)i / posts, c = (i + 1.0) / posts, r = profile[rows][0] - 0.1;
        detail_railing(s, vec3d(r * turn_cosine(a), 0, r * turn_sine(a)),
                       vec3d(r * turn_cosine(c), 0, r * turn_sine(c)));
    }
    shaper_pop(s, before);
}

void part_cooling_legs(shaper* s, const double* p)
{
    int legs = shaper_amount(s, (int)p[2]);
    double r = p[0], h = p[1];
    for (int i = 0; i < legs; ++i) {
        double a = (double)i / legs, b = (i + 0.5) / legs;
        stp_vec3d foot = vec3d(1.04 * r * turn_cosine(a), 0, 1.04 * r * turn_sine(a));
        for (int side = -1; side <= 1; side += 2) {
            double t = a + side * (b - a);
            shape_straight(s, foot, vec3d(r * turn_cosine(t), h + 0.3, r * turn_sine(t)), 0.4,
                           shaper_sides(s, 16, 5));
        }
        stp_affine base = shaper_push(s, place_by_turn(foot.x, 0.6, foot.z, -a));
        shape_box(s, 0, 0, 0, 2.0, 1.2, 2.0);
        shaper_pop(s, base);
    }
    double basin[5][2] = {{1.1 * r, 0}, {1.1 * r, 1.5}, {1.08 * r, 1.5}, {1.08 * r, 0.1}, {0, 0.1}};
    shape_lathe(s, (const double(*)[2])basin, 5, shaper_sides(s, 160, 24));
}

void part_cooling_fill(shaper* s, const double* p)
{
    double r = p[0], h = p[1], pitch = p[2];
    int rows = shaper_amount(s, (int)(2 * r / pitch)), sides = shaper_sides(s, 8, 4);
    for (int i = 0; i < rows; ++i) { // distribution pipes with sprays, on beams
        double z = 2 * r * ((i + 0.5) / rows - 0.5), half = sqrt(r * r - z * z);
        shape_straight(s, vec3d(-half, h, z), vec3d(half, h, z), 0.1, sides);
        shape_box(s, 0, h - 1.0, z, 2 * half, 0.3, 0.15);
        shape_box(s, 0, h - 0.5, z, 2 * half, 0.5, 0.004);
        int sprays = shaper_amount(s, (int)(2 * half / 0.9));
        for (int k = 0; k < sprays; ++k) {
            double x = 2 * half * ((k + 0.5) / sprays - 0.5);
            double cone[3][2] = {{0.02, 0}, {0.06, 0.12}, {0.02, 0.2}};
            stp_affine at = shaper_move(s, x, h - 0.3, z);
            shape_lathe(s, (const double(*)[2])cone, 3, sides);
            shaper_pop(s, at);
        }
    }
}

void part_chimney(shaper* s, const double* p)
{
    double h = p[0],
           profile[8][2] = {
               {p[1], 0}, {p[1], 0.04 * h}, {p[2], h}, {p[2] - 0.2, h}, {p[1] - 0.4, 0.04 * h}};
    int sides = shaper_sides(s, 72, 10), storeys = 6;
    shape_lathe(s, (const double(*)[2])profile, 5, sides);
    for (int i = 1; i <= storeys; ++i) {
        double y = h * i / storeys - 1.5, r = p[1] + (p[2] - p[1]) * y / h;
        stp_affine before = shaper_move(s, 0, y, 0);
        shape_ring_solid(s, r - 0.1, r + 1.3, 0.05, sides);
        int posts = shaper_amount(s, 28);
        for (int k = 0; k < posts; ++k) {
            double a = (double)k / posts, b = (k + 1.0) / posts, out = r + 1.25;
            detail_railing(s, vec3d(out * turn_cosine(a), 0, out * turn_sine(a)),
                           vec3d(out * turn_cosine(b), 0, out * turn_sine(b)));
        }
        shaper_pop(s, before);
    }
    part_ladder(s, PARAMETERS(h, p[1]));
    for (int i = 0; i < 4; ++i) { // stays for the flues inside
        stp_affine before = shaper_push(s, place_by_turn(0, 0.04 * h, 0, 0.25 * i));
        shape_straight(s, vec3d(0.35 * p[2], 0, 0), vec3d(0.35 * p[2], 0.98 * h, 0), 0.28 * p[2],
                       shaper_sides(s, 40, 8));
        shaper_pop(s, before);
    }
}
