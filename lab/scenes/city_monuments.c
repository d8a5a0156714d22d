// SPDX-License-Identifier: MIT
//
// Streets, the city walls, temples, the amphitheatre; and the instanced columns, statues and jars.
#include "lab/scenes/city.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/trees.h"
#include "lab/scenes/trigonometry.h"

static void put_box(mesh_builder* b, double x, double y, double z, double width, double height,
                    double depth)
{
    solid_box(b, point3(x, y, z), point3(x + width, y + height, z + depth));
}

// A stone with a rough outline of `sides` corners, its top smaller than its foot.
static void put_stone(mesh_builder* b, random_stream* random, double x, double z, double radius,
                      double bottom, double top, int sides)
{
    if (b->counting) {
        random->index += 1 + 2 * (uint64_t)sides; // as many as below
        b->index_count += 3 * 5 * (size_t)sides;
        return;
    }
    uint32_t first = (uint32_t)b->vertex_count;
    double turned = random_unit(random);
    for (int ring = 0; ring < 3; ++ring) {
        double r = radius * (ring < 2 ? 1.0 : 0.8), y = ring == 0   ? bottom
                                                        : ring == 1 ? top - 0.06
                                                                    : top;
        for (int i = 0; i < sides; ++i) {
            double turns = turned + (double)i / sides;
            double rough = ring == 0 ? 1.0 : random_between(random, 0.93, 1.07);
            mesh_builder_vertex(
                b, point3(x + r * rough * turn_cosine(turns), y, z + r * rough * turn_sine(turns)),
                (stp_vec3){0});
        }
    }
    uint32_t middle = mesh_builder_vertex(b, point3(x, top + 0.02, z), (stp_vec3){0});
    for (uint32_t ring = 0; ring < 3; ++ring) {
        for (uint32_t i = 0; i < (uint32_t)sides; ++i) {
            uint32_t a = first + ring * (uint32_t)sides + i;
            uint32_t c = first + ring * (uint32_t)sides + (i + 1) % (uint32_t)sides;
            if (ring == 2) {
                mesh_builder_triangle(b, a, middle, c);
            } else {
                mesh_builder_triangle(b, a, a + (uint32_t)sides, c + (uint32_t)sides);
                mesh_builder_triangle(b, a, c + (uint32_t)sides, c);
            }
        }
    }
}

static void make_paving(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double width = piece->sizes[0], length = piece->sizes[1], size = 0.8;
    int columns = (int)(width / size) + 1, rows = (int)(length / size) + 1;
    for (int row = 0; row < rows; ++row) {
        for (int i = 0; i < columns; ++i) {
            double x = width * (i + (row % 2 == 0 ? 0.25 : 0.75)) / columns;
            double z = length * (row + 0.5) / rows;
            double top = random_between(random, 0.0, 0.035) + 0.05 -
                         0.06 * (x / width - 0.5) * (x / width - 0.5);
            put_stone(b, random, x, z, 0.56 * size, -0.12, top, 5 + (int)random_below(random, 2));
        }
    }
    put_box(b, 0, -0.2, 0, width, 0.19, length);
}

static void make_kerb(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double length = piece->sizes[0];
    int stones = (int)(length / 1.1) + 1;
    for (int i = 0; i < stones; ++i) {
        double x = length * i / stones;
        double out = random_between(random, -0.02, 0.02);
        double tall = random_between(random, 0.42, 0.46);
        put_box(b, x + 0.01, -0.1, out, length / stones - 0.02, tall, 0.32);
    }
    put_box(b, 0, -0.1, 0.3, length, 0.5, 1.1); // the pavement behind them
}

static void make_steps(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    int count = (int)piece->sizes[1];
    for (int i = 0; i < count; ++i) {
        stp_affine before = b->place;
        stp_affine there = place_at(piece->sizes[0] * (i + 0.5) / count, 0, 0);
        there.m[2][2] = 1.7;
        b->place = stp_affine_multiply(before, there);
        put_stone(b, random, 0, 0, 0.36, -0.1, 0.36, 12);
        b->place = before;
    }
}

static void put_courses(mesh_builder* b, random_stream* random, double length, double height,
                        double depth, double course)
{
    int rows = (int)(height / course + 0.5);
    for (int row = 0; row < rows; ++row) {
        int count = (int)(length / (2.6 * course)) + 1;
        for (int i = 0; i < count; ++i) {
            double shift = row % 2 == 0 ? 0.0 : 0.5, x = length * (i - shift) / count;
            double left = x < 0.0 ? 0.0 : x, right = length * (i + 1 - shift) / count;
            right = i + 1 == count ? length : right;
            double out = random_between(random, 0.0, 0.04);
            put_box(b, left, height * row / rows, -out, right - left - 0.015, height / rows - 0.012,
                    depth + 2.0 * out);
        }
    }
}

