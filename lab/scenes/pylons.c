// SPDX-License-Identifier: MIT
#include "lab/scenes/compose.h"
#include "lab/scenes/paper.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/terrain.h"

enum { LINES = 5, PYLONS_PER_LINE = 61, PANELS = 14, ARMS = 3 };

static const double tower_height = 42.0;

static stp_vec3d mix(stp_vec3d a, stp_vec3d b, double t)
{
    return stp_addd(a, stp_scaled(stp_subd(b, a), t));
}

// Hexagonal heads along a bar, two at each end.
static void put_bolts(mesh_builder* builder, stp_vec3d from, stp_vec3d axis, double length,
                      stp_vec3d u, stp_vec3d v, double size)
{
    static const lathe_ring head[3] = {{0.024, 0.0}, {0.024, 0.02}, {0.0, 0.022}};
    static const double places[4] = {0.06, 0.14, -0.14, -0.06};
    stp_affine before = builder->place;
    for (int i = 0; i < 4; ++i) {
        double at = places[i] < 0.0 ? length + places[i] : places[i];
        stp_vec3d p = stp_addd(stp_addd(from, stp_scaled(axis, at)), stp_scaled(u, 0.5 * size));
        stp_affine there = {
            {{axis.x, -v.x, u.x, p.x}, {axis.y, -v.y, u.y, p.y}, {axis.z, -v.z, u.z, p.z}}};
        builder->place = stp_affine_multiply(before, there);
        solid_lathe(builder, head, 3, 6);
    }
    builder->place = before;
}

