// SPDX-License-Identifier: MIT
// Draws items in tasks. Any free worker takes the next task; each draws into its own buffer.
#include "draw/cpu/layers.h"
#include "draw/cpu/passes.h"
#include "draw/cpu/triangle.h"
#include "draw/placement.h"
#include "draw/transparency.h"

#include <assert.h>
#include <string.h>

/// The last item whose first task is at or before `task`.
const stp_cpu_item* stp_cpu_item_of_task(const stp_cpu_renderer* r, uint32_t task)
{
    assert(r->item_count > 0 && task < r->task_count);
    size_t low = 0, high = r->item_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (r->items[middle].first_task <= task) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(r->items[low].first_task <= task);
    return &r->items[low];
}

// In radii. Measured on a CAD assembly of fins and ribs from 26 directions, at the distance where
// its splats just suffice: the median SSIM of covered pixels rises from 0.48 (0, 0) over 0.62 (2,
// 0) to 0.69 (4, 2); beyond, surfaces begin to show through those in front (`stipple-lab bench
// quality`).
#define RIM_DEPTH 4.0f
#define BACK_DEPTH 2.0f

/// @return whether some were occluded
static bool record_hidden(const uint16_t* bits, uint32_t begin, uint32_t end)
{
    assert(begin % 16 == 0 && "words belong to one task");
    uint16_t any = 0;
    for (uint32_t i = begin / 16; i < (end + 15) / 16; ++i) {
        any |= bits[i];
    }
    return any != 0;
}

/// Tasks drawn by a pass.
typedef struct task_loop {
    stp_cpu_renderer* r;
    uint32_t first;
    uint32_t first_new; ///< earlier tasks draw only content occluded so far
} task_loop;

typedef void (*range_drawer)(const stp_cpu_renderer* r, const stp_cpu_item* item,
                             const stp_raster_splats* splats, const stp_raster_target* target,
                             stp_cpu_worker* worker);

static void draw_range(const stp_cpu_renderer* r, const stp_cpu_item* item,
                       const stp_raster_splats* splats, const stp_raster_target* target,
                       stp_cpu_worker* worker)
{
    if (r->blend.stage != CPU_BLEND_NONE) {
        stp_cpu_blend_range(r, item, splats);
        return;
    }
    worker->fragments +=
        stp_raster_draw_splats(target, 0, r->height, &item->camera, splats, item->first_id);
}

/// Marks no splat of [begin, end) as occluded.
static void clear_hidden(const stp_raster_splats* splats, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin / 16; splats->hidden != NULL && i < (end + 15) / 16; ++i) {
        splats->hidden[i] = 0;
    }
}

/// Draws the splats of a task, run by run.
static void draw_runs(stp_cpu_renderer* r, const stp_cpu_item* item, stp_raster_splats* splats,
                      const stp_raster_target* target, stp_cpu_worker* worker, range_drawer draw)
{
    uint32_t begin = splats->begin, end = splats->end, run = 0;
    if (item->runs == NULL || item->draw->scattered) {
        draw(r, item, splats, target, worker);
        return;
    }
    while (run < item->draw->run_count && item->runs[run].end <= begin) {
        run += 1;
    }
    for (uint32_t at = begin; at < end; ++run) {
        bool none = run == item->draw->run_count || item->runs[run].begin >= end;
        assert((none || run == 0 || item->runs[run - 1].end <= item->runs[run].begin) &&
               "runs ascend");
        uint32_t from = none ? end : item->runs[run].begin;
        clear_hidden(splats, at, from);
        splats->begin = at = from > at ? from : at;
        if (!none) {
            splats->end = at = item->runs[run].end < end ? item->runs[run].end : end;
            splats->nearest = item->runs[run].nearest;
            splats->farthest = item->runs[run].farthest;
            draw(r, item, splats, target, worker);
        }
    }
}

/// Draws splats of which some may be transparent: these skip the occlusion test.
static void draw_both(stp_cpu_renderer* r, const stp_cpu_item* item, stp_raster_splats* splats,
                      bool late, const stp_raster_target* target, stp_cpu_worker* worker)
{
    stp_raster_splats opaque = *splats, glass = *splats;
    if (splats->normals == NULL) { // fixed-size points, all opaque
        if (r->layers.stage != CPU_LAYERS_PEEL) {
            draw_runs(r, item, &opaque, target, worker, draw_range);
        }
        return;
    }
    if (r->layers.stage != CPU_LAYERS_PEEL) {
        stp_cpu_pick_transparent(r, item, false, &opaque, worker);
        draw_runs(r, item, &opaque, target, worker, draw_range);
    }
    if (r->layers.stage == CPU_LAYERS_OPAQUE || r->blend.stage != CPU_BLEND_NONE || late) {
        return;
    }
    glass.hidden = NULL;
    glass.occluder = NULL;
    if (stp_cpu_pick_transparent(r, item, true, &glass, worker) > 0) {
        draw_runs(r, item, &glass, target, worker, stp_cpu_draw_transparent);
    }
}

