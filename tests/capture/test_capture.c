// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/io/hash.h"
#include "base/math/color.h"
#include "base/math/rng.h"
#include "capture/capture.h"
#include "capture/capture_internal.h"

#include <string.h>

/// A scene under construction, and its parts.
typedef struct test_scene {
    stp_scene* scene;
    stp_placed_part parts[64];
    size_t part_count;
} test_scene;

static test_scene scene_over(stp_context* context)
{
    test_scene made = {0};
    return stp_scene_create(context, &made.scene) == STP_OK ? made : (test_scene){0};
}

static stp_affine scaled_and_moved(double x, double y, double z, double tx, double ty, double tz)
{
    return (stp_affine){{{x, 0, 0, tx}, {0, y, 0, ty}, {0, 0, z, tz}}};
}

static void place(test_scene* t, stp_part_kind kind, uint32_t index, stp_affine transform)
{
    t->parts[t->part_count++] = (stp_placed_part){.part = {kind, index}, .transform = transform};
}

static void set_bounds(stp_mesh* mesh)
{
    mesh->bounds = stp_box_empty();
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const float* p = mesh->positions + 3 * (size_t)v;
        stp_box_add(&mesh->bounds, (stp_vec3){p[0], p[1], p[2]});
    }
}

/// Allocates a mesh; false if out of memory (then everything is freed).
static bool make_mesh(test_scene* t, uint32_t vertices, uint32_t triangles, bool normals,
                      bool texcoords, bool colors, stp_mesh* mesh)
{
    stp_context* context = t->scene->context;
    *mesh = (stp_mesh){.vertex_count = vertices, .triangle_count = triangles};
    mesh->positions = STP_NEW_ZEROED(context, float, 3 * (size_t)vertices);
    mesh->indices = STP_NEW_ZEROED(context, uint32_t, 3 * (size_t)triangles);
    mesh->normals = normals ? STP_NEW_ZEROED(context, float, 3 * (size_t)vertices) : NULL;
    mesh->texcoords[0] = texcoords ? STP_NEW_ZEROED(context, float, 2 * (size_t)vertices) : NULL;
    mesh->colors = colors ? STP_NEW_ZEROED(context, uint16_t, 4 * (size_t)vertices) : NULL;
    if (mesh->positions != NULL && mesh->indices != NULL && (!normals || mesh->normals != NULL) &&
        (!texcoords || mesh->texcoords[0] != NULL) && (!colors || mesh->colors != NULL)) {
        return true;
    }
    stp_free(context, mesh->positions);
    stp_free(context, mesh->indices);
    stp_free(context, mesh->normals);
    stp_free(context, mesh->texcoords[0]);
    stp_free(context, mesh->colors);
    return false;
}

/// A unit sphere of `rings` x 2 `rings` quads, from an octahedron's unfolding: no sines needed.
static bool add_sphere(test_scene* t, uint32_t rings, bool normals, uint32_t material,
                       uint32_t* index)
{
    stp_mesh mesh;
    uint32_t side = rings + 1;
    if (!make_mesh(t, 6 * side * side, 12 * rings * rings, normals, false, false, &mesh)) {
        return false;
    }
    mesh.material = material;
    uint32_t* out = mesh.indices;
    for (uint32_t face = 0; face < 6; ++face) { // an inflated cube's faces
        for (uint32_t v = 0; v < side * side; ++v) {
            float a = (float)(v % side) / (float)rings * 2.0f - 1.0f;
            float b = (float)(v / side) / (float)rings * 2.0f - 1.0f;
            float s = face % 2 == 0 ? 1.0f : -1.0f;
            stp_vec3 p = face < 2   ? (stp_vec3){s, a, b}
                         : face < 4 ? (stp_vec3){a, s, b}
                                    : (stp_vec3){a, b, s};
            p = stp_normalize(p);
            memcpy(mesh.positions + 3 * (face * side * side + v), &p, sizeof(p));
            if (normals) {
                memcpy(mesh.normals + 3 * (face * side * side + v), &p, sizeof(p));
            }
        }
        for (uint32_t q = 0; q < rings * rings; ++q) {
            uint32_t i = face * side * side + q / rings * side + q % rings;
            uint32_t quad[6] = {i, i + 1, i + side, i + 1, i + side + 1, i + side};
            memcpy(out, quad, sizeof(quad));
            out += 6;
        }
    }
    set_bounds(&mesh);
    return stp_scene_add_mesh(t->scene, &mesh, index) == STP_OK;
}

