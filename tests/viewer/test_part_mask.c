// SPDX-License-Identifier: MIT
#include "program/viewer/model/part_mask.h"
#include "select/camera.h"
#include "select/support_built.h"

#include <stdlib.h>

void test_viewer_part_masks_show_what_is_hidden(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = context != NULL ? built_open(context, 61, false) : NULL;
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_farthest_store content = {context, store, NULL};
    part_shape shape = {0};
    part_mask mask = {0};
    stp_placed_node all = {d->root, stp_affine_identity()};
    part_shape_make(context, store, &all, &shape);
    CHECK_EQUAL(d->nodes[d->root].triangle_count, shape.count);
    stp_view view = {.width = 161, .height = 90};
    CHECK(stp_camera_face("iso", &view));
    stp_camera_fit_store(&content, NULL, &view);
    // nothing in front: all of it is visible, within the margins of the picture
    float* nearness = calloc((size_t)view.width * view.height, sizeof(float));
    CHECK(nearness != NULL && part_mask_draw(&mask, &shape, &view, nearness, 1.0));
    CHECK(mask.width == 81 && mask.height == 45 && mask.visible > 200 && mask.hidden == 0);
    for (uint32_t x = 0; x < mask.width; ++x) {
        CHECK(mask.cells[x] == PART_CELL_NONE);
    }
    // something in front of the left half
    size_t visible = mask.visible;
    for (uint32_t y = 0; y < view.height; ++y) {
        for (uint32_t x = 0; x < view.width / 2; ++x) {
            nearness[(size_t)y * view.width + x] = 1e6f;
        }
    }
    CHECK(part_mask_draw(&mask, &shape, &view, nearness, 1.0));
    CHECK(mask.visible + mask.hidden == visible && mask.visible > 50 && mask.hidden > 50);
    // depths that are not known hide nothing; sections cut the mask as well
    CHECK(part_mask_draw(&mask, &shape, &view, NULL, 0.0) && mask.hidden == 0);
    view.sections = (stp_sections){1, {{{0, 1, 0}, -1e9}}};
    CHECK(part_mask_draw(&mask, &shape, &view, nearness, 1.0));
    CHECK(mask.visible == 0 && mask.hidden == 0);
    // an invalid view and an object without triangles
    stp_placed_node none = {STP_STORE_NONE, stp_affine_identity()};
    part_shape_make(context, store, &none, &shape);
    CHECK(shape.count == 0 && !part_mask_draw(&mask, &shape, &(stp_view){0}, NULL, 0.0));
    CHECK(mask.width == 0);
    free(nearness);
    part_mask_destroy(&mask);
    part_shape_destroy(&shape);
    stp_store_close(store);
    stp_context_destroy(context);
}
