// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/io/hash.h"
#include "lab/scenes/paper.h"
#include "lab/scenes/parts.h"

#include <string.h>

#define SMALL (1.0 / 64.0)

typedef stp_result (*part_adder)(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                 const scene_options* options, uint32_t* object);

typedef struct industry_part {
    void (*plan)(assembly_plan* plan);
    const plan_counts* counts;
    part_adder add;
    double width, depth, height; ///< size of the space available to it
    uint64_t hash;               ///< total of its meshes at the small scale
} industry_part;

static const industry_part power_plants = {
    plan_power_plants,          &power_plants_counts, scene_add_power_plants, 900, 900, 160,
    UINT64_C(0x6cbc8b3550bc680)};

static const industry_part bakery = {
    plan_bakery, &bakery_counts, scene_add_bakery, 122, 62, 14, UINT64_C(0x36ecbfe152853746)};

static const industry_part car_factory = {plan_car_factory,
                                          &car_factory_counts,
                                          scene_add_car_factory,
                                          300,
                                          202,
                                          20,
                                          UINT64_C(0x9a330054f90550b2)};

static bool within(uint64_t got, double wanted, double tolerance)
{
    double off = (double)got / wanted - 1.0;
    return off < tolerance && off > -tolerance;
}

static void check_full_counts(test_state* test, const industry_part* part)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    assembly_plan plan;
    plan_begin(&plan, context, 0);
    part->plan(&plan);
    plan_fit(&plan, part->counts, 1.0);
    plan_counts got = plan_count(&plan);
    CHECK_EQUAL(part->counts->objects, got.objects);
    CHECK_EQUAL(part->counts->unique_objects, got.unique_objects);
    CHECK_EQUAL(part->counts->unique_objects, plan.mesh_count);
    CHECK(within(got.triangles, (double)part->counts->triangles, 1e-3));
    CHECK(within(got.unique_triangles, (double)part->counts->unique_triangles, 1e-3));
    plan_end(&plan);
    stp_context_destroy(context);
}

static void check_mesh(test_state* test, const stp_mesh* mesh)
{
    uint64_t flat = 0;
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i += 3) {
        const float* n = mesh->normals + i;
        double x = (double)n[0], y = (double)n[1], z = (double)n[2];
        double square = x * x + y * y + z * z;
        CHECK(square > 0.998 && square < 1.002);
    }
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t* c = mesh->indices + 3 * t;
        CHECK(c[0] < mesh->vertex_count && c[1] < mesh->vertex_count && c[2] < mesh->vertex_count);
        const float *p = mesh->positions + 3 * (size_t)c[0],
                    *q = mesh->positions + 3 * (size_t)c[1],
                    *r = mesh->positions + 3 * (size_t)c[2];
        flat += memcmp(p, q, 12) == 0 || memcmp(q, r, 12) == 0 || memcmp(p, r, 12) == 0;
    }
    CHECK(50 * flat <= mesh->triangle_count);
}

// Lengths of all edges, in whole micrometres.
static uint64_t edge_length(const stp_mesh* mesh, size_t edge)
{
    const uint32_t* c = mesh->indices + edge / 3 * 3;
    const float* p = mesh->positions + 3 * (size_t)mesh->indices[edge];
    const float* q = mesh->positions + 3 * (size_t)c[(edge + 1) % 3];
    stp_vec3 way = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    return (uint64_t)((double)stp_length(way) * 1e6);
}

// Lower bound on the ratio of the 95th to the 5th percentile of all edges, by powers of two.
static double edge_ratio(const stp_scene* scene)
{
    uint64_t counts[64] = {0}, total = 0, below = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        size_t edges = 3 * (size_t)scene->meshes[i].triangle_count;
        for (size_t e = 0; e < edges; ++e) {
            int bits = 0;
            for (uint64_t length = edge_length(&scene->meshes[i], e); length > 0; length /= 2) {
                ++bits;
            }
            counts[bits] += 1;
        }
        total += edges;
    }
    double low = 0.0, size = 1.0; // both are upper ends of buckets
    for (int bits = 0; bits < 64; ++bits, size *= 2.0) {
        below += counts[bits];
        if (low == 0.0 && 20 * below >= total) {
            low = size;
        }
        if (20 * below >= 19 * total) {
            return 0.5 * size / low;
        }
    }
    return 0.0;
}