/// The square [-1, 1]^2 in x and y at z = 0, in cells x cells quads; texture coordinates 0..1.
static bool add_square(test_scene* t, uint32_t cells, uint32_t material, uint32_t* index)
{
    stp_mesh mesh;
    uint32_t side = cells + 1;
    if (!make_mesh(t, side * side, 2 * cells * cells, false, true, false, &mesh)) {
        return false;
    }
    mesh.material = material;
    for (uint32_t v = 0; v < side * side; ++v) {
        float a = (float)(v % side) / (float)cells, b = (float)(v / side) / (float)cells;
        mesh.positions[3 * v] = 2.0f * a - 1.0f;
        mesh.positions[3 * v + 1] = 2.0f * b - 1.0f;
        mesh.texcoords[0][2 * v] = a;
        mesh.texcoords[0][2 * v + 1] = b;
    }
    for (uint32_t q = 0; q < cells * cells; ++q) {
        uint32_t i = q / cells * side + q % cells;
        uint32_t quad[6] = {i, i + 1, i + side, i + 1, i + side + 1, i + side};
        memcpy(mesh.indices + 6 * (size_t)q, quad, sizeof(quad));
    }
    set_bounds(&mesh);
    return stp_scene_add_mesh(t->scene, &mesh, index) == STP_OK;
}

static stp_vec3 candidate_position(const stp_candidates* c, uint32_t i)
{
    const float* p = c->positions + 3 * (size_t)i;
    return (stp_vec3){p[0], p[1], p[2]};
}

static stp_vec3 candidate_normal(const stp_candidates* c, uint32_t i)
{
    const float* n = c->normals + 3 * (size_t)i;
    return (stp_vec3){n[0], n[1], n[2]};
}

static stp_result capture(const test_scene* t, uint64_t wanted, uint32_t resolution,
                          stp_candidates* out)
{
    stp_capture_desc desc = {.wanted_candidates = wanted, .resolution = resolution};
    return stp_capture_parts(t->scene, t->parts, t->part_count, &desc, out);
}

void test_capture_directions_are_unit_and_spread(test_state* test)
{
    static const uint32_t counts[] = {1, 2, 6, 8, 14, 16, 26, 100};
    for (size_t n = 0; n < sizeof(counts) / sizeof(counts[0]); ++n) {
        stp_vec3d d[100];
        stp_capture_directions(counts[n], d);
        stp_vec3d sum = {0};
        double nearest = 4.0;
        for (uint32_t i = 0; i < counts[n]; ++i) {
            CHECK(fabs(stp_dotd(d[i], d[i]) - 1.0) < 1e-12);
            sum = stp_addd(sum, d[i]);
            for (uint32_t j = 0; j < i; ++j) {
                stp_vec3d apart = stp_subd(d[i], d[j]);
                double distance = stp_dotd(apart, apart);
                nearest = distance < nearest ? distance : nearest;
            }
        }
        // n evenly spread points have about 4 pi / n steradians each
        CHECK(counts[n] < 2 || nearest * (double)counts[n] > 5.0);
        CHECK(counts[n] < 2 || stp_dotd(sum, sum) < 1.0);
    }
}

