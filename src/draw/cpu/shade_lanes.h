// SPDX-License-Identifier: MIT
// Merging and lighting, written for vectors of LANES numbers. Included once by each variant, which defines the
// types lanes_int and lanes_float and the few operations that need its own instructions.
#pragma once

#include "draw/cpu/shade.h"

#include <string.h>

static inline lanes_int load_int(const int32_t* from)
{
    lanes_int v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline lanes_float load_float(const float* from)
{
    lanes_float v;
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

/// Numbers `offset` of records of `size` floats each.
static inline lanes_float gather_field(const void* records, size_t size, size_t offset,
                                       lanes_int index, bool all_alike)
{
    const float* base = (const float*)records + offset;
    if (all_alike) {
        return spread(base[size * (size_t)index[0]]);
    }
    return lanes_gather(base, index * (int32_t)size);
}

static inline bool are_alike(lanes_int index)
{
    return lanes_none(index != spread_int(index[0]));
}

static inline void decode_colors(const cpu_shade_row* row, const cpu_shade_chunk* c, uint32_t at,
                                 lanes_int coded, lanes_float color[3])
{
    lanes_int bytes = load_int(c->color + at), low = load_int(c->low + at);
    lanes_float blend = load_float(c->blend + at);
    for (int k = 0; k < 3; ++k) {
        lanes_float linear = lanes_gather(row->decode, bytes >> (8 * k) & 255);
        if (c->has_low) {
            lanes_float before = lanes_gather(row->decode, low >> (8 * k) & 255);
            linear = before + (linear - before) * blend;
        }
        color[k] = lanes_select(coded, linear, color[k]);
    }
}

/// stp_octahedral_decode
static inline void decode_normals(const cpu_shade_chunk* c, uint32_t at, lanes_int coded,
                                  lanes_float normal[3])
{
    lanes_int code = load_int(c->code + at);
    lanes_float u = __builtin_convertvector(code << 24 >> 24, lanes_float) / 127.0f;
    lanes_float v = __builtin_convertvector(code << 16 >> 24, lanes_float) / 127.0f;
    lanes_float z = 1.0f - lanes_absolute(u) - lanes_absolute(v);
    lanes_float fold = lanes_select(z < 0.0f, -z, spread(0.0f));
    u = u + lanes_select(u >= 0.0f, -fold, fold);
    v = v + lanes_select(v >= 0.0f, -fold, fold);
    lanes_float length = lanes_root(u * u + v * v + z * z);
    normal[0] = lanes_select(coded, u / length, normal[0]);
    normal[1] = lanes_select(coded, v / length, normal[1]);
    normal[2] = lanes_select(coded, z / length, normal[2]);
}

/// From the item to the scene, of unit length, or zero.
static inline void turn_normals(const cpu_shade_row* row, lanes_int item, lanes_float normal[3])
{
    const size_t size = sizeof(cpu_shade_item) / sizeof(float);
    bool alike = are_alike(item);
    lanes_float turned[3];
    for (size_t k = 0; k < 3; ++k) {
        lanes_float m0 = gather_field(row->items, size, 3 * k, item, alike);
        lanes_float m1 = gather_field(row->items, size, 3 * k + 1, item, alike);
        lanes_float m2 = gather_field(row->items, size, 3 * k + 2, item, alike);
        turned[k] = m0 * normal[0] + m1 * normal[1] + m2 * normal[2];
    }
    lanes_float square = dot(turned, turned), inverse = 1.0f / lanes_root(square);
    for (int k = 0; k < 3; ++k) {
        normal[k] = lanes_select(square > 0.0f, turned[k] * inverse, spread(0.0f));
    }
}

static inline void direct_to_eye(const cpu_shade_row* row, uint32_t x, lanes_float eye[3])
{
    const float start[3] = {row->start.x, row->start.y, row->start.z};
    const float step[3] = {row->step.x, row->step.y, row->step.z};
    lanes_float center = __builtin_convertvector(lanes_index() + (int32_t)x, lanes_float) + 0.5f;
    for (int k = 0; k < 3; ++k) {
        eye[k] = row->parallel ? spread(start[k]) : start[k] + step[k] * center;
    }
    if (!row->parallel) {
        lanes_float inverse = 1.0f / lanes_root(dot(eye, eye));
        for (int k = 0; k < 3; ++k) {
            eye[k] = eye[k] * inverse;
        }
    }
}

static inline lanes_float least(lanes_float a, lanes_float b)
{
    return lanes_select(a < b, a, b);
}

static inline lanes_float most(lanes_float a, lanes_float b)
{
    return lanes_select(a > b, a, b);
}

/// cpu_light_surface
static inline void light_lanes(const cpu_shade_row* row, lanes_int material,
                               const lanes_float eye[3], lanes_float n[3],
                               const lanes_float color[3], lanes_float out[3])
{
    const size_t size = sizeof(cpu_shade_material) / sizeof(float);
    bool alike = are_alike(material);
    lanes_float field[8];
    for (size_t k = 0; k < 8; ++k) {
        field[k] = gather_field(row->materials, size, k, material, alike);
    }
    lanes_float metallic = field[0], kept = field[1], a2 = field[2];
    lanes_float facing = dot(n, eye);
    lanes_int turned = facing < 0.0f;
    for (int k = 0; k < 3; ++k) {
        n[k] = lanes_select(turned, n[k] * -1.0f, n[k]);
    }
    facing = lanes_select(turned, -facing, facing);
    lanes_float lambert = most(dot_with(n, row->light.toward), spread(0.0f));
    lanes_float height = 0.5f + 0.5f * dot_with(n, row->light.up);
    lanes_float diffuse = CPU_LIGHT_GROUND + (CPU_LIGHT_SKY - CPU_LIGHT_GROUND) * height +
                          CPU_LIGHT_KEY * lambert + CPU_LIGHT_FILL * facing;
    lanes_float half[3] = {row->light.toward.x + eye[0], row->light.toward.y + eye[1],
                           row->light.toward.z + eye[2]};
    lanes_float length = lanes_root(dot(half, half));
    lanes_float cosine = most(dot(n, half) / length, spread(0.0f));
    cosine = lanes_select(length > 0.0f, cosine, spread(0.0f));
    lanes_float d = cosine * cosine * (a2 - 1.0f) + 1.0f;
    lanes_float gloss = lambert * least(a2 / (d * d) * field[3], spread(2.0f));
    lanes_int unlit = field[7] > 0.0f;
    for (int k = 0; k < 3; ++k) {
        lanes_float mirror = 0.04f + (color[k] - 0.04f) * metallic;
        lanes_float lit =
            color[k] * kept * diffuse + mirror * (gloss + 0.5f * metallic * diffuse) + field[4 + k];
        out[k] = lanes_select(unlit, color[k] + field[4 + k], lit);
    }
}

static inline lanes_int encode_lanes(const cpu_shade_row* row, lanes_float linear)
{
    const float top = (float)(CPU_ENCODE_SIZE - 1);
    lanes_float scaled = linear * (float)CPU_ENCODE_SIZE;
    scaled = lanes_select(scaled > 0.0f, scaled, spread(0.0f)); // also what is not a number
    scaled = lanes_select(scaled >= top, spread(top), scaled);
    return lanes_gather_byte(row->encode, __builtin_convertvector(scaled, lanes_int));
}

static void light_chunk(const cpu_shade_row* row, cpu_shade_chunk* c, uint32_t x, uint32_t size)
{
    for (uint32_t at = 0; at < size; at += LANES) {
        lanes_float color[3], normal[3], eye[3], out[3];
        for (int k = 0; k < 3; ++k) {
            color[k] = load_float(c->linear[k] + at);
            normal[k] = load_float(c->normal[k] + at);
        }
        if (c->has_codes) {
            lanes_int coded = load_int(c->coded + at);
            decode_colors(row, c, at, coded, color);
            decode_normals(c, at, coded, normal);
        }
        turn_normals(row, load_int(c->item + at), normal);
        direct_to_eye(row, x + at, eye);
        light_lanes(row, load_int(c->material + at), eye, normal, color, out);
        lanes_int bytes = spread_int(INT32_MIN / 128); // alpha 255
        for (int k = 0; k < 3; ++k) {
            memcpy(c->out[k] + at, &out[k], sizeof(out[k]));
            bytes |= encode_lanes(row, out[k]) << (8 * k);
        }
        lanes_int there = load_int(c->there + at);
        bytes = (there & bytes) | (~there & spread_int((int32_t)row->empty));
        memcpy(c->bytes + at, &bytes, sizeof(bytes));
    }
}

/// All pixels of one buffer into the least of all, where any is there at all.
static inline void merge_one(uint64_t* restrict from, uint32_t size, uint64_t* restrict pixels)
{
    uint64_t all = STP_RASTER_EMPTY;
    for (uint32_t i = 0; i < size; ++i) {
        all &= from[i];
    }
    if (all == STP_RASTER_EMPTY) {
        return; // not written to: its memory stays clean
    }
    for (uint32_t i = 0; i < size; ++i) { // nearness is not negative, so all have the same sign
        int64_t a = (int64_t)from[i], b = (int64_t)pixels[i];
        pixels[i] = (uint64_t)(a < b ? a : b);
    }
    for (uint32_t i = 0; i < size; ++i) {
        from[i] = STP_RASTER_EMPTY;
    }
}

static bool merge_chunk(uint64_t* const* buffers, uint32_t count, size_t at, uint32_t size,
                        uint64_t* restrict pixels, float* restrict depth)
{
    uint64_t all = STP_RASTER_EMPTY;
    for (uint32_t i = 0; i < size; ++i) {
        pixels[i] = STP_RASTER_EMPTY;
    }
    for (uint32_t k = 0; k < count; ++k) {
        merge_one(buffers[k] + at, size, pixels);
    }
    for (uint32_t i = 0; i < size; ++i) {
        all &= pixels[i];
        uint32_t bits = ~(uint32_t)(pixels[i] >> 32); // 0 where it is empty
        memcpy(&depth[i], &bits, sizeof(bits));
    }
    return all != STP_RASTER_EMPTY;
}
