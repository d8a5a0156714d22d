// SPDX-License-Identifier: MIT
#include "lod/spt/splats.h"

#include "base/coverage.h"
#include "base/octahedral.h"
#include "base/prefix_table.h"
#include "base/sort.h"
#include "base/splat_codes.h"
#include "lod/spt/replaced.h"
#include "lod/spt/sequence.h"
#include "lod/surfels.h"

#include <string.h>

enum {
    FIRST_OCTAVE = 64, ///< splats; the next ones are four times as many
    OCTAVE_GROWTH = 4,
    FINEST_STEP = 8, ///< of the prefix table: an eighth more
};

#define ROUNDED 1.05f            ///< a 64th of an edge at both ends, and more
#define HALF_DIAGONAL 0.8660254f ///< of a cube of side 1

typedef struct spt_maker {
    stp_context* context;
    const stp_surfels* samples;
    stp_surfels* splats;
    stp_spt_samples points; ///< the samples as points
    stp_point_tree tree;
    stp_point_sequence sequence;
    double* areas;    ///< of nodes before each: the shares of leaves' disks that are drawn, summed
    uint32_t* leaves; ///< of nodes before each: leaves
    uint8_t* spreads; ///< of nodes: sines of how far leaves' normals lie from theirs (find_spread)
    float*
        replaced; ///< of nodes: the level up to which large triangles lie all around their leaves
    uint32_t* arranged; ///< places in the sequence, as the splats lie
} spt_maker;

/// Sine of the largest angle between a node's normal and those of its leaves, rounded up: STP_SHAPE_SPREAD_ANY is 1.
static uint8_t find_spread(const stp_point_tree* tree, uint32_t node)
{
    stp_vec3 normal = tree->disks[node].normal;
    float least = stp_dot(normal, normal) > 0.0f ? 1.0f : 0.0f;
    for (uint32_t i = node + 1; i < tree->ends[node] && least > 0.0f; ++i) {
        float cosine = stp_dot(normal, tree->disks[i].normal);
        least = tree->points[i] != UINT32_MAX && cosine < least ? cosine : least;
    }
    if (!(least > 0.0f)) {
        return STP_SHAPE_SPREAD_ANY;
    }
    float sine = sqrtf(fmaxf(1.0f - least * least, 0.0f)) * (float)STP_SHAPE_SPREAD_ANY + 0.999f;
    return sine < (float)STP_SHAPE_SPREAD_ANY ? (uint8_t)sine : STP_SHAPE_SPREAD_ANY;
}

static void find_spreads(size_t begin, size_t end, uint32_t worker, void* user)
{
    const spt_maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        m->spreads[i] = find_spread(&m->tree, (uint32_t)i);
    }
}

static stp_result make_tree(spt_maker* m, const stp_tree_desc* desc)
{
    stp_result result = stp_point_tree_make(m->context, &m->points.points, desc, &m->tree);
    if (result == STP_OK) { // levels are half errors
        result = stp_point_sequence_make(m->context, &m->tree, 2.0 * (double)STP_LEVEL_SLOPE,
                                         &m->sequence);
    }
    if (result != STP_OK) {
        return result;
    }
    size_t count = m->tree.count;
    m->areas = STP_NEW_ARRAY(m->context, double, count + 1);
    m->leaves = STP_NEW_ARRAY(m->context, uint32_t, count + 1);
    m->spreads = STP_NEW_ARRAY(m->context, uint8_t, count + 1);
    if (m->areas == NULL || m->leaves == NULL || m->spreads == NULL) {
        return stp_fail_memory(m->context);
    }
    stp_parallel_for(m->context, count, 1024, find_spreads, m);
    double area = 0.0;
    uint32_t leaves = 0;
    for (size_t i = 0; i <= count; ++i) {
        m->areas[i] = area;
        m->leaves[i] = leaves;
        if (i < count && m->tree.points[i] != UINT32_MAX) {
            // leaves cut at a border count as whole: a share would make holes inside the border
            area += (double)stp_coverage_share(m->points.coverages[m->tree.points[i]]) / 255.0;
            leaves += 1;
        }
    }
    return STP_OK;
}

