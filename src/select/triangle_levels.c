// SPDX-License-Identifier: MIT
// Levels of a node's triangles (store/file/levels.h): which of them a view draws, and the depth from
// which they replace the originals. Each cluster is chosen when it is drawn, by the depths of its
// groups' spheres (stp_draw_item.level_per_depth).
#include "select/rule.h"
#include "select/select_internal.h"

#include <assert.h>

/// Levels may be this many times as coarse as wanted, while better ones are loaded.
#define COARSEST 8.0

/// The levels of a node.
typedef struct node_levels {
    uint32_t begin, end; ///< of the directory's
} node_levels;

static node_levels levels_of(const stp_selection* s, uint32_t node)
{
    const uint32_t* starts = s->directory->level_starts;
    return starts != NULL ? (node_levels){starts[node], starts[node + 1]} : (node_levels){0};
}

/// Whether the levels of a node look like its originals in this view: nothing cuts it, all of it is
/// shown, and no eye is where it sees what cannot be seen from outside.
static bool are_usable(const stp_selection* s, const stp_select_entry* at,
                       const stp_box_visibility* sight, node_levels of)
{
    bool outside = (s->directory->levels[of.begin].flags & STP_LEVEL_FROM_OUTSIDE) != 0;
    return at->shown == STP_SHOW && at->sections == 0 && !(outside && sight->is_inside);
}

/// Depth of the nearest point of all groups' spheres.
static double nearest_of_groups(const stp_selection* s, const stp_select_entry* at,
                                const stp_box_visibility* sight)
{
    if (s->frames[0].parallel) {
        return sight->range.near;
    }
    double reach = (double)s->graph->level_overhangs[at->node] * stp_affine_scale(&at->transform);
    return fmax(sight->range.near - reach, 0.0);
}

/// Requests the levels that a view needs, and all coarser ones, which are small. @return the least
/// error that the loaded ones can show
static double request_levels(stp_selection* s, const stp_select_entry* at,
                             const stp_box_visibility* sight, double nearest, double farthest)
{
    node_levels of = levels_of(s, at->node);
    double floor = 0.0, before;
    for (uint32_t i = of.begin; i < of.end; ++i) {
        const stp_store_level* level = &s->directory->levels[i];
        if ((double)level->most > nearest) {
            (void)stp_select_request_level(s, at, sight, level->mesh, (double)level->most);
        }
    }
    do { // what is missing is left out, which may need coarser ones
        before = floor;
        for (uint32_t i = of.begin; i < of.end; ++i) {
            const stp_store_level* level = &s->directory->levels[i];
            bool needed = (double)level->most > fmax(nearest, floor) &&
                          (double)level->least <= fmax(farthest, floor);
            if (needed && !stp_store_is_mesh_resident(s->store, level->mesh)) {
                floor = (double)level->most;
            }
        }
    } while (floor > before);
    return floor;
}

/// Whether a node is drawn by levels, and how: without the limits of what is loaded.
static bool wants_levels(stp_selection* s, const stp_select_entry* at,
                         const stp_box_visibility* sight, stp_levels_use* use)
{
    node_levels of = levels_of(s, at->node);
    *use = (stp_levels_use){0};
    if (!s->draws_levels || of.begin == of.end || !are_usable(s, at, sight, of)) {
        return false;
    }
    double pixel = stp_view_frame_pixel_size(&s->frames[0], 1.0);
    use->per_depth =
        stp_select_node_level_error(s, at, sight) * pixel / stp_affine_scale(&at->transform);
    if (!(use->per_depth > 0.0) || !isfinite(use->per_depth)) {
        return false;
    }
    use->nearest = use->per_depth * nearest_of_groups(s, at, sight);
    use->farthest = use->per_depth * sight->range.far;
    use->originals_to = (double)s->graph->level_floors[at->node] / use->per_depth;
    return true;
}

/// Requests what a use needs. @return whether it is loaded finely enough
static bool limit_levels(stp_selection* s, const stp_select_entry* at,
                         const stp_box_visibility* sight, stp_levels_use* use)
{
    if (!s->streams) {
        return true;
    }
    use->floor = request_levels(s, at, sight, use->nearest, use->farthest);
    double wanted =
        fmax(use->per_depth * sight->range.near, (double)s->graph->level_floors[at->node]);
    return use->floor <= COARSEST * wanted;
}

bool stp_select_request_levels(stp_selection* s, const stp_select_entry* at, bool* here)
{
    stp_levels_use use;
    stp_box_visibility sight;
    stp_boxd box = stp_select_place_box(&at->transform, &s->directory->nodes[at->node].bounds);
    if (!stp_select_is_in_view(s, &box, &sight) || !wants_levels(s, at, &sight, &use)) {
        return false;
    }
    *here = limit_levels(s, at, &sight, &use);
    return true;
}

