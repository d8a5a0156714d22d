// SPDX-License-Identifier: MIT
// Forged clusters, meshes that cannot become clusters, and out-of-memory.
#include "exhaustive.h"
#include "support_mesh.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/math/rng.h"

/// Calls every function on clusters.
static float use_clusters(const stp_clusters* clusters)
{
    float sum = 0.0f;
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster c;
        float positions[3 * STP_CLUSTER_VERTICES], color[4];
        uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
        stp_clusters_get_shape(clusters, i, &c);
        stp_cluster_positions(clusters, &c, positions);
        stp_cluster_indices(&c, 0, indices);
        for (uint32_t k = 0; k < 3 * c.triangle_count; ++k) {
            sum += positions[3 * (size_t)indices[k]];
        }
        stp_clusters_get(clusters, i, &c);
        stp_cluster_positions(clusters, &c, positions);
        sum += stp_clusters_bounds(clusters, i).max.x;
        for (uint32_t v = 0; v < c.vertex_count; ++v) {
            sum += positions[3 * v] + stp_cluster_texcoord(clusters, &c, 0, v).x +
                   stp_cluster_texcoord(clusters, &c, 1, v).y;
            stp_cluster_color(&c, v, color);
            sum += color[3];
        }
        for (uint32_t t = 0; t < c.triangle_count; ++t) {
            stp_vec3 n[3];
            sum += stp_cluster_normals(&c, t, n) ? n[2].x : 0.0f;
        }
    }
    return sum;
}

static bool make_coded(stp_context* context, uint32_t side, stp_coded_mesh* coded)
{
    made_mesh m;
    if (!made_mesh_create(MADE_BOXES, side, MADE_NORMALS | MADE_COLORS | MADE_TEXCOORDS, &m)) {
        return false;
    }
    stp_store_mesh view = made_mesh_view(&m);
    double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
    stp_result result = stp_clusters_encode(context, &view, step, coded);
    made_mesh_destroy(&m);
    return result == STP_OK;
}

/// In memory of exactly that size, so that sanitizers detect reads beyond it.
static const char* open_copy(const unsigned char* bytes, size_t size, size_t at, unsigned change)
{
    static volatile float sink;
    unsigned char* copy = malloc(size != 0 ? size : 1);
    if (copy == NULL) {
        return "memory";
    }
    memcpy(copy, bytes, size);
    if (at < size) {
        copy[at] = (unsigned char)(copy[at] ^ change);
    }
    stp_clusters clusters;
    const char* fault = stp_clusters_open(copy, size, &clusters);
    if (fault == NULL) {
        sink = sink + use_clusters(&clusters);
    }
    free(copy);
    return fault;
}

void test_clusters_refuse_every_truncation(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_coded_mesh coded;
    CHECK(context != NULL && make_coded(context, 14, &coded));
    CHECK(open_copy(coded.bytes, coded.size, SIZE_MAX, 0) == NULL);
    for (size_t size = 0; size < coded.size; ++size) {
        CHECK(open_copy(coded.bytes, size, SIZE_MAX, 0) != NULL);
    }
    stp_coded_mesh_destroy(context, &coded);
    stp_context_destroy(context);
}

void test_clusters_survive_every_changed_byte(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_coded_mesh coded;
    CHECK(context != NULL && make_coded(context, 9, &coded));
    size_t refused = 0, head = 24 + 32 * (size_t)coded.cluster_count;
    static const unsigned changes[] = {0xff, 0x80, 0x01, 0x10};
    for (size_t at = 0; at < coded.size; ++at) { // one change of each byte behind the head
        size_t stride = at < head ? 1 : test_stride(4);
        for (size_t i = stride == 1 ? 0 : at % 4; i < 4; i += stride) {
            const char* fault = open_copy(coded.bytes, coded.size, at, changes[i]);
            refused += at < head && fault != NULL ? 1 : 0;
        }
    }
    CHECK(refused > 2 * head); // any origins and steps are valid
    stp_coded_mesh_destroy(context, &coded);
    stp_context_destroy(context);
}

