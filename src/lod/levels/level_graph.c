// SPDX-License-Identifier: MIT
#include "lod/levels/level_graph.h"

#include "base/core/sort.h"
#include "lod/levels/patches.h"

#include <assert.h>
#include <string.h>

enum { LEVELS_MAX = 64 };

/// A group on its way to fewer triangles.
typedef struct group_task {
    uint32_t begin, end; ///< range of `order`
    uint32_t triangle_count;
    uint32_t* indices;  ///< owned: 3 per triangle, of `vertices`
    uint32_t* tags;     ///< owned
    uint32_t* vertices; ///< owned: number in the graph of each vertex, or STP_LEVEL_NONE: it moved
    float* positions;   ///< owned: 3 per vertex
    uint32_t vertex_count;
    double error;
    bool kept; ///< it has too many triangles left: its clusters wait
} group_task;

typedef struct maker {
    stp_context* context;
    const stp_level_desc* desc;
    stp_level_graph* graph;
    uint32_t level;
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
    return (stp_level_desc){.first_error = diagonal / 4096.0,
                            .growth = 1.6,
                            .last_error = diagonal / 8.0,
                            .most_kept = 0.85,
                            .border_weight = 0.3,
                            .least_cosine = 0.2};
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

/// Items divided into patches of neighbours.
typedef struct division {
    float* centers;    ///< 3 per item; filled by the caller
    uint32_t* item_of; ///< per triangle; filled by the caller
    uint32_t* members; ///< items, patch by patch
    uint32_t* ends;    ///< of each patch in `members`
    uint32_t patch_count;
} division;

static stp_result create_division(stp_context* context, uint32_t triangles, uint32_t items,
                                  division* d)
{
    size_t count = (size_t)items + 1;
    *d = (division){.centers = STP_NEW_ARRAY(context, float, 3 * count),
                    .item_of = STP_NEW_ARRAY(context, uint32_t, (size_t)triangles + 1),
                    .members = STP_NEW_ARRAY(context, uint32_t, count),
                    .ends = STP_NEW_ARRAY(context, uint32_t, count)};
    bool good = d->centers != NULL && d->item_of != NULL && d->members != NULL && d->ends != NULL;
    return good ? STP_OK : stp_fail_memory(context);
}

static void destroy_division(stp_context* context, division* d)
{
    stp_free(context, d->centers);
    stp_free(context, d->item_of);
    stp_free(context, d->members);
    stp_free(context, d->ends);
}

/// Divides items into patches of at most `maximum`. `indices`: all their triangles, of the graph's
/// vertices.
static stp_result divide(const maker* m, const uint32_t* indices, uint32_t triangles,
                         uint32_t items, uint32_t maximum, division* d)
{
    stp_patch_links links;
    stp_result result = stp_patch_links_make(m->context, indices, triangles, m->graph->vertex_count,
                                             d->item_of, items, &links);
    if (result == STP_OK) {
        result = stp_grow_patches(m->context, &links, d->centers, items, maximum, d->members,
                                  d->ends, &d->patch_count);
    }
    stp_patch_links_destroy(m->context, &links);
    return result;
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
    bool good = stp_make_room(m->context, &g->positions, &g->vertex_capacity, (size_t)vertices,
                              3 * sizeof(float)) &&
                stp_make_room(m->context, &g->indices, &g->triangle_capacity, (size_t)triangles,
                              3 * sizeof(uint32_t)) &&
                STP_MAKE_ROOM(m->context, g->tags, g->tag_capacity, (size_t)triangles) &&
                STP_MAKE_ROOM(m->context, g->clusters, g->cluster_capacity, (size_t)clusters);
    return good ? STP_OK : stp_fail_memory(m->context);
}

/// Appends triangles of the graph's vertices as clusters of neighbours, and lists these in `next`.
static stp_result add_clusters(maker* m, const uint32_t* indices, const uint32_t* tags,
                               uint32_t count, uint32_t made_by)
{
    stp_level_graph* g = m->graph;
    division d;
    stp_result result = create_division(m->context, count, count, &d);
    for (uint32_t t = 0; t < count && result == STP_OK; ++t) {
        const uint32_t* c = indices + 3 * (size_t)t;
        stp_vec3d sum =
            stp_addd(stp_addd(vertex_of(g->positions, c[0]), vertex_of(g->positions, c[1])),
                     vertex_of(g->positions, c[2]));
        put_center(d.centers, t, stp_scaled(sum, 1.0 / 3.0));
        d.item_of[t] = t;
    }
    result = result == STP_OK ? divide(m, indices, count, count, STP_LEVEL_CLUSTER, &d) : result;
    result = result == STP_OK ? make_room(m, g->vertex_count, (uint64_t)g->triangle_count + count,
                                          (uint64_t)g->cluster_count + d.patch_count)
                              : result;
    if (result == STP_OK && !STP_MAKE_ROOM(m->context, m->next, m->next_capacity,
                                           (size_t)m->next_count + d.patch_count)) {
        result = stp_fail_memory(m->context);
    }
    for (uint32_t r = 0, t = 0; r < d.patch_count && result == STP_OK; ++r) {
        g->clusters[g->cluster_count] = (stp_level_cluster){.first_triangle = g->triangle_count,
                                                            .triangle_count = d.ends[r] - t,
                                                            .made_by = made_by,
                                                            .used_by = STP_LEVEL_NONE};
        m->next[m->next_count++] = g->cluster_count++;
        for (; t < d.ends[r]; ++t) {
            uint32_t from = d.members[t];
            memcpy(g->indices + 3 * (size_t)g->triangle_count, indices + 3 * (size_t)from,
                   3 * sizeof(*indices));
            g->tags[g->triangle_count++] = tags != NULL ? tags[from] : from;
        }
    }
    destroy_division(m->context, &d);
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
    division d;
    stp_result result = create_division(m->context, triangles, count, &d);
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
    result = result == STP_OK ? divide(m, indices, triangles, count, STP_LEVEL_GROUP, &d) : result;
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
    destroy_division(m->context, &d);
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

/// Numbers the vertices of a group from 0, ascending. `corners`: graph vertices in, own numbers out.
static stp_result number_vertices(stp_context* context, uint32_t* corners, uint32_t count,
                                  uint32_t** vertices, uint32_t* vertex_count)
{
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, (size_t)count + 1);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, (size_t)count + 1);
    *vertices = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    *vertex_count = 0;
    bool good = items != NULL && scratch != NULL && *vertices != NULL;
    if (good) {
        for (uint32_t i = 0; i < count; ++i) {
            items[i] = (uint64_t)corners[i] << 32 | i;
        }
        const uint64_t* sorted = stp_sort_u64(items, scratch, count, 32, 32);
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t vertex = (uint32_t)(sorted[i] >> 32);
            if (i == 0 || (*vertices)[*vertex_count - 1] != vertex) {
                (*vertices)[(*vertex_count)++] = vertex;
            }
            corners[(uint32_t)sorted[i]] = *vertex_count - 1;
        }
    }
    stp_free(context, items);
    stp_free(context, scratch);
    return good ? STP_OK : stp_fail_memory(context);
}

