// SPDX-License-Identifier: MIT
#include "lab/scenes/solids.h"

#include "lab/scenes/trigonometry.h"

void solid_quad(mesh_builder* builder, stp_vec3 a, stp_vec3 b, stp_vec3 c, stp_vec3 d)
{
    stp_vec3 normal = stp_cross(stp_sub(c, a), stp_sub(d, b));
    uint32_t first = mesh_builder_vertex(builder, a, normal);
    mesh_builder_vertex(builder, b, normal);
    mesh_builder_vertex(builder, c, normal);
    mesh_builder_vertex(builder, d, normal);
    mesh_builder_triangle(builder, first, first + 1, first + 2);
    mesh_builder_triangle(builder, first, first + 2, first + 3);
}

// Corner i of a box: bit 0 is x, bit 1 y, bit 2 z. Counter-clockwise from outside.
static const unsigned char box_faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                              {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

void solid_box(mesh_builder* builder, stp_vec3 min, stp_vec3 max)
{
    if (builder->counting) {
        builder->index_count += 36;
        return;
    }
    stp_vec3 corners[8];
    for (int i = 0; i < 8; ++i) {
        corners[i] = (stp_vec3){(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y,
                                (i & 4) != 0 ? max.z : min.z};
    }
    if (!builder->flat) {
        for (int f = 0; f < 6; ++f) {
            const unsigned char* face = box_faces[f];
            solid_quad(builder, corners[face[0]], corners[face[1]], corners[face[2]],
                       corners[face[3]]);
        }
        return;
    }
    uint32_t first = 0;
    for (int i = 0; i < 8; ++i) {
        uint32_t index = mesh_builder_vertex(builder, corners[i], (stp_vec3){0});
        first = i == 0 ? index : first;
    }
    for (int f = 0; f < 6; ++f) {
        const unsigned char* face = box_faces[f];
        mesh_builder_triangle(builder, first + face[0], first + face[1], first + face[2]);
        mesh_builder_triangle(builder, first + face[0], first + face[2], first + face[3]);
    }
}

// The outward slope of a profile at a ring, from its neighbours.
static stp_vec3 ring_normal(const lathe_ring* profile, int rings, int ring)
{
    int below = ring > 0 ? ring - 1 : 0, above = ring + 1 < rings ? ring + 1 : ring;
    return point3(profile[above].height - profile[below].height,
                  profile[below].radius - profile[above].radius, 0);
}

static uint32_t add_ring(mesh_builder* builder, const lathe_ring* profile, int rings, int ring,
                         int sides)
{
    stp_vec3 slope = ring_normal(profile, rings, ring);
    double radius = profile[ring].radius, height = profile[ring].height;
    if (!(radius > 0.0)) {
        return mesh_builder_vertex(builder, point3(0, height, 0),
                                   point3(0, ring == 0 ? -1.0 : 1.0, 0));
    }
    uint32_t first = 0;
    for (int i = 0; i < sides; ++i) {
        double c = turn_cosine((double)i / sides), s = turn_sine((double)i / sides);
        uint32_t index =
            mesh_builder_vertex(builder, point3(radius * c, height, radius * s),
                                point3((double)slope.x * c, (double)slope.y, (double)slope.x * s));
        first = i == 0 ? index : first;
    }
    return first;
}

static size_t lathe_triangles(const lathe_ring* profile, int rings, int sides)
{
    size_t count = 0;
    for (int ring = 1; ring < rings; ++ring) {
        count += (size_t)sides * ((profile[ring].radius > 0.0 ? 1u : 0u) +
                                  (profile[ring - 1].radius > 0.0 ? 1u : 0u));
    }
    return count;
}

void solid_lathe(mesh_builder* builder, const lathe_ring* profile, int rings, int sides)
{
    if (builder->counting) {
        builder->index_count += 3 * lathe_triangles(profile, rings, sides);
        return;
    }
    uint32_t below = 0;
    for (int ring = 0; ring < rings; ++ring) {
        uint32_t above = add_ring(builder, profile, rings, ring, sides);
        for (int i = 0; ring > 0 && i < sides; ++i) {
            uint32_t k = (uint32_t)i, next = (uint32_t)((i + 1) % sides);
            bool tip = !(profile[ring].radius > 0.0), base = !(profile[ring - 1].radius > 0.0);
            if (!tip) {
                mesh_builder_triangle(builder, below + (base ? 0 : k), above + k, above + next);
            }
            if (!base) {
                mesh_builder_triangle(builder, below + k, above + (tip ? 0 : next), below + next);
            }
        }
        below = above;
    }
}

static void subdivide(mesh_builder* builder, stp_vec3 center, double radius,
                      const stp_vec3 corners[3], const uint32_t indices[3], int levels)
{
    if (levels == 0) {
        mesh_builder_triangle(builder, indices[0], indices[1], indices[2]);
        return;
    }
    stp_vec3 middles[3];
    uint32_t between[3];
    for (int i = 0; i < 3; ++i) { // neighbours compute the same points, bit for bit
        middles[i] = stp_normalize(stp_add(corners[i], corners[(i + 1) % 3]));
        between[i] = mesh_builder_vertex(
            builder, stp_add(center, stp_scale(middles[i], (float)radius)), middles[i]);
    }
    for (int i = 0; i < 3; ++i) {
        stp_vec3 corner[3] = {corners[i], middles[i], middles[(i + 2) % 3]};
        uint32_t index[3] = {indices[i], between[i], between[(i + 2) % 3]};
        subdivide(builder, center, radius, corner, index, levels - 1);
    }
    subdivide(builder, center, radius, middles, between, levels - 1);
}

void solid_sphere(mesh_builder* builder, stp_vec3 center, double radius, int levels)
{
    static const double golden = 1.61803398874989484820;
    static const unsigned char faces[20][3] = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    if (builder->counting) {
        builder->index_count += (size_t)60 << (2 * levels);
        return;
    }
    stp_vec3 corners[12];
    uint32_t indices[12];
    for (int i = 0; i < 12; ++i) {
        double one = (i & 1) != 0 ? 1.0 : -1.0, far = (i & 2) != 0 ? -golden : golden;
        stp_vec3 p = i < 4   ? point3(one, far, 0)
                     : i < 8 ? point3(0, one, far)
                             : point3((i & 2) != 0 ? -golden : golden, 0, one);
        corners[i] = stp_normalize(p);
        indices[i] = mesh_builder_vertex(
            builder, stp_add(center, stp_scale(corners[i], (float)radius)), corners[i]);
    }
    for (int f = 0; f < 20; ++f) {
        const unsigned char* face = faces[f];
        stp_vec3 corner[3] = {corners[face[0]], corners[face[1]], corners[face[2]]};
        uint32_t index[3] = {indices[face[0]], indices[face[1]], indices[face[2]]};
        subdivide(builder, center, radius, corner, index, levels);
    }
}
