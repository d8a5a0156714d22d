// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_field.h"

#include "lod/grid.h"
#include "lod/psp/initial.h"
#include "lod/psp/kd_tree.h"

#include <assert.h>
#include <string.h>

enum {
    NEIGHBOURS = 8, ///< k of the paper
    WEIGHT_ONE = 256,
    WEIGHT_MAX = 1 << 16,
    ROUNDS_MAX = 32, ///< rounds of connecting parts: each halves their number
};
#define MARGIN 0.5f ///< margin of a point, relative to the radius of its disk

/// Pairs of points. Each becomes an edge in both directions.
typedef struct edge_list {
    const uint32_t* pairs;
    size_t count;
} edge_list;

static bool lists(const uint32_t* near, uint32_t wanted)
{
    for (int k = 0; k < NEIGHBOURS; ++k) {
        if (near[k] == wanted) {
            return true;
        }
    }
    return false;
}

/// Makes the graph in which two points are neighbours if either lists the other.
static stp_result make_graph(stp_context* context, const uint32_t* nearest,
                             stp_subsample_field* field)
{
    size_t count = field->count;
    uint32_t* starts = field->starts = STP_NEW_ZEROED(context, uint32_t, count + 2);
    if (starts == NULL) {
        return stp_fail_memory(context);
    }
    // the first pass counts edges at starts[i + 2]; the second one fills, and moves starts[i + 1]
    // to the end of i
    for (int fill = 0; fill < 2; ++fill) {
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t* near = nearest + NEIGHBOURS * (size_t)i;
            for (int k = 0; k < NEIGHBOURS && near[k] != UINT32_MAX; ++k) {
                uint32_t j = near[k];
                bool mutual = lists(nearest + NEIGHBOURS * (size_t)j, i);
                if (fill == 0) {
                    starts[i + 2]++;
                    starts[j + 2] += mutual ? 0 : 1;
                } else {
                    field->neighbours[starts[i + 1]++] = j;
                    if (!mutual) {
                        field->neighbours[starts[j + 1]++] = i;
                    }
                }
            }
        }
        for (size_t i = 2; fill == 0 && i < count + 2; ++i) {
            starts[i] += starts[i - 1];
        }
        if (fill == 0) {
            field->neighbours = STP_NEW_ARRAY(context, uint32_t, (size_t)starts[count + 1] + 1);
            if (field->neighbours == NULL) {
                return stp_fail_memory(context);
            }
        }
    }
    assert(starts[0] == 0 && starts[count] == starts[count + 1] && "all edges are listed");
    return STP_OK;
}

/// A point's area is that of a disk that extends to its farthest neighbour, up to a common factor.
static void weigh(stp_subsample_field* field)
{
    double mean = 0.0;
    for (uint32_t i = 0; i < field->count; ++i) {
        double r = (double)field->own[i].minor;
        mean += r * r / field->count;
    }
    for (uint32_t i = 0; i < field->count; ++i) {
        double r = (double)field->own[i].minor, share = WEIGHT_ONE * (r * r / mean);
        field->weights[i] = !(share > 1.0) ? 1 : share < WEIGHT_MAX ? (uint32_t)share : WEIGHT_MAX;
        field->margins[i] = MARGIN * field->own[i].minor;
    }
}

static double measure_diagonal(const stp_subsample_field* field)
{
    stp_boxd box = stp_boxd_empty();
    for (uint32_t i = 0; i < field->count; ++i) {
        stp_boxd_add(&box, stp_to_double(stp_subsample_position(field, i)));
    }
    stp_vec3d extent = stp_subd(box.max, box.min);
    double diagonal = field->count > 0 ? sqrt(stp_dotd(extent, extent)) : 0.0;
    return diagonal > 0.0 ? diagonal : 1.0;
}

stp_result stp_subsample_field_make(stp_context* context, const stp_subsample_unique* points,
                                    stp_subsample_field* field)
{
    size_t count = points->count;
    *field = (stp_subsample_field){.count = points->count,
                                   .positions = points->positions,
                                   .normals = points->normals,
                                   .colors = points->colors,
                                   .own = STP_NEW_ARRAY(context, stp_ellipse, count + 1),
                                   .weights = STP_NEW_ARRAY(context, uint32_t, count + 1),
                                   .margins = STP_NEW_ARRAY(context, float, count + 1),
                                   .order = STP_NEW_ARRAY(context, uint32_t, count + 1)};
    uint32_t* nearest = STP_NEW_ARRAY(context, uint32_t, NEIGHBOURS * (count + 1));
    stp_result result = STP_OK;
    if (field->own == NULL || field->weights == NULL || field->margins == NULL ||
        field->order == NULL || nearest == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK) {
        stp_psp_points given = {
            .count = points->count, .positions = points->positions, .normals = points->normals};
        result = stp_psp_make_initial(context, &given, NEIGHBOURS, field->own, nearest);
    }
    if (result == STP_OK) {
        result = make_graph(context, nearest, field);
    }
    stp_free(context, nearest);
    if (result == STP_OK && count > 0) {
        result = stp_sort_spatially(context, field->positions, field->count, field->order);
    }
    if (result == STP_OK) {
        weigh(field);
        field->diagonal = measure_diagonal(field);
    }
    return result;
}

