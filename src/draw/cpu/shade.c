// SPDX-License-Identifier: MIT
// From the visibility buffer to colours: each pixel is looked up and lit once.
#include "draw/cpu/shade.h"

#include <string.h>

/// What one band of the picture needs to know.
typedef struct shader {
    cpu_renderer* r;
    cpu_worker* worker;
    const cpu_shade_kernels* kernels;
    cpu_shade_row row;
    uint32_t buffer_count;
    uint64_t** buffers; ///< of workers that drew
    uint32_t item;      ///< that the last pixel belonged to
    uint32_t alone_count;
    uint8_t alone[SHADE_CHUNK]; ///< lanes lit by themselves
    float alone_color[SHADE_CHUNK][3];
} shader;

static int32_t read_color(const uint8_t* color)
{
    return (int32_t)((uint32_t)color[0] | (uint32_t)color[1] << 8 | (uint32_t)color[2] << 16);
}

static void look_up_surfel(const cpu_shade_item* item, uint32_t index, cpu_shade_chunk* c,
                           uint32_t lane)
{
    c->coded[lane] = -1;
    c->color[lane] = read_color(item->colors + 3 * (size_t)index);
    c->low[lane] = c->color[lane];
    c->blend[lane] = item->blend;
    if (index < item->low_count) {
        c->low[lane] = read_color(item->low_colors + 3 * (size_t)index);
        c->has_low = true;
    }
    uint16_t code;
    memcpy(&code, item->normals + 2 * (size_t)index, sizeof(code));
    c->code[lane] = code;
    c->material[lane] = item->materials[index];
    c->has_codes = true;
}

static void look_up_point(const shader* s, uint32_t slot, uint32_t index, cpu_shade_chunk* c,
                          uint32_t lane)
{
    const cpu_item* item = &s->r->items[slot];
    const stp_store_point_set* points = &item->points;
    stp_vec3 normal = {0};
    for (size_t k = 0; k < 3; ++k) {
        float color = item->material->base_color[k];
        if (points->colors != NULL) {
            color *= s->row.decode[points->colors[4 * (size_t)index + k]];
        }
        c->linear[k][lane] = color;
    }
    if (points->normals != NULL) {
        normal = cpu_decode_normal(points->normals + 2 * (size_t)index);
    }
    c->normal[0][lane] = normal.x;
    c->normal[1][lane] = normal.y;
    c->normal[2][lane] = normal.z;
    c->material[lane] = (int32_t)s->row.items[slot].material;
}

/// Which items pixels show; what will be read of surfels is asked for.
static void find_items(shader* s, cpu_shade_chunk* c, uint32_t size)
{
    const cpu_shade_item* items = s->row.items;
    uint32_t slot = s->item;
    for (uint32_t i = 0; i < size; ++i) {
        c->there[i] = -(int32_t)(c->pixels[i] != STP_RASTER_EMPTY);
        uint32_t id = stp_raster_id(c->pixels[i]);
        if (id - items[slot].first_id >= items[slot].count && c->there[i] != 0) {
            slot = cpu_find_item(s->r, id);
        }
        c->item[i] = (int32_t)slot;
        const cpu_shade_item* item = &items[slot];
        if (item->kind == STP_DRAW_SURFELS && c->there[i] != 0) {
            size_t index = id - item->first_id;
            __builtin_prefetch(item->colors + 3 * index);
            __builtin_prefetch(item->normals + 2 * index);
            __builtin_prefetch(item->materials + index);
        }
    }
    s->item = slot;
}

/// What pixels show.
static void look_up(shader* s, cpu_shade_chunk* c, uint32_t x, uint32_t y, uint32_t size)
{
    float* depth = s->r->depth + (size_t)y * s->r->width + x;
    find_items(s, c, size);
    c->has_codes = c->has_low = false;
    s->alone_count = 0;
    for (uint32_t i = 0; i < size; ++i) {
        if (c->there[i] == 0) {
            continue;
        }
        const cpu_shade_item* item = &s->row.items[c->item[i]];
        uint32_t index = stp_raster_id(c->pixels[i]) - item->first_id;
        c->coded[i] = 0;
        if (item->kind == STP_DRAW_SURFELS) {
            look_up_surfel(item, index, c, i);
        } else if (item->kind == STP_DRAW_POINTS) {
            look_up_point(s, (uint32_t)c->item[i], index, c, i);
        } else {
            depth[i] = cpu_true_nearness(&s->r->items[c->item[i]], depth[i]);
            bool done = cpu_look_up_triangle(s->r, s->worker, &s->row, c, i, x + i, y,
                                             s->alone_color[s->alone_count]);
            s->alone[s->alone_count] = (uint8_t)i;
            s->alone_count += done ? 0 : 1;
        }
    }
}

