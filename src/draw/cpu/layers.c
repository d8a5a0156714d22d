// SPDX-License-Identifier: MIT
#include "draw/cpu/layers.h"

#include "draw/transparency.h"
#include "raster/splats_transparent.h"

#include <assert.h>
#include <string.h>

bool stp_cpu_wants_layers(const stp_cpu_renderer* r, const stp_draw_style* style)
{
    return r->layers.possible && style->transparency != STP_TRANSPARENCY_PATTERN;
}

static size_t tiles_of(uint32_t pixels, uint32_t size)
{
    return ((size_t)pixels + size - 1) / size;
}

/// Whether the layers touch the tile of a pixel.
static bool* touched_at(const stp_cpu_renderer* r, size_t x, size_t y)
{
    assert(x < r->width && y < r->height);
    return &r->layers.touched[y / SHADE_ROWS * tiles_of(r->width, SHADE_WIDTH) + x / SHADE_WIDTH];
}

static size_t count_tiles(const stp_cpu_renderer* r)
{
    return tiles_of(r->width, SHADE_WIDTH) * tiles_of(r->height, SHADE_ROWS);
}

static void touch_all(stp_cpu_renderer* r)
{
    memset(r->layers.touched, true, count_tiles(r) * sizeof(bool));
}

/// Column after the last one of the tile that begins at a column.
static size_t end_of_tile(const stp_cpu_renderer* r, size_t x)
{
    return x + SHADE_WIDTH < r->width ? x + SHADE_WIDTH : r->width;
}

static bool make_room(stp_cpu_renderer* r)
{
    stp_cpu_layers* l = &r->layers;
    stp_context* context = r->base.context;
    size_t needed = (size_t)r->width * r->height;
    if (!STP_MAKE_ROOM(context, l->touched, l->touched_capacity, count_tiles(r))) {
        return false;
    }
    if (l->width != r->width || l->height != r->height) {
        touch_all(r);
        l->width = r->width;
        l->height = r->height;
    }
    if (needed > l->capacity) {
        stp_cpu_destroy_layers(r);
        touch_all(r);
        l->nearer = STP_NEW_ARRAY(context, uint64_t, needed);
        l->farther = STP_NEW_ARRAY(context, uint64_t, needed);
        l->splats_below = STP_NEW_ARRAY(context, float, needed);
        l->light = STP_NEW_ARRAY(context, float, 4 * needed);
        l->optical_depths = STP_NEW_ARRAY(context, atomic_uint, needed);
        l->mark_count = needed / STP_LAYER_MARKED + 1;
        l->marks = STP_NEW_ARRAY(context, bool, r->team.threads * l->mark_count);
        if (l->nearer == NULL || l->farther == NULL || l->splats_below == NULL ||
            l->light == NULL || l->optical_depths == NULL || l->marks == NULL) {
            stp_cpu_destroy_layers(r);
            return false;
        }
        l->capacity = needed;
    }
    return true;
}

void stp_cpu_begin_layers(stp_cpu_renderer* r)
{
    stp_cpu_layers* l = &r->layers;
    l->stage = CPU_LAYERS_NONE;
    if (!stp_cpu_wants_layers(r, r->style)) {
        return;
    }
    l->nearest_only = r->style->transparency == STP_TRANSPARENCY_NEAREST;
    if (make_room(r)) {
        l->stage = CPU_LAYERS_OPAQUE;
    } else if (!l->warned) {
        l->warned = true;
        stp_warn(r->base.context,
                 "the memory limit leaves no room for layers of transparent surfaces in a picture "
                 "of %ux%u: "
                 "they are drawn as a pattern of pixels",
                 r->width, r->height);
    }
}

/// Prepares pixels for their first layer.
static void clear_pixels(stp_cpu_layers* l, size_t begin, size_t count)
{
    memset(l->nearer + begin, 0, count * sizeof(*l->nearer));
    for (size_t at = begin; at < begin + count; ++at) {
        l->splats_below[at] = FLT_MAX;
        atomic_store_explicit(&l->optical_depths[at], 0, memory_order_relaxed);
    }
    for (size_t at = begin; at < begin + count; ++at) {
        l->light[4 * at] = l->light[4 * at + 1] = l->light[4 * at + 2] = 0.0f;
        l->light[4 * at + 3] = 1.0f;
    }
}

/// Prepares the touched tiles of whole rows of tiles.
static void clear_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    (void)worker;
    assert(begin % SHADE_ROWS == 0);
    for (size_t y = begin; y < end; ++y) {
        for (size_t x = 0; x < r->width; x += SHADE_WIDTH) {
            bool* touched = touched_at(r, x, y);
            if (*touched) {
                clear_pixels(&r->layers, y * r->width + x, end_of_tile(r, x) - x);
            }
            *touched = *touched && (y + 1) % SHADE_ROWS != 0 && y + 1 < end;
        }
    }
}

