// SPDX-License-Identifier: MIT
#include "raster/splat_groups.h"

#include "base/splats/splat_codes.h"
#include "raster/splats_kernel.h"

#include <assert.h>
#include <math.h>

void stp_raster_find_eye(const stp_raster_camera* camera, const stp_raster_splats* splats,
                         float eye[3])
{
    const float origin[3] = {splats->origin.x, splats->origin.y, splats->origin.z};
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        square += (double)camera->view[2][k] * (double)camera->view[2][k];
    }
    for (int k = 0; k < 3; ++k) {
        double at = 0.0;
        for (int r = 0; r < 3; ++r) {
            at -= (double)camera->view[r][k] * (double)camera->view[r][3] / square;
        }
        double gaze = (double)camera->view[2][k] / sqrt(square);
        eye[k] = camera->parallel ? (float)gaze
                                  : (float)((at - (double)origin[k]) / (double)splats->step);
    }
}

stp_raster_groups stp_raster_groups_make(const stp_raster_camera* camera,
                                         const stp_raster_splats* splats,
                                         const stp_raster_frame* frame)
{
    assert(!(frame->margin < 0.0f));
    stp_raster_groups groups = {.width = (float)frame->width + 2.0f * frame->margin,
                                .height = (float)frame->height + 2.0f * frame->margin,
                                .per_code = splats->radius / splats->step,
                                .parallel = camera->parallel,
                                .one_sided = frame->one_sided};
    stp_splats_fold_row(camera->matrix.m[0], splats, groups.x);
    stp_splats_fold_row(camera->matrix.m[1], splats, groups.y);
    stp_splats_fold_row(camera->matrix.m[3], splats, groups.w);
    for (int k = 0; k < 4; ++k) { // with its margin, the picture begins at 0
        groups.x[k] += frame->margin * groups.w[k];
        groups.y[k] += frame->margin * groups.w[k];
    }
    stp_raster_find_eye(camera, splats, groups.eye);
    return groups;
}

bool stp_raster_drops_group(const stp_raster_groups* g, const stp_splat_group* group)
{
    float grow = stp_shape_radius(group->largest) * g->per_code;
    float center[3], half[3], square = 0.0f;
    for (int k = 0; k < 3; ++k) {
        assert(group->low[k] <= group->high[k]);
        center[k] = 0.5f * ((float)group->low[k] + (float)group->high[k]);
        half[k] = 0.5f * ((float)group->high[k] - (float)group->low[k]);
        square += half[k] * half[k];
    }
    // culled if the whole box is beyond one plane of the picture
    float at[4] = {g->x[3], -g->x[3], g->y[3], -g->y[3]}, reach[4] = {0}, depth = g->w[3],
          deep = 0.0f;
    const float sides[4] = {0.0f, g->width, 0.0f, g->height};
    for (int side = 0; side < 4; ++side) {
        at[side] += sides[side] * g->w[3];
    }
    for (int k = 0; k < 3; ++k) {
        float wide = half[k] + grow;
        const float rows[4] = {g->x[k], g->width * g->w[k] - g->x[k], g->y[k],
                               g->height * g->w[k] - g->y[k]};
        for (int side = 0; side < 4; ++side) {
            at[side] += rows[side] * center[k];
            reach[side] += fabsf(rows[side]) * wide;
        }
        depth += g->w[k] * center[k];
        deep += fabsf(g->w[k]) * wide;
    }
    bool beyond = depth + deep <= 0.0f;
    for (int side = 0; side < 4; ++side) {
        beyond = beyond || at[side] + reach[side] * 1.001f < 0.0f;
    }
    if (beyond || !g->one_sided || group->sine == 255) {
        return beyond;
    }
    // culled if all normals face away from the eye, seen from anywhere in the box (as for clusters
    // of triangles)
    float sine = (float)group->sine / 255.0f, along = 0.0f, length = 0.0f;
    float scale =
        1.0f / sqrtf((float)(group->axis[0] * group->axis[0] + group->axis[1] * group->axis[1] +
                             group->axis[2] * group->axis[2]));
    for (int k = 0; k < 3; ++k) {
        float d = g->parallel ? g->eye[k] : center[k] - g->eye[k];
        along += d * (float)group->axis[k] * scale;
        length += d * d;
    }
    float radius = g->parallel ? 0.0f : sqrtf(square);
    return along >= sine * sqrtf(length) + radius;
}
