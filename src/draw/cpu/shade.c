// SPDX-License-Identifier: MIT
// Shades the visibility buffer, tile by tile.
#include "draw/cpu/shade.h"

#include "base/math/color.h"
#include "draw/cpu/layers.h"
#include "draw/shading_setup.h"

#include <assert.h>
#include <string.h>

/// Parameters of one band of the picture.
typedef struct shader {
    stp_cpu_renderer* r;
    stp_cpu_worker* worker;
    stp_cpu_shade_memory* memory;
    const stp_cpu_shade_kernels* kernels;
    stp_cpu_shade_scene scene;
    stp_draw_heights heights;
    uint32_t buffer_count;
    uint64_t** buffers; ///< pixels of the workers that drew
    uint32_t empty;     ///< colour of background pixels
} shader;

static uint8_t encode(const stp_cpu_renderer* r, float linear)
{
    float scaled = linear * (float)CPU_ENCODE_SIZE;
    float top = (float)(CPU_ENCODE_SIZE - 1);
    return r->encode[scaled >= top ? CPU_ENCODE_SIZE - 1 : scaled > 0.0f ? (int)scaled : 0];
}

static void write_pixel(const stp_cpu_renderer* r, const float color[3], float coverage,
                        uint8_t* out)
{
    const stp_draw_style* style = r->style;
    float back = style->background ? 1.0f - coverage : 0.0f;
    for (int k = 0; k < 3; ++k) {
        float linear = style->background
                           ? color[k] * coverage + back * r->decode[style->background_color[k]]
                           : color[k];
        out[k] = encode(r, linear);
    }
    out[3] = style->background ? 255 : (uint8_t)(coverage * 255.0f + 0.5f);
    if (!style->background && coverage <= 0.0f) {
        out[0] = out[1] = out[2] = 0;
    }
}

stp_vec3 stp_cpu_toward_eye(const stp_cpu_renderer* r, double x, double y)
{
    const stp_view_frame* f = &r->frame;
    stp_vec3d toward = stp_scaled(f->forward, -1.0); // the negative of (forward + right u + down v)
    if (!f->parallel) {
        double u = (x - f->center_x - r->shift_x) / f->scale;
        double v = (y - f->center_y - r->shift_y) / f->scale;
        toward = stp_subd(toward, stp_addd(stp_scaled(f->right, u), stp_scaled(f->down, v)));
    }
    return stp_to_float(toward);
}

/// Direction to the eye for a tile.
static void place_eye(const stp_cpu_renderer* r, uint32_t x, uint32_t y, stp_cpu_shade_scene* scene)
{
    const stp_view_frame* f = &r->frame;
    scene->start = stp_cpu_toward_eye(r, (double)x, (double)y);
    scene->across = stp_to_float(stp_scaled(f->right, -1.0 / f->scale));
    scene->down = stp_to_float(stp_scaled(f->down, -1.0 / f->scale));
    scene->parallel = f->parallel;
}

stp_cpu_shade_scene stp_cpu_make_shade_scene(const stp_cpu_renderer* r)
{
    stp_cpu_shade_scene scene = {.encode = r->encode,
                                 .light = stp_lighting_make(&r->frame, r->style->headlight)};
    place_eye(r, 0, 0, &scene);
    return scene;
}

static void merge_tile(const shader* s, stp_cpu_shade_tile* tile)
{
    const stp_cpu_layers* layers = &s->r->layers;
    uint64_t any = 0;
    if (layers->stage == CPU_LAYERS_PEEL && !stp_cpu_has_layer(s->r, tile)) {
        tile->any = false;
        return;
    }
    for (uint32_t row = 0; row < tile->height; ++row) {
        size_t at = (size_t)(tile->y + row) * s->r->width + tile->x;
        uint64_t* copy = layers->stage == CPU_LAYERS_OPAQUE ? layers->farther + at : NULL;
        s->kernels->merge(s->buffers, s->buffer_count, at, tile->width, copy, &tile->rows[row]);
        any |= tile->rows[row].there;
    }
    tile->any = any != 0;
}

