// SPDX-License-Identifier: MIT
// Meshes as clusters: nothing is lost, no cracks appear, errors stay within the format's bounds.
#include "support_mesh.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/splats/octahedral.h"

#include <math.h>

/// A triangle as rounded corners, rotated to its smallest form.
typedef struct rounded {
    int64_t corner[3][3];
    uint32_t triangle, turn;
} rounded;

static int compare_corners(const int64_t* a, const int64_t* b)
{
    for (int k = 0; k < 3; ++k) {
        if (a[k] != b[k]) {
            return a[k] < b[k] ? -1 : 1;
        }
    }
    return 0;
}

static int compare_rounded(const void* left, const void* right)
{
    const rounded *a = left, *b = right;
    for (int k = 0; k < 3; ++k) {
        int order = compare_corners(a->corner[k], b->corner[k]);
        if (order != 0) {
            return order;
        }
    }
    return 0;
}

static rounded make_rounded(const float* const corners[3], double step, uint32_t triangle)
{
    int64_t q[3][3];
    for (uint32_t k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) {
            double x = (double)corners[k][c] / step;
            q[k][c] = (int64_t)floor(x + 0.5);
        }
    }
    rounded minimum = {0};
    for (uint32_t turn = 0; turn < 3; ++turn) {
        rounded r = {.triangle = triangle, .turn = turn};
        for (uint32_t k = 0; k < 3; ++k) {
            memcpy(r.corner[k], q[(turn + k) % 3], sizeof(q[0]));
        }
        minimum = turn == 0 || compare_rounded(&r, &minimum) < 0 ? r : minimum;
    }
    return minimum;
}

/// The triangles of both meshes, sorted. The caller frees them.
static rounded* round_source(const made_mesh* m, double step)
{
    rounded* list = calloc(m->triangle_count + 1, sizeof(*list));
    for (uint32_t t = 0; list != NULL && t < m->triangle_count; ++t) {
        const float* p[3];
        for (size_t k = 0; k < 3; ++k) {
            p[k] = m->positions + 3 * (size_t)m->indices[3 * (size_t)t + k];
        }
        list[t] = make_rounded(p, step, t);
    }
    qsort(list, m->triangle_count, sizeof(*list), compare_rounded);
    return list;
}

static rounded* round_decoded(const stp_decoded_mesh* m, double step)
{
    rounded* list = calloc(m->triangle_count + 1, sizeof(*list));
    for (uint32_t t = 0; list != NULL && t < m->triangle_count; ++t) {
        const float* p = m->positions + 9 * (size_t)t;
        list[t] = make_rounded((const float* const[3]){p, p + 3, p + 6}, step, t);
    }
    qsort(list, m->triangle_count, sizeof(*list), compare_rounded);
    return list;
}

static bool is_whole(float position, double step)
{
    double x = (double)position / step;
    return floor(x) >= x;
}

/// Codes a mesh, opens the result and decodes it. The caller destroys `coded` and `decoded`.
static bool code_and_decode(stp_context* context, const stp_store_mesh* view, double step,
                            stp_coded_mesh* coded, stp_clusters* clusters,
                            stp_decoded_mesh* decoded)
{
    return stp_clusters_encode(context, view, step, coded) == STP_OK &&
           stp_clusters_open(coded->bytes, coded->size, clusters) == NULL &&
           stp_clusters_decode(context, clusters, decoded) == STP_OK;
}

/// Every source triangle occurs once, with its winding. Each position is the grid point nearest to
/// the source's, in every cluster, so no cracks appear.
static const char* find_position_fault(const made_mesh* m, const stp_decoded_mesh* decoded,
                                       double step)
{
    if (m->triangle_count != decoded->triangle_count) {
        return "triangle count";
    }
    rounded* a = round_source(m, step);
    rounded* b = round_decoded(decoded, step);
    const char* fault = a == NULL || b == NULL ? "memory" : NULL;
    for (uint32_t t = 0; fault == NULL && t < m->triangle_count; ++t) {
        fault = compare_rounded(&a[t], &b[t]) != 0 ? "a triangle" : NULL;
    }
    for (size_t i = 0; fault == NULL && i < 9 * (size_t)m->triangle_count; ++i) {
        fault = !is_whole(decoded->positions[i], step) ? "a position beside the grid" : NULL;
    }
    free(a);
    free(b);
    return fault;
}

