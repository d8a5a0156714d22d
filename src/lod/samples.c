// SPDX-License-Identifier: MIT
#include "lod/samples.h"

#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "capture/splat_disks.h"

#include <assert.h>
#include <string.h>

static stp_result find_radii(stp_context* context, const stp_splats* set,
                             const stp_shading* shadings, stp_method_samples* samples)
{
    samples->radii = STP_NEW_ARRAY(context, float, set->count);
    if (samples->radii == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < set->count; ++i) {
        float growth = shadings[set->materials[i]].growth;
        samples->radii[i] = samples->points.radius + set->candidate_radius * growth;
    }
    samples->points.radii = samples->radii;
    return STP_OK;
}

stp_result stp_method_samples_take(stp_context* context, const stp_splats* set,
                                   const stp_shading* shadings, stp_method_samples* samples)
{
    assert(set->count > 0);
    assert((set->columns & STP_SPLATS_FLAT_COLORS) != 0 ||
           (set->octave_count > 0 && set->octave_ends[set->octave_count - 1] == set->count));
    size_t count = set->count, finest = stp_set_entries_of(set, set->count).first;
    *samples = (stp_method_samples){
        .coverages = set->coverages + finest,
        .positions = STP_NEW_ARRAY(context, float, 3 * count),
        .normals = STP_NEW_ARRAY(context, float, 3 * count),
    };
    if (samples->positions == NULL || samples->normals == NULL) {
        return stp_fail_memory(context);
    }
    const float origin[3] = {set->origin.x, set->origin.y, set->origin.z};
    for (size_t i = 0; i < count; ++i) {
        stp_vec3 normal = stp_octahedral_decode(set->normals[2 * i], set->normals[2 * i + 1]);
        memcpy(samples->normals + 3 * i, &normal, sizeof(normal));
        for (size_t k = 0; k < 3; ++k) {
            samples->positions[3 * i + k] =
                origin[k] + set->step * (float)set->positions[3 * i + k];
        }
    }
    float reach = stp_prefix_table_radius(&set->table, set->count);
    samples->points = (stp_tree_points){.count = set->count,
                                        .positions = samples->positions,
                                        .normals = samples->normals,
                                        .colors = set->colors + 3 * finest,
                                        .radius = reach + set->candidate_radius};
    return shadings != NULL ? find_radii(context, set, shadings, samples) : STP_OK;
}

void stp_method_samples_destroy(stp_context* context, stp_method_samples* samples)
{
    stp_free(context, samples->positions);
    stp_free(context, samples->normals);
    stp_free(context, samples->radii);
    *samples = (stp_method_samples){.coverages = NULL};
}
