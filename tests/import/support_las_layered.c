// SPDX-License-Identifier: MIT
#include "laz_encoder.h"

#include <assert.h>
#include <string.h>

enum { XY, Z, CLASS, FLAGS, INTENSITY, ANGLE, USER, SOURCE, TIME, RGB, NIR, LAYERS, JUNK = 5 };

typedef struct channel {
    bool met, new_time;
    las_point last;
    uint16_t color[4]; // red, green, blue, near infrared
    bool color_met;
    stp_laz_model changed[8], channel, counts[16], numbers[16], same_pulse, classes[64], used,
        nir[2];
    stp_laz_integer x, y, z, intensity, angle, source;
    stp_laz_time time;
    stp_laz_rgb rgb;
    stp_laz_median x_steps[12], y_steps[12];
    int32_t heights[8];
    uint16_t intensities[8];
} channel;

typedef struct layered {
    channel channels[4];
    unsigned at, color_at;
    laz_encoder layers[LAYERS];
} layered;

static void make(stp_laz_pool* pool, layered* l)
{
    for (int i = 0; i < 4; ++i) {
        channel* c = &l->channels[i];
        stp_laz_models_make(pool, c->changed, 8, 128);
        stp_laz_model_make(pool, &c->channel, 3);
        stp_laz_models_make(pool, c->counts, 16, 16);
        stp_laz_models_make(pool, c->numbers, 16, 16);
        stp_laz_model_make(pool, &c->same_pulse, 13);
        stp_laz_models_make(pool, c->classes, 64, 256);
        stp_laz_model_make(pool, &c->used, 4);
        stp_laz_models_make(pool, c->nir, 2, 256);
        stp_laz_integer_make(pool, &c->x, 32, 2);
        stp_laz_integer_make(pool, &c->y, 32, 22);
        stp_laz_integer_make(pool, &c->z, 32, 20);
        stp_laz_integer_make(pool, &c->intensity, 16, 4);
        stp_laz_integer_make(pool, &c->angle, 16, 2);
        stp_laz_integer_make(pool, &c->source, 16, 1);
        stp_laz_time_make(pool, &c->time, 0);
        stp_laz_rgb_make(pool, &c->rgb);
    }
}

static void visit_object(channel* c, const las_point* last)
{
    c->met = true;
    c->last = *last;
    c->new_time = false;
    for (int i = 0; i < 8; ++i) {
        c->heights[i] = last->position[2];
        c->intensities[i] = last->intensity;
    }
    stp_laz_time_begin(&c->time, last->time);
}

// Contexts by number of returns and return number; checked against the decoder's table by another
// program.
static unsigned return_context(unsigned n, unsigned r)
{
    static const char rows[16][17] = {
        "0123453445555555", "1013333333333333", "2124444444433333", "3345444444444444",
        "4344544444444444", "5344454444444444", "3344445444444444", "4344444544444444",
        "4344444454444444", "5344444445444444", "5344444444544444", "5334444444455444",
        "5334444444455544", "5334444444445554", "5334444444444555", "5334444444444455"};
    assert(n < 16 && r < 16 && "returns have four bits");
    return (unsigned)(rows[n][r] - '0');
}