void test_capture_sphere_is_on_the_sphere(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    uint32_t sphere;
    CHECK(add_sphere(&t, 24, true, 0, &sphere));
    place(&t, STP_PART_MESH, sphere, scaled_and_moved(3, 3, 3, 10, 20, 30));
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 20000, 0, &c));
    CHECK(c.count > 15000 && c.count < 25000);
    CHECK_EQUAL(8, c.direction_count);
    CHECK_EQUAL(c.count, c.covered_pixels);
    CHECK_EQUAL(8 * 24 * 24 * 12, c.triangle_views);
    CHECK(fabs(c.origin.x - 10) + fabs(c.origin.y - 20) + fabs(c.origin.z - 30) < 1e-5);
    // eight disks of radius 3 at one scale
    double expected = 8.0 * STP_PI * 9.0 / (c.pixel_size * c.pixel_size);
    CHECK(fabs((double)c.count / expected - 1.0) < 0.02);
    for (uint32_t i = 0; i < c.count; ++i) {
        stp_vec3 p = candidate_position(&c, i), n = candidate_normal(&c, i);
        CHECK(stp_length(p) < 3.0001f && stp_length(p) > 2.97f); // the facets of the mesh
        CHECK(fabsf(stp_length(n) - 1.0f) < 1e-5f);
        CHECK(stp_dot(n, stp_normalize(p)) > 0.998f);
        CHECK_EQUAL(0, c.materials[i]);
        CHECK_EQUAL(255, c.colors[4 * i + 3]);
    }
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_sees_the_outside_only(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    stp_material red = stp_material_default();
    red.base_color[1] = red.base_color[2] = 0.0f;
    uint32_t inner, outer, material;
    CHECK_EQUAL(STP_OK, stp_scene_add_material(t.scene, &red, &material));
    CHECK(add_sphere(&t, 16, false, material, &inner));
    CHECK(add_sphere(&t, 16, false, 0, &outer));
    place(&t, STP_PART_MESH, inner, scaled_and_moved(0.95, 0.95, 0.95, 0, 0, 0));
    place(&t, STP_PART_MESH, outer, stp_affine_identity());
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 30000, 0, &c));
    CHECK(c.count > 20000);
    for (uint32_t i = 0; i < c.count; ++i) {
        CHECK_EQUAL(0, c.materials[i]);
        CHECK_EQUAL(255, c.colors[4 * i + 1]);
        // flat normals of a convex shape point outwards
        CHECK(stp_dot(candidate_normal(&c, i), stp_normalize(candidate_position(&c, i))) > 0.98f);
    }
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_thin_wall_has_two_sides(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    uint32_t square;
    CHECK(add_square(&t, 3, 0, &square));
    place(&t, STP_PART_MESH, square, scaled_and_moved(5, 5, 1, 0, 0, 0));
    stp_candidates c; // all in one plane: the box has no depth
    CHECK_EQUAL(STP_OK, capture(&t, 10000, 0, &c));
    CHECK(c.count > 7000 && c.count < 14000);
    uint32_t front = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        stp_vec3 p = candidate_position(&c, i), n = candidate_normal(&c, i);
        CHECK(fabsf(p.z) < 1e-6f && fabsf(p.x) <= 5.0001f && fabsf(p.y) <= 5.0001f);
        CHECK(fabsf(n.z) > 0.9999f);
        front += n.z > 0.0f;
    }
    CHECK(front * 2 == c.count);
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_sees_fronts_of_single_sided_surfaces(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    uint32_t square;
    CHECK(add_square(&t, 3, 0, &square));
    t.scene->materials[0].front_only = true;
    place(&t, STP_PART_MESH, square, scaled_and_moved(5, 5, 1, 0, 0, 0));
    place(&t, STP_PART_MESH, square, scaled_and_moved(-5, 5, 1, 11, 0, 0)); // mirrored
    place(&t, STP_PART_MESH, square, scaled_and_moved(5, 5, -1, 0, 11, 0)); // seen from below
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 10000, 0, &c));
    CHECK(c.count > 3000);
    uint32_t below = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        bool turned = candidate_position(&c, i).y + (float)c.origin.y > 5.5f;
        below += turned ? 1 : 0;
        CHECK(turned ? candidate_normal(&c, i).z < -0.9999f : candidate_normal(&c, i).z > 0.9999f);
    }
    CHECK(below > c.count / 4 && below < c.count / 2);
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

/// A texture whose left half is red and opaque, and whose right half is blue with the given alpha.
static bool add_halves(test_scene* t, uint8_t alpha, uint32_t* index)
{
    enum { SIZE = 16 };
    stp_texture texture = {.width = SIZE, .height = SIZE};
    texture.texels = stp_alloc(t->scene->context, SIZE * SIZE * 4);
    if (texture.texels == NULL) {
        return false;
    }
    texture.wrap_u = texture.wrap_v = STP_WRAP_CLAMP;
    for (size_t i = 0; i < SIZE * SIZE; ++i) {
        bool left = i % SIZE < SIZE / 2;
        memcpy(texture.texels + 4 * i,
               (uint8_t[4]){left ? 255 : 0, 0, left ? 0 : 255, left ? 255 : alpha}, 4);
    }
    return stp_scene_add_texture(t->scene, &texture, index) == STP_OK;
}

