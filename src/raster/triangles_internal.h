// SPDX-License-Identifier: MIT
// Shared by the variants of the triangle kernels: the sub-pixel grid, and triangle setup.
//
// All variants compile the same source (triangles_lanes.h) for vectors of different width. Coverage
// is integer arithmetic and nearness a fixed sequence of float operations, so all give the same
// bits.
#pragma once

#include "raster/triangles.h"

#include <assert.h>

enum {
    STP_SUBPIXEL_BITS = 8,
    STP_SUBPIXEL = 1 << STP_SUBPIXEL_BITS,
    STP_SUBPIXEL_HALF = STP_SUBPIXEL / 2,
    /// Largest coordinate, sub-pixels: 2^21 pixels; products stay below 2^62
    STP_GUARD_BAND = 1 << 29,
    /// X of a vertex that may not be drawn unclipped; y holds its outcode
    STP_OUTSIDE = -(1 << 30),
    STP_SMALL_EXTENT = 1 << 15, ///< sub-pixels: smaller triangles have 32-bit edge functions
    STP_LANES_MAX = 16,
};

/// Points with a smaller W do not count as in front of the eye.
#define STP_MIN_W 1e-30f
/// Smallest nearness drawn: 0 marks an empty pixel.
#define STP_MIN_NEARNESS FLT_MIN

typedef struct stp_screen_vertex {
    int32_t x, y; ///< sub-pixels
    float nearness;
} stp_screen_vertex;

/// Drawing target: rows [row_begin, row_end) of a picture.
typedef struct stp_triangle_window {
    uint64_t* pixels; ///< pixels from row first_row on
    size_t stride;
    int32_t width, first_row, row_begin, row_end;
    int32_t facing;      ///< as in stp_raster_mesh
    size_t behind;       ///< likewise
    uint64_t* fragments; ///< counts those inside triangles
} stp_triangle_window;

static inline uint64_t* stp_triangle_row(const stp_triangle_window* window, int32_t row)
{
    assert(row >= window->first_row);
    return window->pixels + (size_t)(row - window->first_row) * window->stride;
}

/// Writes a pixel into the picture from behind, where depths are the other way round.
static inline void stp_triangle_write_behind(uint64_t* place, uint64_t pixel)
{
    uint64_t other = pixel ^ UINT64_C(0xFFFFFFFF00000000);
    *place = other < *place ? other : *place;
}

/// Triangles with transformed vertices; a piece of a mesh.
typedef struct stp_triangle_chunk {
    stp_triangle_window window;
    const uint32_t* indices; ///< 3 per triangle
    uint32_t index_base;     ///< index of the vertex at x[0]
    uint32_t triangle_count;
    uint32_t first_id;
    const uint32_t* numbers; ///< NULL, or one per triangle, added to first_id
    int32_t *x, *y;          ///< one per vertex
    float* nearness;
    /// Receives the triangles that need clipping, counted from the chunk's first
    uint32_t* clipped;
    uint32_t clipped_count;
} stp_triangle_chunk;

typedef struct stp_triangle_transform {
    float matrix[4][4];
    float offset[3];
    float nearness_limit;
} stp_triangle_transform;

/// One variant. `transform` writes up to STP_LANES_MAX - 1 elements past `count`.
typedef struct stp_triangle_kernels {
    void (*find_range)(const uint32_t* indices, size_t count, uint32_t* minimum, uint32_t* maximum);
    void (*transform)(const stp_triangle_transform* transform, const float* positions, size_t count,
                      int32_t* x, int32_t* y, float* nearness);
    void (*draw_chunk)(stp_triangle_chunk* chunk);
    void (*draw_one)(const stp_triangle_window* window, const stp_screen_vertex corners[3],
                     uint32_t id);
} stp_triangle_kernels;

extern const stp_triangle_kernels stp_triangle_kernels_portable;
extern const stp_triangle_kernels stp_triangle_kernels_vector;
extern const stp_triangle_kernels stp_triangle_kernels_wide;

/// Rounds sub-pixels to the nearest grid point, halves to even; out-of-range results are undefined.
/// Adding 1.5 x 2^52 leaves the integer in the low bits of the double.
static inline int32_t stp_triangle_snap(double grid)
{
    double shifted = grid + 6755399441055744.0;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof(bits));
    return (int32_t)(uint32_t)bits;
}

