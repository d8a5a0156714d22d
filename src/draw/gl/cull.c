// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "draw/facing.h"
#include "draw/gl/item_commands.h"
#include "draw/gl/upload.h"
#include "draw/placement.h"
#include "draw/transparency.h"
#include "store/bytes/format.h"
#include "store/sets/large_triangles.h"

#include <assert.h>
#include <string.h>

static stp_bounding bound(const stp_gl_renderer* r, const item_block* item)
{
    return stp_bounding_make(item->rows, item->nearness_limit, item->offset, r->target.width,
                             r->target.height);
}

static bool needs_keep(const stp_gl_renderer* r, const item_block* item, uint32_t present)
{
    const stp_store_material* material = &r->directory->materials[item->material];
    if ((item->flags & ITEM_GHOST) != 0 || item->sections != 0) {
        return true;
    }
    // filters need one more draw call per eye: with one for all triangles, two eyes need at most
    // eight
    if (r->target.eye_count > 1 && r->style->filter != STP_FILTER_NONE) {
        return true;
    }
    if (material->alpha == STP_STORE_OPAQUE) {
        return false;
    }
    float minimum = material->alpha == STP_STORE_MASK ? material->alpha_cutoff : 1.0f;
    return item->base_color != NO_ADDRESS || (present & STP_COLUMN_COLORS) != 0 ||
           material->base_color[3] < minimum;
}

/// Commands that draw the clusters of a mesh.
typedef struct cluster_kinds {
    stp_gl_command_kind kind;
    bool again; ///< also for layers
} cluster_kinds;

static cluster_kinds choose_kinds(const stp_gl_renderer* r, const item_block* item,
                                  uint32_t present)
{
    cluster_kinds kinds = {.kind = GL_COMMANDS_TRIANGLES};
    const stp_store_material* material = &r->directory->materials[item->material];
    bool varies = item->base_color != NO_ADDRESS || (present & STP_COLUMN_COLORS) != 0;
    stp_mesh_transparency glass = stp_transparency_of_mesh(material, varies);
    if (r->layer_pass.active && glass == STP_TRANSPARENT_EVERYWHERE) {
        kinds.kind = GL_COMMANDS_GLASS_TRIANGLES;
    } else if (needs_keep(r, item, present)) {
        kinds.kind = GL_COMMANDS_KEEP;
        kinds.again = r->layer_pass.active && glass == STP_TRANSPARENT_PARTLY;
    }
    return kinds;
}

/// Adds a cluster of `triangles`, of which a share is drawn. @return the record; NULL if out of
/// memory
static record_block* add_cluster(stp_gl_renderer* r, uint32_t index, cluster_kinds kinds,
                                 uint32_t cluster, uint32_t triangles, float share)
{
    record_block* record = stp_gl_frame_add_command(r, kinds.kind, 3 * triangles);
    if (record != NULL) {
        record->item = index;
        record->address = r->frame.items[index].address + CLUSTER_WORDS * cluster;
        record->share = share;
    }
    bool enough = record != NULL &&
                  (!kinds.again ||
                   stp_gl_frame_repeat_command(r, GL_COMMANDS_GLASS_TRIANGLES, 3 * triangles));
    return enough ? record : NULL;
}

static void count_drawn(stp_gl_renderer* r, uint32_t triangles, float share)
{
    r->frame.drawn_triangles += (uint64_t)((double)triangles * (double)share + 0.5);
}

/// Sets where an item is seen from, if some of its triangles are drawn from the front only.
/// @return whether all of them are
static bool place_eye(const stp_gl_renderer* r, uint32_t index, bool* some)
{
    const stp_gl_placed* placed = &r->frame.placed[index];
    item_block* item = &r->frame.items[index];
    const stp_store_material* material = &r->directory->materials[item->material];
    bool all = (material->flags & STP_SHADING_FRONT_ONLY) != 0 &&
               !stp_draws_backs(r->style, &r->view->sections);
    *some =
        (all || placed->draw->is_level) &&
        stp_find_item_eye(&r->placement.frame, &placed->draw->transform, placed->offset, item->eye);
    return all && *some;
}

/// Adds a mesh of columns, without culling: all its clusters have the same share.
static stp_result add_columns(stp_gl_renderer* r, uint32_t index, stp_store_mesh* mesh)
{
    item_block* item = &r->frame.items[index];
    const stp_draw_item* draw = r->frame.placed[index].draw;
    uint32_t present = mesh->colors != NULL ? STP_COLUMN_COLORS : 0u;
    item->flags |= mesh->colors != NULL ? ITEM_HAS_COLORS : 0u;
    item->cluster_count =
        (mesh->triangle_count + UPLOAD_CLUSTER_TRIANGLES - 1) / UPLOAD_CLUSTER_TRIANGLES;
    cluster_kinds kind = choose_kinds(r, item, present);
    stp_bounding bounding = bound(r, item);
    float share = stp_draw_share(draw, stp_bounding_min_depth(&bounding, mesh->bounds));
    bool some, all = place_eye(r, index, &some);
    for (uint32_t i = 0; i < item->cluster_count && share > 0.0f; ++i) {
        uint32_t left = mesh->triangle_count - i * UPLOAD_CLUSTER_TRIANGLES;
        uint32_t count = left < UPLOAD_CLUSTER_TRIANGLES ? left : UPLOAD_CLUSTER_TRIANGLES;
        record_block* record = add_cluster(r, index, kind, i, count, share);
        if (record == NULL) {
            return stp_fail_memory(r->base.context);
        }
        count_drawn(r, count, share);
        record->first = all ? count : 0;
    }
    return STP_OK;
}

