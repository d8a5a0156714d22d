// SPDX-License-Identifier: MIT
#include "spt_drawing.h"

#include "base/clock.h"
#include "base/octahedral.h"
#include "base/splat_codes.h"
#include "draw/placement.h"
#include "lod/method.h"
#include "lod/surfels.h"
#include "raster/splats.h"
#include "store/internal.h"

#include <string.h>

enum { WIDTH = 1920, HEIGHT = 1080, BLOCK = 4096 };

struct spt_drawing {
    stp_context* context;
    stp_surfels set; ///< the sequence
    uint64_t* pixels;
    uint16_t* bits; ///< a bit a splat
    // of the nodes of the tree, and of a block of those that a traversal selects
    uint16_t *positions, *block_positions;
    int8_t *normals, *block_normals;
    uint32_t *shapes, *block_shapes;
    float radius;
};

static void make_nodes(spt_drawing* d, const stp_point_tree* tree)
{
    const float origin[3] = {d->set.origin.x, d->set.origin.y, d->set.origin.z};
    for (size_t i = 0; i < tree->count; ++i) {
        const stp_disk* disk = &tree->disks[i];
        const float center[3] = {disk->center.x, disk->center.y, disk->center.z};
        for (size_t k = 0; k < 3; ++k) {
            float at = (center[k] - origin[k]) / d->set.step + 0.5f;
            d->positions[3 * i + k] = (uint16_t)fminf(fmaxf(at, 0.0f), 65535.0f);
        }
        stp_octahedral_encode(disk->normal, d->normals + 2 * i);
        d->shapes[i] = stp_shape_disk(disk->radius / d->set.step, 0, false);
    }
}

stp_result spt_drawing_create(stp_context* context, const stp_point_tree* tree,
                              const stp_surfels* samples, spt_drawing** drawing)
{
    stp_method_options options = stp_method_options_default();
    spt_drawing* d = STP_NEW_ZEROED(context, spt_drawing, 1);
    *drawing = d;
    if (d == NULL) {
        return stp_fail_memory(context);
    }
    d->context = context;
    options.tree.color_threshold = 255; // as of the trees that are measured
    const stp_method_source source = {.samples = samples};
    stp_result result = stp_method_by_id(STP_METHOD_SPT)->make(context, &source, &options, &d->set);
    if (result != STP_OK) {
        return result;
    }
    size_t count = tree->count;
    d->pixels = STP_NEW_ARRAY(context, uint64_t, (size_t)WIDTH * HEIGHT);
    d->bits = STP_NEW_ARRAY(context, uint16_t, (size_t)d->set.count / 16 + 1);
    d->set.groups =
        STP_NEW_ARRAY(context, stp_splat_group, (size_t)stp_store_group_count(d->set.count) + 1);
    d->positions = STP_NEW_ARRAY(context, uint16_t, 3 * count);
    d->normals = STP_NEW_ARRAY(context, int8_t, 2 * count);
    d->shapes = STP_NEW_ARRAY(context, uint32_t, count);
    d->block_positions = STP_NEW_ARRAY(context, uint16_t, 3 * BLOCK);
    d->block_normals = STP_NEW_ARRAY(context, int8_t, 2 * BLOCK);
    d->block_shapes = STP_NEW_ARRAY(context, uint32_t, BLOCK);
    if (d->pixels == NULL || d->bits == NULL || d->set.groups == NULL || d->positions == NULL ||
        d->normals == NULL || d->shapes == NULL || d->block_positions == NULL ||
        d->block_normals == NULL || d->block_shapes == NULL) {
        return stp_fail_memory(context);
    }
    make_nodes(d, tree);
    stp_store_make_groups(&d->set, 0, d->set.count);
    return STP_OK;
}

void spt_drawing_destroy(spt_drawing* d)
{
    if (d == NULL) {
        return;
    }
    void* arrays[] = {d->pixels,          d->bits,          d->set.groups,
                      d->positions,       d->normals,       d->shapes,
                      d->block_positions, d->block_normals, d->block_shapes};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(d->context, arrays[i]);
    }
    stp_surfels_destroy(d->context, &d->set);
    stp_free(d->context, d);
}

static bool make_camera(const stp_tree_view* from, stp_vec3d target, stp_raster_camera* camera)
{
    static const float nowhere[3] = {0.0f, 0.0f, 0.0f};
    stp_view view = {.eye = from->eye,
                     .target = target,
                     .up = {0, 1, 0},
                     .fov_degrees = 60.0,
                     .width = WIDTH,
                     .height = HEIGHT};
    stp_vec3d gaze = stp_subd(target, from->eye);
    if (fabs(gaze.y) > 0.99 * sqrt(gaze.x * gaze.x + gaze.y * gaze.y + gaze.z * gaze.z)) {
        view.up = (stp_vec3d){0, 0, 1};
    }
    stp_view_frame frame;
    if (!stp_view_frame_make(&view, &frame)) {
        return false;
    }
    const stp_placement placement = {.frame = frame, .nearness_scale = frame.near_distance};
    stp_draw_item item = {.kind = STP_DRAW_SURFELS, .transform = stp_affine_identity()};
    stp_placed_item placed;
    stp_placement_place(&placement, &item, nowhere, &placed);
    *camera = placed.camera;
    return true;
}

