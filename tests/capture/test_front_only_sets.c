// SPDX-License-Identifier: MIT
// Splats of single-sided surfaces do not hide what is behind their backs, and are not captured
// there.
#include "tests.h"

#include "capture/capture.h"
#include "draw/support_store.h"

/// Two squares of splats that face each other's backs: one at z = 0 faces up, one at z = 1 down.
static void check_capture(test_state* test, bool front_only)
{
    static const uint8_t white[3] = {255, 255, 255};
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    scene->front_only_shadings[0] = front_only;
    stp_splats set = made_square_set(context, 4, white);
    CHECK(set.count == 256 && set.materials[0] == 0);
    const double spacing = 2.0 / 16.0;
    stp_placed_set sets[2];
    for (int i = 0; i < 2; ++i) {
        sets[i] = (stp_placed_set){.splats = &set,
                                   .prefix = set.count,
                                   .radius = (float)(0.8 * spacing),
                                   .transform = stp_affine_identity()};
    }
    sets[1].transform = (stp_affine){{{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 1}}};
    const stp_vec3d below = {0, 0, -1};
    const stp_capture_sources sources = {.sets = sets, .set_count = 2};
    const stp_capture_desc desc = {
        .directions = &below, .direction_count = 1, .pixel_size = 0.5 * spacing};
    stp_candidates c;
    CHECK_EQUAL(STP_OK, stp_capture_all(scene, &sources, &desc, &c));
    uint32_t far = 0;
    for (uint32_t i = 0; i < c.count; ++i) {
        far += c.normals[3 * i + 2] < 0.0f ? 1 : 0;
    }
    // from below, the lower square shows its back
    CHECK(front_only ? far == 256 && c.count == 256 : far < 64 && c.count > 128);
    stp_candidates_destroy(context, &c);
    made_free_set(context, &set);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_capture_sees_through_backs_of_single_sided_splats(test_state* test)
{
    check_capture(test, false);
    check_capture(test, true);
}