static stp_material textured_material(uint32_t texture, stp_alpha_mode mode)
{
    stp_material material = stp_material_default();
    material.base_color_texture = stp_texture_use_none();
    material.base_color_texture.texture = texture;
    material.base_color_texture.transform[0][0] = material.base_color_texture.transform[1][1] =
        1.0f;
    material.alpha_mode = mode;
    material.alpha_cutoff = 0.5f;
    return material;
}

void test_capture_reads_textures_and_masks(test_state* test)
{
    for (int mode = STP_ALPHA_OPAQUE; mode <= STP_ALPHA_BLEND; ++mode) {
        stp_context* context = test_context(NULL, 2, NULL);
        test_scene t = scene_over(context);
        uint32_t texture, index, square;
        CHECK(add_halves(&t, 100, &texture));
        stp_material material = textured_material(texture, (stp_alpha_mode)mode);
        CHECK_EQUAL(STP_OK, stp_scene_add_material(t.scene, &material, &index));
        CHECK(add_square(&t, 2, index, &square));
        place(&t, STP_PART_MESH, square, stp_affine_identity());
        stp_capture_textures* textures;
        CHECK_EQUAL(STP_OK, stp_capture_textures_create(t.scene, false, &textures));
        stp_capture_desc desc = {.resolution = 100, .no_fill = true, .textures = textures};
        stp_candidates c;
        CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &c));
        uint32_t sides[2] = {0, 0};
        for (uint32_t i = 0; i < c.count; ++i) {
            float x = candidate_position(&c, i).x;
            sides[x > 0.0f] += 1;
            if (fabsf(x) > 0.15f) { // away from the seam
                CHECK_EQUAL(x < 0.0f ? 255 : 0, c.colors[4 * i]);
                CHECK_EQUAL(x < 0.0f ? 0 : 255, c.colors[4 * i + 2]);
                bool clear = mode == STP_ALPHA_BLEND && x > 0.0f;
                CHECK_EQUAL(clear ? 100 : 255, c.colors[4 * i + 3]);
            }
        }
        float share = (float)sides[1] / (float)sides[0]; // right half over left half
        CHECK(sides[0] > 5000);
        CHECK(mode != STP_ALPHA_OPAQUE || fabsf(share - 1.0f) < 0.05f);
        CHECK(mode != STP_ALPHA_MASK || share < 0.05f);
        CHECK(mode != STP_ALPHA_BLEND || fabsf(share - 0.5f) < 0.05f);
        stp_candidates_destroy(context, &c);
        stp_capture_textures_destroy(textures);
        stp_scene_destroy(t.scene);
        stp_context_destroy(context);
    }
}

void test_capture_averages_fine_textures(test_state* test)
{
    // a fine black and white checkerboard, many texels per pixel: every candidate is the linear
    // average
    enum { SIZE = 256 };
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    stp_texture texture = {.width = SIZE, .height = SIZE};
    texture.texels = stp_alloc(context, SIZE * SIZE * 4);
    CHECK(texture.texels != NULL);
    for (size_t i = 0; i < SIZE * SIZE; ++i) {
        memset(texture.texels + 4 * i, (i % SIZE + i / SIZE) % 2 ? 255 : 0, 4);
        texture.texels[4 * i + 3] = 255;
    }
    uint32_t index, square, material_index;
    CHECK_EQUAL(STP_OK, stp_scene_add_texture(t.scene, &texture, &index));
    stp_material material = textured_material(index, STP_ALPHA_OPAQUE);
    CHECK_EQUAL(STP_OK, stp_scene_add_material(t.scene, &material, &material_index));
    CHECK(add_square(&t, 1, material_index, &square));
    place(&t, STP_PART_MESH, square, stp_affine_identity());
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 0, 30, &c));
    CHECK(c.count > 200);
    for (uint32_t i = 0; i < c.count; ++i) {
        CHECK(abs((int)c.colors[4 * i] - 188) <= 1);
    }
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_mirrored_and_stretched_normals(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    uint32_t sphere;
    CHECK(add_sphere(&t, 24, true, 0, &sphere));
    place(&t, STP_PART_MESH, sphere,
          scaled_and_moved(-4, 2, 1, 0, 0, 0)); // an ellipsoid, inside out
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 10000, 0, &c));
    CHECK(c.count > 7000);
    for (uint32_t i = 0; i < c.count; ++i) {
        stp_vec3 p = candidate_position(&c, i);
        stp_vec3 gradient = stp_normalize((stp_vec3){p.x / 16.0f, p.y / 4.0f, p.z});
        CHECK(stp_dot(candidate_normal(&c, i), gradient) > 0.99f);
        float on = p.x * p.x / 16.0f + p.y * p.y / 4.0f + p.z * p.z;
        CHECK(on > 0.98f && on < 1.0001f);
    }
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

