// SPDX-License-Identifier: MIT
// Meshes drawn from columns and from clusters give the same pictures, except for rounding.
#include "support_store.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "draw/draw.h"
#include "store/support_mesh.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120 };

static const unsigned every_attribute = MADE_NORMALS | MADE_COLORS | MADE_TEXCOORDS;

typedef struct pair {
    stp_context* context;
    made_mesh mesh;
    stp_coded_mesh coded;
    stp_store* stores[2]; ///< stored as columns, as clusters
    uint8_t pixels[2][WIDTH * HEIGHT * 4];
} pair;

static uint8_t texels[4 * 64 * 64];

static void find_bounds(const made_mesh* m, stp_store_mesh* out)
{
    stp_box box = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (size_t v = 0; v < m->vertex_count; ++v) {
        const float* p = m->positions + 3 * v;
        box.min =
            (stp_vec3){fminf(box.min.x, p[0]), fminf(box.min.y, p[1]), fminf(box.min.z, p[2])};
        box.max =
            (stp_vec3){fmaxf(box.max.x, p[0]), fmaxf(box.max.y, p[1]), fmaxf(box.max.z, p[2])};
    }
    out->bounds = box;
}

static bool pair_create(pair* p, made_shape shape, unsigned attributes, stp_store_alpha alpha)
{
    *p = (pair){.context = test_context(NULL, 2, NULL)};
    if (p->context == NULL || !made_mesh_create(shape, 60, attributes, &p->mesh)) {
        return false;
    }
    stp_store_mesh view = made_mesh_view(&p->mesh);
    find_bounds(&p->mesh, &view);
    double step = stp_choose_grid_step(view.positions, view.indices, view.triangle_count);
    if (stp_clusters_encode(p->context, &view, step, &p->coded) != STP_OK) {
        return false;
    }
    for (size_t i = 0; i < sizeof(texels); ++i) {
        texels[i] = (uint8_t)(i % 4 == 3 ? (i / 4 % 64 < 40 ? 255 : 0) : 128 + i / 256);
    }
    for (int k = 0; k < 2; ++k) {
        made_scene scene = {.material_count = 1, .mesh_count = 1, .part_count = 1, .node_count = 1};
        scene.materials[0] = made_material();
        scene.materials[0].alpha = alpha;
        if ((attributes & MADE_TEXCOORDS) != 0) {
            scene.textures[0] = (stp_store_texture){.width = 64, .height = 64, .texels = texels};
            scene.texture_count = 1;
            scene.materials[0].base_color_texture.texture = 0;
        }
        scene.meshes[0] = view;
        scene.coded_meshes = k == 1 ? &p->coded : NULL;
        scene.nodes[0] = (stp_store_node){
            .part_count = 1,
            .set = STP_STORE_NONE,
            .triangle_count = view.triangle_count,
            .bounds = {stp_to_double(view.bounds.min), stp_to_double(view.bounds.max)}};
        p->stores[k] = made_open(p->context, &scene);
        if (p->stores[k] == NULL) {
            return false;
        }
    }
    return true;
}

static void pair_destroy(pair* p)
{
    stp_store_close(p->stores[0]);
    stp_store_close(p->stores[1]);
    stp_coded_mesh_destroy(p->context, &p->coded);
    made_mesh_destroy(&p->mesh);
    stp_context_destroy(p->context);
}

static bool pair_draw(pair* p, const stp_view* view)
{
    bool drawn = true;
    for (int k = 0; k < 2 && drawn; ++k) {
        stp_renderer* renderer = NULL;
        stp_draw_list list = {0};
        stp_draw_stats stats;
        stp_image image = {WIDTH, HEIGHT, p->pixels[k]};
        stp_quality quality = {.splat_size = 1, .reference = true};
        drawn = stp_draw_cpu_create(p->context, p->stores[k], &renderer) == STP_OK &&
                stp_select(p->context, p->stores[k], view, &quality, &list) == STP_OK &&
                stp_renderer_draw(renderer, view, &list, &(stp_draw_style){0}, &image, &stats) ==
                    STP_OK;
        stp_draw_list_destroy(p->context, &list);
        stp_renderer_destroy(renderer);
    }
    return drawn;
}

