// SPDX-License-Identifier: MIT
// Which meshes are transparent, and the cells of their surfaces (src/draw/transparency.c).
#include "tests.h"

#include "draw/transparency.h"

void test_transparency_cells_divide_the_longest_side(test_state* test)
{
    for (int axis = 0; axis < 3; ++axis) {
        float sides[3] = {1.0f, 2.0f, 3.0f};
        sides[axis] = 8.0f;
        const stp_box box = {{-1.0f, 5.0f, 0.0f}, {-1.0f + sides[0], 5.0f + sides[1], sides[2]}};
        CHECK(stp_transparency_cells(box) == STP_TRANSPARENT_CELLS / 8.0f);
        float thin[3] = {0.0f, 0.0f, 0.0f};
        thin[axis] = 4.0f;
        const stp_box line = {{0.0f, 0.0f, 0.0f}, {thin[0], thin[1], thin[2]}};
        CHECK(stp_transparency_cells(line) == STP_TRANSPARENT_CELLS / 4.0f);
    }
    CHECK(stp_transparency_cells((stp_box){{3, 3, 3}, {3, 3, 3}}) == 0.0f);
}

void test_transparency_of_meshes_follows_their_material(test_state* test)
{
    stp_store_material material = {.base_color = {1, 1, 1, 0.5f}, .alpha = STP_STORE_BLEND};
    CHECK_EQUAL(STP_TRANSPARENT_EVERYWHERE, stp_transparency_of_mesh(&material, false));
    CHECK_EQUAL(STP_TRANSPARENT_PARTLY, stp_transparency_of_mesh(&material, true));
    material.base_color[3] = STP_ALPHA_OPAQUE_FROM; // rounded to a byte, it is opaque
    CHECK_EQUAL(STP_TRANSPARENT_NOWHERE, stp_transparency_of_mesh(&material, false));
    material.base_color[3] = 254.0f / 255.0f;
    CHECK_EQUAL(STP_TRANSPARENT_EVERYWHERE, stp_transparency_of_mesh(&material, false));
    material.alpha = STP_STORE_MASK;
    CHECK_EQUAL(STP_TRANSPARENT_NOWHERE, stp_transparency_of_mesh(&material, true));
    material.alpha = STP_STORE_OPAQUE;
    CHECK_EQUAL(STP_TRANSPARENT_NOWHERE, stp_transparency_of_mesh(&material, false));
}
