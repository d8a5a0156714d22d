// SPDX-License-Identifier: MIT
// The range test with split errors: against double precision, in every variant.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "raster/splats_levels_kernel.h"

#include <string.h>

enum { SPLATS = 1000, WORDS = (SPLATS + 15) / 16 };

typedef struct scene {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint32_t ranges[SPLATS], errors[SPLATS];
    stp_raster_splats splats;
    stp_raster_camera camera;
    stp_vec3d eye; ///< in grid coordinates; in parallel the view direction
} scene;

static double uniform(uint64_t seed, uint64_t at, double low, double high)
{
    return low + (high - low) * (double)stp_rng_below(seed, at, 1 << 20) / (1 << 20);
}

static void fill(scene* s, uint64_t seed)
{
    for (uint64_t i = 0; i < SPLATS; ++i) {
        for (uint64_t k = 0; k < 3; ++k) {
            s->positions[3 * i + k] = (uint16_t)stp_rng_below(seed, 3 * i + k, 65536);
        }
        uint32_t codes = (uint32_t)stp_rng_hash(seed + 1, i);
        s->normals[2 * i] = (int8_t)codes;
        s->normals[2 * i + 1] = (int8_t)(codes >> 8);
        double lowest = i % 7 == 0 ? 0.0 : uniform(seed + 2, i, 0.0, 4.0);
        double highest = i % 11 == 0 ? HUGE_VAL : lowest + uniform(seed + 3, i, 0.0, 2.0);
        s->ranges[i] = stp_range_code((float)lowest, (float)highest);
        s->errors[i] = (uint32_t)stp_rng_hash(seed + 4, i);
    }
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .end = SPLATS,
                                    .origin = {-1.0f, -1.0f, -1.0f},
                                    .step = 1.0f / 32768.0f,
                                    .radius = 0.01f};
}

/// A camera outside the box that looks along z, turned around y and doubled in size.
static void place(scene* s, double angle, bool parallel)
{
    double c = cos(angle), w = sin(angle), away = 3.0;
    const double rows[3][3] = {{c, 0, w}, {0, 1, 0}, {-w, 0, c}};
    const double eye[3] = {away * w, 0.25, -away * c};
    s->camera = (stp_raster_camera){.pixel_scale = 100.0f, .parallel = parallel};
    for (int r = 0; r < 3; ++r) {
        double shift = 0.0;
        for (int k = 0; k < 3; ++k) {
            s->camera.view[r][k] = (float)(2.0 * rows[r][k]);
            shift -= 2.0 * rows[r][k] * eye[k];
        }
        s->camera.view[r][3] = (float)shift;
    }
    const float flat[4] = {0.0f, 0.0f, 0.0f, 3.0f};
    memcpy(s->camera.matrix.m[3], parallel ? flat : s->camera.view[2], sizeof(flat));
    s->eye = parallel ? (stp_vec3d){rows[2][0], rows[2][1], rows[2][2]}
                      : (stp_vec3d){(eye[0] + 1.0) * 32768.0, (eye[1] + 1.0) * 32768.0,
                                    (eye[2] + 1.0) * 32768.0};
}

static double find_share(uint32_t code, int8_t u, int8_t v, stp_vec3d sight)
{
    stp_vec3d n = stp_to_double(stp_octahedral_decode(u, v));
    double size = sqrt(sight.x * sight.x + sight.y * sight.y + sight.z * sight.z);
    double cosine = fmin(fabs(n.x * sight.x + n.y * sight.y + n.z * sight.z) / size, 1.0);
    double share = ((code & 15u) + 5) / 20.0 * sqrt(1.0 - cosine * cosine) +
                   ((code >> 4 & 15u) + 5) / 20.0 * cosine;
    return fmin(share, 1.0);
}

