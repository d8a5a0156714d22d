// SPDX-License-Identifier: MIT
#include "formats_test.h"

#include "base/math/rng.h"
#include "import/obj/obj.h"
#include "import/reading/text.h"

#include <math.h>

// Imports a text as OBJ with chunks of about `chunk` bytes.
static stp_scene* import_obj_bytes(stp_context* context, const char* text, size_t size,
                                   size_t chunk, stp_result* result)
{
    stp_scene* scene = NULL;
    *result = stp_scene_create(context, &scene);
    stp_import import = {.context = context,
                         .scene = scene,
                         .path = "test.obj",
                         .file = {text[0] != '\0' ? (const unsigned char*)text : NULL, size},
                         .alone = true};
    stp_object root = {.name = "test.obj", .parent = STP_NONE, .transform = stp_affine_identity()};
    if (*result == STP_OK) {
        *result = stp_scene_add_object(scene, &root, &import.root);
    }
    if (*result == STP_OK) {
        *result = stp_obj_read(&import, chunk);
    }
    if (*result != STP_OK) {
        stp_scene_destroy(scene);
        return NULL;
    }
    return scene;
}

static stp_scene* import_obj(stp_context* context, const char* text, size_t chunk,
                             stp_result* result)
{
    return import_obj_bytes(context, text, strlen(text), chunk, result);
}

static const char cube[] = "\xef\xbb\xbf# a cube in parts\r\n"
                           "o box\r\n"
                           "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\n"
                           "v 0 0 1\nv 1 0 1 1\nv 1e0 1.0 +1\nv -0 1. .1e1\n"
                           "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                           "vn 0 0 -2\nvn 0 0 1\n"
                           "g bottom\nusemtl red\n"
                           "f 1/1/1 4/4/1 3/3/1 2/2/1\n"
                           "g top\nusemtl blue\n"
                           "f 5/1/2 6/2/2 \\\n  7/3/2 8/4/2\n"
                           "usemtl red\n"
                           "f -8//-2 -7//-2 -3//-2 -4//-2 # front\n"
                           "o rest\n"
                           "s off\n"
                           "f 2 3 7 6\nf 3 4 8 7\n"
                           "o box\ng top\n"
                           "f 4 1 5 8\n"
                           "l 1 2 3\n";