stp_result stp_gl_cull_mesh(stp_gl_renderer* r, uint32_t index)
{
    item_block* item = &r->frame.items[index];
    const stp_draw_item* draw = r->frame.placed[index].draw;
    stp_clusters clusters;
    if (!stp_store_is_clustered(r->store, draw->index)) {
        stp_store_mesh mesh;
        stp_result result = stp_store_get_mesh(r->store, draw->index, &mesh);
        return result == STP_OK ? add_columns(r, index, &mesh) : result;
    }
    stp_result result = stp_store_get_clusters(r->store, draw->index, &clusters);
    if (result != STP_OK) {
        return result;
    }
    bool colors = (clusters.present & STP_COLUMN_COLORS) != 0;
    item->flags |= colors ? ITEM_HAS_COLORS : 0u;
    item->cluster_count = clusters.cluster_count;
    cluster_kinds kind = choose_kinds(r, item, clusters.present);
    const float* shares = stp_gl_cluster_shares_get(&r->frame.shares, index);
    bool some, all = place_eye(r, index, &some);
    const stp_store_level_cluster* of_level = NULL;
    if (some && draw->is_level) {
        of_level = r->directory->level_clusters + r->directory->levels[draw->level].first_cluster;
    }
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        if (!(shares[i] > 0.0f)) {
            continue;
        }
        uint32_t triangles = stp_clusters_triangles(&clusters, i);
        record_block* record = add_cluster(r, index, kind, i, triangles, shares[i]);
        if (record == NULL) {
            return stp_fail_memory(r->base.context);
        }
        record->first = all ? triangles : of_level != NULL ? of_level[i].one_sided : 0;
        count_drawn(r, triangles, shares[i]);
    }
    return STP_OK;
}

/// Sets the bits of clusters that have any of the large triangles of an item.
static stp_result mark_clusters(stp_gl_renderer* r, const stp_draw_item* draw,
                                const stp_clusters* clusters)
{
    stp_gl_frame* f = &r->frame;
    stp_large_triangles large;
    stp_result result =
        stp_store_get_large_triangles(r->store, draw->index, draw->large_min, &large);
    size_t words = (size_t)clusters->cluster_count / 32 + 1;
    if (result != STP_OK) {
        return result;
    }
    if (!STP_MAKE_ROOM(r->base.context, f->marks, f->mark_capacity, words)) {
        return stp_fail_memory(r->base.context);
    }
    uint32_t* marks = f->marks;
    memset(marks, 0, words * sizeof(*marks));
    uint32_t count = stp_large_triangles_find(&large, draw->large_from);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t cluster = stp_clusters_find(clusters, large.triangles[i]);
        assert(cluster < clusters->cluster_count && "there is a bit for it");
        marks[cluster / 32] |= 1u << cluster % 32;
    }
    f->large_count += count;
    f->drawn_triangles += count;
    return STP_OK;
}

stp_result stp_gl_cull_large(stp_gl_renderer* r, uint32_t index)
{
    item_block* item = &r->frame.items[index];
    const stp_draw_item* draw = r->frame.placed[index].draw;
    stp_clusters clusters;
    stp_result result = stp_store_get_clusters(r->store, draw->index, &clusters);
    result = result == STP_OK ? mark_clusters(r, draw, &clusters) : result;
    if (result != STP_OK) {
        return result;
    }
    item->flags |= ITEM_LARGE | ((clusters.present & STP_COLUMN_COLORS) != 0 ? ITEM_HAS_COLORS : 0);
    item->cluster_count = clusters.cluster_count;
    item->level_per_depth = draw->level_per_depth;
    item->level_min = draw->level_min;
    item->large_from = draw->switch_begin > 0.0f ? draw->switch_begin : -HUGE_VALF;
    cluster_kinds kind = choose_kinds(r, item, clusters.present);
    stp_bounding bounding = bound(r, item);
    bool some, all = place_eye(r, index, &some);
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        bool marked = (r->frame.marks[i / 32] >> i % 32 & 1) != 0;
        if (!marked || stp_bounding_misses(&bounding, stp_clusters_bounds(&clusters, i))) {
            continue;
        }
        uint32_t triangles = stp_clusters_triangles(&clusters, i);
        record_block* record = add_cluster(r, index, kind, i, triangles, 1.0f);
        if (record == NULL) {
            return stp_fail_memory(r->base.context);
        }
        record->first = all ? triangles : 0;
    }
    return STP_OK;
}
