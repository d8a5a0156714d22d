// SPDX-License-Identifier: MIT
//
// Pictures of two balls, of triangles and of splats, against those in tests/golden/draw: opaque,
// cut out, of glass, cut open and capped, in all drawing styles.
#include "support_golden.h"
#include "support_store.h"
#include "tests.h"

#include "base/splats/octahedral.h"
#include "draw/draw.h"
#include "lod/psp/psp_set.h"
#include "lod/set_columns.h"
#include "select/camera.h"
#include "select/sections.h"

#include <stipple/order.h>

#include <string.h>

enum { SIDE = 208, BALL_RINGS = 24, BALL_SPLATS = 3000 };
enum {
    BALL_VERTICES = (BALL_RINGS + 1) * (2 * BALL_RINGS + 1),
    BALL_TRIANGLES = 4 * BALL_RINGS * BALL_RINGS
};

typedef struct ball {
    float positions[3 * BALL_VERTICES], texcoords[2 * BALL_VERTICES];
    int16_t normals[2 * BALL_VERTICES];
    uint32_t indices[3 * BALL_TRIANGLES];
    uint8_t texels[4 * 32 * 32];
    uint16_t grid[3 * BALL_SPLATS];
    int8_t codes[2 * BALL_SPLATS];
    uint8_t materials[BALL_SPLATS], colors[3 * BALL_SPLATS], coverages[BALL_SPLATS];
} ball;

static int16_t to_16_bit(float v)
{
    return (int16_t)(v * 32767.0f + (v < 0.0f ? -0.5f : 0.5f));
}

static void encode_16(stp_vec3 n, int16_t out[2])
{
    float sum = fabsf(n.x) + fabsf(n.y) + fabsf(n.z), u = n.x / sum, v = n.y / sum;
    if (n.z < 0.0f) {
        float folded = (1.0f - fabsf(v)) * (u < 0.0f ? -1.0f : 1.0f);
        v = (1.0f - fabsf(u)) * (v < 0.0f ? -1.0f : 1.0f);
        u = folded;
    }
    out[0] = to_16_bit(u);
    out[1] = to_16_bit(v);
}

// A ball of radius 1 with a chequered texture, one quarter of it cut out.
static void make_ball_mesh(ball* b)
{
    const int columns = 2 * BALL_RINGS + 1;
    for (int i = 0; i < BALL_VERTICES; ++i) {
        double theta = STP_PI * (i / columns) / BALL_RINGS,
               phi = STP_PI * (i % columns) / BALL_RINGS;
        stp_vec3 n = {(float)(sin(theta) * sin(phi)), (float)cos(theta),
                      (float)(sin(theta) * cos(phi))};
        memcpy(b->positions + 3 * i, &n, sizeof(n));
        encode_16(n, b->normals + 2 * i);
        b->texcoords[2 * i] = (float)(i % columns) / (float)(columns - 1);
        b->texcoords[2 * i + 1] = (float)(i / columns) / (float)BALL_RINGS;
    }
    uint32_t* out = b->indices;
    for (int i = 0; i < BALL_RINGS * 2 * BALL_RINGS; ++i) {
        uint32_t a = (uint32_t)(i / (2 * BALL_RINGS) * columns + i % (2 * BALL_RINGS)),
                 c = a + (uint32_t)columns;
        const uint32_t corners[6] = {a, c, c + 1, a, c + 1, a + 1};
        memcpy(out, corners, sizeof(corners));
        out += 6;
    }
    for (int i = 0; i < 32 * 32; ++i) {
        int x = i % 32, y = i / 32;
        bool light = (x / 4 + y / 4) % 2 == 0;
        const uint8_t texel[4] = {light ? 230 : 40, light ? 200 : 90, light ? 120 : 160,
                                  (x - 4) * (x - 4) + (y - 14) * (y - 14) < 20 ? 0 : 255};
        memcpy(b->texels + 4 * i, texel, sizeof(texel));
    }
}