/// Of leaves what is found of their samples; of inner nodes the least of what is below.
static stp_result find_replaced(spt_maker* m, const stp_spt_desc* desc)
{
    size_t count = m->tree.count;
    float* of_samples = STP_NEW_ARRAY(m->context, float, (size_t)m->samples->count + 1);
    m->replaced = STP_NEW_ARRAY(m->context, float, count + 1);
    bool made = of_samples != NULL && m->replaced != NULL;
    stp_result result = made
                            ? stp_spt_find_replaced(m->context, &m->points, m->samples->step,
                                                    desc->corners, desc->triangle_count, of_samples)
                            : stp_fail_memory(m->context);
    for (uint32_t i = (uint32_t)count; i-- > 0 && result == STP_OK;) {
        uint32_t point = m->tree.points[i];
        m->replaced[i] = point != UINT32_MAX ? of_samples[point] : HUGE_VALF;
        for (uint32_t c = i + 1; point == UINT32_MAX && c < m->tree.ends[i]; c = m->tree.ends[c]) {
            m->replaced[i] = fminf(m->replaced[i], m->replaced[c]);
        }
    }
    stp_free(m->context, of_samples);
    return result;
}

static uint32_t find_range(const spt_maker* m, uint32_t place)
{
    return stp_range_code(0.5f * m->sequence.lowest[place], 0.5f * m->sequence.highest[place]);
}

/// Whether triangles are drawn wherever a splat would be. Rounded, they may be a little smaller.
static bool is_replaced(const spt_maker* m, uint32_t place)
{
    float highest = stp_range_level(find_range(m, place) >> 16);
    return highest * ROUNDED < m->replaced[m->sequence.nodes[place]];
}

static stp_result make_columns(spt_maker* m)
{
    stp_surfels* s = m->splats;
    size_t count = s->count;
    s->positions = STP_NEW_ARRAY(m->context, uint16_t, 3 * count);
    s->normals = STP_NEW_ARRAY(m->context, int8_t, 2 * count);
    s->materials = STP_NEW_ARRAY(m->context, uint8_t, count);
    s->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * count);
    s->coverages = STP_NEW_ARRAY(m->context, uint8_t, count);
    s->shapes = STP_NEW_ARRAY(m->context, uint32_t, count);
    s->ranges = STP_NEW_ARRAY(m->context, uint32_t, count);
    bool made = s->positions != NULL && s->normals != NULL && s->materials != NULL &&
                s->colors != NULL && s->coverages != NULL && s->shapes != NULL && s->ranges != NULL;
    return made ? STP_OK : stp_fail_memory(m->context);
}

static uint16_t to_grid(float x, float origin, float step)
{
    float value = (x - origin) / step + 0.5f;
    return value > 0.0f ? (value < 65535.0f ? (uint16_t)value : 65535) : 0;
}

static void place_disk(const spt_maker* m, const stp_disk* disk, uint16_t position[3])
{
    const stp_surfels* s = m->splats;
    position[0] = to_grid(disk->center.x, s->origin.x, s->step);
    position[1] = to_grid(disk->center.y, s->origin.y, s->step);
    position[2] = to_grid(disk->center.z, s->origin.z, s->step);
}

/// The first leaf below a node, or itself.
static uint32_t first_leaf(const stp_point_tree* tree, uint32_t node)
{
    while (tree->points[node] == UINT32_MAX) {
        node += 1;
    }
    return node;
}

/// A leaf keeps its sample's coverage; an inner node gets the mean share of its leaves.
static uint8_t find_coverage(const spt_maker* m, uint32_t node)
{
    uint32_t point = m->tree.points[node], end = m->tree.ends[node];
    if (point != UINT32_MAX) {
        return m->points.coverages[point];
    }
    double area = m->areas[end] - m->areas[node];
    double mean = area / (double)(m->leaves[end] - m->leaves[node]);
    return mean < 254.0 / 255.0 ? stp_coverage_of_share(mean) : STP_COVERAGE_WHOLE;
}

