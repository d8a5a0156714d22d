// SPDX-License-Identifier: MIT
// Vectorised lighting, merging and depths against single pixels, and cached surfaces.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/color.h"
#include "base/math/rng.h"
#include "draw/cpu/shade.h"
#include "draw/shaders/light_constants.h"

#include <string.h>

enum { SURFACES = 40, LIT = 100, BUFFERS = 3, ROW = 300 };

typedef struct tables {
    stp_cpu_shade_surface surfaces[SURFACES];
    uint8_t encode[CPU_ENCODE_SIZE + 3];
    stp_cpu_shade_scene scene;
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

static void make_surface(stp_cpu_shade_surface* s, int number, dice* rng)
{
    const float emissive[3] = {unit(rng) * 0.2f, 0, 0.1f};
    for (int k = 0; k < 3; ++k) {
        s->color[k] = unit(rng);
        s->normal[k] = number == 0 ? 0.0f : 2.0f * unit(rng) - 1.0f;
    }
    s->normal[3] = number % 3 == 0 ? 0.0f : number % 3 == 1 ? unit(rng) : 1.0f - unit(rng) * 0.1f;
    s->material = stp_cpu_make_shade_material(unit(rng), unit(rng), emissive, number % 4 == 1);
}

static void make_tables(tables* t, dice* rng)
{
    for (int i = 0; i < SURFACES; ++i) {
        make_surface(&t->surfaces[i], i, rng);
    }
    for (int i = 0; i < CPU_ENCODE_SIZE; ++i) {
        t->encode[i] = stp_linear_to_srgb8(((float)i + 0.5f) / (float)CPU_ENCODE_SIZE);
    }
    t->scene = (stp_cpu_shade_scene){.encode = t->encode,
                                     .light = {.key = {-0.45f, 0.65f, 0.62f},
                                               .up = {0, 1, 0},
                                               .left_box = {-0.6f, 0.64f, 0.48f},
                                               .right_box = {0.8f, 0.0f, 0.6f}},
                                     .start = {-0.3f, 0.2f, 0.9f},
                                     .across = {0.001f, 0, 0.0001f},
                                     .down = {0, -0.002f, 0.0001f}};
}

static void make_lanes(stp_cpu_shade_lanes* lanes, dice* rng, uint32_t count)
{
    *lanes = (stp_cpu_shade_lanes){.count = count, .wants_linear = true};
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

static float smooth(float x)
{
    x = stp_min(stp_max(x, 0.0f), 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

static void mirror_one(const stp_lighting* light, stp_vec3 r, float rough, float out[3])
{
    static const float horizon[3] = {MIRROR_HORIZON_R, MIRROR_HORIZON_G, MIRROR_HORIZON_B};
    static const float ground[3] = {MIRROR_GROUND_R, MIRROR_GROUND_G, MIRROR_GROUND_B};
    float sharp = 1.0f / (MIRROR_BLUR + MIRROR_BLUR_ROUGH * rough), height = stp_dot(r, light->up);
    float above = smooth(height * sharp + 0.5f);
    float fade = 1.0f - (1.0f - MIRROR_ZENITH) * stp_max(height, 0.0f);
    float left = smooth((stp_dot(r, light->left_box) - MIRROR_LEFT_EDGE) * sharp + 0.5f);
    float right = smooth((stp_dot(r, light->right_box) - MIRROR_RIGHT_EDGE) * sharp + 0.5f);
    float boxes =
        (MIRROR_BOX_LEFT * left + MIRROR_BOX_RIGHT * right) * (1.0f - MIRROR_ROUGH_BOX * rough);
    for (int k = 0; k < 3; ++k) {
        out[k] = ground[k] + (horizon[k] * fade - ground[k]) * above + boxes;
    }
}

/// The key light's highlight.
static float gloss_one(const stp_lighting* light, stp_vec3 eye, float toward, float facing,
                       float variance, const stp_cpu_shade_material* m)
{
    float a2 = stp_min(m->a2 + SPREAD_GLOSS * variance, 1.0f);
    float size = variance > 0.0f ? 1.0f / (4.0f * a2 + 0.2f) : m->gloss;
    float square = 2.0f + 2.0f * stp_dot(eye, light->key);
    float along = stp_max(toward + facing, 0.0f);
    float squared = square > 0.0f ? along * along / square : 0.0f;
    float d = squared * (a2 - 1.0f) + 1.0f;
    return stp_max(toward, 0.0f) * stp_min(a2 / (d * d) * size, LIGHT_GLOSS_MAX) *
           (1.0f - m->rough);
}

/// Diffuse light of normals about n, whose mean has this length.
static void diffuse_one(const stp_lighting* light, stp_vec3 n, stp_vec3 eye, float facing,
                        float length, float out[3])
{
    static const float sky[3] = {LIGHT_SKY_R, LIGHT_SKY_G, LIGHT_SKY_B};
    static const float ground[3] = {LIGHT_GROUND_R, LIGHT_GROUND_G, LIGHT_GROUND_B};
    static const float key[3] = {LIGHT_KEY_R, LIGHT_KEY_G, LIGHT_KEY_B};
    float variance = 1.0f - length * length, to_eye = (1.0f - length) * SPREAD_TO_EYE;
    float toward = length * stp_dot(n, light->key) + to_eye * stp_dot(eye, light->key);
    float lambert = 0.5f * (toward + sqrtf(toward * toward + SPREAD_LAMBERT * variance));
    float height =
        0.5f + 0.5f * (length * stp_dot(n, light->up) + to_eye * stp_dot(eye, light->up));
    float fill =
        LIGHT_FILL * facing * facing * (length * length) + LIGHT_FILL * SPREAD_FILL * variance;
    for (int k = 0; k < 3; ++k) {
        out[k] = ground[k] + (sky[k] - ground[k]) * height + key[k] * lambert + fill;
        if (!(variance > 0.0f)) { // the light of n itself
            float own = ground[k] + (sky[k] - ground[k]) * (0.5f + 0.5f * stp_dot(n, light->up));
            own += key[k] * stp_max(stp_dot(n, light->key), 0.0f);
            out[k] = own + LIGHT_FILL * facing * facing;
        }
    }
}

static stp_vec3 find_eye(const stp_cpu_shade_scene* scene, float x, float y)
{
    stp_vec3 eye = scene->start;
    if (!scene->parallel) {
        eye = stp_add(eye, stp_scale(scene->across, x));
        eye = unit_or_zero(stp_add(eye, stp_scale(scene->down, y)));
    }
    return eye;
}

/// The same lane in plain C.
static void light_one(const stp_cpu_shade_scene* scene, const stp_cpu_shade_surface* s, float x,
                      float y, float out[3])
{
    const stp_cpu_shade_material* m = &s->material;
    float length = 1.0f - s->normal[3], variance = 1.0f - length * length, diffuse[3];
    stp_vec3 n = unit_or_zero((stp_vec3){s->normal[0], s->normal[1], s->normal[2]});
    stp_vec3 eye = find_eye(scene, x, y);
    float facing = stp_dot(n, eye), mirrored[3];
    if (facing < 0.0f) {
        n = stp_scale(n, -1.0f);
        facing = -facing;
    }
    mirror_one(&scene->light, stp_sub(stp_scale(n, 2.0f * facing), eye),
               stp_min(m->rough + variance, 1.0f), mirrored);
    float toward = stp_dot(n, scene->light.key);
    float gloss = gloss_one(&scene->light, eye, toward, facing, variance, m);
    diffuse_one(&scene->light, n, eye, facing, length, diffuse);
    float aside = 1.0f - facing, polish = 1.0f - m->rough, square = aside * aside;
    float edge = square * square * aside * polish * polish * LIGHT_GRAZING;
    for (int k = 0; k < 3; ++k) {
        float front = LIGHT_DIELECTRIC + (s->color[k] - LIGHT_DIELECTRIC) * m->metallic;
        float mirror = front + (1.0f - front) * edge;
        float seen = mirrored[k] + (diffuse[k] - mirrored[k]) * m->rough;
        out[k] = s->color[k] * (1.0f - m->metallic) * diffuse[k] + mirror * seen + front * gloss +
                 m->emissive[k];
        out[k] = m->unlit > 0.0f ? s->color[k] + m->emissive[k] : out[k];
    }
}

static bool agrees(const tables* t, const stp_cpu_shade_lanes* lanes)
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

static int list_variants(const stp_cpu_shade_kernels* variants[3])
{
    int count = 0;
    variants[count++] = &stp_cpu_shade_kernels_portable;
    if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
        variants[count++] = &STP_VECTOR(stp_cpu_shade_kernels);
    }
    if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
        variants[count++] = &STP_WIDE(stp_cpu_shade_kernels);
    }
    return count;
}

void test_shade_lights_as_one_by_one(test_state* test)
{
    static tables t;
    static stp_cpu_shade_lanes lanes;
    dice rng = {7, 0};
    make_tables(&t, &rng);
    const stp_cpu_shade_kernels* variants[3];
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
                      const stp_cpu_shade_merged* row)
{
    bool good = true;
    uint32_t before = 0;
    for (uint32_t i = 0; i < SHADE_WIDTH; ++i) {
        uint64_t minimum = STP_RASTER_EMPTY;
        for (int k = 0; k < BUFFERS && i < size; ++k) {
            minimum = made[k][at + i] < minimum ? made[k][at + i] : minimum;
        }
        float nearness = minimum == STP_RASTER_EMPTY ? 0.0f : stp_raster_nearness(minimum);
        uint32_t id = stp_raster_id(minimum);
        good = good && row->ids[i + 1] == id && memcmp(&row->nearness[i], &nearness, 4) == 0;
        good = good && (row->there >> i & 1) == (minimum != STP_RASTER_EMPTY);
        good = good && (row->starts >> i & 1) == (i == 0 || id != before);
        before = id;
    }
    return good;
}

void test_shade_merges_the_nearest_and_empties(test_state* test)
{
    static uint64_t made[BUFFERS][ROW], used[BUFFERS][ROW];
    dice rng = {8, 0};
    const stp_cpu_shade_kernels* variants[3];
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
            stp_cpu_shade_merged row;
            memcpy(used, made, sizeof(used));
            memset(&row, 0xFF, sizeof(row));
            const uint32_t at = 101, size = round % 2 == 0 ? SHADE_WIDTH : 37;
            uint64_t copy[SHADE_WIDTH + 1] = {[0] = 7};
            copy[size] = 7;
            variants[v]->merge(buffers, BUFFERS, at, size, round % 3 == 0 ? NULL : copy, &row);
            CHECK(is_merged(made, at, size, &row));
            CHECK(copy[size] == 7); // no more than asked for
            for (uint32_t i = 0; i < size && round % 3 != 0; ++i) {
                CHECK_EQUAL(stp_raster_id(copy[i]), row.ids[i + 1]);
                CHECK(stp_raster_nearness(copy[i]) == row.nearness[i] ||
                      copy[i] == STP_RASTER_EMPTY);
            }
            for (int k = 0; k < BUFFERS; ++k) {
                for (uint32_t i = 0; i < ROW; ++i) {
                    bool within = i >= at && i < at + size;
                    CHECK(used[k][i] == (within ? STP_RASTER_EMPTY : made[k][i]));
                }
            }
        }
    }
}

