// SPDX-License-Identifier: MIT
#include "draw/gl/cluster_shares.h"

#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"
#include "draw/placement.h"

#include <assert.h>

enum { GRAIN = 1024 }; ///< clusters per task of the loop

struct stp_gl_share_item {
    size_t item;  ///< index in the list
    size_t first; ///< index of its first share
    const stp_draw_item* draw;
    stp_clusters clusters;
    stp_bounding bounding;
    stp_level_choice choice; ///< of a level
};

static stp_gl_share_item* add_item(stp_gl_renderer* r)
{
    stp_gl_cluster_shares* s = &r->frame.shares;
    if (s->count == s->capacity) {
        if (!STP_MAKE_ROOM(r->base.context, s->items, s->capacity, s->count + 1)) {
            return NULL;
        }
    }
    return &s->items[s->count++];
}

static stp_result list_items(stp_gl_renderer* r, size_t* cluster_count)
{
    stp_placed_item where;
    *cluster_count = 0;
    for (size_t i = 0; i < r->list->count; ++i) {
        const stp_draw_item* draw = &r->list->items[i];
        if (draw->kind != STP_DRAW_MESH || draw->large ||
            !stp_store_is_clustered(r->store, draw->index)) {
            continue;
        }
        stp_gl_share_item* item = add_item(r);
        if (item == NULL) {
            return stp_fail_memory(r->base.context);
        }
        float offset[3];
        stp_mesh_offset(r->store, r->directory, draw, offset);
        stp_result result = stp_store_get_clusters(r->store, draw->index, &item->clusters);
        if (result != STP_OK) {
            return result;
        }
        stp_placement_place(&r->placement, draw, offset, &where);
        item->item = i;
        item->first = *cluster_count;
        item->draw = draw;
        item->bounding =
            stp_bounding_make((const float(*)[4])where.camera.matrix.m, where.camera.nearness_limit,
                              offset, r->target.width, r->target.height);
        if (draw->is_level) {
            item->choice = stp_level_choice_make(r->directory, draw,
                                                 (const float(*)[4])where.camera.matrix.m, offset);
        }
        *cluster_count += item->clusters.cluster_count;
    }
    return STP_OK;
}

static float share_of(const stp_gl_share_item* item, uint32_t cluster)
{
    const stp_draw_item* draw = item->draw;
    if (draw->is_level && !stp_level_choice_draws(&item->choice, cluster)) {
        return 0.0f;
    }
    stp_box box = stp_clusters_bounds(&item->clusters, cluster);
    float share = stp_draw_share(draw, stp_bounding_min_depth(&item->bounding, box));
    bool originals =
        draw->is_level && stp_bounding_max_depth(&item->bounding, box) < draw->level_from;
    bool drawn = share > 0.0f && !originals && !stp_bounding_misses(&item->bounding, box);
    return drawn ? share : 0.0f;
}

/// Shares of clusters [begin, end) of all items.
static void find_shares(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_gl_cluster_shares* s = user;
    (void)worker;
    size_t low = 0, high = s->count;
    while (high - low > 1) { // the last item that begins at or before `begin`
        size_t middle = low + (high - low) / 2;
        *(s->items[middle].first <= begin ? &low : &high) = middle;
    }
    assert(s->count > 0 && s->items[low].first <= begin);
    for (size_t i = begin; i < end; ++i) {
        while (i - s->items[low].first >= s->items[low].clusters.cluster_count) {
            low += 1;
            assert(low < s->count && "items hold all clusters");
        }
        const stp_gl_share_item* item = &s->items[low];
        s->shares[i] = share_of(item, (uint32_t)(i - item->first));
    }
}

stp_result stp_gl_cluster_shares_find(stp_gl_renderer* r)
{
    stp_gl_cluster_shares* s = &r->frame.shares;
    size_t count;
    s->count = s->next = 0;
    stp_result result = list_items(r, &count);
    if (result == STP_OK && count > s->share_capacity) {
        if (!STP_MAKE_ROOM(r->base.context, s->shares, s->share_capacity, count)) {
            return stp_fail_memory(r->base.context);
        }
    }
    if (result != STP_OK || count == 0) {
        return result;
    }
    if (count <= GRAIN) { // waking the threads would take longer
        find_shares(0, count, 0, s);
    } else {
        stp_parallel_for(r->base.context, count, GRAIN, find_shares, s);
    }
    return STP_OK;
}

const float* stp_gl_cluster_shares_get(stp_gl_cluster_shares* s, size_t item)
{
    while (s->items[s->next].item < item) {
        s->next += 1;
        assert(s->next < s->count && "only meshes of clusters have shares");
    }
    assert(s->items[s->next].item == item && "items are asked for in the order of the list");
    return s->shares + s->items[s->next].first;
}

void stp_gl_cluster_shares_destroy(stp_context* context, stp_gl_cluster_shares* s)
{
    stp_free(context, s->items);
    stp_free(context, s->shares);
    *s = (stp_gl_cluster_shares){0};
}