/// Of 128 directions, the triangle of a subdivided octahedron that holds a normal (3.10): its octant, then one of sixteen.
static uint32_t find_cluster(stp_vec3 n)
{
    float x = fabsf(n.x), y = fabsf(n.y), sum = x + y + fabsf(n.z);
    uint32_t octant = (n.x < 0.0f ? 1u : 0u) | (n.y < 0.0f ? 2u : 0u) | (n.z < 0.0f ? 4u : 0u);
    float scale = sum > 0.0f ? 4.0f / sum : 0.0f;
    uint32_t a = (uint32_t)(x * scale), b = (uint32_t)(y * scale);
    a = a < 3 ? a : 3;
    b = b < 3 - a ? b : 3 - a;
    // of a row of the triangle, the upright ones and, between them, those that stand on a corner
    bool turned = x * scale - (float)a + (y * scale - (float)b) > 1.0f && a + b < 3;
    static const uint32_t rows[4] = {0, 7, 12, 15};
    return 16 * octant + rows[a] + 2 * b + (turned ? 1 : 0);
}

/// The place of a splat along a curve through the grid: the upper bits of its Morton code.
static uint32_t find_place(const uint16_t* position)
{
    uint32_t place = 0;
    for (int bit = 15; bit >= 10; --bit) {
        for (int k = 0; k < 3; ++k) {
            place = place << 1 | (position[k] >> bit & 1u);
        }
    }
    return place;
}

/// Within a band, from one breakpoint of the table to the next, those that triangles replace come last. Others lie by where
/// they face, then by where they are, so that neighbours can be left out together.
static stp_result arrange(spt_maker* m)
{
    const stp_prefix_table* table = &m->splats->table;
    size_t count = m->sequence.count;
    uint64_t* keys = STP_NEW_ARRAY(m->context, uint64_t, count + 1);
    uint64_t* scratch = STP_NEW_ARRAY(m->context, uint64_t, count + 1);
    m->arranged = STP_NEW_ARRAY(m->context, uint32_t, count + 1);
    bool made = keys != NULL && scratch != NULL && m->arranged != NULL;
    uint64_t band = 0;
    for (uint32_t i = 0; made && i < count; ++i) {
        while (band < table->size && i >= table->count[band]) {
            band += 1;
        }
        uint16_t position[3];
        const stp_disk* disk = &m->tree.disks[m->sequence.nodes[i]];
        place_disk(m, disk, position);
        uint64_t cluster = find_cluster(disk->normal);
        uint64_t replaced = is_replaced(m, i) ? 1 : 0;
        keys[i] =
            band << 58 | replaced << 57 | cluster << 50 | (uint64_t)find_place(position) << 32 | i;
    }
    if (made) {
        const uint64_t* sorted = stp_sort_u64(keys, scratch, count, 32, 32);
        for (size_t i = 0; i < count; ++i) {
            m->arranged[i] = (uint32_t)sorted[i];
        }
    }
    stp_free(m->context, keys);
    stp_free(m->context, scratch);
    return made ? STP_OK : stp_fail_memory(m->context);
}

static void fill_splats(size_t begin, size_t end, uint32_t worker, void* user)
{
    const spt_maker* m = user;
    const stp_surfels* s = m->splats;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t at = m->arranged[i], node = m->sequence.nodes[at];
        uint32_t leaf = first_leaf(&m->tree, node);
        const stp_disk* disk = &m->tree.disks[node];
        place_disk(m, disk, s->positions + 3 * i);
        bool turned = stp_dot(disk->normal, disk->normal) > 0.0f; // else as its first leaf
        stp_vec3 normal = turned ? disk->normal : m->tree.disks[leaf].normal;
        stp_octahedral_encode_many(&normal.x, 1, s->normals + 2 * i);
        s->materials[i] = m->samples->materials[m->tree.points[leaf]];
        memcpy(s->colors + 3 * i, m->tree.colors + 3 * (size_t)node, 3);
        s->coverages[i] = find_coverage(m, node);
        // centres are rounded to the grid: by half the diagonal of a cell
        float radius = disk->radius / s->step + HALF_DIAGONAL;
        s->shapes[i] = stp_shape_disk(radius, m->spreads[node], is_replaced(m, at));
        s->ranges[i] = find_range(m, at);
    }
}