void test_obj_groups_and_materials(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_obj(context, cube, 1 << 20, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    // root, box, box/bottom, box/top, rest
    CHECK_EQUAL(5, scene->object_count);
    CHECK(strcmp(scene->objects[1].name, "box") == 0 && scene->objects[1].parent == 0);
    CHECK(strcmp(scene->objects[2].name, "bottom") == 0 && scene->objects[2].parent == 1);
    CHECK(strcmp(scene->objects[3].name, "top") == 0 && scene->objects[3].parent == 1);
    CHECK(strcmp(scene->objects[4].name, "rest") == 0 && scene->objects[4].parent == 0);
    CHECK_EQUAL(0, scene->objects[1].part_count);
    CHECK_EQUAL(1, scene->objects[2].part_count);
    CHECK_EQUAL(2, scene->objects[3].part_count); // blue, red
    CHECK_EQUAL(3, scene->material_count);
    size_t triangles = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        triangles += scene->meshes[i].triangle_count;
    }
    CHECK_EQUAL(12, triangles);
    const stp_mesh* bottom = &scene->meshes[scene->parts[scene->objects[2].first_part].index];
    CHECK_EQUAL(4, bottom->vertex_count);
    CHECK(bottom->normals != NULL && bottom->normals[2] == -1.0f);          // of unit length
    CHECK(bottom->texcoords[0] != NULL && bottom->texcoords[0][1] == 1.0f); // v turned over
    CHECK(strcmp(scene->materials[bottom->material].name, "red") == 0);
    CHECK(scene->materials[bottom->material].double_sided);
    CHECK_EQUAL(0, scene->materials[bottom->material].metallic != 0.0f);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_names_that_begin_with_a_zero(test_state* test)
{
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\no \0a\ng b\nf 1 2 3\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_obj_bytes(context, text, sizeof(text) - 1, 1 << 20, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(2, scene->object_count);
    CHECK(strcmp(scene->objects[1].name, "b") == 0 && scene->objects[1].parent == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_chunks_and_threads_change_nothing(test_state* test)
{
    // a file with all features, in chunks from one byte on, with 1 to 3 threads
    static char text[40000];
    size_t length = (size_t)snprintf(text, sizeof(text), "%s", cube);
    for (int i = 0; i < 300; ++i) {
        length += (size_t)snprintf(
            text + length, sizeof(text) - length,
            "%sv %d.5 %d %d 0.5 0.25 %g\nvt 0.%d 0.5\nf -1 -2/-1 %d \\%s\n -4/1/1\np %d\n",
            i % 37 == 0 ? "g part\nusemtl m\n" : "", i, i * i % 17, i % 5, (double)i / 300.0, i,
            i + 1,
            i % 3 == 0   ? "\r"
            : i % 3 == 1 ? " \t"
                         : "",
            -1 - i % 3);
    }
    stp_hash wanted = {0};
    for (size_t chunk = 1 << 20; chunk >= 1; chunk = chunk == 1 << 20 ? 700 : chunk / 3) {
        for (uint32_t threads = 1; threads <= 3; ++threads) {
            stp_context* context = test_context(NULL, threads, NULL);
            stp_result result;
            stp_scene* scene = import_obj(context, text, chunk, &result);
            CHECK_EQUAL(STP_OK, result);
            CHECK(scene_is_sound(scene));
            stp_hash hash = digest_scene(scene);
            wanted = chunk == 1 << 20 && threads == 1 ? hash : wanted;
            CHECK(stp_hash_equal(wanted, hash));
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
}

void test_obj_vertices_are_unique_triples(test_state* test)
{
    // random corners over few elements: as many vertices as distinct triples, each with its own
    // values
    enum { FACES = 400, RANGE = 7 };
    static char text[65536];
    static unsigned char seen[RANGE][RANGE][RANGE];
    memset(seen, 0, sizeof(seen));
    size_t length = 0, distinct = 0;
    for (int i = 0; i < RANGE; ++i) {
        length += (size_t)snprintf(text + length, sizeof(text) - length,
                                   "v %d 0 0\nvt %d 0\nvn %d 1 0\n", i, i, i);
    }
    for (uint64_t i = 0; i < FACES; ++i) {
        length += (size_t)snprintf(text + length, sizeof(text) - length, "f");
        for (uint64_t k = 0; k < 3; ++k) {
            uint64_t random = stp_rng_hash(1, 3 * i + k);
            unsigned v = (unsigned)(random % RANGE), t = (unsigned)(random / 64 % RANGE);
            unsigned n = (unsigned)(random / 4096 % RANGE);
            distinct += seen[v][t][n] == 0;
            seen[v][t][n] = 1;
            length += (size_t)snprintf(text + length, sizeof(text) - length, " %u/%u/%u", v + 1,
                                       t + 1, n + 1);
        }
        length += (size_t)snprintf(text + length, sizeof(text) - length, "\n");
    }
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_obj(context, text, 500, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(distinct, mesh->vertex_count);
    for (uint64_t i = 0; i < 3 * (uint64_t)FACES; ++i) {
        uint64_t random = stp_rng_hash(1, i);
        uint32_t vertex = mesh->indices[i];
        CHECK_EQUAL(random % RANGE, mesh->positions[3 * vertex]);
        CHECK_EQUAL(random / 64 % RANGE, mesh->texcoords[0][2 * vertex]);
        float n = (float)(random / 4096 % RANGE);
        CHECK(fabsf(mesh->normals[3 * vertex] - n / sqrtf(n * n + 1.0f)) < 1e-6f);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_large_mesh_with_threads(test_state* test)
{
    // large enough for all threads to work on one mesh; quads with seams in their texture
    // coordinates
    enum { SIDE = 160 };
    size_t size = (size_t)SIDE * SIDE * 90, length = 0;
    char* text = malloc(size);
    CHECK(text != NULL);
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            length += (size_t)snprintf(text + length, size - length, "v %d.%d %d -%d.25\n", x,
                                       y % 7, y, x * y % 13);
        }
    }
    length += (size_t)snprintf(text + length, size - length, "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n");
    for (int y = 0; y + 1 < SIDE; ++y) {
        for (int x = 0; x + 1 < SIDE; ++x) {
            int a = y * SIDE + x + 1, b = a + SIDE;
            length += (size_t)snprintf(text + length, size - length, "f %d/1 %d/2 %d/3 %d/4\n", a,
                                       a + 1, b + 1, b);
        }
    }
    CHECK(length + 1 < size);
    stp_hash wanted = {0};
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_result result;
        stp_scene* scene = import_obj(context, text, 60000, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(2 * (SIDE - 1) * (SIDE - 1), scene->meshes[0].triangle_count);
        // a position has as many vertices as quads around it
        CHECK_EQUAL(4 * (SIDE - 1) * (SIDE - 1), scene->meshes[0].vertex_count);
        CHECK(scene_is_sound(scene));
        stp_hash hash = digest_scene(scene);
        wanted = threads == 1 ? hash : wanted;
        CHECK(stp_hash_equal(wanted, hash));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
    free(text);
}

void test_obj_sparse_meshes(test_state* test)
{
    // many small meshes that each use the first and the last of many positions
    enum { COUNT = 3000 };
    static char text[COUNT * 64];
    size_t length = 0;
    for (int i = 0; i < COUNT; ++i) {
        length +=
            (size_t)snprintf(text + length, sizeof(text) - length, "v %d %d 1\n", i, i * i % 11);
    }
    for (int i = 0; i < COUNT / 3; ++i) {
        length += (size_t)snprintf(text + length, sizeof(text) - length, "g g%d\nf 1 %d %d\n", i,
                                   i + 2, COUNT - i);
    }
    stp_context* context = test_context(NULL, 2, NULL);
    stp_result result;
    stp_scene* scene = import_obj(context, text, 5000, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(COUNT / 3, scene->mesh_count);
    CHECK(scene_is_sound(scene));
    const stp_mesh* last = &scene->meshes[COUNT / 3 - 1];
    CHECK_EQUAL(3, last->vertex_count);
    CHECK_EQUAL(0, last->positions[3 * last->indices[0]]);
    CHECK_EQUAL(COUNT / 3, last->positions[3 * last->indices[1]]);
    CHECK_EQUAL(COUNT - COUNT / 3, last->positions[3 * last->indices[2]]);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_points_and_colors(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene =
        import_obj(context, "v 1 2 3 1 0.5 0\nv 4 5 6\nvn 0 3 0\nvn 1 0 0\n", 8, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->point_set_count);
    const stp_point_set* points = &scene->point_sets[0];
    CHECK_EQUAL(2, points->point_count);
    CHECK(points->colors[0] == 255 && points->colors[1] == 128 && points->colors[2] == 0);
    CHECK(points->colors[4] == 255 && points->colors[7] == 255); // none written: white
    CHECK(points->normals[1] == 1.0f && points->normals[3] == 1.0f);
    stp_scene_destroy(scene);

    // colours written as bytes, and points named by index
    static const char bytes[] =
        "v 0 0 0 255 0 51\nv 1 1 1 0 0 0\np -1\nf 1 2 2\np 1 2\nv 3 3 3\np 3\n";
    for (size_t chunk = 8; chunk <= 100; chunk += 92) {
        scene = import_obj(context, bytes, chunk, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(255, scene->point_sets[0].colors[14]); // none written: white, in any chunk
        stp_scene_destroy(scene);
    }
    scene = import_obj(context, bytes, 8, &result);
    CHECK_EQUAL(STP_OK, result);
    points = &scene->point_sets[0];
    CHECK_EQUAL(4, points->point_count);
    CHECK(points->positions[0] == 1.0f && points->positions[3] == 0.0f);
    CHECK(points->colors[4] == 255 && points->colors[6] == 51);
    CHECK_EQUAL(65535, scene->meshes[0].colors[0]);
    CHECK_EQUAL(2170, scene->meshes[0].colors[2]); // 51 decoded: 0.0331
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_far_from_the_origin(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_obj(context,
                                  "v 458123.125 5429123.0625 312\nv 458124.125 5429123.0625 312\n"
                                  "v 458123.125 5429124.1875 312\nf 1 2 3\n",
                                  8, &result);
    CHECK_EQUAL(STP_OK, result);
    const stp_affine* transform = &scene->objects[0].transform;
    const float* p = scene->meshes[0].positions;
    stp_vec3d place =
        stp_affine_point(transform, (stp_vec3d){(double)p[6], (double)p[7], (double)p[8]});
    CHECK(place.x == 458123.125 && place.y == 5429124.1875 && place.z == 312.0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_obj_bad_input_is_one_sentence(test_state* test)
{
    static const struct {
        const char* text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"", STP_ERROR_FORMAT, "no positions"},
        {"# nothing\n", STP_ERROR_FORMAT, "no positions"},
        {"v 0 0\n", STP_ERROR_FORMAT, "line 1"},
        {"v 0 0 0\nf 1 1 2\n", STP_ERROR_FORMAT, "face 1"},
        {"\xef\xbb\xbf", STP_ERROR_FORMAT, "no positions"},
        {"v 0 0 0\n\xef\xbb\xbfv\nf 1 1 2\n", STP_ERROR_FORMAT, "face 1"}, // no mark there
        {"v 0 0 0\nf 1 1 1\nf 1 1 -2\n", STP_ERROR_FORMAT, "face 2"},
        {"v 0 0 0\nf 1 1 0\n", STP_ERROR_FORMAT, "line 2"},
        {"v 0 0 0\nf 1 1 99999999999999999999\n", STP_ERROR_FORMAT, "line 2"},
        {"v 0 0 0\nf 1 1 -99999999999999999999\n", STP_ERROR_FORMAT, "line 2"},
        {"v 0 0 0\nf 1 1 1x\n", STP_ERROR_FORMAT, "line 2"},
        {"v 0 0 0\np 2\n", STP_ERROR_FORMAT, "point"},
        {"v 0 0 0\np 0\n", STP_ERROR_FORMAT, "line 2"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        stp_result result;
        stp_scene* scene = import_obj(context, cases[i].text, 4, &result);
        CHECK(scene == NULL);
        CHECK_EQUAL(cases[i].result, result);
        CHECK_EQUAL(1, log.errors);
        if (strstr(log.text, cases[i].says) == NULL) {
            fprintf(stderr, "case %zu says: %s\n", i, log.text);
        }
        CHECK(strstr(log.text, cases[i].says) != NULL);
        stp_context_destroy(context);
    }
}

void test_obj_survives_truncation(test_state* test)
{
    CHECK(survives_truncation("cube.obj", cube, strlen(cube)));
}

void test_obj_survives_failing_allocator(test_state* test)
{
    CHECK(survives_failing_allocator("cube.obj", cube, strlen(cube)));
}

void test_obj_material_library(test_state* test)
{
    static const char mtl[] =
        "# library\nnewmtl glass pane\nKd 0.5 0.5 0.5\nd 0.25\nNs 98\nillum 2\n"
        "map_Kd -s 2 3 1 -clamp on -o 0.5 0.25 missing file.png\n"
        "newmtl lamp\nKd 1\nKe 1 0 0\nPm 0.5\nPr 0.75\nTr 0\n"
        "newmtl lamp\nKd 0 0 0"; // the first definition of a name wins
    char path[256], obj_path[256], text[512];
    CHECK(write_scratch(path, "lib rary.mtl", mtl, strlen(mtl)));
    snprintf(text, sizeof(text),
             "mtllib %s\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass pane\nf 1 2 3\n"
             "usemtl lamp\nf 3 2 1\nusemtl unknown\nf 2 1 3\n",
             strrchr(path, '/') + 1);
    CHECK(write_scratch(obj_path, "model.obj", text, strlen(text)));
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_result result = stp_import_file(scene, obj_path, &(stp_import_desc){0});
    unlink(path);
    unlink(obj_path);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(0, log.errors); // missing files cause a warning
    CHECK_EQUAL(4, scene->material_count);
    const stp_material* glass = &scene->materials[1];
    CHECK(strcmp(glass->name, "glass pane") == 0);
    CHECK(fabsf(glass->base_color[0] - 0.2140f) < 1e-3f); // Kd is sRGB
    CHECK(glass->base_color[3] == 0.25f && glass->alpha_mode == STP_ALPHA_BLEND);
    CHECK(fabsf(glass->roughness - 0.37606f) < 1e-4f); // (2 / 100)^(1/4)
    CHECK_EQUAL(STP_NONE, glass->base_color_texture.texture);
    CHECK(glass->base_color_texture.transform[0][0] == 2.0f);
    CHECK(glass->base_color_texture.transform[0][2] == 0.5f);
    CHECK(glass->base_color_texture.transform[1][1] == 3.0f);
    const stp_material* lamp = &scene->materials[2];
    CHECK(lamp->base_color[0] == 1.0f && lamp->base_color[1] == 1.0f && lamp->emissive[0] == 1.0f);
    CHECK(lamp->metallic == 0.5f && lamp->roughness == 0.75f &&
          lamp->alpha_mode == STP_ALPHA_OPAQUE);
    CHECK(strcmp(scene->materials[3].name, "unknown") == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_text_numbers_match_the_c_library(test_state* test)
{
    static const char* const fixed[] = {"0",
                                        "-0",
                                        "1",
                                        "-1.5",
                                        "+2.25",
                                        ".5",
                                        "5.",
                                        "1e3",
                                        "1E-3",
                                        "123456789012345678901234567890",
                                        "0.1",
                                        "3.14159265358979323846",
                                        "1e22",
                                        "1e-22",
                                        "9007199254740993",
                                        "0.000001",
                                        "4e-5x",
                                        "7e",
                                        "8e+",
                                        "00000000000000000000000001.5",
                                        "0.0000000000000000000000000000000000001"};
    for (size_t i = 0; i < 20000; ++i) {
        char text[64];
        if (i < sizeof(fixed) / sizeof(fixed[0])) {
            snprintf(text, sizeof(text), "%s\n", fixed[i]);
        } else {
            uint64_t random = stp_rng_hash(7, i);
            float value = (float)((double)(int64_t)random / 9.2e18);
            snprintf(text, sizeof(text), i % 2 == 0 ? "%.6f\n" : "%.9g\n",
                     (double)value * (i % 7 == 0 ? 1e6 : 1.0));
        }
        double value, wanted = strtod(text, NULL);
        CHECK(stp_read_number((const unsigned char*)text, &value) != NULL);
        CHECK(fabs(value - wanted) <= fabs(wanted) * 4.5e-16);
        if (i >= sizeof(fixed) / sizeof(fixed[0])) {
            CHECK(value == wanted); // values written by programs are parsed exactly
        }
    }
    double value;
    CHECK(stp_read_number((const unsigned char*)"nan\n", &value) != NULL && isnan(value));
    CHECK(stp_read_number((const unsigned char*)"-nan(ind)\n", &value) != NULL && isnan(value));
    CHECK(stp_read_number((const unsigned char*)"1.#QNAN\n", &value) != NULL && isnan(value));
    CHECK(stp_read_number((const unsigned char*)"-inf\n", &value) != NULL && value < 0 &&
          isinf(value));
    CHECK(stp_read_number((const unsigned char*)"1e99999\n", &value) != NULL && isinf(value));
    CHECK(stp_read_number((const unsigned char*)"1e-99999\n", &value) != NULL && value == 0.0);
    CHECK(stp_read_number((const unsigned char*)"x\n", &value) == NULL);
    CHECK(stp_read_number((const unsigned char*)"-\n", &value) == NULL);
    CHECK(stp_read_number((const unsigned char*)".\n", &value) == NULL);
    CHECK(stp_read_number((const unsigned char*)"\n1", &value) == NULL);
}
