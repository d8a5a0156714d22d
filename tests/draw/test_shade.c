// SPDX-License-Identifier: MIT
// Lighting and merging in vectors against pixels one by one, and what is remembered of surfaces.
#include "tests.h"

#include "base/color.h"
#include "base/processor.h"
#include "base/rng.h"
#include "draw/cpu/shade.h"

#include <string.h>

enum { SURFACES = 40, LIT = 100, BUFFERS = 3, ROW = 300 };

typedef struct tables {
    cpu_shade_surface surfaces[SURFACES];
    uint8_t encode[CPU_ENCODE_SIZE + 3];
    cpu_shade_scene scene;
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

static void make_surface(cpu_shade_surface* s, int number, dice* rng)
{
    const float emissive[3] = {unit(rng) * 0.2f, 0, 0.1f};
    for (int k = 0; k < 3; ++k) {
        s->color[k] = unit(rng);
        s->normal[k] = number == 0 ? 0.0f : 2.0f * unit(rng) - 1.0f;
    }
    s->material = cpu_make_shade_material(unit(rng), unit(rng), emissive, number % 4 == 1);
}

static void make_tables(tables* t, dice* rng)
{
    for (int i = 0; i < SURFACES; ++i) {
        make_surface(&t->surfaces[i], i, rng);
    }
    for (int i = 0; i < CPU_ENCODE_SIZE; ++i) {
        t->encode[i] = stp_linear_to_srgb8(((float)i + 0.5f) / (float)CPU_ENCODE_SIZE);
    }
    t->scene = (cpu_shade_scene){.encode = t->encode,
                                 .light = {.toward = {-0.45f, 0.65f, 0.62f}, .up = {0, 1, 0}},
                                 .start = {-0.3f, 0.2f, 0.9f},
                                 .across = {0.001f, 0, 0.0001f},
                                 .down = {0, -0.002f, 0.0001f}};
}

static void make_lanes(cpu_shade_lanes* lanes, dice* rng, uint32_t count)
{
    *lanes = (cpu_shade_lanes){.count = count, .wants_linear = true};
    for (uint32_t i = 0; i < count; ++i) {
        lanes->surface[i] = (uint32_t)(next(rng) % SURFACES);
        lanes->x[i] = 64.0f * unit(rng);
        lanes->y[i] = 8.0f * unit(rng);
    }
}

static stp_vec3 unit_or_zero(stp_vec3 v)
{
    float square = stp_dot(v, v);
    return square > 0.0f ? stp_scale(v, 1.0f / sqrtf(square)) : (stp_vec3){0};
}

/// The same lane in plain C.
static void light_one(const cpu_shade_scene* scene, const cpu_shade_surface* s, float x, float y,
                      float out[3])
{
    const cpu_shade_material* m = &s->material;
    stp_vec3 n = unit_or_zero((stp_vec3){s->normal[0], s->normal[1], s->normal[2]});
    stp_vec3 eye = scene->start;
    if (!scene->parallel) {
        eye = stp_add(eye, stp_scale(scene->across, x));
        eye = unit_or_zero(stp_add(eye, stp_scale(scene->down, y)));
    }
    float facing = stp_dot(n, eye);
    if (facing < 0.0f) {
        n = stp_scale(n, -1.0f);
        facing = -facing;
    }
    float lambert = stp_max(stp_dot(n, scene->light.toward), 0.0f);
    float height = 0.5f + 0.5f * stp_dot(n, scene->light.up);
    float diffuse = CPU_LIGHT_GROUND + (CPU_LIGHT_SKY - CPU_LIGHT_GROUND) * height +
                    CPU_LIGHT_KEY * lambert + CPU_LIGHT_FILL * facing;
    stp_vec3 half = stp_add(scene->light.toward, eye);
    float length = stp_length(half);
    float cosine = length > 0.0f ? stp_max(stp_dot(n, half) / length, 0.0f) : 0.0f;
    float d = cosine * cosine * (m->a2 - 1.0f) + 1.0f;
    float gloss = lambert * stp_min(m->a2 / (d * d) * m->gloss, 2.0f);
    for (int k = 0; k < 3; ++k) {
        float mirror = 0.04f + (s->color[k] - 0.04f) * m->metallic;
        out[k] = s->color[k] * m->kept * diffuse + mirror * (gloss + 0.5f * m->metallic * diffuse) +
                 m->emissive[k];
        out[k] = m->unlit > 0.0f ? s->color[k] + m->emissive[k] : out[k];
    }
}

static bool agrees(const tables* t, const cpu_shade_lanes* lanes)
{
    for (uint32_t i = 0; i < lanes->count; ++i) {
        float wanted[3];
        uint32_t bytes = 0xFF000000u;
        light_one(&t->scene, &t->surfaces[lanes->surface[i]], lanes->x[i], lanes->y[i], wanted);
        for (int k = 0; k < 3; ++k) {
            float scaled = wanted[k] * (float)CPU_ENCODE_SIZE;
            int code = scaled >= (float)(CPU_ENCODE_SIZE - 1) ? CPU_ENCODE_SIZE - 1
                       : scaled > 0.0f                        ? (int)scaled
                                                              : 0;
            bytes |= (uint32_t)t->encode[code] << (8 * k);
            if (memcmp(&wanted[k], &lanes->linear[k][i], sizeof(float)) != 0) {
                return false;
            }
        }
        if (lanes->bytes[i] != bytes) {
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
    static cpu_shade_lanes lanes;
    dice rng = {7, 0};
    make_tables(&t, &rng);
    const cpu_shade_kernels* variants[3];
    int count = list_variants(variants);
    for (int round = 0; round < 40; ++round) {
        make_lanes(&lanes, &rng, round % 2 == 0 ? LIT : 1 + (uint32_t)round);
        t.scene.parallel = round % 5 == 0;
        for (int v = 0; v < count; ++v) {
            memset(lanes.linear, 0xFF, sizeof(lanes.linear));
            memset(lanes.bytes, 0xFF, sizeof(lanes.bytes));
            variants[v]->light(&t.scene, t.surfaces, &lanes);
            CHECK(agrees(&t, &lanes));
        }
    }
}

static bool is_merged(uint64_t made[BUFFERS][ROW], uint32_t at, uint32_t size,
                      const cpu_shade_merged* row)
{
    bool good = true;
    uint32_t before = 0;
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        uint64_t least = STP_RASTER_EMPTY;
        for (int k = 0; k < BUFFERS && i < size; ++k) {
            least = made[k][at + i] < least ? made[k][at + i] : least;
        }
        float nearness = least == STP_RASTER_EMPTY ? 0.0f : stp_raster_nearness(least);
        uint32_t id = stp_raster_id(least);
        good = good && row->ids[i + 1] == id && memcmp(&row->nearness[i], &nearness, 4) == 0;
        good = good && (row->there >> i & 1) == (least != STP_RASTER_EMPTY);
        good = good && (row->starts >> i & 1) == (i == 0 || id != before);
        before = id;
    }
    return good;
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
                uint32_t id = round % 4 == 0 ? (uint32_t)next(&rng) >> 1 : (uint32_t)i / 5;
                made[k][i] = there ? stp_raster_pixel(unit(&rng), id) : STP_RASTER_EMPTY;
            }
        }
        for (int v = 0; v < count; ++v) {
            uint64_t* buffers[BUFFERS] = {used[0], used[1], used[2]};
            cpu_shade_merged row;
            memcpy(used, made, sizeof(used));
            memset(&row, 0xFF, sizeof(row));
            const uint32_t at = 101, size = round % 2 == 0 ? SHADE_WIDTH : 37;
            variants[v]->merge(buffers, BUFFERS, at, size, &row);
            CHECK(is_merged(made, at, size, &row));
            for (int k = 0; k < BUFFERS; ++k) {
                for (uint32_t i = 0; i < ROW; ++i) {
                    bool within = i >= at && i < at + size;
                    CHECK(used[k][i] == (within ? STP_RASTER_EMPTY : made[k][i]));
                }
            }
        }
    }
}

