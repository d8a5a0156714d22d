// SPDX-License-Identifier: MIT
#include "tests.h"

#include "scene/scene.h"

void test_scene_indices_have_32_bits(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    size_t capacity = 0;
    uint32_t* array = NULL;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_ERROR_LIMIT, stp_scene_make_room(context, (void*)&array, &capacity,
                                                     (size_t)STP_NONE + 1, sizeof(*array)));
    CHECK(array == NULL && capacity == 0);
    CHECK_EQUAL(1, log.errors);
    stp_context_destroy(context);
}
