// SPDX-License-Identifier: MIT
// From the visibility buffer to colours, tile by tile.
#include "draw/cpu/shade.h"

#include <string.h>

/// Four numbers at once, in the compiler's own notation: the same bits everywhere.
typedef float four __attribute__((vector_size(16)));
typedef uint32_t four_int __attribute__((vector_size(16)));

/// What one band of the picture needs to know, and where it is.
typedef struct shader {
    cpu_renderer* r;
    cpu_worker* worker;
    cpu_shade_memory* memory;
    const cpu_shade_kernels* kernels;
    cpu_shade_scene scene;
    uint32_t buffer_count;
    uint64_t** buffers;           ///< of workers that drew
    uint32_t empty;               ///< colour of pixels that show nothing
    uint32_t x, y, width, height; ///< of the tile
    uint32_t run_count;
    uint32_t row_runs[SHADE_ROWS + 1]; ///< of each row, the first
    cpu_shade_run runs[SHADE_PIXELS];
} shader;

static uint8_t encode(const cpu_renderer* r, float linear)
{
    float scaled = linear * (float)CPU_ENCODE_SIZE;
    float top = (float)(CPU_ENCODE_SIZE - 1);
    return r->encode[scaled >= top ? CPU_ENCODE_SIZE - 1 : scaled > 0.0f ? (int)scaled : 0];
}

static void write_pixel(const cpu_renderer* r, const float color[3], float coverage, uint8_t* out)
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

static cpu_light make_light(const cpu_renderer* r)
{
    const stp_view_frame* f = &r->frame;
    stp_vec3d up = stp_scaled(f->down, -1.0), back = stp_scaled(f->forward, -1.0);
    stp_vec3d toward = back;
    if (!r->style->headlight) { // above the viewer's left shoulder
        toward = stp_addd(stp_scaled(f->right, -0.45), stp_scaled(up, 0.65));
        toward = stp_normalized(stp_addd(toward, stp_scaled(back, 0.62)));
    }
    return (cpu_light){.toward = stp_to_float(toward), .up = stp_to_float(up)};
}

/// What the direction to the eye is made of, for a tile: (forward + right u + down v) turned round.
static void place_eye(const cpu_renderer* r, uint32_t x, uint32_t y, cpu_shade_scene* scene)
{
    const stp_view_frame* f = &r->frame;
    stp_vec3d start = stp_scaled(f->forward, -1.0);
    if (!f->parallel) {
        double u = ((double)x - f->center_x - r->shift_x) / f->scale;
        double v = ((double)y - f->center_y - r->shift_y) / f->scale;
        start = stp_subd(start, stp_addd(stp_scaled(f->right, u), stp_scaled(f->down, v)));
    }
    scene->start = stp_to_float(start);
    scene->across = stp_to_float(stp_scaled(f->right, -1.0 / f->scale));
    scene->down = stp_to_float(stp_scaled(f->down, -1.0 / f->scale));
    scene->parallel = f->parallel;
}

cpu_shade_scene cpu_make_shade_scene(const cpu_renderer* r)
{
    cpu_shade_scene scene = {.encode = r->encode, .light = make_light(r)};
    place_eye(r, 0, 0, &scene);
    return scene;
}

/// @return whether the tile shows anything
static bool merge_tile(shader* s)
{
    uint64_t any = 0;
    for (uint32_t row = 0; row < s->height; ++row) {
        cpu_shade_merged* merged = &s->memory->rows[row];
        size_t at = (size_t)(s->y + row) * s->r->width + s->x;
        s->kernels->merge(s->buffers, s->buffer_count, at, s->width, merged);
        any |= merged->there;
    }
    return any != 0;
}

static void find_runs(shader* s)
{
    cpu_shade_memory* memory = s->memory;
    cpu_begin_tile(memory);
    s->run_count = 0;
    for (uint32_t row = 0; row < s->height; ++row) {
        const cpu_shade_merged* merged = &memory->rows[row];
        s->row_runs[row] = s->run_count;
        for (uint64_t starts = merged->starts; starts != 0;) {
            uint32_t x = (uint32_t)__builtin_ctzll(starts);
            starts &= starts - 1;
            uint32_t end = starts != 0 ? (uint32_t)__builtin_ctzll(starts) : SHADE_WIDTH;
            uint32_t id = merged->ids[x + 1];
            uint32_t surface = id == UINT32_MAX ? SHADE_EMPTY : cpu_find_surface(memory, id);
            s->runs[s->run_count++] = (cpu_shade_run){
                .x = (uint8_t)x, .length = (uint8_t)(end - x), .surface = (uint16_t)surface};
        }
    }
    s->row_runs[s->height] = s->run_count;
}

