// SPDX-License-Identifier: MIT
// Candidates of surfaces with normal maps are lit by the normals of their texels, and lie as before.
#include "tests.h"

#include "capture/capture.h"

#include <string.h>

enum { TEXELS = 8 };

/// How a square differs from the plain one.
typedef struct square_kind {
    float u, v;       ///< factors of the texture coordinates
    float scale;      ///< of the map
    bool mirrored;    ///< placed by a mirroring transform
    bool turned;      ///< its corners turn clockwise
    bool has_normals; ///< vertex normals, towards +z
    bool plain;       ///< no map
} square_kind;

/// A map of four quadrants, tilted to the right or to the left, and up or down.
static bool add_map(stp_scene* scene, uint32_t* index)
{
    stp_texture texture = {.width = TEXELS, .height = TEXELS, .nearest = true};
    texture.wrap_u = texture.wrap_v = STP_WRAP_REPEAT;
    texture.texels = stp_alloc(scene->context, TEXELS * TEXELS * 4);
    if (texture.texels == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < TEXELS * TEXELS; ++i) {
        bool left = i % TEXELS < TEXELS / 2, above = i / TEXELS < TEXELS / 2;
        const uint8_t texel[4] = {left ? 168 : 88, above ? 148 : 108, 245, 255};
        memcpy(texture.texels + 4 * (size_t)i, texel, 4);
    }
    return stp_scene_add_texture(scene, &texture, index) == STP_OK;
}

/// A square from -1 to 1 in the plane z = 0, facing +z; the map's first row is at the top.
static bool add_square(stp_scene* scene, const square_kind* kind, uint32_t material,
                       uint32_t* index)
{
    stp_context* context = scene->context;
    stp_mesh mesh = {.vertex_count = 4, .triangle_count = 2, .material = material};
    mesh.positions = STP_NEW_ZEROED(context, float, 12);
    mesh.texcoords[0] = STP_NEW_ZEROED(context, float, 8);
    mesh.indices = STP_NEW_ZEROED(context, uint32_t, 6);
    mesh.normals = kind->has_normals ? STP_NEW_ZEROED(context, float, 12) : NULL;
    if (mesh.positions == NULL || mesh.texcoords[0] == NULL || mesh.indices == NULL ||
        (kind->has_normals && mesh.normals == NULL)) {
        return false;
    }
    mesh.bounds = (stp_box){{-1, -1, 0}, {1, 1, 0}};
    for (size_t i = 0; i < 4; ++i) {
        float u = (float)(i % 2), v = (float)(i / 2);
        memcpy(mesh.positions + 3 * i, (float[3]){2.0f * u - 1.0f, 1.0f - 2.0f * v, 0.0f}, 12);
        memcpy(mesh.texcoords[0] + 2 * i, (float[2]){kind->u * u, kind->v * v}, 8);
        if (kind->has_normals) {
            mesh.normals[3 * i + 2] = 1.0f;
        }
    }
    static const uint32_t corners[2][6] = {{0, 2, 3, 0, 3, 1}, {0, 3, 2, 0, 1, 3}};
    memcpy(mesh.indices, corners[kind->turned], sizeof(corners[0]));
    return stp_scene_add_mesh(scene, &mesh, index) == STP_OK;
}

static bool capture(stp_context* context, const square_kind* kind, stp_candidates* candidates)
{
    stp_scene* scene = NULL;
    stp_material m = stp_material_default();
    uint32_t material, mesh;
    if (stp_scene_create(context, &scene) != STP_OK) {
        return false;
    }
    m.normal_scale = kind->scale;
    bool made = (kind->plain || add_map(scene, &m.normal_texture.texture)) &&
                stp_scene_add_material(scene, &m, &material) == STP_OK &&
                add_square(scene, kind, material, &mesh);
    stp_placed_part part = {.part = {STP_PART_MESH, 0}, .transform = stp_affine_identity()};
    part.transform.m[0][0] = kind->mirrored ? -1.0 : 1.0;
    stp_capture_desc desc = {.resolution = 60, .no_fill = true};
    made = made && stp_capture_parts(scene, &part, 1, &desc, candidates) == STP_OK;
    stp_scene_destroy(scene);
    return made;
}

