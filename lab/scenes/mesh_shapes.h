// SPDX-License-Identifier: MIT
//
// Shapes for machines, pipes and steelwork, as a CAD exporter writes them: outward normals, smooth
// on round surfaces, split at hard edges.
//
// The same code counts and makes: a shaper without a builder only adds up triangles and vertices by
// formulas. So a plan of millions of triangles is counted and fitted to a wanted number before any
// is made.
#pragma once

#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"

enum {
    SHAPE_RINGS = 16,       ///< circles kept at a time
    SHAPE_MOST_SIDES = 256, ///< maximum sides of a circle
};

/// The points of a circle: cosine and sine in turn, the first repeated at the end.
typedef struct shape_ring {
    int sides; ///< 0: not computed yet
    double cosine[SHAPE_MOST_SIDES + 1], sine[SHAPE_MOST_SIDES + 1];
} shape_ring;

typedef struct shaper {
    mesh_builder* builder; ///< NULL: only counts
    uint64_t triangles, vertices;
    double tessellation; ///< factor on the sides of round shapes; 1: as designed
    double amount;       ///< factor on the number of details; at most 1
    double keep;         ///< probability of making a shape; below 1 only at small scales
    uint64_t seed, draws, shapes;
    stp_affine place; ///< placement of the next shapes: rotation and translation only
    shape_ring* rings;
} shaper;

/// Reserves the counted space, so that arrays are allocated once.
void shaper_reserve(shaper* s, uint64_t vertices, uint64_t triangles);
/// A uniform number in [0, 1).
double shaper_random(shaper* s);
double shaper_between(shaper* s, double low, double high);
/// `base` sides times the tessellation, rounded up or down at random so that totals grow evenly.
int shaper_sides(shaper* s, int base, int least);
/// `base` details times the amount, at least one.
int shaper_amount(shaper* s, int base);

// Placement. Lengths are metres. A push returns the previous place; pass it to pop.
stp_affine shaper_push(shaper* s, stp_affine local);
stp_affine shaper_move(shaper* s, double x, double y, double z);
void shaper_pop(shaper* s, stp_affine place);

/// Rotates about the vertical axis by a fraction of a turn (0.25: z goes to x), then moves.
stp_affine place_by_turn(double x, double y, double z, double turns);
/// The local y axis along `direction`, the origin at `point`.
stp_affine place_along(stp_vec3d point, stp_vec3d direction);

/// A box by its centre and its full sizes: 12 triangles.
void shape_box(shaper* s, double x, double y, double z, double width, double height, double depth);

typedef enum shape_ends { SHAPE_OPEN, SHAPE_CAPPED } shape_ends;

/// A surface of revolution about y. The profile's points are (radius, height); with radius to the
/// right and height upwards, the outside is on the right of its direction. Sharp corners are split.
void shape_lathe(shaper* s, const double (*profile)[2], int count, int sides);
/// Closed cylinder about y from height 0.
void shape_cylinder(shaper* s, double radius, double height, int sides);
/// A cylinder with a bore.
void shape_ring_solid(shaper* s, double inner, double outer, double height, int sides);
void shape_torus(shaper* s, double radius, double tube, int sides, int tube_sides);
/// A ball or, by height, an ellipsoid.
void shape_ball(shaper* s, double radius, double height, int sides);

/// A tube along points, with twist-free frames.
void shape_tube(shaper* s, const stp_vec3d* points, int count, double radius, int sides,
                shape_ends ends);
void shape_straight(shaper* s, stp_vec3d from, stp_vec3d to, double radius, int sides);

/// A prism along y. Its outline (x, z) is star-shaped about the origin and runs from x to z; `bore`
/// is the radius of a hole, 0: none. Nearly flat corners are smooth.
void shape_prism(shaper* s, const double (*outline)[2], int count, double bore, double length);

typedef enum shape_profile {
    PROFILE_I,
    PROFILE_U,
    PROFILE_L,
    PROFILE_T,
    PROFILE_TUBE
} shape_profile;

/// A rolled profile between two points. Its height is along the local x axis (place_along), which
/// points up where the beam is level.
void shape_beam(shaper* s, shape_profile profile, stp_vec3d from, stp_vec3d to, double height,
                double width, double thickness);
/// Flat bar or rectangular stick between two points: 12 triangles.
void shape_bar(shaper* s, stp_vec3d from, stp_vec3d to, double height, double width);

/// A V thread about y.
void shape_thread(shaper* s, double radius, double pitch, double length, int sides);
/// A coil spring about y.
void shape_coil(shaper* s, double radius, double wire, double pitch, double turns, int sides,
                int wire_sides);

/// A plate in x, z with a grid of round holes, including their walls. Its top is at y = 0.
void shape_perforated(shaper* s, double width, double depth, double thickness, int columns,
                      int rows, double hole, int sides);

/// A point of a curved sheet for u, v in [0, 1].
typedef stp_vec3d (*shape_surface)(double u, double v, const void* user);
/// A curved sheet with both sides and a rim; `thickness` 0: one side only. The outside is along
/// (d/du) x (d/dv).
void shape_sheet(shaper* s, shape_surface surface, const void* user, int columns, int rows,
                 double thickness);

/// Rounds the corners of a path: `out` receives the points. @return their number (at most
/// `capacity`)
int shape_round_path(const stp_vec3d* corners, int count, double bend, int steps, stp_vec3d* out,
                     int capacity);

static inline stp_vec3d vec3d(double x, double y, double z)
{
    return (stp_vec3d){x, y, z};
}
