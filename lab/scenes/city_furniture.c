// SPDX-License-Identifier: MIT
//
// Objects in houses, gardens and streets.
#include "lab/scenes/city.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/trigonometry.h"

static void put_box(mesh_builder* b, double x, double y, double z, double width, double height,
                    double depth)
{
    solid_box(b, point3(x, y, z), point3(x + width, y + height, z + depth));
}

static void put_lathe_at(mesh_builder* b, double x, double y, double z, const lathe_ring* profile,
                         int rings, int sides)
{
    stp_affine before = b->place, there = place_at(x, y, z);
    b->place = stp_affine_multiply(before, there);
    solid_lathe(b, profile, rings, sides);
    b->place = before;
}

// Slabs of slightly different heights with joints between them.
static void make_floor(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double width = piece->sizes[0], depth = piece->sizes[1], stone = piece->sizes[2];
    int columns = (int)(width / stone) + 1, rows = (int)(depth / stone) + 1;
    columns = columns > 40 ? 40 : columns;
    rows = rows > 40 ? 40 : rows;
    double w = width / columns, d = depth / rows, joint = 0.03 * w;
    for (int i = 0; i < columns * rows; ++i) {
        if (b->counting) {
            b->index_count += 3 * 10;
            continue;
        }
        double x = w * (i % columns), z = d * (i / columns);
        double top = random_between(random, 0.015, 0.03);
        uint32_t first = (uint32_t)b->vertex_count;
        for (int k = 0; k < 8; ++k) {
            double in = k < 4 ? 0.0 : joint, y = k < 4 ? 0.0 : top;
            bool right = k % 4 == 1 || k % 4 == 2, back = k % 4 >= 2;
            mesh_builder_vertex(b,
                                point3(right ? x + w - in : x + in, y, back ? z + d - in : z + in),
                                (stp_vec3){0});
        }
        mesh_builder_triangle(b, first + 4, first + 7, first + 6);
        mesh_builder_triangle(b, first + 4, first + 6, first + 5);
        for (uint32_t k = 0; k < 4; ++k) {
            uint32_t a = first + k, c = first + (k + 1) % 4;
            mesh_builder_triangle(b, a, a + 4, c + 4);
            mesh_builder_triangle(b, a, c + 4, c);
        }
    }
}

static void make_basin(mesh_builder* b, const city_piece* piece)
{
    double w = piece->sizes[0], d = piece->sizes[1], rim = 0.3;
    for (int step = 0; step < 3; ++step) { // stepped edges around a sunken floor
        double out = rim * (1.0 - step / 3.0), top = 0.18 - 0.06 * step;
        put_box(b, -out, 0, -out, w + 2 * out, top, rim / 3);
        put_box(b, -out, 0, d + out - rim / 3, w + 2 * out, top, rim / 3);
        put_box(b, -out, 0, -out, rim / 3, top, d + 2 * out);
        put_box(b, w + out - rim / 3, 0, -out, rim / 3, top, d + 2 * out);
    }
    put_box(b, 0, 0, 0, w, 0.03, d);
}

static void make_door(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    static const lathe_ring stud[4] = {{0.03, 0.0}, {0.028, 0.012}, {0.016, 0.022}, {0.0, 0.026}};
    double width = piece->sizes[0], height = piece->sizes[1], half = 0.5 * width;
    for (int leaf = 0; leaf < 2; ++leaf) {
        double x = leaf * half;
        put_box(b, x + 0.01, 0.02, 0.0, half - 0.02, height - 0.04, 0.05);
        for (int panel = 0; panel < 3; ++panel) {
            double y = 0.12 + panel * (height - 0.2) / 3.0;
            put_box(b, x + 0.1, y, -0.015, half - 0.2, (height - 0.5) / 3.0, 0.02);
        }
        for (int i = 0; i < 12; ++i) {
            stp_affine before = b->place;
            stp_affine there = {{{1, 0, 0, x + 0.06 + (half - 0.12) * (i % 2)},
                                 {0, 0, 1, 0.15 + (height - 0.3) * (i / 2) / 5.0},
                                 {0, -1, 0, 0}}};
            b->place = stp_affine_multiply(before, there);
            solid_lathe(b, stud, 4, 8);
            b->place = before;
        }
    }
    put_box(b, -0.12, 0, 0, 0.12, height, 0.14);
    put_box(b, width, 0, 0, 0.12, height, 0.14);
    put_box(b, -0.2, height, -0.03, width + 0.4, random_between(random, 0.14, 0.2), 0.2);
}

