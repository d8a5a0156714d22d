// SPDX-License-Identifier: MIT
// Points of a mesh's preview (src/builder/preview_points.c): on its triangles, in proportion to area, in
// the colours of texture and vertices, and none where the mesh is cut out.
#include "tests.h"

#include "base/math/color.h"
#include "base/splats/octahedral.h"
#include "builder/draft_content.h"

#include <math.h>
#include <string.h>

enum { COUNT = 2000, SIDE = 4 };

/// A flat strip from x = 0 to 3: a triangle pair of area 1, and one of area 2.
typedef struct strip {
    stp_mesh mesh;
    stp_material material;
    stp_texture texture;
    stp_scene scene;
    float positions[18], texcoords[12];
    uint32_t indices[12];
    uint16_t colors[24];
    uint8_t texels[4 * SIDE * SIDE];
} strip;

static void make_strip(stp_context* context, strip* s)
{
    static const float xs[3] = {0, 1, 3};
    static const uint32_t indices[12] = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
    *s = (strip){.material = stp_material_default()};
    memcpy(s->indices, indices, sizeof(indices));
    for (int i = 0; i < 6; ++i) {
        float* p = s->positions + 3 * i;
        p[0] = xs[i / 2];
        p[1] = (float)(i % 2);
        s->texcoords[2 * i] = p[0] / 2.0f - 0.25f; // from -0.25 to 1.25
        s->texcoords[2 * i + 1] = p[1];
        for (int k = 0; k < 4; ++k) {
            s->colors[4 * i + k] = k == 1 ? 32768 : 65535;
        }
    }
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const uint8_t texel[4] = {(uint8_t)(60 * (i % SIDE) + 15), (uint8_t)(60 * (i / SIDE) + 15),
                                  200, (uint8_t)(i % SIDE < 2 ? 255 : 0)};
        memcpy(s->texels + 4 * i, texel, sizeof(texel));
    }
    s->texture = (stp_texture){.width = SIDE, .height = SIDE, .texels = s->texels};
    s->mesh = (stp_mesh){.name = "strip",
                         .vertex_count = 6,
                         .triangle_count = 4,
                         .positions = s->positions,
                         .indices = s->indices,
                         .bounds = {{0, 0, 0}, {3, 1, 0}}};
    s->mesh.texcoords[0] = s->texcoords;
    s->scene = (stp_scene){.context = context,
                           .meshes = &s->mesh,
                           .mesh_count = 1,
                           .materials = &s->material,
                           .material_count = 1,
                           .textures = &s->texture,
                           .texture_count = 1};
}

/// Texel of the strip's texture at a place, repeated or clamped, as its definition says.
static const uint8_t* expected_texel(const strip* s, const float* p)
{
    double uv[2] = {(double)p[0] / 2.0 - 0.25, (double)p[1]};
    int at[2];
    for (int k = 0; k < 2; ++k) {
        bool clamps = (k == 0 ? s->texture.wrap_u : s->texture.wrap_v) == STP_WRAP_CLAMP;
        double part = clamps ? fmin(fmax(uv[k], 0.0), 1.0) : uv[k] - floor(uv[k]);
        at[k] = (int)fmin(part * SIDE, SIDE - 1);
    }
    return s->texels + 4 * (at[1] * SIDE + at[0]);
}

/// Whether a place is so near to the border of a texel that rounding decides.
static bool is_at_border(const float* p)
{
    double u = ((double)p[0] / 2.0 - 0.25) * SIDE, v = (double)p[1] * SIDE;
    return fabs(u - nearbyint(u)) < 1e-4 || fabs(v - nearbyint(v)) < 1e-4;
}

