// SPDX-License-Identifier: MIT
#include "lod/levels/level_graph.h"

#include "capture/seen_sides.h"
#include "lod/levels/division.h"
#include "lod/levels/simplify_group.h"

#include <assert.h>
#include <string.h>

enum {
    LEVELS_MAX = 64,
    HOPELESS_LEVEL = 3,
    VIEWS = 96, ///< from which hidden triangles are looked for
    VIEW_PIXELS_MOST = 256,
};

#define BOTH_SIDES (STP_SEEN_FRONT | STP_SEEN_BACK)
#define FIRST_SHARE 4      // the first level may have one triangle for so many
#define HIDES_BELOW 0.5    // share of the triangles that is left when hidden ones are looked for,
#define HIDES_FROM_LEVEL 3 // or the level
#define HOPELESS 0.8       // share of the triangles that is drawn in spite of the first levels
#define HIDDEN_SHARE 0.25  // sides that must be hidden, so that it pays

/// A group on its way to fewer triangles.
typedef struct group_task {
    uint32_t begin, end; ///< range of `order`
    stp_group_mesh mesh;
    uint32_t before;       ///< triangles before
    double error;          ///< of its collapses
    double look;           ///< of the change of colours and normals, as an error
    bool kept;             ///< it has too many triangles left: its clusters wait
    stp_division clusters; ///< of what is left
} group_task;

typedef struct maker {
    stp_context* context;
    const stp_level_source* source;
    const stp_level_desc* desc;
    stp_level_graph* graph;
    uint32_t level;
    bool hidden;       ///< hidden triangles were looked for
    double limit;      ///< error of a collapse at this level
    uint32_t* current; ///< clusters to be grouped
    uint32_t current_count;
    size_t current_capacity;
    uint32_t* next; ///< clusters of the next level
    uint32_t next_count;
    size_t next_capacity;
    uint32_t* order;  ///< current clusters, group by group
    uint32_t* owners; ///< per vertex: the group that uses it; the count of groups: several
    group_task* tasks;
    uint32_t task_count;
    stp_result* results; ///< per task
} maker;

stp_level_desc stp_level_defaults(double diagonal)
{
    return (stp_level_desc){.first_error = diagonal / 1500.0,
                            .growth = 1.8,
                            .last_error = diagonal / 8.0,
                            .most_kept = 0.85,
                            .border_weight = 0.3,
                            .least_cosine = 0.2,
                            .color_weight = 1.0,
                            .normal_weight = 0.1,
                            .useful_error = diagonal / 48.0,
                            .hides = true};
}

