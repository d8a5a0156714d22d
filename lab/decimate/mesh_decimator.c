// SPDX-License-Identifier: MIT
// Garland, Heckbert. Surface Simplification Using Quadric Error Metrics. 1997, by libmeshoptimizer:
// the reference for splats in Figure 9 of the paper, at an equal number of vertices.
#include "lab/decimate/point_disks.h"
#include "lab/decimate/simplify.h"

#include <assert.h>
#include <string.h>

enum { ATTEMPTS = 12 };

typedef struct mesh_maker {
    stp_context* context;
    const stp_decimate_input* input;
    // distinct used vertices, and their triangles
    uint32_t* originals; ///< numbers in the input, ascending
    float* positions;
    uint32_t vertex_count;
    uint32_t* welded;    ///< triangles
    size_t welded_count; ///< number of indices in `welded`
    uint32_t *found, *best;
    size_t best_count;
    uint32_t best_vertices;
    uint32_t* numbers; ///< new number per vertex; UINT32_MAX: not used
} mesh_maker;

/// Numbers the used vertices among `vertex_count`. @return number of used vertices
static uint32_t number_vertices(const mesh_maker* m, const uint32_t* indices, size_t count,
                                uint32_t vertex_count)
{
    uint32_t used = 0;
    memset(m->numbers, 0, vertex_count * sizeof(*m->numbers));
    for (size_t i = 0; i < count; ++i) {
        m->numbers[indices[i]] = 1;
    }
    for (uint32_t i = 0; i < vertex_count; ++i) {
        m->numbers[i] = m->numbers[i] != 0 ? used++ : UINT32_MAX;
    }
    return used;
}

/// Welds coincident vertices. Drops degenerate triangles and unused vertices, because the
/// simplifier would keep vertices that coincide with them.
static stp_result weld(mesh_maker* m)
{
    const stp_decimate_input* input = m->input;
    size_t count = 3 * (size_t)input->triangle_count;
    if (count > 0 && stp_simplify_weld(m->welded, input->triangles, count, input->positions,
                                       input->count) != 0) {
        return stp_fail_memory(m->context);
    }
    for (size_t i = 0; i + 2 < count; i += 3) {
        uint32_t t[3] = {m->welded[i], m->welded[i + 1], m->welded[i + 2]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
            memcpy(m->welded + m->welded_count, t, sizeof(t));
            m->welded_count += 3;
        }
    }
    m->vertex_count = number_vertices(m, m->welded, m->welded_count, input->count);
    for (uint32_t i = 0; i < input->count; ++i) {
        if (m->numbers[i] != UINT32_MAX) {
            m->originals[m->numbers[i]] = i;
            memcpy(m->positions + 3 * (size_t)m->numbers[i], input->positions + 3 * (size_t)i,
                   3 * sizeof(float));
        }
    }
    for (size_t i = 0; i < m->welded_count; ++i) {
        m->welded[i] = m->numbers[m->welded[i]];
    }
    return STP_OK;
}