// An angle profile between two points, bolted at both ends.
static void put_bar(mesh_builder* builder, stp_vec3d from, stp_vec3d to, double size)
{
    static const double outline[6][2] = {{0, 0},       {1, 0},    {1, 0.12},
                                         {0.12, 0.12}, {0.12, 1}, {0, 1}};
    static const unsigned char caps[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
    stp_vec3d along = stp_subd(to, from);
    double length = sqrt(stp_dotd(along, along));
    stp_vec3d axis = stp_scaled(along, 1.0 / length);
    stp_vec3d helper = axis.y * axis.y < 0.5 ? (stp_vec3d){0, 1, 0} : (stp_vec3d){1, 0, 0};
    stp_vec3d u = stp_normalized(stp_crossd(axis, helper)), v = stp_crossd(axis, u);
    uint32_t first = (uint32_t)builder->vertex_count;
    for (int i = 0; i < 12; ++i) {
        stp_vec3d p = i < 6 ? from : to;
        p = stp_addd(p, stp_scaled(u, size * outline[i % 6][0]));
        p = stp_addd(p, stp_scaled(v, size * outline[i % 6][1]));
        mesh_builder_vertex(builder, stp_to_float(p), (stp_vec3){0});
    }
    for (uint32_t i = 0; i < 6; ++i) {
        uint32_t a = first + i, b = first + (i + 1) % 6;
        mesh_builder_triangle(builder, a, b, b + 6);
        mesh_builder_triangle(builder, a, b + 6, a + 6);
    }
    for (int i = 0; i < 4; ++i) {
        const unsigned char* c = caps[i];
        mesh_builder_triangle(builder, first + c[0], first + c[2], first + c[1]);
        mesh_builder_triangle(builder, first + 6 + c[0], first + 6 + c[1], first + 6 + c[2]);
    }
    put_bolts(builder, from, axis, length, u, v, size);
}

// Half width of the tower at a height: narrows to the waist, then stays constant.
static double half_width(double y)
{
    const double foot = 3.6, waist = 0.75, waist_height = 27.0;
    return y < waist_height ? foot + (waist - foot) * y / waist_height : waist;
}

static stp_vec3d corner(int i, double y)
{
    double w = half_width(y);
    return (stp_vec3d){i == 0 || i == 3 ? -w : w, y, i < 2 ? -w : w};
}

// A panel of one face: crossed diagonals, the bar above, and thin bars that stiffen the legs.
static void put_panel(mesh_builder* builder, int face, double low, double high)
{
    stp_vec3d a = corner(face, low), b = corner((face + 1) % 4, low);
    stp_vec3d c = corner((face + 1) % 4, high), d = corner(face, high);
    stp_vec3d middle = mix(mix(a, c, 0.5), mix(b, d, 0.5), 0.5);
    put_bar(builder, a, c, 0.08);
    put_bar(builder, b, d, 0.08);
    put_bar(builder, d, c, 0.07);
    put_bar(builder, mix(a, d, 0.5), middle, 0.05);
    put_bar(builder, mix(b, c, 0.5), middle, 0.05);
    put_bar(builder, mix(a, d, 0.25), mix(a, middle, 0.5), 0.045);
    put_bar(builder, mix(b, c, 0.25), mix(b, middle, 0.5), 0.045);
}

static void put_insulators(mesh_builder* builder, stp_vec3d top)
{
    enum { DISCS = 12 };
    lathe_ring rings[2 * DISCS + 2];
    for (int i = 0; i < DISCS; ++i) {
        rings[2 * i] = (lathe_ring){0.04, 0.17 * i};
        rings[2 * i + 1] = (lathe_ring){0.14, 0.17 * i + 0.05};
    }
    rings[2 * DISCS] = (lathe_ring){0.03, 0.17 * DISCS};
    rings[2 * DISCS + 1] = (lathe_ring){0.0, 0.17 * DISCS + 0.2};
    stp_affine before = builder->place, there = place_at(top.x, top.y - 2.24, top.z);
    builder->place = stp_affine_multiply(before, there);
    solid_lathe(builder, rings, 2 * DISCS + 2, 12);
    builder->place = before;
}

// An arm: two chords below, two above that meet them at the tip, laced.
static void put_arm(mesh_builder* builder, double y, double reach, double side)
{
    enum { FIELDS = 6 };
    double w = half_width(y);
    stp_vec3d tip = {side * reach, y, 0};
    stp_vec3d roots[4] = {
        {side * w, y, -w}, {side * w, y, w}, {side * w, y + 1.6, -w}, {side * w, y + 1.6, w}};
    for (int i = 0; i < 4; ++i) {
        put_bar(builder, roots[i], tip, 0.09);
    }
    for (int i = 0; i < FIELDS; ++i) {
        double t = (double)i / FIELDS, next = (double)(i + 1) / FIELDS - 0.02;
        put_bar(builder, mix(roots[0], tip, t), mix(roots[1], tip, next), 0.05);
        put_bar(builder, mix(roots[0], tip, next), mix(roots[2], tip, t), 0.05);
        put_bar(builder, mix(roots[1], tip, next), mix(roots[3], tip, t), 0.05);
    }
    put_insulators(builder, tip);
}

void pylon_make(struct mesh_builder* builder, const void* parameters)
{
    (void)parameters;
    builder->flat = true;
    double low = 0.0;
    for (int panel = 0; panel < PANELS; ++panel) {
        double t = (double)(panel + 1) / PANELS;
        double high =
            tower_height * (t < 1.0 ? t * (1.35 - 0.35 * t) : 1.0); // lower ones are taller
        for (int face = 0; face < 4; ++face) {
            put_panel(builder, face, low, high);
            put_bar(builder, corner(face, low), corner(face, high), 0.16);
        }
        low = high;
    }
    static const double reaches[ARMS] = {7.0, 8.5, 6.0};
    for (int arm = 0; arm < ARMS; ++arm) {
        put_arm(builder, 28.0 + 5.2 * arm, reaches[arm], 1.0);
        put_arm(builder, 28.0 + 5.2 * arm, reaches[arm], -1.0);
    }
    for (int i = 0; i < 4; ++i) { // the feet's concrete
        stp_vec3d foot = corner(i, 0.0);
        solid_box(builder, point3(foot.x - 0.5, -1.0, foot.z - 0.5),
                  point3(foot.x + 0.5, 0.25, foot.z + 0.5));
    }
}

stp_result scene_add_pylons(stp_scene* scene, uint32_t parent, const scene_options* options)
{
    static const double rows[LINES] = {-1520.0, -1180.0, -880.0, -330.0, 1330.0};
    uint32_t count = (uint32_t)(LINES * PYLONS_PER_LINE * options->scale + 0.5), material, mesh,
             group;
    count = count < 1 ? 1 : count;
    stp_affine still = stp_affine_identity();
    stp_result result = add_plain_material(scene, "galvanised lattice", 0x9aa0a4, 0.6, &material);
    mesh_recipe recipe = {"pylon", pylon_make, NULL, material};
    result = result == STP_OK ? make_meshes(scene, &recipe, 1, &mesh) : result;
    result = result == STP_OK ? add_group(scene, "Pylons", parent, &still, &group) : result;
    terrain_map map;
    terrain_map_make(&map, options->seed);
    for (uint32_t i = 0; result == STP_OK && i < count; ++i) {
        double along =
            -2500.0 + 5000.0 * (double)(i / LINES % PYLONS_PER_LINE) / (PYLONS_PER_LINE - 1);
        double z = rows[i % LINES] + 3.0 * (double)(i / (LINES * PYLONS_PER_LINE));
        stp_affine place = place_turned(along, terrain_height(&map, along, z), z, 0.25, 1.0);
        result = add_mesh_object(scene, "pylon", group, &place, mesh);
    }
    return result;
}