static stp_vec3d vertex_of(const float* positions, uint32_t vertex)
{
    const float* p = positions + 3 * (size_t)vertex;
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

static void put_center(float* centers, uint32_t item, stp_vec3d center)
{
    stp_vec3 c = stp_to_float(center);
    memcpy(centers + 3 * (size_t)item, &c, sizeof(c));
}

/// Makes room in the graph. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
static stp_result make_room(maker* m, uint64_t vertices, uint64_t triangles, uint64_t clusters)
{
    stp_level_graph* g = m->graph;
    if (vertices > INT32_MAX || 3 * triangles > INT32_MAX) {
        return stp_fail(m->context, STP_ERROR_LIMIT,
                        "the levels of a mesh have %llu triangles, expected at most %d",
                        (unsigned long long)triangles, INT32_MAX / 3);
    }
    bool good =
        stp_make_room(m->context, &g->positions, &g->vertex_capacity, (size_t)vertices,
                      3 * sizeof(float)) &&
        stp_make_room(m->context, &g->indices, &g->triangle_capacity, (size_t)triangles,
                      3 * sizeof(uint32_t)) &&
        STP_MAKE_ROOM(m->context, g->tags, g->tag_capacity, (size_t)triangles) &&
        STP_MAKE_ROOM(m->context, g->sides, g->side_capacity, (size_t)triangles) &&
        stp_make_room(m->context, &g->spreads, &g->spread_capacity, (size_t)triangles,
                      2 * sizeof(float)) &&
        (m->source->colors == NULL || stp_make_room(m->context, &g->colors, &g->color_capacity,
                                                    (size_t)triangles, 9 * sizeof(float))) &&
        STP_MAKE_ROOM(m->context, g->clusters, g->cluster_capacity, (size_t)clusters);
    return good ? STP_OK : stp_fail_memory(m->context);
}

/// Appends triangle `t` of a mesh, for which there is room.
static void add_triangle(stp_level_graph* g, const stp_group_mesh* from, uint32_t t)
{
    size_t to = g->triangle_count++;
    memcpy(g->indices + 3 * to, from->indices + 3 * (size_t)t, 3 * sizeof(*g->indices));
    g->tags[to] = from->tags != NULL ? from->tags[t] : t;
    g->sides[to] = from->sides != NULL ? from->sides[t] : BOTH_SIDES;
    for (size_t k = 0; k < 2; ++k) {
        g->spreads[2 * to + k] = from->spreads != NULL ? from->spreads[2 * (size_t)t + k] : 0.0f;
    }
    if (g->colors != NULL) {
        memcpy(g->colors + 9 * to, from->colors + 9 * (size_t)t, 9 * sizeof(*g->colors));
    }
}

/// Appends triangles of the graph's vertices as clusters, and lists these in `next`. `d`: clusters
/// of these triangles.
static stp_result add_clusters(maker* m, const stp_group_mesh* from, const stp_division* d,
                               uint32_t made_by)
{
    stp_level_graph* g = m->graph;
    stp_result result =
        make_room(m, g->vertex_count, (uint64_t)g->triangle_count + from->triangle_count,
                  (uint64_t)g->cluster_count + d->patch_count);
    if (result == STP_OK && !STP_MAKE_ROOM(m->context, m->next, m->next_capacity,
                                           (size_t)m->next_count + d->patch_count)) {
        result = stp_fail_memory(m->context);
    }
    for (uint32_t r = 0, t = 0; r < d->patch_count && result == STP_OK; ++r) {
        g->clusters[g->cluster_count] = (stp_level_cluster){.first_triangle = g->triangle_count,
                                                            .triangle_count = d->ends[r] - t,
                                                            .made_by = made_by,
                                                            .used_by = STP_LEVEL_NONE};
        m->next[m->next_count++] = g->cluster_count++;
        for (; t < d->ends[r]; ++t) {
            add_triangle(g, from, d->members[t]);
        }
    }
    return result;
}

static stp_vec3d middle_of(const stp_level_graph* g, uint32_t cluster)
{
    const stp_level_cluster* c = &g->clusters[cluster];
    stp_boxd box = stp_boxd_empty();
    for (size_t i = 3 * (size_t)c->first_triangle;
         i < 3 * (size_t)(c->first_triangle + c->triangle_count); ++i) {
        stp_boxd_add(&box, vertex_of(g->positions, g->indices[i]));
    }
    return stp_scaled(stp_addd(box.min, box.max), 0.5);
}

/// Groups the current clusters: `order` and the ranges of `tasks`.
static stp_result group_clusters(maker* m)
{
    const stp_level_graph* g = m->graph;
    uint32_t count = m->current_count, triangles = 0;
    for (uint32_t i = 0; i < count; ++i) {
        triangles += g->clusters[m->current[i]].triangle_count;
    }
    stp_division d;
    stp_result result = stp_division_create(m->context, triangles, count, &d);
    uint32_t* indices = STP_NEW_ARRAY(m->context, uint32_t, 3 * (size_t)triangles + 1);
    m->order = STP_NEW_ARRAY(m->context, uint32_t, (size_t)count + 1);
    if (result == STP_OK && (indices == NULL || m->order == NULL)) {
        result = stp_fail_memory(m->context);
    }
    for (uint32_t i = 0, next = 0; i < count && result == STP_OK; ++i) {
        const stp_level_cluster* c = &g->clusters[m->current[i]];
        put_center(d.centers, i, middle_of(g, m->current[i]));
        memcpy(indices + 3 * (size_t)next, g->indices + 3 * (size_t)c->first_triangle,
               3 * sizeof(*indices) * c->triangle_count);
        for (uint32_t t = 0; t < c->triangle_count; ++t) {
            d.item_of[next++] = i;
        }
    }
    result = result == STP_OK ? stp_divide(m->context, indices, triangles, g->vertex_count, count,
                                           STP_LEVEL_GROUP, &d)
                              : result;
    if (result == STP_OK) {
        m->tasks = STP_NEW_ZEROED(m->context, group_task, (size_t)d.patch_count + 1);
        m->results = STP_NEW_ZEROED(m->context, stp_result, (size_t)d.patch_count + 1);
        m->task_count = d.patch_count;
        result = m->tasks != NULL && m->results != NULL ? STP_OK : stp_fail_memory(m->context);
    }
    for (uint32_t t = 0, i = 0; t < d.patch_count && result == STP_OK; ++t) {
        m->tasks[t].begin = i;
        m->tasks[t].end = d.ends[t];
        for (; i < d.ends[t]; ++i) {
            m->order[i] = m->current[d.members[i]];
        }
    }
    stp_free(m->context, indices);
    stp_division_destroy(m->context, &d);
    return result;
}

/// Notes which group uses each vertex, to lock those that several use.
static stp_result find_owners(maker* m)
{
    const stp_level_graph* g = m->graph;
    m->owners = STP_NEW_ARRAY(m->context, uint32_t, (size_t)g->vertex_count + 1);
    if (m->owners == NULL) {
        return stp_fail_memory(m->context);
    }
    memset(m->owners, 0xff, g->vertex_count * sizeof(*m->owners));
    for (uint32_t t = 0; t < m->task_count; ++t) {
        for (uint32_t i = m->tasks[t].begin; i < m->tasks[t].end; ++i) {
            const stp_level_cluster* c = &g->clusters[m->order[i]];
            for (size_t k = 0; k < 3 * (size_t)c->triangle_count; ++k) {
                uint32_t* owner = &m->owners[g->indices[3 * (size_t)c->first_triangle + k]];
                *owner = *owner == UINT32_MAX || *owner == t ? t : m->task_count;
            }
        }
    }
    return STP_OK;
}

/// Whether a triangle can be seen, or nobody knows.
static bool is_shown(const stp_level_graph* g, uint32_t triangle)
{
    return g->sides[triangle] != 0;
}

/// Copies the visible triangles of a group.
static stp_result gather(const maker* m, group_task* task, uint32_t number)
{
    const stp_level_graph* g = m->graph;
    stp_group_mesh* to = &task->mesh;
    uint32_t count = 0;
    for (uint32_t i = task->begin; i < task->end; ++i) {
        const stp_level_cluster* c = &g->clusters[m->order[i]];
        task->before += c->triangle_count;
        for (uint32_t t = c->first_triangle; t < c->first_triangle + c->triangle_count; ++t) {
            count += is_shown(g, t) ? 1 : 0;
        }
    }
    stp_result result = stp_group_create(m->context, count, g->colors != NULL, to);
    size_t next = 0;
    for (uint32_t i = task->begin; i < task->end && result == STP_OK; ++i) {
        const stp_level_cluster* c = &g->clusters[m->order[i]];
        for (uint32_t t = c->first_triangle; t < c->first_triangle + c->triangle_count; ++t) {
            if (!is_shown(g, t)) {
                continue;
            }
            memcpy(to->indices + 3 * next, g->indices + 3 * (size_t)t, 3 * sizeof(*g->indices));
            to->tags[next] = g->tags[t];
            to->sides[next] = g->sides[t];
            memcpy(to->spreads + 2 * next, g->spreads + 2 * (size_t)t, 2 * sizeof(float));
            if (g->colors != NULL) {
                memcpy(to->colors + 9 * next, g->colors + 9 * (size_t)t, 9 * sizeof(float));
            }
            next += 1;
        }
    }
    to->keeps_tags = m->source->tags != NULL;
    result = result == STP_OK ? stp_group_number(m->context, to) : result;
    for (uint32_t i = 0; i < to->vertex_count && result == STP_OK; ++i) {
        uint32_t vertex = to->vertices[i];
        bool fixed = m->source->locked != NULL && vertex < m->source->vertex_count &&
                     m->source->locked[vertex] != 0;
        to->locked[i] = fixed || m->owners[vertex] != number;
        memcpy(to->positions + 3 * (size_t)i, g->positions + 3 * (size_t)vertex, 3 * sizeof(float));
    }
    return result;
}

static stp_result simplify_group(const maker* m, group_task* task, uint32_t number)
{
    stp_result result = gather(m, task, number);
    if (result != STP_OK) {
        return result;
    }
    uint32_t target = task->mesh.triangle_count / (m->level == 1 ? FIRST_SHARE : 2);
    const stp_collapse_desc desc = {.triangle_target = target > 0 ? target : 1,
                                    .error_limit = m->limit,
                                    .border_weight = m->desc->border_weight,
                                    .least_cosine = m->desc->least_cosine};
    double spreads[2], size;
    result = stp_group_simplify(m->context, &desc, &task->mesh, &task->error, spreads, &size);
    if (result == STP_OK) {
        task->look = size * (m->desc->color_weight * sqrt(spreads[0]) +
                             m->desc->normal_weight * sqrt(spreads[1]));
    }
    task->kept = (double)task->mesh.triangle_count > m->desc->most_kept * (double)task->before;
    if (result == STP_OK && !task->kept) {
        result = stp_divide_triangles(m->context, task->mesh.positions, task->mesh.vertex_count,
                                      task->mesh.indices, task->mesh.triangle_count,
                                      STP_LEVEL_CLUSTER, &task->clusters);
    }
    return result;
}

static void simplify_groups(size_t begin, size_t end, uint32_t worker, void* user)
{
    maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        m->results[i] = simplify_group(m, &m->tasks[i], (uint32_t)i);
    }
}

