// SPDX-License-Identifier: MIT
// Difference between pictures of a splat and of the surface it represents (region.h).
#include "lod/psp/metric.h"
#include "lod/psp/region.h"

#include <assert.h>
#include <string.h>

static stp_ellipse find_ellipse(const stp_psp_shared* shared, const stp_psp_region* region,
                                stp_vec3 fallback)
{
    stp_ellipse e = stp_psp_region_ellipse(region, fallback);
    e.center = stp_add(e.center, shared->middle);
    return e;
}

static void begin(const stp_psp_shared* shared, uint32_t point, stp_psp_splat* splat, void* state)
{
    const stp_psp_points* p = shared->points;
    stp_psp_sample sample = {.position = stp_sub(splat->ellipse.center, shared->middle),
                             .normal = splat->ellipse.normal,
                             .color = {255, 255, 255},
                             .area = p->areas[point] * shared->scale * shared->scale};
    if (p->normals != NULL) {
        const float* n = p->normals + 3 * (size_t)point;
        stp_vec3 given = {n[0], n[1], n[2]};
        sample.normal = stp_dot(given, given) > 0.0f ? given : sample.normal;
    }
    if (p->colors != NULL) {
        memcpy(sample.color, stp_psp_color(p, point), 3);
    }
    assert(!(sample.area < 0.0f));
    stp_psp_region region = stp_psp_region_of(&sample);
    memcpy(state, &region, sizeof(region));
    splat->ellipse = find_ellipse(shared, &region, sample.normal);
    splat->area = sample.area;
}

static double measure(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                      const stp_psp_splat* b, const void* b_state)
{
    (void)shared;
    (void)b;
    stp_psp_region both = stp_psp_region_add(a_state, b_state);
    stp_ellipse e = stp_psp_region_ellipse(&both, a->ellipse.normal);
    return stp_psp_region_error(&both, &e);
}

static void merge(const stp_psp_shared* shared, const stp_psp_splat* a, const void* a_state,
                  const stp_psp_splat* b, const void* b_state, stp_psp_splat* merged,
                  void* merged_state)
{
    (void)b;
    stp_psp_region both = stp_psp_region_add(a_state, b_state);
    memcpy(merged_state, &both, sizeof(both));
    merged->ellipse = find_ellipse(shared, &both, a->ellipse.normal);
    merged->area = (float)both.area;
}

static void turn(void* state)
{
    stp_psp_region region;
    memcpy(&region, state, sizeof(region));
    stp_psp_region_turn(&region);
    memcpy(state, &region, sizeof(region));
}

const stp_psp_metric_table stp_psp_metric_regions = {
    .state_bytes = sizeof(stp_psp_region),
    .power = 2,
    .begin = begin,
    .error = measure,
    .merge = merge,
    .turn = turn,
};
