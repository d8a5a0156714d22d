// SPDX-License-Identifier: MIT
#include "draw/placement.h"

#include <assert.h>

stp_level_choice stp_level_choice_make(const stp_store_directory* directory,
                                       const stp_draw_item* item, const float rows[4][4],
                                       const float offset[3])
{
    assert(item->is_level && item->level < directory->level_count);
    const double w[3] = {(double)rows[3][0], (double)rows[3][1], (double)rows[3][2]};
    stp_level_choice choice = {.clusters = directory->level_clusters +
                                           directory->levels[item->level].first_cluster,
                               .groups = directory->level_groups,
                               .depth = {w[0], w[1], w[2], (double)rows[3][3]},
                               .steepness = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]),
                               .per_depth = (double)item->level_per_depth,
                               .minimum = (double)item->level_min};
    for (int c = 0; c < 3; ++c) {
        choice.depth[3] -= w[c] * (double)offset[c];
    }
    return choice;
}

/// The error that is allowed at the nearest point of a group's sphere.
static double allowed_at(const stp_level_choice* choice, const stp_store_level_group* group)
{
    double depth = choice->depth[3] - choice->steepness * (double)group->radius;
    for (int c = 0; c < 3; ++c) {
        depth += choice->depth[c] * (double)group->center[c];
    }
    return fmax(choice->per_depth * depth, choice->minimum);
}

bool stp_level_choice_draws(const stp_level_choice* choice, uint32_t cluster)
{
    const stp_store_level_cluster* c = &choice->clusters[cluster];
    if (c->used_by != STP_STORE_NONE) {
        const stp_store_level_group* used = &choice->groups[c->used_by];
        if ((double)used->error <= allowed_at(choice, used)) {
            return false;
        }
    }
    const stp_store_level_group* made =
        c->made_by != STP_STORE_NONE ? &choice->groups[c->made_by] : NULL;
    return made == NULL || (double)made->error <= allowed_at(choice, made);
}

void stp_mesh_offset(const stp_store* store, const stp_store_directory* directory,
                     const stp_draw_item* item, float offset[3])
{
    assert(item->kind == STP_DRAW_MESH && "others are placed by their grid");
    stp_vec3 middle;
    if (item->is_level) {
        const stp_boxd* box = &directory->nodes[directory->levels[item->level].node].bounds;
        middle = stp_to_float(stp_scaled(stp_addd(box->min, box->max), 0.5));
    } else {
        stp_box box = stp_store_describe_mesh(store, item->index)->bounds;
        middle = (stp_vec3){0.5f * (box.min.x + box.max.x), 0.5f * (box.min.y + box.max.y),
                            0.5f * (box.min.z + box.max.z)};
    }
    offset[0] = middle.x;
    offset[1] = middle.y;
    offset[2] = middle.z;
}
