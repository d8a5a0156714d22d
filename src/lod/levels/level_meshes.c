// SPDX-License-Identifier: MIT
// Chooses the clusters of a graph of levels that are stored, and makes meshes of them.
#include "capture/covered_pixels.h"
#include "capture/seen_sides.h"
#include "lod/levels/node_levels.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define DRAWN_SHARE 0.4     // of the originals: the most that the finest stored mixture draws
#define STORED_SHARE 0.4    // of the originals: the most that is stored
#define STEPS 4.0           // of the grid, at least, in the finest error
#define COVERAGE_STEP 3.0   // factor on the error between comparisons of what is covered
#define KEPT_COVERAGE 0.8   // of the pixels that finer mixtures cover, at least
#define NUMBER_LIMIT 0x1p24 // of steps, from the origin

enum { LEAST_PIXELS = 16, MOST_PIXELS = 256 }; // of pictures that are compared

/// Triangles of the coarsest mesh; each further one is as large as all before.
enum { FIRST_BLOCK = 512 };

enum { SHADINGS = 256, SLOTS = 1024, VERTICES = 256 };

/// A change of what mixtures draw, as the allowed error grows.
typedef struct event {
    double error;
    int64_t drawn, stored;
} event;

typedef struct exporter {
    stp_context* context;
    const stp_scene* scene;
    const stp_level_graph* graph;
    const uint8_t* shading_of_material;
    stp_node_levels* levels;
    double finest;   ///< least allowed error of a mixture
    double coarsest; ///< no group of a larger error is stored
    uint32_t* order; ///< stored clusters, coarse first
    uint32_t order_count;
    uint32_t* group_names;       ///< per group: its number among those that are stored
    uint32_t level_of[SHADINGS]; ///< level of the current block; STP_LEVEL_NONE: none yet
    // the cluster being made
    uint32_t vertex_count, first_vertex;
    uint16_t slots[SLOTS]; ///< hash table: 1 + vertex of the cluster
} exporter;

/// The sides of a triangle that are drawn. Of materials that are drawn from the front only, a back
/// stays a back.
static uint8_t drawn_sides(const exporter* e, uint32_t triangle)
{
    uint8_t sides = e->graph->sides[triangle];
    bool front_only = e->scene->materials[e->graph->tags[triangle]].front_only;
    return sides == STP_SEEN_BACK && front_only ? STP_SEEN_FRONT | STP_SEEN_BACK : sides;
}

static double made_error(const stp_level_graph* g, uint32_t cluster)
{
    uint32_t group = g->clusters[cluster].made_by;
    return group != STP_LEVEL_NONE ? g->groups[group].error : 0.0;
}

static double used_error(const stp_level_graph* g, uint32_t cluster)
{
    uint32_t group = g->clusters[cluster].used_by;
    return group != STP_LEVEL_NONE ? g->groups[group].error : HUGE_VAL;
}

static uint32_t count_shown(const stp_level_graph* g, uint32_t cluster)
{
    const stp_level_cluster* c = &g->clusters[cluster];
    uint32_t count = 0;
    for (uint32_t t = c->first_triangle; t < c->first_triangle + c->triangle_count; ++t) {
        count += g->sides[t] != 0 ? 1 : 0;
    }
    return count;
}

static int compare_events(const void* left, const void* right)
{
    const event *a = left, *b = right;
    return a->error < b->error ? -1 : a->error > b->error ? 1 : 0;
}

