// SPDX-License-Identifier: MIT
#include "lab/scenes/parts.h"
#include "lab/scenes/trigonometry.h"

void detail_railing(shaper* s, stp_vec3d from, stp_vec3d to)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way));
    if (length < 0.01) { // a ring of a single piece
        return;
    }
    int posts = shaper_amount(s, 1 + (int)(length / 1.2)), sides = shaper_sides(s, 10, 4);
    for (int i = 0; i <= posts; ++i) {
        stp_vec3d foot = stp_addd(from, stp_scaled(way, (double)i / posts));
        shape_straight(s, foot, stp_addd(foot, vec3d(0, 1.1, 0)), 0.021, sides);
        shape_box(s, foot.x, foot.y + 0.005, foot.z, 0.1, 0.01, 0.1);
    }
    for (int rail = 1; rail <= 2; ++rail) {
        stp_vec3d up = vec3d(0, 0.55 * rail, 0);
        shape_straight(s, stp_addd(from, up), stp_addd(to, up), rail == 2 ? 0.021 : 0.013, sides);
    }
    stp_vec3d toe = vec3d(0, 0.06, 0);
    shape_bar(s, stp_addd(from, toe), stp_addd(to, toe), 0.1, 0.004);
}

// Bars and cross rods of a grating in x, z around the origin, top at y = 0.
static void grating(shaper* s, double width, double depth)
{
    int bars = shaper_amount(s, (int)(width / 0.05) + 1);
    int rods = shaper_amount(s, (int)(depth / 0.15) + 1);
    for (int i = 0; i < bars; ++i) {
        double x = bars > 1 ? width * ((double)i / (bars - 1) - 0.5) : 0.0;
        shape_box(s, x, -0.015, 0, 0.003, 0.03, depth);
    }
    for (int i = 0; i < rods; ++i) {
        double z = rods > 1 ? depth * ((double)i / (rods - 1) - 0.5) : 0.0;
        shape_box(s, 0, -0.004, z, width, 0.005, 0.005);
    }
    shape_box(s, 0, -0.015, -0.5 * depth, width, 0.03, 0.003);
    shape_box(s, 0, -0.015, 0.5 * depth, width, 0.03, 0.003);
}

void detail_lattice(shaper* s, stp_vec3d from, stp_vec3d to, double width, int panels)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way)), half = 0.5 * width, step = length / panels;
    stp_affine before = shaper_push(s, place_along(from, way));
    double chord = 0.08 * width + 0.03, brace = 0.6 * chord;
    for (int i = 0; i < 4; ++i) {
        double x = i & 1 ? half : -half, z = i & 2 ? half : -half;
        shape_beam(s, PROFILE_L, vec3d(x, 0, z), vec3d(x, length, z), chord, chord, 0.1 * chord);
    }
    for (int face = 0; face < 4; ++face) {
        stp_affine side = shaper_push(s, place_by_turn(0, 0, 0, 0.25 * face));
        for (int i = 0; i < panels; ++i) {
            double left = i & 1 ? half : -half, y = i * step;
            shape_beam(s, PROFILE_L, vec3d(left, y, half), vec3d(-left, y + step, half), brace,
                       brace, 0.12 * brace);
            shape_beam(s, PROFILE_L, vec3d(-half, y, half), vec3d(half, y, half), brace, brace,
                       0.12 * brace);
            shape_box(s, left, y, half, 0.22 * width, 0.22 * width, 0.01); // gusset plate
            stp_affine plate =
                shaper_push(s, place_along(vec3d(0.9 * left, y, half + 0.005), vec3d(0, 0, 1)));
            detail_hexagon_head(s, 0.02);
            shaper_pop(s, plate);
        }
        shaper_pop(s, side);
    }
    shaper_pop(s, before);
}

// End plate with four bolts, where a beam meets a column.
static void joint(shaper* s, stp_vec3d at, stp_vec3d way, double h)
{
    stp_affine before = shaper_push(s, place_along(at, way));
    shape_box(s, 0, 0.01, 0, 1.1 * h, 0.02, 0.6 * h);
    for (int i = 0; i < 4; ++i) {
        stp_affine corner =
            shaper_move(s, (i & 1 ? 0.4 : -0.4) * h, 0.02, (i & 2 ? 0.2 : -0.2) * h);
        detail_hexagon_head(s, 0.024);
        shaper_pop(s, corner);
    }
    shaper_pop(s, before);
}

