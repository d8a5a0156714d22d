// SPDX-License-Identifier: MIT
// Pixels lit in vectors against pixels lit one by one, and variants against each other.
#include "tests.h"

#include "base/color.h"
#include "base/octahedral.h"
#include "base/processor.h"
#include "base/rng.h"
#include "draw/cpu/shade.h"

#include <string.h>

enum { ITEMS = 5, MATERIALS = 9, BUFFERS = 3, ROW = 300 };

typedef struct tables {
    cpu_shade_item items[ITEMS];
    cpu_shade_material materials[MATERIALS];
    float roughness[MATERIALS];
    float decode[256];
    uint8_t encode[CPU_ENCODE_SIZE + 3];
    cpu_shade_row row;
} tables;

typedef struct dice {
    uint64_t seed, index;
} dice;

static uint64_t next(dice* d)
{
    return stp_rng_hash(d->seed, d->index++);
}

static float unit(dice* d)
{
    return (float)(next(d) >> 40) * (1.0f / 16777216.0f);
}

static void make_tables(tables* t, dice* rng)
{
    for (int i = 0; i < ITEMS; ++i) {
        for (int k = 0; k < 9; ++k) {
            t->items[i].normal_matrix[k] = i == 0 ? 0.0f : 2.0f * unit(rng) - 1.0f;
        }
    }
    for (int i = 0; i < MATERIALS; ++i) {
        float roughness = unit(rng), metallic = unit(rng), a = stp_max(roughness, 0.25f);
        float a2 = a * a * a * a;
        t->roughness[i] = roughness;
        t->materials[i] = (cpu_shade_material){.metallic = metallic,
                                               .kept = 1.0f - 0.5f * metallic,
                                               .a2 = a2,
                                               .gloss = 1.0f / (4.0f * a2 + 0.2f),
                                               .emissive = {unit(rng) * 0.2f, 0, 0.1f},
                                               .unlit = i % 4 == 0 ? 1.0f : 0.0f};
    }
    for (int i = 0; i < 256; ++i) {
        t->decode[i] = stp_srgb8_to_linear((uint8_t)i);
    }
    for (int i = 0; i < CPU_ENCODE_SIZE; ++i) {
        t->encode[i] = stp_linear_to_srgb8(((float)i + 0.5f) / (float)CPU_ENCODE_SIZE);
    }
    t->row = (cpu_shade_row){.items = t->items,
                             .materials = t->materials,
                             .decode = t->decode,
                             .encode = t->encode,
                             .light = {.toward = {-0.45f, 0.65f, 0.62f}, .up = {0, 1, 0}},
                             .start = {-0.3f, 0.2f, 0.9f},
                             .step = {0.001f, 0, 0.0001f},
                             .empty = 0x12345678};
}

static void make_chunk(cpu_shade_chunk* c, dice* rng, bool alike)
{
    *c = (cpu_shade_chunk){.has_codes = true, .has_low = true};
    for (int i = 0; i < SHADE_CHUNK; ++i) {
        c->there[i] = unit(rng) < 0.8f ? -1 : 0;
        c->coded[i] = unit(rng) < 0.5f ? -1 : 0;
        c->item[i] = alike ? 2 : (int32_t)(next(rng) % ITEMS);
        c->material[i] = alike ? 1 : (int32_t)(next(rng) % MATERIALS);
        c->color[i] = (int32_t)(next(rng) & 0xFFFFFF);
        c->low[i] = (int32_t)(next(rng) & 0xFFFFFF);
        int8_t code[2] = {(int8_t)(next(rng) % 255 - 127), (int8_t)(next(rng) % 255 - 127)};
        c->code[i] = (uint8_t)code[0] | (uint8_t)code[1] << 8;
        c->blend[i] = unit(rng);
        for (int k = 0; k < 3; ++k) {
            c->linear[k][i] = unit(rng);
            c->normal[k][i] = unit(rng) - 0.5f;
        }
    }
}

/// The same pixel in plain C.
static void light_one(const tables* t, const cpu_shade_chunk* c, int i, uint32_t x, float out[3])
{
    const cpu_shade_material* m = &t->materials[c->material[i]];
    cpu_surface s = {.metallic = m->metallic,
                     .roughness = t->roughness[c->material[i]],
                     .emissive = {m->emissive[0], m->emissive[1], m->emissive[2]},
                     .unlit = m->unlit > 0.0f};
    stp_vec3 n = {c->normal[0][i], c->normal[1][i], c->normal[2][i]};
    if (c->coded[i] != 0) {
        n = stp_octahedral_decode((int8_t)(c->code[i] & 255), (int8_t)(c->code[i] >> 8));
    }
    for (int k = 0; k < 3; ++k) {
        float before = t->decode[c->low[i] >> (8 * k) & 255];
        float now = t->decode[c->color[i] >> (8 * k) & 255];
        s.color[k] = c->coded[i] != 0 ? before + (now - before) * c->blend[i] : c->linear[k][i];
    }
    const float* a = t->items[c->item[i]].normal_matrix;
    stp_vec3 turned = {a[0] * n.x + a[1] * n.y + a[2] * n.z, a[3] * n.x + a[4] * n.y + a[5] * n.z,
                       a[6] * n.x + a[7] * n.y + a[8] * n.z};
    float square = stp_dot(turned, turned);
    s.normal = square > 0.0f ? stp_scale(turned, 1.0f / sqrtf(square)) : (stp_vec3){0};
    stp_vec3 eye = t->row.start;
    if (!t->row.parallel) {
        eye = stp_add(eye, stp_scale(t->row.step, (float)(x + (uint32_t)i) + 0.5f));
        eye = stp_scale(eye, 1.0f / sqrtf(stp_dot(eye, eye)));
    }
    cpu_light_surface(&t->row.light, eye, &s, out);
}