/// What the direction to the eye is made of, for a row: (forward + right u + down v) turned round.
static void begin_row(shader* s, uint32_t y)
{
    const cpu_renderer* r = s->r;
    const stp_view_frame* f = &r->frame;
    stp_vec3d start = stp_scaled(f->forward, -1.0);
    if (!f->parallel) {
        double u = (-f->center_x - r->shift_x) / f->scale;
        double v = ((double)y + 0.5 - f->center_y - r->shift_y) / f->scale;
        start = stp_subd(start, stp_addd(stp_scaled(f->right, u), stp_scaled(f->down, v)));
    }
    s->row.start = stp_to_float(start);
    s->row.step = stp_to_float(stp_scaled(f->right, -1.0 / f->scale));
    s->row.parallel = f->parallel;
}

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

static void add_to_sums(const cpu_renderer* r, size_t at, const cpu_shade_chunk* c, uint32_t size,
                        bool any)
{
    for (uint32_t i = 0; i < size; ++i) {
        float* sum = r->sums + 4 * (at + i);
        bool there = any && c->there[i] != 0;
        for (int k = 0; k < 3; ++k) {
            float linear = there ? c->out[k][i] : 0.0f;
            linear = linear < 1.0f ? linear : 1.0f; // so that glints do not outshine edges
            sum[k] = r->sample == 0 ? linear : sum[k] + linear;
        }
        float coverage = there ? 1.0f : 0.0f;
        sum[3] = r->sample == 0 ? coverage : sum[3] + coverage;
    }
}

/// Shades what a chunk's pixels show.
static void shade_chunk(shader* s, cpu_shade_chunk* c, uint32_t x, uint32_t y, uint32_t size)
{
    look_up(s, c, x, y, size);
    s->kernels->light(&s->row, c, x, size);
    for (uint32_t k = 0; k < s->alone_count; ++k) {
        const float* color = s->alone_color[k];
        uint32_t lane = s->alone[k];
        write_pixel(s->r, color, 1.0f, (uint8_t*)&c->bytes[lane]);
        for (int i = 0; i < 3; ++i) {
            c->out[i][lane] = color[i];
        }
    }
}

static void finish_chunk(const shader* s, const cpu_shade_chunk* c, size_t at, uint32_t size,
                         bool any)
{
    const cpu_renderer* r = s->r;
    if (r->sample_count > 1) {
        add_to_sums(r, at, c, size, any);
        return;
    }
    uint8_t* out = r->image->pixels + 4 * at;
    if (any) {
        memcpy(out, c->bytes, 4 * (size_t)size);
        for (uint32_t i = 0; i < size; ++i) {
            s->worker->covered += c->there[i] != 0;
        }
        return;
    }
    for (uint32_t i = 0; i < size; ++i) {
        memcpy(out + 4 * (size_t)i, &s->row.empty, 4);
    }
}

static shader make_shader(cpu_renderer* r, cpu_worker* worker)
{
    shader s = {.r = r,
                .worker = worker,
                .kernels = cpu_choose_shade_kernels(),
                .row = {.items = r->shade_items,
                        .materials = r->shade_materials,
                        .decode = r->decode,
                        .encode = r->encode,
                        .light = make_light(r)},
                .buffers = worker->buffers};
    const float nothing[3] = {0};
    write_pixel(r, nothing, 0.0f, (uint8_t*)&s.row.empty);
    for (uint32_t i = 0; i < r->team.threads; ++i) {
        if (r->workers[i].drew) {
            s.buffers[s.buffer_count++] = r->workers[i].pixels;
        }
    }
    return s;
}

void cpu_shade_rows(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker)
{
    shader s = make_shader(r, worker);
    cpu_shade_chunk chunk = {0};
    for (uint32_t y = begin; y < end; ++y) {
        begin_row(&s, y);
        for (uint32_t x = 0; x < r->width; x += SHADE_CHUNK) {
            uint32_t left = r->width - x, size = left < SHADE_CHUNK ? left : SHADE_CHUNK;
            size_t at = (size_t)y * r->width + x;
            bool any =
                s.kernels->merge(s.buffers, s.buffer_count, at, size, chunk.pixels, r->depth + at);
            if (any) {
                shade_chunk(&s, &chunk, x, y, size);
            }
            finish_chunk(&s, &chunk, at, size, any);
        }
    }
}

void cpu_find_depths(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker)
{
    shader s = make_shader(r, worker);
    for (size_t at = (size_t)begin * r->width; at < (size_t)end * r->width; ++at) {
        uint64_t least = STP_RASTER_EMPTY;
        for (uint32_t k = 0; k < s.buffer_count; ++k) {
            least = s.buffers[k][at] < least ? s.buffers[k][at] : least;
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
