// SPDX-License-Identifier: MIT
//
// Height tiles: positions, voids, sizes.
#include "points_test.h"

enum { SIDE = 1201, SIZE = 2 * SIDE * SIDE };

// Heights decrease from north to south; one void in the north-western corner and one in the centre.
static unsigned char* write_tile(void)
{
    unsigned char* bytes = malloc(SIZE);
    for (int i = 0; bytes != NULL && i < SIDE * SIDE; ++i) {
        int height = 3000 - 3 * (i / SIDE);
        if (i == 0 || i == 600 * SIDE + 600) {
            height = -32768;
        }
        bytes[2 * i] = (unsigned char)((unsigned)height >> 8);
        bytes[2 * i + 1] = (unsigned char)height;
    }
    return bytes;
}

void test_hgt_places_and_holes(test_state* test)
{
    unsigned char* bytes = write_tile();
    CHECK(bytes != NULL);
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "tiles/S34W071.hgt", bytes, SIZE, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(0, log.warnings);
    CHECK(strcmp(scene->up, "z") == 0 && scene->unit_metres == 1.0);
    CHECK(strcmp(scene->objects[0].name, "S34W071.hgt") == 0);
    const stp_mesh* m = &scene->meshes[0];
    CHECK_EQUAL(SIDE * SIDE, m->vertex_count);
    // a corner void leaves one triangle of its cell, the central one four of its four cells
    CHECK_EQUAL(2 * 1200 * 1200 - 1 - 4, m->triangle_count);
    const float* north_west = m->positions;
    const float* south_east = m->positions + 3 * ((size_t)SIDE * SIDE - 1);
    // a degree at 33.5 degrees south: cosine 0.83388582
    CHECK(fabs((double)south_east[0] - 0.5 * 111319.4908 * 0.83388582) < 0.1);
    CHECK(fabs((double)north_west[1] - 0.5 * 111319.4908) < 0.1);
    CHECK(north_west[0] == -south_east[0] && north_west[1] == -south_east[1]);
    CHECK(south_east[2] == -600.0f);
    for (size_t t = 0; t < m->triangle_count; t += 997) {
        const uint32_t* c = m->indices + 3 * t;
        const float *a = m->positions + 3 * c[0], *b = m->positions + 3 * c[1],
                    *d = m->positions + 3 * c[2];
        float up = (b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0]);
        CHECK(up > 0.0f); // counterclockwise from above
    }
    for (size_t k = 0; k < 3 * (size_t)m->triangle_count; ++k) {
        CHECK(m->indices[k] != 0 && m->indices[k] != 600 * SIDE + 600);
    }
    stp_hash one = digest_scene(scene);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    context = test_context(NULL, 1, &log);
    scene = import_bytes(context, "tiles/S34W071.hgt", bytes, SIZE, &result);
    CHECK(scene != NULL && stp_hash_equal(one, digest_scene(scene)));
    stp_scene_destroy(scene);
    scene = import_bytes(context, "tile.hgt", bytes, SIZE, &result);
    CHECK(scene != NULL && log.warnings == 1 && strstr(log.warning, "has no coordinates") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(bytes);
}

void test_hgt_bad_input_is_one_sentence(test_state* test)
{
    unsigned char* bytes = write_tile();
    CHECK(bytes != NULL);
    CHECK(is_refused("N48E010.hgt", bytes, SIZE - 1, STP_ERROR_FORMAT, "1201 or 3601"));
    CHECK(is_refused("N48E010.hgt", "", 0, STP_ERROR_FORMAT, "1201 or 3601"));
    memset(bytes, 0x80, SIZE);
    for (size_t i = 0; i < SIZE; i += 2) {
        bytes[i + 1] = 0;
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "N48E010.hgt", bytes, SIZE, &result);
    CHECK(scene != NULL && scene->mesh_count == 0); // only voids
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_failing_allocator("N48E010.hgt", bytes, SIZE));
    free(bytes);
}
