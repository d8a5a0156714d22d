// SPDX-License-Identifier: MIT
// Large triangles drawn beside the splats of their node (Dachsbacher et al. 2003, 3.8).
#include "draw/cpu/cpu.h"

#include <assert.h>

enum { BATCH_TRIANGLES = 256 };

bool stp_cpu_leaves_out_splats(const stp_cpu_item* item)
{
    bool any = false;
    uint32_t groups = (item->count + STP_GROUP_SPLATS - 1) / STP_GROUP_SPLATS;
    for (uint32_t i = 0; i < groups && item->splats.groups != NULL && !any; ++i) {
        any = item->splats.groups[i].replaced != 0;
    }
    return any && item->draw->beside_triangles;
}

stp_result stp_cpu_find_large(stp_cpu_renderer* r, stp_cpu_item* item)
{
    const stp_draw_item* draw = item->draw;
    stp_result result =
        stp_store_get_large_triangles(r->store, draw->index, draw->large_min, &item->large);
    item->unit_count = 0;
    item->task_units = CPU_TASK_TRIANGLES;
    if (result == STP_OK) {
        item->unit_count = stp_large_triangles_find(&item->large, draw->large_from);
        r->large_count += item->unit_count;
    }
    return result;
}

/// A batch of large triangles.
typedef struct batch {
    uint32_t count;
    float positions[9 * BATCH_TRIANGLES];
    uint32_t indices[3 * BATCH_TRIANGLES];
    uint32_t numbers[BATCH_TRIANGLES];
} batch;

/// Whether a triangle is drawn, by the depth of its nearest corner.
static bool is_wanted(const stp_cpu_item* item, const float corners[9], float level)
{
    const float* w = item->camera.matrix.m[3];
    float nearest = FLT_MAX, from = item->draw->switch_begin;
    for (int k = 0; k < 3; ++k) {
        const float* p = corners + 3 * k;
        nearest =
            stp_min(nearest, w[0] * (p[0] - item->offset[0]) + w[1] * (p[1] - item->offset[1]) +
                                 w[2] * (p[2] - item->offset[2]) + w[3]);
    }
    return (!(from > 0.0f) || nearest >= from) &&
           level >= stp_max(item->draw->level_per_depth * nearest, item->draw->level_min);
}

static bool draw_batch(const stp_cpu_renderer* r, const stp_cpu_item* item, batch* b,
                       const stp_raster_target* target, stp_cpu_worker* worker)
{
    assert(b->count > 0 && b->count <= BATCH_TRIANGLES);
    const stp_raster_mesh mesh = {.positions = b->positions,
                                  .vertex_count = 3 * b->count,
                                  .indices = b->indices,
                                  .triangle_count = b->count,
                                  .numbers = b->numbers,
                                  .offset = {item->offset[0], item->offset[1], item->offset[2]},
                                  .facing = stp_cpu_item_facing(r, item),
                                  .fragments = &worker->fragments};
    stp_cpu_count_triangles(r, item, b->count, worker);
    b->count = 0;
    return stp_raster_triangles(target, 0, r->height, &item->camera.matrix,
                                item->camera.nearness_limit, &mesh, item->first_id,
                                &worker->scratch) == STP_OK;
}

/// Adds a triangle if it is drawn.
static void add_triangle(const stp_cpu_item* item, const stp_cluster* cluster, uint32_t triangle,
                         float level, batch* b)
{
    assert(b->count < BATCH_TRIANGLES && "a full batch is drawn first");
    assert(triangle - cluster->first_triangle < cluster->triangle_count);
    uint32_t corner[3];
    float* corners = b->positions + 9 * (size_t)b->count;
    stp_cluster_corners(cluster, triangle - cluster->first_triangle, corner);
    for (int k = 0; k < 3; ++k) {
        stp_vec3 p = stp_cluster_position(&item->clusters, cluster, corner[k]);
        corners[3 * k] = p.x;
        corners[3 * k + 1] = p.y;
        corners[3 * k + 2] = p.z;
    }
    if (is_wanted(item, corners, level)) {
        b->numbers[b->count++] = triangle;
    }
}

bool stp_cpu_draw_large(const stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t begin,
                        uint32_t end, const stp_raster_target* target, stp_cpu_worker* worker)
{
    assert(begin <= end && end <= item->unit_count);
    stp_cluster cluster = {.triangle_count = 0};
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    batch* b = stp_arena_alloc(&worker->scratch, sizeof(*b));
    bool enough = b != NULL;
    for (uint32_t i = 0; enough && i < 3 * BATCH_TRIANGLES; ++i) {
        b->indices[i] = i;
    }
    if (enough) {
        b->count = 0;
    }
    for (uint32_t i = begin; i < end && enough; ++i) {
        uint32_t triangle = item->large.triangles[i];
        if (triangle - cluster.first_triangle >= cluster.triangle_count) {
            stp_clusters_get(&item->clusters, stp_clusters_find(&item->clusters, triangle),
                             &cluster);
        }
        if (triangle - cluster.first_triangle <
            cluster.triangle_count) { // otherwise the file has changed
            add_triangle(item, &cluster, triangle, item->large.levels[i], b);
        }
        if (b->count == BATCH_TRIANGLES) {
            enough = draw_batch(r, item, b, target, worker);
        }
    }
    enough = enough && (b->count == 0 || draw_batch(r, item, b, target, worker));
    stp_arena_rewind(&worker->scratch, mark);
    return enough;
}