void test_previews_are_spread_by_area(test_state* test)
{
    static strip s;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_arena arena = stp_arena_create(context, 4096);
    stp_store_point_set points;
    make_strip(context, &s);
    CHECK(stp_preview_mesh(&arena, &s.scene, 0, COUNT, &points));
    CHECK_EQUAL(COUNT, points.point_count);
    uint32_t first = 0, lower = 0;
    for (uint32_t i = 0; i < COUNT; ++i) {
        const float* p = points.positions + 3 * i;
        CHECK(p[0] >= 0.0f && p[0] <= 3.0f && p[1] >= 0.0f && p[1] <= 1.0f && p[2] == 0.0f);
        stp_vec3 n = stp_octahedral_decode16(points.normals[2 * i], points.normals[2 * i + 1]);
        CHECK(fabsf(n.z) > 0.999f);
        first += p[0] < 1.0f;
        lower += p[1] < 0.5f;
        CHECK(points.colors[4 * i] == 255 && points.colors[4 * i + 3] == 255);
    }
    CHECK(abs((int)first - COUNT / 3) <= 2); // a third of the area
    CHECK(abs((int)lower - COUNT / 2) < COUNT / 20);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_previews_have_the_colours_of_texture_and_vertices(test_state* test)
{
    static strip s;
    stp_context* context = test_context(NULL, 1, NULL);
    for (int clamps = 0; clamps < 2; ++clamps) {
        for (int colored = 0; colored < 2; ++colored) {
            stp_arena arena = stp_arena_create(context, 4096);
            stp_store_point_set points;
            make_strip(context, &s);
            s.material.base_color_texture.texture = 0;
            s.texture.wrap_u = clamps ? STP_WRAP_CLAMP : STP_WRAP_REPEAT;
            s.mesh.colors = colored ? s.colors : NULL;
            CHECK(stp_preview_mesh(&arena, &s.scene, 0, COUNT, &points));
            CHECK_EQUAL(COUNT, points.point_count);
            for (uint32_t i = 0; i < COUNT; ++i) {
                const float* p = points.positions + 3 * i;
                const uint8_t *got = points.colors + 4 * i, *texel = expected_texel(&s, p);
                float green =
                    stp_srgb8_to_linear(texel[1]) * (colored ? 32768.0f / 65535.0f : 1.0f);
                bool same = abs(got[0] - texel[0]) <= 1 && abs(got[2] - texel[2]) <= 1 &&
                            abs(got[1] - stp_linear_to_srgb8(green)) <= 1 && got[3] == 255;
                CHECK(same || is_at_border(p));
            }
            stp_arena_destroy(&arena);
        }
    }
    stp_context_destroy(context);
}

void test_previews_leave_out_what_is_cut_out(test_state* test)
{
    static strip s;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_arena arena = stp_arena_create(context, 4096);
    stp_store_point_set points;
    make_strip(context, &s);
    s.material.base_color_texture.texture = 0;
    s.material.alpha_mode = STP_ALPHA_MASK;
    s.material.alpha_cutoff = 0.5f;
    CHECK(stp_preview_mesh(&arena, &s.scene, 0, COUNT, &points));
    CHECK(points.point_count > COUNT / 3 && points.point_count < COUNT / 2 + COUNT / 10);
    for (uint32_t i = 0; i < points.point_count; ++i) {
        const float* p = points.positions + 3 * i;
        CHECK(expected_texel(&s, p)[3] == 255 || is_at_border(p));
    }
    s.texture.texels = NULL; // pictures that are still encoded cut out nothing
    CHECK(stp_preview_mesh(&arena, &s.scene, 0, COUNT, &points));
    CHECK_EQUAL(COUNT, points.point_count);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_previews_survive_failing_allocator(test_state* test)
{
    static strip s;
    bool done = false;
    for (int n = 0; !done; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_store_point_set points;
        if (context == NULL) {
            continue;
        }
        stp_arena arena = stp_arena_create(context, 4096);
        make_strip(context, &s);
        done = stp_preview_mesh(&arena, &s.scene, 0, COUNT, &points);
        CHECK(!done || points.point_count == COUNT);
        stp_arena_destroy(&arena);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}