/// Copies the triangles of a group.
static stp_result gather(const maker* m, group_task* task)
{
    const stp_level_graph* g = m->graph;
    for (uint32_t i = task->begin; i < task->end; ++i) {
        task->triangle_count += g->clusters[m->order[i]].triangle_count;
    }
    size_t corners = 3 * (size_t)task->triangle_count;
    task->indices = STP_NEW_ARRAY(m->context, uint32_t, corners + 1);
    task->tags = STP_NEW_ARRAY(m->context, uint32_t, (size_t)task->triangle_count + 1);
    if (task->indices == NULL || task->tags == NULL) {
        return stp_fail_memory(m->context);
    }
    size_t next = 0;
    for (uint32_t i = task->begin; i < task->end; ++i) {
        const stp_level_cluster* c = &g->clusters[m->order[i]];
        memcpy(task->indices + 3 * next, g->indices + 3 * (size_t)c->first_triangle,
               3 * sizeof(*g->indices) * c->triangle_count);
        memcpy(task->tags + next, g->tags + c->first_triangle,
               sizeof(*g->tags) * c->triangle_count);
        next += c->triangle_count;
    }
    return number_vertices(m->context, task->indices, (uint32_t)corners, &task->vertices,
                           &task->vertex_count);
}

static stp_result simplify_group(const maker* m, group_task* task, uint32_t number)
{
    stp_result result = gather(m, task);
    if (result != STP_OK) {
        return result;
    }
    const stp_level_graph* g = m->graph;
    uint32_t before = task->triangle_count;
    uint8_t* locked = STP_NEW_ARRAY(m->context, uint8_t, (size_t)task->vertex_count + 1);
    task->positions = STP_NEW_ARRAY(m->context, float, 3 * (size_t)task->vertex_count + 1);
    if (locked == NULL || task->positions == NULL) {
        stp_free(m->context, locked);
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < task->vertex_count; ++i) {
        locked[i] = m->owners[task->vertices[i]] != number;
        memcpy(task->positions + 3 * (size_t)i, g->positions + 3 * (size_t)task->vertices[i],
               3 * sizeof(float));
    }
    stp_collapse_mesh mesh = {.vertex_count = task->vertex_count,
                              .triangle_count = before,
                              .positions = task->positions,
                              .indices = task->indices,
                              .tags = task->tags,
                              .locked = locked};
    stp_collapse_desc desc = {.triangle_target = before / 2 > 0 ? before / 2 : 1,
                              .error_limit = m->limit,
                              .border_weight = m->desc->border_weight,
                              .least_cosine = m->desc->least_cosine};
    result = stp_collapse(m->context, &mesh, &desc, &task->error);
    stp_free(m->context, locked);
    task->triangle_count = mesh.triangle_count;
    task->kept = (double)mesh.triangle_count > m->desc->most_kept * (double)before;
    for (uint32_t i = 0; i < task->vertex_count && result == STP_OK; ++i) {
        bool moved = memcmp(task->positions + 3 * (size_t)i,
                            g->positions + 3 * (size_t)task->vertices[i], 3 * sizeof(float)) != 0;
        task->vertices[i] = moved ? STP_LEVEL_NONE : task->vertices[i];
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
            group->error = fmax(group->error, below->error);
        }
    }
}