/// Pixels in which the two pictures differ by more than a little; `covered` are those of the first.
static uint32_t count_different(const pair* p, uint32_t* covered)
{
    uint32_t different = 0;
    *covered = 0;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        const uint8_t *a = p->pixels[0] + 4 * i, *b = p->pixels[1] + 4 * i;
        int worst = 0;
        for (int c = 0; c < 4; ++c) {
            worst = abs(a[c] - b[c]) > worst ? abs(a[c] - b[c]) : worst;
        }
        different += worst > 6 ? 1 : 0;
        *covered += a[3] != 0 ? 1 : 0;
    }
    return different;
}

static const stp_view views[] = {
    {.eye = {1.5, 1.2, 1.8}, .target = {0.5, 0, 0.5}, .up = {0, 1, 0}, .fov_degrees = 50},
    {.eye = {0.5, 0.3, 0.4}, .target = {0.1, 0, 0.1}, .up = {0, 1, 0}, .fov_degrees = 70},
    {.eye = {0.9, 0.06, 0.9}, .target = {0.2, 0.05, 0.1}, .up = {0, 1, 0}, .fov_degrees = 90},
    {.eye = {3, 4, 3}, .target = {0.5, 0, 0.5}, .up = {0, 1, 0}, .ortho_height = 0.7},
};

void test_draw_clusters_as_columns(test_state* test)
{
    static pair p;
    static const made_shape shapes[] = {MADE_WAVE, MADE_BOXES};
    for (int shape = 0; shape < 2; ++shape) {
        CHECK(pair_create(&p, shapes[shape], every_attribute & ~(unsigned)MADE_COLORS,
                          STP_STORE_OPAQUE));
        for (size_t i = 0; i < sizeof(views) / sizeof(views[0]); ++i) {
            stp_view view = views[i];
            view.width = WIDTH;
            view.height = HEIGHT;
            uint32_t covered = 0;
            CHECK(pair_draw(&p, &view));
            uint32_t different = count_different(&p, &covered);
            CHECK(covered > 1000);
            CHECK(different <= covered / 50); // edges
        }
        pair_destroy(&p);
    }
}

void test_draw_clusters_with_colors(test_state* test)
{
    static pair p;
    CHECK(pair_create(&p, MADE_WAVE, MADE_NORMALS | MADE_COLORS, STP_STORE_OPAQUE));
    stp_view view = views[1];
    view.width = WIDTH;
    view.height = HEIGHT;
    uint32_t covered = 0;
    CHECK(pair_draw(&p, &view));
    uint32_t different = count_different(&p, &covered);
    CHECK(covered > 1000 && different <= covered / 20); // colours change from vertex to vertex
    pair_destroy(&p);
}

void test_draw_clusters_cutout(test_state* test)
{
    static pair p;
    CHECK(pair_create(&p, MADE_WAVE, MADE_NORMALS | MADE_TEXCOORDS, STP_STORE_MASK));
    stp_view view = views[0];
    view.width = WIDTH;
    view.height = HEIGHT;
    uint32_t covered = 0, holes = 0;
    CHECK(pair_draw(&p, &view));
    uint32_t different = count_different(&p, &covered);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        holes += p.pixels[1][4 * i + 3] == 0 ? 1 : 0;
    }
    CHECK(covered > 1000 && holes > 1000 && different <= covered / 25);
    pair_destroy(&p);
}

void test_draw_clusters_without_normals(test_state* test)
{
    static pair p;
    CHECK(pair_create(&p, MADE_SOUP, 0, STP_STORE_OPAQUE));
    stp_view view = views[0];
    view.width = WIDTH;
    view.height = HEIGHT;
    uint32_t covered = 0;
    CHECK(pair_draw(&p, &view));
    uint32_t different = count_different(&p, &covered);
    CHECK(covered > 1000);
    CHECK(different <= covered / 20);
    pair_destroy(&p);
}