static void make_rampart(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double length = piece->sizes[0], height = piece->sizes[1];
    put_courses(b, random, length, height, 1.6, 0.62);
    int merlons = (int)(length / 2.2);
    for (int i = 0; i < merlons; ++i) {
        put_box(b, length * (i + 0.2) / merlons, height, 0, 1.1, 1.3, 0.5);
    }
    put_box(b, 0, height - 0.4, 1.6, length, 0.4, 2.4);
}

static void make_tower(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double side = piece->sizes[0], height = piece->sizes[1];
    put_courses(b, random, side, height, side, 0.7);
    for (int i = 0; i < 4; ++i) {
        double at = side * (i + 0.1) / 4.0, size = side / 6.0;
        put_box(b, at, height, 0, size, 1.2, 0.5);
        put_box(b, at, height, side - 0.5, size, 1.2, 0.5);
        put_box(b, 0, height, at, 0.5, 1.2, size);
        put_box(b, side - 0.5, height, at, 0.5, 1.2, size);
    }
}

static void make_podium(mesh_builder* b, const city_piece* piece, random_stream* random)
{
    double w = piece->sizes[0], d = piece->sizes[1], h = piece->sizes[2];
    put_courses(b, random, w, h, d, 0.55);
    put_box(b, -0.15, h, -0.15, w + 0.3, 0.2, d + 0.3);
    int steps = (int)(h / 0.22) + 1;
    for (int i = 0; i < steps; ++i) {
        double depth = 0.33 * (steps - i);
        put_box(b, 0.1 * w, h * i / steps, -depth, 0.8 * w, h / steps, 0.33 * (steps - i));
    }
}

static void make_architrave(mesh_builder* b, const city_piece* piece)
{
    double length = piece->sizes[0], h = piece->sizes[1];
    put_box(b, 0, 0, -0.35, length, 0.4 * h, 0.7);
    put_box(b, -0.03, 0.4 * h, -0.4, length + 0.06, 0.06 * h, 0.8);
    put_box(b, 0, 0.46 * h, -0.33, length, 0.32 * h, 0.66);
    put_box(b, -0.1, 0.78 * h, -0.55, length + 0.2, 0.22 * h, 1.1);
    int dentils = (int)(length / 0.24);
    for (int i = 0; i < dentils; ++i) {
        put_box(b, length * i / dentils, 0.7 * h, -0.5, 0.12, 0.08 * h, 1.0);
    }
}

static void make_gable(mesh_builder* b, const city_piece* piece)
{
    double w = piece->sizes[0], h = piece->sizes[1], t = piece->sizes[2];
    for (int layer = 0; layer < 2; ++layer) { // the field, then the frame that stands out
        double in = layer == 0 ? 0.0 : 0.12, out = layer == 0 ? 0.0 : 0.15;
        uint32_t first = (uint32_t)b->vertex_count;
        for (int i = 0; i < 6; ++i) {
            double x = i % 3 == 0 ? -out : i % 3 == 1 ? w + out : 0.5 * w;
            double y = i % 3 == 2 ? h + out : in * 2.0;
            mesh_builder_vertex(b, point3(x, y + (layer == 0 ? 0 : 0.1), i < 3 ? -out : t + out),
                                (stp_vec3){0});
        }
        mesh_builder_triangle(b, first, first + 2, first + 1);
        mesh_builder_triangle(b, first + 3, first + 4, first + 5);
        for (uint32_t i = 0; i < 3; ++i) {
            uint32_t k = (i + 1) % 3;
            mesh_builder_triangle(b, first + i, first + k, first + 3 + k);
            mesh_builder_triangle(b, first + i, first + 3 + k, first + 3 + i);
        }
        if (layer == 0) {
            for (int i = 0; i < 7; ++i) { // figures, the tallest in the middle
                double off = i < 3 ? 3 - i : i - 3;
                double tall = h * (0.62 - 0.16 * off);
                put_box(b, w * (0.2 + 0.1 * i) - 0.12 * h, 0.12 * h, -0.12, 0.24 * h, tall, 0.12);
                solid_sphere(b, point3(w * (0.2 + 0.1 * i), 0.12 * h + tall, -0.06), 0.09 * h, 2);
            }
        }
    }
}

