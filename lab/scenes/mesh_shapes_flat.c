// SPDX-License-Identifier: MIT
//
// Prisms, perforated plates and curved sheets.
#include "lab/scenes/mesh_shapes_patch.h"

#include <assert.h>

static const double smooth_cosine = 0.9;

// The outward normal of the edge from corner i to the next.
static void edge_normal(const double (*outline)[2], int count, int i, double* x, double* z)
{
    const double *a = outline[(i + count) % count], *b = outline[(i + 1 + count) % count];
    double dx = b[0] - a[0], dz = b[1] - a[1], size = sqrt(dx * dx + dz * dz);
    *x = size > 0.0 ? dz / size : 1.0;
    *z = size > 0.0 ? -dx / size : 0.0;
}

// The walls: four vertices per edge; nearly flat corners share normals.
static void put_walls(shape_patch* p, const double (*outline)[2], int count, double length)
{
    uint32_t at = p->first;
    for (int i = 0; i < count; ++i, at += 4) {
        double n[3][2];
        for (int k = 0; k < 3; ++k) {
            edge_normal(outline, count, i + k - 1, &n[k][0], &n[k][1]);
        }
        for (int end = 0; end < 2; ++end) {
            const double* q = outline[(i + end) % count];
            const double* other = n[end == 0 ? 0 : 2];
            bool smooth = n[1][0] * other[0] + n[1][1] * other[1] > smooth_cosine;
            double x = n[1][0] + (smooth ? other[0] : 0.0), z = n[1][1] + (smooth ? other[1] : 0.0);
            double size = sqrt(x * x + z * z);
            patch_vertex(p, q[0], end == 0 ? 0 : length, q[1], x / size, 0, z / size);
            patch_vertex(p, q[0], end == 0 ? length : 0, q[1], x / size, 0, z / size);
        }
        patch_quad(p, at, at + 1, at + 2, at + 3);
    }
}

// An end with a hole: the hole has a corner for each corner of the outline.
static void put_bored_end(shape_patch* p, uint32_t at, const double (*outline)[2], int count,
                          double bore, double y, double side)
{
    for (int i = 0; i < count; ++i) {
        double x = outline[i][0], z = outline[i][1], r = bore / sqrt(x * x + z * z);
        patch_vertex(p, x, y, z, 0, side, 0);
        patch_vertex(p, x * r, y, z * r, 0, side, 0);
    }
    for (int i = 0; i < count; ++i) {
        uint32_t a = at + 2 * (uint32_t)i, b = at + 2 * (uint32_t)((i + 1) % count);
        if (side > 0.0) {
            patch_quad(p, a, a + 1, b + 1, b);
        } else {
            patch_quad(p, a, b, b + 1, a + 1);
        }
    }
}

static void put_bore(shape_patch* p, uint32_t at, const double (*outline)[2], int count,
                     double bore, double length)
{
    for (int i = 0; i < count; ++i) {
        double x = outline[i][0], z = outline[i][1], r = 1.0 / sqrt(x * x + z * z);
        patch_vertex(p, x * r * bore, 0, z * r * bore, -x * r, 0, -z * r);
        patch_vertex(p, x * r * bore, length, z * r * bore, -x * r, 0, -z * r);
    }
    for (int i = 0; i < count; ++i) {
        uint32_t a = at + 2 * (uint32_t)i, b = at + 2 * (uint32_t)((i + 1) % count);
        patch_quad(p, a, b, b + 1, a + 1);
    }
}

static void put_full_end(shape_patch* p, uint32_t at, const double (*outline)[2], int count,
                         double y, double side)
{
    patch_vertex(p, 0, y, 0, 0, side, 0);
    for (int i = 0; i < count; ++i) {
        patch_vertex(p, outline[i][0], y, outline[i][1], 0, side, 0);
    }
    for (int i = 0; i < count; ++i) {
        uint32_t a = at + 1 + (uint32_t)i, b = at + 1 + (uint32_t)((i + 1) % count);
        patch_triangle(p, at, side > 0.0 ? b : a, side > 0.0 ? a : b);
    }
}