static stp_hash hash_meshes(const stp_scene* scene)
{
    stp_hash hash = {0, 0};
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const stp_mesh* mesh = &scene->meshes[i];
        hash = stp_hash_bytes(hash, mesh->positions, 12 * (size_t)mesh->vertex_count);
        hash = stp_hash_bytes(hash, mesh->normals, 12 * (size_t)mesh->vertex_count);
        hash = stp_hash_bytes(hash, mesh->indices, 12 * (size_t)mesh->triangle_count);
    }
    return hash;
}

static void check_small(test_state* test, const industry_part* part)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    assembly_plan plan;
    plan_begin(&plan, context, 0);
    part->plan(&plan);
    plan_fit(&plan, part->counts, SMALL);
    uint32_t object = STP_NONE;
    stp_affine still = stp_affine_identity();
    CHECK_EQUAL(STP_OK, plan_build(&plan, scene, STP_NONE, "part", &still, &object));
    CHECK_EQUAL(0, object);
    CHECK_EQUAL(plan.mesh_count, scene->mesh_count);
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        CHECK_EQUAL(plan.meshes[i].triangles, scene->meshes[i].triangle_count);
        CHECK_EQUAL(plan.meshes[i].vertices, scene->meshes[i].vertex_count);
        check_mesh(test, &scene->meshes[i]);
    }
    CHECK(edge_ratio(scene) >= 100.0);
    CHECK_EQUAL(part->hash, hash_meshes(scene).low);
    plan_counts got = plan_count(&plan);
    CHECK(within(got.triangles, (double)part->counts->triangles * SMALL, 0.02));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(part->counts->unique_objects, scene->mesh_count); // all are different
    const stp_node* root = &scene->nodes[scene->root];
    CHECK_EQUAL(got.triangles, root->triangle_count);
    CHECK(root->bounds.min.x >= -0.5 * part->width && root->bounds.max.x <= 0.5 * part->width);
    CHECK(root->bounds.min.z >= -0.5 * part->depth && root->bounds.max.z <= 0.5 * part->depth);
    CHECK(root->bounds.min.y >= -8.0 && root->bounds.max.y <= part->height);
    plan_end(&plan);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_industry_power_plants_counts(test_state* test)
{
    check_full_counts(test, &power_plants);
}

// The counts must fit without instancing, too.
void test_industry_twenty_million_counts(test_state* test)
{
    static const plan_counts counts = {566, 566, 20000000, 20000000};
    static const industry_part part = {.plan = plan_twenty_million, .counts = &counts};
    check_full_counts(test, &part);
}

void test_industry_power_plants_small(test_state* test)
{
    check_small(test, &power_plants);
}

void test_industry_bakery_counts(test_state* test)
{
    check_full_counts(test, &bakery);
}

void test_industry_bakery_small(test_state* test)
{
    check_small(test, &bakery);
}

void test_industry_car_factory_counts(test_state* test)
{
    check_full_counts(test, &car_factory);
}

void test_industry_car_factory_small(test_state* test)
{
    check_small(test, &car_factory);
}

// Every shape is closed, and its faces and normals point outwards: its faces enclose the volume
// of the shape.
static double volume(const mesh_builder* b, bool* agree)
{
    double sum = 0.0;
    *agree = true;
    for (size_t t = 0; t < b->index_count; t += 3) {
        const float *p = b->positions + 3 * (size_t)b->indices[t],
                    *q = b->positions + 3 * (size_t)b->indices[t + 1],
                    *r = b->positions + 3 * (size_t)b->indices[t + 2];
        const float* n = b->normals + 3 * (size_t)b->indices[t];
        stp_vec3d o = {(double)p[0], (double)p[1], (double)p[2]};
        stp_vec3d u = {(double)q[0] - o.x, (double)q[1] - o.y, (double)q[2] - o.z};
        stp_vec3d v = {(double)r[0] - o.x, (double)r[1] - o.y, (double)r[2] - o.z};
        stp_vec3d cross = stp_crossd(u, v);
        sum += stp_dotd(o, cross) / 6.0;
        double along = stp_dotd(cross, vec3d((double)n[0], (double)n[1], (double)n[2]));
        *agree = *agree && along >= -1e-9;
    }
    return sum;
}