/// A vertex in homogeneous screen coordinates.
typedef struct stp_screen_point {
    double x, y, n, w;
} stp_screen_point;

/// Planes that a point lies beyond, as bits; 0: no clipping needed. NaN lies beyond both planes of
/// its coordinate.
uint32_t stp_triangle_outcode(float x, float y, float n, float w, float nearness_limit);

/// Homogeneous screen coordinates of a position, with the same bits as in the kernels.
void stp_triangle_project(const stp_triangle_transform* transform, const float* position,
                          float out[4]);

/// Three corners and one more for each of seven planes; the rest is for polygons that rounding made
/// concave.
enum { STP_CLIPPED_MAX = 16 };

/// Clips a triangle. @return corners of a convex polygon, 0 if nothing is left
uint32_t stp_triangle_clip(const stp_triangle_transform* transform, const float* const corners[3],
                           stp_screen_vertex polygon[STP_CLIPPED_MAX]);

/// A triangle in the window, oriented so that its area is positive.
typedef struct stp_triangle_setup {
    stp_screen_vertex corner[3];
    int64_t area;                     ///< twice, square sub-pixels
    int32_t left, right, top, bottom; ///< pixels whose centres may be inside, inclusive
    float low, high;                  ///< range of nearness
    bool small;                       ///< edge functions fit 32 bits
} stp_triangle_setup;

