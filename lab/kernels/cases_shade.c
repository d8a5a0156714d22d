// SPDX-License-Identifier: MIT
// Shading of rows of a tile.
#include "base/math/color.h"
#include "draw/cpu/shade.h"
#include "lab/kernels/kernel_cases.h"

#include <string.h>

enum {
    ROWS = 64,
    WORKERS = 2,
    LIT = SHADE_PIXELS,
    SURFACES = 64,
    RUN = 8,
    RUNS = SHADE_WIDTH / RUN
};

typedef struct merge_input {
    uint64_t drawn[WORKERS][ROWS * SHADE_WIDTH];
    uint64_t buffers[WORKERS][ROWS * SHADE_WIDTH]; ///< copies, which merging clears
} merge_input;

static bool draw_buffers(kernel_case* c)
{
    merge_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    for (uint32_t w = 0; w < WORKERS; ++w) {
        for (uint32_t i = 0; i < ROWS * SHADE_WIDTH; ++i) {
            bool empty = kernel_random(1 + w, i, 0.0f, 1.0f) < 0.3f;
            float nearness = kernel_random(3 + w, i, 0.1f, 1.0f);
            in->drawn[w][i] = empty ? STP_RASTER_EMPTY : stp_raster_pixel(nearness, i / 3);
        }
    }
    c->input = in;
    return true;
}

bool kernel_make_merge(kernel_case* c)
{
    return draw_buffers(c) &&
           kernel_set_output(c, ROWS * sizeof(stp_cpu_shade_merged), ROWS * SHADE_WIDTH);
}

void kernel_reset_merge(kernel_case* c)
{
    merge_input* in = c->input;
    memcpy(in->buffers, in->drawn, sizeof(in->buffers));
    memset(c->output, 0xFF, c->output_bytes);
}

void kernel_run_merge(kernel_case* c)
{
    merge_input* in = c->input;
    const stp_cpu_shade_kernels* kernels_here = stp_cpu_choose_shade_kernels();
    uint64_t* const buffers[WORKERS] = {in->buffers[0], in->buffers[1]};
    for (size_t row = 0; row < ROWS; ++row) {
        kernels_here->merge(buffers, WORKERS, row * SHADE_WIDTH, SHADE_WIDTH, NULL,
                            (stp_cpu_shade_merged*)c->output + row);
    }
}

bool kernel_make_depths(kernel_case* c)
{
    return draw_buffers(c) &&
           kernel_set_output(c, ROWS * SHADE_WIDTH * sizeof(float), ROWS * SHADE_WIDTH);
}

void kernel_run_depths(kernel_case* c)
{
    merge_input* in = c->input;
    uint64_t* const buffers[WORKERS] = {in->drawn[0], in->drawn[1]};
    stp_cpu_choose_shade_kernels()->find_depths(buffers, WORKERS, 0, ROWS * SHADE_WIDTH, c->output);
}

typedef struct light_input {
    stp_cpu_shade_surface surfaces[SURFACES];
    uint8_t encode[CPU_ENCODE_SIZE + 3];
    stp_cpu_shade_scene scene;
    stp_cpu_shade_lanes lanes; ///< without results
} light_input;

static void make_surface(stp_cpu_shade_surface* s, uint32_t number)
{
    uint64_t at = 16 * (uint64_t)number;
    for (uint32_t k = 0; k < 3; ++k) {
        s->color[k] = kernel_random(6, at + k, 0.0f, 1.0f);
        s->normal[k] = kernel_random(6, at + 3 + k, -1.0f, 1.0f);
    }
    s->normal[3] = number % 2 == 0 ? 0.0f : kernel_random(6, at + 9, 0.0f, 0.5f);
    const float emissive[3] = {kernel_random(6, at + 6, 0.0f, 0.2f), 0.0f, 0.1f};
    s->material = stp_cpu_make_shade_material(kernel_random(6, at + 7, 0.0f, 1.0f),
                                              kernel_random(6, at + 8, 0.0f, 1.0f), emissive,
                                              number % 4 == 1);
}

