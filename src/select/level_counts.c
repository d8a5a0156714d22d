// SPDX-License-Identifier: MIT
// How many triangles the levels of a node have for each allowed error, and the error that a view
// allows them by it: where triangles cover many pixels each, a frame pays for their fragments, and
// finer levels cost next to nothing (docs/notes/2026-11-level-errors.md).
#include "base/splats/prefix_table.h"
#include "select/select_internal.h"

#include <assert.h>

enum { ERRORS = STP_LEVEL_ERRORS };

// The error is a sum of root mean squares. Among the finest splats facets show. Beside larger ones
// it may grow, but no further than it saves.
#define FINE_ERROR 1.4    ///< pixels
#define FINE_SIZE 2.0     ///< of the splats that go with it
#define LARGE_PIXELS 20.0 ///< of a triangle, from which finer ones cost little

double stp_select_level_error(double splat_size)
{
    double ratio = splat_size / FINE_SIZE;
    return FINE_ERROR * (ratio < 1.0 ? ratio * ratio : sqrt(ratio));
}

double stp_select_node_diagonal(const stp_store_node* node)
{
    const stp_boxd* box = &node->bounds;
    return stp_boxd_is_empty(*box) ? 0.0 : stp_lengthd(stp_subd(box->max, box->min));
}

double stp_select_node_level_error(const stp_selection* s, const stp_select_entry* at,
                                   const stp_box_visibility* sight)
{
    double coarse = stp_select_level_error(sight->splat_size);
    uint32_t row = s->graph->level_rows[at->node];
    assert(row != STP_STORE_NONE && "it has levels");
    double middle = 0.5 * (sight->range.near + sight->range.far);
    double pixel = stp_view_frame_pixel_size(&s->frames[0], 1.0) * middle /
                   stp_affine_scale(&at->transform); // node units
    double most = (double)s->graph->level_areas[row] / (LARGE_PIXELS * pixel * pixel);
    if (coarse <= FINE_ERROR || !(most > 0.0)) {
        return coarse;
    }
    const float* counts = s->graph->level_counts + ERRORS * (size_t)row;
    double error = stp_select_node_diagonal(&s->directory->nodes[at->node]) / pixel;
    if ((double)counts[0] > most) {
        return coarse;
    }
    for (int k = 1; k < ERRORS; ++k, error *= 0.5) {
        double below = (double)counts[k - 1], here = (double)counts[k];
        if (here > most) {
            error *= 1.0 - 0.5 * (most - below) / (here - below);
            break;
        }
    }
    return stp_clampd(error, FINE_ERROR, coarse);
}

/// Adds to `counts` the triangles that are drawn where errors of size, size / 2 and so on are
/// allowed.
static void count_drawn(const stp_selection* s, uint32_t node, float counts[ERRORS])
{
    const stp_store_directory* d = s->directory;
    for (uint32_t i = d->level_starts[node]; i < d->level_starts[node + 1]; ++i) {
        const stp_store_level* level = &d->levels[i];
        float each = (float)stp_store_describe_mesh(s->store, level->mesh)->triangle_count /
                     (float)level->cluster_count;
        for (uint32_t c = 0; c < level->cluster_count; ++c) {
            const stp_store_level_cluster* cluster = &d->level_clusters[level->first_cluster + c];
            double made = cluster->made_by == STP_STORE_NONE
                              ? 0.0
                              : (double)d->level_groups[cluster->made_by].error;
            double used = cluster->used_by == STP_STORE_NONE
                              ? HUGE_VAL
                              : (double)d->level_groups[cluster->used_by].error;
            double error = stp_select_node_diagonal(&d->nodes[node]);
            int k = 0;
            for (; k < ERRORS && error >= used; ++k) {
                error *= 0.5;
            }
            for (; k < ERRORS && error >= made; ++k) {
                counts[k] += each;
                error *= 0.5;
            }
        }
    }
}

#define DISKS_OF_AREA 1.25 ///< area that a Poisson disk sample covers, per squared radius

/// Estimates the area of a node's surface: by its splats, else that of its box.
static double find_area(const stp_selection* s, uint32_t node)
{
    uint32_t set = stp_select_set_of(s, node);
    if (set != STP_STORE_NONE) {
        const stp_splats* splats = stp_store_describe_splat_set(s->store, set);
        double radius = (double)stp_prefix_table_radius(&splats->table, splats->count);
        if (splats->count > 0 && radius > 0.0) {
            return DISKS_OF_AREA * (double)splats->count * radius * radius;
        }
    }
    const stp_boxd* box = &s->directory->nodes[node].bounds;
    stp_vec3d size = stp_subd(box->max, box->min);
    return 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

stp_result stp_select_count_levels(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* d = s->directory;
    uint32_t rows = 0;
    for (uint32_t node = 0; node < d->node_count; ++node) {
        bool has = d->level_starts != NULL && d->level_starts[node] < d->level_starts[node + 1];
        graph->level_rows[node] = has ? rows++ : STP_STORE_NONE;
    }
    graph->level_counts = STP_NEW_ZEROED(s->context, float, ERRORS*(size_t)rows + 1);
    graph->level_areas = STP_NEW_ARRAY(s->context, float, (size_t)rows + 1);
    if (graph->level_counts == NULL || graph->level_areas == NULL) {
        return stp_fail_memory(s->context);
    }
    for (uint32_t node = 0; node < d->node_count; ++node) {
        uint32_t row = graph->level_rows[node];
        if (row != STP_STORE_NONE) {
            count_drawn(s, node, graph->level_counts + ERRORS * (size_t)row);
            graph->level_areas[row] = (float)fmin(find_area(s, node), (double)FLT_MAX);
        }
    }
    return STP_OK;
}
