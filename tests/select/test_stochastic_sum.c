// SPDX-License-Identifier: MIT
// Views take from cubes of many leaves what these leaves want together, by Table 1 (Bhakar, Luo,
// Mudur 2004) leaf by leaf, and more in larger pictures (src/select/rule_cues.c).
#include "stochastic_scene.h"

#include "base/math/rng.h"
#include "select/cues.h"

#include <string.h>

enum { POINTS = 40000 };

static double unit(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

/// A box with bumps on a wide floor: flat and bent leaves, edges, and every direction.
static void place_point(uint64_t i, float* p, float* n)
{
    double a = unit(1, i), b = unit(2, i);
    memset(n, 0, 3 * sizeof(float));
    if (i % 4 == 0) {
        n[1] = 1.0f;
        memcpy(p, (float[3]){(float)(4.0 * a - 2.0), -1.0f, (float)(4.0 * b - 2.0)},
               3 * sizeof(float));
        return;
    }
    if (i % 4 == 1) { // a ball with bumps beside it
        double z = 2.0 * a - 1.0, r = sqrt(1.0 - z * z), turn = 6.2831853 * b;
        float out = 0.5f + 0.02f * (float)sin(30.0 * z);
        memcpy(n, (float[3]){(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z},
               3 * sizeof(float));
        memcpy(p, (float[3]){1.2f + out * n[0], out * n[1], out * n[2]}, 3 * sizeof(float));
        return;
    }
    uint32_t side = (uint32_t)(stp_rng_hash(3, i) % 6), axis = side / 2;
    n[axis] = side % 2 != 0 ? 1.0f : -1.0f;
    p[axis] = 0.5f * n[axis];
    p[(axis + 1) % 3] = (float)(a - 0.5);
    p[(axis + 2) % 3] = (float)(b - 0.5);
}

static bool set_up(stochastic_scene* f)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    const stp_leaf_desc desc = {.budget = 100, .minimum = 16, .flatness = 0.005f, .sample = 100};
    for (uint64_t i = 0; i < POINTS; ++i) {
        place_point(i, positions + 3 * i, normals + 3 * i);
    }
    return stochastic_scene_open(f, &desc, positions, normals, POINTS,
                                 (stp_boxd){{-2, -1, -2}, {2, 1, 2}}) &&
           f->leaves.leaf_count > 300;
}

/// What the leaves of a view want, one by one.
static double sum_leaves(const stochastic_scene* f, const stp_view* view,
                         const stp_quality* quality)
{
    stp_draw_list list = {.splat_size = quality->splat_size};
    stp_selection s = {.quality = quality, .list = &list, .eye_count = 1};
    const stp_select_entry at = {.transform = stp_affine_identity()};
    stp_box_visibility all, sight;
    const stp_boxd box = f->made.nodes[0].bounds;
    (void)stp_view_frame_make(view, &s.frames[0]);
    (void)stp_select_is_in_view(&s, &box, &all);
    stp_cue_view cues = stp_cue_view_make(&s, &at, &f->made.sets[0], &f->leaves, &all);
    double sum = 0.0;
    for (uint32_t i = 0; i < f->leaves.node_count; ++i) {
        const stp_leaf_node* node = &f->leaves.nodes[i];
        stp_boxd cube = stp_cue_box(&cues, node);
        double reach = stp_cue_overhang(&cues, node, &cube);
        const stp_vec3d margin = {reach, reach, reach};
        const stp_boxd larger = {stp_subd(cube.min, margin), stp_addd(cube.max, margin)};
        if (node->leaf_count == 1 && (stp_select_is_in_view(&s, &cube, &sight) ||
                                      stp_select_is_in_view(&s, &larger, &sight))) {
            double enough = stp_cue_occlusion_limit(&cues, node, &sight);
            sum += stp_cue_samples(&cues, node, &sight, stp_cue_before(&cues, node, enough));
        }
    }
    return sum;
}

void test_stochastic_views_draw_what_their_leaves_want(test_state* test)
{
    static stochastic_scene f;
    static const stp_vec3d eyes[] = {{3, 2, 5}, {-14, 9, 12}, {1, 0.2, 2.6}};
    static const uint32_t cues[] = {STP_CUES_PAPER, STP_CUES_ALL};
    CHECK(set_up(&f));
    for (size_t e = 0; e < sizeof(eyes) / sizeof(eyes[0]); ++e) {
        for (size_t c = 0; c < sizeof(cues) / sizeof(cues[0]); ++c) {
            for (float size = 2.0f; size <= 16.0f; size *= 2.0f) {
                uint64_t before = 0;
                for (uint32_t width = 100; width <= 800; width = width * 3 / 2) {
                    const stp_view view = {.eye = eyes[e],
                                           .up = {0, 1, 0},
                                           .fov_degrees = 50,
                                           .width = width,
                                           .height = width};
                    const stp_quality quality = {.splat_size = size,
                                                 .cues_off = STP_CUES_ALL & ~cues[c]};
                    CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
                    double wanted = sum_leaves(&f, &view, &quality);
                    double drawn = (double)f.list.splat_count;
                    CHECK(fabs(drawn - wanted) < 0.15 * wanted + 60.0);
                    CHECK(f.list.splat_count >= before);
                    before = f.list.splat_count;
                }
            }
        }
    }
    stochastic_scene_close(&f);
}