static uint32_t distance(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

/// Next triangle count to try, between one that leaves too few vertices and one that leaves too
/// many.
static int64_t next_wanted(int64_t wanted, int64_t missing, int64_t low, int64_t high)
{
    assert(low <= high);
    int64_t next = wanted + 2 * missing; // within a closed surface, a collapse takes two triangles
    return next > low && next < high ? next : low + (high - low) / 2;
}

/// Simplifies to several triangle counts, until the vertex count is right, or no count is left to
/// try. Each attempt begins with all triangles.
static stp_result find_best(mesh_maker* m, uint32_t target)
{
    memcpy(m->best, m->welded, m->welded_count * sizeof(*m->best));
    m->best_count = m->welded_count;
    m->best_vertices = m->vertex_count;
    int64_t low = 0, high = (int64_t)m->welded_count / 3;
    int64_t wanted = next_wanted(0, target, low, high);
    for (int attempt = 0; attempt < ATTEMPTS && m->vertex_count > target &&
                          m->best_vertices != target && wanted > low && wanted < high;
         ++attempt) {
        size_t count = 0;
        if (stp_simplify_triangles(m->found, &count, m->welded, m->welded_count, m->positions,
                                   m->vertex_count, 3 * (size_t)wanted) != 0) {
            return stp_fail_memory(m->context);
        }
        assert(count <= m->welded_count && count % 3 == 0);
        uint32_t vertices = number_vertices(m, m->found, count, m->vertex_count);
        if (distance(vertices, target) < distance(m->best_vertices, target)) {
            uint32_t* swap = m->best;
            m->best = m->found;
            m->found = swap;
            m->best_count = count;
            m->best_vertices = vertices;
        }
        if (vertices > target && (int64_t)count / 3 > wanted) {
            break; // it cannot collapse any further
        }
        low = vertices < target ? wanted : low;
        high = vertices > target ? wanted : high;
        wanted = next_wanted(wanted, (int64_t)target - (int64_t)vertices, low, high);
    }
    return STP_OK;
}

static stp_result copy_best(mesh_maker* m, stp_decimate_output* output)
{
    const stp_decimate_input* input = m->input;
    uint32_t vertices = number_vertices(m, m->best, m->best_count, m->vertex_count);
    assert(vertices == m->best_vertices && m->best_count % 3 == 0);
    output->vertices = STP_NEW_ARRAY(m->context, float, 3 * (size_t)vertices + 1);
    output->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * (size_t)vertices + 1);
    output->triangles = STP_NEW_ARRAY(m->context, uint32_t, m->best_count + 1);
    if (output->vertices == NULL || output->colors == NULL || output->triangles == NULL) {
        return stp_fail_memory(m->context);
    }
    for (size_t i = 0; i < m->vertex_count; ++i) {
        if (m->numbers[i] == UINT32_MAX) {
            continue;
        }
        size_t to = 3 * (size_t)m->numbers[i];
        memcpy(output->vertices + to, m->positions + 3 * i, 3 * sizeof(float));
        if (input->colors != NULL) {
            memcpy(output->colors + to, input->colors + 3 * (size_t)m->originals[i], 3);
        } else {
            memset(output->colors + to, 255, 3);
        }
    }
    for (size_t i = 0; i < m->best_count; ++i) {
        output->triangles[i] = m->numbers[m->best[i]];
    }
    output->vertex_count = vertices;
    output->triangle_count = (uint32_t)(m->best_count / 3);
    return STP_OK;
}

stp_result stp_decimate_by_mesh(stp_context* context, const stp_decimate_input* input,
                                uint32_t target, stp_decimate_output* output)
{
    *output = (stp_decimate_output){0};
    stp_result result = stp_decimate_check(context, input);
    if (result == STP_OK && input->triangles == NULL) {
        result = stp_fail(context, STP_ERROR_ARGUMENT,
                          "mesh simplification: expected triangles, found points alone");
    }
    if (result != STP_OK) {
        return result;
    }
    size_t indices = 3 * (size_t)input->triangle_count;
    uint64_t bytes = stp_simplify_bytes(indices, input->count);
    if (!stp_reserve(context, bytes)) {
        return stp_fail_memory(context);
    }
    size_t vertices = (size_t)input->count + 1;
    mesh_maker m = {.context = context,
                    .input = input,
                    .originals = STP_NEW_ARRAY(context, uint32_t, vertices),
                    .positions = STP_NEW_ARRAY(context, float, 3 * vertices),
                    .welded = STP_NEW_ARRAY(context, uint32_t, indices + 1),
                    .found = STP_NEW_ARRAY(context, uint32_t, indices + 1),
                    .best = STP_NEW_ARRAY(context, uint32_t, indices + 1),
                    .numbers = STP_NEW_ARRAY(context, uint32_t, vertices)};
    if (m.originals == NULL || m.positions == NULL || m.welded == NULL || m.found == NULL ||
        m.best == NULL || m.numbers == NULL) {
        result = stp_fail_memory(context);
    }
    result = result == STP_OK ? weld(&m) : result;
    result = result == STP_OK ? find_best(&m, target) : result;
    result = result == STP_OK ? copy_best(&m, output) : result;
    stp_release(context, bytes);
    stp_free(context, m.originals);
    stp_free(context, m.positions);
    stp_free(context, m.welded);
    stp_free(context, m.found);
    stp_free(context, m.best);
    stp_free(context, m.numbers);
    return result;
}
