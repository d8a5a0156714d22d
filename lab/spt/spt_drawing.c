// SPDX-License-Identifier: MIT
#include "lab/spt/spt_drawing.h"

#include "base/core/clock.h"
#include "base/core/context.h"

#include <assert.h>
#include <string.h>

struct spt_drawing {
    spt_model* model;
    uint64_t* pixels;
    // columns of a block of nodes that a traversal selected
    uint16_t* positions;
    int8_t* normals;
    uint32_t* shapes;
};

stp_result spt_drawing_create(spt_model* model, spt_drawing** drawing)
{
    stp_context* context = model->context;
    spt_drawing* d = STP_NEW_ZEROED(context, spt_drawing, 1);
    *drawing = d;
    if (d == NULL) {
        return stp_fail_memory(context);
    }
    d->model = model;
    d->pixels = STP_NEW_ARRAY(context, uint64_t, (size_t)SPT_WIDTH * SPT_HEIGHT);
    d->positions = STP_NEW_ARRAY(context, uint16_t, 3 * SPT_BLOCK);
    d->normals = STP_NEW_ARRAY(context, int8_t, 2 * SPT_BLOCK);
    d->shapes = STP_NEW_ARRAY(context, uint32_t, SPT_BLOCK);
    bool whole =
        d->pixels != NULL && d->positions != NULL && d->normals != NULL && d->shapes != NULL;
    return whole ? STP_OK : stp_fail_memory(context);
}

void spt_drawing_destroy(spt_drawing* d)
{
    if (d == NULL) {
        return;
    }
    stp_context* context = d->model->context;
    void* arrays[] = {d->pixels, d->positions, d->normals, d->shapes};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    stp_free(context, d);
}

static void clear(spt_drawing* d)
{
    memset(d->pixels, 0xFF, sizeof(*d->pixels) * SPT_WIDTH * SPT_HEIGHT);
}

static uint64_t count_covered(const spt_drawing* d)
{
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)SPT_WIDTH * SPT_HEIGHT; ++i) {
        count += d->pixels[i] != UINT64_MAX ? 1 : 0;
    }
    return count;
}

static stp_raster_target target_of(const spt_drawing* d)
{
    return (stp_raster_target){SPT_WIDTH, SPT_HEIGHT, SPT_WIDTH, d->pixels};
}

static stp_splats gather(spt_drawing* d, const uint32_t* nodes, uint32_t count)
{
    const spt_model* m = d->model;
    assert(count <= SPT_BLOCK);
    for (size_t i = 0; i < count; ++i) {
        size_t node = nodes[i];
        assert(node < m->tree->count);
        memcpy(d->positions + 3 * i, m->positions + 3 * node, 6);
        memcpy(d->normals + 2 * i, m->normals + 2 * node, 2);
        d->shapes[i] = m->shapes[node];
    }
    return (stp_splats){.positions = d->positions,
                        .normals = d->normals,
                        .shapes = d->shapes,
                        .origin = m->set.origin,
                        .step = m->set.step};
}

static void draw_traversal(spt_drawing* d, uint32_t* nodes, const spt_view* view, spt_times* times)
{
    const stp_raster_target target = target_of(d);
    clear(d);
    double start = stp_clock_ms(), from = start;
    uint32_t count = stp_point_tree_traverse(d->model->tree, &view->tree, nodes);
    for (uint32_t begin = 0; begin < count; begin += SPT_BLOCK) {
        uint32_t size = count - begin < SPT_BLOCK ? count - begin : SPT_BLOCK;
        stp_splats block = gather(d, nodes + begin, size);
        stp_raster_splats splats = spt_model_splats(&block, size);
        times->gather_ms += stp_clock_ms() - from;
        (void)stp_raster_draw_splats(&target, 0, SPT_HEIGHT, &view->camera, &splats, begin);
        from = stp_clock_ms();
    }
    times->traversal_ms += stp_clock_ms() - start;
    times->traversal_splats += count;
    times->traversal_pixels += count_covered(d);
}

/// Figures of a way to draw the sequence.
typedef struct way_figures {
    double *draw_ms, *test_ms;
    uint64_t *splats, *pixels;
} way_figures;

static way_figures figures_of(spt_times* t, spt_way way)
{
    switch (way) {
    case SPT_GROUPED:
        return (way_figures){&t->group_ms, &t->group_test_ms, &t->group_splats, &t->group_pixels};
    case SPT_DIRECTED:
        return (way_figures){&t->directed_ms, &t->directed_test_ms, &t->directed_splats,
                             &t->directed_pixels};
    case SPT_PLAIN:
        break;
    }
    return (way_figures){&t->sequence_ms, &t->test_ms, &t->sequence_splats, &t->sequence_pixels};
}

static void draw_sequence(spt_drawing* d, const spt_view* view, spt_way way, spt_times* times)
{
    const stp_raster_target target = target_of(d);
    spt_model* m = d->model;
    clear(d);
    double start = stp_clock_ms();
    spt_model_pick(m, view, way);
    double test_ms = stp_clock_ms() - start;
    stp_raster_splats splats = spt_model_splats(spt_model_set(m, way), spt_view_prefix(view, way));
    splats.wanted = m->bits;
    (void)stp_raster_draw_splats(&target, 0, SPT_HEIGHT, &view->camera, &splats, 0);
    double took = stp_clock_ms() - start;
    way_figures figures = figures_of(times, way);
    *figures.draw_ms += took;
    *figures.test_ms += test_ms;
    *figures.splats += spt_model_count(m, view, way);
    *figures.pixels += count_covered(d);
}

void spt_drawing_measure(spt_drawing* d, uint32_t* nodes, const spt_view* view, spt_times* times)
{
    draw_traversal(d, nodes, view, times);
    draw_sequence(d, view, SPT_PLAIN, times);
    draw_sequence(d, view, SPT_GROUPED, times);
    draw_sequence(d, view, SPT_DIRECTED, times);
    times->directed_examined += view->directed_prefix;
}