/// Before a worker's first task of a layer: forgets where it drew fragments of the one before.
static void clear_marks(const stp_cpu_renderer* r, uint32_t worker)
{
    const stp_cpu_layers* l = &r->layers;
    size_t used = (size_t)r->width * r->height / STP_LAYER_MARKED + 1;
    assert(used <= l->mark_count && worker < r->team.threads);
    memset(l->marks + worker * l->mark_count, 0, used * sizeof(bool));
}

bool stp_cpu_has_layer(const stp_cpu_renderer* r, const stp_cpu_shade_tile* tile)
{
    const stp_cpu_layers* l = &r->layers;
    assert(l->stage == CPU_LAYERS_PEEL && tile->width > 0);
    bool any = false;
    for (uint32_t row = 0; row < tile->height; ++row) {
        size_t at = (size_t)(tile->y + row) * r->width + tile->x;
        size_t first = at / STP_LAYER_MARKED, last = (at + tile->width - 1) / STP_LAYER_MARKED;
        for (uint32_t k = 0; k < r->team.threads; ++k) {
            const bool* marks = l->marks + k * l->mark_count;
            for (size_t i = first; i <= last && r->workers[k].drew; ++i) {
                any = any || marks[i];
            }
        }
    }
    return any;
}

/// Whether an item may have transparent parts.
static bool may_have(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    return item->kind == STP_DRAW_MESH ? item->glass != STP_TRANSPARENT_NOWHERE
                                       : item->kind == STP_DRAW_SPLATS && r->layers.of_splats;
}

/// Marks the tasks that may have visible fragments, one byte each. @param any whether there are any
static stp_result list_tasks(stp_cpu_renderer* r, bool* any)
{
    stp_cpu_layers* l = &r->layers;
    *any = false;
    if (!STP_MAKE_ROOM(r->base.context, l->alive, l->alive_capacity, r->task_count)) {
        return stp_fail_memory(r->base.context);
    }
    stp_result result = STP_OK;
    for (size_t i = 0; i < r->item_count && result == STP_OK; ++i) {
        uint32_t end = i + 1 < r->item_count ? r->items[i + 1].first_task : r->task_count;
        assert(r->items[i].first_task <= end && end <= r->task_count && "tasks ascend");
        bool may = may_have(r, &r->items[i]);
        *any = *any || may;
        memset(l->alive + r->items[i].first_task, may, end - r->items[i].first_task);
    }
    return result;
}

static void draw_tasks(size_t begin, size_t end, uint32_t index, void* user)
{
    stp_cpu_renderer* r = user;
    stp_cpu_worker* worker = &r->workers[index];
    stp_raster_target target = {
        .width = r->width, .height = r->height, .stride = r->width, .pixels = worker->pixels};
    assert(begin < end && end <= r->task_count);
    const stp_cpu_item* item = stp_cpu_item_of_task(r, (uint32_t)begin);
    for (uint32_t task = (uint32_t)begin; task < end; ++task) {
        const stp_cpu_item* last = r->items + r->item_count - 1;
        while (item < last && item[1].first_task <= task) {
            item += 1;
        }
        if (r->layers.alive[task] != 0) {
            if (!worker->drew) {
                clear_marks(r, index);
            }
            worker->drew = true;
            worker->layer_found = 0;
            stp_cpu_draw_task(r, item, task, false, &target, worker);
            r->layers.alive[task] =
                worker->layer_found > 0; // fewer fragments lie behind after each pass
        }
    }
}

static void shade_bands(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    stp_cpu_shade_rows(r, (uint32_t)begin, (uint32_t)end, &r->workers[worker]);
}

/// Minimum nearness of splats that belong to the surface of a splat.
static float find_below(const stp_cpu_renderer* r, const stp_cpu_item* item, float nearness)
{
    double thickness =
        (double)STP_TRANSPARENT_THICKNESS * (double)item->radius * (double)item->scale;
    double scale = r->nearness_scale;
    return (float)(r->frame.parallel ? (double)nearness + scale * thickness
                                     : scale / (scale / (double)nearness + thickness));
}

/// Opacity of the layer that stands for all layers in a pixel: the sum of depths includes a
/// triangle of the layer, but not a splat.
static float find_whole_opacity(stp_cpu_layers* l, size_t at, float own, bool splat)
{
    uint32_t depth = atomic_load_explicit(&l->optical_depths[at], memory_order_relaxed);
    float clear = exp2f((float)depth * (-1.0f / (float)STP_OPTICAL_UNIT));
    return 1.0f - (splat ? 1.0f - own : 1.0f) * clear;
}

