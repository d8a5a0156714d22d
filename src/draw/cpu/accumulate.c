// SPDX-License-Identifier: MIT
#include "draw/cpu/accumulate.h"

#include <string.h>

enum { LINEAR_FULL = 65535 }; ///< times the most frames, 4096: within 32 bits

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
    while (b != 0) {
        uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

uint32_t cpu_choose_sample(uint32_t side, uint32_t k)
{
    uint32_t all = side * side, step = (all * 618 + 500) / 1000; // in golden sections
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

static bool is_same_view(const stp_view* a, const stp_view* b)
{
    return is_same_vector(a->eye, b->eye) && is_same_vector(a->target, b->target) &&
           is_same_vector(a->up, b->up) && a->fov_degrees == b->fov_degrees &&
           a->ortho_height == b->ortho_height && a->near_distance == b->near_distance &&
           a->eye_distance == b->eye_distance && a->width == b->width && a->height == b->height &&
           are_same_sections(&a->sections, &b->sections);
}

/// Of what is drawn: it changes with the quality, and with what of a scene is in memory.
static stp_hash hash_list(const stp_draw_list* list)
{
    stp_hash hash = {0};
    for (size_t i = 0; i < list->count; ++i) {
        const stp_draw_item* item = &list->items[i];
        const uint32_t numbers[] = {(uint32_t)item->kind, item->index,     item->prefix,
                                    item->full_prefix,    item->first_run, item->run_count,
                                    item->ghost ? 1 : 0};
        const float sizes[] = {item->radius, item->pixel_radius, item->fade_begin, item->fade_end};
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

static bool is_same_style(const stp_draw_style* a, const stp_draw_style* b)
{
    return a->splat_scale == b->splat_scale && a->supersample == b->supersample &&
           a->headlight == b->headlight && a->background == b->background &&
           memcmp(a->background_color, b->background_color, sizeof(a->background_color)) == 0 &&
           a->filter == b->filter && a->eye_dome == b->eye_dome &&
           a->ambient_occlusion == b->ambient_occlusion && a->ghost == b->ghost;
}

void cpu_continue_accumulation(cpu_renderer* r, const stp_view* view, const stp_draw_list* list,
                               const stp_draw_style* style)
{
    cpu_accumulation* a = &r->accumulation;
    stp_hash hash = hash_list(list);
    if (!is_same_view(&a->view, view) || !stp_hash_equal(a->list, hash) ||
        !is_same_style(&a->style, style)) {
        a->frames = 0;
    }
    a->view = *view;
    a->list = hash;
    a->style = *style;
}

stp_result cpu_make_accumulation(cpu_renderer* r, uint32_t frames)
{
    cpu_accumulation* a = &r->accumulation;
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
    cpu_renderer* r = user;
    const cpu_accumulation* a = &r->accumulation;
    (void)worker;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        const uint8_t* in = r->image->pixels + 4 * at;
        uint32_t* sum = a->sums + 4 * at;
        uint32_t there = in[3] > 0;
        for (int k = 0; k < 3; ++k) {
            sum[k] = (a->frames > 0 ? sum[k] : 0) + there * a->linear[in[k]];
        }
        sum[3] = (a->frames > 0 ? sum[3] : 0) + there;
    }
}

void cpu_add_frame(cpu_renderer* r)
{
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, add_rows, r);
}

static void show_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    cpu_renderer* r = user;
    const stp_draw_style* style = r->style;
    float whole = 1.0f / (float)r->accumulation.frames;
    uint64_t covered = 0;
    for (size_t at = begin * r->width; at < end * r->width; ++at) {
        const uint32_t* sum = r->accumulation.sums + 4 * at;
        uint8_t* out = r->image->pixels + 4 * at;
        float coverage = (float)sum[3] * whole;
        float share = sum[3] > 0 ? 1.0f / ((float)sum[3] * (float)LINEAR_FULL) : 0.0f;
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

void cpu_show_frames(cpu_renderer* r)
{
    stp_team_run(&r->team, r->height, CPU_BAND_ROWS, show_rows, r);
}

void cpu_destroy_accumulation(cpu_renderer* r)
{
    stp_free(r->base.context, r->accumulation.memory);
    stp_free(r->base.context, r->accumulation.linear);
}
