// SPDX-License-Identifier: MIT
#include "scene_helpers.h"
#include "tests.h"

static bool add_texture(stp_scene* scene, uint8_t shade, const char* name, uint32_t* index)
{
    uint8_t* texels = STP_NEW_ZEROED(scene->context, uint8_t, 64);
    stp_texture texture = {.name = name, .width = 4, .height = 4, .texels = texels};
    if (texels != NULL) {
        memset(texels, shade, 64);
    }
    return texels != NULL && stp_scene_add_texture(scene, &texture, index) == STP_OK;
}

// A bolt with its own texture, material and meshes, as written by an exporter without sharing.
static bool add_copy(stp_scene* scene, const char* name, stp_affine at, uint8_t shade,
                     uint32_t* object)
{
    uint32_t texture, meshes[2];
    stp_material material = stp_material_default();
    material.name = name;
    if (!add_texture(scene, shade, name, &texture)) {
        return false;
    }
    material.base_color_texture.texture = texture;
    stp_object top = {.name = name, .id = name, .parent = STP_NONE, .transform = at};
    bool added = stp_scene_add_object(scene, &top, object) == STP_OK;
    for (int i = 0; added && i < 2; ++i) {
        stp_mesh mesh = make_strip_mesh(scene->context, 6, (float)i);
        added = stp_scene_add_material(scene, &material, &mesh.material) == STP_OK &&
                mesh.positions != NULL && mesh.indices != NULL;
        mesh.name = name;
        added = added && stp_scene_add_mesh(scene, &mesh, &meshes[i]) == STP_OK &&
                add_mesh_object(scene, *object, make_translation(0, i, 0), meshes[i], NULL);
    }
    return added;
}