static void make_table(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double w = piece->sizes[0], d = piece->sizes[1], h = piece->sizes[2];
    lathe_ring leg[6] = {{0.05, 0.0},     {0.035, 0.1 * h}, {0.05, 0.4 * h},
                         {0.03, 0.6 * h}, {0.045, 0.8 * h}, {0.05, h - 0.06}};
    for (int i = 0; i < 4; ++i) {
        put_lathe_at(b, (i & 1) != 0 ? w - 0.1 : 0.1, 0, (i & 2) != 0 ? d - 0.1 : 0.1, leg, 6, 10);
    }
    put_box(b, 0, h - 0.06, 0, w, 0.06, d);
    lathe_ring bowl[6] = {{0.0, 0.0},  {0.06, 0.0}, {0.13, 0.05},
                          {0.16, 0.1}, {0.14, 0.1}, {0.0, 0.03}};
    int bowls = 1 + (int)random_below(random, 4);
    for (int i = 0; i < bowls; ++i) {
        double bowl_x = random_between(random, 0.2, w - 0.2);
        double bowl_z = random_between(random, 0.2, d - 0.2);
        put_lathe_at(b, bowl_x, h, bowl_z, bowl, 6, 14);
    }
}

static void make_counter(mesh_builder* b, const city_piece* piece)
{
    static const lathe_ring jar[7] = {{0.30, 0.96}, {0.30, 1.0}, {0.22, 1.0}, {0.20, 0.9},
                                      {0.27, 0.6},  {0.2, 0.35}, {0.0, 0.3}};
    double length = piece->sizes[0];
    put_box(b, 0, 0, 0, length, 0.96, 0.75);
    put_box(b, -0.05, 0.9, -0.05, length + 0.1, 0.06, 0.85);
    int jars = (int)(length / 0.7);
    for (int i = 0; i < jars; ++i) {
        put_lathe_at(b, length * (i + 0.5) / jars, 0, 0.37, jar, 7, 20);
    }
    for (int step = 0; step < 3; ++step) { // shelves for cups
        put_box(b, 0, 0.96 + 0.14 * step, 0.55 + 0.1 * step, length, 0.03, 0.12);
    }
}

static void make_shrine(mesh_builder* b, const city_piece* piece)
{
    double h = piece->sizes[0];
    lathe_ring column[8] = {{0.09, 0.0},      {0.09, 0.04},     {0.06, 0.07},     {0.058, 0.3 * h},
                            {0.05, 0.45 * h}, {0.08, 0.48 * h}, {0.085, 0.5 * h}, {0.0, 0.5 * h}};
    put_box(b, 0, 0, 0, 1.1, 0.4 * h, 0.8);
    put_box(b, -0.06, 0.4 * h, -0.06, 1.22, 0.06, 0.92);
    put_lathe_at(b, 0.12, 0.4 * h + 0.06, 0.12, column, 8, 16);
    put_lathe_at(b, 0.98, 0.4 * h + 0.06, 0.12, column, 8, 16);
    put_box(b, 0, 0.4 * h, 0.55, 1.1, 0.5 * h, 0.25);
    put_box(b, -0.05, 0.9 * h + 0.06, -0.05, 1.2, 0.1, 0.9);
    for (int i = 0; i < 5; ++i) { // a stepped gable
        put_box(b, 0.11 * i, 0.9 * h + 0.16 + 0.05 * i, 0.0, 1.1 - 0.22 * i, 0.05, 0.8);
    }
}

static void make_couch(mesh_builder* b, const city_piece* piece)
{
    static const lathe_ring leg[6] = {{0.05, 0.0},  {0.07, 0.05}, {0.03, 0.15},
                                      {0.07, 0.25}, {0.04, 0.35}, {0.06, 0.4}};
    double length = piece->sizes[0];
    for (int i = 0; i < 4; ++i) {
        put_lathe_at(b, (i & 1) != 0 ? length - 0.08 : 0.08, 0, (i & 2) != 0 ? 0.72 : 0.08, leg, 6,
                     12);
    }
    put_box(b, 0, 0.4, 0, length, 0.08, 0.8);
    uint32_t first = (uint32_t)b->vertex_count;
    enum { ROWS = 12, COLUMNS = 20 };
    for (int i = 0; i <= ROWS; ++i) { // a mattress, softly quilted
        for (int k = 0; k <= COLUMNS; ++k) {
            double u = (double)k / COLUMNS, v = (double)i / ROWS;
            double edge = 16.0 * u * (1 - u) * v * (1 - v);
            double y = 0.48 + 0.16 * (edge > 1.0 ? 1.0 : edge) +
                       0.02 * turn_sine(3 * u) * turn_sine(2 * v);
            mesh_builder_vertex(b, point3(length * u, y, 0.8 * v), (stp_vec3){0});
        }
    }
    for (uint32_t i = 0; i < ROWS * COLUMNS; ++i) {
        uint32_t a = first + i / COLUMNS * (COLUMNS + 1) + i % COLUMNS, c = a + COLUMNS + 1;
        mesh_builder_triangle(b, a, c, c + 1);
        mesh_builder_triangle(b, a, c + 1, a + 1);
    }
}

