// SPDX-License-Identifier: MIT
#include "lod/spt/spt_set.h"

#include "base/core/sort.h"
#include "base/math/morton.h"
#include "base/splats/prefix_table.h"
#include "base/splats/splat_codes.h"
#include "lod/set_columns.h"
#include "lod/spt/node_splats.h"
#include "lod/spt/sequence.h"
#include "lod/spt/split_errors.h"

#include <assert.h>
#include <string.h>

enum {
    GRAIN = 4096, ///< splats
};

#define ROUNDED 1.05f ///< a 64th of an edge at both ends, with some margin

typedef struct spt_maker {
    stp_context* context;
    const stp_splats* samples;
    stp_splats* splats;
    stp_method_samples points; ///< samples as points
    stp_point_tree tree;
    stp_point_sequence sequence;
    double max_allowed;       ///< of the sequence
    stp_node_splat* nodes;    ///< splats of the tree's nodes
    uint32_t* errors;         ///< codes of the tree's nodes; NULL: no split errors
    uint64_t *keys, *scratch; ///< key, and place in the sequence in the lower 32 bits
    const uint64_t* arranged; ///< sorted keys: `keys` or `scratch`, in the order of the splats
} spt_maker;

static stp_result make_tree(spt_maker* m, const stp_tree_desc* desc)
{
    stp_result result = stp_point_tree_make(m->context, &m->points.points, desc, &m->tree);
    m->max_allowed = 2.0 * (double)STP_LEVEL_SLOPE; // levels are half errors
    if (result == STP_OK) {
        result = stp_point_sequence_make(m->context, &m->tree, m->max_allowed,
                                         desc->error == STP_TREE_SPLIT, &m->sequence);
    }
    return result;
}

static stp_result make_nodes(spt_maker* m, const stp_spt_desc* desc)
{
    float* replaced = STP_NEW_ARRAY(m->context, float, (size_t)m->samples->count + 1);
    stp_node_splats_desc nodes = {.materials = m->samples->materials,
                                  .replaced = replaced,
                                  .origin = m->samples->origin,
                                  .step = m->samples->step};
    stp_result result = replaced != NULL
                            ? stp_spt_find_replaced(m->context, &m->points, m->samples->step,
                                                    desc->corners, desc->triangle_count, replaced)
                            : stp_fail_memory(m->context);
    if (result == STP_OK) {
        result = stp_node_splats_make(m->context, &m->tree, &m->points, &nodes, &m->nodes);
    }
    stp_free(m->context, replaced);
    if (result == STP_OK && desc->tree.error == STP_TREE_SPLIT) {
        m->errors = STP_NEW_ARRAY(m->context, uint32_t, (size_t)m->tree.count);
        if (m->errors == NULL) {
            return stp_fail_memory(m->context);
        }
        stp_split_errors_make(m->context, &m->tree, m->nodes, m->max_allowed, m->errors);
    }
    return result;
}

/// Position of a splat along a curve through the grid: the upper bits of its Morton code.
static uint32_t find_place(const uint16_t* position)
{
    return stp_morton(position[2] >> 10, position[1] >> 10, position[0] >> 10);
}

static uint32_t find_range(const spt_maker* m, size_t place)
{
    return stp_range_code(0.5f * m->sequence.lowest[place], 0.5f * m->sequence.highest[place]);
}

/// Whether triangles are drawn wherever a splat would be. Rounding may shrink them slightly.
static bool is_replaced(const spt_maker* m, const stp_node_splat* node, size_t place)
{
    return stp_range_level(find_range(m, place) >> 16) * ROUNDED < node->replaced;
}

