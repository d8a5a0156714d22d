// SPDX-License-Identifier: MIT
// Models for the tests of decimators, and properties of all decimators.
#pragma once

#include "tests.h"

#include "base/math/rng.h"
#include "lab/decimate/decimator.h"

#include <string.h>

enum { DECIMATE_SIDE = 48, DECIMATE_POINTS = DECIMATE_SIDE * DECIMATE_SIDE };

typedef struct decimate_model {
    float positions[3 * DECIMATE_POINTS], normals[3 * DECIMATE_POINTS];
    uint8_t colors[3 * DECIMATE_POINTS];
    uint32_t triangles[6 * DECIMATE_POINTS];
} decimate_model;

static inline double decimate_unit(uint64_t seed, uint64_t at)
{
    return (double)(stp_rng_hash(seed, at) >> 11) * 0x1p-53;
}

/// A torus around the y axis, of radii 1 and 0.4: closed, with normals; red where x > 0, else
/// green.
static inline stp_decimate_input decimate_torus(decimate_model* m)
{
    for (uint32_t i = 0; i < DECIMATE_POINTS; ++i) {
        uint32_t u = i % DECIMATE_SIDE, v = i / DECIMATE_SIDE;
        double a = 6.283185307179586 * u / DECIMATE_SIDE, b = 6.283185307179586 * v / DECIMATE_SIDE;
        double across = 1.0 + 0.4 * cos(b);
        const float p[3] = {(float)(across * cos(a)), (float)(0.4 * sin(b)),
                            (float)(across * sin(a))};
        const float n[3] = {(float)(cos(b) * cos(a)), (float)sin(b), (float)(cos(b) * sin(a))};
        memcpy(m->positions + 3 * i, p, sizeof(p));
        memcpy(m->normals + 3 * i, n, sizeof(n));
        m->colors[3 * i] = p[0] > 0.0f ? 255 : 0;
        m->colors[3 * i + 1] = p[0] > 0.0f ? 0 : 255;
        m->colors[3 * i + 2] = 0;
        uint32_t right = v * DECIMATE_SIDE + (u + 1) % DECIMATE_SIDE;
        uint32_t above = (v + 1) % DECIMATE_SIDE * DECIMATE_SIDE;
        const uint32_t t[6] = {i,     above + u, right,
                               right, above + u, above + (u + 1) % DECIMATE_SIDE};
        memcpy(m->triangles + 6 * i, t, sizeof(t));
    }
    return (stp_decimate_input){.count = DECIMATE_POINTS,
                                .positions = m->positions,
                                .normals = m->normals,
                                .colors = m->colors,
                                .triangles = m->triangles,
                                .triangle_count = 2 * DECIMATE_POINTS};
}

/// Whether all numbers of a splat are finite, its normal of unit length, and its axes in order.
static inline bool decimate_is_sound(const stp_ellipse* e)
{
    float major = stp_length(e->major);
    return stp_is_finite(e->center) && stp_is_finite(e->major) && isfinite(e->minor) &&
           e->minor > 0.0f && e->minor <= major * 1.001f &&
           fabsf(stp_length(e->normal) - 1.0f) < 1e-3f &&
           fabsf(stp_dot(e->major, e->normal)) <= 1e-3f * major;
}

/// Whether the projection of a point lies in a splat, `away` or less from its plane.
static inline bool decimate_is_covered_by(const stp_ellipse* e, stp_vec3 p, float away)
{
    float major = stp_length(e->major);
    stp_vec3 x = stp_scale(e->major, 1.0f / major), y = stp_cross(e->normal, x);
    stp_vec3 d = stp_sub(p, e->center);
    float u = stp_dot(d, x) / major, v = stp_dot(d, y) / e->minor;
    return u * u + v * v <= 1.001f && fabsf(stp_dot(d, e->normal)) <= away;
}

/// Number of points that lie in no splat.
static inline uint32_t decimate_count_bare(const stp_decimate_input* input,
                                           const stp_decimate_output* output, float away)
{
    uint32_t bare = 0;
    // squared distances from the centres beyond which a splat covers no point
    float* squares = malloc((output->count + 1) * sizeof(float));
    for (uint32_t s = 0; s < output->count; ++s) {
        const stp_vec3* major = &output->ellipses[s].major;
        float square = major->x * major->x + major->y * major->y + major->z * major->z;
        squares[s] = 1.01f * (square + away * away);
    }
    for (uint32_t i = 0; i < input->count; ++i) {
        stp_vec3 p = {input->positions[3 * i], input->positions[3 * i + 1],
                      input->positions[3 * i + 2]};
        bool covered = false;
        for (uint32_t s = 0; s < output->count && !covered; ++s) {
            const stp_vec3* center = &output->ellipses[s].center;
            float x = p.x - center->x, y = p.y - center->y, z = p.z - center->z;
            covered = x * x + y * y + z * z <= squares[s] &&
                      decimate_is_covered_by(&output->ellipses[s], p, away);
        }
        bare += covered ? 0 : 1;
    }
    free(squares);
    return bare;
}
