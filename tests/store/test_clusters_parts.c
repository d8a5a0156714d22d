// SPDX-License-Identifier: MIT
// Meshes of leaves and twigs as clusters: small, and every part in its place.
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "store/clusters/clusters.h"

#include <math.h>

enum {
    LEAVES = 700,
    TWIGS = 150,
    TWIG_TRIANGLES = 6,
    VERTICES = 4 * LEAVES + 6 * TWIGS,
    TRIANGLES = 2 * LEAVES + TWIG_TRIANGLES * TWIGS,
};

/// Each corner has unique texture coordinates, which identify it.
typedef struct plant {
    float positions[3 * VERTICES], texcoords[2 * VERTICES];
    int16_t normals[2 * VERTICES];
    uint16_t colors[4 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    uint32_t vertex_count, triangle_count;
} plant;

static float between(uint64_t* random, float low, float high)
{
    return low + (high - low) * (float)(stp_rng_hash(5, (*random)++) & 0xffff) / 65536.0f;
}

static stp_vec3 anywhere(uint64_t* random, float size)
{
    float x = between(random, -size, size), y = between(random, -size, size);
    return (stp_vec3){x, y, between(random, -size, size)};
}

static void put_vertex(plant* p, stp_vec3 position, stp_vec3 normal, const uint16_t color[4])
{
    uint32_t v = p->vertex_count++;
    memcpy(p->positions + 3 * (size_t)v, &position, sizeof(position));
    stp_octahedral_encode16(normal, p->normals + 2 * (size_t)v);
    memcpy(p->colors + 4 * (size_t)v, color, 4 * sizeof(color[0]));
    p->texcoords[2 * (size_t)v] = (float)(v % 64) / 64.0f;
    p->texcoords[2 * (size_t)v + 1] = (float)(v / 64) / 256.0f;
}

static void put_triangle(plant* p, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t* index = p->indices + 3 * (size_t)p->triangle_count++;
    index[0] = a;
    index[1] = b;
    index[2] = c;
}

static void put_leaf(plant* p, uint64_t* random, stp_vec3 at)
{
    stp_vec3 along = stp_scale(stp_normalize(anywhere(random, 1.0f)), 0.3f);
    stp_vec3 side = stp_scale(stp_normalize(stp_cross(along, anywhere(random, 1.0f))), 0.1f);
    stp_vec3 normal = stp_normalize(anywhere(random, 1.0f));
    uint16_t shade = (uint16_t)between(random, 20000.0f, 60000.0f);
    const uint16_t color[4] = {shade / 2, shade, shade / 4, 65535};
    stp_vec3 middle = stp_add(at, stp_scale(along, 0.5f));
    uint32_t first = p->vertex_count;
    put_vertex(p, at, normal, color);
    put_vertex(p, stp_add(middle, side), normal, color);
    put_vertex(p, stp_add(at, along), normal, color);
    put_vertex(p, stp_sub(middle, side), normal, color);
    put_triangle(p, first, first + 1, first + 2);
    put_triangle(p, first, first + 2, first + 3);
}

static void put_twig(plant* p, uint64_t* random, stp_vec3 at)
{
    static const uint16_t color[4] = {9000, 7000, 5000, 65535};
    stp_vec3 along = stp_scale(stp_normalize(anywhere(random, 1.0f)), 0.4f);
    uint32_t first = p->vertex_count;
    for (int i = 0; i < 6; ++i) {
        stp_vec3 out = stp_normalize(stp_cross(along, anywhere(random, 1.0f)));
        stp_vec3 ring = stp_add(at, stp_scale(out, 0.01f));
        put_vertex(p, i < 3 ? ring : stp_add(ring, along), out, color);
    }
    for (uint32_t i = 0; i < 3; ++i) {
        uint32_t next = (i + 1) % 3;
        put_triangle(p, first + i, first + next, first + 3 + next);
        put_triangle(p, first + i, first + 3 + next, first + 3 + i);
    }
}

static plant* make_plant(void)
{
    plant* p = calloc(1, sizeof(*p));
    uint64_t random = 0;
    for (uint32_t i = 0; p != NULL && i < LEAVES; ++i) {
        put_leaf(p, &random, anywhere(&random, 3.0f));
        if (i < TWIGS) {
            put_twig(p, &random, anywhere(&random, 3.0f));
        }
    }
    return p;
}

static stp_store_mesh view_plant(const plant* p)
{
    return (stp_store_mesh){.vertex_count = p->vertex_count,
                            .triangle_count = p->triangle_count,
                            .positions = p->positions,
                            .normals = p->normals,
                            .texcoords = {p->texcoords, NULL},
                            .colors = p->colors,
                            .indices = p->indices};
}

/// Every corner of every cluster is a vertex of the plant, in a triangle of the plant, with that
/// vertex's attributes, and lies within half a step of its cluster on each axis.
static const char* find_fault(const plant* p, const stp_clusters* clusters, uint32_t* coarse)
{
    uint32_t seen[VERTICES] = {0};
    *coarse = 0;
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster c;
        stp_clusters_get(clusters, i, &c);
        float step = clusters->step * (float)(1u << c.runs[0].shift);
        *coarse += c.runs[0].shift > 0 ? c.triangle_count : 0;
        for (uint32_t t = 0; t < c.triangle_count; ++t) {
            stp_vec3 normals[3];
            uint32_t corners[3];
            stp_cluster_corners(&c, t, corners);
            bool lit = stp_cluster_normals(&c, t, normals);
            for (uint32_t k = 0; k < 3; ++k) {
                stp_vec2 uv = stp_cluster_texcoord(clusters, &c, 0, corners[k]);
                uint32_t v = (uint32_t)(uv.x * 64.0f) + 64 * (uint32_t)(uv.y * 256.0f);
                stp_vec3 at = stp_cluster_position(clusters, &c, corners[k]);
                const float* from = p->positions + 3 * (size_t)v;
                if (v >= p->vertex_count || fabsf(at.x - from[0]) > 0.51f * step ||
                    fabsf(at.y - from[1]) > 0.51f * step || fabsf(at.z - from[2]) > 0.51f * step) {
                    return "a position";
                }
                stp_vec3 n = stp_octahedral_decode16(p->normals[2 * (size_t)v],
                                                     p->normals[2 * (size_t)v + 1]);
                if (lit && stp_dot(n, stp_normalize(normals[k])) < 0.99996f) {
                    return "a normal";
                }
                float color[4];
                stp_cluster_color(&c, corners[k], color);
                float green = sqrtf((float)p->colors[4 * (size_t)v + 1] / 65535.0f);
                if (fabsf(sqrtf(color[1]) - green) > 0.51f / 255.0f) {
                    return "a colour";
                }
                seen[v] += 1;
            }
        }
    }
    for (size_t i = 0; i < 3 * (size_t)p->triangle_count; ++i) {
        seen[p->indices[i]] -= 1;
    }
    bool all = true;
    for (uint32_t v = 0; v < p->vertex_count; ++v) {
        all = all && seen[v] == 0;
    }
    return all ? NULL : "a triangle is missing";
}

