// SPDX-License-Identifier: MIT
// Splats are lit by their light normals, on both backends, and lie as without them.
#include "support_gl.h"
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/light_normal.h"

#include <stdlib.h>
#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE };

static const uint8_t grey[3] = {180, 180, 180};

/// Light normals of both octaves of a set. NULL: none.
typedef void fill_lights(const stp_splats* set, uint32_t octave, uint32_t splat, stp_vec3* mean);

/// Splits a set into two octaves of equal colours, with light normals.
static void split_octaves(stp_context* context, stp_splats* s, fill_lights* fill)
{
    uint32_t count = s->count, first = count / 4;
    size_t entries = (size_t)first + count;
    stp_free(context, s->colors);
    stp_free(context, s->coverages);
    s->colors = STP_NEW_ZEROED(context, uint8_t, 3 * entries);
    s->coverages = STP_NEW_ZEROED(context, uint8_t, entries);
    s->turns = STP_NEW_ZEROED(context, int8_t, 2 * entries);
    s->spreads = STP_NEW_ZEROED(context, uint8_t, entries);
    s->octave_count = 2;
    s->octave_ends[0] = first;
    s->octave_ends[1] = count;
    s->light_octaves = fill != NULL ? 3 : 0;
    for (size_t i = 0; i < entries; ++i) {
        uint32_t octave = i < first ? 0 : 1;
        uint32_t splat = (uint32_t)i - (octave != 0 ? first : 0);
        memcpy(s->colors + 3 * i, grey, 3);
        s->coverages[i] = 255;
        if (fill != NULL) {
            stp_vec3 mean;
            fill(s, octave, splat, &mean);
            stp_light_normal_encode(mean, s->normals + 2 * (size_t)splat, s->turns + 2 * i,
                                    s->spreads + i);
        }
    }
}

/// Left half: towards the sky; right half: towards the ground.
static void lean_by_side(const stp_splats* set, uint32_t octave, uint32_t splat, stp_vec3* mean)
{
    (void)octave;
    float lean = set->positions[3 * (size_t)splat] < 32768 ? 0.6f : -0.6f;
    *mean = (stp_vec3){0.0f, lean, 0.8f};
}

/// The same, with half of its length.
static void lean_loosely(const stp_splats* set, uint32_t octave, uint32_t splat, stp_vec3* mean)
{
    lean_by_side(set, octave, splat, mean);
    *mean = stp_scale(*mean, 0.5f);
}

static void lean_apart(const stp_splats* set, uint32_t octave, uint32_t splat, stp_vec3* mean)
{
    (void)set, (void)splat;
    *mean = (stp_vec3){0.0f, octave == 0 ? 0.6f : -0.6f, 0.8f};
}

static void lean_anywhere(const stp_splats* set, uint32_t octave, uint32_t splat, stp_vec3* mean)
{
    (void)set;
    float part[3];
    for (uint32_t k = 0; k < 3; ++k) {
        uint64_t bits = stp_rng_hash(41 + octave, 3 * (uint64_t)splat + k);
        part[k] = (float)(bits >> 40) * (1.0f / 16777216.0f);
    }
    *mean = (stp_vec3){part[0] - 0.5f, part[1] - 0.5f, 0.8f * part[2]};
}

/// A lit square of splats.
static void add_square(made_picture* p, fill_lights* fill)
{
    p->scene.materials[0].flags = p->scene.shadings[0].flags = 0;
    p->scene.shadings[0].roughness = 0.6f;
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, grey);
    split_octaves(p->context, &p->scene.sets[p->scene.set_count - 1], fill);
}

typedef struct measured {
    double left, right; ///< mean green values
    uint64_t covered;
} measured;

static measured draw(test_state* test, fill_lights* fill, uint64_t splats)
{
    made_picture p;
    measured m = {0};
    CHECK(made_picture_begin(&p, NULL, 1));
    add_square(&p, fill);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    p.quality.splats_only = true;
    p.quality.splat_count = splats;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK_EQUAL(splats, p.stats.splats);
    m.covered = p.stats.covered_pixels;
    for (int i = 0; i < 10 * 20; ++i) {
        int x = i % 10, y = 22 + i / 10;
        m.left += made_picture_pixel(&p, 19 + x, y)[1] / 200.0;
        m.right += made_picture_pixel(&p, 35 + x, y)[1] / 200.0;
    }
    made_picture_end(&p);
    return m;
}

void test_light_normals_light_splats(test_state* test)
{
    measured own = draw(test, NULL, 1024), lean = draw(test, lean_by_side, 1024);
    measured loose = draw(test, lean_loosely, 1024);
    CHECK(own.covered > 800 && fabs(own.left - own.right) < 2.0);
    CHECK_EQUAL(own.covered, lean.covered); // disks lie as before
    CHECK_EQUAL(own.covered, loose.covered);
    CHECK(lean.left > own.left + 5.0 && lean.right < own.right - 20.0);
    double contrast = lean.left - lean.right;
    CHECK(loose.left - loose.right > 0.2 * contrast && loose.left - loose.right < 0.8 * contrast);
}

void test_light_normals_change_between_octaves(test_state* test)
{
    double low = draw(test, lean_apart, 256).left, high = draw(test, lean_apart, 1024).left;
    CHECK(low > high + 20.0);
    double before = low; // from the sky to the ground, without a step
    for (uint64_t splats = 384; splats < 1024; splats += 128) {
        double now = draw(test, lean_apart, splats).left;
        CHECK(now < before && now > high);
        before = now;
    }
}

static void add_random(made_picture* p)
{
    add_square(p, lean_anywhere);
    p->scene.shadings[0].metallic = 0.5f;
}

void test_gl_light_normals_match_the_cpu(test_state* test)
{
    static const stp_filter filters[] = {STP_FILTER_NONE, STP_FILTER_EWA};
    made_gl m;
    bool failed;
    if (!made_gl_begin_with(&m, add_random, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    m.picture.quality.splats_only = true;
    for (uint64_t splats = 200; splats <= 1000; splats += 400) {
        for (int i = 0; i < 2; ++i) {
            m.picture.quality.splat_count = splats;
            m.picture.style.filter = filters[i];
            CHECK_EQUAL(STP_OK, made_picture_draw(&m.picture));
            CHECK(m.picture.stats.covered_pixels > 500);
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(made_count_different(m.pixels, m.picture.pixels, 3) <= PIXELS / 100);
        }
    }
    made_gl_end(&m);
}
