// SPDX-License-Identifier: MIT
// Tangents of triangles, and normals from texels of normal maps.
#include "tests.h"

#include "raster/normal_map.h"

static bool is_near(stp_vec3 a, float x, float y, float z)
{
    return stp_length(stp_sub(a, (stp_vec3){x, y, z})) < 1e-5f;
}

/// Tangents of a triangle in the plane z = 0 with edges along +x and +y. u grows along +x, or
/// against it; v decreases along +y, as pictures have their first row at the top.
static stp_tangents upright(bool mirrored)
{
    const stp_vec3 edges[2] = {{2.0f, 0.0f, 0.0f}, {0.0f, 3.0f, 0.0f}};
    const float uv[2][2] = {{mirrored ? -1.0f : 1.0f, 0.0f}, {0.0f, -1.0f}};
    stp_tangents tangents = {0};
    return stp_tangents_find(edges, uv, &tangents) ? tangents : (stp_tangents){0};
}

void test_tangents_follow_texture_coordinates(test_state* test)
{
    stp_tangents t = upright(false);
    CHECK(t.right.x > 0.0f && t.right.y == 0.0f && t.right.z == 0.0f);
    CHECK(t.up.y > 0.0f && t.up.x == 0.0f && t.up.z == 0.0f);
    t = upright(true);
    CHECK(t.right.x < 0.0f && t.right.y == 0.0f);
    CHECK(t.up.y > 0.0f && t.up.x == 0.0f);
    const stp_vec3 edges[2] = {{2.0f, 0.0f, 0.0f}, {0.0f, 3.0f, 0.0f}};
    const float unusable[][2][2] = {{{0.0f, 0.0f}, {0.0f, 0.0f}}, // no coordinates
                                    {{1.0f, 1.0f}, {2.0f, 2.0f}}, // along a line
                                    {{NAN, 0.0f}, {0.0f, 1.0f}},  // damaged
                                    {{INFINITY, 0.0f}, {0.0f, 1.0f}}};
    for (int i = 0; i < 4; ++i) {
        CHECK(!stp_tangents_find(edges, unusable[i], &t));
    }
}

void test_normal_maps_turn_normals(test_state* test)
{
    const stp_vec3 eye = {0.0f, 0.0f, 1.0f}, up = eye, down = {0.0f, 0.0f, -1.0f};
    const float plain[3] = {0.5f, 0.5f, 1.0f}, red[3] = {0.8f, 0.5f, 0.9f},
                green[3] = {0.5f, 0.8f, 0.9f};
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        stp_tangents t = upright(mirrored != 0);
        float x = mirrored != 0 ? -0.6f : 0.6f;
        CHECK(is_near(stp_normal_map_apply(&t, up, plain, 1.0f, eye), 0, 0, 1));
        CHECK(is_near(stp_normal_map_apply(&t, up, red, 1.0f, eye), x, 0, 0.8f));
        CHECK(is_near(stp_normal_map_apply(&t, up, green, 1.0f, eye), 0, 0.6f, 0.8f));
        CHECK(is_near(stp_normal_map_apply(&t, down, red, 1.0f, eye), x, 0, -0.8f));
        CHECK(is_near(stp_normal_map_apply(&t, down, green, 1.0f, eye), 0, 0.6f, -0.8f));
        CHECK(is_near(stp_normal_map_apply(&t, up, red, 0.0f, eye), 0, 0, 1));
        CHECK(is_near(stp_normal_map_apply(&t, up, red, -1.0f, eye), -x, 0, 0.8f));
    }
}

void test_mapped_normals_face_as_their_surface(test_state* test)
{
    stp_tangents t = upright(false);
    const stp_vec3 up = {0.0f, 0.0f, 1.0f}, down = {0.0f, 0.0f, -1.0f};
    const float steep[3] = {0.9f, 0.5f, 0.6f}, inwards[3] = {0.9f, 0.5f, 0.1f},
                nothing[3] = {0.5f, 0.5f, 0.5f};
    CHECK(is_near(stp_normal_map_apply(&t, up, nothing, 1.0f, up), 0, 0, 1));
    stp_vec3 flat = stp_normal_map_apply(&t, up, inwards, 1.0f, up); // no farther than the plane
    CHECK(flat.x > 0.999f && flat.z > 0.0f);
    for (int i = 0; i < 16; ++i) {
        float angle = 0.1f * (float)i;
        const stp_vec3 eye = {-sinf(angle), 0.0f, cosf(angle)}; // the texel leans away from it
        stp_vec3 seen = stp_normal_map_apply(&t, up, steep, 1.0f, eye);
        CHECK(stp_dot(seen, eye) > 0.0f && fabsf(stp_length(seen) - 1.0f) < 1e-5f);
        seen = stp_normal_map_apply(&t, down, steep, 1.0f, eye); // from behind
        CHECK(stp_dot(seen, eye) < 0.0f && fabsf(stp_length(seen) - 1.0f) < 1e-5f);
    }
    const stp_vec3 along = {1.0f, 0.0f, 0.0f}; // no tangent is across it
    CHECK(is_near(stp_normal_map_apply(&t, along, steep, 1.0f, along), 1, 0, 0));
}