/// Within a band between two breakpoints of the table, splats replaced by triangles come last.
/// Others are sorted by direction, then by position, so that neighbouring splats can be culled
/// together.
static void find_keys(size_t begin, size_t end, uint32_t worker, void* user)
{
    const spt_maker* m = user;
    const stp_prefix_table* table = &m->splats->table;
    uint64_t band = 0;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        while (band < table->size && i >= table->count[band]) {
            band += 1;
        }
        const stp_node_splat* node = &m->nodes[m->sequence.nodes[i]];
        uint64_t replaced = is_replaced(m, node, i) ? 1 : 0;
        assert(band < 64 && node->cluster < 128 && "bits of the key do not overlap");
        m->keys[i] = band << 58 | replaced << 57 | (uint64_t)node->cluster << 50 |
                     (uint64_t)find_place(node->position) << 32 | i;
    }
}

static stp_result arrange(spt_maker* m)
{
    size_t count = m->sequence.count;
    m->keys = STP_NEW_ARRAY(m->context, uint64_t, count + 1);
    m->scratch = STP_NEW_ARRAY(m->context, uint64_t, count + 1);
    if (m->keys != NULL && m->scratch != NULL) {
        stp_parallel_for(m->context, count, GRAIN, find_keys, m);
        m->arranged = stp_parallel_sort_u64(m->context, m->keys, m->scratch, count, 32, 32);
    }
    return m->arranged != NULL ? STP_OK : stp_fail_memory(m->context);
}

static void fill_splats(size_t begin, size_t end, uint32_t worker, void* user)
{
    const spt_maker* m = user;
    const stp_splats* s = m->splats;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t at = (uint32_t)m->arranged[i];
        assert(at < m->sequence.count);
        const stp_node_splat* node = &m->nodes[m->sequence.nodes[at]];
        memcpy(s->positions + 3 * i, node->position, sizeof(node->position));
        memcpy(s->normals + 2 * i, node->normal, sizeof(node->normal));
        memcpy(s->colors + 3 * i, node->color, sizeof(node->color));
        s->materials[i] = node->material;
        s->coverages[i] = node->coverage;
        s->shapes[i] = node->shape | (is_replaced(m, node, at) ? STP_SHAPE_REPLACED : 0u);
        s->ranges[i] = find_range(m, at);
        if (m->errors != NULL) {
            s->errors[i] = m->errors[m->sequence.nodes[at]];
        }
    }
}

static stp_result make(spt_maker* m, const stp_spt_desc* desc)
{
    stp_splats* s = m->splats;
    stp_result result = stp_method_samples_take(m->context, m->samples, desc->shadings, &m->points);
    result = result == STP_OK ? make_tree(m, &desc->tree) : result;
    result = result == STP_OK ? make_nodes(m, desc) : result;
    s->origin = m->samples->origin;
    s->step = m->samples->step;
    s->candidate_radius = m->samples->candidate_radius;
    s->count = m->sequence.count;
    result = result == STP_OK ? stp_splats_make_columns(m->context, s) : result;
    if (result == STP_OK) {
        stp_set_octaves_make(s);
        stp_set_table_make(s, m->sequence.highest, 0.5f,
                           stp_prefix_table_radius(&m->samples->table, m->samples->count));
        assert(s->table.count[s->table.size - 1] == s->count);
        result = arrange(m);
    }
    if (result == STP_OK) {
        stp_parallel_for(m->context, s->count, GRAIN, fill_splats, m);
    }
    return result;
}

stp_result stp_spt_make(stp_context* context, const stp_splats* samples, const stp_spt_desc* desc,
                        stp_splats* splats)
{
    spt_maker m = {.context = context, .samples = samples, .splats = splats};
    *splats = (stp_splats){.columns = STP_SPT_COLUMNS};
    if (desc->tree.error == STP_TREE_SPLIT) {
        splats->columns |= STP_SPLATS_ERRORS;
    }
    if (samples->count == 0) {
        return STP_OK;
    }
    stp_result result = make(&m, desc);
    stp_point_sequence_destroy(context, &m.sequence);
    stp_point_tree_destroy(context, &m.tree);
    stp_free(context, m.nodes);
    stp_free(context, m.errors);
    stp_free(context, m.keys);
    stp_free(context, m.scratch);
    stp_method_samples_destroy(context, &m.points);
    if (result != STP_OK) {
        stp_splats_destroy(context, splats);
    }
    return result;
}