static void find_runs(const shader* s, stp_cpu_shade_tile* tile)
{
    uint32_t count = 0;
    for (uint32_t row = 0; row < tile->height; ++row) {
        const stp_cpu_shade_merged* merged = &tile->rows[row];
        tile->row_runs[row] = count;
        assert((merged->starts & 1) != 0 && "runs cover the whole row");
        for (uint64_t starts = merged->starts; starts != 0;) {
            uint32_t x = (uint32_t)__builtin_ctzll(starts);
            starts &= starts - 1;
            uint32_t end = starts != 0 ? (uint32_t)__builtin_ctzll(starts) : SHADE_WIDTH;
            uint32_t id = merged->ids[x + 1];
            uint32_t surface =
                id == UINT32_MAX ? SHADE_EMPTY : stp_cpu_find_surface(s->memory, tile, id);
            assert(x < end && count < SHADE_PIXELS);
            tile->runs[count++] = (stp_cpu_shade_run){
                .x = (uint8_t)x, .length = (uint8_t)(end - x), .surface = (uint16_t)surface};
        }
    }
    tile->row_runs[tile->height] = count;
}

/// Colour of the normal on the visible side; (x, y) is relative to the tile.
static void color_normal(const shader* s, float x, float y, stp_cpu_shade_surface* surface)
{
    const stp_cpu_shade_scene* scene = &s->scene;
    stp_vec3 n =
        stp_normalize((stp_vec3){surface->normal[0], surface->normal[1], surface->normal[2]});
    stp_vec3 eye = scene->start;
    if (!scene->parallel) {
        eye = stp_add(eye, stp_add(stp_scale(scene->across, x), stp_scale(scene->down, y)));
    }
    float side = stp_dot(n, eye) < 0.0f ? -0.5f : 0.5f;
    const float parts[3] = {0.5f + side * n.x, 0.5f + side * n.y, 0.5f + side * n.z};
    for (int c = 0; c < 3; ++c) {
        surface->color[c] = parts[c] * parts[c];
    }
}

/// Lanes of a run with a single colour and normal.
static uint32_t add_flat_lanes(stp_cpu_shade_lanes* lanes, uint32_t at,
                               const stp_cpu_shade_run* run, uint32_t row)
{
    for (uint32_t x = 0; x < run->length; x += SHADE_REACH, ++at) {
        uint32_t left = run->length - x, size = left < SHADE_REACH ? left : SHADE_REACH;
        lanes->surface[at] = run->surface;
        lanes->x[at] = (float)(run->x + x) + 0.5f * (float)size;
        lanes->y[at] = (float)row + 0.5f;
    }
    return at;
}

/// Place in the colour scale of the height of a splat's centre, because its rim lies behind its
/// plane; UINT32_MAX for other elements, whose pixels have their own heights.
static uint32_t find_center_place(const stp_cpu_renderer* r, uint32_t id)
{
    const stp_cpu_item* item = &r->items[stp_cpu_find_item(r, id)];
    if (item->kind != STP_DRAW_SPLATS || r->style->coloring != STP_DRAW_ELEVATION) {
        return UINT32_MAX;
    }
    const stp_cpu_splats* splats = &item->splats;
    const uint16_t* at = splats->positions + 3 * (size_t)(id - item->first_id);
    double step = (double)splats->step;
    stp_vec3d place = {(double)splats->origin.x + step * at[0],
                       (double)splats->origin.y + step * at[1],
                       (double)splats->origin.z + step * at[2]};
    double low = r->style->elevation[0], range = r->style->elevation[1] - low;
    double height = stp_affine_point(&item->draw->transform, place).y - low;
    double part = range > 0.0 ? stp_clampd(height / range, 0.0, 1.0) : 0.0;
    return (uint32_t)(part * 255.0 + 0.5);
}