/// Lanes of a run that has one colour and normal all over.
static uint32_t add_flat_lanes(cpu_shade_lanes* lanes, uint32_t at, const cpu_shade_run* run,
                               uint32_t row)
{
    for (uint32_t x = 0; x < run->length; x += SHADE_REACH, ++at) {
        uint32_t left = run->length - x, size = left < SHADE_REACH ? left : SHADE_REACH;
        lanes->surface[at] = run->surface;
        lanes->x[at] = (float)(run->x + x) + 0.5f * (float)size;
        lanes->y[at] = (float)row + 0.5f;
    }
    return at;
}

static void add_lanes(shader* s, uint32_t row)
{
    cpu_shade_memory* memory = s->memory;
    cpu_shade_lanes* lanes = &memory->lanes;
    uint32_t at = lanes->count;
    for (uint32_t i = s->row_runs[row]; i < s->row_runs[row + 1]; ++i) {
        cpu_shade_run* run = &s->runs[i];
        run->flat = memory->kind[run->surface] == SHADE_FLAT;
        if (run->surface == SHADE_EMPTY) {
            run->lane = SHADE_EMPTY_LANE;
            continue;
        }
        run->lane = (uint16_t)at;
        if (run->flat) {
            at = add_flat_lanes(lanes, at, run, row);
            continue;
        }
        cpu_make_pixel_surfaces(s->r, memory, run, s->x + run->x, s->y + row,
                                memory->rows[row].nearness + run->x,
                                memory->surfaces + SHADE_OWN + at);
        for (uint32_t k = 0; k < run->length; ++k, ++at) {
            lanes->surface[at] = SHADE_OWN + at;
            lanes->x[at] = (float)(run->x + k) + 0.5f;
            lanes->y[at] = (float)row + 0.5f;
        }
    }
    lanes->count = at;
}

static void light_tile(shader* s)
{
    cpu_shade_lanes* lanes = &s->memory->lanes;
    lanes->count = 0;
    for (uint32_t row = 0; row < s->height; ++row) {
        add_lanes(s, row);
    }
    for (uint32_t i = 0; i < SHADE_LANES_MOST; ++i) {
        lanes->surface[lanes->count + i] = SHADE_EMPTY;
    }
    place_eye(s->r, s->x, s->y, &s->scene);
    s->kernels->light(&s->scene, s->memory->surfaces, lanes);
}

/// Writes a row of bytes and nearness, up to three more than there are.
static void spread_runs(const shader* s, uint32_t row, uint32_t* bytes, float* nearness)
{
    const cpu_shade_memory* memory = s->memory;
    const float* from = memory->rows[row].nearness;
    for (uint32_t i = s->row_runs[row]; i < s->row_runs[row + 1]; ++i) {
        const cpu_shade_run* run = &s->runs[i];
        const uint32_t* lane = memory->lanes.bytes + run->lane;
        cpu_shade_nearness near = memory->nearness[run->surface];
        for (uint32_t k = 0; k < run->length; k += 4) {
            four_int color;
            four depth;
            memcpy(&depth, from + run->x + k, sizeof(depth));
            depth = depth * near.factor + near.shift;
            memcpy(nearness + run->x + k, &depth, sizeof(depth));
            memcpy(&color, lane + k, sizeof(color));
            if (run->flat) {
                color = lane[k / SHADE_REACH] - (four_int){0};
            }
            memcpy(bytes + run->x + k, &color, sizeof(color));
        }
    }
}

static void add_to_sums(const shader* s, uint32_t row)
{
    const cpu_renderer* r = s->r;
    const cpu_shade_lanes* lanes = &s->memory->lanes;
    float* sums = r->sums + 4 * ((size_t)(s->y + row) * r->width + s->x);
    for (uint32_t i = s->row_runs[row]; i < s->row_runs[row + 1]; ++i) {
        const cpu_shade_run* run = &s->runs[i];
        bool there = run->surface != SHADE_EMPTY;
        for (uint32_t k = 0; k < run->length && run->x + k < s->width; ++k) {
            float* sum = sums + 4 * (size_t)(run->x + k);
            uint32_t lane = run->lane + (run->flat ? k / SHADE_REACH : k);
            for (int c = 0; c < 3; ++c) {
                float linear = there ? lanes->linear[c][lane] : 0.0f;
                linear = linear < 1.0f ? linear : 1.0f; // so that glints do not outshine edges
                sum[c] = r->sample == 0 ? linear : sum[c] + linear;
            }
            float coverage = there ? 1.0f : 0.0f;
            sum[3] = r->sample == 0 ? coverage : sum[3] + coverage;
        }
    }
}