/// A site 500 km from the origin, placed in doubles: candidates are accurate to a hundredth of a
/// millimetre.
void test_capture_far_from_the_origin(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    stp_material other = stp_material_default();
    uint32_t sphere, square, material;
    CHECK_EQUAL(STP_OK, stp_scene_add_material(t.scene, &other, &material));
    CHECK(add_sphere(&t, 16, true, 0, &sphere) && add_square(&t, 1, material, &square));
    const stp_vec3d at = {500000.125, 100.0, -400000.25};
    place(&t, STP_PART_MESH, sphere, scaled_and_moved(2, 2, 2, at.x, at.y, at.z));
    place(&t, STP_PART_MESH, square, scaled_and_moved(3, 3, 1, at.x + 6, at.y, at.z + 0.0625));
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 5000, 0, &c));
    CHECK(c.count > 3000);
    uint32_t of_square = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        stp_vec3d p = stp_addd(stp_to_double(candidate_position(&c, i)), stp_subd(c.origin, at));
        if (c.materials[i] == material) {
            of_square += 1;
            CHECK(fabs(p.z - 0.0625) < 1e-5 && p.x > 3.0 - 1e-5 && p.x < 9.0 + 1e-5);
        } else {
            double r = sqrt(stp_dotd(p, p));
            CHECK(r < 2.0 + 1e-5 && r > 1.96);
        }
    }
    CHECK(of_square > 500);
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

/// Spheres, a masked square and points: everything a scene can contain.
static bool add_everything(test_scene* t)
{
    uint32_t sphere, square, texture, material_index, points_index;
    if (!add_halves(t, 30, &texture)) {
        return false;
    }
    stp_material material = textured_material(texture, STP_ALPHA_MASK);
    if (stp_scene_add_material(t->scene, &material, &material_index) != STP_OK ||
        !add_sphere(t, 6, true, 0, &sphere) || !add_square(t, 2, material_index, &square)) {
        return false;
    }
    enum { POINTS = 500 };
    stp_point_set points = {.point_count = POINTS, .bounds = stp_box_empty()};
    points.positions = STP_NEW_ARRAY(t->scene->context, float, 3 * POINTS);
    if (points.positions == NULL) {
        return false;
    }
    for (uint64_t i = 0; i < POINTS; ++i) {
        float* p = points.positions + 3 * i;
        for (uint64_t k = 0; k < 3; ++k) {
            p[k] = (float)(stp_rng_hash(1, 3 * i + k) % 1000) / 1000.0f;
        }
        stp_box_add(&points.bounds, (stp_vec3){p[0], p[1], p[2]});
    }
    if (stp_scene_add_point_set(t->scene, &points, &points_index) != STP_OK) {
        return false;
    }
    place(t, STP_PART_MESH, sphere, stp_affine_identity());
    place(t, STP_PART_MESH, square, scaled_and_moved(2, 2, 1, 0, 0, 1.5));
    place(t, STP_PART_MESH, sphere, scaled_and_moved(0.5, 0.7, -0.5, 2, 0, 0));
    place(t, STP_PART_POINTS, points_index, scaled_and_moved(1, 1, 1, 0, 1.5, 0));
    return true;
}

static bool same_candidates(const stp_candidates* a, const stp_candidates* b)
{
    size_t n = a->count;
    return a->count == b->count && memcmp(a->positions, b->positions, n * 12) == 0 &&
           memcmp(a->normals, b->normals, n * 12) == 0 &&
           memcmp(a->colors, b->colors, n * 4) == 0 &&
           memcmp(a->materials, b->materials, n * 4) == 0;
}

