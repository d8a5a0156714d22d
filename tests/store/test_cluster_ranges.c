// SPDX-License-Identifier: MIT
// Meshes coded as given clusters: exactly these clusters, nothing is lost, limits are kept.
#include "support_mesh.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/math/rng.h"
#include "store/clusters/clusters.h"

#include <math.h>
#include <string.h>

enum { SIDE = 24, CLUSTER_LIMIT = 2 * SIDE * SIDE };

/// Random ends of clusters of up to 80 triangles. @return their number
static uint32_t make_ends(uint64_t seed, uint32_t triangle_count, uint32_t ends[CLUSTER_LIMIT])
{
    uint32_t count = 0;
    for (uint32_t at = 0; at < triangle_count; ++count) {
        at += 1 + (uint32_t)(stp_rng_hash(seed, count) % 80);
        at = at < triangle_count ? at : triangle_count;
        ends[count] = at;
    }
    return count;
}

static double choose_step(const stp_store_mesh* mesh)
{
    return stp_choose_grid_step(mesh->positions, mesh->indices, mesh->triangle_count);
}

static bool is_rounded(float source, float coded, double step)
{
    double wanted = floor((double)source / step + 0.5) * step;
    return !(fabs(wanted - (double)coded) > 0.0);
}

/// Turns of a triangle after which its corners are those of the source; 3: none.
static uint32_t find_turn(const stp_store_mesh* mesh, uint32_t triangle, const float* coded,
                          double step)
{
    for (uint32_t turn = 0; turn < 3; ++turn) {
        bool same = true;
        for (uint32_t k = 0; k < 9; ++k) {
            size_t corner = 3 * (size_t)triangle + (k / 3 + turn) % 3;
            const float* source = mesh->positions + 3 * (size_t)mesh->indices[corner];
            same = same && is_rounded(source[k % 3], coded[k], step);
        }
        if (same) {
            return turn;
        }
    }
    return 3;
}

/// Checks counts and first triangles of all clusters.
static bool are_clusters(const stp_clusters* clusters, const uint32_t* ends, uint32_t count)
{
    bool same = clusters->cluster_count == count;
    for (uint32_t i = 0; same && i < count; ++i) {
        uint32_t first = i > 0 ? ends[i - 1] : 0;
        same = stp_clusters_first_triangle(clusters, i) == first &&
               stp_clusters_triangles(clusters, i) == ends[i] - first;
    }
    return same;
}

void test_cluster_ranges_keep_clusters_and_order(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static uint32_t ends[CLUSTER_LIMIT];
    for (int shape = 0; shape < MADE_SHAPES; ++shape) {
        made_mesh made;
        stp_coded_mesh coded;
        stp_clusters clusters;
        stp_decoded_mesh decoded;
        CHECK(made_mesh_create((made_shape)shape, SIDE, MADE_COLORS | MADE_TEXCOORDS, &made));
        if (shape % 2 == 0) {
            made_mesh_shuffle(&made, 5);
        }
        stp_store_mesh mesh = made_mesh_view(&made);
        double step = choose_step(&mesh);
        uint32_t count = make_ends((uint64_t)shape, mesh.triangle_count, ends);
        CHECK_EQUAL(STP_OK, stp_clusters_encode_ranges(context, &mesh, step, ends, count, &coded));
        CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
        CHECK_EQUAL(count, coded.cluster_count);
        CHECK(are_clusters(&clusters, ends, count));
        CHECK_EQUAL(STP_OK, stp_clusters_decode(context, &clusters, &decoded));
        for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
            CHECK_EQUAL(0, find_turn(&mesh, t, decoded.positions + 9 * (size_t)t, step));
        }
        for (uint32_t i = 0; i < count; ++i) {
            stp_cluster cluster;
            stp_clusters_get(&clusters, i, &cluster);
            CHECK_EQUAL(0, cluster.smooth_count + cluster.face_count + cluster.normal_count);
        }
        stp_decoded_mesh_destroy(context, &decoded);
        stp_coded_mesh_destroy(context, &coded);
        made_mesh_destroy(&made);
    }
    stp_context_destroy(context);
}

