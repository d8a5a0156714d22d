// SPDX-License-Identifier: MIT
// A set of method blue on a sphere, for tests of methods that start from samples.
#pragma once

#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_columns.h"

#include <assert.h>
#include <math.h>

enum { SAMPLES = 3000 };

typedef struct samples {
    uint16_t positions[3 * SAMPLES];
    int8_t normals[2 * SAMPLES];
    uint8_t materials[SAMPLES], colors[3 * SAMPLES], coverages[SAMPLES];
    stp_splats set;
} samples;

/// The normal of a sample: `count` of them lie evenly along a spiral.
static inline stp_vec3 sample_normal(uint32_t i, uint32_t count)
{
    double y = 1.0 - 2.0 * ((double)i + 0.5) / count, around = 2.399963229728653 * i;
    double across = sqrt(1.0 - y * y);
    return (stp_vec3){(float)(across * cos(around)), (float)y, (float)(across * sin(around))};
}

/// Samples on a sphere of radius about 0.92 around the origin that cover to `reach`. Materials,
/// colours and coverages are zero.
static inline void make_sphere_samples(samples* s, uint32_t count, float reach)
{
    assert(count <= SAMPLES && "the columns hold all samples");
    *s = (samples){.set = {.count = count,
                           .origin = {-1.0f, -1.0f, -1.0f},
                           .step = 1.0f / 32768.0f,
                           .octave_count = 1,
                           .octave_ends = {count},
                           .table = {.size = 1, .count = {count}, .radius = {reach}},
                           .candidate_radius = 0.001f}};
    s->set.positions = s->positions;
    s->set.normals = s->normals;
    s->set.materials = s->materials;
    s->set.colors = s->colors;
    s->set.coverages = s->coverages;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 n = sample_normal(i, count);
        s->positions[3 * i] = (uint16_t)(32768.0 + 30000.0 * (double)n.x);
        s->positions[3 * i + 1] = (uint16_t)(32768.0 + 30000.0 * (double)n.y);
        s->positions[3 * i + 2] = (uint16_t)(32768.0 + 30000.0 * (double)n.z);
        stp_octahedral_encode(n, s->normals + 2 * i);
    }
}

/// The centre of a splat.
static inline stp_vec3d place_of(const stp_splats* s, uint32_t i)
{
    const uint16_t* p = s->positions + 3 * (size_t)i;
    return (stp_vec3d){(double)s->origin.x + (double)s->step * p[0],
                       (double)s->origin.y + (double)s->step * p[1],
                       (double)s->origin.z + (double)s->step * p[2]};
}

/// A random number from 0 to 1.
static inline double unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}