/// Finds the finest error from which on levels are stored. @return STP_OK; `*finest` is infinite if
/// they are not worth it
static stp_result find_finest(stp_context* context, const stp_level_graph* g, uint32_t triangles,
                              double* finest)
{
    event* events = STP_NEW_ARRAY(context, event, 2 * (size_t)g->cluster_count + 1);
    size_t count = 0;
    *finest = HUGE_VAL;
    if (events == NULL) {
        return stp_fail_memory(context);
    }
    int64_t drawn = 0, stored = 0;
    for (uint32_t i = 0; i < g->cluster_count; ++i) {
        int64_t shown = (int64_t)count_shown(g, i);
        stored += shown;
        events[count++] = (event){made_error(g, i), shown, 0};
        events[count++] = (event){used_error(g, i), -shown, -shown};
    }
    qsort(events, count, sizeof(*events), compare_events);
    for (size_t i = 0; i < count && events[i].error < HUGE_VAL;) {
        double error = events[i].error;
        for (; i < count && !(events[i].error > error); ++i) {
            drawn += events[i].drawn;
            stored += events[i].stored;
        }
        bool fits = (double)drawn <= DRAWN_SHARE * (double)triangles &&
                    (double)stored <= STORED_SHARE * (double)triangles;
        if (fits && error > 0.0 && error >= g->outside_error) {
            *finest = error;
            break;
        }
    }
    stp_free(context, events);
    return STP_OK;
}

/// A stored cluster, to be sorted.
typedef struct ranked {
    double used;
    uint32_t cluster;
} ranked;

// Coarse first; ties by cluster.
static int compare_ranks(const void* left, const void* right)
{
    const ranked *a = left, *b = right;
    if (a->used < b->used || a->used > b->used) {
        return a->used > b->used ? -1 : 1;
    }
    return a->cluster < b->cluster ? -1 : a->cluster > b->cluster ? 1 : 0;
}

/// Triangles of the mixture for an error; 0: the originals.
static stp_result collect_drawn(const exporter* e, double error, uint32_t** indices,
                                uint32_t* count)
{
    const stp_level_graph* g = e->graph;
    *indices = STP_NEW_ARRAY(e->context, uint32_t, 3 * (size_t)g->triangle_count + 1);
    *count = 0;
    if (*indices == NULL) {
        return stp_fail_memory(e->context);
    }
    for (uint32_t i = 0; i < g->cluster_count; ++i) {
        const stp_level_cluster* c = &g->clusters[i];
        if (!stp_level_is_drawn(g, i, error, error)) {
            continue;
        }
        memcpy(*indices + 3 * (size_t)*count, g->indices + 3 * (size_t)c->first_triangle,
               3 * sizeof(**indices) * c->triangle_count);
        *count += c->triangle_count;
    }
    return STP_OK;
}

/// Pixels that the mixture for an error covers, in pictures of a resolution.
static stp_result count_covered(const exporter* e, double error, stp_box box, uint32_t resolution,
                                uint64_t* covered)
{
    uint32_t *indices = NULL, count = 0;
    stp_result result = collect_drawn(e, error, &indices, &count);
    if (result == STP_OK) {
        result = stp_count_covered_pixels(e->context, e->graph->positions, e->graph->vertex_count,
                                          indices, count, box, resolution, covered);
    }
    stp_free(e->context, indices);
    return result;
}

/// Finds the coarsest error at which mixtures still cover what the originals do. Leaves, bars and
/// needles would vanish one by one, and all together show much.
static stp_result find_coarsest(exporter* e)
{
    const stp_level_graph* g = e->graph;
    stp_box box = stp_box_of(g->positions, g->vertex_count);
    stp_vec3 size = stp_sub(box.max, box.min);
    double side = (double)stp_max(size.x, stp_max(size.y, size.z)), error = e->finest;
    double last = 0.0;
    uint64_t reference = 0; // pixels of what the mixture is compared with
    uint32_t compared = 0;  // in pictures of this resolution
    for (uint32_t i = 0; i < g->group_count; ++i) {
        last = fmax(last, g->groups[i].error);
    }
    e->coarsest = 0.0;
    for (;; error = fmin(error * COVERAGE_STEP, last)) {
        uint64_t drawn = 0;
        double pixels = fmin(fmax(side / error, (double)LEAST_PIXELS), (double)MOST_PIXELS);
        uint32_t resolution = (uint32_t)pixels;
        stp_result result = STP_OK;
        if (resolution != compared) {
            result = count_covered(e, compared == 0 ? 0.0 : e->finest, box, resolution, &reference);
        }
        result = result == STP_OK ? count_covered(e, error, box, resolution, &drawn) : result;
        if (result != STP_OK || (double)drawn < KEPT_COVERAGE * (double)reference) {
            return result;
        }
        // the finest mixture, which comes first, is as good as the originals, and smaller
        reference = compared == 0 ? drawn : reference;
        compared = resolution;
        e->coarsest = error;
        if (error >= last) {
            e->coarsest = HUGE_VAL;
            return STP_OK;
        }
    }
}