/// Surfaces per pixel, with colours of heights or normals.
static void recolor(const shader* s, const stp_cpu_shade_tile* tile, const stp_cpu_shade_run* run,
                    uint32_t row, stp_cpu_shade_surface* surfaces)
{
    const stp_cpu_renderer* r = s->r;
    const stp_cpu_shade_nearness near = s->memory->nearness[run->surface];
    static const float dark[3] = {0};
    uint32_t center = find_center_place(r, s->memory->slots[run->surface].id);
    for (uint32_t k = 0; k < run->length; ++k) {
        stp_cpu_shade_surface* surface = &surfaces[k];
        bool unlit = surface->material.unlit > 0.0f || r->style->coloring == STP_DRAW_NORMALS;
        float x = (float)(tile->x + run->x + k) + 0.5f, y = (float)(tile->y + row) + 0.5f;
        surface->material = stp_cpu_make_shade_material(0.0f, 1.0f, dark, unlit);
        if (r->style->coloring == STP_DRAW_NORMALS) {
            color_normal(s, (float)(run->x + k) + 0.5f, (float)row + 0.5f, surface);
            continue;
        }
        float nearness = tile->rows[row].nearness[run->x + k] * near.factor + near.shift;
        const uint8_t* color =
            stp_color_map[center != UINT32_MAX
                              ? center
                              : stp_draw_height_place(&s->heights, x, y, nearness)];
        for (int c = 0; c < 3; ++c) {
            surface->color[c] = r->decode[color[c]];
        }
    }
}

/// Surfaces of a run's pixels, one per pixel.
static void make_own_surfaces(const shader* s, const stp_cpu_shade_tile* tile,
                              const stp_cpu_shade_run* run, uint32_t row,
                              stp_cpu_shade_surface* surfaces)
{
    stp_cpu_shade_memory* memory = s->memory;
    if (memory->kind[run->surface] != SHADE_FLAT) {
        stp_cpu_make_pixel_surfaces(s->r, memory, run, tile->x + run->x, tile->y + row,
                                    tile->rows[row].nearness + run->x, surfaces);
    }
    for (uint32_t k = 0; memory->kind[run->surface] == SHADE_FLAT && k < run->length; ++k) {
        surfaces[k] = memory->surfaces[run->surface];
    }
    if (s->r->style->coloring != STP_DRAW_OWN_COLORS) {
        recolor(s, tile, run, row, surfaces);
    }
}

static void add_lanes(const shader* s, stp_cpu_shade_tile* tile, uint32_t row)
{
    stp_cpu_shade_memory* memory = s->memory;
    stp_cpu_shade_lanes* lanes = &memory->lanes;
    uint32_t at = lanes->count;
    for (uint32_t i = tile->row_runs[row]; i < tile->row_runs[row + 1]; ++i) {
        stp_cpu_shade_run* run = &tile->runs[i];
        run->flat = memory->kind[run->surface] == SHADE_FLAT &&
                    s->r->style->coloring == STP_DRAW_OWN_COLORS;
        if (run->surface == SHADE_EMPTY) {
            run->lane = SHADE_EMPTY_LANE;
            continue;
        }
        run->lane = (uint16_t)at;
        if (run->flat) {
            at = add_flat_lanes(lanes, at, run, row);
            continue;
        }
        make_own_surfaces(s, tile, run, row, memory->surfaces + SHADE_OWN + at);
        for (uint32_t k = 0; k < run->length; ++k, ++at) {
            lanes->surface[at] = SHADE_OWN + at;
            lanes->x[at] = (float)(run->x + k) + 0.5f;
            lanes->y[at] = (float)row + 0.5f;
        }
    }
    assert(at <= (row + 1) * SHADE_WIDTH && "at most one lane per pixel");
    lanes->count = at;
}

static void light_tile(shader* s, stp_cpu_shade_tile* tile)
{
    stp_cpu_shade_lanes* lanes = &s->memory->lanes;
    lanes->count = 0;
    place_eye(s->r, tile->x, tile->y, &s->scene);
    for (uint32_t row = 0; row < tile->height; ++row) {
        add_lanes(s, tile, row);
    }
    for (uint32_t i = 0; i < SHADE_LANES_MAX; ++i) {
        lanes->surface[lanes->count + i] = SHADE_EMPTY;
    }
    s->kernels->light(&s->scene, s->memory->surfaces, lanes);
}

static void add_to_sums(const shader* s, const stp_cpu_shade_tile* tile, uint32_t row)
{
    const stp_cpu_renderer* r = s->r;
    const stp_cpu_shade_lanes* lanes = &s->memory->lanes;
    float* sums = r->sums + 4 * ((size_t)(tile->y + row) * r->width + tile->x);
    for (uint32_t i = tile->row_runs[row]; i < tile->row_runs[row + 1]; ++i) {
        const stp_cpu_shade_run* run = &tile->runs[i];
        bool there = run->surface != SHADE_EMPTY;
        for (uint32_t k = 0; k < run->length && run->x + k < tile->width; ++k) {
            float* sum = sums + 4 * (size_t)(run->x + k);
            uint32_t lane = run->lane + (run->flat ? k / SHADE_REACH : k);
            for (int c = 0; c < 3; ++c) {
                float linear = there ? lanes->linear[c][lane] : 0.0f;
                linear = linear < 1.0f ? linear : 1.0f; // so that highlights do not outshine edges
                sum[c] = r->sample == 0 ? linear : sum[c] + linear;
            }
            float coverage = there ? 1.0f : 0.0f;
            sum[3] = r->sample == 0 ? coverage : sum[3] + coverage;
        }
    }
}