static float shape_scale(const stp_draw_item* draw)
{
    return draw->shape_scale > 0.0f ? draw->shape_scale : 1.0f;
}

/// Selects the splats whose ranges hold the level at their depth. @return false if there are none,
/// or memory is short
static bool pick_levels(const stp_cpu_renderer* r, const stp_cpu_item* item,
                        stp_raster_splats* splats, stp_cpu_worker* worker)
{
    if (item->kind != STP_DRAW_SPLATS || item->splats.ranges == NULL) {
        return true;
    }
    assert(splats->begin % 16 == 0);
    stp_raster_levels levels = {.per_depth = item->draw->level_per_depth,
                                .minimum = item->draw->level_min,
                                .divide = item->draw->divide,
                                .below = item->draw->level_below,
                                .errors = item->splats.errors,
                                .groups = item->splats.groups,
                                .one_sided = stp_draw_one_sided(item->draw, r->layers.of_splats),
                                .beside_triangles = item->draw->beside_triangles,
                                .width = r->width,
                                .height = r->height};
    uint16_t* bits = STP_ARENA_ARRAY(&worker->scratch, uint16_t, ((size_t)splats->end + 15) / 16);
    if (bits == NULL) {
        worker->failed = true;
        return false;
    }
    bool any = stp_raster_pick_levels(&item->camera, splats, item->splats.ranges, &levels, bits);
    splats->wanted = bits;
    return any;
}

/// Selects the splats of a scattered item's runs. @return false if there are none, or memory is
/// short
static bool pick_runs(const stp_cpu_item* item, stp_raster_splats* splats, stp_cpu_worker* worker)
{
    if (!item->draw->scattered || item->runs == NULL) {
        return true;
    }
    uint32_t low = 0, high = item->draw->run_count;
    while (low < high) { // the first run that ends after the beginning
        uint32_t middle = low + (high - low) / 2;
        *(item->runs[middle].end <= splats->begin ? &low : &high) =
            item->runs[middle].end <= splats->begin ? middle + 1 : middle;
    }
    uint16_t* bits = STP_ARENA_ARRAY(&worker->scratch, uint16_t, ((size_t)splats->end + 15) / 16);
    if (bits == NULL) {
        worker->failed = true;
        return false;
    }
    assert(splats->begin % 16 == 0 && "whole words are cleared");
    assert(low == 0 || item->runs[low - 1].end <= splats->begin);
    bool any = false;
    memset(bits + splats->begin / 16, 0,
           (((size_t)splats->end + 15) / 16 - splats->begin / 16) * sizeof(*bits));
    for (uint32_t r = low; r < item->draw->run_count && item->runs[r].begin < splats->end; ++r) {
        uint32_t at = item->runs[r].begin > splats->begin ? item->runs[r].begin : splats->begin;
        uint32_t end = item->runs[r].end < splats->end ? item->runs[r].end : splats->end;
        for (; at < end && (at % 16 != 0 || end - at < 16); ++at) {
            bits[at / 16] |= (uint16_t)(1u << at % 16);
            any = true;
        }
        for (; end - at >= 16; at += 16) {
            bits[at / 16] = 0xFFFF;
            any = true;
        }
        for (; at < end; ++at) {
            bits[at / 16] |= (uint16_t)(1u << at % 16);
        }
    }
    splats->wanted = bits;
    return any;
}

/// Sets the wanted size of points. They are drawn in full: such pictures have no occlusion test
/// (may_occlude), and sections are tested separately.
static void fix_size(const stp_cpu_renderer* r, const stp_cpu_item* item, stp_raster_splats* splats)
{
    if (stp_point_size_is_fixed(r->style, item->draw)) {
        stp_point_radius radius = stp_point_radius_of(r->style, item->draw);
        splats->radius = radius.units;
        splats->pixels = radius.pixels;
        splats->rim_depth = STP_POINT_RIM_DEPTH;
        splats->normals = NULL;
        splats->shapes = NULL;
        splats->materials = NULL;
        splats->coverages = NULL;
    }
}