static uint64_t hash_candidates(const stp_candidates* c)
{
    size_t n = c->count;
    stp_hash hash = stp_hash_bytes((stp_hash){0}, c->positions, n * 12);
    hash = stp_hash_bytes(hash, c->normals, n * 12);
    hash = stp_hash_bytes(hash, c->colors, n * 4);
    return stp_hash_bytes(hash, c->materials, n * 4).low;
}

void test_capture_costs_what_is_there(test_state* test)
{
    // two spheres a million apart: at any resolution, nearly all pixels are empty
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    uint32_t sphere;
    CHECK(add_sphere(&t, 8, true, 0, &sphere));
    place(&t, STP_PART_MESH, sphere, scaled_and_moved(1, 1, 1, 0, 0, 0));
    place(&t, STP_PART_MESH, sphere, scaled_and_moved(1, 1, 1, 1e6, 1e6, 3e5));
    for (uint64_t wanted = 1500; wanted <= 6000; wanted *= 4) {
        stp_candidates c;
        CHECK_EQUAL(STP_OK, capture(&t, wanted, 0, &c));
        double pixels = (double)c.resolution * (double)c.resolution * c.direction_count;
        CHECK(pixels < 8.0 * STP_CAPTURE_MAX_PIXELS_EACH * (double)wanted);
        stp_candidates_destroy(context, &c);
    }
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_from_one_direction(test_state* test)
{
    stp_context* context = test_context(NULL, 4, NULL);
    test_scene t = scene_over(context);
    uint32_t square;
    CHECK(t.scene != NULL && add_square(&t, 1, 0, &square));
    place(&t, STP_PART_MESH, square, scaled_and_moved(1, 1, 1, -1, -1, 0));
    place(&t, STP_PART_MESH, square, scaled_and_moved(1, 1, 1, 1, 1, 0)); // half of the outline
    stp_vec3d toward = {0, 0, 1};
    stp_capture_desc desc = {
        .direction_count = 1, .directions = &toward, .wanted_candidates = 20000};
    stp_candidates c;
    CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &c));
    CHECK(c.count > 18000 && c.count < 22000); // the probe's pixels
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_is_the_same_for_any_thread_count(test_state* test)
{
    stp_candidates first = {0};
    stp_context* contexts[3] = {NULL};
    static const uint32_t threads[] = {1, 2, 9};
    for (int i = 0; i < 3; ++i) {
        contexts[i] = test_context(NULL, threads[i], NULL);
        test_scene t = scene_over(contexts[i]);
        CHECK(add_everything(&t));
        stp_candidates c;
        CHECK_EQUAL(STP_OK, capture(&t, 4000, 0, &c));
        CHECK(c.count > 2000);
        if (i == 0) {
            first = c;
            // for any compiler and optimisation level; changes only with intended changes of the
            // capture
            CHECK_EQUAL(0x511465aaf24ffde7, hash_candidates(&c));
        } else {
            CHECK(same_candidates(&first, &c));
            stp_candidates_destroy(contexts[i], &c);
        }
        // few ids per pass: several buffers are merged
        stp_capture_desc desc = {.wanted_candidates = 4000};
        CHECK_EQUAL(STP_OK,
                    stp_capture_parts_in_passes(t.scene, t.parts, t.part_count, &desc, 450, &c));
        CHECK(same_candidates(&first, &c));
        stp_candidates_destroy(contexts[i], &c);
        stp_scene_destroy(t.scene);
    }
    stp_candidates_destroy(contexts[0], &first);
    for (int i = 0; i < 3; ++i) {
        stp_context_destroy(contexts[i]);
    }
}

/// Hidden parts are skipped: the result is the same as with a separate buffer for each part.
void test_capture_hidden_parts_change_nothing(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    uint32_t ball, coarse;
    CHECK(add_sphere(&t, 8, false, 0, &ball) && add_sphere(&t, 2, true, 0, &coarse));
    for (uint64_t i = 0; i < 60; ++i) {
        double at[3], size = 0.1 + (double)(stp_rng_hash(5, i) % 100) / 100.0;
        for (uint64_t k = 0; k < 3; ++k) {
            at[k] = (double)(stp_rng_hash(6, 3 * i + k) % 400) / 100.0;
        }
        place(&t, STP_PART_MESH, i % 3 == 0 ? coarse : ball,
              scaled_and_moved(size, size, size, at[0], at[1], at[2]));
    }
    stp_capture_desc desc = {.resolution = 90};
    stp_candidates together, apart;
    CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &together));
    CHECK_EQUAL(STP_OK,
                stp_capture_parts_in_passes(t.scene, t.parts, t.part_count, &desc, 1, &apart));
    CHECK(together.count > 10000);
    CHECK(same_candidates(&together, &apart));
    stp_candidates_destroy(context, &together);
    stp_candidates_destroy(context, &apart);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