static void frame_beams(shaper* s, const double* p, double y)
{
    double x = p[0], z = p[2], h = p[6] * 0.85;
    int nx = (int)p[3], nz = (int)p[5];
    for (int i = 0; i <= nx; ++i) {
        for (int k = 0; k <= nz; ++k) {
            double ax = x * ((double)i / nx - 0.5), az = z * ((double)k / nz - 0.5);
            if (i < nx) {
                shape_beam(s, PROFILE_I, vec3d(ax, y, az), vec3d(ax + x / nx, y, az), h, 0.5 * h,
                           0.04 * h);
                joint(s, vec3d(ax + 0.5 * p[6], y, az), vec3d(1, 0, 0), h);
                joint(s, vec3d(ax + x / nx - 0.5 * p[6], y, az), vec3d(-1, 0, 0), h);
            }
            if (k < nz) {
                shape_beam(s, PROFILE_I, vec3d(ax, y, az), vec3d(ax, y, az + z / nz), h, 0.5 * h,
                           0.04 * h);
                joint(s, vec3d(ax, y, az + 0.3 * p[6]), vec3d(0, 0, 1), h);
            }
        }
    }
    int joists = shaper_amount(s, nx * 5);
    for (int i = 0; i < joists; ++i) {
        double ax = x * ((i + 0.5) / joists - 0.5);
        shape_beam(s, PROFILE_I, vec3d(ax, y, -0.5 * z), vec3d(ax, y, 0.5 * z), 0.4 * h, 0.2 * h,
                   0.02 * h);
    }
}

void part_frame(shaper* s, const double* p)
{
    double x = p[0], y = p[1], z = p[2], h = p[6];
    int nx = (int)p[3], ny = (int)p[4], nz = (int)p[5];
    for (int i = 0; i <= nx; ++i) {
        for (int k = 0; k <= nz; ++k) {
            double ax = x * ((double)i / nx - 0.5), az = z * ((double)k / nz - 0.5);
            shape_beam(s, PROFILE_I, vec3d(ax, 0, az), vec3d(ax, y, az), h, h, 0.06 * h);
            shape_box(s, ax, 0.02, az, 1.8 * h, 0.04, 1.8 * h);
            for (int c = 0; c < 4; ++c) {
                stp_affine foot = shaper_move(s, ax + (c & 1 ? 0.7 : -0.7) * h, 0.04,
                                              az + (c & 2 ? 0.7 : -0.7) * h);
                detail_hexagon_head(s, 0.036);
                shaper_pop(s, foot);
            }
            for (int level = 0; k < nz && (i == 0 || i == nx) && k % 2 == 0 && level < ny;
                 ++level) {
                double low = y * level / ny, high = y * (level + 1) / ny;
                shape_beam(s, PROFILE_L, vec3d(ax, low, az), vec3d(ax, high, az + z / nz), 0.12,
                           0.12, 0.01);
                shape_beam(s, PROFILE_L, vec3d(ax, high, az), vec3d(ax, low, az + z / nz), 0.12,
                           0.12, 0.01);
            }
        }
    }
    for (int level = 1; level <= ny; ++level) {
        frame_beams(s, p, y * level / ny - 0.5 * h);
    }
}

void part_floor(shaper* s, const double* p)
{
    const double panel = 2.0;
    int nx = (int)(p[0] / panel), nz = (int)(p[1] / panel);
    for (int i = 0; i < nx; ++i) {
        for (int k = 0; k < nz; ++k) {
            double x = (i + 0.5) * panel - 0.5 * p[0], z = (k + 0.5) * panel - 0.5 * p[1];
            bool open = x * x < 0.25 * p[2] * p[2] && z * z < 0.25 * p[3] * p[3];
            if (open || shaper_random(s) > s->amount * 4.0) {
                continue;
            }
            stp_affine before = shaper_move(s, x, 0, z);
            grating(s, panel - 0.01, panel - 0.01);
            shaper_pop(s, before);
        }
    }
}

void part_railings(shaper* s, const double* p)
{
    double x = 0.5 * p[0], z = 0.5 * p[1];
    detail_railing(s, vec3d(-x, 0, -z), vec3d(x, 0, -z));
    detail_railing(s, vec3d(-x, 0, z), vec3d(x, 0, z));
    detail_railing(s, vec3d(-x, 0, -z), vec3d(-x, 0, z));
    detail_railing(s, vec3d(x, 0, -z), vec3d(x, 0, z));
}