void stp_subsample_field_destroy(stp_context* context, stp_subsample_field* field)
{
    stp_free(context, field->own);
    stp_free(context, field->starts);
    stp_free(context, field->neighbours);
    stp_free(context, field->weights);
    stp_free(context, field->margins);
    stp_free(context, field->order);
    *field = (stp_subsample_field){0};
}

/// Numbers the connected components of the graph. @return their number
static uint32_t number_parts(const stp_subsample_field* field, uint32_t* parts, uint32_t* first,
                             uint32_t* stack)
{
    uint32_t found = 0;
    memset(parts, 0xff, field->count * sizeof(*parts));
    for (uint32_t i = 0; i < field->count; ++i) {
        uint32_t start = field->order[i], size = 0;
        if (parts[start] != UINT32_MAX) {
            continue;
        }
        parts[start] = found;
        first[found] = start;
        stack[size++] = start;
        while (size > 0) {
            uint32_t point = stack[--size];
            for (uint32_t n = field->starts[point]; n < field->starts[point + 1]; ++n) {
                uint32_t next = field->neighbours[n];
                if (parts[next] == UINT32_MAX) {
                    assert(size < field->count && "each point is visited once");
                    parts[next] = found;
                    stack[size++] = next;
                }
            }
        }
        found++;
    }
    return found;
}

static stp_result add_edges(stp_context* context, stp_subsample_field* field, edge_list edges)
{
    size_t count = field->count, old = field->starts[count];
    uint32_t* starts = STP_NEW_ZEROED(context, uint32_t, count + 2);
    uint32_t* neighbours = STP_NEW_ARRAY(context, uint32_t, old + 2 * edges.count + 1);
    if (starts == NULL || neighbours == NULL) {
        stp_free(context, starts);
        stp_free(context, neighbours);
        return stp_fail_memory(context);
    }
    for (size_t e = 0; e < 2 * edges.count; ++e) {
        starts[edges.pairs[e] + 2]++;
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t degree = field->starts[i + 1] - field->starts[i];
        starts[i + 2] += starts[i + 1] + degree;
        memcpy(neighbours + starts[i + 1], field->neighbours + field->starts[i],
               degree * sizeof(*neighbours));
    }
    for (size_t i = 0; i < count; ++i) { // now the place of the next edge
        starts[i + 1] += field->starts[i + 1] - field->starts[i];
    }
    for (size_t e = 0; e < edges.count; ++e) {
        uint32_t a = edges.pairs[2 * e], b = edges.pairs[2 * e + 1];
        neighbours[starts[a + 1]++] = b;
        neighbours[starts[b + 1]++] = a;
    }
    assert(starts[count] == old + 2 * edges.count);
    stp_free(context, field->starts);
    stp_free(context, field->neighbours);
    field->starts = starts;
    field->neighbours = neighbours;
    return STP_OK;
}

/// Connects the first point of each component with those of the nearest components.
static stp_result connect_parts(stp_context* context, stp_subsample_field* field,
                                const uint32_t* first, uint32_t part_count)
{
    assert(part_count > 1);
    float* positions = STP_NEW_ARRAY(context, float, 3 * (size_t)part_count);
    uint32_t* nearest = STP_NEW_ARRAY(context, uint32_t, NEIGHBOURS * (size_t)part_count);
    uint32_t* pairs = STP_NEW_ARRAY(context, uint32_t, 2 * NEIGHBOURS * (size_t)part_count);
    stp_result result = STP_OK;
    if (positions == NULL || nearest == NULL || pairs == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK) {
        for (uint32_t i = 0; i < part_count; ++i) {
            memcpy(positions + 3 * (size_t)i, field->positions + 3 * (size_t)first[i],
                   3 * sizeof(float));
        }
        result = stp_find_nearest_points(context, positions, part_count, NEIGHBOURS, nearest);
    }
    size_t count = 0;
    for (uint32_t i = 0; result == STP_OK && i < part_count; ++i) {
        const uint32_t* near = nearest + NEIGHBOURS * (size_t)i;
        for (int k = 0; k < NEIGHBOURS && near[k] != UINT32_MAX; ++k) {
            if (i < near[k] || !lists(nearest + NEIGHBOURS * (size_t)near[k], i)) {
                pairs[2 * count] = first[i];
                pairs[2 * count + 1] = first[near[k]];
                count++;
            }
        }
    }
    if (result == STP_OK) {
        result = add_edges(context, field, (edge_list){pairs, count});
    }
    stp_free(context, positions);
    stp_free(context, nearest);
    stp_free(context, pairs);
    return result;
}

stp_result stp_subsample_field_connect(stp_context* context, stp_subsample_field* field,
                                       uint32_t* added)
{
    uint32_t* parts = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)field->count + 1);
    stp_result result = parts != NULL ? STP_OK : stp_fail_memory(context);
    uint32_t before = field->starts[field->count];
    for (int round = 0; result == STP_OK && round < ROUNDS_MAX; ++round) {
        uint32_t *first = parts + field->count, *stack = first + field->count;
        uint32_t count = number_parts(field, parts, first, stack);
        if (count < 2) {
            break;
        }
        result = connect_parts(context, field, first, count);
    }
    stp_free(context, parts);
    *added = (field->starts[field->count] - before) / 2;
    return result;
}
