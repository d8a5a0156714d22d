// SPDX-License-Identifier: MIT
#include "lod/psp/metric.h"

#include "lod/psp/kd_tree.h"

#include <assert.h>
#include <string.h>

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
    assert(point < shared->points->count);
    const float* p = shared->points->positions + 3 * (size_t)point;
    return (stp_vec3){stp_kd_clean(p[0], shared->scale), stp_kd_clean(p[1], shared->scale),
                      stp_kd_clean(p[2], shared->scale)};
}

/// A splat with its state, turned to the other side.
typedef struct turned_splat {
    stp_psp_splat splat;
    union {
        double aligned;
        unsigned char bytes[STP_PSP_STATE_MAX];
    } state;
} turned_splat;

/// If signs of normals are a guess (`two_sided`), turns the second of two splats to the side of the
/// first.
static void turn_alike(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                       const stp_psp_splat* a, const stp_psp_splat** b, const void** b_state,
                       turned_splat* room)
{
    if (!shared->desc.two_sided || stp_dot(a->ellipse.normal, (*b)->ellipse.normal) >= 0.0f) {
        return;
    }
    room->splat = **b;
    room->splat.ellipse.normal = stp_scale((*b)->ellipse.normal, -1.0f);
    *b = &room->splat;
    if (metric->turn != NULL) {
        assert(metric->state_bytes <= sizeof(room->state));
        memcpy(room->state.bytes, *b_state, metric->state_bytes);
        metric->turn(room->state.bytes);
        *b_state = room->state.bytes;
    }
}

/// The splat of the lower key is the first.
static void sort_pair(const stp_psp_splat** a, const void** a_state, const stp_psp_splat** b,
                      const void** b_state)
{
    if ((*b)->key < (*a)->key) {
        const stp_psp_splat* splat = *a;
        const void* state = *a_state;
        *a = *b;
        *a_state = *b_state;
        *b = splat;
        *b_state = state;
    }
}

float stp_psp_pair_error(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                         const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                         const void* b_state)
{
    assert(a->key != b->key && "splats represent different points");
    turned_splat turned;
    sort_pair(&a, &a_state, &b, &b_state);
    turn_alike(shared, metric, a, &b, &b_state, &turned);
    if (!(stp_dot(a->ellipse.normal, b->ellipse.normal) >= shared->desc.min_cosine)) {
        return HUGE_VALF;
    }
    double error = metric->error(shared, a, a_state, b, b_state);
    if (metric->by_length) {
        error *= (double)stp_length(stp_sub(b->ellipse.center, a->ellipse.center));
    }
    return error <= (double)FLT_MAX ? error > 0.0 ? (float)error : 0.0f : FLT_MAX;
}

void stp_psp_merge_pair(const stp_psp_shared* shared, const stp_psp_metric_table* metric,
                        const stp_psp_splat* a, const void* a_state, const stp_psp_splat* b,
                        const void* b_state, stp_psp_splat* merged, void* merged_state)
{
    assert(merged != a && merged != b && "outputs do not alias inputs");
    turned_splat turned;
    sort_pair(&a, &a_state, &b, &b_state);
    turn_alike(shared, metric, a, &b, &b_state, &turned);
    float share = a->area / (a->area + b->area);
    assert(!(share < 0.0f) && !(share > 1.0f) && "areas are not negative");
    for (int k = 0; k < 3; ++k) {
        merged->color[k] = share * a->color[k] + (1.0f - share) * b->color[k];
    }
    merged->key = a->key;
    metric->merge(shared, a, a_state, b, b_state, merged, merged_state);
}