/// Composites one pixel of a layer.
static void add_pixel(stp_cpu_layers* l, size_t at, const float color[3], float alpha)
{
    float* light = l->light + 4 * at;
    float share = light[3] * stp_clamp(alpha, 0.0f, 1.0f);
    for (int c = 0; c < 3; ++c) {
        light[c] += share * stp_clamp(color[c], 0.0f, 1.0f);
    }
    light[3] -= share;
}

void stp_cpu_take_layer(stp_cpu_renderer* r, stp_cpu_worker* worker, const stp_cpu_shade_tile* tile)
{
    stp_cpu_layers* l = &r->layers;
    const stp_cpu_shade_memory* memory = worker->shading;
    const stp_cpu_shade_lanes* lanes = &memory->lanes;
    assert(l->stage == CPU_LAYERS_PEEL && lanes->wants_linear &&
           "layers are composited in linear light");
    *touched_at(r, tile->x, tile->y) = true;
    for (uint32_t row = 0; row < tile->height; ++row) {
        const stp_cpu_shade_merged* merged = &tile->rows[row];
        size_t first = (size_t)(tile->y + row) * r->width + tile->x;
        for (uint32_t i = tile->row_runs[row]; i < tile->row_runs[row + 1]; ++i) {
            const stp_cpu_shade_run* run = &tile->runs[i];
            if (run->surface == SHADE_EMPTY) {
                continue;
            }
            const stp_cpu_item* item = &r->items[memory->item[run->surface]];
            bool splat = item->kind != STP_DRAW_MESH;
            for (uint32_t k = 0; k < run->length && run->x + k < tile->width; ++k) {
                uint32_t x = run->x + k, lane = run->lane + (run->flat ? k / SHADE_REACH : k);
                const float color[3] = {lanes->linear[0][lane], lanes->linear[1][lane],
                                        lanes->linear[2][lane]};
                size_t at = first + x;
                float opacity = memory->surfaces[lanes->surface[lane]].color[3];
                opacity = l->nearest_only ? find_whole_opacity(l, at, opacity, splat) : opacity;
                add_pixel(l, at, color, opacity);
                l->nearer[at] = stp_raster_pixel(merged->nearness[x], merged->ids[x + 1]);
                if (splat) {
                    l->splats_below[at] = find_below(r, item, merged->nearness[x]);
                }
                if (l->light[4 * at + 3] < STP_LAYERS_CLEAR) {
                    l->nearer[at] = STP_RASTER_EMPTY;
                }
                worker->layer_pixels += 1;
            }
        }
    }
}

/// Begins the layers of an eye, whose opaque pixels were merged; those of other eyes may not be.
static void keep_opaque(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].drew_opaque = r->workers[i].drew;
        r->workers[i].drew = false;
        r->workers[i].layer_pixels = 0;
    }
}

/// After the layers of an eye.
static void return_to_opaque(stp_cpu_renderer* r)
{
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        r->workers[i].drew = r->workers[i].drew_opaque;
    }
}

/// Pixels of a drawn layer.
static uint64_t count_pixels(stp_cpu_renderer* r)
{
    uint64_t pixels = 0;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        pixels += r->workers[i].layer_pixels;
        r->workers[i].layer_pixels = 0;
        r->workers[i].drew = false;
    }
    return pixels;
}

/// Composites the layers over pixels of the picture. @return those that were empty before
static uint64_t compose_pixels(stp_cpu_renderer* r, size_t begin, size_t end)
{
    uint64_t covered = 0;
    for (size_t at = begin; at < end; ++at) {
        const float* light = r->layers.light + 4 * at;
        uint8_t* out = r->image->pixels + 4 * at;
        if (light[3] >= 1.0f) {
            continue;
        }
        float behind = (float)out[3] * (1.0f / 255.0f), clear = light[3] * behind;
        float coverage = 1.0f - light[3] + clear, whole = 1.0f / coverage;
        for (int c = 0; c < 3; ++c) {
            float linear = (light[c] + clear * r->decode[out[c]]) * whole;
            int place = (int)(linear * (float)CPU_ENCODE_SIZE);
            out[c] = r->encode[place < CPU_ENCODE_SIZE ? place : CPU_ENCODE_SIZE - 1];
        }
        covered += out[3] == 0;
        out[3] = (uint8_t)(coverage * 255.0f + 0.5f);
        if (out[3] == 0) {
            memset(out, 0, 4);
        }
    }
    return covered;
}

static void compose_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    for (size_t y = begin; y < end; ++y) {
        for (size_t x = 0; x < r->width; x += SHADE_WIDTH) {
            if (*touched_at(r, x, y)) {
                size_t row = y * r->width;
                r->workers[worker].covered += compose_pixels(r, row + x, row + end_of_tile(r, x));
            }
        }
    }
}