bool stp_select_replaces_part(const stp_selection* s, stp_store_part part)
{
    return part.kind == STP_STORE_PART_MESH &&
           s->directory->materials[stp_store_describe_mesh(s->store, part.index)->material].alpha ==
               STP_STORE_OPAQUE;
}

static stp_result add_levels(stp_selection* s, const stp_select_entry* at,
                             const stp_box_visibility* sight, const stp_levels_use* use)
{
    node_levels of = levels_of(s, at->node);
    double switch_depth = at->ancestor_switch_depth;
    stp_result result = STP_OK;
    if (!(stp_level_switch_share(switch_depth, sight->range.near) > 0.0) ||
        sight->range.far < use->originals_to) {
        return STP_OK;
    }
    double nearest = fmax(use->nearest, use->floor), farthest = fmax(use->farthest, use->floor);
    for (uint32_t i = of.begin; i < of.end && result == STP_OK; ++i) {
        const stp_store_level* level = &s->directory->levels[i];
        if (!((double)level->most > nearest) || (double)level->least > farthest) {
            continue;
        }
        stp_draw_item item = {.kind = STP_DRAW_MESH,
                              .index = level->mesh,
                              .is_level = true,
                              .level = i,
                              .level_per_depth = (float)use->per_depth,
                              .level_min = (float)use->floor,
                              .level_from = (float)use->originals_to,
                              .transform = at->transform};
        if (sight->range.far > switch_depth) {
            item.switch_begin = (float)switch_depth;
            item.switch_end = (float)(switch_depth * STP_LEVEL_SWITCH_FAR);
        }
        result = stp_select_add_item(
            s, item, stp_store_describe_mesh(s->store, level->mesh)->triangle_count);
    }
    return result;
}

stp_result stp_select_use_levels(stp_selection* s, stp_select_entry* at,
                                 const stp_box_visibility* sight)
{
    stp_levels_use use;
    if (!wants_levels(s, at, sight, &use) || !limit_levels(s, at, sight, &use)) {
        return STP_OK;
    }
    double to = fmin(use.originals_to, at->ancestor_switch_depth);
    if (s->streams && stp_level_switch_share(to, sight->range.near) > 0.0) {
        bool here = false;
        stp_result result = stp_select_request_meshes(s, at, true, to, &here);
        if (result != STP_OK) {
            return result;
        }
        use.originals_to = here ? use.originals_to : 0.0;
    }
    at->level_depth = use.originals_to;
    return add_levels(s, at, sight, &use);
}

void stp_select_find_levels(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* d = s->directory;
    for (uint32_t node = 0; node < d->node_count; ++node) {
        const stp_store_node* n = &d->nodes[node];
        for (uint32_t i = 0; i < n->part_count; ++i) {
            bool replaced = stp_select_replaces_part(s, d->parts[n->first_part + i]);
            graph->others[node] = graph->others[node] || !replaced;
        }
        for (uint32_t i = 0; i < n->edge_count; ++i) {
            uint32_t child = d->edges[n->first_edge + i].node;
            graph->others[node] = graph->others[node] || graph->others[child];
        }
        node_levels of = levels_of(s, node);
        double least = (double)FLT_MAX, reach = 0.0;
        const stp_boxd* box = &n->bounds;
        stp_vec3d middle = stp_scaled(stp_addd(box->min, box->max), 0.5);
        stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
        for (uint32_t i = of.begin; i < of.end; ++i) {
            const stp_store_level* level = &d->levels[i];
            for (uint32_t k = 0; k < level->cluster_count; ++k) {
                const stp_store_level_cluster* c = &d->level_clusters[level->first_cluster + k];
                for (int end = 0; end < 2; ++end) {
                    uint32_t name = end == 0 ? c->made_by : c->used_by;
                    if (name == STP_STORE_NONE) {
                        continue;
                    }
                    const stp_store_level_group* g = &d->level_groups[name];
                    stp_vec3d center = {(double)g->center[0], (double)g->center[1],
                                        (double)g->center[2]};
                    double out = stp_lengthd(stp_subd(center, middle)) + (double)g->radius;
                    least = fmin(least, (double)g->error);
                    reach = fmax(reach, out);
                }
            }
        }
        // the part of the spheres beyond the box, in any direction
        double inside = fmin(half.x, fmin(half.y, half.z));
        graph->level_floors[node] = of.begin < of.end ? (float)least : 0.0f;
        graph->level_overhangs[node] = (float)fmax(reach - inside, 0.0);
    }
}