static bool agrees(const tables* t, const cpu_shade_chunk* c, uint32_t x, uint32_t size)
{
    for (uint32_t i = 0; i < size; ++i) {
        float wanted[3];
        light_one(t, c, (int)i, x, wanted);
        uint32_t bytes = 0xFF000000u;
        for (int k = 0; k < 3; ++k) {
            float scaled = wanted[k] * (float)CPU_ENCODE_SIZE;
            int code = scaled >= (float)(CPU_ENCODE_SIZE - 1) ? CPU_ENCODE_SIZE - 1
                       : scaled > 0.0f                        ? (int)scaled
                                                              : 0;
            bytes |= (uint32_t)t->encode[code] << (8 * k);
            if (memcmp(&wanted[k], &c->out[k][i], sizeof(float)) != 0) {
                return false;
            }
        }
        if (c->bytes[i] != (c->there[i] != 0 ? bytes : t->row.empty)) {
            return false;
        }
    }
    return true;
}

static int list_variants(const cpu_shade_kernels* variants[3])
{
    int count = 0;
    variants[count++] = &cpu_shade_kernels_portable;
#if defined(__x86_64__)
    if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
        variants[count++] = &cpu_shade_kernels_avx2;
    }
    if (stp_processor_detect() >= STP_PROCESSOR_AVX512) {
        variants[count++] = &cpu_shade_kernels_avx512;
    }
#endif
    return count;
}

void test_shade_lights_as_one_by_one(test_state* test)
{
    static tables t;
    static cpu_shade_chunk c;
    dice rng = {7, 0};
    make_tables(&t, &rng);
    const cpu_shade_kernels* variants[3];
    int count = list_variants(variants);
    for (int round = 0; round < 40; ++round) {
        make_chunk(&c, &rng, round % 3 == 0);
        t.row.parallel = round % 5 == 0;
        uint32_t size = round % 2 == 0 ? SHADE_CHUNK : 1 + (uint32_t)round;
        for (int v = 0; v < count; ++v) {
            memset(c.out, 0xFF, sizeof(c.out));
            variants[v]->light(&t.row, &c, 64u * (uint32_t)round, size);
            CHECK(agrees(&t, &c, 64u * (uint32_t)round, size));
        }
    }
}

void test_shade_merges_the_nearest_and_empties(test_state* test)
{
    static uint64_t made[BUFFERS][ROW], used[BUFFERS][ROW];
    dice rng = {8, 0};
    const cpu_shade_kernels* variants[3];
    int count = list_variants(variants);
    for (int round = 0; round < 20; ++round) {
        for (int k = 0; k < BUFFERS; ++k) {
            for (int i = 0; i < ROW; ++i) {
                bool there = unit(&rng) < 0.02f * (float)(round * k);
                made[k][i] =
                    there ? stp_raster_pixel(unit(&rng), (uint32_t)next(&rng)) : STP_RASTER_EMPTY;
            }
        }
        for (int v = 0; v < count; ++v) {
            uint64_t* buffers[BUFFERS] = {used[0], used[1], used[2]};
            uint64_t pixels[SHADE_CHUNK];
            float depth[SHADE_CHUNK];
            memcpy(used, made, sizeof(used));
            const uint32_t at = 101, size = round % 2 == 0 ? SHADE_CHUNK : 37;
            bool any = false;
            bool said = variants[v]->merge(buffers, BUFFERS, at, size, pixels, depth);
            for (uint32_t i = 0; i < size; ++i) {
                uint64_t least = STP_RASTER_EMPTY;
                for (int k = 0; k < BUFFERS; ++k) {
                    least = made[k][at + i] < least ? made[k][at + i] : least;
                    CHECK(used[k][at + i] == STP_RASTER_EMPTY);
                }
                float nearness = least == STP_RASTER_EMPTY ? 0.0f : stp_raster_nearness(least);
                CHECK(pixels[i] == least);
                CHECK_EQUAL(0, memcmp(&depth[i], &nearness, sizeof(nearness)));
                any = any || least != STP_RASTER_EMPTY;
            }
            CHECK_EQUAL(any, said);
            CHECK(used[2][at - 1] == made[2][at - 1] && used[2][at + size] == made[2][at + size]);
        }
    }
}
