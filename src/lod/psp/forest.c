// SPDX-License-Identifier: MIT
#include "lod/psp/forest.h"

#include "base/core/sort.h"
#include "base/math/color.h"
#include "lod/psp/initial.h"
#include "lod/psp/rounds.h"
#include "lod/psp/scale.h"

#include <assert.h>

enum {
    POINTS_MAX = 1 << 30,
    STRIPE = 1 << 20,   ///< pages are released after this many points
    POINT_BYTES = 85,   ///< peak memory per point in bytes; measured
    DISTANCE_BYTES = 70 ///< additional bytes per point for metrics other than STP_PSP_NORMALS
};

stp_psp_desc stp_psp_desc_default(void)
{
    return (stp_psp_desc){.metric = STP_PSP_NORMALS, .neighbours = 8, .eager = true};
}

static stp_box find_box(const stp_psp_rounds* r, const stp_psp_points* points)
{
    stp_box box = stp_box_empty();
    for (size_t i = 0; i < points->count; ++i) {
        const float* p = points->positions + 3 * i;
        if (i % STRIPE == 0) {
            stp_psp_rounds_release(r, 0);
        }
        stp_box_add(&box, (stp_vec3){stp_kd_clean(p[0], 1.0f), stp_kd_clean(p[1], 1.0f),
                                     stp_kd_clean(p[2], 1.0f)});
    }
    return points->count > 0 ? box : (stp_box){0};
}

/// Merges until the target is reached. The caller destroys `rounds`, also after a failure.
static stp_result merge_points(stp_psp_rounds* r, const stp_psp_points* points)
{
    stp_context* context = r->shared.context;
    if (points->count > POINTS_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT, "progressive splats: %u points, at most %d",
                        points->count, POINTS_MAX);
    }
    assert(points->count == 0 || points->areas != NULL || r->shared.desc.metric != STP_PSP_REGIONS);
    stp_box box = find_box(r, points);
    float scale = stp_psp_choose_scale(stp_length(stp_sub(box.max, box.min)));
    float size = scale * stp_length(stp_sub(box.max, box.min));
    stp_vec3 middle = stp_scale(stp_add(stp_scale(box.min, 0.5f), stp_scale(box.max, 0.5f)), scale);
    r->shared.scale = scale;
    r->shared.minimum = size > 0.0f && size < HUGE_VALF ? 1e-9f * size : 1e-3f;
    r->shared.middle = middle;
    r->alone = size > 0.0f ? stp_psp_radius_alone(size) : 1.0f;
    const stp_psp_room* room = &r->rooms[STP_PSP_ROOM_TREE];
    stp_result result = stp_psp_room_open(&r->storage, &r->rooms[STP_PSP_ROOM_POINTS]);
    if (result == STP_OK) {
        result = stp_psp_room_open(&r->storage, &r->rooms[STP_PSP_ROOM_TREE]);
    }
    if (result == STP_OK && r->metric->open != NULL && !r->metric->open(&r->shared)) {
        result = stp_psp_storage_fail(&r->storage);
    }
    if (result == STP_OK) {
        result =
            stp_kd_tree_make_in(context, room, points->positions, points->count, scale, &r->tree);
    }
    result = result == STP_OK ? stp_psp_order_points(r) : result;
    return result == STP_OK ? stp_psp_rounds_run(r) : result;
}

stp_result stp_psp_forest_make(stp_context* context, const stp_psp_points* points,
                               const stp_psp_desc* desc, uint32_t target, stp_psp_forest* forest)
{
    *forest = (stp_psp_forest){.point_count = points->count};
    stp_psp_rounds r;
    stp_psp_desc in_memory = *desc;
    in_memory.spill = NULL;
    stp_psp_rounds_begin(&r, context, points, &in_memory, target);
    r.keep_history = true;
    size_t maximum = 2 * (size_t)points->count + 1;
    stp_result result = STP_OK;
    if (points->count <= POINTS_MAX) { // merge_points rejects larger counts
        forest->ellipses = STP_NEW_ARRAY(context, stp_ellipse, maximum);
        forest->colors = STP_NEW_ARRAY(context, uint8_t, 3 * maximum);
        result =
            forest->ellipses != NULL && forest->colors != NULL ? STP_OK : stp_fail_memory(context);
    }
    r.initial = forest->ellipses;
    result = result == STP_OK ? merge_points(&r, points) : result;
    result = result == STP_OK ? stp_psp_order_merges(&r, forest) : result;
    stp_psp_rounds_destroy(&r);
    if (result != STP_OK) {
        stp_psp_forest_destroy(context, forest);
    }
    return result;
}