/// A sphere around the clusters of a group and the spheres of the groups that made them.
static void enclose(const maker* m, const group_task* task, stp_level_group* group)
{
    const stp_level_graph* g = m->graph;
    stp_boxd box = stp_boxd_empty();
    for (uint32_t i = task->begin; i < task->end; ++i) {
        const stp_level_cluster* c = &g->clusters[m->order[i]];
        for (size_t k = 3 * (size_t)c->first_triangle;
             k < 3 * (size_t)(c->first_triangle + c->triangle_count); ++k) {
            stp_boxd_add(&box, vertex_of(g->positions, g->indices[k]));
        }
    }
    group->center = stp_scaled(stp_addd(box.min, box.max), 0.5);
    group->radius = 0.5 * stp_lengthd(stp_subd(box.max, box.min));
    for (uint32_t i = task->begin; i < task->end; ++i) {
        uint32_t made_by = g->clusters[m->order[i]].made_by;
        if (made_by != STP_LEVEL_NONE) {
            const stp_level_group* below = &g->groups[made_by];
            double reach = stp_lengthd(stp_subd(below->center, group->center)) + below->radius;
            group->radius = fmax(group->radius, reach * (1.0 + 1e-12));
            group->moved = fmax(group->moved, below->moved);
            group->look = fmax(group->look, below->look);
        }
    }
}