void test_shade_finds_the_depths_of_the_nearest(test_state* test)
{
    static uint64_t made[BUFFERS][ROW];
    dice rng = {11, 0};
    const stp_cpu_shade_kernels* variants[3];
    int count = list_variants(variants);
    for (uint32_t round = 0; round < 60; ++round) {
        for (uint32_t k = 0; k < BUFFERS; ++k) {
            for (int i = 0; i < ROW; ++i) {
                bool there = unit(&rng) < 0.01f * (float)(round * k);
                uint32_t id = (uint32_t)next(&rng) >> 1;
                made[k][i] = there ? stp_raster_pixel(unit(&rng), id) : STP_RASTER_EMPTY;
            }
        }
        const uint32_t buffer_count = round % (BUFFERS + 1), at = round, size = round * 4 % 201;
        uint64_t* const buffers[BUFFERS] = {made[0], made[1], made[2]};
        float wanted[ROW], depth[ROW];
        memset(wanted, 0xFF, sizeof(wanted));
        for (uint32_t i = 0; i < size; ++i) {
            uint64_t minimum = STP_RASTER_EMPTY;
            for (uint32_t k = 0; k < buffer_count; ++k) {
                minimum = made[k][at + i] < minimum ? made[k][at + i] : minimum;
            }
            wanted[i] = minimum == STP_RASTER_EMPTY ? 0.0f : stp_raster_nearness(minimum);
        }
        for (int v = 0; v < count; ++v) {
            memset(depth, 0xFF, sizeof(depth));
            variants[v]->find_depths(buffers, buffer_count, at, size, depth);
            CHECK_EQUAL(0, memcmp(depth, wanted, sizeof(wanted))); // and no more than asked for
        }
    }
}