void test_clusters_keep_leaves_and_twigs(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    plant* p = make_plant();
    CHECK(context != NULL && p != NULL);
    for (int cut = 0; cut < 2; ++cut) {
        double step = stp_choose_grid_step(p->positions, p->indices, p->triangle_count);
        stp_store_mesh view = view_plant(p);
        view.is_piece = cut == 1;
        stp_coded_mesh coded;
        stp_clusters clusters;
        CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
        CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
        uint32_t coarse;
        const char* fault = find_fault(p, &clusters, &coarse);
        if (fault != NULL) {
            fprintf(stderr, "cut %d: %s\n", cut, fault);
        }
        CHECK(fault == NULL);
        CHECK(cut == 1 ? coarse == 0
                       : coarse >= LEAVES); // steps for twigs are too small for leaves
        stp_coded_mesh_destroy(context, &coded);
    }
    free(p);
    stp_context_destroy(context);
}

void test_clusters_of_leaves_take_12_bytes_a_triangle_at_most(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    plant* p = make_plant();
    CHECK(context != NULL && p != NULL);
    double step = stp_choose_grid_step(p->positions, p->indices, p->triangle_count);
    stp_store_mesh view = view_plant(p);
    view.texcoords[0] = NULL;
    stp_coded_mesh coded;
    CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
    CHECK(coded.size <= 12 * (size_t)p->triangle_count);
    stp_coded_mesh_destroy(context, &coded);
    free(p);
    stp_context_destroy(context);
}