/// Whether a view selects a splat: 0 or 1; -1: its level is at an end of the range.
static int expect(const scene* s, uint32_t i, double per_depth)
{
    stp_vec3d p = {s->positions[3 * i], s->positions[3 * i + 1], s->positions[3 * i + 2]};
    double depth = (double)s->camera.matrix.m[3][3];
    const double place_of[3] = {p.x / 32768.0 - 1.0, p.y / 32768.0 - 1.0, p.z / 32768.0 - 1.0};
    for (int k = 0; k < 3; ++k) {
        depth += (double)s->camera.matrix.m[3][k] * place_of[k];
    }
    stp_vec3d sight = s->camera.parallel ? s->eye : stp_subd(s->eye, p);
    uint32_t code = s->errors[i];
    double lowest = find_share(code, s->normals[2 * i], s->normals[2 * i + 1], sight) *
                    (double)stp_range_level(s->ranges[i] & 0xFFFFu);
    double highest = find_share(code >> 8, (int8_t)(code >> 16), (int8_t)(code >> 24), sight) *
                     (double)stp_range_level(s->ranges[i] >> 16);
    double level = per_depth * depth;
    if (fabs(level - lowest) < 1e-4 * level || fabs(level - highest) < 1e-4 * level) {
        return -1;
    }
    return level >= lowest && level <= highest;
}

void test_splats_within_levels_of_their_direction(test_state* test)
{
    static scene s;
    int whole = 0, directed = 0;
    for (int round = 0; round < 12; ++round) {
        fill(&s, 50 + (uint64_t)round);
        place(&s, 0.5 * round, round % 4 == 3);
        s.splats.begin = 16 * ((uint32_t)round % 3);
        s.splats.end = SPLATS - (uint32_t)round;
        const stp_raster_levels levels = {.per_depth = 0.3f, .errors = s.errors};
        uint16_t bits[WORDS] = {0}, of_ranges[WORDS] = {0};
        CHECK(stp_raster_pick_levels(&s.camera, &s.splats, s.ranges, &levels, bits));
        CHECK(stp_raster_pick_levels(&s.camera, &s.splats, s.ranges,
                                     &(stp_raster_levels){.per_depth = 0.3f}, of_ranges));
        int wrong = 0;
        for (uint32_t i = s.splats.begin; i < s.splats.end; ++i) {
            int expected = expect(&s, i, (double)levels.per_depth);
            int got = bits[i / 16] >> i % 16 & 1;
            wrong += expected >= 0 && got != expected;
            directed += got;
            whole += of_ranges[i / 16] >> i % 16 & 1;
        }
        CHECK_EQUAL(0, wrong);
        // a cut of the whole set is one of the whole ranges
        const stp_raster_levels cut = {.minimum = 1.5f, .errors = s.errors};
        CHECK(stp_raster_pick_levels(&s.camera, &s.splats, s.ranges, &cut, bits));
        CHECK(stp_raster_pick_levels(&s.camera, &s.splats, s.ranges,
                                     &(stp_raster_levels){.minimum = 1.5f}, of_ranges));
        CHECK(memcmp(bits, of_ranges, sizeof(bits)) == 0);
    }
    CHECK(whole > 1000 && directed > 1000 && whole != directed);
}

void test_splats_within_levels_of_their_direction_by_all_variants(test_state* test)
{
    static scene s;
    for (int round = 0; round < 12; ++round) {
        fill(&s, 80 + (uint64_t)round);
        place(&s, 0.7 * round, round % 4 == 3);
        s.splats.end = SPLATS - (uint32_t)round;
        levels_frame frame = {.splats = &s.splats,
                              .ranges = s.ranges,
                              .levels = {.per_depth = 0.3f, .errors = s.errors},
                              .away = s.camera.parallel ? 0.0f : 1.0f};
        stp_splats_fold_row(s.camera.matrix.m[3], &s.splats, frame.w);
        stp_raster_find_eye(&s.camera, &s.splats, frame.eye);
        for (uint32_t i = 0; i < SPLATS; i += 97) { // the eye in the middle of a splat
            for (int k = 0; round == 5 && k < 3; ++k) {
                s.positions[3 * i + (uint32_t)k] = 77;
                frame.eye[k] = 77.0f;
            }
        }
        uint16_t expected[WORDS] = {0}, bits[WORDS] = {0};
        bool any = stp_splats_pick_portable(&frame, expected);
        CHECK(any);
        stp_processor processor = stp_processor_detect();
        if (processor >= STP_PROCESSOR_VECTOR) {
            CHECK_EQUAL(any, STP_VECTOR(stp_splats_pick)(&frame, bits));
            CHECK(memcmp(expected, bits, sizeof(bits)) == 0);
        }
        if (processor >= STP_PROCESSOR_WIDE) {
            CHECK_EQUAL(any, STP_WIDE(stp_splats_pick)(&frame, bits));
            CHECK(memcmp(expected, bits, sizeof(bits)) == 0);
        }
    }
}