static stp_vec3 normal_of(const stp_candidates* c, uint32_t i)
{
    const float* n = (c->light_normals != NULL ? c->light_normals : c->normals) + 3 * (size_t)i;
    return (stp_vec3){n[0], n[1], n[2]};
}

/// Number of candidates away from the borders of quadrants, all of which tilt by the factors in
/// their own quadrant, seen from both sides; 0: some do not.
static uint32_t count_tilted(const stp_candidates* c, float right, float up)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; ++i) {
        float x = c->positions[3 * (size_t)i], y = c->positions[3 * (size_t)i + 1];
        if (fabsf(x) < 0.1f || fabsf(y) < 0.1f || fabsf(x) > 0.9f || fabsf(y) > 0.9f) {
            continue;
        }
        stp_vec3 n = normal_of(c, i);
        float side = n.z < 0.0f ? -1.0f : 1.0f; // seen from behind, all of the normal is turned
        float tilt_x = n.x * side * (x < 0.0f ? 1.0f : -1.0f);
        float tilt_y = n.y * side * (y > 0.0f ? 1.0f : -1.0f);
        if (fabsf(tilt_x - right) > 0.02f || fabsf(tilt_y - up) > 0.02f ||
            fabsf(stp_length(n) - 1.0f) > 1e-4f) {
            return 0;
        }
        count += 1;
    }
    return count;
}

void test_candidates_are_lit_by_normal_maps(test_state* test)
{
    // with right and up: the map's red is 0.32 and its green 0.16, or less
    const struct {
        square_kind kind;
        float right, up;
    } cases[] = {
        {{.u = 1, .v = 1, .scale = 1}, 0.31f, 0.155f},
        {{.u = 1, .v = 1, .scale = 1, .has_normals = true}, 0.31f, 0.155f},
        {{.u = 1, .v = 1, .scale = 1, .turned = true, .has_normals = true}, 0.31f, 0.155f},
        {{.u = 1, .v = 1, .scale = 1, .mirrored = true}, 0.31f, 0.155f},
        {{.u = 1, .v = 1, .scale = -1}, -0.31f, -0.155f},
        {{.u = -1, .v = 1, .scale = 1}, 0.31f, 0.155f}, // mirrored: the other half is here
        {{.u = 1, .v = -1, .scale = 1}, 0.31f, 0.155f},
        {{.u = 0, .v = 1, .scale = 1}, 0.0f, 0.0f}, // no tangents
        {{.u = 1, .v = 1, .scale = 0}, 0.0f, 0.0f},
        {{.u = 1, .v = 1, .scale = 1, .plain = true}, 0.0f, 0.0f},
        {{.u = 1, .v = 1, .scale = 4}, 0.757f, 0.378f}, // far
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_candidates c;
        CHECK(capture(context, &cases[i].kind, &c));
        CHECK(count_tilted(&c, cases[i].right, cases[i].up) > c.count / 2);
        CHECK((c.light_normals == NULL) == (cases[i].kind.plain || cases[i].kind.scale == 0.0f));
        for (uint32_t k = 0; k < c.count; ++k) {
            CHECK(fabsf(fabsf(c.normals[3 * (size_t)k + 2]) - 1.0f) < 1e-6f);
        }
        stp_candidates_destroy(context, &c);
        stp_context_destroy(context);
    }
}

void test_capture_with_normal_maps_is_the_same_for_any_thread_count(test_state* test)
{
    const square_kind kind = {.u = 3, .v = 2, .scale = 1, .has_normals = true};
    stp_candidates made[2];
    stp_context* contexts[2];
    for (uint32_t i = 0; i < 2; ++i) {
        contexts[i] = test_context(NULL, 1 + 3 * i, NULL);
        CHECK(capture(contexts[i], &kind, &made[i]));
    }
    CHECK_EQUAL(made[0].count, made[1].count);
    CHECK(memcmp(made[0].light_normals, made[1].light_normals, 12 * (size_t)made[0].count) == 0);
    for (uint32_t i = 0; i < 2; ++i) {
        stp_candidates_destroy(contexts[i], &made[i]);
        stp_context_destroy(contexts[i]);
    }
}