void test_shade_keeps_all_surfaces_of_a_tile(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    cpu_shade_memory* memory = cpu_make_shade_memory(context);
    CHECK(memory != NULL);
    if (memory == NULL) {
        stp_context_destroy(context);
        return;
    }
    cpu_forget_surfaces(memory);
    CHECK((uintptr_t)memory->surfaces % sizeof(cpu_shade_surface) == 0);
    dice rng = {9, 0};
    for (int tile = 0; tile < 50; ++tile) {
        uint32_t ids[SHADE_PIXELS], places[SHADE_PIXELS], before = memory->miss_count;
        cpu_begin_tile(memory);
        for (int i = 0; i < SHADE_PIXELS; ++i) {
            ids[i] = (uint32_t)(next(&rng) % (tile % 2 == 0 ? 300 : 1 << 20));
            places[i] = cpu_find_surface(memory, ids[i]);
        }
        for (int i = 0; i < SHADE_PIXELS; ++i) { // whatever came after took no other's place
            CHECK(places[i] < SHADE_KEPT && memory->slots[places[i]].id == ids[i]);
        }
        CHECK(before == 0 && memory->miss_count <= SHADE_PIXELS);
        bool made[SHADE_KEPT] = {false};
        for (uint32_t i = 0; i < memory->miss_count; ++i) { // each is made once
            CHECK(!made[memory->misses[i]]);
            made[memory->misses[i]] = true;
        }
        memory->miss_count = 0;
        for (int i = 0; i < SHADE_PIXELS; ++i) {
            bool seen = places[i] < SHADE_CACHE;
            CHECK(!seen || cpu_find_surface(memory, ids[i]) == places[i]);
        }
        CHECK(memory->miss_count == 0);
    }
    cpu_destroy_shade_memory(context, memory);
    stp_context_destroy(context);
}