stp_result stp_cpu_draw_layers(stp_cpu_renderer* r)
{
    stp_cpu_layers* l = &r->layers;
    bool any;
    assert(l->stage == CPU_LAYERS_OPAQUE && "layers begin before anything is drawn");
    stp_result result = list_tasks(r, &any);
    l->stage = CPU_LAYERS_PEEL;
    r->occluding = NULL;
    keep_opaque(r);
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, clear_rows, r);
    uint32_t most = l->nearest_only ? 1 : STP_LAYERS_MAX;
    for (l->count = 0; any && l->count < most && result == STP_OK; ++l->count) {
        size_t grain = r->task_count / ((size_t)r->team.threads * 64);
        stp_team_run(&r->team, r->task_count, grain > 0 ? grain : 1, draw_tasks, r);
        for (uint32_t i = 0; i < r->team.threads; ++i) {
            if (r->workers[i].failed) {
                result = stp_fail_memory(r->base.context);
            }
        }
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, shade_bands, r);
        any = count_pixels(r) > 0;
        result = result == STP_OK && stp_cpu_is_stopped(r) ? STP_ERROR_CANCELLED : result;
    }
    return_to_opaque(r);
    l->count -= l->count > 0 && !any; // the last pass found none
    if (l->count > 0 && result == STP_OK) {
        stp_team_run(&r->team, r->height, CPU_BAND_ROWS, compose_rows, r);
    }
    if (result != STP_OK) { // fragments may be drawn that were not composited
        touch_all(r);
    }
    assert(l->count <= STP_LAYERS_MAX);
    l->stage = CPU_LAYERS_OPAQUE;
    return result;
}

void stp_cpu_destroy_layers(stp_cpu_renderer* r)
{
    stp_cpu_layers* l = &r->layers;
    stp_context* context = r->base.context;
    stp_free(context, l->nearer);
    stp_free(context, l->farther);
    stp_free(context, l->splats_below);
    stp_free(context, l->light);
    stp_free(context, l->optical_depths);
    stp_free(context, l->marks);
    l->marks = NULL;
    l->mark_count = 0;
    l->optical_depths = NULL;
    l->nearer = l->farther = NULL;
    l->splats_below = l->light = NULL;
    l->capacity = 0;
}

uint32_t stp_cpu_pick_transparent(const stp_cpu_renderer* r, const stp_cpu_item* item,
                                  bool transparent, stp_raster_splats* splats,
                                  stp_cpu_worker* worker)
{
    assert(splats->begin % 16 == 0 && splats->begin <= splats->end && "bits in words of 16");
    uint32_t others = 0, left = 0;
    size_t words = ((size_t)splats->end + 15) / 16;
    uint16_t* bits = stp_arena_alloc(&worker->scratch, words * sizeof(*bits));
    if (bits == NULL) {
        worker->failed = true;
        return 0;
    }
    const uint8_t *materials = item->splats.materials, *coverages = item->coverages;
    for (uint32_t first = splats->begin; first < splats->end; first += 16) {
        uint32_t count = splats->end - first < 16 ? splats->end - first : 16, glass = 0;
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t is = r->layers.of_shading[materials[first + i]] != 0;
            glass |= (is & (uint32_t)(coverages != NULL &&
                                      stp_cpu_coverage_share(item, coverages[first + i]) < 255))
                     << i;
        }
        uint32_t wanted = splats->wanted != NULL ? splats->wanted[first / 16] : 0xFFFFu;
        wanted &= (1u << count) - 1u;
        uint32_t kept = wanted & (transparent ? glass : ~glass);
        bits[first / 16] = (uint16_t)kept;
        left += (uint32_t)__builtin_popcount(kept);
        others |= wanted & ~kept;
    }
    assert(left <= splats->end - splats->begin);
    if (others != 0) {
        splats->wanted = bits;
    }
    return left;
}

void stp_cpu_draw_transparent(const stp_cpu_renderer* r, const stp_cpu_item* item,
                              const stp_raster_splats* splats, const stp_raster_target* target,
                              stp_cpu_worker* worker)
{
    assert(r->layers.stage != CPU_LAYERS_OPAQUE && "transparent splats would hide opaque ones");
    const stp_raster_layer layer = stp_cpu_make_layer(r, worker);
    const stp_raster_transparency glass = {
        .layer = r->layers.stage == CPU_LAYERS_PEEL ? &layer : NULL,
        .seed = item->seed,
        .sample = r->pattern,
        .share = item->draw->ghost ? stp_cpu_ghost_share(r) : 1.0f};
    worker->fragments +=
        stp_raster_draw_transparent(target, &item->camera, splats, item->first_id, &glass);
}