/// A group, as numbers that fit floats.
static stp_level_group round_group(const stp_level_group* group)
{
    stp_level_group rounded = *group;
    rounded.center = stp_to_double(stp_to_float(group->center));
    rounded.radius = (double)(float)(group->radius * (1.0 + 1e-6));
    rounded.error = (double)(float)group->error;
    return rounded;
}

/// Numbers the groups that decide when stored clusters are drawn.
static void name_groups(exporter* e)
{
    const stp_level_graph* g = e->graph;
    memset(e->group_names, 0xff, g->group_count * sizeof(*e->group_names));
    for (uint32_t i = 0; i < e->order_count; ++i) {
        const stp_level_cluster* c = &g->clusters[e->order[i]];
        const uint32_t groups[2] = {c->made_by, c->used_by};
        for (int k = 0; k < 2; ++k) {
            if (groups[k] != STP_LEVEL_NONE) {
                e->group_names[groups[k]] = 0;
            }
        }
    }
    for (uint32_t i = 0; i < g->group_count; ++i) {
        bool named = e->group_names[i] != STP_LEVEL_NONE && g->groups[i].error > e->finest &&
                     g->groups[i].error <= e->coarsest;
        e->group_names[i] = named ? e->levels->group_count : STP_LEVEL_NONE;
        if (named) {
            e->levels->groups[e->levels->group_count++] = round_group(&g->groups[i]);
        }
    }
}

/// Lists the stored clusters and groups.
static stp_result choose_clusters(exporter* e)
{
    const stp_level_graph* g = e->graph;
    ranked* ranks = STP_NEW_ARRAY(e->context, ranked, (size_t)g->cluster_count + 1);
    e->order = STP_NEW_ARRAY(e->context, uint32_t, (size_t)g->cluster_count + 1);
    e->group_names = STP_NEW_ARRAY(e->context, uint32_t, (size_t)g->group_count + 1);
    e->levels->groups = STP_NEW_ARRAY(e->context, stp_level_group, (size_t)g->group_count + 1);
    if (ranks == NULL || e->order == NULL || e->group_names == NULL || e->levels->groups == NULL) {
        stp_free(e->context, ranks);
        return stp_fail_memory(e->context);
    }
    for (uint32_t i = 0; i < g->cluster_count; ++i) {
        if (used_error(g, i) > e->finest && made_error(g, i) <= e->coarsest &&
            count_shown(g, i) > 0) {
            double used = used_error(g, i);
            ranks[e->order_count++] = (ranked){used > e->coarsest ? HUGE_VAL : used, i};
        }
    }
    qsort(ranks, e->order_count, sizeof(*ranks), compare_ranks);
    for (uint32_t i = 0; i < e->order_count; ++i) {
        e->order[i] = ranks[i].cluster;
    }
    name_groups(e);
    stp_free(e->context, ranks);
    return STP_OK;
}

static uint32_t name_of(const exporter* e, uint32_t group)
{
    return group != STP_LEVEL_NONE ? e->group_names[group] : STP_LEVEL_NONE;
}

/// The level of a shading in the current block; NULL if memory runs out.
static stp_node_level* find_level(exporter* e, uint8_t shading)
{
    uint32_t* index = &e->level_of[shading];
    stp_node_levels* l = e->levels;
    if (*index == STP_LEVEL_NONE) {
        if (!STP_MAKE_ROOM(e->context, l->levels, l->level_capacity, (size_t)l->level_count + 1)) {
            return NULL;
        }
        l->levels[l->level_count] = (stp_node_level){.shading = shading};
        *index = l->level_count++;
    }
    return &l->levels[*index];
}