bool kernel_make_light(kernel_case* c)
{
    light_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    memset(in, 0, sizeof(*in));
    for (uint32_t i = 0; i < SURFACES; ++i) {
        make_surface(&in->surfaces[i], i);
    }
    for (int i = 0; i < CPU_ENCODE_SIZE; ++i) {
        in->encode[i] = stp_linear_to_srgb8(((float)i + 0.5f) / (float)CPU_ENCODE_SIZE);
    }
    in->scene = (stp_cpu_shade_scene){.encode = in->encode,
                                      .light = {.key = {-0.45f, 0.65f, 0.62f},
                                                .up = {0, 1, 0},
                                                .left_box = {-0.6f, 0.64f, 0.48f},
                                                .right_box = {0.8f, 0.0f, 0.6f}},
                                      .start = {-0.3f, 0.2f, 0.9f},
                                      .across = {0.001f, 0, 0.0001f},
                                      .down = {0, -0.002f, 0.0001f}};
    in->lanes.count = LIT;
    in->lanes.wants_linear = true;
    for (uint32_t i = 0; i < LIT; ++i) {
        in->lanes.surface[i] = stp_rng_below(7, i, SURFACES);
        in->lanes.x[i] = (float)(i % SHADE_WIDTH);
        in->lanes.y[i] = (float)(i / SHADE_WIDTH);
    }
    c->input = in;
    return kernel_set_output(c, sizeof(stp_cpu_shade_lanes), LIT);
}

void kernel_reset_light(kernel_case* c)
{
    const light_input* in = c->input;
    memcpy(c->output, &in->lanes, sizeof(in->lanes));
}

void kernel_run_light(kernel_case* c)
{
    const light_input* in = c->input;
    stp_cpu_choose_shade_kernels()->light(&in->scene, in->surfaces, c->output);
}

typedef struct spread_input {
    stp_cpu_shade_run runs[RUNS];
    stp_cpu_shade_nearness surfaces[RUNS];
    uint32_t lanes[SHADE_WIDTH + SHADE_LANES_MAX];
    float nearness[SHADE_WIDTH + SHADE_LANES_MAX];
} spread_input;

/// Rows of pixels. A row may be written past its end, until the next one is.
typedef struct spread_output {
    uint8_t colors[4 * ROWS * SHADE_WIDTH], colors_past[4 * SHADE_LANES_MAX];
    float depth[ROWS * SHADE_WIDTH], depth_past[SHADE_LANES_MAX];
} spread_output;

/// Runs of eight pixels, flat or not.
bool kernel_make_spread(kernel_case* c)
{
    spread_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < RUNS; ++i) {
        in->runs[i] = (stp_cpu_shade_run){.x = (uint8_t)(i * RUN),
                                          .length = RUN,
                                          .surface = (uint16_t)i,
                                          .lane = (uint16_t)(i * RUN),
                                          .flat = i % 2 == 0};
        in->surfaces[i] = (stp_cpu_shade_nearness){kernel_random(8, 2 * i, 0.5f, 1.0f),
                                                   kernel_random(8, 2 * i + 1, 0.0f, 0.1f)};
    }
    for (uint32_t i = 0; i < SHADE_WIDTH + SHADE_LANES_MAX; ++i) {
        in->lanes[i] = (uint32_t)stp_rng_hash(9, i);
        in->nearness[i] = kernel_random(10, i, 0.1f, 1.0f);
    }
    c->input = in;
    return kernel_set_output(c, sizeof(spread_output), ROWS * SHADE_WIDTH);
}

void kernel_run_spread(kernel_case* c)
{
    const spread_input* in = c->input;
    spread_output* out = c->output;
    const stp_cpu_shade_kernels* kernels_here = stp_cpu_choose_shade_kernels();
    for (size_t at = 0; at < ROWS * SHADE_WIDTH; at += SHADE_WIDTH) {
        kernels_here->spread(in->runs, in->runs + RUNS, in->surfaces, in->lanes, in->nearness,
                             out->colors + 4 * at, out->depth + at);
    }
    memset(out->colors_past, 0, sizeof(out->colors_past));
    memset(out->depth_past, 0, sizeof(out->depth_past));
}