// Round arches on piers: each arch a strip of stones around a half circle.
static void make_arcade(mesh_builder* b, const city_piece* piece)
{
    enum { STONES = 16 };
    double length = piece->sizes[0], height = piece->sizes[1], t = piece->sizes[2];
    int arches = (int)(length / 4.0);
    arches = arches < 1 ? 1 : arches;
    double bay = length / arches, radius = 0.36 * bay, spring = height - radius - 0.9;
    for (int i = 0; i < arches; ++i) {
        double middle = bay * (i + 0.5);
        put_box(b, bay * i, 0, 0, 0.5 * bay - radius, height, t);
        put_box(b, middle + radius, 0, 0, 0.5 * bay - radius, height, t);
        put_box(b, bay * i - 0.05, spring, -0.08, 0.5 * bay - radius + 0.1, 0.25, t + 0.16);
        for (int k = 0; k < STONES; ++k) {
            uint32_t first = (uint32_t)b->vertex_count;
            for (int corner = 0; corner < 8; ++corner) {
                double turns = 0.5 * (k + ((corner & 1) != 0 ? 0.97 : 0.03)) / STONES;
                double c = turn_cosine(turns), s = turn_sine(turns);
                double x = middle + radius * c, y = spring + radius * s;
                if ((corner & 2) != 0) { // up to the straight upper edge
                    y = height;
                    x = middle + radius * 1.02 * c;
                }
                mesh_builder_vertex(
                    b, point3(x, y, (corner & 4) != 0 ? t + 0.02 * (k % 2) : -0.02 * (k % 2)),
                    (stp_vec3){0});
            }
            static const unsigned char faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                                      {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
            for (int f = 0; f < 6; ++f) {
                mesh_builder_triangle(b, first + faces[f][0], first + faces[f][1],
                                      first + faces[f][2]);
                mesh_builder_triangle(b, first + faces[f][0], first + faces[f][2],
                                      first + faces[f][3]);
            }
        }
    }
    put_box(b, -0.05, height, -0.15, length + 0.1, 0.4, t + 0.3);
}

// Rows of seats that rise outwards, as a wedge around the y axis.
static void make_seats(mesh_builder* b, const city_piece* piece)
{
    double inner = piece->sizes[0], outer = piece->sizes[1], turns = piece->sizes[2];
    int rows = (int)((outer - inner) / 0.75), around = 12;
    uint32_t first = (uint32_t)b->vertex_count;
    for (int row = 0; row <= rows; ++row) {
        for (int edge = 0; edge < 2; ++edge) {
            double r = inner + (outer - inner) * row / rows;
            double y = piece->sizes[3] * (row + edge) / (rows + 1);
            for (int i = 0; i <= around; ++i) {
                double at = turns * i / around;
                mesh_builder_vertex(b, point3(r * turn_cosine(at), y, r * turn_sine(at)),
                                    (stp_vec3){0});
            }
        }
    }
    uint32_t width = (uint32_t)around + 1;
    for (uint32_t line = 0; line + 1 < 2 * ((uint32_t)rows + 1); ++line) {
        for (uint32_t i = 0; i < (uint32_t)around; ++i) {
            uint32_t a = first + line * width + i, c = a + width;
            mesh_builder_triangle(b, a, a + 1, c + 1);
            mesh_builder_triangle(b, a, c + 1, c);
        }
    }
}

// Fluted: every second vertex of a ring is deeper.
static void make_column(mesh_builder* b, const city_piece* piece)
{
    enum { SIDES = 40, RINGS = 14 };
    double h = piece->sizes[0], radius = piece->sizes[1];
    int order = (int)piece->sizes[2];
    lathe_ring base[7] = {{1.35, 0.0}, {1.35, 0.3},  {1.25, 0.4}, {1.1, 0.45},
                          {1.2, 0.6},  {1.15, 0.75}, {1.0, 0.8}};
    for (int i = 0; i < 7; ++i) {
        base[i].radius *= radius;
        base[i].height *= radius;
    }
    solid_lathe(b, base, 7, SIDES);
    uint32_t first = (uint32_t)b->vertex_count;
    double foot = 0.8 * radius, shaft = h - 2.4 * radius;
    for (int ring = 0; ring <= RINGS; ++ring) {
        double t = (double)ring / RINGS, r = radius * (1.0 - 0.16 * t * t);
        for (int i = 0; i < SIDES; ++i) {
            double deep = order == 0 && ring < RINGS / 3 ? 1.0 : i % 2 == 0 ? 1.0 : 0.93;
            double turns = (double)i / SIDES, c = turn_cosine(turns), s = turn_sine(turns);
            mesh_builder_vertex(b, point3(r * deep * c, foot + shaft * t, r * deep * s),
                                point3(c, 0, s));
        }
    }
    for (uint32_t i = 0; i < RINGS * SIDES; ++i) {
        uint32_t a = first + i, c = i % SIDES == SIDES - 1 ? a + 1 - SIDES : a + 1;
        mesh_builder_triangle(b, a, a + SIDES, c + SIDES);
        mesh_builder_triangle(b, a, c + SIDES, c);
    }
    double top = foot + shaft, wide = order == 0 ? 1.3 : 1.15;
    lathe_ring capital[6] = {{0.84, 0.0},
                             {0.95, 0.08},
                             {0.86, 0.16},
                             {0.9, 0.4},
                             {wide, order == 2 ? 1.3 : 0.7},
                             {0.0, order == 2 ? 1.3 : 0.7}};
    for (int i = 0; i < 6; ++i) {
        capital[i].radius *= radius;
        capital[i].height = top + capital[i].height * radius;
    }
    solid_lathe(b, capital, 6, SIDES);
    for (int i = 0; order > 0 && i < (order == 1 ? 4 : 16); ++i) { // volutes, or leaves in two rows
        double turns = order == 1 ? 0.125 + i / 4.0 : (i % 8 + 0.5 * (i / 8)) / 8.0;
        double out = radius * (order == 1 ? 1.05 : 0.98 + 0.1 * (i / 8));
        double y = top + radius * (order == 1 ? 0.5 : 0.4 + 0.45 * (i / 8));
        solid_sphere(b, point3(out * turn_cosine(turns), y, out * turn_sine(turns)),
                     radius * (order == 1 ? 0.3 : 0.2), order == 1 ? 2 : 1);
    }
    put_box(b, -wide * radius, h - (order == 2 ? 0.3 : 0.9) * radius, -wide * radius,
            2 * wide * radius, (order == 2 ? 0.3 : 0.9) * radius, 2 * wide * radius);
}

static void make_amphora(mesh_builder* b)
{
    static const lathe_ring jar[16] = {{0.0, 0.0},    {0.04, 0.02},  {0.06, 0.08}, {0.12, 0.2},
                                       {0.17, 0.35},  {0.19, 0.5},   {0.19, 0.62}, {0.16, 0.72},
                                       {0.09, 0.79},  {0.065, 0.86}, {0.06, 0.96}, {0.075, 1.0},
                                       {0.085, 1.03}, {0.06, 1.03},  {0.05, 0.95}, {0.0, 0.9}};
    solid_lathe(b, jar, 16, 32);
    for (int side = 0; side < 2; ++side) { // handles
        double sign = side == 0 ? 1.0 : -1.0;
        lathe_ring ring[5] = {
            {0.075, -0.015}, {0.1, -0.015}, {0.1, 0.015}, {0.075, 0.015}, {0.075, -0.015}};
        stp_affine before = b->place;
        stp_affine there = {{{1, 0, 0, sign * 0.11}, {0, 0, 1, 0.86}, {0, -1, 0, 0}}};
        b->place = stp_affine_multiply(before, there);
        solid_lathe(b, ring, 5, 20);
        b->place = before;
    }
}

// A draped figure: rings whose outline has folds, on a plinth.
static void make_statue(mesh_builder* b)
{
    enum { SIDES = 56, RINGS = 48 };
    static const double body[13][2] = {{0.30, 0.0}, {0.31, 0.2},  {0.28, 0.6},   {0.25, 0.9},
                                       {0.24, 1.1}, {0.22, 1.25}, {0.27, 1.45},  {0.24, 1.55},
                                       {0.09, 1.6}, {0.08, 1.66}, {0.125, 1.76}, {0.11, 1.88},
                                       {0.0, 1.93}};
    put_box(b, -0.45, 0, -0.45, 0.9, 0.12, 0.9);
    put_box(b, -0.38, 0.12, -0.38, 0.76, 0.9, 0.76);
    put_box(b, -0.45, 1.02, -0.45, 0.9, 0.12, 0.9);
    uint32_t first = (uint32_t)b->vertex_count;
    for (int ring = 0; ring <= RINGS; ++ring) {
        double at = 12.0 * ring / RINGS;
        int k = (int)at > 11 ? 11 : (int)at;
        double u = at - k, r = body[k][0] + u * (body[k + 1][0] - body[k][0]);
        double y = 1.14 + body[k][1] + u * (body[k + 1][1] - body[k][1]);
        double folds = body[k][1] < 1.5 ? 0.09 * (1.6 - body[k][1]) : 0.0;
        for (int i = 0; i < SIDES; ++i) {
            double turns = (double)i / SIDES, c = turn_cosine(turns), s = turn_sine(turns);
            double deep =
                r * (1.0 + folds * turn_sine(9.0 * turns + 0.15 * y)) * (1.0 - 0.2 * s * s);
            mesh_builder_vertex(b, point3(deep * c + 0.03 * turn_sine(0.4 * y), y, deep * s),
                                point3(c, 0, s));
        }
    }
    for (uint32_t i = 0; i < RINGS * SIDES; ++i) {
        uint32_t a = first + i, c = i % SIDES == SIDES - 1 ? a + 1 - SIDES : a + 1;
        mesh_builder_triangle(b, a, a + SIDES, c + SIDES);
        mesh_builder_triangle(b, a, c + SIDES, c);
    }
    for (int arm = 0; arm < 2; ++arm) {
        for (int i = 0; i < 5; ++i) {
            double sign = arm == 0 ? 1.0 : -1.0;
            solid_sphere(b, point3(sign * (0.27 + 0.02 * i * arm), 2.55 - 0.12 * i, -0.06 * i),
                         0.075, 2);
        }
    }
}

static void make_fountain(mesh_builder* b)
{
    static const lathe_ring basin[9] = {{0.0, 0.0},  {0.5, 0.0},   {0.3, 0.15},
                                        {0.16, 0.4}, {0.18, 0.7},  {0.5, 0.85},
                                        {0.8, 1.0},  {0.76, 1.03}, {0.0, 0.86}};
    solid_lathe(b, basin, 9, 48);
    put_box(b, -1.1, 0, -1.1, 2.2, 0.5, 0.25);
    put_box(b, -1.1, 0, 0.85, 2.2, 0.5, 0.25);
    put_box(b, -1.1, 0, -0.85, 0.25, 0.5, 1.7);
    put_box(b, 0.85, 0, -0.85, 0.25, 0.5, 1.7);
}

static void make_monument(mesh_builder* b, const city_piece* piece)
{
    random_stream random = random_begin(piece->seed);
    switch (piece->kind) {
    case CITY_PAVING:
        make_paving(b, piece, &random);
        break;
    case CITY_KERB:
        make_kerb(b, piece, &random);
        break;
    case CITY_STEPS:
        make_steps(b, piece, &random);
        break;
    case CITY_RAMPART:
        make_rampart(b, piece, &random);
        break;
    case CITY_TOWER:
        make_tower(b, piece, &random);
        break;
    case CITY_PODIUM:
        make_podium(b, piece, &random);
        break;
    case CITY_ARCHITRAVE:
        make_architrave(b, piece);
        break;
    case CITY_GABLE:
        make_gable(b, piece);
        break;
    case CITY_ARCADE:
        make_arcade(b, piece);
        break;
    case CITY_SEATS:
        make_seats(b, piece);
        break;
    case CITY_COLUMN:
        make_column(b, piece);
        break;
    case CITY_AMPHORA:
        make_amphora(b);
        break;
    case CITY_STATUE:
        make_statue(b);
        break;
    default:
        make_fountain(b);
        break;
    }
}

// Pieces of a kind differ slightly in size: no two are the same mesh.
void city_make_piece(mesh_builder* builder, const void* parameters)
{
    const city_piece* piece = parameters;
    if (piece->kind == CITY_TREE) {
        tree_recipe tree = {.kind = piece->sizes[0] > 0.5 ? 4 : 0,
                            .triangles = (uint32_t)piece->sizes[1],
                            .seed = 11};
        tree_make(builder, &tree);
        return;
    }
    random_stream random = random_begin(piece->seed ^ UINT64_C(0x517e));
    builder->flat =
        piece->kind != CITY_COLUMN && piece->kind != CITY_STATUE && piece->kind != CITY_AMPHORA;
    for (int axis = 0; axis < 3; ++axis) {
        builder->place.m[axis][axis] = random_between(&random, 0.997, 1.0);
    }
    if (piece->kind == CITY_WALL) {
        city_make_wall(builder, piece);
    } else if (piece->kind == CITY_ROOF) {
        city_make_roof(builder, piece);
    } else if (piece->kind <= CITY_CART || piece->kind == CITY_BEAMS) {
        city_make_furniture(builder, piece);
    } else {
        make_monument(builder, piece);
    }
}