void test_clusters_move_no_leaf_that_another_meets(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    plant* p = make_plant();
    CHECK(context != NULL && p != NULL);
    // half of the leaves' tips coincide with the next one's stalk, as separate vertices
    uint32_t leaf[LEAVES], count = 0;
    for (uint32_t t = 0; t < p->triangle_count; t += 2) {
        const uint32_t* index = p->indices + 3 * (size_t)t;
        if (index[5] == index[0] + 3 && index[2] == index[0] + 2) {
            leaf[count++] = index[0];
        }
    }
    CHECK_EQUAL(LEAVES, count);
    for (uint32_t i = 0; i + 1 < count; i += 4) {
        memcpy(p->positions + 3 * (size_t)leaf[i + 1], p->positions + 3 * (size_t)(leaf[i] + 2),
               3 * sizeof(float));
    }
    double step = stp_choose_grid_step(p->positions, p->indices, p->triangle_count);
    stp_store_mesh view = view_plant(p);
    stp_coded_mesh coded;
    stp_clusters clusters;
    CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
    CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
    uint32_t coarse, met = 0;
    CHECK(find_fault(p, &clusters, &coarse) == NULL);
    CHECK(coarse >= LEAVES / 2);
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        stp_cluster c;
        stp_clusters_get(&clusters, i, &c);
        for (uint32_t k = 0; k < c.vertex_count; ++k) {
            stp_vec2 uv = stp_cluster_texcoord(&clusters, &c, 0, k);
            uint32_t v = (uint32_t)(uv.x * 64.0f) + 64 * (uint32_t)(uv.y * 256.0f);
            for (uint32_t n = 0; n + 1 < count; n += 4) {
                met += v == leaf[n + 1] || v == leaf[n] + 2 ? 1 : 0;
                CHECK(v != leaf[n + 1] || c.runs[0].group == 0);
                CHECK(v != leaf[n] + 2 || c.runs[0].group == 0);
            }
        }
    }
    CHECK(met >= 2 * (count / 4));
    stp_coded_mesh_destroy(context, &coded);
    free(p);
    stp_context_destroy(context);
}

void test_clusters_of_leaves_survive_changed_bytes(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    plant* p = make_plant();
    CHECK(context != NULL && p != NULL);
    stp_store_mesh view = view_plant(p);
    view.triangle_count = 300;
    double step = stp_choose_grid_step(p->positions, p->indices, view.triangle_count);
    stp_coded_mesh coded;
    CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
    size_t opened = 0, refused = 0;
    unsigned char* copy = malloc(coded.size);
    CHECK(copy != NULL);
    for (size_t at = 0; at < coded.size; at += at < 400 ? 1 : 17) {
        for (unsigned change = 1; change < 256; change *= 2) {
            memcpy(copy, coded.bytes, coded.size);
            copy[at] = (unsigned char)(copy[at] ^ change);
            stp_clusters clusters;
            stp_decoded_mesh decoded;
            if (stp_clusters_open(copy, coded.size, &clusters) != NULL) {
                refused += 1;
                continue;
            }
            opened += 1;
            CHECK_EQUAL(STP_OK, stp_clusters_decode(context, &clusters, &decoded));
            stp_decoded_mesh_destroy(context, &decoded);
        }
    }
    CHECK(opened > 0 && refused > 0);
    free(copy);
    stp_coded_mesh_destroy(context, &coded);
    free(p);
    stp_context_destroy(context);
}

void test_clusters_of_quads_that_a_coarse_grid_flattens(test_state* test)
{
    enum { QUADS = 130 };
    static float positions[12 * QUADS];
    static uint32_t indices[6 * QUADS];
    static const uint32_t corners[6] = {0, 1, 2, 1, 3, 2};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint64_t random = 0;
    for (uint32_t i = 0; i < 12 * QUADS; ++i) {
        uint32_t q = i / 12, v = i / 3 % 4, k = i % 3;
        uint32_t cell = k == 0 ? q % 10 : k == 1 ? q / 10 % 10 : q / 100;
        uint32_t side = k == 0 ? v & 1 : k == 1 ? v >> 1 : 0;
        positions[i] = (float)(10 * cell + 3 * side) + between(&random, 0.0f, 1.0f);
    }
    for (uint32_t i = 0; i < 6 * QUADS; ++i) {
        indices[i] = 4 * (i / 6) + corners[i % 6];
    }
    for (uint32_t quads = 100; quads <= QUADS; ++quads) {
        stp_store_mesh mesh = {.vertex_count = 4 * quads,
                               .triangle_count = 2 * quads,
                               .positions = positions,
                               .indices = indices};
        stp_coded_mesh coded;
        stp_clusters clusters;
        CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &mesh, 0.5, &coded));
        CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
        CHECK_EQUAL(2 * quads, clusters.triangle_count);
        stp_coded_mesh_destroy(context, &coded);
    }
    stp_context_destroy(context);
}
