// SPDX-License-Identifier: MIT
// Clusters drawn: those in view are decoded, a few at a time, into memory that stays in the processor's cache.
#include "draw/cpu/cpu.h"

enum { BATCH_CLUSTERS = 8 };

/// Neighbouring clusters, decoded.
typedef struct batch {
    uint32_t vertex_count, triangle_count, cluster_count, first_triangle;
    float positions[3 * BATCH_CLUSTERS * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * BATCH_CLUSTERS * STP_CLUSTER_TRIANGLES];
} batch;

/// Planes that bound what is seen: a point p with a.p + b < 0 is not.
typedef struct bounding_planes {
    double a[5][3], b[5];
} bounding_planes;

/// The sides of the picture, one pixel further out, and the near plane.
static bounding_planes make_planes(const cpu_renderer* r, const cpu_item* item)
{
    const stp_raster_camera* camera = &item->camera;
    bounding_planes planes;
    double width = (double)r->width + 1.0, height = (double)r->height + 1.0;
    for (int c = 0; c < 4; ++c) {
        double x = (double)camera->matrix.m[0][c], y = (double)camera->matrix.m[1][c];
        double near = (double)camera->matrix.m[2][c], w = (double)camera->matrix.m[3][c];
        double rows[5] = {x + w, width * w - x, y + w, height * w - y,
                          (double)camera->nearness_limit * w - near};
        for (int i = 0; i < 5; ++i) {
            if (c < 3) {
                planes.a[i][c] = rows[i];
            } else {
                planes.b[i] = rows[i];
            }
        }
    }
    return planes;
}

/// Whether the whole box lies behind one of the planes, with a margin for what floats round.
static bool is_outside(const bounding_planes* planes, const cpu_item* item, stp_box box)
{
    const double low[3] = {(double)box.min.x, (double)box.min.y, (double)box.min.z};
    const double high[3] = {(double)box.max.x, (double)box.max.y, (double)box.max.z};
    bool outside = false;
    for (int i = 0; i < 5; ++i) {
        double most = planes->b[i], size = fabs(planes->b[i]);
        for (int c = 0; c < 3; ++c) {
            double a = planes->a[i][c], offset = (double)item->offset[c];
            double from = (low[c] - offset) * a, to = (high[c] - offset) * a;
            most += from > to ? from : to;
            size += fmax(fabs(from), fabs(to));
        }
        outside = outside || most < -1e-5 * size;
    }
    return outside;
}

static bool draw_batch(const cpu_renderer* r, const cpu_item* item, const batch* b,
                       const stp_raster_target* target, cpu_keep* keep, cpu_worker* worker)
{
    if (b->triangle_count == 0) {
        return true;
    }
    stp_raster_mesh mesh = {.positions = b->positions,
                            .vertex_count = b->vertex_count,
                            .indices = b->indices,
                            .triangle_count = b->triangle_count,
                            .offset = {item->offset[0], item->offset[1], item->offset[2]},
                            .fragments = &worker->fragments};
    if (keep->cut_mask != 0 || cpu_item_needs_keep(item)) {
        keep->first_triangle = b->first_triangle;
        mesh.keep = cpu_keep_fragment;
        mesh.keep_user = keep;
    }
    return stp_raster_triangles(target, 0, r->height, &item->camera.matrix,
                                item->camera.nearness_limit, &mesh,
                                item->first_id + b->first_triangle, &worker->scratch) == STP_OK;
}

float cpu_least_depth(const cpu_item* item, stp_box box)
{
    const float* w = item->camera.matrix.m[3];
    const float low[3] = {box.min.x, box.min.y, box.min.z};
    const float high[3] = {box.max.x, box.max.y, box.max.z};
    float depth = w[3];
    for (int c = 0; c < 3; ++c) {
        depth += w[c] * ((w[c] > 0.0f ? low[c] : high[c]) - item->offset[c]);
    }
    return depth;
}

void cpu_drop_triangles(uint32_t* indices, uint32_t first, uint32_t count, float share)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (!stp_draw_keeps(first + i, share)) {
            indices[3 * i + 1] = indices[3 * i + 2] = indices[3 * i];
        }
    }
}

static void add_cluster(const cpu_item* item, uint32_t index, float share, batch* b)
{
    stp_cluster cluster;
    stp_clusters_get(&item->clusters, index, &cluster);
    if (b->cluster_count == 0) {
        b->first_triangle = cluster.first_triangle;
    }
    stp_cluster_positions(&item->clusters, &cluster, b->positions + 3 * (size_t)b->vertex_count);
    uint32_t* indices = b->indices + 3 * (size_t)b->triangle_count;
    stp_cluster_indices(&cluster, b->vertex_count, indices);
    if (share < 1.0f) {
        cpu_drop_triangles(indices, cluster.first_triangle, cluster.triangle_count, share);
    }
    b->vertex_count += cluster.vertex_count;
    b->triangle_count += cluster.triangle_count;
    b->cluster_count += 1;
}

/// Whether there is anything to draw of a cluster.
static bool is_seen(const cpu_renderer* r, const cpu_item* item, const bounding_planes* planes,
                    stp_box box, uint32_t bit, cpu_cluster_range* range)
{
    if ((range->wanted & bit) == 0 || is_outside(planes, item, box)) {
        return false;
    }
    if (r->occluding != NULL && cpu_hides(r, item, box)) {
        range->hidden |= bit;
        return false;
    }
    return true;
}

bool cpu_draw_clusters(const cpu_renderer* r, const cpu_item* item, cpu_cluster_range* range,
                       const stp_raster_target* target, cpu_worker* worker)
{
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    batch* b = stp_arena_alloc(&worker->scratch, sizeof(*b));
    cpu_keep_memory memory = {.triangle = UINT32_MAX};
    cpu_cuts cuts;
    cpu_find_cuts(r, item, &cuts);
    cpu_keep keep = {.renderer = r, .item = item, .memory = &memory, .cuts = &cuts};
    bounding_planes planes = make_planes(r, item);
    bool enough = b != NULL;
    for (uint32_t i = range->begin; enough && i < range->end;) {
        b->vertex_count = b->triangle_count = b->cluster_count = 0;
        keep.cut_mask = 0;
        while (i < range->end && b->cluster_count < BATCH_CLUSTERS) {
            stp_box box = stp_clusters_bounds(&item->clusters, i);
            float share = stp_draw_share(item->draw, cpu_least_depth(item, box));
            bool seen = share > 0.0f && !cpu_cuts_drop(&cuts, item, box, &keep.cut_mask) &&
                        is_seen(r, item, &planes, box, 1u << (i - range->begin), range);
            if (!seen && b->cluster_count != 0) {
                i += 1;
                break; // ids of a batch follow each other
            }
            if (seen) {
                add_cluster(item, i, share, b);
            }
            i += 1;
        }
        enough = draw_batch(r, item, b, target, &keep, worker);
    }
    stp_arena_rewind(&worker->scratch, mark);
    return enough;
}