/// Spreading against single pixels.
void test_shade_spreads_runs(test_state* test)
{
    enum { SPACE = SHADE_WIDTH + SHADE_LANES_MAX, LANES = 2 * SHADE_WIDTH + SHADE_LANES_MAX };
    dice rng = {10, 0};
    const stp_cpu_shade_kernels* variants[3];
    int count = list_variants(variants);
    for (int round = 0; round < 40; ++round) {
        stp_cpu_shade_run runs[SHADE_WIDTH];
        stp_cpu_shade_nearness near[SHADE_WIDTH];
        uint32_t lanes[LANES], wanted[SHADE_WIDTH];
        float nearness[SPACE], wanted_depth[SHADE_WIDTH];
        uint32_t run_count = 0, lane = 0;
        for (uint32_t i = 0; i < LANES; ++i) {
            lanes[i] = (uint32_t)next(&rng);
        }
        for (uint32_t i = 0; i < SPACE; ++i) {
            nearness[i] = unit(&rng);
        }
        for (uint32_t x = 0; x < SHADE_WIDTH; ++run_count) {
            uint32_t length = 1 + (uint32_t)next(&rng) % (round % 2 == 0 ? 50 : 5);
            length = length < SHADE_WIDTH - x ? length : SHADE_WIDTH - x;
            stp_cpu_shade_run* run = &runs[run_count];
            *run = (stp_cpu_shade_run){(uint8_t)x, (uint8_t)length, (uint16_t)run_count,
                                       (uint16_t)lane, next(&rng) % 2 == 0};
            near[run_count] = (stp_cpu_shade_nearness){0.9f + unit(&rng), unit(&rng)};
            for (uint32_t k = 0; k < length; ++k, ++x) {
                wanted[x] = lanes[lane + (run->flat ? k / SHADE_REACH : k)];
                wanted_depth[x] = near[run_count].factor * nearness[x] + near[run_count].shift;
            }
            lane += length;
        }
        for (int v = 0; v < count; ++v) {
            uint8_t colors[4 * SPACE];
            float depth[SPACE];
            variants[v]->spread(runs, runs + run_count, near, lanes, nearness, colors, depth);
            CHECK_EQUAL(0, memcmp(colors, wanted, sizeof(wanted)));
            CHECK_EQUAL(0, memcmp(depth, wanted_depth, sizeof(wanted_depth)));
        }
    }
}

