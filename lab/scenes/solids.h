// SPDX-License-Identifier: MIT
//
// Solids for houses and trees. With a flat builder, faces share vertices; else each face has its
// normals.
#pragma once

#include "lab/scenes/mesh_builder.h"

static inline stp_vec3 point3(double x, double y, double z)
{
    return (stp_vec3){(float)x, (float)y, (float)z};
}

/// Four corners, counter-clockwise seen from the front.
void solid_quad(mesh_builder* builder, stp_vec3 a, stp_vec3 b, stp_vec3 c, stp_vec3 d);
/// A box: 12 triangles.
void solid_box(mesh_builder* builder, stp_vec3 min, stp_vec3 max);

typedef struct lathe_ring {
    double radius, height;
} lathe_ring;

/// A profile rotated about the y axis. Rings go upwards. Smooth unless the builder is flat. A
/// radius of 0 at an end closes it.
void solid_lathe(mesh_builder* builder, const lathe_ring* profile, int rings, int sides);

/// A sphere of 20 * 4^levels triangles, smooth.
void solid_sphere(mesh_builder* builder, stp_vec3 center, double radius, int levels);