static void make_mill(mesh_builder* b, const city_piece* piece)
{
    double h = piece->sizes[0];
    lathe_ring base[5] = {
        {0.75, 0.0}, {0.75, 0.3 * h}, {0.6, 0.33 * h}, {0.3, 0.4 * h}, {0.0, 0.6 * h}};
    lathe_ring runner[8] = {{0.5, 0.42 * h}, {0.3, 0.66 * h}, {0.34, 0.7 * h}, {0.3, 0.74 * h},
                            {0.5, h},        {0.42, h},       {0.2, 0.74 * h}, {0.0, 0.72 * h}};
    solid_lathe(b, base, 5, 28);
    solid_lathe(b, runner, 8, 28);
    put_box(b, -1.2, 0.66 * h, -0.05, 2.4, 0.09, 0.1);
}

// Plants in rows: each a tuft of bent blades.
static void make_bed(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double w = piece->sizes[0], d = piece->sizes[1];
    int plants = (int)(w * d * 3.5);
    plants = plants > 260 ? 260 : plants < 4 ? 4 : plants;
    for (int i = 0; i < plants; ++i) {
        double x = w * random_unit(random), z = d * random_unit(random);
        double tall = random_between(random, 0.25, 0.7);
        int blades = 6 + (int)random_below(random, 5);
        for (int k = 0; k < blades; ++k) {
            double turns = ((double)k + random_unit(random)) / blades, lean = tall * 0.5;
            double c = turn_cosine(turns), s = turn_sine(turns), half = 0.05 * tall;
            stp_vec3 a = point3(x - half * s, 0, z + half * c),
                     e = point3(x + half * s, 0, z - half * c);
            stp_vec3 m = point3(x + 0.5 * lean * c - 2 * half * s, 0.65 * tall,
                                z + 0.5 * lean * s + 2 * half * c);
            stp_vec3 n = point3(x + 0.5 * lean * c + 2 * half * s, 0.65 * tall,
                                z + 0.5 * lean * s - 2 * half * c);
            stp_vec3 tip = point3(x + lean * c, 0.8 * tall, z + lean * s);
            uint32_t first = mesh_builder_vertex(b, a, (stp_vec3){0});
            mesh_builder_vertex(b, e, (stp_vec3){0});
            mesh_builder_vertex(b, n, (stp_vec3){0});
            mesh_builder_vertex(b, m, (stp_vec3){0});
            mesh_builder_vertex(b, tip, (stp_vec3){0});
            mesh_builder_triangle(b, first, first + 1, first + 2);
            mesh_builder_triangle(b, first, first + 2, first + 3);
            mesh_builder_triangle(b, first + 3, first + 2, first + 4);
        }
    }
}

static void make_awning(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    enum { COLUMNS = 32, ROWS = 12 };
    double w = piece->sizes[0], d = piece->sizes[1], wave = random_unit(random);
    uint32_t first = (uint32_t)b->vertex_count;
    for (int i = 0; i <= ROWS; ++i) {
        for (int k = 0; k <= COLUMNS; ++k) {
            double u = (double)k / COLUMNS, v = (double)i / ROWS;
            double sag = 0.25 * v * (1 - v) + 0.05 * turn_sine(4 * u + wave) * v;
            mesh_builder_vertex(b, point3(w * u, 2.7 - 0.5 * v - sag, -d * v), (stp_vec3){0});
        }
    }
    for (uint32_t i = 0; i < ROWS * COLUMNS; ++i) {
        uint32_t a = first + i / COLUMNS * (COLUMNS + 1) + i % COLUMNS, c = a + COLUMNS + 1;
        mesh_builder_triangle(b, a, a + 1, c + 1);
        mesh_builder_triangle(b, a, c + 1, c);
    }
    put_box(b, 0, 0, -d, 0.06, 2.2, 0.06);
    put_box(b, w - 0.06, 0, -d, 0.06, 2.2, 0.06);
}