/// Kernels write past a row's end: into the next tile, which is written later, or into a scratch
/// row.
static void spread_row(const shader* s, const stp_cpu_shade_tile* tile, uint32_t row)
{
    stp_cpu_renderer* r = s->r;
    const stp_cpu_shade_memory* memory = s->memory;
    uint8_t own_colors[4 * (SHADE_WIDTH + SHADE_LANES_MAX)];
    float own_depth[SHADE_WIDTH + SHADE_LANES_MAX];
    size_t at = (size_t)(tile->y + row) * r->width + tile->x;
    bool last = tile->x + SHADE_WIDTH + SHADE_LANES_MAX > r->width, sums = r->sample_count > 1;
    uint8_t* colors = last || sums ? own_colors : r->image->pixels + 4 * at;
    float* depth = last ? own_depth : r->depth + at;
    s->kernels->spread(tile->runs + tile->row_runs[row], tile->runs + tile->row_runs[row + 1],
                       memory->nearness, memory->lanes.bytes, tile->rows[row].nearness, colors,
                       depth);
    if (last) {
        memcpy(r->depth + at, depth, tile->width * sizeof(float));
    }
    if (last && !sums) {
        memcpy(r->image->pixels + 4 * at, colors, tile->width * sizeof(uint32_t));
    }
}

/// Records which pixels of a row show splats, for the pixel filter.
static void write_kinds(const shader* s, const stp_cpu_shade_tile* tile, uint32_t row)
{
    uint8_t kinds[2 * SHADE_WIDTH];
    for (uint32_t i = tile->row_runs[row]; i < tile->row_runs[row + 1]; ++i) {
        const stp_cpu_shade_run* run = &tile->runs[i];
        uint64_t eight = s->memory->splats[run->surface] * 0x0101010101010101u;
        for (uint32_t k = 0; k < run->length; k += sizeof(eight)) {
            memcpy(kinds + run->x + k, &eight, sizeof(eight)); // the next run writes over the rest
        }
    }
    memcpy(s->r->pixel_filter.kinds + (size_t)(tile->y + row) * s->r->width + tile->x, kinds,
           tile->width);
}

static void write_tile(const shader* s, const stp_cpu_shade_tile* tile)
{
    if (s->r->layers.stage == CPU_LAYERS_PEEL) {
        stp_cpu_take_layer(s->r, s->worker, tile);
        return;
    }
    for (uint32_t row = 0; row < tile->height; ++row) {
        spread_row(s, tile, row);
        if (s->r->pixel_filter.kinds != NULL) {
            write_kinds(s, tile, row);
        }
        if (s->r->sample_count > 1) {
            add_to_sums(s, tile, row);
        } else {
            s->worker->covered += (uint32_t)__builtin_popcountll(tile->rows[row].there);
        }
    }
}

static void write_nothing(const shader* s, const stp_cpu_shade_tile* tile)
{
    stp_cpu_renderer* r = s->r;
    if (r->layers.stage == CPU_LAYERS_PEEL) {
        return;
    }
    for (uint32_t row = 0; row < tile->height; ++row) {
        size_t at = (size_t)(tile->y + row) * r->width + tile->x;
        memset(r->depth + at, 0, tile->width * sizeof(float));
        if (r->pixel_filter.kinds != NULL) {
            memset(r->pixel_filter.kinds + at, 0, tile->width);
        }
        if (r->sample_count == 1) {
            for (size_t i = 0; i < tile->width; ++i) {
                memcpy(r->image->pixels + 4 * (at + i), &s->empty, sizeof(s->empty));
            }
        } else if (r->sample == 0) {
            memset(r->sums + 4 * at, 0, 4 * tile->width * sizeof(float));
        }
    }
}

