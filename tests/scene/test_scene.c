// SPDX-License-Identifier: MIT
#include "tests.h"

#include "scene/scene.h"

void test_scene_indices_have_32_bits(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    size_t capacity = 0;
    CHECK(context != NULL);
    CHECK(stp_scene_grow(context, NULL, &capacity, (size_t)STP_NONE + 1, 1) == NULL);
    CHECK_EQUAL(STP_ERROR_LIMIT, stp_scene_fail_grow(context, (size_t)STP_NONE + 1));
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_scene_fail_grow(context, 1));
    CHECK_EQUAL(2, log.errors);
    stp_context_destroy(context);
}