void test_copies_with_copied_resources_are_merged(test_state* test)
{
    enum { COPIES = 500 };
    stp_context* context = test_context(NULL, 2, NULL);
    stp_scene* scene = NULL;
    uint32_t objects[COPIES], other;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    for (int i = 0; i < COPIES; ++i) { // every other one mirrored, and of another size
        char name[32];
        snprintf(name, sizeof(name), "bolt %d", i);
        stp_affine at = {{{i % 2 == 0 ? 1 : -1, 0, 0, i}, {0, 1 + i % 3, 0, 0}, {0, 0, 1, 0}}};
        CHECK(add_copy(scene, name, at, 7, &objects[i]));
    }
    CHECK(add_copy(scene, "bolt 0", stp_affine_identity(), 8, &other));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(2, scene->texture_count);
    CHECK_EQUAL(3, scene->material_count); // glTF's default stays the first
    CHECK_EQUAL(STP_NONE, scene->materials[0].base_color_texture.texture);
    CHECK_EQUAL(4, scene->mesh_count);
    for (int i = 1; i < COPIES; ++i) {
        CHECK_EQUAL(scene->objects[objects[0]].node, scene->objects[objects[i]].node);
    }
    CHECK(scene->objects[objects[0]].node != scene->objects[other].node);
    CHECK_EQUAL(7, scene->node_count); // two strips and their bolt, in two colours; the root
    CHECK_EQUAL(12 * (COPIES + 1), scene->nodes[scene->root].triangle_count);
    CHECK_EQUAL(1, scene->materials[scene->meshes[0].material].base_color_texture.texture + 1);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// The same part among others, in scenes with different numbering.
void test_content_does_not_depend_on_numbering(test_state* test)
{
    stp_hash contents[3], roots[3];
    for (int variant = 0; variant < 3; ++variant) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        uint32_t object, ignored;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        if (variant == 1) {
            CHECK(add_texture(scene, 99, "unused", NULL));
            CHECK(add_copy(scene, "before", make_translation(9, 9, 9), 3, &ignored));
        }
        stp_affine at = make_translation(variant == 2 ? -0.0 : 0.0, 0, 0);
        CHECK(add_copy(scene, variant == 0 ? "a" : "b", at, 5, &object));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        contents[variant] = scene->nodes[scene->objects[object].node].content;
        roots[variant] = scene->nodes[scene->root].content;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
    CHECK(stp_hash_equal(contents[0], contents[1]) && stp_hash_equal(contents[0], contents[2]));
    CHECK(!stp_hash_equal(roots[0], roots[1]) && stp_hash_equal(roots[0], roots[2]));
}

void test_different_materials_are_not_merged(test_state* test)
{
    enum { CHANGES = 18 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_texture(scene, 1, NULL, NULL) && add_texture(scene, 2, NULL, NULL));
    for (int i = 0; i < CHANGES + 4; ++i) {
        stp_material m = stp_material_default();
        m.alpha_mode = STP_ALPHA_MASK;
        m.base_color_texture.texture = i == 0 ? 1 : 0;
        m.base_color[2] = i == 1 ? 0.5f : 1.0f;
        m.metallic = i == 2 ? 0.5f : 1.0f;
        m.roughness = i == 3 ? 0.5f : 1.0f;
        m.emissive[1] = i == 4 ? 2.0f : 0.0f;
        m.alpha_cutoff = i == 5 ? 0.25f : 0.5f;
        m.alpha_mode = i == 6 ? STP_ALPHA_BLEND : m.alpha_mode;
        m.double_sided = i == 7;
        m.unlit = i == 8;
        m.metallic_roughness_texture.texture = i == 9 ? 0 : STP_NONE;
        m.emissive_texture.texture = i == 10 ? 0 : STP_NONE;
        m.base_color_texture.texcoord = i == 11;
        m.base_color_texture.transform[1][2] = i == 12 ? 0.5f : 0.0f;
        m.base_color[3] = i == 13 ? 0.5f : 1.0f;
        m.normal_texture.texture = i >= 14 && i <= 16 ? (uint32_t)(i == 15) : STP_NONE;
        m.normal_scale = i == 16 ? 0.5f : 1.0f;
        // invisible differences: a name, a transform without content, the sign of zero
        m.name = i == CHANGES ? "name" : NULL;
        m.emissive_texture.texcoord = i == CHANGES + 1;
        m.emissive[0] = i == CHANGES + 2 ? -0.0f : 0.0f;
        if (i == CHANGES + 3) { // of no effect
            m.normal_texture.texture = 0;
            m.normal_scale = 0.0f;
        }
        CHECK_EQUAL(STP_OK, stp_scene_add_material(scene, &m, NULL));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(1 + CHANGES, scene->material_count); // the last change changes nothing
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_identical_point_sets_become_one(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    for (int i = 0; i < 4; ++i) {
        stp_point_set set = {.point_count = 5};
        set.positions = STP_NEW_ZEROED(context, float, 15);
        set.colors = i == 3 ? STP_NEW_ZEROED(context, uint8_t, 20) : NULL;
        uint32_t index;
        CHECK(set.positions != NULL && stp_scene_add_point_set(scene, &set, &index) == STP_OK);
        CHECK(add_object(scene, STP_NONE, make_translation(i, 0, 0), 0, NULL));
        CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(2, scene->point_set_count);
    CHECK_EQUAL(3, scene->node_count);
    CHECK_EQUAL(20, scene->nodes[scene->root].point_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_areas_follow_scales_and_instances(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, object;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 8, 0.0f, &mesh)); // 8 triangles of base 1 and height 1
    stp_affine twice = {{{0, 2, 0, 5}, {-2, 0, 0, 0}, {0, 0, 2, 0}}};
    CHECK(add_mesh_object(scene, STP_NONE, twice, mesh, &object));
    for (int i = 0; i < 3; ++i) {
        stp_affine at = make_translation(0, 0, i);
        CHECK_EQUAL(STP_OK, stp_scene_add_instance(scene, &at));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK(fabs(scene->meshes[0].area - 4.0) < 1e-12);
    CHECK(fabs(scene->nodes[scene->objects[object].node].area - 12.0) < 1e-12);
    CHECK(fabs(scene->nodes[scene->root].area - 48.0) < 1e-12);
    CHECK(scene->meshes[0].grid_step > 0.0 && scene->meshes[0].grid_step <= 0.125);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