static stp_result begin_cluster(exporter* e, stp_node_level* level, uint32_t cluster)
{
    const stp_level_cluster* c = &e->graph->clusters[cluster];
    if (!STP_MAKE_ROOM(e->context, level->clusters, level->cluster_capacity,
                       (size_t)level->cluster_count + 1)) {
        return stp_fail_memory(e->context);
    }
    level->clusters[level->cluster_count++] =
        (stp_node_level_cluster){.end = level->triangle_count,
                                 .made_by = name_of(e, c->made_by),
                                 .used_by = name_of(e, c->used_by)};
    e->vertex_count = 0;
    e->first_vertex = level->vertex_count;
    memset(e->slots, 0, sizeof(e->slots));
    return STP_OK;
}

static uint16_t code_color(float value)
{
    return (uint16_t)(fmin(fmax((double)value, 0.0), 1.0) * 65535.0 + 0.5);
}

/// The vertex of a corner in the current cluster, added if it is new. There is room.
static uint32_t find_vertex(exporter* e, stp_node_level* level, const float* position,
                            const uint16_t color[4])
{
    uint32_t bits[3], hash = 0;
    memcpy(bits, position, sizeof(bits));
    for (int k = 0; k < 3; ++k) {
        hash = (hash ^ bits[k]) * 0x9E3779B1u;
        hash = (hash ^ hash >> 15 ^ color[k]) * 0x2C1B3C6Du;
    }
    uint32_t slot = hash >> 16 & (SLOTS - 1);
    for (; e->slots[slot] != 0; slot = (slot + 1) & (SLOTS - 1)) {
        uint32_t vertex = e->first_vertex + e->slots[slot] - 1;
        if (memcmp(level->positions + 3 * (size_t)vertex, position, 3 * sizeof(float)) == 0 &&
            memcmp(level->colors + 4 * (size_t)vertex, color, 4 * sizeof(*color)) == 0) {
            return vertex;
        }
    }
    uint32_t vertex = level->vertex_count++;
    memcpy(level->positions + 3 * (size_t)vertex, position, 3 * sizeof(float));
    memcpy(level->colors + 4 * (size_t)vertex, color, 4 * sizeof(*color));
    e->slots[slot] = (uint16_t)(++e->vertex_count);
    return vertex;
}

/// Appends a triangle of the graph to a level: a new cluster begins where the current one is full.
static stp_result add_triangle(exporter* e, stp_node_level* level, uint32_t cluster, uint32_t t,
                               bool one_sided)
{
    const stp_level_graph* g = e->graph;
    stp_node_level_cluster* c = &level->clusters[level->cluster_count - 1];
    uint32_t first = level->cluster_count > 1 ? c[-1].end : 0;
    if (level->triangle_count - first >= STP_LEVEL_CLUSTER || e->vertex_count + 3 > VERTICES) {
        stp_result result = begin_cluster(e, level, cluster);
        if (result != STP_OK) {
            return result;
        }
        c = &level->clusters[level->cluster_count - 1];
    }
    bool room = stp_make_room(e->context, &level->positions, &level->vertex_capacity,
                              (size_t)level->vertex_count + 3, 3 * sizeof(float)) &&
                stp_make_room(e->context, &level->colors, &level->color_capacity,
                              (size_t)level->vertex_count + 3, 4 * sizeof(uint16_t)) &&
                stp_make_room(e->context, &level->indices, &level->triangle_capacity,
                              (size_t)level->triangle_count + 1, 3 * sizeof(uint32_t));
    if (!room) {
        return stp_fail_memory(e->context);
    }
    const float* base = e->scene->materials[g->tags[t]].base_color;
    for (size_t k = 0; k < 3; ++k) {
        const float* position = g->positions + 3 * (size_t)g->indices[3 * (size_t)t + k];
        const float* color = g->colors != NULL ? g->colors + 9 * (size_t)t + 3 * k : base;
        const uint16_t code[4] = {code_color(color[0]), code_color(color[1]), code_color(color[2]),
                                  65535};
        // a triangle of which only the back is seen is turned around
        size_t corner = drawn_sides(e, t) == STP_SEEN_BACK ? 2 - k : k;
        level->indices[3 * (size_t)level->triangle_count + corner] =
            find_vertex(e, level, position, code);
    }
    c->end = ++level->triangle_count;
    c->one_sided += one_sided ? 1 : 0;
    return STP_OK;
}