/// Appends what a group was simplified to.
static stp_result add_group(maker* m, group_task* task)
{
    stp_level_graph* g = m->graph;
    stp_level_group group = {.level = m->level};
    enclose(m, task, &group);
    // errors of collapses add up; so all ascend along every path
    group.moved = group.moved * (1.0 + 1e-9) + fmax(task->error, 1e-3 * m->limit);
    group.look = fmax(group.look, task->look);
    group.error = group.moved + group.look;
    if (!STP_MAKE_ROOM(m->context, g->groups, g->group_capacity, (size_t)g->group_count + 1)) {
        return stp_fail_memory(m->context);
    }
    stp_group_mesh* mesh = &task->mesh;
    stp_result result =
        make_room(m, (uint64_t)g->vertex_count + mesh->vertex_count,
                  (uint64_t)g->triangle_count + mesh->triangle_count, g->cluster_count);
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i) {
        uint32_t* vertex = &mesh->vertices[mesh->indices[i]];
        if (*vertex == UINT32_MAX) {
            memcpy(g->positions + 3 * (size_t)g->vertex_count,
                   mesh->positions + 3 * (size_t)mesh->indices[i], 3 * sizeof(float));
            *vertex = g->vertex_count++;
        }
        mesh->indices[i] = *vertex;
    }
    uint32_t number = g->group_count++;
    g->groups[number] = group;
    for (uint32_t i = task->begin; i < task->end; ++i) {
        g->clusters[m->order[i]].used_by = number;
    }
    return add_clusters(m, mesh, &task->clusters, number);
}

