// SPDX-License-Identifier: MIT
//
// Pictures of OBJ materials: alpha maps join the colours, options of maps, and emission.
#include "formats_test.h"

#include <math.h>

enum { SIDE = 2, TEXELS = SIDE * SIDE };

/// Writes a TGA picture of 32 bits a texel, top row first, into the test's folder.
static int write_picture(const char* name, int width, int height, const uint8_t (*texels)[4])
{
    uint8_t bytes[18 + 4 * 16] = {
        [2] = 2, [12] = (uint8_t)width, [14] = (uint8_t)height, [16] = 32, [17] = 0x28};
    for (int i = 0; i < width * height; ++i) {
        uint8_t* out = bytes + 18 + 4 * i;
        out[0] = texels[i][2];
        out[1] = texels[i][1];
        out[2] = texels[i][0];
        out[3] = texels[i][3];
    }
    size_t size = 18 + 4 * (size_t)(width * height);
    FILE* file = fopen(name, "wb");
    size_t written = file != NULL ? fwrite(bytes, 1, size, file) : 0;
    return file != NULL && fclose(file) == 0 && written == size;
}

static const uint8_t colors[TEXELS][4] = {
    {10, 20, 30, 255}, {40, 50, 60, 255}, {70, 80, 90, 255}, {100, 110, 120, 255}};
static const uint8_t grey[TEXELS][4] = {
    {0, 1, 2, 255}, {100, 3, 4, 255}, {200, 5, 6, 255}, {255, 7, 8, 255}};
static const uint8_t alpha[TEXELS][4] = {
    {9, 9, 9, 0}, {9, 9, 9, 128}, {9, 9, 9, 255}, {9, 9, 9, 7}};

/// Imports a triangle whose only material has these lines; NULL on failure.
static stp_scene* import_material(stp_context* context, const char* lines)
{
    static const char obj[] = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    stp_scene* scene = NULL;
    FILE *model = fopen("a.obj", "w"), *library = fopen("a.mtl", "w");
    int good = model != NULL && library != NULL && fputs(obj, model) >= 0 &&
               fprintf(library, "newmtl m\n%s", lines) > 0;
    good = (model == NULL || fclose(model) == 0) && good;
    good = (library == NULL || fclose(library) == 0) && good;
    good = good && stp_scene_create(context, &scene) == STP_OK;
    if (good && stp_import_file(scene, "a.obj", &(stp_import_desc){0}) == STP_OK) {
        return scene;
    }
    stp_scene_destroy(scene);
    return NULL;
}

static int write_pictures(void)
{
    return write_picture("colors.tga", SIDE, SIDE, colors) &&
           write_picture("grey.tga", SIDE, SIDE, grey) &&
           write_picture("alpha.tga", SIDE, SIDE, alpha) &&
           write_picture("row.tga", TEXELS, 1, grey);
}

static const stp_texture* color_texture(const stp_scene* scene)
{
    uint32_t texture = scene->materials[1].base_color_texture.texture;
    return texture != STP_NONE ? &scene->textures[texture] : NULL;
}

/// Whether the material's picture has these colours, and channel `channel` of `mask` as its alpha.
static bool is_joined(const stp_scene* scene, const uint8_t (*mask)[4], int channel)
{
    const stp_texture* t = color_texture(scene);
    bool good = t != NULL && t->width == SIDE && t->height == SIDE && t->texels != NULL &&
                t->encoded == NULL && scene->materials[1].alpha_mode == STP_ALPHA_MASK;
    for (int i = 0; good && i < TEXELS; ++i) {
        good = memcmp(t->texels + 4 * i, colors[i], 3) == 0 &&
               t->texels[4 * i + 3] == mask[i][channel];
    }
    return good;
}

void test_mtl_alpha_maps_join_the_colours(test_state* test)
{
    CHECK(write_pictures());
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    // an opaque map is read as grey
    stp_scene* scene = import_material(context, "map_d grey.tga\nmap_Kd colors.tga\n");
    CHECK(scene != NULL && is_joined(scene, grey, 0));
    stp_scene_destroy(scene);
    scene = import_material(context, "map_Kd colors.tga\nmap_d -imfchan m alpha.tga\n");
    CHECK(scene != NULL && is_joined(scene, alpha, 3));
    stp_scene_destroy(scene);
    // the colours' own alpha: the picture stays as it is
    scene = import_material(context, "map_Kd alpha.tga\nmap_d alpha.tga\n");
    CHECK(scene != NULL && scene->materials[1].alpha_mode == STP_ALPHA_MASK);
    CHECK_EQUAL(1, scene->texture_count);
    stp_scene_destroy(scene);
    CHECK_EQUAL(0, log.warnings);
    stp_context_destroy(context);
}

