// SPDX-License-Identifier: MIT
#include "points_test.h"

static stp_scene* import_off(stp_context* context, const char* text, stp_result* result)
{
    return import_bytes(context, "a.off", text, strlen(text), result);
}

static const char cube[] = "OFF # a pyramid\n\n5 5 0\n0 0 0\n1 0 0\n# between\n1 1 0\n0 1 0\n"
                           "0.5 0.5 1e0\n4 0 1 2 3\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4";

void test_off_polygons(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_off(context, cube, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK(mesh->vertex_count == 5 && mesh->triangle_count == 6);
    CHECK(mesh->normals == NULL && mesh->colors == NULL && mesh->texcoords[0] == NULL);
    CHECK(mesh->positions[14] == 1.0f && mesh->indices[17] == 4);
    CHECK(strcmp(scene->up, "y") == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_truncation("a.off", cube, strlen(cube)));
    CHECK(survives_failing_allocator("a.off", cube, strlen(cube)));
}

// Every part of a vertex; colours as bytes with alpha, as fractions, or missing.
void test_off_parts_of_vertices(test_state* test)
{
    static const char text[] = "STCNOFF\n3 1 0\n0 0 0 0 0 2 255 0 0 51 0.25 0.75\n"
                               "1 0 0 0 0 2 0 255 0 0 1 1\n0 1 0 0 0 2 1 0\n3 0 1 2 0.5 0.5 0.5\n";
    static const char fractions[] = "COFF\r\n3 1\r\n0 0 0 1 0 0\r\n1 0 0 0 0.5 0\r\n0 1 0\r\n"
                                    "3 0 1 2\r\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_off(context, text, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK(mesh->normals[5] == 1.0f && mesh->texcoords[0][0] == 0.25f);
    CHECK(mesh->texcoords[0][1] == 0.25f && mesh->texcoords[0][4] == 1.0f);
    CHECK(mesh->colors[0] == 65535 && mesh->colors[1] == 0 && mesh->colors[3] == 13107);
    CHECK(mesh->colors[8] == 65535 && mesh->colors[11] == 65535);
    CHECK(strstr(log.warning, "the colours of 1 faces are left out") != NULL);
    stp_scene_destroy(scene);
    scene = import_off(context, fractions, &result);
    CHECK_EQUAL(STP_OK, result);
    mesh = &scene->meshes[0];
    CHECK(mesh->colors[0] == 65535 && mesh->colors[5] > 13000 && mesh->colors[5] < 15000);
    CHECK(mesh->colors[3] == 65535 && mesh->colors[9] == 65535);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_truncation("a.off", text, strlen(text)));
    CHECK(survives_failing_allocator("a.off", text, strlen(text)));
}

// National grids keep their precision; a position that is not finite costs its faces.
void test_off_keeps_distant_coordinates(test_state* test)
{
    static const char text[] = "4 3 0\nnan 0 0\n500000.125 4500000.5 10\n500000.375 4500000.5 10\n"
                               "500000.125 4500000.75 10\n3 1 2 3\n3 0 1 2\n2 1 2\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_off(context, text, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->meshes[0].triangle_count);
    CHECK(strstr(log.warning, "1 faces with fewer than three corners") != NULL);
    CHECK(stp_scene_finish(scene) == STP_OK);
    stp_boxd box = scene->nodes[scene->root].bounds;
    CHECK(box.min.x == 500000.125 && box.max.x == 500000.375);
    CHECK(box.min.y == 4500000.5 && box.max.y == 4500000.75);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_off_faces_may_have_one_corner(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_off(context, "OFF\n1 4 0\n0 0 0\n1 0\n1 0\n0\n1 0", &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, log.warnings); // they are left out
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_off_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char* text;
        stp_result result;
        const char* says;
    } cases[] = {{"", STP_ERROR_FORMAT, "line 1: expected OFF"},
                 {"OFFSET\n", STP_ERROR_FORMAT, "line 1: expected OFF"},
                 {"4OFF\n1 1 1\n", STP_ERROR_FORMAT, "expected"},
                 {"OFF BINARY\n", STP_ERROR_UNSUPPORTED, "binary"},
                 {"OFF\nmany\n", STP_ERROR_FORMAT, "line 2: expected the numbers"},
                 {"OFF\n1e9 1e9 0\n", STP_ERROR_TRUNCATED, "too short"},
                 {"OFF\n1 0 0\n0 0 x    \n", STP_ERROR_FORMAT, "line 3"},
                 {"OFF\n1 1 0\n0 0 0\n3 0 0 1     \n", STP_ERROR_FORMAT, "line 4"},
                 {"OFF\n1 1 0\n0 0 0\n3 0 0 -1    \n", STP_ERROR_FORMAT, "line 4"},
                 {"OFF\n2 1 0\n0 0 0\n0 0 1\n3 0 1 0.5\n", STP_ERROR_FORMAT, "line 5"},
                 {"OFF\n1 1 0\n0 0 0\n9999999 0 0 0\n", STP_ERROR_FORMAT, "line 4"}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_refused("a.off", cases[i].text, strlen(cases[i].text), cases[i].result,
                         cases[i].says));
    }
}