void shape_prism(shaper* s, const double (*outline)[2], int count, double bore, double length)
{
    uint64_t n = (uint64_t)count;
    shape_patch p;
    if (bore > 0.0) {
        if (shape_begin(s, 10 * n, 8 * n, &p)) {
            uint32_t at = p.first;
            put_walls(&p, outline, count, length);
            put_bored_end(&p, at + 4 * (uint32_t)count, outline, count, bore, 0, -1);
            put_bored_end(&p, at + 6 * (uint32_t)count, outline, count, bore, length, 1);
            put_bore(&p, at + 8 * (uint32_t)count, outline, count, bore, length);
        }
    } else if (shape_begin(s, 6 * n + 2, 4 * n, &p)) {
        uint32_t at = p.first;
        put_walls(&p, outline, count, length);
        put_full_end(&p, at + 4 * (uint32_t)count, outline, count, 0, -1);
        put_full_end(&p, at + 5 * (uint32_t)count + 1, outline, count, length, 1);
    }
}

// One cell of a perforated plate: faces between a square and a circle, and the wall of the hole.
// The square's corners are at odd eighths of a turn, so the number of sides is a multiple of eight.
static void put_cell(shape_patch* p, const shape_ring* ring, int sides, const double at[2],
                     const double half[2], double hole, double thickness)
{
    uint32_t first = p->first;
    for (int face = 0; face < 2; ++face) {
        for (int i = 0; i < sides; ++i) {
            double c = ring->cosine[i], d = ring->sine[i];
            double reach = c * c > d * d ? (c < 0 ? -c : c) : (d < 0 ? -d : d);
            double y = face == 0 ? 0 : -thickness, up = face == 0 ? 1 : -1;
            patch_vertex(p, at[0] + half[0] * c / reach, y, at[1] + half[1] * d / reach, 0, up, 0);
            patch_vertex(p, at[0] + hole * c, y, at[1] + hole * d, 0, up, 0);
        }
        uint32_t base = first + (uint32_t)(2 * sides * face);
        for (uint32_t i = 0; i < (uint32_t)sides; ++i) {
            uint32_t a = base + 2 * i, b = base + 2 * (i + 1 < (uint32_t)sides ? i + 1 : 0);
            if (face == 0) {
                patch_quad(p, a, a + 1, b + 1, b);
            } else {
                patch_quad(p, a, b, b + 1, a + 1);
            }
        }
    }
    uint32_t wall = first + (uint32_t)(4 * sides);
    for (int i = 0; i < sides; ++i) {
        double c = ring->cosine[i], d = ring->sine[i];
        patch_vertex(p, at[0] + hole * c, -thickness, at[1] + hole * d, -c, 0, -d);
        patch_vertex(p, at[0] + hole * c, 0, at[1] + hole * d, -c, 0, -d);
    }
    for (uint32_t i = 0; i < (uint32_t)sides; ++i) {
        uint32_t a = wall + 2 * i, b = wall + 2 * (i + 1 < (uint32_t)sides ? i + 1 : 0);
        patch_quad(p, a, b, b + 1, a + 1);
    }
    p->first = first + (uint32_t)(6 * sides);
}

void shape_perforated(shaper* s, double width, double depth, double thickness, int columns,
                      int rows, double hole, int sides)
{
    sides = sides < 8 ? 8 : sides - sides % 8;
    uint64_t n = (uint64_t)sides, cells = (uint64_t)columns * (uint64_t)rows;
    shape_patch p;
    if (!shape_begin(s, 6 * n * cells, 6 * n * cells, &p)) {
        return;
    }
    assert(columns > 0 && rows > 0 && sides % 8 == 0 && "corners of cells are vertices");
    const shape_ring* ring = shape_circle(s, sides);
    double half[2] = {0.5 * width / columns, 0.5 * depth / rows};
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            double at[2] = {(2 * column + 1) * half[0] - 0.5 * width,
                            (2 * row + 1) * half[1] - 0.5 * depth};
            put_cell(&p, ring, sides, at, half, hole, thickness);
        }
    }
}