/// Appends the triangles of a cluster that have one shading; those seen from one side come first.
static stp_result add_shading(exporter* e, uint32_t cluster, uint8_t shading)
{
    const stp_level_graph* g = e->graph;
    const stp_level_cluster* c = &g->clusters[cluster];
    stp_node_level* level = NULL;
    stp_result result = STP_OK;
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t t = c->first_triangle;
             t < c->first_triangle + c->triangle_count && result == STP_OK; ++t) {
            uint8_t sides = drawn_sides(e, t);
            bool one = sides == STP_SEEN_FRONT || sides == STP_SEEN_BACK;
            if (sides == 0 || one != (pass == 0) || e->shading_of_material[g->tags[t]] != shading) {
                continue;
            }
            if (level == NULL) {
                level = find_level(e, shading);
                result =
                    level != NULL ? begin_cluster(e, level, cluster) : stp_fail_memory(e->context);
            }
            result = result == STP_OK ? add_triangle(e, level, cluster, t, one) : result;
        }
    }
    return result;
}

static stp_result add_cluster(exporter* e, uint32_t cluster)
{
    const stp_level_graph* g = e->graph;
    const stp_level_cluster* c = &g->clusters[cluster];
    uint8_t met[SHADINGS] = {0};
    stp_result result = STP_OK;
    for (uint32_t t = c->first_triangle;
         t < c->first_triangle + c->triangle_count && result == STP_OK; ++t) {
        uint8_t shading = e->shading_of_material[g->tags[t]];
        if (g->sides[t] != 0 && met[shading] == 0) {
            met[shading] = 1;
            result = add_shading(e, cluster, shading);
        }
    }
    return result;
}

/// Makes the meshes, block by block.
static stp_result add_clusters(exporter* e)
{
    stp_result result = STP_OK;
    uint64_t total = 0, block_end = 0;
    for (uint32_t i = 0; i < e->order_count && result == STP_OK; ++i) {
        if (total >= block_end) {
            block_end = total == 0 ? FIRST_BLOCK : 2 * total;
            memset(e->level_of, 0xff, sizeof(e->level_of));
        }
        total += count_shown(e->graph, e->order[i]);
        result = add_cluster(e, e->order[i]);
    }
    return result;
}

/// The largest coordinate, without its sign.
static double find_farthest(const stp_level_graph* g)
{
    double farthest = 0.0;
    for (size_t i = 0; i < 3 * (size_t)g->vertex_count; ++i) {
        farthest = fmax(farthest, fabs((double)g->positions[i]));
    }
    return farthest;
}

/// The largest power of two up to a length.
static double choose_step(double length)
{
    int exponent;
    (void)frexp(length, &exponent);
    return ldexp(0.5, exponent);
}

stp_result stp_level_meshes_make(const stp_scene* scene, const stp_level_graph* graph,
                                 const uint8_t* shading_of_material, uint32_t triangles,
                                 double most, double least_step, stp_node_levels* levels)
{
    exporter e = {.context = scene->context,
                  .scene = scene,
                  .graph = graph,
                  .shading_of_material = shading_of_material,
                  .levels = levels};
    stp_result result = find_finest(e.context, graph, triangles, &e.finest);
    if (result != STP_OK || !(e.finest <= most)) {
        return result;
    }
    result = find_coarsest(&e);
    if (result != STP_OK || !(e.coarsest > 0.0)) {
        return result;
    }
    levels->from_outside = graph->from_outside;
    double step = fmax(e.finest / STEPS, least_step < HUGE_VAL ? least_step : 0.0);
    levels->step = choose_step(fmax(step, 2.0 * find_farthest(graph) / NUMBER_LIMIT));
    result = choose_clusters(&e);
    result = result == STP_OK ? add_clusters(&e) : result;
    stp_free(e.context, e.order);
    stp_free(e.context, e.group_names);
    return result;
}
