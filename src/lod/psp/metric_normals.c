// SPDX-License-Identifier: MIT
// L2,1: difference between the normals of two splats, weighted by area (Wu, Zhang, Kobbelt 2005,
// section 4.2).
#include "lod/psp/metric.h"

#include <assert.h>

/// Squared differences of unit normals below this are noise. Added to all, so that planes are
/// merged evenly, smallest splats first.
#define FLAT 1e-12

static double measure(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                      const stp_psp_splat* b, const void* b_state)
{
    (void)shared;
    (void)a_state;
    (void)b_state;
    stp_vec3 d = stp_sub(a->ellipse.normal, b->ellipse.normal);
    assert(!(stp_dot(d, d) > 4.01f) && "normals are unit vectors");
    return (double)a->area * (double)b->area * ((double)stp_dot(d, d) + FLAT);
}

static void merge(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                  const stp_psp_splat* b, const void* b_state, stp_psp_splat* merged,
                  void* merged_state)
{
    (void)a_state;
    (void)b_state;
    (void)merged_state;
    const stp_ellipse *l = &a->ellipse, *r = &b->ellipse;
    float share = a->area / (a->area + b->area);
    stp_vec3 center = stp_add(stp_scale(l->center, share), stp_scale(r->center, 1.0f - share));
    stp_vec3 normal = stp_add(stp_scale(l->normal, share), stp_scale(r->normal, 1.0f - share));
    stp_vec3 samples[2 * STP_ELLIPSE_SAMPLES];
    float length = stp_length(normal);
    normal = length > 0.0f ? stp_scale(normal, 1.0f / length) : l->normal;
    stp_ellipse_sample(l, samples);
    stp_ellipse_sample(r, samples + STP_ELLIPSE_SAMPLES);
    merged->ellipse =
        stp_ellipse_cover(center, normal, samples, 2 * STP_ELLIPSE_SAMPLES, shared->minimum);
    merged->area = stp_ellipse_area(&merged->ellipse);
}

const stp_psp_metric_table stp_psp_metric_normals = {
    .power = 5,
    .by_length = true,
    .error = measure,
    .merge = merge,
};