/// Draws splats [begin, end) of a task. `late`: those occluded so far.
static void draw_splats(stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t begin, uint32_t end,
                        bool late, const stp_raster_target* target, stp_cpu_worker* worker)
{
    assert(begin <= end && begin % 16 == 0 && "bits of tasks share no word");
    stp_raster_splats splats = {.begin = begin,
                                .end = end,
                                .radius = item->radius,
                                .seed = stp_cpu_sample_seed(r, item),
                                .squares = r->style->splat_shape == STP_SPLAT_SQUARE &&
                                           !stp_cpu_has_filter(r->style),
                                .drawn = stp_cpu_is_counted(r, item) ? &worker->splats : NULL};
    if (item->kind == STP_DRAW_SPLATS) {
        splats.positions = item->splats.positions;
        splats.normals = item->splats.normals;
        splats.origin = item->splats.origin;
        splats.step = item->splats.step;
        splats.coverages = item->coverages;
        splats.low_coverages = item->low_coverages;
        splats.plain_coverages = item->splats.plain_coverages;
        splats.shapes = item->splats.shapes;
        splats.radius = splats.shapes != NULL
                            ? item->splats.step * stp_cpu_splat_scale(r) * shape_scale(item->draw)
                            : splats.radius;
        if (splats.shapes == NULL && r->growths != NULL) {
            splats.materials = item->splats.materials;
            splats.growths = r->growths;
            splats.growth_share = item->growth_share;
        }
        splats.low_share = (uint32_t)(256.0f * (1.0f - item->blend) + 0.5f);
        assert(splats.low_share <= 256);
        splats.low_count = item->coverages != NULL && splats.low_share > 0 ? item->low_count : 0;
        splats.rim_depth = RIM_DEPTH;
        splats.back_depth = item->splats.unknown_signs ? 0.0f : BACK_DEPTH;
        splats.occluder = r->occluding != NULL ? &item->occluder : NULL;
        splats.hidden = r->occluding != NULL ? r->eye->late + item->late : NULL;
    } else {
        splats.points = item->points.positions;
    }
    fix_size(r, item, &splats);
    if (late && splats.hidden != NULL) { // most are still occluded: test them before any other work
        if (!stp_raster_test_splats(&splats, splats.hidden)) {
            return;
        }
        splats.wanted = splats.hidden;
        splats.hidden = NULL;
        splats.occluder = NULL;
    }
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    bool filtered = item->draw->sections != 0 || item->draw->ghost || stp_cpu_hides_some(r, item) ||
                    stp_cpu_drops_backs(r, item);
    bool left = late || (pick_levels(r, item, &splats, worker) && pick_runs(item, &splats, worker));
    if (item->draw->scattered && item->runs != NULL) {
        splats.nearest = item->runs[0].nearest;
        splats.farthest = item->runs[0].farthest;
    }
    if (filtered && left && !stp_cpu_filter_splats(r, item, &splats, worker)) {
        worker->failed = true;
    } else if (!left) {
        clear_hidden(&splats, splats.begin, splats.end);
    } else if (item->kind == STP_DRAW_SPLATS && r->layers.of_splats) {
        draw_both(r, item, &splats, late, target, worker);
    } else {
        draw_runs(r, item, &splats, target, worker, draw_range);
    }
    stp_arena_rewind(&worker->scratch, mark);
}

static void draw_triangles(stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t begin,
                           uint32_t end, const stp_raster_target* target, stp_cpu_worker* worker)
{
    assert(begin <= end && end <= item->count);
    stp_cpu_keep_memory memory = {.triangle = UINT32_MAX};
    const stp_raster_layer layer = stp_cpu_make_layer(r, worker);
    stp_cpu_sections sections;
    stp_cpu_find_sections(r, item, &sections);
    stp_cpu_keep keep = {.renderer = r,
                         .item = item,
                         .first_triangle = begin,
                         .memory = &memory,
                         .sections = &sections,
                         .section_mask = (1u << sections.count) - 1};
    stp_raster_mesh mesh = {.positions = item->mesh.positions,
                            .vertex_count = item->mesh.vertex_count,
                            .triangle_count = end - begin,
                            .offset = {item->offset[0], item->offset[1], item->offset[2]},
                            .facing = stp_cpu_item_facing(r, item),
                            .fragments = &worker->fragments};
    if (keep.section_mask != 0 || stp_cpu_item_needs_keep(item)) {
        mesh.keep = stp_cpu_keep_fragment;
        mesh.keep_user = &keep;
        mesh.layer = r->layers.stage == CPU_LAYERS_PEEL ? &layer : NULL;
    }
    stp_box box = item->mesh.bounds;
    stp_bounding bounding = stp_cpu_bound(r, item);
    float share = stp_draw_share(item->draw, stp_bounding_min_depth(&bounding, box));
    stp_arena_mark mark = stp_arena_get_mark(&worker->scratch);
    size_t corners = 3 * (size_t)(end - begin);
    uint32_t* kept = STP_ARENA_ARRAY(&worker->scratch, uint32_t, corners);
    if (kept == NULL) {
        worker->failed = true;
        return;
    }
    for (size_t i = 0; i < corners; ++i) {
        kept[i] = stp_store_mesh_corner(&item->mesh, 3 * (size_t)begin + i);
    }
    uint32_t left = stp_cpu_drop_triangles(kept, begin, end - begin, share);
    stp_cpu_count_triangles(r, item, left, worker);
    mesh.indices = kept;
    stp_result result = stp_raster_triangles(target, 0, r->height, &item->camera.matrix,
                                             item->camera.nearness_limit, &mesh,
                                             item->first_id + begin, &worker->scratch);
    stp_arena_rewind(&worker->scratch, mark);
    worker->failed = worker->failed || result != STP_OK;
}

