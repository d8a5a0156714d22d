// SPDX-License-Identifier: MIT
// Filling in of surface: a further view along -z at bumpy ground, and two main views that saw most
// of it, one from the same side and one at a slant. One unit is one pixel.
#include "capture/fill.h"
#include "lab/kernels/kernel_cases.h"

#include <string.h>

enum { SIDE = 160, PIXELS = SIDE * SIDE, ROW_WORDS = (SIDE + 31) / 32, VIEWS = 2 };

typedef struct fill_input {
    stp_capture_view views[VIEWS];
    stp_fill_map map;
    stp_fill_word words[VIEWS * SIDE * ROW_WORDS];
    stp_fill_surface surface[VIEWS * PIXELS];
    uint64_t pixels[PIXELS];
} fill_input;

static void see_ground(fill_input* in, uint32_t view, uint32_t* candidates)
{
    stp_fill_word* words = in->words + (size_t)view * SIDE * ROW_WORDS;
    for (uint32_t i = 0; i < PIXELS; ++i) {
        stp_fill_word* word = &words[i / SIDE * ROW_WORDS + i % SIDE / 32];
        word->first = i % SIDE % 32 == 0 ? *candidates : word->first;
        if (kernel_random(1, i + (uint64_t)view * PIXELS, 0.0f, 1.0f) < 0.8f) {
            word->covered |= (uint32_t)1 << i % SIDE % 32;
            in->surface[*candidates] = (stp_fill_surface){
                .nearness = kernel_random(3, *candidates, 1.4f, 1.43f),
                .normal = (uint32_t)stp_rng_hash(2, *candidates) & 0x3FFFFFFFu,
            };
            *candidates += 1;
        }
    }
}

bool kernel_make_fill(kernel_case* c)
{
    fill_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return false;
    }
    memset(in, 0, sizeof(*in));
    uint32_t candidates = 0;
    for (uint32_t v = 0; v < VIEWS; ++v) {
        in->views[v] = (stp_capture_view){.toward = {0, 0, 1},
                                          .right = {1, 0, v == 1 ? 0.3 : 0},
                                          .down = {0, 1, 0},
                                          .depth = {0, 0, 0.01},
                                          .shift_x = 0.25,
                                          .width = SIDE,
                                          .height = SIDE};
        in->map.starts[v] = (size_t)v * SIDE * ROW_WORDS;
        see_ground(in, v, &candidates);
    }
    in->map.views = in->views;
    in->map.view_count = VIEWS;
    in->map.pixel_size = 1.0;
    in->map.words = in->words;
    in->map.surface = in->surface;
    for (uint32_t i = 0; i < PIXELS; ++i) {
        bool empty = kernel_random(4, i, 0.0f, 1.0f) < 0.3f;
        float nearness = kernel_random(5, i, 1.4f, 1.43f);
        in->pixels[i] = empty ? STP_RASTER_EMPTY : stp_raster_pixel(nearness, i);
    }
    c->input = in;
    return kernel_set_output(c, sizeof(in->pixels), PIXELS);
}

void kernel_reset_fill(kernel_case* c)
{
    const fill_input* in = c->input;
    memcpy(c->output, in->pixels, sizeof(in->pixels));
}

void kernel_run_fill(kernel_case* c)
{
    const fill_input* in = c->input;
    const stp_raster_target target = {SIDE, SIDE, SIDE, c->output};
    stp_fill_drop_known(&in->map, &in->views[0], 0, &target);
}
