// SPDX-License-Identifier: MIT
#include "lod/psp/metric.h"

#include "lod/psp/kd_tree.h"

const stp_psp_metric_table* stp_psp_metric_find(stp_psp_metric metric)
{
    switch (metric) {
    case STP_PSP_DISTANCES:
        return &stp_psp_metric_distances;
    case STP_PSP_REGIONS:
        return &stp_psp_metric_regions;
    case STP_PSP_NORMALS:
        break;
    }
    return &stp_psp_metric_normals;
}

stp_vec3 stp_psp_point_at(const stp_psp_shared* shared, uint32_t point)
{
    const float* p = shared->points->positions + 3 * (size_t)point;
    return (stp_vec3){stp_kd_clean(p[0], shared->scale), stp_kd_clean(p[1], shared->scale),
                      stp_kd_clean(p[2], shared->scale)};
}

float stp_psp_pair_error(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                         const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                         const void* b_state)
{
    if (!(stp_dot(a->ellipse.normal, b->ellipse.normal) >= shared->desc.least_cosine)) {
        return HUGE_VALF;
    }
    double error = a->key < b->key ? metric->error(shared, a, a_state, b, b_state)
                                   : metric->error(shared, b, b_state, a, a_state);
    if (metric->by_length) {
        error *= (double)stp_length(stp_sub(b->ellipse.center, a->ellipse.center));
    }
    return error <= (double)FLT_MAX ? error > 0.0 ? (float)error : 0.0f : FLT_MAX;
}

void stp_psp_merge_pair(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                        const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                        const void* b_state, stp_psp_splat* merged, void* merged_state)
{
    if (b->key < a->key) {
        const stp_psp_splat* splat = a;
        const void* state = a_state;
        a = b;
        a_state = b_state;
        b = splat;
        b_state = state;
    }
    float share = a->area / (a->area + b->area);
    for (int k = 0; k < 3; ++k) {
        merged->color[k] = share * a->color[k] + (1.0f - share) * b->color[k];
    }
    merged->key = a->key;
    metric->merge(shared, a, a_state, b, b_state, merged, merged_state);
}