bool stp_cpu_draw_task(stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t task, bool late,
                       const stp_raster_target* target, stp_cpu_worker* worker)
{
    uint32_t size = item->task_units;
    uint32_t from = (task - item->first_task) * size;
    assert(task >= item->first_task && from < item->unit_count && "a task of this item");
    uint32_t to = item->unit_count - from < size ? item->unit_count : from + size;
    if (r->blend.stage != CPU_BLEND_NONE && item->kind == STP_DRAW_MESH) {
        return false;
    }
    if (r->layers.stage == CPU_LAYERS_OPAQUE && item->glass == STP_TRANSPARENT_EVERYWHERE) {
        return false;
    }
    if (item->draw->large) {
        bool enough = stp_cpu_draw_large(r, item, from, to, target, worker);
        worker->failed = worker->failed || !enough;
        return false;
    }
    if (item->clusters.bytes != NULL) {
        uint16_t* bits = r->eye->late + item->late + (size_t)2 * (task - item->first_task);
        stp_cpu_cluster_range range = {.begin = from, .end = to, .wanted = UINT32_MAX};
        if (late) {
            range.wanted = (uint32_t)bits[0] | (uint32_t)bits[1] << 16;
        }
        bool enough = (item->draw->is_level ? stp_cpu_draw_level : stp_cpu_draw_clusters)(
            r, item, &range, target, worker);
        worker->failed = worker->failed || !enough;
        if (!late) {
            bits[0] = (uint16_t)range.hidden;
            bits[1] = (uint16_t)(range.hidden >> 16);
        }
        return range.hidden != 0;
    }
    if (item->kind == STP_DRAW_MESH) {
        draw_triangles(r, item, from, to, target, worker);
        return false;
    }
    draw_splats(r, item, from, to, late, target, worker);
    return item->kind == STP_DRAW_SPLATS && r->occluding != NULL &&
           record_hidden(r->eye->late + item->late, from, to);
}

static void draw_tasks(size_t begin, size_t end, uint32_t index, void* user)
{
    const task_loop* loop = user;
    stp_cpu_renderer* r = loop->r;
    begin += loop->first;
    end += loop->first;
    stp_cpu_worker* worker = &r->workers[index];
    stp_raster_target target = {
        .width = r->width, .height = r->height, .stride = r->width, .pixels = worker->pixels};
    assert(begin < end && end <= r->task_count);
    worker->drew = true;
    const stp_cpu_item* item = stp_cpu_item_of_task(r, (uint32_t)begin);
    for (uint32_t task = (uint32_t)begin; task < end && !stp_cpu_is_stopped(r); ++task) {
        const stp_cpu_item* last = r->items + r->item_count - 1;
        while (item < last && item[1].first_task <= task) {
            item += 1;
        }
        bool late = task < loop->first_new;
        if (!late || r->eye->late_tasks[task] != 0) {
            r->eye->late_tasks[task] = stp_cpu_draw_task(r, item, task, late, &target, worker);
        }
    }
}

stp_result stp_cpu_draw_items(stp_cpu_renderer* r, uint32_t first_task)
{
    assert(first_task <= r->task_count);
    task_loop loop = {.r = r, .first = first_task, .first_new = first_task};
    if (first_task > 0) { // test occluded ones again
        loop.first = 0;
    }
    uint32_t count = r->task_count - loop.first;
    if (count == 0) {
        return STP_OK;
    }
    size_t grain = count / ((size_t)r->team.threads * 64);
    stp_team_run(&r->team, count, grain > 0 ? grain : 1, draw_tasks, &loop);
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        if (r->workers[i].failed) {
            return stp_fail_memory(r->base.context);
        }
    }
    return stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : STP_OK;
}
