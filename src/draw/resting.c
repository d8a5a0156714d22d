// SPDX-License-Identifier: MIT
#include "draw/renderer.h"

#include <assert.h>
#include <string.h>

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
    while (b != 0) {
        uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

uint32_t stp_resting_sample(uint32_t side, uint32_t k)
{
    assert(side > 0 && side <= 2048 && "its steps fit 32 bits");
    uint32_t all = side * side, step = (all * 618 + 500) / 1000; // by golden-section steps
    while (common_divisor(step, all) != 1) {
        step += 1;
    }
    return (uint32_t)((uint64_t)k * step % all);
}

static bool is_same_vector(stp_vec3d a, stp_vec3d b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool are_same_sections(const stp_sections* a, const stp_sections* b)
{
    bool same = a->count == b->count;
    for (uint32_t i = 0; same && i < a->count; ++i) {
        same = is_same_vector(a->planes[i].normal, b->planes[i].normal) &&
               a->planes[i].distance == b->planes[i].distance;
    }
    return same;
}

bool stp_resting_is_same_view(const stp_view* a, const stp_view* b)
{
    return is_same_vector(a->eye, b->eye) && is_same_vector(a->target, b->target) &&
           is_same_vector(a->up, b->up) && a->fov_degrees == b->fov_degrees &&
           a->ortho_height == b->ortho_height && a->near_distance == b->near_distance &&
           a->eye_distance == b->eye_distance && a->width == b->width && a->height == b->height &&
           are_same_sections(&a->sections, &b->sections);
}

/// Hash of the drawn items: changes with the quality, and with the resident data.
static stp_hash hash_list(const stp_draw_list* list)
{
    assert((list->run_count == 0 || list->runs != NULL) && "runs are hashed as a whole");
    stp_hash hash = {0};
    for (size_t i = 0; i < list->count; ++i) {
        const stp_draw_item* item = &list->items[i];
        const uint32_t flags = (item->ghost ? 1u : 0u) | (item->large ? 2u : 0u) |
                               (item->beside_triangles ? 4u : 0u) | (item->one_sided ? 8u : 0u) |
                               (item->scattered ? 16u : 0u) | (item->of_points ? 32u : 0u);
        const uint32_t numbers[] = {
            (uint32_t)item->kind, item->index,    item->prefix, item->full_prefix, item->first_run,
            item->run_count,      item->sections, item->divide, item->split_count, flags};
        const float sizes[] = {item->shape_scale, item->radius,          item->switch_begin,
                               item->switch_end,  item->level_per_depth, item->level_min,
                               item->level_below, item->large_from};
        hash = stp_hash_bytes(hash, numbers, sizeof(numbers));
        hash = stp_hash_bytes(hash, sizes, sizeof(sizes));
        hash = stp_hash_bytes(hash, item->transform.m, sizeof(item->transform.m));
    }
    const float whole[] = {list->splat_size, list->mixes ? 1.0f : 0.0f};
    hash = stp_hash_bytes(hash, whole, sizeof(whole));
    return list->run_count > 0
               ? stp_hash_bytes(hash, list->runs, list->run_count * sizeof(*list->runs))
               : hash;
}

bool stp_resting_continues(stp_resting* resting, const stp_view* view, const stp_draw_list* list,
                           const stp_draw_style* style)
{
    stp_hash hash = hash_list(list);
    bool same = stp_resting_is_same_view(&resting->view, view) &&
                stp_hash_equal(resting->list, hash) &&
                stp_draw_style_is_same(&resting->style, style);
    *resting = (stp_resting){.view = *view, .list = hash, .style = *style};
    return same;
}