static inline int32_t stp_triangle_min(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t stp_triangle_max(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/// @return false if the triangle certainly covers no pixel centre of the window
static inline bool stp_triangle_set_up(const stp_triangle_window* window,
                                       const stp_screen_vertex corners[3],
                                       stp_triangle_setup* setup)
{
    stp_screen_vertex a = corners[0], b = corners[1], c = corners[2];
    int32_t min_x = stp_triangle_min(a.x, stp_triangle_min(b.x, c.x));
    int32_t max_x = stp_triangle_max(a.x, stp_triangle_max(b.x, c.x));
    int32_t min_y = stp_triangle_min(a.y, stp_triangle_min(b.y, c.y));
    int32_t max_y = stp_triangle_max(a.y, stp_triangle_max(b.y, c.y));
    assert(min_x >= -STP_GUARD_BAND && max_x <= STP_GUARD_BAND && min_y >= -STP_GUARD_BAND &&
           max_y <= STP_GUARD_BAND && "products of coordinates fit 64 bits");
    setup->left = stp_triangle_max((min_x + STP_SUBPIXEL_HALF - 1) >> STP_SUBPIXEL_BITS, 0);
    setup->right =
        stp_triangle_min((max_x - STP_SUBPIXEL_HALF) >> STP_SUBPIXEL_BITS, window->width - 1);
    setup->top =
        stp_triangle_max((min_y + STP_SUBPIXEL_HALF - 1) >> STP_SUBPIXEL_BITS, window->row_begin);
    setup->bottom =
        stp_triangle_min((max_y - STP_SUBPIXEL_HALF) >> STP_SUBPIXEL_BITS, window->row_end - 1);
    if (setup->left > setup->right || setup->top > setup->bottom) {
        return false;
    }
    setup->area = (int64_t)(b.x - a.x) * (c.y - a.y) - (int64_t)(b.y - a.y) * (c.x - a.x);
    if ((window->facing > 0 && setup->area < 0) || (window->facing < 0 && setup->area > 0)) {
        return false;
    }
    setup->corner[0] = a;
    setup->corner[1] = setup->area < 0 ? c : b;
    setup->corner[2] = setup->area < 0 ? b : c;
    setup->area = setup->area < 0 ? -setup->area : setup->area;
    setup->low = stp_min(a.nearness, stp_min(b.nearness, c.nearness));
    setup->high = stp_max(a.nearness, stp_max(b.nearness, c.nearness));
    setup->small = max_x - min_x < STP_SMALL_EXTENT && max_y - min_y < STP_SMALL_EXTENT;
    return setup->area != 0;
}

/// One edge function; it is at least 0 on the inner side. It falls by `dy` per sub-pixel along x
/// and grows by `dx` along y. The bias assigns centres on the edge to the triangle for which it is
/// a top or left edge.
typedef struct stp_triangle_edge {
    int64_t dx, dy, bias;
    int64_t x, y; ///< first corner of the edge
} stp_triangle_edge;

static inline stp_triangle_edge stp_triangle_edge_make(stp_screen_vertex a, stp_screen_vertex b)
{
    int64_t dx = (int64_t)b.x - a.x, dy = (int64_t)b.y - a.y;
    bool top_left = dy < 0 || (dy == 0 && dx > 0);
    return (stp_triangle_edge){.dx = dx, .dy = dy, .bias = top_left ? 0 : -1, .x = a.x, .y = a.y};
}

/// The edge function at a pixel's centre, without bias.
static inline int64_t stp_triangle_edge_at(const stp_triangle_edge* edge, int32_t column,
                                           int32_t row)
{
    int64_t x = (int64_t)column * STP_SUBPIXEL + STP_SUBPIXEL_HALF;
    int64_t y = (int64_t)row * STP_SUBPIXEL + STP_SUBPIXEL_HALF;
    return edge->dx * (y - edge->y) - edge->dy * (x - edge->x);
}

/// Narrows [*first, *last] to the columns of a row whose centres are on the inner side.
static inline void stp_triangle_edge_narrow(const stp_triangle_edge* edge, int32_t row,
                                            int64_t* first, int64_t* last)
{
    int64_t value = stp_triangle_edge_at(edge, 0, row) + edge->bias; // at column 0
    int64_t step = edge->dy * STP_SUBPIXEL;
    if (step > 0) { // value - column * step >= 0
        int64_t limit = value >= 0 ? value / step : -1;
        *last = limit < *last ? limit : *last;
    } else if (step < 0) {
        int64_t limit = value >= 0 ? 0 : (-value + (-step - 1)) / -step;
        *first = limit > *first ? limit : *first;
    } else if (value < 0) {
        *last = *first - 1;
    }
}

/// Nearness plane in double, for triangles that are not small.
typedef struct stp_triangle_plane {
    double x, y, nearness, along_x, along_y;
} stp_triangle_plane;

static inline stp_triangle_plane stp_triangle_plane_make(const stp_triangle_setup* setup)
{
    const stp_screen_vertex* v = setup->corner;
    assert(setup->area > 0);
    double x1 = (double)(v[1].x - v[0].x), y1 = (double)(v[1].y - v[0].y);
    double x2 = (double)(v[2].x - v[0].x), y2 = (double)(v[2].y - v[0].y);
    double n1 = (double)v[1].nearness - (double)v[0].nearness;
    double n2 = (double)v[2].nearness - (double)v[0].nearness;
    double area = (double)setup->area;
    return (stp_triangle_plane){
        .x = (double)v[0].x,
        .y = (double)v[0].y,
        .nearness = (double)v[0].nearness,
        .along_x = (n1 * y2 - n2 * y1) / area,
        .along_y = (n2 * x1 - n1 * x2) / area,
    };
}

static inline double stp_triangle_plane_row(const stp_triangle_plane* plane, int32_t row)
{
    double y = (double)row * (double)STP_SUBPIXEL + (double)STP_SUBPIXEL_HALF;
    return plane->nearness + plane->along_y * (y - plane->y);
}

static inline float stp_triangle_plane_at(const stp_triangle_plane* plane, double row_nearness,
                                          int32_t column, float low, float high)
{
    double x = (double)column * (double)STP_SUBPIXEL + (double)STP_SUBPIXEL_HALF;
    float nearness = (float)(row_nearness + plane->along_x * (x - plane->x));
    nearness = nearness > low ? nearness : low;
    return nearness < high ? nearness : high;
}

/// Nearness of a small triangle from the edge functions opposite corners 1 and 2.
static inline float stp_triangle_small_nearness(const stp_triangle_setup* setup, float inverse_area,
                                                int32_t edge1, int32_t edge2)
{
    assert(setup->small && "edge functions fit 32 bits");
    float n0 = setup->corner[0].nearness;
    float nearness = n0 + ((float)edge1 * inverse_area) * (setup->corner[1].nearness - n0);
    nearness = nearness + ((float)edge2 * inverse_area) * (setup->corner[2].nearness - n0);
    nearness = nearness > setup->low ? nearness : setup->low;
    return nearness < setup->high ? nearness : setup->high;
}