void test_clusters_keep_every_triangle_of_every_shape(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static const uint32_t sides[] = {1, 7, 8, 9, 40};
    for (int shape = 0; shape < MADE_SHAPES; ++shape) {
        for (unsigned i = 0; i < 5 * 2; ++i) {
            made_mesh m;
            unsigned attributes = i % 2 == 0 ? 0 : MADE_NORMALS | MADE_COLORS | MADE_TEXCOORDS;
            CHECK(made_mesh_create((made_shape)shape, sides[i / 2], attributes, &m));
            if (i % 4 >= 2) {
                made_mesh_shuffle(&m, i);
            }
            double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
            stp_store_mesh view = made_mesh_view(&m);
            view.is_piece = true; // loose parts, too, keep to the grid
            stp_coded_mesh coded;
            stp_clusters clusters;
            stp_decoded_mesh decoded;
            CHECK(code_and_decode(context, &view, step, &coded, &clusters, &decoded));
            const char* fault = find_position_fault(&m, &decoded, step);
            if (fault != NULL) {
                fprintf(stderr, "shape %d, side %u: %s\n", shape, sides[i / 2], fault);
            }
            CHECK(fault == NULL);
            stp_coded_mesh described = stp_clusters_describe(&clusters);
            CHECK(memcmp(&described.bounds, &coded.bounds, sizeof(described.bounds)) == 0);
            CHECK_EQUAL(coded.vertex_count, described.vertex_count);
            stp_decoded_mesh_destroy(context, &decoded);
            stp_coded_mesh_destroy(context, &coded);
            made_mesh_destroy(&m);
        }
    }
    stp_context_destroy(context);
}

static double edge_length(const float* a, const float* b)
{
    double x = (double)a[0] - (double)b[0], y = (double)a[1] - (double)b[1],
           z = (double)a[2] - (double)b[2];
    return sqrt(x * x + y * y + z * z);
}

static int compare_doubles(const void* left, const void* right)
{
    double a = *(const double*)left, b = *(const double*)right;
    return (a > b) - (a < b);
}

/// The largest position error relative to the median edge of its cluster (without edges of length
/// 0).
static double worst_error(const stp_clusters* clusters, const stp_decoded_mesh* decoded)
{
    double worst = 0.0;
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster cluster;
        stp_clusters_get(clusters, i, &cluster);
        double edges[3 * STP_CLUSTER_TRIANGLES];
        size_t count = 0;
        for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
            const float* p = decoded->positions + 9 * (size_t)(cluster.first_triangle + t);
            for (int k = 0; k < 3; ++k) {
                double length = edge_length(p + 3 * k, p + (3 * k + 3) % 9);
                edges[count] = length;
                count += length > 0.0 ? 1 : 0;
            }
        }
        if (count != 0) {
            qsort(edges, count, sizeof(edges[0]), compare_doubles);
            double step = (double)clusters->step * (double)(1u << cluster.runs[0].shift);
            double error = step * 0.5 * sqrt(3.0) / edges[count / 2];
            worst = error > worst ? error : worst;
        }
    }
    return worst;
}

void test_clusters_err_by_an_eighth_of_their_edges_at_most(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int shape = 0; shape < MADE_SHAPES; ++shape) {
        for (int shuffled = 0; shuffled < 2; ++shuffled) {
            made_mesh m;
            CHECK(made_mesh_create((made_shape)shape, 40, 0, &m));
            if (shuffled == 1) {
                made_mesh_shuffle(&m, 3);
            }
            double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
            stp_store_mesh view = made_mesh_view(&m);
            stp_coded_mesh coded;
            stp_clusters clusters;
            stp_decoded_mesh decoded;
            CHECK(code_and_decode(context, &view, step, &coded, &clusters, &decoded));
            double worst = worst_error(&clusters, &decoded);
            CHECK(worst <= 0.125);
            stp_decoded_mesh_destroy(context, &decoded);
            stp_coded_mesh_destroy(context, &coded);
            made_mesh_destroy(&m);
        }
    }
    stp_context_destroy(context);
}

static double degrees_between(const float* a, stp_vec3 b)
{
    double x = (double)a[0] - (double)b.x, y = (double)a[1] - (double)b.y,
           z = (double)a[2] - (double)b.z;
    return sqrt(x * x + y * y + z * z) * 57.3; // for small angles
}