// A user-defined view: captures nothing of the far side, not even by the fill.
void test_capture_uses_the_given_directions(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    uint32_t ball;
    CHECK(add_sphere(&t, 16, false, 0, &ball));
    place(&t, STP_PART_MESH, ball, scaled_and_moved(1.0, 1.0, 1.0, 3.0, 0.0, 0.0));
    const stp_vec3d toward = stp_normalized((stp_vec3d){1.0, 0.8, 1.2});
    stp_capture_desc desc = {.directions = &toward, .direction_count = 1, .pixel_size = 0.02};
    stp_candidates seen;
    CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &seen));
    CHECK_EQUAL(1, seen.direction_count);
    CHECK_EQUAL(0, seen.filled);
    CHECK(seen.count > 7500 && seen.count < 8000); // a disk of radius 50 pixels
    for (uint32_t i = 0; i < seen.count; ++i) {
        CHECK(stp_dotd(stp_to_double(candidate_position(&seen, i)), toward) > -0.1);
        CHECK(stp_dotd(stp_to_double(candidate_normal(&seen, i)), toward) > -0.1);
    }
    stp_candidates_destroy(context, &seen);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

static int stop(const stp_progress_report* report, void* user)
{
    return report->fraction >= *(const double*)user;
}

void test_capture_can_be_stopped(test_state* test)
{
    double limits[] = {0.0, 0.5};
    for (int i = 0; i < 2; ++i) {
        test_heap heap = TEST_HEAP(-1);
        stp_context_desc context_desc = {
            .allocator = {.alloc = test_heap_alloc, .free = test_heap_free, .user = &heap},
            .thread_count = 2,
            .progress = stop,
            .progress_user = &limits[i],
        };
        stp_context* context = NULL;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &context_desc));
        test_scene t = scene_over(context);
        CHECK(add_everything(&t));
        stp_candidates c;
        CHECK_EQUAL(STP_ERROR_CANCELLED, capture(&t, 1000, 0, &c));
        CHECK(c.positions == NULL);
        stp_scene_destroy(t.scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}

void test_capture_points_are_candidates(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    test_scene t = scene_over(context);
    stp_point_set points = {.point_count = 2, .bounds = {{0, 0, 0}, {4, 0, 0}}};
    points.positions = STP_NEW_ZEROED(context, float, 6);
    points.colors = STP_NEW_ZEROED(context, uint8_t, 8);
    points.normals = STP_NEW_ZEROED(context, float, 6);
    CHECK(points.positions != NULL && points.colors != NULL && points.normals != NULL);
    points.positions[3] = 4.0f;
    memcpy(points.colors, (uint8_t[8]){10, 20, 30, 255, 200, 100, 50, 255}, 8);
    points.normals[1] = 1.0f; // the second has none
    uint32_t index;
    CHECK_EQUAL(STP_OK, stp_scene_add_point_set(t.scene, &points, &index));
    place(&t, STP_PART_POINTS, index, scaled_and_moved(1, 1, 1, 7, 0, 0));
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 0, 64, &c));
    CHECK_EQUAL(16, c.count); // both from eight sides
    for (uint32_t i = 0; i < c.count; ++i) {
        bool second = c.positions[3 * i] > 0.0f;
        CHECK(fabsf(fabsf(c.positions[3 * i]) - 2.0f) < 1e-5f);
        CHECK_EQUAL(second ? 200 : 10, c.colors[4 * i]);
        CHECK(fabsf(stp_length(candidate_normal(&c, i)) - 1.0f) < 1e-5f);
        CHECK(second || fabsf(c.normals[3 * i + 1]) > 0.999f);
    }
    stp_candidates_destroy(context, &c);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_odd_scenes(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    stp_candidates c;
    CHECK_EQUAL(STP_OK, capture(&t, 100, 0, &c)); // nothing
    CHECK_EQUAL(0, c.count);
    uint32_t square, sphere;
    CHECK(add_square(&t, 1, 0, &square) && add_sphere(&t, 2, false, 0, &sphere));
    // all in one point, all on one line, NaN, and a speck beside a giant
    stp_affine cases[] = {scaled_and_moved(0, 0, 0, 1, 2, 3), scaled_and_moved(1, 0, 0, 0, 0, 0),
                          scaled_and_moved(1, (double)NAN, 1, 0, 0, 0),
                          scaled_and_moved(1e-9, 1e-9, 1, 0, 0, 0),
                          scaled_and_moved(1e200, 1, 1, 0, 0, 0)};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        t.part_count = 0;
        place(&t, STP_PART_MESH, square, cases[i]);
        CHECK_EQUAL(STP_OK, capture(&t, 100, 0, &c));
        stp_candidates_destroy(context, &c);
        place(&t, STP_PART_MESH, sphere, stp_affine_identity());
        CHECK_EQUAL(STP_OK, capture(&t, 400, 0, &c));
        CHECK(c.count > 100);
        stp_candidates_destroy(context, &c);
    }
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}