void stp_psp_forest_destroy(stp_context* context, stp_psp_forest* forest)
{
    stp_free(context, forest->ellipses);
    stp_free(context, forest->colors);
    stp_free(context, forest->merges);
    stp_free(context, forest->parents);
    *forest = (stp_psp_forest){0};
}

/// Lists the remaining splats, by key.
static stp_result list_splats(const stp_psp_rounds* r, stp_psp_splats* splats)
{
    stp_context* context = r->shared.context;
    size_t count = r->live, numbered = 0;
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, 2 * count + 1);
    const stp_psp_splat** all = STP_NEW_ARRAY(context, const stp_psp_splat*, count + 1);
    splats->ellipses = STP_NEW_ARRAY(context, stp_ellipse, count + 1);
    splats->colors = STP_NEW_ARRAY(context, uint8_t, 3 * count + 1);
    splats->areas = STP_NEW_ARRAY(context, float, count + 1);
    splats->firsts = STP_NEW_ARRAY(context, uint32_t, count + 1);
    bool made = items != NULL && all != NULL && splats->ellipses != NULL &&
                splats->colors != NULL && splats->areas != NULL && splats->firsts != NULL;
    for (uint32_t b = 0; made && b < r->block_count; ++b) {
        for (uint32_t i = 0; i < r->blocks[b].count; ++i, ++numbered) {
            all[numbered] = &r->blocks[b].splats[i];
            items[numbered] = (uint64_t)all[numbered]->key << 32 | numbered;
        }
    }
    assert((!made || numbered == count) && "the blocks hold all remaining splats");
    if (made) {
        const uint64_t* sorted = stp_sort_u64(items, items + count, count, 32, 32);
        for (size_t i = 0; i < count; ++i) {
            const stp_psp_splat* s = all[(uint32_t)sorted[i]];
            splats->ellipses[i] = stp_psp_scale_ellipse(&s->ellipse, r->shared.scale);
            splats->areas[i] = s->area / r->shared.scale / r->shared.scale;
            splats->firsts[i] = s->key;
            for (size_t k = 0; k < 3; ++k) {
                splats->colors[3 * i + k] = stp_linear_to_srgb8(s->color[k]);
            }
        }
        splats->count = (uint32_t)count;
    }
    stp_free(context, items);
    stp_free(context, all);
    return made ? STP_OK : stp_fail_memory(context);
}

uint64_t stp_psp_decimate_bytes(uint32_t count, const stp_psp_desc* desc)
{
    uint64_t each = POINT_BYTES + (desc->metric == STP_PSP_NORMALS ? 0 : DISTANCE_BYTES);
    return each * count;
}

stp_result stp_psp_decimate(stp_context* context, const stp_psp_points* points,
                            const stp_psp_desc* desc, uint32_t target, stp_psp_splats* splats)
{
    *splats = (stp_psp_splats){0};
    stp_psp_rounds r;
    stp_psp_rounds_begin(&r, context, points, desc, target);
    stp_result result = merge_points(&r, points);
    result = result == STP_OK ? list_splats(&r, splats) : result;
    stp_psp_rounds_destroy(&r);
    if (result != STP_OK) {
        stp_psp_splats_destroy(context, splats);
    }
    return result;
}

void stp_psp_splats_destroy(stp_context* context, stp_psp_splats* splats)
{
    stp_free(context, splats->ellipses);
    stp_free(context, splats->colors);
    stp_free(context, splats->areas);
    stp_free(context, splats->firsts);
    *splats = (stp_psp_splats){0};
}