void test_cluster_ranges_with_normals_keep_clusters(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static uint32_t ends[CLUSTER_LIMIT];
    static bool met[CLUSTER_LIMIT];
    made_mesh made;
    stp_coded_mesh coded;
    stp_clusters clusters;
    stp_decoded_mesh decoded;
    CHECK(made_mesh_create(MADE_WAVE, SIDE, MADE_NORMALS, &made));
    stp_store_mesh mesh = made_mesh_view(&made);
    double step = choose_step(&mesh);
    uint32_t count = make_ends(3, mesh.triangle_count, ends);
    CHECK_EQUAL(STP_OK, stp_clusters_encode_ranges(context, &mesh, step, ends, count, &coded));
    CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
    CHECK(are_clusters(&clusters, ends, count));
    CHECK_EQUAL(STP_OK, stp_clusters_decode(context, &clusters, &decoded));
    for (uint32_t i = 0, first = 0; i < count; first = ends[i++]) {
        for (uint32_t t = first; t < ends[i]; ++t) { // one of the same cluster
            uint32_t source = first;
            const float* corners = decoded.positions + 9 * (size_t)t;
            while (source < ends[i] &&
                   (met[source] || find_turn(&mesh, source, corners, step) == 3)) {
                source += 1;
            }
            CHECK(source < ends[i]);
            met[source] = true;
        }
    }
    stp_decoded_mesh_destroy(context, &decoded);
    stp_coded_mesh_destroy(context, &coded);
    made_mesh_destroy(&made);
    stp_context_destroy(context);
}

void test_cluster_ranges_have_limits(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    enum { TRIANGLES = STP_CLUSTER_TRIANGLES + 1 };
    static float positions[9 * TRIANGLES];
    static uint32_t indices[3 * TRIANGLES];
    for (uint32_t i = 0; i < 9 * TRIANGLES; ++i) {
        positions[i] = i % 3 == 0 ? (float)(i / 3) : i % 3 == 1 ? (float)(i / 3 % 2) : 0.0f;
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
        indices[i] = i < 3 * 85 ? i : i % 3; // 85 apart, the others at the first one's corners
    }
    stp_store_mesh mesh = {.vertex_count = 3 * TRIANGLES,
                           .triangle_count = STP_CLUSTER_TRIANGLES,
                           .positions = positions,
                           .indices = indices};
    stp_coded_mesh coded;
    uint32_t end = STP_CLUSTER_TRIANGLES;
    CHECK_EQUAL(STP_OK, stp_clusters_encode_ranges(context, &mesh, 0.125, &end, 1, &coded));
    CHECK_EQUAL(255, coded.vertex_count);
    stp_coded_mesh_destroy(context, &coded);
    indices[3 * 90] = 300;
    CHECK_EQUAL(STP_OK, stp_clusters_encode_ranges(context, &mesh, 0.125, &end, 1, &coded));
    CHECK_EQUAL(256, coded.vertex_count);
    stp_coded_mesh_destroy(context, &coded);
    CHECK_EQUAL(0, log.errors);
    indices[3 * 127 + 1] = 301;
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_clusters_encode_ranges(context, &mesh, 0.125, &end, 1, &coded));
    CHECK(coded.bytes == NULL);
    indices[3 * 127 + 1] = 1;
    mesh.triangle_count = end = TRIANGLES;
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_clusters_encode_ranges(context, &mesh, 0.125, &end, 1, &coded));
    CHECK(strstr(log.text, "cluster 0 of 129 triangles has more than 128 triangles or 256") !=
          NULL);
    CHECK_EQUAL(2, log.errors);
    stp_context_destroy(context);
}