void test_mtl_alpha_maps_that_do_not_fit_are_left_out(test_state* test)
{
    CHECK(write_pictures());
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene = import_material(context, "map_Kd colors.tga\nmap_d row.tga\n");
    CHECK(scene != NULL && scene->materials[1].alpha_mode == STP_ALPHA_OPAQUE);
    CHECK(log.warnings == 1 && strstr(log.warning, "its size differs") != NULL);
    stp_scene_destroy(scene);
    scene = import_material(context, "map_Kd colors.tga\nmap_d none.tga\n");
    CHECK(scene != NULL && scene->materials[1].alpha_mode == STP_ALPHA_OPAQUE);
    CHECK(log.warnings == 2 && strstr(log.warning, "none.tga") != NULL);
    stp_scene_destroy(scene);
    // without colours there is nothing to join
    scene = import_material(context, "map_d grey.tga\n");
    CHECK(scene != NULL && color_texture(scene) == NULL && log.warnings == 2);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_mtl_normal_maps_are_read_and_heights_are_not(test_state* test)
{
    CHECK(write_pictures());
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    const char* lines[] = {"norm -s 2 2 colors.tga\n",
                           "map_Kn -s 2 2 colors.tga\nmap_Bump grey.tga\n", "map_Bump grey.tga\n",
                           "bump -bm 0.2 grey.tga\n", "norm none.tga\n"};
    for (int i = 0; i < 5; ++i) {
        stp_scene* scene = import_material(context, lines[i]);
        CHECK(scene != NULL);
        const stp_material* m = &scene->materials[1];
        CHECK((m->normal_texture.texture != STP_NONE) == (i < 2));
        CHECK(i >= 2 || (m->normal_texture.transform[0][0] == 2.0f && m->normal_scale == 1.0f));
        CHECK_EQUAL(i < 2 ? 0 : i - 1, log.warnings); // a missing one is left out
        CHECK(i < 2 || i > 3 || strstr(log.warning, "not kept: 1 map of heights") != NULL);
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}

void test_mtl_options_of_maps_are_skipped(test_state* test)
{
    CHECK(write_pictures());
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = import_material(context, "map_Ke -mm 0.5 2 -t 1 1 1 -s 4 -bm 3 grey.tga\n"
                                                "map_Kd -clamp off -o 0.25 0.5 colors.tga\n"
                                                "Ns 0\nd 0.5\nPm 7\nNs 6\n");
    CHECK(scene != NULL && scene->texture_count == 2);
    const stp_material* m = &scene->materials[1];
    const stp_texture_use *light = &m->emissive_texture, *color = &m->base_color_texture;
    CHECK(light->texture != STP_NONE && light->transform[0][0] == 4.0f);
    CHECK(light->transform[1][1] == 1.0f && light->transform[0][2] == 0.0f);
    CHECK(color->transform[0][2] == 0.25f && color->transform[1][2] == -0.5f);
    CHECK(scene->textures[color->texture].wrap_u == STP_WRAP_REPEAT);
    CHECK(m->alpha_mode == STP_ALPHA_BLEND && m->base_color[3] == 0.5f && m->metallic == 1.0f);
    CHECK(fabsf(m->roughness - 0.70711f) < 1e-4f); // (2 / 8)^(1/4)
    stp_scene_destroy(scene);
    scene = import_material(context, "map_Kd -clamp on colors.tga\n");
    CHECK(scene != NULL && color_texture(scene)->wrap_u == STP_WRAP_CLAMP);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_mtl_survives_failing_allocator(test_state* test)
{
    CHECK(write_pictures());
    bool done = false;
    for (int n = 0; !done; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_scene* scene = import_material(context, "map_Kd colors.tga\nmap_d grey.tga\n");
        // a picture without memory for it is an error, not a lost picture
        done = scene != NULL;
        CHECK(done ? log.errors == 0 && is_joined(scene, grey, 0) : log.errors == 1);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
