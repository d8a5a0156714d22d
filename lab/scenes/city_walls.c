// SPDX-License-Identifier: MIT
//
// Walls with openings, and roofs of clay tiles.
#include "lab/scenes/city.h"
#include "lab/scenes/solids.h"

#include <assert.h>

enum { MOST_CUTS = 40 };

// A panel cut into cells by lines; some cells are holes. Faces share their vertices.
typedef struct panel {
    double xs[MOST_CUTS + 1], ys[8];
    int columns, rows;
    bool hole[MOST_CUTS][8];
    double thickness;
} panel;

static bool is_solid(const panel* p, int column, int row)
{
    return column >= 0 && row >= 0 && column < p->columns && row < p->rows && !p->hole[column][row];
}

static void put_face(mesh_builder* builder, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    mesh_builder_triangle(builder, a, b, c);
    mesh_builder_triangle(builder, a, c, d);
}

// Front (z = 0, facing -z), back, and the reveal next to holes.
static void put_cell(mesh_builder* builder, const panel* p, uint32_t first, int column, int row)
{
    uint32_t width = (uint32_t)p->columns + 1, layer = width * ((uint32_t)p->rows + 1);
    uint32_t a = first + (uint32_t)row * width + (uint32_t)column, b = a + 1, c = b + width,
             d = a + width;
    put_face(builder, a, d, c, b);
    put_face(builder, a + layer, b + layer, c + layer, d + layer);
    if (!is_solid(p, column - 1, row)) {
        put_face(builder, a, a + layer, d + layer, d);
    }
    if (!is_solid(p, column + 1, row)) {
        put_face(builder, b, c, c + layer, b + layer);
    }
    if (!is_solid(p, column, row - 1)) {
        put_face(builder, a, b, b + layer, a + layer);
    }
    if (!is_solid(p, column, row + 1)) {
        put_face(builder, d, d + layer, c + layer, c);
    }
}

static void put_panel(mesh_builder* builder, const panel* p)
{
    uint32_t first = (uint32_t)builder->vertex_count;
    for (int layer = 0; layer < 2; ++layer) {
        for (int row = 0; row <= p->rows; ++row) {
            for (int column = 0; column <= p->columns; ++column) {
                mesh_builder_vertex(builder,
                                    point3(p->xs[column], p->ys[row], layer * p->thickness),
                                    (stp_vec3){0});
            }
        }
    }
    for (int column = 0; column < p->columns; ++column) {
        for (int row = 0; row < p->rows; ++row) {
            if (!p->hole[column][row]) {
                put_cell(builder, p, first, column, row);
            }
        }
    }
}

// An opening of `width` in the middle of a bay, with solid wall on both sides.
static void add_bay(panel* p, double bay, double width, int low, int high)
{
    if (p->columns + 2 > MOST_CUTS) {
        return;
    }
    double left = p->xs[p->columns];
    p->xs[p->columns + 1] = left + 0.5 * (bay - width);
    p->xs[p->columns + 2] = left + 0.5 * (bay + width);
    for (int row = low; row < high; ++row) {
        p->hole[p->columns + 1][row] = true;
    }
    p->columns += 2;
}

static void add_openings(panel* p, const city_piece* piece, random_stream* random)
{
    double length = piece->sizes[0];
    city_openings openings = (city_openings)(int)piece->sizes[3];
    double wanted = openings == OPEN_SHOPS ? 4.2 : openings == OPEN_ROOMS ? 3.4 : 3.0;
    int bays = openings == OPEN_NONE ? 0 : (int)(length / wanted);
    bays = bays < 1 && openings != OPEN_NONE ? 1 : bays > 18 ? 18 : bays;
    double bay = bays > 0 ? length / bays : length;
    int door = bays / 2;
    for (int i = 0; i < bays; ++i) {
        bool is_door = openings == OPEN_ROOMS || (openings == OPEN_DOOR && i == door) ||
                       (openings == OPEN_DOOR_WINDOWS && i == door);
        double narrow = bay * 0.7;
        if (openings == OPEN_SHOPS) {
            add_bay(p, bay, i == door ? bay * 0.36 : bay * 0.72, 0, 2);
        } else if (is_door) {
            add_bay(p, bay, narrow < 1.3 ? narrow : 1.3, 0, 2);
        } else if (openings != OPEN_DOOR) {
            add_bay(p, bay, random_between(random, 0.45, 0.8), 1, 2);
        } else {
            p->xs[++p->columns] = bay * (i + 1);
        }
        if (p->rows == 5) { // an upper floor has a window in each bay
            p->hole[p->columns - 1][3] = openings != OPEN_DOOR;
        }
    }
    assert(p->columns < MOST_CUTS);
    p->xs[++p->columns] = length;
}