/// Nor does a tile overwrite a surface of the previous tile, which is not lit yet.
void test_shade_keeps_all_surfaces_of_two_tiles(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_cpu_shade_memory* memory = stp_cpu_make_shade_memory(context);
    CHECK(memory != NULL);
    if (memory == NULL) {
        stp_context_destroy(context);
        return;
    }
    stp_cpu_reset_surfaces(memory);
    CHECK((uintptr_t)memory->surfaces % sizeof(stp_cpu_shade_surface) == 0);
    dice rng = {9, 0};
    static uint32_t ids[2][SHADE_PIXELS], places[2][SHADE_PIXELS];
    for (int number = 0; number < 50; ++number) {
        stp_cpu_shade_tile* tile = stp_cpu_begin_tile(memory);
        int now = number % 2;
        for (int i = 0; i < SHADE_PIXELS; ++i) {
            ids[now][i] = (uint32_t)(next(&rng) % (number % 4 < 2 ? 300 : 1 << 20));
            places[now][i] = stp_cpu_find_surface(memory, tile, ids[now][i]);
        }
        for (int i = 0; i < SHADE_PIXELS; ++i) {
            CHECK(places[now][i] < SHADE_KEPT && memory->slots[places[now][i]].id == ids[now][i]);
            CHECK(number == 0 || memory->slots[places[!now][i]].id == ids[!now][i]);
        }
        bool made[SHADE_KEPT] = {false};
        CHECK(tile->miss_count <= SHADE_PIXELS);
        for (uint32_t i = 0; i < tile->miss_count; ++i) { // each surface is made once
            CHECK(!made[tile->misses[i]]);
            made[tile->misses[i]] = true;
        }
        tile->miss_count = 0;
        for (int i = 0; i < SHADE_PIXELS; ++i) {
            bool remembered = places[now][i] < SHADE_CACHE;
            CHECK(!remembered || stp_cpu_find_surface(memory, tile, ids[now][i]) == places[now][i]);
        }
        CHECK(tile->miss_count == 0);
    }
    stp_cpu_destroy_shade_memory(context, memory);
    stp_context_destroy(context);
}
