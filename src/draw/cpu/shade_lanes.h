// SPDX-License-Identifier: MIT
// Merging and lighting, written for vectors of LANES numbers. Included once by each variant, which
// defines the types lanes_int and lanes_float, and the few operations with special instructions.
#pragma once

#include "draw/cpu/shade.h"
#include "draw/shaders/light_constants.h"

#include <assert.h>
#include <string.h>

enum { SURFACE_FLOATS = sizeof(stp_cpu_shade_surface) / sizeof(float) };

static inline lanes_float load_float(const float* from)
{
    lanes_float v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline lanes_int load_int(const uint32_t* from)
{
    lanes_int v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline lanes_float dot(const lanes_float a[3], const lanes_float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline lanes_float dot_with(const lanes_float a[3], stp_vec3 b)
{
    return a[0] * b.x + a[1] * b.y + a[2] * b.z;
}

static inline lanes_float spread(float value)
{
    return value - (lanes_float){0};
}

static inline lanes_int spread_int(int32_t value)
{
    return value - (lanes_int){0};
}

static inline lanes_float minimum(lanes_float a, lanes_float b)
{
    return lanes_select(a < b, a, b);
}

static inline lanes_float maximum(lanes_float a, lanes_float b)
{
    return lanes_select(a > b, a, b);
}

/// Normalizes; zero stays zero.
static inline void normalize(lanes_float v[3])
{
    lanes_float square = dot(v, v), inverse = 1.0f / lanes_root(square);
    for (int k = 0; k < 3; ++k) {
        v[k] = lanes_select(square > 0.0f, v[k] * inverse, spread(0.0f));
    }
}

static inline void direct_to_eye(const stp_cpu_shade_scene* s, lanes_float x, lanes_float y,
                                 lanes_float eye[3])
{
    const float start[3] = {s->start.x, s->start.y, s->start.z};
    const float across[3] = {s->across.x, s->across.y, s->across.z};
    const float down[3] = {s->down.x, s->down.y, s->down.z};
    for (int k = 0; k < 3; ++k) {
        eye[k] = s->parallel ? spread(start[k]) : start[k] + across[k] * x + down[k] * y;
    }
    if (!s->parallel) {
        normalize(eye);
    }
}

/// Smoothstep: from 0 to 1 for x from 0 to 1.
static inline lanes_float smooth(lanes_float x)
{
    x = minimum(maximum(x, spread(0.0f)), spread(1.0f));
    return x * x * (3.0f - 2.0f * x);
}

/// Environment reflected in a direction: sky and ground, with a horizon between them, and two soft
/// boxes; blurred on rough surfaces.
static inline void mirror_lanes(const stp_lighting* light, const lanes_float r[3],
                                lanes_float rough, lanes_float out[3])
{
    static const float horizon[3] = {MIRROR_HORIZON_R, MIRROR_HORIZON_G, MIRROR_HORIZON_B};
    static const float ground[3] = {MIRROR_GROUND_R, MIRROR_GROUND_G, MIRROR_GROUND_B};
    lanes_float width = MIRROR_BLUR + MIRROR_BLUR_ROUGH * rough, sharp = 1.0f / width;
    lanes_float height = dot_with(r, light->up);
    lanes_float above = smooth(height * sharp + 0.5f);
    lanes_float fade = 1.0f - (1.0f - MIRROR_ZENITH) * maximum(height, spread(0.0f));
    lanes_float left = dot_with(r, light->left_box) - MIRROR_LEFT_EDGE;
    lanes_float right = dot_with(r, light->right_box) - MIRROR_RIGHT_EDGE;
    lanes_float boxes = (MIRROR_BOX_LEFT * smooth(left * sharp + 0.5f) +
                         MIRROR_BOX_RIGHT * smooth(right * sharp + 0.5f)) *
                        (1.0f - MIRROR_ROUGH_BOX * rough);
    for (int k = 0; k < 3; ++k) {
        out[k] = ground[k] + (horizon[k] * fade - ground[k]) * above + boxes;
    }
}

/// The key light's highlight: the distribution of Trowbridge and Reitz, bounded; wider where
/// normals have a variance (Toksvig 2005).
static inline lanes_float gloss_lanes(const stp_lighting* light, const lanes_float eye[3],
                                      lanes_float toward, lanes_float facing, lanes_float variance,
                                      const lanes_float material[8])
{
    lanes_float a2 = minimum(material[2] + SPREAD_GLOSS * variance, spread(1.0f));
    lanes_float size = lanes_select(variance > 0.0f, 1.0f / (4.0f * a2 + 0.2f), material[3]);
    // square of the sum of the unit vectors to light and eye, which points halfway between them:
    // 2 + 2 light . eye
    lanes_float square = 2.0f + 2.0f * dot_with(eye, light->key);
    lanes_float along = maximum(toward + facing, spread(0.0f));
    lanes_float squared = lanes_select(square > 0.0f, along * along / square, spread(0.0f));
    lanes_float d = squared * (a2 - 1.0f) + 1.0f;
    lanes_float bounded = minimum(a2 / (d * d) * size, spread(LIGHT_GLOSS_MAX));
    return maximum(toward, spread(0.0f)) * bounded * (1.0f - material[1]);
}

/// Diffuse light for each channel: the mean over normals about n. With their mean of this length,
/// those of the visible side lean towards the eye; the mean of a clamped cosine is a soft clamp of
/// the mean cosine. Without a variance, it is the light of n, to the bit.
static inline void diffuse_lanes(const stp_lighting* light, const lanes_float eye[3],
                                 const lanes_float n[3], lanes_float facing, lanes_float length,
                                 lanes_float variance, lanes_float out[3])
{
    static const float sky[3] = {LIGHT_SKY_R, LIGHT_SKY_G, LIGHT_SKY_B};
    static const float ground[3] = {LIGHT_GROUND_R, LIGHT_GROUND_G, LIGHT_GROUND_B};
    static const float key[3] = {LIGHT_KEY_R, LIGHT_KEY_G, LIGHT_KEY_B};
    lanes_float to_eye = (1.0f - length) * SPREAD_TO_EYE;
    lanes_float toward = length * dot_with(n, light->key) + to_eye * dot_with(eye, light->key);
    lanes_float soft = lanes_root(toward * toward + SPREAD_LAMBERT * variance);
    lanes_float lambert = 0.5f * (toward + soft);
    lanes_float up = length * dot_with(n, light->up) + to_eye * dot_with(eye, light->up);
    lanes_float height = 0.5f + 0.5f * up;
    lanes_float fill =
        LIGHT_FILL * facing * facing * (length * length) + LIGHT_FILL * SPREAD_FILL * variance;
    for (int k = 0; k < 3; ++k) {
        out[k] = ground[k] + (sky[k] - ground[k]) * height + key[k] * lambert + fill;
    }
}

/// Light from key, sky and ground, and reflections. Visible surfaces face the eye. A surface that
/// is not polished reflects as much light as falls on it.
/// @param apart 1 less the length of the mean of the normals about n
static inline void light_lanes(const stp_lighting* light, const lanes_float eye[3],
                               lanes_float n[3], lanes_float apart, const lanes_float color[3],
                               const lanes_float material[8], lanes_float out[3])
{
    lanes_float metallic = material[0], rough = material[1], r[3], mirrored[3], diffuse[3];
    lanes_float facing = dot(n, eye);
    lanes_float length = 1.0f - apart, variance = 1.0f - length * length;
    lanes_int turned = facing < 0.0f;
    for (int k = 0; k < 3; ++k) {
        n[k] = lanes_select(turned, n[k] * -1.0f, n[k]);
    }
    facing = lanes_select(turned, -facing, facing);
    for (int k = 0; k < 3; ++k) {
        r[k] = 2.0f * facing * n[k] - eye[k];
    }
    mirror_lanes(light, r, minimum(rough + variance, spread(1.0f)), mirrored);
    lanes_float gloss =
        gloss_lanes(light, eye, dot_with(n, light->key), facing, variance, material);
    diffuse_lanes(light, eye, n, facing, length, variance, diffuse);
    lanes_float aside = 1.0f - facing, polish = 1.0f - rough, square = aside * aside;
    lanes_float edge = square * square * aside * polish * polish * LIGHT_GRAZING;
    lanes_int unlit = material[7] > 0.0f;
    for (int k = 0; k < 3; ++k) {
        lanes_float front = LIGHT_DIELECTRIC + (color[k] - LIGHT_DIELECTRIC) * metallic;
        lanes_float mirror = front + (1.0f - front) * edge;
        lanes_float seen = mirrored[k] + (diffuse[k] - mirrored[k]) * rough;
        lanes_float lit = color[k] * (1.0f - metallic) * diffuse[k] + mirror * seen +
                          front * gloss + material[4 + k];
        out[k] = lanes_select(unlit, color[k] + material[4 + k], lit);
    }
}

static inline lanes_int encode_lanes(const stp_cpu_shade_scene* scene, lanes_float linear)
{
    const float top = (float)(CPU_ENCODE_SIZE - 1);
    lanes_float scaled = linear * (float)CPU_ENCODE_SIZE;
    scaled = lanes_select(scaled > 0.0f, scaled, spread(0.0f)); // also NaN
    scaled = lanes_select(scaled >= top, spread(top), scaled);
    return lanes_gather_byte(scene->encode, __builtin_convertvector(scaled, lanes_int));
}

static void light_all(const stp_cpu_shade_scene* scene, const stp_cpu_shade_surface* surfaces,
                      stp_cpu_shade_lanes* lanes)
{
    assert(lanes->count <= SHADE_PIXELS && "the last vector may be padded");
    for (uint32_t at = 0; at < lanes->count; at += LANES) {
        lanes_float field[SURFACE_FLOATS], eye[3], out[3];
        lanes_turn(surfaces, lanes->surface + at, field);
        normalize(field + 4);
        direct_to_eye(scene, load_float(lanes->x + at), load_float(lanes->y + at), eye);
        light_lanes(&scene->light, eye, field + 4, field[7], field, field + 8, out);
        lanes_int bytes = spread_int(INT32_MIN / 128); // alpha 255
        for (int k = 0; k < 3; ++k) {
            bytes |= encode_lanes(scene, out[k]) << (8 * k);
        }
        memcpy(lanes->bytes + at, &bytes, sizeof(bytes));
        for (int k = 0; k < 3 && lanes->wants_linear; ++k) {
            memcpy(lanes->linear[k] + at, &out[k], sizeof(out[k]));
        }
    }
}

/// Writes up to LANES - 1 pixels past the end.
static void spread_row(const stp_cpu_shade_run* run, const stp_cpu_shade_run* end,
                       const stp_cpu_shade_nearness* surfaces, const uint32_t* lanes,
                       const float* nearness, uint8_t* restrict colors, float* restrict depth)
{
    for (; run < end; ++run) {
        stp_cpu_shade_run now = *run;
        assert(now.length > 0 && (uint32_t)now.x + now.length <= SHADE_WIDTH);
        stp_cpu_shade_nearness near = surfaces[now.surface];
        const uint32_t* lane = lanes + now.lane;
        for (uint32_t k = 0; k < now.length; k += LANES) {
            uint32_t x = now.x + k;
            lanes_float there = load_float(nearness + x) * near.factor + near.shift;
            lanes_int color =
                now.flat ? spread_int((int32_t)lane[k / SHADE_REACH]) : load_int(lane + k);
            memcpy(depth + x, &there, sizeof(there));
            memcpy(colors + 4 * (size_t)x, &color, sizeof(color));
        }
    }
}

/// Merges the pixels of one buffer into the minimum, if any are covered.
static inline void merge_one(uint64_t* restrict from, uint32_t size, uint64_t* restrict pixels)
{
    uint64_t all = STP_RASTER_EMPTY;
    for (uint32_t i = 0; i < SHADE_WIDTH;
         i += 8) { // prefetch the next tile: its rows are far apart in memory
        __builtin_prefetch(from + SHADE_WIDTH + i, 1);
    }
    for (uint32_t i = 0; i < size; ++i) {
        all &= from[i];
    }
    if (all == STP_RASTER_EMPTY) {
        return; // not written: its cache lines stay clean
    }
    for (uint32_t i = 0; i < size; ++i) { // nearness is never negative, so all signs are equal
        int64_t a = (int64_t)from[i], b = (int64_t)pixels[i];
        pixels[i] = (uint64_t)(a < b ? a : b);
    }
    for (uint32_t i = 0; i < size; ++i) {
        from[i] = STP_RASTER_EMPTY;
    }
}

static void merge_row(uint64_t* const* buffers, uint32_t count, size_t at, uint32_t size,
                      uint64_t* copy, stp_cpu_shade_merged* restrict row)
{
    assert(size > 0 && size <= SHADE_WIDTH);
    uint64_t pixels[SHADE_WIDTH];
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        pixels[i] = STP_RASTER_EMPTY;
    }
    for (uint32_t k = 0; k < count; ++k) {
        if (size == SHADE_WIDTH) { // known to the compiler: no remainder loop
            merge_one(buffers[k] + at, SHADE_WIDTH, pixels);
        } else {
            merge_one(buffers[k] + at, size, pixels);
        }
    }
    if (copy != NULL) {
        memcpy(copy, pixels, size * sizeof(*copy));
    }
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        uint32_t bits = ~(uint32_t)(pixels[i] >> 32); // 0 if empty
        memcpy(&row->nearness[i], &bits, sizeof(bits));
        row->ids[i + 1] = (uint32_t)pixels[i];
    }
    row->there = row->starts = 0;
    for (uint32_t i = 0; i < SHADE_WIDTH; i += LANES) {
        lanes_int ids = load_int(row->ids + i + 1), before = load_int(row->ids + i);
        row->starts |= (uint64_t)lanes_mask(ids != before) << i;
        row->there |= (uint64_t)lanes_mask(ids != -1) << i;
    }
    row->starts |= 1;
}

static void find_depths(uint64_t* const* buffers, uint32_t count, size_t at, size_t size,
                        float* restrict depth)
{
    size_t i = 0;
    for (; i + LANES <= size; i += LANES) {
        lanes_int least =
            spread_int(-1); // empty; nearness is never negative, so all signs are equal
        for (uint32_t k = 0; k < count; ++k) {
            lanes_int upper = lanes_upper(buffers[k] + at + i);
            least = (lanes_int)lanes_select(upper < least, (lanes_float)upper, (lanes_float)least);
        }
        least = ~least; // nearness; 0 if empty
        memcpy(depth + i, &least, sizeof(least));
    }
    for (; i < size; ++i) {
        uint64_t least = STP_RASTER_EMPTY;
        for (uint32_t k = 0; k < count; ++k) {
            least = buffers[k][at + i] < least ? buffers[k][at + i] : least;
        }
        depth[i] = stp_raster_nearness(least);
    }
}