static stp_raster_splats splats_of(const stp_surfels* set, uint32_t count)
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

static void clear(spt_drawing* d)
{
    memset(d->pixels, 0xFF, sizeof(*d->pixels) * WIDTH * HEIGHT);
}

static double draw_traversal(spt_drawing* d, const stp_point_tree* tree, uint32_t* nodes,
                             const stp_tree_view* view, const stp_raster_camera* camera,
                             spt_times* times)
{
    const stp_raster_target target = {WIDTH, HEIGHT, WIDTH, d->pixels};
    clear(d);
    double start = stp_clock_ms();
    uint32_t count = stp_point_tree_traverse(tree, view, nodes);
    for (uint32_t begin = 0; begin < count; begin += BLOCK) {
        uint32_t size = count - begin < BLOCK ? count - begin : BLOCK;
        for (size_t i = 0; i < size; ++i) {
            size_t node = nodes[begin + i];
            memcpy(d->block_positions + 3 * i, d->positions + 3 * node, 6);
            memcpy(d->block_normals + 2 * i, d->normals + 2 * node, 2);
            d->block_shapes[i] = d->shapes[node];
        }
        stp_surfels block = {.positions = d->block_positions,
                             .normals = d->block_normals,
                             .shapes = d->block_shapes,
                             .origin = d->set.origin,
                             .step = d->set.step};
        stp_raster_splats splats = splats_of(&block, size);
        (void)stp_raster_draw_splats(&target, 0, HEIGHT, camera, &splats, begin);
    }
    times->traversal_splats += count;
    return stp_clock_ms() - start;
}

/// @return milliseconds in all; those of the test in `test_ms`
static double draw_sequence(spt_drawing* d, const stp_tree_view* view, double nearest,
                            const stp_raster_camera* camera, bool grouped, uint64_t* drawn,
                            double* test_ms)
{
    const stp_raster_target target = {WIDTH, HEIGHT, WIDTH, d->pixels};
    const stp_prefix_table* table = &d->set.table;
    clear(d);
    double start = stp_clock_ms();
    double per_depth = 0.5 * view->allowed; // levels are half errors
    uint32_t count = d->set.count;
    for (uint32_t i = 0; i < table->size && count == d->set.count; ++i) {
        count = (double)table->radius[i] <= per_depth * nearest ? table->count[i] : count;
    }
    stp_raster_splats splats = splats_of(&d->set, count);
    stp_raster_levels levels = {.per_depth = (float)per_depth,
                                .groups = grouped ? d->set.groups : NULL,
                                .one_sided = grouped,
                                .width = WIDTH,
                                .height = HEIGHT};
    (void)stp_raster_pick_levels(camera, &splats, d->set.ranges, &levels, d->bits);
    *test_ms += stp_clock_ms() - start;
    splats.wanted = d->bits;
    (void)stp_raster_draw_splats(&target, 0, HEIGHT, camera, &splats, 0);
    double took = stp_clock_ms() - start;
    for (uint32_t i = 0; i < (count + 15) / 16; ++i) {
        *drawn += (uint64_t)__builtin_popcount(d->bits[i]);
    }
    return took;
}

void spt_drawing_measure(spt_drawing* d, const stp_point_tree* tree, uint32_t* nodes,
                         const stp_tree_view* view, stp_vec3d target, spt_times* times)
{
    stp_raster_camera camera;
    if (!make_camera(view, target, &camera)) {
        return;
    }
    double nearest = HUGE_VAL;
    for (uint32_t i = 0; i < d->set.count; i += 64) { // near enough for a benchmark: the groups'
        const stp_splat_group* g = &d->set.groups[i / STP_GROUP_SPLATS];
        double depth = (double)camera.matrix.m[3][3];
        const float origin[3] = {d->set.origin.x, d->set.origin.y, d->set.origin.z};
        for (int k = 0; k < 3; ++k) {
            double row = (double)camera.matrix.m[3][k];
            double at = row < 0.0 ? (double)g->high[k] : (double)g->low[k];
            depth += row * ((double)origin[k] + (double)d->set.step * at);
        }
        nearest = fmin(nearest, depth);
    }
    times->traversal_ms += draw_traversal(d, tree, nodes, view, &camera, times);
    times->sequence_ms +=
        draw_sequence(d, view, nearest, &camera, false, &times->sequence_splats, &times->test_ms);
    times->group_ms +=
        draw_sequence(d, view, nearest, &camera, true, &times->group_splats, &times->group_test_ms);
}