/// Appends what a group was simplified to.
static stp_result add_group(maker* m, group_task* task)
{
    stp_level_graph* g = m->graph;
    stp_level_group group = {.level = m->level};
    enclose(m, task, &group);
    // errors of collapses add up; the sum also ascends along every path
    group.error = group.error * (1.0 + 1e-9) + fmax(task->error, 1e-3 * m->limit);
    if (!STP_MAKE_ROOM(m->context, g->groups, g->group_capacity, (size_t)g->group_count + 1)) {
        return stp_fail_memory(m->context);
    }
    stp_result result =
        make_room(m, (uint64_t)g->vertex_count + task->vertex_count,
                  (uint64_t)g->triangle_count + task->triangle_count, g->cluster_count);
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < 3 * (size_t)task->triangle_count; ++i) {
        uint32_t* vertex = &task->vertices[task->indices[i]];
        if (*vertex == STP_LEVEL_NONE) {
            memcpy(g->positions + 3 * (size_t)g->vertex_count,
                   task->positions + 3 * (size_t)task->indices[i], 3 * sizeof(float));
            *vertex = g->vertex_count++;
        }
        task->indices[i] = *vertex;
    }
    uint32_t number = g->group_count++;
    g->groups[number] = group;
    for (uint32_t i = task->begin; i < task->end; ++i) {
        g->clusters[m->order[i]].used_by = number;
    }
    return add_clusters(m, task->indices, task->tags, task->triangle_count, number);
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
        stp_free(m->context, m->tasks[t].indices);
        stp_free(m->context, m->tasks[t].tags);
        stp_free(m->context, m->tasks[t].vertices);
        stp_free(m->context, m->tasks[t].positions);
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

stp_result stp_level_graph_make(stp_context* context, const stp_collapse_mesh* mesh,
                                const stp_level_desc* desc, stp_level_graph* graph)
{
    maker m = {.context = context, .desc = desc, .graph = graph};
    assert(desc->first_error > 0.0 && desc->growth > 1.0 && desc->most_kept < 1.0);
    *graph = (stp_level_graph){0};
    stp_result result = make_room(&m, mesh->vertex_count, mesh->triangle_count, 0);
    if (result == STP_OK && mesh->vertex_count > 0) {
        memcpy(graph->positions, mesh->positions, 3 * sizeof(float) * (size_t)mesh->vertex_count);
    }
    graph->vertex_count = result == STP_OK ? mesh->vertex_count : 0;
    if (result == STP_OK) {
        result = add_clusters(&m, mesh->indices, mesh->tags, mesh->triangle_count, STP_LEVEL_NONE);
    }
    m.limit = desc->first_error;
    for (m.level = 1; m.level < LEVELS_MAX && m.limit <= desc->last_error && m.next_count > 0 &&
                      result == STP_OK;
         ++m.level) {
        result = make_level(&m);
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
    stp_free(context, graph->clusters);
    stp_free(context, graph->groups);
    *graph = (stp_level_graph){0};
}
