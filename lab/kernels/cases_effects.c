// SPDX-License-Identifier: MIT
// Post-shading effects of a row of pixels.
#include "draw/cpu/effects.h"
#include "draw/cpu/pixel_filter.h"
#include "lab/kernels/kernel_cases.h"

#include <string.h>

enum { ROW = 4096, PAD = 16, REPEATS = 32 };

typedef struct effect_input {
    float center[ROW], gain[ROW], near[2][ROW + 2 * PAD], values[ROW];
    const float* neighbours[2];
} effect_input;

/// Results of a row.
typedef struct effect_output {
    float sums[2][ROW];
    float mixed[ROW]; ///< of blocks
} effect_output;

bool kernel_make_rows(kernel_case* c)
{
    effect_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < ROW + 2 * PAD; ++i) {
        for (uint32_t k = 0; k < 2; ++k) { // some pixels are outside the picture
            bool outside = kernel_random(1 + k, i, 0.0f, 1.0f) < 0.1f;
            in->near[k][i] = outside ? (float)k - 1.0f : kernel_random(3 + k, i, 0.0f, 1.0f);
        }
    }
    for (uint32_t i = 0; i < ROW; ++i) {
        in->center[i] = i % 7 == 0 ? 0.0f : kernel_random(5, i, 0.0f, 1.0f);
        in->gain[i] = kernel_random(6, i, 100.0f, 900.0f);
        in->values[i] = kernel_random(7, i, 0.0f, 1.0f);
    }
    in->neighbours[0] = in->near[0] + PAD - 3;
    in->neighbours[1] = in->near[1] + PAD + 5;
    c->input = in;
    return kernel_set_output(c, sizeof(effect_output), (uint64_t)REPEATS * ROW);
}

void kernel_reset_rows(kernel_case* c)
{
    memset(c->output, 0, c->output_bytes);
}

void kernel_run_greatest(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->greatest(in->near[0] + PAD, 3, out->sums[0], ROW);
    }
}

void kernel_run_gain(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->gain(in->center, 900.0f, false, out->sums[0], ROW);
    }
}

void kernel_run_rise(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->rise(in->center, in->gain, in->neighbours, 0.3f,
                                              out->sums[0], ROW);
    }
}

/// Factors become sums again.
void kernel_run_eye_dome(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    memcpy(out->sums[0], in->values, sizeof(in->values));
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->eye_dome(out->sums[0], 0.7f, ROW);
    }
}

void kernel_run_pair(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    const float numbers[3] = {0.1f, 0.05f, 1.0f / 700.0f};
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->pair(in->center, in->gain, in->neighbours, numbers,
                                              out->sums[0], ROW);
    }
}

void kernel_run_blur(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    float* const sums[2] = {out->sums[0], out->sums[1]};
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->blur(in->center, in->gain, in->neighbours[0], in->values,
                                              0.01f, sums, ROW);
    }
}

void kernel_run_blocks(kernel_case* c)
{
    const effect_input* in = c->input;
    effect_output* out = c->output;
    for (int i = 0; i < REPEATS; ++i) {
        stp_cpu_choose_effect_kernels()->spread(in->neighbours, 0.375f, out->mixed,
                                                ROW / STP_EFFECT_BLOCK, out->sums[0], ROW);
    }
}

typedef struct filter_input {
    uint8_t pixels[4 * ROW], kinds[ROW];
} filter_input;

typedef struct filter_output {
    uint16_t light[4 + 4 * ROW + 4], weights[4 * ROW], across[4 * ROW], mixed[4 * ROW];
    uint8_t pixels[4 * ROW];
} filter_output;

bool kernel_make_pixels(kernel_case* c)
{
    filter_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    for (uint32_t x = 0; x < ROW; ++x) {
        bool there = kernel_random(1, x, 0.0f, 1.0f) > 0.1f;
        in->kinds[x] = kernel_random(2, x, 0.0f, 1.0f) > 0.5f;
        for (uint32_t k = 0; k < 4; ++k) {
            uint8_t value = k == 3 ? 255 : (uint8_t)kernel_random(3 + k, x, 0.0f, 255.0f);
            in->pixels[4 * x + k] = there ? value : 0;
        }
    }
    c->input = in;
    return kernel_set_output(c, sizeof(filter_output), (uint64_t)REPEATS * ROW);
}

void kernel_run_pixels(kernel_case* c)
{
    const filter_input* in = c->input;
    filter_output* out = c->output;
    const stp_cpu_pixel_kernels* k = stp_cpu_choose_pixel_kernels();
    const uint16_t* const rows[3] = {out->across, out->across, out->across};
    for (int i = 0; i < REPEATS; ++i) {
        k->light(in->pixels, out->light + 4, ROW);
        k->weigh(in->kinds, out->weights, ROW);
        k->across(out->light + 4, out->weights, out->across, ROW);
        k->down(rows, out->weights, out->mixed, out->pixels, ROW);
    }
}