static bool make_ball_set(stp_context* context, ball* b, stp_splats* s)
{
    static float positions[3 * BALL_SPLATS], radii[BALL_SPLATS];
    static uint32_t order[BALL_SPLATS];
    for (int i = 0; i < BALL_SPLATS; ++i) {
        double z = 1.0 - (2.0 * i + 1.0) / BALL_SPLATS, angle = 2.399963229728653 * i,
               r = sqrt(1.0 - z * z);
        const float p[3] = {(float)(r * cos(angle)), (float)(r * sin(angle)), (float)z};
        memcpy(positions + 3 * i, p, sizeof(p));
    }
    stp_order_desc desc = {.metric = STP_METRIC_EUCLIDEAN};
    uint32_t count = 0;
    float final_radius = 0.0f;
    if (stp_order_points(context, &desc, positions, NULL, BALL_SPLATS, BALL_SPLATS, order, radii,
                         &count, &final_radius, NULL) != STP_OK ||
        count != BALL_SPLATS) {
        return false;
    }
    *s = (stp_splats){.count = count,
                      .origin = {-2, -2, -2},
                      .step = 1.0f / 16384.0f,
                      .positions = b->grid,
                      .normals = b->codes,
                      .materials = b->materials,
                      .octave_count = 1,
                      .octave_ends = {BALL_SPLATS},
                      .colors = b->colors,
                      .coverages = b->coverages,
                      .candidate_radius = 0.04f,
                      .paper_radius = 0.1f,
                      .paper_count = 1000};
    s->table.size = 2;
    s->table.count[0] = 1;
    s->table.radius[0] = 2.0f;
    s->table.count[1] = count;
    s->table.radius[1] = radii[count - 1];
    for (uint32_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * (size_t)order[i];
        for (uint32_t k = 0; k < 3; ++k) {
            b->grid[3 * i + k] = (uint16_t)((p[k] + 2.0f) * 16384.0f + 0.5f);
            b->colors[3 * i + k] = (uint8_t)(127.0f + 100.0f * p[k]);
        }
        stp_octahedral_encode((stp_vec3){p[0], p[1], p[2]}, b->codes + 2 * (size_t)i);
        b->coverages[i] = p[1] < -0.4f ? 120 : 255;
        b->materials[i] = 0;
    }
    return true;
}

// Two balls side by side: triangles on the left; on the right splats, or splats merged by a
// method.
static stp_store* open_balls(stp_context* context, ball* b, stp_store_alpha alpha, uint32_t method)
{
    static made_scene s;
    s = (made_scene){.material_count = 1,
                     .shading_count = 1,
                     .texture_count = 1,
                     .mesh_count = 1,
                     .set_count = 1,
                     .part_count = 2,
                     .node_count = 3,
                     .edge_count = 2};
    make_ball_mesh(b);
    if (!make_ball_set(context, b, &s.sets[0])) {
        return NULL;
    }
    stp_splats merged = {0};
    if (method == STP_METHOD_PSP) {
        if (stp_psp_make(context, &s.sets[0], NULL, false, STP_PSP_REGIONS, 0, &merged) != STP_OK) {
            return NULL;
        }
        s.sets[0] = merged;
        s.method =
            (stp_store_method){.name = "psp", .id = STP_METHOD_PSP, .columns = STP_PSP_COLUMNS};
    }
    s.materials[0] = made_material();
    s.materials[0].roughness = 0.4f;
    s.materials[0].alpha = alpha;
    s.materials[0].base_color[3] = alpha == STP_STORE_BLEND ? 0.4f : 1.0f;
    s.materials[0].base_color_texture.texture = 0;
    s.shadings[0] = (stp_shading){.roughness = 0.4f};
    s.textures[0] = (stp_store_texture){.width = 32, .height = 32, .texels = b->texels};
    s.meshes[0] = (stp_store_mesh){.vertex_count = BALL_VERTICES,
                                   .triangle_count = BALL_TRIANGLES,
                                   .bounds = {{-1, -1, -1}, {1, 1, 1}},
                                   .positions = b->positions,
                                   .normals = b->normals,
                                   .texcoords = {b->texcoords, NULL},
                                   .indices = b->indices};
    s.parts[0] = s.parts[1] = (stp_store_part){STP_STORE_PART_MESH, 0};
    stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    s.nodes[0] = (stp_store_node){
        .part_count = 1, .set = STP_STORE_NONE, .triangle_count = BALL_TRIANGLES, .bounds = unit};
    s.nodes[1] = s.nodes[0];
    s.nodes[1].first_part = 1;
    s.nodes[1].set = 0;
    for (uint32_t i = 0; i < 2; ++i) {
        s.edges[i] = (stp_store_edge){i, stp_affine_identity()};
        s.edges[i].transform.m[0][3] = i == 0 ? -1.1 : 1.1;
    }
    s.nodes[2] = (stp_store_node){.first_part = 2,
                                  .edge_count = 2,
                                  .set = STP_STORE_NONE,
                                  .triangle_count = 2 * BALL_TRIANGLES,
                                  .bounds = {{-2.1, -1, -1}, {2.1, 1, 1}}};
    stp_store* store = made_open(context, &s);
    stp_splats_destroy(context, &merged);
    return store;
}