static void make_shape(shaper* s, int kind)
{
    static const double cone[4][2] = {{0, 0}, {2, 0}, {1, 3}, {0, 3}};
    static const double star[5][2] = {{2, 0}, {1, 1}, {-1, 2}, {-2, -1}, {0, -2}};
    stp_vec3d bent[4] = {{0, 0, 0}, {4, 0, 0}, {4, 5, 0}, {4, 5, 6}}, path[64];
    switch (kind) {
    case 0:
        shape_box(s, 1, 2, 3, 1, 2, 3);
        break;
    case 1:
        shape_lathe(s, cone, 4, 32);
        break;
    case 2:
        shape_ring_solid(s, 1, 2, 1, 24);
        break;
    case 3:
        shape_torus(s, 3, 1, 24, 12);
        break;
    case 4:
        shape_ball(s, 2, 4, 24);
        break;
    case 5:
        shape_tube(s, path, shape_round_path(bent, 4, 1.0, 6, path, 64), 0.3, 12, SHAPE_CAPPED);
        break;
    case 6:
        shape_prism(s, star, 5, 0, 2);
        break;
    case 7:
        shape_prism(s, star, 5, 0.5, 2);
        break;
    case 8:
        shape_beam(s, PROFILE_I, vec3d(0, 0, 0), vec3d(3, 4, 5), 0.5, 0.3, 0.05);
        break;
    case 9:
        shape_beam(s, PROFILE_U, vec3d(0, 0, 0), vec3d(0, 4, 0), 0.5, 0.3, 0.05);
        break;
    case 10:
        shape_beam(s, PROFILE_L, vec3d(0, 0, 0), vec3d(0, -4, 0), 0.5, 0.3, 0.05);
        break;
    case 11:
        shape_beam(s, PROFILE_T, vec3d(0, 0, 0), vec3d(1, 0, 0), 0.5, 0.3, 0.05);
        break;
    default:
        shape_beam(s, PROFILE_TUBE, vec3d(0, 0, 0), vec3d(0, 0, -2), 0.5, 0.3, 0.05);
        break;
    }
}

void test_industry_shapes_are_closed_and_look_outwards(test_state* test)
{
    static const double volumes[13] = {6.0,  21.7,  9.3, 55.8, 32.6,   3.8, 18.0,
                                       16.9, 0.355, 0.2, 0.15, 0.0375, 0.3};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static shape_ring rings[SHAPE_RINGS];
    for (int kind = 0; kind < 13; ++kind) {
        mesh_builder builder;
        mesh_builder_init(&builder, context);
        shaper s = {.tessellation = 1, .amount = 1, .keep = 1, .rings = rings};
        s.place = place_by_turn(5, 6, 7, 0.1);
        make_shape(&s, kind);
        uint64_t triangles = s.triangles, vertices = s.vertices;
        s.builder = &builder;
        make_shape(&s, kind);
        CHECK_EQUAL(3 * triangles, builder.index_count);
        CHECK_EQUAL(vertices, builder.vertex_count);
        bool agree;
        double got = volume(&builder, &agree);
        CHECK(agree);
        CHECK(got > 0.95 * volumes[kind] && got < 1.05 * volumes[kind]);
        mesh_builder_destroy(&builder);
    }
    stp_context_destroy(context);
}

void test_industry_out_of_memory(test_state* test)
{
    for (int fail = 0, done = 0; !done; fail += 1 + fail / 3) {
        test_heap heap = TEST_HEAP(fail);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_scene* scene = NULL;
        if (context != NULL && stp_scene_create(context, &scene) == STP_OK) {
            stp_affine still = stp_affine_identity();
            assembly_plan plan;
            plan_begin(&plan, context, 0);
            uint32_t group = plan_group(&plan, STP_NONE, plan_text(&plan, "group %d", 1), still);
            plan_part(&plan, group, "gears", FINISH_STEEL, part_gearbox, PARAMETERS(1, 1, 1),
                      still);
            plan_fit(&plan, &(plan_counts){1, 1, 4000, 4000}, 1.0);
            stp_result result = plan_build(&plan, scene, STP_NONE, "top", &still, NULL);
            plan_end(&plan);
            done = result == STP_OK;
            CHECK(done || result == STP_ERROR_OUT_OF_MEMORY);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