void test_capture_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context == NULL) {
            CHECK_EQUAL(0, heap.live_bytes);
            continue;
        }
        test_scene t = scene_over(context);
        stp_result result = STP_ERROR_OUT_OF_MEMORY;
        stp_candidates c = {0};
        if (t.scene != NULL && add_everything(&t)) {
            stp_capture_desc desc = {.wanted_candidates = 200};
            result = stp_capture_parts_in_passes(t.scene, t.parts, t.part_count, &desc, 450, &c);
            CHECK(result == STP_OK || (c.count == 0 && c.positions == NULL));
        }
        stp_candidates_destroy(context, &c);
        if (t.scene != NULL) {
            stp_scene_destroy(t.scene);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            CHECK(n > 10);
            return;
        }
    }
}

// A steep, long V: the corners of the cube see only its upper part, the face above it sees all.
void test_capture_fills_what_the_corners_miss(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    test_scene t = scene_over(context);
    uint32_t square;
    CHECK(add_square(&t, 2, 0, &square));
    // x of the square runs up the wall from (0, 0) to (+-0.2, 1), y along z
    stp_affine right = {{{0.1, 0, 0.5, 0.1}, {0.5, 0, -0.1, 0.5}, {0, 3, 0, 0}}};
    stp_affine left = {{{-0.1, 0, 0.5, -0.1}, {0.5, 0, 0.1, 0.5}, {0, 3, 0, 0}}};
    place(&t, STP_PART_MESH, square, right);
    place(&t, STP_PART_MESH, square, left);
    stp_capture_desc desc = {.resolution = 200, .no_fill = true};
    stp_candidates corners, all;
    CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &corners));
    desc.no_fill = false;
    CHECK_EQUAL(STP_OK, stp_capture_parts(t.scene, t.parts, t.part_count, &desc, &all));
    CHECK_EQUAL(0, corners.filled);
    CHECK_EQUAL(corners.count, all.count - all.filled);
    CHECK(memcmp(corners.positions, all.positions, corners.count * 3 * sizeof(float)) == 0);
    uint32_t deep[2] = {0, 0};
    for (uint32_t i = 0; i < all.count; ++i) {
        bool inside = candidate_normal(&all, i).y > 0.0f; // the walls' upper sides
        double height = (double)candidate_position(&all, i).y + all.origin.y;
        bool clear = fabsf(candidate_position(&all, i).z) < 2.0f; // of the open ends
        deep[i >= corners.count] += inside && clear && height < 0.4 && height > 0.05;
    }
    CHECK_EQUAL(0, deep[0]);
    // both walls, 4 long and 0.35 high, seen from above at a slope of 5: about a row of pixels in
    // five
    double pixels = 2.0 * 4.0 * 0.35 / (all.pixel_size * all.pixel_size);
    CHECK((double)deep[1] > 0.15 * pixels && (double)deep[1] < 1.5 * pixels);
    stp_candidates_destroy(context, &corners);
    stp_candidates_destroy(context, &all);
    stp_scene_destroy(t.scene);
    stp_context_destroy(context);
}