typedef struct golden {
    const char* name;
    stp_view view;
    stp_quality quality;
    stp_draw_style style;
} golden;

static const char* draw_all(const golden* cases, size_t count, stp_store_alpha alpha,
                            uint32_t method)
{
    static ball b;
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = context != NULL ? open_balls(context, &b, alpha, method) : NULL;
    const char* wrong = store != NULL ? NULL : "cannot be opened";
    for (size_t i = 0; i < count && wrong == NULL; ++i) {
        wrong = golden_draw(context, store, cases[i].name, cases[i].view, cases[i].quality,
                            cases[i].style);
    }
    stp_store_close(store);
    stp_context_destroy(context);
    return wrong;
}

static const stp_boxd balls_box = {{-2.1, -1, -1}, {2.1, 1, 1}};

void test_golden_pictures(test_state* test)
{
    stp_view view = {.width = SIDE, .height = SIDE, .fov_degrees = 40};
    CHECK(stp_camera_frame("iso", &balls_box, &view));
    stp_view parallel = {.width = SIDE, .height = SIDE, .ortho_height = 1};
    CHECK(stp_camera_frame("front", &balls_box, &parallel));
    stp_view far = view; // texels smaller than pixels: cut-out shares must stay
    for (int k = 0; k < 3; ++k) {
        double* eye = k == 0 ? &far.eye.x : k == 1 ? &far.eye.y : &far.eye.z;
        *eye *= 4.0;
    }
    const golden cases[] = {
        {"balls_splats", view, {.splat_size = 14}, {.splat_scale = 1}},
        {"balls_dots", parallel, {.splat_size = 8}, {.splat_scale = 0.3f, .headlight = true}},
        {"balls_blended", view, {.splat_size = 14}, {.filter = STP_FILTER_EWA}},
        {"balls_dark", view, {.splat_size = 14}, {.eye_dome = 1, .ambient_occlusion = 0.12f}},
        {"balls_smooth",
         view,
         {.reference = true},
         {.supersample = 3, .background = true, .background_color = {40, 60, 90}}},
        {"balls_far", far, {.reference = true}, {.background = true}},
        {"balls_cut_out_1", view, {.splat_size = 1}, {.background = true}},
        {"balls_cut_out_4", view, {.splat_size = 4, .splats_only = true}, {.background = true}},
        {"balls_cut_out_16", view, {.splat_size = 16}, {.background = true}},
    };
    CHECK(draw_all(cases, sizeof(cases) / sizeof(cases[0]), STP_STORE_MASK, 0) == NULL);
}

void test_golden_pictures_of_glass_and_caps(test_state* test)
{
    stp_view view = {.width = SIDE, .height = SIDE, .fov_degrees = 40};
    CHECK(stp_camera_frame("iso", &balls_box, &view));
    stp_view cut = view;
    stp_vec3d at = {0.2, 0.1, 0.3}, along = {0.3, 0.5, 1.0};
    CHECK(stp_sections_add_plane(&cut.sections, at, along));
    stp_draw_style plain = {.background = true, .background_color = {70, 70, 80}}, caps = plain;
    stp_draw_style pattern = plain;
    caps.caps = true;
    pattern.transparency = STP_TRANSPARENCY_PATTERN;
    const golden solid[] = {{"balls_open", cut, {.reference = true}, plain},
                            {"balls_capped", cut, {.reference = true}, caps},
                            {"balls_capped_splats", cut, {.splat_size = 8}, caps}};
    CHECK(draw_all(solid, 3, STP_STORE_OPAQUE, 0) == NULL);
    const golden glass[] = {{"balls_glass", view, {.reference = true}, plain},
                            {"balls_glass_pattern", view, {.reference = true}, pattern},
                            {"balls_glass_cut", cut, {.reference = true}, caps},
                            {"balls_glass_4", view, {.splat_size = 4, .splats_only = true}, plain},
                            {"balls_glass_16", view, {.splat_size = 16}, plain}};
    CHECK(draw_all(glass, 5, STP_STORE_BLEND, 0) == NULL);
}

void test_golden_pictures_of_merged_splats(test_state* test)
{
    stp_view view = {.width = SIDE, .height = SIDE, .fov_degrees = 40};
    CHECK(stp_camera_frame("iso", &balls_box, &view));
    const golden cases[] = {
        {"balls_merged", view, {.splat_size = 8}, {.splat_scale = 1}},
        {"balls_merged_few", view, {.splat_size = 1, .splat_count = 150}, {.supersample = 2}},
    };
    CHECK(draw_all(cases, 2, STP_STORE_OPAQUE, STP_METHOD_PSP) == NULL);
}