// One flight along x: stringers, treads of grating, railings.
static void flight(shaper* s, double run, double rise)
{
    int treads = shaper_amount(s, (int)(rise / 0.2));
    for (int side = -1; side <= 1; side += 2) {
        shape_bar(s, vec3d(0, 0, side * 0.45), vec3d(run, rise, side * 0.45), 0.2, 0.01);
        detail_railing(s, vec3d(0, 0, side * 0.45), vec3d(run, rise, side * 0.45));
    }
    for (int i = 0; i < treads; ++i) {
        stp_affine before = shaper_move(s, run * (i + 0.5) / treads, rise * (i + 1.0) / treads, 0);
        grating(s, 0.26, 0.88);
        shaper_pop(s, before);
    }
}

void part_stairs(shaper* s, const double* p)
{
    int storeys = (int)p[1];
    double storey = p[0] / storeys, run = 0.5 * storey / 0.75;
    for (int i = 0; i < storeys; ++i) {
        stp_affine before = shaper_move(s, -0.5 * run, i * storey, -0.6);
        flight(s, run, 0.5 * storey);
        shaper_push(s, (stp_affine){{{-1, 0, 0, run}, {0, 1, 0, 0.5 * storey}, {0, 0, -1, 1.2}}});
        flight(s, run, 0.5 * storey);
        shaper_pop(s, before);
        for (int end = -1; end <= 1; end += 2) {
            double y = storey * (i + (end > 0 ? 0.5 : 1.0));
            before = shaper_move(s, end * (0.5 * run + 0.6), y, 0);
            grating(s, 1.2, 2.2);
            detail_railing(s, vec3d(end * 0.6, 0, -1.1), vec3d(end * 0.6, 0, 1.1));
            shaper_pop(s, before);
        }
    }
    for (int i = 0; i < 4; ++i) {
        double x = (i & 1 ? 1 : -1) * (0.5 * run + 1.2), z = i & 2 ? 1.15 : -1.15;
        shape_beam(s, PROFILE_I, vec3d(x, 0, z), vec3d(x, p[0] + 1.1, z), 0.16, 0.16, 0.01);
    }
}

// Trapezoidal waves along u; the outside is +z.
static stp_vec3d corrugated(double u, double v, const void* user)
{
    const double* p = user;
    double waves = p[0] / p[2], at = u * waves, part = at - (double)(int64_t)at;
    double wave = part < 0.3   ? 0.0
                  : part < 0.4 ? (part - 0.3) * 10.0
                  : part < 0.9 ? 1.0
                               : (1.0 - part) * 10.0;
    return vec3d(p[0] * (u - 0.5), p[1] * v, p[3] * wave);
}

void part_cladding(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)(p[0] / p[2])) * 10;
    shape_sheet(s, corrugated, p, columns, shaper_sides(s, 1 + (int)(p[1] / 4.0), 1), 0.001);
    int girts = shaper_amount(s, 1 + (int)(p[1] / 2.0));
    for (int i = 0; i <= girts; ++i) { // rails behind the sheet, and the screws through it
        double y = 0.1 + (p[1] - 0.2) * i / girts;
        shape_beam(s, PROFILE_U, vec3d(-0.5 * p[0], y, -0.06), vec3d(0.5 * p[0], y, -0.06), 0.1,
                   0.1, 0.004);
        int screws = shaper_amount(s, (int)(p[0] / p[2] / 2.0)), sides = shaper_sides(s, 6, 3);
        for (int k = 0; k < screws; ++k) {
            stp_affine at = shaper_push(
                s, place_along(vec3d(p[0] * ((k + 0.5) / screws - 0.5), y, 0), vec3d(0, 0, 1)));
            shape_cylinder(s, 0.008, p[3] + 0.006, sides);
            shaper_pop(s, at);
        }
    }
}