/// The count of the next breakpoint: larger by one part in `part`. Octave ends are always breakpoints, because sets are loaded
/// by octaves.
static uint32_t next_count(const stp_surfels* s, uint32_t count, uint32_t part)
{
    uint64_t next = (uint64_t)count + (count / part > 1 ? count / part : 1);
    for (uint32_t k = 0; k < s->octave_count; ++k) {
        uint32_t end = s->octave_ends[k];
        next = count < end && end < next ? end : next;
    }
    return (uint32_t)next;
}

/// The finest step for which the table holds all breakpoints.
static uint32_t choose_part(const stp_surfels* s)
{
    for (uint32_t part = FINEST_STEP; part > 1; --part) {
        uint32_t steps = 1;
        for (uint32_t count = 1; count < s->count; count = next_count(s, count, part)) {
            steps += 1;
        }
        if (steps <= STP_PREFIX_TABLE_SIZE) {
            return part;
        }
    }
    return 1; // doubling: 32 steps, and the octaves'
}

/// Fills the prefix table. A prefix reaches the level of the first splat after it, rounded as ranges are.
static void make_table(spt_maker* m)
{
    stp_surfels* s = m->splats;
    stp_prefix_table* table = &s->table;
    float reach = stp_prefix_table_radius(&m->samples->table, m->samples->count);
    uint32_t part = choose_part(s);
    for (uint32_t count = 1; count < s->count; count = next_count(s, count, part)) {
        uint32_t code = stp_range_code(0.0f, 0.5f * m->sequence.highest[count]);
        float left = stp_range_level(code >> 16);
        table->count[table->size] = count;
        table->radius[table->size++] = left > reach ? left : reach;
    }
    table->count[table->size] = s->count;
    table->radius[table->size++] = reach;
}

static void make_octaves(stp_surfels* s)
{
    for (uint64_t end = FIRST_OCTAVE; end < s->count && s->octave_count + 1 < STP_OCTAVE_LIMIT;
         end *= OCTAVE_GROWTH) {
        s->octave_ends[s->octave_count++] = (uint32_t)end;
    }
    s->octave_ends[s->octave_count++] = s->count;
}

static stp_result make(spt_maker* m, const stp_spt_desc* desc)
{
    stp_surfels* s = m->splats;
    stp_result result = stp_spt_samples_take(m->context, m->samples, &m->points);
    result = result == STP_OK ? make_tree(m, &desc->tree) : result;
    result = result == STP_OK ? find_replaced(m, desc) : result;
    s->columns = STP_SPLATS_COLUMNS;
    s->origin = m->samples->origin;
    s->step = m->samples->step;
    s->candidate_radius = m->samples->candidate_radius;
    s->count = m->sequence.count;
    result = result == STP_OK ? make_columns(m) : result;
    if (result == STP_OK) {
        make_octaves(s);
        make_table(m);
        result = arrange(m);
    }
    if (result == STP_OK) {
        stp_parallel_for(m->context, s->count, 4096, fill_splats, m);
    }
    return result;
}

stp_result stp_spt_make(stp_context* context, const stp_surfels* samples, const stp_spt_desc* desc,
                        stp_surfels* splats)
{
    spt_maker m = {.context = context, .samples = samples, .splats = splats};
    *splats = (stp_surfels){.columns = STP_SPLATS_COLUMNS};
    if (samples->count == 0) {
        return STP_OK;
    }
    stp_result result = make(&m, desc);
    stp_point_sequence_destroy(context, &m.sequence);
    stp_point_tree_destroy(context, &m.tree);
    stp_free(context, m.arranged);
    stp_free(context, m.replaced);
    stp_free(context, m.spreads);
    stp_free(context, m.leaves);
    stp_free(context, m.areas);
    stp_spt_samples_destroy(context, &m.points);
    if (result != STP_OK) {
        stp_surfels_destroy(context, splats);
    }
    return result;
}