/// Buffers of workers that have drawn.
static uint32_t find_buffers(const stp_cpu_renderer* r, uint64_t** buffers)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        if (r->workers[i].drew) {
            buffers[count++] = r->workers[i].pixels;
        }
    }
    return count;
}

static shader make_shader(stp_cpu_renderer* r, stp_cpu_worker* worker)
{
    const float nothing[3] = {0};
    stp_cpu_shade_memory* memory = worker->shading;
    shader s = {.r = r,
                .worker = worker,
                .memory = memory,
                .kernels = stp_cpu_choose_shade_kernels(),
                .scene = stp_cpu_make_shade_scene(r),
                .buffers = worker->buffers};
    const stp_draw_pixels pixels = {r->shift_x, r->shift_y, r->nearness_scale, r->nearness_offset};
    s.heights = stp_draw_heights_make(&r->frame, &pixels, r->style);
    s.buffer_count = find_buffers(r, s.buffers);
    assert(s.buffer_count <= r->team.threads);
    write_pixel(r, nothing, 0.0f, (uint8_t*)&s.empty);
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        memory->lanes.bytes[SHADE_EMPTY_LANE + i] = s.empty;
    }
    memory->lanes.wants_linear = r->sample_count > 1 || r->layers.stage == CPU_LAYERS_PEEL;
    return s;
}

/// Collects the ids of a tile, and prefetches their data.
static stp_cpu_shade_tile* begin_tile(const shader* s, uint32_t x, uint32_t y, uint32_t end)
{
    uint32_t left = s->r->width - x, rows = end - y;
    assert(x < s->r->width && y < end && end <= s->r->height);
    stp_cpu_shade_tile* tile = stp_cpu_begin_tile(s->memory);
    tile->x = x;
    tile->y = y;
    tile->width = left < SHADE_WIDTH ? left : SHADE_WIDTH;
    tile->height = rows < SHADE_ROWS ? rows : SHADE_ROWS;
    merge_tile(s, tile);
    if (tile->any) {
        find_runs(s, tile);
        stp_cpu_prefetch_surfaces(s->r, s->memory, tile);
    }
    return tile;
}

static void finish_tile(shader* s, stp_cpu_shade_tile* tile)
{
    if (!tile->any) {
        write_nothing(s, tile);
        return;
    }
    stp_cpu_make_surfaces(s->r, s->memory, tile);
    light_tile(s, tile);
    write_tile(s, tile);
}

void stp_cpu_shade_rows(stp_cpu_renderer* r, uint32_t begin, uint32_t end, stp_cpu_worker* worker)
{
    assert(begin <= end && end <= r->height && worker->shading != NULL);
    shader s = make_shader(r, worker);
    stp_cpu_shade_tile* before = NULL;
    for (uint32_t y = begin; y < end; y += SHADE_ROWS) {
        for (uint32_t x = 0; x < r->width; x += SHADE_WIDTH) {
            stp_cpu_shade_tile* tile = begin_tile(&s, x, y, end);
            if (before != NULL) {
                finish_tile(&s, before);
            }
            before = tile;
        }
    }
    if (before != NULL) {
        finish_tile(&s, before);
    }
}

void stp_cpu_find_depths(stp_cpu_renderer* r, uint32_t begin, uint32_t end, stp_cpu_worker* worker)
{
    assert(begin <= end && end <= r->height);
    uint32_t count = find_buffers(r, worker->buffers);
    size_t at = (size_t)begin * r->width, size = (size_t)(end - begin) * r->width;
    stp_cpu_choose_shade_kernels()->find_depths(worker->buffers, count, at, size, r->depth + at);
}

void stp_cpu_average_rows(stp_cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* covered)
{
    assert(begin <= end && end <= r->height && r->sample_count > 1 &&
           "otherwise there are no sums");
    for (size_t at = (size_t)begin * r->width; at < (size_t)end * r->width; ++at) {
        const float* sum = r->sums + 4 * at;
        float share = sum[3] > 0.0f ? 1.0f / sum[3] : 0.0f;
        float color[3] = {sum[0] * share, sum[1] * share, sum[2] * share};
        *covered += sum[3] > 0.0f;
        write_pixel(r, color, sum[3] / (float)r->sample_count, r->image->pixels + 4 * at);
    }
}
