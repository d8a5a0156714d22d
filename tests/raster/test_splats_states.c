// SPDX-License-Identifier: MIT
// The range test selects the splats of a state of a progressive set, in every variant, for any
// positions of the splats.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/progressive.h"
#include "raster/splats_levels_kernel.h"
#include "store/support_progressive.h"

#include <string.h>

enum { MOST = 900, WORDS = (MOST + 15) / 16 };

typedef struct fixture {
    stp_context* context;
    stp_arena arena;
    stp_splats set;
    stp_progressive_counts counts;
    uint32_t order[MOST], scratch[MOST];
} fixture;

static bool set_up(fixture* f, const progressive_desc* desc)
{
    f->context = test_context(NULL, 1, NULL);
    f->arena = stp_arena_create(f->context, 1 << 20);
    bool made_set = progressive_sample_make(&f->arena, desc, &f->set);
    f->counts = stp_progressive_count(f->set.ranges, f->set.count);
    stp_progressive_order(f->set.ranges, f->set.count, f->order, f->scratch);
    return made_set;
}

static void tear_down(fixture* f)
{
    stp_arena_destroy(&f->arena);
    stp_context_destroy(f->context);
}

/// The frame of a piece that begins at `begin`, of a state of `wanted` splats.
static levels_frame frame_of(const fixture* f, const stp_raster_splats* splats, uint32_t wanted)
{
    stp_progressive_cut cut = stp_progressive_find_cut(f->set.ranges, f->set.count, wanted);
    return (levels_frame){
        .splats = splats,
        .ranges = f->set.ranges,
        .w = {0.5f, -0.25f, 1e-3f, 7.0f}, // on both sides of the eye
        .levels = {.minimum = cut.level, .below = cut.below, .divide = cut.divide}};
}

/// Compares the splats of a state with those the kernels select, in two pieces.
static void check_state(test_state* test, fixture* f, uint32_t wanted, uint64_t seed)
{
    uint16_t expected[WORDS] = {0}, bits[3][WORDS] = {{0}};
    bool marks[MOST];
    uint32_t size = progressive_sample_mark(f->counts, f->order, wanted, marks);
    uint32_t end = stp_progressive_find_cut(f->set.ranges, f->set.count, wanted).end;
    uint32_t middle = (uint32_t)(seed % (end + 1)) / 16 * 16, words = (end + 15) / 16;
    for (uint32_t i = 0; i < end; ++i) {
        expected[i / 16] |= (uint16_t)(marks[i] << i % 16);
    }
    for (int piece = 0; piece < 2; ++piece) {
        const stp_raster_splats splats = {.positions = f->set.positions,
                                          .begin = piece == 0 ? 0 : middle,
                                          .end = piece == 0 ? middle : end};
        const levels_frame frame = frame_of(f, &splats, wanted);
        (void)stp_splats_pick_portable(&frame, bits[0]);
        if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
            (void)STP_VECTOR(stp_splats_pick)(&frame, bits[1]);
        }
        if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
            (void)STP_WIDE(stp_splats_pick)(&frame, bits[2]);
        }
    }
    CHECK_EQUAL(wanted, size);
    CHECK(memcmp(expected, bits[0], words * sizeof(*expected)) == 0);
    CHECK(stp_processor_detect() < STP_PROCESSOR_VECTOR ||
          memcmp(expected, bits[1], words * sizeof(*expected)) == 0);
    CHECK(stp_processor_detect() < STP_PROCESSOR_WIDE ||
          memcmp(expected, bits[2], words * sizeof(*expected)) == 0);
}

void test_splats_of_a_state_are_those_of_its_definition(test_state* test)
{
    static const progressive_desc descs[] = {
        {.seed = 1, .base = 1, .splits = 400},
        {.seed = 2, .base = 37, .splits = 300, .wild = true},
        {.seed = 3, .base = 5, .splits = 350, .coarse = true},
        {.seed = 4, .base = 90, .splits = 4, .wild = true},
    };
    static fixture f;
    for (uint64_t k = 0; k < 4; ++k) {
        CHECK(set_up(&f, &descs[k]));
        uint64_t states = (uint64_t)f.counts.splits + 1;
        for (uint64_t i = 0; i < 200; ++i) {
            uint64_t split = stp_rng_hash(20 + k, i) % states;
            check_state(test, &f, f.counts.base + (uint32_t)split, stp_rng_hash(30, i));
        }
        check_state(test, &f, f.counts.base, 3);
        check_state(test, &f, f.counts.base + f.counts.splits, 5);
        tear_down(&f);
    }
}