// Drawing looks a triangle's cluster up after the check, when the mapped file may have changed.
void test_clusters_overwritten_after_the_check_hold_few_triangles(test_state* test)
{
    enum { ENTRIES = 24, ENTRY = 32, FIRST = 4 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_coded_mesh coded;
    stp_clusters clusters;
    CHECK(context != NULL && make_coded(context, 30, &coded));
    unsigned char* bytes = malloc(coded.size);
    CHECK(bytes != NULL);
    memcpy(bytes, coded.bytes, coded.size);
    CHECK(stp_clusters_open(bytes, coded.size, &clusters) == NULL && clusters.cluster_count > 2);
    for (uint32_t i = 0; i < 1000; ++i) {
        uint32_t at = i % clusters.cluster_count;
        for (int k = 0; k < 4; ++k) {
            uint64_t random = stp_rng_hash(i, (uint64_t)k);
            bytes[ENTRIES + (size_t)ENTRY * at + FIRST + (size_t)k] =
                i < 8 ? 0xff : (unsigned char)random;
        }
        for (uint32_t c = 0; c < clusters.cluster_count; ++c) {
            CHECK(stp_clusters_triangles(&clusters, c) <= STP_CLUSTER_TRIANGLES);
        }
        CHECK(stp_clusters_find(&clusters, i % clusters.triangle_count) < clusters.cluster_count);
    }
    free(bytes);
    stp_coded_mesh_destroy(context, &coded);
    stp_context_destroy(context);
}

void test_clusters_of_nothing_are_none(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_mesh mesh = {0};
    stp_coded_mesh coded;
    stp_clusters clusters;
    stp_decoded_mesh decoded;
    CHECK(stp_choose_grid_step(NULL, NULL, 0) > 0.0);
    CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &mesh, 1.0, &coded));
    CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
    CHECK_EQUAL(0, clusters.cluster_count);
    CHECK_EQUAL(STP_OK, stp_clusters_decode(context, &clusters, &decoded));
    CHECK_EQUAL(0, decoded.triangle_count);
    stp_decoded_mesh_destroy(context, &decoded);
    stp_coded_mesh_destroy(context, &coded);
    stp_context_destroy(context);
}

void test_clusters_take_the_largest_and_smallest_numbers(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    static const uint32_t indices[] = {0, 1, 2};
    static const float sizes[] = {1e-44f, 1e-38f, 1e-10f, 1.0f, 1e10f, 1e35f};
    for (int i = 0; i < 6; ++i) {
        float positions[9] = {sizes[i], 0,         -sizes[i],       0, sizes[i],
                              0,        -sizes[i], 0.3f * sizes[i], 0};
        stp_store_mesh mesh = {
            .vertex_count = 3, .triangle_count = 1, .positions = positions, .indices = indices};
        double step = stp_choose_grid_step(positions, indices, 1);
        stp_coded_mesh coded;
        stp_clusters clusters;
        CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &mesh, step, &coded));
        CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
        stp_cluster c;
        stp_clusters_get(&clusters, 0, &c);
        float error = stp_cluster_position(&clusters, &c, c.indices[0]).x - positions[0];
        float other = stp_cluster_position(&clusters, &c, c.indices[0]).x;
        CHECK(fabsf(error) <= 0.5f * (float)step || other <= 0.0f); // or rotated to begin elsewhere
        stp_coded_mesh_destroy(context, &coded);
    }
    CHECK_EQUAL(0, log.errors);
    float huge[9] = {3e38f, 0, 0, 0, 3e38f, 0, 0, 0, 0};
    stp_store_mesh mesh = {
        .vertex_count = 3, .triangle_count = 1, .positions = huge, .indices = indices};
    stp_coded_mesh coded;
    double step = stp_choose_grid_step(huge, indices, 1);
    CHECK_EQUAL(STP_ERROR_LIMIT, stp_clusters_encode(context, &mesh, step, &coded));
    CHECK_EQUAL(1, log.errors);
    CHECK_EQUAL(STP_ERROR_LIMIT, stp_clusters_encode(context, &mesh, 0.0, &coded));
    CHECK_EQUAL(2, log.errors);
    stp_context_destroy(context);
}

void test_clusters_survive_failing_allocator(test_state* test)
{
    made_mesh m;
    CHECK(made_mesh_create(MADE_WAVE, 40, MADE_NORMALS | MADE_TEXCOORDS | MADE_COLORS, &m));
    stp_store_mesh view = made_mesh_view(&m);
    double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
    int failures = 0;
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_coded_mesh coded;
        stp_clusters clusters;
        stp_decoded_mesh decoded;
        stp_result result = stp_clusters_encode(context, &view, step, &coded);
        if (result == STP_OK) {
            CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
            result = stp_clusters_decode(context, &clusters, &decoded);
            if (result == STP_OK) {
                stp_decoded_mesh_destroy(context, &decoded);
            }
            stp_coded_mesh_destroy(context, &coded);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            CHECK_EQUAL(0, log.errors);
            break;
        }
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
        CHECK_EQUAL(1, log.errors);
        failures += 1;
    }
    CHECK(failures > 8);
    made_mesh_destroy(&m);
}