static void write_tile(const shader* s)
{
    cpu_renderer* r = s->r;
    uint32_t bytes[SHADE_WIDTH + 4];
    float nearness[SHADE_WIDTH + 4];
    for (uint32_t row = 0; row < s->height; ++row) {
        size_t at = (size_t)(s->y + row) * r->width + s->x;
        spread_runs(s, row, bytes, nearness);
        memcpy(r->depth + at, nearness, s->width * sizeof(float));
        if (r->sample_count > 1) {
            add_to_sums(s, row);
        } else {
            memcpy(r->image->pixels + 4 * at, bytes, s->width * sizeof(uint32_t));
            s->worker->covered += (uint32_t)__builtin_popcountll(s->memory->rows[row].there);
        }
    }
}

static void write_nothing(const shader* s)
{
    cpu_renderer* r = s->r;
    for (uint32_t row = 0; row < s->height; ++row) {
        size_t at = (size_t)(s->y + row) * r->width + s->x;
        memset(r->depth + at, 0, s->width * sizeof(float));
        if (r->sample_count == 1) {
            for (size_t i = 0; i < s->width; ++i) {
                memcpy(r->image->pixels + 4 * (at + i), &s->empty, sizeof(s->empty));
            }
        } else if (r->sample == 0) {
            memset(r->sums + 4 * at, 0, 4 * s->width * sizeof(float));
        }
    }
}

/// Buffers of workers that drew.
static uint32_t find_buffers(const cpu_renderer* r, uint64_t** buffers)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        if (r->workers[i].drew) {
            buffers[count++] = r->workers[i].pixels;
        }
    }
    return count;
}

static void begin_shader(shader* s, cpu_renderer* r, cpu_worker* worker)
{
    const float nothing[3] = {0};
    cpu_shade_memory* memory = worker->shading;
    s->r = r;
    s->worker = worker;
    s->memory = memory;
    s->kernels = cpu_choose_shade_kernels();
    s->scene = cpu_make_shade_scene(r);
    s->buffers = worker->buffers;
    s->buffer_count = find_buffers(r, s->buffers);
    write_pixel(r, nothing, 0.0f, (uint8_t*)&s->empty);
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        memory->lanes.bytes[SHADE_EMPTY_LANE + i] = s->empty;
    }
    memory->lanes.wants_linear = r->sample_count > 1;
}

void cpu_shade_rows(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker)
{
    shader s;
    begin_shader(&s, r, worker);
    for (s.y = begin; s.y < end; s.y += SHADE_ROWS) {
        s.height = end - s.y < SHADE_ROWS ? end - s.y : SHADE_ROWS;
        for (s.x = 0; s.x < r->width; s.x += SHADE_WIDTH) {
            s.width = r->width - s.x < SHADE_WIDTH ? r->width - s.x : SHADE_WIDTH;
            if (!merge_tile(&s)) {
                write_nothing(&s);
                continue;
            }
            find_runs(&s);
            cpu_make_surfaces(r, s.memory);
            light_tile(&s);
            write_tile(&s);
        }
    }
}

void cpu_find_depths(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker)
{
    uint32_t count = find_buffers(r, worker->buffers);
    for (size_t at = (size_t)begin * r->width; at < (size_t)end * r->width; ++at) {
        uint64_t least = STP_RASTER_EMPTY;
        for (uint32_t k = 0; k < count; ++k) {
            least = worker->buffers[k][at] < least ? worker->buffers[k][at] : least;
        }
        r->depth[at] = least == STP_RASTER_EMPTY ? 0.0f : stp_raster_nearness(least);
    }
}

void cpu_average_rows(cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* covered)
{
    for (size_t at = (size_t)begin * r->width; at < (size_t)end * r->width; ++at) {
        const float* sum = r->sums + 4 * at;
        float share = sum[3] > 0.0f ? 1.0f / sum[3] : 0.0f;
        float color[3] = {sum[0] * share, sum[1] * share, sum[2] * share};
        *covered += sum[3] > 0.0f;
        write_pixel(r, color, sum[3] / (float)r->sample_count, r->image->pixels + 4 * at);
    }
}