static void make_stall(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    static const lathe_ring basket[6] = {{0.0, 0.0},  {0.2, 0.0},   {0.27, 0.15},
                                         {0.3, 0.32}, {0.27, 0.33}, {0.0, 0.25}};
    double w = piece->sizes[0], d = piece->sizes[1];
    int crates = 2 + (int)random_below(random, 4);
    for (int i = 0; i < crates; ++i) { // slatted
        double x = random_between(random, 0, w - 0.6), z = random_between(random, 0, d - 0.4);
        for (int slat = 0; slat < 4; ++slat) {
            put_box(b, x, 0.1 * slat, z, 0.6, 0.07, 0.02);
            put_box(b, x, 0.1 * slat, z + 0.38, 0.6, 0.07, 0.02);
            put_box(b, x, 0.1 * slat, z, 0.02, 0.07, 0.4);
            put_box(b, x + 0.58, 0.1 * slat, z, 0.02, 0.07, 0.4);
        }
        put_box(b, x, 0, z, 0.6, 0.02, 0.4);
    }
    int baskets = 2 + (int)random_below(random, 5);
    for (int i = 0; i < baskets; ++i) {
        double x = random_between(random, 0.3, w), z = random_between(random, 0, d);
        put_lathe_at(b, x, 0, z, basket, 6, 18);
        for (int k = 0; k < 5; ++k) {
            double off_x = random_between(random, -0.15, 0.15);
            double off_z = random_between(random, -0.15, 0.15);
            solid_sphere(b, point3(x + off_x, 0.33, z + off_z), 0.06, 1);
        }
    }
}

static void make_cart(mesh_builder* b, const city_piece* piece)
{
    double length = piece->sizes[0];
    lathe_ring rim[5] = {{0.5, -0.04}, {0.58, -0.04}, {0.58, 0.04}, {0.5, 0.04}, {0.5, -0.04}};
    lathe_ring hub[4] = {{0.0, -0.12}, {0.1, -0.12}, {0.1, 0.12}, {0.0, 0.12}};
    put_box(b, 0, 0.75, -0.6, length, 0.06, 1.2);
    for (int side = 0; side < 2; ++side) {
        double z = side == 0 ? -0.72 : 0.72;
        for (int slat = 0; slat < 4; ++slat) {
            put_box(b, 0, 0.85 + 0.13 * slat, side == 0 ? -0.6 : 0.57, length, 0.08, 0.03);
        }
        stp_affine before = b->place;
        stp_affine turned = {{{1, 0, 0, 0.5 * length}, {0, 0, 1, 0.58}, {0, -1, 0, z}}};
        b->place = stp_affine_multiply(before, turned);
        solid_lathe(b, rim, 5, 32);
        solid_lathe(b, hub, 4, 12);
        for (int spoke = 0; spoke < 8; ++spoke) {
            stp_affine around = place_turned(0, 0, 0, spoke / 8.0, 1.0);
            stp_affine there = stp_affine_multiply(before, turned);
            b->place = stp_affine_multiply(there, around);
            put_box(b, 0.1, -0.025, -0.025, 0.42, 0.05, 0.05);
        }
        b->place = before;
    }
    put_box(b, length, 0.75, -0.04, 1.6, 0.07, 0.08);
}

// Beams under a roof, from the ridge to the eave and across.
static void make_beams(mesh_builder* b, const city_piece* piece)
{
    double w = piece->sizes[0], run = piece->sizes[1];
    int count = (int)(w / 0.8) + 1;
    for (int i = 0; i < count; ++i) {
        put_box(b, (w - 0.12) * i / (count > 1 ? count - 1 : 1), 0, 0, 0.12, 0.16, run);
    }
    put_box(b, 0, -0.2, 0.1, w, 0.2, 0.16);
    put_box(b, 0, -0.2, run - 0.26, w, 0.2, 0.16);
}

void city_make_furniture(mesh_builder* b, const city_piece* piece)
{
    random_stream random = random_begin(piece->seed);
    switch (piece->kind) {
    case CITY_FLOOR:
        make_floor(b, piece, &random);
        break;
    case CITY_BASIN:
        make_basin(b, piece);
        break;
    case CITY_DOOR:
        make_door(b, piece, &random);
        break;
    case CITY_TABLE:
        make_table(b, piece, &random);
        break;
    case CITY_COUNTER:
        make_counter(b, piece);
        break;
    case CITY_SHRINE:
        make_shrine(b, piece);
        break;
    case CITY_COUCH:
        make_couch(b, piece);
        break;
    case CITY_MILL:
        make_mill(b, piece);
        break;
    case CITY_BED:
        make_bed(b, piece, &random);
        break;
    case CITY_AWNING:
        make_awning(b, piece, &random);
        break;
    case CITY_STALL:
        make_stall(b, piece, &random);
        break;
    case CITY_CART:
        make_cart(b, piece);
        break;
    default:
        make_beams(b, piece);
        break;
    }
}
