// SPDX-License-Identifier: MIT
//
// Splats as captures see them: position, normal, and colour as a member of a prefix.
#pragma once

#include "base/math/math.h"
#include "base/splats/light_normal.h"
#include "capture/capture_internal.h"

#include <assert.h>
#include <string.h>

/// Entries of the colour pyramid that a prefix is drawn with (base/splats/splat_columns.h).
typedef struct stp_set_entries {
    size_t first;                            ///< entry of splat 0 in the prefix's octave
    size_t first_before;                     ///< same in the octave before
    uint32_t before;                         ///< splats that have entries there
    float share;                             ///< weight of the prefix's own octave for those
    stp_light_normals lights, lights_before; ///< of both octaves
} stp_set_entries;

static inline stp_set_entries stp_set_entries_of(const stp_splats* splats, uint32_t prefix)
{
    stp_set_entries look = {0};
    uint32_t octave = 0;
    assert(prefix <= splats->count);
    if ((splats->columns & STP_SPLATS_FLAT_COLORS) != 0) { // one colour each
        look.share = 1.0f;
        return look;
    }
    while (octave + 1 < splats->octave_count && splats->octave_ends[octave] < prefix) {
        look.first_before = look.first;
        look.before = splats->octave_ends[octave];
        look.first += look.before;
        octave += 1;
    }
    uint32_t end = splats->octave_ends[octave];
    look.share =
        end > look.before ? (float)(prefix - look.before) / (float)(end - look.before) : 1.0f;
    assert(prefix >= look.before && look.share <= 1.0f);
    look.lights = stp_light_normals_of(splats, octave);
    look.lights_before = stp_light_normals_of(splats, octave > 0 ? octave - 1 : 0);
    return look;
}

/// Transform of a set to another space.
typedef struct stp_set_placing {
    const stp_splats* splats;
    stp_affine placement;
    double normal_matrix[3][3];
} stp_set_placing;

static inline stp_set_placing stp_set_placing_make(const stp_splats* splats,
                                                   const stp_affine* placement)
{
    stp_set_placing placing = {.splats = splats, .placement = *placement};
    stp_affine_normal_matrix(placement, placing.normal_matrix);
    return placing;
}

stp_vec3d stp_set_position(const stp_set_placing* placing, uint32_t splat);

/// Unit normal by the inverse transpose. Keeps its side, mirrored or not.
stp_vec3d stp_set_normal(const stp_set_placing* placing, uint32_t splat);

/// Transform from a set's own space to the captured space minus its centre.
static inline stp_affine stp_capture_set_placement(const stp_capture_job* job, size_t set)
{
    return stp_affine_shifted(job->sets[set].transform, job->centre);
}