static void grid_normal(const float* q, size_t columns, size_t rows, size_t i, size_t k,
                        double n[3])
{
    size_t i0 = i > 0 ? i - 1 : i, i1 = i + 1 < columns ? i + 1 : i;
    size_t k0 = k > 0 ? k - 1 : k, k1 = k + 1 < rows ? k + 1 : k;
    const float *a = q + 3 * (k * columns + i0), *b = q + 3 * (k * columns + i1);
    const float *c = q + 3 * (k0 * columns + i), *d = q + 3 * (k1 * columns + i);
    stp_vec3d u = vec3d((double)b[0] - (double)a[0], (double)b[1] - (double)a[1],
                        (double)b[2] - (double)a[2]);
    stp_vec3d v = vec3d((double)d[0] - (double)c[0], (double)d[1] - (double)c[1],
                        (double)d[2] - (double)c[2]);
    stp_vec3d cross = stp_normalized(stp_crossd(u, v));
    if (cross.x == 0.0 && cross.y == 0.0 && cross.z == 0.0) {
        cross.y = 1.0; // a pole of the sheet
    }
    n[0] = cross.x;
    n[1] = cross.y;
    n[2] = cross.z;
}

static void put_grid(shape_patch* p, uint32_t at, uint32_t columns, uint32_t rows, bool back)
{
    for (uint32_t k = 0; k + 1 < rows; ++k) {
        for (uint32_t i = 0; i + 1 < columns; ++i) {
            uint32_t a = at + k * columns + i, b = a + columns;
            if (back) {
                patch_quad(p, a, b, b + 1, a + 1);
            } else {
                patch_quad(p, a, a + 1, b + 1, b);
            }
        }
    }
}

// Strips that close the rim, with the normals of the front (a rim is only as high as the sheet is
// thick).
static void put_rim(shape_patch* p, uint32_t front, uint32_t columns, uint32_t rows)
{
    uint32_t back = front + columns * rows;
    for (uint32_t i = 0; i + 1 < columns; ++i) {
        uint32_t a = i, b = (rows - 1) * columns + i;
        patch_quad(p, front + a, back + a, back + a + 1, front + a + 1);
        patch_quad(p, front + b, front + b + 1, back + b + 1, back + b);
    }
    for (uint32_t k = 0; k + 1 < rows; ++k) {
        uint32_t a = k * columns, b = a + columns - 1;
        patch_quad(p, front + a, front + a + columns, back + a + columns, back + a);
        patch_quad(p, front + b, back + b, back + b + columns, front + b + columns);
    }
}

void shape_sheet(shaper* s, shape_surface surface, const void* user, int columns, int rows,
                 double thickness)
{
    size_t w = (size_t)columns + 1, h = (size_t)rows + 1, n = w * h;
    uint64_t faces = 2 * (uint64_t)columns * (uint64_t)rows;
    uint64_t rim = 4 * ((uint64_t)columns + (uint64_t)rows);
    bool thick = thickness > 0.0;
    shape_patch p;
    if (!shape_begin(s, thick ? 2 * n : n, thick ? 2 * faces + rim : faces, &p)) {
        return;
    }
    float *front = p.position, *normals = p.normal;
    for (size_t k = 0; k < h; ++k) {
        for (size_t i = 0; i < w; ++i) {
            stp_vec3d q = surface((double)i / columns, (double)k / rows, user);
            patch_vertex(&p, q.x, q.y, q.z, 0, 1, 0);
        }
    }
    for (size_t i = 0; i < n; ++i) {
        double normal[3];
        grid_normal(front, w, h, i % w, i / w, normal);
        for (size_t axis = 0; axis < 3; ++axis) {
            normals[3 * i + axis] = (float)normal[axis];
            if (thick) {
                double inside = (double)front[3 * i + axis] - thickness * normal[axis];
                front[3 * (n + i) + axis] = (float)inside;
                normals[3 * (n + i) + axis] = (float)-normal[axis];
            }
        }
    }
    put_grid(&p, p.first, (uint32_t)w, (uint32_t)h, false);
    if (thick) {
        put_grid(&p, p.first + (uint32_t)n, (uint32_t)w, (uint32_t)h, true);
        put_rim(&p, p.first, (uint32_t)w, (uint32_t)h);
    }
}