/// Puts the clusters of a group off to the next level.
static stp_result wait_for_next(maker* m, const group_task* task)
{
    uint32_t count = task->end - task->begin;
    if (!STP_MAKE_ROOM(m->context, m->next, m->next_capacity, (size_t)m->next_count + count)) {
        return stp_fail_memory(m->context);
    }
    memcpy(m->next + m->next_count, m->order + task->begin, count * sizeof(*m->next));
    m->next_count += count;
    return STP_OK;
}

static void end_level(maker* m)
{
    for (uint32_t t = 0; t < m->task_count && m->tasks != NULL; ++t) {
        stp_group_destroy(m->context, &m->tasks[t].mesh);
        stp_division_destroy(m->context, &m->tasks[t].clusters);
    }
    stp_free(m->context, m->tasks);
    stp_free(m->context, m->results);
    stp_free(m->context, m->owners);
    stp_free(m->context, m->order);
    m->tasks = NULL;
    m->results = NULL;
    m->owners = m->order = NULL;
    m->task_count = 0;
}

/// Groups the clusters in `next` and simplifies each group.
static stp_result make_level(maker* m)
{
    uint32_t* before = m->current;
    size_t capacity = m->current_capacity;
    m->current = m->next;
    m->current_count = m->next_count;
    m->current_capacity = m->next_capacity;
    m->next = before;
    m->next_count = 0;
    m->next_capacity = capacity;
    stp_result result = group_clusters(m);
    result = result == STP_OK ? find_owners(m) : result;
    if (result == STP_OK) {
        stp_parallel_for(m->context, m->task_count, 1, simplify_groups, m);
    }
    for (uint32_t t = 0; t < m->task_count && result == STP_OK; ++t) {
        result = m->results[t];
        if (result == STP_OK) {
            result = m->tasks[t].kept ? wait_for_next(m, &m->tasks[t]) : add_group(m, &m->tasks[t]);
        }
    }
    end_level(m);
    return result;
}

/// Pixels of a picture in which triangles are looked for: some for each.
static uint32_t choose_pixels(uint32_t triangles)
{
    uint32_t pixels = (uint32_t)(4.0 * sqrt((double)triangles));
    return pixels < VIEW_PIXELS_MOST ? pixels + 1 : VIEW_PIXELS_MOST;
}

/// Looks for triangles that cannot be seen from outside, among those that are left.
static stp_result hide(maker* m)
{
    stp_level_graph* g = m->graph;
    uint32_t count = 0, hidden = 0;
    for (uint32_t i = 0; i < m->next_count; ++i) {
        count += g->clusters[m->next[i]].triangle_count;
    }
    m->hidden = true;
    uint32_t* indices = STP_NEW_ARRAY(m->context, uint32_t, 3 * (size_t)count + 1);
    uint8_t* sides = STP_NEW_ZEROED(m->context, uint8_t, (size_t)count + 1);
    const uint8_t* of_tags = m->source->front_only;
    uint8_t* front_only =
        of_tags != NULL ? STP_NEW_ARRAY(m->context, uint8_t, (size_t)count + 1) : NULL;
    bool enough = indices != NULL && sides != NULL && (of_tags == NULL || front_only != NULL);
    stp_result result = enough ? STP_OK : stp_fail_memory(m->context);
    for (uint32_t i = 0, at = 0; i < m->next_count && result == STP_OK; ++i) {
        const stp_level_cluster* c = &g->clusters[m->next[i]];
        memcpy(indices + 3 * (size_t)at, g->indices + 3 * (size_t)c->first_triangle,
               3 * sizeof(*indices) * c->triangle_count);
        for (uint32_t t = 0; t < c->triangle_count && of_tags != NULL; ++t) {
            front_only[at + t] = of_tags[g->tags[c->first_triangle + t]];
        }
        at += c->triangle_count;
    }
    if (result == STP_OK) {
        result =
            stp_find_seen_sides(m->context, g->positions, g->vertex_count, indices, count,
                                &(stp_seen_desc){VIEWS, choose_pixels(count), front_only}, sides);
    }
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        hidden += (sides[i] & STP_SEEN_FRONT) == 0 ? 1 : 0;
        hidden += (sides[i] & STP_SEEN_BACK) == 0 ? 1 : 0;
    }
    g->from_outside = (double)hidden > HIDDEN_SHARE * 2.0 * (double)count;
    for (uint32_t i = 0, at = 0; i < m->next_count && result == STP_OK && g->from_outside; ++i) {
        const stp_level_cluster* c = &g->clusters[m->next[i]];
        memcpy(g->sides + c->first_triangle, sides + at, c->triangle_count);
        at += c->triangle_count;
    }
    for (uint32_t i = 0; i < g->group_count; ++i) {
        g->outside_error = fmax(g->outside_error, g->groups[i].error);
    }
    stp_free(m->context, front_only);
    stp_free(m->context, sides);
    stp_free(m->context, indices);
    return result;
}