static void truss(shaper* s, double span, double rise, int panels)
{
    double step = span / panels, depth = 0.35 * rise + 0.6;
    shape_beam(s, PROFILE_I, vec3d(-0.5 * span, 0, 0), vec3d(0.5 * span, 0, 0), 0.2, 0.2, 0.012);
    for (int i = 0; i < panels; ++i) {
        double x0 = i * step - 0.5 * span, x1 = x0 + step;
        double y0 = depth + rise * (1.0 - (x0 < 0 ? -x0 : x0) / (0.5 * span));
        double y1 = depth + rise * (1.0 - (x1 < 0 ? -x1 : x1) / (0.5 * span));
        shape_beam(s, PROFILE_I, vec3d(x0, y0, 0), vec3d(x1, y1, 0), 0.2, 0.2, 0.012);
        shape_beam(s, PROFILE_L, vec3d(x0, y0, 0.06), vec3d(x1, 0, 0.06), 0.09, 0.09, 0.009);
        shape_beam(s, PROFILE_L, vec3d(x0, y0, -0.06), vec3d(x1, 0, -0.06), 0.09, 0.09, 0.009);
        shape_beam(s, PROFILE_L, vec3d(x1, 0, 0), vec3d(x1, y1, 0), 0.09, 0.09, 0.009);
        shape_box(s, x1, 0.1, 0, 0.4, 0.35, 0.012);
        for (int k = 0; k < 4; ++k) {
            stp_affine at = shaper_push(
                s, place_along(vec3d(x1 - 0.12 + 0.08 * k, 0.16, 0.006), vec3d(0, 0, 1)));
            detail_hexagon_head(s, 0.02);
            shaper_pop(s, at);
        }
    }
}

void part_roof_truss(shaper* s, const double* p)
{
    double span = p[0], length = p[1], rise = p[3], depth = 0.35 * rise + 0.6;
    int bays = (int)p[2], panels = 2 * (int)(span / 5.0);
    for (int i = 0; i <= bays; ++i) {
        stp_affine before = shaper_move(s, 0, 0, length * ((double)i / bays - 0.5));
        truss(s, span, rise, panels);
        shaper_pop(s, before);
    }
    int purlins = shaper_amount(s, (int)(span / 1.5));
    for (int i = 0; i <= purlins; ++i) {
        double x = span * ((double)i / purlins - 0.5);
        double y = depth + 0.15 + rise * (1.0 - (x < 0 ? -x : x) / (0.5 * span));
        shape_beam(s, PROFILE_U, vec3d(x, y, -0.5 * length), vec3d(x, y, 0.5 * length), 0.14, 0.06,
                   0.004);
    }
}

void part_lattice_bridge(shaper* s, const double* p)
{
    double length = p[0], w = 0.5 * p[1], h = p[2], rise = p[3], chord = 0.14;
    int panels = (int)p[4];
    for (int side = -1; side <= 1; side += 2) {
        double z = side * w;
        shape_beam(s, PROFILE_I, vec3d(0, 0, z), vec3d(length, rise, z), 0.3, 0.2, 0.014);
        shape_beam(s, PROFILE_I, vec3d(0, h, z), vec3d(length, rise + h, z), 0.2, 0.2, 0.012);
        for (int i = 0; i < panels; ++i) {
            double x = length * i / panels, y = rise * i / panels, x1 = length * (i + 1) / panels;
            double y1 = rise * (i + 1) / panels, low = i & 1 ? h : 0.0;
            shape_beam(s, PROFILE_L, vec3d(x, y + low, z), vec3d(x1, y1 + h - low, z), chord, chord,
                       0.01);
            shape_beam(s, PROFILE_L, vec3d(x, y, z), vec3d(x, y + h, z), chord, chord, 0.01);
        }
    }
    for (int i = 0; i <= panels; ++i) {
        double x = length * i / panels, y = rise * i / panels;
        shape_beam(s, PROFILE_I, vec3d(x, y, -w), vec3d(x, y, w), 0.2, 0.1, 0.01);
        shape_beam(s, PROFILE_L, vec3d(x, y + h, -w), vec3d(x, y + h, w), chord, chord, 0.01);
    }
    for (int side = -1; side <= 1; side += 2) {
        detail_railing(s, vec3d(0, 0.2, side * (w - 0.15)),
                       vec3d(length, rise + 0.2, side * (w - 0.15)));
        detail_railing(s, vec3d(0, 0.2, side * (w - 1.0)),
                       vec3d(length, rise + 0.2, side * (w - 1.0)));
    }
}

void part_lattice_mast(shaper* s, const double* p)
{
    double h = p[0], w = p[1];
    int panels = (int)p[2], arms = (int)p[3];
    detail_lattice(s, vec3d(0, 0, 0), vec3d(0, h, 0), w, panels);
    for (int i = 0; i < arms; ++i) {
        double y = h * (1.0 - 0.16 * i) - w;
        detail_lattice(s, vec3d(0, y, 0), vec3d(0, y, 4.5 * w), 0.5 * w, panels / 3 + 2);
        detail_lattice(s, vec3d(0, y, 0), vec3d(0, y, -4.5 * w), 0.5 * w, panels / 3 + 2);
    }
}

