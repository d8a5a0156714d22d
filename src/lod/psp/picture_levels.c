// SPDX-License-Identifier: MIT
// Levels of merges that a metric of the paper chose. Its errors have other units than the radius
// that a view asks for, and do not see colours and outlines, so levels are differences of pictures.
#include "lod/psp/forest.h"
#include "lod/psp/region.h"

#include <assert.h>
#include <string.h>

static stp_psp_region region_of_point(const stp_psp_points* p, const stp_psp_forest* f,
                                      uint32_t point)
{
    const float* at = p->positions + 3 * (size_t)point;
    stp_vec3 first = {p->positions[0], p->positions[1], p->positions[2]};
    stp_psp_sample sample = {.position = stp_sub((stp_vec3){at[0], at[1], at[2]}, first),
                             .normal = f->ellipses[point].normal,
                             .color = {255, 255, 255},
                             .area = p->areas[point]};
    if (p->colors != NULL) {
        memcpy(sample.color, stp_psp_color(p, point), 3);
    }
    return stp_psp_region_of(&sample);
}

static stp_psp_region add_regions(const stp_psp_region* a, const stp_psp_region* b, bool two_sided)
{
    double across = 0.0;
    for (int k = 0; k < 3; ++k) {
        across += (double)a->normal[k] * (double)b->normal[k];
    }
    if (!two_sided || across >= 0.0) {
        return stp_psp_region_add(a, b);
    }
    stp_psp_region turned = *b;
    stp_psp_region_turn(&turned);
    return stp_psp_region_add(a, &turned);
}

stp_result stp_psp_measure_pictures(stp_context* context, const stp_psp_points* points,
                                    bool two_sided, stp_psp_forest* forest)
{
    assert(points->count == forest->point_count && points->areas != NULL);
    size_t count = (size_t)forest->point_count + forest->merge_count;
    stp_psp_region* regions = STP_NEW_ARRAY(context, stp_psp_region, count + 1);
    if (regions == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < forest->point_count; ++i) {
        regions[i] = region_of_point(points, forest, i);
    }
    for (uint32_t i = 0; i < forest->merge_count; ++i) {
        stp_psp_merge* merge = &forest->merges[i];
        uint32_t splat = forest->point_count + i;
        assert(merge->left < splat && merge->right < splat && "parts come first");
        regions[splat] = add_regions(&regions[merge->left], &regions[merge->right], two_sided);
        stp_ellipse e =
            stp_psp_region_ellipse(&regions[splat], forest->ellipses[merge->left].normal);
        merge->level = stp_psp_region_error(&regions[splat], &e);
        const uint32_t parts[2] = {merge->left, merge->right};
        for (int k = 0; k < 2; ++k) {
            if (parts[k] >= forest->point_count) {
                merge->level =
                    fmax(merge->level, forest->merges[parts[k] - forest->point_count].level);
            }
        }
    }
    stp_free(context, regions);
    return STP_OK;
}
