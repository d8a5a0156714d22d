// SPDX-License-Identifier: MIT
// Draws clusters: decodes those in view in small batches, which stay in the CPU cache.
#include "draw/cpu/triangle.h"

#include <assert.h>

enum { BATCH_CLUSTERS = 8 };

/// A batch of consecutive decoded clusters.
typedef struct batch {
    uint32_t vertex_count, triangle_count, cluster_count, first_triangle;
    uint32_t kept; ///< triangles drawn: their share keeps them
    float positions[3 * BATCH_CLUSTERS * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * BATCH_CLUSTERS * STP_CLUSTER_TRIANGLES];
} batch;

static bool draw_batch(const stp_cpu_renderer* r, const stp_cpu_item* item, const batch* b,
                       const stp_raster_target* target, stp_cpu_keep* keep, stp_cpu_worker* worker)
{
    assert(b->cluster_count <= BATCH_CLUSTERS &&
           b->vertex_count <= BATCH_CLUSTERS * STP_CLUSTER_VERTICES &&
           b->triangle_count <= BATCH_CLUSTERS * STP_CLUSTER_TRIANGLES);
    if (b->triangle_count == 0) {
        return true;
    }
    stp_cpu_count_triangles(r, item, b->kept, worker);
    const stp_raster_layer layer = stp_cpu_make_layer(r, worker);
    stp_raster_mesh mesh = {.positions = b->positions,
                            .vertex_count = b->vertex_count,
                            .indices = b->indices,
                            .triangle_count = b->triangle_count,
                            .offset = {item->offset[0], item->offset[1], item->offset[2]},
                            .facing = stp_cpu_item_facing(r, item),
                            .fragments = &worker->fragments};
    if (keep->section_mask != 0 || stp_cpu_item_needs_keep(item)) {
        keep->first_triangle = b->first_triangle;
        mesh.keep = stp_cpu_keep_fragment;
        mesh.keep_user = keep;
        mesh.layer = r->layers.stage == CPU_LAYERS_PEEL ? &layer : NULL;
    }
    return stp_raster_triangles(target, 0, r->height, &item->camera.matrix,
                                item->camera.nearness_limit, &mesh,
                                item->first_id + b->first_triangle, &worker->scratch) == STP_OK;
}

stp_bounding stp_cpu_bound(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    return stp_bounding_make(item->camera.matrix.m, item->camera.nearness_limit, item->offset,
                             r->width, r->height);
}

uint32_t stp_cpu_drop_triangles(uint32_t* indices, uint32_t first, uint32_t count, float share)
{
    uint32_t kept = count;
    for (uint32_t i = 0; share < 1.0f && i < count; ++i) {
        if (!stp_draw_keeps(first + i, share)) {
            indices[3 * i + 1] = indices[3 * i + 2] = indices[3 * i];
            kept -= 1;
        }
    }
    return kept;
}

/// Adds a cluster, unless the pyramid hides it. Leaves out one that does not continue the ids of the
/// batch: the file was overwritten. @return whether the pyramid hides it
static bool add_cluster(const stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t index,
                        float share, batch* b)
{
    assert(b->cluster_count < BATCH_CLUSTERS && index < item->clusters.cluster_count);
    stp_cluster cluster;
    stp_clusters_get_shape(&item->clusters, index, &cluster);
    if (b->cluster_count == 0) {
        b->first_triangle = cluster.first_triangle;
    } else if (cluster.first_triangle != b->first_triangle + b->triangle_count) {
        return false;
    }
    float* positions = b->positions + 3 * (size_t)b->vertex_count;
    stp_cluster_positions(&item->clusters, &cluster, positions);
    if (stp_cpu_hides_cluster(r, item, positions, cluster.vertex_count)) {
        return true;
    }
    uint32_t* indices = b->indices + 3 * (size_t)b->triangle_count;
    stp_cluster_indices(&cluster, b->vertex_count, indices);
    b->kept +=
        stp_cpu_drop_triangles(indices, cluster.first_triangle, cluster.triangle_count, share);
    b->vertex_count += cluster.vertex_count;
    b->triangle_count += cluster.triangle_count;
    b->cluster_count += 1;
    return false;
}

/// Whether any of a cluster may be visible.
static bool is_seen(const stp_cpu_renderer* r, const stp_cpu_item* item,
                    const stp_bounding* bounding, stp_box box, uint32_t bit,
                    stp_cpu_cluster_range* range)
{
    if ((range->wanted & bit) == 0 || stp_bounding_misses(bounding, box)) {
        return false;
    }
    if (r->occluding != NULL && stp_cpu_hides(r, item, box)) {
        range->hidden |= bit;
        return false;
    }
    return true;
}

bool stp_cpu_draw_clusters(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_cpu_cluster_range* range, const stp_raster_target* target,
                           stp_cpu_worker* worker)
{
    assert(range->begin <= range->end && range->end - range->begin <= 32 && "one bit each");
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    batch* b = stp_arena_alloc(&worker->scratch, sizeof(*b));
    stp_cpu_keep_memory memory = {.triangle = UINT32_MAX};
    stp_cpu_sections sections;
    stp_cpu_find_sections(r, item, &sections);
    stp_cpu_keep keep = {.renderer = r, .item = item, .memory = &memory, .sections = &sections};
    stp_bounding bounding = stp_cpu_bound(r, item);
    bool enough = b != NULL;
    for (uint32_t i = range->begin; enough && i < range->end;) {
        b->vertex_count = b->triangle_count = b->cluster_count = b->kept = 0;
        keep.section_mask = 0;
        while (i < range->end && b->cluster_count < BATCH_CLUSTERS) {
            stp_box box = stp_clusters_bounds(&item->clusters, i);
            float share = stp_draw_share(item->draw, stp_bounding_min_depth(&bounding, box));
            bool seen = share > 0.0f &&
                        !stp_cpu_sections_drop(&sections, item, box, &keep.section_mask) &&
                        is_seen(r, item, &bounding, box, 1u << (i - range->begin), range);
            bool hidden = seen && add_cluster(r, item, i, share, b);
            range->hidden |= hidden ? 1u << (i - range->begin) : 0;
            i += 1;
            if ((!seen || hidden) && b->cluster_count != 0) {
                break; // ids of a batch are consecutive
            }
        }
        enough = draw_batch(r, item, b, target, &keep, worker);
    }
    assert((range->hidden & ~range->wanted) == 0 && "only wanted clusters are tested");
    stp_arena_rewind(&worker->scratch, mark);
    return enough;
}