/// Whether a decoded triangle has the attributes of the source's corner `from`.
static const char* find_attribute_fault(const made_mesh* m, const stp_decoded_mesh* d, uint32_t v,
                                        size_t corner, double largest)
{
    stp_vec3 n = stp_octahedral_decode16(m->normals[2 * (size_t)v], m->normals[2 * (size_t)v + 1]);
    if (degrees_between(d->normals + 3 * corner, n) > 0.5) {
        return "a normal";
    }
    for (int set = 0; set < 2; ++set) {
        for (size_t k = 0; k < 2; ++k) {
            double error = fabs((double)d->texcoords[set][2 * corner + k] -
                                (double)m->texcoords[set][2 * (size_t)v + k]);
            // a sixteenth of a texel of 8192, or the float precision of the largest coordinate
            if (error > fmax(1.0 / 131072.0, largest * 0x1p-24) * 1.01) {
                return "texture coordinates";
            }
        }
    }
    for (size_t k = 0; k < 4; ++k) {
        double now = (double)d->colors[4 * corner + k];
        double was = (double)m->colors[4 * (size_t)v + k] / 65535.0;
        double error = k < 3 ? fabs(sqrt(now) - sqrt(was)) * 255.0 : fabs(now - was) * 255.0;
        if (error > 0.51) {
            return "a colour";
        }
    }
    return NULL;
}

void test_clusters_keep_attributes_of_corners(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static const made_shape shapes[] = {MADE_WAVE, MADE_SOUP, MADE_SCATTERED, MADE_BOXES};
    for (int i = 0; i < 4; ++i) {
        made_mesh m;
        CHECK(made_mesh_create(shapes[i], 30, MADE_NORMALS | MADE_COLORS | MADE_TEXCOORDS, &m));
        made_mesh_shuffle(&m, 9);
        double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
        stp_store_mesh view = made_mesh_view(&m);
        view.is_piece = true; // loose parts, too, keep to the grid
        stp_coded_mesh coded;
        stp_clusters clusters;
        stp_decoded_mesh decoded;
        CHECK(code_and_decode(context, &view, step, &coded, &clusters, &decoded));
        rounded* a = round_source(&m, step);
        rounded* b = round_decoded(&decoded, step);
        CHECK(a != NULL && b != NULL);
        const char* fault = NULL;
        double largest = 0.0;
        for (size_t v = 0; v < 2 * (size_t)m.vertex_count; ++v) {
            largest = fmax(largest, fabs((double)m.texcoords[1][v]));
        }
        for (uint32_t t = 0; t < m.triangle_count && fault == NULL; ++t) {
            CHECK_EQUAL(0, compare_rounded(&a[t], &b[t]));
            for (uint32_t k = 0; k < 3 && fault == NULL; ++k) {
                uint32_t v = m.indices[3 * (size_t)a[t].triangle + (a[t].turn + k) % 3];
                size_t corner = 3 * (size_t)b[t].triangle + (b[t].turn + k) % 3;
                fault = find_attribute_fault(&m, &decoded, v, corner, largest);
            }
        }
        CHECK(fault == NULL);
        free(a);
        free(b);
        stp_decoded_mesh_destroy(context, &decoded);
        stp_coded_mesh_destroy(context, &coded);
        made_mesh_destroy(&m);
    }
    stp_context_destroy(context);
}

void test_clusters_of_split_meshes_meet(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_mesh m;
    CHECK(context != NULL && made_mesh_create(MADE_WAVE, 30, 0, &m));
    double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
    // whole, and as two pieces with the same vertices: each piece rounds as the whole does
    for (uint32_t piece = 0; piece < 3; ++piece) {
        stp_store_mesh view = made_mesh_view(&m);
        uint32_t half = m.triangle_count / 2;
        view.triangle_count = piece == 0 ? m.triangle_count : half;
        view.indices = m.indices + (piece == 2 ? 3 * (size_t)half : 0);
        made_mesh part = m;
        part.triangle_count = view.triangle_count;
        part.indices = m.indices + (piece == 2 ? 3 * (size_t)half : 0);
        stp_coded_mesh coded;
        stp_clusters clusters;
        stp_decoded_mesh decoded;
        CHECK(code_and_decode(context, &view, step, &coded, &clusters, &decoded));
        CHECK(find_position_fault(&part, &decoded, step) == NULL);
        stp_decoded_mesh_destroy(context, &decoded);
        stp_coded_mesh_destroy(context, &coded);
    }
    made_mesh_destroy(&m);
    stp_context_destroy(context);
}

