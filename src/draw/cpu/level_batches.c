// SPDX-License-Identifier: MIT
// Draws the clusters of a level: decodes those that suit their depth in small batches. Triangles
// that are seen from one side alone are left out where that side faces away.
#include "draw/cpu/cpu.h"

#include <assert.h>

enum { BATCH_CLUSTERS = 8, BATCH_TRIANGLES = BATCH_CLUSTERS * STP_CLUSTER_TRIANGLES };

/// Triangles that face one way fill the arrays from the front, the others from the back.
typedef struct batch {
    uint32_t vertex_count, cluster_count, one_sided, two_sided;
    float positions[3 * BATCH_CLUSTERS * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * BATCH_TRIANGLES];
    uint32_t numbers[BATCH_TRIANGLES];
} batch;

/// Adds consecutive triangles, all of one or of both sides.
static void add_triangles(const uint32_t* corners, uint32_t number, uint32_t count, bool one_sided,
                          batch* b)
{
    assert(b->one_sided + b->two_sided + count <= BATCH_TRIANGLES);
    b->two_sided += one_sided ? 0 : count;
    uint32_t place = one_sided ? b->one_sided : BATCH_TRIANGLES - b->two_sided;
    b->one_sided += one_sided ? count : 0;
    memcpy(b->indices + 3 * (size_t)place, corners, 3 * (size_t)count * sizeof(*corners));
    for (uint32_t i = 0; i < count; ++i) {
        b->numbers[place + i] = number + i;
    }
}

/// Adds a cluster, unless the pyramid hides it. @return whether it does
static bool add_cluster(const stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t index,
                        uint32_t one_sided, float share, batch* b)
{
    assert(b->cluster_count < BATCH_CLUSTERS && index < item->clusters.cluster_count);
    stp_cluster cluster;
    uint32_t corners[3 * STP_CLUSTER_TRIANGLES];
    stp_clusters_get_shape(&item->clusters, index, &cluster);
    float* positions = b->positions + 3 * (size_t)b->vertex_count;
    stp_cluster_positions(&item->clusters, &cluster, positions);
    if (stp_cpu_hides_cluster(r, item, positions, cluster.vertex_count)) {
        return true;
    }
    stp_cluster_indices(&cluster, b->vertex_count, corners);
    uint32_t count = cluster.triangle_count, number = cluster.first_triangle;
    one_sided = one_sided < count ? one_sided : count;
    if (share < 1.0f) {
        for (uint32_t t = 0; t < count; ++t) {
            if (stp_draw_keeps(number + t, share)) {
                add_triangles(corners + 3 * (size_t)t, number + t, 1, t < one_sided, b);
            }
        }
    } else {
        add_triangles(corners, number, one_sided, true, b);
        add_triangles(corners + 3 * (size_t)one_sided, number + one_sided, count - one_sided, false,
                      b);
    }
    b->vertex_count += cluster.vertex_count;
    b->cluster_count += 1;
    return false;
}

static bool draw_some(const stp_cpu_renderer* r, const stp_cpu_item* item, const batch* b,
                      uint32_t first, uint32_t count, int32_t facing,
                      const stp_raster_target* target, stp_cpu_worker* worker)
{
    const stp_raster_mesh mesh = {.positions = b->positions,
                                  .vertex_count = b->vertex_count,
                                  .indices = b->indices + 3 * (size_t)first,
                                  .triangle_count = count,
                                  .numbers = b->numbers + first,
                                  .offset = {item->offset[0], item->offset[1], item->offset[2]},
                                  .facing = facing,
                                  .fragments = &worker->fragments};
    stp_cpu_count_triangles(r, item, count, worker);
    return count == 0 || stp_raster_triangles(target, 0, r->height, &item->camera.matrix,
                                              item->camera.nearness_limit, &mesh, item->first_id,
                                              &worker->scratch) == STP_OK;
}

static bool draw_batch(const stp_cpu_renderer* r, const stp_cpu_item* item, batch* b,
                       int32_t facing, const stp_raster_target* target, stp_cpu_worker* worker)
{
    bool enough = draw_some(r, item, b, 0, b->one_sided, facing, target, worker) &&
                  draw_some(r, item, b, BATCH_TRIANGLES - b->two_sided, b->two_sided,
                            stp_cpu_item_facing(r, item), target, worker);
    b->vertex_count = b->cluster_count = b->one_sided = b->two_sided = 0;
    return enough;
}

/// Whether a cluster is drawn. Notes those that the pyramid hides.
static bool is_wanted(const stp_cpu_renderer* r, const stp_cpu_item* item,
                      const stp_bounding* bounding, const stp_level_choice* choice, uint32_t index,
                      stp_cpu_cluster_range* range, float* share)
{
    uint32_t bit = 1u << (index - range->begin);
    if ((range->wanted & bit) == 0 || !stp_level_choice_draws(choice, index)) {
        return false;
    }
    stp_box box = stp_clusters_bounds(&item->clusters, index);
    *share = stp_draw_share(item->draw, stp_bounding_min_depth(bounding, box));
    if (!(*share > 0.0f) || stp_bounding_misses(bounding, box) ||
        stp_bounding_max_depth(bounding, box) < item->draw->level_from) {
        return false;
    }
    if (r->occluding != NULL && stp_cpu_hides(r, item, box)) {
        range->hidden |= bit;
        return false;
    }
    return true;
}

bool stp_cpu_draw_level(const stp_cpu_renderer* r, const stp_cpu_item* item,
                        stp_cpu_cluster_range* range, const stp_raster_target* target,
                        stp_cpu_worker* worker)
{
    assert(range->begin <= range->end && range->end - range->begin <= 32 && "one bit each");
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    batch* b = NULL;
    stp_bounding bounding = stp_cpu_bound(r, item);
    stp_level_choice choice =
        stp_level_choice_make(r->directory, item->draw, item->camera.matrix.m, item->offset);
    int32_t facing = stp_affine_front_turn(&item->draw->transform);
    bool enough = true;
    for (uint32_t i = range->begin; enough && i < range->end; ++i) {
        float share = 1.0f;
        if (!is_wanted(r, item, &bounding, &choice, i, range, &share)) {
            continue;
        }
        if (b == NULL) {
            b = stp_arena_alloc(&worker->scratch, sizeof(*b));
            enough = b != NULL;
            if (!enough) {
                break;
            }
            b->vertex_count = b->cluster_count = b->one_sided = b->two_sided = 0;
        }
        bool hidden = add_cluster(r, item, i, choice.clusters[i].one_sided, share, b);
        range->hidden |= hidden ? 1u << (i - range->begin) : 0;
        if (b->cluster_count == BATCH_CLUSTERS) {
            enough = draw_batch(r, item, b, facing, target, worker);
        }
    }
    if (enough && b != NULL) {
        enough = draw_batch(r, item, b, facing, target, worker);
    }
    assert((range->hidden & ~range->wanted) == 0 && "only wanted clusters are tested");
    stp_arena_rewind(&worker->scratch, mark);
    return enough;
}