/// Whether the levels so far do so little that more are not worth it.
static bool is_hopeless(const maker* m)
{
    const stp_level_graph* g = m->graph;
    uint64_t drawn = 0;
    for (uint32_t i = 0; i < g->cluster_count; ++i) {
        bool is = stp_level_is_drawn(g, i, m->desc->useful_error, m->desc->useful_error);
        drawn += is ? g->clusters[i].triangle_count : 0;
    }
    return (double)drawn > HOPELESS * (double)m->source->triangle_count;
}

/// Whether it is time to look for hidden triangles.
static bool should_hide(const maker* m)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < m->next_count; ++i) {
        count += m->graph->clusters[m->next[i]].triangle_count;
    }
    return m->desc->hides && !m->hidden && count > 0 &&
           (m->level >= HIDES_FROM_LEVEL ||
            (double)count <= HIDES_BELOW * (double)m->source->triangle_count);
}

/// Copies the originals into the graph, as clusters.
static stp_result add_originals(maker* m)
{
    const stp_level_source* source = m->source;
    stp_level_graph* g = m->graph;
    // levels have about as many vertices and triangles as the originals
    stp_result result =
        make_room(m, 2 * (uint64_t)source->vertex_count, 2 * (uint64_t)source->triangle_count, 0);
    if (result != STP_OK || source->vertex_count == 0) {
        return result;
    }
    memcpy(g->positions, source->positions, 3 * sizeof(float) * (size_t)source->vertex_count);
    g->vertex_count = source->vertex_count;
    // read only: the arrays of a group are its own
    const stp_group_mesh all = {.triangle_count = source->triangle_count,
                                .indices = (uint32_t*)(uintptr_t)source->indices,
                                .tags = (uint32_t*)(uintptr_t)source->tags,
                                .colors = (float*)(uintptr_t)source->colors,
                                .spreads = (float*)(uintptr_t)source->spreads};
    stp_division clusters;
    result =
        stp_divide_triangles(m->context, source->positions, source->vertex_count, source->indices,
                             source->triangle_count, STP_LEVEL_CLUSTER, &clusters);
    result = result == STP_OK ? add_clusters(m, &all, &clusters, STP_LEVEL_NONE) : result;
    stp_division_destroy(m->context, &clusters);
    return result;
}

stp_result stp_level_graph_make(stp_context* context, const stp_level_source* source,
                                const stp_level_desc* desc, stp_level_graph* graph)
{
    maker m = {.context = context, .source = source, .desc = desc, .graph = graph};
    assert(desc->first_error > 0.0 && desc->growth > 1.0 && desc->most_kept < 1.0);
    *graph = (stp_level_graph){0};
    stp_result result = add_originals(&m);
    m.limit = desc->first_error;
    for (m.level = 1; m.level < LEVELS_MAX && m.limit <= desc->last_error && m.next_count > 0 &&
                      result == STP_OK;
         ++m.level) {
        result = make_level(&m);
        if (result == STP_OK && m.level == HOPELESS_LEVEL && is_hopeless(&m)) {
            break;
        }
        if (result == STP_OK && should_hide(&m)) {
            result = hide(&m);
        }
        m.limit *= desc->growth;
    }
    stp_free(context, m.current);
    stp_free(context, m.next);
    return result;
}

void stp_level_graph_destroy(stp_context* context, stp_level_graph* graph)
{
    stp_free(context, graph->positions);
    stp_free(context, graph->indices);
    stp_free(context, graph->tags);
    stp_free(context, graph->sides);
    stp_free(context, graph->colors);
    stp_free(context, graph->spreads);
    stp_free(context, graph->clusters);
    stp_free(context, graph->groups);
    *graph = (stp_level_graph){0};
}