void test_clusters_stay_within_their_limits(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int shape = 0; shape < MADE_SHAPES; ++shape) {
        made_mesh m;
        CHECK(made_mesh_create((made_shape)shape, 25, MADE_NORMALS, &m));
        double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
        stp_store_mesh view = made_mesh_view(&m);
        stp_coded_mesh coded;
        stp_clusters clusters;
        CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
        CHECK(stp_clusters_open(coded.bytes, coded.size, &clusters) == NULL);
        uint32_t triangles = 0;
        for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
            stp_cluster c;
            stp_clusters_get(&clusters, i, &c);
            CHECK_EQUAL(triangles, c.first_triangle);
            CHECK(c.triangle_count >= 1 && c.triangle_count <= STP_CLUSTER_TRIANGLES);
            CHECK(c.vertex_count <= STP_CLUSTER_VERTICES && c.normal_count <= c.vertex_count);
            CHECK_EQUAL(i, stp_clusters_find(&clusters, triangles));
            CHECK_EQUAL(i, stp_clusters_find(&clusters, triangles + c.triangle_count - 1));
            stp_box box = stp_clusters_bounds(&clusters, i);
            float positions[3 * STP_CLUSTER_VERTICES], others[3 * STP_CLUSTER_VERTICES];
            uint32_t indices[2][3 * STP_CLUSTER_TRIANGLES];
            stp_cluster part;
            stp_clusters_get_shape(&clusters, i, &part);
            stp_cluster_positions(&clusters, &c, positions);
            stp_cluster_positions(&clusters, &part, others);
            stp_cluster_indices(&c, i, indices[0]);
            stp_cluster_indices(&part, i, indices[1]);
            CHECK(part.first_triangle == triangles && part.triangle_count == c.triangle_count);
            CHECK(memcmp(positions, others, 3 * c.vertex_count * sizeof(float)) == 0);
            CHECK(memcmp(indices[0], indices[1], 3 * c.triangle_count * sizeof(uint32_t)) == 0);
            for (uint32_t t = 0; t < c.triangle_count; ++t) {
                uint32_t corners[3];
                stp_cluster_corners(&c, t, corners);
                for (uint32_t k = 0; k < 3; ++k) {
                    CHECK_EQUAL(i + corners[k], indices[0][3 * t + k]);
                }
            }
            for (uint32_t v = 0; v < c.vertex_count; ++v) {
                stp_vec3 p = stp_cluster_position(&clusters, &c, v);
                CHECK(memcmp(&p, positions + 3 * v, sizeof(p)) == 0);
                CHECK(p.x >= box.min.x && p.y >= box.min.y && p.z >= box.min.z);
                CHECK(p.x <= box.max.x && p.y <= box.max.y && p.z <= box.max.z);
            }
            triangles += c.triangle_count;
        }
        CHECK_EQUAL(m.triangle_count, triangles);
        stp_coded_mesh_destroy(context, &coded);
        made_mesh_destroy(&m);
    }
    stp_context_destroy(context);
}

void test_clusters_of_connected_meshes_take_12_bytes_a_triangle_at_most(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static const made_shape shapes[] = {MADE_WAVE, MADE_SOUP, MADE_BOXES, MADE_SLIVERS};
    for (int i = 0; i < 4; ++i) {
        made_mesh m;
        CHECK(made_mesh_create(shapes[i], 40, MADE_NORMALS, &m));
        double step = stp_choose_grid_step(m.positions, m.indices, m.triangle_count);
        stp_store_mesh view = made_mesh_view(&m);
        stp_coded_mesh coded;
        CHECK_EQUAL(STP_OK, stp_clusters_encode(context, &view, step, &coded));
        CHECK(coded.size <= 12 * (size_t)m.triangle_count);
        stp_coded_mesh_destroy(context, &coded);
        made_mesh_destroy(&m);
    }
    stp_context_destroy(context);
}
