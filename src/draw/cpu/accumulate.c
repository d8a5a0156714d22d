// SPDX-License-Identifier: MIT
#include "draw/cpu/passes.h"

#include <assert.h>
#include <string.h>

enum { LINEAR_FULL = 65535 }; ///< times the maximum of 4096 frames: fits 32 bits

void stp_cpu_continue_accumulation(stp_cpu_renderer* r, const stp_view* view,
                                   const stp_draw_list* list, const stp_draw_style* style)
{
    stp_cpu_accumulation* a = &r->accumulation;
    if (!stp_resting_continues(&a->resting, view, list, style)) {
        a->frames = 0;
    }
}

stp_result stp_cpu_make_accumulation(stp_cpu_renderer* r, uint32_t frames)
{
    stp_cpu_accumulation* a = &r->accumulation;
    stp_context* context = r->base.context;
    size_t needed = (size_t)r->width * r->height * r->eye_count;
    if (a->linear == NULL) {
        a->linear = STP_NEW_ARRAY(context, uint32_t, 256);
        if (a->linear == NULL) {
            return stp_fail_memory(context);
        }
        for (int i = 0; i < 256; ++i) {
            a->linear[i] = (uint32_t)(r->decode[i] * (float)LINEAR_FULL + 0.5f);
        }
    }
    if (needed > a->capacity) {
        assert(frames == 0 && "new memory holds no sums");
        a->capacity = 0;
        a->frames = 0;
        stp_free(context, a->memory);
        a->memory = STP_NEW_ARRAY(context, uint32_t, 4 * needed);
        if (a->memory == NULL) {
            return stp_fail_memory(context);
        }
        a->capacity = needed;
    }
    a->frames = frames;
    return STP_OK;
}

static void add_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    const stp_cpu_accumulation* a = &r->accumulation;
    (void)worker;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        const uint8_t* in = r->image->pixels + 4 * at;
        uint32_t* sum = a->sums + 4 * at;
        uint32_t alpha = in[3]; // below 255 if only transparent surfaces cover the pixel
        for (int k = 0; k < 3; ++k) {
            sum[k] = (a->frames > 0 ? sum[k] : 0) + (alpha * a->linear[in[k]] + 127) / 255;
        }
        sum[3] = (a->frames > 0 ? sum[3] : 0) + alpha;
    }
}

void stp_cpu_add_frame(stp_cpu_renderer* r)
{
    assert(r->accumulation.frames < 4096 && "sums of more frames overflow 32 bits");
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, add_rows, r);
}

static void show_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_cpu_renderer* r = user;
    const stp_draw_style* style = r->style;
    float whole = 1.0f / (float)r->accumulation.frames;
    uint64_t covered = 0;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        const uint32_t* sum = r->accumulation.sums + 4 * at;
        uint8_t* out = r->image->pixels + 4 * at;
        assert(sum[3] <= 255 * r->accumulation.frames && "a frame covers a pixel once");
        float covering = (float)sum[3] / 255.0f, coverage = covering * whole;
        float share = sum[3] > 0 ? 1.0f / (covering * (float)LINEAR_FULL) : 0.0f;
        covered += sum[3] > 0;
        for (int k = 0; k < 3; ++k) {
            float linear = (float)sum[k] * share;
            if (style->background) {
                float back = r->decode[style->background_color[k]];
                linear = linear * coverage + back * (1.0f - coverage);
            }
            int place = (int)(linear * (float)CPU_ENCODE_SIZE);
            out[k] = r->encode[place < CPU_ENCODE_SIZE ? place : CPU_ENCODE_SIZE - 1];
        }
        out[3] = style->background ? 255 : (uint8_t)(coverage * 255.0f + 0.5f);
        if (out[3] == 0) {
            memset(out, 0, 4);
        }
    }
    r->workers[worker].covered += covered;
}

void stp_cpu_show_frames(stp_cpu_renderer* r)
{
    assert(r->accumulation.frames > 0 && "there is no mean of nothing");
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, show_rows, r);
}

void stp_cpu_destroy_accumulation(stp_cpu_renderer* r)
{
    stp_free(r->base.context, r->accumulation.memory);
    stp_free(r->base.context, r->accumulation.linear);
}