void part_ladder(shaper* s, const double* p)
{
    double h = p[0], r = p[1];
    int rungs = shaper_amount(s, (int)(h / 0.28)), hoops = shaper_amount(s, (int)(h / 0.9));
    int sides = shaper_sides(s, 8, 4);
    for (int side = -1; side <= 1; side += 2) {
        shape_bar(s, vec3d(r + 0.2, 0, side * 0.22), vec3d(r + 0.2, h, side * 0.22), 0.06, 0.012);
    }
    for (int i = 0; i < rungs; ++i) {
        double y = h * (i + 0.5) / rungs;
        shape_straight(s, vec3d(r + 0.2, y, -0.22), vec3d(r + 0.2, y, 0.22), 0.012, sides);
    }
    for (int i = 0; i < hoops; ++i) {
        double y = 2.2 + (h - 2.2) * i / hoops;
        stp_vec3d hoop[17];
        for (int k = 0; k <= 16; ++k) {
            double turns = -0.25 + 0.5 * k / 16.0;
            hoop[k] = vec3d(r + 0.2 + 0.7 * turn_cosine(turns), y, 0.38 * turn_sine(turns));
        }
        shape_tube(s, hoop, 17, 0.012, sides, SHAPE_CAPPED);
    }
    for (int k = 0; k <= 4; ++k) {
        double c = r + 0.2 + 0.7 * turn_cosine(k * 0.125 - 0.25),
               d = 0.38 * turn_sine(k * 0.125 - 0.25);
        shape_bar(s, vec3d(c, 2.2, d), vec3d(c, h, d), 0.04, 0.005);
    }
}

void part_slab(shaper* s, const double* p)
{
    int nx = shaper_amount(s, (int)p[3]), nz = shaper_amount(s, (int)p[4]);
    double w = p[0] / nx, d = p[1] / nz, joint_width = 0.006;
    for (int i = 0; i < nx; ++i) {
        for (int k = 0; k < nz; ++k) {
            shape_box(s, (i + 0.5) * w - 0.5 * p[0], -0.5 * p[2], (k + 0.5) * d - 0.5 * p[1],
                      w - joint_width, p[2], d - joint_width);
        }
    }
}

static void fence_side(shaper* s, stp_vec3d from, stp_vec3d to, double h)
{
    stp_vec3d way = stp_subd(to, from);
    double length = sqrt(stp_dotd(way, way));
    int posts = shaper_amount(s, (int)(length / 2.5)), sides = shaper_sides(s, 8, 4);
    int wires = shaper_amount(s, (int)(length / 0.35));
    for (int i = 0; i <= posts; ++i) {
        stp_vec3d foot = stp_addd(from, stp_scaled(way, (double)i / posts));
        shape_straight(s, foot, stp_addd(foot, vec3d(0, h + 0.1, 0)), 0.03, sides);
    }
    for (int i = 0; i < 8; ++i) {
        stp_vec3d up = vec3d(0, 0.05 + (h - 0.05) * i / 7.0, 0);
        shape_straight(s, stp_addd(from, up), stp_addd(to, up), 0.004, 4);
    }
    for (int i = 0; i < wires; ++i) {
        stp_vec3d foot = stp_addd(from, stp_scaled(way, (i + 0.5) / wires));
        shape_bar(s, foot, stp_addd(foot, vec3d(0, h, 0)), 0.005, 0.005);
    }
}

void part_fence(shaper* s, const double* p)
{
    double x = 0.5 * p[0], z = 0.5 * p[1];
    fence_side(s, vec3d(-x, 0, -z), vec3d(x, 0, -z), p[2]);
    fence_side(s, vec3d(x, 0, -z), vec3d(x, 0, z), p[2]);
    fence_side(s, vec3d(x, 0, z), vec3d(-x, 0, z), p[2]);
    fence_side(s, vec3d(-x, 0, z), vec3d(-x, 0, -z), p[2]);
}

void part_box_rows(shaper* s, const double* p)
{
    int columns = shaper_amount(s, (int)p[2]), rows = (int)p[3];
    for (int i = 0; i < columns; ++i) {
        for (int k = 0; k < rows; ++k) {
            double x = p[0] * ((i + 0.5) / columns - 0.5), z = p[1] * ((k + 0.5) / rows - 0.5);
            shape_box(s, x, 0.5 * p[5], z, p[4], p[5], p[6]);
        }
    }
}