// The first layer. @return the channel's contexts, now of this point
static channel* put_xy(layered* l, const las_point* p, bool* new_time)
{
    laz_encoder* e = &l->layers[XY];
    channel* before = &l->channels[l->at];
    const las_point* b = &before->last;
    unsigned context = (b->return_number == 1 ? 1u : 0u) |
                       (b->return_number >= b->return_count ? 2u : 0u) |
                       (before->new_time ? 4u : 0u);
    assert(p->channel < 4 && "channels have two bits");
    channel* c = &l->channels[p->channel];
    const las_point* a = c->met ? &c->last : b;
    unsigned step = (unsigned)(p->return_number - a->return_number) & 15;
    unsigned kind = step == 0 ? 0 : step == 1 ? 1 : step == 15 ? 2 : 3;
    *new_time = a->time != p->time;
    unsigned changed = kind | (a->return_count != p->return_count ? 4u : 0) |
                       (a->angle != p->angle ? 8u : 0) | (*new_time ? 16u : 0) |
                       (a->source != p->source ? 32u : 0) | (p->channel != l->at ? 64u : 0);
    laz_put_symbol(e, &before->changed[context], changed);
    if (p->channel != l->at) {
        laz_put_symbol(e, &before->channel, (p->channel - l->at - 1) & 3);
        if (!c->met) {
            visit_object(c, b);
        }
        l->at = p->channel;
    }
    if (changed & 4) {
        laz_put_symbol(e, &c->counts[c->last.return_count], p->return_count);
    }
    if (kind == 3) {
        bool other = *new_time;
        laz_put_symbol(e, other ? &c->numbers[c->last.return_number] : &c->same_pulse,
                       other ? p->return_number : step - 2);
    }
    unsigned m = return_context(p->return_count, p->return_number) * 2 + *new_time;
    unsigned single = p->return_count == 1;
    int32_t dx = (int32_t)((uint32_t)p->position[0] - (uint32_t)c->last.position[0]);
    int32_t dy = (int32_t)((uint32_t)p->position[1] - (uint32_t)c->last.position[1]);
    laz_put_integer(e, &c->x, c->x_steps[m].values[2], dx, single, 32);
    stp_laz_median_add(&c->x_steps[m], dx);
    laz_put_integer(e, &c->y, c->y_steps[m].values[2], dy, single + laz_even(c->x.k, 20), 32);
    stp_laz_median_add(&c->y_steps[m], dy);
    return c;
}

static void put_values(layered* l, channel* c, const las_point* p, bool new_time)
{
    unsigned n = p->return_count, r = p->return_number, single = n == 1;
    unsigned level = n > r ? n - r : r - n, kind = (r == 1 ? 1u : 0u) | (r >= n ? 2u : 0u);
    level = level < 7 ? level : 7;
    laz_put_integer(&l->layers[Z], &c->z, c->heights[level], p->position[2],
                    single + laz_even((c->x.k + c->y.k) / 2, 18), 32);
    c->heights[level] = p->position[2];
    laz_put_symbol(&l->layers[CLASS], &c->classes[(c->last.class & 31) << 1 | (kind == 3)],
                   p->class);
    uint16_t* last = &c->intensities[kind << 1 | new_time];
    laz_put_integer(&l->layers[INTENSITY], &c->intensity, *last, p->intensity, kind, 16);
    *last = p->intensity;
    if (c->last.angle != p->angle) {
        laz_put_integer(&l->layers[ANGLE], &c->angle, c->last.angle, p->angle, new_time, 16);
    }
    if (c->last.source != p->source) {
        laz_put_integer(&l->layers[SOURCE], &c->source, c->last.source, p->source, 0, 16);
    }
    if (new_time) {
        laz_put_time(&l->layers[TIME], &c->time, p->time, 0);
    }
}

// Colours of version 3 continue from the previous channel if this one is already known.
static void put_colors(layered* l, const las_desc* desc, const las_point* p)
{
    channel *before = &l->channels[l->color_at], *c = &l->channels[p->channel], *last = c;
    if (p->channel != l->color_at) {
        if (!c->color_met) {
            memcpy(c->color, before->color, sizeof(c->color));
        } else {
            last = desc->fixed ? c : before;
        }
        c->color_met = true;
        l->color_at = p->channel;
    }
    laz_put_rgb(&l->layers[RGB], &c->rgb, last->color, p->rgb);
    memcpy(last->color, p->rgb, sizeof(p->rgb));
    unsigned was = last->color[3], low = (was ^ p->nir) & 255, high = (was ^ p->nir) >> 8;
    if (desc->format == 8 || desc->format == 10) {
        laz_put_symbol(&l->layers[NIR], &c->used, (low != 0 ? 1u : 0u) | (high != 0 ? 2u : 0u));
        if (low != 0) {
            laz_put_symbol(&l->layers[NIR], &c->nir[0], (p->nir - was) & 255);
        }
        if (high != 0) {
            laz_put_symbol(&l->layers[NIR], &c->nir[1], ((p->nir >> 8) - (was >> 8)) & 255);
        }
        last->color[3] = p->nir;
    }
}

