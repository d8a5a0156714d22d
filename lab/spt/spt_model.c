// SPDX-License-Identifier: MIT
#include "lab/spt/spt_model.h"

#include "base/core/context.h"
#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "draw/placement.h"
#include "lod/method.h"
#include "lod/set_columns.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

static void place_nodes(spt_model* m)
{
    const float origin[3] = {m->set.origin.x, m->set.origin.y, m->set.origin.z};
    for (size_t i = 0; i < m->tree->count; ++i) {
        const stp_tree_disk* disk = &m->tree->disks[i];
        const float center[3] = {disk->center.x, disk->center.y, disk->center.z};
        for (size_t k = 0; k < 3; ++k) {
            float at = (center[k] - origin[k]) / m->set.step + 0.5f;
            m->positions[3 * i + k] = (uint16_t)fminf(fmaxf(at, 0.0f), 65535.0f);
        }
        stp_octahedral_encode(disk->normal, m->normals + 2 * i);
        m->shapes[i] = stp_shape_disk(disk->radius / m->set.step, 0, false);
    }
}

stp_result spt_model_create(stp_context* context, const stp_point_tree* tree,
                            const stp_splats* samples, spt_model* model)
{
    spt_model* m = model;
    stp_method_options options = stp_method_options_default();
    *m = (spt_model){.context = context, .tree = tree};
    options.tree.color_threshold = 255; // as of the trees that are measured
    const stp_method_source source = {.samples = samples};
    stp_result result = stp_method_by_id(STP_METHOD_SPT)->make(context, &source, &options, &m->set);
    if (result != STP_OK) {
        return result;
    }
    options.tree.error = STP_TREE_SPLIT;
    result = stp_method_by_id(STP_METHOD_SPT)->make(context, &source, &options, &m->directed);
    if (result != STP_OK) {
        return result;
    }
    size_t count = tree->count;
    m->set.groups =
        STP_NEW_ARRAY(context, stp_splat_group, (size_t)stp_store_group_count(m->set.count) + 1);
    m->bits = STP_NEW_ARRAY(context, uint16_t, (size_t)m->set.count / 16 + 1);
    m->positions = STP_NEW_ARRAY(context, uint16_t, 3 * count);
    m->normals = STP_NEW_ARRAY(context, int8_t, 2 * count);
    m->shapes = STP_NEW_ARRAY(context, uint32_t, count);
    if (m->set.groups == NULL || m->bits == NULL || m->positions == NULL || m->normals == NULL ||
        m->shapes == NULL) {
        return stp_fail_memory(context);
    }
    place_nodes(m);
    memset(m->set.coverages, STP_COVERAGE_WHOLE, m->set.count); // nodes have none
    memset(m->directed.coverages, STP_COVERAGE_WHOLE, m->directed.count);
    stp_store_make_groups(&m->set, 0, m->set.count);
    return STP_OK;
}

void spt_model_destroy(spt_model* m)
{
    if (m->context == NULL) {
        return;
    }
    void* arrays[] = {m->set.groups, m->bits, m->positions, m->normals, m->shapes};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(m->context, arrays[i]);
    }
    stp_splats_destroy(m->context, &m->set);
    stp_splats_destroy(m->context, &m->directed);
}

/// The depth of the group that reaches nearest to the eye.
static double find_nearest(const spt_model* m, const stp_raster_camera* camera)
{
    const float origin[3] = {m->set.origin.x, m->set.origin.y, m->set.origin.z};
    double nearest = HUGE_VAL;
    for (uint32_t i = 0; i < stp_store_group_count(m->set.count); ++i) {
        const stp_splat_group* g = &m->set.groups[i];
        double depth = (double)camera->matrix.m[3][3];
        for (int k = 0; k < 3; ++k) {
            double row = (double)camera->matrix.m[3][k];
            double at = row < 0.0 ? (double)g->high[k] : (double)g->low[k];
            depth += row * ((double)origin[k] + (double)m->set.step * at);
        }
        nearest = fmin(nearest, depth);
    }
    return nearest;
}

/// The part of a set that a level can need.
static uint32_t find_prefix(const stp_splats* set, double level)
{
    const stp_prefix_table* table = &set->table;
    for (uint32_t i = 0; i < table->size; ++i) {
        if ((double)table->radius[i] <= level) {
            assert(table->count[i] <= set->count);
            return table->count[i];
        }
    }
    return set->count;
}

bool spt_model_make_view(const spt_model* m, const stp_tree_view* from, stp_vec3d target,
                         spt_view* view)
{
    static const float nowhere[3] = {0.0f, 0.0f, 0.0f};
    *view = (spt_view){.tree = *from,
                       .view = {.eye = from->eye,
                                .target = target,
                                .up = {0, 1, 0},
                                .fov_degrees = 60.0,
                                .width = SPT_WIDTH,
                                .height = SPT_HEIGHT},
                       .per_depth = (float)(0.5 * from->allowed)}; // levels are half errors
    stp_vec3d gaze = stp_subd(target, from->eye);
    if (fabs(gaze.y) > 0.99 * sqrt(gaze.x * gaze.x + gaze.y * gaze.y + gaze.z * gaze.z)) {
        view->view.up = (stp_vec3d){0, 0, 1};
    }
    stp_view_frame frame;
    if (!stp_view_frame_make(&view->view, &frame)) {
        return false;
    }
    const stp_placement placement = {.frame = frame, .nearness_scale = frame.near_distance};
    stp_draw_item item = {.kind = STP_DRAW_SPLATS, .transform = stp_affine_identity()};
    stp_placed_item placed;
    stp_placement_place(&placement, &item, nowhere, &placed);
    view->camera = placed.camera;
    double level = 0.5 * from->allowed * find_nearest(m, &view->camera);
    view->prefix = find_prefix(&m->set, level);
    view->directed_prefix = find_prefix(&m->directed, level);
    return true;
}

stp_raster_splats spt_model_splats(const stp_splats* set, uint32_t count)
{
    return (stp_raster_splats){.positions = set->positions,
                               .normals = set->normals,
                               .shapes = set->shapes,
                               .end = count,
                               .origin = set->origin,
                               .step = set->step,
                               .radius = set->step,
                               .rim_depth = 4.0f,
                               .back_depth = 2.0f};
}

const stp_splats* spt_model_set(const spt_model* m, spt_way way)
{
    return way == SPT_DIRECTED ? &m->directed : &m->set;
}

uint32_t spt_view_prefix(const spt_view* view, spt_way way)
{
    return way == SPT_DIRECTED ? view->directed_prefix : view->prefix;
}

void spt_model_pick(spt_model* m, const spt_view* view, spt_way way)
{
    const stp_splats* set = spt_model_set(m, way);
    const stp_raster_splats splats = spt_model_splats(set, spt_view_prefix(view, way));
    const stp_raster_levels levels = {.per_depth = view->per_depth,
                                      .errors = set->errors,
                                      .groups = way == SPT_GROUPED ? set->groups : NULL,
                                      .one_sided = way == SPT_GROUPED,
                                      .width = SPT_WIDTH,
                                      .height = SPT_HEIGHT};
    (void)stp_raster_pick_levels(&view->camera, &splats, set->ranges, &levels, m->bits);
}

uint64_t spt_model_count(const spt_model* m, const spt_view* view, spt_way way)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < (spt_view_prefix(view, way) + 15) / 16; ++i) {
        count += (uint64_t)__builtin_popcount(m->bits[i]);
    }
    return count;
}