void city_make_wall(mesh_builder* builder, const city_piece* piece)
{
    random_stream random = random_begin(piece->seed);
    double height = piece->sizes[1];
    bool floors = height > 5.6;
    panel p = {.rows = floors ? 5 : 3, .thickness = piece->sizes[2]};
    double sill = random_between(&random, 1.2, 1.7);
    double levels[6] = {0.0, sill, random_between(&random, 2.3, 2.6), 3.9, 4.9, height};
    for (int i = 0; i < 6; ++i) {
        p.ys[i] = !floors && i == 3 ? height : levels[i];
    }
    add_openings(&p, piece, &random);
    put_panel(builder, &p);
    // a plinth and a cornice
    double out = random_between(&random, 0.02, 0.05), length = piece->sizes[0];
    solid_box(builder, point3(-0.01, height, -2.0 * out),
              point3(length + 0.01, height + 0.12, p.thickness + 2.0 * out));
    if ((city_openings)(int)piece->sizes[3] == OPEN_NONE) {
        solid_box(builder, point3(0.0, 0.0, -out), point3(length, 0.9, p.thickness + out));
    }
}

// Profile across one tile: position and height. Flat pans lie side by side, half-round covers over
// their joints.
enum { PROFILE = 7 };
static const double profile[PROFILE][2] = {{0.00, 0.25}, {0.09, 0.20}, {0.15, 0.10}, {0.18, 0.0},
                                           {0.82, 0.0},  {0.85, 0.10}, {0.91, 0.20}};

static void count_tiles(const city_piece* piece, uint32_t* columns, uint32_t* rows, double* slope)
{
    double width = piece->sizes[0], run = piece->sizes[1], rise = piece->sizes[2];
    double tile = piece->sizes[3];
    *slope = sqrt(run * run + rise * rise);
    *columns = (uint32_t)(width / tile + 0.5);
    *rows = (uint32_t)(*slope / (1.45 * tile) + 0.5);
    *columns = *columns < 2 ? 2 : *columns;
    *rows = *rows < 2 ? 2 : *rows;
}

uint64_t city_roof_triangles(const city_piece* piece)
{
    uint32_t columns, rows;
    double slope;
    count_tiles(piece, &columns, &rows, &slope);
    return ((uint64_t)columns * PROFILE) * 2 * (2 * (uint64_t)rows - 1) + 12;
}

// Rows of tiles overlap: each has a line of vertices at its lower end, raised, and one at its upper
// end, and a step leads down to the previous row.
void city_make_roof(mesh_builder* builder, const city_piece* piece)
{
    uint32_t columns, rows;
    double slope, width = piece->sizes[0];
    count_tiles(piece, &columns, &rows, &slope);
    if (builder->counting) {
        builder->index_count += 3 * (size_t)city_roof_triangles(piece);
        return;
    }
    random_stream random = random_begin(piece->seed);
    double tile = width / columns, step = slope / rows;
    double up_z = piece->sizes[1] / slope, up_y = piece->sizes[2] / slope;
    uint32_t points = columns * PROFILE + 1, first = 0;
    for (uint32_t line = 0; line < 2 * rows; ++line) {
        uint32_t row = line / 2;
        bool lower = line % 2 == 0;
        double raised = lower ? 0.09 * tile : 0.0;
        double along = step * (double)(lower ? row : row + 1) - (lower ? 0.1 * step : 0.0);
        uint32_t begin = (uint32_t)builder->vertex_count;
        double shift = 0.0, lift = 0.0;
        for (uint32_t i = 0; i < points; ++i) {
            uint32_t k = i % PROFILE;
            if (k == 0 && lower) { // each tile is placed slightly differently
                shift = random_between(&random, -0.03, 0.03) * step;
                lift = random_between(&random, -0.02, 0.03) * tile;
            }
            double x = tile * ((double)(i / PROFILE) + profile[k][0]);
            double above = raised + lift + profile[k][1] * tile, at = along + shift;
            mesh_builder_vertex(builder,
                                point3(x, up_y * at + up_z * above, up_z * at - up_y * above),
                                (stp_vec3){0});
        }
        for (uint32_t i = 0; line > 0 && i + 1 < points; ++i) {
            put_face(builder, first + i, begin + i, begin + i + 1, first + i + 1);
        }
        first = begin;
    }
    uint32_t corners = (uint32_t)builder->vertex_count; // the boards beneath
    for (int i = 0; i < 8; ++i) {
        double along = (i & 2) != 0 ? slope : 0.0, below = (i & 4) != 0 ? -0.03 : -0.10;
        mesh_builder_vertex(builder,
                            point3((i & 1) != 0 ? width : 0.0, up_y * along + up_z * below,
                                   up_z * along - up_y * below),
                            (stp_vec3){0});
    }
    static const unsigned char faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                              {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    for (int f = 0; f < 6; ++f) {
        put_face(builder, corners + faces[f][0], corners + faces[f][1], corners + faces[f][2],
                 corners + faces[f][3]);
    }
}