// A layer whose value never changes has no bytes.
static bool changes(const las_desc* desc, size_t first, size_t count, int layer)
{
    const las_point* a = &desc->points[first];
    bool any = layer == XY;
    for (const las_point* b = a; b < a + count; ++b) {
        any = any || (layer == Z && a->position[2] != b->position[2]) ||
              (layer == CLASS && a->class != b->class) ||
              (layer == INTENSITY && a->intensity != b->intensity) ||
              (layer == ANGLE && a->angle != b->angle) ||
              (layer == SOURCE && a->source != b->source) ||
              (layer == TIME && a->time != b->time) ||
              (layer == RGB && memcmp(a->rgb, b->rgb, sizeof(a->rgb)) != 0) ||
              (layer == NIR && a->nir != b->nir);
    }
    return any;
}

static void put_layers(layered* l, const las_desc* desc, size_t first, size_t count,
                       las_buffer* out)
{
    bool rgb = desc->format != 6 && desc->format != 9,
         nir = desc->format == 8 || desc->format == 10;
    int layers = TIME + 1 + rgb + nir;
    size_t junk = desc->extra + (desc->format >= 9); // layers that readers may skip
    las_put_number(out, count, 4);
    for (int i = 0; i < layers; ++i) {
        bool there = changes(desc, first, count, i);
        laz_encoder_end(&l->layers[i]);
        las_put_number(out, there ? l->layers[i].out.size : 0, 4);
    }
    for (size_t i = 0; i < junk; ++i) {
        las_put_number(out, JUNK, 4);
    }
    for (int i = 0; i < layers; ++i) {
        if (changes(desc, first, count, i)) {
            las_put(out, l->layers[i].out.bytes, l->layers[i].out.size);
        }
    }
    for (size_t i = 0; i < JUNK * junk; ++i) {
        las_put_number(out, 0xA5 ^ i, 1);
    }
}

void laz_write_layered(const las_desc* desc, size_t first, size_t count, las_buffer* out)
{
    unsigned char record[256];
    const las_point* p = &desc->points[first];
    assert(desc->format >= 6 && "older formats are compressed pointwise");
    assert(count > 0 && first + count <= desc->count && "the chunk has points of the file");
    assert(p->channel < 4 && las_record_size(desc) <= sizeof(record));
    layered* l = calloc(1, sizeof(*l));
    stp_laz_pool pool = {0};
    make(&pool, l);
    pool = (stp_laz_pool){.bytes = calloc(1, pool.used)};
    unsigned char* numbers = pool.bytes;
    make(&pool, l);
    las_put(out, record, las_write_record(desc, first, record));
    for (int i = 0; i < LAYERS; ++i) {
        l->layers[i] = laz_encoder_begin();
    }
    l->at = l->color_at = p->channel;
    channel* c = &l->channels[p->channel];
    visit_object(c, p);
    c->color_met = true;
    memcpy(c->color, p->rgb, sizeof(p->rgb));
    c->color[3] = p->nir;
    for (size_t i = 1; i < count; ++i) {
        bool new_time;
        c = put_xy(l, &p[i], &new_time);
        put_values(l, c, &p[i], new_time);
        c->last = p[i];
        c->new_time = new_time;
        if (desc->format != 6 && desc->format != 9) {
            put_colors(l, desc, &p[i]);
        }
    }
    put_layers(l, desc, first, count, out);
    for (int i = 0; i < LAYERS; ++i) {
        free(l->layers[i].out.bytes);
    }
    free(numbers);
    free(l);
}
